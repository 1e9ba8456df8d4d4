/* home_sums.h: votes as they travel, and how the home of their positions adds them up. */
#ifndef NORMA_MPI_HOME_SUMS_H
#define NORMA_MPI_HOME_SUMS_H
#include "mpi/vertex/sums.h"

/* The slot, the vote, and where numbered the number of its face. */
static inline size_t norma_mpi_vote_size(int numbered) {
    return sizeof(uint32_t) + 4 * sizeof(double) + (numbered ? sizeof(uint64_t) : 0);
}
void norma_mpi_write_vote(
    unsigned char *record, int numbered, uint32_t slot, uint64_t face, const double vote[4]);

typedef struct mpi_home {
    const mpi_call *call;
    const mpi_lists *in; /* votes of each rank, in ascending number of faces */
    int numbered;        /* else each rank's faces follow those of the rank before */
    uint64_t first;      /* of count slots, which all votes are for */
    size_t count;
    mpi_outcome *outcomes; /* written, of these slots */
} mpi_home;

/* MEMORY, or the outcomes. */
norma_result norma_mpi_sum_at_home(const mpi_home *home);
#endif
