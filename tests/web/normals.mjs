/* node normals.mjs PACKAGE: norma-mesh/normals beside norma-mesh: the same tangents, the same errors, a heap of its own that is given back, and its size. What it computes otherwise is held against the native library in bits.mjs. */
import { readFileSync } from "node:fs";
import { pathToFileURL } from "node:url";
import { gzipSync } from "node:zlib";
import { attempt, check, finish } from "./tap.mjs";
import { randomNumbers, shapes, waves } from "./shapes.mjs";

const [folder] = process.argv.slice(2), entry = (name) => import(pathToFileURL(`${folder}/${name}.js`));
const { load, NormaError } = await entry("normals"), small = await load(), whole = await (await entry("node")).load();
const bytesOf = (array) => Buffer.from(array.buffer, array.byteOffset, array.byteLength);

check("loaded once", small === (await load()) && small.version === whole.version);

/* Texture coordinates at random: mirrored, degenerate and crossed triangles. */
const random = randomNumbers(41);
for (const { name, positions, indices } of shapes())
  await attempt(`${name}: tangents, the same`, () => {
    const count = positions.length / 3, texcoords = Float32Array.from({ length: 2 * count }, () => Math.floor(9 * random()) / 8), floats = Float32Array.from(positions);
    const [one, other] = [small, whole].map((norma) => norma.tangents(floats, norma.vertexNormals(floats, indices), texcoords, indices, { report: true }));
    if (Buffer.compare(bytesOf(one.tangents), bytesOf(other.tangents)) || JSON.stringify(one.report) !== JSON.stringify(other.report)) throw new Error("others");
  });

const wrong = [
  ["an index that does not exist", (norma) => norma.vertexNormals(new Float32Array(9), Uint32Array.of(0, 1, 3))],
  ["an option that does not exist", (norma) => norma.cornerNormals(new Float32Array(9), null, { creese: 3 })],
  ["a crease that is no angle", (norma) => norma.split(new Float32Array(9), null, { crease: 1e9 })],
  ["a matrix that is not finite", (norma) => norma.normalMatrix(new Float32Array(16).fill(NaN))],
];
const told = (norma, call) => { try { call(norma); return "nothing"; } catch (error) { return `${error instanceof NormaError} ${error.message}`; } };
for (const [name, call] of wrong) check(`${name}: the same error`, told(small, call) === told(whole, call) && told(small, call).startsWith("true "), told(small, call));

/* What is left out is refused, not computed otherwise. */
const triangle = new Float32Array(9), leftOut = [
  ["weight: \"visible\"", () => small.vertexNormals(triangle, { weight: "visible" })],
  ["weight: \"visible\"", () => small.cornerNormals(triangle, null, { weight: "visible" })],
  ["weld: 0.5", () => small.split(triangle, null, { weld: 0.5 })],
  ["weld: 0", () => small.faceNormals(triangle, { weld: 0 })],
  ["mode: \"steady\"", () => small.tangents(triangle, triangle, new Float32Array(6), { mode: "steady" })],
];
for (const [name, call] of leftOut) check(`${name} is left out, and says where it is`, told(small, call) === `true ${name} is left out of norma-mesh/normals; norma-mesh has it`, told(small, call));

/* The allocator: sizes up and down, a thousand times; blocks that were not given back, or not joined, would fill the 4 GiB. */
await attempt("a thousand calls on meshes of many sizes, 150 on one of 100,000 triangles: the memory is given back", () => {
  for (let i = 0; i < 1000; i++) {
    const { positions, indices } = waves(3 + ((i * 7919) % 60), 2 + ((i * 104729) % 50)), options = { crease: 30, fallback: "nearest", weld: i % 3 ? "exact" : "none" };
    const one = small.cornerNormals(positions, indices, options);
    if (i % 50 === 0 && Buffer.compare(bytesOf(one), bytesOf(whole.cornerNormals(positions, indices, options)))) throw new Error(`call ${i} differs`);
  }
  const { positions, indices } = waves(250, 200), normals = small.vertexNormals(positions, indices);
  for (let i = 0; i < 150; i++) small.split(positions, indices, { crease: 20 });
  if (Buffer.compare(bytesOf(normals), bytesOf(whole.vertexNormals(positions, indices)))) throw new Error("other normals");
});

/* As measured and a little more; asked for are 30 kB. */
const size = (name) => gzipSync(readFileSync(`${folder}/${name}.js`), { level: 9 }).length;
check("the module is at most 47.5 kB (gzip), as text", size("normals-text") <= 47500, `${size("normals-text")} bytes`);
finish();
