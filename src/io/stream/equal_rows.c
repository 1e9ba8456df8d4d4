/* equal_rows.c: rows of bytes in a table by their hash; what is told is by comparing all bytes. */
#include "io/stream/equal_rows.h"
#include <stdlib.h>
#include <string.h>

static uint64_t hash_row(const unsigned char *bytes, size_t length) {
    const uint64_t prime = UINT64_C(0x9E3779B97F4A7C15);
    uint64_t hash = length * prime;
    for (size_t i = 0; i < length; i += 8) {
        uint64_t word = 0;
        memcpy(&word, bytes + i, length - i < 8 ? length - i : 8);
        hash = (hash ^ word) * prime;
        hash ^= hash >> 29;
    }
    return hash;
}

int norma_equal_rows(norma_row_of *row_of, const void *context, size_t count, uint32_t *first) {
    size_t capacity = 16;
    if (count > UINT32_MAX - 1 || count > SIZE_MAX / 16) return 0;
    while (capacity / 2 < count) capacity *= 2;
    uint32_t *table = calloc(capacity, sizeof *table); /* 0: free, else a row's number and 1 */
    if (!table) return 0;
    for (size_t row = 0; row < count; ++row) {
        size_t length, other_length;
        const unsigned char *bytes = row_of(context, row, &length);
        size_t at = (size_t)hash_row(bytes, length) & (capacity - 1);
        for (; table[at]; at = (at + 1) & (capacity - 1)) {
            const unsigned char *other = row_of(context, table[at] - 1, &other_length);
            if (other_length == length && memcmp(other, bytes, length) == 0) break;
        }
        if (!table[at]) table[at] = (uint32_t)row + 1;
        first[row] = table[at] - 1;
    }
    free(table);
    return 1;
}
