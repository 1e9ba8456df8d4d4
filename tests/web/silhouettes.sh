#!/bin/bash
# What norma render draws of glTF files with skins, morph targets and instances covers the same pixels as what three.js draws of them, within one in a hundred: see silhouettes.mjs.
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
cd "$root" || exit 1
norma=${NORMA_BIN:-$tree/bin/norma}
data=${NORMA_DATA:-$root/../shared/data}
modules=$root/build/npm-web/node_modules
[ -d "$modules/three" ] || modules=${NODE_PATH:-}
for need in "$modules/three" "$modules/esbuild" "$data/INDEX.tsv"; do
    if [ ! -e "$need" ]; then skip "silhouettes against three.js ($(basename "$need") is not here: scripts/install-deps.sh)"; finish; exit; fi
done
if ! command -v chromium >/dev/null && ! command -v google-chrome >/dev/null && [ -z "${NORMA_CHROME:-}" ]; then
    skip "silhouettes against three.js (chromium is not installed: scripts/install-deps.sh)"
    finish
    exit
fi
mapfile -t files < <(awk -F'\t' '($2 == "gltf" || $2 == "glb") && $1 !~ /^bad\// && tolower($0) ~ /skins [1-9]|morph targets [1-9]|instanc/ { print $1 }' "$data/INDEX.tsv")
check "the data set has skinned, morphed and instanced files" test "${#files[@]}" -gt 10
status=0
output=$(NODE_PATH=$modules node tests/web/silhouettes.mjs "$norma" "$data" "$scratch/silhouettes" "${files[@]}" 2>"$scratch/silhouettes.err") || status=$?
while IFS= read -r line; do
    case $line in
    "ok "*) pass "${line#ok }" ;;
    "not ok "*) fail "${line#not ok }" ;;
    esac
done <<<"$output"
check "all of them were compared" test "$(grep -c '^\(not \)\?ok [^p]' <<<"$output")" = "${#files[@]}"
check "and some with joints turned and weights set" test "$(grep -c '^\(not \)\?ok posed/' <<<"$output")" -gt 8
[ "$status" -le 1 ] || fail "the comparison ran to its end" "$(cat "$scratch/silhouettes.err")"
finish
