/* three.js: a BufferGeometry in, normals out.   node three.mjs */
import { BufferAttribute, BufferGeometry, LatheGeometry, Matrix4, TorusKnotGeometry, Vector2 } from "three";
import { load } from "norma-mesh";

const norma = await load();

/* One normal per vertex; vertices at one position, as along a seam of UVs, share it. */
export function computeNormals(geometry, options) {
  const { position } = geometry.attributes, old = geometry.getAttribute("normal")?.array;
  const out = old instanceof Float32Array && old.length === position.array.length ? old : undefined;
  const normals = norma.vertexNormals(position.array, geometry.index?.array, { ...options, out });
  if (out) geometry.attributes.normal.needsUpdate = true;
  else geometry.setAttribute("normal", new BufferAttribute(normals, 3));
  return geometry;
}

/* Creases: an indexed geometry in which a vertex is doubled only where it has to be; every attribute comes along. */
export function creaseNormals(geometry, crease = 60, options) {
  const { indices, sourceVertices, normals } = norma.split(geometry.attributes.position.array, geometry.index?.array, { fallback: "nearest", ...options, crease });
  const creased = new BufferGeometry();
  for (const [name, attribute] of Object.entries(geometry.attributes)) {
    const { itemSize, array, normalized } = attribute;
    const copy = new array.constructor(sourceVertices.length * itemSize);
    sourceVertices.forEach((vertex, i) => copy.set(array.subarray(vertex * itemSize, (vertex + 1) * itemSize), i * itemSize));
    creased.setAttribute(name, new BufferAttribute(copy, itemSize, normalized));
  }
  return creased.setAttribute("normal", new BufferAttribute(normals, 3)).setIndex(new BufferAttribute(indices, 1));
}

const knot = new TorusKnotGeometry(10, 3, 200, 24);
const exact = knot.attributes.normal.array.slice();
const normals = computeNormals(knot).attributes.normal.array;
let worst = 0;
for (let i = 0; i < exact.length; i += 3) {
  const cosine = exact[i] * normals[i] + exact[i + 1] * normals[i + 1] + exact[i + 2] * normals[i + 2];
  worst = Math.max(worst, (Math.acos(Math.min(1, cosine)) * 180) / Math.PI);
}
console.log(`torus knot: ${normals.length / 3} normals, within ${worst.toFixed(1)} degrees of those that three.js takes from the curve`);

const cup = new LatheGeometry([[0, 0], [2, 0], [2.5, 3]].map(([x, y]) => new Vector2(x, y)), 32);
const count = (geometry) => geometry.attributes.position.count;
console.log(`cup: ${count(cup)} vertices; creased at 60 degrees ${count(creaseNormals(cup, 60))}, at 180 ${count(creaseNormals(cup, 180))}`);

const model = new Matrix4().makeScale(2, 0.5, 1);
console.log(`scaled by (2, 0.5, 1), plain M would turn normals by up to ${norma.matrixInfo(model.elements).worstErrorDeg.toFixed(2)} degrees`);
console.log(`normal matrix: ${Array.from(norma.normalMatrix(model.elements)).join(" ")}`);
