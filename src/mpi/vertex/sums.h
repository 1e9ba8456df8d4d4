/* sums.h: the sum at each position, each in ascending number of faces, wherever they are. */
#ifndef NORMA_MPI_SUMS_H
#define NORMA_MPI_SUMS_H
#include "core/vertex/sum_record.h"
#include "mpi/vertex/face_order.h"
#include "mpi/vertex/sharing.h"

/* What became of a slot. */
typedef struct mpi_outcome {
    float normal[3];
    uint32_t reason; /* UNREFERENCED where nobody votes */
} mpi_outcome;

typedef struct mpi_sums {
    const core_prepared_mesh *prepared;
    const mpi_face_order *faces;
    const uint32_t *merge; /* NULL, or for each position the one that stands for it in sharing */
    const mpi_sharing *sharing;
    int numbered;            /* contributions carry the numbers of their faces */
    norma_count *degenerate; /* NULL: they are not counted */
    vertex_sum *own;         /* of the sums that are taken here */
    mpi_outcome *outcomes;   /* of the slots of this rank */
} mpi_sums;

/* Collective. The caller sets all but own and outcomes. On an error there is nothing to close. */
norma_result norma_mpi_sum_all(mpi_call *call, size_t budget, mpi_sums *sums);
void norma_mpi_sums_close(const mpi_call *call, mpi_sums *sums);

/* Collective: what became of each position that takes part, in sharing's terms, some at a time.
 * reason: UNREFERENCED also where the position is not finite. */
typedef void mpi_receiver(void *context, size_t position, int reason, const float normal[3]);
norma_result norma_mpi_hand_out(
    mpi_call *call, const mpi_sums *sums, size_t budget, mpi_receiver *receive, void *context);

/* What becomes of a sum. */
int norma_mpi_resolve(const vertex_sum *sum, float normal[3]);
#endif
