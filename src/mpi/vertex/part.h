/* part.h: this rank's part of the mesh, checked and agreed upon, ready to be summed. */
#ifndef NORMA_MPI_PART_H
#define NORMA_MPI_PART_H
#include "core/call/output.h"
#include "core/corner/prepared_mesh.h"
#include "mpi/exchange/exchange.h"
#include "mpi/vertex/face_order.h"

typedef struct mpi_input {
    const norma_mesh *mesh;
    const uint64_t *vertex_ids, *face_ids;
    float *normals;
    size_t capacity;
} mpi_input;

typedef struct mpi_part {
    core_prepared_mesh prepared;
    int is_prepared;
    core_output output;
    const uint64_t *vertex_ids;
    mpi_face_order faces;
    int numbered; /* ranks' faces mix, so votes carry their numbers */
    int doubles;  /* some rank's positions are doubles */
    uint64_t
        *groups;   /* with NORMA_WELD_DISTANCE: of each position, the same for those that are one */
    size_t budget; /* bytes for lists */
    size_t positions;
} mpi_part;

/* Collective. core: begun by begun, which is agreed upon here. On an error there is nothing to
 * close. */
norma_result norma_mpi_open_part(
    mpi_call *call, norma_result begun, const mpi_input *input, mpi_part *part);
/* *weld: for each of count numbers the first that is equal; NULL where all differ. */
norma_result norma_mpi_weld_numbers(
    core_call *core, const uint64_t *numbers, size_t count, uint32_t **weld);
void norma_mpi_close_part(const mpi_call *call, mpi_part *part);
#endif
