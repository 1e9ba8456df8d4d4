#!/bin/bash
# The whole test suite: builds the trees, runs every cmocka program and every script, counts each case that they report (TAP), and closes with one line,
# "N passed, N failed, N skipped". Exits non-zero when anything failed.
#   tests/run.sh              everything
#   tests/run.sh gcc asan     some of: gcc (warnings as errors, all unit tests), scripts, asan, tsan, fuzz
# shellcheck disable=SC2016  # single quotes hold what inner shells expand
set -u
cd "$(dirname "$0")/.." || exit 1
root=$PWD
out=$root/build/test
results=$out/results
jobs=${JOBS:-$(nproc)}
sections=${*:-gcc scripts asan tsan fuzz}
case " $sections " in *" scripts "*) case " $sections " in *" gcc "*) ;; *) sections="gcc $sections" ;; esac ;; esac

export NORMA_DATA=${NORMA_DATA:-$root/../shared/data}
export NODE_PATH=$root/build/npm/node_modules
export ASAN_OPTIONS=${ASAN_OPTIONS:-detect_leaks=1:detect_stack_use_after_return=1}
export UBSAN_OPTIONS=${UBSAN_OPTIONS:-print_stacktrace=1}
export TSAN_OPTIONS=${TSAN_OPTIONS:-halt_on_error=1}
export CMOCKA_MESSAGE_OUTPUT=TAP
export LC_ALL=C.UTF-8

rm -rf "$results"
mkdir -p "$results"

say() { printf '%s  %s\n' "$(date +%H:%M:%S)" "$*"; }

# one RESULT-NAME COMMAND...: runs a program that speaks TAP; its output and exit status go to files. The limit is for what hangs: the longest test takes some two minutes, and
# a machine may be loaded many times over.
one() {
    local name=$1 status=0
    shift
    local scratch
    scratch=$(mktemp -d)
    local start=$SECONDS
    NORMA_SCRATCH=$scratch timeout --kill-after=10 "${TEST_TIMEOUT:-7200}" "$@" >"$results/$name.tap" 2>"$results/$name.err" </dev/null || status=$?
    rm -rf "$scratch"
    echo "$status" >"$results/$name.status"
    echo $((SECONDS - start)) >"$results/$name.seconds"
}
export -f one
export results

# left_out NAME REASON: a section that cannot be run here counts as skipped.
left_out() {
    say "$1: skipped, $2"
    printf '1..1\nok 1 # SKIP %s\n' "$2" >"$results/$1.tap"
    echo 0 >"$results/$1.status"
}

# build TREE FLAGS...: a configured and compiled tree. A failure counts as a failed case.
build() {
    local tree=$1
    shift
    mkdir -p "$out/$tree"
    if cmake -S . -B "$out/$tree" -G Ninja "$@" >"$out/$tree/build.log" 2>&1 && cmake --build "$out/$tree" -j "$jobs" -- -k 0 >>"$out/$tree/build.log" 2>&1; then
        printf '1..1\nok 1 - builds without a warning\n' >"$results/$tree.build.tap"
        echo 0 >"$results/$tree.build.status"
    else
        { echo 1..1; echo "not ok 1 - builds without a warning"; grep -E 'error|warning|FAILED|undefined' "$out/$tree/build.log" | head -40 | sed 's/^/# /'; } >"$results/$tree.build.tap"
        echo 1 >"$results/$tree.build.status"
        return 1
    fi
}

# units TREE [PATTERN...]: the unit tests of a tree, several at a time.
units() {
    local tree=$1
    shift
    export NORMA_TREE=$out/$tree
    export NORMA_BIN=$out/$tree/bin/norma
    one "$tree.units" "$NORMA_TREE/tests/norma_tests" -j "$jobs" "$@"
    [ $# -gt 0 ] || one "$tree.wrapped" "$NORMA_TREE/tests/norma_tests_wrapped" -j "$jobs"
}

run_gcc() {
    say "gcc: building with warnings as errors"
    build gcc -DCMAKE_C_COMPILER=gcc -DNORMA_WERROR=ON -DNORMA_TESTS=ON -DNORMA_WEB=AUTO -DCMAKE_BUILD_TYPE=Release -DCMAKE_C_FLAGS_RELEASE=-O2
    say "gcc: unit tests"
    units gcc
}

# Scripts see the gcc tree.
run_scripts() {
    say "scripts: the command line, arrows between layers, headers, README, examples, install, single file, manual"
    export NORMA_TREE=$out/gcc
    export NORMA_BIN=$out/gcc/bin/norma
    find tests/cli tests/mpi tests/python tests/repo tests/tangent tests/web -maxdepth 1 -name '*.sh' ! -name threads.sh | sort |
        xargs -P "$jobs" -I{} bash -c 'name=${0#tests/}; name=${name%.sh}; one "${name/\//.}" "$0"' {}
}

run_asan() {
    command -v clang >/dev/null || { left_out asan "clang is not installed"; return; }
    say "asan: building with clang, address and undefined-behaviour sanitizers"
    build asan -DCMAKE_C_COMPILER=clang -DNORMA_WERROR=ON -DNORMA_TESTS=ON -DNORMA_WEB=OFF -DNORMA_SANITIZE=address,undefined -DCMAKE_BUILD_TYPE=Release -DCMAKE_C_FLAGS_RELEASE="-O1 -g1" -DNORMA_SHARED=OFF
    say "asan: unit tests"
    units asan
    one asan.golden tests/cli/golden.sh
    NORMA_BITS_WAYS=one one asan.bits tests/repo/portable.sh
}

run_tsan() {
    command -v clang >/dev/null || { left_out tsan "clang is not installed"; return; }
    say "tsan: building with clang, thread sanitizer"
    build tsan -DCMAKE_C_COMPILER=clang -DNORMA_WERROR=ON -DNORMA_TESTS=ON -DNORMA_WEB=OFF -DNORMA_SANITIZE=thread -DCMAKE_BUILD_TYPE=Release -DCMAKE_C_FLAGS_RELEASE="-O1 -g1" -DNORMA_SHARED=OFF
    say "tsan: the tests that use threads"
    units tsan '*thread*'
    one tsan.programs tests/cli/threads.sh
}

# The seeds of the fuzz targets, what they ever found, and a fixed number of runs from a fixed seed; `make fuzz` is for the rest.
run_fuzz() {
    if ! echo 'int LLVMFuzzerTestOneInput(const unsigned char *b, unsigned long n); int LLVMFuzzerTestOneInput(const unsigned char *b, unsigned long n) { return !b && n; }' |
        clang -x c -fsanitize=fuzzer - -o "$out/has-fuzzer" 2>/dev/null; then
        left_out fuzz "clang with libFuzzer is not installed"
        return
    fi
    say "fuzz: building the targets with clang, libFuzzer and the sanitizers"
    if scripts/fuzz.sh build "$out/fuzz" >"$results/fuzz.build.err" 2>&1; then
        printf '1..1\nok 1 - builds without a warning\n' >"$results/fuzz.build.tap"
        echo 0 >"$results/fuzz.build.status"
    else
        printf '1..1\nnot ok 1 - builds without a warning\n' >"$results/fuzz.build.tap"
        echo 1 >"$results/fuzz.build.status"
        return
    fi
    say "fuzz: seeds, what was found, and runs from a fixed seed"
    export NORMA_TREE=$out/fuzz
    find tests/fuzz -name 'fuzz_*.c' -exec grep -l '^int LLVMFuzzerTestOneInput' {} + | sed 's|.*/fuzz_||; s|\.c$||' | sort |
        xargs -P "$jobs" -I{} bash -c 'one "fuzz.$0" tests/fuzz/replay.sh "$0"' {}
}

for section in $sections; do
    "run_$section"
done

# Counting: of each program its "ok", "not ok" and "# SKIP" lines. One that promised more cases than it reported, or that ended badly without saying
# which case failed (a crash, a sanitizer's report, a time-out), has one more failure.
passed=0 failed=0 skipped=0
for tap in "$results"/*.tap; do
    name=$(basename "$tap" .tap)
    status=$(cat "$results/$name.status" 2>/dev/null || echo "no status")
    read -r p f s planned < <(awk '
        /^1\.\.[0-9]+/ { planned += substr($1, 4); next }
        /^(not )?ok [0-9]*.*# *SKIP/ { s++; next }
        /^not ok [0-9]/ { f++; next }
        /^ok [0-9]/ { p++ }
        END { print p + 0, f + 0, s + 0, planned + 0 }' "$tap")
    trouble=""
    if [ $((p + f + s)) -lt "$planned" ] || [ $((p + f + s)) -eq 0 ]; then
        trouble="reported $((p + f + s)) of $planned cases, exit status $status"
    elif [ "$status" != 0 ] && [ "$f" -eq 0 ]; then
        trouble="exit status $status"
    fi
    [ -z "$trouble" ] || f=$((f + 1))
    passed=$((passed + p)) failed=$((failed + f)) skipped=$((skipped + s))
    [ "$s" -eq 0 ] || sed -nE "s/^(not )?ok [0-9]*.*# *SKIP *(.*)/    $name: \\2/p" "$tap" >>"$results/skipped"
    printf '%-44s %5d passed %4d failed %4d skipped %5s s\n' "$name" "$p" "$f" "$s" "$(cat "$results/$name.seconds" 2>/dev/null)"
    if [ "$f" -gt 0 ]; then
        awk '/^not ok [0-9]/ && !/# *SKIP/ { print "    " $0; show = 1; next } /^#/ { if (show) print "      " $0; next } { show = 0 }' "$tap" | head -n 60
        if [ -n "$trouble" ]; then
            echo "    $name: $trouble"
            tail -n 25 "$results/$name.err" 2>/dev/null | sed 's/^/      /'
        fi
        echo "    output: build/test/results/$name.tap, $name.err"
    fi
done
if [ -s "$results/skipped" ]; then
    echo "Skipped:"
    sort "$results/skipped"
fi
say "done, after $SECONDS s"
echo "$passed passed, $failed failed, $skipped skipped"
[ "$failed" -eq 0 ] && [ "$passed" -gt 0 ]
