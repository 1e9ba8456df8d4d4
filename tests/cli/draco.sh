#!/bin/bash
# Files of the data set, packed by gltf-transform and unpacked by draco3d: Norma must find the same in both, and change the packed one as it changes the other, with nothing new for the
# Khronos validator to say. The reader's own tests are in tests/unit/io/test_draco.c.
# shellcheck source=tests/support/gltf_judges.sh
source "$(dirname "$0")/../support/gltf_judges.sh"
modules=${NORMA_NPM_WEB:-$root/build/npm-web/node_modules}
needs_data
[ -d "$modules/draco3dgltf" ] && [ -d "$modules/@gltf-transform/functions" ] || { skip "gltf-transform or draco3d is not installed"; finish; exit; }
if ! "$norma" check "$data/gltf/misc/box-draco.glb" --quiet >"$scratch/box" 2>&1 || grep -q "without libdraco" "$scratch/box"; then skip "the tool was built without libdraco"; finish; exit; fi

files="gltf/khronos/VertexColorTest/VertexColorTest.gltf gltf/khronos/SimpleMeshes/SimpleMeshes.gltf gltf/khronos/OrientationTest/OrientationTest.gltf gltf/khronos/RiggedSimple/RiggedSimple.gltf
    gltf/khronos/Fox/Fox.gltf gltf/khronos/NegativeScaleTest/NegativeScaleTest.gltf gltf/misc/box-data-uri.gltf"
pairs=()
for file in $files; do
    for found in "$data/$file" "${data}/${file%.gltf}.glb"; do
        [ -f "$found" ] && pairs+=("$found") && break
    done
done
check "there are files to pack" test ${#pairs[@]} -ge 3

for method in edgebreaker sequential; do
    arguments=()
    for file in "${pairs[@]}"; do arguments+=("$file" "$scratch/$method-$(basename "${file%.*}")"); done
    check "$method: gltf-transform packs" node --no-warnings "$validator/../draco/pack.mjs" "$modules" "$method" "${arguments[@]}"
done
packed=$(find "$scratch" -name '*.glb' ! -name '*.plain.glb' -exec grep -laF KHR_draco_mesh_compression {} + | LC_ALL=C sort)
check "some of them are packed now" test "$(wc -l <<<"$packed")" -ge 6

# findings FILE: without the file's name and the time that it took.
findings() { "$norma" check "$1" --format line --info 2>&1 | sed "s|$1||g" | LC_ALL=C sort; }
different=""
for file in $packed; do
    if ! diff <(findings "$file") <(findings "${file%.glb}.plain.glb") >"$scratch/difference"; then different+="$file"$'\n'$(head -n 5 "$scratch/difference")$'\n'; fi
done
if [ -z "$different" ]; then pass "the same findings packed and unpacked"; else fail "the same findings packed and unpacked" "$different"; fi

changed() { # NAME VERB OPTIONS...
    local name=$1 file out packs=0
    shift
    : >"$scratch/$name.plain"
    : >"$scratch/$name.drawn"
    for file in $packed; do
        out=$scratch/$name-$(basename "$file")
        "$norma" "$@" "$file" -o "$out" --quiet 2>"$scratch/message" || { fail "$name $file" "$(cat "$scratch/message")"; continue; }
        grep -qaF KHR_draco_mesh_compression "$out" && continue # parts of it did not change, and no judge reads those
        packs=$((packs + 1))
        printf '%s\t%s\n' "${file%.glb}.plain.glb" "$out" >>"$scratch/$name.plain"
    done
    check "$name: some are written without Draco" test $packs -ge 4
    judge_validity "$name" "$scratch/$name.plain"
}
changed flat compute --flat
changed moved transform --bake --matrix "1 0.5 0 3  0 1 0.25 -2  0.125 0 -1.5 11  0 0 0 1"
check "moved: what is drawn is what was, moved" node "$validator/world.mjs" --quiet --bake --matrix "1 0.5 0 3  0 1 0.25 -2  0.125 0 -1.5 11  0 0 0 1" --list "$scratch/moved.plain"

# One file by every verb that reads.
box=$data/gltf/misc/box-draco.glb
check "info names the compression" bash -c '"$0" info "$1" --json | grep -q "\"compression\": \"KHR_draco_mesh_compression\""' "$norma" "$box"
if "$norma" render "$box" -o "$scratch/box.png" --quiet >"$scratch/render" 2>&1; then
    pass "render draws it"
elif grep -q "not in this build\|display\|EGL" "$scratch/render"; then
    skip "render: $(head -n 1 "$scratch/render")"
else
    fail "render draws it" "$(cat "$scratch/render")"
fi
check "a note says that it is written uncompressed" bash -c '"$0" compute "$1" --smooth -o "$2" 2>&1 | grep -q "was compressed with KHR_draco_mesh_compression; it has changed and is written uncompressed"' "$norma" "$box" "$scratch/smooth.glb"

# Cut short anywhere behind the JSON: one line, the file's name, status 3, nothing written.
head -c 1000 "$box" >"$scratch/short.glb"
check "a GLB that is cut short is refused" bash -c '"$0" compute "$1" -o "$2" 2>"$3"; [ $? = 3 ] && [ ! -e "$2" ] && [ "$(wc -l <"$3")" = 1 ]' "$norma" "$scratch/short.glb" "$scratch/none.glb" "$scratch/message"
size=$(stat -c %s "$box")
{ head -c $((size - 60)) "$box"; head -c 60 /dev/zero; } >"$scratch/damaged.glb"
check "a damaged stream is refused in one line" bash -c '"$0" compute "$1" -o "$2" 2>"$3"; [ $? = 3 ] && [ ! -e "$2" ] && [ "$(wc -l <"$3")" = 1 ] && grep -q "damaged.glb.*/meshes/0/primitives/0.*Draco stream" "$3"' "$norma" "$scratch/damaged.glb" "$scratch/none.glb" "$scratch/message"
finish
