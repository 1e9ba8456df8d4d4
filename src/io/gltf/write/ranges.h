/* ranges.h: sets of bytes in a buffer, each part from start up to end. */
#ifndef NORMA_IO_GLTF_RANGES_H
#define NORMA_IO_GLTF_RANGES_H
#include <stddef.h>

typedef struct range {
    size_t start, end;
} range;

typedef struct ranges {
    range *list;
    size_t count, capacity;
    int failed;
} ranges;

void norma_range_add(ranges *r, size_t start, size_t end); /* nothing where it is empty */
void norma_ranges_merge(ranges *r);                        /* sorted, and none touches another */
/* What is left of from without what; both merged. */
void norma_ranges_subtract(const ranges *from, const ranges *what, ranges *left);
#endif
