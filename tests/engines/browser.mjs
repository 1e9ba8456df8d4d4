/* Runs an engine of the web over an acid scene in headless Chromium with software rendering.
 *   node browser.mjs ENGINE SCENE.glb SHOT.png [WIDTHxHEIGHT]
 * pages/ENGINE.js is bundled from the modules of build/npm-engines. Its default export draws the scene and returns
 * the engine's name and version; it gets { canvas, url, far, width, height }: far is 2 degrees high, 343.7 away. */
import { createServer } from "node:http";
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { dirname, extname, join, resolve } from "node:path";
import { fileURLToPath } from "node:url";
import { findChrome, launch } from "../web/chrome.mjs";

const here = dirname(fileURLToPath(import.meta.url));
const modules = resolve(process.env.NORMA_ENGINES ?? join(here, "../../build/npm-engines"), "node_modules");
const types = { ".html": "text/html", ".js": "text/javascript", ".mjs": "text/javascript", ".wasm": "application/wasm", ".json": "application/json", ".css": "text/css", ".png": "image/png" };

/* serve: the page, its script, the scene, and below /modules/ what the engine fetches by itself (workers, WebAssembly). */
function serve(files) {
  const server = createServer((request, response) => {
    const path = decodeURIComponent(new URL(request.url, "http://x").pathname);
    try {
      const inside = path.startsWith("/modules/") ? resolve(modules, path.slice("/modules/".length)) : undefined;
      if (inside !== undefined && !inside.startsWith(modules)) throw new Error(path);
      const bytes = inside === undefined ? files[path] : readFileSync(inside);
      if (bytes === undefined) throw new Error(path);
      response.writeHead(200, { "content-type": types[extname(path)] ?? "application/octet-stream" }).end(bytes);
    } catch {
      response.writeHead(404).end();
    }
  });
  return new Promise((done) => server.listen(0, "127.0.0.1", () => done(server)));
}

/* imports and before: statements that run before the engine does (mistakes.mjs). */
const bundle = async (engine, { imports, before }) => {
  const { build } = createRequire(join(modules, "x.js"))("esbuild");
  const contents = `import draw from ${JSON.stringify(join(here, "pages", `${engine}.js`))};
    ${imports}
    const canvas = document.querySelector("canvas"), { width, height } = canvas;
    ${before}
    draw({ canvas, url: new URL("/scene.glb", location).href, width, height, far: { distance: 343.73976978455664, degrees: 2, near: 300, end: 400 } }).then(
      (version) => setTimeout(() => { window.drawn = version; }, 300), (error) => { window.drawn = "error: " + (error?.stack ?? error); });`;
  const { outputFiles } = await build({ stdin: { contents, resolveDir: modules }, nodePaths: [modules], bundle: true, write: false, format: "esm", target: "esnext", logLevel: "error",
    external: ["fs", "path", "node:*"], loader: { ".glsl": "text", ".wasm": "file" }, outdir: "/out", supported: { "import-meta": true } });
  return outputFiles.find(({ path }) => path.endsWith(".js")).text;
};

export async function draw(engine, scene, shot, size = "1600x1200", changes = { imports: "", before: "" }) {
  const [width, height] = size.split("x").map(Number);
  const page = `<!doctype html><meta charset="utf-8"><style>html,body{margin:0;overflow:hidden;background:#777}canvas{display:block}</style><canvas id="canvas" width="${width}" height="${height}"></canvas><script type="module" src="/page.js"></script>`;
  const server = await serve({ "/": page, "/index.html": page, "/page.js": await bundle(engine, changes), "/scene.glb": readFileSync(scene), "/favicon.ico": "" });
  const chrome = await launch(findChrome(), { width, height });
  try {
    const tab = await chrome.open(`http://127.0.0.1:${server.address().port}/index.html`, { size: [width, height] });
    const drawn = await tab.until("window.drawn", Number(process.env.NORMA_SECONDS ?? 150)).catch((error) => `error: ${error.message}`);
    await tab.screenshot(shot);
    return { drawn, said: tab.said };
  } finally {
    await chrome.close().catch(() => undefined); /* its profile may still be in use */
    server.close();
  }
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const [engine, scene, shot, size] = process.argv.slice(2);
  const { drawn, said } = await draw(engine, scene, shot, size);
  for (const line of said) console.error(line.slice(0, 500));
  console.log(drawn);
  process.exitCode = String(drawn).startsWith("error: ") ? 1 : 0;
}
