/* joined_sets.h: numbers joined into sets (union by the lower number, paths halved: Tarjan, van
 * Leeuwen 1984). joined[i] is a number of the same set, lower or i itself; the lowest of a set is
 * its own. */
#ifndef NORMA_CORE_JOINED_SETS_H
#define NORMA_CORE_JOINED_SETS_H
#include <stdint.h>

/* The lowest number of i's set. */
static inline uint32_t norma_core_set_of(uint32_t *joined, uint32_t i) {
    while (joined[i] != i) i = joined[i] = joined[joined[i]];
    return i;
}

static inline void norma_core_join_sets(uint32_t *joined, uint32_t a, uint32_t b) {
    const uint32_t set_a = norma_core_set_of(joined, a), set_b = norma_core_set_of(joined, b);
    if (set_a < set_b)
        joined[set_b] = set_a;
    else
        joined[set_a] = set_b;
}
#endif
