/* exchange.h: what all ranks do together: agreeing on a result, and handing records to each other.
 */
#ifndef NORMA_MPI_EXCHANGE_H
#define NORMA_MPI_EXCHANGE_H
#include "core/call/call.h"
#include <mpi.h>

/* What is sent: positions of a file to the ranks that name them; positions to their homes, and
 * answers; votes; normals, and questions for them; tables of cells; all else. */
typedef enum mpi_cargo {
    MPI_POSITIONS,
    MPI_KEYS,
    MPI_CONTRIBUTIONS,
    MPI_NORMALS,
    MPI_CELLS,
    MPI_OTHERS,
    MPI_CARGOS
} mpi_cargo;

typedef struct mpi_call {
    MPI_Comm comm; /* a copy of the caller's: messages of others never meet ours */
    int rank, ranks;
    core_call *core; /* memory, progress, options */
    /* Bytes that left this rank for others; what ranks agree on is left out. */
    uint64_t sent[MPI_CARGOS];
} mpi_call;

/* Collective. comm: the caller's. End frees the copy. */
norma_result norma_mpi_begin(mpi_call *call, MPI_Comm comm, core_call *core);
void norma_mpi_end(mpi_call *call);

/* Collective: all ranks' numbers become one, in place. */
void norma_mpi_reduce(const mpi_call *call, void *all, int count, MPI_Datatype type, MPI_Op op);
/* Collective: the gravest of all ranks' results, on every rank. */
norma_result norma_mpi_agree(const mpi_call *call, norma_result mine);
/* The same, and each rank's progress is told: one that cancels cancels all. */
norma_result norma_mpi_step(mpi_call *call, double fraction, norma_result mine);

/* Collective sums, and the largest and the least, over all ranks. */
uint64_t norma_mpi_sum(const mpi_call *call, uint64_t mine);
uint64_t norma_mpi_largest(const mpi_call *call, uint64_t mine);
uint64_t norma_mpi_least(const mpi_call *call, uint64_t mine);
/* Collective: of the ranks before this one; 0 for the first. */
uint64_t norma_mpi_sum_before(const mpi_call *call, uint64_t mine);
uint64_t norma_mpi_largest_before(const mpi_call *call, uint64_t mine);
/* Collective: whether count numbers are the same everywhere. */
int norma_mpi_all_equal(const mpi_call *call, const uint64_t *numbers, size_t count);

/* Records of one size for each rank. */
typedef struct mpi_lists {
    unsigned char *bytes;
    size_t capacity, record; /* bytes of all, and of one */
    int *counts, *starts;    /* of each rank, in records; starts has the end as well */
} mpi_lists;

/* room: records for each rank at most. OVERFLOW where all together are too many for a message. On
 * an error there is nothing to close. */
norma_result norma_mpi_lists_open(
    const mpi_call *call, const uint64_t *room, size_t record, mpi_lists *lists);
/* As many records as shape has, of another size. */
norma_result norma_mpi_lists_like(
    const mpi_call *call, const mpi_lists *shape, size_t record, mpi_lists *lists);
void norma_mpi_lists_close(const mpi_call *call, mpi_lists *lists);
static inline unsigned char *norma_mpi_record(const mpi_lists *lists, size_t index) {
    return lists->bytes + index * lists->record;
}
/* The next one for a rank. */
static inline unsigned char *norma_mpi_lists_add(mpi_lists *lists, int rank) {
    return norma_mpi_record(lists, (size_t)lists->starts[rank] + (size_t)lists->counts[rank]++);
}
static inline size_t norma_mpi_lists_total(const mpi_call *call, const mpi_lists *lists) {
    size_t sum = 0;
    for (int r = 0; r < call->ranks; ++r) sum += (size_t)lists->counts[r];
    return sum;
}

/* Collective: opens in, and fills it with what the ranks have for this one, in the order of ranks.
 * mine: the result so far, agreed on first. On an error in is closed. */
norma_result norma_mpi_exchange(
    mpi_call *call, mpi_cargo cargo, norma_result mine, const mpi_lists *out, mpi_lists *in);
/* Collective: answers, of the shape of what was received, go back into the shape of what was sent.
 */
void norma_mpi_answer(mpi_call *call, mpi_cargo cargo, const mpi_lists *answers, mpi_lists *in);
#endif
