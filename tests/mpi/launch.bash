# shellcheck shell=bash
# Sourced: how programs are run on several ranks of this machine, more than it has cores, by root too.
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_rmaps_base_oversubscribe=1 OMPI_MCA_mpi_yield_when_idle=1
export OMPI_MCA_btl_vader_single_copy_mechanism=none OMPI_MCA_btl_base_warn_component_unused=0

# ranks TREE N COMMAND...: with the launcher of the MPI that the tree was built with. What hangs ends after LIMIT seconds (120).
ranks() {
    local launcher
    launcher=$(sed -n 's/^MPIEXEC_EXECUTABLE:[A-Z]*=//p' "$1/CMakeCache.txt")
    timeout --kill-after=10 "${LIMIT:-120}" "$launcher" -n "$2" "${@:3}"
}
