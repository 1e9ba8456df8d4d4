#!/bin/bash
# What `make` does: configures and builds, and ends with what is there now. On a terminal one line says how far it is; the compiler's lines go to build.log, and are shown where
# something fails, or with V=1. A folder that has been built with the page (make web) keeps it up to date.
#   BUILD  the folder (build)     CMAKE_FLAGS  further flags for cmake     V=1  shows everything
set -euo pipefail
cd "$(dirname "$0")/.."
build=${BUILD:-build}
verbose=${V:-0}
command -v cmake >/dev/null || { echo "cmake is needed (Debian: cmake)" >&2; exit 1; }
mkdir -p "$build"
generator=""
[ -e "$build/CMakeCache.txt" ] || ! command -v ninja >/dev/null || generator="-G Ninja"

# run LOG COMMAND...: quietly, unless it fails.
run() {
    log=$1
    shift
    if [ "$verbose" != 0 ]; then
        "$@"
    elif ! "$@" >"$log" 2>&1; then
        grep -E -A 6 'error|Error|FAILED|undefined' "$log" | head -n 60 || true
        echo "This failed; all of it is in $log (V=1 shows it as it happens): $*" >&2
        exit 1
    fi
}

# progress: how far the build is, from its lines "[12/345] ..." or "[ 12%] ...", in one line of the terminal.
progress() {
    if [ -t 1 ]; then
        awk '/^\[/ { sub(/\].*/, "]"); printf "\rBuilding Norma in %s: %s ", where, $0; fflush(); n = 1 } END { if (n) print "" }' where="$build"
    else
        cat >/dev/null
    fi
}

fresh="-DNORMA_WEB=OFF -DNORMA_EXAMPLES=OFF"
[ ! -e "$build/CMakeCache.txt" ] || fresh=""
# shellcheck disable=SC2086  # lists of flags
run "$build/configure.log" cmake -S . -B "$build" $generator -DCMAKE_BUILD_TYPE=Release -DNORMA_TESTS=OFF $fresh ${CMAKE_FLAGS:-}
if [ "$verbose" != 0 ]; then
    cmake --build "$build" --parallel
else
    [ -t 1 ] || echo "Building Norma in $build; this takes a minute or two the first time."
    if ! cmake --build "$build" --parallel 2>&1 | tee "$build/build.log" | progress; then
        grep -E -A 6 'error|Error|FAILED|undefined' "$build/build.log" | head -n 60 || true
        echo "This failed; all of it is in $build/build.log (V=1 shows it as it happens)" >&2
        exit 1
    fi
    grep -E '^-- .* no, ' "$build/configure.log" | grep -v 'norma view, page, npm package *no, NORMA_WEB is OFF' | sed 's/^-- */Left out: /; s/  *no, /: /' || true
fi

echo "Built:"
for file in bin/norma lib/libnorma.a lib/libnorma.so lib/libnorma-core.a web/norma.html web/npm; do
    [ ! -e "$build/$file" ] || case $file in
    bin/norma) echo "  $build/bin/norma          the tool: $build/bin/norma --help" ;;
    lib/libnorma.a) echo "  $build/lib/libnorma.a     the library, to link into a program" ;;
    lib/libnorma.so) echo "  $build/lib/libnorma.so    the same, shared" ;;
    lib/libnorma-core.a) echo "  $build/lib/libnorma-core.a    the core alone" ;;
    web/norma.html) echo "  $build/web/norma.html     the page: open it in a browser" ;;
    web/npm) echo "  $build/web/npm            the npm package" ;;
    esac
done
