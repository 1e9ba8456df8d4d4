/* node inspector.mjs NORMA FOLDER CLI FILES: norma mcp, asked by the command line of the protocol's inspector. FOLDER: empty; CLI: its cli.js; FILES: tests/cli/golden/files. */
import { execFileSync } from "node:child_process";
import { copyFileSync, existsSync, readFileSync } from "node:fs";
import { join } from "node:path";
import assert from "node:assert/strict";
import { attempt, finish } from "../web/tap.mjs";

const [norma, folder, cli, files] = process.argv.slice(2);
const ask = (method, ...more) => JSON.parse(execFileSync(process.execPath, [cli, "--cli", norma, "mcp", "--method", method, ...more], { cwd: folder, encoding: "utf8", timeout: 120000, stdio: ["ignore", "pipe", "pipe"] }));
const call = (tool, given) => ask("tools/call", "--tool-name", tool, ...Object.entries(given).flatMap(([name, value]) => ["--tool-arg", `${name}=${value}`]));
for (const name of ["cube.obj", "roof.glb"]) copyFileSync(join(files, name), join(folder, name));

await attempt("inspector: the nine tools, each with a schema", () => {
  const { tools } = ask("tools/list");
  assert.deepEqual(tools.map(({ name }) => name).sort(), ["check_mesh", "compare_normals", "compute_normals", "compute_tangents", "explain_rule", "fix_mesh", "mesh_info", "render_mesh", "transform_mesh"]);
  for (const { inputSchema } of tools) assert.equal(inputSchema.type, "object");
});
await attempt("inspector: a file is checked: what norma check says of it", () => {
  const { isError, structuredContent } = call("check_mesh", { path: "roof.glb", profile: "print" });
  assert.equal(isError, false);
  const { summary } = JSON.parse(execFileSync(norma, ["check", "--profile", "print", "--format", "json", "roof.glb"], { cwd: folder, encoding: "utf8" }));
  assert.deepEqual([structuredContent.errors, structuredContent.warnings], [summary.errors, summary.warnings]);
  assert.ok(structuredContent.findings.some(({ rule }) => rule === "N307")); // a roof is open
});
await attempt("inspector: a file is written, and the source stays", () => {
  const before = readFileSync(join(folder, "cube.obj"));
  assert.equal(call("compute_normals", { path: "cube.obj", output: "shaded.obj" }).isError, false);
  assert.ok(existsSync(join(folder, "shaded.obj")));
  assert.deepEqual(readFileSync(join(folder, "cube.obj")), before);
});
await attempt("inspector: a file that is not there is the tool's error", () => {
  const { isError, content } = call("check_mesh", { path: "gone.obj" });
  assert.equal(isError, true);
  assert.match(content[0].text, /no such file/);
});
await attempt("inspector: the rules are resources", () => {
  assert.ok(ask("resources/list").resources.some(({ name }) => name === "N302"));
});
finish();
