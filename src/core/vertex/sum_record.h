/* sum_record.h: the sum of the votes at one position, and what becomes of it. */
#ifndef NORMA_CORE_SUM_RECORD_H
#define NORMA_CORE_SUM_RECORD_H
#include "core/corner/prepared_mesh.h"
#include <math.h>

typedef struct vertex_sum {
    double x, y, z, weight;
} vertex_sum; /* weight: -0 as long as nobody votes */

static inline int norma_core_has_votes(const vertex_sum *sum) { return !signbit(sum->weight); }
int norma_core_record_cancels(const vertex_sum *sum);
void norma_core_clear_sums(vertex_sum *sums, size_t count);
void norma_core_add_vote(vertex_sum *sum, double weight, const double normal[3]);

/* One face added by itself: a polygon, or a triangle that doubles do not decide. Corners elsewhere
 * than at the count positions from first on are passed over. The first corner's owner counts the
 * degenerate. */
typedef struct core_face_adder {
    const core_prepared_mesh *prepared;
    vertex_sum *sums;
    uint32_t first, count;
    norma_count *degenerate;
} core_face_adder;
void norma_core_add_face(void *face_adder, size_t face);

/* Returns NORMA_REASON_NONE and the normal, or the reason why it has no normal. */
int norma_core_resolve_record(
    const core_mesh *mesh, const vertex_sum *sum, size_t vertex, float normal[3]);
#endif
