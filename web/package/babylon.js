/* norma-mesh/babylon: normals and tangents of Babylon.js's VertexData. After `await load()` every call is synchronous. */
import * as given from "./arguments.js";
import { fail, spell } from "./arguments.js";
import { loaded } from "./load.js";
import { NORMAL_OPTIONS, creaseVertices, gather, indexArray, pick, turnTriangles } from "./vertices.js";

const SIZES = { positions: 3, normals: 3, tangents: 4, uvs: 2, uvs2: 2, uvs3: 2, uvs4: 2, uvs5: 2, uvs6: 2, colors: 4, matricesIndices: 4, matricesWeights: 4, matricesIndicesExtra: 4, matricesWeightsExtra: 4 };
const LAST_TEXCOORD = 5;

/* One of the arrays as floats, which is what the graphics card gets; it has to hold a value for each vertex. */
function floatsOf(data, name, count) {
  const array = data[name], size = SIZES[name];
  if (!array) fail(`vertexData: it has no ${name}`);
  if (!Array.isArray(array) && given.kindOf(array) === undefined) fail(`vertexData.${name}: ${spell(array)} is neither an array nor a typed array`);
  if (count === undefined ? array.length % size : array.length !== size * count) fail(`vertexData.${name}: ${array.length} numbers, where ${count === undefined ? `a multiple of ${size}` : size * count} are expected`);
  return array instanceof Float32Array ? array : Float32Array.from(array);
}

/* Positions, and corners in the order in which their faces are seen from outside against the clock. Babylon.js is left-handed unless its scene says otherwise; its faces are then seen with the clock. */
function readData(data, rightHanded) {
  if (data === null || typeof data !== "object") fail(`vertexData: ${spell(data)} is not a VertexData`);
  const positions = floatsOf(data, "positions"), count = positions.length / SIZES.positions;
  const corners = data.indices ? Uint32Array.from(data.indices) : Uint32Array.from({ length: count }, (_, i) => i);
  if (corners.length % 3) fail(`vertexData: ${corners.length} corners are not a multiple of 3`);
  if (corners.some((vertex) => vertex >= count)) given.failAtIndex(corners, count);
  return { positions, count, indices: rightHanded ? corners : turnTriangles(corners) };
}

const likeBefore = (indices, count, before) => (Array.isArray(before) ? Array.from(indices) : before instanceof Int32Array ? Int32Array.from(indices) : indexArray(indices, count, before));

/* Gives data the vertices that were there and copies of those in sources. Faces keep their order, and with it the ranges of sub-meshes; which vertices those use is counted again. */
function setVertices(data, before, { count, indices, sources }, rightHanded, next) {
  for (const [name, size] of Object.entries(SIZES)) if (before[name] && name !== next) data[name] = gather(floatsOf(before, name, count - sources.length), size, count - sources.length, sources);
  if (before.indices) data.indices = likeBefore(rightHanded ? indices : turnTriangles(indices), count, before.indices);
  if (!before.materialInfos || !before.indices) return;
  data.materialInfos = before.materialInfos.map((info) => {
    const used = data.indices.slice(info.indexStart, info.indexStart + info.indexCount), least = used.reduce((a, b) => Math.min(a, b), count), most = used.reduce((a, b) => Math.max(a, b), -1);
    return Object.assign(Object.create(Object.getPrototypeOf(info)), info, used.length ? { verticesStart: least, verticesCount: most - least + 1 } : {});
  });
}

/* One normal per vertex, written in place. */
export function computeNormals(data, options) {
  const norma = loaded(), chosen = given.options(options, [...NORMAL_OPTIONS, "rightHanded", "report"].join(" ")), wanted = given.flag(chosen.report, "report");
  const { positions, indices, count } = readData(data, given.flag(chosen.rightHanded, "rightHanded"));
  const out = data.normals instanceof Float32Array && data.normals.length === SIZES.normals * count ? data.normals : undefined;
  const computed = norma.vertexNormals(positions, indices, { ...pick(chosen, NORMAL_OPTIONS), out, report: wanted });
  data.normals = wanted ? computed.normals : computed;
  return wanted ? { vertexData: data, report: computed.report } : data;
}

/* A VertexData with creases: vertices are doubled only where one is. */
export function toCreased(data, options) {
  const norma = loaded(), chosen = given.options(options, [...NORMAL_OPTIONS, "crease", "rightHanded", "report"].join(" ")), rightHanded = given.flag(chosen.rightHanded, "rightHanded");
  const wanted = given.flag(chosen.report, "report"), { positions, indices } = readData(data, rightHanded);
  const vertices = creaseVertices(norma, positions, indices, { ...pick(chosen, NORMAL_OPTIONS), crease: given.crease(chosen.crease), report: wanted });
  const made = new data.constructor();
  /* A VertexData keeps functions that are bound to itself, and a number of its own. */
  for (const [name, value] of Object.entries(data)) if (typeof value !== "function" && name !== "uniqueId") made[name] = value;
  setVertices(made, data, vertices, rightHanded, "normals");
  made.normals = vertices.values;
  return wanted ? { vertexData: made, report: vertices.report } : made;
}

/* Tangents, in place: vertices are added only where the tangents of their corners differ. */
export function computeTangents(data, options) {
  const norma = loaded(), chosen = given.options(options, "mode weight negateSign texcoord rightHanded report"), rightHanded = given.flag(chosen.rightHanded, "rightHanded");
  const { texcoord: channel = 0 } = chosen, negate = given.flag(chosen.negateSign, "negateSign"), wanted = given.flag(chosen.report, "report");
  if (!Number.isInteger(channel) || channel < 0 || channel > LAST_TEXCOORD) fail(`texcoord: ${spell(channel)} is not a whole number from 0 to ${LAST_TEXCOORD}`);
  const { positions, indices, count } = readData(data, rightHanded);
  const vertices = norma.tangentVertices(positions, floatsOf(data, "normals", count), floatsOf(data, channel ? `uvs${channel + 1}` : "uvs", count), indices, { ...pick(chosen, ["mode", "weight"]), report: wanted });
  if (negate) for (let i = 3; i < vertices.values.length; i += SIZES.tangents) vertices.values[i] = -vertices.values[i];
  if (vertices.sources.length) setVertices(data, data, vertices, rightHanded, "tangents");
  data.tangents = vertices.values;
  return wanted ? { vertexData: data, report: vertices.report } : data;
}

export { load } from "norma-mesh";
