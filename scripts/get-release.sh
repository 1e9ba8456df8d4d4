#!/bin/bash
# Puts the tool of a release into build/bin, for action.yml, instead of building it:
#   scripts/get-release.sh OWNER/NAME TAG
# Fails, and changes nothing, where there is no release for this machine or its checksum is another one. NORMA_RELEASES: where releases lie, if not at GitHub.
set -euo pipefail
cd "$(dirname "$0")/.."
base=${NORMA_RELEASES:-https://github.com/${1:?OWNER/NAME}/releases/download/${2:?TAG}}
version=$(sed -nE 's/^#define NORMA_VERSION_(MAJOR|MINOR|PATCH) +([0-9]+).*/\2/p' include/norma/norma.h | paste -sd.)
name=norma-$version-linux-$(uname -m)
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
curl -fsSL --retry 2 -o "$place/SHA256SUMS" "$base/SHA256SUMS"
curl -fsSL --retry 2 -o "$place/$name.tar.gz" "$base/$name.tar.gz"
(cd "$place" && grep " $name.tar.gz\$" SHA256SUMS | sha256sum --check --quiet)
tar -xzf "$place/$name.tar.gz" -C "$place"
"$place/$name/norma" --version
mkdir -p build/bin
cp -r "$place/$name/norma" "$place/$name/lib" build/bin/
