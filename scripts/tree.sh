#!/bin/bash
# The build trees that tests run in, below build/test: configures one and builds it, or some of its targets. Says what went wrong, and exits non-zero then.
#   scripts/tree.sh gcc [TARGET...]     everything but the page, warnings are errors
#   scripts/tree.sh web [TARGET...]     the same tree, and the page and the npm package
#   scripts/tree.sh clang [TARGET...]   address and undefined-behaviour sanitizers, and coverage for fuzzing: unit tests, fuzz targets, the tool
#   scripts/tree.sh fuzz [TARGET...]    the same, and each comparison is told to the fuzzer: for long runs (twice as slow)
#   scripts/tree.sh tsan [TARGET...]    the thread sanitizer: unit tests with threads, the tool
# JOBS: how many compilers at once.  TREES: another folder than build/test.
set -u
cd "$(dirname "$0")/.." || exit 1
name=${1:?scripts/tree.sh NAME [TARGET...]}
shift
folder=${TREES:-build/test}/${name/web/gcc}
common="-DNORMA_WERROR=ON -DNORMA_TESTS=ON"
sanitizer="-DCMAKE_C_COMPILER=clang -DNORMA_WEB=OFF -DNORMA_SHARED=OFF -DCMAKE_BUILD_TYPE=Sanitize"
untold=""
case $name in
gcc) flags="-DCMAKE_C_COMPILER=gcc -DNORMA_WEB=OFF -DCMAKE_BUILD_TYPE=Release -DCMAKE_C_FLAGS_RELEASE=-O2" ;;
web) flags="-DCMAKE_C_COMPILER=gcc -DNORMA_WEB=AUTO -DCMAKE_BUILD_TYPE=Release -DCMAKE_C_FLAGS_RELEASE=-O2" ;;
clang | fuzz) flags="$sanitizer -DNORMA_SANITIZE=address,undefined,float-cast-overflow,fuzzer-no-link -DNORMA_FUZZ=AUTO -DNORMA_EXAMPLES=OFF" ;;
tsan) flags="$sanitizer -DNORMA_SANITIZE=thread -DNORMA_TESTS_ONLY=thread" ;;
*) echo "$0: no tree is called $name" >&2; exit 2 ;;
esac
[ "$name" != clang ] || untold=" -fno-sanitize-coverage=trace-cmp"
targets=()
[ $# -eq 0 ] || targets=(--target "$@")
mkdir -p "$folder"
log=$folder/build.log
# shellcheck disable=SC2086  # lists of flags
if cmake -S . -B "$folder" -G Ninja $common $flags "-DCMAKE_C_FLAGS_SANITIZE=-O1 -g1$untold" "-DCMAKE_CXX_FLAGS_SANITIZE=-O1 -g1$untold" >"$log" 2>&1 &&
    cmake --build "$folder" -j "${JOBS:-$(nproc)}" "${targets[@]}" -- -k 0 >>"$log" 2>&1; then
    exit 0
fi
grep -aE 'error|warning|FAILED|undefined|Error' "$log" | head -40
exit 1
