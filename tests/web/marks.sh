#!/bin/bash
# Every error and warning that is pressed in the page is seen: at least 0.2 % of the picture is marked (marks.mjs).
#   tests/web/marks.sh          the small meshes of the repository, and faults planted into some
#   tests/web/marks.sh --all    every file of data/large (make marks; some minutes)
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
cd "$root" || exit 1
tool=${NORMA_BIN:-$tree/bin/norma}
data=${NORMA_DATA:-$root/../shared/data}
if [ ! -f "$tree/web/norma.html" ]; then skip "the page (this tree is built without -DNORMA_WEB=ON)"; finish; exit; fi
if ! command -v chromium >/dev/null && ! command -v google-chrome >/dev/null && [ -z "${NORMA_CHROME:-}" ]; then
    skip "the page in a browser (chromium is not installed: scripts/install-deps.sh)"
    finish
    exit
fi

# A roof one of whose faces is turned round, a sliver within a grid, a normal turned round, and one of no length.
printf 'v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 1 1 1\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 1 4 5\nf 4 3 2 1\n' >"$scratch/turned.obj"
awk 'BEGIN { for (y = 0; y < 9; y++) for (x = 0; x < 9; x++) print "v", x, y, 0.1 * sin(x + 2 * y); print "v 3 3.0000001 0.0412119"; for (y = 0; y < 8; y++) for (x = 1; x < 9; x++) { a = 9 * y + x; print "f", a, a + 1, a + 10, a + 9 } print "f 31 32 82" }' >"$scratch/sliver.obj"
printf 'v 0 0 0\nv 4 0 0\nv 4 4 0\nv 0 4 0\nv 2 2 3\nvn 0 -1 0.7\nvn 1 0 0.7\nvn 0 1 -0.7\nvn 0 0 0\nf 1//1 2//1 5//1\nf 2//2 3//2 5//2\nf 3//3 4//3 5//3\nf 4//4 1//4 5//4\n' >"$scratch/normals.obj"
# The same roof under morph targets, of which one cancels normals, in a skin whose joint is flat; and once more without normals for its target to change.
cat >"$scratch/moved.mjs" <<'END'
import { writeFileSync } from "node:fs";
const points = [0, 0, 0, 4, 0, 0, 4, 4, 0, 0, 4, 0, 2, 2, 3], t = Math.sqrt(1 / 3), normals = [-t, -t, t, t, -t, t, t, t, t, -t, t, t, 0, 0, 1], still = points.map(() => 0), turned = normals.map((x, i) => (i < 6 ? -x : 0));
const lifted = still.map((x, i) => (i === 14 ? 2 : 0)), joints = [0, 0, 0, 0], weights = [1, 0, 0, 0], five = (list) => Array(5).fill(list).flat();
const floats = [points, normals, turned, lifted, five(weights)].map((list) => Buffer.from(Float32Array.from(list).buffer)), rest = [Buffer.from(Uint16Array.of(0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4).buffer), Buffer.from(Uint8Array.from(five(joints)).buffer)];
const parts = [...floats, ...rest], bufferViews = [], accessors = [], kinds = ["VEC3", "VEC3", "VEC3", "VEC3", "VEC4", "SCALAR", "VEC4"], types = [5126, 5126, 5126, 5126, 5126, 5123, 5121];
let at = 0;
parts.forEach((part, i) => { bufferViews.push({ buffer: 0, byteOffset: at, byteLength: part.length }); at += part.length; accessors.push({ bufferView: i, componentType: types[i], count: i === 5 ? 12 : 5, type: kinds[i], ...(kinds[i] === "VEC3" ? { min: [-9, -9, -9], max: [9, 9, 9] } : {}) }); });
writeFileSync(process.argv[2], JSON.stringify({ asset: { version: "2.0" }, scene: 0, scenes: [{ nodes: [0, 1, 2] }], nodes: [{ mesh: 0, skin: 0 }, { scale: [1, 1, 0.2] }, { mesh: 1, translation: [6, 0, 0] }], skins: [{ joints: [1] }],
  meshes: [{ weights: [0, 0.3], primitives: [{ attributes: { POSITION: 0, NORMAL: 1, JOINTS_0: 6, WEIGHTS_0: 4 }, indices: 5, targets: [{ POSITION: 3, NORMAL: 2 }, { POSITION: 3 }] }] },
    { primitives: [{ attributes: { POSITION: 0 }, indices: 5, targets: [{ POSITION: 3, NORMAL: 2 }] }] }],
  accessors, bufferViews, buffers: [{ byteLength: at, uri: `data:application/octet-stream;base64,${Buffer.concat(parts).toString("base64")}` }] }));
END
node "$scratch/moved.mjs" "$scratch/moved.gltf"
files=(assets/box-rotated.obj assets/spider.stl "$scratch/turned.obj" "$scratch/sliver.obj" "$scratch/normals.obj" "$scratch/moved.gltf")
if [ "${1:-}" = --all ]; then
    [ -d "$data/large" ] || { skip "the data set (no $data/large)"; finish; exit; }
    mapfile -t files < <(find "$data/large" -type f \( -name '*.obj' -o -name '*.ply' -o -name '*.stl' -o -name '*.gltf' -o -name '*.glb' \) | sort)
fi
relay marks node tests/web/marks.mjs "$tool" "$scratch/marks" "${files[@]}"
check "findings were pressed" test "$relayed" -gt 3
finish
