/* fix, compute and info: the tool's subcommands on files in memory. A file goes in, with those that it names, and files come out, with the bytes that norma writes. */
import * as given from "./arguments.js";
import { RESULT, fail, spell } from "./arguments.js";
import { makeDecoders } from "./decoders.js";
import { makeMemoryHost, startTool } from "./memory-host.js";

const OUT = ".norma-out", FINDINGS = 1;

const baseOf = (name) => name.slice(name.lastIndexOf("/") + 1);

/* The file and those beside it, by name. */
function filesOf(bytes, name, more = {}) {
  if (typeof more !== "object" || more === null || ArrayBuffer.isView(more)) fail(`files: ${spell(more)} is not an object with the bytes of each name`);
  return new Map([...Object.entries(more).map(([other, content]) => [given.name(other, "files"), given.bytes(content, `files.${other}`)]), [name, given.bytes(bytes)]]);
}

const rulesOf = (value, what) => {
  const rules = Array.isArray(value) ? value : [value];
  if (!rules.length || rules.some((rule) => typeof rule !== "string" || rule === "")) fail(`${what}: ${spell(value)} is neither a rule such as "N301" nor a list of them`);
  return rules.join();
};
const oneOf = (names) => (value, what) => names[given.numberOf(names, value, what)];
const weldOf = (value) => { given.weld(value); return String(value); };

/* Words of the command line for an option; undefined: a flag. */
const FIX = { profile: (value) => { given.profile(value); return value; }, select: rulesOf, ignore: rulesOf };
const COMPUTE = {
  crease: (value) => String(given.crease(value)), weight: (value) => { given.weight(value); return value; }, weld: weldOf, nonManifold: (value) => { given.nonManifold(value); return value; },
  groups: oneOf(["auto", "ignore"]), only: oneOf(["all", "missing", "broken"]), tangents: oneOf(["keep", "orthogonalise", "regenerate"]), smooth: undefined, flat: undefined, morphs: undefined,
};
const wordOf = (name) => `--${name.replace(/[A-Z]/g, (letter) => `-${letter.toLowerCase()}`)}`;
const wordsOf = (chosen, table) => Object.entries(table).filter(([name]) => chosen[name] !== undefined)
  .flatMap(([name, spelled]) => (spelled ? [wordOf(name), spelled(chosen[name], name)] : given.flag(chosen[name], name) ? [wordOf(name)] : []));

/* What the tool says of an error, without its own name; check says it in its report. */
function reasonOf({ stdout, stderr }) {
  if (stderr) return stderr.trim().split("\n").at(-1).replace(/^norma( \w+)?: /, "");
  const { files: [{ path, findings: [{ message }] }] } = JSON.parse(stdout);
  return `${path}: ${message}`;
}

/* loadModule: () => a promise of tool.wasm as a WebAssembly.Module. */
export function makeTool(loadModule, libraries) {
  let compiled = null;
  const run = async (words, files) => {
    compiled ??= loadModule();
    const module = await compiled.catch((error) => { compiled = null; throw error; }), decoders = makeDecoders(libraries);
    return decoders.reading(({ host, exports }) => host.finish(startTool(exports)), undefined, async () => {
      let exports = null;
      const host = makeMemoryHost(words, files, () => exports.memory), { norma, ...wasi } = host.imports;
      ({ exports } = await WebAssembly.instantiate(module, { ...wasi, norma: { ...norma, ...decoders.imports.norma } }));
      decoders.serve(exports);
      return { host, exports };
    });
  };
  const work = async (words, files, most = 0) => {
    const ended = await run(words, files);
    if (ended.status > most) fail(reasonOf(ended), /out of memory/.test(ended.stderr) ? RESULT.MEMORY : RESULT.ARGUMENT);
    return ended;
  };
  /* The file that was written, and those that belong to it. */
  const written = ({ files }, name, bytes) => {
    const made = new Map([...files].filter(([path]) => path.startsWith(`${OUT}/`)).map(([path, content]) => [path.slice(OUT.length + 1), content])), own = baseOf(name);
    const result = made.get(own) ?? given.bytes(bytes).slice();
    made.delete(own);
    return { bytes: result, files: Object.fromEntries(made) };
  };

  return {
    fix: async (bytes, options) => {
      const chosen = given.options(options, "name files unsafe profile select ignore"), name = given.fileName(chosen.name, given.bytes(bytes)), words = wordsOf(chosen, FIX);
      const ended = await work(["check", given.flag(chosen.unsafe, "unsafe") ? "--fix-unsafe" : "--fix", "--no-config", "--format", "json", "--out-dir", OUT, ...words, "--", name], filesOf(bytes, name, chosen.files), FINDINGS);
      return { ...written(ended, name, bytes), report: JSON.parse(ended.stdout) };
    },
    compute: async (bytes, options) => {
      const chosen = given.options(options, `name files ${Object.keys(COMPUTE).join(" ")}`), name = given.fileName(chosen.name, given.bytes(bytes)), words = wordsOf(chosen, COMPUTE);
      const ended = await work(["compute", "--json", "--out-dir", OUT, ...words, "--", name], filesOf(bytes, name, chosen.files));
      const { output, ...summary } = JSON.parse(ended.stdout); // its name is one of ours
      return { ...written(ended, name, bytes), summary };
    },
    info: async (bytes, options) => {
      const chosen = given.options(options, "name files deep"), name = given.fileName(chosen.name, given.bytes(bytes));
      return JSON.parse((await work(["info", "--json", ...(given.flag(chosen.deep, "deep") ? ["--deep"] : []), "--", name], filesOf(bytes, name, chosen.files))).stdout);
    },
  };
}
