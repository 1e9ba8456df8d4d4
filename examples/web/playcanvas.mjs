/* PlayCanvas: a Mesh in, normals and tangents out. Its device without a picture serves here; a page makes one of its canvas.   node playcanvas.mjs */
import { Mesh, NullGraphicsDevice, SEMANTIC_NORMAL, SEMANTIC_TANGENT } from "playcanvas";
import { computeNormals, computeTangents, load, toCreased } from "norma-mesh/playcanvas";

await load();
const canvas = { width: 1, height: 1, addEventListener() {}, removeEventListener() {}, getBoundingClientRect: () => ({ width: 1, height: 1 }) };
const device = new NullGraphicsDevice(canvas), count = (mesh) => mesh.vertexBuffer.numVertices;
const mesh = new Mesh(device); // a prism of three sides and eight vertices, two of them at the same place as others: a seam of texture coordinates
mesh.setPositions([0, 0, 0, 0.5, 0, 1, 1, 0, 0, 0, 0, 0, 0, 2, 0, 0.5, 2, 1, 1, 2, 0, 0, 2, 0]);
mesh.setUvs(0, [0, 0, 1, 0, 2, 0, 3, 0, 0, 2, 1, 2, 2, 2, 3, 2]);
mesh.setIndices([0, 1, 5, 0, 5, 4, 1, 2, 6, 1, 6, 5, 2, 3, 7, 2, 7, 6, 0, 2, 1, 4, 5, 6]);
mesh.update();

/* Normals alone, in place: vertices at equal positions share one, so that no seam is seen. */
console.log(`smooth: ${count(computeNormals(mesh))} normals`);

/* Creases: vertices are doubled only where one is, and all streams go along. Tangents for the normal map afterwards. */
const { mesh: creased, report } = toCreased(mesh, { crease: 40, report: true });
computeTangents(creased);
console.log(`creased at 40 degrees: ${count(creased)} vertices of ${count(mesh)}; ${report.degenerateFaces} faces without area`);
console.log(`streams: ${creased.vertexBuffer.format.elements.map(({ name, numComponents }) => `${name} ${numComponents}`).join(", ")}`);

const normals = [], tangents = [];
creased.getVertexStream(SEMANTIC_NORMAL, normals);
creased.getVertexStream(SEMANTIC_TANGENT, tangents);
const skew = Math.max(...Array.from({ length: count(creased) }, (_, i) => Math.abs(normals[3 * i] * tangents[4 * i] + normals[3 * i + 1] * tangents[4 * i + 1] + normals[3 * i + 2] * tangents[4 * i + 2])));
console.log(`normals and tangents are perpendicular: ${skew < 1e-6}`);
