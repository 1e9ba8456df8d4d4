/* run_examples.mjs: the pages of examples/shaders in headless Chromium. Under the stretch (2, 1, 1) the normal (0.6, 0.8, 0) becomes (0.6, 1.6, 0), made unit; its colour is what the middle of the
 * square must have. With plain M it would be (1.2, 0.8, 0).
 *
 *   node run_examples.mjs NAME...     exits with 77 where there is no Chromium */
import { createServer } from "node:http";
import { existsSync, readFileSync } from "node:fs";
import { join } from "node:path";
import { findChrome, launch } from "../web/chrome.mjs";
import { readPng } from "../web/png.mjs";
import { check, finish } from "../web/tap.mjs";

const root = join(import.meta.dirname, "../.."), length = Math.hypot(0.6, 1.6), wanted = [0.6, 1.6, 0].map((x) => Math.round(255 * (0.5 + 0.5 * x / length)));
const path = findChrome();
if (!path) process.exit(77);
const server = createServer((request, response) => {
  const file = ["examples/shaders", "include/norma/shaders"].map((folder) => join(root, folder, request.url.slice(1))).find((file) => request.url.length > 1 && existsSync(file));
  response.setHeader("Content-Type", request.url.endsWith(".html") ? "text/html" : "text/plain").end(file ? readFileSync(file) : "");
});
await new Promise((done) => server.listen(0, "127.0.0.1", done));
const chrome = await launch(path, { flags: ["--enable-unsafe-webgpu", "--use-webgpu-adapter=swiftshader", "--enable-features=Vulkan", "--use-vulkan=swiftshader"] });
for (const name of process.argv.slice(2)) {
  const page = await chrome.open(`http://127.0.0.1:${server.address().port}/${name}`);
  const drawn = await page.until("document.title === 'drawn'").then(() => true, () => false), png = readPng(await page.screenshot());
  const seen = png.at(100, 100);
  check(`${name} draws the right normal`, drawn && wanted.every((x, i) => Math.abs(x - seen[i]) <= 1), `${seen}, not ${wanted}; ${page.said}`);
}
await chrome.close();
server.close();
finish();
