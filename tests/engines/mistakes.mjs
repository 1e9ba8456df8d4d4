/* The judge's table of docs/acid.md: mistakes are put into the shaders of two engines and of norma render, their pictures are distorted, and what the judge says of each
 * subject is counted by what was put in. About ten minutes (the engines' pictures are kept in build/engines/mistakes); exits with 1 if a verdict is wrong.
 *   node mistakes.mjs [SHOTS]           200
 * Needs build/npm-engines (make engines), and build/mistakes, a norma render that makes mistakes (cmake -B build/mistakes -DNORMA_MISTAKES=ON, see tests/support/mistakes.cmake). */
import { spawnSync } from "node:child_process";
import { existsSync, mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { draw } from "./browser.mjs";
import { findChrome, launch } from "../web/chrome.mjs";

const here = dirname(fileURLToPath(import.meta.url)), root = join(here, "../.."), out = join(root, "build/engines/mistakes");
const norma = process.env.NORMA_BIN ?? join(root, "build/bin/norma"), mistaken = join(root, "build/mistakes/bin/norma");
const shots = Number(process.argv[2] ?? 200), scene = join(out, "scenes/norma-acid.glb");

/* [mistake, cells in which it is put in, [shader, a text that stands in it once, another]...] */
const three = [
  ["object-space", "rotation non-uniform-scale", ["defaultnormal_vertex", "normalMatrix * transformedNormal", "mat3( viewMatrix ) * transformedNormal"]],
  ["model-matrix", "non-uniform-scale shear mirror quantized", ["defaultnormal_vertex", "normalMatrix * transformedNormal", "mat3( modelViewMatrix ) * transformedNormal"]],
  ["not-normalized", "uniform-scale non-uniform-scale morph", ["normal_vertex", "vNormal = normalize( transformedNormal )", "vNormal = transformedNormal"], ["normal_fragment_begin", "vec3 normal = normalize( vNormal )", "vec3 normal = vNormal"]],
  ["reversed", "mirror mirror-double-sided", ["defaultnormal_vertex", "normalMatrix * transformedNormal", "sign( determinant( normalMatrix ) ) * normalMatrix * transformedNormal"]],
  ["model-matrix", "instanced", ["defaultnormal_vertex", "transformedNormal /= vec3( dot( im[ 0 ], im[ 0 ] ), dot( im[ 1 ], im[ 1 ] ), dot( im[ 2 ], im[ 2 ] ) );", ""]],
  ["instance-ignored", "instanced", ["defaultnormal_vertex", "transformedNormal /= vec3( dot( im[ 0 ], im[ 0 ] ), dot( im[ 1 ], im[ 1 ] ), dot( im[ 2 ], im[ 2 ] ) );", ""], ["defaultnormal_vertex", "transformedNormal = im * transformedNormal;", ""]],
  ["normals-not-morphed", "morph", ["morphnormal_vertex", "objectNormal += getMorph( gl_VertexID, i, 1 ).xyz * morphTargetInfluences[ i ]", "objectNormal += vec3( 0.0 )"]],
  ["not-flipped", "back-side", ["normal_fragment_begin", "normal *= faceDirection;", ""]],
  ["sign-lost", "tangent-sign", ["normal_vertex", " * tangent.w", ""]],
  ["green-flipped", "tangent-sign", ["normal_fragment_maps", "mapN.xy *= normalScale;", "mapN.xy *= normalScale; mapN.y = - mapN.y;"]],
  ["tangent-by-normal-matrix", "tangent-non-uniform", ["defaultnormal_vertex", "( modelViewMatrix * vec4( transformedTangent, 0.0 ) ).xyz", "normalMatrix * transformedTangent"]],
  ["scale-ignored", "normal-scale", ["normal_fragment_maps", "mapN.xy *= normalScale;", ""]],
  ["scale-on-z", "normal-scale", ["normal_fragment_maps", "mapN.xy *= normalScale;", "mapN.z *= normalScale.x;"]]];
const babylon = [
  ["object-space", "rotation non-uniform-scale", ["pbrVertexShader", "vNormalW=normalize(normalWorld*normalUpdated)", "vNormalW=normalize(normalUpdated)"]],
  ["model-matrix", "non-uniform-scale shear mirror quantized", ["pbrVertexShader", "normalWorld=transposeMat3(inverseMat3(normalWorld));", ""]],
  ["not-normalized", "non-uniform-scale morph", ["pbrVertexShader", "vNormalW=normalize(normalWorld*normalUpdated)", "vNormalW=normalWorld*normalUpdated"], ["pbrBlockNormalGeometric", "normalize(vNormalW)", "vNormalW"]],
  ["reversed", "mirror mirror-double-sided", ["pbrVertexShader", "vNormalW=normalize(normalWorld*normalUpdated)", "vNormalW=normalize(normalWorld*normalUpdated)*sign(determinant(mat3(finalWorld)))"]],
  ["model-matrix", "instanced", ["pbrVertexShader", "vNormalW=normalUpdated/vec3(dot(normalWorld[0],normalWorld[0]),dot(normalWorld[1],normalWorld[1]),dot(normalWorld[2],normalWorld[2]))", "vNormalW=normalUpdated"]],
  ["normals-not-morphed", "morph", ["morphTargetsVertex", "normalUpdated+=(readVector3FromRawSampler(i,vertexID) -normal)*morphTargetInfluences[i];", ""]],
  ["not-flipped", "back-side", ["pbrBlockNormalFinal", "gl_FrontFacing ? -normalW : normalW", "normalW"], ["pbrBlockNormalFinal", "gl_FrontFacing ? normalW : -normalW", "normalW"]],
  ["sign-lost", "tangent-sign", ["bumpVertex", "*tangentUpdated.w", ""]],
  ["green-flipped", "tangent-sign", ["bumpFragmentMainFunctions", "textureSample*2.0-1.0", "(textureSample*2.0-1.0)*vec3(1.0,-1.0,1.0)"]],
  ["scale-ignored", "normal-scale", ["bumpFragment", "perturbNormal(TBN,TEXRD(bumpSampler,vBumpUV+uvOffset).xyz,vBumpInfos.y)", "perturbNormal(TBN,TEXRD(bumpSampler,vBumpUV+uvOffset).xyz,1.0)"]]];

const change = (table, changes) => `const shaders = ${table}; for (const [name, old, text] of ${JSON.stringify(changes)}) { if (shaders[name].split(old).length !== 2) throw new Error(name + ": " + old); shaders[name] = shaders[name].replace(old, text); }`;
const engines = {
  "three.js": { own: "three", mistakes: three, page: "three", imports: 'import { ShaderChunk } from "three";', table: "ShaderChunk" },
  "Babylon.js": { own: "babylon", mistakes: babylon, page: "babylon", imports: 'import { ShaderStore } from "@babylonjs/core/Engines/shaderStore.js"; import "@babylonjs/core/Shaders/pbr.vertex.js"; import "@babylonjs/core/Shaders/pbr.fragment.js";', table: `new Proxy({}, { get: (_, name) => (ShaderStore.ShadersStore[name] ?? ShaderStore.IncludesShadersStore[name]), set: (_, name, text) => { (name in ShaderStore.ShadersStore ? ShaderStore.ShadersStore : ShaderStore.IncludesShadersStore)[name] = text; return true; } })` },
};

const run = (program, words, env = {}) => spawnSync(program, words, { encoding: "utf8", env: { ...process.env, ...env } });
mkdirSync(out, { recursive: true });
run(norma, ["acid", "-o", join(out, "scenes"), "--quiet"]);
const layout = JSON.parse(readFileSync(join(out, "scenes/acid.json"), "utf8"));
const verdicts = JSON.parse(readFileSync(join(here, "verdicts.json"), "utf8"));
const judge = (picture) => Object.fromEntries(JSON.parse(run(norma, ["acid", "--judge", picture, "--json"]).stdout || '{"cells": []}').cells.map(({ id, verdict, mistake }) => [id, mistake ? `${verdict}: ${mistake}` : verdict]));

/* pictures: { engine, mistake, path, expected: { cell: what the judge should say } } */
const pictures = [], add = (engine, mistake, path, expected) => pictures.push({ engine, mistake, path, expected });
for (const [engine, { own, mistakes, page, imports, table }] of Object.entries(engines)) {
  const known = Object.fromEntries(Object.entries(verdicts[own].cells).filter(([, verdict]) => /^(pass|fail)/.test(verdict)));
  for (const [index, [mistake, cells, ...changes]] of [["nothing", ""], ...mistakes].entries()) {
    const path = join(out, `${page}-${index}.png`);
    const { drawn } = existsSync(path) ? { drawn: "" } : await draw(page, scene, path, "1600x1200", { imports, before: change(table, changes) });
    if (String(drawn).startsWith("error")) throw new Error(`${engine}, ${mistake}: ${drawn}`);
    add(engine, mistake, path, mistake === "nothing" ? known : Object.fromEntries(cells.split(" ").map((cell) => [cell, `fail: ${mistake}`])));
  }
}
const put = readFileSync(join(here, "../support/mistakes.cmake"), "utf8");
const ids = [...new Set(layout.cells.flatMap(({ references }) => references.map(({ id }) => id)))].filter((id) => id !== "right" && new RegExp(`["_]${id.replaceAll("-", "[-_]")}\\b`).test(put));
for (const mistake of ["nothing", ...ids]) {
  const path = join(out, `norma-${mistake}.png`);
  if (!existsSync(path)) run(mistaken, ["render", scene, "-o", path, "--size", "1600x1200", "--camera", "0,0", "--fov", "0", "--renderer", "software", "--quiet", "--weight", "area"], { NORMA_MISTAKE: mistake });
  const cells = layout.cells.filter(({ id, references }) => mistake === "nothing" || (references.some((r) => r.id === mistake) && id !== "mirror-twice")); // two mirrors make none
  add("norma render", mistake, path, Object.fromEntries(cells.map(({ id }) => [id, mistake === "nothing" ? "pass" : `fail: ${mistake}`])));
}

/* ---- distortions, by a canvas: size, crop or border, exposure, tone curve, gamma, JPEG */

let seed = 39;
const random = (low, high) => { seed = (seed * 1664525 + 1013904223) % 4294967296; return low + (high - low) * seed / 4294967296; };
const curves = ["x / (1 + x) * 1.6", "x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)", "(x * (0.15 * x + 0.05) + 0.004) / (x * (0.15 * x + 0.5) + 0.06) - 0.0667"]; // Reinhard; Narkowicz's fit of ACES; Hable
const chrome = await launch(findChrome(), { width: 800, height: 600 }), tab = await chrome.open("about:blank");
const counts = {};
let wrong = 0;
/* Nor may any other cell name a mistake, but one that follows from what was put in or that the engine makes itself. */
const also = new Set(readFileSync(join(here, "../support/acid_also.txt"), "utf8").split("\n").map((line) => line.split(" ").slice(0, 3).join(" ")));
const is_true = ({ engine, mistake }, cell, said) => said === `fail: ${mistake}` || said === verdicts[engines[engine]?.own]?.cells[cell] || also.has(`${mistake} ${cell} ${said.slice("fail: ".length)}`);
for (let number = 0; number < shots; number++) {
  const picture = pictures[number % pictures.length], width = Math.round(random(640, 2000)), height = Math.round(width * random(0.72, 0.78));
  const how = { width, height, curve: curves[Math.floor(random(0, 3))], exposure: random(0.8, 1.6), gamma: random(1.8, 2.4), quality: random(0.6, 0.95), left: random(-0.06, 0.004), top: random(-0.06, 0.004), right: random(-0.06, 0.004), bottom: random(-0.06, 0.004) };
  const url = await tab.evaluate(`(async () => { const how = ${JSON.stringify(how)}, image = new Image(); image.src = "data:image/png;base64,${readFileSync(picture.path).toString("base64")}"; await image.decode();
    const canvas = Object.assign(document.createElement("canvas"), { width: how.width, height: how.height }), context = canvas.getContext("2d"), W = image.width, H = image.height;
    context.fillStyle = "#345"; context.fillRect(0, 0, how.width, how.height); context.imageSmoothingQuality = "high";
    const x = how.width / (1 - how.left - how.right), y = how.height / (1 - how.top - how.bottom); context.drawImage(image, 0, 0, W, H, -how.left * x, -how.top * y, x, y);
    const tone = new Function("x", "return " + how.curve), white = tone(4), bytes = Uint8ClampedArray.from({ length: 256 }, (_, v) => { const c = v / 255, linear = c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4; return 255 * Math.max(0, Math.min(1, tone(how.exposure * linear) / Math.min(1, white))) ** (1 / how.gamma); });
    const data = context.getImageData(0, 0, how.width, how.height); for (let i = 0; i < data.data.length; i++) if (i % 4 < 3) data.data[i] = bytes[data.data[i]]; context.putImageData(data, 0, 0);
    return canvas.toDataURL("image/jpeg", how.quality); })()`);
  const path = join(out, `shot-${number}.jpg`);
  writeFileSync(path, Buffer.from(url.split(",")[1], "base64"));
  const said = judge(path);
  for (const [cell, is] of Object.entries(said))
    if (!(cell in picture.expected) && is.startsWith("fail: ") && !is_true(picture, cell, is)) {
      wrong++;
      console.log(`shot ${number}, ${picture.engine}, ${picture.mistake}: ${cell} is misnamed ${is}`);
    }
  for (const [cell, expected] of Object.entries(picture.expected)) {
    const is = said[cell] ?? "unclear", verdict = is === expected ? "right" : is === "unclear" || is === "fail" ? "unclear" : "wrong"; // a control that fails says that the picture cannot be judged
    const name = expected === "pass" ? "nothing" : expected.slice("fail: ".length), row = counts[name] ??= {}, count = row[picture.engine] ??= { right: 0, unclear: 0, wrong: 0 };
    count[verdict]++;
    if (verdict === "wrong") wrong++;
    if (verdict !== "right") console.log(`shot ${number}, ${picture.engine}, ${picture.mistake}: ${cell} is ${is}, expected ${expected}`);
  }
}
await chrome.close();
const names = [...Object.keys(engines), "norma render"], rows = Object.keys(counts).sort((a, b) => (b === "nothing") - (a === "nothing") || (a < b ? -1 : 1));
const cell = (c) => c ? `${c.right} / ${c.unclear} / ${c.wrong}` : "";
const sum = (name) => rows.reduce((all, row) => { for (const key in all) all[key] += counts[row][name]?.[key] ?? 0; return all; }, { right: 0, unclear: 0, wrong: 0 });
const text = [`| Mistake put in | ${names.join(" | ")} |`, `|---|${names.map(() => "---|").join("")}`,
  ...rows.map((row) => `| ${row === "nothing" ? "nothing" : `\`${row}\``} | ${names.map((name) => cell(counts[row][name])).join(" | ")} |`), `| all | ${names.map((name) => cell(sum(name))).join(" | ")} |`].join("\n");
console.log(text);
const page = join(root, "docs/acid.md"), old = readFileSync(page, "utf8");
writeFileSync(page, old.replace(/(<!-- judged: tests\/engines\/mistakes.mjs -->\n)[^]*?(<!-- end -->)/, `$1${text}\n$2`));
process.exitCode = wrong ? 1 : 0;
