/* node adapters.mjs, beside an installed norma-mesh, Babylon.js, PlayCanvas and React: what their meshes hold before and after, judged by definition and by the engines' own calls. */
import { StrictMode, Suspense, createElement } from "react";
import ReactThreeTestRenderer from "@react-three/test-renderer";
import { Logger } from "@babylonjs/core/Misc/logger.js";
import { VertexData, VertexDataMaterialInfo } from "@babylonjs/core/Meshes/mesh.vertexData.js";
import { CreateBoxVertexData } from "@babylonjs/core/Meshes/Builders/boxBuilder.js";
import * as pc from "playcanvas";
import * as THREE from "three";
import * as babylon from "norma-mesh/babylon";
import * as playcanvas from "norma-mesh/playcanvas";
import { useCreasedGeometry } from "norma-mesh/react";
import { attempt, check, finish } from "./tap.mjs";
import { randomNumbers } from "./shapes.mjs";

Logger.LogLevels = Logger.ErrorLogLevel;
const thrown = (work) => { try { work(); return "nothing"; } catch (error) { return error.message; } };
check("before load it says what to do", /^norma-mesh: not loaded; await load\(\) first/.test(thrown(() => babylon.computeNormals(new VertexData()))));
await babylon.load();

const sub = (a, b) => a.map((x, i) => x - b[i]), dot = (a, b) => a.reduce((sum, x, i) => sum + x * b[i], 0);
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = (a) => a.map((x) => x / Math.hypot(...a));
const row = (array, size, i) => Array.from(array.slice(size * i, size * i + size));
function must(condition, what) { if (!condition) throw new Error(what); }

/* A bumpy sheet that is folded like a roof at its middle, every vertex once; texture coordinates are the sheet's, seen against the clock as its faces are. */
function makeRoof(seed, side = 6) {
  const random = randomNumbers(seed), positions = [], uvs = [], indices = [], colours = [];
  for (let j = 0; j <= side; j++)
    for (let i = 0; i <= side; i++) {
      positions.push(i, j, 1.5 * Math.abs(i - side / 2) + 0.1 * random());
      uvs.push(i / side, j / side);
      colours.push(random(), random(), random(), 1);
    }
  for (let j = 0; j < side; j++)
    for (let i = 0; i < side; i++) {
      const a = j * (side + 1) + i, b = a + 1, c = a + side + 1, d = c + 1;
      indices.push(a, b, d, a, d, c);
    }
  return { positions, uvs, indices, colours, fold: side / 2 };
}

/* Whether corners have what they had before: values of all arrays, in the order of faces. */
function sameCorners(before, after, sizes) {
  must(before.indices.length === after.indices.length, "other corners");
  for (const [name, size] of Object.entries(sizes))
    for (let c = 0; c < before.indices.length; c++) must(row(before[name], size, before.indices[c]).map(Math.fround).join() === row(after[name], size, after.indices[c]).join(), `${name} of corner ${c}`);
}

/* By definition: away from the fold all faces of a vertex share a normal, at the fold those of each side; the weight is the corner's angle. Faces are seen with the clock where sense is -1. */
function judgeNormals({ positions, indices, normals }, roof, sense) {
  const point = (c) => row(positions, 3, indices[c]), isLeft = (f) => (point(3 * f)[0] + point(3 * f + 1)[0] + point(3 * f + 2)[0]) / 3 < roof.fold, sums = new Map();
  const key = (c) => `${point(c).join()} ${point(c)[0] === roof.fold ? isLeft(Math.floor(c / 3)) : ""}`;
  for (let f = 0; 3 * f < indices.length; f++) {
    const [a, b, c] = [0, 1, 2].map((k) => point(3 * f + k)), normal = unit(cross(sub(b, a), sub(c, a)));
    for (let k = 0; k < 3; k++) {
      const [p, q, r] = [0, 1, 2].map((n) => point(3 * f + ((k + n) % 3))), angle = Math.acos(dot(unit(sub(q, p)), unit(sub(r, p)))), sum = sums.get(key(3 * f + k)) ?? [0, 0, 0];
      sums.set(key(3 * f + k), sum.map((x, i) => x + sense * angle * normal[i]));
    }
  }
  for (let c = 0; c < indices.length; c++) must(dot(unit(sums.get(key(c))), row(normals, 3, indices[c])) > 1 - 1e-6, `the normal of corner ${c}`);
}

/* dP/du and dP/dv of each face by definition: the tangent and w (normal x tangent) lie on their sides. */
function judgeTangents({ positions, indices, normals, tangents, uvs }, sign) {
  for (let f = 0; 3 * f < indices.length; f++) {
    const [a, b, c] = [0, 1, 2].map((k) => indices[3 * f + k]), at = (i) => row(positions, 3, i), uv = (i) => row(uvs, 2, i);
    const e = sub(at(b), at(a)), g = sub(at(c), at(a)), [s, t] = sub(uv(b), uv(a)), [p, q] = sub(uv(c), uv(a)), area = s * q - t * p;
    const along = e.map((x, i) => (x * q - g[i] * t) / area), up = e.map((x, i) => (g[i] * s - x * p) / area);
    for (const i of [a, b, c]) {
      const tangent = row(tangents, 4, i), normal = row(normals, 3, i), bitangent = cross(normal, tangent.slice(0, 3)).map((x) => sign * tangent[3] * x);
      must(dot(tangent.slice(0, 3), unit(along)) > 0.8 && dot(bitangent, unit(up)) > 0.8, `the tangent of vertex ${i}`);
      must(Math.abs(dot(tangent.slice(0, 3), normal)) < 1e-6, `vertex ${i} is askew`);
    }
  }
}

/* ---- Babylon.js */
const SIZES = { positions: 3, uvs: 2, colors: 4, matricesIndices: 4, matricesWeights: 4, uvs2: 2 };
function babylonRoof(roof, kind = Array) {
  const data = new VertexData(), count = roof.positions.length / 3;
  const turned = roof.indices.map((_, i) => roof.indices[i % 3 ? i + (i % 3 === 1 ? 1 : -1) : i]);
  data.positions = roof.positions.slice();
  data.indices = kind.from(turned);
  data.uvs = Float32Array.from(roof.uvs);
  data.uvs2 = Float32Array.from(roof.uvs, (x) => 1 - x);
  data.colors = Float32Array.from(roof.colours);
  data.matricesIndices = Float32Array.from({ length: 4 * count }, (_, i) => i % 7);
  data.matricesWeights = Float32Array.from({ length: 4 * count }, () => 0.25);
  return data;
}
for (const kind of [Array, Int32Array, Uint32Array, Uint16Array])
  for (const seed of [1, 2, 3])
    await attempt(`Babylon.js, ${kind.name}, roof ${seed}: creases by definition, all arrays carried, tangents by dP/du and dP/dv`, () => {
      const roof = makeRoof(seed), before = babylonRoof(roof, kind), { vertexData: after, report } = babylon.toCreased(before, { crease: 50, report: true });
      must(after !== before && after instanceof VertexData && !before.normals, "it is not another VertexData");
      must(after.uniqueId !== before.uniqueId, "its number is the other's");
      must(after.indices.constructor === kind, `indices became ${after.indices.constructor.name}`);
      must(after.positions.length / 3 === 49 + 7 && report.nonFinite === 0, `${after.positions.length / 3} vertices`);
      sameCorners(before, after, SIZES);
      judgeNormals(after, roof, -1);
      judgeTangents(babylon.computeTangents(after), 1);
      judgeTangents(babylon.computeTangents(after, { negateSign: true, mode: "steady" }), -1);
      const theirs = [];
      VertexData.ComputeNormals(after.positions, after.indices, theirs);
      must(theirs.every((_, i) => i % 3 || dot(row(theirs, 3, i / 3), row(after.normals, 3, i / 3)) > 0.8), "Babylon.js's normals point to the other side");
    });
await attempt("Babylon.js, right-handed: the other sense, as useRightHandedSystem", () => {
  const roof = makeRoof(4), data = babylonRoof(roof), theirs = [];
  data.indices = roof.indices.slice();
  const made = babylon.toCreased(data, { crease: 50, rightHanded: true });
  judgeNormals(made, roof, 1);
  judgeTangents(babylon.computeTangents(made, { rightHanded: true }), 1);
  VertexData.ComputeNormals(made.positions, made.indices, theirs, { useRightHandedSystem: true });
  must(dot(theirs.slice(0, 3), row(made.normals, 3, 0)) > 0.8, "another side");
});
await attempt("Babylon.js: sub-meshes keep their faces, and count their vertices again", () => {
  const data = babylonRoof(makeRoof(5)), half = data.indices.length / 2;
  data.materialInfos = [0, 1].map((materialIndex) => Object.assign(new VertexDataMaterialInfo(), { materialIndex, indexStart: materialIndex * half, indexCount: half, verticesStart: 0, verticesCount: 49 }));
  const made = babylon.toCreased(data, { crease: 50 });
  must(data.materialInfos[0].verticesCount === 49 && made.materialInfos[0] instanceof VertexDataMaterialInfo, "the other's were changed");
  for (const { indexStart, indexCount, verticesStart, verticesCount } of made.materialInfos) {
    const used = made.indices.slice(indexStart, indexStart + indexCount);
    must(indexCount === half && Math.min(...used) === verticesStart && Math.max(...used) === verticesStart + verticesCount - 1, "a range is wrong");
  }
});
await attempt("Babylon.js: without indices every three positions are a triangle; a box is found whole", () => {
  const data = new VertexData();
  data.positions = [0, 0, 0, 0, 1, 0, 1, 0, 0];
  must(babylon.computeNormals(data).normals.join() === "0,0,1,0,0,1,0,0,1" && !data.indices, data.normals?.join());
  const box = CreateBoxVertexData({ size: 1 }), before = box.normals.slice();
  must(Math.max(...sub(Array.from(babylon.toCreased(box, { crease: 30 }).normals), before).map(Math.abs)) < 1e-6, "the box's normals became others");
});
{
  const data = babylonRoof(makeRoof(6));
  data.positions[3 * 8] = NaN;
  check("Babylon.js: positions that are not a number are told", babylon.computeNormals(data, { report: true }).report.nonFinite > 0);
  const errors = [
    [() => babylon.computeNormals(null), /^vertexData: null is not a VertexData/], [() => babylon.computeNormals(new VertexData()), /^vertexData: it has no positions/],
    [() => babylon.computeTangents(babylonRoof(makeRoof(7))), /^vertexData: it has no normals/], [() => babylon.toCreased(babylonRoof(makeRoof(7)), { crease: 1000 }), /^crease: 1000 is out of range/],
    [() => babylon.computeNormals(babylonRoof(makeRoof(7)), { creased: 1 }), /^options: creased is not an option/], [() => babylon.toCreased(Object.assign(babylonRoof(makeRoof(7)), { colors: [1, 2] })), /^vertexData\.colors: 2 numbers, where 196 are expected/],
    [() => babylon.computeNormals(Object.assign(babylonRoof(makeRoof(7)), { indices: [0, 1, 99] })), /^indices: number 2 is 99, but there are only 49 positions/],
    [() => babylon.computeTangents(babylonRoof(makeRoof(7)), { texcoord: 6 }), /^texcoord: 6 is not a whole number from 0 to 5/],
  ];
  for (const [work, expected] of errors) check(`Babylon.js: ${expected.source}`, expected.test(thrown(work)), thrown(work));
}

/* ---- PlayCanvas */
const canvas = { width: 1, height: 1, addEventListener() {}, removeEventListener() {}, getBoundingClientRect: () => ({ width: 1, height: 1 }) }, device = new pc.NullGraphicsDevice(canvas);
function playcanvasRoof(roof, change = () => {}) {
  const mesh = new pc.Mesh(device), count = roof.positions.length / 3;
  mesh.setPositions(roof.positions);
  mesh.setUvs(0, roof.uvs);
  mesh.setColors32(Uint8Array.from(roof.colours, (x) => 255 * x));
  mesh.setVertexStream(pc.SEMANTIC_BLENDINDICES, Uint8Array.from({ length: 4 * count }, (_, i) => i % 7), 4, count, pc.TYPE_UINT8);
  change(mesh, count);
  mesh.setIndices(roof.indices);
  mesh.update();
  return mesh;
}
function streamsOf(mesh) {
  const get = (name) => { const all = []; mesh.getVertexStream(name, all); return all; }, indices = [];
  mesh.getIndices(indices);
  return { positions: get(pc.SEMANTIC_POSITION), uvs: get(pc.SEMANTIC_TEXCOORD0), colours: get(pc.SEMANTIC_COLOR), joints: get(pc.SEMANTIC_BLENDINDICES), normals: get(pc.SEMANTIC_NORMAL), tangents: get(pc.SEMANTIC_TANGENT), indices };
}
for (const seed of [1, 2, 3])
  await attempt(`PlayCanvas, roof ${seed}: creases by definition, all streams carried with their types, tangents by dP/du and dP/dv`, () => {
    const roof = makeRoof(seed), mesh = playcanvasRoof(roof), before = streamsOf(mesh), made = playcanvas.toCreased(mesh, { crease: 50 }), after = streamsOf(made);
    must(made !== mesh && made instanceof pc.Mesh && mesh.vertexBuffer.numVertices === 49 && made.vertexBuffer.numVertices === 56, `${made.vertexBuffer.numVertices} vertices`);
    sameCorners(before, after, { positions: 3, uvs: 2, colours: 4, joints: 4 });
    judgeNormals(after, roof, 1);
    const elements = Object.fromEntries(made.vertexBuffer.format.elements.map((element) => [element.name, element]));
    must(elements.COLOR.dataType === pc.TYPE_UINT8 && elements.COLOR.normalize && made.primitive[0].count === roof.indices.length && made.aabb.halfExtents.equals(mesh.aabb.halfExtents), "a format became another");
    playcanvas.computeTangents(made);
    const whole = streamsOf(made), theirs = pc.calculateTangents(whole.positions, whole.normals, whole.uvs, whole.indices);
    judgeTangents(whole, 1);
    must(theirs.every((w, i) => i % 4 !== 3 || w === whole.tangents[i]), "w is another than that of calculateTangents");
    playcanvas.computeTangents(made, { negateSign: true });
    judgeTangents(streamsOf(made), -1);
  });
await attempt("PlayCanvas: normals in place, also over normals in bytes", () => {
  const roof = makeRoof(8), mesh = playcanvasRoof(roof, (one, count) => one.setVertexStream(pc.SEMANTIC_NORMAL, new Int8Array(4 * count), 4, count, pc.TYPE_INT8, true)), smooth = playcanvas.computeNormals(mesh, { report: true });
  must(smooth.mesh === mesh && smooth.report.cancelled === 0 && mesh.vertexBuffer.numVertices === 49, "another mesh");
  const { normals } = streamsOf(mesh);
  must(normals.length === 147 && normals.every((_, i) => i % 3 || Math.abs(Math.hypot(...row(normals, 3, i / 3)) - 1) < 1e-6), "no unit normals");
});
await attempt("PlayCanvas: positions in 16 bits, and without an index", () => {
  const mesh = new pc.Mesh(device), points = Int16Array.of(0, 0, 0, 300, 0, 0, 0, 200, 0, 0, 0, 9, 0, 200, 9, 300, 0, 9);
  mesh.setVertexStream(pc.SEMANTIC_POSITION, points, 3, 6, pc.TYPE_INT16, true);
  mesh.update();
  playcanvas.computeNormals(mesh);
  must(!mesh.indexBuffer[0] && mesh.primitive[0].count === 6 && streamsOf(mesh).normals.join() === "0,0,1,0,0,1,0,0,1,0,0,-1,0,0,-1,0,0,-1", streamsOf(mesh).normals.join());
});
{
  const roof = makeRoof(9), lines = playcanvasRoof(roof), morphed = playcanvasRoof(roof), halves = playcanvasRoof(roof);
  lines.primitive[0].type = pc.PRIMITIVE_LINES;
  morphed.morph = new pc.Morph([new pc.MorphTarget({ deltaPositions: new Float32Array(147) })], device);
  halves.vertexBuffer.format.elements.find(({ name }) => name === pc.SEMANTIC_POSITION).dataType = pc.TYPE_FLOAT16;
  const errors = [
    [() => playcanvas.computeNormals({}), /^mesh: an object with nothing in it is not a Mesh/], [() => playcanvas.computeNormals(new pc.Mesh(device)), /^mesh: it has no vertices on the graphics card yet; call its update\(\) first/],
    [() => playcanvas.computeNormals(lines), /^mesh: it is not a list of triangles/], [() => playcanvas.toCreased(morphed, { crease: 30 }), /^mesh: it has morph targets/],
    [() => playcanvas.computeTangents(playcanvasRoof(roof)), /^mesh: it has no NORMAL/], [() => playcanvas.computeNormals(halves), /^mesh: its POSITION is not of at least 3 floats/],
  ];
  for (const [work, expected] of errors) check(`PlayCanvas: ${expected.source}`, expected.test(thrown(work)), thrown(work));
  check("PlayCanvas: a mesh with morph targets keeps them where no vertex is added", playcanvas.toCreased(morphed, { crease: 180 }).morph === morphed.morph);
}

/* ---- React */
globalThis.IS_REACT_ACT_ENVIRONMENT = true;
const roofGeometry = (seed) => { const roof = makeRoof(seed); return new THREE.BufferGeometry().setAttribute("position", new THREE.Float32BufferAttribute(roof.positions, 3)).setIndex(roof.indices); };
function Roof({ geometry, options }) { return createElement("mesh", { geometry: useCreasedGeometry(geometry, options) }); }
for (const strict of [false, true])
  await attempt(`React${strict ? ", strict" : ""}: suspends, computes once, anew for other options, and disposes of each`, async () => {
    const geometry = roofGeometry(1), scene = (options) => createElement(strict ? StrictMode : Suspense, null, createElement(Suspense, { fallback: null }, createElement(Roof, { geometry, options })));
    const renderer = await ReactThreeTestRenderer.create(scene({ crease: 50 })), drawn = () => renderer.scene.children[0]?.instance.geometry;
    await ReactThreeTestRenderer.act(async () => { for (let i = 0; i < 200 && !drawn(); i++) await new Promise((resolve) => setTimeout(resolve, 10)); });
    const first = drawn(), gone = [];
    must(first.attributes.position.count === 56 && first !== geometry, `${first.attributes.position.count} vertices`);
    judgeNormals({ positions: first.attributes.position.array, indices: first.index.array, normals: first.attributes.normal.array }, makeRoof(1), 1);
    first.addEventListener("dispose", () => gone.push("first"));
    await renderer.update(scene({ crease: 50 }));
    must(drawn() === first && !gone.length, "equal options gave another geometry");
    await renderer.update(scene({ crease: 180 }));
    const second = drawn();
    second.addEventListener("dispose", () => gone.push("second"));
    must(second.attributes.position.count === 49 && gone.join() === "first", gone.join());
    await renderer.unmount();
    must(gone.join() === "first,second", gone.join());
  });
check("React: an option that does not exist", /^options: creas is not an option of this call/.test(thrown(() => useCreasedGeometry(roofGeometry(1), { creas: 1 }))));
finish();
