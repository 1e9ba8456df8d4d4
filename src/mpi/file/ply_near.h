/* ply_near.h: the faces round the positions that are this rank's: those whose class is one of its
 * own vertices. Each is complete here, whoever read its faces. */
#ifndef NORMA_MPI_PLY_NEAR_H
#define NORMA_MPI_PLY_NEAR_H
#include "mpi/file/ply_faces.h"

typedef struct ply_near {
    ply_part part;       /* faces ascend as in the file; corners are places in vertex_ids */
    uint32_t *classes;   /* of each place; places ascend by class, then by vertex */
    uint32_t *origins;   /* of each face: where its corners begin at the rank that read it */
    size_t *face_begins; /* of each rank: the first face here that it read; and the end */
} ply_near;

/* Collective: one exchange of faces. part: faces as they were read, corners numbered as in the
 * file, which are dropped afterwards; classes: of its own vertices. Close in any case. */
int norma_mpi_gather_near(mpi_job *job, const ply_layout *layout, ply_part *part,
    const uint32_t *classes, ply_near *near);
void norma_mpi_close_near(mpi_job *job, ply_near *near);

static inline size_t norma_mpi_places(const ply_near *near) {
    return near->part.own + near->part.others;
}
static inline size_t norma_mpi_corner_begin(const ply_part *part, size_t face) {
    return part->face_starts ? part->face_starts[face] : 3 * face;
}
/* Whether the position at a place is this rank's. */
static inline int norma_mpi_is_mine(const ply_near *near, size_t place) {
    return near->classes[place] - near->part.first < near->part.own;
}
#endif
