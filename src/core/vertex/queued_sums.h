/* queued_sums.h: the sums of large meshes of triangles in no order, by several at once. */
#ifndef NORMA_CORE_VERTEX_QUEUE_H
#define NORMA_CORE_VERTEX_QUEUE_H
#include "core/vertex/add_triangles.h"

/* mesh: the surface's, its positions perhaps copied. sums: of all its positions. *done: 0, and
 * nothing is touched, if there are too few faces for the memory that this takes (not quite 2 bytes
 * for each), or no memory. */
norma_result norma_core_queue_vertices(const core_prepared_mesh *prepared, const core_mesh *mesh,
    vertex_sum *sums, norma_count *degenerate, int *done);
#endif
