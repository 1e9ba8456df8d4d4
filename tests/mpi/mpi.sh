#!/bin/bash
# libnorma-mpi and norma-mpi: the same bits as one process on any number of ranks, and one rank's faults. `make test` runs a short part with the MPI of the tree;
# `make mpi` sets NORMA_MPI_LONG and builds and tests with Open MPI and MPICH, on 1 to 16 ranks.
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
# shellcheck source=tests/mpi/launch.bash
source "$(dirname "$0")/launch.bash"
cd "$root" || exit 1

# test_tree TREE MPI COUNT RANKS...: COUNT meshes on each number of ranks; with MPICH fewer where ranks outnumber cores: who waits there does not give way, so each message takes a time slice.
test_tree() {
    local tree=$1 mpi=$2 count=$3 n meshes
    shift 3
    for n; do
        meshes=$count
        [ "$mpi" != mpich ] || [ "$n" -le "$(nproc)" ] || meshes=$((count / 20))
        check "$mpi, $n ranks: $meshes meshes in random parts have the bits of one process" env LIMIT=300 bash -c '. tests/mpi/launch.bash; ranks "$@"' _ "$tree" "$n" "$tree/tests/mpi_bits" "$((n * 1000))" "$meshes"
    done
    meshes=$((count / 10 + 1))
    [ "$mpi" != mpich ] || [ "$(nproc)" -ge 3 ] || meshes=4
    check "$mpi, 3 ranks: $meshes large meshes, in several rounds" env LIMIT=300 bash -c '. tests/mpi/launch.bash; ranks "$@"' _ "$tree" 3 "$tree/tests/mpi_bits" 70 "$meshes" 60000
    for n in 1 3; do
        LIMIT=300 ranks "$tree" "$n" "$tree/tests/mpi_faults" >"$scratch/faults.tap" 2>"$scratch/faults.err"
        grep -E '^(not )?ok ' "$scratch/faults.tap" >"$scratch/lines"
        while read -r result _ _ name; do
            case $result in ok) pass "$mpi, $n ranks: $name" ;; *) fail "$mpi, $n ranks: ${name#- }" "$(cat "$scratch/faults.tap")" ;; esac
        done < <(sed 's/^not ok/notok/' "$scratch/lines")
        check "$mpi, $n ranks: all faults were tried" grep -qx "1..$(wc -l <"$scratch/lines")" "$scratch/faults.tap"
    done
}

# as_rank RANK VALUE OTHER: in a shell that is one of the ranks: VALUE on that rank, OTHER elsewhere.
export AS_RANK='as_rank() { if [ "${OMPI_COMM_WORLD_RANK:-${PMI_RANK:-0}}" = "$1" ]; then echo "$2"; else echo "$3"; fi; }'

same_file() { # NAME MPI TREE RANKS FILE OPTIONS...: norma-mpi writes what norma does
    local name=$1 mpi=$2 tree=$3 n=$4 file=$5 out=$scratch/out.${5##*.}
    shift 5
    rm -f "$out"
    check "$mpi, $n ranks, $name: the file that norma compute writes" bash -c '. tests/mpi/launch.bash; file=$2; tree=$0; n=$1; out=$3; shift 3; "$tree/bin/norma" compute "$file" -o "${out%.*}.alone.${out##*.}" --quiet "$@" && ranks "$tree" "$n" "$tree/bin/norma-mpi" compute "$file" -o "$out" --quiet "$@" && cmp "${out%.*}.alone.${out##*.}" "$out"' \
        "$tree" "$n" "$file" "$out" "$@"
}

# refused NAME MPI TREE WORDS SCRIPT: the script, run by each of 3 ranks, ends with status 3 and the words; the old output stays, and nothing else is left.
refused() {
    local folder=$scratch/refused status=0
    rm -rf "$folder"
    mkdir -p "$folder/here" "$folder/there"
    cp "$scratch/a.ply" "$folder/here"
    head -c 20000 "$scratch/a.ply" >"$folder/there/a.ply"
    echo old >"$folder/here/out.ply"
    (cd "$folder/here" && PATH=$3/bin:$PATH LIMIT=60 ranks "$3" 3 bash -c "$AS_RANK; $5") >"$folder/log" 2>&1 || status=$?
    if [ "$status" = 3 ] && grep -q "$4" "$folder/log" && [ "$(cat "$folder/here/out.ply")" = old ] && [ "$(find "$folder" -type f | wc -l)" = 4 ]; then
        pass "$2: $1"
    else
        fail "$2: $1" "status $status, $(find "$folder" -type f | tr '\n' ' ')$(cat "$folder/log")"
    fi
}

test_tool() { # TREE MPI RANKS...
    local tree=$1 mpi=$2 words n
    shift 2
    for n; do
        for words in "" "big number tail" "double shuffled before" "polygons normals" "codes polygons tail" "nan big polygons normals"; do
            # shellcheck disable=SC2086  # a list of words
            python3 tests/mpi/make_file.py "$scratch/made.ply" 40 $words
            same_file "PLY ${words:-plain}" "$mpi" "$tree" "$n" "$scratch/made.ply"
        done
        for words in "flat shuffled" "double fins flat nan normals" "polygons fins flat tail before number"; do
            # shellcheck disable=SC2086
            python3 tests/mpi/make_file.py "$scratch/made.ply" 30 $words
            same_file "creases, PLY $words" "$mpi" "$tree" "$n" "$scratch/made.ply" --crease 30
            same_file "creases, PLY $words, by area" "$mpi" "$tree" "$n" "$scratch/made.ply" --crease 75 --weight area --non-manifold smooth
        done
        same_file "creases, not welded" "$mpi" "$tree" "$n" "$scratch/made.ply" --crease 60 --weld none
        same_file "creases, within a distance, most visible" "$mpi" "$tree" "$n" "$scratch/made.ply" --crease 60 --weld 0.1 --weight visible
        python3 tests/mpi/make_file.py "$scratch/made.ply" 190 short shuffled
        same_file "creases, corners that get wider" "$mpi" "$tree" "$n" "$scratch/made.ply" --crease 30
        python3 tests/mpi/make_file.py "$scratch/made.ply" 40
        same_file "PLY by area, not welded" "$mpi" "$tree" "$n" "$scratch/made.ply" --weight area --weld none
        same_file "PLY, within a distance" "$mpi" "$tree" "$n" "$scratch/made.ply" --weld 0.2
        for words in stl "stl nan"; do
            # shellcheck disable=SC2086
            python3 tests/mpi/make_file.py "$scratch/made.stl" 40 $words
            same_file "$words" "$mpi" "$tree" "$n" "$scratch/made.stl"
        done
    done
    python3 tests/mpi/make_file.py "$scratch/a.ply" 60
    refused "a file that is shorter on one rank" "$mpi" "$tree" "all ranks must see one file" 'cd "$(as_rank 2 ../there .)"; norma-mpi compute a.ply -o out.ply'
    refused "a file that is too short" "$mpi" "$tree" "too short" 'norma-mpi compute ../there/a.ply -o out.ply'
    refused "ranks that disagree on the weight" "$mpi" "$tree" "a.ply: " 'norma-mpi compute a.ply -o out.ply --weight "$(as_rank 1 area angle)"'
    refused "ranks that disagree on the crease" "$mpi" "$tree" "different options" 'norma-mpi compute a.ply -o out.ply --crease "$(as_rank 1 30 40)"'
    refused "one rank of three cuts at creases" "$mpi" "$tree" "different options" 'norma-mpi compute a.ply -o out.ply $(as_rank 1 "--crease 30" "")'
    for words in "3, 1, -1, 3" "3, 1, 2, 4" "-1, 1, 2, 3"; do # the second face: its count and its vertices
        python3 -c 'import struct, sys; open(sys.argv[1], "wb").write(b"ply\nformat binary_little_endian 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 2\nproperty list char int vertex_indices\nend_header\n" + struct.pack("<12fb3ib3i", 0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 1, 3, 0, 1, 2, *map(int, sys.argv[2].split(", "))))' "$scratch/bad.ply" "$words"
        said=$("$tree/bin/norma" compute "$scratch/bad.ply" -o "$scratch/out.ply" 2>&1)
        refused "a second face of ($words), as norma says it" "$mpi" "$tree" "bad.ply:byte${said#*:byte}" 'norma-mpi compute ../../bad.ply -o out.ply'
    done
    refused "ranks that disagree on the output" "$mpi" "$tree" "other paths" 'norma-mpi compute a.ply -o "$(as_rank 1 other.ply out.ply)"'
    python3 -c 'import sys; data = open(sys.argv[1], "rb").read(); open(sys.argv[2], "wb").write(data.replace(b"element vertex", b"element empty 5\nelement\tbare 2\nelement vertex", 1))' "$scratch/a.ply" "$scratch/made.ply"
    same_file "PLY with elements without properties, and a tab" "$mpi" "$tree" 2 "$scratch/made.ply"
    check "$mpi: the source is no output" bash -c '. tests/mpi/launch.bash; cp "$1" "$2" && ln -f "$2" "$3" && ! ranks "$0" 2 "$0/bin/norma-mpi" compute "$2" -o "$3" 2>"$4" && grep -q "this is the input" "$4" && cmp "$1" "$2"' "$tree" "$scratch/a.ply" "$scratch/source.ply" "$scratch/link.ply" "$scratch/log"
    python3 tests/mpi/make_file.py "$scratch/a.ply" 480 # so large that MPI's own files stay below the limit
    refused "a rank that cannot write all of its slice" "$mpi" "$tree" "out.ply: cannot be written" 'trap "" XFSZ; ulimit -f "$(as_rank 2 6000 unlimited)"; exec norma-mpi compute a.ply -o out.ply'
    check "$mpi: the example of a solver's seams" bash -c '. tests/mpi/launch.bash; ranks "$0" 4 "$0/examples/solver_seams" | tee "$1" | grep -q "norma_mpi_vertex_normals: *0.0 %" && ! grep -q "by itself: *0.0 %" "$1"' "$tree" "$scratch/seams"
    if [ -x "$tree/examples/petsc_seams" ]; then
        check "$mpi: the example with PETSc has the same bits on 1, 2 and 5 ranks" bash -c '. tests/mpi/launch.bash; for n in 1 2 5; do ranks "$0" "$n" "$0/examples/petsc_seams"; done >"$1" && [ "$(grep "norma_mpi_vertex_normals: *0.0 %" "$1" | sort | uniq -c | awk "{print \$1}")" = 3 ] && [ "$(grep "by itself" "$1" | sort -u | wc -l)" = 3 ]' "$tree" "$scratch/petsc"
    fi
}

if [ -n "${NORMA_MPI_LONG:-}" ]; then
    for mpi in openmpi mpich; do
        if ! command -v "mpicc.$mpi" >/dev/null; then
            skip "$mpi is not installed"
            continue
        fi
        made=$root/build/mpi/$mpi
        mkdir -p "$made"
        check "$mpi: builds without a warning" bash -c 'cmake -S . -B "$0" -G Ninja -DNORMA_WERROR=ON -DNORMA_TESTS=ON -DNORMA_WEB=OFF -DNORMA_WITH_RENDER=OFF -DNORMA_WITH_MPI=ON -DMPI_C_COMPILER="mpicc.$1" -DMPIEXEC_EXECUTABLE="$(command -v mpirun."$1")" -DCMAKE_BUILD_TYPE=Release && cmake --build "$0" --target norma-cli norma-mpi-all' "$made" "$mpi"
        test_tree "$made" "$mpi" 400 1 2 3 4 5 8 13 16
        test_tool "$made" "$mpi" 1 2 5 16
        for way in slices random; do
            for n in 1 2 4 16; do
                check "$mpi, $n ranks, $way: 40 bytes of scratch memory for a triangle, each vote sent once" bash -c '. tests/mpi/launch.bash; LIMIT=300 ranks "$0" "$1" "$0/tests/mpi_table" "$2" 1000000 >"$3"' "$made" "$n" "$way" "$scratch/table"
                sed "s/^/# $mpi: /" "$scratch/table"
            done
        done
    done
elif [ -x "$tree/tests/mpi_bits" ]; then
    test_tree "$tree" MPI 60 1 2 5
    test_tool "$tree" MPI 3
else
    skip "MPI (the tree was built without it: Debian's libopenmpi-dev)"
fi
finish
