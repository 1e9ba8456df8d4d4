#!/bin/bash
# The Blender add-on, which `make blender` tests: the zip is installed into a Blender without a window; made scenes and files of the data set are compared with the command-line tool.
# What needs no Blender is tested in tests/python/wheel.sh too, after the wheel that the zip is made of.
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
cd "$root" || exit 1
data=${NORMA_DATA:-$root/../shared/data}
bin=${NORMA_BIN:-$tree/bin/norma}
if ! command -v blender >/dev/null; then
    skip "Blender is not installed"
    finish
    exit
fi
if ! zip=$(scripts/blender.sh 2>"$scratch/build.err" | tail -n 1); then
    fail "the add-on is built" "$(cat "$scratch/build.err")"
    finish
    exit 1
fi
pass "the add-on is built"
check "the parts that need no Blender" "${PYTHON:-/usr/bin/python3}" tests/blender/test_pure.py "$zip"
check "the calls of Blender's versions" "${PYTHON:-/usr/bin/python3}" tests/blender/test_versions.py "$zip"

files=("$PWD/assets/goathead.obj" "$PWD/assets/box-rotated.obj")
for name in truth/icosphere.obj truth/dodecahedron.obj obj/spot-quads-ngons.obj gltf/misc/no-indices.glb gltf/misc/nonuniform-nested.glb gltf/misc/box-vertex-colors.glb \
    gltf/misc/two-cubes-no-normals.glb large/voxel/veh_tank1.glb large/toon/bee-bot.glb; do
    [ ! -e "$data/$name" ] || files+=("$data/$name")
done
status=0
BLENDER_USER_SCRIPTS=$scratch/scripts BLENDER_USER_CONFIG=$scratch/config timeout 600 blender -b --factory-startup --python-exit-code 1 --python tests/blender/test_addon.py -- "$zip" "$bin" "${files[@]}" \
    >"$scratch/out" 2>&1 || status=$?
# unittest prints a case's name before what Blender prints during it, and its result after.
while IFS=$'\t' read -r name result; do
    case $result in
    ok) pass "in Blender: $name" ;;
    skipped*) skip "in Blender: $name: $result" ;;
    *) fail "in Blender: $name" "$(sed -n '/^=====/,$p' "$scratch/out")" ;;
    esac
done < <(awk '/^test_[a-z_]+ \(/ { name = $1 } name && match($0, /(^| )(ok|FAIL|ERROR|skipped .*)$/) { print name "\t" substr($0, RSTART + ($0 ~ /^(ok|FAIL|ERROR|skipped)/ ? 0 : 1)); name = "" }' "$scratch/out")
check "Blender ends well" test "$status" = 0
finish
