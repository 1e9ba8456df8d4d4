#!/bin/bash
# What a fuzz target does again, in the same way at each run of the same commit: neither a clock nor an address takes part. TAP.
#   tests/fuzz/replay.sh TARGET         every committed seed and every case that was ever found (tests/fuzz/found)
#   tests/fuzz/replay.sh TARGET runs    a fixed number of runs from a fixed seed
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
target=$1
program=$tree/fuzz/fuzz_$target
cd "$root/tests/fuzz" || exit 1
[ -x "$program" ] || { fail "the target is there" "no program at $program"; finish; exit 1; }
export ASAN_OPTIONS=allocator_may_return_null=1:handle_abort=2 UBSAN_OPTIONS=print_stacktrace=1

# About four seconds of processor time each.
case $target in
stl) runs=60000 ;;
3mf) runs=10000 ;;
matrices) runs=40000 ;;
ply) runs=20000 ;;
obj | gltf | glb | tile) runs=10000 ;;
meshopt | normals | plan) runs=5000 ;;
roundtrip) runs=4000 ;;
commands | overwritten) runs=200 ;; # files are made for each
*) runs=1500 ;;
esac

# quietly NAME ARGUMENTS...: the target over these.
quietly() {
    local name=$1 said
    shift
    if said=$("$program" -artifact_prefix="$scratch/" "$@" 2>&1); then pass "$name"; else fail "$name" "$(printf '%s\n' "$said" | grep -aE '^fuzz:|ERROR:|SUMMARY:|^ *#[0-9]+ 0x' | head -40)"; fi
}

mapfile -t seeds < <(find "corpus/$target" -type f 2>/dev/null | LC_ALL=C sort)
[ ${#seeds[@]} -gt 0 ] || { fail "there are seeds"; finish; exit 1; } # without one the program would run for ever
if [ "${2:-}" != runs ]; then
    quietly "${#seeds[@]} seeds" "${seeds[@]}"
    while IFS= read -r file; do
        quietly "$file" "$file"
    done < <(find "found/$target" -type f 2>/dev/null | LC_ALL=C sort)
    finish
    exit
fi
# No folder is given, since the order in one is the file system's; what comparisons saw (use_cmp) may be addresses.
printf '%s,' "${seeds[@]}" | sed 's/,$//' >"$scratch/seeds"
dictionary=()
case $target in
obj | ply | stl | 3mf) dictionary=(-dict="dictionaries/$target.dict") ;;
gltf | glb | tile | check | roundtrip) dictionary=(-dict=dictionaries/gltf.dict) ;;
esac
quietly "$runs runs from seed 1" -seed=1 -runs="$runs" -use_cmp=0 -max_len=2048 -timeout=1200 -report_slow_units=100000 -rss_limit_mb=3072 -malloc_limit_mb=1024 -seed_inputs="@$scratch/seeds" "${dictionary[@]}"
finish
