/* edge_parts.h: edges by the exact positions of their ends, and the parts that faces joined by them
 * make. */
#ifndef NORMA_MEND_PARTS_H
#define NORMA_MEND_PARTS_H
#include "core/mesh/input_mesh.h"

typedef struct fix_edge {
    double a[3], b[3];   /* its ends, the lesser first */
    uint32_t face, mesh; /* whose it is: the caller's numbers */
    int way;             /* from a to b */
} fix_edge;

/* By x, then y, then z: below, equal to or above 0. */
int norma_fix_compare_points(const double a[3], const double b[3]);
/* Of fix_edge, for qsort: by their ends, then by mesh. */
int norma_fix_compare_edges(const void *a, const void *b);
/* A face's edges between finite positions that differ, numbered as given. edges: room for one for
 * each of its corners. Returns how many. */
size_t norma_fix_face_edges(const core_mesh *mesh, size_t face, uint32_t face_number,
    uint32_t mesh_number, fix_edge *edges);

/* parents: of each face one of the same part, itself where none is less. Returns the least;
 * shortens the way to it. */
uint32_t norma_fix_root(uint32_t *parents, uint32_t face);
void norma_fix_unite(uint32_t *parents, uint32_t one, uint32_t other);
#endif
