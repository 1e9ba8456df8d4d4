#!/bin/bash
# Which lines and branches of src/core and src/io the tests run (the fuzzers aside), counted by gcov. Fails below 97.5 % of the lines or 89.9 % of the branches.
#   scripts/coverage.sh                 builds build/coverage, runs every test in it that can count, reports
#   scripts/coverage.sh report ...      reports what was counted so far; --lines and --branches name what did not run
#   scripts/coverage.sh more NAME...    runs these tests (test_obj, golden.sh, ...) as well and reports
# The build is gcc's at -O0 with NDEBUG, core and io counted, and the rest optimised. The kernels are functions there rather than copies for each instruction set, so
# that a branch counts once (random tests repeat an eighth as often as in make test); the function that chooses the instructions for each is a line of its own. All sets that the processor has are run by the tests themselves.
set -u
cd "$(dirname "$0")/.." || exit 1
root=$PWD
tree=${NORMA_COVERAGE_TREE:-$root/build/coverage}
jobs=${JOBS:-$(nproc)}
export NORMA_DATA=${NORMA_DATA:-$root/../shared/data}
export NODE_PATH=$root/build/npm/node_modules NORMA_TREE=$tree NORMA_BIN=$tree/bin/norma LC_ALL=C.UTF-8
export root tree

build() {
    mkdir -p "$tree"
    cmake -S . -B "$tree" -G Ninja -DCMAKE_C_COMPILER=gcc -DNORMA_COVERAGE=ON -DNORMA_TESTS=ON -DNORMA_WEB=OFF -DNORMA_SHARED=OFF -DNORMA_EXAMPLES=OFF \
        -DCMAKE_BUILD_TYPE=Release -DCMAKE_C_FLAGS_RELEASE="-O1 -DNDEBUG" >"$tree/build.log" 2>&1 &&
        cmake --build "$tree" -j "$jobs" >>"$tree/build.log" 2>&1 || { tail -n 20 "$tree/build.log"; exit 1; }
}

# one NAME: a unit test or a script, its answer in a file. That a test passes is for make test to say; here a failure is told and counts on.
one() {
    local command=$tree/tests/$1 scratch status=0
    [[ $1 != *.sh ]] || command=$root/tests/$1
    scratch=$(mktemp -d)
    NORMA_SCRATCH=$scratch timeout --kill-after=10 1800 "$command" >"$tree/results/${1//\//.}" 2>&1 </dev/null || status=$?
    rm -rf "$scratch"
    [ "$status" -eq 0 ] || echo "$1: exit status $status, see $tree/results/${1//\//.}"
}
export -f one

# The scripts that run the tool, but for those of the browser, of what is built, of how long things take, and those that kill processes, since one that is killed while it
# writes its counts leaves the file of them broken.
tests() {
    (cd "$tree" && ctest -N -L unit) | sed -n 's/^ *Test *#[0-9]*: //p'
    grep -l NORMA_BIN tests/cli/*.sh tests/repo/*.sh | sed 's,^tests/,,' | grep -vE 'hygiene|portable|interrupt|faults'
}

run() {
    mkdir -p "$tree/results"
    grep -v fuzz | xargs -P "$jobs" -I{} bash -c 'one "$1"' - {}
}

case ${1:-all} in
all)
    scripts/install-deps.sh || true
    build
    find "$tree" -name '*.gcda' -delete
    tests | run
    ;;
more)
    build
    printf '%s\n' "${@:2}" | run
    set --
    ;;
report) ;;
*)
    echo "usage: scripts/coverage.sh [report | more NAME...]" >&2
    exit 2
    ;;
esac
node scripts/coverage.mjs "$tree" "${@:2}"
