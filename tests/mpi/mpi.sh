#!/bin/bash
# libnorma-mpi and norma-mpi: the same bits as one process on any number of ranks, and one rank's faults. `make test` runs a short part with the MPI of the tree;
# `make mpi` sets NORMA_MPI_LONG and builds and tests with Open MPI and MPICH, on 1 to 16 ranks.
# shellcheck source=tests/support/tap.sh
source "$(dirname "$0")/../support/tap.sh"
# shellcheck source=tests/mpi/launch.sh
source "$(dirname "$0")/launch.sh"
cd "$root" || exit 1

# test_tree TREE MPI COUNT RANKS...: COUNT meshes on each number of ranks.
test_tree() {
    local tree=$1 mpi=$2 count=$3 n
    shift 3
    for n; do
        check "$mpi, $n ranks: $count meshes in random parts have the bits of one process" ranks "$tree" "$n" "$tree/tests/mpi_bits" "$((n * 1000))" "$count"
    done
    check "$mpi, 3 ranks: large meshes, in several rounds" ranks "$tree" 3 "$tree/tests/mpi_bits" 70 "$((count / 10 + 1))" 60000
    for n in 1 4; do
        ranks "$tree" "$n" "$tree/tests/mpi_faults" >"$scratch/faults.tap" 2>"$scratch/faults.err"
        grep -E '^(not )?ok ' "$scratch/faults.tap" >"$scratch/lines"
        while read -r result _ _ name; do
            case $result in ok) pass "$mpi, $n ranks: $name" ;; *) fail "$mpi, $n ranks: ${name#- }" "$(cat "$scratch/faults.tap")" ;; esac
        done < <(sed 's/^not ok/notok/' "$scratch/lines")
        check "$mpi, $n ranks: all faults were tried" grep -qx "1..$(wc -l <"$scratch/lines")" "$scratch/faults.tap"
    done
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
    done
elif [ -x "$tree/tests/mpi_bits" ]; then
    test_tree "$tree" MPI 60 1 2 5
else
    skip "MPI (the tree was built without it: Debian's libopenmpi-dev)"
fi
finish
