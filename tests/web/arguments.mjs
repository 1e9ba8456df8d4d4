/* node arguments.mjs PACKAGE: calls with arguments of all kinds, right and wrong, give a result or a NormaError; nothing else is thrown, and the module goes on working. */
import { pathToFileURL } from "node:url";
import { check, finish } from "./tap.mjs";
import { cube, randomNumbers } from "./shapes.mjs";

const { load, NormaError } = await import(pathToFileURL(`${process.argv[2]}/node.js`));
const norma = await load(), random = randomNumbers(23), { positions, indices } = cube(), expected = norma.vertexNormals(positions, indices).join();
const pick = (list) => list[Math.floor(random() * list.length)];

function array() {
  const Kind = pick([Float32Array, Float32Array, Float64Array, Int8Array, Uint8Array, Uint8ClampedArray, Int16Array, Uint16Array, Uint32Array, Int32Array, BigInt64Array]), made = new Kind(Math.floor(random() * 40));
  for (let i = 0; i < made.length; i++) made[i] = Kind === BigInt64Array ? 1n : random() < 0.1 ? NaN : Math.floor(random() * 9);
  return random() < 0.2 ? made.subarray(1) : made;
}
const gone = () => { const made = new Float32Array(9); structuredClone(made, { transfer: [made.buffer] }); return made; };
const strided = () => ({ array: pick([array, array, gone, () => positions])(), stride: pick([3, 3, 4, 8, 0, -1, 1.5, NaN, 1e9, 2 ** 32, undefined]), ...(random() < 0.5 && { offset: pick([0, 1, 5, -1, 1e9, "2"]) }), ...(random() < 0.4 && { count: pick([0, 1, 2, 3, 1e9, NaN]) }) });
const anything = () => pick([array, array, strided, strided, gone, () => null, () => undefined, () => ({}), () => [], () => [1, 2, 3], () => "abc", () => 7, () => NaN, () => true, () => Symbol.iterator, () => () => 1, () => new DataView(new ArrayBuffer(9)), () => new ArrayBuffer(12),
  () => new SharedArrayBuffer(12), () => new Date(), () => Object.create(null), () => Array(16).fill(1), () => Array(9).fill(2), () => new Float32Array(new SharedArrayBuffer(36))])();
const value = () => pick([anything, () => "angle", () => "none", () => 60, () => new Float32Array(200), () => true, () => "visible", () => 0.5, () => "nearest", () => "steady", () => "corner"])();
function options() {
  const made = {};
  for (const name of ["weight", "weld", "crease", "out", "report", "per", "mode", "winding", "fallback", "nonManifold", "moved", "encoding", "bogus"]) if (random() < 0.06) made[name] = value();
  return random() < 0.9 ? made : anything();
}
const vectors = () => pick([() => positions, () => positions.slice(), () => Float64Array.from(positions), anything])(), corners = () => pick([() => indices, () => Uint16Array.from(indices), () => null, anything])();

let fine = 0, refused = 0;
const wrong = new Map();
for (let i = 0; i < 40000; i++) {
  const call = pick(["faceNormals", "vertexNormals", "cornerNormals", "split", "tangents", "plan", "normalMatrix", "normalMatrices", "matrixInfo", "transformNormals", "encodeNormals", "decodeNormals", "encodingErrorDeg"]);
  try {
    const result = norma[call](...(call === "tangents" ? [vectors(), vectors(), pick([() => new Float32Array(16), anything])(), corners(), options()] : /codeN/.test(call) ? [pick([vectors, () => Uint32Array.of(1, 2, 3)])(), options()] : /atri|transform|coding/.test(call) ? [anything(), pick([vectors, options])(), options()] : [vectors(), corners(), options()]));
    if (call === "plan") try { result.update(vectors(), options()); } finally { result.free(); }
    fine++;
  } catch (error) {
    if (error instanceof NormaError && /^[\w.]+: /.test(error.message)) refused++;
    else wrong.set(`${call}: ${error.constructor.name}: ${error.message}`, error.stack);
  }
}
check(`${fine} calls give a result, ${refused} a NormaError that begins with what is wrong`, wrong.size === 0 && fine > 3000 && refused > 3000, [...wrong.values()].slice(0, 4).join("\n"));
check("and the module works as before", norma.vertexNormals(positions, indices).join() === expected);
finish();
