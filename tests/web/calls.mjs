/* node calls.mjs PACKAGE: options, outputs and errors of the package, and closed forms. */
import { readFileSync } from "node:fs";
import { createServer } from "node:http";
import { resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { attempt, check, finish } from "./tap.mjs";
import { cube, sphere } from "./shapes.mjs";

const folder = resolve(process.argv[2]);
const { load, NormaError } = await import(pathToFileURL(`${folder}/node.js`));
const norma = await load();

/* ---- ways to load */
const bytes = readFileSync(`${folder}/norma.wasm`);
/* Built without them, check.wasm imports none of the decoders either. */
const importsOf = (name) => WebAssembly.Module.imports(new WebAssembly.Module(readFileSync(`${folder}/${name}.wasm`))).map((part) => `${part.module}.${part.name}`);
check("norma.wasm imports nothing", importsOf("norma").length === 0, importsOf("norma").join());
check("check.wasm imports Draco's decoder, meshoptimizer and deflate alone", importsOf("check").every((name) => /^norma\.(draco_decode|meshopt_[a-zA-Z]+|(in|de)flate_bytes)$/.test(name)), importsOf("check").join());
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
for (const [where, why] of [[`${address}/nothing`, /404/], [`${folder}/nothing.wasm`, /ENOENT/]])
  await attempt(`where nothing is, a NormaError says so and what bundles need: ${why}`, async () => {
    const error = await load(where).then(() => Error("loaded"), (error) => error);
    if (error.name !== "NormaError" || !why.test(error.message) || !error.message.startsWith(`load: ${where} `) || !error.message.includes("norma-mesh/inline")) throw error;
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
for (const [encoding, degrees] of [["oct8", 0.638], ["oct12", 0.0396], ["oct16", 0.00248], ["10-10-10-2", 0.0793]]) {
  const back = norma.decodeNormals(norma.encodeNormals(round.positions, { encoding }), { encoding }), bound = norma.encodingErrorDeg(encoding);
  let worst = 0;
  for (let i = 0; i < back.length; i += 3) {
    const [x, y, z] = round.positions.subarray(i, i + 3), [a, b, c] = back.subarray(i, i + 3);
    worst = Math.max(worst, (Math.asin(Math.hypot(y * c - z * b, z * a - x * c, x * b - y * a) / Math.hypot(x, y, z)) * 180) / Math.PI);
  }
  check(`${encoding}: codes of a sphere's normals are within ${degrees} degrees`, near(bound, degrees, degrees / 200) && worst <= bound && worst > bound / 2, `${worst} of ${bound}`);
}
check("codes of axes, and of what has no direction", norma.encodeNormals(Float32Array.of(0, 0, 1, 1, 0, 0, -1, 0, 0, 0, 0, 0), { encoding: "oct8" }).join() === "0,127,128,0");
const unknown = norma.encodeNormals(Float32Array.of(0, 0, 0, NaN, 0, 1, 0, 1, 0), { report: true });
check("and how many those are", unknown.codes.length === 3 && unknown.report.cancelled === 1 && unknown.report.nonFinite === 1);
check("codes are written where they are wanted", (() => { const codes = new Uint32Array(2); return norma.encodeNormals(Int8Array.of(0, 5, 0), { encoding: "10-10-10-2", out: codes }) === codes && codes[0] === 511 << 10 && codes[1] === 0; })());
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

/* ---- counts */
const flat = norma.vertexNormals(Float32Array.of(0, 0, 0, 1, 0, 0, 2, 0, 0, 5, 5, NaN), Uint8Array.of(0, 1, 2), { report: true });
check("report: true adds the counts of what has no normal", flat.normals.length === 12 && flat.report.degenerateFaces === 1 && flat.report.unreferenced === 3 && flat.report.nonFinite === 1 && flat.report.cancelled === 0);
check("those of edges for the calls that look at them", norma.cornerNormals(positions, Uint8Array.of(0, 1, 2, 1, 0, 3, 0, 1, 4), { report: true }).report.nonManifoldEdges === 1 && norma.split(positions, Uint8Array.of(0, 1, 2, 0, 1, 3), { report: true }).report.windingConflicts === 1);
check("a plan's update too", plan.update(positions, { report: true }).report.cancelled === 0);

/* ---- views with a stride: what lies between is not looked at */
const interleaved = new Float32Array(5 + 8 * 8).fill(NaN);
for (let i = 0; i < 8; i++) interleaved.set(positions.subarray(3 * i, 3 * i + 3), 5 + 8 * i);
const view = { array: interleaved, stride: 8, offset: 5 }, same = (a, b) => a.length === b.length && a.every((x, i) => Object.is(x, b[i]));
check("a view with a stride gives the same as tight positions", same(norma.vertexNormals(view, indices), norma.vertexNormals(positions, indices)) && same(norma.cornerNormals({ ...view, count: 8 }, indices), norma.cornerNormals(positions, indices)));
check("so do plans", same(norma.plan(view, indices).update(view), plan.update(positions)));
check("without indices, options may follow", same(norma.faceNormals({ array: interleaved, stride: 8, offset: 5, count: 6 }, { weld: "none" }), norma.faceNormals(positions.subarray(0, 18))));
check("normals too may be a view", norma.transformNormals(norma.normalMatrix(diagonal(1, 1, 1)), { array: Float32Array.of(7, 0, 0, 2, 7, 7, 0, 3, 0, 7), stride: 5, offset: 1 }).join() === "0,0,1,0,1,0");

/* ---- tangents: along u, by closed forms */
const quad = { positions: Float32Array.of(0, 0, 0, 2, 0, 0, 2, 3, 0, 0, 3, 0), normals: Float32Array.from({ length: 12 }, (_, i) => (i % 3 === 2 ? 1 : 0)), indices: Uint16Array.of(0, 1, 2, 0, 2, 3) };
const straight = Float32Array.of(0, 0, 1, 0, 1, 1, 0, 1), mirrored = Float32Array.of(0, 0, -1, 0, -1, 1, 0, 1), turned = Uint8Array.of(0, 0, 0, 255, 255, 255, 255, 0);
const tangentsOf = (texcoords, options) => norma.tangents(quad.positions, quad.normals, texcoords, quad.indices, options);
const everyFour = (array, four) => array.length === 24 && array.every((x, i) => near(x, four[i % 4], 1e-7));
for (const mode of ["mikk", "steady"]) {
  check(`${mode}: u along x`, everyFour(tangentsOf(straight, { mode }), [1, 0, 0, 1]));
  check(`${mode}: u along -x, mirrored`, everyFour(tangentsOf(mirrored, { mode }), [-1, 0, 0, -1]));
  check(`${mode}: bytes as texture coordinates, u along y`, everyFour(tangentsOf(turned, { mode }), [0, 1, 0, -1]));
}
const perCorner = { normals: Float32Array.from({ length: 18 }, (_, i) => (i % 3 === 2 ? 1 : 0)), texcoords: Float32Array.from(quad.indices).reduce((all, vertex, i) => (all.set(straight.subarray(2 * vertex, 2 * vertex + 2), 2 * i), all), new Float32Array(12)) };
check("normals and texture coordinates may be those of corners", everyFour(norma.tangents(quad.positions, perCorner.normals, perCorner.texcoords, quad.indices), [1, 0, 0, 1]));
const none = norma.tangents(quad.positions, quad.normals, new Float32Array(8), quad.indices, { report: true });
check("corners without texture area are counted, and get unit vectors perpendicular to the normal", none.report.degenerate === 6 && none.tangents.every((x, i) => i % 4 !== 2 || x === 0) && near(Math.hypot(...none.tangents.subarray(0, 3)), 1, 1e-6));

/* ---- a second load, and files */
check("load without a source gives the same module again", (await load()) === norma && (await load(bytes)) !== norma);
await attempt("check reads a file and reports what the library finds", async () => {
  const text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 -1\nf 1//1 2//1 3//1\n";
  const report = await norma.check(new TextEncoder().encode(text), { name: "back.obj" }), rules = report.files[0].findings.map(({ rule }) => rule);
  if (report.schema !== "norma-check/1" || !rules.some((rule) => rule.startsWith("N2"))) throw new Error(JSON.stringify(report));
  const broken = await norma.check(new TextEncoder().encode("v 0 0 0\nf 1 2 3\n"), { name: "broken.obj" });
  if (broken.files[0].status !== "unreadable" || broken.files[0].findings[0].rule !== "N001" || broken.summary.errors !== 1) throw new Error(JSON.stringify(broken));
});

/* ---- errors: what is wrong comes first */
const text = (message) => new RegExp(`^${message.replace(/[.*+?^${}()|[\]\\]/g, "\\$&")}`);
const gone = new Float32Array(24);
structuredClone(gone, { transfer: [gone.buffer] });
const faults = [
  ["positions that a worker took", "argument", () => norma.vertexNormals(gone, indices), "positions: its memory is gone"],
  ["an output that a worker took", "argument", () => norma.vertexNormals(positions, indices, { out: gone }), "out: its memory is gone"],
  ["bytes that a worker took", "argument", () => norma.check(gone, { name: "a.obj" }), "bytes: its memory is gone"],
  ["a buffer that a worker took", "argument", () => norma.check(gone.buffer, { name: "a.obj" }), "bytes: its memory is gone"],
  ["an index out of range", "index", () => norma.vertexNormals(positions, Uint32Array.of(0, 1, 8)), "indices: number 2 is 8, but there are only 8 positions"],
  ["a crease that is NaN", "argument", () => norma.cornerNormals(positions, indices, { crease: NaN }), "crease: NaN"],
  ["a crease that is text", "argument", () => norma.split(positions, indices, { crease: "60" }), 'crease: "60"'],
  ["a crease above 180", "argument", () => norma.split(positions, indices, { crease: 181 }), "crease: 181 is out of range"],
  ["a crease below 0", "argument", () => norma.cornerNormals(positions, indices, { crease: -1 }), "crease: -1 is out of range"],
  ["a crease that is null", "argument", () => norma.cornerNormals(positions, indices, { crease: null }), "crease: null is not an angle"],
  ["a plan's crease that is null", "argument", () => norma.plan(positions, indices, { crease: null }), "crease: null is not an angle"],
  ["an option that does not exist", "argument", () => norma.cornerNormals(positions, indices, { creases: 60 }), "options: creases is not an option of this call; it takes"],
  ["an option of another call", "argument", () => norma.vertexNormals(positions, indices, { crease: 60 }), "options: crease"],
  ["an unknown weight", "argument", () => norma.vertexNormals(positions, indices, { weight: "heavy" }), 'weight: "heavy" is not one of "angle", "area"'],
  ["an unknown weld", "argument", () => norma.vertexNormals(positions, indices, { weld: "loose" }), 'weld: "loose"'],
  ["a weld distance below zero", "argument", () => norma.vertexNormals(positions, indices, { weld: -1 }), "weld: -1 is not a distance"],
  ["a weld distance that is NaN", "argument", () => norma.vertexNormals(positions, indices, { weld: NaN }), "weld: NaN"],
  ["an unknown fallback", "argument", () => norma.vertexNormals(positions, indices, { fallback: "up" }), 'fallback: "up"'],
  ["an unknown nonManifold", "argument", () => norma.vertexNormals(positions, indices, { nonManifold: true }), "nonManifold: true"],
  ["a report that is no truth value", "argument", () => norma.vertexNormals(positions, indices, { report: 1 }), "report: 1"],
  ["no positions", "argument", () => norma.vertexNormals(), "positions: undefined"],
  ["positions that are a plain array", "argument", () => norma.vertexNormals([0, 0, 0]), "positions: an Array is not one of Float32Array"],
  ["positions that are text", "argument", () => norma.faceNormals("abc"), 'positions: "abc"'],
  ["positions of a wrong length", "argument", () => norma.vertexNormals(new Float32Array(10), indices), "positions: 10 numbers"],
  ["positions of 32-bit integers", "argument", () => norma.vertexNormals(new Int32Array(9)), "positions: Int32Array"],
  ["an attribute of three.js", "argument", () => norma.vertexNormals({ array: positions, itemSize: 3, count: 8 }, indices), "positions: itemSize is not expected in a view"],
  ["a view without a stride", "argument", () => norma.vertexNormals({ array: positions }, indices), "positions.stride: undefined"],
  ["a stride below three", "argument", () => norma.vertexNormals({ array: positions, stride: 2 }, indices), "positions.stride: 2"],
  ["a stride that is no whole number", "argument", () => norma.vertexNormals({ array: positions, stride: 3.5 }, indices), "positions.stride: 3.5"],
  ["an offset below zero", "argument", () => norma.vertexNormals({ array: positions, stride: 3, offset: -3 }, indices), "positions.offset: -3"],
  ["more vectors than fit", "argument", () => norma.vertexNormals({ array: positions, stride: 3, count: 9 }, indices), "positions: 9 vectors 3 numbers apart from 0 on do not fit into 24 numbers"],
  ["a view of an array of another kind", "argument", () => norma.vertexNormals({ array: [1, 2, 3], stride: 3 }, indices), "positions.array: an Array"],
  ["indices of a wrong length", "argument", () => norma.faceNormals(positions, Uint32Array.of(0, 1, 2, 3)), "indices: 4 are not a multiple of 3"],
  ["positions alone that are no triangles", "argument", () => norma.faceNormals(new Float32Array(12)), "positions: 4 without indices"],
  ["indices with a sign", "argument", () => norma.faceNormals(positions, Int32Array.of(0, 1, 2)), "indices: Int32Array"],
  ["options that are a number", "argument", () => norma.faceNormals(positions, indices, 60), "options: 60"],
  ["an output too small", "capacity", () => norma.vertexNormals(positions, indices, { out: new Float32Array(23) }), "out: 23 floats, but 24"],
  ["an output of doubles", "argument", () => norma.vertexNormals(positions, indices, { out: new Float64Array(24) }), "out: Float64Array"],
  ["a model of 15 numbers", "argument", () => norma.normalMatrix(new Float32Array(15)), "model: 15 numbers are not 16"],
  ["a model that is not finite", "argument", () => norma.normalMatrix(diagonal(1, Infinity, 1)), "model: element 5 is Infinity"],
  ["one of many models", "argument", () => norma.normalMatrices([...diagonal(1, 1, 1), ...diagonal(1, 1, NaN)]), "models: element 26 is NaN"],
  ["a model of text", "argument", () => norma.matrixInfo("0123456789abcdef"), "model:"],
  ["a model with text in it", "argument", () => norma.matrixInfo(Array(16).fill("1")), 'model: element 0 is "1"'],
  ["models that are not whole", "argument", () => norma.normalMatrices(new Float32Array(17)), "models: 17 numbers are not a multiple of 16"],
  ["an unknown winding", "argument", () => norma.normalMatrix(mirror, { winding: "left" }), 'winding: "left"'],
  ["an unknown element of a plan", "argument", () => norma.plan(positions, indices, { per: "face" }), 'per: "face"'],
  ["a plan over an index out of range", "index", () => norma.plan(positions, Uint32Array.of(0, 1, 8)), "indices: number 2 is 8"],
  ["a plan's update with other positions", "argument", () => plan.update(positions.slice(3)), "positions: 7 vectors, but the plan has 8"],
  ["a moved vertex that does not exist", "index", () => plan.update(positions, { moved: [1, 8], out: new Float32Array(24) }), "moved: element 1 is 8"],
  ["the same as a Uint32Array", "index", () => plan.update(positions, { moved: Uint32Array.of(8), out: new Float32Array(24) }), "moved: element 0 is 8"],
  ["moved without the normals of before", "argument", () => plan.update(positions, { moved: [1] }), "out: is needed with moved"],
  ["an unknown option of an update", "argument", () => plan.update(positions, { changed: [1] }), "options: changed"],
  ["a plan that has been freed", "argument", () => freed.update(positions), "plan: it has been freed"],
  ["its room", "argument", () => freed.normals, "plan: it has been freed"],
  ["a normal matrix of 16 numbers", "argument", () => norma.transformNormals(mirror, new Float32Array(3)), "normalMatrix: 16 numbers are not 9"],
  ["an unknown encoding", "argument", () => norma.encodeNormals(positions, { encoding: "oct9" }), 'encoding: "oct9"'],
  ["codes that are floats", "argument", () => norma.decodeNormals(positions), "codes: Float32Array"],
  ["room for codes of another kind", "argument", () => norma.encodeNormals(positions, { out: new Float32Array(99) }), "out: Float32Array is not a Uint32Array"],
  ["room for too few codes", "capacity", () => norma.encodeNormals(positions, { out: new Uint32Array(1) }), "out: 1 numbers, but 8 are written"],
  ["an unknown mode of tangents", "argument", () => tangentsOf(straight, { mode: "fast" }), 'mode: "fast"'],
  ["texture coordinates for no element", "argument", () => tangentsOf(straight.subarray(2)), "texcoords: 3 values, but the mesh has 4 vertices and 6 corners"],
  ["texture coordinates of an odd length", "argument", () => tangentsOf(straight.subarray(1)), "texcoords: 7 numbers"],
  ["normals for no element", "argument", () => norma.tangents(quad.positions, quad.normals.subarray(3), straight, quad.indices), "normals: 3 values"],
  ["check without a name", "argument", () => norma.check(bytes), "name: bytes that begin with"],
  ["check with a name of no format", "argument", () => norma.check(bytes, { name: "chair.fbx" }), 'name: "chair.fbx" does not end in one of'],
  ["check of text", "argument", () => norma.check("v 0 0 0", { name: "a.obj" }), 'bytes: "v 0 0 0"'],
  ["an unknown profile", "argument", () => norma.check(bytes, { name: "a.obj", profile: "film" }), 'profile: "film"'],
  ["an unknown option of check", "argument", () => norma.check(bytes, { name: "a.obj", strict: true }), "options: strict"],
  ["a module that is none", "argument", () => load(new Uint8Array(8)), "load: these bytes are not a WebAssembly module"],
  ["an address that is none", "argument", () => load(7), "load: 7"],
  ["an unknown option of load", "argument", () => load(bytes, { checks: bytes }), "options: checks"],
];
for (const [name, result, call, message] of faults) {
  let error = null;
  try { await call(); } catch (thrown) { error = thrown; }
  const right = error instanceof NormaError && error instanceof Error && text(message).test(error.message) && error.result === result;
  check(`${name}: an Error that begins with what is wrong`, right, error ? `${error.result}: ${error.message}` : "none");
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
