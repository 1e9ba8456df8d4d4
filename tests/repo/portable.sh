#!/bin/bash
# The same bits: the hashes of this build's results, for every number of threads and instruction set, are those in tests/bits. `make portable` does the same for other
# compilers and machines.
#   tests/repo/portable.sh --refresh    writes the hashes anew: only for a change that is meant to change bits, and says so
#   NORMA_BITS_WAYS=one                  fewer ways to run, for slow builds
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
cd "$root" || exit 1
bits=$tree/tests/norma_bits
ways=${NORMA_BITS_WAYS:-some}
data=${NORMA_DATA:-$root/../shared/data}

assets() { tests/bits/files.sh assets tests/cli/golden/files; }
if [ "${1:-}" = --refresh ]; then
    assets >"$scratch/list"
    "$bits" --made >tests/bits/expected-made.txt
    "$bits" --files "$scratch/list" >tests/bits/expected-assets.txt
    if [ -d "$data" ]; then
        (cd "$data" && "$root/tests/bits/files.sh" -- * >"$scratch/list" && "$bits" --ways one --files "$scratch/list") >tests/bits/expected-data.txt
    fi
    exit 0
fi

# compare NAME EXPECTED FOLDER ARGUMENT...
compare() {
    local name=$1 expected=$root/tests/bits/$2 folder=$3 status=0
    shift 3
    (cd "$folder" && "$bits" --ways "$ways" "$@") >"$scratch/got" 2>"$scratch/said" || status=$?
    if [ "$status" = 0 ] && diff "$expected" "$scratch/got" >"$scratch/difference"; then
        pass "$name: $(sed -n 's/ hashes, each in up to \([0-9]*\) ways.*/ hashes, up to \1 ways/p' "$scratch/said")"
    else
        fail "$name" "exit status $status; $(head -n 20 "$scratch/difference" "$scratch/said")"
    fi
}

check "the driver was built" test -x "$bits"
compare "made meshes" expected-made.txt "$root" --made
assets >"$scratch/list"
compare "meshes of the repository" expected-assets.txt "$root" --files "$scratch/list"
if [ "$ways" = one ]; then
    skip "the data set (left to a faster build)"
elif [ -d "$data" ]; then
    (cd "$data" && "$root/tests/bits/files.sh" -- * >"$scratch/list")
    ways=one
    compare "the data set" expected-data.txt "$data" --files "$scratch/list"
else
    skip "the data set (not here)"
fi
finish
