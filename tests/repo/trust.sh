#!/bin/bash
# docs/trust.md: its table of bad files is what the tool says of them today, and its table of coverage names every file of src/core and src/io. By hand:
#   tests/repo/trust.sh --refresh     writes the table of bad files anew
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
data=${NORMA_DATA:-$root/../shared/data}
norma=${NORMA_BIN:-$tree/bin/norma}
page=$root/docs/trust.md
export LC_ALL=C.UTF-8
[ -x "$norma" ] || { fail "the tool is there" "no program at $norma"; finish; exit 1; }

# said FILE: the tool's first line of error about a file of the data set, as the document has it: without the file's name, "|" escaped for its table.
said() {
    (cd "$data" && timeout 60 "$norma" compute "$1" -o /dev/null --quiet 2>&1 >/dev/null; echo "status $?") | awk -v file="$1" '
        /^status / { status = $2; next }
        !line { line = $0 }
        END { prefix = "norma: " file; if (index(line, prefix) == 1) line = substr(line, length(prefix) + 1); sub(/^: ?/, "", line); gsub(/\|/, "\\|", line); print status "\t" line }'
}

# The rows of the table: the files that are refused.
rows() {
    cut -f1 "$data/INDEX.tsv" | grep '^bad/' | while read -r file; do
        IFS=$'\t' read -r status line < <(said "$file")
        case $status in
        0) ;;
        3) printf '| `%s` | %s |\n' "${file#bad/}" "$line" ;;
        *) printf '| `%s` | status %s: %s |\n' "${file#bad/}" "$status" "$line" ;;
        esac
    done
}

between() { sed -n "/<!-- $1 -->/,/<!-- end of $1 -->/p" "$page" | sed '1d;$d'; }

if [ ! -d "$data/bad" ]; then
    skip "the data set is not there"
elif [ "${1:-}" = --refresh ]; then
    rows >"$scratch/rows"
    awk -v rows="$scratch/rows" '
        /<!-- end of bad files -->/ { print "| File | What is said |"; print "|---|---|"; while ((getline line < rows) > 0) print line; skipping = 0 }
        !skipping { print }
        /<!-- bad files -->/ { skipping = 1 }' "$page" >"$scratch/page" && cp "$scratch/page" "$page"
    pass "the table of bad files is written"
else
    rows >"$scratch/rows"
    between "bad files" | tail -n +3 >"$scratch/told"
    if [ -s "$scratch/rows" ] && cmp -s "$scratch/rows" "$scratch/told"; then
        pass "$(wc -l <"$scratch/rows") bad files are refused with the words of docs/trust.md"
    else
        fail "bad files are refused with the words of docs/trust.md" "$(diff "$scratch/told" "$scratch/rows")"
    fi
    if grep -q 'status [^3]' "$scratch/rows"; then fail "each with status 3" "$(grep 'status [^3]' "$scratch/rows")"; else pass "each with status 3"; fi
fi

missing=""
for file in "$root"/src/core/*.c "$root"/src/io/*.c; do
    name=${file#"$root/"}
    case $name in *_windows.c) continue ;; esac
    between "coverage" | grep -q "\`$name\`" || missing+="$name"$'\n'
done
if [ -z "$missing" ]; then pass "the table of coverage names every file"; else fail "the table of coverage names every file (scripts/coverage.sh --refresh)" "$missing"; fi
finish
