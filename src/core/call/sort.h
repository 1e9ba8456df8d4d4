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
#endif
