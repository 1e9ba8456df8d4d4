/* Puts together what `make web` leaves.
 *   node build.mjs package FOLDER SOURCES    FOLDER/npm, from FOLDER/norma.wasm, check.wasm and draco.wasm
 *   node build.mjs page FOLDER SOURCES       FOLDER/norma.html, one file with everything in it, from FOLDER/page.wasm and draco.wasm
 * SOURCES: where the sources of others lie, whose licences go with what was made of them. */
import { execFileSync } from "node:child_process";
import { copyFileSync, existsSync, mkdirSync, readdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { deflateRawSync } from "node:zlib";

const here = dirname(fileURLToPath(import.meta.url));

/* All modules that start imports as one script (esbuild). */
function bundle(start, more = []) {
  const options = ["--bundle", "--format=iife", "--target=es2020", "--charset=utf8", "--log-level=warning"];
  return execFileSync(process.env.ESBUILD || "esbuild", [start, ...options, ...more], { encoding: "utf8", maxBuffer: 1 << 26 });
}

/* The licences of what the modules hold of others. */
function readNotices(sources) {
  const texts = [["meshoptimizer", "LICENSE.md"], ["draco", "LICENSE"]].map(([name, file]) => [name, join(sources, name, file)]).filter(([, path]) => existsSync(path));
  return texts.map(([name, path]) => `The WebAssembly modules hold code of ${name}:\n\n${readFileSync(path, "utf8").trim()}\n`).join("\n\n");
}

/* A module without anything stands where Draco was left out: bundlers find the file, and nothing ever loads it. */
const EMPTY = Buffer.from([0x00, 0x61, 0x73, 0x6d, 0x01, 0x00, 0x00, 0x00]);
const readModule = (folder, name) => (name !== "draco" || existsSync(join(folder, "draco.wasm")) ? readFileSync(join(folder, `${name}.wasm`)) : EMPTY);

function buildPackage(folder, sources) {
  const out = join(folder, "npm"), source = join(here, "package");
  rmSync(out, { recursive: true, force: true });
  mkdirSync(out, { recursive: true });
  for (const name of readdirSync(source)) if (/\.(js|ts|json|md)$/.test(name) && name !== "worker-inline.js") copyFileSync(join(source, name), join(out, name));
  copyFileSync(join(here, "..", "LICENSE"), join(out, "LICENSE"));
  const textModule = (name, about, text) => writeFileSync(join(out, name), `/* ${about} */\nexport default ${JSON.stringify(text)};\n`);
  writeFileSync(join(out, "NOTICES"), readNotices(sources));
  for (const name of ["norma", "check", "draco"]) {
    const bytes = readModule(folder, name);
    writeFileSync(join(out, `${name}.wasm`), bytes);
    textModule(`${name}-text.js`, `${name}.wasm in base64.`, bytes.toString("base64"));
  }
  textModule("worker-text.js", "The worker of norma-mesh/inline as one script.", bundle(join(source, "worker-inline.js"), ["--minify"]));
}

/* ---- the page */

function readShaders() {
  const shaders = join(here, "..", "src", "render", "shaders");
  const names = ["colour.glsl", "light.glsl", "surface.vert", "surface.frag", "line.vert", "line.frag"];
  const own = join(here, "page", "shaders"), texts = [...names.map((name) => [name, join(shaders, name)]), ...readdirSync(own).map((name) => [name, join(own, name)])];
  return `const SHADERS = ${JSON.stringify(Object.fromEntries(texts.map(([name, path]) => [name, readFileSync(path, "utf8")])))};`;
}

/* An OBJ of triangles as bytes: counts of vertices and triangles (32 bits), least and step of each axis (floats), positions and indices (16 bits each). A 65,535th of a sculpture cannot be seen. */
function packSculpture(path) {
  const rows = readFileSync(path, "utf8").split("\n").map((line) => line.trim().split(/\s+/));
  const points = rows.filter(([word]) => word === "v").map((row) => row.slice(1, 4).map(Number)), faces = rows.filter(([word]) => word === "f").map((row) => row.slice(1, 4).map((corner) => parseInt(corner, 10) - 1));
  const least = [0, 1, 2].map((i) => Math.min(...points.map((p) => p[i]))), step = [0, 1, 2].map((i) => (Math.max(...points.map((p) => p[i])) - least[i]) / 65535);
  const bytes = Buffer.alloc(32 + 6 * points.length + 6 * faces.length);
  [points.length, faces.length].forEach((count, i) => bytes.writeUInt32LE(count, 4 * i));
  [...least, ...step].forEach((x, i) => bytes.writeFloatLE(x, 8 + 4 * i));
  points.flatMap((p) => p.map((x, i) => Math.round((x - least[i]) / step[i]))).forEach((x, i) => bytes.writeUInt16LE(x, 32 + 2 * i));
  faces.flat().forEach((corner, i) => bytes.writeUInt16LE(corner, 32 + 6 * points.length + 2 * i));
  return bytes.toString("base64");
}

/* A module as the page holds it (web/page/inflate.js). */
const packModule = (bytes) => deflateRawSync(bytes, { level: 9 }).toString("base64");

function buildPage(folder, sources) {
  const page = join(here, "page");
  /* No closing tag may stand in what lies within one. */
  const guard = (text) => text.replaceAll("</", "<\\/");
  const parts = {
    STYLE: readFileSync(join(page, "style.css"), "utf8"),
    WASM: packModule(readFileSync(join(folder, "page.wasm"))),
    NOTICES: guard(readNotices(sources)),
    WORKER: guard(bundle(join(page, "worker.js"), ["--minify"])),
    SCRIPT: guard(`${readShaders()}\n${bundle(join(page, "main.js"), ["--minify"])}`),
  };
  const text = readFileSync(join(page, "index.html"), "utf8").replace(/\/\*(STYLE|WASM|NOTICES|WORKER|SCRIPT)\*\//g, (_, name) => parts[name]);
  /* The page of norma view needs neither: the tool has read its file. */
  writeFileSync(join(folder, "page.html"), text.replace("/*SCULPTURE*/", "").replace("/*DRACO*/", ""));
  const sculpture = packSculpture(join(here, "..", "assets", "goathead.obj")), draco = existsSync(join(folder, "draco.wasm")) ? packModule(readModule(folder, "draco")) : "";
  writeFileSync(join(folder, "norma.html"), text.replace("/*NAME*/", "").replace("/*MODEL*/", "").replace("/*SCULPTURE*/", sculpture).replace("/*DRACO*/", draco));
}

const [what, folder, sources] = process.argv.slice(2);
const works = { package: buildPackage, page: buildPage };
if (!works[what] || !sources) {
  console.error(`usage: node build.mjs ${Object.keys(works).join("|")} FOLDER SOURCES`);
  process.exit(2);
}
works[what](folder, sources);
