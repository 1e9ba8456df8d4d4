#!/bin/bash
# Builds the Python wheel into build/python: libnorma and the tool without pictures (they need EGL), then the extension for every Python from 3.9 on.
#   scripts/python.sh            builds
#   scripts/python.sh sanitize   the same with the address sanitizer, in build/python-asan
# Without Draco, whose archive would need the C++ library of the system that the wheel is for.
# The wheel carries the shared libraries of meshoptimizer, libpng, zlib and libjpeg beside the tool and the extension. Its tag is that of this platform; where auditwheel is
# installed, the wheel is repaired to manylinux. Elsewhere: the same commands; on macOS `delocate-wheel`, on Windows nothing more.
set -euo pipefail
cd "$(dirname "$0")/.."
root=$PWD
kind=${1:-}
place=$root/build/python${kind:+-asan}
python=${PYTHON:-/usr/bin/python3}
[ -x "$python" ] || python=python3
mkdir -p "$place"

flags=(-DCMAKE_BUILD_TYPE=Release -DNORMA_WITH_RENDER=OFF -DNORMA_WITH_DRACO=OFF -DNORMA_WEB=OFF -DNORMA_TESTS=OFF -DNORMA_BITS=OFF -DNORMA_EXAMPLES=OFF -DNORMA_SHARED=ON -DNORMA_TOOL_SHARED=ON -DNORMA_INSTALL=OFF
    -DCMAKE_BUILD_RPATH_USE_ORIGIN=ON "-DCMAKE_BUILD_RPATH=\$ORIGIN/../lib")
command -v ccache >/dev/null && flags+=(-DCMAKE_C_COMPILER_LAUNCHER=ccache)
export CFLAGS="" LDFLAGS=""
[ -z "$kind" ] || flags+=(-DCMAKE_C_COMPILER=gcc -DNORMA_SANITIZE=address "-DCMAKE_C_FLAGS_RELEASE=-O1 -g1")
cmake -S . -B "$place/tree" -G Ninja "${flags[@]}" >"$place/build.log" 2>&1 || { tail -n 20 "$place/build.log" >&2; exit 1; }
cmake --build "$place/tree" -- norma-cli >>"$place/build.log" 2>&1 || { grep -E 'error|warning' "$place/build.log" | head -n 20 >&2; exit 1; }

rm -rf "$place/source" "$place"/*.whl
cp -r python "$place/source"
cp README.md LICENSE "$place/source/" 2>/dev/null || true
[ ! -f python/README.md ] || cp python/README.md "$place/source/README.md"
package=$place/source/norma_mesh
mkdir -p "$package/bin" "$package/lib"
install -m 755 "$place/tree/bin/norma" "$package/bin/norma"
[ -n "$kind" ] || strip "$package/bin/norma"
for library in $(ldd "$place/tree/bin/norma" | sed -nE 's/.*lib(norma|meshoptimizer|png|jpeg|z)[^ ]* => ([^ ]+).*/\2/p'); do
    cp -L "$library" "$package/lib/"
done
[ -n "$kind" ] || strip "$package"/lib/libnorma.so.*
[ -z "$kind" ] && export CFLAGS="-DNDEBUG -g0" LDFLAGS="-s" || export CFLAGS="-fsanitize=address -g1" LDFLAGS="-fsanitize=address"
(cd "$place/source" && NORMA_SOURCE=$root NORMA_LIBRARY=$(echo "$package"/lib/libnorma.*) "$python" setup.py --quiet bdist_wheel --dist-dir "$place") >>"$place/build.log" 2>&1 || { tail -n 20 "$place/build.log" >&2; exit 1; }
if [ -z "$kind" ] && command -v auditwheel >/dev/null; then
    auditwheel repair "$place"/*.whl -w "$place/repaired" && mv "$place"/repaired/*.whl "$place" && rm -rf "$place/repaired"
fi
ls "$place"/*.whl
