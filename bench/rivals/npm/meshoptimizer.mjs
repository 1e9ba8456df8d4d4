/* The npm package beside meshoptimizer's generateNormals (WebAssembly too), one thread, in one run: one normal per corner, creases at 60 degrees, equal positions shared.
 *   node bench/rivals/npm/meshoptimizer.mjs [PACKAGE] [NODE_MODULES]        build/web/npm and build/npm-bench/node_modules
 * The least of several calls, in milliseconds; and how far the corners' normals are apart, since the two weigh differently. */
import { readFileSync } from "node:fs";
import { dirname, join, resolve } from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";
import { waves } from "../../../tests/web/shapes.mjs";

const root = join(dirname(fileURLToPath(import.meta.url)), "../../.."), words = process.argv.slice(2);
const folder = resolve(words[0] ?? join(root, "build/web/npm")), modules = resolve(words[1] ?? join(root, "build/npm-bench/node_modules"));
const { load } = await import(pathToFileURL(join(folder, "node.js")));
const { MeshoptTangents } = await import(pathToFileURL(join(modules, "meshoptimizer/meshopt_tangents.js")));
const norma = await load();
await MeshoptTangents.ready;

function least(budget, call) {
  let best = Infinity, spent = 0;
  for (let i = 0; i < 3 || spent < budget; i++) {
    const begin = performance.now();
    call();
    const took = performance.now() - begin;
    best = Math.min(best, took);
    spent += took;
  }
  return best;
}

/* Vertices in random order, the faces with them and in random order too. */
function shuffled({ positions, indices }) {
  let state = 1;
  const order = (count) => {
    const numbers = Uint32Array.from({ length: count }, (_, i) => i);
    for (let i = count - 1; i > 0; i--) {
      state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
      const j = Math.floor((state / 4294967296) * (i + 1));
      [numbers[i], numbers[j]] = [numbers[j], numbers[i]];
    }
    return numbers;
  };
  const vertices = order(positions.length / 3), faces = order(indices.length / 3);
  const moved = new Float32Array(positions.length), corners = new Uint32Array(indices.length);
  vertices.forEach((to, from) => moved.set(positions.subarray(3 * from, 3 * from + 3), 3 * to));
  faces.forEach((to, from) => { for (let k = 0; k < 3; k++) corners[3 * to + k] = vertices[indices[3 * from + k]]; });
  return { positions: moved, indices: corners };
}

function largestAngle(a, b) {
  let largest = 0;
  for (let i = 0; i < a.length; i += 3) {
    const x = a[i + 1] * b[i + 2] - a[i + 2] * b[i + 1], y = a[i + 2] * b[i] - a[i] * b[i + 2], z = a[i] * b[i + 1] - a[i + 1] * b[i];
    largest = Math.max(largest, Math.atan2(Math.hypot(x, y, z), a[i] * b[i] + a[i + 1] * b[i + 1] + a[i + 2] * b[i + 2]));
  }
  return (largest * 180) / Math.PI;
}

const version = JSON.parse(readFileSync(join(modules, "meshoptimizer/package.json"), "utf8")).version;
console.log(`node ${process.version}, meshoptimizer ${version}, milliseconds, crease 60`);
console.log("triangles      order    generateNormals   cornerNormals   ratio   apart, degrees");
for (const [columns, rows] of [[100, 50], [400, 250], [1000, 500]])
  for (const order of ["rows", "shuffled"]) {
    const plain = waves(columns, rows), { positions, indices } = order === "rows" ? plain : shuffled(plain);
    const out = new Float32Array(3 * indices.length);
    let theirs;
    const rival = least(500, () => { theirs = MeshoptTangents.generateNormals(indices, positions, 3, Math.PI / 3); });
    const ours = least(500, () => norma.cornerNormals(positions, indices, { crease: 60, out }));
    console.log(`${String(indices.length / 3).padStart(9)}   ${order.padEnd(8)} ${rival.toFixed(2).padStart(15)} ${ours.toFixed(2).padStart(15)} ${(rival / ours).toFixed(1).padStart(7)} ${largestAngle(theirs, out).toFixed(3).padStart(16)}`);
  }
