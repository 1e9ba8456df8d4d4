#!/bin/bash
# The README, and what docs/checking.md shows, is true: its console blocks are run and their output compared, its C programs built and run, its make targets and links exist.
# In a console block a line "$ COMMAND" is run in a folder that has assets/, and the lines below it are its output (standard error too); a block of
# C is compiled to ./program just before the console block that follows it.
#   tests/repo/readme.sh --refresh     writes the output of the console blocks anew
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
cd "$root" || exit 1

mkdir -p "$scratch/run" "$scratch/bin"
ln -s "$root/assets" "$scratch/run/assets"
ln -s "$tree/bin/norma" "$scratch/bin/norma"
export PATH=$scratch/bin:$PATH
refresh=${1:-}
# What `make install` would leave: programs are built as the README says, through pkg-config.
cmake --install "$tree" --prefix "$scratch/prefix" >/dev/null
library=$scratch/prefix/$(cd "$scratch/prefix" && find lib -name libnorma.so)
PKG_CONFIG_PATH=$(dirname "$library")/pkgconfig
LD_LIBRARY_PATH=$(dirname "$library")
export PKG_CONFIG_PATH LD_LIBRARY_PATH

# Each fenced block to a file of its own, NUMBER.LANGUAGE, and its first line's number in the README beside it.
awk -v out="$scratch" '/^```/ { if (inside) { inside = 0; close(file) } else { inside = 1; file = sprintf("%s/block-%03d.%s", out, ++n, substr($0, 4)); printf "" > file }; next } inside { print > file }' README.md docs/checking.md

commands=0 programs=0
run_console() { # FILE: runs each command and compares
    local command="" expected="" line fresh=$1.fresh
    while IFS= read -r line || [ -n "$line" ]; do
        if [[ $line == '$ '* ]]; then
            [ -z "$command" ] || compare "$command" "$expected"
            command=${line#\$ } expected=""
        else
            expected+=$line$'\n'
        fi
    done <"$1"
    [ -z "$command" ] || compare "$command" "$expected"
}
compare() { # COMMAND EXPECTED
    local output
    commands=$((commands + 1))
    output=$(cd "$scratch/run" && bash -c "$1" 2>&1; echo "status $?")
    local status=${output##*status }
    output=${output%status *}
    [ "$refresh" != --refresh ] || printf '$ %s\n%s' "$1" "$output" >>"$fresh"
    if [ "$output" = "$2" ] && [ "$status" = 0 ]; then pass "README: $1"; else fail "README: $1" "$(diff <(printf '%s' "$2") <(printf '%s' "$output"); echo "status $status")"; fi
}

for block in "$scratch"/block-*; do
    case $block in
    *.c)
        programs=$((programs + 1))
        cp "$block" "$scratch/run/program.c"
        check "README: the C program has at most ten lines" test "$(wc -l <"$block")" -le 10
        # shellcheck disable=SC2046
        check "README: the C program has no warning" gcc -std=c11 -Wall -Wextra -Wpedantic -Werror -fsyntax-only $(pkg-config --cflags norma) "$block"
        ;;
    *.console) run_console "$block" ;;
    *.sh)
        # Commands for a machine of one's own: here only whether the targets exist.
        while read -r word target _; do
            if [ "$word" = make ]; then check "README: make $target is a target" make -n ${target:+"$target"}; fi
        done < <(sed 's/#.*//; s/^sudo //' "$block")
        ;;
    esac
done
if [ "$commands" -gt 1 ] && [ "$programs" -gt 0 ]; then pass "README: $commands commands and $programs programs found"; else fail "README: commands and programs found" "$commands commands, $programs programs"; fi

if [ "$refresh" = --refresh ]; then
    # The blocks are numbered through both documents, as above.
    n=0
    for document in README.md docs/checking.md; do
        awk -v out="$scratch" -v n="$n" '
            /^```/ && inside { inside = skip = 0 }
            !skip { print }
            /^```/ && !closing { inside = 1; ++n; file = sprintf("%s/block-%03d.%s.fresh", out, n, substr($0, 4))
                while ((getline line < file) > 0) { print line; skip = 1 } }
            { closing = inside }' "$document" >"$scratch/refreshed"
        n=$((n + $(grep -c '^```' "$document") / 2))
        cp "$scratch/refreshed" "$document"
    done
fi

# The table of rules in docs/checking.md is what norma explain prints.
verb() { norma explain "$1" | sed -nE 's/^Fix \(([a-z ]+)\).*/\1/p'; }
value() { sed -nE "s/.*\"$1\": \"([^\"]*)\".*/\1/p" "$scratch/rule"; }
{
    echo '| Rule | To render | To print | Generated | Fix |'
    echo '|---|---|---|---|---|'
    norma explain | while read -r id _; do
        norma explain "$id" --json >"$scratch/rule"
        case $(value fix) in
        safe) fix=$(verb "$id") ;;
        unsafe) fix=$(verb "$id")† ;;
        *) fix=– ;;
        esac
        echo "| $id $(value name) | $(value render) | $(value print) | $(value generated) | $fix |"
    done
} >"$scratch/rules"
if [ "$refresh" = --refresh ]; then
    sed -i -e "/<!-- rules -->/r $scratch/rules" -e '/<!-- rules -->/,/<!-- end of rules -->/{/^|/d}' docs/checking.md
fi
sed -n '/<!-- rules -->/,/<!-- end of rules -->/{/^|/p}' docs/checking.md >"$scratch/shown"
if difference=$(diff "$scratch/shown" "$scratch/rules"); then pass "docs/checking.md: the table of rules"; else fail "docs/checking.md: the table of rules" "$difference"; fi
rules=$(($(wc -l <"$scratch/rules") - 2))
check "README: there are $rules rules" grep -q " $rules rules" README.md

for document in README.md CONTRIBUTING.md CHANGELOG.md docs/*.md; do
    missing=$(grep -oE '\]\([^)#:]+' "$document" | sed 's/^](//' | grep -vE '^https?$' | while read -r link; do [ -e "$(dirname "$document")/$link" ] || echo "$link"; done)
    if [ -z "$missing" ]; then pass "$document: every link leads somewhere"; else fail "$document: every link leads somewhere" "$missing"; fi
done
finish
