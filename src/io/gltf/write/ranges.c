/* ranges.c: sets of bytes in a buffer. */
#include "io/gltf/write/ranges.h"
#include "io/format/format.h"
#include <stdlib.h>

void norma_range_add(ranges *r, size_t start, size_t end) {
    if (end <= start || r->failed) return;
    range *grown = norma_io_grow(r->list, &r->capacity, r->count + 1, sizeof *grown);
    if (!grown) {
        r->failed = 1;
        return;
    }
    r->list = grown;
    r->list[r->count++] = (range){start, end};
}

static int compare_ranges(const void *a, const void *b) {
    const range *x = a, *y = b;
    return x->start < y->start ? -1 : x->start > y->start;
}

void norma_ranges_merge(ranges *r) {
    if (r->count < 2) return;
    qsort(r->list, r->count, sizeof *r->list, compare_ranges);
    size_t last = 0;
    for (size_t i = 1; i < r->count; ++i) {
        if (r->list[i].start > r->list[last].end)
            r->list[++last] = r->list[i];
        else if (r->list[i].end > r->list[last].end)
            r->list[last].end = r->list[i].end;
    }
    r->count = last + 1;
}

void norma_ranges_subtract(const ranges *from, const ranges *what, ranges *left) {
    size_t k = 0;
    for (size_t i = 0; i < from->count; ++i) {
        size_t at = from->list[i].start, end = from->list[i].end;
        while (k < what->count && what->list[k].end <= at) ++k;
        for (size_t m = k; m < what->count && what->list[m].start < end; ++m) {
            norma_range_add(left, at, what->list[m].start);
            if (what->list[m].end > at) at = what->list[m].end;
        }
        norma_range_add(left, at, end);
    }
}
