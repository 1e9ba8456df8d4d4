/* node files.mjs PACKAGE TOOL FILE...: check gives what `norma check --format json` prints, for every file. */
import { spawnSync } from "node:child_process";
import { readFileSync, statSync } from "node:fs";
import { isDeepStrictEqual } from "node:util";
import { pathToFileURL } from "node:url";
import { asNpx, check, finish } from "./tap.mjs";

const [folder, tool, ...files] = process.argv.slice(2);
const { load } = await import(pathToFileURL(`${folder}/node.js`));
const norma = await load(), known = /\.(obj|ply|stl|gltf|glb|3mf)$/i;
/* Files that name others cannot be read from their bytes alone; a package that was built without the sources of meshoptimizer and Draco does not decode theirs. */
const isWhole = statSync(`${folder}/draco.wasm`).size > 8 && /meshoptimizer/.test(readFileSync(`${folder}/NOTICES`, "utf8"));
const standsAlone = (path, bytes) => (isWhole || !/meshopt_compression|KHR_draco_mesh_compression/.test(bytes.toString("latin1", 0, 100000))) && !(/\.gltf$/i.test(path) && /"uri"\s*:\s*"(?!data:)/.test(bytes.toString("latin1")));

let same = 0, findings = 0, unreadable = 0, left = 0;
const differ = [];
for (const path of files.filter((name) => known.test(name))) {
  const bytes = readFileSync(path);
  if (!standsAlone(path, bytes)) { left++; continue; }
  for (const profile of ["render", "print"]) {
    const run = spawnSync(tool, ["check", "--format", "json", "--profile", profile, path], { encoding: "utf8", maxBuffer: 1 << 28 });
    let expected, report;
    try { expected = JSON.parse(run.stdout); } catch { differ.push(`${path}: the tool printed no JSON: ${run.stderr}`); continue; }
    try { report = await norma.check(bytes, { name: path, profile }); } catch (error) { differ.push(`${path}: ${error.stack}`); continue; }
    report = JSON.parse(JSON.stringify(report));
    asNpx(expected.files[0]);
    if (isDeepStrictEqual(report, expected)) same++;
    else differ.push(`${path}, ${profile}:\n${JSON.stringify(report).slice(0, 1500)}\n${JSON.stringify(expected).slice(0, 1500)}`);
    findings += expected.files[0].findings.length;
    unreadable += expected.files[0].status === "unreadable" ? 1 : 0;
  }
}
check(`${same} reports, ${findings} findings, ${unreadable} of unreadable files: as the tool prints them (${left} files need others)`, differ.length === 0 && same > 20 && findings > 20 && unreadable > 0, differ.slice(0, 5).join("\n"));
finish();
