#!/bin/bash
# Every glTF of the data set through norma tangents. Judges that are not ours: the Khronos validator may say nothing new but that tangents are not used;
# tests/cli/validator/corners.mjs finds all but tangents as it was, and the tangents those of three.js's addon. Then a file made for it: a normal map that is turned.
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
data=${NORMA_DATA:-$root/../shared/data}
norma=${NORMA_BIN:-$tree/bin/norma}
validator=$root/tests/cli/validator
modules=${NORMA_NPM_TANGENT:-$root/build/npm-tangent/node_modules}
export NODE_PATH=${NODE_PATH:-$root/build/npm/node_modules}
if ! [ -d "$modules/three" ] || ! command -v node >/dev/null; then
    skip "tangents of glTF: scripts/install-deps.sh has not been run"
    finish
    exit
fi

# charts.gltf: a square of two triangles, and another with its corners mirrored in texture space, that share an edge's vertices; a morph target that bends them; and a normal
# map that is moved, scaled and turned. three.js looks the map up by the same numbers.
charts=$root/tests/tangent/charts.gltf
said=$("$norma" tangents "$charts" -o "$scratch/out.gltf" 2>&1)
check "a turned map, two mirrored charts: the two vertices between them are split" grep -q "vertices 6 -> 8" <<<"$said"
judged=$(node "$validator/corners.mjs" --tangents "$modules" "$charts" "$scratch/out.gltf")
check "a turned map: tangents and differences of three.js" grep -q "1 pairs, 0 wrong, 0 primitives passed over; tangents of 1 primitives and 1 morph targets, 12 corners, at 0" <<<"$judged"
check "info: how these tangents were made" grep -q "MikkTSpace on triangles through the texture transform, sign negated: .*12 of 12 corners explained" <(
    "$norma" info "$scratch/out.gltf" --deep
)
"$norma" tangents "$scratch/out.gltf" -o "$scratch/again.gltf" --quiet
check "tangents of tangents: the same file" cmp "$scratch/out.gltf" "$scratch/again.gltf"
"$norma" tangents "$scratch/out.gltf" -o "$scratch/missing.gltf" --quiet --only missing
check "--only missing changes nothing where there are tangents" cmp "$scratch/out.gltf" "$scratch/missing.gltf"
# Tangents on new normals: those that norma tangents gives once the normals are there, by three.js again. The same charts with normals that lean far off their plane.
sed 's/"NORMAL":1,"TEXCOORD_0"/"NORMAL":5,"TEXCOORD_0"/' "$charts" >"$scratch/leaning.gltf"
"$norma" tangents "$scratch/leaning.gltf" -o "$scratch/stale.gltf" --quiet
"$norma" compute "$scratch/stale.gltf" -o "$scratch/flat.gltf" --quiet --flat --tangents keep
"$norma" compute "$scratch/stale.gltf" -o "$scratch/renewed.gltf" --quiet --flat --tangents regenerate
judged=$(node "$validator/corners.mjs" --tangents "$modules" "$scratch/flat.gltf" "$scratch/renewed.gltf")
check "--tangents regenerate: tangents and differences of three.js" grep -q "1 pairs, 0 wrong, 0 primitives passed over; tangents of 1 primitives and 1 morph targets, 12 corners, at 0" <<<"$judged"
"$norma" check "$charts" --fix-unsafe --select N805 -o "$scratch/fixed.gltf" >/dev/null 2>&1
judged=$(node "$validator/corners.mjs" --tangents "$modules" "$charts" "$scratch/fixed.gltf")
check "check --fix-unsafe: a normal map gets tangents of three.js" grep -q "1 pairs, 0 wrong, 0 primitives passed over; tangents of 1 primitives and 1 morph targets, 12 corners, at 0" <<<"$judged"
"$norma" tangents "$root/assets/goathead.obj" -o "$scratch/a.obj" 2>"$scratch/err"
check "an OBJ is a usage error" test $? -eq 2

if ! [ -d "$data" ]; then
    skip "tangents of the data set's files: it is not there"
    finish
    exit
fi
mkdir "$scratch/all"
number=0 wrong=""
while IFS=$'\t' read -r file expect; do
    number=$((number + 1))
    mkdir "$scratch/all/$number"
    out=$scratch/all/$number/$(basename "$file")
    if "$norma" tangents "$data/$file" -o "$out" --quiet 2>"$scratch/message"; then
        cmp -s "$data/$file" "$out" || printf '%s\t%s\n' "$data/$file" "$out" >>"$scratch/pairs"
    elif [ "$expect" = ok ] || [ "$expect" = lint ]; then
        wrong+=$(cat "$scratch/message")$'\n'
    fi
done < <(cut -f1,6 "$data/INDEX.tsv" | grep -iE '\.(gltf|glb)	')
if [ -z "$wrong" ]; then pass "$(wc -l <"$scratch/pairs") of $number files changed"; else fail "refused" "$wrong"; fi
output=$(node "$validator/compare.mjs" --allow UNUSED_MESH_TANGENT --list "$scratch/pairs" 2>&1)
case $? in
0) pass "validator: $(tail -n 1 <<<"$output")" ;;
77) skip "$output" ;;
*) fail "validator" "$output" ;;
esac
if output=$(node "$validator/corners.mjs" --quiet --tangents "$modules" --list "$scratch/pairs" 2>&1); then
    pass "all but tangents, and tangents bit for bit: $(tail -n 1 <<<"$output")"
else
    fail "all but tangents, and tangents bit for bit" "$output"
fi
finish
