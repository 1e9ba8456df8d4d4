// corners.mjs: did a tool that computes normals leave all else alone? Reads both files with code of its own, nothing of Norma's.
//
//   node corners.mjs [--flat] [--quiet] INPUT OUTPUT [INPUT OUTPUT ...]
//   node corners.mjs ... --list PAIRS              PAIRS: a file, or - for standard input; a line: INPUT tab OUTPUT
//
// Primitive by primitive, corner by corner of what it draws (strips and fans as triangles, points and lines as they are): every attribute but NORMAL and TANGENT, also
// those of morph targets, is the same numbers in the same type. The rest of the JSON (all but accessors, views, buffers and primitives) is the same. Every triangle
// primitive has normals, of unit length. With --flat each is that of its triangle, found here, to .05 degrees (.5 for bytes). Meshes that this cannot
// read (compressed, buffers without bytes) are passed over, and counted. Exit status 0, 1 (something is wrong), 2 usage.
import { readFileSync } from "node:fs";
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
    if (name === "NORMAL" || name === "TANGENT") continue;
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
      if ((p.mode ?? 4) >= 4) checkNormals(after, q, now, flat, where, wrong);
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
console.log(`${files.length / 2} pairs, ${bad} wrong, ${passedOver} primitives passed over`);
process.exitCode = bad ? 1 : 0;
