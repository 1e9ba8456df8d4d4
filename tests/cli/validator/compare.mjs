// compare.mjs: which messages of the Khronos glTF validator did a tool add to a file?
//
//   node compare.mjs [options] INPUT OUTPUT [INPUT OUTPUT ...]
//   node compare.mjs [options] --list PAIRS        PAIRS: a file, or - for standard input; a line: INPUT tab OUTPUT
//
//   --json FILE   everything as JSON (- : standard output, and the text goes to standard error)
//   --strict      a code that the input has, but less often, counts as new too
//   --allow CODE  a code that may be new; can be given several times
//
// A message is new where its code is reported for the output and not at all for the input, whatever its severity (error, warning,
// information, hint). Codes that were there and only come more often are listed as "more" (a mesh that becomes one for each of its nodes
// repeats its faults), and are new with --strict. An output equal to its input, byte for byte, is passed without a look.
// A line for each new code, and at the end one with counts. Exit status: 0 nothing new, 1 something new, 2 usage, 3 a file that could not be
// read or validated, 77 the npm package is not installed (run npm ci in this folder, or let NODE_PATH name a node_modules).
//
// Buffers and images beside a file are read from its folder. maxIssues is 0, no limit: the validator's own default of 100 would hide codes.
import { createRequire } from "node:module";
import { readFile, writeFile } from "node:fs/promises";
import path from "node:path";

const severityNames = ["error", "warning", "information", "hint"];

function loadValidator() {
  try {
    return createRequire(import.meta.url)("gltf-validator");
  } catch {
    console.error("compare.mjs: gltf-validator is not installed: run npm ci in tests/cli/validator");
    process.exit(77);
  }
}

function usage(message) {
  console.error(`compare.mjs: ${message}; usage: node compare.mjs [--json FILE] [--strict] [--allow CODE] INPUT OUTPUT ... | --list PAIRS`);
  process.exit(2);
}

async function pairsOfList(name) {
  const text = await readFile(name === "-" ? 0 : name, "utf8");
  return text.split("\n").filter((line) => line !== "").map((line) => {
    const fields = line.split("\t");
    if (fields.length !== 2) usage(`a line of ${name} is not INPUT tab OUTPUT: ${line}`);
    return fields;
  });
}

async function parseArguments(words) {
  const options = { pairs: [], strict: false, json: null, allow: new Set() };
  const files = [];
  while (words.length) {
    const word = words.shift();
    const value = () => (words.length ? words.shift() : usage(`${word} needs a value`));
    if (word === "--strict") options.strict = true;
    else if (word === "--json") options.json = value();
    else if (word === "--allow") options.allow.add(value());
    else if (word === "--list") options.pairs.push(...(await pairsOfList(value())));
    else if (word.startsWith("--")) usage(`unknown option ${word}`);
    else files.push(word);
  }
  if (files.length % 2) usage("files come in pairs");
  for (let i = 0; i < files.length; i += 2) options.pairs.push([files[i], files[i + 1]]);
  if (!options.pairs.length) usage("nothing to compare");
  return options;
}

// Code -> {severity, count, first: the first such message}.
async function messagesOf(validator, file, bytes) {
  const beside = (uri) => readFile(path.resolve(path.dirname(file), decodeURIComponent(uri))).then((data) => new Uint8Array(data));
  const report = await validator.validateBytes(new Uint8Array(bytes), { uri: path.basename(file), maxIssues: 0, writeTimestamp: false, externalResourceFunction: beside });
  if (report.issues.truncated) throw new Error("the validator's report is truncated");
  const codes = new Map();
  for (const { code, severity, message, pointer, offset } of report.issues.messages) {
    const seen = codes.get(code);
    if (seen) seen.count++;
    else codes.set(code, { severity: severityNames[severity], count: 1, first: `${pointer ?? (offset === undefined ? "" : `@${offset}`)} ${message}`.trim() });
  }
  return codes;
}

async function comparePair(validator, [input, output], options) {
  const result = { input, output, identical: false, new: [], more: [], error: null };
  try {
    const [before, after] = await Promise.all([readFile(input), readFile(output)]);
    if (before.equals(after) && path.dirname(input) === path.dirname(output)) return { ...result, identical: true };
    const old = await messagesOf(validator, input, before);
    for (const [code, found] of await messagesOf(validator, output, after)) {
      const had = old.get(code)?.count ?? 0;
      const entry = { code, ...found, before: had };
      if (options.allow.has(code) || found.count <= had) continue;
      (had === 0 || options.strict ? result.new : result.more).push(entry);
    }
  } catch (error) {
    result.error = String(error?.message ?? error);
  }
  return result;
}

const options = await parseArguments(process.argv.slice(2));
const validator = loadValidator();
const say = options.json === "-" ? console.error : console.log;
const results = [];
for (const pair of options.pairs) {
  const result = await comparePair(validator, pair, options);
  results.push(result);
  for (const entry of result.new) say(`${result.output}: new ${entry.severity} ${entry.code}, ${entry.before} -> ${entry.count}: ${entry.first}`);
  if (result.error !== null) say(`${result.output}: not validated: ${result.error}`);
}
const summary = {
  pairs: results.length,
  with_new_messages: results.filter((result) => result.new.length).length,
  with_more_messages: results.filter((result) => result.more.length).length,
  not_validated: results.filter((result) => result.error !== null).length,
};
if (options.json !== null) {
  const text = JSON.stringify({ validator: validator.version(), summary, results }, null, 1) + "\n";
  if (options.json === "-") process.stdout.write(text);
  else await writeFile(options.json, text);
}
say(`${summary.pairs} pairs, ${summary.with_new_messages} with new messages, ${summary.with_more_messages} with more of old ones, ${summary.not_validated} not validated`);
process.exitCode = summary.not_validated ? 3 : summary.with_new_messages ? 1 : 0;
