#!/bin/bash
# norma pack: every glTF of the data set at two bounds. Judges that are not ours: the Khronos validator may say nothing new; tests/cli/validator/corners.mjs reads both
# files, finds all but normals and tangents as it was, and recomputes the angle of every direction, those of morph targets among them.
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
data=${NORMA_DATA:-$root/../shared/data}
norma=${NORMA_BIN:-$tree/bin/norma}
validator=$root/tests/cli/validator
export NODE_PATH=${NODE_PATH:-$root/build/npm/node_modules}
if ! command -v node >/dev/null; then
    skip "norma pack: scripts/install-deps.sh has not been run"
    finish
    exit
fi

# judge NAME DEG: the pairs of a list.
judge() {
    local output
    output=$(node "$validator/compare.mjs" --list "$scratch/pairs" 2>&1)
    case $? in
    0) pass "$1: validator: $(tail -n 1 <<<"$output")" ;;
    77) skip "$output" ;;
    *) fail "$1: validator" "$output" ;;
    esac
    if output=$(node "$validator/corners.mjs" --quiet --packed "$2" --list "$scratch/pairs" 2>&1); then
        pass "$1: all but normals and tangents, and these within $2 degrees: $(tail -n 1 <<<"$output")"
    else
        fail "$1: all but normals and tangents, and these within $2 degrees" "$output"
    fi
}

# A file of one triangle with two targets, made here: base and differences, of which one is far too large for codes; normals beside positions in rows, and a shared accessor.
node - "$scratch" <<'JS'
const { writeFileSync } = require("fs"), folder = process.argv[2];
const rows = [[0, 0, 0, 0, 0, 1], [1, 0, 0, 0.6, 0, 0.8], [0, 1, 0, 0, 0.28, 0.96]].flat();
const small = [0.1, 0.05, 0, 0, 0, 0, -0.2, 0.1, 0.1], large = [3, 0, 0, 0, 2, 0, 0, 0, -4];
const bytes = Buffer.from(Float32Array.from([...rows, ...small, ...large]).buffer);
const vec3 = (bufferView, byteOffset, more) => ({ bufferView, byteOffset, componentType: 5126, count: 3, type: "VEC3", ...more });
const position = { min: [0, 0, 0], max: [1, 1, 0] };
const asset = {
  asset: { version: "2.0" }, scene: 0, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0 }],
  meshes: [{ primitives: [0, 1].map(() => ({ attributes: { POSITION: 0, NORMAL: 1 }, targets: [{ NORMAL: 2 }, { NORMAL: 3 }] })) }],
  accessors: [vec3(0, 0, position), vec3(0, 12), vec3(1, 0), vec3(1, 36)],
  bufferViews: [{ buffer: 0, byteLength: 72, byteStride: 24, target: 34962 }, { buffer: 0, byteOffset: 72, byteLength: 72, byteStride: 12, target: 34962 }],
  buffers: [{ byteLength: bytes.length, uri: "data:application/octet-stream;base64," + bytes.toString("base64") }],
};
writeFileSync(`${folder}/morph.gltf`, JSON.stringify(asset));
const picture = { ...asset, buffers: [{ byteLength: bytes.length }], images: [{ uri: "picture.png" }], textures: [{ source: 0 }], materials: [{ normalTexture: { index: 0 } }] };
const json = JSON.stringify(picture), text = Buffer.from(json + " ".repeat(3 - (json.length + 3) % 4)), word = (...n) => Buffer.from(Uint32Array.from(n).buffer);
writeFileSync(`${folder}/picture.glb`, Buffer.concat([word(0x46546c67, 2, 28 + text.length + bytes.length, text.length, 0x4e4f534a), text, word(bytes.length, 0x004e4942), bytes]));
writeFileSync(`${folder}/picture.png`, Buffer.concat([Buffer.from("\x89PNG\r\n\x1a\n", "latin1"), Buffer.alloc(9000)]));
asset.meshes[0].primitives[1].attributes.COLOR_0 = 1;
writeFileSync(`${folder}/color.gltf`, JSON.stringify(asset));
JS
said=$("$norma" pack "$scratch/morph.gltf" -o "$scratch/packed.gltf")
check "targets too large for codes stay floats, the others do not" grep -q "normals 108 bytes -> 60 bytes.*(1 of 3 accessors as they were)" <<<"$said"
mkdir "$scratch/elsewhere"
said=$("$norma" pack "$scratch/picture.glb" -o "$scratch/elsewhere/picture.glb")
check "a picture that is copied along is not growth" bash -c 'grep -q "normals 108 bytes -> 60 bytes" <<<"$1" && ! grep -q "; size" <<<"$1" && [ -s "$2" ]' - "$said" "$scratch/elsewhere/picture.png"
check "rows become shorter: no gap is left" node -e '
const j = JSON.parse(require("fs").readFileSync(process.argv[1]));
process.exit(j.bufferViews[0].byteStride === 16 && j.bufferViews[0].byteLength === 48 && j.accessors[0].byteOffset === 0 && j.accessors[1].componentType === 5120 &&
    j.accessors.length === 4 && ["extensionsUsed", "extensionsRequired"].every((k) => j[k].length === 1 && j[k][0] === "KHR_mesh_quantization") ? 0 : 1);' "$scratch/packed.gltf"
printf '%s\t%s\n' "$scratch/morph.gltf" "$scratch/packed.gltf" >"$scratch/pairs"
judge "a morph" 0.5
"$norma" pack "$scratch/morph.gltf" -o "$scratch/finer.gltf" --quiet --max-error 0.01
printf '%s\t%s\n' "$scratch/morph.gltf" "$scratch/finer.gltf" >"$scratch/pairs"
judge "a morph" 0.01
"$norma" pack "$scratch/packed.gltf" -o "$scratch/again.gltf" --quiet
check "packed again: the same file" cmp "$scratch/packed.gltf" "$scratch/again.gltf"
"$norma" pack "$scratch/color.gltf" -o "$scratch/color-packed.gltf" --quiet
check "normals that are colours too keep their encoding" node -e '
process.exit(JSON.parse(require("fs").readFileSync(process.argv[1])).accessors[1].componentType === 5126 ? 0 : 1);' "$scratch/color-packed.gltf"
"$norma" pack "$root/assets/goathead.obj" -o "$scratch/a.obj" 2>"$scratch/err"
check "an OBJ is a usage error" test $? -eq 2
check "and nothing is written" test ! -e "$scratch/a.obj"

if ! [ -d "$data" ]; then
    skip "the data set's files: it is not there"
    finish
    exit
fi
# Floats that EXT_meshopt_compression holds: the box without its normals gets new ones, and these are packed and compressed again. Draco's streams stay.
if [ -f "$data/gltf/misc/box-meshopt.glb" ]; then
    node -e 'const fs = require("fs"), data = fs.readFileSync(process.argv[1]), size = data.readUInt32LE(12);
        const text = data.toString("utf8", 20, 20 + size).replace(/"NORMAL":\d+,|,"NORMAL":\d+/, "").padEnd(size);
        fs.writeFileSync(process.argv[2], Buffer.concat([data.subarray(0, 20), Buffer.from(text), data.subarray(20 + size)]));' "$data/gltf/misc/box-meshopt.glb" "$scratch/bare.glb"
    "$norma" compute "$scratch/bare.glb" -o "$scratch/lit.glb" --crease 60 --quiet
    said=$("$norma" pack "$scratch/lit.glb" -o "$scratch/small.glb" --quiet --json)
    check "normals within EXT_meshopt_compression are packed" grep -q '"normals": {"accessors": 1, "packed": 1' <<<"$said"
    check "and are the same for a reader of it" test "$("$norma" compare "$scratch/lit.glb" "$scratch/small.glb" --max 0.4 >/dev/null; echo $?)" = 0
    check "and for the validator" node "$validator/compare.mjs" "$scratch/lit.glb" "$scratch/small.glb"
    said=$("$norma" pack "$data/gltf/misc/box-draco.glb" -o "$scratch/draco.glb" 2>&1)
    check "primitives of Draco are left as they are, which a note reports" grep -q "1 primitive is compressed with KHR_draco_mesh_compression" <<<"$said"
    check "the file is the same" cmp "$data/gltf/misc/box-draco.glb" "$scratch/draco.glb"
fi
# Differences in doubles that no float holds stay what they are.
node - "$scratch" <<'JS'
const { writeFileSync } = require("fs"), folder = process.argv[2];
const bytes = Buffer.concat([Float32Array.of(0, 0, 0, 1, 0, 0, 0, 1, 0), Float32Array.of(0, 0, 1, 0, 0, 1, 0, 0, 1), Float64Array.of(1e300, 0, 0, 1e300, 0, 0, 1e300, 0, 0)].map((a) => Buffer.from(a.buffer)));
const vec3 = (bufferView, componentType) => ({ bufferView, componentType, count: 3, type: "VEC3" });
writeFileSync(`${folder}/doubles.gltf`, JSON.stringify({
    asset: { version: "2.0" }, extensionsUsed: ["KHR_accessor_float64"], buffers: [{ byteLength: bytes.length, uri: `data:application/octet-stream;base64,${bytes.toString("base64")}` }],
    bufferViews: [[0, 36], [36, 36], [72, 72]].map(([byteOffset, byteLength]) => ({ buffer: 0, byteOffset, byteLength })),
    accessors: [{ ...vec3(0, 5126), min: [0, 0, 0], max: [1, 1, 0] }, vec3(1, 5126), vec3(2, 5130)],
    meshes: [{ primitives: [{ attributes: { POSITION: 0, NORMAL: 1 }, targets: [{ NORMAL: 2 }] }] }], nodes: [{ mesh: 0 }], scenes: [{ nodes: [0] }],
}));
JS
check "differences in doubles beyond floats are left as they are" "$norma" pack "$scratch/doubles.gltf" -o "$scratch/doubles-packed.gltf"
for bound in 0.5 0.01; do
    number=0 wrong="" larger=""
    : >"$scratch/pairs"
    while IFS=$'\t' read -r file expect; do
        number=$((number + 1))
        mkdir -p "$scratch/all/$bound-$number"
        out=$scratch/all/$bound-$number/$(basename "$file")
        if said=$("$norma" pack "$data/$file" -o "$out" --max-error "$bound" --json 2>"$scratch/message"); then
            cmp -s "$data/$file" "$out" && continue
            printf '%s\t%s\n' "$data/$file" "$out" >>"$scratch/pairs"
            node -e 'const j = JSON.parse(process.argv[1]);
                process.exit([j.normals, j.tangents].every((p) => p.bytes.after <= p.bytes.before && p.error_deg <= j.max_error_deg) ? 0 : 1);' "$said" || larger+="$file: $said"$'\n'
        elif [ "$expect" = ok ] || [ "$expect" = lint ]; then
            wrong+=$(cat "$scratch/message")$'\n'
        fi
    done < <(cut -f1,6 "$data/INDEX.tsv" | grep -iE '\.(gltf|glb)	')
    if [ -z "$wrong" ]; then pass "$bound degrees: $(wc -l <"$scratch/pairs") of $number files changed"; else fail "$bound degrees: refused" "$wrong"; fi
    if [ -z "$larger" ]; then pass "$bound degrees: none has more bytes or says more degrees"; else fail "$bound degrees: more bytes or degrees" "$larger"; fi
    judge "the data set" "$bound"
done
finish
