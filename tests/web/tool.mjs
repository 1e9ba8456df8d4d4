/* node tool.mjs COMMAND TOOL ASSETS FILES FILE...: what npx norma-mesh writes has the bytes of what the tool writes, also of compressed files; a pasted command of a finding fixes it; rights are kept; a signal leaves nothing half-written. */
import { spawn, spawnSync } from "node:child_process";
import { chmodSync, copyFileSync, cpSync, mkdirSync, mkdtempSync, readFileSync, readdirSync, realpathSync, rmSync, statSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { basename, dirname, extname, join } from "node:path";
import { attempt, check, finish } from "./tap.mjs";

const [command, tool, assets, files, ...packed] = process.argv.slice(2), scratch = mkdtempSync(join(tmpdir(), "norma-tool-"));
const run = (program, words, options = {}) => spawnSync(program, words, { cwd: scratch, encoding: "utf8", maxBuffer: 1 << 28, ...options });
const meshes = readdirSync(assets).filter((name) => /\.(obj|ply|stl|glb|gltf)$/.test(name)).map((name) => join(assets, name));
const bytesIn = (folder) => readdirSync(folder).sort().map((name) => [name, readFileSync(join(folder, name)).toString("base64")]);

/* Both on a copy of the file, with the same names; everything that they print and write is compared. */
function isSame(file, words) {
  const sides = [command, tool].map((program) => {
    const folder = mkdtempSync(join(scratch, "side-"));
    copyFileSync(file, join(folder, basename(file)));
    const { status, stdout, stderr } = run(program, words(basename(file), `out${extname(file)}`), { cwd: folder });
    return JSON.stringify([status, ...[stdout, stderr].map((text) => text.replaceAll("npx norma-mesh ", "norma ")), bytesIn(folder)]);
  });
  return { same: sides[0] === sides[1], sides };
}
for (const file of [...meshes, ...packed])
  await attempt(`${basename(file)}: compute, transform and check --fix-unsafe write the tool's bytes`, async () => {
    for (const words of [(name, out) => ["compute", name, "-o", out], (name, out) => ["transform", name, "-o", out, "--scale", "2,1,1"], (name, out) => ["check", name, "--fix-unsafe", "-o", out], (name) => ["check", name, "--format", "json"]]) {
      const { same, sides } = isSame(file, words);
      if (!same) throw new Error(`${words("IN", "OUT").join(" ")}\n${sides.map((side) => side.slice(0, 1500)).join("\n")}`);
    }
  });

await attempt("a finding's command begins with npx norma-mesh, and its words fix it", async () => {
  copyFileSync(join(files, "corner.stl"), join(scratch, "corner.stl"));
  const { files: [{ findings }] } = JSON.parse(run(command, ["check", "corner.stl", "--format", "json"]).stdout), commands = findings.map((finding) => finding.command).filter((words) => words);
  if (!commands.length || commands.some((words) => !words.startsWith("npx norma-mesh check corner.stl "))) throw new Error(commands.join("\n"));
  const fixed = run("bash", ["-c", commands[0].replace("npx norma-mesh", '"$0"'), command]), { files: [{ findings: left }] } = JSON.parse(run(tool, ["check", "corner.fixed.stl", "--format", "json"]).stdout);
  if (fixed.status !== 0 || left.some(({ rule }) => rule === findings.find((finding) => finding.command).rule)) throw new Error(fixed.stdout + fixed.stderr);
});
await attempt("explanations, helps and hints name commands that can be pasted, and are the tool's otherwise", async () => {
  const verbs = ["compute", "seams", "tangents", "pack", "transform", "matrix", "check", "report", "explain", "info", "compare"];
  for (const words of [["explain", "N"], ["explain", "N", "--json"], ["matrix"], ["nothing"], ["check", "--nothing"], ["help"], ...verbs.map((verb) => ["help", verb])]) {
    const [ours, theirs] = [command, tool].map((program) => run(program, words)), plain = (text) => text.replace(/\s+/g, " ").replaceAll("npx norma-mesh ", "norma ");
    const wrong = ours.stdout.match(/.*(?<!npx )norma [a-z].*/g) ?? (ours.stderr && !/\(see 'npx norma-mesh help/.test(ours.stderr) && [ours.stderr]);
    if (wrong) throw new Error(`${words.join(" ")}\n${wrong.join("\n")}`);
    if (words[0] !== "help" || words[1]) if (plain(ours.stdout + ours.stderr) !== plain(theirs.stdout + theirs.stderr)) throw new Error(`${words.join(" ")}\n${ours.stdout}\n${theirs.stdout}`);
  }
});
await attempt("a pipe that is read late gets everything", async () => {
  const words = Array(9).fill('"$0" explain N --json').join("; "), { stdout, stderr } = run("bash", ["-c", `{ ${words}; } | (sleep 5; wc -c)`, command]), all = 9 * Buffer.byteLength(run(tool, ["explain", "N", "--json"]).stdout);
  if (Number(stdout) < all || stderr) throw new Error(`${stdout} of ${all} bytes\n${stderr}`);
});
await attempt("a file that is replaced keeps its mode, and one that may not be written is not replaced", async () => {
  const file = join(scratch, "kept.obj"), owner = process.geteuid() === 0 ? { uid: 65534, gid: 65534 } : {};
  copyFileSync(join(assets, "goathead.obj"), file);
  chmodSync(file, 0o600);
  if (run(command, ["compute", "kept.obj", "--in-place"]).status !== 0 || (statSync(file).mode & 0o777) !== 0o600) throw new Error("not kept");
  const before = readFileSync(file), closed = join(scratch, "closed");
  mkdirSync(closed);
  copyFileSync(file, join(closed, "closed.obj"));
  chmodSync(join(closed, "closed.obj"), 0o444);
  for (const path of [scratch, closed]) chmodSync(path, 0o777);
  cpSync(dirname(realpathSync(command)), join(scratch, "package"), { recursive: true }); // where everyone may read
  const { status, stderr } = run(process.execPath, [join(scratch, "package/bin.js"), "compute", join(closed, "closed.obj"), "--in-place", "--smooth"], owner);
  if (status !== 3 || !/Permission denied/.test(stderr) || !readFileSync(join(closed, "closed.obj")).equals(before)) throw new Error(`${status} ${stderr}`);
});
await attempt("SIGTERM while it waits for its input ends it, and no file is left", async () => {
  const folder = mkdtempSync(join(scratch, "signal-")), child = spawn(command, ["compute", "-", "--input-format", "obj", "-o", "out.obj"], { cwd: folder });
  let said = "";
  child.stderr.on("data", (text) => { said += text; });
  setTimeout(() => child.kill("SIGTERM"), 1500);
  const status = await new Promise((settle) => child.on("exit", (code, signal) => settle(signal)));
  if (status !== "SIGTERM" || !said.includes("norma: interrupted") || readdirSync(folder).length) throw new Error(`${status} ${said} ${readdirSync(folder)}`);
});
await attempt("a large file, whose memory grows while node collects, is computed as by the tool; one that may not be written whole is an error", async () => {
  const side = 800, path = join(scratch, "large.stl"), bytes = new DataView(new ArrayBuffer(84 + 50 * side * side));
  bytes.setUint32(80, side * side, true);
  for (let i = 0; i < side * side; i++) [0, 0, 0, i % side, Math.floor(i / side), i % 7, 1 + (i % side), Math.floor(i / side), 0, i % side, 1 + Math.floor(i / side), 0].forEach((number, k) => bytes.setFloat32(84 + 50 * i + 4 * k, number, true));
  writeFileSync(path, bytes);
  const [ours, theirs] = [command, tool].map((program, i) => run(program, ["compute", path, "-o", `large-${i}.stl`]));
  if (ours.status !== 0 || theirs.status !== 0 || !readFileSync(join(scratch, "large-0.stl")).equals(readFileSync(join(scratch, "large-1.stl")))) throw new Error(`${ours.status} ${ours.signal} ${ours.stderr.slice(0, 500)}`);
  const { status, stderr } = run("bash", ["-c", 'ulimit -f 8; "$0" compute "$1" -o small.stl', command, path]);
  if (status !== 3 || !/small\.stl: cannot be written: File too large/.test(stderr)) throw new Error(`${status} ${stderr.slice(0, 500)}`);
});
for (const word of ["render", "view", "acid", "mcp"]) {
  const { status, stderr } = run(command, [word, "a.obj"]);
  check(`${word} says that it is not in the package`, status === 2 && stderr.includes(`${word} is not in the npm package`), stderr);
}
rmSync(scratch, { recursive: true });
finish();
