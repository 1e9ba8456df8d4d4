#!/bin/bash
# Static analysers over the library and the tool: clang-tidy with the list in .clang-tidy, and gcc's -fanalyzer. What they find and is no fault stands in scripts/analysed.txt with its
# reason. Anything else is printed, and the exit status is 1. Some five minutes on two cores.
set -u
cd "$(dirname "$0")/.." || exit 1
out=${ANALYSE_BUILD:-build/analyse}
mkdir -p "$out/found"
rm -f "$out"/found/*
cmake -S . -B "$out" -G Ninja -DCMAKE_C_COMPILER=clang -DNORMA_TESTS=OFF -DNORMA_WEB=OFF -DNORMA_EXAMPLES=OFF >"$out/configure.log" 2>&1 || { cat "$out/configure.log"; exit 1; }
command -v clang-tidy >/dev/null || { echo "clang-tidy is not installed (Debian: clang-tidy)"; exit 1; }
export out
one() {
    local name
    name=$(tr / _ <<<"$1")
    clang-tidy -p "$out" --quiet "$1" 2>/dev/null | sed -nE "s#^$PWD/([^:]+):([0-9]+):[0-9]+: warning: (.*) \[(.*)\]\$#\1 [\4] line \2: \3#p" >"$out/found/$name"
    gcc -std=c11 -O2 -ffp-contract=off -Iinclude -Isrc -I. -I"$out/generated" -fanalyzer -c "$1" -o /dev/null 2>&1 |
        sed -nE -e 's#^([^: ]+):([0-9]+):[0-9]+: warning: (.*) \[-W(analyzer-[a-z-]+)\]$#\1 [\4] line \2: \3#p' -e "s#^cc1: warning: (.*) \[-W(analyzer-[a-z-]+)\]\$#$1 [\2] no line: \1#p" >>"$out/found/$name"
}
export -f one
files=$(find src -name '*.c' ! -name '*_windows.c' ! -name '*_left_out.c' | LC_ALL=C sort)
printf '%s\n' "$files" | xargs -P "$(nproc)" -I{} bash -c 'one "$0"' {}
sort -u "$out"/found/* >"$out/all"
awk -v said="$out/said" '
    FNR == NR { if ($0 !~ /^[#=]/ && NF == 2) known[$1 " " $2] = 1; next }
    { key = $1 " " $2; if (key in known || "* " $2 in known) { explained++; used[key in known ? key : "* " $2] = 1 } else { print; other++ } }
    END { for (k in known) if (!used[k]) print "scripts/analysed.txt explains what is no longer found: " k
          printf "%d findings, %d of them explained in scripts/analysed.txt\n", explained + other, explained; exit other > 0 }' scripts/analysed.txt "$out/all"
