// The table of rules in docs/checking.md: NORMA_BIN=... node tests/repo/rules-table.mjs
// planted: the assertions on a rule in the tests that plant its fault (they run in every build, so that all of them are found); in the data set: files of ../shared/data with an
// error or a warning of it, and how many of these a person who looked did not agree with (tests/cli/judged-findings.md).
import { execFileSync } from "node:child_process";
import { readFileSync, readdirSync } from "node:fs";

const folder = new URL(".", import.meta.url), read = (name) => readFileSync(new URL(name, folder), "utf8");
const norma = process.env.NORMA_BIN ?? new URL("../build/bin/norma", folder).pathname;
const planting = readdirSync(folder).filter((name) => /^test_check_(planted|scene|joined|known)\.c$/.test(name)).map(read).join("\n");
const judged = read("judged-findings.md").split("\n").map((line) => line.split("|").map((cell) => cell.trim())).filter((cells) => cells.length >= 8 && /^N\d{3}$/.test(cells[2]));

console.log("| Rule | Planted | Found | In the data set | Disagreed with | Fix |\n|---|---|---|---|---|---|");
for (const line of execFileSync(norma, ["explain"], { encoding: "utf8" }).trim().split("\n")) {
    const id = line.split(" ")[0], rule = JSON.parse(execFileSync(norma, ["explain", id, "--json"], { encoding: "utf8" }));
    const planted = planting.split(`"${id}"`).length - 1, files = judged.filter((cells) => cells[2] === id), wrong = files.filter((cells) => /^disagree/i.test(cells[6])).length;
    const fix = rule.fix ? `${execFileSync(norma, ["explain", id], { encoding: "utf8" }).match(/^Fix: (\w+)/m)?.[1] ?? ""}${rule.fix === "unsafe" ? "†" : ""}` : "–";
    console.log(`| ${id} ${rule.name} | ${planted} | ${planted ? "all" : "–"} | ${files.length} | ${wrong} | ${fix} |`);
}
