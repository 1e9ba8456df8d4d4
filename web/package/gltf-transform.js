/* norma-mesh/gltf-transform: normals, tangents and checks as transforms of a glTF-Transform Document. */
import { WebIO } from "@gltf-transform/core";
import { load } from "norma-mesh";
import * as given from "./arguments.js";
import { fail, spell } from "./arguments.js";
import { isLoaded, loaded } from "./load.js";
import { creaseVertices, gather, indexArray } from "./vertices.js";

const TRIANGLES = 4, TRIANGLE_STRIP = 5, TRIANGLE_FAN = 6;
const XYZ = 3, XYZW = 4;
const NORMAL_OPTIONS = ["weight", "weld", "nonManifold", "fallback", "crease"];
const COMPRESSION = /_(draco_mesh|meshopt)_compression$/;

const pick = (options, names) => Object.fromEntries(names.filter((name) => options[name] !== undefined).map((name) => [name, options[name]]));
const ready = async () => (isLoaded() ? loaded() : load());
/* glTF-Transform tells transforms apart by the names of their functions. */
const named = (name, transform) => Object.defineProperty(transform, "name", { value: name });
const flag = (value, standard, what) => (value === undefined ? standard : given.flag(value, what));

/* ---- reading */

function floatsOf(accessor) {
  const size = accessor.getElementSize(), count = accessor.getCount(), floats = new Float32Array(size * count), element = [];
  for (let i = 0; i < count; i++) floats.set(accessor.getElement(i, element), size * i);
  return floats;
}

/* An accessor's array as the calls take it; integers that stand for others than themselves become floats. */
const numbersOf = (accessor) => (accessor.getArray() instanceof Float32Array && !accessor.getNormalized() ? accessor.getArray() : floatsOf(accessor));

/* Corners of a strip or fan as those of triangles. */
function unroll(corners, mode) {
  const triangles = Math.max(0, corners.length - 2), unrolled = new Uint32Array(3 * triangles);
  for (let i = 0; i < triangles; i++) {
    const odd = mode === TRIANGLE_STRIP ? i % 2 : 0;
    unrolled.set(mode === TRIANGLE_STRIP ? [corners[i], corners[i + 1 + odd], corners[i + 2 - odd]] : [corners[i + 1], corners[i + 2], corners[0]], 3 * i);
  }
  return unrolled;
}

/* The corners of a primitive's triangles; undefined: positions are in order. null: it has none. */
function trianglesOf(primitive) {
  const mode = primitive.getMode(), indices = primitive.getIndices()?.getArray();
  if (mode === TRIANGLES) return indices ?? undefined;
  if (mode !== TRIANGLE_STRIP && mode !== TRIANGLE_FAN) return null;
  return unroll(indices ?? Uint32Array.from({ length: primitive.getAttribute("POSITION").getCount() }, (_, i) => i), mode);
}

/* The primitives of each mesh, with what they are called in messages. */
const listMeshes = (document) => document.getRoot().listMeshes().map((mesh, i) => mesh.listPrimitives().map((primitive, j) => ({ primitive, place: `mesh ${i}${mesh.getName() ? ` "${mesh.getName()}"` : ""}, primitive ${j}` })));

/* Every primitive of the document once. */
const listPrimitives = (document) => new Map(listMeshes(document).flat().reverse().map(({ primitive, place }) => [primitive, place]).reverse());

const areEqual = (a, b) => a.length === b.length && a.every((x, i) => x === b[i]);

/* make() once for each list of keys, compared by identity, and of arrays, compared by what they hold. */
function remember() {
  const ids = new Map(), made = new Map(), idOf = (key) => (ids.has(key) ? ids : ids.set(key, ids.size)).get(key);
  return (keys, make, arrays = []) => {
    const id = keys.map(idOf).join(), known = made.get(id) ?? [];
    let found = known.find((one) => one.arrays.every((array, i) => areEqual(array, arrays[i])));
    if (!found) made.set(id, [...known, (found = { arrays, value: make() })]);
    return found.value;
  };
}

/* ---- writing */

/* A document while its vertices change. Whatever primitives share, they share afterwards, as long as their results are the same. */
class Edit {
  constructor(document) {
    this.document = document;
    this.once = remember();
    this.touched = new Set();
  }

  /* A copy with the same name, extras and buffer. */
  copy(accessor, array) {
    const copy = accessor.clone().setArray(array);
    this.touched.add(accessor).add(copy);
    return copy;
  }

  /* An accessor with the copies that result.sources asks for. */
  carry(accessor, result) {
    return this.once([accessor, result, "carry"], () => this.copy(accessor, gather(accessor.getArray(), accessor.getElementSize(), accessor.getCount(), result.sources)));
  }

  /* floats as an accessor: with the name, extras and encoding of the one before, or a new one. */
  store(before, floats, type, buffer, keys) {
    return this.once([before, type, ...keys], () => {
      if (!before) return this.document.createAccessor().setType(type).setArray(floats).setBuffer(buffer);
      const array = before.getArray(), quantised = before.getNormalized() && (array instanceof Int8Array || array instanceof Int16Array), most = array instanceof Int8Array ? 127 : 32767;
      return this.copy(before, quantised ? array.constructor.from(floats, (x) => Math.round(x * most)) : floats).setNormalized(quantised);
    });
  }

  /* Gives a primitive, and its morph targets, the vertices of result. Whoever shares targets and gets the same surroundings goes on sharing them. */
  setVertices(primitive, result, mode, corners, surroundings = result) {
    const indices = primitive.getIndices(), position = primitive.getAttribute("POSITION");
    for (const semantic of result.sources.length ? primitive.listSemantics() : []) primitive.setAttribute(semantic, this.carry(primitive.getAttribute(semantic), result));
    this.setTargets(primitive, result, surroundings);
    if (!result.sources.length && mode === TRIANGLES) return;
    primitive.setMode(TRIANGLES).setIndices(this.once([indices, mode, result, "indices"], () => {
      const array = indexArray(corners, result.count, indices?.getArray() ?? new Uint16Array(0));
      return indices ? this.copy(indices, array) : this.document.createAccessor().setType("SCALAR").setArray(array).setBuffer(position.getBuffer());
    }, [corners]));
  }

  setTargets(primitive, result, surroundings) {
    const targets = primitive.listTargets(), isShared = targets.some((target) => target.listParents().filter((parent) => parent.propertyType === "Primitive").length > 1);
    const own = targets.map((target) => this.once([target, surroundings, "target"], () => {
      const carried = isShared ? target.clone() : target;
      for (const semantic of result.sources.length ? carried.listSemantics() : []) carried.setAttribute(semantic, this.carry(carried.getAttribute(semantic), result));
      return carried;
    }));
    if (own.every((target, t) => target === targets[t])) return;
    for (const target of targets) primitive.removeTarget(target);
    for (const target of own) primitive.addTarget(target);
  }

  /* Disposes of accessors that nothing uses any more. */
  finish() {
    for (const accessor of this.touched) if (accessor.listParents().every((parent) => parent.propertyType === "Root")) accessor.dispose();
  }
}

/* base + difference, for each vertex */
const moved = (base, difference) => {
  const sum = Float32Array.from(base), array = numbersOf(difference);
  for (let i = 0; i < sum.length; i++) sum[i] += array[i];
  return sum;
};

/* For each vertex of result the difference between the values of a target at its corner, and its own; size: numbers of a corner's value. Vertices of no face do not change. */
function differences(result, base, ofCorners, size) {
  const { count, firsts } = result, out = new Float32Array(XYZ * count);
  for (let i = 0; i < count; i++)
    for (let k = 0; k < XYZ && firsts[i] >= 0; k++) out[XYZ * i + k] = ofCorners[size * firsts[i] + k] - base[size * i + k];
  return out;
}

/* ---- normals */

const positionOf = ({ primitive }) => primitive.getAttribute("POSITION");
const displacementsOf = ({ primitive }) => primitive.listTargets().map((target) => target.getAttribute("POSITION"));

/* The corners of a member, checked. */
function cornersOf({ primitive, place, triangles }) {
  const count = primitive.getAttribute("POSITION").getCount(), corners = triangles ?? Uint32Array.from({ length: count }, (_, i) => i);
  at(place, () => { if (given.corners(triangles, count) && corners.some((vertex) => vertex >= count)) given.failAtIndex(triangles, count); });
  return corners;
}

/* The primitives of a mesh as one surface, as norma compute joins them, so that edges between them are not open. Primitives with the same positions, in the base and in every target, share a block of vertices; an exact
 * repetition of a primitive (another material over the same triangles) is taken once. */
function joinPrimitives(members) {
  const once = remember(), blocks = [], rows = [];
  let vertices = 0, corners = 0;
  for (const member of members) {
    const position = positionOf(member), displacements = displacementsOf(member);
    member.block = once([position, ...displacements, "block"], () => {
      blocks.push({ position, displacements, start: vertices, count: position.getCount() });
      vertices += position.getCount();
      return blocks.at(-1);
    });
    member.row = once([member.block, member.primitive.getIndices(), member.primitive.getMode()], () => {
      rows.push({ block: member.block, start: corners, corners: cornersOf(member) });
      corners += rows.at(-1).corners.length;
      return rows.at(-1);
    });
  }
  const joined = new Uint32Array(corners);
  for (const { block, start, corners: own } of rows) own.forEach((vertex, i) => { joined[start + i] = block.start + vertex; });
  return { blocks, rows, corners: joined, count: vertices };
}

/* The positions of blocks, one after the other; of(block) has them. */
function joinPositions({ blocks, count }, of) {
  const first = of(blocks[0]);
  if (blocks.length === 1) return first;
  const joined = new first.constructor(XYZ * count);
  blocks.forEach((block, i) => joined.set(i ? of(block) : first, XYZ * block.start));
  return joined;
}

/* Gives each block its part of the vertices made for the surface, and each row its corners: old vertices keep their numbers, what was added follows. */
function cutSurface(edit, { blocks, rows, count }, made) {
  const blockOf = new Uint32Array(count), added = blocks.map(() => []), numbers = new Uint32Array(made.count);
  blocks.forEach((block, b) => blockOf.fill(b, block.start, block.start + block.count));
  for (let vertex = 0; vertex < made.count; vertex++) {
    const b = blockOf[vertex < count ? vertex : made.sources[vertex - count]], block = blocks[b];
    numbers[vertex] = vertex < count ? vertex - block.start : block.count + added[b].push(vertex) - 1;
  }
  blocks.forEach((block, b) => {
    const list = added[b], all = block.count + list.length, values = new Float32Array(XYZ * all), sources = Uint32Array.from(list, (vertex) => made.sources[vertex - count] - block.start);
    values.set(made.values.subarray(XYZ * block.start, XYZ * (block.start + block.count)));
    list.forEach((vertex, i) => values.set(made.values.subarray(XYZ * vertex, XYZ * (vertex + 1)), XYZ * (block.count + i)));
    block.firsts = Int32Array.from({ length: all }, (_, i) => made.firsts[i < block.count ? block.start + i : list[i - block.count]]);
    block.result = edit.once([block.position, "result"], () => ({ count: all, sources, values }), [sources, values]);
  });
  for (const row of rows) row.corners = made.indices.subarray(row.start, row.start + row.corners.length).map((vertex) => numbers[vertex]);
}

/* Computes the normals of members, primitives of one mesh: each gets a block with its result, and a row of corners. */
function creased(edit, norma, members, options) {
  const surface = joinPrimitives(members), [first] = surface.blocks, same = (a, b) => a.getComponentType() === b.getComponentType() && a.getNormalized() === b.getNormalized();
  /* A factor that all integers have in common turns no direction, but it scales distances. */
  const integers = typeof options.weld !== "number" && surface.blocks.every(({ position }) => same(position, first.position));
  const positions = joinPositions(surface, ({ position }) => (integers ? position.getArray() : floatsOf(position)));
  cutSurface(edit, surface, creaseVertices(norma, positions, surface.corners, { crease: 60, ...options }, true));
  return surface;
}

/* Gives each block the differences of its targets' normals, where one of the members has them. A primitive without that target stays where it is. */
function morphNormals(norma, members, surface, options) {
  const { blocks } = surface, isWanted = (t) => members.some(({ primitive }) => primitive.listTargets()[t]?.getAttribute("NORMAL")), most = Math.max(...blocks.map(({ displacements }) => displacements.length));
  const wanted = Array.from({ length: most }, (_, t) => t).filter(isWanted);
  for (const block of blocks) Object.assign(block, { base: wanted.length ? floatsOf(block.position) : null, deltas: [] });
  if (!wanted.length) return;
  const plan = norma.plan(joinPositions(surface, ({ base }) => base), surface.corners, { fallback: "nearest", ...options, per: "corner", crease: options.crease ?? 60 });
  try {
    for (const t of wanted) {
      const ofCorners = plan.update(joinPositions(surface, ({ base, displacements }) => (displacements[t] ? moved(base, displacements[t]) : base)));
      for (const { result, firsts, deltas } of blocks) deltas[t] = differences({ count: result.count, firsts }, result.values, ofCorners, XYZ);
    }
  } finally {
    plan.free();
  }
}

function writeNormals(edit, norma, { primitive, block, row }) {
  const before = primitive.getAttribute("NORMAL"), buffer = positionOf({ primitive }).getBuffer(), { result } = block;
  edit.setVertices(primitive, result, primitive.getMode(), row.corners, block);
  primitive.setAttribute("NORMAL", edit.store(before, result.values, "VEC3", buffer, [result, "normals"]));
  primitive.listTargets().forEach((target, t) => {
    const normal = target.getAttribute("NORMAL");
    if (normal && block.deltas[t]) edit.once([target, block, "normal"], () => target.setAttribute("NORMAL", edit.store(normal, block.deltas[t], "VEC3", normal.getBuffer(), [block, t])));
  });
  keepTangents(edit, norma, primitive, result);
}

/* Tangents stay perpendicular to the new normals. */
function keepTangents(edit, norma, primitive, result) {
  const tangent = primitive.getAttribute("TANGENT");
  if (!tangent) return;
  primitive.setAttribute("TANGENT", edit.once([tangent, result, "tangent"], () => edit.store(tangent, norma.orthogonaliseTangents(floatsOf(tangent), result.values), "VEC4", tangent.getBuffer(), [result, "turned"])));
}

/* Computes the normals that are missing, of all meshes, with creases; with overwrite all normals. */
export function normals(options) {
  const chosen = given.options(options, [...NORMAL_OPTIONS, "overwrite"].join(" ")), computed = pick(chosen, NORMAL_OPTIONS), overwrite = flag(chosen.overwrite, false, "overwrite");
  given.crease(computed.crease);
  return named("normals", async (document) => {
    const norma = await ready(), edit = new Edit(document), logger = document.getLogger(), done = new Set();
    let kept = 0;
    const chosenOf = (members) => members.filter(({ primitive }) => !done.has(primitive) && (overwrite || !primitive.getAttribute("NORMAL")));
    const work = listMeshes(document).map((listed) => {
      const there = listed.filter(({ primitive }) => primitive.getAttribute("POSITION")?.getArray()).map((member) => ({ ...member, triangles: trianglesOf(member.primitive) }));
      for (const { place } of there.filter(({ triangles }) => triangles === null)) logger.debug(`normals: ${place}: points or lines, which have no normals`);
      const members = there.filter(({ triangles }) => triangles !== null), wanted = chosenOf(members);
      if (wanted.length) at(wanted[0].place, () => morphNormals(norma, members, creased(edit, norma, members, computed), computed));
      for (const { primitive } of members) if (!done.has(primitive)) { kept += !wanted.some((member) => member.primitive === primitive); done.add(primitive); }
      return wanted;
    });
    if (kept && kept === done.size) logger.warn("normals: nothing was computed, because all primitives have normals; normals({ overwrite: true }) replaces them");
    for (const member of work.flat()) writeNormals(edit, norma, member);
    edit.finish();
    logger.debug("normals: complete");
  });
}

/* An error names the primitive that it is about. */
function at(place, work) {
  try {
    return work();
  } catch (error) {
    if (!error.message.startsWith("mesh ")) error.message = `${place}: ${error.message}`;
    throw error;
  }
}

/* ---- tangents */

/* Texture coordinates of glTF run downwards: w has the other sign. */
function turnedSigns(tangents) {
  for (let i = 3; i < tangents.length; i += XYZW) tangents[i] = -tangents[i];
  return tangents;
}

function withTangents(norma, primitive, texcoord, triangles, options) {
  const result = norma.tangentVertices(numbersOf(primitive.getAttribute("POSITION")), numbersOf(primitive.getAttribute("NORMAL")), numbersOf(texcoord), triangles, options);
  turnedSigns(result.values);
  return { ...result, triangles };
}

/* The set of texture coordinates of the map that a material needs tangents for; undefined: it has none. */
function mapSet(material) {
  const coat = material.getExtension("KHR_materials_clearcoat"), streaks = material.getExtension("KHR_materials_anisotropy");
  const [used] = [[material.getNormalTexture(), () => material.getNormalTextureInfo()], [coat?.getClearcoatNormalTexture(), () => coat.getClearcoatNormalTextureInfo()], [streaks, () => streaks.getAnisotropyTextureInfo()]].filter(([map]) => map);
  return used && (used[1]()?.getTexCoord() ?? 0);
}

/* The same of a primitive, whose variants may have other materials. */
const setOf = (primitive) => [primitive.getMaterial(), ...(primitive.getExtension("KHR_materials_variants")?.listMappings().map((mapping) => mapping.getMaterial()) ?? [])].filter((material) => material).map(mapSet).find((set) => set !== undefined);

/* Morph targets get the differences of the tangents if they have such already; with add, all targets with normals. */
function morphTangents(edit, norma, primitive, texcoord, result, add, options) {
  const position = primitive.getAttribute("POSITION"), normal = primitive.getAttribute("NORMAL");
  const made = primitive.listTargets().map((target) => {
    const change = target.getAttribute("NORMAL");
    if (!change || !(add || target.getAttribute("TANGENT"))) return null;
    const positions = target.getAttribute("POSITION") ? moved(numbersOf(position), target.getAttribute("POSITION")) : numbersOf(position);
    const turned = norma.transformNormals([1, 0, 0, 0, 1, 0, 0, 0, 1], moved(numbersOf(normal), change));
    return differences(result, result.values, turnedSigns(norma.tangents(positions, turned, numbersOf(texcoord), result.triangles, options)), XYZW);
  });
  return (targets) => targets.forEach((target, i) => {
    if (made[i]) target.setAttribute("TANGENT", edit.store(target.getAttribute("TANGENT"), made[i], "VEC3", position.getBuffer(), [result, made[i]]));
  });
}

/* Computes tangents for primitives whose material has a normal map, if they have normals and its texture coordinates; with all for those without a map too, from set 0. */
export function tangents(options) {
  const chosen = given.options(options, "mode weight texcoord overwrite all morphTargets"), computed = pick(chosen, ["mode", "weight"]), { texcoord } = chosen;
  const [overwrite, all, morphTargets] = ["overwrite", "all", "morphTargets"].map((name) => flag(chosen[name], false, name));
  given.tangentMode(computed.mode);
  if (texcoord !== undefined && !(Number.isInteger(texcoord) && texcoord >= 0)) fail(`texcoord: ${spell(texcoord)} is not the number of a set of texture coordinates`);
  return named("tangents", async (document) => {
    const norma = await ready(), edit = new Edit(document), logger = document.getLogger();
    for (const [primitive, place] of listPrimitives(document)) {
      const used = setOf(primitive), set = texcoord ?? used ?? 0, mode = primitive.getMode();
      const [position, normal, coordinates, before] = ["POSITION", "NORMAL", `TEXCOORD_${set}`, "TANGENT"].map((semantic) => primitive.getAttribute(semantic));
      if (!position?.getArray() || (before && !overwrite)) continue;
      if (used === undefined && !all) { logger.debug(`tangents: ${place}: left as it is; it has no normal map`); continue; }
      const triangles = trianglesOf(primitive);
      if (triangles === null || !normal || !coordinates) { logger.debug(`tangents: ${place}: left as it is; it has no ${triangles === null ? "triangles" : normal ? `TEXCOORD_${set}` : "NORMAL"}`); continue; }
      const result = edit.once([position, normal, coordinates, primitive.getIndices(), mode], () => at(place, () => withTangents(norma, primitive, coordinates, triangles, computed)));
      const writeMorphs = morphTangents(edit, norma, primitive, coordinates, result, morphTargets, computed);
      edit.setVertices(primitive, result, mode, result.indices);
      primitive.setAttribute("TANGENT", edit.store(before, result.values, "VEC4", position.getBuffer(), [result, "tangents"]));
      writeMorphs(primitive.listTargets());
    }
    edit.finish();
    logger.debug("tangents: complete");
  });
}

/* ---- check */

/* The document as a GLB. The resources of a writer lie one after the other in its binary chunk. */
async function writeBinary(document) {
  const extensions = document.getRoot().listExtensionsUsed().filter(({ extensionName }) => !COMPRESSION.test(extensionName)).map(({ constructor }) => constructor);
  const { json, resources } = await new WebIO().setLogger(document.getLogger()).registerExtensions(extensions).writeJSON(document, { format: "GLTF" });
  const parts = (json.buffers ?? []).map(({ uri }) => resources[uri]), starts = [];
  let size = 0;
  for (const part of parts) { starts.push(size); size += Math.ceil((part?.byteLength ?? 0) / 8) * 8; }
  for (const view of json.bufferViews ?? []) { view.byteOffset = (view.byteOffset ?? 0) + starts[view.buffer]; view.buffer = 0; }
  if (parts.length) json.buffers = [{ byteLength: size }];
  const text = new TextEncoder().encode(JSON.stringify(json)), padded = Math.ceil(text.length / 8) * 8 + 4, glb = new Uint8Array(20 + padded + 8 + size), words = new DataView(glb.buffer);
  [0x46546c67, 2, glb.length, padded, 0x4e4f534a].forEach((word, i) => words.setUint32(4 * i, word, true));
  glb.fill(0x20, 20, 20 + padded).set(text, 20);
  [size, 0x004e4942].forEach((word, i) => words.setUint32(20 + padded + 4 * i, word, true));
  parts.forEach((part, i) => { if (part) glb.set(part, 28 + padded + starts[i]); });
  return glb;
}

/* Looks for what is wrong with normals and surfaces. The document stays as it is; errors and warnings go to its logger, the whole report to onReport. */
export function check(options) {
  const { name = "document.glb", profile, onReport } = given.options(options, "name profile onReport");
  given.profile(profile);
  if (onReport !== undefined && typeof onReport !== "function") fail(`onReport: ${spell(onReport)} is not a function`);
  return named("check", async (document) => {
    const norma = await ready(), logger = document.getLogger();
    const report = await norma.check(await writeBinary(document), { name: /\.glb$/i.test(given.name(name)) ? name : `${name}.glb`, profile });
    for (const { rule, severity, where, message } of report.files[0].findings) {
      const line = `${rule} ${where}${where && ": "}${message}`;
      if (severity === "error") logger.error(line);
      else if (severity === "warning") logger.warn(line);
    }
    await onReport?.(report);
  });
}

/* A configuration for the command line of glTF-Transform, which gets a command for all three. */
export const config = {
  onProgramReady({ program, io, Session }) {
    program.command("normals", "Compute normals and tangents")
      .argument("<input>", "the file to read").argument("<output>", "the file to write")
      .option("--crease <degrees>", "edges that bend by more are hard", { default: 60 })
      .option("--overwrite", "also replace normals and tangents that are there", { default: false })
      .action(({ args, options, logger }) => Session.create(io, logger, args.input, args.output)
        .transform(normals({ crease: Number(options.crease), overwrite: options.overwrite === true }), tangents({ overwrite: options.overwrite === true }), check()));
  },
};
