#!/bin/bash
# libnorma-mpi and norma-mpi: the same bits as one process on any number of ranks, and one rank's faults. `make test` runs a short part with the MPI of the tree;
# `make mpi` sets NORMA_MPI_LONG and builds and tests with Open MPI and MPICH, on 1 to 16 ranks; the tables of docs/mpi.md are then in build/mpi/tables.md.
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
# shellcheck source=tests/mpi/launch.bash
source "$(dirname "$0")/launch.bash"
cd "$root" || exit 1

# meshes_of MPI RANKS COUNT: fewer with MPICH where ranks outnumber cores: who waits there does not give way, so each message takes a time slice.
meshes_of() { if [ "$1" != mpich ] || [ "$2" -le "$(nproc)" ]; then echo "$3"; else echo $(($3 / 20)); fi; }

# same_bits TREE MPI RANKS COUNT KIND: that many meshes of the kind (mpi_bits.c), each in parts of its own.
same_bits() {
    check "$2, $3 ranks: $4 meshes in parts ($5) have the bits of one process" env LIMIT=300 bash -c '. tests/mpi/launch.bash; ranks "$@"' _ "$1" "$3" "$1/tests/mpi_bits" "$(($3 * 1000))" "$4" 400 "$5"
}

# test_tree TREE MPI COUNT: several rounds, and each allocation of a rank failing.
test_tree() {
    local tree=$1 mpi=$2 n meshes
    meshes=$(($3 / 10 + 1))
    [ "$mpi" != mpich ] || [ "$(nproc)" -ge 3 ] || meshes=4
    check "$mpi, 3 ranks: $meshes large meshes, in several rounds" env LIMIT=300 bash -c '. tests/mpi/launch.bash; ranks "$@"' _ "$tree" 3 "$tree/tests/mpi_bits" 70 "$meshes" 60000
    for n in 1 3; do
        LIMIT=300 relay "$mpi, $n ranks" ranks "$tree" "$n" "$tree/tests/mpi_faults"
    done
}

# bits_table TREE MPI: all kinds of parts on 1 to 16 ranks; a row for each kind, with the number of meshes that had the same bits.
bits_table() {
    local tree=$1 mpi=$2 kind n row meshes failed
    printf '\n| meshes with the same bits, %s | 1 rank | 2 | 3 | 4 | 5 | 8 | 13 | 16 |\n|---|---|---|---|---|---|---|---|---|\n' "$mpi" >>"$tables"
    for kind in random slices isolated one-rank half-empty seams soup; do
        row="| $kind |"
        for n in 1 2 3 4 5 8 13 16; do
            meshes=$(meshes_of "$mpi" "$n" 60)
            failed=$tap_failed
            same_bits "$tree" "$mpi" "$n" "$meshes" "$kind"
            if [ "$tap_failed" = "$failed" ]; then row+=" $meshes |"; else row+=" differ |"; fi
        done
        echo "$row" >>"$tables"
    done
}

# library_table TREE MPI: a grid of a million triangles in slices and in random parts: bytes sent, memory, time.
library_table() {
    local tree=$1 mpi=$2 way n
    printf '\n| norma_mpi_vertex_normals, %s | positions | bytes sent | votes sent | scratch memory | seconds |\n|---|---|---|---|---|---|\n' "$mpi" >>"$tables"
    for way in slices random; do
        for n in 1 2 4 8 16; do
            [ "$way $n" != "random 1" ] || continue
            check "$mpi, $n ranks, $way: 40 bytes of scratch memory for a triangle, each vote sent once" bash -c '. tests/mpi/launch.bash; LIMIT=300 ranks "$0" "$1" "$0/tests/mpi_table" "$2" 1000000 >"$3"' "$tree" "$n" "$way" "$scratch/table"
            cat "$scratch/table" >>"$tables"
        done
    done
}

# tool_table TREE MPI: norma-mpi compute over files of a million triangles, in rows and shuffled: all memory that a rank asks for, by triangle of its own, and time. With more ranks, blocks of fixed size would count.
tool_table() {
    local tree=$1 mpi=$2 words file options n from memory
    printf '\n| norma-mpi compute, %s | bytes of memory | seconds |\n|---|---|---|\n' "$mpi" >>"$tables"
    for words in "" shuffled; do
        file=$scratch/million${words:+-$words}.ply
        # shellcheck disable=SC2086  # no word, or one
        [ -f "$file" ] || python3 tests/mpi/make_file.py "$file" 708 ridges $words
        for n in 1 2 4; do
            from=${EPOCHREALTIME/./}
            memory=$(LIMIT=300 ranks "$tree" "$n" "$tree/bin/norma-mpi" compute "$file" -o "$scratch/million.out.ply" --json 2>"$scratch/log" | sed -n 's/.*"most_memory_of_a_rank": \([0-9]*\).*/\1/p')
            python3 -c 'import sys; print("| %s, %s %s | %.0f | %.1f |" % (sys.argv[1] or "rows", sys.argv[2], "rank" if sys.argv[2] == "1" else "ranks", float(sys.argv[3] or "nan") * int(sys.argv[2]) / 999698, float(sys.argv[4]) / 1e6))' \
                "$words" "$n" "$memory" "$((${EPOCHREALTIME/./} - from))" >>"$tables"
            [ -n "$words$memory" ] || cat "$scratch/log"
            # Rows alone: how much of a shuffled file's faces are near depends on the number of ranks.
            [ -n "$words" ] || check "$mpi, $n ranks: 54 bytes of memory for a triangle, the slice and the result included" test "$((${memory:-1000000000} * n))" -le "$((54 * 999698))"
        done
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

# killed WHEN MPI TREE RANK WAIT: SIGKILL hits the rank once WAIT succeeds: no rank hangs, and the output is the old one or, if all was done by then, the whole new one.
# Unless rank 0 is hit, which makes it, no temporary file of ours is left either.
killed() {
    local folder=$scratch/killed status from tries hit=0 left bad=""
    for tries in 1 2 3 4 5; do
        rm -rf "$folder"
        mkdir -p "$folder"
        echo old >"$folder/out.ply"
        status=0
        from=$SECONDS
        (cd "$folder" && export WAIT=$5 && PATH=$3/bin:$PATH LIMIT=60 ranks "$3" 3 bash -c "$AS_RANK"'; if [ "$(as_rank '"$4"' yes no)" = yes ]; then (while kill -0 $$ && ! eval "$WAIT"; do :; done; kill -KILL $$) 2>/dev/null & fi; exec norma-mpi compute ../a.ply -o out.ply --quiet') >"$scratch/log" 2>&1 || status=$?
        for _ in {1..50}; do # the guard has seen the end of the rank that it watches, or will
            left=$(cd "$folder" && find . -name ".norma-*.tmp" -o -name ".out.ply.*" ! -name "*.lock") # Open MPI's own, of the rank that was killed
            [ -n "$left" ] || break
            sleep 0.1
        done
        [ -z "$left" ] || bad="left behind: $left"
        # Open MPI's launcher may itself wait for ever where a rank dies while it joins: its own error, before a line of ours has run.
        if [ $((SECONDS - from)) -ge 60 ] && grep -q "PMIX ERROR" "$scratch/log"; then continue; fi
        [ $((SECONDS - from)) -lt 60 ] || bad="it hung"
        if cmp -s "$folder/out.ply" "$scratch/a.done.ply"; then continue; fi # too late
        if [ "$(cat "$folder/out.ply")" = old ] && [ "$status" != 0 ]; then hit=1; else bad="status $status, another output"; fi
        break
    done
    if [ -n "$bad" ]; then fail "$2: rank $4 is killed $1" "$bad: $(tail -5 "$scratch/log")"; elif [ $hit = 0 ]; then skip "$2: rank $4 is killed $1 (it was always done by then)"; else pass "$2: rank $4 is killed $1"; fi
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
        for words in "flat shuffled" "double fins flat nan normals" "polygons fins flat tail before number" "short shuffled polygons"; do
            # shellcheck disable=SC2086
            python3 tests/mpi/make_file.py "$scratch/made.ply" 30 $words
            same_file "PLY $words" "$mpi" "$tree" "$n" "$scratch/made.ply"
        done
        same_file "PLY, most visible, within a distance" "$mpi" "$tree" "$n" "$scratch/made.ply" --weld 0.1 --weight visible
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
    refused "a file that is too short" "$mpi" "$tree" "the file ends" 'norma-mpi compute ../there/a.ply -o out.ply'
    refused "ranks that disagree on the weight" "$mpi" "$tree" "a.ply: " 'norma-mpi compute a.ply -o out.ply --weight "$(as_rank 1 area angle)"'
    for words in "3, 1, -1, 3" "3, 1, 2, 4" "-1, 1, 2, 3"; do # the second face: its count and its vertices
        python3 -c 'import struct, sys; open(sys.argv[1], "wb").write(b"ply\nformat binary_little_endian 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 2\nproperty list char int vertex_indices\nend_header\n" + struct.pack("<12fb3ib3i", 0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 1, 3, 0, 1, 2, *map(int, sys.argv[2].split(", "))))' "$scratch/bad.ply" "$words"
        said=$("$tree/bin/norma" compute "$scratch/bad.ply" -o "$scratch/out.ply" 2>&1)
        refused "a second face of ($words), as norma says it" "$mpi" "$tree" "bad.ply:byte${said#*:byte}" 'norma-mpi compute ../../bad.ply -o out.ply'
    done
    refused "ranks that disagree on the output" "$mpi" "$tree" "other paths" 'norma-mpi compute a.ply -o "$(as_rank 1 other.ply out.ply)"'
    python3 -c 'import sys; data = open(sys.argv[1], "rb").read(); open(sys.argv[2], "wb").write(data.replace(b"element vertex", b"element empty 5\nelement\tbare 2\nelement vertex", 1))' "$scratch/a.ply" "$scratch/made.ply"
    same_file "PLY with elements without properties, and a tab" "$mpi" "$tree" 2 "$scratch/made.ply"
    # Two triangles with an edge in common, one on each of two ranks, which read two of the four vertices each. By hand: each rank asks for one vertex (4 bytes) and gets it (12); of the
    # edge's two positions, one of the two ranks is the home, so the other one sends it (12, and 1 for its part), its vote (36) and a question (4), and gets an answer (4) and a normal (13).
    python3 -c 'import struct, sys; open(sys.argv[1], "wb").write(b"ply\nformat binary_little_endian 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n" + struct.pack("<12f", 0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 1) + struct.pack("<B3iB3i", 3, 0, 1, 2, 3, 1, 3, 2))' "$scratch/two.ply"
    for words in "1 0 0 0 0 0" "2 32 34 72 34 512"; do
        read -r n sent[0] sent[1] sent[2] sent[3] sent[4] <<<"$words"
        check "$mpi, $n ranks: the bytes that are sent, counted by hand" bash -c '. tests/mpi/launch.bash; ranks "$0" "$1" "$0/bin/norma-mpi" compute "$2" -o "$3" --json | tee "$3.json" | grep -qF "\"sent\": {\"positions\": $4, \"homes\": $5, \"votes\": $6, \"normals\": $7, \"cells\": $8, \"other\": 0}"' \
            "$tree" "$n" "$scratch/two.ply" "$scratch/out.ply" "${sent[@]}"
    done
    check "$mpi: an output that is replaced keeps its permissions" bash -c '. tests/mpi/launch.bash; echo old >"$2" && chmod 604 "$2" && ranks "$0" 2 "$0/bin/norma-mpi" compute "$1" -o "$2" --quiet && [ "$(stat -c %a "$2")" = 604 ] && [ "$(head -c 3 "$2")" = ply ]' "$tree" "$scratch/a.ply" "$scratch/kept.ply"
    check "$mpi: the source is no output" bash -c '. tests/mpi/launch.bash; cp "$1" "$2" && ln -f "$2" "$3" && ! ranks "$0" 2 "$0/bin/norma-mpi" compute "$2" -o "$3" 2>"$4" && grep -q "this is the input" "$4" && cmp "$1" "$2"' "$tree" "$scratch/a.ply" "$scratch/source.ply" "$scratch/link.ply" "$scratch/log"
    python3 tests/mpi/make_file.py "$scratch/a.ply" 480 # so large that MPI's own files stay below the limit
    refused "a rank that cannot write all of its slice" "$mpi" "$tree" "out.ply: cannot be written" 'trap "" XFSZ; ulimit -f "$(as_rank 2 6000 unlimited)"; exec norma-mpi compute a.ply -o out.ply'
    "$tree/bin/norma" compute "$scratch/a.ply" -o "$scratch/a.done.ply" --quiet
    for n in 0 2; do
        killed "at the start" "$mpi" "$tree" "$n" 'sleep 0.1'
        killed "while it reads or computes" "$mpi" "$tree" "$n" 'readlink /proc/$$/fd/* | grep -q "/a.ply$"'
        killed "while the output is written" "$mpi" "$tree" "$n" 'compgen -G ".norma-*.tmp" >/dev/null'
    done
    check "$mpi: the example of a solver's seams" bash -c '. tests/mpi/launch.bash; ranks "$0" 4 "$0/examples/solver_seams" | tee "$1" | grep -q "norma_mpi_vertex_normals: *0.0 %" && ! grep -q "by itself: *0.0 %" "$1"' "$tree" "$scratch/seams"
    if [ "$mpi" != mpich ] && ldd "$tree/lib/libnorma-mpi.so" | grep -q libmpi.so.40 && /usr/bin/python3 -c 'import mpi4py' 2>/dev/null; then # Debian's is built with Open MPI
        for n in 1 2 3 5; do ranks "$tree" "$n" /usr/bin/python3 examples/mpi/mpi4py_seams.py "$tree/lib/libnorma-mpi.so"; done >"$scratch/mpi4py" 2>&1
        check "$mpi: the example with mpi4py: exact normals, the same bits on 1, 2, 3 and 5 ranks" bash -c '[ "$(grep "^norma_mpi_vertex_normals: *worst *0.0000" "$0" | sort | uniq -c | awk "{print \$1}")" = 4 ]' "$scratch/mpi4py"
        check "$mpi: and plain sums are wrong, by degrees, differently on each" bash -c '[ "$(grep -cE "^sums .* worst +[2-9]\." "$0")" = 4 ] && [ "$(grep "^sums" "$0" | sort -u | wc -l)" = 4 ]' "$scratch/mpi4py"
        for n in 1 2 3 5; do ranks "$tree" "$n" /usr/bin/python3 examples/mpi/mpi4py_seams.py "$tree/lib/libnorma-mpi.so" assets/goathead.obj; done >"$scratch/mpi4py.model" 2>&1
        check "$mpi: the example with mpi4py, a model: exact normals, the same bits on 1, 2, 3 and 5 ranks" bash -c '[ "$(grep "^norma_mpi_vertex_normals: *worst *0.0000" "$0" | sort | uniq -c | awk "{print \$1}")" = 4 ]' "$scratch/mpi4py.model"
        check "$mpi: and what ranks sum alone is wrong by 7.6 degrees and more, unless one rank has all; the mean of ranks as well" awk '/alone:/ {one++; if ($(NF - 1) >= 7.6) far++} /^mean/ {for (i = 1; i < NF; i++) if ($i == "worst" && $(i + 1) >= 7.6) mean++} END {exit !(one == 4 && far == 3 && mean == 3)}' "$scratch/mpi4py.model"
    else
        skip "$mpi: the example with mpi4py (Debian's python3-mpi4py, for Open MPI)"
    fi
    for words in vtk vtu xdmf; do
        if ! /usr/bin/python3 -c 'import meshio, sys; (sys.argv[1] == "xdmf") and __import__("h5py")' $words 2>/dev/null; then
            skip "$mpi: the example with meshio, $words (Debian's python3-meshio and python3-h5py)"
            continue
        fi
        check "$mpi: the example with meshio, $words: a sphere's normals, all else as it was" bash -c '. tests/mpi/launch.bash; launcher=$(sed -n "s/^MPIEXEC_EXECUTABLE:[A-Z]*=//p" "$0/CMakeCache.txt"); /usr/bin/python3 tests/mpi/meshio_cases.py examples/mpi/with_meshio.py "$1" "$2" "$launcher" -n 2 "$0/bin/norma-mpi" compute' "$tree" "$scratch" $words
    done
    if [ -x "$tree/examples/petsc_seams" ]; then
        check "$mpi: the example with PETSc has the same bits on 1, 2 and 5 ranks" bash -c '. tests/mpi/launch.bash; for n in 1 2 5; do ranks "$0" "$n" "$0/examples/petsc_seams"; done >"$1" && [ "$(grep "norma_mpi_vertex_normals: *0.0 %" "$1" | sort | uniq -c | awk "{print \$1}")" = 3 ] && [ "$(grep "by itself" "$1" | sort -u | wc -l)" = 3 ]' "$tree" "$scratch/petsc"
    fi
}

if [ -n "${NORMA_MPI_LONG:-}" ]; then
    tables=$root/build/mpi/tables.md
    mkdir -p "$root/build/mpi"
    echo "$(date +%Y-%m-%d), $(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -1), $(nproc) cores; with more ranks than cores, ranks take turns" >"$tables"
    for mpi in openmpi mpich; do
        if ! command -v "mpicc.$mpi" >/dev/null; then
            skip "$mpi is not installed"
            continue
        fi
        made=$root/build/mpi/$mpi
        mkdir -p "$made"
        check "$mpi: builds without a warning" bash -c 'cmake -S . -B "$0" -G Ninja -DNORMA_WERROR=ON -DNORMA_TESTS=ON -DNORMA_WEB=OFF -DNORMA_WITH_RENDER=OFF -DNORMA_WITH_MPI=ON -DMPI_C_COMPILER="mpicc.$1" -DMPIEXEC_EXECUTABLE="$(command -v mpirun."$1")" -DCMAKE_BUILD_TYPE=Release && cmake --build "$0" --target norma-cli norma-mpi-all' "$made" "$mpi"
        test_tree "$made" "$mpi" 400
        test_tool "$made" "$mpi" 1 2 5 16
        bits_table "$made" "$mpi"
        library_table "$made" "$mpi"
        tool_table "$made" "$mpi"
    done
elif [ -x "$tree/tests/mpi_bits" ]; then
    for n in 1 2 5; do same_bits "$tree" MPI "$n" 60 any; done
    test_tree "$tree" MPI 60
    test_tool "$tree" MPI 3
else
    skip "MPI (the tree was built without it: Debian's libopenmpi-dev)"
fi
[ -z "${tables:-}" ] || sed 's/^/# /' "$tables"
finish
