/* counts.c: what is counted over the parts of a file. */
#include "io/large/counts.h"
#include <math.h>

void norma_large_add_count(norma_count *sum, const norma_count *count, size_t first) {
    if (count->count == 0) return;
    const size_t lowest = first + count->first;
    if (sum->count == 0 || lowest < sum->first) sum->first = lowest;
    sum->count += count->count;
}

void norma_large_count_reason(norma_report *report, uint8_t reason, size_t element) {
    const norma_count one = {1, 0};
    if (reason == NORMA_REASON_NON_FINITE)
        norma_large_add_count(&report->non_finite, &one, element);
    if (reason == NORMA_REASON_UNREFERENCED)
        norma_large_add_count(&report->unreferenced, &one, element);
    if (reason == NORMA_REASON_CANCELLED) norma_large_add_count(&report->cancelled, &one, element);
}

void norma_large_include(norma_large_description *description, const double at[3]) {
    if (!isfinite(at[0]) || !isfinite(at[1]) || !isfinite(at[2])) return;
    for (int axis = 0; axis < 3; ++axis) {
        double *least = &description->least[axis], *most = &description->most[axis];
        if (!description->has_bounds || at[axis] < *least) *least = at[axis];
        if (!description->has_bounds || at[axis] > *most) *most = at[axis];
    }
    description->has_bounds = 1;
}
