#!/bin/bash
# Coverage-guided fuzzing: every target of tests/fuzz, on the cores there are, each for so many minutes of processor time (a busy or stopped machine shortens nothing).
#   scripts/fuzz.sh build                     the targets, in build/test/fuzz (clang with libFuzzer; scripts/tree.sh)
#   scripts/fuzz.sh run MINUTES [TARGET...]   runs them; prints executions, coverage and finds of each; exits non-zero where something was found
#   scripts/fuzz.sh coverage [TARGET...]      of each source file the edges that seeds and working corpora reach (of each function what the best target reaches)
#   scripts/fuzz.sh seeds MINUTES [TARGET...] makes tests/fuzz/corpus anew: runs without the data set, then keeps the fewest files that reach as much
# Working corpora stay in build/fuzz/corpus, so that the next run goes on from there; what was found is left in build/fuzz/found. Seeds: tests/fuzz/corpus, and small files of
# ../shared/data (NORMA_DATA), where that is there: they are read from where they are and end in no seed that is kept.
# JOBS: how many targets at once (as many as there are cores).  FUZZ_TREE: another folder than build/fuzz.  NORMA_DATA=none: without the data.
set -u
cd "$(dirname "$0")/.." || exit 1
root=$PWD
tree=${FUZZ_TREE:-$root/build/fuzz} # what runs leave
programs=$root/build/test/fuzz/fuzz
data=${NORMA_DATA:-$root/../shared/data}
jobs=${JOBS:-$(nproc)}
working=$tree/corpus
export ASAN_OPTIONS=${ASAN_OPTIONS:-allocator_may_return_null=1:handle_abort=2} UBSAN_OPTIONS=${UBSAN_OPTIONS:-print_stacktrace=1}

build() {
    command -v clang >/dev/null || { echo "$0: clang is needed; scripts/install-deps.sh installs it" >&2; return 1; }
    JOBS=$jobs scripts/tree.sh fuzz fuzzers
}

targets() { find "$root/tests/fuzz" -name 'fuzz_*.c' -exec grep -l '^int LLVMFuzzerTestOneInput' {} + | sed 's|.*/fuzz_||; s|\.c$||' | sort; }

dictionary() {
    case $1 in
    obj | ply | stl | 3mf) echo "-dict=tests/fuzz/dictionaries/$1.dict" ;;
    gltf | glb | tile | check | roundtrip) echo "-dict=tests/fuzz/dictionaries/gltf.dict" ;;
    esac
}

# head FORMAT KIND: the bytes that stand before a file in the inputs of check and roundtrip.
head_of() {
    local number
    case $1 in obj) number=0 ;; ply) number=1 ;; stl) number=2 ;; gltf) number=3 ;; *) number=4 ;; esac
    if [ "$2" = check ]; then printf '\2%b\20\0' "\\0$number"; else printf '%b\0\0\0\0\0\0\0' "\\0$number"; fi
}

# The small files of the data set as seeds of a target.
data_seeds() {
    local to=$tree/data/$1 kinds file name
    [ -d "$data" ] && [ ! -d "$to" ] || return 0
    case $1 in
    obj | ply | stl | gltf | glb) kinds=$1 ;;
    check | roundtrip) kinds="obj ply stl gltf glb" ;;
    *) return 0 ;;
    esac
    mkdir -p "$to"
    for kind in $kinds; do
        while IFS= read -r file; do
            name=$(echo "$file" | md5sum | cut -c1-16)
            if [ "$kind" = "$1" ]; then cp "$file" "$to/$name"; else { head_of "$kind" "$1"; cat "$file"; } >"$to/$name"; fi
        done < <(find -L "$data" -name "*.$kind" -size -24k | sort)
    done
}

# field NAME LOG: a figure of libFuzzer's statistics.
field() { grep -a "stat::$1:" "$2" | awk '{ sum += $2 } END { print sum + 0 }'; }

# one TARGET SECONDS: until the seconds are spent; begins again after each find, at most five times.
one() {
    local target=$1 left=$2 log=$tree/logs/$1.log found=$tree/found/$1 started=0 status
    mkdir -p "$tree/logs" "$found" "$working/$target"
    : >"$log"
    data_seeds "$target"
    local folders=("$working/$target")
    [ ! -d "tests/fuzz/corpus/$target" ] || folders+=("tests/fuzz/corpus/$target")
    [ ! -d "tests/fuzz/found/$target" ] || folders+=("tests/fuzz/found/$target")
    [ ! -d "$tree/data/$target" ] || folders+=("$tree/data/$target")
    while [ "$left" -gt 0 ] && [ "$started" -lt 6 ]; do
        started=$((started + 1))
        # shellcheck disable=SC2046  # no dictionary, no word
        (ulimit -St "$left"; TIMEFORMAT='processor seconds: %U %S'; time nice -n 19 "$programs/fuzz_$target" -max_len=16384 -timeout=1200 -report_slow_units=100000 -rss_limit_mb=3072 -malloc_limit_mb=1024 \
            -print_final_stats=1 -artifact_prefix="$found/" $(dictionary "$target") "${folders[@]}") >>"$log" 2>&1
        status=$?
        local spent
        spent=$(grep -a '^processor seconds:' "$log" | tail -1 | awk '{ printf "%d", $3 + $4 + 1 }')
        left=$((left - ${spent:-$left}))
        [ $status -ne 0 ] || break
    done
}

# What a run of a target said, as a line of the table.
tell() {
    local log=$tree/logs/$1.log covered all seconds finds
    covered=$(grep -aoE 'cov: [0-9]+' "$log" | awk '{ if ($2 > most) most = $2 } END { print most + 0 }')
    all=$(grep -aoE '\([0-9]+ inline 8-bit counters\)|[0-9]+ inline 8-bit counters' "$log" | head -1 | grep -oE '[0-9]+' | head -1)
    seconds=$(grep -a '^processor seconds:' "$log" | awk '{ s += $3 + $4 } END { printf "%.1f", s / 60 }')
    finds=$(find "$tree/found/$1" -type f 2>/dev/null | wc -l)
    printf '%-12s %12s %9s %9s of %-7s %6s %6s\n' "$1" "$(field number_of_executed_units "$log")" "$seconds" "$covered" "${all:-?}" "$(find "$working/$1" -type f 2>/dev/null | wc -l)" "$finds"
}

run() {
    local minutes=$1 found=0 names
    shift
    build || return 1
    names=${*:-$(targets)}
    rm -rf "$tree/data"
    export -f one data_seeds dictionary head_of field
    export tree programs data root working
    # shellcheck disable=SC2016,SC2086  # what an inner shell expands; a list of words
    printf '%s\n' $names | xargs -P "$jobs" -I{} bash -c 'one "$0" "$1"' {} $((minutes * 60))
    printf '%-12s %12s %9s %9s    %-7s %6s %6s\n' target executions minutes edges all corpus finds
    for name in $names; do
        tell "$name"
        found=$((found + $(find "$tree/found/$name" -type f 2>/dev/null | wc -l)))
    done
    [ $found -eq 0 ] || echo "$found found: in $tree/found; each is run again by build/test/fuzz/fuzz/fuzz_TARGET FILE"
    [ $found -eq 0 ]
}

# The fewest inputs of at most 4 KiB that reach what running on from the committed seeds reaches: nothing of the data set is among them.
seeds() {
    local name minutes=$1
    shift
    data=none
    working=$tree/own
    run "$minutes" "$@" || return 1
    # shellcheck disable=SC2048  # a list of words
    for name in ${*:-$(targets)}; do
        rm -rf "$tree/merged" && mkdir -p "$tree/merged" "tests/fuzz/corpus/$name"
        "$programs/fuzz_$name" -merge=1 -max_len=4096 "$tree/merged" "tests/fuzz/corpus/$name" "$working/$name" >"$tree/logs/$name.merge" 2>&1 || { tail -5 "$tree/logs/$name.merge"; return 1; }
        rm -rf "tests/fuzz/corpus/$name"
        mv "$tree/merged" "tests/fuzz/corpus/$name"
        echo "$name: $(find "tests/fuzz/corpus/$name" -type f | wc -l) files, $(du -bs "tests/fuzz/corpus/$name" | cut -f1) bytes"
    done
}

coverage() {
    local name folders
    build || return 1
    # shellcheck disable=SC2048  # a list of words
    for name in ${*:-$(targets)}; do
        mkdir -p "$tree/corpus/$name"
        folders=("$tree/corpus/$name")
        [ ! -d "tests/fuzz/corpus/$name" ] || folders+=("tests/fuzz/corpus/$name")
        "$programs/fuzz_$name" -runs=0 -max_len=16384 -print_coverage=1 "${folders[@]}" 2>&1 | grep -aE '^(UN)?COVERED_FUNC'
    done | awk '{
            place = $NF; split($5, edges, "/")
            if (place !~ /\/src\/(core|check|io)\//) next
            sub(/.*\/src\/(core|check|io)\//, substr(place, match(place, /(core|check|io)\//), RLENGTH), place)
            if (edges[1] > reached[place]) reached[place] = edges[1]
            all[place] = edges[2]
        }
        END {
            for (place in all) { file = place; sub(/:[0-9]+$/, "", file); r[file] += reached[place]; a[file] += all[place]; sum += reached[place]; total += all[place] }
            for (file in a) printf "%-32s %6d of %6d %5.1f %%\n", file, r[file], a[file], 100 * r[file] / a[file] | "sort"
            close("sort")
            if (total) printf "%-32s %6d of %6d %5.1f %%\n", "all", sum, total, 100 * sum / total
        }'
}

case ${1:-} in
coverage) shift; coverage "$@" ;;
build) build ;;
run) shift; run "$@" ;;
seeds) shift; seeds "$@" ;;
*) sed -n '2,11s/^# \{0,1\}//p' "$0"; exit 2 ;;
esac
