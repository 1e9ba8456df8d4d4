/* Uses of the entries for three.js, React, Babylon.js, PlayCanvas and glTF-Transform, checked by tsc --strict; what must not pass is said so. */
import { VertexData } from "@babylonjs/core/Meshes/mesh.vertexData.js";
import { Document } from "@gltf-transform/core";
import type { Mesh } from "playcanvas";
import { BoxGeometry, type BufferGeometry } from "three";
import type { CheckReport, NormaWorker, Report } from "norma-mesh";
import * as babylon from "norma-mesh/babylon";
import { check, normals, tangents } from "norma-mesh/gltf-transform";
import * as playcanvas from "norma-mesh/playcanvas";
import { useCreasedGeometry } from "norma-mesh/react";
import { computeNormals, computeTangents, load, planFor, planForWorker, toCreased, type GeometryPlan, type WorkerGeometryPlan } from "norma-mesh/three";

export async function uses(): Promise<void> {
  await load();
  const box: BoxGeometry = computeNormals(new BoxGeometry(), { weight: "area", weld: "none" });
  const report: Report = computeNormals(box, { report: true }).report;
  const creased: BufferGeometry = toCreased(box, { crease: 30 });
  const tangent: BufferGeometry = computeTangents(creased, { mode: "steady", negateSign: false, texcoord: 1 });
  const plan: GeometryPlan = planFor(tangent, { crease: 60 });
  plan.update({ moved: [1] });
  const cancelled: number = plan.update({ report: true }).cancelled + report.cancelled;
  plan.free();
  let found: CheckReport | undefined;
  await new Document().transform(normals({ crease: 30, overwrite: false }), tangents({ mode: "mikk", texcoord: 0, all: true, morphTargets: false, overwrite: true }), check({ profile: "render", onReport: (given) => { found = given; } }));
  console.log(cancelled, found);

  // @ts-expect-error radians are not taken
  toCreased(box, Math.PI / 3);
  // @ts-expect-error a misspelt option
  computeNormals(box, { weights: "area" });
  // @ts-expect-error there are four channels
  computeTangents(box, { texcoord: 4 });
  // @ts-expect-error a report is not returned unless it is asked for
  plan.update().cancelled;
  // @ts-expect-error an unknown mode
  tangents({ mode: "fast" });
}

export async function moving(worker: NormaWorker, geometry: BufferGeometry): Promise<number> {
  const plan: WorkerGeometryPlan = await planForWorker(worker, geometry, { crease: 60 });
  await plan.update({ moved: [1] });
  // @ts-expect-error a report is not returned unless it is asked for
  (await plan.update()).cancelled;
  return (await plan.update({ report: true })).cancelled;
}

export function engines(data: VertexData, mesh: Mesh, geometry: BufferGeometry): void {
  const made: VertexData = babylon.toCreased(babylon.computeNormals(data, { weld: 1e-6, rightHanded: true }), { crease: 30 });
  babylon.computeTangents(made, { texcoord: 5, report: true }).report.degenerate satisfies number;
  const creased: Mesh = playcanvas.toCreased(playcanvas.computeNormals(mesh), { crease: 30, report: true }).mesh;
  playcanvas.computeTangents(creased, { texcoord: 7, negateSign: true });
  const used: BufferGeometry = useCreasedGeometry(geometry, { crease: 30, weight: "area" });
  // @ts-expect-error a hook gives no report
  useCreasedGeometry(used, { report: true });
  // @ts-expect-error Babylon.js alone has left-handed scenes
  playcanvas.toCreased(mesh, { rightHanded: true });
}
