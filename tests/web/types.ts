/* Uses of every call, checked by tsc --strict; what must not pass is said so. */
import { load, loadWorker, NormaError, type CheckReport, type MatrixInfo, type Norma, type NormaWorker, type Plan, type Report, type SplitMesh } from "norma-mesh";
import { load as loadInline } from "norma-mesh/inline";
import { loadSkin, type Skin, type Skins } from "norma-mesh/skin";
import { load as loadNormals, type Normals } from "norma-mesh/normals";
import { glsl, hlsl, wgsl } from "norma-mesh/shaders";

for (const text of [glsl, hlsl, wgsl]) text.includes("norma_normal_matrix") satisfies boolean;

export async function skinned(): Promise<Float32Array> {
  const skins: Skins = await loadSkin(), skin: Skin = { matrices: new Float32Array(16), joints: new Uint8Array(4), weights: new Float32Array(4) };
  const normals = skins.normals(skin, skins.positions(skin, new Float32Array(3)), { out: new Float32Array(3) });
  // @ts-expect-error: a blend that does not exist
  skins.normals({ ...skin, blend: "cubic" }, normals);
  return skins.tangents({ ...skin, influences: 4, blend: "dual-quaternion" }, new Float32Array(4), normals);
}

export async function small(): Promise<Float32Array> {
  const norma: Normals = await loadNormals(), normals = norma.vertexNormals(new Float32Array(9), null, { weight: "visible", fallback: "nearest" });
  // @ts-expect-error: a call of norma-mesh alone
  norma.plan(new Float32Array(9));
  return norma.tangents(new Float32Array(9), normals, new Float32Array(6), null, { mode: "steady" });
}

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
  const codes: Uint32Array = norma.encodeNormals(normals, { encoding: "oct12" });
  normals = norma.decodeNormals(codes, { encoding: "oct12", out: normals });
  const zeros: number = norma.encodeNormals(normals, { report: true }).report.cancelled + norma.encodingErrorDeg("10-10-10-2");
  const info: MatrixInfo = norma.matrixInfo(new Float32Array(16));
  const degrees: number = info.worstErrorDeg;
  const error: Error = new Error(String(degrees));
  if (error instanceof NormaError) error.result satisfies "argument" | "capacity" | "index" | "memory" | "overflow";

  const report: Report = norma.vertexNormals(positions, indices, { report: true }).report;
  normals = norma.vertexNormals({ array: new Float32Array(24), stride: 8, offset: 2 }, indices);
  const written = await norma.fix(new Uint8Array(4), { name: "a.glb", unsafe: true, select: ["N3"], files: { "a.bin": new ArrayBuffer(4) } }), errors: number = written.report.summary.errors, size: number = written.bytes.length + written.files["a.bin"]!.length + errors;
  const { summary } = await norma.compute(new ArrayBuffer(4), { name: "a.obj", crease: 30 + size, weight: "area", only: "missing" }), listed: object = { ...summary, ...(await norma.info(new ArrayBuffer(4), { name: "a.stl", deep: true })) };
  const tiles: number = ((await norma.info(new ArrayBuffer(4), { name: "a.cmpt" })).tiles ?? []).filter((tile) => tile["faces"] === 0).length;
  if (!listed || tiles) return;
  normals = norma.tangents(positions, normals, new Float32Array(6), indices, { mode: "steady", weight: "area" });
  const degenerate: number = report.degenerateFaces + norma.tangents(positions, normals, new Float32Array(6), { report: true }).report.degenerate;
  const found: CheckReport = await norma.check(new Uint8Array(8), { name: "chair.glb", profile: "render" });
  const rules: string[] = found.files.flatMap(({ findings }) => findings.map(({ rule }) => `${rule} ${degenerate}`));
  const inline: Norma = await loadInline();
  const worker: NormaWorker = await loadWorker();
  normals = await worker.vertexNormals(positions, indices, { weld: "none", transfer: true });
  const moving = await worker.plan(positions, indices);
  normals = await moving.update(positions, { out: normals });
  worker.terminate();
  console.log(rules, inline.version, zeros, await worker.encodeNormals(normals, { transfer: true }));

  // @ts-expect-error a view needs a stride
  norma.vertexNormals({ array: positions });
  // @ts-expect-error a report is asked for, so that the normals are a member of what is returned
  normals = norma.vertexNormals(positions, indices, { report: true });
  await norma.check(new Uint8Array(8), { profile: "print" });
  await norma.info((await norma.fix(new Uint8Array(8))).bytes);
  // @ts-expect-error a name is a word
  await norma.check(new Uint8Array(8), { name: 3 });
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
