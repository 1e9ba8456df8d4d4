/* visit_positions.h: every ring of a surface, visited in parallel. */
#ifndef NORMA_CORE_RINGS_H
#define NORMA_CORE_RINGS_H
#include "core/corner/corner_sort.h"
#include "core/mesh/output.h"

typedef enum core_join { CORE_JOIN_ALL = 0, CORE_JOIN_FANS } core_join;
typedef struct rings_part {
    core_tally tally;
    ring_counts counts;
    size_t waiting;
} rings_part;

/* What becomes of the corners at one position. */
typedef struct core_fans {
    uint32_t position, count, fan_count;
    const uint32_t *corners; /* ascending */
    const uint32_t *fan_of;  /* of each corner, the number of its fan, in the order of their first
                                corners; NULL with by_fan, and one fan */
    const core_fan *fans;
    ring_member *members; /* room for one of each corner */
    core_ring *ring;      /* with CORE_JOIN_ALL */
} core_fans;

/* Sees each position at which there are corners once, its fans joined and summed. What it adds to
 * tally is summed over all. */
typedef void ring_visitor(void *context, const core_fans *fans, core_tally *tally);

typedef struct ring_visit {
    core_join join;
    int counting; /* whether edges are counted */
    int by_fan;   /* the fans of a large ring may be seen one by one, with nothing but their corners
                   */
    const uint8_t *skip; /* NULL, or nonzero at positions that are passed over */
    ring_visitor *see;
    void *context;
    const void
        *target; /* NULL, or where the visitor will write: target_size bytes for each corner */
    size_t target_size;
} ring_visit;

/* sum: what all visits added up to, degenerate faces among it. MEMORY or CANCELLED: some were not
 * made. */
norma_result norma_core_visit_rings(
    core_surface *surface, const ring_visit *visit, rings_part *sum);

/* large_star.c: rings of very many corners, in little memory, fan by fan; of triangles, all weights
 * but the visible one. */
typedef struct large_ring {
    uint64_t *out, *back; /* of each corner: the position at the other end of its edge to next, from
                             previous, and its ring number */
    uint32_t *fan;        /* of each corner a lower one of the same fan, or itself */
    size_t room;
} large_ring;
norma_result norma_core_large_ring_allocate(
    const core_call *call, large_ring *large, size_t corners);
void norma_core_large_ring_release(const core_call *call, large_ring *large);
norma_result norma_core_visit_large_ring(const core_surface *surface, const ring_visit *visit,
    uint32_t position, large_ring *large, rings_part *part);

/* The same for one position, in order, in a ring that has room for any position of the surface. */
void norma_core_make_ring(const core_surface *surface, core_join join, uint32_t position,
    ring_counts *counts, core_ring *ring);
#endif
