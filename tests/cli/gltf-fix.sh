#!/bin/bash
# Vertices of glTF welded and split by norma check --fix-unsafe. Two judges that are not ours, as in check-gltf-compute.sh: the Khronos validator says nothing new, and
# tests/cli/validator/corners.mjs finds every corner of every triangle with all its attributes but normals and tangents as they were.
# shellcheck source=tests/support/gltf_judges.sh
source "$(dirname "$0")/../support/gltf_judges.sh"

# Two tents that meet at their tips, each corner's UV its own: one position to be split.
node -e '
    const z = .5, p = [[0, 0, 0], [1, 0, z], [0, 1, z], [-1, 0, z], [0, -1, z], [1, 0, -z], [0, 1, -z], [-1, 0, -z], [0, -1, -z]];
    const corners = [0, 1, 2, 0, 2, 3, 0, 3, 4, 0, 4, 1, 0, 6, 5, 0, 7, 6, 0, 8, 7, 0, 5, 8];
    const normals = p.map((q, i) => { const n = i ? [-z * q[0], -z * q[1], i < 5 ? 1 : -1] : [0, 0, 1], l = Math.hypot(...n); return n.map(x => x / l); });
    const bytes = Buffer.concat([Buffer.from(new Float32Array(p.flat()).buffer), Buffer.from(new Float32Array(normals.flat()).buffer), Buffer.from(new Float32Array(p.flatMap((_, i) => [i / 9, 0])).buffer), Buffer.from(Uint8Array.from(corners))]);
    const accessor = (bufferView, componentType, count, type, more) => ({ bufferView, componentType, count, type, ...more });
    console.log(JSON.stringify({ asset: { version: "2.0" }, scene: 0, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0 }],
        meshes: [{ primitives: [{ attributes: { POSITION: 0, NORMAL: 1, TEXCOORD_0: 2 }, indices: 3 }] }],
        accessors: [accessor(0, 5126, 9, "VEC3", { min: [-1, -1, -z], max: [1, 1, z] }), accessor(1, 5126, 9, "VEC3"), accessor(2, 5126, 9, "VEC2"), accessor(3, 5121, 24, "SCALAR")],
        bufferViews: [[0, 108], [108, 108], [216, 72], [288, 24]].map(([byteOffset, byteLength]) => ({ buffer: 0, byteOffset, byteLength })),
        buffers: [{ byteLength: bytes.length, uri: "data:application/octet-stream;base64," + bytes.toString("base64") }] }))' >"$scratch/tents.gltf"
"$norma" check "$scratch/tents.gltf" --fix-unsafe --select N403 --no-config -o "$scratch/tents.split.gltf" --json >"$scratch/report" 2>&1
if [ -s "$scratch/tents.split.gltf" ] && ! cmp -s "$scratch/tents.gltf" "$scratch/tents.split.gltf" && ! grep -q '"rule": *"N403"' "$scratch/report"; then pass "the tents are split"; else fail "the tents are split" "$(head -5 "$scratch/report")"; fi
printf '%s\t%s\n' "$scratch/tents.gltf" "$scratch/tents.split.gltf" >"$scratch/pairs"

number=0 wrong="" welded=0
while [ -d "$data" ] && read -r file; do
    out=$scratch/$((++number))/$(basename "$file")
    mkdir -p "$(dirname "$out")"
    "$norma" check "$data/$file" --fix-unsafe --select N403,N502 --no-config -o "$out" --quiet >"$scratch/message" 2>&1
    case $? in
    0 | 1) ;;
    *) wrong+="$file: $(head -1 "$scratch/message")"$'\n' ;;
    esac
    if [ ! -e "$out" ] || cmp -s "$data/$file" "$out"; then continue; fi
    welded=$((welded + 1))
    printf '%s\t%s\n' "$data/$file" "$out" >>"$scratch/pairs"
done < <(cut -f1,6 "$data/INDEX.tsv" 2>/dev/null | grep -E '\.(gltf|glb)	ok$' | cut -f1)
if [ -d "$data" ]; then
    if [ -z "$wrong" ] && [ "$welded" -ge 3 ]; then pass "$number files, $welded with vertices welded"; else fail "$number files, $welded with vertices welded" "$wrong"; fi
else
    skip "the data set is not there"
fi

judge_validity "welded and split" "$scratch/pairs"
# It also asks for normals, which these need not have.
output=$(node "$validator/corners.mjs" --list "$scratch/pairs" 2>&1)
rest=$(grep -vE ' has no normals$|: fine$|^[0-9]+ pairs' <<<"$output")
if grep -qE '^[0-9]+ pairs' <<<"$output" && [ -z "$rest" ]; then pass "every corner is what it was: $(tail -n 1 <<<"$output")"; else fail "every corner is what it was" "$rest"; fi
finish
