#!/bin/bash
# The table that generators and libraries of models are compared by: for each origin, the share of its models that have each fault. A model counts once for a fault, however often
# it has it; infos are left out, unless --info is given. The origin of a file is what FOLDER/INDEX.tsv says (columns "file" and "origin", as far as it lists it), else the first
# folder below FOLDER. Markdown on standard output.
#   scripts/census.sh FOLDER [OPTION OF NORMA CHECK...]
#   scripts/census.sh models --profile generated
# NORMA_BIN: the tool (build/bin/norma). Exit status: 0, or 2 where the table could not be made.
set -euo pipefail
here=$(cd "$(dirname "$0")/.." && pwd)
[ $# -ge 1 ] && [ -d "$1" ] || { echo "usage: $0 FOLDER [OPTION OF NORMA CHECK...]" >&2; exit 2; }
folder=$1
shift
report=$(mktemp)
trap 'rm -f "$report"' EXIT
"${NORMA_BIN:-$here/build/bin/norma}" check "$folder" --no-config --format json --exit job "$@" >"$report" || exit 2
python3 - "$folder" "$report" "$*" <<'PYTHON'
import csv, json, os, sys
from collections import Counter, defaultdict

folder, report, options = sys.argv[1:]
files = json.load(open(report, encoding="utf-8"))["files"]
index = os.path.join(folder, "INDEX.tsv")
listed = {}
if os.path.exists(index):
    with open(index, newline="", encoding="utf-8") as lines:
        listed = {row["file"]: row["origin"] for row in csv.DictReader(lines, delimiter="\t")}

models, clean, faults, names = Counter(), Counter(), defaultdict(Counter), {}
for file in files:
    inside = os.path.relpath(file["path"], folder)
    origin = listed.get(inside) or (inside.split(os.sep)[0] if os.sep in inside else ".")
    shown = {f["rule"]: f["name"] for f in file["findings"] if "--info" in options.split() or f["severity"] != "info"}
    names.update(shown)
    models[origin] += 1
    clean[origin] += not shown
    for rule in shown:
        faults[rule][origin] += 1
if not models:
    sys.exit("census: no models")

def row(label, counts):
    shares = [100 * counts[origin] / models[origin] for origin in origins] + [100 * sum(counts.values()) / sum(models.values())]
    print(f"| {label} | " + " | ".join(f"{share:.0f} %" if share else "" for share in shares) + " |")

origins = sorted(models)
print("| | " + " | ".join(origin.replace("|", "\\|") for origin in origins) + " | all |")
print("|---|" + "---:|" * (len(origins) + 1))
print("| models | " + " | ".join(str(models[origin]) for origin in origins) + f" | {sum(models.values())} |")
row("without fault", clean)
for rule in sorted(faults):
    row(f"{rule} {names[rule]}", faults[rule])
PYTHON
