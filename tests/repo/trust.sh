#!/bin/bash
# What the tool says of the damaged files of the data set is what tests/repo/bad-files.txt has, and each of them is refused with status 3.
#   tests/repo/trust.sh --refresh     writes bad-files.txt anew (read the difference before you commit it)
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
data=${NORMA_DATA:-$root/../shared/data}
norma=${NORMA_BIN:-$tree/bin/norma}
expected=$root/tests/repo/bad-files.txt
export LC_ALL=C.UTF-8
[ -x "$norma" ] || { fail "the tool is there" "no program at $norma"; finish; exit 1; }

# said FILE: the exit status, and the tool's first line of error without the file's name.
said() {
    (cd "$data" && timeout 60 "$norma" compute "$1" -o /dev/null --quiet 2>&1 >/dev/null; echo "status $?") | awk -v file="$1" '
        /^status / { status = $2; next }
        !line { line = $0 }
        END { prefix = "norma: " file; if (index(line, prefix) == 1) line = substr(line, length(prefix) + 1); sub(/^: ?/, "", line); print status "\t" line }'
}

# FILE, a tab, and what is said, for each file that is refused.
refused() {
    cut -f1 "$data/INDEX.tsv" | grep '^bad/' | while read -r file; do
        IFS=$'\t' read -r status line < <(said "$file")
        case $status in
        0) ;;
        3) printf '%s\t%s\n' "${file#bad/}" "$line" ;;
        *) printf '%s\tstatus %s: %s\n' "${file#bad/}" "$status" "$line" ;;
        esac
    done
}

if [ ! -d "$data/bad" ]; then
    skip "the data set is not there"
else
    refused >"$scratch/refused"
    [ "${1:-}" != --refresh ] || cp "$scratch/refused" "$expected"
    if [ -s "$scratch/refused" ] && difference=$(diff "$expected" "$scratch/refused"); then
        pass "$(wc -l <"$scratch/refused") bad files are refused with the words of tests/repo/bad-files.txt"
    else
        fail "bad files are refused with the words of tests/repo/bad-files.txt (meant: tests/repo/trust.sh --refresh)" "$difference"
    fi
    if grep -q $'\tstatus ' "$scratch/refused"; then fail "each with status 3" "$(grep $'\tstatus ' "$scratch/refused")"; else pass "each with status 3"; fi
fi
finish
