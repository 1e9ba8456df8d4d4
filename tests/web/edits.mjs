/* node edits.mjs PACKAGE TOOL FILE...: fix, compute and info give what the tool writes and prints for each file, byte by byte, here and in a worker; errors are its sentences. */
import { spawnSync } from "node:child_process";
import { copyFileSync, existsSync, mkdirSync, mkdtempSync, readFileSync, readdirSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { basename, dirname, join } from "node:path";
import { attempt, check, finish } from "./tap.mjs";

const [place, tool, ...given] = process.argv.slice(2), { load, loadWorker } = await import(join(place, "node.js")), scratch = mkdtempSync(join(tmpdir(), "norma-edits-"));
const files = given.filter((file) => /\.(obj|ply|stl|gltf|glb|b3dm|i3dm|cmpt)$/.test(file)), norma = await load(), worker = await loadWorker();
/* What lies beside a .gltf. */
const more = (file) => (file.endsWith(".gltf") ? readdirSync(dirname(file)).filter((name) => name.endsWith(".bin")) : []);

function runTool(words, file) {
  const folder = mkdtempSync(join(scratch, "tool-")), out = join(folder, "out");
  for (const name of [basename(file), ...more(file)]) copyFileSync(join(dirname(file), name), join(folder, name));
  mkdirSync(out);
  const { status, stdout, stderr } = spawnSync(tool, [...words, "--", basename(file)], { cwd: folder, encoding: "utf8", maxBuffer: 1 << 28 });
  return { status, stdout, stderr, made: new Map(readdirSync(out).map((name) => [name, readFileSync(join(out, name))])) };
}
/* The tool's spelling of the same command. */
const CALLS = [
  ["fix", {}, ["check", "--fix", "--no-config", "--format", "json", "--out-dir", "out"]], ["fix", { unsafe: true, profile: "print", select: ["N1", "N3", "N4"] }, ["check", "--fix-unsafe", "--no-config", "--profile", "print", "--select", "N1,N3,N4", "--format", "json", "--out-dir", "out"]],
  ["compute", { crease: 25, weight: "area" }, ["compute", "--crease", "25", "--weight", "area", "--json", "--out-dir", "out"]], ["compute", { smooth: true, only: "missing" }, ["compute", "--smooth", "--only", "missing", "--json", "--out-dir", "out"]],
  ["info", {}, ["info", "--json"]], ["info", { deep: true }, ["info", "--deep", "--json"]],
];
const withoutOutput = ({ output, ...rest }) => rest, plain = (value) => JSON.stringify(value).replaceAll("npx norma-mesh ", "norma ");

function compare(call, expected, result, file) {
  const printed = JSON.parse(expected.stdout), told = call === "info" ? result : call === "fix" ? result.report : result.summary;
  if (plain(told) !== plain(call === "compute" ? withoutOutput(printed) : printed)) throw new Error(`${plain(told)}\n${plain(printed)}`);
  if (call === "info") return;
  const own = expected.made.get(basename(file)) ?? readFileSync(file), others = [...expected.made.keys()].filter((name) => name !== basename(file)).sort();
  if (!own.equals(result.bytes)) throw new Error(`${result.bytes.length} bytes, not the ${own.length} of the tool`);
  if (others.join() !== Object.keys(result.files).sort().join() || others.some((name) => !expected.made.get(name).equals(result.files[name]))) throw new Error(`${others} and ${Object.keys(result.files)}`);
}
let compared = 0;
for (const file of files)
  await attempt(`${basename(file)}: fix, compute and info are the tool's`, async () => {
    for (const [call, options, words] of CALLS) {
      const expected = runTool(words, file), asked = { name: basename(file), files: Object.fromEntries(more(file).map((name) => [name, readFileSync(join(dirname(file), name))])), ...options };
      const answer = await norma[call](readFileSync(file), asked).catch((error) => error);
      if (answer instanceof Error) {
        const reason = expected.stderr.trim().split("\n").at(-1).replace(/^norma( \w+)?: /, "") || JSON.parse(expected.stdout).files[0].findings[0].message;
        if (expected.status < 2 || !answer.message.endsWith(reason)) throw new Error(`${call}: ${answer.message}\n${expected.status} ${reason}`);
        continue;
      }
      if (expected.status > 1) throw new Error(`${call} is fine, but the tool says ${expected.stderr}`);
      compare(call, expected, answer, file);
      compared++;
    }
  });
check("most could be compared", compared > 4 * files.length, `${compared} of ${CALLS.length * files.length}`);
await attempt("a worker gives the same", async () => {
  const bytes = readFileSync(files[0]), name = basename(files[0]);
  for (const [call, options] of CALLS) if (plain(await worker[call](bytes, { name, ...options })) !== plain(await norma[call](bytes, { name, ...options }))) throw new Error(call);
  if (!bytes.equals(readFileSync(files[0]))) throw new Error("the bytes were handed over");
});
await attempt("several at once", async () => {
  const all = files.filter((file) => /ball|assets/.test(file)), one = async (file) => plain(await norma.compute(readFileSync(file), { name: basename(file) })), apart = [];
  for (const file of all) apart.push(await one(file));
  if ((await Promise.all(all.map(one))).join() !== apart.join()) throw new Error("others");
});
const encode = (text) => new TextEncoder().encode(text);
for (const ending of ["glb", "gltf", "ply", "b3dm", "i3dm", "cmpt"])
  await attempt(`.${ending} needs no name`, async () => {
    const file = files.find((path) => path.endsWith(`.${ending}`)), content = file ? readFileSync(file) : encode(`${ending}: broken`), name = `file.${ending}`;
    const beside = file ? Object.fromEntries(more(file).map((other) => [other, readFileSync(join(dirname(file), other))])) : {};
    for (const [call, options] of [...CALLS, ["check", {}]]) {
      const asked = call === "check" ? options : { files: beside, ...options };
      const [bare, full] = await Promise.all([asked, { name, ...asked }].map((chosen) => norma[call](content, chosen).then(plain, String)));
      if (bare !== full || /unknown kind|name: /.test(bare)) throw new Error(`${call}: ${bare}\n${full}`);
    }
  });
await attempt("white space before JSON needs no name either", async () => { if ((await norma.check(encode(' \n{"asset":{"version":"2.0"}}'))).files[0].path !== "file.gltf") throw new Error("another name"); });
const bytes = readFileSync(files[0]);
for (const [what, message, work] of [
  ["a name without a format", /unknown kind of file/, () => norma.info(bytes, { name: "a.txt" })], ["a weight that does not exist", /^weight: "heavy"/, () => norma.compute(bytes, { name: "a.obj", weight: "heavy" })], ["a crease out of range", /^crease: 200/, () => norma.compute(bytes, { name: "a.obj", crease: 200 })],
  ["an option of another call", /^options: crease/, () => norma.fix(bytes, { name: "a.obj", crease: 3 })], ["a rule that is none", /N9x/, () => norma.fix(bytes, { name: "a.obj", select: "N9x" })], ["files that are none", /^files: /, () => norma.info(bytes, { name: "a.obj", files: 3 })],
  ["no name", /^name: bytes that begin with "v /, () => norma.info(encode("v 0 0 0\n"))], ["a wrong name", /^name: 3 is not/, () => norma.info(bytes, { name: 3 })], ["no bytes", /^bytes: /, () => norma.info("a.obj", { name: "a.obj" })],
]) {
  const error = await work().catch((given) => given);
  check(`${what}: an error that says so`, error instanceof Error && error.name === "NormaError" && message.test(error.message), String(error?.message));
}
worker.terminate();
if (existsSync(scratch)) rmSync(scratch, { recursive: true });
finish();
