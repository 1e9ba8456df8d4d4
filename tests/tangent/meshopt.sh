#!/bin/bash
# norma tangents --mode meshopt against the npm package meshoptimizer: the tangents of corners, those that files get, and what norma says of files that hold them.
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
modules=${NORMA_NPM_TANGENT:-$root/build/npm-tangent/node_modules}
data=${NORMA_DATA:-$root/../shared/data}
norma=${NORMA_BIN:-$tree/bin/norma}
corners=$root/tests/cli/validator/corners.mjs
if ! [ -d "$modules/meshoptimizer" ] || ! command -v node >/dev/null; then
    skip "meshoptimizer's tangents: scripts/install-deps.sh has not been run"
    finish
    exit
fi
files=()
[ ! -d "$data" ] || mapfile -t files < <(find "$data" \( -name '*.glb' -o -name '*.gltf' -o -name '*.obj' \) -size -1024k | sort)
relay corners node "$root/tests/tangent/meshopt.mjs" "$tree/tests/tangents_of" "$modules" "${files[@]}"

# A roof of two panes, one twice as wide as the other, over one map: at the ridge MikkTSpace gives both panes the same say, meshoptimizer the wide one more.
node "$root/tests/tangent/panes.mjs" "$scratch/panes.gltf"
for mode in mikk meshopt; do "$norma" tangents "$scratch/panes.gltf" --mode "$mode" -o "$scratch/$mode.gltf" --quiet; done
check "a glTF gets the package's tangents (one corner has those of its fallback)" grep -q "1 pairs, 0 wrong, 0 primitives passed over; tangents of 1 primitives and 0 morph targets, 6 corners, at 1 of" <(
    node "$corners" --meshopt "$modules" "$scratch/panes.gltf" "$scratch/meshopt.gltf"
)
check "info names MikkTSpace's" grep -q "stored tangents are best explained by MikkTSpace on triangles, sign negated: .*; 6 of 6 corners explained" <("$norma" info --deep "$scratch/mikk.gltf")
check "info names meshoptimizer's" grep -q "stored tangents are best explained by meshoptimizer, sign negated: .*; 6 of 6 corners explained" <("$norma" info --deep "$scratch/meshopt.gltf")
said=$("$norma" check "$scratch/meshopt.gltf" --select N807 --info 2>&1)
check "N807 names them" grep -q "best explained by meshoptimizer" <<<"$said"
# By hand: at the ridge's lower end the panes meet at right angles to it, with edges of 1 and 1, of 1 and 2: the tangents point (1 + sqrt 2, sqrt 2) and, by MikkTSpace, along pi/8.
check "N807: a map errs by 7.86 degrees under MikkTSpace" grep -q "errs by up to 7.86 degrees .* MikkTSpace" <<<"$said"

if [ -d "$data/large/game" ]; then
    for file in large/toon/bee-bot.glb large/game/vino-scooter.glb; do
        "$norma" tangents "$data/$file" --mode meshopt -o "$scratch/out.glb" --quiet
        check "$file gets the package's tangents" node "$corners" --meshopt "$modules" "$data/$file" "$scratch/out.glb"
    done
else
    skip "tangents of large files: they are not there"
fi
finish
