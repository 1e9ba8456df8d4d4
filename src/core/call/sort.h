/* sort.h: for what is sorted seldom and may be large. */
#ifndef NORMA_CORE_SORT_H
#define NORMA_CORE_SORT_H
#include <stddef.h>
#include <stdint.h>

enum { SORT_MOST_BYTES = 32 }; /* of one item */

/* Heap sort (Williams 1964): in place, O(n log n) whatever the input; the same order everywhere
 * where less tells any two apart. */
void norma_core_sort(
    void *items, size_t count, size_t size, int (*less)(const void *a, const void *b));

/* Ascending, without further memory, O(n). */
void norma_core_sort_numbers(uint64_t *numbers, size_t count);

/* Bisection: of 0 to count, of which those at the beginning come before, the first that does not.
 */
typedef int core_comes_before(const void *context, size_t i);

static inline size_t norma_core_bisect(
    size_t count, core_comes_before *comes_before, const void *context) {
    size_t low = 0, high = count;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (comes_before(context, middle))
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}
#endif
