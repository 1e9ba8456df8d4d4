/* sort.c: the library's own, since qsort may allocate, and orders equals as it likes. */
#include "core/call/call.h"
#include <string.h>

typedef struct heap {
    unsigned char *items;
    size_t size;
    int (*less)(const void *a, const void *b);
} heap;

static unsigned char *item(const heap *h, size_t index) { return h->items + index * h->size; }

static void swap_items(const heap *h, size_t a, size_t b) {
    unsigned char held[SORT_MOST_BYTES];
    memcpy(held, item(h, a), h->size);
    memcpy(item(h, a), item(h, b), h->size);
    memcpy(item(h, b), held, h->size);
}

static void sift(const heap *h, size_t at, size_t count) {
    for (size_t child; (child = 2 * at + 1) < count; at = child) {
        if (child + 1 < count && h->less(item(h, child), item(h, child + 1))) ++child;
        if (!h->less(item(h, at), item(h, child))) return;
        swap_items(h, at, child);
    }
}

void norma_core_sort(
    void *items, size_t count, size_t size, int (*less)(const void *a, const void *b)) {
    const heap h = {items, size, less};
    for (size_t i = count / 2; i-- > 0;) sift(&h, i, count);
    for (size_t end = count; end > 1; --end) {
        swap_items(&h, 0, end - 1);
        sift(&h, 0, end - 1);
    }
}

/* ---- numbers: dealt by the highest byte in which any two differ, in place,
 * and each part again (McIlroy, Bostic, McIlroy 1993, American flag sort) */

enum { FEW_NUMBERS = 24, BYTE_VALUES = 256 };

static void sort_few_numbers(uint64_t *numbers, size_t count) {
    for (size_t i = 1; i < count; ++i) {
        const uint64_t moved = numbers[i];
        size_t at = i;
        for (; at > 0 && moved < numbers[at - 1]; --at) numbers[at] = numbers[at - 1];
        numbers[at] = moved;
    }
}

/* The bits in which they differ; 0 where they are in order already. */
static uint64_t disorder(const uint64_t *numbers, size_t count) {
    uint64_t differ = 0;
    int ordered = 1;
    for (size_t i = 1; i < count; ++i) {
        differ |= numbers[i] ^ numbers[0];
        ordered &= numbers[i - 1] < numbers[i];
    }
    return ordered ? 0 : differ;
}

static size_t byte_of(uint64_t number, int shift) {
    return (size_t)(number >> shift) & (BYTE_VALUES - 1);
}

static void deal(uint64_t *numbers, size_t count, int shift, uint32_t ends[BYTE_VALUES]) {
    uint32_t next[BYTE_VALUES], sum = 0;
    memset(ends, 0, BYTE_VALUES * sizeof *ends);
    for (size_t i = 0; i < count; ++i) ++ends[byte_of(numbers[i], shift)];
    for (size_t value = 0; value < BYTE_VALUES; ++value) {
        next[value] = sum;
        ends[value] = sum += ends[value];
    }
    for (size_t value = 0; value < BYTE_VALUES; ++value)
        while (next[value] < ends[value]) {
            const uint64_t number = numbers[next[value]];
            const size_t to = byte_of(number, shift);
            numbers[next[value]] = numbers[next[to]];
            numbers[next[to]++] = number;
        }
}

/* Eight deep at most, as each is about a lower byte. */
void norma_core_sort_numbers(uint64_t *numbers, size_t count) {
    uint32_t ends[BYTE_VALUES], begin = 0;
    if (count <= FEW_NUMBERS) {
        sort_few_numbers(numbers, count);
        return;
    }
    const uint64_t differ = disorder(numbers, count);
    int shift = 56;
    if (!differ) return;
    while (!byte_of(differ, shift)) shift -= 8;
    deal(numbers, count, shift, ends);
    for (size_t value = 0; value < BYTE_VALUES && shift; begin = ends[value++])
        if (ends[value] - begin > 1) norma_core_sort_numbers(numbers + begin, ends[value] - begin);
}
