// panes.mjs OUT.gltf: two triangles in a plane that share an edge, the second twice as wide. In the first, u and v are x and y; in the second u = 2 x and v = y - x.
import { writeFileSync } from "node:fs";

const parts = [Float32Array.of(0, 0, 0, 0, 1, 0, 1, 0, 0, -2, 0, 0), Float32Array.of(0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1), Float32Array.of(0, 0, 0, 1, 1, 0, -4, 2), Uint16Array.of(0, 2, 1, 0, 1, 3)];
const bytes = Buffer.concat(parts.map((part) => Buffer.from(part.buffer)));
let at = 0;
const bufferViews = parts.map((part) => ({ buffer: 0, byteOffset: (at += part.byteLength) - part.byteLength, byteLength: part.byteLength }));
writeFileSync(process.argv[2], JSON.stringify({
  asset: { version: "2.0" },
  scene: 0,
  scenes: [{ nodes: [0] }],
  nodes: [{ mesh: 0 }],
  meshes: [{ primitives: [{ attributes: { POSITION: 0, NORMAL: 1, TEXCOORD_0: 2 }, indices: 3 }] }],
  accessors: [
    { bufferView: 0, componentType: 5126, type: "VEC3", count: 4, min: [-2, 0, 0], max: [1, 1, 0] },
    { bufferView: 1, componentType: 5126, type: "VEC3", count: 4 },
    { bufferView: 2, componentType: 5126, type: "VEC2", count: 4 },
    { bufferView: 3, componentType: 5123, type: "SCALAR", count: 6 },
  ],
  bufferViews,
  buffers: [{ byteLength: bytes.length, uri: `data:application/octet-stream;base64,${bytes.toString("base64")}` }],
}));
