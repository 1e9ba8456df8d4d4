// coverage.mjs: what gcov counted, per file and in all. Fails below 97.5 % of the lines or 89.9 % of the branches: half a point below what was reached on 2026-11-22.
//   node scripts/coverage.mjs TREE [--lines] [--branches]      (scripts/coverage.sh makes TREE and runs the tests in it)
// TREE/files.md gets the table per file, TREE/uncovered.txt the lines that did not run, by file with their number. --lines and --branches print what did not run.
// Lines are those that hold code. A branch is one way out of a condition of the compiled code (each of && and || has its own two, a switch one for each target). What a header or a
// kernel compiled for several instruction sets holds is there several times: the copies for instruction sets count each by itself, those of several source files are added up.
import { execFileSync } from "node:child_process";
import { readdirSync, readFileSync, writeFileSync } from "node:fs";
import { join, relative, resolve } from "node:path";

const root = resolve(import.meta.dirname ?? new URL(".", import.meta.url).pathname, "..");
const [tree, ...flags] = process.argv.slice(2);
const asked = { line: 97.5, branch: 89.9 };
const layers = ["src/core", "src/io"];

// The JSON that gcov prints for each object that was compiled to be counted, run or not.
function* counted() {
    for (const layer of layers) {
        const folder = join(resolve(tree), "CMakeFiles", layer === "src/core" ? "norma-core-objects.dir" : "norma-objects.dir", layer);
        const notes = readdirSync(folder, { recursive: true }).filter(name => name.endsWith(".gcno")).map(name => join(folder, name));
        if (!notes.length) throw new Error(`${folder}: nothing was compiled to be counted`);
        const text = execFileSync("gcov", ["--json-format", "--stdout", "--branch-probabilities", ...notes], { maxBuffer: 1 << 30, stdio: ["ignore", "pipe", "ignore"] });
        for (const line of text.toString().split("\n")) if (line) yield JSON.parse(line);
    }
}

// file -> line number -> { runs, branches: [runs of each] , function }
function gather() {
    const files = new Map();
    for (const unit of counted()) {
        for (const file of unit.files) {
            const name = relative(root, resolve(unit.current_working_directory, file.file));
            if (!layers.some(layer => name.startsWith(layer + "/"))) continue;
            if (!files.has(name)) files.set(name, new Map());
            const lines = files.get(name), here = new Map(); // a line that several functions share is given once for each
            for (const { line_number, count, branches, function_name } of file.lines) {
                const line = here.get(line_number) ?? { runs: 0, branches: [], function: function_name };
                line.runs += count;
                line.branches.push(...branches.map(b => b.count));
                here.set(line_number, line);
            }
            for (const [number, { runs, branches, function: inside }] of here) {
                const line = lines.get(number) ?? { runs: 0, branches: [], function: inside };
                line.runs += runs;
                branches.forEach((count, i) => { line.branches[i] = (line.branches[i] ?? 0) + count; });
                lines.set(number, line);
            }
        }
    }
    return files;
}

const percent = (part, whole) => whole ? (100 * part / whole).toFixed(1) : "-";

function sums(lines) {
    const sum = { lines: 0, run: 0, branches: 0, taken: 0 };
    for (const { runs, branches } of lines.values()) {
        sum.lines++;
        if (runs) sum.run++;
        sum.branches += branches.length;
        sum.taken += branches.filter(count => count).length;
    }
    return sum;
}

const table = ["| File | Lines | of | % | Branches | of | % |", "|---|---|---|---|---|---|---|"];
const row = (name, s) => table.push(`| ${name.startsWith("all") ? `**${name}**` : `\`${name}\``} | ${s.run} | ${s.lines} | ${percent(s.run, s.lines)} | ${s.taken} | ${s.branches} | ${percent(s.taken, s.branches)} |`) && console.log(`${name.padEnd(34)} ${String(s.run).padStart(6)} of ${String(s.lines).padStart(6)} lines ${percent(s.run, s.lines).padStart(6)} %` +
    `   ${String(s.taken).padStart(6)} of ${String(s.branches).padStart(6)} branches ${percent(s.taken, s.branches).padStart(6)} %`);

const add = (a, b) => ({ lines: a.lines + b.lines, run: a.run + b.run, branches: a.branches + b.branches, taken: a.taken + b.taken });
const none = { lines: 0, run: 0, branches: 0, taken: 0 };

const files = gather(), uncovered = [];
let all = none, bad = 0;
for (const layer of layers) {
    let layerSum = none;
    for (const [name, lines] of [...files].sort((a, b) => a[0] < b[0] ? -1 : 1)) {
        if (!name.startsWith(layer + "/")) continue;
        const text = readFileSync(join(root, name), "utf8").split("\n"), sum = sums(lines);
        row(name, sum);
        layerSum = add(layerSum, sum);
        if (sum.run < sum.lines) uncovered.push(`# ${name}: ${sum.lines - sum.run} of ${sum.lines} lines did not run`);
        for (const [number, line] of [...lines].sort((a, b) => a[0] - b[0])) {
            const shown = (text[number - 1] ?? "").trim();
            if (flags.includes("--branches") && line.runs && line.branches.some(count => !count)) console.log(`  ${name}:${number}: branches ${line.branches.map(count => count ? "+" : "-").join("")}  ${shown}`);
            if (line.runs) continue;
            if (flags.includes("--lines")) console.log(`  ${name}:${number}: ${shown}`);
            uncovered.push(`${name}:${number} ${line.function ?? "-"}: ${shown}`);
        }
    }
    row(`all of ${layer}`, layerSum);
    all = add(all, layerSum);
}
row("all", all);
for (const [kind, part, whole] of [["line", all.run, all.lines], ["branch", all.taken, all.branches]]) {
    if (100 * part / whole < asked[kind]) bad++, console.log(`too few: ${percent(part, whole)} % of the ${kind === "line" ? "lines" : "branches"}, asked ${asked[kind]} %`);
}
writeFileSync(join(tree, "files.md"), table.join("\n") + "\n");
writeFileSync(join(tree, "uncovered.txt"), uncovered.join("\n") + "\n");
console.log(`${all.lines - all.run} lines did not run: ${join(tree, "uncovered.txt")}`);
process.exit(bad ? 1 : 0);
