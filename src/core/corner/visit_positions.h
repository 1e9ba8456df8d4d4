/* visit_positions.h: every star of a prepared, visited in parallel. */
#ifndef NORMA_CORE_STARS_H
#define NORMA_CORE_STARS_H
#include "core/corner/corner_sort.h"
#include "core/call/call.h"

typedef enum core_join { CORE_JOIN_ALL = 0, CORE_JOIN_FANS } core_join;
typedef struct stars_part {
    core_tally tally;
    star_counts counts;
    size_t waiting;
} stars_part;

/* What becomes of the corners at one position. */
typedef struct core_fans {
    uint32_t position, count, fan_count;
    const uint32_t *corners; /* ascending */
    const uint32_t *fan_of;  /* of each corner, the number of its fan; NULL with by_fan, and one
                                fan */
    const core_fan *fans;
    star_member *members; /* room for one of each corner */
    core_star *star;      /* with CORE_JOIN_ALL */
} core_fans;

/* Sees each position at which there are corners once, its fans joined and summed. What it adds to
 * tally is summed over all. */
typedef void position_visitor(void *context, const core_fans *fans, core_tally *tally);

typedef struct position_visit {
    core_join join;
    int counting; /* whether edges are counted */
    int by_fan;   /* the fans of a large star may be seen one by one, with nothing but their corners
                   */
    const uint8_t *skip; /* NULL, or nonzero at positions that are passed over */
    position_visitor *see;
    void *context;
    const void
        *target; /* NULL, or where the visitor will write: target_size bytes for each corner */
    size_t target_size;
} position_visit;

/* sum: what all visits added up to, degenerate faces among it. MEMORY or CANCELLED: some were not
 * made. */
norma_result norma_core_visit_positions(
    core_prepared_mesh *prepared, const position_visit *visit, stars_part *sum);

/* large_star.c: stars of very many corners, in little memory, fan by fan; of triangles, all weights
 * but the visible one. */
typedef struct large_star {
    uint64_t *out, *back; /* of each corner: the position at the other end of its edge to next, from
                             previous, and its star number */
    uint32_t *fan;        /* of each corner a lower one of the same fan, or itself */
    size_t room;
} large_star;
norma_result norma_core_large_star_allocate(
    const core_call *call, large_star *large, size_t corners);
void norma_core_large_star_release(const core_call *call, large_star *large);
norma_result norma_core_visit_large_star(const core_prepared_mesh *prepared,
    const position_visit *visit, uint32_t position, large_star *large, stars_part *part);

/* The same for one position, in order, in a star that has room for any position of the surface. */
void norma_core_make_star(const core_prepared_mesh *prepared, core_join join, uint32_t position,
    star_counts *counts, core_star *star);
#endif
