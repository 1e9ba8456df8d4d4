/* sort.c: the library's own, since qsort may allocate, and orders equals as it likes. */
#include "core/call/sort.h"
#include <string.h>

typedef struct heap {
    unsigned char *items;
    size_t size;
    int (*less)(const void *a, const void *b);
} heap;

static unsigned char *item(const heap *h, size_t index) { return h->items + index * h->size; }

static void swap(const heap *h, size_t a, size_t b) {
    unsigned char held[SORT_MOST_BYTES];
    memcpy(held, item(h, a), h->size);
    memcpy(item(h, a), item(h, b), h->size);
    memcpy(item(h, b), held, h->size);
}

static void sift(const heap *h, size_t at, size_t count) {
    for (size_t child; (child = 2 * at + 1) < count; at = child) {
        if (child + 1 < count && h->less(item(h, child), item(h, child + 1))) child++;
        if (!h->less(item(h, at), item(h, child))) return;
        swap(h, at, child);
    }
}

void norma_core_sort(
    void *items, size_t count, size_t size, int (*less)(const void *a, const void *b)) {
    const heap h = {items, size, less};
    for (size_t i = count / 2; i-- > 0;) sift(&h, i, count);
    for (size_t end = count; end > 1; end--) {
        swap(&h, 0, end - 1);
        sift(&h, 0, end - 1);
    }
}
