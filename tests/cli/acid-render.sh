#!/bin/bash
# norma render and the acid scene: it passes every cell, in the whole scene and in each file alone; and a norma render into which a mistake was put (tests/support/mistakes.cmake,
# a build of its own) fails every cell that has that mistake beside it, by its name.
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
norma=${NORMA_BIN:-$tree/bin/norma}
cd "$root" || exit 1
export MESA_SHADER_CACHE_DISABLE=true

"$norma" acid -o "$scratch/scenes" --quiet || { skip "the tree was built without images"; finish; exit; }
scene=$scratch/scenes/norma-acid.glb
straight=(--camera 0,0 --fov 0 --renderer software --quiet)
if ! "$norma" render "$scene" -o "$scratch/shot.png" --size 1600x1200 "${straight[@]}" 2>"$scratch/message"; then
    skip "nothing can be drawn here: $(cat "$scratch/message")"
    finish
    exit
fi
check "norma render passes every cell" "$norma" acid --judge "$scratch/shot.png"
"$norma" render "$scene" -o "$scratch/far.png" --size 1600x1200 "${straight[@]}" --fov 2
check "seen from far away too" "$norma" acid --judge "$scratch/far.png"
for file in "$scratch"/scenes/cells/*.glb; do
    name=$(basename "$file" .glb)
    "$norma" render "$file" -o "$scratch/alone.png" --size 800x600 "${straight[@]}"
    check "$name alone passes" "$norma" acid --judge "$scratch/alone.png" --scene "$file"
done

# ---- mistakes: named in each cell where they lie beside the subject

built=$scratch/mistakes
# Compiled as scripts/tree.sh does, so that ccache has what is the same.
as_first_tree="-DCMAKE_C_COMPILER=gcc -DCMAKE_BUILD_TYPE=Release -DCMAKE_C_FLAGS_RELEASE=-O2 -DNORMA_WERROR=ON"
# shellcheck disable=SC2086  # a list of words
if ! { cmake -S . -B "$built" -G Ninja $as_first_tree -DNORMA_MISTAKES=ON -DNORMA_TESTS=OFF -DNORMA_WEB=OFF -DNORMA_SHARED=OFF -DNORMA_EXAMPLES=OFF && cmake --build "$built" --target norma-cli; } >"$scratch/log" 2>&1; then
    fail "norma render with mistakes is built" "$(tail -n 20 "$scratch/log")"
    finish
    exit
fi
# verdicts SHOT: "cell verdict mistake" of each cell that has $mistake beside it; others to $scratch/misnamed if they name a mistake that was not made.
verdicts() {
    "$norma" acid --judge "$1" --json >"$scratch/json"
    python3 - "$scratch/json" "$scratch/scenes/acid.json" "$mistake" tests/support/acid_also.txt 2>"$scratch/misnamed" <<'END'
import json, sys
found = {cell["id"]: cell for cell in json.load(open(sys.argv[1]))["cells"]}
for cell in json.load(open(sys.argv[2]))["cells"]:
    if any(r["id"] == sys.argv[3] for r in cell["references"]):
        print(cell["id"], found[cell["id"]]["verdict"], found[cell["id"]]["mistake"])
also = {tuple(line.split()[:3]) for line in open(sys.argv[4])}
for cell in found.values():
    if cell["verdict"] == "missing" or cell["mistake"] not in (None, sys.argv[3]) and (sys.argv[3], cell["id"], cell["mistake"]) not in also:
        print(cell["id"], cell["verdict"], cell["mistake"], file=sys.stderr)
END
}
# draw MISTAKE OUT [OPTION...]
draw() { NORMA_MISTAKE=$1 "$built/bin/norma" render "$scene" -o "$2" --size 1600x1200 "${straight[@]}" --weight area "${@:3}"; }
draw none "$scratch/shot.png"
check "with no mistake chosen, it passes" "$norma" acid --judge "$scratch/shot.png"
for mistake in $(grep -oE '\{"id": "[a-z-]+"' "$scratch/scenes/acid.json" | sed 's/.*"id": "//; s/"//' | grep -vx right | sort -u); do
    grep -qE "[\"_]${mistake//-/[-_]}\b" tests/support/mistakes.cmake || continue
    draw "$mistake" "$scratch/shot.png"
    verdicts "$scratch/shot.png" >"$scratch/verdicts"
    # Two mirrors make none.
    wrong=$(grep -v " fail $mistake\$" "$scratch/verdicts" | grep -v "^mirror-twice pass None")
    check "$mistake: no cell names another mistake" test ! -s "$scratch/misnamed"
    if [ -s "$scratch/verdicts" ] && [ -z "$wrong" ]; then pass "$mistake is named in $(wc -l <"$scratch/verdicts") cells"; else fail "$mistake is named" "$wrong"; fi
done
# Reversed normals are black without ambient light; on black they may as well be no surface at all.
draw reversed "$scratch/shot.png" --background black --phong 0,1,0,1
"$norma" acid --judge "$scratch/shot.png" --json >"$scratch/json"
check "what black hides is not called missing" python3 -c '
import json, sys
found = {c["id"]: c["verdict"] for c in json.load(open(sys.argv[1]))["cells"]}
assert found["control"] == found["rotation"] == "pass" and "missing" not in found.values(), found
assert found["mirror"] == found["skinned-mirror"] == found["tangent-mirror"] == "unclear", found' "$scratch/json"
finish
