#!/bin/sh
# Builds the Debian packages of debian/ from a copy of the files that git knows, into BUILD/deb, and has lintian check them. Fails where lintian reports an error or a warning.
set -eu
cd "$(dirname "$0")/.."
root=$PWD
out=$root/${BUILD:-build}/deb
case ${BUILD:-build} in /*) out=$BUILD/deb ;; esac
for tool in dpkg-buildpackage dh; do
    command -v $tool >/dev/null || { echo "$tool is needed: scripts/install-deps.sh deb installs it" >&2; exit 1; }
done
rm -rf "$out"
mkdir -p "$out/source"
git ls-files -z | xargs -0 cp --parents -Pt "$out/source"
mkdir -p "$out/source/build"
cp -r build/npm-bundled "$out/source/build/" # what npm has of the page's
if ! (cd "$out/source" && DEB_BUILD_OPTIONS="parallel=${JOBS:-$(nproc)} ${DEB_BUILD_OPTIONS:-}" dpkg-buildpackage -b -us -uc) >"$out/build.log" 2>&1; then
    grep -E 'error|Error|dh_[a-z]*:' "$out/build.log" | head -n 20 || true
    echo "The packages could not be built; all of it is in $out/build.log" >&2
    exit 1
fi
rm -rf "$out/source"
if command -v lintian >/dev/null; then
    lintian --tag-display-limit 0 --allow-root --fail-on error,warning "$out"/*.changes
else
    echo "lintian is not installed: the packages were not checked"
fi
echo "Packages, to install with apt install:"
ls "$out"/*.deb
