/* count.h: the counts of a report, added up from those of parts. */
#ifndef NORMA_CORE_COUNT_H
#define NORMA_CORE_COUNT_H
#include <norma/norma.h>

static inline void norma_core_count_one(norma_count *count, size_t index) {
    if (!count->count || index < count->first) count->first = index;
    count->count++;
}
static inline void norma_core_count_add(norma_count *sum, const norma_count *part) {
    if (!part->count) return;
    if (!sum->count || part->first < sum->first) sum->first = part->first;
    sum->count += part->count;
}
static inline void norma_core_edges_add(norma_edges *sum, const norma_edges *part) {
    sum->count += part->count;
    sum->open += part->open;
    sum->smooth += part->smooth;
    sum->hard += part->hard;
}
#endif
