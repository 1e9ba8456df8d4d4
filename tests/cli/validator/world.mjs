// world.mjs: does a transformed glTF show what its input shows, under the matrix? Reads both files with code of its own, nothing of Norma's.
//
//   node world.mjs [--matrix "16 numbers, row by row"] [--bake] [--quiet] INPUT OUTPUT [INPUT OUTPUT ...]
//   node world.mjs ... --list PAIRS                PAIRS: a file, or - for standard input; a line: INPUT tab OUTPUT
//
// For every mesh that a node draws (instances one by one, skins by their joints), vertex by vertex: the world position, the normal's and the tangent's direction,
// the tangent's sign, the same with each morph target at 1; and the set of triangles with the side they face; all once at rest and once with each animated
// property at its last key. With --bake also: what is not skinned or animated is drawn at the identity; nodes that draw nothing, and had children or a camera or
// an extension, are where they were or where the matrix takes them. Meshes compressed by extensions are passed over, and counted.
// Prints the worst deviations for each pair, and what is wrong; exit status 0, 1 (something wrong), 2 usage.
import { readFileSync } from "node:fs";
import { load, readers, widths } from "./asset.mjs";

// ---- reading

function elements(asset, view, offset, component, width, count) {
  const { json, buffers } = asset, v = json.bufferViews[view], [size, read] = readers[component];
  if (v.extensions?.EXT_meshopt_compression) throw new Error("compressed");
  const stride = v.byteStride ?? size * width, out = new Float64Array(count * width);
  for (let i = 0; i < count; i++) for (let k = 0; k < width; k++) out[i * width + k] = read(buffers[v.buffer], (v.byteOffset ?? 0) + (offset ?? 0) + i * stride + k * size);
  return out;
}

function accessor(asset, number) {
  if (asset.cache.has(number)) return asset.cache.get(number);
  const a = asset.json.accessors[number], width = widths[a.type], by = a.normalized ? readers[a.componentType][2] : 1;
  const data = a.bufferView === undefined ? new Float64Array(a.count * width) : elements(asset, a.bufferView, a.byteOffset, a.componentType, width, a.count);
  if (a.sparse) {
    const at = elements(asset, a.sparse.indices.bufferView, a.sparse.indices.byteOffset, a.sparse.indices.componentType, 1, a.sparse.count);
    const values = elements(asset, a.sparse.values.bufferView, a.sparse.values.byteOffset, a.componentType, width, a.sparse.count);
    at.forEach((to, i) => { for (let k = 0; k < width; k++) data[to * width + k] = values[i * width + k]; });
  }
  for (let i = 0; by > 1 && i < data.length; i++) data[i] = Math.max(data[i] / by, -1);
  const result = { data, width, count: a.count, component: a.componentType };
  asset.cache.set(number, result);
  return result;
}

// ---- matrices, column-major

const identity = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];
function multiply(a, b) {
  const out = new Array(16).fill(0);
  for (let c = 0; c < 4; c++) for (let r = 0; r < 4; r++) for (let k = 0; k < 4; k++) out[4 * c + r] += a[4 * k + r] * b[4 * c + k];
  return out;
}
function compose(t = [0, 0, 0], q = [0, 0, 0, 1], s = [1, 1, 1]) {
  const [x, y, z, w] = q;
  return [(1 - 2 * (y * y + z * z)) * s[0], 2 * (x * y + z * w) * s[0], 2 * (x * z - y * w) * s[0], 0, 2 * (x * y - z * w) * s[1], (1 - 2 * (x * x + z * z)) * s[1],
    2 * (y * z + x * w) * s[1], 0, 2 * (x * z + y * w) * s[2], 2 * (y * z - x * w) * s[2], (1 - 2 * (x * x + y * y)) * s[2], 0, ...t, 1];
}
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const column = (m, i) => [m[4 * i], m[4 * i + 1], m[4 * i + 2]];
const determinant = (m) => dot(column(m, 0), cross(column(m, 1), column(m, 2)));
const linear = (m, v) => [0, 1, 2].map((r) => m[r] * v[0] + m[4 + r] * v[1] + m[8 + r] * v[2]);
const point = (m, v) => linear(m, v).map((c, r) => c + m[12 + r]);
function covector(m, v) {
  const sign = determinant(m) < 0 ? -1 : 1, c = [cross(column(m, 1), column(m, 2)), cross(column(m, 2), column(m, 0)), cross(column(m, 0), column(m, 1))];
  return [0, 1, 2].map((r) => sign * (c[0][r] * v[0] + c[1][r] * v[1] + c[2][r] * v[2]));
}
const degrees = (a, b) => Math.atan2(Math.hypot(...cross(a, b)), dot(a, b)) * 180 / Math.PI;

// ---- the scene

function poses(asset) {
  const nodes = asset.json.nodes ?? [], moved = nodes.map((node) => ({ ...node }));
  for (const animation of asset.json.animations ?? [])
    for (const { target, sampler } of animation.channels) {
      if (target.node === undefined || !["translation", "rotation", "scale"].includes(target.path)) continue;
      const { interpolation, output } = animation.samplers[sampler], { data, width, count } = accessor(asset, output);
      const last = interpolation === "CUBICSPLINE" ? count - 2 : count - 1;
      moved[target.node][target.path] = Array.from(data.subarray(last * width, last * width + width));
    }
  return [nodes, moved];
}

function worlds(nodes) {
  const parents = nodes.map(() => -1), out = [];
  nodes.forEach((node, i) => (node.children ?? []).forEach((child) => { parents[child] = i; }));
  const world = (i) => {
    if (!out[i]) {
      const { matrix, translation, rotation, scale } = nodes[i], local = matrix ?? compose(translation, rotation, scale);
      out[i] = parents[i] < 0 ? local : multiply(world(parents[i]), local);
    }
    return out[i];
  };
  nodes.forEach((_, i) => world(i));
  return { parents, world: out };
}

const unit = (q) => q?.map((c) => c / (Math.hypot(...q) || 1)); // integers cannot hold a unit quaternion

function instances(asset, node) {
  const attributes = node.extensions?.EXT_mesh_gpu_instancing?.attributes;
  if (!attributes) return [identity];
  const get = (key) => (attributes[key] === undefined ? null : accessor(asset, attributes[key]));
  const [t, r, s] = ["TRANSLATION", "ROTATION", "SCALE"].map(get), at = (a, i) => (a ? Array.from(a.data.subarray(i * a.width, (i + 1) * a.width)) : undefined);
  return Array.from({ length: (t ?? r ?? s).count }, (_, i) => compose(at(t, i), unit(at(r, i)), at(s, i)));
}

function triangles(asset, primitive, vertices) {
  const list = primitive.indices === undefined ? Array.from({ length: vertices }, (_, i) => i) : Array.from(accessor(asset, primitive.indices).data), out = [];
  const mode = primitive.mode ?? 4;
  if (mode === 4) for (let i = 0; i + 2 < list.length; i += 3) out.push([list[i], list[i + 1], list[i + 2]]);
  if (mode === 5) for (let i = 0; i + 2 < list.length; i++) out.push(i % 2 ? [list[i], list[i + 2], list[i + 1]] : [list[i], list[i + 1], list[i + 2]]);
  if (mode === 6) for (let i = 1; i + 1 < list.length; i++) out.push([list[0], list[i], list[i + 1]]);
  return out.filter(([a, b, c]) => a !== b && b !== c && c !== a);
}

// Triangles as a sorted list of texts, each from its lowest vertex on, turned where the matrix mirrors.
function facing(list, mirrored) {
  return list.map(([a, b, c]) => {
    const t = mirrored ? [a, c, b] : [a, b, c], low = t.indexOf(Math.min(...t));
    return `${t[low]},${t[(low + 1) % 3]},${t[(low + 2) % 3]}`;
  }).sort();
}

// Every drawn primitive: key, the maps of its vertices (one matrix, or one for each vertex), its accessors.
function draws(asset, nodes, oldCount) {
  const { parents, world } = worlds(nodes), out = new Map(), counts = new Map();
  nodes.forEach((node, number) => {
    if (node.mesh === undefined) return;
    let origin = number;
    while (origin >= oldCount && parents[origin] >= 0) origin = parents[origin];
    const skin = node.skin === undefined ? null : asset.json.skins[node.skin];
    const joints = skin?.joints.map((joint, i) => {
      const inverse = skin.inverseBindMatrices === undefined ? identity : Array.from(accessor(asset, skin.inverseBindMatrices).data.subarray(16 * i, 16 * i + 16));
      return multiply(world[joint], inverse);
    });
    for (const instance of instances(asset, node)) {
      const turn = counts.get(origin) ?? 0;
      counts.set(origin, turn + 1);
      asset.json.meshes[node.mesh].primitives.forEach((primitive, k) => {
        if (primitive.attributes?.POSITION !== undefined) out.set(`node ${origin}, ${turn}, primitive ${k}`, { number, primitive, joints, matrix: multiply(world[number], instance) });
      });
    }
  });
  return { out, world, parents };
}

function vertexMatrix(asset, draw, i) {
  if (!draw.joints) return draw.matrix;
  const { JOINTS_0, WEIGHTS_0 } = draw.primitive.attributes, joints = accessor(asset, JOINTS_0), weights = accessor(asset, WEIGHTS_0), sum = new Array(16).fill(0);
  for (let k = 0; k < 4; k++) {
    const w = weights.data[4 * i + k];
    if (w) draw.joints[joints.data[4 * i + k]].forEach((c, e) => { sum[e] += w * c; });
  }
  return sum;
}

// ---- comparing

const tolerances = { 5126: 0.01, 5122: 0.02, 5120: 1.2 };
function element(asset, number, i) {
  const a = accessor(asset, number);
  return Array.from(a.data.subarray(i * a.width, (i + 1) * a.width));
}
const sum = (a, b) => a.map((c, k) => c + (b?.[k] ?? 0));

function compareDraw(before, after, a, b, matrix, size, worst, complain) {
  const pa = accessor(before, a.primitive.attributes.POSITION), pb = accessor(after, b.primitive.attributes.POSITION);
  if (pa.count !== pb.count) return complain(`${pa.count} vertices became ${pb.count}`);
  const whole = multiply(matrix, a.matrix), flat = Math.abs(determinant(whole)) < 1e-12 * Math.max(...whole.slice(0, 12).map(Math.abs)) ** 3;
  const fa = facing(triangles(before, a.primitive, pa.count), !a.joints && determinant(whole) < 0), fb = facing(triangles(after, b.primitive, pb.count), !b.joints && determinant(b.matrix) < 0);
  if (!flat && fa.join(" ") !== fb.join(" ")) complain(`triangles differ: ${fa.slice(0, 3).join(" ")} ... and ${fb.slice(0, 3).join(" ")} ...`);
  const targets = [null, ...(a.primitive.targets ?? []).map((_, i) => i)];
  for (let i = 0; i < pa.count; i++) {
    const ma = multiply(matrix, vertexMatrix(before, a, i)), mb = vertexMatrix(after, b, i);
    for (const target of targets) {
      const get = (asset, draw, name) => {
        const base = draw.primitive.attributes[name], delta = target === null ? undefined : draw.primitive.targets[target][name];
        return base === undefined ? null : sum(element(asset, base, i), delta === undefined ? null : element(asset, delta, i));
      };
      const off = Math.hypot(...point(ma, get(before, a, "POSITION")).map((c, k) => c - point(mb, get(after, b, "POSITION"))[k])) / size;
      worst.position = Math.max(worst.position, off);
      if (!(off < 3e-6)) return complain(`vertex ${i}${target === null ? "" : `, target ${target}`}: position off by ${off} of the scene's size`);
      for (const name of ["NORMAL", "TANGENT"]) {
        const from = get(before, a, name), to = get(after, b, name);
        if (!from !== !to) return complain(`${name} lost or made`);
        if (!from || flat || a.joints || Math.hypot(...from.slice(0, 3)) < 1e-3) continue;
        let expected = name === "NORMAL" ? covector(ma, from) : linear(ma, from), got = name === "NORMAL" ? covector(mb, to) : linear(mb, to);
        const normal = get(before, a, "NORMAL");
        if (name === "TANGENT" && normal) { // what counts is the direction within the surface
          const n = covector(ma, normal), within = (v) => v.map((c, k) => c - dot(v, n) / dot(n, n) * n[k]), inside = within(expected);
          if (Math.hypot(...inside) < 1e-2 * Math.hypot(...expected)) continue;
          expected = inside;
          got = within(got);
        }
        const angle = degrees(expected, got), kind = after.json.accessors[b.primitive.attributes[name]].componentType;
        const limit = (tolerances[kind] ?? 0.01) * (target === null ? 1 : 4) * (name === "TANGENT" && target !== null ? 4 : 1);
        if (name === "NORMAL" || target === null) worst[name] = Math.max(worst[name], kind === 5126 ? angle : 0);
        if (!(angle <= limit)) return complain(`vertex ${i}${target === null ? "" : `, target ${target}`}: ${name} off by ${angle} degrees`);
        if (name === "TANGENT" && target === null && Math.sign(from[3]) * Math.sign(determinant(ma)) !== Math.sign(to[3]) * Math.sign(determinant(mb))) return complain(`vertex ${i}: sign of the tangent`);
      }
    }
  }
}

function stays(asset, nodes, number, parents) {
  const moved = new Set();
  for (const animation of asset.json.animations ?? []) for (const { target } of animation.channels) if (target.path !== "weights") moved.add(target.node);
  for (let i = number; i >= 0; i = parents[i]) if (moved.has(i)) return true;
  return nodes[number].skin !== undefined;
}

function compareNodes(before, after, a, b, matrix, complain) {
  const nodes = before.json.nodes ?? [];
  for (const [number, node] of (after.json.nodes ?? []).entries())
    if (node.mesh !== undefined && !stays(after, after.json.nodes, number, b.parents) && b.world[number].some((c, k) => k < 15 && Math.abs(c - identity[k]) > 1e-9)) {
      const compressed = after.json.meshes[node.mesh].primitives.some((p) => p.extensions?.KHR_draco_mesh_compression);
      if (!compressed) complain(`node ${number} draws, and is not at the identity`);
    }
  nodes.forEach((node, number) => {
    if (node.mesh !== undefined) return;
    const far = (m) => Math.max(...b.world[number].map((c, k) => Math.abs(c - m[k]))) / Math.max(1, ...m.map(Math.abs));
    if (far(a.world[number]) > 1e-9 && far(multiply(matrix, a.world[number])) > 1e-9) complain(`node ${number} draws nothing, and was moved`);
  });
}

function comparePair(input, output, matrix, bake) {
  const before = load(input), after = load(output), worst = { position: 0, NORMAL: 0, TANGENT: 0 }, wrong = [];
  const count = before.json.nodes?.length ?? 0, posesBefore = poses(before), posesAfter = poses(after);
  let drawn = 0, passed = 0;
  for (let pose = 0; pose < (before.json.animations?.length ? 2 : 1); pose++) {
    const a = draws(before, posesBefore[pose], count), b = draws(after, posesAfter[pose], count);
    if (pose === 0 && bake) compareNodes(before, after, a, b, matrix, (text) => wrong.push(text));
    let size = 1e-30;
    for (const draw of a.out.values()) {
      const bounds = before.json.accessors[draw.primitive.attributes.POSITION], m = multiply(matrix, draw.matrix);
      for (const corner of [bounds.min, bounds.max]) if (corner && !draw.joints) size = Math.max(size, ...point(m, corner).map(Math.abs), ...m.slice(12, 15).map(Math.abs));
      if (draw.joints) size = Math.max(size, ...(bounds.max ?? [1]).map(Math.abs), ...draw.joints.flatMap((j) => multiply(matrix, j).map(Math.abs)));
    }
    if (a.out.size !== b.out.size) wrong.push(`${a.out.size} things drawn became ${b.out.size}`);
    for (const [key, draw] of a.out) {
      drawn++;
      const other = b.out.get(key);
      if (!other) { wrong.push(`${key} is not drawn any more`); continue; }
      if (draw.primitive.extensions?.KHR_draco_mesh_compression) { passed++; continue; }
      try {
        compareDraw(before, after, draw, other, matrix, size, worst, (text) => wrong.push(`${key}${pose ? ", animated" : ""}: ${text}`));
      } catch (error) {
        if (error.message !== "compressed") throw error;
        passed++;
      }
    }
  }
  return { drawn, passed, worst, wrong };
}

function usage(message) {
  console.error(`world.mjs: ${message}; usage: node world.mjs [--matrix "16 numbers"] [--bake] [--quiet] INPUT OUTPUT ... | --list PAIRS`);
  process.exit(2);
}

const words = process.argv.slice(2), files = [];
let matrix = identity, bake = false, quiet = false;
while (words.length) {
  const word = words.shift();
  if (word === "--bake") bake = true;
  else if (word === "--quiet") quiet = true;
  else if (word === "--matrix") {
    const rows = words.shift()?.trim().split(/[\s,]+/).map(Number) ?? [];
    if (rows.length !== 16 || rows.some(Number.isNaN)) usage("--matrix needs 16 numbers");
    matrix = rows.map((_, i) => rows[4 * (i % 4) + Math.floor(i / 4)]);
  } else if (word === "--list") {
    const name = words.shift();
    for (const line of readFileSync(name === "-" ? 0 : name, "utf8").split("\n")) if (line) files.push(...line.split("\t"));
  } else if (word.startsWith("--")) usage(`unknown option ${word}`);
  else files.push(word);
}
if (!files.length || files.length % 2) usage("files come in pairs");
let bad = 0, all = 0;
for (let i = 0; i < files.length; i += 2) {
  const { drawn, passed, worst, wrong } = comparePair(files[i], files[i + 1], matrix, bake);
  all += drawn;
  bad += wrong.length > 0;
  if (!quiet) console.log(`${files[i + 1]}: ${drawn} drawn, ${passed} compressed; positions ${worst.position.toExponential(1)}, normals ${worst.NORMAL.toFixed(5)}, tangents ${worst.TANGENT.toFixed(5)} degrees`);
  for (const text of wrong.slice(0, 10)) console.log(`${files[i + 1]}: WRONG: ${text}`);
  if (wrong.length > 10) console.log(`${files[i + 1]}: WRONG: and ${wrong.length - 10} more`);
}
console.log(`${files.length / 2} pairs, ${all} primitives drawn, ${bad} pairs wrong`);
process.exitCode = bad ? 1 : 0;
