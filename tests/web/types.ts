/* Uses of every call, checked by tsc --strict; what must not pass is said so. */
import { load, NormaError, type MatrixInfo, type Norma, type Plan, type SplitMesh } from "norma";

export async function uses(): Promise<void> {
  const norma: Norma = await load();
  await load("norma.wasm");
  await load(new URL("https://example.org/norma.wasm"));
  await load(new Uint8Array(8));
  const positions = new Float32Array(9), indices = new Uint16Array(3);
  let normals: Float32Array = norma.vertexNormals(positions);
  normals = norma.vertexNormals(positions, indices, { weight: "angle-area", weld: 0.5, out: normals });
  normals = norma.faceNormals(positions, null, { out: normals });
  normals = norma.cornerNormals(positions, { crease: 30, weld: "none" });
  const split: SplitMesh = norma.split(positions, indices, { crease: 60 });
  normals = split.normals;
  const plan: Plan = norma.plan(positions, indices, { per: "corner", crease: 60 });
  normals = plan.update(positions, { moved: [1, 2], out: plan.normals });
  plan.free();
  normals = norma.normalMatrix([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1], { winding: "kept" });
  normals = norma.normalMatrices(new Float64Array(32));
  normals = norma.transformNormals(normals, new Int8Array(3));
  const info: MatrixInfo = norma.matrixInfo(new Float32Array(16));
  const degrees: number = info.worstErrorDeg;
  const error: Error = new Error(String(degrees));
  if (error instanceof NormaError) error.result satisfies "argument" | "capacity" | "index" | "memory" | "overflow";

  // @ts-expect-error an unknown weight
  norma.vertexNormals(positions, indices, { weight: "heavy" });
  // @ts-expect-error positions are a typed array
  norma.vertexNormals([0, 0, 0]);
  // @ts-expect-error a crease is a number
  norma.cornerNormals(positions, indices, { crease: "60" });
  // @ts-expect-error an output is of floats
  norma.faceNormals(positions, indices, { out: new Float64Array(3) });
  // @ts-expect-error a misspelt option
  norma.split(positions, indices, { creases: 60 });
  // @ts-expect-error indices have no sign
  norma.faceNormals(positions, new Int32Array(3));
}
