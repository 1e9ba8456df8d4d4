#!/bin/bash
# make bench: Norma beside memcpy of the same bytes and beside the other libraries that are installed, on the same meshes, in one run. Everything is printed and left in
# build/bench: core.txt, real.txt, rivals.tsv, rivals.md (the README's table), files.txt, web.txt, python.txt.
#   scripts/bench.sh             everything (about ten minutes)
#   scripts/bench.sh core web    some of: core, real, rivals, files, web, python
# NORMA_BENCH_TRIANGLES: of the meshes made (2000000; core: 10000000). NORMA_BENCH_BUSY=1: processor time of one thread, where others use the machine.
set -u
cd "$(dirname "$0")/.." || exit 1
root=$PWD
out=$root/build/bench
sections=${*:-core real rivals files web python}
triangles=${NORMA_BENCH_TRIANGLES:-2000000}
mkdir -p "$out"

case " $sections " in *" rivals "* | *" files "* | *" web "* | *" python "*) scripts/install-deps.sh bench || echo "some libraries could not be installed; those that are there are measured" ;; esac
cmake -S . -B "$out/tree" -G Ninja -DCMAKE_BUILD_TYPE=Release -DNORMA_BENCH=ON -DNORMA_TESTS=OFF -DNORMA_WEB=OFF -DNORMA_EXAMPLES=OFF -DNORMA_SHARED=OFF >"$out/build.log" 2>&1 &&
    cmake --build "$out/tree" >>"$out/build.log" 2>&1 || { tail -20 "$out/build.log"; exit 1; }
bin=$out/tree/bin

about() {
    local isa
    isa=$(grep -owm1 -E 'avx512f|avx2|asimd' /proc/cpuinfo | sort | tail -1)
    echo "$(date +%Y-%m-%d), $(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -1), $(nproc) cores${isa:+, $isa}, $(gcc --version | head -1)${NORMA_BENCH_BUSY:+, busy: processor time of one thread}; load $(cut -d' ' -f1 /proc/loadavg)"
}

run_core() {
    about | tee "$out/core.txt"
    "$bin/bench_core" --triangles "${NORMA_BENCH_TRIANGLES:-10000000}" | tee -a "$out/core.txt"
    "$bin/bench_plan" | tee -a "$out/core.txt"
}

# Meshes that people made, if the data set is there; quads among them.
run_real() {
    local data=${NORMA_DATA:-$root/../shared/data}/large
    about | tee "$out/real.txt"
    (cd "$data" && "$bin/bench_uses" --only files medical/headsq-bone.ply terrain/jacksboro.ply game/vino-scooter.glb interior/dream-apartment.glb cad/exhaust_filter_housing.stl \
        voxel/pandora/pandora.obj foliage/bamboo/bamboo.obj hair/bob01.obj hair/long01.obj) | tee -a "$out/real.txt"
}

run_rivals() {
    local rival
    : >"$out/rivals.tsv"
    for rival in norma vtk open3d openmesh cgal assimp matrices; do
        [ -x "$bin/rival_$rival" ] && "$bin/rival_$rival" "$triangles" | tee -a "$out/rivals.tsv"
    done
    {
        about
        echo
        echo "| library | call | weight | mesh | elements | ns each | times a copy | degrees off at most | peak MB |"
        echo "|---|---|---|---|---|---|---|---|---|"
        sed 's/\t/ | /g; s/^/| /; s/$/ |/' "$out/rivals.tsv"
    } >"$out/rivals.md"
}

run_files() {
    NORMA_BIN=$bin/norma GLTF_TRANSFORM=$root/build/npm-bench/node_modules bench/bench_files.sh | tee "$out/files.txt"
}

run_web() {
    if [ ! -d build/web/npm ]; then make --no-print-directory web >"$out/web.log" 2>&1 || { tail -5 "$out/web.log"; return; }; fi
    NODE_PATH=$root/build/npm-web/node_modules node bench/bench_web.mjs | tee "$out/web.txt"
}

run_python() {
    scripts/python.sh >/dev/null || return
    rm -rf "$out/venv"
    /usr/bin/python3 -m venv --system-site-packages "$out/venv" && "$out/venv/bin/pip" install --quiet --no-index --no-deps build/python/*.whl &&
        "$out/venv/bin/python" bench/bench_python.py | tee "$out/python.txt"
}

# bench/tables.sh writes what was measured into docs/speed.md.
for section in $sections; do
    echo "== $section"
    "run_$section"
done
