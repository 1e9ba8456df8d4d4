/* Uses of norma-mesh/three and norma-mesh/gltf-transform, checked by tsc --strict; what must not pass is said so. */
import { Document } from "@gltf-transform/core";
import { BoxGeometry, type BufferGeometry } from "three";
import type { CheckReport, Report } from "norma-mesh";
import { check, normals, tangents } from "norma-mesh/gltf-transform";
import { computeNormals, computeTangents, load, planFor, toCreased, type GeometryPlan } from "norma-mesh/three";

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
