/* Babylon.js: a VertexData in, normals and tangents out. Its engine without a picture serves here; a page makes an Engine of its canvas.   node babylon.mjs */
import { NullEngine } from "@babylonjs/core/Engines/nullEngine.js";
import { Logger } from "@babylonjs/core/Misc/logger.js";
import { VertexBuffer } from "@babylonjs/core/Buffers/buffer.js";
import { Mesh } from "@babylonjs/core/Meshes/mesh.js";
import { VertexData } from "@babylonjs/core/Meshes/mesh.vertexData.js";
import { Scene } from "@babylonjs/core/scene.js";
import { computeNormals, computeTangents, load, toCreased } from "norma-mesh/babylon";

await load();
Logger.LogLevels = Logger.ErrorLogLevel;
const scene = new Scene(new NullEngine()), prism = new VertexData(); // of three sides and eight vertices, two of them at the same place as others: a seam of texture coordinates
prism.positions = [0, 0, 0, 0.5, 0, 1, 1, 0, 0, 0, 0, 0, 0, 2, 0, 0.5, 2, 1, 1, 2, 0, 0, 2, 0];
prism.uvs = [0, 0, 1, 0, 2, 0, 3, 0, 0, 2, 1, 2, 2, 2, 3, 2];
prism.indices = [0, 5, 1, 0, 4, 5, 1, 6, 2, 1, 5, 6, 2, 7, 3, 2, 6, 7, 0, 1, 2, 4, 6, 5];

/* Normals alone, in place: vertices at equal positions share one, so that no seam is seen. */
const smooth = computeNormals(prism.clone());
console.log(`smooth: ${smooth.normals.length / 3} normals`);

/* Creases: vertices are doubled only where one is; texture coordinates, colours and bones go along. Tangents for the normal map afterwards. */
const { vertexData: creased, report } = toCreased(prism, { crease: 40, report: true });
computeTangents(creased);
console.log(`creased at 40 degrees: ${creased.positions.length / 3} vertices of ${prism.positions.length / 3}; ${report.degenerateFaces} faces without area`);

const mesh = new Mesh("prism", scene);
creased.applyToMesh(mesh);
console.log(`on the mesh: ${mesh.getTotalVertices()} vertices, ${mesh.getVerticesData(VertexBuffer.TangentKind).length / 4} tangents`);

/* Babylon.js's own normals, for comparison: the same sense, no creases. */
const theirs = [];
VertexData.ComputeNormals(creased.positions, creased.indices, theirs);
const agree = creased.normals.filter((_, i) => i % 3 === 0 && creased.normals[i] * theirs[i] + creased.normals[i + 1] * theirs[i + 1] + creased.normals[i + 2] * theirs[i + 2] > 0).length;
console.log(`${agree} of ${theirs.length / 3} point to the side that Babylon.js's point to`);
