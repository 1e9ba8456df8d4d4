/* run_wgsl.mjs: runs a WGSL compute shader over records of vec4 in headless Chromium, on its software device.
 *
 *   node run_wgsl.mjs SHADER IN OUT     SHADER: a whole one; IN, OUT: raw records of 12 and 14 vec4
 *
 * Exits with 77, and says why, where there is no Chromium or no WebGPU in it. */
import { createServer } from "node:http";
import { readFileSync, writeFileSync } from "node:fs";
import { findChrome, launch } from "../web/chrome.mjs";

const IN = 12 * 16, OUT = 14 * 16, BATCH = 65536, PIECE = 1 << 18;
const [shaderPath, inPath, outPath] = process.argv.slice(2);
const records = readFileSync(inPath), shader = readFileSync(shaderPath, "utf8"), results = [];
const count = records.length / IN, batches = Math.ceil(count / BATCH);

/* What runs in the page. It answers with a word of its own where something is missing. */
async function compute(shader, batches, OUT, IN, PIECE) {
  const adapter = await navigator.gpu?.requestAdapter();
  if (!adapter) return "no WebGPU";
  const device = await adapter.requestDevice();
  const module = device.createShaderModule({ code: shader });
  const said = (await module.getCompilationInfo()).messages.filter((message) => message.type !== "info");
  if (said.length) return said.map(({ lineNum, message }) => `line ${lineNum}: ${message}`).join("\n");
  const pipeline = device.createComputePipeline({ layout: "auto", compute: { module, entryPoint: "main" } });
  const buffer = (size, usage) => device.createBuffer({ size, usage });
  for (let batch = 0; batch < batches; batch++) {
    const given = await (await fetch(`/given/${batch}`)).arrayBuffer(), size = given.byteLength / IN * OUT;
    const source = buffer(given.byteLength, GPUBufferUsage.STORAGE | GPUBufferUsage.COPY_DST), result = buffer(size, GPUBufferUsage.STORAGE | GPUBufferUsage.COPY_SRC);
    const read = buffer(size, GPUBufferUsage.MAP_READ | GPUBufferUsage.COPY_DST);
    device.queue.writeBuffer(source, 0, given);
    const encoder = device.createCommandEncoder(), pass = encoder.beginComputePass();
    pass.setPipeline(pipeline);
    pass.setBindGroup(0, device.createBindGroup({ layout: pipeline.getBindGroupLayout(0), entries: [source, result].map((buffer, binding) => ({ binding, resource: { buffer } })) }));
    pass.dispatchWorkgroups(Math.ceil(given.byteLength / IN / 64));
    pass.end();
    encoder.copyBufferToBuffer(result, 0, read, 0, size);
    device.queue.submit([encoder.finish()]);
    await read.mapAsync(GPUMapMode.READ);
    const mapped = read.getMappedRange();
    /* In small pieces: chrome.mjs is told of each request, its body included. */
    for (let at = 0; at < size; at += PIECE) await fetch("/result", { method: "POST", body: mapped.slice(at, at + PIECE) });
    for (const each of [source, result, read]) each.destroy();
  }
  return "";
}

const server = createServer(async (request, response) => {
  const [, what, batch] = request.url.split("/");
  if (what === "given") return response.end(records.subarray(batch * BATCH * IN, (+batch + 1) * BATCH * IN));
  if (what === "result") {
    const parts = [];
    for await (const part of request) parts.push(part);
    results.push(Buffer.concat(parts));
  }
  return response.setHeader("Content-Type", "text/html").end("<!doctype html><title>shaders</title>");
});

const path = findChrome();
if (!path) { console.error("chromium is not installed"); process.exit(77); }
await new Promise((done) => server.listen(0, "127.0.0.1", done));
const chrome = await launch(path, { flags: ["--enable-unsafe-webgpu", "--use-webgpu-adapter=swiftshader", "--enable-features=Vulkan", "--use-vulkan=swiftshader"] });
const page = await chrome.open(`http://127.0.0.1:${server.address().port}/`);
const fault = await page.evaluate(`(${compute})(${JSON.stringify(shader)}, ${batches}, ${OUT}, ${IN}, ${PIECE})`);
await chrome.close();
server.close();
if (fault) { console.error(fault); process.exit(fault === "no WebGPU" ? 77 : 1); }
writeFileSync(outPath, Buffer.concat(results));
