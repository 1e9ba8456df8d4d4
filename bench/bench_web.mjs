/* The npm package beside three.js, one thread, in one run: computeVertexNormals (weighted by area, vertices shared by index), also by a plan of the mesh, and toCreasedNormals. Then the page, in headless
 * Chromium with its software renderer, where there is one: how long it takes to compute 200,000 triangles anew when a slider or a choice changes.
 *   node bench/bench_web.mjs [--json] [--page] [PACKAGE] [NODE_MODULES]        build/web/npm and build/npm-web/node_modules; the page is norma.html beside the package
 *   --page: the page only
 * Times are the least of several calls, in milliseconds, output arrays reused where the interface allows it; ratio: three.js over Norma. */
import { existsSync } from "node:fs";
import { dirname, join, resolve } from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";
import { findChrome, launch } from "../tests/web/chrome.mjs";
import { waves } from "../tests/web/shapes.mjs";

const root = join(dirname(fileURLToPath(import.meta.url)), "..");
const words = process.argv.slice(2).filter((word) => !word.startsWith("--"));
const json = process.argv.includes("--json"), onlyPage = process.argv.includes("--page");
const folder = resolve(words[0] ?? join(root, "build/web/npm")), modules = resolve(words[1] ?? join(root, "build/npm-web/node_modules"));
if (!existsSync(join(folder, "node.js")) || !existsSync(join(modules, "three"))) {
  console.error("bench_web: needs `make web` and three.js (scripts/install-deps.sh)");
  process.exit(1);
}
const { load } = await import(pathToFileURL(join(folder, "node.js")));
const { BufferAttribute, BufferGeometry, REVISION } = await import(pathToFileURL(join(modules, "three/build/three.module.js")));
const { toCreasedNormals } = await import(pathToFileURL(join(modules, "three/examples/jsm/utils/BufferGeometryUtils.js")));
const norma = await load();

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

const sizes = { 10000: [100, 50], 200000: [400, 250], 1000000: [1000, 500] };
const rows = [];
for (const [triangles, [columns, lines]] of onlyPage ? [] : Object.entries(sizes)) {
  const { positions, indices } = waves(columns, lines);
  const geometry = new BufferGeometry().setAttribute("position", new BufferAttribute(positions, 3)).setIndex(new BufferAttribute(indices, 1));
  const out = new Float32Array(positions.length), corners = new Float32Array(3 * indices.length);
  const budget = 500;
  const three = least(budget, () => geometry.computeVertexNormals());
  const creased = least(budget, () => toCreasedNormals(geometry, Math.PI / 3));
  const plan = norma.plan(positions, indices, { weight: "area", weld: "none" });
  plan.positions.set(positions);
  const planned = least(budget, () => plan.update(plan.positions, { out: plan.normals }));
  plan.free();
  rows.push({
    triangles: Number(triangles),
    three_vertex: three, norma_vertex: least(budget, () => norma.vertexNormals(positions, indices, { weight: "area", weld: "none", out })),
    norma_plan: planned,
    norma_vertex_default: least(budget, () => norma.vertexNormals(positions, indices, { out })),
    three_creased: creased, norma_corners: least(budget, () => norma.cornerNormals(positions, indices, { crease: 60, out: corners })),
    norma_split: least(budget, () => norma.split(positions, indices, { crease: 60 })),
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
const page = existsSync(file) && chrome ? await measurePage(file, chrome) : null;

if (json) {
  console.log(JSON.stringify({ node: process.version, three: REVISION, rows, page }));
} else {
  const ms = (time) => time.toFixed(time < 10 ? 2 : 0).padStart(8), ratio = (a, b) => (a / b).toFixed(1).padStart(6);
  console.log(`node ${process.version}, three.js r${REVISION}; milliseconds`);
  console.log("triangles | computeVertexNormals   area, by index  ratio     a plan  ratio   defaults | toCreasedNormals  cornerNormals  ratio      split  ratio");
  for (const row of rows)
    console.log(`${String(row.triangles).padStart(9)} | ${ms(row.three_vertex).padStart(20)} ${ms(row.norma_vertex).padStart(16)} ${ratio(row.three_vertex, row.norma_vertex)} ${ms(row.norma_plan).padStart(10)} ${ratio(row.three_vertex, row.norma_plan)} ${ms(row.norma_vertex_default).padStart(10)} | ` +
                `${ms(row.three_creased).padStart(16)} ${ms(row.norma_corners).padStart(14)} ${ratio(row.three_creased, row.norma_corners)} ${ms(row.norma_split).padStart(10)} ${ratio(row.three_creased, row.norma_split)}`);
  if (!page) console.log("the page: no browser, or no page");
  else {
    console.log("the page, 200,000 triangles computed anew, milliseconds | least  middle  most | the picture included, middle");
    for (const { name, least, middle, most, with_picture } of page) console.log(`  ${name.padEnd(52)} | ${[least, middle, most, with_picture].map(ms).join(" ")}`);
  }
}
