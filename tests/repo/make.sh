#!/bin/bash
# make ends with what was built, not with the compiler's lines; V=1 shows those, and so does a build that fails. make install says how programs find the library. Tried with
# the core alone, which is built quickly.
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
cd "$root" || exit 1
export BUILD=$scratch/build

export CMAKE_FLAGS="-DNORMA_FILES=OFF -DNORMA_SHARED=OFF -DCMAKE_BUILD_TYPE=Debug"

scripts/build.sh >"$scratch/said" 2>&1
check "a build succeeds" test -f "$BUILD/lib/libnorma-core.a"
check "it leaves the page and the npm package to make web" grep -q '^NORMA_WEB:[A-Z]*=OFF' "$BUILD/CMakeCache.txt"
check "it prints at most ten lines" test "$(wc -l <"$scratch/said")" -le 10
check "it ends with what was built" bash -c 'tail -n 1 "$0" | grep -q "libnorma-core.a"' "$scratch/said"
find "$BUILD" -name 'call.c.o' -delete
V=1 scripts/build.sh >"$scratch/said" 2>&1
check "V=1 shows each file" grep -q 'call.c' "$scratch/said"
if CMAKE_FLAGS="$CMAKE_FLAGS -DCMAKE_C_FLAGS=-Dnorma_version=0" scripts/build.sh >"$scratch/said" 2>&1; then
    fail "a build that fails is an error" "$(cat "$scratch/said")"
else
    check "a build that fails shows the compiler's error" grep -q 'error: expected identifier' "$scratch/said"
    check "and names the log" grep -qF "$BUILD/build.log" "$scratch/said"
fi

export BUILD=$tree
mkdir -p "$scratch/home"
check "make install installs" bash -c 'PREFIX="$0" scripts/install.sh >"$1"' "$scratch/home" "$scratch/said"
check "the tool is there" "$scratch/home/bin/norma" --version
check "it says how programs find the library" grep -qE "export PKG_CONFIG_PATH=$scratch/home/.*pkgconfig LD_LIBRARY_PATH=$scratch/home/lib" "$scratch/said"
check "it says how the shell finds the tool" grep -qF "export PATH=$scratch/home/bin:" "$scratch/said"
check "what it says is enough for a program" bash -c 'eval "$(grep -E "^ *export" "$0")"; gcc -std=c11 tests/repo/consumer/core.c -o "$1/program" $(pkg-config --cflags --libs norma) && "$1/program"' "$scratch/said" "$scratch"
finish
