#!/bin/bash
# Builds the Blender add-on, build/blender/norma-blender-VERSION-PLATFORM.zip: the files of blender/norma_normals with their own copy of the Python package, from its wheel.
# The zip installs in Blender 3.4 to 4.1 as an add-on and in 4.2 and later as an extension. The wheel is built if there is none that is newer than its sources.
set -euo pipefail
cd "$(dirname "$0")/.."
place=$PWD/build/blender
python=${PYTHON:-/usr/bin/python3}
[ -x "$python" ] || python=python3

newest() { find "$1" -maxdepth 1 -name '*.whl' -printf '%T@ %p\n' 2>/dev/null | sort -n | tail -n 1 | cut -d' ' -f2-; }
mkdir -p build/python
wheel=$(newest build/python)
if [ -z "$wheel" ] || [ -n "$(find python src include scripts/python.sh -type f -newer "$wheel" -print -quit)" ]; then
    scripts/python.sh >/dev/null
    wheel=$(newest build/python)
fi

rm -rf "$place"
mkdir -p "$place/norma_normals"
cp blender/norma_normals/*.py "$place/norma_normals/"
cp LICENSE "$place/norma_normals/"
cp blender/README.md "$place/norma_normals/"
"$python" -m zipfile -e "$wheel" "$place/wheel"
cp -r "$place/wheel/norma_mesh" "$place/norma_normals/norma_mesh"
# The tool is not needed: the add-on calls the library.
rm -rf "$place/norma_normals/norma_mesh/bin" "$place/wheel"

version=$(sed -nE 's/^#define NORMA_VERSION_(MAJOR|MINOR|PATCH) +([0-9]+).*/\2/p' include/norma/norma.h | paste -sd.)
case $(basename "$wheel" .whl) in
*manylinux*x86_64 | *linux_x86_64) platform=linux-x64 ;;
*linux*aarch64) platform=linux-arm64 ;;
*macosx*arm64) platform=macos-arm64 ;;
*macosx*x86_64) platform=macos-x64 ;;
*win_amd64) platform=windows-x64 ;;
*) echo "scripts/blender.sh: no Blender platform fits $wheel" >&2; exit 1 ;;
esac
sed -e "s/@PLATFORM@/$platform/" -e "s/^version = .*/version = \"$version\"/" blender/norma_normals/blender_manifest.toml >"$place/norma_normals/blender_manifest.toml"
sed -i "s/^    \"version\": .*/    \"version\": (${version//./, }),/" "$place/norma_normals/__init__.py"

# The same files give the same bytes: sorted names, one time for all.
"$python" - "$place" "norma-blender-$version-$platform.zip" <<'PYTHON'
import os
import sys
import time
import zipfile

place, name = sys.argv[1:]
moment = time.gmtime(int(os.environ.get("SOURCE_DATE_EPOCH", "315532800")))[:6]
with zipfile.ZipFile(os.path.join(place, name), "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
    paths = [os.path.join(folder, file) for folder, _, files in os.walk(os.path.join(place, "norma_normals")) for file in files]
    for path in sorted(paths):
        info = zipfile.ZipInfo(os.path.relpath(path, place), moment)
        info.external_attr = (0o755 if path.endswith((".so", ".pyd")) else 0o644) << 16
        info.compress_type = zipfile.ZIP_DEFLATED
        with open(path, "rb") as file:
            archive.writestr(info, file.read(), compresslevel=9)
PYTHON
rm -rf "$place/norma_normals"
ls "$place"/*.zip
