/* Silhouettes of norma render against those of three.js's GLTFLoader in headless Chromium, through the same camera: every file with a skin, with morph targets or with instances.
 *   node silhouettes.mjs NORMA FOLDER PICTURES FILE...
 * Files with skins or morph targets are compared a second time with every joint turned and every weight set: at rest, most stand as they are stored.
 * prints, for each file, the pixels that only one of the two covers, as a share of those that three.js covers. Pictures of what differs are left in PICTURES. */
import { execFileSync } from "node:child_process";
import { createServer } from "node:http";
import { cpSync, readFileSync, writeFileSync, existsSync, mkdirSync } from "node:fs";
import { createRequire } from "node:module";
import { basename, dirname, join, normalize } from "node:path";
import { pathToFileURL } from "node:url";
import { findChrome, launch } from "./chrome.mjs";
import { readPng } from "./png.mjs";

const [norma, folder, pictures, ...files] = process.argv.slice(2);
const SIZE = 512, MOST = 0.01;
const esbuild = await import(pathToFileURL(createRequire(join(process.env.NODE_PATH, "x.js")).resolve("esbuild")));

/* In the page: a file through a given matrix from the world to clip space, white on black, by the sides that its materials have. */
const PAGE = `
import * as THREE from "three";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";
import { MeshoptDecoder } from "three/addons/libs/meshopt_decoder.module.js";
const renderer = new THREE.WebGLRenderer({ antialias: false, preserveDrawingBuffer: true });
renderer.setSize(${SIZE}, ${SIZE});
document.body.style.margin = 0;
document.body.append(renderer.domElement);
const white = { [THREE.FrontSide]: new THREE.MeshBasicMaterial({ side: THREE.FrontSide }), [THREE.DoubleSide]: new THREE.MeshBasicMaterial({ side: THREE.DoubleSide }) };
window.draw = async (url, matrix) => {
  const { scene } = await new GLTFLoader().setMeshoptDecoder(MeshoptDecoder).loadAsync(url);
  scene.traverse((object) => {
    object.frustumCulled = false;
    if (object.isMesh) object.material = white[object.material.side];
    if (object.isPoints || object.isLine) object.visible = false;
  });
  const camera = new THREE.Camera();
  camera.projectionMatrix.fromArray(matrix);
  camera.projectionMatrixInverse.copy(camera.projectionMatrix).invert();
  renderer.setClearColor(0x000000, 1);
  renderer.render(scene, camera);
  return true;
};
window.ready = true;`;

const { outputFiles } = await esbuild.build({ stdin: { contents: PAGE, resolveDir: join(process.env.NODE_PATH, ".."), loader: "js" }, bundle: true, write: false, format: "iife", nodePaths: [process.env.NODE_PATH] });
const server = createServer((request, response) => {
  const path = decodeURIComponent(request.url.split("?")[0]);
  if (path === "/") return response.setHeader("content-type", "text/html").end("<!doctype html><meta charset=utf-8><link rel=icon href=data:,><body><script src=/page.js></script>");
  if (path === "/page.js") return response.setHeader("content-type", "text/javascript").end(outputFiles[0].text);
  const file = path.startsWith("/posed/") ? join(pictures, normalize(path)) : join(folder, normalize(path));
  if (!existsSync(file)) return response.writeHead(404).end();
  response.end(readFileSync(file));
}).listen(0);
const address = `http://127.0.0.1:${server.address().port}`;

/* A copy of a file's folder in PICTURES/posed, in which joints are turned and weights set; undefined: it has neither. */
function pose(name) {
  const bytes = readFileSync(join(folder, name)), binary = bytes.toString("latin1", 0, 4) === "glTF", length = binary ? bytes.readUInt32LE(12) : bytes.length;
  const asset = JSON.parse(bytes.toString("utf8", binary ? 20 : 0, (binary ? 20 : 0) + length));
  const joints = new Set((asset.skins ?? []).flatMap((skin) => skin.joints)), half = Math.PI / 24;
  const meshes = (asset.meshes ?? []).filter((mesh) => mesh.primitives.some((primitive) => primitive.targets?.length));
  if (!joints.size && !meshes.length) return undefined;
  for (const joint of joints) {
    const node = asset.nodes[joint];
    if (node.matrix) {
      const m = node.matrix, s = Math.sin(2 * half), c = Math.cos(2 * half);
      for (let i = 0; i < 3; i++) [m[i], m[4 + i]] = [c * m[i] + s * m[4 + i], c * m[4 + i] - s * m[i]];
      continue;
    }
    const [x, y, z, w] = node.rotation ?? [0, 0, 0, 1], s = Math.sin(half), c = Math.cos(half);
    node.rotation = [x * c + y * s, y * c - x * s, z * c + w * s, w * c - z * s];
  }
  for (const mesh of meshes) mesh.weights = mesh.primitives[0].targets.map((_, i) => 0.6 / (i + 1));
  for (const node of asset.nodes ?? []) delete node.weights;
  let json = Buffer.from(JSON.stringify(asset)), copy = join("posed", name);
  cpSync(join(folder, dirname(name)), join(pictures, dirname(copy)), { recursive: true });
  if (binary) {
    json = Buffer.concat([json, Buffer.alloc((4 - json.length % 4) % 4, " ")]);
    const head = Buffer.from(bytes.subarray(0, 20)), rest = bytes.subarray(20 + length);
    head.writeUInt32LE(20 + json.length + rest.length, 8);
    head.writeUInt32LE(json.length, 12);
    json = Buffer.concat([head, json, rest]);
  }
  writeFileSync(join(pictures, copy), json);
  return copy;
}

const covered = (at) => (x, y) => at(x, y)[0] > 127;
mkdirSync(pictures, { recursive: true });
const chrome = await launch(findChrome(), { width: SIZE, height: SIZE });
const page = await chrome.open(`${address}/`, { size: [SIZE, SIZE] });
await page.until("window.ready");
let bad = 0;
for (const name of files.flatMap((file) => [file, pose(file)]).filter(Boolean)) {
  const posed = name.startsWith("posed"), place = join(posed ? pictures : folder, name);
  const own = join(pictures, `${posed ? "posed-" : ""}${basename(dirname(name))}-${basename(name)}.norma.png`), other = own.replace("norma.png", "three.png");
  let line;
  try {
    const said = JSON.parse(execFileSync(norma, ["render", place, "-o", own, "--json", "--renderer", "software", "--size", `${SIZE}x${SIZE}`, "--samples", "1", "--background", "#ff00ff"
      ], { encoding: "utf8", stdio: ["ignore", "pipe", "pipe"] }));
    await page.evaluate(`draw(${JSON.stringify(`/${name}`)}, ${JSON.stringify(said.world_to_clip)})`);
    writeFileSync(other, await page.screenshot());
    const a = readPng(readFileSync(own)), b = readPng(readFileSync(other));
    let differ = 0, both = 0, theirs = 0;
    for (let y = 0; y < SIZE; y++) for (let x = 0; x < SIZE; x++) {
      const [r, g, b3] = a.at(x, y), ours = !(r === 255 && g === 0 && b3 === 255), three = covered(b.at)(x, y);
      differ += ours !== three;
      both += ours && three;
      theirs += three;
    }
    const share = differ / Math.max(theirs, 1), good = theirs > 0 && share <= MOST;
    if (!good) bad++;
    line = `${good ? "ok" : "not ok"} ${name}: three.js covers ${theirs} pixels, both ${both}, only one ${differ}, ${(100 * share).toFixed(3)} %`;
  } catch (error) {
    bad++;
    line = `not ok ${name}: ${String(error.stderr || error.message).split("\n")[0].slice(0, 300)}`;
  }
  console.log(line);
}
await chrome.close();
server.close();
process.exit(bad ? 1 : 0);
