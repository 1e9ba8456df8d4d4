/* norma-mesh/three: normals and tangents of three.js geometries. After `await load()` every call is synchronous. */
import { BufferAttribute, BufferGeometry, InterleavedBufferAttribute } from "three";
import * as given from "./arguments.js";
import { fail, spell } from "./arguments.js";
import { loaded } from "./load.js";
import { NORMAL_OPTIONS, creaseVertices, gather, indexArray, pick } from "./vertices.js";

const DIRECT = [Float32Array, Float64Array, Int8Array, Uint8Array, Uint8ClampedArray, Int16Array, Uint16Array];
const XYZ = 3, XYZW = 4, UV = 2;

/* ---- reading geometries */

const needed = (geometry, name) => {
  if (!geometry?.isBufferGeometry) fail(`geometry: ${spell(geometry)} is not a BufferGeometry`);
  const attribute = geometry.getAttribute(name) ?? fail(`geometry: it has no ${name} attribute`);
  if (attribute.isGLBufferAttribute) fail(`geometry: its ${name} attribute lies in a buffer of the graphics card alone`);
  return attribute;
};

const numbersOf = (attribute, size) => {
  const get = [(i) => attribute.getX(i), (i) => attribute.getY(i), (i) => attribute.getZ(i)], floats = new Float32Array(size * attribute.count);
  for (let i = 0; i < attribute.count; i++) for (let k = 0; k < size; k++) floats[size * i + k] = k < attribute.itemSize ? get[k](i) : 0;
  return floats;
};

/* An attribute as the calls take it; copied only if its numbers are not what they stand for. asTheyAre: integers may stay integers, a common factor does not matter. */
function viewOf(attribute, size, asTheyAre) {
  const { itemSize, count } = attribute, array = attribute.isInterleavedBufferAttribute ? attribute.data.array : attribute.array;
  const isFloat = array instanceof Float32Array || array instanceof Float64Array;
  const direct = DIRECT.includes(array.constructor) && !attribute.isFloat16BufferAttribute && itemSize >= size && (isFloat || asTheyAre || attribute.normalized);
  if (!direct) return numbersOf(attribute, size);
  if (attribute.isInterleavedBufferAttribute) return { array, stride: attribute.data.stride, offset: attribute.offset, count };
  return itemSize === size ? array : { array, stride: itemSize, count };
}

const positionsOf = (attribute, options) => viewOf(attribute, XYZ, typeof options.weld !== "number");

function indicesOf(geometry) {
  const array = geometry.index?.array;
  return !array || array instanceof Uint32Array || array instanceof Uint16Array || array instanceof Uint8Array ? array : Uint32Array.from(array);
}

/* ---- writing them */

const isPlain = (attribute, size) => attribute.array instanceof Float32Array && !attribute.isInterleavedBufferAttribute && attribute.itemSize === size && !attribute.normalized;

/* The attribute that floats are written into: the one that is there, if it has a value for each vertex. */
function writable(geometry, name, size, count) {
  const there = geometry.getAttribute(name);
  if (there && there.count === count && there.itemSize === size && !there.isGLBufferAttribute) return there;
  const made = new BufferAttribute(new Float32Array(size * count), size);
  geometry.setAttribute(name, made);
  return made;
}

function write(attribute, floats) {
  if (isPlain(attribute, XYZ)) { if (attribute.array !== floats) attribute.array.set(floats); }
  else for (let i = 0; i < attribute.count; i++) attribute.setXYZ(i, floats[XYZ * i], floats[XYZ * i + 1], floats[XYZ * i + 2]);
  attribute.needsUpdate = true;
}

/* ---- morph targets */

/* The positions of a target, whole. */
function morphed(base, target, isRelative) {
  const positions = numbersOf(target, XYZ);
  if (isRelative) for (let i = 0; i < positions.length; i++) positions[i] += base[i];
  return positions;
}

/* The normals of morph targets as the geometry stores them: at vertices, or differences. cornerOf: with the normals of corners, one corner of each vertex (-1: none). */
function morphNormals(geometry, plan, normals, cornerOf) {
  const targets = geometry.morphAttributes.position, isRelative = geometry.morphTargetsRelative, base = numbersOf(geometry.attributes.position, XYZ);
  return targets.map((target) => {
    const computed = plan.update(morphed(base, target, isRelative)), count = normals.length / XYZ, result = new Float32Array(XYZ * count);
    for (let i = 0; i < count; i++) {
      const from = cornerOf ? cornerOf[i] : i;
      for (let k = 0; k < XYZ; k++) {
        const there = from < 0 ? normals[XYZ * i + k] : computed[XYZ * from + k];
        result[XYZ * i + k] = isRelative ? there - normals[XYZ * i + k] : there;
      }
    }
    return result;
  });
}

function writeMorphNormals(geometry, arrays) {
  const before = geometry.morphAttributes.normal ?? [];
  geometry.morphAttributes.normal = arrays.map((array, i) => {
    const fits = before[i]?.count === array.length / XYZ && before[i].itemSize === XYZ, attribute = fits ? before[i] : new BufferAttribute(array, XYZ);
    if (fits) write(attribute, array);
    attribute.name = geometry.morphAttributes.position[i].name;
    return attribute;
  });
}

const hasMorphs = (geometry) => geometry.morphAttributes.position?.length > 0;

/* ---- the calls */

/* One normal per vertex, written in place; morph normals too. */
export function computeNormals(geometry, options) {
  const norma = loaded(), chosen = given.options(options, [...NORMAL_OPTIONS, "report"].join(" "));
  const position = needed(geometry, "position"), indices = indicesOf(geometry), normal = pick(chosen, NORMAL_OPTIONS);
  const positions = positionsOf(position, chosen), wanted = given.flag(chosen.report, "report");
  const there = geometry.getAttribute("normal"), out = there?.count === position.count && isPlain(there, XYZ) ? there.array : undefined;
  const computed = norma.vertexNormals(positions, indices, { ...normal, out, report: wanted }), { normals, report } = wanted ? computed : { normals: computed };
  write(writable(geometry, "normal", XYZ, position.count), normals);
  if (hasMorphs(geometry)) {
    const plan = norma.plan(positions, indices, normal);
    try { writeMorphNormals(geometry, morphNormals(geometry, plan, normals)); } finally { plan.free(); }
  }
  return wanted ? { geometry, report } : geometry;
}

/* Whether an attribute has a value for each instance, not for each vertex. */
const isInstanced = (attribute) => attribute.isInstancedBufferAttribute || attribute.isInstancedInterleavedBuffer || attribute.data?.isInstancedInterleavedBuffer;

/* A copy of an attribute, with another array. */
function withArray(attribute, array) {
  const made = new attribute.constructor(new array.constructor(0), attribute.itemSize, attribute.normalized);
  made.array = array;
  made.count = array.length / attribute.itemSize;
  if (attribute.gpuType !== undefined) made.gpuType = attribute.gpuType;
  return made.setUsage(attribute.usage);
}

/* Attributes for count vertices and copies of those in sources. An interleaved buffer is copied once, and stays interleaved. */
function makeCarry(count, sources) {
  const buffers = new Map();
  return (attribute) => {
    if (isInstanced(attribute) || attribute.isGLBufferAttribute) return attribute;
    let made;
    if (attribute.isInterleavedBufferAttribute) {
      const { data } = attribute;
      if (!buffers.has(data)) {
        const copy = new data.constructor(gather(data.array, data.stride, count, sources), data.stride);
        buffers.set(data, copy.setUsage(data.usage));
      }
      made = new InterleavedBufferAttribute(buffers.get(data), attribute.itemSize, attribute.offset, attribute.normalized);
    } else {
      made = withArray(attribute, gather(attribute.array, attribute.itemSize, count, sources));
    }
    made.name = attribute.name;
    return made;
  };
}

/* Gives geometry the vertices of another, and copies of those in sources: all attributes but the one that is written next, and those of morph targets. */
function setAttributes(geometry, from, sources, next) {
  const carry = makeCarry(from.attributes.position.count, sources);
  for (const [name, attribute] of Object.entries(from.attributes)) if (name !== next) geometry.setAttribute(name, carry(attribute));
  for (const [name, targets] of Object.entries(from.morphAttributes)) geometry.morphAttributes[name] = targets.map(carry);
}

/* The same, with an index. */
function setVertices(geometry, from, { count, indices, sources }, next) {
  setAttributes(geometry, from, sources, next);
  geometry.setIndex(new BufferAttribute(indexArray(indices, count, from.index.array), 1));
}

/* Everything but attributes and index. */
function copyRest(geometry, from) {
  geometry.name = from.name;
  if (Object.keys(from.userData).length) geometry.userData = structuredClone(from.userData);
  geometry.morphTargetsRelative = from.morphTargetsRelative;
  for (const { start, count, materialIndex } of from.groups) geometry.addGroup(start, count, materialIndex);
  geometry.setDrawRange(from.drawRange.start, from.drawRange.count);
  geometry.boundingBox = from.boundingBox?.clone() ?? null;
  geometry.boundingSphere = from.boundingSphere?.clone() ?? null;
  if (from.isInstancedBufferGeometry) geometry.instanceCount = from.instanceCount;
}

/* A geometry with creases: vertices are doubled only where one is. */
export function toCreased(geometry, options) {
  const norma = loaded(), chosen = given.options(options, [...NORMAL_OPTIONS, "crease", "report"].join(" "));
  const position = needed(geometry, "position"), indices = indicesOf(geometry), normal = { fallback: "nearest", ...pick(chosen, NORMAL_OPTIONS) }, crease = given.crease(chosen.crease);
  const positions = positionsOf(position, chosen), wanted = given.flag(chosen.report, "report");
  const creased = emptyLike(geometry), asked = { ...normal, crease, report: wanted };
  let normals, firsts, report;
  if (indices) {
    const vertices = creaseVertices(norma, positions, indices, asked, hasMorphs(geometry));
    ({ values: normals, firsts, report } = vertices);
    setVertices(creased, geometry, vertices, "normal");
  } else {
    const computed = norma.cornerNormals(positions, asked);
    ({ normals, report } = wanted ? computed : { normals: computed });
    setAttributes(creased, geometry, [], "normal");
  }
  creased.setAttribute("normal", new BufferAttribute(normals, XYZ));
  if (hasMorphs(geometry)) {
    const plan = norma.plan(positions, indices, { ...normal, per: "corner", crease });
    try {
      const carried = morphNormals(geometry, plan, normals, firsts);
      delete creased.morphAttributes.normal;
      writeMorphNormals(creased, carried);
    } finally { plan.free(); }
  }
  return wanted ? { geometry: creased, report } : creased;
}

/* An empty geometry with whatever is not an attribute. */
function emptyLike(geometry) {
  const made = geometry.isInstancedBufferGeometry ? new geometry.constructor() : new BufferGeometry();
  copyRest(made, geometry);
  return made;
}

/* Tangents with the precision of the normals: normalised integers, or floats. */
function tangentAttribute(values, normal) {
  const array = normal.array, quantised = normal.normalized && (array instanceof Int8Array || array instanceof Int16Array);
  if (!quantised) return new BufferAttribute(values, XYZW);
  const most = array instanceof Int8Array ? 127 : 32767;
  return new BufferAttribute(array.constructor.from(values, (x) => Math.round(x * most)), XYZW, true);
}

/* Tangents, in place. An indexed geometry stays indexed: vertices are added only where the tangents of their corners differ. */
export function computeTangents(geometry, options) {
  const norma = loaded(), chosen = given.options(options, "mode weight negateSign texcoord report");
  const { texcoord: channel = 0 } = chosen, negate = chosen.negateSign === undefined || given.flag(chosen.negateSign, "negateSign"), wanted = given.flag(chosen.report, "report");
  if (!Number.isInteger(channel) || channel < 0 || channel > 3) fail(`texcoord: ${spell(channel)} is not 0, 1, 2 or 3`);
  const position = needed(geometry, "position"), normal = needed(geometry, "normal"), uv = needed(geometry, channel ? `uv${channel}` : "uv"), indices = indicesOf(geometry);
  const streams = [viewOf(position, XYZ, false), viewOf(normal, XYZ, false), viewOf(uv, UV, false)], asked = { ...pick(chosen, ["mode", "weight"]), report: wanted };
  const vertices = norma.tangentVertices(...streams, indices, asked), { values, report } = vertices;
  if (negate) for (let i = 3; i < values.length; i += XYZW) values[i] = -values[i];
  if (vertices.sources.length) setVertices(geometry, geometry, vertices, "tangent");
  geometry.setAttribute("tangent", tangentAttribute(values, normal));
  return wanted ? { geometry, report } : geometry;
}

/* For a geometry that moves: update() reads its positions and writes its normals. */
export function planFor(geometry, options) {
  const norma = loaded(), chosen = given.options(options, "weight weld nonManifold fallback crease");
  const position = needed(geometry, "position"), indices = indicesOf(geometry), { count } = position;
  const plan = norma.plan(positionsOf(position, chosen), indices, chosen);
  const free = () => {
    geometry.removeEventListener("dispose", free);
    plan.free();
  };
  geometry.addEventListener("dispose", free);
  let kept = null; // the last normals, where the attribute cannot hold them as they are
  const update = (wanted) => {
    const { moved, report } = given.options(wanted, "moved report"), now = needed(geometry, "position");
    if (now.count !== count) fail(`geometry: it has ${now.count} positions, but the plan was made for ${count}`);
    const normal = writable(geometry, "normal", XYZ, count), plain = isPlain(normal, XYZ);
    if (moved && !plain && !kept) fail("moved: the first update has to be of all vertices");
    const out = plain ? normal.array : (kept ??= new Float32Array(XYZ * count));
    const updated = plan.update(positionsOf(now, chosen), { moved, out, report: true });
    write(normal, updated.normals);
    return report ? updated.report : undefined;
  };
  return { update, free, get bytes() { return plan.bytes; } };
}

/* Memory that a worker sees too, where there is such; arrays elsewhere are copied to it. */
const sharedFloats = (length) => new Float32Array(globalThis.SharedArrayBuffer ? new SharedArrayBuffer(4 * length) : length);

/* The same in a worker. Positions are read when update is called, or when the update before is done; normals are written when the promise is kept: nobody sees half of either. */
export async function planForWorker(worker, geometry, options) {
  if (typeof worker?.plan !== "function") fail(`worker: ${spell(worker)} is not what loadWorker gives`);
  const chosen = given.options(options, "weight weld nonManifold fallback crease"), { count } = needed(geometry, "position"), positions = sharedFloats(XYZ * count);
  const read = () => {
    const now = needed(geometry, "position");
    if (now.count !== count) fail(`geometry: it has ${now.count} positions, but the plan was made for ${count}`);
    positions.set(isPlain(now, XYZ) ? now.array : numbersOf(now, XYZ));
    return positions;
  };
  const plan = await worker.plan(read(), indicesOf(geometry), chosen);
  let out = null, last = Promise.resolve(); // out: the last normals; none where an update failed, for they may have been handed over
  const free = () => {
    geometry.removeEventListener("dispose", free);
    return plan.free();
  };
  geometry.addEventListener("dispose", free);
  const step = async ({ moved, report }) => {
    const before = out, asked = { moved: before ? moved : undefined, out: before ?? sharedFloats(XYZ * count), report: true };
    out = null;
    const updated = await plan.update(read(), asked);
    out = updated.normals;
    write(writable(geometry, "normal", XYZ, count), out);
    return report ? updated.report : undefined;
  };
  const update = async (wanted) => {
    const asked = given.options(wanted, "moved report"), mine = last.then(() => step(asked));
    last = mine.catch(() => undefined);
    return mine;
  };
  return { update, free, bytes: plan.bytes };
}

export { load } from "norma-mesh";
