/* rings.h: every ring of a surface, visited in parallel. */
#ifndef NORMA_CORE_RINGS_H
#define NORMA_CORE_RINGS_H
#include "output.h"
#include "ring.h"

typedef enum core_join { CORE_JOIN_ALL = 0, CORE_JOIN_FANS } core_join;
typedef struct rings_part { core_tally tally; ring_counts counts; } rings_part;

/* Sees each position at which there are corners once, its fans joined and summed. What it adds to part is summed over all. */
typedef void ring_visitor(void *context, core_ring *ring, core_tally *tally);

/* counting: whether edges are counted. skip: NULL, or nonzero at positions that are passed over. sum: what all visits added up to. MEMORY or CANCELLED: some
 * were not made. */
norma_result norma_core_visit_rings(core_surface *surface, core_join join, int counting, const uint8_t *skip, ring_visitor *visit, void *context, rings_part *sum);

/* The same for one position, in order, in a ring that has room for any position of the surface. */
void norma_core_make_ring(const core_surface *surface, core_join join, uint32_t position, ring_counts *counts, core_ring *ring);
#endif
