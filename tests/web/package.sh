#!/bin/bash
# The npm package, installed as a user has it: the same bits as the native library, arguments and errors, files, workers, three.js, glTF-Transform, bundles in a browser, the README, types, examples.
#   tests/web/package.sh --refresh     writes the examples' expected output anew
# shellcheck disable=SC2016  # single quotes hold what inner shells expand
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
cd "$root" || exit 1
refresh=${1:-}
package=$tree/web/npm
tool=${NORMA_BIN:-$tree/bin/norma}
modules=${NORMA_NPM_WEB:-$root/build/npm-web/node_modules}

if [ ! -f "$package/index.js" ]; then
    skip "the npm package (this tree is built without -DNORMA_WEB=ON)"
    finish
    exit
fi

# As a user has it: packed by npm and installed into a fresh folder. All that follows uses that.
version=$(sed -nE 's/^project\(norma VERSION ([0-9.]+).*/\1/p' CMakeLists.txt)
user=$scratch/user
mkdir -p "$user"
echo '{ "name": "user", "private": true, "type": "module" }' >"$user/package.json"
if ! { (cd "$package" && npm pack --silent --pack-destination "$scratch") >/dev/null && (cd "$user" && npm install --offline --no-audit --no-fund --silent "$scratch/norma-mesh-$version.tgz"); } 2>"$scratch/pack.err"; then
    fail "npm pack and npm install" "$(cat "$scratch/pack.err")"
    finish
    exit
fi
pass "npm pack and npm install"
installed=$user/node_modules/norma-mesh
check "package.json has the library's version" test "$(node -p 'require(process.argv[1]).version' "$installed/package.json")" = "$version"
check "the core is at most 120 kB (brotli)" node -e 'process.exit(require("zlib").brotliCompressSync(require("fs").readFileSync(process.argv[1])).length > 120000 ? 1 : 0)' "$installed/norma.wasm"
check "the decoder for Draco is at most 60 kB (brotli)" node -e 'process.exit(require("zlib").brotliCompressSync(require("fs").readFileSync(process.argv[1])).length > 60000 ? 1 : 0)' "$installed/draco.wasm"
check "nothing of the page or of C is in the package" bash -c '! find "$0" -type f ! -name "*.js" ! -name "*.d.ts" ! -name "norma.wasm" ! -name "check.wasm" ! -name "draco.wasm" ! -name "tool.wasm" ! -name package.json ! -name README.md ! -name LICENSE ! -name NOTICES | grep .' "$installed"
for path in "$modules"/* "$modules"/@*/*; do
    name=${path#"$modules"/}
    [ ! -e "$path" ] || [[ $name == @* && $name != */* ]] || { mkdir -p "$(dirname "$user/node_modules/$name")" && ln -s "$path" "$user/node_modules/$name"; }
done

check "the native program compiles" gcc -std=c11 -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Werror -O1 -Iinclude tests/web/native.c -o "$scratch/native" "$tree/lib/libnorma.a" -lmeshoptimizer -ldraco -lstdc++ -lpng -ljpeg -lz -lm -pthread
relay bits node tests/web/bits.mjs "$installed" "$scratch/native"
relay "bits of norma-mesh/normals" node tests/web/bits.mjs "$installed" "$scratch/native" normals
relay "norma-mesh/normals" node tests/web/normals.mjs "$installed"
relay calls node tests/web/calls.mjs "$installed"
relay arguments node tests/web/arguments.mjs "$installed"
relay skins node tests/web/skin.mjs "$installed"
data=${NORMA_DATA:-$root/../shared/data}
places=(assets tests/cli)
[ ! -d "$data" ] || places+=("$data/bad" "$data/gltf" "$data/obj" "$data/ply")
# 3MF is there where npm's fflate was when the package was built.
has_3mf=() no_3mf='|\.3mf'
if grep -q 'code of fflate' "$installed/NOTICES"; then
    has_3mf=(-o -name '*.3mf') no_3mf=
    [ ! -d "$data/fresh/3mf" ] || places+=("$data/fresh/3mf")
else
    skip "3MF (this tree was built without fflate: scripts/install-deps.sh)"
fi
mapfile -d '' files < <(find "${places[@]}" -size -400k \( -name '*.obj' -o -name '*.stl' -o -name '*.ply' -o -name '*.gltf' -o -name '*.glb' "${has_3mf[@]}" \) -print0)
relay files node tests/web/files.mjs "$installed" "$tool" "${files[@]}"
# The tool itself, under node's WASI: the cases of the command line, byte by byte. It cannot draw, limit its memory, open a shell's pipes by name or take names that are not UTF-8.
command=$user/node_modules/.bin/norma-mesh
check "npx norma-mesh is the tool" test "$(cd "$user" && npx --no-install norma-mesh --version)" = "$("$tool" --version)"
relay "npx norma-mesh" env NORMA_SAYS="npx norma-mesh" NORMA_LEFT_OUT='norma render|help render|norma view|norma mcp|--max-memory|<\(|\\xff|^norma( --help)?$|explain N501'"$no_3mf" NORMA_BIN="$command" tests/cli/golden.sh
relay "npx norma-mesh beside the tool" node tests/web/tool.mjs "$command" "$(realpath "$tool")" "$root/assets" "$root/tests/cli/golden/files" tests/web/ball-draco.glb tests/web/ball-meshopt.glb
relay "files in, files out" node tests/web/edits.mjs "$installed" "$(realpath "$tool")" "$root"/assets/*.obj "$root"/assets/*.stl "$root"/tests/cli/golden/files/*.* "$root"/tests/web/ball-*.glb
if [ -z "$no_3mf" ]; then
    relay 3MF node tests/web/3mf.mjs "$installed" "$(realpath "$tool")" "$root/tests/cli/golden/files/turned.3mf"
    samples=("$data"/fresh/3mf/examples/*/*.3mf)
    if [ -f "${samples[0]}" ] && command -v unzip >/dev/null; then
        relay "npx norma-mesh turns triangles back" python3 tests/cli/judge_3mf.py "$command" "$scratch" "${samples[@]}"
    else
        skip "turned triangles of 3MF (no samples, or no unzip)"
    fi
fi
relay workers node tests/web/workers.mjs "$installed"

# What imports the package by its name lies beside it.
cp tests/web/*.mjs tests/web/app.js tests/web/types*.ts tests/web/types.json "$user"
beside() { (cd "$user" && exec "$@"); }
if [ -d "$modules/three" ]; then relay three beside node three.mjs; else skip "three.js (not installed: scripts/install-deps.sh)"; fi
gltf=()
for file in khronos/AnimatedMorphCube/AnimatedMorphCube.gltf khronos/Fox/Fox.gltf khronos/MeshPrimitiveModes/MeshPrimitiveModes.gltf khronos/BoxInterleaved/BoxInterleaved.gltf generator/Mesh_PrimitivesUV/Mesh_PrimitivesUV_06.gltf \
    quantized/avocado-quant.glb quantized/lantern-quant-norm.glb; do
    [ ! -f "$data/gltf/$file" ] || gltf+=("$data/gltf/$file")
done
if [ -d "$modules/@gltf-transform" ]; then relay "glTF-Transform" beside node gltf-transform.mjs "$(realpath "$tool")" "$root/tests/cli/golden/files/roof.gltf" "${gltf[@]}"; else skip "glTF-Transform (not installed: scripts/install-deps.sh)"; fi
printf 'export default "%s";\n' "$(base64 -w 0 tests/fuzz/corpus/glb/draco)" >"$user/packed-file.js"
is_packed=$(node -p 'require("fs").statSync(process.argv[1]).size > 8 && /meshoptimizer/.test(require("fs").readFileSync(process.argv[2], "utf8"))' "$installed/draco.wasm" "$installed/NOTICES")
if [ "$is_packed" != true ]; then
    skip "compressed glTF (this tree was built without the sources of meshoptimizer and draco: scripts/install-deps.sh)"
elif [ -d "$modules/draco3dgltf" ] && [ -d "$modules/@gltf-transform" ]; then
    packed=("$root"/tests/web/ball-*.glb "$root/tests/fuzz/found/draco/orientations")
    for file in gltf/misc/box-draco.glb gltf/misc/box-meshopt.glb gltf/quantized/avocado-meshopt.glb; do [ ! -f "$data/$file" ] || packed+=("$data/$file"); done
    relay "compressed glTF" beside node packed.mjs "$(realpath "$tool")" "${packed[@]}"
else
    skip "compressed glTF (draco3d is not installed: scripts/install-deps.sh)"
fi
if [ -d "$modules/react" ]; then relay adapters beside node adapters.mjs; else skip "Babylon.js, PlayCanvas, React (not installed: scripts/install-deps.sh)"; fi
if [ -d "$modules/three" ]; then relay bundles beside node bundles.mjs; else skip "bundles (three.js is not installed)"; fi
relay README beside node readme.mjs "$(realpath "$tool")" "$root/tests/cli/golden/files/roof.gltf"

# What the page makes of a file, with the sanitizers of a native compiler.
check "the model's files compile under the sanitizers" gcc -std=c11 -g -O1 -fsanitize=address,undefined -fno-sanitize-recover=all -Wno-attributes -Iinclude -Isrc tests/web/model.c \
    web/page/model/model.c web/page/model/recompute.c web/page/model/crease_slider.c web/page/model/shown_findings.c web/page/model/pick.c web/package/wasm/calls.c web/page/model/model_pack.c web/page/model/pack_findings.c web/page/model/pack_materials.c -o "$scratch/model" "$tree/lib/libnorma.a" -lmeshoptimizer -ldraco -lstdc++ -lpng -ljpeg -lz -lm -pthread
check "packs of the assets are drawn, and damaged ones drawn or refused" "$scratch/model" assets/*.obj assets/*.stl tests/cli/golden/files/*.obj tests/cli/golden/files/roof.*

cp examples/web/*.mjs "$user"

for example in examples/web/*.mjs; do
    name=$(basename "$example" .mjs)
    for engine in three react playcanvas @babylonjs/core; do
        if grep -q "from \"$engine[\"/]" "$example" && [ ! -d "$modules/$engine" ]; then
            skip "$name ($engine is not installed: scripts/install-deps.sh)"
            continue 2
        fi
    done
    if ! (cd "$user" && node "$name.mjs") >"$scratch/$name.out" 2>"$scratch/$name.err"; then
        fail "examples/web/$name.mjs runs" "$(cat "$scratch/$name.err")"
        continue
    fi
    [ "$refresh" != --refresh ] || cp "$scratch/$name.out" "tests/web/expected/$name.txt"
    if difference=$(diff "tests/web/expected/$name.txt" "$scratch/$name.out" 2>&1); then pass "examples/web/$name.mjs prints what it should"; else fail "examples/web/$name.mjs prints what it should" "$difference"; fi
done

if [ -d "$modules/typescript" ]; then
    check "types: tsc --strict" bash -c 'cd "$0" && node node_modules/typescript/bin/tsc -p types.json' "$user"
else
    skip "types (typescript is not installed: scripts/install-deps.sh)"
fi
finish
