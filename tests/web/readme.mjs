/* node readme.mjs TOOL FILE, beside an installed norma-mesh: every example of the package's README runs, prints what stands below it, and compiles in strict TypeScript; the config runs in glTF-Transform's command line. */
import { spawnSync } from "node:child_process";
import { existsSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { check, finish, skip } from "./tap.mjs";

const [tool, file] = process.argv.slice(2), modules = join(import.meta.dirname, "node_modules"), has = (name) => existsSync(join(modules, name));
const text = readFileSync(join(modules, "norma-mesh/README.md"), "utf8");
const blocks = [...text.matchAll(/^```js( config)?\n(.*?)^```\n(?:\n```text\n(.*?)^```)?/gms)].map(([, isConfig, code, output]) => ({ isConfig: Boolean(isConfig), code, output, title: text.slice(0, text.indexOf(code)).match(/^#+ .*$/gm).at(-1).replace(/^#+ /, "") }));
const ENTRIES = ["three", "react", "@babylonjs", "playcanvas", "@gltf-transform"];
const examples = blocks.filter(({ isConfig }) => !isConfig), compiled = [];
check("the README has examples", examples.length === 10 && blocks.length === 11, blocks.length);
examples.forEach(({ code, output, title }, i) => {
  const missing = ENTRIES.find((name) => code.includes(`"${name}`) && !has(name));
  if (missing) { skip(`README, ${title} (${missing} is not installed)`); return; }
  writeFileSync(`readme-${i}.mjs`, code);
  writeFileSync(`readme-${i}.mts`, code);
  compiled.push(`readme-${i}.mts`);
  const { status, stdout, stderr } = spawnSync(process.execPath, [`readme-${i}.mjs`], { encoding: "utf8" });
  check(`README, ${title}: it runs and prints what stands there`, status === 0 && (output === undefined || stdout === output), `${stdout}${stderr}`);
});
if (has("typescript")) {
  if (has("@gltf-transform")) blocks.filter(({ isConfig }) => isConfig).forEach(({ code }, i) => { writeFileSync(`readme-config-${i}.mts`, code); compiled.push(`readme-config-${i}.mts`); });
  writeFileSync("readme.json", JSON.stringify({ compilerOptions: { strict: true, exactOptionalPropertyTypes: true, noEmit: true, module: "nodenext", target: "es2022", lib: ["es2022", "dom"], types: [], skipLibCheck: true }, files: [...compiled, ...(ENTRIES.every(has) ? ["types-others.ts"] : [])] }));
  const { status, stdout } = spawnSync(process.execPath, ["node_modules/typescript/bin/tsc", "-p", "readme.json"], { encoding: "utf8" });
  check("the examples, and uses of every call, compile in strict TypeScript", status === 0, stdout);
} else skip("strict TypeScript (it is not installed)");
if (has("@gltf-transform/cli")) {
  writeFileSync("gltf-transform.config.mjs", blocks.find(({ isConfig }) => isConfig).code);
  const run = spawnSync(process.execPath, ["node_modules/@gltf-transform/cli/bin/cli.js", "normals", file, "out.glb", "--crease", "40", "--config", "gltf-transform.config.mjs"], { encoding: "utf8" });
  const found = run.status === 0 && JSON.parse(spawnSync(tool, ["info", "out.glb", "--json"], { encoding: "utf8" }).stdout);
  const again = spawnSync(process.execPath, ["node_modules/@gltf-transform/cli/bin/cli.js", "normals", "out.glb", "again.glb", "--crease", "180", "--overwrite", "--config", "gltf-transform.config.mjs"], { encoding: "utf8" });
  check("README, with --overwrite it replaces them", again.status === 0 && !readFileSync("again.glb").equals(readFileSync("out.glb")) && !/nothing was computed/.test(again.stdout + again.stderr), again.stdout + again.stderr);
  check("README, glTF-Transform's command line with the config writes normals", found && found.meshes.every(({ normals }) => normals === "vertex"), run.stdout + run.stderr);
} else skip("glTF-Transform's command line (it is not installed)");
finish();
