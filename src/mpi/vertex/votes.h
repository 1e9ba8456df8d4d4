/* votes.h: the votes of faces, one after the other. */
#ifndef NORMA_MPI_VOTES_H
#define NORMA_MPI_VOTES_H
#include "core/corner/prepared_mesh.h"
#include "mpi/vertex/face_order.h"

typedef struct mpi_visit {
    const core_prepared_mesh *prepared;
    const mpi_face_order *faces;
    int (*wants)(const void *context, size_t face);
    void (*vote)(void *context, size_t face, size_t corner, double weight, const double normal[3]);
    void (*degenerate)(void *context, size_t face); /* positions finite, no direction */
    void *context;
} mpi_visit;

/* The votes of the faces that are wanted, in ascending number of faces and corners: the numbers
 * that norma_vertex_normals adds. For the most visible normal all weigh 1. */
void norma_mpi_visit_votes(const mpi_visit *visit);
#endif
