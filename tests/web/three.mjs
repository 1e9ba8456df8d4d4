/* node three.mjs, beside an installed norma-mesh and three: geometries in and out, and the same results as three.js where those are right. */
import * as THREE from "three";
import { computeMikkTSpaceTangents, toCreasedNormals } from "three/examples/jsm/utils/BufferGeometryUtils.js";
import { generateTangents } from "mikktspace";
import { load, loadWorker } from "norma-mesh";
import { computeNormals, computeTangents, planFor, planForWorker, toCreased } from "norma-mesh/three";
import { attempt, check, finish } from "./tap.mjs";

const thrown = (work) => { try { work(); return "nothing"; } catch (error) { return error.message; } };
check("before load it says what to do", /^norma-mesh: not loaded; await load\(\) first/.test(thrown(() => computeNormals(new THREE.BoxGeometry()))));
const norma = await load();
const { BufferAttribute, BufferGeometry, Float32BufferAttribute } = THREE;

const xyz = (attribute, i) => new THREE.Vector3().fromBufferAttribute(attribute, i);
/* The largest angle in degrees between the normals of corners. */
function apart(a, b, name = "normal") {
  const of = (geometry, corner) => xyz(geometry.attributes[name], geometry.index ? geometry.index.getX(corner) : corner);
  const corners = a.index ? a.index.count : a.attributes.position.count;
  let worst = 0;
  for (let i = 0; i < corners; i++) {
    const p = of(a, i), q = of(b, i);
    worst = Math.max(worst, (Math.atan2(new THREE.Vector3().crossVectors(p, q).length(), p.dot(q)) * 180) / Math.PI);
  }
  return worst;
}
const near = (a, b, most = 0.001) => { const angle = apart(a, b); if (!(angle <= most)) throw new Error(`${angle} degrees apart`); };
const threes = (geometry) => { const copy = geometry.clone(); copy.deleteAttribute("normal"); copy.computeVertexNormals(); return copy; };
const AS_THREE = { weight: "area", weld: "none" };

const shapes = {
  sphere: new THREE.SphereGeometry(1, 24, 16), knot: new THREE.TorusKnotGeometry(1, 0.3, 80, 12), box: new THREE.BoxGeometry(1, 2, 3, 2, 2, 2), cone: new THREE.ConeGeometry(1, 2, 20),
  lathe: new THREE.LatheGeometry([[0, 0], [2, 0], [2.5, 3]].map(([x, y]) => new THREE.Vector2(x, y)), 24), icosahedron: new THREE.IcosahedronGeometry(1, 3),
  extruded: new THREE.ExtrudeGeometry(new THREE.Shape([[0, 0], [3, 0], [3, 1], [1, 1], [1, 3], [0, 3]].map(([x, y]) => new THREE.Vector2(x, y))), { depth: 1, bevelSegments: 2 }),
  quantised: new BufferGeometry().setAttribute("position", new BufferAttribute(Int16Array.from({ length: 300 }, (_, i) => ((i * 7919) % 2001) - 1000), 3)).setIndex(Array.from({ length: 297 }, (_, i) => (i * 31) % 100)),
};

/* ---- computeNormals beside computeVertexNormals */
for (const [name, shape] of Object.entries(shapes))
  await attempt(`${name}: by area and by index, the normals of computeVertexNormals`, () => near(computeNormals(shape.clone(), AS_THREE), threes(shape)));
{
  /* Its seam and its south pole are closed to the sixteenth decimal only. */
  const seam = new THREE.SphereGeometry(1, 24, 16), ours = computeNormals(seam.clone(), { weld: 1e-6 }), error = (geometry) => { let worst = 0; for (let i = 0; i < geometry.attributes.position.count; i++) worst = Math.max(worst, xyz(geometry.attributes.normal, i).angleTo(xyz(geometry.attributes.position, i))); return (worst * 180) / Math.PI; };
  check("the seam and poles of a sphere are smooth, where three.js leaves them open", error(ours) < 0.7 && error(threes(seam)) > 5, `${error(ours)} ${error(threes(seam))}`);
  const cube = new BufferGeometry().setAttribute("position", new Float32BufferAttribute([0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 0, 1, 1, 0, 1, 0, 1, 1, 1, 1, 1], 3)).setIndex([0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5]);
  const isDiagonal = (geometry) => Array.from({ length: 24 }, (_, i) => Math.abs(Math.abs(geometry.attributes.normal.array[i]) - Math.sqrt(1 / 3)) < 1e-6).every(Boolean);
  check("a cube's normals do not depend on its diagonals, where those of three.js do", isDiagonal(computeNormals(cube.clone())) && !isDiagonal(threes(cube)));
  const tiny = new BufferGeometry().setAttribute("position", new Float32BufferAttribute([0, 0, 0, 1e-25, 0, 0, 0, 1e-25, 0], 3));
  check("a triangle of 1e-25 has a normal, where that of three.js is zero", computeNormals(tiny.clone()).attributes.normal.getZ(0) === 1 && threes(tiny).attributes.normal.getZ(0) === 0);
}
await attempt("in place: the attribute stays, and is marked", () => {
  const geometry = shapes.knot.clone(), { normal } = geometry.attributes, { array, version } = normal;
  if (computeNormals(geometry) !== geometry || geometry.attributes.normal !== normal || normal.array !== array || normal.version !== version + 1) throw new Error("another one");
});
await attempt("positions without an index are triangles", () => { const flat = shapes.box.toNonIndexed(); flat.deleteAttribute("normal"); near(computeNormals(flat, AS_THREE), threes(flat)); });

function interleave(geometry, names) {
  const stride = names.reduce((sum, name) => sum + geometry.attributes[name].itemSize, 0), { count } = geometry.attributes.position, buffer = new THREE.InterleavedBuffer(new Float32Array(stride * count), stride), copy = geometry.clone();
  let offset = 0;
  for (const name of names) {
    const attribute = geometry.attributes[name], { itemSize } = attribute;
    for (let i = 0; i < count; i++) for (let k = 0; k < itemSize; k++) buffer.array[stride * i + offset + k] = attribute.array[itemSize * i + k];
    copy.setAttribute(name, new THREE.InterleavedBufferAttribute(buffer, itemSize, offset));
    offset += itemSize;
  }
  return copy;
}
for (const names of [["uv", "position", "normal"], ["position", "uv"], ["uv", "normal"]])
  await attempt(`interleaved ${names.join(", ")}`, () => {
    const inside = interleave(shapes.lathe, names), uv = inside.attributes.uv.data.array.slice();
    near(computeNormals(inside), computeNormals(shapes.lathe.clone()), 1e-4);
    if (names.includes("normal") && !inside.attributes.normal.isInterleavedBufferAttribute) throw new Error("taken apart");
    if (names[0] === "uv" && inside.attributes.uv.data.array.some((x, i) => i % inside.attributes.uv.data.stride < 2 && x !== uv[i])) throw new Error("texture coordinates were written");
    near(toCreased(inside, { crease: 40 }), toCreased(shapes.lathe, { crease: 40 }), 1e-4);
  });
await attempt("normals of normalised bytes stay bytes", () => {
  const bytes = shapes.knot.clone().setAttribute("normal", new BufferAttribute(new Int8Array(shapes.knot.attributes.normal.array.length), 3, true));
  near(computeNormals(bytes), computeNormals(shapes.knot.clone()), 0.7);
  if (!(bytes.attributes.normal.array instanceof Int8Array)) throw new Error("not bytes");
});
await attempt("half floats", () => {
  const half = shapes.box.clone().setAttribute("position", new THREE.Float16BufferAttribute(Array.from(shapes.box.attributes.position.array, (x) => THREE.DataUtils.toHalfFloat(x)), 3));
  near(computeNormals(half), computeNormals(shapes.box.clone()), 0.001);
});
await attempt("report: true", () => {
  const flat = new BufferGeometry().setAttribute("position", new Float32BufferAttribute([0, 0, 0, 1, 0, 0, 2, 0, 0, 0, 0, 1, 1, 0, 1, 0, 1, 1], 3)), { geometry, report } = computeNormals(flat, { report: true });
  if (geometry !== flat || report.degenerateFaces !== 1 || report.unreferenced !== 3) throw new Error(JSON.stringify(report));
});

/* ---- morph targets */
function withMorphs(geometry, isRelative) {
  const copy = geometry.clone(), { array } = copy.attributes.position, other = array.map((x, i) => (i % 3 === 1 ? 1.7 * x + 0.1 : x));
  copy.morphAttributes.position = [new Float32BufferAttribute(isRelative ? other.map((x, i) => x - array[i]) : other, 3)];
  copy.morphAttributes.position[0].name = "tall";
  copy.morphTargetsRelative = isRelative;
  return { copy, other: new BufferGeometry().setAttribute("position", new Float32BufferAttribute(other, 3)).setIndex(copy.index) };
}
for (const isRelative of [false, true])
  await attempt(`morph normals, ${isRelative ? "differences" : "absolute"}: those of the shape that the target makes`, () => {
    const { copy, other } = withMorphs(shapes.knot, isRelative), expected = computeNormals(other).attributes.normal.array, base = computeNormals(copy).attributes.normal.array, [morph] = copy.morphAttributes.normal;
    const worst = Math.max(...expected.map((x, i) => Math.abs(x - morph.array[i] - (isRelative ? base[i] : 0))));
    if (worst > 1e-5 || morph.name !== "tall") throw new Error(`${worst}`);
    const { array } = morph;
    if (computeNormals(copy).morphAttributes.normal[0].array !== array) throw new Error("not in place");
    const cut = withMorphs(shapes.box, isRelative).copy, creased = toCreased(cut, { crease: 30 }), [now] = creased.morphAttributes.normal;
    for (let i = 0; i < now.count; i++) {
      const length = xyz(now, i).add(isRelative ? xyz(creased.attributes.normal, i) : new THREE.Vector3()).length();
      if (Math.abs(length - 1) > 1e-5) throw new Error(`a morph normal of length ${length}`);
    }
    if (now.count !== creased.attributes.position.count || creased.morphAttributes.position[0].count !== now.count || creased.morphAttributes.position[0].name !== "tall") throw new Error("counts");
  });

/* ---- toCreased beside toCreasedNormals: the same where all faces round a vertex lie on one side of the crease, or bend alike */
const welded = (geometry) => { const copy = geometry.index ? geometry.toNonIndexed() : geometry.clone(); copy.deleteAttribute("normal"); return copy; };
for (const [name, shape, crease] of [["box", shapes.box, 30], ["extruded", shapes.extruded, 20], ["icosahedron", shapes.icosahedron, 60], ["sphere", shapes.sphere, 179], ["icosahedron, flat", new THREE.IcosahedronGeometry(1, 1), 1]])
  await attempt(`${name}, crease ${crease}, weights alike: the normals of toCreasedNormals`, () => near(toCreased(shape, { crease, weight: "uniform", weld: 1e-6 }), toCreasedNormals(welded(shape), (crease * Math.PI) / 180), 0.01));
await attempt("vertices are doubled only where a crease is", () => {
  const sphere = toCreased(shapes.sphere, { crease: 60 }), box = toCreased(new THREE.BoxGeometry(), { crease: 60 });
  if (sphere.attributes.position.count !== shapes.sphere.attributes.position.count || box.attributes.position.count !== 24) throw new Error(`${sphere.attributes.position.count} ${box.attributes.position.count}`);
  if (sphere.index === shapes.sphere.index || sphere.index.array.some((vertex, i) => vertex !== shapes.sphere.index.array[i])) throw new Error("another index");
});
await attempt("every attribute, group, name and instance comes along, and the source stays as it is", () => {
  const source = new THREE.InstancedBufferGeometry().copy(new THREE.CylinderGeometry(1, 1, 2, 8)), { count } = source.attributes.position;
  source.setIndex([...source.index.array]);
  source.setAttribute("color", new BufferAttribute(Uint8Array.from({ length: 4 * count }, (_, i) => i % 251), 4, true));
  source.setAttribute("ids", new BufferAttribute(Uint32Array.from({ length: count }, (_, i) => i), 1));
  source.setAttribute("offset", new THREE.InstancedBufferAttribute(new Float32Array(30), 3));
  Object.assign(source, { name: "can", userData: { metal: true }, instanceCount: 10 });
  source.setDrawRange(3, 12);
  /* Smooth first, so that there is something to cut. */
  const joined = new THREE.InstancedBufferGeometry().copy(source), before = JSON.stringify(joined.toJSON()), creased = toCreased(joined, { crease: 30 });
  if (JSON.stringify(joined.toJSON()) !== before) throw new Error("the source changed");
  if (!creased.isInstancedBufferGeometry || creased.name !== "can" || !creased.userData.metal || creased.instanceCount !== 10 || creased.drawRange.count !== 12 || JSON.stringify(creased.groups) !== JSON.stringify(source.groups)) throw new Error("what is not an attribute");
  if (creased.attributes.offset.count !== 10 || !creased.attributes.offset.isInstancedBufferAttribute) throw new Error("instances");
  for (let i = 0; i < creased.index.count; i++) {
    const now = creased.index.getX(i), old = source.index.getX(i);
    if (creased.attributes.ids.getX(now) !== old) throw new Error("ids");
    for (const name of ["position", "uv", "color"]) for (let k = 0; k < creased.attributes[name].itemSize; k++) if (creased.attributes[name].getComponent(now, k) !== source.attributes[name].getComponent(old, k)) throw new Error(name);
  }
  if (!(creased.attributes.color.array instanceof Uint8Array) || !creased.attributes.color.normalized) throw new Error("colours");
});
await attempt("a split really carries attributes: a cube of eight vertices", () => {
  const cube = toCreased(new BufferGeometry().setAttribute("position", new Float32BufferAttribute([0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 0, 1, 1, 0, 1, 0, 1, 1, 1, 1, 1], 3)).setAttribute("ids", new BufferAttribute(Uint16Array.of(0, 1, 2, 3, 4, 5, 6, 7), 1))
    .setIndex([0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5]));
  const { position, ids, normal } = cube.attributes;
  if (position.count !== 24 || normal.count !== 24) throw new Error(`${position.count}`);
  for (let i = 0; i < 24; i++) if (ids.getX(i) !== position.getX(i) + 2 * position.getY(i) + 4 * position.getZ(i) || xyz(normal, i).toArray().filter((x) => Math.abs(x) === 1).length !== 1) throw new Error(`${i}`);
  if (ids.array.subarray(0, 8).join() !== "0,1,2,3,4,5,6,7") throw new Error("old vertices got other numbers");
});
await attempt("corners share a vertex where their normals have the same bits, also 9,000 of one vertex, with indices of any width", () => {
  const count = 9000, positions = [0, 0, 4], faces = [];
  for (let i = 0; i < count; i++) {
    const turn = (2 * Math.PI * i) / count, far = 1 + (i % 3);
    positions.push(far * Math.cos(turn), far * Math.sin(turn), i % 2);
    faces.push(0, 1 + i, 1 + ((i + 1) % count));
  }
  const fan = (kind, used) => new BufferGeometry().setAttribute("position", new Float32BufferAttribute(positions, 3)).setIndex(new BufferAttribute(kind.from(faces.slice(0, 3 * used)), 1));
  for (const [kind, used, crease] of [[Uint32Array, count, 3], [Uint16Array, count, 3], [Uint16Array, count, 0], [Uint8Array, 250, 2]]) {
    const source = fan(kind, used), indices = source.index.array, corners = norma.cornerNormals(source.attributes.position.array, indices, { crease, fallback: "nearest" });
    const names = Array.from(indices, (vertex, i) => `${vertex} ${new Uint32Array(corners.buffer, 12 * i, 3)}`), created = toCreased(source, { crease }), { index, attributes: { normal, position } } = created;
    const added = new Set(names).size - new Set(indices).size;
    if (position.count !== 1 + count + added || normal.count !== position.count) throw new Error(`${kind.name}, crease ${crease}: ${position.count} vertices, ${added} added`);
    if (added < used / 2) throw new Error(`only ${added} added`);
    for (let i = 0; i < indices.length; i++) {
      const now = index.getX(i);
      for (let k = 0; k < 3; k++) if (normal.array[3 * now + k] !== corners[3 * i + k] || position.array[3 * now + k] !== source.attributes.position.array[3 * indices[i] + k]) throw new Error(`corner ${i}`);
    }
  }
});
await attempt("without an index it stays without, and attributes are copies", () => {
  const flat = shapes.box.toNonIndexed(), creased = toCreased(flat, { crease: 30 });
  if (creased.index || creased === flat || creased.attributes.uv === flat.attributes.uv) throw new Error("shared");
  near(creased, toCreasedNormals(flat, Math.PI / 6), 0.001);
  const inside = toCreased(interleave(flat, ["uv", "position"]), { crease: 30 });
  if (!inside.attributes.position.isInterleavedBufferAttribute || inside.attributes.position.data !== inside.attributes.uv.data) throw new Error("taken apart");
  near(inside, creased, 0);
  inside.attributes.position.setX(0, 99);
  if (creased.attributes.position.getX(0) === 99) throw new Error("shared memory");
});
await attempt("an interleaved geometry is copied, not shared, with and without an index", () => {
  for (const source of [interleave(shapes.box, ["uv", "position"]), interleave(shapes.box.toNonIndexed(), ["uv", "position"])]) {
    const creased = toCreased(source, { crease: 30 });
    creased.attributes.position.setX(0, 99);
    if (source.attributes.position.getX(0) === 99) throw new Error("shared memory");
  }
});

/* ---- computeTangents beside the MikkTSpace addon */
const mikk = { isReady: true, generateTangents };
for (const [name, shape] of Object.entries(shapes).filter(([name]) => name !== "quantised"))
  for (const negateSign of [true, false])
    await attempt(`${name}: the bits of the MikkTSpace addon${negateSign ? "" : ", sign kept"}, corner for corner`, () => {
      const theirs = computeMikkTSpaceTangents(shape.clone(), mikk, negateSign), ours = computeTangents(shape.clone(), negateSign ? {} : { negateSign });
      const corners = theirs.attributes.position.count, { tangent } = ours.attributes;
      let differ = 0, useless = 0;
      for (let i = 0; i < corners; i++) {
        const vertex = ours.index ? ours.index.getX(i) : i, their = Array.from({ length: 4 }, (_, k) => theirs.attributes.tangent.getComponent(i, k)), our = Array.from({ length: 4 }, (_, k) => tangent.getComponent(vertex, k));
        /* Where the reference gives nothing of use there is no same: what is not a unit vector across the normal, and its fallback on a face with two equal positions. */
        const normal = xyz(ours.attributes.normal, vertex), isUseful = Math.abs(new THREE.Vector3(...their).dot(normal)) < 0.01 && Math.hypot(their[0], their[1], their[2]) > 0.5;
        const face = [0, 1, 2].map((k) => xyz(theirs.attributes.position, i - (i % 3) + k)), isFallback = their.slice(0, 3).join() === "1,0,0" && (face[0].equals(face[1]) || face[1].equals(face[2]) || face[2].equals(face[0]));
        if (!isUseful || isFallback) useless++; else if (their.some((x, k) => x !== our[k])) differ++;
      }
      if (differ || useless > corners / 4) throw new Error(`${differ} of ${corners} corners differ, ${useless} are of no use`);
      if (shape.index && !ours.index) throw new Error("not indexed any more");
    });
await attempt("tangents of quantised normals are quantised, by another channel too", () => {
  const bytes = shapes.sphere.clone();
  bytes.setAttribute("normal", new BufferAttribute(Int8Array.from(bytes.attributes.normal.array, (x) => Math.round(127 * x)), 3, true)).setAttribute("uv1", bytes.attributes.uv);
  bytes.deleteAttribute("uv");
  const { geometry, report } = computeTangents(bytes, { texcoord: 1, mode: "steady", report: true });
  if (!(geometry.attributes.tangent.array instanceof Int8Array) || typeof report.degenerate !== "number") throw new Error("floats");
});

/* ---- planForWorker */
{
  const worker = await loadWorker(), shared = globalThis.SharedArrayBuffer;
  const rippled = (geometry, time) => { const { position } = geometry.attributes; for (let i = 0; i < position.count; i++) position.setZ(i, 0.1 * Math.sin(5 * position.getX(i) + time)); };
  const same = (a, b) => { if (!a.attributes.normal.array.every((x, i) => x === b.attributes.normal.array[i])) throw new Error("other bits"); };
  for (const memory of ["shared memory", "messages"]) {
    globalThis.SharedArrayBuffer = memory === "messages" ? undefined : shared;
    await attempt(`a plan in a worker, by ${memory}: the bits of planFor, whole and for vertices that moved`, async () => {
      const here = new THREE.PlaneGeometry(2, 2, 30, 30), there = here.clone(), near = planFor(here, { crease: 40 }), far = await planForWorker(worker, there, { crease: 40 });
      if (!(far.bytes > 0)) throw new Error(`${far.bytes} bytes`);
      for (const time of [0, 1]) {
        for (const geometry of [here, there]) rippled(geometry, time);
        near.update();
        const { version } = there.attributes.normal, work = far.update();
        if (there.attributes.normal.version !== version) throw new Error("written before it is there");
        await work;
        same(here, there);
      }
      for (const geometry of [here, there]) geometry.attributes.position.setZ(480, 1);
      near.update({ moved: [480] });
      if ((await far.update({ moved: [480], report: true })).nonFinite !== 0) throw new Error("a report");
      same(here, there);
      const wrong = await far.update({ moved: [961] }).catch((error) => error.message);
      if (!/^moved: element 0 is 961/.test(wrong)) throw new Error(wrong);
      for (const geometry of [here, there]) rippled(geometry, 2);
      near.update();
      await Promise.all([far.update(), far.update(), far.update({ moved: [3] })]);
      same(here, there);
      here.dispose();
      there.dispose();
      const freed = await far.update().catch((error) => error.message);
      if (!/^plan: it has been freed/.test(freed)) throw new Error(freed);
    });
  }
  globalThis.SharedArrayBuffer = shared;
  await attempt("a plan in a worker, interleaved: normals lie where they lay", async () => {
    const inside = interleave(new THREE.PlaneGeometry(2, 2, 10, 10), ["uv", "position", "normal"]), { normal } = inside.attributes, plain = new THREE.PlaneGeometry(2, 2, 10, 10), plan = await planForWorker(worker, inside);
    for (const geometry of [inside, plain]) rippled(geometry, 1);
    await plan.update();
    if (inside.attributes.normal !== normal) throw new Error("another attribute");
    near(inside, computeNormals(plain), 0);
  });
  check("without a worker it says so", /^worker: an object with nothing in it is not what loadWorker gives/.test(await planForWorker({}, new THREE.PlaneGeometry()).catch((error) => error.message)));
  await worker.terminate();
}

/* ---- planFor */
await attempt("a plan writes the normals of the positions that are there now", () => {
  const plane = new THREE.PlaneGeometry(2, 2, 30, 30), { position, normal } = plane.attributes, plan = planFor(plane);
  for (let i = 0; i < position.count; i++) position.setZ(i, 0.2 * Math.sin(5 * position.getX(i)));
  const { version } = normal;
  plan.update();
  near(plane, computeNormals(plane.clone()), 1e-4);
  if (normal.version !== version + 1 || plane.attributes.normal !== normal) throw new Error("not in place");
  position.setZ(450, 1);
  plan.update({ moved: [450] });
  near(plane, computeNormals(plane.clone()), 1e-4);
  if (typeof plan.update({ report: true }).cancelled !== "number") throw new Error("no report");
  plane.dispose();
  if (!/^plan: it has been freed/.test(thrown(() => plan.update()))) throw new Error("it lives on after dispose()");
});
await attempt("of an interleaved geometry too, with what moved", () => {
  const inside = interleave(new THREE.PlaneGeometry(2, 2, 10, 10), ["uv", "position", "normal"]), plan = planFor(inside);
  plan.update();
  inside.attributes.position.setZ(60, 1);
  plan.update({ moved: [60] });
  near(inside, computeNormals(inside.clone()), 1e-4);
  plan.free();
  plan.free();
});

/* ---- errors */
for (const [name, message, work] of [
  ["no geometry", /^geometry: an object with/, () => computeNormals({ attributes: {} })], ["no positions", /^geometry: it has no position attribute/, () => computeNormals(new BufferGeometry())],
  ["no uv", /^geometry: it has no uv attribute/, () => computeTangents(computeNormals(shapes.quantised.clone()))], ["an option that does not exist", /^options: angle is not an option/, () => toCreased(shapes.box, { angle: 30 })],
  ["three's radians as an argument", /^options: 1.04/, () => toCreased(shapes.box, Math.PI / 3)], ["a crease out of range", /^crease: 200/, () => toCreased(shapes.box, { crease: 200 })],
  ["a channel out of range", /^texcoord: 4/, () => computeTangents(shapes.box.clone(), { texcoord: 4 })], ["a channel that is null", /^texcoord: null/, () => computeTangents(shapes.box.clone(), { texcoord: null })],
  ["a crease that is null", /^crease: null/, () => toCreased(shapes.box, { crease: null })], ["a plan's crease that is null", /^crease: null/, () => planFor(shapes.box.clone(), { crease: null })], ["an index out of range", /^indices: number 1 is 9/, () => computeNormals(shapes.box.clone().setAttribute("position", new Float32BufferAttribute([0, 0, 0, 1, 0, 0, 0, 1, 0], 3)).setIndex([0, 9, 1]))],
]) check(`${name}: an error that begins with it`, message.test(thrown(work)), thrown(work));
finish();
