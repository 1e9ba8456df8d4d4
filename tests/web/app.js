/* What every bundle of the tests holds: each part of norma-mesh once. run() gives text, the same wherever it runs. */
import { BoxGeometry } from "three";
import packed from "./packed-file.js";
import { computeTangents, planFor, toCreased } from "norma-mesh/three";

const digits = (array) => Array.from(array, (x) => x.toFixed(5)).join(" ");

export async function run({ load, loadWorker }) {
  const norma = await load(), box = new BoxGeometry(1, 2, 3), { position, uv } = box.attributes, report = [];
  report.push(norma.version, digits(norma.vertexNormals(position.array, box.index.array)), digits(norma.tangents(position.array, box.attributes.normal.array, uv.array, box.index.array)));
  report.push(digits(computeTangents(toCreased(box, { crease: 30 })).attributes.tangent.array));
  planFor(box).update();
  report.push(digits(box.attributes.normal.array));
  const file = new TextEncoder().encode("v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 -1\nf 1//1 2//1 3//1\n"), rules = ({ files: [{ findings }] }) => findings.map(({ rule }) => rule).join();
  report.push(rules(await norma.check(file, { name: "back.obj" })));
  const draco = () => Uint8Array.from(atob(packed), (c) => c.charCodeAt(0)), judged = ({ files: [{ status, findings }] }) => [status, ...findings.map(({ rule, message }) => `${rule} ${message}`)].join();
  report.push(judged(await norma.check(draco(), { name: "packed.glb" })));
  const worker = await loadWorker();
  report.push(judged(await worker.check(draco(), { name: "packed.glb" })));
  report.push(digits(await worker.cornerNormals(position.array, box.index.array, { crease: 30 })), rules(await worker.check(file, { name: "back.obj" })));
  const text = ({ bytes }) => new TextDecoder().decode(bytes).replaceAll("\n", " ");
  report.push(text(await norma.compute(file, { name: "back.obj", smooth: true })), text(await worker.fix(file, { name: "back.obj", unsafe: true })), (await norma.info(draco(), { name: "packed.glb" })).vertices);
  worker.terminate();
  return report.join("\n");
}
