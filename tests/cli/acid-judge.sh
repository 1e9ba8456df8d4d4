#!/bin/bash
# norma acid --judge as people run it: made screenshots with mistakes put in, the forms of its report, the picture it marks, and what it refuses.
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
norma=${NORMA_BIN:-$tree/bin/norma}
screens=$tree/tests/acid_screens
cd "$root" || exit 1
[ -x "$screens" ] || { skip "the tree was built without images"; finish; exit; }

"$screens" layout "$scratch/acid.json"
"$screens" shot 3 "$scratch/shot.png" >"$scratch/shows"

# status NAME EXPECTED COMMAND...: its output goes to out, its errors to err.
status() {
    local name=$1 expected=$2 got=0
    shift 2
    "$@" >"$scratch/out" 2>"$scratch/err" || got=$?
    if [ "$got" = "$expected" ]; then pass "$name"; else fail "$name" "status $got, expected $expected: $(cat "$scratch/err")"; fi
}
judge=("$norma" acid --scene "$scratch/acid.json" --judge)

# ---- verdicts: what was put in, as the generator tells it

verdicts() { sed 's/{"id": /\n/g' "$scratch/out" | sed -nE 's/^"([a-z-]*)", "verdict": "([a-z]*)", "mistake": ("([a-z-]*)"|null).*/\1 \2 \4/p'; }
# tangent-mirror's mistake can be named only if tangent-sign passes, scale-on-z only if it passes or shows a mistake.
expected() {
    awk 'NR == FNR { shown[$1] = $2; next }
        { print $1, ($2 == "right" ? "pass " : $2 == "other" || $2 == "sign-kept" && shown["tangent-sign"] != "right" || $2 == "scale-on-z" && shown["tangent-sign"] ~ /^(other|nothing)$/ ? "unclear " : $2 == "nothing" ? ($1 == "flattened" ? "fail lost" : "missing ") : "fail " $2) }' "$scratch/shows" "$scratch/shows"
}
for number in 3 4 5; do
    "$screens" shot "$number" "$scratch/shot.png" >"$scratch/shows"
    status "screenshot $number is judged with status 1" 1 "${judge[@]}" "$scratch/shot.png" --json
    if [ "$(verdicts)" = "$(expected)" ] && [ -n "$(verdicts)" ]; then pass "each verdict of screenshot $number is what was put in"; else fail "the verdicts of screenshot $number" "$(diff <(verdicts) <(expected))"; fi
done
check "the JSON is JSON" python3 -c 'import json, sys; d = json.load(open(sys.argv[1])); assert d["schema"] == "norma-acid/1" and len(d["cells"]) == 24 == sum(d["summary"].values()) and d["cells"][1]["distances"]["right"] >= 0' "$scratch/out"
status "TAP has a test for each cell" 1 "${judge[@]}" "$scratch/shot.png" --tap
check "and its plan" grep -qx '1\.\.24' "$scratch/out"
check "cells that fail are not ok" test "$(grep -c '^not ok' "$scratch/out")" = "$(expected | grep -cv ' pass ')"
status "text names the mistake and its mend" 1 "${judge[@]}" "$scratch/shot.png"
check "one mend for each failure" test "$(grep -c 'mend: ' "$scratch/out")" = "$(expected | grep -c ' fail ')"
status "cells that need an extension are skipped" 1 "${judge[@]}" "$scratch/shot.png" --json --without KHR_a,EXT_mesh_gpu_instancing
check "both of them" grep -q '"skipped": 2}' "$scratch/out"
status "a picture is marked" 1 "${judge[@]}" "$scratch/shot.png" -o "$scratch/marked.png" --quiet
check "nothing else is said" test ! -s "$scratch/out"
check "it is another picture" bash -c "! cmp -s '$scratch/shot.png' '$scratch/marked.png'"
status "and can be judged again" 1 "${judge[@]}" "$scratch/marked.png" --quiet

# ---- norma render that reads green downward everywhere (tests/support/mistakes.cmake), with the ACES curve, 691 pixels wide, as a JPEG

status "one mistake in all cells" 1 "$norma" acid --judge tests/cli/pictures/acid-green-flipped.jpg --json
check "is named where it can be told from others, and never misnamed" test "$(verdicts | grep -v ' pass ' | tr -s ' \n' ' ')" = \
    "tangent-absent unclear tangent-sign fail green-flipped tangent-non-uniform unclear tangent-mirror unclear tangent-skinned unclear normal-scale unclear "
check "and why, where other mistakes look the same" grep -q '"tangent-mirror".*sign-kept, sign-lost and green-flipped look the same' "$scratch/out"

# ---- what it refuses

status "no marks" 3 "${judge[@]}" tests/cli/pictures/compare.png
check "says so" grep -q 'marks of the scene were not found' "$scratch/err"
head -c 3000 "$scratch/shot.png" >"$scratch/cut.png"
status "a picture that is cut off" 3 "${judge[@]}" "$scratch/cut.png"
printf '\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\1\0\0\0\1\0\0\10\2\0\0\0\0\0\0\0' >"$scratch/large.png"
status "a picture with a side of 65,536" 3 "${judge[@]}" "$scratch/large.png"
status "no picture" 3 "${judge[@]}" "$scratch/acid.json"
status "a folder" 3 "${judge[@]}" "$scratch"
status "nothing" 3 "${judge[@]}" "$scratch/none.png"
status "the screenshot is not overwritten" 2 "${judge[@]}" "$scratch/shot.png" -o "$scratch/shot.png"
sed 's/"right"/"wrong"/' "$scratch/acid.json" >"$scratch/wrong.json"
status "a cell without a right reference" 3 "$norma" acid --judge "$scratch/shot.png" --scene "$scratch/wrong.json"
check "is named" grep -q 'wrong.json: cell 1: expected' "$scratch/err"
sed 's/"red"/"grey"/' "$scratch/acid.json" >"$scratch/wrong.json"
status "marks that are not four" 3 "$norma" acid --judge "$scratch/shot.png" --scene "$scratch/wrong.json"
sed 's/"size": \[[0-9.]*/"size": [1e300/' "$scratch/acid.json" >"$scratch/wrong.json"
status "a patch without a sound size" 3 "$norma" acid --judge "$scratch/shot.png" --scene "$scratch/wrong.json"
echo '{}' >"$scratch/wrong.json"
status "another JSON" 3 "$norma" acid --judge "$scratch/shot.png" --scene "$scratch/wrong.json"
status "nothing to do" 2 "$norma" acid
status "JSON and TAP" 2 "${judge[@]}" "$scratch/shot.png" --json --tap
status "an empty extension" 2 "${judge[@]}" "$scratch/shot.png" --without A,,B

# ---- many

status "40 made screenshots: no wrong verdict" 0 nice "$screens" table 40 5000
check "and hardly an unclear one" awk -F'|' '/^\| `/ && $2 !~ /other/ { all += $3; unclear += $5 } END { exit !(all > 800 && unclear <= all / 100) }' "$scratch/out"
finish
