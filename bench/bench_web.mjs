/* The npm package beside three.js, one thread, in one run: computeVertexNormals (weighted by area, vertices shared by index) and toCreasedNormals.
 *   node bench/bench_web.mjs [--json] [PACKAGE] [NODE_MODULES]        build/web/npm and build/npm-web/node_modules
 * Times are the least of several calls, in milliseconds, output arrays reused where the interface allows it; ratio: three.js over Norma. */
import { existsSync } from "node:fs";
import { dirname, join, resolve } from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";
import { waves } from "../tests/web/shapes.mjs";

const root = join(dirname(fileURLToPath(import.meta.url)), "..");
const words = process.argv.slice(2).filter((word) => !word.startsWith("--"));
const json = process.argv.includes("--json");
const folder = resolve(words[0] ?? join(root, "build/web/npm")), modules = resolve(words[1] ?? join(root, "build/npm-web/node_modules"));
if (!existsSync(join(folder, "index.js")) || !existsSync(join(modules, "three"))) {
  console.error("bench_web: needs `make web` and three.js (scripts/install-deps.sh)");
  process.exit(1);
}
const { load } = await import(pathToFileURL(join(folder, "index.js")));
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
for (const [triangles, [columns, lines]] of Object.entries(sizes)) {
  const { positions, indices } = waves(columns, lines);
  const geometry = new BufferGeometry().setAttribute("position", new BufferAttribute(positions, 3)).setIndex(new BufferAttribute(indices, 1));
  const out = new Float32Array(positions.length), corners = new Float32Array(3 * indices.length);
  const budget = 500;
  const three = least(budget, () => geometry.computeVertexNormals());
  const creased = least(budget, () => toCreasedNormals(geometry, Math.PI / 3));
  rows.push({
    triangles: Number(triangles),
    three_vertex: three, norma_vertex: least(budget, () => norma.vertexNormals(positions, indices, { weight: "area", weld: "none", out })),
    norma_vertex_default: least(budget, () => norma.vertexNormals(positions, indices, { out })),
    three_creased: creased, norma_corners: least(budget, () => norma.cornerNormals(positions, indices, { crease: 60, out: corners })),
    norma_split: least(budget, () => norma.split(positions, indices, { crease: 60 })),
  });
}
if (json) {
  console.log(JSON.stringify({ node: process.version, three: REVISION, rows }));
} else {
  const ms = (time) => time.toFixed(time < 10 ? 2 : 0).padStart(8), ratio = (a, b) => (a / b).toFixed(1).padStart(6);
  console.log(`node ${process.version}, three.js r${REVISION}; milliseconds`);
  console.log("triangles | computeVertexNormals   area, by index  ratio   defaults | toCreasedNormals  cornerNormals  ratio      split  ratio");
  for (const row of rows)
    console.log(`${String(row.triangles).padStart(9)} | ${ms(row.three_vertex).padStart(20)} ${ms(row.norma_vertex).padStart(16)} ${ratio(row.three_vertex, row.norma_vertex)} ${ms(row.norma_vertex_default).padStart(10)} | ` +
                `${ms(row.three_creased).padStart(16)} ${ms(row.norma_corners).padStart(14)} ${ratio(row.three_creased, row.norma_corners)} ${ms(row.norma_split).padStart(10)} ${ratio(row.three_creased, row.norma_split)}`);
}
