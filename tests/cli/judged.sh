#!/bin/bash
# Every error and warning of the data set has been looked at: tests/cli/judged-findings.md lists it, with its places and its count and what a person says of it. What is new, gone or other
# is told of here, to be judged; so are shares of useful ones below those asked for. (N001 and N002 of the folder bad/ are told of in words there.)
#   tests/cli/judged.sh [--print]      --print: the rows as they are now, without verdicts
# shellcheck source=tests/support/tap.sh disable=SC2046  # a list of folders
source "$(dirname "$0")/../support/tap.sh"
norma=${NORMA_BIN:-$tree/bin/norma}
data=${NORMA_DATA:-$root/../shared/data}
[ -x "$norma" ] || { fail "the tool is there" "no program at $norma"; finish; exit 1; }
command -v node >/dev/null || { skip "node is not there"; finish; exit; }
[ -d "$data" ] || { skip "the data set is not there"; finish; exit; }

# repro/ holds files that broke the program, not people's.
(cd "$data" && "$norma" check $(find . -mindepth 1 -maxdepth 1 -type d ! -name repro | sort) --no-config --json --max-samples 1) >"$scratch/report.json" 2>"$scratch/err"
node -e '
    const [report, judged, print] = process.argv.slice(1), fs = require("fs"), rows = new Map();
    const key = (file, rule, severity) => file.replace(/^\.\//, "") + " | " + rule + " | " + severity;
    for (const file of JSON.parse(fs.readFileSync(report)).files)
        for (const f of file.findings) {
            if (f.severity === "info" || f.rule === "N001" || (f.rule === "N002" && /^(\.\/)?bad\//.test(file.path))) continue;
            const at = key(file.path, f.rule, f.severity === "error" ? "E" : "W"), row = rows.get(at) ?? { places: 0, count: 0 };
            rows.set(at, { places: row.places + 1, count: row.count + f.count });
        }
    const told = new Map(), shares = new Map(), lines = fs.readFileSync(judged, "utf8").split("\n");
    for (const line of lines) {
        const cells = line.split("|").map((cell) => cell.trim());
        if (cells.length < 8 || !/^N\d{3}$/.test(cells[2]) || !/^[EW]$/.test(cells[3])) continue;
        const at = key(cells[1], cells[2], cells[3]), old = told.get(at) ?? { places: 0, count: 0 };
        told.set(at, { places: old.places + +cells[4], count: old.count + +cells[5] });
        const kind = /^(planted, )?(useful|noise|false): ./.exec(cells[6]);
        if (!kind) console.log("without a verdict:", at);
        const kinds = ["useful", "noise", "false", "planted"];
        for (const of of [cells[2], "all", ...(cells[1].startsWith("fresh/") ? ["fresh"] : [])]) {
            const share = shares.get(of + cells[3]) ?? { of, severity: cells[3], counts: [0, 0, 0, 0] };
            share.counts[kinds.indexOf(kind?.[1] ? "planted" : kind?.[2])] += +cells[4];
            shares.set(of + cells[3], share);
        }
    }
    if (print) { for (const [at, row] of rows) console.log("| " + at + " | " + row.places + " | " + row.count + " | |"); process.exit(); }
    for (const [at, row] of rows) {
        const old = told.get(at);
        if (!old) console.log("not judged:", at, row.places, row.count);
        else if (old.places !== row.places || old.count !== row.count) console.log("judged otherwise:", at, old.places, old.count, "now", row.places, row.count);
    }
    for (const at of told.keys()) if (!rows.has(at)) console.log("gone:", at);
    for (const share of shares.values()) {
        const row = "| " + [share.of, share.severity, ...share.counts].join(" | ") + " |";
        if (!lines.includes(row)) console.log("the table by rule should have:", row);
    }
    for (const of of ["all", "fresh"])
        for (const [severity, least] of [["E", 0.95], ["W", 0.85]]) {
            const [useful, noise, wrong] = shares.get(of + severity)?.counts ?? [0, 0, 1];
            if (useful < least * (useful + noise + wrong)) console.log(of, severity, useful, "useful of", useful + noise + wrong);
            if (wrong) console.log(of, severity, wrong, "are false");
        }
    if (rows.size < 50) console.log("only", rows.size, "findings: nothing was checked");
' -- "$scratch/report.json" "$root/tests/cli/judged-findings.md" "${1:-}" >"$scratch/out"
if [ "${1:-}" = --print ]; then cat "$scratch/out"; exit; fi
if [ -s "$scratch/out" ]; then fail "every error and warning of the data set is judged" "$(cat "$scratch/out")"; else pass "every error and warning of the data set is judged"; fi
finish
