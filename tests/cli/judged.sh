#!/bin/bash
# Every error and warning of the data set has been looked at: tests/cli/judged-findings.md lists it, with its places and its count and what a person says of it. What is new, gone or other
# is told of here, to be judged. (N001 and N002 of the folder bad/ are told of in words there.)
#   tests/cli/judged.sh [--print]      --print: the rows as they are now, without verdicts
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
norma=${NORMA_BIN:-$tree/bin/norma}
data=${NORMA_DATA:-$root/../shared/data}
[ -x "$norma" ] || { fail "the tool is there" "no program at $norma"; finish; exit 1; }
command -v node >/dev/null || { skip "node is not there"; finish; exit; }
[ -d "$data" ] || { skip "the data set is not there"; finish; exit; }

(cd "$data" && "$norma" check . --no-config --json --max-samples 1) >"$scratch/report.json" 2>"$scratch/err"
node -e '
    const [report, judged, print] = process.argv.slice(1), fs = require("fs"), rows = new Map();
    const key = (file, rule, severity) => file.replace(/^\.\//, "") + " | " + rule + " | " + severity;
    for (const file of JSON.parse(fs.readFileSync(report)).files)
        for (const f of file.findings) {
            if (f.severity === "info" || f.rule === "N001" || (f.rule === "N002" && /^(\.\/)?bad\//.test(file.path))) continue;
            const at = key(file.path, f.rule, f.severity === "error" ? "E" : "W"), row = rows.get(at) ?? { places: 0, count: 0 };
            rows.set(at, { places: row.places + 1, count: row.count + f.count });
        }
    const told = new Map();
    for (const line of fs.readFileSync(judged, "utf8").split("\n")) {
        const cells = line.split("|").map((cell) => cell.trim());
        if (cells.length < 8 || !/^N\d{3}$/.test(cells[2]) || !/^[EW]$/.test(cells[3]) || cells[2] === "N001" || (cells[2] === "N002" && cells[1].startsWith("bad/"))) continue;
        told.set(key(cells[1], cells[2], cells[3]), { places: +cells[4], count: +cells[5], verdict: cells[6] });
    }
    if (print) { for (const [at, row] of rows) console.log("| " + at + " | " + row.places + " | " + row.count + " | |"); process.exit(); }
    for (const [at, row] of rows) {
        const old = told.get(at);
        if (!old) console.log("not judged:", at, row.places, row.count);
        else if (old.places !== row.places || old.count !== row.count) console.log("judged otherwise:", at, old.places, old.count, "now", row.places, row.count);
        else if (!old.verdict) console.log("without a verdict:", at);
    }
    for (const at of told.keys()) if (!rows.has(at)) console.log("gone:", at);
    if (rows.size < 50) console.log("only", rows.size, "findings: nothing was checked");
' -- "$scratch/report.json" "$root/tests/cli/judged-findings.md" "${1:-}" >"$scratch/out"
if [ "${1:-}" = --print ]; then cat "$scratch/out"; exit; fi
if [ -s "$scratch/out" ]; then fail "every error and warning of the data set is judged" "$(cat "$scratch/out")"; else pass "every error and warning of the data set is judged"; fi
finish
