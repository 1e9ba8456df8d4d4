/* bits.h: a set of vertices, a bit each, that tells how many of its members come before one. */
#ifndef NORMA_IO_LARGE_BITS_H
#define NORMA_IO_LARGE_BITS_H
#include "io/large/budget.h"

typedef struct large_bits {
    uint64_t *words;
    uint32_t *before; /* members before each word, once they are counted */
    size_t count;
} large_bits;

/* Empty; 0: out of memory. */
int norma_large_bits_open(large_budget *budget, size_t count, large_bits *bits);
void norma_large_bits_close(large_budget *budget, large_bits *bits);
void norma_large_bits_clear(large_bits *bits);
void norma_large_bits_set_range(large_bits *bits, size_t begin, size_t end);
/* Before norma_large_bits_before; returns how many members there are. */
size_t norma_large_bits_count(large_bits *bits);
/* Members before index, which may be count. */
size_t norma_large_bits_before(const large_bits *bits, size_t index);

static inline void norma_large_bits_set(large_bits *bits, size_t index) {
    bits->words[index >> 6] |= UINT64_C(1) << (index & 63);
}
static inline int norma_large_bits_has(const large_bits *bits, size_t index) {
    return (int)(bits->words[index >> 6] >> (index & 63) & 1);
}
static inline int norma_large_bits_any(const large_bits *bits, size_t begin, size_t end) {
    return norma_large_bits_before(bits, end) > norma_large_bits_before(bits, begin);
}
#endif
