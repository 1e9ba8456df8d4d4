// parity.mjs: what the Khronos glTF validator reports about normals and tangents, does norma check report as well, and the other way round?
//
//   node parity.mjs REPORT FILE ...        REPORT: what norma check --format json printed for these files, "-" for standard input
//
// One way: each message of a code below must be matched by one of its rules at the same primitive, or by the file being unreadable (N001). Other way: where Norma calls a file
// wrong by a rule that the validator has with the same threshold, the validator must as well. A line for each mismatch, one with counts at the end. Exit status: 0 none,
// 1 some, 2 usage, 77 the npm package is not installed.
import { createRequire } from "node:module";
import { readFile } from "node:fs/promises";
import path from "node:path";

let validator;
try {
  validator = createRequire(import.meta.url)("gltf-validator");
} catch {
  console.error("parity.mjs: gltf-validator is not installed: run npm ci in tests/cli/validator");
  process.exit(77);
}

const attributeOf = (pointer) => pointer.split("/").pop();
const ofNormals = (pointer) => attributeOf(pointer) === "NORMAL";
const ofTangents = (pointer) => attributeOf(pointer) === "TANGENT";
const ofEither = (pointer) => ofNormals(pointer) || ofTangents(pointer);

// code, which of its pointers, what Norma calls it
const codes = [
  ["ACCESSOR_VECTOR3_NON_UNIT", ofNormals, ["N101", "N102", "N103"]],
  ["ACCESSOR_VECTOR3_NON_UNIT", ofTangents, ["N801"]],
  ["ACCESSOR_INVALID_SIGN", ofTangents, ["N802"]],
  ["ACCESSOR_INVALID_FLOAT", ofNormals, ["N101"]],
  ["ACCESSOR_INVALID_FLOAT", ofTangents, ["N801", "N802"]],
  ["MESH_PRIMITIVE_MORPH_TARGET_NO_BASE_ACCESSOR", ofEither, ["N903"]],
  ["MESH_PRIMITIVE_TANGENT_WITHOUT_NORMAL", () => true, ["N806"]],
  ["MESH_PRIMITIVE_GENERATED_TANGENT_SPACE", () => true, ["N805"]],
  ["MESH_PRIMITIVE_UNEQUAL_ACCESSOR_COUNT", ofNormals, ["N106"]],
  ["MESH_PRIMITIVE_UNEQUAL_ACCESSOR_COUNT", () => true, []],
  ["MESH_PRIMITIVE_MORPH_TARGET_INVALID_ATTRIBUTE_COUNT", () => true, []],
  ["MESH_PRIMITIVE_ATTRIBUTES_ACCESSOR_INVALID_FORMAT", ofEither, []],
  ["ACCESSOR_INDEX_OOB", () => true, []],
];

// rule, codes of which the validator must then have one
const backwards = [
  ["N101", ["ACCESSOR_INVALID_FLOAT"]],
  ["N102", ["ACCESSOR_VECTOR3_NON_UNIT"]],
  ["N802", ["ACCESSOR_INVALID_SIGN", "ACCESSOR_INVALID_FLOAT"]],
  ["N806", ["MESH_PRIMITIVE_TANGENT_WITHOUT_NORMAL"]],
  ["N903", ["MESH_PRIMITIVE_MORPH_TARGET_NO_BASE_ACCESSOR"]],
];

async function messagesOf(file) {
  const folder = path.dirname(file);
  const options = {
    uri: path.basename(file),
    maxIssues: 0,
    externalResourceFunction: async (uri) => new Uint8Array(await readFile(path.join(folder, decodeURIComponent(uri)))),
  };
  try {
    return (await validator.validateBytes(new Uint8Array(await readFile(file)), options)).issues.messages;
  } catch {
    return null; // no glTF at all
  }
}

const within = (where, pointer) => where === "" || pointer === where || pointer.startsWith(where + "/");

function missing(message, findings) {
  const pointer = message.pointer ?? "";
  const row = codes.find(([code, wanted]) => code === message.code && wanted(pointer));
  if (!row) return null;
  const found = findings.some((f) => (f.rule === "N001" || row[2].includes(f.rule)) && within(f.where, pointer));
  return { counted: true, missing: !found };
}

const [reportName, ...files] = process.argv.slice(2);
if (!reportName || !files.length) {
  console.error("parity.mjs: usage: node parity.mjs REPORT FILE ...");
  process.exit(2);
}
const report = JSON.parse(await readFile(reportName === "-" ? 0 : reportName, "utf8"));
const findingsOf = new Map(report.files.map((file) => [path.resolve(file.path), file.findings]));
let messages = 0, rules = 0, mismatches = 0;
for (const file of files) {
  const findings = findingsOf.get(path.resolve(file));
  const issued = await messagesOf(file);
  if (!findings) {
    console.log(`${file}: not in the report`);
    mismatches++;
    continue;
  }
  for (const message of issued ?? []) {
    const verdict = missing(message, findings);
    if (!verdict) continue;
    messages++;
    if (!verdict.missing) continue;
    mismatches++;
    console.log(`${file}: ${message.code} ${message.pointer}: not found by Norma: ${message.message}`);
  }
  for (const [rule, wanted] of backwards) {
    if (!issued || !findings.some((f) => f.rule === rule)) continue;
    rules++;
    if (issued.some((message) => wanted.includes(message.code))) continue;
    mismatches++;
    console.log(`${file}: ${rule}: not found by the validator`);
  }
}
console.log(`${files.length} files: ${messages} messages of the validator and ${rules} rules of Norma compared, ${mismatches} mismatches`);
process.exit(mismatches ? 1 : 0);
