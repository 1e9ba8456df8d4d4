// mikktspace.mjs PROGRAM MODULES [FILE...]: the library's tangents against those of three.js's addon,
// bit for bit: on made meshes, of the kinds on which generators differ, and on those of files. Then
// against the WebAssembly of the npm package mikktspace, on fans alone: on other made meshes it stops
// with an access out of bounds.
import { pathToFileURL } from "node:url";
import { createRequire } from "node:module";
import { fan, madeMesh, mirroredSheet, shuffledSwirl, swirl } from "./meshes.mjs";
import { meshesOf, Native } from "./native.mjs";
import { check, finish, skip } from "../web/tap.mjs";

const [program, modules, ...files] = process.argv.slice(2);
const { generateTangents } = await import(pathToFileURL(`${modules}/three/examples/jsm/libs/mikktspace.module.js`));
const wasm = createRequire(import.meta.url)(`${modules}/mikktspace`);
const made = Number(process.env.NORMA_MADE_MESHES ?? 20000);
const bits = (floats) => new Uint32Array(floats.buffer, floats.byteOffset, floats.length);
const REASON_NONE = 0, REASON_NON_FINITE = 2;

// Where the library gives a reason, the reference must have nothing of use: its fallback, a vector
// that is not unit, or something that is not a number.
const isOfUse = (t) => Math.abs(Math.hypot(t[0], t[1], t[2]) - 1) < 1e-3 && !(t[0] === 1 && t[1] === 0 && t[2] === 0 && t[3] === -1);

// A face without texture area goes on with the tangents of others, or has the reference's fallback,
// (1, 0, 0, -1), which is to have a reason. Some mirrored faces' tangents have these very bits: then
// one that has an area shares its vertex with the corner, and has the same tangent there.
const isFallback = (t) => t[0] === 1 && t[1] === 0 && t[2] === 0 && t[3] === -1;
const hasArea = ({ texcoords: t }, face) => {
  const [x1, y1, x2, y2, x3, y3] = t.subarray(6 * face, 6 * face + 6), d = (a, b) => Math.fround(a - b);
  return d(Math.fround(d(x2, x1) * d(y3, y1)), Math.fround(d(y2, y1) * d(x3, x1))) !== 0;
};
const isOneVertex = ({ positions: p, normals: n, texcoords: t }, a, b) =>
  [0, 1, 2].every((k) => p[3 * a + k] === p[3 * b + k] && n[3 * a + k] === n[3 * b + k]) && t[2 * a] === t[2 * b] && t[2 * a + 1] === t[2 * b + 1];
const isTaken = (m, expected, corner) => {
  for (let c = 0; 4 * c < expected.length; c++) if (isFallback(expected.subarray(4 * c, 4 * c + 4)) && hasArea(m, Math.floor(c / 3)) && isOneVertex(m, corner, c)) return true;
  return false;
};

export class Tally {
  constructor() { Object.assign(this, { meshes: 0, corners: 0, differing: 0, differingMeshes: 0, reasons: 0, unreasonable: 0, silent: 0, first: "" }); }

  add(name, expected, { tangents, reasons }, m) {
    const a = bits(expected), b = bits(tangents);
    let differs = 0;
    for (let c = 0; c < reasons.length; c++) {
      const same = a[4 * c] === b[4 * c] && a[4 * c + 1] === b[4 * c + 1] && a[4 * c + 2] === b[4 * c + 2] && a[4 * c + 3] === b[4 * c + 3];
      if (reasons[c] !== REASON_NONE) {
        this.reasons++;
        if (reasons[c] !== REASON_NON_FINITE && isOfUse(expected.subarray(4 * c, 4 * c + 4))) this.unreasonable++;
      } else if (m && isFallback(expected.subarray(4 * c, 4 * c + 4)) && !hasArea(m, Math.floor(c / 3)) && !isTaken(m, expected, c)) {
        this.silent++;
      } else if (!same) {
        differs++;
        this.first ||= `${name}, corner ${c}: ${expected.subarray(4 * c, 4 * c + 4)} and ${tangents.subarray(4 * c, 4 * c + 4)}`;
      }
    }
    this.meshes++;
    this.corners += reasons.length;
    this.differing += differs;
    this.differingMeshes += differs > 0;
  }

  toString() { return `${this.meshes} meshes, ${this.corners} corners, ${this.reasons} of them without a tangent`; }
  details() { return `${this.differing} corners of ${this.differingMeshes} meshes differ, ${this.unreasonable} have a reason but a tangent, ${this.silent} the fallback without a reason; ${this.first}`; }
}

const fresh = (m) => [m.positions.slice(), m.normals.slice(), m.texcoords.slice()];
const exact = (t) => t.meshes > 0 && t.differing === 0 && t.unreasonable === 0 && t.silent === 0;

function meshOf(seed) {
  const kind = seed % 500;
  if (kind === 0) return fan(50 + (seed % 700));
  if (kind === 125) return shuffledSwirl(60 + (seed % 1300), 1 + (seed % 3), 0, seed);
  if (kind === 250) return swirl(3 + (seed % 900));
  if (kind === 375) return shuffledSwirl(60 + (seed % 500), 1, 1 + (seed % 4), seed);
  return seed % 4 === 1 ? mirroredSheet(seed) : madeMesh(seed);
}

async function madeMeshes() {
  const one = new Native(program, "mikk", 1), two = new Native(program, "mikk", 2);
  const addon = new Tally(), package_ = new Tally(), threads = new Tally();
  for (let seed = 1; seed <= made; seed++) {
    const m = meshOf(seed);
    const ours = await one.tangents(m.positions, m.normals, m.texcoords);
    addon.add(`seed ${seed}`, generateTangents(...fresh(m)), ours, m);
    if (seed % 10 === 0) threads.add(`seed ${seed}`, (await two.tangents(m.positions, m.normals, m.texcoords)).tangents, ours);
  }
  for (let count = 50; count < 500; count += 50) {
    const m = fan(count);
    package_.add(`fan of ${count}`, wasm.generateTangents(...fresh(m)), await one.tangents(m.positions, m.normals, m.texcoords));
  }
  one.close();
  two.close();
  check(`made meshes: every bit of three.js's addon (${addon})`, exact(addon), addon.details());
  check(`made meshes: the same bits with two threads (${threads})`, threads.differing === 0, threads.details());
  check(`fans: every bit of the npm package mikktspace (${package_})`, exact(package_), package_.details());
}

async function fileMeshes() {
  const addon = new Tally(), all = files.length;
  let withMeshes = 0;
  for (const path of files) {
    const before = addon.meshes;
    for await (const m of meshesOf(program, "mikk", path)) addon.add(path, generateTangents(...fresh(m)), m, m);
    withMeshes += addon.meshes > before;
  }
  check(`${withMeshes} of ${all} files have normals and texture coordinates: every bit of three.js's addon (${addon})`, exact(addon), addon.details());
}

await madeMeshes();
if (files.length) await fileMeshes();
else skip("meshes of files: no data");
finish();
