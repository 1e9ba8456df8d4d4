/* node skin.mjs PACKAGE: skins of norma-mesh/skin against matrices blended here in doubles, of normals by solving with the transpose; arguments that are wrong. */
import { pathToFileURL } from "node:url";
import { check, finish } from "./tap.mjs";
import { randomNumbers } from "./shapes.mjs";

const { loadSkin, NormaError } = await import(pathToFileURL(`${process.argv[2]}/skin.js`));
const skins = await loadSkin(), random = randomNumbers(39), joint_count = 5, count = 500, signed = () => 2 * random() - 1;
const matrices = Float32Array.from({ length: 16 * joint_count }, (_, i) => (i % 4 === 3 ? Number(i % 16 === 15) : signed() + (i % 5 === 0 ? 2 : 0)));
for (let k = 0; k < 3; k++) matrices[16 + k] *= -1; // the second joint mirrors
const joints = Uint16Array.from({ length: 4 * count }, () => Math.floor(random() * joint_count)), weights = Float32Array.from({ length: 4 * count }, () => random());
for (let v = 0; v < 50; v++) { joints[4 * v] = 1; weights.set([1, 0, 0, 0], 4 * v); }
const skin = { matrices, joints, weights };
const positions = Float32Array.from({ length: 3 * count }, signed), normals = Float32Array.from({ length: 3 * count }, signed);
const tangents = Float32Array.from({ length: 4 * count }, (_, i) => (i % 4 === 3 ? (random() < 0.5 ? -1 : 1) : signed()));

const blend = (v) => Array.from({ length: 16 }, (_, i) => [0, 1, 2, 3].reduce((sum, k) => sum + weights[4 * v + k] * matrices[16 * joints[4 * v + k] + i], 0));
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2], unit = (a) => a.map((x) => x / Math.hypot(...a));
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const columns = (m) => [0, 4, 8].map((c) => m.slice(c, c + 3)), det = (m) => { const [a, b, c] = columns(m); return dot(a, cross(b, c)); };
const through = (m, p) => [0, 1, 2].map((k) => m[k] * p[0] + m[4 + k] * p[1] + m[8 + k] * p[2]);
/* x with transpose(m) x = n, by Cramer's rule. */
function solve(m, n) {
  const [a, b, c] = columns(m), rows = [0, 1, 2].map((k) => [a[k], b[k], c[k]]), d = det(m);
  return [0, 1, 2].map((k) => { const swapped = rows.map((row, i) => (i === k ? n : row)); return dot(swapped[0], cross(swapped[1], swapped[2])) / d; });
}
const far = (found, at, expected) => Math.hypot(...expected.map((x, k) => x - found[at + k]));

const moved = skins.positions(skin, positions), turned = skins.normals(skin, normals), along = skins.tangents(skin, tangents, turned);
let worst = [0, 0, 0], signs = 0, mirrored = 0;
for (let v = 0; v < count; v++) {
  const m = blend(v), n = unit(solve(m, [...normals.subarray(3 * v, 3 * v + 3)])), t = through(m, tangents.subarray(4 * v)), flat = t.map((x, k) => x - n[k] * dot(n, t));
  mirrored += det(m) < 0;
  worst = [far(moved, 3 * v, through(m, positions.subarray(3 * v)).map((x, k) => x + m[12 + k])), far(turned, 3 * v, n), far(along, 4 * v, unit(flat))].map((x, i) => Math.max(x, worst[i]));
  signs += along[4 * v + 3] === tangents[4 * v + 3] * Math.sign(det(m));
}
check(`positions of ${count} vertices`, worst[0] < 2e-6, worst[0]);
check("normals: the inverse transpose of the blend", worst[1] < 1e-6, worst[1]);
check("tangents: through the blend, perpendicular to the normals", worst[2] < 1e-4, worst[2]);
check(`signs of tangents, ${mirrored} of them mirrored`, signs === count && mirrored >= 50 && mirrored < count, `${signs} ${mirrored}`);
const out = new Float32Array(3 * count);
check("out is written and returned", skins.normals(skin, normals, { out }) === out && out.every((x, i) => Object.is(x, turned[i])));
check("the same with joints of 8 and 32 bits", [Uint8Array, Uint32Array].every((Kind) => skins.normals({ ...skin, joints: Kind.from(joints) }, normals).every((x, i) => Object.is(x, turned[i]))));
const rigid = { matrices: Float32Array.of(0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1), joints: Uint8Array.of(0), weights: Float32Array.of(1), influences: 1, blend: "dual-quaternion" };
check("dual quaternions turn as the matrix", far(skins.normals(rigid, Float32Array.of(1, 0, 0)), 0, [0, 1, 0]) < 1e-6);

const told = (call) => { try { call(); return "nothing was thrown"; } catch (error) { return error instanceof NormaError ? error.message : `no NormaError: ${error}`; } };
const wrong = { ...skin, joints: Uint16Array.from(joints, (j, i) => (i === 6 ? 7 : j)) };
for (const [name, call, beginning] of [
  ["a joint that does not exist", () => skins.normals(wrong, normals), "joints[6]: expected"],
  ["weights too few", () => skins.normals({ ...skin, weights: new Float32Array(3) }, normals), "weights: 3 numbers"],
  ["normals too few", () => skins.normals(skin, new Float32Array(3)), "normals: 3 numbers"],
  ["normals of another type", () => skins.normals(skin, [1, 2, 3]), "normals: an Array"],
  ["a blend that does not exist", () => skins.normals({ ...skin, blend: "cubic" }, normals), 'blend: "cubic"'],
  ["no skin", () => skins.positions(undefined, positions), "skin:"],
  ["tangents without normals", () => skins.tangents(skin, tangents), "skinnedNormals:"],
]) { const message = told(call); check(`${name}: ${message}`, message.startsWith(beginning), message); }
finish();
