/* node workers.mjs PACKAGE: the calls in a worker thread give what they give here; buffers are handed over or kept, as asked. */
import { pathToFileURL } from "node:url";
import { attempt, check, finish } from "./tap.mjs";
import { cube, sphere, waves } from "./shapes.mjs";

const { load, loadWorker, NormaError } = await import(pathToFileURL(`${process.argv[2]}/node.js`));
const norma = await load(), worker = await loadWorker();
const { positions, indices } = waves(40, 30), box = cube();
const same = (a, b) => a.length === b.length && a.every((x, i) => Object.is(x, b[i]));
const sameObjects = (a, b) => Object.keys(a).join() === Object.keys(b).join() && Object.entries(a).every(([name, value]) => (ArrayBuffer.isView(value) ? same(value, b[name]) : JSON.stringify(value) === JSON.stringify(b[name])));
const texcoords = Float32Array.from({ length: 2 * positions.length / 3 }, (_, i) => positions[3 * (i >> 1) + (i & 1)]), normals = norma.vertexNormals(positions, indices);
const model = [2, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];

for (const [name, call] of Object.entries({
  faceNormals: (n) => n.faceNormals(positions, indices), vertexNormals: (n) => n.vertexNormals(positions, indices, { weight: "area" }), cornerNormals: (n) => n.cornerNormals(positions, indices, { crease: 3 }),
  tangents: (n) => n.tangents(positions, normals, texcoords, indices), normalMatrix: (n) => n.normalMatrix(model), normalMatrices: (n) => n.normalMatrices([...model, ...model]),
  transformNormals: (n) => n.transformNormals([1, 0, 0, 0, 2, 0, 0, 0, 3], normals), encodeNormals: (n) => n.encodeNormals(normals), decodeNormals: (n) => n.decodeNormals(Uint32Array.of(5, 6, 7), { encoding: "oct8" }),
  encodingErrorDeg: async (n) => [await n.encodingErrorDeg("oct8")], "a view with a stride": (n) => n.faceNormals({ array: positions, stride: 6, count: 3 }),
})) await attempt(`${name} in a worker`, async () => { if (!same(await call(worker), await call(norma))) throw new Error("other numbers"); });
for (const [name, call] of Object.entries({ split: (n) => n.split(box.positions, box.indices, { report: true }), matrixInfo: (n) => n.matrixInfo(model), "a report": (n) => n.vertexNormals(positions, indices, { report: true }) }))
  await attempt(`${name} in a worker`, async () => { if (!sameObjects(await call(worker), call(norma))) throw new Error(JSON.stringify(await call(worker))); });
check("the worker has the version", worker.version === norma.version);

check("arrays stay here unless they are handed over", positions.length > 0 && indices.length > 0 && texcoords.length > 0);
const given = { positions: positions.slice(), indices: indices.slice() };
const handed = await worker.vertexNormals(given.positions, given.indices, { transfer: true });
check("transfer: true hands them over", given.positions.length === 0 && given.indices.length === 0 && same(handed, normals));
const out = new Float32Array(positions.length), returned = await worker.vertexNormals(positions, indices, { out });
check("out is handed over and comes back", out.length === 0 && same(returned, normals) && positions.length > 0);
const shared = new Float32Array(new SharedArrayBuffer(positions.byteLength));
shared.set(positions);
check("shared memory is neither copied nor handed over", same(await worker.vertexNormals(shared, indices.slice(), { transfer: true }), normals) && shared.length === positions.length);
const part = new Float32Array(3 + positions.length);
part.set(positions, 3);
check("of a larger array only the part that is meant goes there", same(await worker.vertexNormals(part.subarray(3), indices), normals));

const plan = await worker.plan(positions, indices), local = norma.plan(positions, indices), later = positions.map((x, i) => x * (1 + (i % 7) / 50));
check("a plan in a worker", plan.count === local.count && plan.bytes === local.bytes && same(await plan.update(later), local.update(later)));
const moved = [5, 6], before = await plan.update(positions), expected = local.update(later, { moved, out: local.update(positions) });
check("with what moved", same(await plan.update(later, { moved, out: before }), expected));
await plan.free();
const message = (promise) => promise.then(() => "no error", (error) => (error instanceof NormaError ? `${error.result}: ${error.message}` : `${error.name}: ${error.message}`));
check("a plan that was freed", (await message(plan.update(positions))) === "argument: plan: it has been freed");
check("errors come back as they are thrown", (await message(worker.vertexNormals(positions, Uint32Array.of(0, 1, 99999)))) === `index: indices: number 2 is 99999, but there are only ${positions.length / 3} positions`);
check("an option that does not exist", /^argument: options: speed is not an option/.test(await message(worker.vertexNormals(positions, indices, { speed: 1 }))));
check("a transfer that is no truth value", /^argument: transfer: yes/.test(await message(worker.vertexNormals(positions, indices, { transfer: "yes" }))));
await attempt("files in a worker", async () => {
  const bytes = new TextEncoder().encode("v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 -1\nf 1//1 2//1 3//1\n"), name = "back.obj";
  if (JSON.stringify(await worker.check(bytes, { name })) !== JSON.stringify(await norma.check(bytes, { name }))) throw new Error("another report");
  if (JSON.stringify(await worker.check(bytes.buffer.slice(0), { name })) !== JSON.stringify(await norma.check(bytes, { name }))) throw new Error("another report");
});
const round = sphere(64, 32), answers = await Promise.all(Array.from({ length: 20 }, (_, i) => worker.cornerNormals(round.positions, round.indices, { crease: i })));
check("twenty calls at once are answered each by its own", answers.every((answer, i) => same(answer, norma.cornerNormals(round.positions, round.indices, { crease: i }))));
const late = message(worker.cornerNormals(positions, indices));
worker.terminate();
check("what waits when the worker is ended is rejected, and so is what comes later", /^argument: terminate: the worker has been ended/.test(await late) && /ended/.test(await message(worker.faceNormals(positions))));
check("a worker that cannot load says why", /not a WebAssembly module/.test(await message(loadWorker(new Uint8Array(8)))));
finish();
