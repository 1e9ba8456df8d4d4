#!/bin/bash
# The pictures of docs/engines.md, drawn by engines that need not be installed: the judge gives the page's verdicts,
# each one that is not a pass is explained there, and harnesses are short.
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
norma=${NORMA_BIN:-$tree/bin/norma}
cd "$root" || exit 1
command -v python3 >/dev/null || { skip "no python3"; finish; exit; }
"$norma" --help >/dev/null || { fail "the tool starts"; finish; exit; }
[ -x "$tree/tests/acid_screens" ] || { skip "the tree was built without images"; finish; exit; }

expected() { python3 -c 'import json, sys; [print(*c) for c in json.load(open("tests/engines/verdicts.json"))[sys.argv[1]]["cells"].items()]' "$1"; }
verdicts() { python3 -c 'import json, sys; [print(c["id"], c["verdict"] + (": " + c["mistake"] if c["mistake"] else "")) for c in json.load(sys.stdin)["cells"]]'; }
for picture in docs/figures/engines/*.jpg; do
    name=$(basename "$picture" .jpg)
    without=$(python3 -c 'import json, sys; print(json.load(open("tests/engines/findings.json")).get(sys.argv[1], {}).get("without", ""))' "$name")
    expected "$name" >"$scratch/expected"
    "$norma" acid --judge "$picture" ${without:+--without "$without"} --json 2>"$scratch/err" | verdicts >"$scratch/verdicts" 2>>"$scratch/err"
    # The page's verdicts are of a picture of four times the pixels: one cell with fine detail may be unclear here, none another.
    wrong=$(diff "$scratch/expected" "$scratch/verdicts" | grep '^>' | grep -v ' unclear$')
    lost=$(diff "$scratch/expected" "$scratch/verdicts" | grep -c '^>')
    if [ "$(wc -l <"$scratch/verdicts")" -ge 24 ] && [ -z "$wrong" ] && [ "$lost" -le 1 ]; then pass "$name: the verdicts of docs/engines.md"; else fail "$name: the verdicts of docs/engines.md" "$(diff "$scratch/expected" "$scratch/verdicts"; cat "$scratch/err")"; fi
    check "$name: its picture is small" test "$(stat -c %s "$picture")" -le 75000
done
check "twelve engines or more" test "$(find docs/figures/engines -name '*.jpg' ! -name norma.jpg | wc -l)" -ge 12

# What is explained: every cell that does not pass, and no cell that does.
unexplained=$(python3 - <<'EOF'
import json
verdicts, findings = (json.load(open(f"tests/engines/{name}.json")) for name in ("verdicts", "findings"))
for name, engine in verdicts.items():
    bad = {cell for cell, verdict in engine.get("cells", {}).items() if verdict not in ("pass", "skipped")}
    for cell in sorted(bad ^ set(findings.get(name, {}).get("cells", {}))):
        print(name, cell)
print(*(f"{name}: no such engine" for name in findings if name not in verdicts), sep="\n", end="")
EOF
)
if [ -z "$unexplained" ]; then pass "each cell that does not pass is explained, and no other"; else fail "each cell that does not pass is explained, and no other" "$unexplained"; fi
long=$(wc -l tests/engines/pages/*.js tests/engines/native/* 2>/dev/null | awk '$2 != "total" && $1 > 60')
if [ -z "$long" ]; then pass "harnesses have at most 60 lines"; else fail "harnesses have at most 60 lines" "$long"; fi
finish
