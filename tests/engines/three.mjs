/* three.js draws an acid scene: its GLTFLoader, its default material, WebGL, no tone mapping. three.mjs SCENE.glb SHOT.png [CAMERA] [SIZE] */
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";
import { findChrome, launch } from "../web/chrome.mjs";

const [scene, shot, camera = "norma-acid", size = "1600x1200"] = process.argv.slice(2);
const [width, height] = size.split("x").map(Number);
const modules = resolve(process.env.NODE_PATH ?? "build/npm-web/node_modules"), require = createRequire(join(modules, "x.js"));
const page = `
import * as three from "three";
import { GLTFLoader } from "three/examples/jsm/loaders/GLTFLoader.js";
const bytes = Uint8Array.from(atob(document.getElementById("scene").textContent), (c) => c.charCodeAt(0));
new GLTFLoader().parse(bytes.buffer, "", (gltf) => {
  const renderer = new three.WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
  renderer.setSize(${width}, ${height});
  document.body.append(renderer.domElement);
  const through = gltf.cameras.find((c) => c.name === ${JSON.stringify(camera)});
  if (!through) throw new Error("cameras: " + gltf.cameras.map((c) => c.name));
  renderer.render(gltf.scene, through);
  window.drawn = "revision " + three.REVISION;
}, (error) => { window.drawn = "error: " + error; });
`;
const { outputFiles } = await require("esbuild").build({
  stdin: { contents: page, resolveDir: modules }, bundle: true, write: false, format: "iife", logLevel: "error" });
const folder = mkdtempSync(join(tmpdir(), "norma-engine-"));
writeFileSync(join(folder, "index.html"), `<!doctype html><style>body{margin:0;overflow:hidden}</style><script type="text/plain" id="scene">${readFileSync(scene).toString("base64")}</script><body><script>${outputFiles[0].text.replaceAll("</script", "<\\/script")}</script>`);
const chrome = await launch(findChrome(), { width, height });
try {
  const tab = await chrome.open(`file://${join(folder, "index.html")}`, { size: [width, height] });
  console.log(await tab.until("window.drawn", 60) && await tab.evaluate("window.drawn"), ...tab.said);
  await tab.screenshot(shot);
} finally {
  await chrome.close();
  rmSync(folder, { recursive: true, force: true });
}
