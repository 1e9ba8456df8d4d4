#!/bin/bash
# make bench: Norma beside memcpy of the same bytes and beside the other libraries that are installed, on the same meshes, in one run. Everything is printed and left in
# build/bench: core.txt, rivals.tsv, rivals.md (the README's table), files.txt, web.txt, python.txt.
#   scripts/bench.sh             everything (about ten minutes)
#   scripts/bench.sh core web    some of: core, rivals, files, web, python
# NORMA_BENCH_TRIANGLES: of the meshes made (2000000; core: 10000000).
set -u
cd "$(dirname "$0")/.." || exit 1
root=$PWD
out=$root/build/bench
sections=${*:-core rivals files web python}
triangles=${NORMA_BENCH_TRIANGLES:-2000000}
mkdir -p "$out"

case " $sections " in *" rivals "* | *" files "* | *" web "* | *" python "*) scripts/install-deps.sh bench || echo "some libraries could not be installed; those that are there are measured" ;; esac
cmake -S . -B "$out/tree" -G Ninja -DCMAKE_BUILD_TYPE=Release -DNORMA_BENCH=ON -DNORMA_TESTS=OFF -DNORMA_WEB=OFF -DNORMA_EXAMPLES=OFF -DNORMA_SHARED=OFF >"$out/build.log" 2>&1 &&
    cmake --build "$out/tree" >>"$out/build.log" 2>&1 || { tail -20 "$out/build.log"; exit 1; }
bin=$out/tree/bin

about() {
    echo "$(date +%Y-%m-%d), $(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -1), $(nproc) cores, $(gcc --version | head -1)"
}

run_core() {
    about | tee "$out/core.txt"
    "$bin/bench_core" --triangles "${NORMA_BENCH_TRIANGLES:-10000000}" | tee -a "$out/core.txt"
    "$bin/bench_plan" | tee -a "$out/core.txt"
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

for section in $sections; do
    echo "== $section"
    "run_$section"
done
