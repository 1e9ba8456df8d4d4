#!/bin/bash
# Do two commits give the same? For changes that must not change a result: builds both and compares exported symbols, all hashes of tests/bits, the golden cases, and what every
# verb writes and says about small real meshes; object sizes for information. Exits 1 where one bit differs.
#   scripts/same.sh A B       two commits;  . is the working tree
#   NORMA_DATA=none           without the data set;  SAME_KB=64: files up to that size go through the verbs
# Trees stay in build/same, by commit. JOBS: how many at once.
# shellcheck disable=SC2016  # single quotes hold what inner shells expand
set -u
cd "$(dirname "$0")/.." || exit 1
root=$PWD
[ $# -eq 2 ] || { sed -n '2,6s/^# \{0,1\}//p' "$0"; exit 2; }
jobs=${JOBS:-$(nproc)}
data=${NORMA_DATA:-$root/../shared/data}
kb=${SAME_KB:-64}
export LC_ALL=C.UTF-8 NO_COLOR=1
same=$root/build/same
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failed=0

# built COMMIT: builds it, and prints the folder of its sources.
built() {
    local commit sources
    if [ "$1" = . ]; then
        sources=$root commit=working-tree
    else
        commit=$(git rev-parse --short=10 "$1^{commit}") || return 1
        sources=$same/$commit/source
        [ -d "$sources" ] || { mkdir -p "$sources" && git archive "$commit" | tar -x -C "$sources"; } || return 1
    fi
    mkdir -p "$same/$commit"
    cmake -S "$sources" -B "$same/$commit/tree" -G Ninja -DCMAKE_C_COMPILER=gcc -DCMAKE_BUILD_TYPE=Release -DCMAKE_C_FLAGS_RELEASE=-O2 -DNORMA_TESTS=OFF -DNORMA_BITS=ON -DNORMA_WEB=OFF -DNORMA_EXAMPLES=OFF >"$same/$commit/log" 2>&1 &&
        cmake --build "$same/$commit/tree" -j "$jobs" >>"$same/$commit/log" 2>&1 || { tail -20 "$same/$commit/log" >&2; return 1; }
    echo "$sources $same/$commit/tree"
}
read -r source_a tree_a <<<"$(built "$1")"
read -r source_b tree_b <<<"$(built "$2")"
[ -n "${tree_a:-}" ] && [ -n "${tree_b:-}" ] || exit 2
echo "$1 ($(basename "$(dirname "$tree_a")")) and $2 ($(basename "$(dirname "$tree_b")"))"

# told NAME COUNT DIFFERENCES-FILE: a line of the result, and the first differences.
told() {
    local different
    different=$(wc -l <"$3")
    printf '%-34s %6s compared %6s differ\n' "$1" "$2" "$different"
    [ "$different" -eq 0 ] || { failed=1; head -n "${4:-30}" "$3" | cut -c1-200 | sed 's/^/    /'; }
}

# ---- symbols: none is gone or of another version; new ones are told

for library in libnorma libnorma-core; do
    for side in a b; do
        tree=tree_$side
        nm -D --defined-only "${!tree}/lib/$library.so" | awk '{ print $NF }' | sort >"$work/symbols.$side"
    done
    comm -23 "$work/symbols.a" "$work/symbols.b" >"$work/gone"
    told "symbols of $library.so" "$(wc -l <"$work/symbols.a")" "$work/gone"
    new=$(comm -13 "$work/symbols.a" "$work/symbols.b" | tr '\n' ' ')
    [ -z "$new" ] || echo "    new: $new"
done

# ---- hashes of results: A's driver of hashes has to be B's, or what both print is compared

hashes() { # SIDE ARGUMENT...
    local tree=tree_$1
    shift
    "${!tree}/tests/norma_bits" "$@" 2>"$work/said" || echo "exit status $?: $(head -n 3 "$work/said")"
}
compare_hashes() { # NAME ARGUMENT...
    local name=$1
    shift
    hashes a "$@" >"$work/hashes.a"
    hashes b "$@" >"$work/hashes.b"
    # Lines of A that B has not; what only B knows is no difference.
    grep -vxFf "$work/hashes.b" "$work/hashes.a" >"$work/differences"
    told "$name" "$(wc -l <"$work/hashes.a")" "$work/differences" 10
}
compare_hashes "hashes of made meshes, all ways" --made
tests/bits/files.sh assets tests/cli/golden/files >"$work/list"
compare_hashes "hashes of the repository's meshes" --ways some --files "$work/list"
if [ -d "$data" ]; then
    cd "$data" && "$root/tests/bits/files.sh" -- * >"$work/list"
    compare_hashes "hashes of the data set" --ways one --files "$work/list"
    cd "$root" || exit 1
fi

# ---- golden cases of A with both tools

for side in a b; do
    tree=tree_$side
    NORMA_TREE=${!tree} NORMA_BIN=${!tree}/bin/norma "$source_a/tests/cli/golden.sh" >"$work/golden.$side" 2>/dev/null
    grep -E '^(not )?ok' "$work/golden.$side" | sed -E 's/^(not ok|ok) [0-9]+/\1/' >"$work/cases.$side"
done
diff "$work/cases.a" "$work/cases.b" | sed -n 's/^> //p' >"$work/differences"
told "golden cases of $1" "$(wc -l <"$work/cases.a")" "$work/differences" 200

# ---- every verb over small real meshes

commands='info IN --json
check IN --info --format json
check IN --profile print --format text
check IN --fix -o OUT
check IN --fix-unsafe -o OUT
compute IN -o OUT
compute IN -o OUT --crease 30 --weight area
compute IN -o OUT --smooth
compute IN -o OUT --crease 180 --weight visible --weld 0.001
compute IN -o OUT --flat --only missing
transform IN -o OUT --scale 2,.5,-1 --rotate 1,2,3,40'
gltf_commands='transform IN -o OUT --bake
tangents IN -o OUT
tangents IN -o OUT --mode steady
compute IN -o OUT --morphs --tangents regenerate'

# sums FILE: for each command and both tools the hash of what was said, written and returned; a line where they differ.
sums() {
    local file=$1 line words side tree status sum before folder=$work/$$ list=$commands
    mkdir -p "$folder"
    case $file in *.gltf | *.glb) list+=$'\n'$gltf_commands ;; esac
    cd "$(dirname "$file")" || return
    while IFS= read -r line; do
        before=""
        for side in a b; do
            tree=tree_$side
            rm -rf "$folder"/* && words=${line/ IN/ \"$(basename "$file")\"} && words=${words/OUT/\"$folder/out.${file##*.}\"} status=0
            eval "timeout 120 ${!tree}/bin/norma $words" >"$folder/said" 2>&1 </dev/null || status=$?
            sum="$status $(find "$folder" -type f | LC_ALL=C sort | xargs -d '\n' cat | md5sum)"
            if [ "$side" = a ]; then before=$sum; elif [ "$sum" != "$before" ]; then echo "differs norma $line   (IN = $file) exit ${before%% *} and ${sum%% *}"; else echo same; fi
        done
    done <<<"$list"
    rm -rf "$folder"
}
export -f sums
export commands gltf_commands work tree_a tree_b
{
    find "$root/assets" "$root/tests/cli/golden/files" -type f
    [ ! -d "$data" ] || find -L "$data" -type f -not -path "$data/bad/*"
} | grep -E '\.(obj|ply|stl|gltf|glb)$' | while IFS= read -r file; do [ "$(stat -L -c %s "$file")" -gt $((kb * 1024)) ] || echo "$file"; done | LC_ALL=C sort >"$work/files"
xargs -d '\n' -P "$jobs" -I{} bash -c 'sums "$0"' {} <"$work/files" >"$work/sums"
grep '^differs' "$work/sums" | sed "s/^differs //; s|$data/||; s|$root/||" | LC_ALL=C sort >"$work/differences"
sed 's/ *(IN = .*//' "$work/differences" | sort | uniq -c | sort -rn >"$work/by_command"
told "verbs on $(wc -l <"$work/files") files" "$(wc -l <"$work/sums")" "$work/differences" 20
[ ! -s "$work/by_command" ] || { echo "    by command:"; sed 's/^/    /' "$work/by_command"; }

# ---- sizes, for information

echo "Instructions and constants, in bytes (text of size):"
for file in lib/libnorma.so lib/libnorma-core.so bin/norma; do
    printf '    %-24s %10s %10s\n' "$file" "$(size "$tree_a/$file" | awk 'END { print $1 }')" "$(size "$tree_b/$file" | awk 'END { print $1 }')"
done
echo "Lines, files of src: $(find "$source_a/src" -type f -exec cat {} + | wc -l), $(find "$source_a/src" -type f | wc -l) and $(find "$source_b/src" -type f -exec cat {} + | wc -l), $(find "$source_b/src" -type f | wc -l)"
if [ $failed -eq 0 ]; then echo "The same."; else echo "NOT the same."; fi
exit $failed
