/* norma-mesh/playcanvas: normals and tangents of PlayCanvas's Mesh. After `await load()` every call is synchronous. */
import { BUFFER_DYNAMIC, PRIMITIVE_TRIANGLES, SEMANTIC_NORMAL, SEMANTIC_POSITION, SEMANTIC_TANGENT, SEMANTIC_TEXCOORD, TYPE_FLOAT32, TYPE_INT16, TYPE_INT32, TYPE_INT8, TYPE_UINT16, TYPE_UINT32, TYPE_UINT8 } from "playcanvas";
import * as given from "./arguments.js";
import { fail, spell } from "./arguments.js";
import { loaded } from "./load.js";
import { NORMAL_OPTIONS, creaseVertices, gather, pick } from "./vertices.js";

const XYZ = 3, XYZW = 4, UV = 2, LAST_TEXCOORD = 7;
/* What is of another type is carried along (halves as their bits), and no call computes from it. */
const ARRAYS = new Map([[TYPE_INT8, Int8Array], [TYPE_UINT8, Uint8Array], [TYPE_INT16, Int16Array], [TYPE_UINT16, Uint16Array], [TYPE_INT32, Int32Array], [TYPE_UINT32, Uint32Array], [TYPE_FLOAT32, Float32Array]]);

/* ---- reading */

/* All streams of a mesh, each { name, array, size, type, normalize, asInt }, and its corners. */
function readMesh(mesh) {
  const { vertexBuffer, primitive } = mesh ?? {};
  if (!vertexBuffer || !primitive) fail(mesh?.getVertexStream ? "mesh: it has no vertices on the graphics card yet; call its update() first" : `mesh: ${spell(mesh)} is not a Mesh`);
  const { type, base, baseVertex, count: corners } = primitive[0], count = vertexBuffer.numVertices;
  if (type !== PRIMITIVE_TRIANGLES || base || baseVertex || corners % 3) fail("mesh: it is not a list of triangles from its first vertex on");
  const streams = vertexBuffer.format.elements.map(({ name, numComponents: size, dataType, normalize, asInt }) => {
    const array = new (ARRAYS.get(dataType) ?? Uint16Array)(size * count);
    mesh.getVertexStream(name, array);
    return { name, array, size, type: dataType, normalize, asInt };
  });
  const indexed = Boolean(mesh.indexBuffer[0]), indices = Uint32Array.from({ length: corners }, (_, i) => i), all = [];
  if (indexed) {
    mesh.getIndices(all);
    indices.set(all.slice(0, corners));
  }
  return { mesh, streams, count, indices, indexed };
}

/* A stream as the calls take it. Integers stay what they are: a common factor turns no direction. */
function vectorsOf({ streams }, name, size) {
  const stream = streams.find((one) => one.name === name) ?? fail(`mesh: it has no ${name}`);
  if (!ARRAYS.has(stream.type) || stream.size < size) fail(`mesh: its ${name} is not of at least ${size} floats or integers`);
  const { array, type, normalize } = stream, most = { [TYPE_INT8]: 127, [TYPE_UINT8]: 255, [TYPE_INT16]: 32767, [TYPE_UINT16]: 65535 }[type];
  const values = size === UV && normalize && most ? Float32Array.from(array, (x) => Math.max(x / most, -1)) : array;
  return { array: values instanceof Int32Array || values instanceof Uint32Array ? Float32Array.from(values) : values, stride: stream.size };
}

/* ---- writing */

/* Gives target the vertices of a mesh that was read and copies of those in sources, with values, floats, as the stream called name. */
function writeMesh(target, read, vertices, name, values, size) {
  const { streams, indexed, mesh } = read, { count, indices, sources } = vertices;
  if (sources.length && mesh.morph) fail("mesh: it has morph targets, and vertices would have to be added to them; compute normals of the file instead (npx norma-mesh compute)");
  const { vertexBuffer, indexBuffer } = mesh, kept = streams.filter((stream) => stream.name !== name);
  target.clear(vertexBuffer.usage === BUFFER_DYNAMIC, indexBuffer[0]?.usage === BUFFER_DYNAMIC);
  for (const { name: semantic, array, size: numbers, type, normalize, asInt } of kept) target.setVertexStream(semantic, gather(array, numbers, count - sources.length, sources), numbers, count, type, normalize, asInt);
  target.setVertexStream(name, values, size, count);
  if (indexed) target.setIndices(indices);
  target.update(PRIMITIVE_TRIANGLES, false);
}

/* ---- the calls */

/* One normal per vertex, in place. */
export function computeNormals(mesh, options) {
  const norma = loaded(), chosen = given.options(options, [...NORMAL_OPTIONS, "report"].join(" ")), wanted = given.flag(chosen.report, "report"), read = readMesh(mesh);
  const computed = norma.vertexNormals(vectorsOf(read, SEMANTIC_POSITION, XYZ), read.indices, { ...pick(chosen, NORMAL_OPTIONS), report: wanted });
  writeMesh(mesh, read, { count: read.count, indices: read.indices, sources: [] }, SEMANTIC_NORMAL, wanted ? computed.normals : computed, XYZ);
  return wanted ? { mesh, report: computed.report } : mesh;
}

/* A mesh with creases: vertices are doubled only where one is. */
export function toCreased(mesh, options) {
  const norma = loaded(), chosen = given.options(options, [...NORMAL_OPTIONS, "crease", "report"].join(" ")), wanted = given.flag(chosen.report, "report"), read = readMesh(mesh);
  const vertices = creaseVertices(norma, vectorsOf(read, SEMANTIC_POSITION, XYZ), read.indices, { ...pick(chosen, NORMAL_OPTIONS), crease: given.crease(chosen.crease), report: wanted });
  const made = new mesh.constructor(mesh.device);
  made.aabb = mesh.aabb.clone();
  made.skin = mesh.skin;
  writeMesh(made, read, vertices, SEMANTIC_NORMAL, vertices.values, XYZ);
  made.morph = mesh.morph;
  return wanted ? { mesh: made, report: vertices.report } : made;
}

/* Tangents, in place: vertices are added only where the tangents of their corners differ. */
export function computeTangents(mesh, options) {
  const norma = loaded(), chosen = given.options(options, "mode weight negateSign texcoord report"), read = readMesh(mesh);
  const { texcoord: channel = 0 } = chosen, negate = given.flag(chosen.negateSign, "negateSign"), wanted = given.flag(chosen.report, "report");
  if (!Number.isInteger(channel) || channel < 0 || channel > LAST_TEXCOORD) fail(`texcoord: ${spell(channel)} is not a whole number from 0 to ${LAST_TEXCOORD}`);
  const inputs = [vectorsOf(read, SEMANTIC_POSITION, XYZ), vectorsOf(read, SEMANTIC_NORMAL, XYZ), vectorsOf(read, SEMANTIC_TEXCOORD + channel, UV)];
  const vertices = norma.tangentVertices(...inputs, read.indices, { ...pick(chosen, ["mode", "weight"]), report: wanted });
  if (negate) for (let i = 3; i < vertices.values.length; i += XYZW) vertices.values[i] = -vertices.values[i];
  writeMesh(mesh, read, vertices, SEMANTIC_TANGENT, vertices.values, XYZW);
  return wanted ? { mesh, report: vertices.report } : mesh;
}

export { load } from "norma-mesh";
