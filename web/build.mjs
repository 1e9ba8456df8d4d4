/* Puts together what `make web` leaves.
 *   node build.mjs package FOLDER MODULES    FOLDER/npm, from FOLDER/norma.wasm, check.wasm, tool.wasm, skin.wasm and normals.wasm
 *   node build.mjs page FOLDER MODULES       FOLDER/norma.html, one file with everything in it, from FOLDER/page.wasm
 * MODULES: the npm packages of web/package-lock.json, whose licences go along; what is not there is left out. */
import { execFileSync } from "node:child_process";
import { copyFileSync, existsSync, mkdirSync, readdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { dirname, join, resolve } from "node:path";
import { fileURLToPath } from "node:url";
import { deflateRawSync, deflateSync } from "node:zlib";

const here = dirname(fileURLToPath(import.meta.url));

/* What the page alone holds. */
const PAGE_LIBRARIES = { mediabunny: { licence: "LICENSE" }, three: { licence: "LICENSE" } };
/* meshoptimizer in the version of Debian's library: what the page writes are the tool's bytes. */
const LIBRARIES = {
  draco3dgltf: { licence: join(here, "licences/draco3dgltf.txt"), files: ["draco_decoder_gltf_nodejs.js", "draco_decoder_gltf.wasm"] },
  meshoptimizer: { licence: "LICENSE.md", files: ["meshopt_decoder.module.js", "meshopt_encoder.module.js"] },
  fflate: { licence: "LICENSE", files: ["esm/browser.js"] },
};
const hasLibrary = (modules, name) => LIBRARIES[name].files.every((file) => existsSync(join(modules, name, file)));

/* Empty modules stand where a library is left out: nothing ever calls them. Draco's own script asks for modules of node's where it finds node; it is handed its WebAssembly, and needs none. */
function aliases(folder, modules) {
  const nothing = join(folder, "nothing.js"), path = ([name, { files }]) => files.filter((file) => /js$/.test(file)).map((file) => [`${name}/${file}`, hasLibrary(modules, name) ? join(modules, name, file) : nothing]);
  writeFileSync(nothing, "export const MeshoptDecoder = null, MeshoptEncoder = null, Inflate = null, deflateSync = null;\nexport default null;\n");
  return [...Object.entries(LIBRARIES).flatMap(path), ["fs", nothing], ["path", nothing]].map(([name, place]) => `--alias:${name}=${place}`);
}

/* All modules that start imports as one script (esbuild). */
function bundle(start, folder, modules, more = ["--format=iife"]) {
  const options = ["--bundle", "--minify", ...["process", "__filename", "__dirname"].map((name) => `--define:${name}=undefined`), "--target=es2020", "--charset=utf8", "--log-level=warning", ...aliases(folder, modules), ...more];
  return execFileSync(process.env.ESBUILD || "esbuild", [start, ...options], { encoding: "utf8", maxBuffer: 1 << 26, env: { ...process.env, NODE_PATH: modules } });
}

/* The licences of what package and page hold of others. */
function readNotices(modules, more = {}) {
  const texts = [...Object.entries(LIBRARIES).filter(([name]) => hasLibrary(modules, name)), ...Object.entries(more)].map(([name, { licence }]) => [name, readFileSync(resolve(modules, name, licence), "utf8").trim()]);
  return texts.map(([name, text]) => `Here is code of ${name}, from npm:\n\n${text}\n`).join("\n\n");
}

/* A module without anything stands where Draco was left out: bundlers find the file, and nothing ever loads it. */
const EMPTY = Buffer.from([0x00, 0x61, 0x73, 0x6d, 0x01, 0x00, 0x00, 0x00]);
const readDraco = (modules) => (hasLibrary(modules, "draco3dgltf") ? readFileSync(join(modules, "draco3dgltf/draco_decoder_gltf.wasm")) : EMPTY);

function buildPackage(folder, modules) {
  const out = join(folder, "npm"), source = join(here, "package"), made = ["draco-decoder.js", "meshopt-decoder.js", "meshopt-encoder.js", "deflate.js"];
  rmSync(out, { recursive: true, force: true });
  mkdirSync(out, { recursive: true });
  for (const name of readdirSync(source)) if (/\.(js|ts|json|md)$/.test(name) && name !== "worker-inline.js" && !made.includes(name)) copyFileSync(join(source, name), join(out, name));
  copyFileSync(join(here, "..", "LICENSE"), join(out, "LICENSE"));
  const textModule = (name, about, text) => writeFileSync(join(out, name), `/* ${about} */\nexport default ${JSON.stringify(text)};\n`);
  writeFileSync(join(out, "NOTICES"), readNotices(modules));
  for (const name of made) writeFileSync(join(out, name), bundle(join(source, name), folder, modules, ["--format=esm"]));
  for (const name of ["norma", "check", "draco", "tool"]) {
    const bytes = name === "draco" ? readDraco(modules) : readFileSync(join(folder, `${name}.wasm`));
    writeFileSync(join(out, `${name}.wasm`), bytes);
    textModule(`${name}-text.js`, `${name}.wasm in base64.`, bytes.toString("base64"));
  }
  textModule("skin-text.js", "skin.wasm in base64.", readFileSync(join(folder, "skin.wasm")).toString("base64"));
  textModule("normals-text.js", "normals.wasm, deflated, in base64.", deflateSync(readFileSync(join(folder, "normals.wasm")), { level: 9 }).toString("base64"));
  const shaders = ["glsl", "hlsl", "wgsl"].map((language) => `export const ${language} = ${JSON.stringify(readFileSync(join(here, `../include/norma/shaders/norma.${language}`), "utf8"))};\n`);
  writeFileSync(join(out, "shaders.js"), `/* norma.glsl, norma.hlsl and norma.wgsl. */\n${shaders.join("")}`);
  textModule("worker-text.js", "The worker of norma-mesh/inline as one script.", bundle(join(source, "worker-inline.js"), folder, modules));
}

/* ---- the page */

function readShaders() {
  const shaders = join(here, "..", "src", "render", "shaders");
  const names = ["colour.glsl", "light.glsl", "surface.vert", "surface.frag", "line.vert", "line.frag"];
  const own = join(here, "page", "shaders"), texts = [["norma.glsl", join(here, "../include/norma/shaders/norma.glsl")], ...names.map((name) => [name, join(shaders, name)]), ...readdirSync(own).map((name) => [name, join(own, name)])];
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

function buildPage(folder, modules) {
  const page = join(here, "page");
  /* No closing tag may stand in what lies within one. */
  const guard = (text) => text.replaceAll("</", "<\\/");
  const parts = {
    STYLE: readFileSync(join(page, "style.css"), "utf8"),
    WASM: packModule(readFileSync(join(folder, "page.wasm"))),
    NOTICES: guard(readNotices(modules, PAGE_LIBRARIES)),
    WORKER: guard(bundle(join(page, "worker.js"), folder, modules)),
    SCRIPT: guard(`${readShaders()}\n${bundle(join(page, "main.js"), folder, modules)}`),
  };
  const text = readFileSync(join(page, "index.html"), "utf8").replace(/\/\*(STYLE|WASM|NOTICES|WORKER|SCRIPT)\*\//g, (_, name) => parts[name]);
  const sculpture = packSculpture(join(here, "..", "assets", "goathead.obj")), draco = hasLibrary(modules, "draco3dgltf") ? packModule(readDraco(modules)) : "", whole = text.replace("/*DRACO*/", draco);
  /* The page of norma view has a model of its own. */
  writeFileSync(join(folder, "page.html"), whole.replace("/*SCULPTURE*/", ""));
  writeFileSync(join(folder, "norma.html"), whole.replace("/*NAME*/", "").replace("/*MODEL*/", "").replace("/*FILES*/", "").replace("/*SCULPTURE*/", sculpture));
}

const [what, folder, modules] = process.argv.slice(2);
const works = { package: buildPackage, page: buildPage };
if (!works[what] || !modules) {
  console.error(`usage: node build.mjs ${Object.keys(works).join("|")} FOLDER MODULES`);
  process.exit(2);
}
works[what](resolve(folder), resolve(modules));
