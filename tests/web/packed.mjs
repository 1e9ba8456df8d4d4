/* node packed.mjs TOOL FILE..., beside an installed norma-mesh: glTF files that meshoptimizer and Draco compressed, whole, cut short, damaged and with numbers that lie, are checked as the tool
 * checks them; draco.wasm is loaded with the first Draco stream, not before. FILE: packed GLBs, and streams that the fuzzer of Draco found; other files are packed here. */
import { spawnSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { basename, join } from "node:path";
import { isDeepStrictEqual } from "node:util";
import { Document, Logger, NodeIO } from "@gltf-transform/core";
import { ALL_EXTENSIONS, EXTMeshoptCompression } from "@gltf-transform/extensions";
import { draco, meshopt } from "@gltf-transform/functions";
import { MeshoptEncoder } from "meshoptimizer";
import { load, loadWorker } from "norma-mesh";
import { load as loadInline } from "norma-mesh/inline";
import { asNpx, attempt, check, finish } from "./tap.mjs";
import { sphere } from "./shapes.mjs";

const [tool, ...given] = process.argv.slice(2), scratch = mkdtempSync(join(tmpdir(), "norma-packed-"));
const draco3d = createRequire(import.meta.url)("draco3dgltf"), quiet = new Logger(Logger.Verbosity.SILENT);
await MeshoptEncoder.ready;
const io = new NodeIO().setLogger(quiet).registerExtensions(ALL_EXTENSIONS).registerDependencies({ "draco3d.encoder": await draco3d.createEncoderModule(), "meshopt.encoder": MeshoptEncoder });

/* A sphere with normals that are wrong in places, texture coordinates and tangents. */
function makeDocument() {
  const { positions, indices } = sphere(12, 9), document = new Document().setLogger(quiet), buffer = document.createBuffer(), count = positions.length / 3;
  const accessor = (type, array) => document.createAccessor().setType(type).setBuffer(buffer).setArray(array);
  const normals = Float32Array.from(positions, (x, i) => (i < 30 ? -x : x)), texcoords = Float32Array.from({ length: 2 * count }, (_, i) => (i % 2 ? positions[3 * (i >> 1) + 1] : i / count / 2));
  const tangents = Float32Array.from({ length: 4 * count }, (_, i) => (i % 4 === 0 || i % 4 === 3 ? 1 : 0));
  const primitive = document.createPrimitive().setIndices(accessor("SCALAR", Uint16Array.from(indices)));
  for (const [name, type, array] of [["POSITION", "VEC3", Float32Array.from(positions)], ["NORMAL", "VEC3", normals], ["TEXCOORD_0", "VEC2", texcoords], ["TANGENT", "VEC4", tangents]]) primitive.setAttribute(name, accessor(type, array));
  document.createScene().addChild(document.createNode().setMesh(document.createMesh("ball").addPrimitive(primitive)));
  return document;
}

async function pack(...transforms) {
  const document = makeDocument();
  await document.transform(...transforms);
  return Buffer.from(await io.writeBinary(document));
}
const exponential = (document) => { document.createExtension(EXTMeshoptCompression).setRequired(true).setEncoderOptions({ method: EXTMeshoptCompression.EncoderMethod.FILTER }); };
const packed = {
  edgebreaker: await pack(draco({ method: "edgebreaker" })), sequential: await pack(draco({ method: "sequential" })),
  "meshopt-medium": await pack(meshopt({ encoder: MeshoptEncoder, level: "medium" })), "meshopt-high": await pack(meshopt({ encoder: MeshoptEncoder, level: "high" })), "meshopt-floats": await pack(exponential),
};
packed["meshopt-khr"] = Buffer.from(packed["meshopt-high"].toString("latin1").replaceAll("EXT_meshopt_compression", "KHR_meshopt_compression"), "latin1");
for (const path of given.filter((name) => name.endsWith(".glb"))) packed[basename(path)] = readFileSync(path);

/* ---- damage */
const split = (glb) => { const length = glb.readUInt32LE(12); return { json: JSON.parse(glb.toString("utf8", 20, 20 + length)), body: Buffer.from(glb.subarray(28 + length)) }; };
function join2({ json, body }) {
  const text = Buffer.from(JSON.stringify(json)), head = Buffer.alloc(20), next = Buffer.alloc(8), pad = Buffer.alloc((4 - (text.length % 4)) % 4, 32);
  [0x46546c67, 2, 28 + text.length + pad.length + body.length, text.length + pad.length, 0x4e4f534a].forEach((word, i) => head.writeUInt32LE(word, 4 * i));
  [body.length, 0x004e4942].forEach((word, i) => next.writeUInt32LE(word, 4 * i));
  return Buffer.concat([head, text, pad, next, body]);
}
/* The extensions' objects, and where their bytes are: { byteOffset, byteLength }. */
function streamsOf(json) {
  const meshopts = (json.bufferViews ?? []).map((view) => view.extensions?.EXT_meshopt_compression ?? view.extensions?.KHR_meshopt_compression).filter(Boolean);
  const dracos = json.meshes.flatMap(({ primitives }) => primitives).map((primitive) => primitive.extensions?.KHR_draco_mesh_compression).filter(Boolean);
  return [...meshopts, ...dracos.map(({ bufferView }) => json.bufferViews[bufferView])];
}
let state = 12345;
const random = (below) => { state = (Math.imul(state, 1664525) + 1013904223) >>> 0; return Math.floor((state / 2 ** 32) * below); };
const pick = (list) => list[random(list.length)];
const DAMAGE = {
  cut: ({ json }) => { const stream = pick(streamsOf(json)); stream.byteLength = random(stream.byteLength) + (random(4) ? 0 : stream.byteLength); },
  bit: ({ json, body }) => { const { byteOffset = 0, byteLength } = pick(streamsOf(json)); body[byteOffset + random(byteLength)] ^= 1 << random(8); },
  bytes: ({ json, body }) => { const { byteOffset = 0, byteLength } = pick(streamsOf(json)); for (let i = 0; i < 6; i++) body[byteOffset + random(Math.min(byteLength, i < 3 ? 40 : byteLength))] = random(256); },
  count: ({ json }) => { const accessor = pick(json.accessors); accessor.count = pick([accessor.count - 1, accessor.count + 3, 3 * accessor.count, 1000000, 1000000000]); },
  number: ({ json }) => {
    const stream = pick(streamsOf(json)), names = Object.keys(stream).filter((name) => typeof stream[name] === "number");
    const name = pick(names);
    stream[name] = pick([0, 1, stream[name] + 1, stream[name] + 4, 2 * stream[name], 1000000000]);
  },
  type: ({ json }) => { const accessor = pick(json.accessors); accessor.componentType = pick([5120, 5121, 5122, 5123, 5125, 5126]); },
};
function damaged(glb, kind) {
  const parts = split(glb);
  DAMAGE[kind](parts);
  return join2(parts);
}
/* Around a stream of the fuzzer's, whose first three bytes count attributes and vertices: one that declares more than it holds makes the decoder trap. */
function wrap(bytes, triangles) {
  const stream = bytes.subarray(3), accessor = (type, count, componentType) => ({ type, count, componentType });
  return join2({
    json: {
      asset: { version: "2.0" }, extensionsUsed: ["KHR_draco_mesh_compression"], extensionsRequired: ["KHR_draco_mesh_compression"], nodes: [{ mesh: 0 }],
      meshes: [{ primitives: [{ indices: 0, attributes: { POSITION: 1 }, extensions: { KHR_draco_mesh_compression: { bufferView: 0, attributes: { POSITION: 0 } } } }] }],
      accessors: [accessor("SCALAR", 3 * triangles, 5123), accessor("VEC3", bytes.readUInt16LE(1), 5126)], bufferViews: [{ buffer: 0, byteLength: stream.length }], buffers: [{ byteLength: stream.length }],
    },
    body: Buffer.concat([stream, Buffer.alloc((4 - (stream.length % 4)) % 4)]),
  });
}
const EACH = 12, files = given.filter((name) => !name.endsWith(".glb")).map((path) => [`${basename(path)}.glb`, wrap(readFileSync(path), 8)]);
for (const [name, glb] of Object.entries(packed)) {
  files.push([`${name}.glb`, glb]);
  if (glb.readUInt32LE(0) === 0x46546c67) for (const kind of Object.keys(DAMAGE)) for (let i = 0; i < EACH; i++) files.push([`${name}-${kind}-${i}.glb`, damaged(glb, kind)]);
}

/* ---- the tool's report of each, and ours */
const paths = files.map(([name, bytes]) => { const path = join(scratch, name); writeFileSync(path, bytes); return path; });
const run = spawnSync(tool, ["check", "--format", "json", ...paths], { encoding: "utf8", maxBuffer: 1 << 28 });
const expected = new Map(JSON.parse(run.stdout).files.map((file) => [file.path, file]));
const norma = await load(), differ = [], seen = { checked: 0, partly: 0, unreadable: 0 };
for (const path of paths) {
  const { files: [report] } = JSON.parse(JSON.stringify(await norma.check(readFileSync(path), { name: path })));
  seen[report.status]++;
  asNpx(expected.get(path));
  if (!isDeepStrictEqual(report, expected.get(path))) differ.push(`${path}:\n${JSON.stringify(report).slice(0, 1500)}\n${JSON.stringify(expected.get(path)).slice(0, 1500)}`);
}
check(`packed files, whole and damaged: ${JSON.stringify(seen)}, as the tool reports them`, differ.length === 0 && Object.values(seen).every((count) => count > 5), `${differ.length} differ\n${differ.slice(0, 5).join("\n")}`);
const whole = Object.keys(packed).map((name) => expected.get(join(scratch, `${name}.glb`)));
check("whole files are read", whole.every(({ status }) => status === "checked") && whole.slice(0, 6).every(({ findings }) => findings.some(({ rule }) => rule === "N202")), JSON.stringify(whole.map(({ path, status, findings }) => [path, status, findings.map(({ rule }) => rule).join()])));

/* ---- loading */
const bytes = packed.edgebreaker, name = "ball.glb", rules = ({ files: [{ findings }] }) => findings.map(({ rule }) => rule).join(), wanted = rules(await norma.check(bytes, { name }));
await attempt("draco.wasm is loaded with the first Draco stream, not before", async () => {
  const nowhere = await load(null, { draco: "/nowhere/draco.wasm" });
  await nowhere.check(packed["meshopt-high"], { name });
  const failed = await nowhere.check(bytes, { name }).then(() => null, (error) => error);
  if (!/draco/.test(failed?.message)) throw new Error(`it says ${failed?.message}`);
  const file = readFileSync(new URL("./draco.wasm", import.meta.resolve("norma-mesh")));
  for (const draco of [file, new WebAssembly.Module(file), import.meta.resolve("norma-mesh/draco.wasm")]) if (rules(await (await load(null, { draco })).check(bytes, { name })) !== wanted) throw new Error(`other findings with ${draco}`);
  const wrong = await (await load(null, { draco: Uint8Array.of(1, 2, 3, 4) })).check(bytes, { name }).then(() => null, (error) => error);
  if (!wrong?.message.startsWith("draco: ")) throw new Error(`of bytes that are no module it says ${wrong?.message}`);
});
await attempt("in a worker and with norma-mesh/inline, the same", async () => {
  const worker = await loadWorker();
  if (rules(await worker.check(bytes, { name })) !== wanted) throw new Error("the worker finds something else");
  await worker.terminate();
  const sent = await loadWorker(null, { draco: async () => readFileSync(new URL("./draco.wasm", import.meta.resolve("norma-mesh"))) });
  if (rules(await sent.check(bytes, { name })) !== wanted) throw new Error("the worker to which the module is sent finds something else");
  await sent.terminate();
  const lost = await loadWorker(null, { draco: async () => { throw new Error("lost on the way"); } }), failed = await lost.check(bytes, { name }).then(() => null, (error) => error);
  if (!/lost on the way/.test(failed?.message)) throw new Error(`of a module that is not sent it says ${failed?.message}`);
  await lost.terminate();
  if (rules(await (await loadInline()).check(bytes, { name })) !== wanted) throw new Error("norma-mesh/inline finds something else");
});
rmSync(scratch, { recursive: true });
finish();
