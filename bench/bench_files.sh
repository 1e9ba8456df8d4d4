#!/bin/bash
# Whole processes, file to file, on a memory file system: norma compute with its default options, and with creases at 60 degrees, beside copying the same file.
#   bench/bench_files.sh [TRIANGLES]        (1000000)
# Then norma check. Targets are those of the same bytes as plain OBJ has, or of eight copies, where a row says so; real files come from NORMA_DATA (../shared/data), if it is there.
# NORMA_BIN: the tool (build/bin/norma); RUNS: the best of so many (9); NORMA_BENCH_BUSY: processor time instead of wall time, of one thread; GLTF_TRANSFORM: a node_modules folder with gltf-transform, to measure it too.
# Prints for each format, in milliseconds and MB: the input's bytes, the output's, cp, norma with one thread and with two, the least of both against cp and against the target of
# DESIGN.md, and the largest resident memory of both, with the mapped input and without it, against the input's size.
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
norma=${NORMA_BIN:-$root/build/bin/norma}
triangles=${1:-1000000}
runs=${RUNS:-9}
folder=$(mktemp -d "$([ -w /dev/shm ] && echo /dev/shm || echo /tmp)/norma-bench-XXXXXX")
trap 'rm -rf "$folder"' EXIT
for program in make_meshes run_best; do
    ${CC:-cc} -std=c11 -O2 "$root/bench/$program.c" -o "$folder/$program" -lm
done

# best FIELDS COMMAND...: of run_best's numbers wall time, or processor time; then the memory.
best() {
    "$folder/run_best" "$runs" "$@" | awk -v busy="${NORMA_BENCH_BUSY:-}" '{ print busy ? $2 : $1, $2, $3, $4 }'
}

# ms TARGET: for this many triangles, from that for a million.
target_of() { awk -v t="$1" -v n="$triangles" 'BEGIN { printf "%.0f", t * n / 1e6 }'; }

# measure LABEL KIND EXTENSION TARGET OPTIONS...
measure() {
    local label=$1 kind=$2 extension=$3 target=$4 in out copy one two
    shift 4
    in=$folder/in.$extension
    out=$folder/out.$extension
    [ -e "$in" ] || "$folder/make_meshes" "$kind" "$triangles" "$in"
    copy=$(best cp "$in" "$folder/copy" | cut -d' ' -f1)
    rm -f "$folder/copy"
    one=$(best "$norma" compute "$in" -o "$out" --quiet --threads 1 "$@")
    two=$one
    [ -n "${NORMA_BENCH_BUSY:-}" ] || two=$(best "$norma" compute "$in" -o "$out" --quiet --threads 2 "$@")
    case $target in
    bytes) target=$(awk -v n="$(stat -c %s "$in")" -v plain="$plain" -v t="$(target_of 100)" 'BEGIN { printf "%.0f", t * n / plain }') ;;
    copies) target=$(awk -v copy="$copy" 'BEGIN { printf "%.0f", 8 * copy }') ;;
    *) target=$(target_of "$target") ;;
    esac
    awk -v label="$label" -v in_size="$(stat -c %s "$in")" -v out_size="$(stat -c %s "$out")" -v copy="$copy" -v one="$one" -v two="$two" -v target="$target" 'BEGIN {
        split(one, a, " "); split(two, b, " ")
        least = a[1] < b[1] ? a[1] : b[1]; rss = a[3] > b[3] ? a[3] : b[3]; own = a[4] > b[4] ? a[4] : b[4]
        printf "%-26s %7.1f %7.1f %7.1f %8.1f %8.1f %6.1f %8d %6.2f %8.1f %5.2f %8.1f %5.2f\n", label, in_size / 1e6, out_size / 1e6, copy, a[1], b[1], least / copy, target, least / target,
            rss, rss * 1e6 / in_size, own, own * 1e6 / in_size
    }'
    rm -f "$out"
}

printf '%s triangles; the best of %s runs; %s, %s threads online; %s\n' "$triangles" "$runs" "$(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -1)" "$(nproc)" "$(date -u +%F)"
printf '%-26s %7s %7s %7s %8s %8s %6s %8s %6s %8s %5s %8s %5s\n' "" "in MB" "out MB" "cp ms" "1 thread" "2" "/cp" "must ms" "/must" "RSS MB" "/in" "own MB" "/in"
measure "OBJ, v and f" obj obj 100
plain=$(stat -c %s "$folder/in.obj")
rm -f "$folder"/in.*
for kind in obj-quads obj-vt obj-quads-vt; do
    measure "$kind, as per byte" "$kind" obj bytes
    rm -f "$folder"/in.*
done
data=${NORMA_DATA:-$root/../shared/data}/large
for file in foliage/bamboo/bamboo hair/bob01 scan/ycb-power-drill; do
    [ -e "$data/$file.obj" ] || continue
    awk -v bytes=30000000 -f "$root/bench/repeat_obj.awk" "$data/$file.obj" >"$folder/in.obj"
    measure "$(basename "$file").obj, 8 cp" none obj copies
    rm -f "$folder"/in.*
done
measure "OBJ, v/vt/vn" obj-full obj 200
rm -f "$folder"/in.*
measure "PLY, smooth" ply ply 30
measure "PLY, creases" ply ply 60 --crease 60
rm -f "$folder"/in.*
measure "STL" stl stl 40
rm -f "$folder"/in.*
measure "GLB, smooth" glb glb 40 --smooth
measure "GLB, creases" glb glb 80 --crease 60
measure "GLB, flat" glb glb 80 --flat
if [ -d "${GLTF_TRANSFORM:-}/@gltf-transform" ]; then
    printf '%-26s %s ms (flat normals, node %s)\n' "GLB, gltf-transform" \
        "$("$folder/run_best" 3 node "$root/bench/rivals/npm/gltf-transform.mjs" "$GLTF_TRANSFORM" "$folder/in.glb" "$folder/out.glb" | cut -d' ' -f1)" "$(node --version)"
fi
rm -f "$folder"/in.*
measure "GLB with normals" glb-normals glb 80
rm -f "$folder"/in.*

# check LABEL TRIANGLES TARGET: a sheet whose normals are the ones that Norma computes.
check() {
    "$folder/make_meshes" glb "$2" "$folder/plain.glb"
    "$norma" compute "$folder/plain.glb" -o "$folder/in.glb" --quiet
    printf '%-26s %s ms (must: %s)\n' "$1" "$(best "$norma" check "$folder/in.glb" ${NORMA_BENCH_BUSY:+--threads 1} | cut -d' ' -f1)" "$3"
    rm -f "$folder"/*.glb
}
check "check, 1 million" 1000000 150
check "check, 200,000" 200000 40

# What info reads of 2 GB of vertices: a file with a hole, which takes no room.
"$folder/make_meshes" ply-vertices 2000000000 "$folder/in.ply"
printf '%-26s %s ms (must: 100)\n' "info, PLY of 2 GB" "$("$folder/run_best" "$runs" "$norma" info "$folder/in.ply" | cut -d' ' -f1)"
