#!/bin/bash
# The same bits on other machines: builds the library and tests/bits with each compiler and level of optimisation natively, as WebAssembly (node's WASI), for 64-bit ARM
# (qemu-user) and for Windows (Wine, where it starts), and compares their hashes with those in tests/bits; and natively with AVX-512 in plain C, for machines that have none.
# What it needs: scripts/install-deps.sh portable.
#   scripts/portable.sh [native|avx512|wasm|arm|windows]...       all of them
# One line for each; exit status 1 where a build fails or a hash differs.
set -u
root=$(cd "$(dirname "$0")/.." && pwd)
cd "$root" || exit 1
out=${PORTABLE_BUILD:-$root/build/portable}
jobs=${JOBS:-$(nproc)}
data=${NORMA_DATA:-$root/../shared/data}
what=${*:-native avx512 wasm arm windows}
mkdir -p "$out"
failed=0 passed=0 skipped=0
good() { passed=$((passed + 1)); printf 'ok   %s\n' "$*"; }
bad() { failed=$((failed + 1)); printf 'FAIL %s\n' "$*"; }
left() { skipped=$((skipped + 1)); printf 'skip %s\n' "$*"; }

tests/bits/files.sh assets tests/cli/golden/files >"$out/assets.list"
[ ! -d "$data" ] || (cd "$data" && "$root/tests/bits/files.sh" -- * >"$out/data.list")

# hashes NAME WAYS OUT RUNNER...: the three lists, by RUNNER FOLDER ARGUMENT..., which runs the driver in that folder.
hashes() {
    local name=$1 ways=$2 place=$3 status=0 count
    shift 3
    { "$@" "$root" --ways "$ways" --made && "$@" "$root" --ways "$ways" --files "$out/assets.list"; } >"$place/got" 2>"$place/said" || status=$?
    cat tests/bits/expected-made.txt tests/bits/expected-assets.txt >"$place/expected"
    if [ "$status" = 0 ] && [ -d "$data" ]; then
        "$@" "$data" --ways one --files "$out/data.list" >>"$place/got" 2>>"$place/said" || status=$?
        cat tests/bits/expected-data.txt >>"$place/expected"
    fi
    tr -d '\r' <"$place/got" >"$place/lines"
    count=$(wc -l <"$place/expected")
    if [ "$status" = 0 ] && diff "$place/expected" "$place/lines" >"$place/difference"; then
        good "$name: all $count hashes, $ways ways"
    else
        bad "$name: $(grep -c '^>' "$place/difference") of $count hashes differ, exit status $status: $place/difference"
    fi
}

bits=""
here() { local folder=$1; shift; (cd "$folder" && "$bits" "$@"); }

native() { # COMPILER FLAGS WAYS [NAME]
    local name=${4:-$1 $2} place
    place=$out/$(tr -c 'a-zA-Z0-9\n' _ <<<"$name")
    mkdir -p "$place"
    command -v "$1" >/dev/null || { left "$name: no compiler"; return; }
    if cmake -S . -B "$place" -G Ninja -DCMAKE_C_COMPILER="$1" -DCMAKE_BUILD_TYPE=None -DCMAKE_C_FLAGS="$2" -DNORMA_WITH_DRACO=OFF -DNORMA_TOOL=OFF -DNORMA_TESTS=OFF -DNORMA_EXAMPLES=OFF -DNORMA_SHARED=OFF \
        -DNORMA_BITS=ON >"$place/build.log" 2>&1 && cmake --build "$place" -j "$jobs" --target norma_bits >>"$place/build.log" 2>&1; then
        bits=$place/tests/norma_bits hashes "$name" "$3" "$place" here
    else
        bad "$name: does not build: $place/build.log"
    fi
}

# meshoptimizer's decoder for machines that Debian has no package for: from Debian's source.
source_of_meshoptimizer() {
    [ -d "$out/meshoptimizer" ] && return 0
    local lists=$out/apt option
    mkdir -p "$lists/partial" "$out/source.d"
    printf 'Types: deb-src\nURIs: http://deb.debian.org/debian\nSuites: bookworm bookworm-updates\nComponents: main\nSigned-By: /usr/share/keyrings/debian-archive-keyring.gpg\n' >"$out/source.d/src.sources"
    option="-o Dir::Etc::sourcelist=/dev/null -o Dir::Etc::sourceparts=$out/source.d -o Dir::State::lists=$lists -o APT::Get::List-Cleanup=0"
    # shellcheck disable=SC2086  # a list of options
    (cd "$out" && apt-get $option -qq update && apt-get $option -qq source --download-only meshoptimizer && dpkg-source -x meshoptimizer_*.dsc "$out/meshoptimizer") >"$out/source.log" 2>&1
}

decoder() { # PLACE CXX AR FLAGS...: libmeshoptimizer.a and its header in PLACE
    local place=$1 cxx=$2 ar=$3 file
    shift 3
    source_of_meshoptimizer || return 1
    cp "$out/meshoptimizer/src/meshoptimizer.h" "$place"
    for file in indexcodec vertexcodec vertexfilter allocator; do
        "$cxx" -O2 "$@" -c "$out/meshoptimizer/src/$file.cpp" -o "$place/$file.o" || return 1
    done
    "$ar" rcs "$place/libmeshoptimizer.a" "$place"/{indexcodec,vertexcodec,vertexfilter,allocator}.o
}

cross() { # NAME SYSTEM PROCESSOR PREFIX SUFFIX FLAGS LINK
    local place=$out/$1
    mkdir -p "$place"
    decoder "$place" "$4g++$5" "$4ar" >"$place/build.log" 2>&1 || { bad "$1: no decoder: $place/build.log, $out/source.log"; return 1; }
    cmake -S . -B "$place" -G Ninja -DCMAKE_SYSTEM_NAME="$2" -DCMAKE_SYSTEM_PROCESSOR="$3" -DCMAKE_C_COMPILER="$4gcc$5" -DCMAKE_BUILD_TYPE=Release -DCMAKE_C_FLAGS="$6" \
        -DCMAKE_EXE_LINKER_FLAGS="$7" -DNORMA_MESHOPTIMIZER="$place/libmeshoptimizer.a" -DNORMA_MESHOPTIMIZER_INCLUDE="$place" -DNORMA_WITH_DRACO=OFF -DNORMA_TOOL=OFF -DNORMA_TESTS=OFF -DNORMA_EXAMPLES=OFF \
        -DNORMA_SHARED=OFF -DNORMA_BITS=ON >>"$place/build.log" 2>&1 && cmake --build "$place" -j "$jobs" >>"$place/build.log" 2>&1 || { bad "$1: does not build: $place/build.log"; return 1; }
}

emulated() { local folder=$1; shift; (cd "$folder" && qemu-aarch64 "$out/arm/tests/norma_bits" "$@"); }

arm() {
    command -v aarch64-linux-gnu-gcc >/dev/null || { left "arm: no aarch64-linux-gnu-gcc"; return; }
    cross arm Linux aarch64 aarch64-linux-gnu- "" "-O2" "-static" || return
    command -v qemu-aarch64 >/dev/null || { left "arm: built, no qemu-aarch64 to run it"; return; }
    hashes "64-bit ARM, NEON (gcc, qemu-user)" "${PORTABLE_WAYS:-one}" "$out/arm" emulated
}

in_wine() { local folder=$1; shift; (cd "$folder" && WINEDEBUG=-all WINEPREFIX="$out/wine" wine "$out/windows/tests/norma_bits.exe" "$@"); }

windows() {
    command -v x86_64-w64-mingw32-gcc-posix >/dev/null || { left "windows: no x86_64-w64-mingw32-gcc-posix"; return; }
    cross windows Windows AMD64 x86_64-w64-mingw32- -posix "-O2 -D__USE_MINGW_ANSI_STDIO=1 -Wno-format -Wno-conversion -Wno-float-conversion" "-static" || return
    if command -v wine >/dev/null && timeout 120 env WINEDEBUG=-all WINEPREFIX="$out/wine" wine "$out/windows/tests/norma_bits.exe" --ways one --made >/dev/null 2>&1; then
        hashes "Windows (mingw-w64, Wine)" one "$out/windows" in_wine
    else
        left "windows: built and linked; Wine does not start here"
    fi
}

in_node() {
    local folder=$1
    shift
    NORMA_LISTS=$out node --no-warnings tests/bits/wasi/run.mjs "$out/wasm/norma_bits.wasm" "$folder" "${@/#$out\//\/lists/}"
}

wasm() {
    local place=$out/wasm flags sources
    mkdir -p "$place"
    { command -v clang && command -v wasm-ld && [ -e /usr/include/wasm32-wasi/stdlib.h ]; } >/dev/null || { left "wasm: no clang with lld and wasi-libc"; return; }
    decoder "$place" clang++ true --target=wasm32-wasi -msimd128 -fno-exceptions -fno-rtti -nostdinc++ >"$place/build.log" 2>&1 || { bad "wasm: no decoder: $place/build.log"; return; }
    flags="--target=wasm32-wasi -std=c11 -O2 -DNDEBUG -D_WASI_EMULATED_MMAN -D_WASI_EMULATED_GETPID -msimd128 -fno-slp-vectorize -mbulk-memory -ftls-model=local-exec -ffp-contract=off -fno-math-errno
        -fno-trapping-math -Iinclude -Isrc -I$place -isystem web/page/model/posix -include tests/bits/wasi/missing.h"
    sources=$(find src/core src/check src/io tests/bits -name '*.c' ! -name file_windows.c ! -name meshopt_left_out.c ! -path '*/image/image.c' \( ! -path '*/3mf/*' -o -name 3mf_left_out.c \))
    # shellcheck disable=SC2086,SC2016  # lists of words
    printf '%s\n' $sources | PLACE=$place FLAGS="$(tr '\n' ' ' <<<"$flags")" xargs -P "$jobs" -I{} sh -c 'clang $FLAGS -c {} -o "$PLACE/$(echo {} | tr / _).o"' >>"$place/build.log" 2>&1 &&
        clang --target=wasm32-wasi -Wl,-z,stack-size=8388608 -o "$place/norma_bits.wasm" "$place"/*.o -lm -lwasi-emulated-mman -lwasi-emulated-getpid >>"$place/build.log" 2>&1 ||
        { bad "wasm: does not build: $place/build.log"; return; }
    hashes "WebAssembly, SIMD128 (clang, node's WASI)" one "$place" in_node
}

for one in $what; do
    case $one in
    native)
        for compiler in gcc clang; do
            for flags in -O0 -O1 -O2 -O3 "-O3 -march=native"; do
                native "$compiler" "$flags" "$([ "$flags" = -O2 ] && echo all || echo some)"
            done
        done
        native gcc "-O2 -fno-tree-vectorize -fno-tree-slp-vectorize -DCORE_NO_SHUFFLES" some
        ;;
    avx512) native gcc "-O2 -mavx2 -D_GNU_SOURCE= -include $root/tests/bits/avx512_in_c.h" some "AVX-512 in plain C (gcc)" ;;
    wasm | arm | windows) $one ;;
    *) echo "usage: $0 [native|avx512|wasm|arm|windows]..." >&2; exit 2 ;;
    esac
done
echo "$passed passed, $failed failed, $skipped skipped"
[ "$failed" -eq 0 ]
