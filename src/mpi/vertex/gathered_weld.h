/* gathered_weld.h: which positions of all ranks are one by a distance. */
#ifndef NORMA_MPI_GATHERED_WELD_H
#define NORMA_MPI_GATHERED_WELD_H
#include "core/mesh/input_mesh.h"
#include "mpi/exchange/exchange.h"

/* Collective. *groups: of each position here a number that those that are one have in common; to be
 * released by the caller. NULL on an error. */
norma_result norma_mpi_weld_gathered(mpi_call *call, const core_mesh *mesh, uint64_t **groups);
#endif
