/* node bundles.mjs, beside an installed norma-mesh: the package in esbuild, webpack and vite, without a bundler, in workers, and under a content security policy, each run in headless Chromium. */
import { spawnSync } from "node:child_process";
import { cpSync, existsSync, mkdirSync, readdirSync, readFileSync, statSync, writeFileSync } from "node:fs";
import { createServer } from "node:http";
import { extname, join } from "node:path";
import { gzipSync } from "node:zlib";
import * as inNode from "norma-mesh";
import { attempt, check, finish, skip } from "./tap.mjs";
import { findChrome, launch } from "./chrome.mjs";
import { run } from "./app.js";

const here = import.meta.dirname, expected = await run(inNode), installed = join(here, "node_modules/norma-mesh");
check("in node, everything gives a report", expected.split("\n").length === 13 && /N\d/.test(expected), expected);
await attempt("the inlined entry runs in node too", async () => {
  const { load } = await import("norma-mesh/inline"), norma = await load(), box = Float32Array.of(0, 0, 0, 1, 0, 0, 0, 1, 0);
  if (norma.vertexNormals(box).join() !== "0,0,1,0,0,1,0,0,1") throw new Error("other normals");
});

for (const [name, words] of [["deno", ["run", "-A", "--node-modules-dir=manual"]], ["bun", []]]) {
  writeFileSync(join(here, "runtime.mjs"), `import * as norma from "norma-mesh";\nimport { run } from "./app.js";\nconsole.log(await run(norma));\n`);
  const { status, stdout, error } = spawnSync(name, [...words, "runtime.mjs"], { encoding: "utf8" });
  if (error) skip(`${name} (it is not installed)`);
  else check(`in ${name}, the same`, status === 0 && stdout.trim() === expected, stdout);
}

/* ---- a server, with a policy for each page */
const TYPES = { ".html": "text/html", ".js": "text/javascript", ".mjs": "text/javascript", ".wasm": "application/wasm", ".css": "text/css" };
const POLICY = "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; connect-src 'self'; worker-src 'self'";
function serve(root, policy) {
  const server = createServer(({ url }, response) => {
    const path = join(root, decodeURIComponent(new URL(url, "http://x").pathname));
    if (!existsSync(path) || !statSync(path).isFile()) { response.statusCode = 404; response.end(); return; }
    response.setHeader("content-type", TYPES[extname(path)] ?? "application/octet-stream");
    if (policy) response.setHeader("content-security-policy", policy);
    response.end(readFileSync(path));
  });
  return new Promise((ready) => server.listen(0, "127.0.0.1", () => ready({ address: `http://127.0.0.1:${server.address().port}`, close: () => server.close() })));
}

const start = (entry) => `import * as norma from "${entry}";\nimport { run } from "${entry.startsWith("norma") ? "../app.js" : "/app.js"}";\nrun(norma).then((text) => { globalThis.result = text; }, (error) => { globalThis.result = "error: " + (error.stack ?? error.message); });\n`;
const page = (script, type = "module") => `<!doctype html><meta charset="utf-8"><title>x</title><script type="${type}" src="${script}" ${type === "module" ? "" : "defer"}></script>`;

function folder(name, entry, html) {
  const at = join(here, name);
  mkdirSync(at, { recursive: true });
  writeFileSync(join(at, "start.js"), start(entry));
  writeFileSync(join(at, "index.html"), html);
  return at;
}

const chrome = findChrome(), browser = chrome ? await launch(chrome) : null;
async function runs(name, address) {
  if (!browser) { skip(`${name} (chromium is not installed)`); return; }
  await attempt(name, async () => {
    const tab = await browser.open(address), text = await tab.until("globalThis.result", 20).catch(() => `nothing; the page says: ${tab.said.join("; ")}`);
    await tab.close();
    if (text !== expected) throw new Error(text);
  });
}
/* No module of node's in what a browser gets. */
const noNode = (name, at) => check(`${name}: nothing of node's reaches it`, existsSync(at) && readdirSync(at, { recursive: true }).filter((file) => /\.m?js$/.test(file)).every((file) => !/node:|require\(["']fs/.test(readFileSync(join(at, file), "utf8"))));

/* ---- esbuild: the .wasm and the worker beside the script, or one script with all */
const esbuild = await import("esbuild").catch(() => null);
if (!esbuild) skip("bundlers (they are not installed: scripts/install-deps.sh)");
else {
  const beside = folder("esbuild", "norma-mesh", page("start.out.js"));
  await attempt("esbuild bundles for browsers", async () => {
    const { warnings } = await esbuild.build({ entryPoints: [join(beside, "start.js")], outfile: join(beside, "dist/start.out.js"), bundle: true, format: "esm", platform: "browser", logLevel: "silent" });
    if (warnings.length) throw new Error(JSON.stringify(warnings));
    await esbuild.build({ entryPoints: [join(installed, "worker.js")], outfile: join(beside, "dist/worker.js"), bundle: true, format: "esm", logLevel: "silent" });
    for (const name of ["norma.wasm", "check.wasm", "draco.wasm", "tool.wasm"]) cpSync(join(installed, name), join(beside, "dist", name));
    cpSync(join(beside, "index.html"), join(beside, "dist/index.html"));
  });
  noNode("esbuild", join(beside, "dist"));
  const one = folder("inline", "norma-mesh/inline", page("start.out.js", "text/javascript"));
  await attempt("esbuild makes one classic script of norma-mesh/inline", async () => {
    const { warnings } = await esbuild.build({ entryPoints: [join(one, "start.js")], outfile: join(one, "dist/start.out.js"), bundle: true, format: "iife", platform: "browser", logLevel: "silent" });
    if (warnings.length) throw new Error(JSON.stringify(warnings));
    cpSync(join(one, "index.html"), join(one, "dist/index.html"));
  });
  await attempt("a script without splitting can leave out the texts of other modules, and still computes", async () => {
    const build = { entryPoints: [join(one, "vertices.js")], outfile: join(one, "vertices.mjs"), bundle: true, minify: true, format: "esm", logLevel: "silent" };
    writeFileSync(join(one, "vertices.js"), 'import { load } from "norma-mesh/inline";\nexport default (await load()).vertexNormals(Float32Array.of(0, 0, 0, 1, 0, 0, 0, 1, 0)).join();\n');
    await esbuild.build({ ...build, external: ["check", "draco", "tool"].map((name) => `*/${name}-text.js`) });
    const size = gzipSync(readFileSync(build.outfile)).length, { default: normals } = await import(build.outfile);
    if (size > 220000 || normals !== "0,0,1,0,0,1,0,0,1") throw new Error(`${size} ${normals}`);
  });
  for (const [name, root, policy] of [["esbuild, under a content security policy", beside, POLICY], ["norma-mesh/inline as one script, under a content security policy", one, POLICY.replace("worker-src 'self'", "worker-src blob:").replace("connect-src 'self'; ", "")]]) {
    const server = await serve(join(root, "dist"), policy);
    await runs(name, `${server.address}/index.html`);
    server.close();
  }
  if (browser) await attempt("a policy without 'wasm-unsafe-eval' is what forbids it, and says so", async () => {
    const server = await serve(join(beside, "dist"), POLICY.replace(" 'wasm-unsafe-eval'", "")), tab = await browser.open(`${server.address}/index.html`), text = await tab.until("globalThis.result", 10);
    server.close();
    if (!/^error: .*(unsafe-eval|Content Security Policy)/s.test(text)) throw new Error(text);
  });

  /* ---- webpack */
  const { default: webpack } = await import("webpack"), packed = folder("webpack", "norma-mesh", page("main.js", "text/javascript"));
  await attempt("webpack bundles for browsers", () => new Promise((done, fail) => {
    webpack({ mode: "production", devtool: false, optimization: { minimize: false }, performance: false, entry: join(packed, "start.js"), output: { path: join(packed, "dist") } }, (error, stats) => {
      if (error || stats.hasErrors() || stats.hasWarnings()) fail(error ?? new Error(stats.toString({ all: false, errors: true, warnings: true })));
      else { cpSync(join(packed, "index.html"), join(packed, "dist/index.html")); done(); }
    });
  }));
  noNode("webpack", join(packed, "dist"));
  const server = await serve(join(packed, "dist"), POLICY);
  await runs("webpack, under a content security policy", `${server.address}/index.html`);
  server.close();

  /* ---- vite */
  const vite = await import("vite"), made = folder("vite", "norma-mesh", page("/start.js")), shared = { root: made, configFile: false, logLevel: "error", clearScreen: false };
  await attempt("vite builds", () => vite.build({ ...shared, build: { outDir: "dist", minify: false } }));
  noNode("vite build", join(made, "dist"));
  const built = await serve(join(made, "dist"), POLICY);
  await runs("vite's build, under a content security policy", `${built.address}/index.html`);
  built.close();
  for (const [name, more] of [["vite dev", {}], ["vite dev, the package left out of its optimizer", { optimizeDeps: { exclude: ["norma-mesh"] } }]]) {
    const dev = await vite.createServer({ ...shared, ...more, server: { host: "127.0.0.1", port: 0, fs: { strict: false } } });
    await dev.listen();
    await runs(name, `${dev.resolvedUrls.local[0]}index.html`);
    await dev.close();
  }
}

/* ---- without a bundler: an import map, or a relative address */
if (browser) {
  folder("plain", "/node_modules/norma-mesh/index.js", `<!doctype html><meta charset="utf-8"><title>x</title><script type="importmap">{ "imports": { "three": "/node_modules/three/build/three.module.js", "norma-mesh": "/node_modules/norma-mesh/index.js", "norma-mesh/three": "/node_modules/norma-mesh/three.js" } }</script><script type="module" src="start.js"></script>`);
  const server = await serve(here);
  await runs("without a bundler, by an import map", `${server.address}/plain/index.html`);
  await attempt("the README's page without a bundler", async () => {
    const [, snippet] = readFileSync(join(installed, "README.md"), "utf8").match(/^```html\n(.*?)^```$/ms);
    writeFileSync(join(here, "snippet.html"), `<!doctype html><meta charset="utf-8"><title>x</title>${snippet}`);
    const tab = await browser.open(`${server.address}/snippet.html`), title = await tab.until('document.title !== "x" && document.title', 20).catch(() => tab.said.join("; "));
    await tab.close();
    if (title !== "0 0 1 0 0 1 0 0 1") throw new Error(title);
  });
  server.close();
}
await browser?.close();
finish();
