/* missing.h: the vertices that have no normal of their own: counted, and given that of the nearest
 * one that has. */
#ifndef NORMA_MPI_MISSING_H
#define NORMA_MPI_MISSING_H
#include "mpi/vertex/part.h"

/* Collective. reasons: of each position here. Each number counts once, on however many ranks. */
norma_result norma_mpi_count_missing(
    mpi_call *call, const mpi_part *part, const uint8_t *reasons, core_tally *tally);
/* Collective: the tallies of all ranks, added up. */
void norma_mpi_add_tallies(const mpi_call *call, core_tally *tally);

/* Collective: writes to each position with a reason the normal of the nearest position without one,
 * which it reads from the output; zero where there is none anywhere. */
norma_result norma_mpi_fill_nearest(mpi_call *call, const mpi_part *part, const uint8_t *reasons);
#endif
