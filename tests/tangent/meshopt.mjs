// meshopt.mjs PROGRAM MODULES [FILE...]: the library's tangents in meshoptimizer's way against those of the npm package meshoptimizer with its default weights, bit for bit: on made meshes,
// of the kinds on which generators differ, and on those of files. Where the library gives a reason, the package must have nothing of use; where a number is not finite, nothing is compared.
import { pathToFileURL } from "node:url";
import { fan, madeMesh, mirroredSheet, shuffledSwirl, swirl } from "./meshes.mjs";
import { meshesOf, Native } from "./native.mjs";
import { check, finish, skip } from "../web/tap.mjs";

const [program, modules, ...files] = process.argv.slice(2);
const { MeshoptTangents } = await import(pathToFileURL(`${modules}/meshoptimizer/meshopt_tangents.js`));
await MeshoptTangents.ready;
const made = Number(process.env.NORMA_MADE_MESHES ?? 10000);

const isFinite_ = (m) => [m.positions, m.normals, m.texcoords].every((values) => values.every((x) => Number.isFinite(x)));
const isUnit = (t) => Math.abs(Math.hypot(t[0], t[1], t[2]) - 1) < 4e-4 && !(t[0] === 1 && t[1] === 0 && t[2] === 0);

const tally = () => ({ meshes: 0, corners: 0, reasons: 0, mirrored: 0, differing: 0, unreasonable: 0, first: "" });

function compare(t, name, m, { tangents, reasons }) {
  if (!isFinite_(m)) return;
  const expected = MeshoptTangents.generateTangents(null, m.positions, 3, m.normals, 3, m.texcoords, 2, []);
  t.meshes++;
  for (let c = 0; c < reasons.length; c++) {
    const theirs = expected.subarray(4 * c, 4 * c + 4), ours = tangents.subarray(4 * c, 4 * c + 4);
    const differs = reasons[c] === 0 ? [0, 1, 2, 3].some((k) => theirs[k] !== ours[k]) : theirs[3] !== ours[3];
    t.corners++;
    t.mirrored += ours[3] < 0;
    t.reasons += reasons[c] !== 0;
    t.unreasonable += reasons[c] !== 0 && isUnit(theirs);
    t.differing += differs;
    if (differs) t.first ||= `${name}, corner ${c} (reason ${reasons[c]}): ${theirs} and ${ours}`;
  }
}
const said = (t) => `${t.meshes} meshes, ${t.corners} corners, ${t.mirrored} mirrored, ${t.reasons} without a tangent`;
const judge = (what, t) =>
  check(`${what}: every bit of meshoptimizer's (${said(t)})`, t.meshes > 0 && !t.differing && !t.unreasonable, `${t.differing} corners differ, ${t.unreasonable} have a reason but a tangent; ${t.first}`);

function meshOf(seed) {
  const kind = seed % 500;
  if (kind === 0) return fan(50 + (seed % 700));
  if (kind === 125) return shuffledSwirl(60 + (seed % 1300), 1 + (seed % 3), 0, seed);
  if (kind === 250) return swirl(3 + (seed % 900));
  return seed % 4 === 1 ? mirroredSheet(seed) : madeMesh(seed);
}

const native = new Native(program, "meshopt"), all = tally();
for (let seed = 1; seed <= made; seed++) {
  const m = meshOf(seed);
  compare(all, `seed ${seed}`, m, await native.tangents(m.positions, m.normals, m.texcoords));
}
native.close();
judge("made meshes", all);

if (files.length) {
  const ofFiles = tally();
  for (const path of files) for await (const m of meshesOf(program, "meshopt", path)) compare(ofFiles, path, m, m);
  judge("meshes of files", ofFiles);
} else skip("meshes of files: no data");
finish();
