#!/bin/bash
# The manual: well formed, with the synopses that the headers have.
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
cd "$root" || exit 1

for page in docs/man/*.[1-9]; do
    # What a page refers to lies here or in the system's manual, which may not be installed.
    output=$(mandoc -T lint -W warning "$page" 2>&1 | grep -vE 'referenced manual not found|mandoc.db')
    if [ -z "$output" ]; then pass "$page has no warning"; else fail "$page has no warning" "$output"; fi
done

# Every prototype: result, name and parameters, spaces aside, as in the header.
declared=$(for header in include/norma/*.h; do gcc -fpreprocessed -dD -E -P "$header" 2>/dev/null; done | grep -v '^ *#' | tr '\n' ' ' | tr ';' '\n' | sed 's/extern "C" {//' | grep -vE 'typedef|\{' | grep -oE '[a-z0-9_ ]+[ *]norma_[a-z0-9_]+\(.*\)' | tr -d ' ' | sort -u)
shown=$(awk '
    function flush() { if (name != "") print type name "(" list ")"; name = ""; list = "" }
    { gsub(/,$/, "") }
    /^\.Ft / { type = substr($0, 5) }
    /^\.Fo / { name = $2; list = "" }
    /^\.Fa "/ && name != "" { s = $0; sub(/^\.Fa "/, "", s); sub(/"$/, "", s); list = list (list == "" ? "" : ",") s }
    /^\.Fc/ { flush() }
    /^\.Fn norma_/ && section == "SYNOPSIS" { s = substr($0, 5); name = s; sub(/ .*/, "", name); sub(/^[^ ]+ ?/, "", s); gsub(/" "/, ",", s); gsub(/"/, "", s); list = s; flush() }
    /^\.Sh / { section = $2 }' docs/man/*.3 | tr -d ' ' | sort -u)
wrong=$(comm -13 <(printf '%s\n' "$declared") <(printf '%s\n' "$shown"))
if [ -n "$shown" ] && [ -z "$wrong" ]; then pass "every prototype in the manual is the header's ($(printf '%s\n' "$shown" | wc -l))"; else fail "every prototype in the manual is the header's" "$wrong"; fi
missing=$(comm -23 <(printf '%s\n' "$declared") <(printf '%s\n' "$shown"))
if [ -z "$missing" ]; then pass "every public function is in the manual"; else fail "every public function is in the manual" "$missing"; fi
finish
