/* norma check on the bytes of a file: the objects that `norma check --format json` prints, built from what check.wasm found. */
import * as given from "./arguments.js";
import { RESULT, fail } from "./arguments.js";
import { makeHeap } from "./heap.js";

const SEVERITIES = ["none", "info", "warning", "error"];
const FIXES = [null, "safe", "unsafe"];
const PROFILES = ["auto", "render", "print", "generated"];
const FORMATS = ["", "obj", "ply", "stl", "gltf", "glb", "b3dm", "i3dm", "cmpt", "3mf"];
const SHADINGS = ["default", "crease", "smooth", "flat"];
const WEIGHTS = ["angle", "area", "uniform", "max", "angle-area", "visible", "angle-lengths"];
const TEXTS = { rule: 0, name: 1, where: 2, unit: 3, message: 4, cause: 5, impact: 6 };
const TOTALS = { error: "errors", warning: "warnings", info: "infos" };

const finite = (number) => (Number.isFinite(number) ? number : null);
const degrees = (radians) => finite(radians * (180 / Math.PI));
/* 60 where 60 was given. */
const givenDegrees = (radians) => finite(Math.round(radians * (180 / Math.PI) * 1e9) / 1e9);

/* vertex, face, normal, position, and whether there is one. */
const readSample = (numbers) => ({ vertex: finite(numbers[0]), face: finite(numbers[1]), normal: finite(numbers[2]), position: numbers[6] ? numbers.slice(3, 6).map(finite) : null });

/* A sample lists only what it has. */
const shortSample = ({ position, ...places }) => ({ ...Object.fromEntries(Object.entries(places).filter(([, number]) => number !== null)), position });

/* "PATH: " says again what the report says first; "PATH:12: " becomes "line 12: ". */
function dropPath(message, path) {
  if (!message.startsWith(`${path}:`)) return message;
  const rest = message.slice(path.length + 1);
  return `${/^\d+:/.test(rest) ? "line " : ""}${rest.trimStart()}`;
}

export function bindCheck(wasm) {
  const heap = makeHeap(wasm.memory, wasm.check_allocate, wasm.check_release, (bytes) => fail(`bytes: out of memory, ${bytes} bytes of WebAssembly memory are not to be had`, RESULT.MEMORY));
  const encode = (text) => new TextEncoder().encode(`${text}\0`);

  const readDeviation = (file, index, lender) => {
    const count = wasm.check_deviation_numbers(), at = lender.block(8 * count);
    wasm.check_deviation(file, index, at);
    const [shading, weight, crease, mean, median, most, largest, ...bins] = heap.doubles(at, count);
    return {
      shading: SHADINGS[shading], weight: SHADINGS[shading] === "flat" ? null : WEIGHTS[weight], crease_deg: givenDegrees(crease),
      mean_deg: degrees(mean), p50_deg: degrees(median), p99_deg: degrees(most), max_deg: degrees(largest),
      histogram: Array.from({ length: bins.length / 2 }, (_, i) => ({ below_deg: givenDegrees(bins[2 * i]), corners: bins[2 * i + 1] })),
    };
  };

  const readCommand = (file, index, path) => heap.lend((lender) => {
    const name = lender.input(encode(path)), length = wasm.check_command(file, index, name, 0, 0);
    if (!length) return null;
    const at = lender.block(length + 1);
    wasm.check_command(file, index, name, at, length + 1);
    return heap.text(at);
  });

  const readFinding = (file, index, path) => heap.lend((lender) => {
    const at = lender.block(8 * 15), text = (which) => heap.text(wasm.check_text(file, index, TEXTS[which]));
    wasm.check_numbers(file, index, at);
    const [severity, count, value, fix, samples, deviates, ...more] = heap.doubles(at, 15), halves = more.slice(0, 2), place = more.slice(2);
    const { vertex, face, position } = readSample(place);
    const sample = (i) => (wasm.check_sample(file, index, i, at), shortSample(readSample(heap.doubles(at, 7))));
    const finding = {
      rule: text("rule"), name: text("name"), severity: SEVERITIES[severity], where: text("where"), count, worst: { value: finite(value), unit: text("unit"), vertex, face, position },
      samples: Array.from({ length: samples }, (_, i) => sample(i)), fix: FIXES[fix], command: readCommand(file, index, path), message: text("message"), cause: text("cause"), impact: text("impact"), ...(SEVERITIES[severity] !== "info" && halves.some((half) => half) ? { mesh: halves.map((half) => half.toString(16).padStart(8, "0")).join("") } : {}),
    };
    return deviates ? { ...finding, deviation: readDeviation(file, index, lender) } : finding;
  });

  const readReport = (file, path, unreadable) => {
    const findings = Array.from({ length: wasm.check_count(file) }, (_, i) => readFinding(file, i, path));
    const status = unreadable ? "unreadable" : wasm.check_is_partly(file) ? "partly" : "checked";
    const summary = { errors: 0, warnings: 0, infos: 0, files: 1, not_checked: status === "checked" ? 0 : 1, exit_status: 0 };
    for (const { severity } of findings) summary[TOTALS[severity]]++;
    summary.exit_status = unreadable ? 3 : summary.errors ? 1 : 0;
    return { schema: "norma-check/1", files: [{ path, profile: PROFILES[wasm.check_profile(file)], status, findings }], summary };
  };

  return (bytes, path, profile) => heap.lend((lender) => {
    const name = lender.input(encode(path)), format = wasm.check_format_of(name);
    if (!format) fail(`name: ${given.spell(path)} does not end in one of ${FORMATS.slice(1).map((ending) => `.${ending}`).join(", ")}`);
    const file = wasm.check_file(lender.input(bytes), bytes.length, name, format, profile) >>> 0;
    if (!file) fail("bytes: out of memory", RESULT.MEMORY);
    try {
      const failed = wasm.check_failed(file) !== 0;
      if (failed) {
        const message = dropPath(heap.text(wasm.check_error(file)) || "out of memory", path);
        if (!wasm.check_report_error(file, lender.input(encode(message)), format, profile)) fail(`${path}: ${message}`, RESULT.MEMORY);
      }
      return readReport(file, path, failed);
    } finally {
      wasm.check_close(file);
    }
  });
}

/* check as a call: the module is loaded when it is first needed. loadModule: () => a promise of its exports; reading: of makeDecoders. */
export function makeCheck(loadModule, reading) {
  let bound = null;
  return async (file, options) => {
    const bytes = given.bytes(file), chosen = given.options(options, "name profile");
    const name = given.fileName(chosen.name, bytes), profile = given.profile(chosen.profile);
    bound ??= loadModule().then(bindCheck);
    const check = await bound.catch((error) => { bound = null; throw error; });
    return reading(() => check(bytes, name, profile));
  };
}
