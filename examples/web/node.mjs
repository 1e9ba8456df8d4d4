/* Normals in node: a roof, smooth and creased, and what a scale does to them.   node node.mjs */
import { load } from "norma-mesh";

const norma = await load();
const positions = Float32Array.of(0, 0, 0, 2, 0, 0, 0, 1, 1, 2, 1, 1, 0, 2, 0, 2, 2, 0);
const indices = Uint16Array.of(0, 1, 3, 0, 3, 2, 2, 3, 5, 2, 5, 4);
const show = (name, vectors) => {
  console.log(name);
  for (let i = 0; i < vectors.length; i += 3) console.log("  " + Array.from(vectors.subarray(i, i + 3), (x) => x.toFixed(3)).join(" "));
};

show("one normal for each vertex", norma.vertexNormals(positions, indices));
const creased = norma.split(positions, indices, { crease: 60 });
console.log(`creased at 60 degrees: ${creased.sourceVertices.length} vertices of ${positions.length / 3}`);
show("their normals", creased.normals);

const model = [2, 0, 0, 0, 0, 0.5, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];
const info = norma.matrixInfo(model);
console.log(`${info.kind}: taken for its own normal matrix it errs by up to ${info.worstErrorDeg.toFixed(2)} degrees`);
show("through the normal matrix", norma.transformNormals(norma.normalMatrix(model), creased.normals));

try {
  norma.vertexNormals(positions, Uint16Array.of(0, 1, 6));
} catch (error) {
  console.log(error.message);
}
