/* The npm package beside three.js and meshoptimizer, one thread, in one run: computeVertexNormals (weighted by area, vertices shared by index), also by a plan of the mesh, toCreasedNormals, and generateNormals (one normal
 * per corner, creases at 60 degrees, equal positions shared); tangents beside meshoptimizer's and those of three.js's addon (which takes corners, not indices). Then the page, in headless
 * Chromium with its software renderer, where there is one: how long it takes to compute 200,000 triangles anew when a slider or a choice changes.
 *   node bench/bench_web.mjs [--json] [--page] [PACKAGE] [NODE_MODULES] [MESH.obj...]        build/web/npm and build/npm-web/node_modules; the page is norma.html beside the package
 *   --page: the page only; with meshes these and nothing else
 * Times are the least of several calls, in milliseconds, output arrays reused where the interface allows it; ratio: three.js over Norma. */
import { cpSync, existsSync, mkdirSync, mkdtempSync, readFileSync, rmSync, symlinkSync } from "node:fs";
import { tmpdir } from "node:os";
import { basename, dirname, join, resolve } from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";
import { findChrome, launch } from "../tests/web/chrome.mjs";
import { waves } from "../tests/web/shapes.mjs";

const root = join(dirname(fileURLToPath(import.meta.url)), "..");
const files = process.argv.slice(2).filter((word) => word.endsWith(".obj"));
const words = process.argv.slice(2).filter((word) => !word.startsWith("--") && !word.endsWith(".obj"));
const json = process.argv.includes("--json"), onlyPage = process.argv.includes("--page");
const folder = resolve(words[0] ?? join(root, "build/web/npm")), modules = resolve(words[1] ?? join(root, "build/npm-web/node_modules"));
if (!existsSync(join(folder, "node.js")) || !existsSync(join(modules, "three"))) {
  console.error("bench_web: needs `make web` and three.js (scripts/install-deps.sh)");
  process.exit(1);
}
/* norma-mesh/three asks for three by its name: as a user has it, both lie in one folder. */
const place = mkdtempSync(join(tmpdir(), "norma-bench-"));
mkdirSync(join(place, "node_modules"));
symlinkSync(join(modules, "three"), join(place, "node_modules/three"));
cpSync(folder, join(place, "node_modules/norma-mesh"), { recursive: true });
process.on("exit", () => rmSync(place, { recursive: true }));
const own = join(place, "node_modules/norma-mesh");
const { load } = await import(pathToFileURL(join(own, "node.js")));
const { computeNormals, toCreased } = await import(pathToFileURL(join(own, "three.js")));
const { BufferAttribute, BufferGeometry, REVISION } = await import(pathToFileURL(join(modules, "three/build/three.module.js")));
const { toCreasedNormals } = await import(pathToFileURL(join(modules, "three/examples/jsm/utils/BufferGeometryUtils.js")));
const { generateTangents } = await import(pathToFileURL(join(modules, "three/examples/jsm/libs/mikktspace.module.js")));
const norma = await load();
const rivals = join(root, "build/npm-bench/node_modules/meshoptimizer"), meshopt = existsSync(rivals) ? (await import(pathToFileURL(join(rivals, "meshopt_tangents.js")))).MeshoptTangents : null;
const version = meshopt && JSON.parse(readFileSync(join(rivals, "package.json"), "utf8")).version;
await meshopt?.ready;

/* The least time of as many calls as fit into the budget, at least three: compilers at run time have warmed up by then. */
function least(budget, call) {
  let best = Infinity, spent = 0;
  for (let i = 0; i < 3 || (spent < budget); i++) {
    const begin = performance.now();
    call();
    const took = performance.now() - begin;
    best = Math.min(best, took);
    spent += took;
  }
  return best;
}

/* toCreasedNormals takes vertices in one hundredth for one: of smaller triangles it makes other normals, and takes several times as long. */
function enlarged({ positions, indices }) {
  return { positions: positions.map((x) => 100 * x), indices };
}

/* Vertices in random order, the faces with them and in random order too. */
function shuffled({ positions, indices }) {
  let state = 1;
  const order = (count) => {
    const numbers = Uint32Array.from({ length: count }, (_, i) => i);
    for (let i = count - 1; i > 0; i--) {
      state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
      const j = Math.floor((state / 4294967296) * (i + 1));
      [numbers[i], numbers[j]] = [numbers[j], numbers[i]];
    }
    return numbers;
  };
  const vertices = order(positions.length / 3), faces = order(indices.length / 3), moved = new Float32Array(positions.length), corners = new Uint32Array(indices.length);
  vertices.forEach((to, from) => moved.set(positions.subarray(3 * from, 3 * from + 3), 3 * to));
  faces.forEach((to, from) => { for (let k = 0; k < 3; k++) corners[3 * to + k] = vertices[indices[3 * from + k]]; });
  return { positions: moved, indices: corners };
}

/* The faces of an OBJ as fans of triangles, as large as the waves. */
function readObj(path) {
  const rows = readFileSync(path, "utf8").split("\n").map((line) => line.trim().split(/\s+/)), faces = rows.filter(([word]) => word === "f");
  const positions = rows.filter(([word]) => word === "v").flatMap((row) => row.slice(1, 4).map(Number)), size = positions.reduce((most, x) => Math.max(most, Math.abs(x)), 0), vertex = (word) => { const number = parseInt(word, 10); return number < 0 ? positions.length / 3 + number : number - 1; };
  const indices = faces.flatMap(([, ...corners]) => corners.slice(2).flatMap((_, i) => [corners[0], corners[i + 1], corners[i + 2]].map(vertex)));
  return { name: basename(path, ".obj").slice(0, 8), positions: Float32Array.from(positions, (x) => (100 * x) / size), indices: Uint32Array.from(indices) };
}

/* Those that were named, or waves in two orders. */
function* meshes() {
  for (const path of files) yield readObj(path);
  for (const [columns, lines] of onlyPage || files.length ? [] : [[25, 20], [100, 50], [400, 250], [1000, 500]]) {
    const plain = enlarged(waves(columns, lines));
    yield { name: "rows", ...plain };
    yield { name: "shuffled", ...shuffled(plain) };
  }
}

/* The least times of tangents: vertices' normals, and a flat texture that leans a little. */
function timeTangents(positions, indices, budget) {
  const normals = norma.vertexNormals(positions, indices), texcoords = new Float32Array((positions.length / 3) * 2), out = new Float32Array(4 * indices.length);
  for (let i = 0; i < texcoords.length / 2; i++) {
    const [x, y] = positions.subarray(3 * i);
    texcoords.set([x + 0.1 * y * y, y + 0.2 * x * x], 2 * i);
  }
  const perCorner = (values, size) => Float32Array.from({ length: size * indices.length }, (_, i) => values[size * indices[Math.floor(i / size)] + (i % size)]);
  const corners = [perCorner(positions, 3), perCorner(normals, 3), perCorner(texcoords, 2)];
  return {
    three_tangents: least(budget, () => generateTangents(...corners)),
    meshopt_tangents: meshopt ? least(budget, () => meshopt.generateTangents(indices, positions, 3, normals, 3, texcoords, 2)) : NaN,
    norma_tangents: least(budget, () => norma.tangents(positions, normals, texcoords, indices, { out })),
    norma_steady: least(budget, () => norma.tangents(positions, normals, texcoords, indices, { mode: "steady", out })),
  };
}

const rows = [];
for (const { name: order, positions, indices } of meshes()) {
  const budget = indices.length > 1e6 ? 1500 : 500;
  const geometry = new BufferGeometry().setAttribute("position", new BufferAttribute(positions, 3)).setIndex(new BufferAttribute(indices, 1)), ours = geometry.clone();
  const out = new Float32Array(positions.length), corners = new Float32Array(3 * indices.length);
  const plan = norma.plan(positions, indices, { weight: "area", weld: "none" });
  plan.positions.set(positions);
  const planned = least(budget, () => plan.update(plan.positions, { out: plan.normals }));
  plan.free();
  rows.push({
    triangles: indices.length / 3, order,
    three_vertex: least(budget, () => geometry.computeVertexNormals()), norma_vertex: least(budget, () => computeNormals(ours, { weight: "area", weld: "none" })), norma_plan: planned,
    norma_vertex_default: least(budget, () => norma.vertexNormals(positions, indices, { out })),
    three_creased: least(budget, () => toCreasedNormals(geometry, Math.PI / 3)), norma_creased: least(budget, () => toCreased(ours, { crease: 60 })),
    meshopt_corners: meshopt ? least(budget, () => meshopt.generateNormals(indices, positions, 3, Math.PI / 3)) : NaN, norma_corners: least(budget, () => norma.cornerNormals(positions, indices, { crease: 60, out: corners })),
    ...timeTangents(positions, indices, budget),
  });
}

/* ---- the page: what its own clock says of each change, from the control's event to the normals, drawing left out; and the whole of it, upload and picture included. A fourth entry is chosen
 * before each value, and not measured. */

const CHANGES = [
  ["crease 30 to 90", "crease", [30, 36, 42, 48, 54, 60, 66, 72, 78, 84, 90]], ["crease 1 to 10, most edges cut", "crease", [1, 2, 3, 4, 5, 6, 7, 8, 9, 10]],
  ["weight", "weight", ["area", "angle", "max", "uniform", "angle-area", "angle-lengths", "angle"]], ["weight visible, the first time", "weight", ["visible"]], ["weight visible, again", "weight", ["visible", "visible", "visible", "visible", "visible"], "angle"],
  ["its crease 30 to 90", "crease", [30, 45, 60, 75, 90]], ["its crease 1 to 3, most edges cut", "crease", [3, 2.5, 2, 1.5, 1]],
];

/* In the page. Resolves to the milliseconds that its facts give and those until the next picture was done. */
const change = (id, value) => `new Promise((done) => {
  const control = document.getElementById(${JSON.stringify(id)}), drawn = () => Number(document.body.dataset.drawn), before = drawn(), begin = performance.now();
  control.value = ${JSON.stringify(String(value))};
  control.dispatchEvent(new Event(control.tagName === "SELECT" ? "change" : "input", { bubbles: true }));
  const look = () => drawn() > before ? done([Number(/in ([0-9.]+) ms/.exec(document.getElementById("compute-facts").textContent)[1]), performance.now() - begin]) : requestAnimationFrame(look);
  requestAnimationFrame(look);
})`;

const middle = (list) => list.sort((a, b) => a - b)[list.length >> 1];

async function measurePage(file, chrome) {
  const browser = await launch(chrome, { width: 840, height: 520 });
  try {
    const page = await browser.open(pathToFileURL(file).href);
    await page.until("document.body?.dataset.drawn > 0", 40);
    await page.evaluate(change("model", "fine"));
    await page.evaluate(change("sides", "right"));
    const measured = [];
    for (const [name, id, values, before] of CHANGES) {
      const times = [];
      for (const value of values) {
        if (before) await page.evaluate(change(id, before));
        times.push(await page.evaluate(change(id, value)));
      }
      measured.push({ name, least: Math.min(...times.map(([own]) => own)), middle: middle(times.map(([own]) => own)), most: Math.max(...times.map(([own]) => own)), with_picture: middle(times.map(([, all]) => all)) });
    }
    return measured;
  } finally {
    await browser.close();
  }
}

const file = join(folder, "../norma.html"), chrome = findChrome();
const page = existsSync(file) && chrome && !files.length ? await measurePage(file, chrome) : null;

if (json) {
  console.log(JSON.stringify({ node: process.version, three: REVISION, rows, page }));
} else {
  const ms = (time) => time.toFixed(time < 1 ? 3 : time < 10 ? 2 : 0).padStart(8), ratio = (a, b) => (a / b).toFixed(1).padStart(6);
  console.log(`node ${process.version}, three.js r${REVISION}; milliseconds`);
  console.log(`meshoptimizer ${meshopt ? version : "is not installed"}; ratio: theirs over ours, corner normals: ours over theirs`);
  console.log("triangles order    | computeVertexNormals computeNormals  ratio     a plan  ratio | vertexNormals, defaults | toCreasedNormals  toCreased  ratio | generateNormals cornerNormals  ratio");
  for (const row of rows)
    console.log(`${String(row.triangles).padStart(9)} ${row.order.padEnd(8)} | ${ms(row.three_vertex).padStart(20)} ${ms(row.norma_vertex).padStart(14)} ${ratio(row.three_vertex, row.norma_vertex)} ${ms(row.norma_plan).padStart(10)} ${ratio(row.three_vertex, row.norma_plan)} | ${ms(row.norma_vertex_default).padStart(23)} | ` +
                `${ms(row.three_creased).padStart(16)} ${ms(row.norma_creased).padStart(10)} ${ratio(row.three_creased, row.norma_creased)} | ${ms(row.meshopt_corners).padStart(15)} ${ms(row.norma_corners).padStart(13)} ${(row.norma_corners / row.meshopt_corners).toFixed(2).padStart(6)}`);
  console.log("tangents: triangles order | three.js's addon meshoptimizer     mikk   steady | ratio of mikk: to three.js  to meshoptimizer");
  for (const row of rows)
    console.log(`${String(row.triangles).padStart(19)} ${row.order.padEnd(8)} | ${ms(row.three_tangents).padStart(16)} ${ms(row.meshopt_tangents).padStart(13)} ${ms(row.norma_tangents)} ${ms(row.norma_steady)} | ` +
                `${ratio(row.three_tangents, row.norma_tangents).padStart(23)} ${(row.meshopt_tangents / row.norma_tangents).toFixed(2).padStart(17)}`);
  if (!page) console.log("the page: no browser, or no page");
  else {
    console.log("the page, 200,000 triangles computed anew, milliseconds | least  middle  most | the picture included, middle");
    for (const { name, least, middle, most, with_picture } of page) console.log(`  ${name.padEnd(52)} | ${[least, middle, most, with_picture].map(ms).join(" ")}`);
  }
}
