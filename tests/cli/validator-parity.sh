#!/bin/bash
# norma check beside the Khronos validator, over every glTF of the data set, its own test files among them: what it reports about normals and tangents (length, finiteness, signs,
# what lacks its part) Norma reports as well, at the same primitive; and Norma calls nothing wrong by these rules that the validator does not.
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
data=${NORMA_DATA:-$root/../shared/data}
norma=${NORMA_BIN:-$tree/bin/norma}
export NODE_PATH=${NODE_PATH:-$root/build/npm/node_modules}

if [ ! -d "$data" ] || ! command -v node >/dev/null; then
    skip "the data set or node is not there"
    finish
    exit
fi

cd "$data" || exit 1
cut -f1 INDEX.tsv | grep -iE '\.(gltf|glb)$' >"$scratch/files"
"$norma" check --format json --max-samples 1 --files-from "$scratch/files" >"$scratch/report.json" 2>"$scratch/errors"
status=$?
# 3: some of these files are broken on purpose.
if [ "$status" -le 3 ] && [ -s "$scratch/report.json" ]; then pass "$(wc -l <"$scratch/files") files checked"; else fail "files checked" "status $status: $(cat "$scratch/errors")"; fi

tr '\n' '\0' <"$scratch/files" | xargs -0 node "$root/tests/cli/validator/parity.mjs" "$scratch/report.json" >"$scratch/output" 2>&1
status=$?
last=$(tail -n 1 "$scratch/output")
compared=$(sed -nE 's/^[0-9]+ files: ([0-9]+) messages.*/\1/p' "$scratch/output")
if [ "$status" -eq 77 ]; then
    skip "the validator is not installed"
elif [ "$status" -eq 0 ] && [ "${compared:-0}" -gt 3000 ]; then
    pass "$last"
else
    fail "the validator and Norma agree" "$(cat "$scratch/output")"
fi
finish
