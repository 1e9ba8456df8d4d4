/* node gltf-transform.mjs TOOL FILE..., beside an installed norma-mesh: transforms of a Document give what the tool gives for the file, and keep what is not theirs. */
import { spawnSync } from "node:child_process";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { basename, join } from "node:path";
import { Document, Logger, NodeIO } from "@gltf-transform/core";
import { ALL_EXTENSIONS, KHRMaterialsAnisotropy, KHRMaterialsClearcoat, KHRMaterialsVariants } from "@gltf-transform/extensions";
import { cloneDocument, tangents as theirTangents, unweld } from "@gltf-transform/functions";
import { generateTangents } from "mikktspace";
import { check as checkTransform, normals, tangents } from "norma-mesh/gltf-transform";
import { asNpx, attempt, check, finish } from "./tap.mjs";
import { sphere } from "./shapes.mjs";

const [tool, ...files] = process.argv.slice(2), scratch = mkdtempSync(join(tmpdir(), "norma-gltf-"));
const io = new NodeIO().setLogger(new Logger(Logger.Verbosity.SILENT)).registerExtensions(ALL_EXTENSIONS);
const primitivesOf = (document) => document.getRoot().listMeshes().flatMap((mesh) => mesh.listPrimitives());
const cornersOf = (primitive) => primitive.getIndices()?.getArray() ?? Uint32Array.from({ length: primitive.getAttribute("POSITION").getCount() }, (_, i) => i);

/* The values of corners, floats. */
function ofCorners(primitive, accessor) {
  const size = accessor.getElementSize(), corners = cornersOf(primitive), values = new Float32Array(size * corners.length), element = [];
  corners.forEach((vertex, i) => values.set(accessor.getElement(vertex, element), size * i));
  return values;
}
const largest = (a, b) => (a.length === b.length ? a.reduce((worst, x, i) => Math.max(worst, Math.abs(x - b[i])), 0) : Infinity);

/* Half a step of the encoding may be rounded up or down. */
const step = (accessor) => (accessor.getNormalized() ? 1.01 / (accessor.getArray() instanceof Int8Array ? 127 : 32767) : 0);

/* The same corners with the same values of each attribute: normals and tangents to within most. Strips and fans, which the tool keeps where it can, are compared below. */
function compare(a, b, most) {
  const [ours, theirs] = [a, b].map(primitivesOf);
  if (ours.length !== theirs.length) throw new Error(`${ours.length} and ${theirs.length} primitives`);
  ours.forEach((primitive, i) => {
    if (primitive.getMode() !== theirs[i].getMode()) return;
    for (const semantic of theirs[i].listSemantics()) {
      const accessor = primitive.getAttribute(semantic), distance = accessor ? largest(ofCorners(primitive, accessor), ofCorners(theirs[i], theirs[i].getAttribute(semantic))) : NaN;
      if (!(distance <= (/NORMAL|TANGENT/.test(semantic) ? most + step(accessor) : 0))) throw new Error(`primitive ${i}, ${semantic}: ${distance} apart`);
    }
    primitive.listTargets().forEach((target, j) => {
      const other = theirs[i].listTargets()[j];
      for (const semantic of other.listSemantics()) {
        const distance = largest(ofCorners(primitive, target.getAttribute(semantic)), ofCorners(theirs[i], other.getAttribute(semantic)));
        if (!(distance <= (/NORMAL|TANGENT/.test(semantic) ? 10 * most : 0))) throw new Error(`primitive ${i}, target ${j}, ${semantic}: ${distance} apart`);
      }
    });
  });
}

/* What has nothing to do with vertices. */
const rest = (document) => {
  const root = document.getRoot(), name = (property) => [property.getName(), property.getExtras()];
  return JSON.stringify([root.listMeshes().map((mesh) => [name(mesh), mesh.listPrimitives().map((primitive) => [name(primitive), primitive.getMaterial()?.getName()])]), root.listNodes().map((node) => [name(node), node.getMatrix(), node.listChildren().length, node.getSkin() !== null]),
    root.listMaterials().map(name), root.listTextures().map((texture) => [name(texture), texture.getImage()?.length]), root.listAnimations().map((animation) => [name(animation), animation.listChannels().length]), root.listExtensionsUsed().map((extension) => extension.extensionName)]);
};

/* A flat-shaded ball of several primitives (material slots), whose edges the tool sees across: each with positions of its own, as exporters write them; with the same positions and other indices; one of them twice, with
 * integers beside floats; with morph targets. */
async function slots(name, { shared = false, twice = false, integers = false, morphs = false } = {}) {
  const document = new Document().setLogger(new Logger(Logger.Verbosity.SILENT)), buffer = document.createBuffer(), { positions, indices } = sphere(12, 8), add = (type, array) => document.createAccessor().setType(type).setArray(array).setBuffer(buffer);
  const count = 3, own = Array.from({ length: count }, () => []), flat = Float32Array.from(Array.from(indices).flatMap((i) => Array.from(positions.subarray(3 * i, 3 * i + 3), (x) => Math.round(x * 100))));
  for (let t = 0; t < indices.length / 3; t++) own[(t >> 1) % count].push(3 * t, 3 * t + 1, 3 * t + 2);
  const all = add("VEC3", flat), ids = add("SCALAR", Uint16Array.from({ length: flat.length / 3 }, (_, i) => i)), mesh = document.createMesh("ball"), up = (array) => array.map((x, i) => (i % 3 === 2 && x > 0 ? x : 0));
  own.forEach((corners, i) => {
    const part = Float32Array.from(corners.flatMap((c) => Array.from(flat.subarray(3 * c, 3 * c + 3)))), primitive = document.createPrimitive().setMaterial(document.createMaterial(`slot ${i}`));
    if (shared) primitive.setAttribute("POSITION", all).setAttribute("_IDS", ids).setIndices(add("SCALAR", Uint16Array.from(corners)));
    else primitive.setAttribute("POSITION", add("VEC3", integers && i === 1 ? Int8Array.from(part) : part)).setIndices(i === 2 ? null : add("SCALAR", Uint16Array.from(corners, (_, k) => k)));
    if (morphs) primitive.addTarget(document.createPrimitiveTarget("up").setAttribute("POSITION", add("VEC3", up(part))).setAttribute("NORMAL", add("VEC3", new Float32Array(part.length))));
    mesh.addPrimitive(primitive);
    if (twice && i === 1) mesh.addPrimitive(primitive.clone());
  });
  document.createScene().addChild(document.createNode().setMesh(mesh));
  const path = join(scratch, `${name}.gltf`);
  await io.write(path, document);
  return path;
}
const balls = [await slots("slots"), await slots("shared-slots", { shared: true }), await slots("odd-slots", { twice: true, integers: true }), await slots("morphed-slots", { morphs: true }), await slots("shared-twice", { shared: true, twice: true })];

for (const file of [...files, ...balls]) {
  const input = join(scratch, basename(file).replace(/gltf$/, "glb")), output = join(scratch, `out-${basename(input)}`);
  writeFileSync(input, await io.writeBinary(await io.read(file)));
  const idle = (document) => document.getRoot().listAccessors().filter((accessor) => accessor.listParents().length === 1).length;
  for (const [name, words, transform] of [
    ["normals({ crease: 60 })", [], normals({ crease: 60, overwrite: true })], ["normals({ crease: 25, weight: \"area\" })", ["--crease", "25", "--weight", "area"], normals({ crease: 25, weight: "area", overwrite: true })], ["normals({ crease: 180 })", ["--crease", "180"], normals({ crease: 180, overwrite: true })],
  ]) await attempt(`${basename(file)}: ${name} gives what norma compute ${words.join(" ")} gives`, async () => {
    const document = await io.read(file), before = rest(document), unused = idle(document);
    const run = spawnSync(tool, ["compute", input, "-o", output, ...words, "--quiet"], { encoding: "utf8" });
    if (run.status !== 0) throw new Error(run.stderr);
    await document.transform(transform);
    compare(await io.readBinary(await io.writeBinary(document)), await io.read(output), 1e-6);
    if (rest(document) !== before) throw new Error("something else changed");
    if (idle(document) > unused) throw new Error(`${idle(document)} accessors that nothing uses`);
  });
}

/* ---- tangents, beside glTF-Transform with MikkTSpace: a sphere with a normal map, its texture mirrored on one half */
await attempt("tangents() gives what glTF-Transform and MikkTSpace give", async () => {
  const document = new Document().setLogger(new Logger(Logger.Verbosity.SILENT)), buffer = document.createBuffer(), { positions, indices } = sphere(24, 12);
  const add = (type, array) => document.createAccessor().setType(type).setArray(array).setBuffer(buffer), texcoords = Float32Array.from({ length: (2 * positions.length) / 3 }, (_, i) => (i % 2 ? positions[3 * (i >> 1) + 1] : Math.abs(positions[3 * (i >> 1)])));
  const map = document.createMaterial().setNormalTexture(document.createTexture()), primitive = document.createPrimitive().setMaterial(map).setIndices(add("SCALAR", indices));
  primitive.setAttribute("POSITION", add("VEC3", positions)).setAttribute("NORMAL", add("VEC3", positions.slice())).setAttribute("TEXCOORD_0", add("VEC2", new Float32Array(texcoords.length))).setAttribute("TEXCOORD_1", add("VEC2", texcoords));
  map.getNormalTextureInfo().setTexCoord(1);
  document.createMesh().addPrimitive(primitive);
  const theirs = await cloneDocument(document).transform(unweld(), theirTangents({ generateTangents, overwrite: true }));
  await document.transform(tangents());
  const [their] = primitivesOf(theirs), ours = ofCorners(primitive, primitive.getAttribute("TANGENT")), expected = ofCorners(their, their.getAttribute("TANGENT"));
  /* Where theirs are of no use, on faces without texture area, ours are another vector. */
  const isUseful = (corner) => Math.abs([0, 1, 2].reduce((sum, k) => sum + expected[4 * corner + k] * positions[3 * indices[corner] + k], 0)) < 1e-3 && Math.hypot(...expected.subarray(4 * corner, 4 * corner + 3)) > 0.5;
  let compared = 0;
  for (let corner = 0; corner < indices.length; corner++) if (isUseful(corner) && ++compared) for (let k = 0; k < 4; k++) if (expected[4 * corner + k] !== ours[4 * corner + k]) throw new Error(`corner ${corner}: ${ours.subarray(4 * corner, 4 * corner + 4)} and ${expected.subarray(4 * corner, 4 * corner + 4)}`);
  if (compared < 0.9 * indices.length) throw new Error(`only ${compared} corners compared`);
  if (!(primitive.getAttribute("POSITION").getCount() < indices.length / 2)) throw new Error("more vertices than needed");
});

/* ---- sharing, names and extras: a box that two primitives, two meshes and a morph target share */
function made() {
  const document = new Document().setLogger(new Logger(Logger.Verbosity.SILENT)), buffer = document.createBuffer(), add = (name, type, array) => document.createAccessor(name).setType(type).setArray(array).setBuffer(buffer).setExtras({ from: name });
  const box = Float32Array.from([0, 1, 2, 3, 4, 5, 6, 7].flatMap((i) => [i & 1, (i >> 1) & 1, i >> 2])), triangles = Uint16Array.of(0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5);
  const position = add("place", "VEC3", box), ids = add("ids", "SCALAR", Uint8Array.of(0, 1, 2, 3, 4, 5, 6, 7)), indices = add("faces", "SCALAR", triangles), half = add("half", "SCALAR", triangles.slice(0, 18)), material = document.createMaterial("red").setExtras({ shiny: 1 });
  const target = document.createPrimitiveTarget("tall").setAttribute("POSITION", add("up", "VEC3", box.map((x, i) => (i % 3 === 2 ? x : 0)))).setAttribute("NORMAL", add("turn", "VEC3", new Float32Array(24)));
  const primitive = (use, withTarget) => { const p = document.createPrimitive().setAttribute("POSITION", position).setAttribute("_IDS", ids).setIndices(use).setMaterial(material).setExtras({ part: 1 }); return withTarget ? p.addTarget(target) : p; };
  const mesh = document.createMesh("box").addPrimitive(primitive(indices, true)).addPrimitive(primitive(indices, true)).addPrimitive(primitive(half, true)).setExtras({ a: [1] }), other = document.createMesh("again").addPrimitive(primitive(indices, false));
  document.createScene().addChild(document.createNode("node").setMesh(mesh)).addChild(document.createNode("other").setMesh(other));
  return document;
}
await attempt("what primitives share, they share afterwards", async () => {
  const document = made();
  await document.transform(normals());
  const [a, b, c, d] = primitivesOf(document);
  for (const semantic of ["POSITION", "NORMAL", "_IDS"]) for (const other of [b, c, d]) if (a.getAttribute(semantic) !== other.getAttribute(semantic)) throw new Error(`${semantic} is not shared any more`);
  if (a.getIndices() !== b.getIndices() || a.getIndices() !== d.getIndices() || a.getIndices() === c.getIndices()) throw new Error("indices");
  if (a.getAttribute("POSITION").getCount() !== 24) throw new Error(`${a.getAttribute("POSITION").getCount()} vertices`);
  for (const primitive of [a, b, c]) for (const target of primitive.listTargets()) for (const semantic of target.listSemantics()) if (target.getAttribute(semantic).getCount() !== 24) throw new Error(`a target with ${target.getAttribute(semantic).getCount()} vertices`);
  for (const [accessor, name] of [[a.getAttribute("POSITION"), "place"], [a.getAttribute("_IDS"), "ids"], [a.getIndices(), "faces"], [a.listTargets()[0].getAttribute("POSITION"), "up"], [a.listTargets()[0].getAttribute("NORMAL"), "turn"]])
    if (accessor.getName() !== name || accessor.getExtras().from !== name) throw new Error(`${name}: its name or extras`);
  if (a.listTargets()[0] !== b.listTargets()[0] || a.listTargets()[0] !== c.listTargets()[0] || a.listTargets()[0].getName() !== "tall") throw new Error("targets");
  for (const primitive of [a, c]) {
    const ids = primitive.getAttribute("_IDS").getArray(), place = primitive.getAttribute("POSITION").getArray(), normal = primitive.getAttribute("NORMAL").getArray();
    ids.forEach((id, i) => { if (id !== place[3 * i] + 2 * place[3 * i + 1] + 4 * place[3 * i + 2]) throw new Error(`vertex ${i} took the values of another`); });
    cornersOf(primitive).forEach((vertex) => { if ([0, 1, 2].filter((k) => Math.abs(normal[3 * vertex + k]) === 1).length !== 1) throw new Error("a normal of no face"); });
  }
  if (document.getRoot().listAccessors().some((accessor) => accessor.listParents().length === 1)) throw new Error("accessors that nothing uses");
});
await attempt("strips and fans become triangles that face the same way", async () => {
  for (const [mode, array] of [[5, Uint16Array.of(0, 1, 2, 3)], [6, Uint16Array.of(0, 1, 3, 2)]]) {
    const document = new Document(), buffer = document.createBuffer(), primitive = document.createPrimitive().setMode(mode).setIndices(document.createAccessor().setType("SCALAR").setArray(array).setBuffer(buffer))
      .setAttribute("POSITION", document.createAccessor().setType("VEC3").setArray(Float32Array.of(0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0)).setBuffer(buffer));
    document.createMesh().addPrimitive(primitive);
    await document.transform(normals());
    if (primitive.getMode() !== 4 || primitive.getIndices().getCount() !== 6 || Array.from(primitive.getAttribute("NORMAL").getArray()).join() !== "0,0,1,0,0,1,0,0,1,0,0,1") throw new Error(`mode ${mode}: ${primitive.getAttribute("NORMAL").getArray()}`);
  }
});
await attempt("without overwrite normals() keeps what is there, and with it replaces it", async () => {
  const document = made(), [first] = primitivesOf(document), kept = document.createAccessor().setType("VEC3").setArray(new Float32Array(24).fill(1)).setBuffer(document.getRoot().listBuffers()[0]);
  first.setAttribute("NORMAL", kept);
  await document.transform(normals());
  if (first.getAttribute("NORMAL") !== kept || !primitivesOf(document)[1].getAttribute("NORMAL")) throw new Error("changed");
  await document.transform(normals({ overwrite: true }));
  if (primitivesOf(document).some((primitive) => primitive.getAttribute("NORMAL").getArray().every((x) => x === 1))) throw new Error("kept");
});
await attempt("normals() says that it did nothing where all primitives have normals", async () => {
  const document = made(), lines = [];
  await document.transform(normals());
  document.setLogger({ debug() {}, info() {}, warn: (line) => lines.push(line), error() {} });
  await document.transform(normals());
  await document.transform(normals({ overwrite: true }));
  if (lines.length !== 1 || !lines[0].includes("overwrite: true")) throw new Error(lines.join("\n"));
});

/* ---- which primitives tangents() fills: a plain, a mapped, a coated and a streaked material, and one of a variant; the mapped one with a morph target that turns its normals, at w 1 */
function materials() {
  const document = new Document().setLogger(new Logger(Logger.Verbosity.SILENT)), buffer = document.createBuffer(), mesh = document.createMesh(), { positions, indices } = sphere(24, 12);
  const add = (type, array) => document.createAccessor().setType(type).setArray(array).setBuffer(buffer), texture = document.createTexture(), [coated, streaked, varied] = [KHRMaterialsClearcoat, KHRMaterialsAnisotropy, KHRMaterialsVariants].map((extension) => document.createExtension(extension));
  const plain = document.createMaterial("plain"), mapped = document.createMaterial("mapped").setNormalTexture(texture), texcoords = Float32Array.from({ length: (2 * positions.length) / 3 }, (_, i) => positions[3 * (i >> 1) + (i % 2)]);
  const all = [plain, mapped, document.createMaterial("coated").setExtension("KHR_materials_clearcoat", coated.createClearcoat().setClearcoatNormalTexture(texture)), document.createMaterial("streaked").setExtension("KHR_materials_anisotropy", streaked.createAnisotropy().setAnisotropyStrength(1)), plain, null];
  const made = all.map((material) => document.createPrimitive().setMaterial(material).setIndices(add("SCALAR", indices)).setAttribute("POSITION", add("VEC3", positions.slice())).setAttribute("NORMAL", add("VEC3", positions.slice())).setAttribute("TEXCOORD_0", add("VEC2", texcoords.slice())));
  made[4].setExtension("KHR_materials_variants", varied.createMappingList().addMapping(varied.createMapping().setMaterial(mapped).addVariant(varied.createVariant("worn"))));
  made[1].addTarget(document.createPrimitiveTarget().setAttribute("POSITION", add("VEC3", positions.map((x, i) => (i % 3 === 0 ? x : 0)))).setAttribute("NORMAL", add("VEC3", positions.map((x, i) => (i % 3 === 0 ? -x / 4 : 0)))));
  for (const primitive of made) mesh.addPrimitive(primitive);
  return { document, filled: () => made.map((primitive) => Number(primitive.getAttribute("TANGENT") !== null)).join(""), delta: () => made[1].listTargets()[0].getAttribute("TANGENT"), size: async () => (await io.writeBinary(document)).length };
}
await attempt("tangents() fills primitives with a normal map, and no targets; all and morphTargets fill the others too", async () => {
  const [few, all, targets] = [materials(), materials(), materials()], before = await few.size();
  await few.document.transform(tangents());
  await all.document.transform(tangents({ all: true }));
  await targets.document.transform(tangents({ morphTargets: true }));
  if (few.filled() !== "011110" || few.delta()) throw new Error(few.filled());
  if (all.filled() !== "111111" || all.delta()) throw new Error(all.filled());
  if (targets.filled() !== "011110" || !targets.delta()?.getArray().some((x) => x !== 0)) throw new Error("no differences");
  const [a, b, c] = await Promise.all([few, all, targets].map(({ size }) => size()));
  if (!(before < a && a < b && a < c)) throw new Error(`${before}, ${a}, ${b}, ${c} bytes`);
});
await attempt("differences of tangents that are there follow new tangents, and are kept with them", async () => {
  const { document, delta } = materials();
  await document.transform(tangents({ morphTargets: true }));
  const expected = delta().getArray().slice();
  delta().setArray(new Float32Array(expected.length));
  await document.transform(tangents());
  if (delta().getArray().some((x) => x !== 0)) throw new Error("not kept");
  await document.transform(tangents({ overwrite: true }));
  if (delta().getArray().length !== expected.length || delta().getArray().some((x, i) => x !== expected[i])) throw new Error("not those before");
});

/* ---- check */
await attempt("check logs errors and warnings, reports all, and changes nothing", async () => {
  const lines = [], document = made(), logger = { debug() {}, info() {}, warn: (line) => lines.push(`warning ${line}`), error: (line) => lines.push(`error ${line}`) };
  primitivesOf(document)[0].setAttribute("NORMAL", document.createAccessor().setType("VEC3").setArray(new Float32Array(24).fill(NaN)).setBuffer(document.getRoot().listBuffers()[0]));
  document.setLogger(logger);
  const before = JSON.stringify(await io.writeJSON(document, { format: "GLTF" }));
  let report = null;
  await document.transform(checkTransform({ onReport: (given) => { report = given; } }));
  const serious = report.files[0].findings.filter(({ severity }) => severity !== "info");
  if (!serious.some(({ rule, where }) => rule === "N101" && where === "/meshes/0/primitives/0")) throw new Error(JSON.stringify(report));
  const told = lines.filter((line) => / N\d{3} /.test(line));
  if (told.length !== serious.length || !told.some((line) => line.startsWith("error N101 /meshes/0/primitives/0: "))) throw new Error(lines.join("\n"));
  if (JSON.stringify(await io.writeJSON(document, { format: "GLTF" })) !== before) throw new Error("the document changed");
});
for (const file of files)
  await attempt(`${basename(file)}: check finds what norma check finds`, async () => {
    const document = await io.read(file), bytes = await io.writeBinary(await io.read(file)), path = join(scratch, "checked.glb");
    writeFileSync(path, bytes);
    const { files: [told] } = JSON.parse(spawnSync(tool, ["check", "--format", "json", path], { encoding: "utf8", maxBuffer: 1 << 28 }).stdout);
    let report = null;
    await document.transform(checkTransform({ onReport: (given) => { report = given; } }));
    // WebAssembly decodes no pictures and says so (N002); the tool looks into them (N811, N812).
    const ofPictures = ({ rule, where }) => rule === "N811" || rule === "N812" || (rule === "N002" && where.startsWith("/images/"));
    const short = (findings) => JSON.stringify(findings.filter((finding) => !ofPictures(finding)).map(({ rule, where, count, message }) => [rule, where, count, message]));
    asNpx(told);
    if (short(report.files[0].findings) !== short(told.findings)) throw new Error(`${short(report.files[0].findings)}\n${short(told.findings)}`);
  });

for (const [name, message, make] of [["an option that does not exist", /^options: angle/, () => normals({ angle: 60 })], ["a crease out of range", /^crease: 200/, () => normals({ crease: 200 })], ["a mode that does not exist", /^mode: "fast"/, () => tangents({ mode: "fast" })],
  ["a set that is none", /^texcoord: -1/, () => tangents({ texcoord: -1 })], ["an onReport that is no function", /^onReport: true/, () => checkTransform({ onReport: true })], ["an unknown profile", /^profile: "film"/, () => checkTransform({ profile: "film" })]]) {
  let text = "nothing";
  try { make(); } catch (error) { text = error.message; }
  check(`${name}: an error that begins with it`, message.test(text), text);
}
check("transforms have names", normals().name === "normals" && tangents().name === "tangents" && checkTransform().name === "check");
rmSync(scratch, { recursive: true });
finish();
