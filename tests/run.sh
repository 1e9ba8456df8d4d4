#!/bin/bash
# The test suite: builds the trees (scripts/tree.sh), runs unit tests and scripts, counts each case that they report (TAP), and closes with one line,
# "N passed, N failed, N skipped". Exits non-zero when anything failed.
#   tests/run.sh          what each change must pass (make test)
#   tests/run.sh all      the rest as well (make test-all). What tests/run.sh found of the same sources is counted, not run again
#   tests/run.sh PART...  some parts, by name: `tests/run.sh list` prints them
# Seconds are those of the processor. JOBS: how many at once.  TEST_TIMEOUT: seconds that a script may take (1800: what hangs fails, the rest runs).
# shellcheck disable=SC2016  # single quotes hold what inner shells expand
set -u
cd "$(dirname "$0")/.." || exit 1
root=$PWD
out=$root/build/test
jobs=${JOBS:-$(nproc)}

export NORMA_DATA=${NORMA_DATA:-$root/../shared/data}
export NODE_PATH=$root/build/npm/node_modules
export ASAN_OPTIONS=${ASAN_OPTIONS:-detect_leaks=1:detect_stack_use_after_return=1}
export UBSAN_OPTIONS=${UBSAN_OPTIONS:-print_stacktrace=1}
export TSAN_OPTIONS=${TSAN_OPTIONS:-halt_on_error=1}
export CMOCKA_MESSAGE_OUTPUT=TAP
export LC_ALL=C.UTF-8
# Scripts build the sources again (a user's tree, the tool with mistakes): what they compile as the first tree did is taken from there.
if command -v ccache >/dev/null; then
    export CMAKE_C_COMPILER_LAUNCHER=ccache CMAKE_CXX_COMPILER_LAUNCHER=ccache CCACHE_DIR=$out/ccache
fi

# ---- what is run

quick_parts="gcc scripts clang fuzz tsan"
other_parts="gcc-long web long clang-long fuzz-long tsan-long"
# Scripts of `make test`; all others are of `make test-all`. Long ones first: nothing then waits for a last one.
quick_scripts="repo/format cli/golden repo/hygiene repo/arrows repo/readme repo/headers repo/guide cli/gltf-shared
    repo/trust repo/names repo/checklist repo/manual repo/packaging repo/examples repo/sbom"
# Those that need the page, and a tree that has it; names are written into pages, too.
web_scripts="web/page web/package web/marks web/silhouettes cli/hostile-names"
longest_scripts="cli/faults-memory python/wheel repo/install repo/single cli/acid-render cli/faults repo/shaders repo/portable repo/plain cli/progress cli/large
    cli/together cli/hostile"
long_scripts() {
    printf '%s\n' $longest_scripts
    find tests/cli tests/mpi tests/python tests/repo tests/tangent tests/web -maxdepth 1 -name '*.sh' | sed 's|^tests/||; s|\.sh$||' | sort |
        grep -vxFf <(printf '%s\n' $quick_scripts $web_scripts $longest_scripts cli/threads cli/sweep)
}

say() { printf '%s  %s\n' "$(date +%H:%M:%S)" "$*"; }

# one RESULT-NAME COMMAND...: runs a program that speaks TAP; its output, exit status and processor seconds go to files. The limit is for what hangs: the slowest takes
# eight minutes, but a machine may be loaded many times over.
one() {
    local name=$1 status=0 scratch
    shift
    scratch=$(mktemp -d)
    {
        TIMEFORMAT='%U %S'
        time NORMA_SCRATCH=$scratch timeout --kill-after=10 "${TEST_TIMEOUT:-1800}" "$@" >"$results/$name.tap" 2>"$results/$name.err" </dev/null || status=$?
    } 2>"$results/$name.time"
    rm -rf "$scratch"
    echo "$status" >"$results/$name.status"
}
# run_script NAME: one of tests/, by its name from there without the ending.
run_script() { one "${1/\//.}" "tests/$1.sh"; }
export -f one run_script
# each COMMAND: for each line of its input, which is the command's $0, several at a time.
each() { xargs -P "$jobs" -I{} bash -c "$1" {}; }

# left_out NAME REASON: a part that cannot be run here counts as skipped.
left_out() {
    say "$1: skipped, $2"
    printf '1..1\nok 1 # SKIP %s\n' "$2" >"$results/$1.tap"
    echo 0 >"$results/$1.status"
}

# build TREE [TARGET...]: a failure counts as a failed case.
built=""
build() {
    built="$built $1"
    local said result=$results/$1${2:+.$2}.build before=$SECONDS
    if said=$(scripts/tree.sh "$@"); then
        printf '1..1\nok 1 - builds without a warning\n' >"$result.tap"
        echo 0 >"$result.status"
        say "$1: built in $((SECONDS - before)) s"
    else
        { echo 1..1; echo "not ok 1 - builds without a warning"; sed 's/^/# /' <<<"$said"; } >"$result.tap"
        echo 1 >"$result.status"
        say "$1: DOES NOT BUILD"
        return 1
    fi
}

# needs TREE [TARGET...]: builds it where no part before did.
needs() { case " $built " in *" $1 "*) ;; *) build "$@" ;; esac; }
in_tree() { export NORMA_TREE=$out/$1 NORMA_BIN=$out/$1/bin/norma; }

# ---- parts

part_gcc() {
    say "gcc: building with warnings as errors"
    build gcc
    in_tree gcc
    say "gcc: quick unit tests"
    one gcc.wrapped "$NORMA_TREE/tests/norma_tests_wrapped" -j "$jobs" --quick
    one gcc.units "$NORMA_TREE/tests/norma_tests" -j "$jobs" --quick
}

part_gcc_long() {
    needs gcc
    in_tree gcc
    say "gcc: long unit tests"
    one gcc.wrapped-long "$NORMA_TREE/tests/norma_tests_wrapped" -j "$jobs" --long
    one gcc.units-long "$NORMA_TREE/tests/norma_tests" -j "$jobs" --long
}

long_units() { for program in norma_tests norma_tests_wrapped; do "$out/$1/tests/$program" --long --list; done 2>/dev/null | tr '\n' ' '; }

part_scripts() {
    needs gcc
    in_tree gcc
    say "scripts: command line, README, guide, headers, arrows, format, manual"
    printf '%s\n' $quick_scripts | each 'run_script "$0"'
}

# has_clang PART: without it, the part is left out.
has_clang() { command -v clang >/dev/null || { left_out "$1" "clang is not installed"; return 1; }; }

part_clang() {
    has_clang clang || return
    say "clang: building with address and undefined-behaviour sanitizers, for fuzzing too"
    build clang norma_tests norma_tests_wrapped fuzzers
    in_tree clang
    say "clang: quick unit tests"
    one clang.wrapped "$NORMA_TREE/tests/norma_tests_wrapped" -j "$jobs" --quick
    one clang.units "$NORMA_TREE/tests/norma_tests" -j "$jobs" --quick
}

fuzz_targets() { find tests/fuzz -name 'fuzz_*.c' -exec grep -l '^int LLVMFuzzerTestOneInput' {} + | sed 's|.*/fuzz_||; s|\.c$||' | sort; }
has_fuzzers() {
    has_clang "$1" || return
    needs clang fuzzers
    [ -d "$out/clang/fuzz" ] || { left_out "$1" "clang with libFuzzer is not installed"; return 1; }
}

part_fuzz() {
    has_fuzzers fuzz || return
    in_tree clang
    say "fuzz: seeds and what was ever found"
    fuzz_targets | each 'one "fuzz.$0" tests/fuzz/replay.sh "$0"'
}

part_tsan() {
    has_clang tsan || return
    say "tsan: building what runs in it with the thread sanitizer"
    build tsan norma_tests
    in_tree tsan
    say "tsan: quick unit tests that use threads, and one case of the long ones"
    one tsan.units "$NORMA_TREE/tests/norma_tests" -j "$jobs" --quick
    one tsan.units-defaults "$NORMA_TREE/tests/norma_tests" threads:defaults
}

part_web() {
    say "web: building the page and the npm package into the gcc tree"
    build web
    in_tree gcc
    say "web: the page in a browser, the package, pictures beside three.js"
    printf '%s\n' $web_scripts | each 'run_script "$0"'
}

part_long() {
    needs web
    in_tree gcc
    say "long: faults, data set, judges, MPI, Python, install, plain, single, bits"
    long_scripts | jobs=$((jobs + 1)) each 'run_script "$0"' # they wait for browsers, disks and sleeping programs a third of the time
}

part_clang_long() {
    has_clang clang-long || return
    build clang norma-cli norma_bits
    in_tree clang
    say "clang: long unit tests, golden cases, bits"
    one clang.units-long "$NORMA_TREE/tests/norma_tests" -j "$jobs" --long
    one clang.wrapped-long "$NORMA_TREE/tests/norma_tests_wrapped" -j "$jobs" --long
    printf '%s\n' "clang.golden tests/cli/golden.sh" "clang.bits env NORMA_BITS_WAYS=one tests/repo/portable.sh" | each 'one $0'
    say "clang: every file of the data set through every verb"
    one clang.sweep tests/cli/sweep.sh
}

part_fuzz_long() {
    has_fuzzers fuzz-long || return
    in_tree clang
    say "fuzz: runs from a fixed seed"
    fuzz_targets | each 'one "fuzz-long.$0" tests/fuzz/replay.sh "$0" runs'
}

part_tsan_long() {
    has_clang tsan-long || return
    build tsan norma_tests norma-cli engine_jobs
    in_tree tsan
    say "tsan: long unit tests, whole programs"
    one tsan.units-long "$NORMA_TREE/tests/norma_tests" -j "$jobs" --long
    one tsan.programs tests/cli/threads.sh
}

# ---- counting

# tally RESULT: reads its files into p, f, s (passed, failed, skipped) and trouble. A program that promised more cases than it reported, or that ended badly without saying which
# case failed (a crash, a sanitizer's report, a time-out), has one more failure.
tally() {
    local status planned
    status=$(cat "$1.status" 2>/dev/null || echo "no status")
    read -r p f s planned < <(awk '
        /^1\.\.[0-9]+/ { planned += substr($1, 4); next }
        /^(not )?ok [0-9]*.*# *SKIP/ { s++; next }
        /^not ok [0-9]/ { f++; next }
        /^ok [0-9]/ { p++ }
        END { print p + 0, f + 0, s + 0, planned + 0 }' "$1.tap")
    trouble=""
    if [ $((p + f + s)) -lt "$planned" ] || [ $((p + f + s)) -eq 0 ]; then
        trouble="reported $((p + f + s)) of $planned cases, exit status $status"
    elif [ "$status" != 0 ] && [ "$f" -eq 0 ]; then
        trouble="exit status $status"
    fi
    [ -z "$trouble" ] || f=$((f + 1))
}

# seconds RESULT...: "SECONDS NAME" of each script and each file of unit tests.
seconds() {
    local result name
    for result; do
        name=$(basename "$result" .tap)
        case $name in
        *.units* | *.wrapped*) sed -nE "s/^# seconds ([^ ]+) ([0-9.]+)\$/\\2 ${name%%.*}: \\1/p" "$result" ;;
        *) [ ! -e "${result%.tap}.time" ] || awk -v name="$name" 'END { printf "%.1f %s\n", $1 + $2, name }' "${result%.tap}.time" ;;
        esac
    done
}

# tell RESULT: a line for it, and what failed.
tell() {
    local name
    name=$(basename "$1")
    printf '%-34s %5d passed %4d failed %4d skipped %7s s\n' "$name" "$p" "$f" "$s" "$(awk 'END { if (NF) printf "%.1f", $1 + $2 }' "$1.time" 2>/dev/null)"
    [ "$f" -gt 0 ] || return 0
    awk '/^not ok [0-9]/ && !/# *SKIP/ { print "    " $0; show = 1; next } /^#/ { if (show) print "      " $0; next } { show = 0 }' "$1.tap" | head -n 60
    if [ -n "$trouble" ]; then
        echo "    $name: $trouble"
        tail -n 25 "$1.err" 2>/dev/null | sed 's/^/      /'
    fi
    echo "    output: ${1#"$root"/}.tap, $name.err"
}

# The sources, as one number: what was tested of them need not be tested again. (Bytes that Python leaves are none.)
fingerprint() { find . \( -path ./build -o -path ./.git -o -name __pycache__ \) -prune -o -type f -print0 | sort -z | xargs -0 sha256sum | sha256sum | cut -c1-32; }

# ---- all of it

what=${*:-test}
folders="$out/results/test"
case $what in
list) printf '%s\n' $quick_parts $other_parts; exit ;;
test) parts=$quick_parts ;;
all)
    folders="$out/results/test $out/results/all"
    parts=$other_parts
    if [ "$(cat "$out/results/test/sources" 2>/dev/null)" = "$(fingerprint)" ]; then
        say "make test has been run on these sources: its results are counted, not made again"
    else
        parts="$quick_parts $other_parts"
    fi
    ;;
*) parts=$what folders="$out/results/part" ;;
esac

emptied=""
for part in $parts; do
    results=$out/results/part
    if [ "$what" = test ] || [ "$what" = all ]; then
        case " $quick_parts " in *" $part "*) results=$out/results/test ;; *) results=$out/results/all ;; esac
    fi
    case " $emptied " in *" $results "*) ;; *) rm -rf "$results"; mkdir -p "$results"; emptied="$emptied $results" ;; esac
    export results
    "part_${part//-/_}"
    [ "$results" != "$out/results/test" ] || [ "$part" != "${quick_parts##* }" ] || fingerprint >"$results/sources"
done

passed=0 failed=0 skipped=0
: >"$out/results/skipped"
# shellcheck disable=SC2086  # a list of folders
results=$(find $folders -name '*.tap' | sort)
for tap in $results; do
    tally "${tap%.tap}"
    tell "${tap%.tap}"
    passed=$((passed + p)) failed=$((failed + f)) skipped=$((skipped + s))
    [ "$s" -eq 0 ] || sed -nE "s/^(not )?ok [0-9]*.*# *SKIP *(.*)/    $(basename "$tap" .tap): \\2/p" "$tap" >>"$out/results/skipped"
done
if [ -s "$out/results/skipped" ]; then
    echo "Skipped:"
    sort "$out/results/skipped"
fi
echo "The slowest, in seconds of the processor:"
# shellcheck disable=SC2086  # a list of files
seconds $results | sort -rn | head -n 8 | sed -E 's/^([^ ]+) /    \1  /'
if [ "$what" = test ]; then
    echo "Not run here, but by make test-all: the page, the npm package, Python, MPI; $({ printf '%s\n' $web_scripts; long_scripts; } | tr '\n' ' ')"
    echo "    long unit tests: $(long_units gcc)"
    echo "    with sanitizers: $(long_units clang); golden cases, bits, each file of the data set through each verb, $(fuzz_targets | wc -l) fuzz targets for some seconds each, the tool with threads"
fi
times >"$out/times"
say "done, after $SECONDS s, with $(awk -F"[ms ]+" 'END { printf "%.0f", 60 * ($1 + $3) + $2 + $4 }' "$out/times") s of the processor"
echo "$passed passed, $failed failed, $skipped skipped"
[ "$failed" -eq 0 ] && [ "$passed" -gt 0 ]
