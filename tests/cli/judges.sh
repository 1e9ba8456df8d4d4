#!/bin/bash
# Fixes, judged by programs that are not ours: every file, each rule's fix alone and all of them together. admesh counts what is open and wrong in an STL, the Khronos
# validator says what is wrong with a glTF, fix-closed.mjs finds edges in all formats by itself. None of them may find more after a fix than before.
#   tests/cli/judges.sh          small files (a minute)
#   tests/cli/judges.sh --all    all of the data set (make judges)
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
norma=${NORMA_BIN:-$tree/bin/norma}
data=${NORMA_DATA:-$root/../shared/data}
export NODE_PATH=${NODE_PATH:-$root/build/npm/node_modules}
[ -x "$norma" ] || { fail "the tool is there" "no program at $norma"; finish; exit 1; }
command -v node >/dev/null || { skip "node is not there"; finish; exit; }
most=-40k most_stl=-120k
[ "${1:-}" != --all ] || most=-1000000k most_stl=-1000000k

cd "$root" || exit 1
find assets "$data" -type f \( -size "$most" \( -name '*.obj' -o -name '*.ply' -o -name '*.gltf' -o -name '*.glb' \) -o -size "$most_stl" -name '*.stl' \) 2>/dev/null | sort >"$scratch/files"
[ -d "$data" ] || skip "the data set (no $data)"

# The rules that find something in each file and have a fix, those of a safe fix marked: "FILE tab WHAT" for each, and once more for all.
"$norma" check --files-from "$scratch/files" --no-config --json --max-samples 1 >"$scratch/report.json" 2>/dev/null
node -e '
    for (const file of JSON.parse(require("fs").readFileSync(process.argv[1])).files) {
        const rules = [...new Set(file.findings.filter((x) => x.fix).map((x) => x.rule))];
        if (file.findings.some((x) => x.rule === "N304")) rules.push("N304");
        if (rules.length) for (const what of [...rules, "safe", "all"]) console.log(`${file.path}\t${what}`);
    }' "$scratch/report.json" >"$scratch/fixes"

# fix_one FILE WHAT NUMBER: a line of pairs where the file was changed, and what was left out.
fix_one() {
    local file=$1 what=$2 out=$scratch/fixed/$3 how=(--fix-unsafe)
    case $what in
    safe) how=(--fix) ;;
    all) how+=(--open-by-rays) ;;
    N304) how+=(--select N304 --open-by-rays) ;;
    *) how+=(--select "$what") ;;
    esac
    mkdir -p "$out"
    "$norma" check "$file" "${how[@]}" --no-config --quiet --max-samples 1 -o "$out/$(basename "$file")" >/dev/null 2>"$out/said"
    local status=$?
    [ "$status" -le 1 ] || [ "$status" = 3 ] || echo "$file $what: status $status: $(head -1 "$out/said")" >"$out/wrong"
    grep ' is not fixed' "$out/said" | sed "s|^|$what: |" >"$out/left"
    if [ -s "$out/$(basename "$file")" ] && ! cmp -s "$file" "$out/$(basename "$file")"; then printf '%s\t%s\n' "$file" "$out/$(basename "$file")" >"$out/pair"; fi
}
export -f fix_one
export norma scratch
awk -F '\t' '{ print $1 "\n" $2 "\n" NR }' "$scratch/fixes" | tr '\n' '\0' | xargs -0 -n 3 -P 2 bash -c 'fix_one "$@"' fix_one
find "$scratch/fixed" -name pair -exec cat {} + >"$scratch/pairs" 2>/dev/null
find "$scratch/fixed" -name left -exec cat {} + >"$scratch/left" 2>/dev/null
wrong=$(find "$scratch/fixed" -name wrong -exec cat {} + 2>/dev/null)
told="$(cut -f1 "$scratch/fixes" | sort -u | wc -l) files, $(wc -l <"$scratch/fixes") fixes, $(wc -l <"$scratch/pairs") written, $(wc -l <"$scratch/left") left out in part or whole"
if [ -z "$wrong" ] && [ -s "$scratch/pairs" ]; then pass "$told"; else fail "$told" "$wrong"; fi

node tests/cli/fix-closed.mjs --list "$scratch/pairs" >"$scratch/closed" 2>&1
if [ "$(wc -l <"$scratch/closed")" = 1 ] && grep -q ' compared' "$scratch/closed"; then pass "edges: $(cat "$scratch/closed"), none worse"; else fail "edges" "$(cat "$scratch/closed")"; fi

# faults FILE: what admesh counts in it, as it is (it fills no holes here, and turns nothing: that it decides by the first facet's normal): sides of facets that are open, degenerate
# facets, normals that differ from the winding.
faults() {
    admesh -e -v "$1" 2>/dev/null | awk -F ': *' '
        /^Facets with [123] disconnected/ { open += substr($1, 13, 1) * $2 }
        /^(Degenerate facets|Normals fixed)/ { rest = rest " " $2 + 0; seen = 1 }
        END { if (seen) print open rest }'
}
if command -v admesh >/dev/null; then
    judged=0 worse=""
    while IFS=$'\t' read -r before after; do
        [[ $before == *.stl ]] || continue
        was=$(faults "$before") is=$(faults "$after")
        [ -n "$was" ] && [ -n "$is" ] || continue
        judged=$((judged + 1))
        for number in $(paste -d: <(tr ' ' '\n' <<<"$was") <(tr ' ' '\n' <<<"$is")); do
            if [ "${number#*:}" -gt "${number%:*}" ]; then worse+="$before -> $after: $was became $is"$'\n'; break; fi
        done
    done <"$scratch/pairs"
    if [ -z "$worse" ] && [ "$judged" -gt 0 ]; then pass "admesh: $judged compared, none worse"; else fail "admesh: $judged compared" "$worse"; fi
else
    skip "admesh is not installed"
fi

grep -E '\.(gltf|glb)$' "$scratch/pairs" >"$scratch/gltf"
output=$(node tests/cli/validator/compare.mjs --list "$scratch/gltf" 2>&1)
case $? in
0) pass "validator: $(tail -n 1 <<<"$output")" ;;
77) skip "$output" ;;
*) fail "validator" "$output" ;;
esac
[ "${1:-}" != --all ] || sort "$scratch/left" | sed 's/^/# left out: /'
finish
