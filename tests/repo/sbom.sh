#!/bin/bash
# The bill of materials is what scripts/sbom.mjs makes of the project's files now.
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
cd "$root" || exit 1
check "docs/sbom.spdx.json is current" node scripts/sbom.mjs --check
check "it names each dependency of the build with its least version" bash -c 'for name in meshoptimizer draco jansson png cmocka gmp; do grep -A 1 "\"name\": \"$name\"" docs/sbom.spdx.json | grep -q "\"versionInfo\": \">=[0-9.]*\"" || exit 1; done'
check "it names what page and npm package contain" bash -c 'for name in draco3dgltf meshoptimizer fflate mediabunny three; do grep -A 1 "\"SPDXRef-npm-$name-.*\"," docs/sbom.spdx.json | grep -q "\"relationshipType\": \"CONTAINED_BY\"" || exit 1; done'
finish
