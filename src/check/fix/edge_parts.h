/* edge_parts.h: edges by the exact positions of their ends, and the parts that faces joined by them
 * make. */
#ifndef NORMA_MEND_PARTS_H
#define NORMA_MEND_PARTS_H
#include "core/mesh/input_mesh.h"

typedef struct mend_edge {
    double a[3], b[3];   /* its ends, the lesser first */
    uint32_t face, mesh; /* whose it is: the caller's numbers */
    int way;             /* from a to b */
} mend_edge;

/* By x, then y, then z: below, equal to or above 0. */
int norma_mend_compare_points(const double a[3], const double b[3]);
/* Of mend_edge, for qsort: by their ends, then by mesh. */
int norma_mend_compare_edges(const void *a, const void *b);
/* A face's edges between finite positions that differ, numbered as given. edges: room for one for
 * each of its corners. Returns how many. */
size_t norma_mend_face_edges(const core_mesh *mesh, size_t face, uint32_t face_number,
    uint32_t mesh_number, mend_edge *edges);

/* parents: of each face one of the same part, itself where none is less. Returns the least;
 * shortens the way to it. */
uint32_t norma_mend_root(uint32_t *parents, uint32_t face);
void norma_mend_unite(uint32_t *parents, uint32_t one, uint32_t other);
#endif
