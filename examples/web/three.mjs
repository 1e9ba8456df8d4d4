/* three.js: a BufferGeometry in, normals out.   node three.mjs */
import { LatheGeometry, Matrix4, TorusKnotGeometry, Vector2 } from "three";
import { load } from "norma-mesh";
import { computeNormals, toCreased } from "norma-mesh/three";

const norma = await load();

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
console.log(`cup: ${count(cup)} vertices; creased at 60 degrees ${count(toCreased(cup, { crease: 60 }))}, at 180 ${count(toCreased(cup, { crease: 180 }))}`);

const model = new Matrix4().makeScale(2, 0.5, 1);
console.log(`scaled by (2, 0.5, 1), plain M would turn normals by up to ${norma.matrixInfo(model.elements).worstErrorDeg.toFixed(2)} degrees`);
console.log(`normal matrix: ${Array.from(norma.normalMatrix(model.elements)).join(" ")}`);
