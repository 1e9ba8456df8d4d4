// corners.mjs: did a tool that computes normals leave all else alone? Reads both files with code of its own, nothing of Norma's.
//
//   node corners.mjs [--flat | --tangents MODULES | --meshopt MODULES | --packed DEG] [--quiet] INPUT OUTPUT [INPUT OUTPUT ...]
//   node corners.mjs ... --list PAIRS              PAIRS: a file, or - for standard input; a line: INPUT tab OUTPUT
//
// With --packed, no direction of a normal or tangent turned by more than DEG degrees, those of each morph target alone at full weight among them; signs are the same.
//
// Primitive by primitive, corner by corner of what it draws (strips and fans as triangles, points and lines as they are): every attribute but NORMAL and TANGENT, also
// those of morph targets, is the same numbers in the same type. The rest of the JSON (all but accessors, views, buffers and primitives) is the same. Every triangle
// primitive has normals, of unit length. With --tangents, NORMAL is compared as well, and instead every corner's tangent is that of three.js's addon (in MODULES), bit for bit
// but for the sign, which glTF has the other way round, and where the addon has nothing of use; differences of morph targets too, to 1e-5. With --meshopt they are
// those of the npm package meshoptimizer, which is given vertices and indices as the file has them. With --flat each is that of its triangle, found here, to .05 degrees (.5 for bytes). Meshes that this cannot
// read (compressed, buffers without bytes) are passed over, and counted. Exit status 0, 1 (something is wrong), 2 usage.
import { readFileSync } from "node:fs";
import path from "node:path";
import { pathToFileURL } from "node:url";
import { load, readers, widths } from "./asset.mjs";

class Unreadable extends Error {}

function run({ json, buffers }, view, offset, component, width, count) {
  const v = json.bufferViews[view], [size, read] = readers[component], buffer = buffers[v.buffer];
  if (!buffer || v.extensions?.EXT_meshopt_compression) throw new Unreadable();
  const start = (v.byteOffset ?? 0) + (offset ?? 0), stride = v.byteStride ?? size * width, out = [];
  for (let i = 0; i < count; i++) for (let k = 0; k < width; k++) out.push(read(buffer, start + i * stride + k * size));
  return out;
}

// The numbers as they are stored, sparse ones put in.
function numbers(asset, index) {
  if (asset.cache.has(index)) return asset.cache.get(index);
  const a = asset.json.accessors[index], width = widths[a.type];
  if (width > 4) throw new Unreadable();
  const out = a.bufferView === undefined ? new Array(a.count * width).fill(0) : run(asset, a.bufferView, a.byteOffset, a.componentType, width, a.count);
  if (a.sparse) {
    const where = run(asset, a.sparse.indices.bufferView, a.sparse.indices.byteOffset, a.sparse.indices.componentType, 1, a.sparse.count);
    const what = run(asset, a.sparse.values.bufferView, a.sparse.values.byteOffset, a.componentType, width, a.sparse.count);
    where.forEach((to, i) => { for (let k = 0; k < width; k++) out[to * width + k] = what[i * width + k]; });
  }
  const made = { out, width, component: a.componentType, normalized: !!a.normalized, count: a.count };
  asset.cache.set(index, made);
  return made;
}

function corners(asset, p) {
  const list = p.indices === undefined ? [...Array(asset.json.accessors[p.attributes.POSITION].count).keys()] : numbers(asset, p.indices).out;
  const mode = p.mode ?? 4;
  if (mode < 4) return list;
  const out = [];
  if (mode === 4) return list.slice(0, list.length - (list.length % 3));
  for (let i = 0; i + 2 < list.length; i++) {
    const triangle = mode === 5 ? [list[i], list[i + 1 + (i % 2)], list[i + 2 - (i % 2)]] : [list[i + 1], list[i + 2], list[0]];
    if (new Set(triangle).size === 3) out.push(...triangle); // the others draw nothing, and a list need not have them
  }
  return out;
}

const decode = (a, i) => [0, 1, 2].map((k) => (a.component === 5126 ? a.out[3 * i + k] : a.normalized ? Math.max(a.out[3 * i + k] / readers[a.component][2], -1) : a.out[3 * i + k]));
const length = (v) => Math.hypot(...v);

function compareAttributes(before, after, a, b, old, now, where, wrong) {
  for (const name of Object.keys(a)) {
    if (b[name] === undefined) { wrong.push(`${where}/${name} is gone`); continue; }
    if ((name === "NORMAL" && !addon) || name === "TANGENT") continue;
    const x = numbers(before, a[name]), y = numbers(after, b[name]);
    if (x.component !== y.component || x.width !== y.width || x.normalized !== y.normalized) wrong.push(`${where}/${name} has another type`);
    for (let c = 0; c < old.length; c++)
      for (let k = 0; k < x.width; k++)
        if (!Object.is(x.out[old[c] * x.width + k], y.out[now[c] * x.width + k])) { wrong.push(`${where}/${name} of corner ${c} is another`); c = old.length; break; }
  }
}

function checkNormals(after, p, now, flat, where, wrong) {
  if (p.attributes.NORMAL === undefined) { wrong.push(`${where} has no normals`); return; }
  const normals = numbers(after, p.attributes.NORMAL), positions = numbers(after, p.attributes.POSITION);
  const unit = normals.component === 5120 ? 0.00682 : 5e-4, limit = Math.cos((normals.component === 5120 ? 0.5 : 0.05) * Math.PI / 180);
  for (let v = 0; v < normals.count; v++)
    if (!(Math.abs(length(decode(normals, v)) - 1) <= unit)) { wrong.push(`${where}: normal ${v} is not unit`); break; }
  for (let c = 0; flat && c < now.length; c += 3) {
    const [q, r, s] = [0, 1, 2].map((k) => decode(positions, now[c + k]));
    const [d, e] = [r, s].map((v) => v.map((x, k) => x - q[k]));
    const n = [d[1] * e[2] - d[2] * e[1], d[2] * e[0] - d[0] * e[2], d[0] * e[1] - d[1] * e[0]], size = length(n);
    if (!(size > 1e-9 * length(d) * length(e))) continue;
    for (let k = 0; k < 3; k++) {
      const m = decode(normals, now[c + k]);
      if (!((m[0] * n[0] + m[1] * n[1] + m[2] * n[2]) / size / length(m) >= limit)) { wrong.push(`${where}: corner ${c + k} has not its triangle's normal`); return; }
    }
  }
}

// ---- tangents

let addon = null;
const counted = { meshes: 0, corners: 0, useless: 0, differing: 0, targets: 0 };
const value = (a, i) => (a.component === 5126 ? a.out[i] : a.normalized ? Math.fround(Math.max(a.out[i] / readers[a.component][2], -1)) : a.out[i]);
const gather = (a, corners) => Float32Array.from({ length: corners.length * a.width }, (_, i) => value(a, corners[Math.floor(i / a.width)] * a.width + (i % a.width)));

// Of a primitive's corners: texture coordinates as its normal map is looked up.
function lookedUp(asset, p, corners) {
  const material = asset.json.materials?.[p.material], map = material?.normalTexture ?? material?.extensions?.KHR_materials_clearcoat?.clearcoatNormalTexture;
  const place = map?.extensions?.KHR_texture_transform, set = place?.texCoord ?? map?.texCoord ?? 0;
  const index = p.attributes[`TEXCOORD_${set}`];
  if (index === undefined) return null;
  const uv = gather(numbers(asset, index), corners);
  if (!place) return uv;
  const [sx, sy] = place.scale ?? [1, 1], [ox, oy] = place.offset ?? [0, 0];
  const matrix = new addon.Matrix3().makeScale(sx, sy).premultiply(new addon.Matrix3().setUvTransform(ox, oy, 1, 1, place.rotation ?? 0, 0, 0));
  return Float32Array.from(uv, (_, i) => { const v = new addon.Vector2(uv[i - (i % 2)], uv[i - (i % 2) + 1]).applyMatrix3(matrix); return i % 2 ? v.y : v.x; });
}

// The addon's tangents where they are of use, else NaN; glTF's sign.
function reference(positions, normals, uv, indices) {
  const t = addon.meshopt ? addon.meshopt.generateTangents(Uint32Array.from(indices), positions, 3, normals, 3, uv, 2, []) : addon.generateTangents(positions, normals, uv);
  for (let c = 0; c < t.length; c += 4) {
    const useless = !(Math.abs(Math.hypot(t[c], t[c + 1], t[c + 2]) - 1) < 1e-3) || (t[c] === 1 && t[c + 1] === 0 && t[c + 2] === 0 && (addon.meshopt || t[c + 3] === -1));
    t[c + 3] = useless ? NaN : -t[c + 3];
  }
  return t;
}

function displaced(asset, p, target, name, corners, unit) {
  const out = gather(numbers(asset, p.attributes[name]), corners);
  if (target[name] !== undefined) gather(numbers(asset, target[name]), corners).forEach((d, i) => { out[i] = Math.fround(out[i] + d); });
  for (let i = 0; unit && i < out.length; i += 3) { const l = Math.hypot(out[i], out[i + 1], out[i + 2]); for (let k = 0; l > 0 && k < 3; k++) out[i + k] /= l; }
  return out;
}

function checkTangents(before, after, p, q, old, now, where, wrong) {
  const reach = addon.meshopt && p.attributes.POSITION !== undefined ? [...Array(before.json.accessors[p.attributes.POSITION].count).keys()] : old;
  const has = p.attributes.NORMAL !== undefined && old.length > 0, uv = has && lookedUp(before, p, reach);
  if (!uv) { if ((q.attributes.TANGENT === undefined) !== (p.attributes.TANGENT === undefined)) wrong.push(`${where} has tangents without coordinates`); return; }
  if (q.attributes.TANGENT === undefined) { wrong.push(`${where} has no tangents`); return; }
  const made = numbers(after, q.attributes.TANGENT);
  const expected = reference(gather(numbers(before, p.attributes.POSITION), reach), gather(numbers(before, p.attributes.NORMAL), reach), uv.slice(), old);
  const moved = !!before.json.materials?.[p.material]?.normalTexture?.extensions?.KHR_texture_transform;
  const found = gather(made, now), normals = gather(numbers(before, p.attributes.NORMAL), old), near = made.component === 5120 ? 0.02 : made.component === 5126 && !moved ? 0 : 1e-4;
  counted.meshes++;
  for (let c = 0; c < now.length; c++) {
    const t = found.subarray(4 * c, 4 * c + 4), e = expected.subarray(4 * c, 4 * c + 4), n = normals.subarray(3 * c, 3 * c + 3);
    counted.corners++;
    if (Math.abs(t[3]) !== 1 || !(Math.abs(Math.hypot(t[0], t[1], t[2]) - 1) < (near || 5e-4))) { wrong.push(`${where}: tangent of corner ${c} is ${t}`); return; }
    if (Number.isNaN(e[3])) {
      counted.useless++;
      if (Math.abs(t[0] * n[0] + t[1] * n[1] + t[2] * n[2]) > 1e-2) { wrong.push(`${where}: tangent of corner ${c} leans`); return; }
    } else if (e[3] !== t[3] || [0, 1, 2].some((k) => !(Math.abs(e[k] - t[k]) <= near))) { wrong.push(`${where}: tangent of corner ${c} is ${t}, not ${e}`); counted.differing++; return; }
  }
  (p.targets ?? []).forEach((target, i) => {
    if (target.NORMAL === undefined) return;
    const at = `${where}/targets/${i}`, deltas = q.targets[i].TANGENT === undefined ? null : gather(numbers(after, q.targets[i].TANGENT), now);
    if (!deltas) { wrong.push(`${at} has no tangents`); return; }
    const there = reference(displaced(before, p, target, "POSITION", reach, false), displaced(before, p, target, "NORMAL", reach, true), uv.slice(), old);
    counted.targets++;
    let off = 0;
    for (let c = 0; c < now.length; c++)
      if (!Number.isNaN(expected[4 * c + 3]) && !Number.isNaN(there[4 * c + 3]))
        off += [0, 1, 2].some((k) => !(Math.abs(expected[4 * c + k] + deltas[3 * c + k] - there[4 * c + k]) < 1e-5 + near));
    if (off > now.length / 100) wrong.push(`${at}: ${off} of ${now.length} differences of tangents are others`);
  });
}

// ---- packed normals and tangents

let bound = null;
const packed = { vectors: 0, targets: 0, worst: 0 };
const vector = (a, i) => [0, 1, 2].map((k) => { const x = a.out[i * a.width + k]; return a.component === 5126 ? x : Math.max(x / readers[a.component][2], -1); });
const isZero = (v) => v.every((x) => x === 0);

function angle(a, b) {
  if (isZero(a) || isZero(b)) return isZero(a) && isZero(b) ? 0 : Infinity;
  const cross = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  return Math.atan2(Math.hypot(...cross), a[0] * b[0] + a[1] * b[1] + a[2] * b[2]) * 180 / Math.PI;
}

function checkPacked(before, after, p, q, where, wrong) {
  for (const name of ["NORMAL", "TANGENT"]) {
    if (p.attributes[name] === undefined) continue;
    const old = numbers(before, p.attributes[name]), now = numbers(after, q.attributes[name]);
    if (old.count !== now.count || old.width !== now.width) { wrong.push(`${where}/${name} has another size`); continue; }
    [null, ...(p.targets ?? []).keys()].forEach((t) => {
      const has = t === null || p.targets[t][name] !== undefined;
      if (!has) return;
      const [d, e] = t === null ? [null, null] : [numbers(before, p.targets[t][name]), numbers(after, q.targets[t][name])];
      const sum = (a, b, i) => (b ? vector(a, i).map((x, k) => x + vector(b, i)[k]) : vector(a, i));
      packed.targets += t !== null;
      for (let i = 0; i < old.count; i++) {
        const a = sum(old, d, i), b = sum(now, e, i), off = angle(a, b), same = a.every((x, k) => Object.is(x, b[k]));
        packed.vectors++;
        if (!same && !(off <= bound)) { wrong.push(`${where}/${name} ${i} of ${t ?? "the base"} is ${off} degrees off`); break; }
        if (!same) packed.worst = Math.max(packed.worst, off);
        if (!d && old.width === 4 && value(old, 4 * i + 3) !== value(now, 4 * i + 3)) { wrong.push(`${where}: the sign of tangent ${i} changed`); break; }
      }
    });
  }
}

function compare(input, output, flat) {
  const before = load(input), after = load(output), wrong = [];
  let passedOver = 0;
  const rest = ({ json }) => JSON.stringify({ ...json, accessors: 0, bufferViews: 0, buffers: 0, extensionsUsed: 0, extensionsRequired: 0, meshes: (json.meshes ?? []).map((m) => ({ ...m, primitives: m.primitives.map((p) => ({ ...p, attributes: 0, indices: 0, mode: 0, targets: 0 })) })) });
  if (rest(before) !== rest(after)) wrong.push("the rest of the JSON changed");
  (before.json.meshes ?? []).forEach((mesh, m) => mesh.primitives.forEach((p, i) => {
    const q = after.json.meshes[m].primitives[i], where = `/meshes/${m}/primitives/${i}`;
    if (p.attributes.POSITION === undefined || p.extensions?.KHR_draco_mesh_compression) return;
    try {
      const old = corners(before, p), now = corners(after, q);
      if (old.length !== now.length) { wrong.push(`${where} draws ${now.length} corners instead of ${old.length}`); return; }
      compareAttributes(before, after, p.attributes, q.attributes, old, now, where, wrong);
      (p.targets ?? []).forEach((target, t) => compareAttributes(before, after, target, q.targets[t], old, now, `${where}/targets/${t}`, wrong));
      if (bound !== null) checkPacked(before, after, p, q, where, wrong);
      else if ((p.mode ?? 4) >= 4 && addon) checkTangents(before, after, p, q, old, now, where, wrong);
      else if ((p.mode ?? 4) >= 4) checkNormals(after, q, now, flat, where, wrong);
    } catch (error) {
      if (!(error instanceof Unreadable)) throw error;
      passedOver++;
    }
  }));
  return { wrong, passedOver };
}

const words = process.argv.slice(2), files = [];
let flat = false, quiet = false, bad = 0, passedOver = 0;
while (words.length) {
  const word = words.shift();
  if (word === "--flat") flat = true;
  else if (word === "--quiet") quiet = true;
  else if (word === "--packed" && words.length) bound = Number(words.shift());
  else if ((word === "--tangents" || word === "--meshopt") && words.length) {
    const modules = pathToFileURL(path.resolve(words.shift()));
    addon = { ...(await import(`${modules}/three/examples/jsm/libs/mikktspace.module.js`)), ...(await import(`${modules}/three/build/three.core.js`)) };
    if (addon.ready) await addon.ready;
    if (word === "--meshopt") {
      addon.meshopt = (await import(`${modules}/meshoptimizer/meshopt_tangents.js`)).MeshoptTangents;
      await addon.meshopt.ready;
    }
  }
  else if (word === "--list" && words.length) files.push(...readFileSync(words[0] === "-" ? 0 : words[0], "utf8").split("\n").filter(Boolean).flatMap((line) => line.split("\t"))), words.shift();
  else files.push(word);
}
if (files.length === 0 || files.length % 2) {
  console.error("corners.mjs: usage: node corners.mjs [--flat] [--quiet] INPUT OUTPUT ... | --list PAIRS");
  process.exit(2);
}
for (let i = 0; i < files.length; i += 2) {
  const result = compare(files[i], files[i + 1], flat);
  passedOver += result.passedOver;
  if (result.wrong.length) bad++;
  for (const line of result.wrong.slice(0, 5)) console.log(`${files[i + 1]}: ${line}`);
  if (!quiet && !result.wrong.length) console.log(`${files[i + 1]}: fine`);
}
console.log(`${files.length / 2} pairs, ${bad} wrong, ${passedOver} primitives passed over` + (addon ? `; tangents of ${counted.meshes} primitives and ${counted.targets} morph targets, ${counted.corners} corners, at ${counted.useless} of which the reference has none` : "") + (bound === null ? "" : `; ${packed.vectors} directions, those of ${packed.targets} targets among them, at most ${packed.worst.toFixed(5)} degrees off`));
process.exitCode = bad ? 1 : 0;
