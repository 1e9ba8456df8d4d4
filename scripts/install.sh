#!/bin/sh
# What `make install` does after building: installs BUILD into PREFIX (below DESTDIR, if that is given) and makes programs find the shared library, or says how.
set -eu
cd "$(dirname "$0")/.."
build=${BUILD:-build}
prefix=${PREFIX:-/usr/local}
mkdir -p "${DESTDIR:-}$prefix" 2>/dev/null || true
if [ ! -w "${DESTDIR:-}$prefix" ]; then
    echo "$prefix cannot be written to: run sudo make install, or choose a folder: make install PREFIX=\$HOME/.local" >&2
    exit 1
fi
cmake --install "$build" --prefix "$prefix" >"$build/install.log" || { cat "$build/install.log"; exit 1; }
echo "Installed into ${DESTDIR:-}$prefix: $(grep -cE '^-- (Installing|Up-to-date): ' "$build/install.log") files, listed in $build/install_manifest.txt"
[ -z "${DESTDIR:-}" ] || exit 0

library=$(grep -E '/libnorma\.so$' "$build/install_manifest.txt" | head -n 1)
[ -n "$library" ] || exit 0
folder=$(dirname "$library")
[ "$(id -u)" -ne 0 ] || ldconfig 2>/dev/null || PATH=$PATH:/sbin:/usr/sbin ldconfig || true
if PATH=$PATH:/sbin:/usr/sbin ldconfig -p 2>/dev/null | grep -qF " $folder/libnorma.so."; then
    echo "Programs find it at once."
else
    echo "So that the compiler and programs find it there:"
    echo "  export PKG_CONFIG_PATH=$folder/pkgconfig LD_LIBRARY_PATH=$folder"
fi
case ":$PATH:" in *":$prefix/bin:"*) ;; *) echo "  export PATH=$prefix/bin:\$PATH" ;; esac
