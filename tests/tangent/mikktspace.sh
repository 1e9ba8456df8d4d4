#!/bin/bash
# The tangents of norma_corner_tangents against other programs that make MikkTSpace's.
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
modules=${NORMA_NPM_TANGENT:-$root/build/npm-tangent/node_modules}
if ! [ -d "$modules/three" ] || ! command -v node >/dev/null; then
    skip "tangents of other programs: scripts/install-deps.sh has not been run"
    finish
    exit
fi
files=()
data=${NORMA_DATA:-$root/../shared/data}
[ ! -d "$data" ] || mapfile -t files < <(find "$data" \( -name '*.glb' -o -name '*.gltf' -o -name '*.obj' \) -size -20M | sort)
exec node "$root/tests/tangent/mikktspace.mjs" "$tree/tests/tangents_of" "$modules" "${files[@]}"
