/* node calls.mjs PACKAGE: options, outputs and errors of the package, and closed forms. */
import { readFileSync } from "node:fs";
import { createServer } from "node:http";
import { resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { attempt, check, finish } from "./tap.mjs";
import { cube, sphere } from "./shapes.mjs";

const folder = resolve(process.argv[2]);
const { load, NormaError } = await import(pathToFileURL(`${folder}/index.js`));
const norma = await load();

/* ---- ways to load */
const bytes = readFileSync(`${folder}/norma.wasm`);
check("the module imports nothing", WebAssembly.Module.imports(new WebAssembly.Module(bytes)).length === 0);
const { positions, indices } = cube();
const ways = {
  "its bytes": bytes, "an ArrayBuffer": bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length), "a compiled module": new WebAssembly.Module(bytes),
  "a path": `${folder}/norma.wasm`, "a file: URL": pathToFileURL(`${folder}/norma.wasm`), "a file: URL as text": String(pathToFileURL(`${folder}/norma.wasm`)),
};
for (const [name, source] of Object.entries(ways))
  await attempt(`load takes ${name}`, async () => { if ((await load(source)).vertexNormals(positions, indices).length !== 24) throw new Error("no normals"); });
const server = createServer((request, response) => (request.url === "/norma.wasm" ? response.end(bytes) : ((response.statusCode = 404), response.end()))).listen(0, "127.0.0.1");
await new Promise((ready) => server.once("listening", ready));
const address = `http://127.0.0.1:${server.address().port}`;
await attempt("load takes an address", async () => { if (!(await load(`${address}/norma.wasm`)).version) throw new Error("no version"); });
await attempt("an address where nothing is is an Error", async () => {
  const outcome = await load(`${address}/nothing`).then(() => "loaded", (error) => error.message);
  if (!/404/.test(outcome)) throw new Error(outcome);
});
server.close();

/* ---- closed forms */
const near = (a, b, tolerance) => Math.abs(a - b) <= tolerance;
const diagonal = (x, y, z) => [x, 0, 0, 0, 0, y, 0, 0, 0, 0, z, 0, 0, 0, 0, 1];
for (const s of [1.5, 2, 4, 10]) {
  const expected = (Math.asin((s * s - 1) / (s * s + 1)) * 180) / Math.PI;
  check(`plain M errs by ${expected.toFixed(2)} degrees at a scale of ${s}`, near(norma.matrixInfo(diagonal(s, 1, 1)).worstErrorDeg, expected, 1e-9));
}
check("the corners of a cube, smooth, lie along its diagonals", norma.vertexNormals(positions, indices).every((x) => near(Math.abs(x), 1 / Math.sqrt(3), 1e-7)));
check("those of each face, at a crease of 60 degrees, along its axis", norma.cornerNormals(positions, indices).every((x) => x === 0 || Math.abs(x) === 1));
const cut = norma.split(positions, indices);
check("split gives a cube 24 vertices of its 8", cut.normals.length === 72 && cut.sourceVertices.length === 24 && cut.indices.length === 36 && new Set(cut.sourceVertices).size === 8);
check("split at 180 degrees adds none", norma.split(positions, indices, { crease: 180 }).sourceVertices.length === 8);
const round = sphere(64, 32);
check("a sphere weighted after Max is exact", norma.vertexNormals(round.positions, round.indices, { weight: "max" }).every((x, i) => near(x, round.positions[i], 2e-6)));
const inverse = norma.normalMatrix(diagonal(2, 0.5, 1));
check("the normal matrix of diag(2, 0.5, 1) is along diag(1/2, 2, 1)", near(inverse[4] / inverse[0], 4, 1e-6) && near(inverse[8] / inverse[0], 2, 1e-6) && inverse[1] === 0);
const leaning = norma.transformNormals(inverse, Float32Array.of(Math.SQRT1_2, Math.SQRT1_2, 0));
check("and takes (1, 1, 0) to (0.243, 0.970, 0)", near(leaning[0], 1 / Math.sqrt(17), 1e-6) && near(leaning[1], 4 / Math.sqrt(17), 1e-6) && leaning[2] === 0);
const mirror = diagonal(-1, 1, 1);
check("a mirror: kept and reversed are opposite", norma.normalMatrix(mirror, { winding: "kept" }).every((x, i) => x === -norma.normalMatrix(mirror)[i] || x === 0));
check("matrixInfo knows kinds", ["identity", "translation", "uniform-scale", "non-uniform-scale", "shear", "singular"].every((kind, i) => {
  const model = [diagonal(1, 1, 1), diagonal(1, 1, 1), diagonal(3, 3, 3), diagonal(1, 2, 3), diagonal(1, 1, 1), diagonal(1, 0, 0)][i];
  if (i === 1) model[12] = 5;
  if (i === 4) model[4] = 0.5;
  return norma.matrixInfo(model).kind === kind;
}));
check("a singular matrix errs by a right angle and has no bounded anisotropy", norma.matrixInfo(diagonal(1, 1, 0)).worstErrorDeg === 90 && norma.matrixInfo(diagonal(1, 1, 0)).anisotropy === Infinity);

/* ---- outputs */
const out = new Float32Array(30).fill(7);
check("out is what is returned", norma.vertexNormals(positions, indices, { out }) === out);
check("nothing is written beyond what is needed", out.subarray(24).every((x) => x === 7) && out.subarray(0, 24).every((x) => x !== 7));
const window_ = out.subarray(3, 27);
check("out may be a part of an array", norma.vertexNormals(positions, indices, { out: window_ }) === window_ && out[2] !== 7 && out[27] === 7);
check("positions may be a part of an array", norma.vertexNormals(Float32Array.of(9, ...positions).subarray(1), indices).every((x) => near(Math.abs(x), 1 / Math.sqrt(3), 1e-7)));
check("16-bit and 32-bit indices give the same", norma.cornerNormals(positions, Uint16Array.from(indices)).every((x, i) => x === norma.cornerNormals(positions, Uint32Array.from(indices))[i]));
check("indices may be left out, options following", norma.faceNormals(positions.slice(0, 9), { out: new Float32Array(3) }).length === 3);
check("null indices are none", norma.faceNormals(positions.slice(0, 9), null).length === 3);
check("an array may be its own output", (() => { const normals = Float32Array.of(0, 0, 3); return norma.transformNormals(norma.normalMatrix(diagonal(1, 1, 1)), normals, { out: normals }) === normals && normals[2] === 1; })());
const { vertexNormals } = norma;
check("calls need no this", vertexNormals(positions, indices).length === 24);
check("an empty mesh has no normals", norma.vertexNormals(new Float32Array(0), new Uint32Array(0)).length === 0 && norma.split(new Float32Array(0)).indices.length === 0);
const kept = new Float32Array(18).fill(5);
await attempt("of many models those that are finite are done", () => {
  try { norma.normalMatrices([...diagonal(1, 2, 3), ...diagonal(NaN, 1, 1)], { out: kept }); } catch { if (kept[0] === 6 && kept[9] === 0) return; }
  throw new Error([...kept].join(" "));
});

/* ---- plans */
const plan = norma.plan(positions, indices), freed = norma.plan(positions, indices);
freed.free();
freed.free();
check("a plan counts what it gives", plan.count === 8 && norma.plan(positions, indices, { per: "corner" }).count === 36 && plan.bytes > 100);
check("at the positions it was made from it gives the normals of the mesh", plan.update(positions).every((x, i) => x === norma.vertexNormals(positions, indices)[i]));
const room = plan.normals;
check("its room in the heap can be its output", plan.update(positions, { out: room }) === room && room.every((x, i) => x === plan.update(positions)[i]));
const touched = new Float32Array(24).fill(9);
plan.update(positions, { moved: [], out: touched });
check("where nothing moved nothing is written", touched.every((x) => x === 9));

/* ---- errors: what, by which result, and with which words behind the library's sentence */
const ARGUMENT = "An argument is missing, not a number, out of its range, or contradicts another.";
const CAPACITY = "An output buffer is too small for what would be written.";
const INDEX = "A corner names a position that does not exist.";
const faults = [
  ["an index out of range", INDEX, "index", () => norma.vertexNormals(positions, Uint32Array.of(0, 1, 8))],
  ["a crease that is no number", ARGUMENT, "argument", () => norma.cornerNormals(positions, indices, { crease: NaN }), /crease: NaN/],
  ["a crease that is text", ARGUMENT, "argument", () => norma.split(positions, indices, { crease: "60" }), /crease: "60"/],
  ["an unknown weight", ARGUMENT, "argument", () => norma.vertexNormals(positions, indices, { weight: "heavy" }), /"heavy" is none of "angle", "area"/],
  ["an unknown weld", ARGUMENT, "argument", () => norma.vertexNormals(positions, indices, { weld: "loose" }), /"loose"/],
  ["a weld distance below zero", ARGUMENT, "argument", () => norma.vertexNormals(positions, indices, { weld: -1 }), /-1 is no distance/],
  ["a weld distance that is no number", ARGUMENT, "argument", () => norma.vertexNormals(positions, indices, { weld: NaN })],
  ["an unknown fallback", ARGUMENT, "argument", () => norma.vertexNormals(positions, indices, { fallback: "up" }), /"up"/],
  ["an unknown nonManifold", ARGUMENT, "argument", () => norma.vertexNormals(positions, indices, { nonManifold: true }), /nonManifold: true/],
  ["no positions", ARGUMENT, "argument", () => norma.vertexNormals(), /positions: undefined/],
  ["positions that are a plain array", ARGUMENT, "argument", () => norma.vertexNormals([0, 0, 0]), /positions: an Array is none of Float32Array/],
  ["positions that are text", ARGUMENT, "argument", () => norma.faceNormals("abc")],
  ["positions of a wrong length", ARGUMENT, "argument", () => norma.vertexNormals(new Float32Array(10), indices), /10 numbers/],
  ["positions of 32-bit integers", ARGUMENT, "argument", () => norma.vertexNormals(new Int32Array(9)), /Int32Array/],
  ["indices of a wrong length", ARGUMENT, "argument", () => norma.faceNormals(positions, Uint32Array.of(0, 1, 2, 3)), /4 corners/],
  ["positions alone that are no triangles", ARGUMENT, "argument", () => norma.faceNormals(new Float32Array(12)), /4 corners/],
  ["indices with a sign", ARGUMENT, "argument", () => norma.faceNormals(positions, Int32Array.of(0, 1, 2)), /Int32Array/],
  ["options that are a number", ARGUMENT, "argument", () => norma.faceNormals(positions, indices, 60), /options: 60/],
  ["an output too small", CAPACITY, "capacity", () => norma.vertexNormals(positions, indices, { out: new Float32Array(23) }), /23 floats where 24/],
  ["an output of doubles", ARGUMENT, "argument", () => norma.vertexNormals(positions, indices, { out: new Float64Array(24) }), /Float64Array/],
  ["a model of 15 numbers", ARGUMENT, "argument", () => norma.normalMatrix(new Float32Array(15)), /15 numbers, not 16/],
  ["a model that is not finite", ARGUMENT, "argument", () => norma.normalMatrix(diagonal(Infinity, 1, 1))],
  ["a model of text", ARGUMENT, "argument", () => norma.matrixInfo("0123456789abcdef")],
  ["a model with text in it", ARGUMENT, "argument", () => norma.matrixInfo(Array(16).fill("1"))],
  ["models that are not whole", ARGUMENT, "argument", () => norma.normalMatrices(new Float32Array(17)), /multiple of 16/],
  ["an unknown winding", ARGUMENT, "argument", () => norma.normalMatrix(mirror, { winding: "left" }), /"left"/],
  ["an unknown element of a plan", ARGUMENT, "argument", () => norma.plan(positions, indices, { per: "face" }), /"face"/],
  ["a plan over an index out of range", INDEX, "index", () => norma.plan(positions, Uint32Array.of(0, 1, 8))],
  ["a plan's update with other positions", ARGUMENT, "argument", () => plan.update(positions.slice(3)), /7 vectors where the plan has 8/],
  ["a moved vertex that is none", INDEX, "index", () => plan.update(positions, { moved: [8], out: new Float32Array(24) })],
  ["the same as a Uint32Array", INDEX, "index", () => plan.update(positions, { moved: Uint32Array.of(8), out: new Float32Array(24) })],
  ["moved without the normals of before", ARGUMENT, "argument", () => plan.update(positions, { moved: [1] }), /needs out/],
  ["a plan that has been freed", ARGUMENT, "argument", () => freed.update(positions), /freed/],
  ["its room", ARGUMENT, "argument", () => freed.normals, /freed/],
  ["a normal matrix of 16 numbers", ARGUMENT, "argument", () => norma.transformNormals(mirror, new Float32Array(3)), /16 numbers, not 9/],
];
for (const [name, text, result, call, detail] of faults) {
  let error = null;
  try { call(); } catch (thrown) { error = thrown; }
  const right = error instanceof NormaError && error instanceof Error && error.message.startsWith(text) && error.result === result && (!detail || detail.test(error.message));
  check(`${name}: an Error with the library's text`, right, error ? `${error.result}: ${error.message}` : "none");
}
const untouched = new Float32Array(24).fill(3);
try { norma.vertexNormals(positions, Uint32Array.of(0, 1, 99), { out: untouched }); } catch { /* looked at above */ }
check("after an error nothing has been written", untouched.every((x) => x === 3));
await attempt("ten thousand errors leave the heap as it was", () => {
  const before = norma.vertexNormals(positions, indices);
  for (let i = 0; i < 10000; i++) try { norma.vertexNormals(round.positions, Uint32Array.of(0, 1, 99999)); } catch { /* looked at above */ }
  if (!norma.vertexNormals(positions, indices).every((x, i) => x === before[i])) throw new Error("other normals");
});
finish();
