#!/bin/bash
# Plain cmake on a machine with a compiler and cmake alone: everything optional is left out, the summary says so, and what was left out says so when it is asked for.
# The other packages are hidden from cmake, and the generator is its default one.
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
cd "$root" || exit 1
plain=$scratch/plain

machine=$(gcc -print-multiarch)
check "cmake configures" bash -c 'env -u CMAKE_GENERATOR cmake -S . -B "$0" -DCMAKE_BUILD_TYPE=Debug "-DCMAKE_IGNORE_PATH=/usr/include;/usr/include/$2;/usr/lib/$2" >"$1" 2>&1 || { cat "$1"; exit 1; }' "$plain" "$scratch/configured" "$machine"
for part in meshoptimizer draco 3MF 'norma render' 'norma view' tests; do
    check "the summary says that this is left out: $part" grep -qE -- "-- .*$part.* no(,.* not found \(Debian: .*|\$)" "$scratch/configured"
done
check "cmake builds" cmake --build "$plain" -j "${JOBS:-$(nproc)}"
norma=$plain/bin/norma
check "the tool needs the C library alone" bash -c '! readelf -d "$0" | grep NEEDED | grep -vE "lib(c|m)\.so|ld-linux"' "$norma"
check "compute works" "$norma" compute assets/goathead.obj -o "$scratch/goathead.obj" --quiet
check "the mesh is the other build's" cmp "$scratch/goathead.obj" <("$tree/bin/norma" compute assets/goathead.obj -o - --quiet)

# told NAME STATUS TEXT COMMAND...: the command exits so and says so.
told() {
    local name=$1 wanted=$2 text=$3 output status=0
    shift 3
    output=$("$@" 2>&1) || status=$?
    if [ "$status" = "$wanted" ] && grep -qF -- "$text" <<<"$output"; then pass "$name"; else fail "$name" "status $status: $output"; fi
}
told "render says that it is left out" 3 "pictures are not in this build" "$norma" render assets/goathead.obj -o "$scratch/picture.png"
cp assets/goathead.obj "$scratch/mesh.obj"
echo '{"spelling": 1}' >"$scratch/.norma.json"
told "a configuration is read" 2 "spelling: expected profile, strict" "$norma" check "$scratch/mesh.obj"
rm "$scratch/.norma.json"
# A triangle whose positions are said to be compressed.
cat >"$scratch/packed.gltf" <<'GLTF'
{"asset":{"version":"2.0"},"extensionsUsed":["EXT_meshopt_compression"],"extensionsRequired":["EXT_meshopt_compression"],
 "buffers":[{"byteLength":36,"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA"}],
 "bufferViews":[{"buffer":0,"byteLength":36,"byteStride":12,"extensions":{"EXT_meshopt_compression":{"buffer":0,"byteLength":36,"byteStride":12,"count":3,"mode":"ATTRIBUTES"}}}],
 "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}],
 "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"nodes":[{"mesh":0}],"scenes":[{"nodes":[0]}],"scene":0}
GLTF
told "compute refuses compressed glTF" 3 "needs meshoptimizer, which this Norma was built without" "$norma" compute "$scratch/packed.gltf" -o "$scratch/out.gltf"
sed "s/EXT_meshopt/KHR_draco_mesh/g" "$scratch/packed.gltf" >"$scratch/draco.gltf"
told "compute refuses what Draco packed" 3 "needs libdraco, which this Norma was built without" "$norma" compute "$scratch/draco.gltf" -o "$scratch/out.gltf"
printf 'PK\003\004' >"$scratch/box.3mf"
told "check refuses 3MF" 3 "3MF needs zlib, which this Norma was built without" "$norma" check "$scratch/box.3mf"
told "check of nothing that could be checked is an error" 1 "N002" "$norma" check "$scratch/packed.gltf"

# The core alone.
core=$scratch/core
check "NORMA_FILES=OFF configures" cmake -S . -B "$core" -DCMAKE_BUILD_TYPE=Debug -DNORMA_FILES=OFF
check "it builds" cmake --build "$core" -j "${JOBS:-$(nproc)}"
check "it installs" cmake --install "$core" --prefix "$scratch/prefix"
check "it installs the core and nothing else" test "$(cd "$scratch/prefix" && find . -name '*.a' -o -name '*.h' -o -path './bin/*' | sort | tr '\n' ' ')" = "./include/norma/norma.h ./lib/libnorma-core.a "
finish
