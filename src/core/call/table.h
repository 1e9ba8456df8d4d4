/* table.h: numbers found again by what they stand for: a hash table with open addressing and
 * linear probing (Knuth, volume 3, 6.4), at most half full; and bisection. A slot holds a number +
 * 1, or 0 where it is free. What the numbers stand for is the caller's, who compares it. The core
 * itself needs neither so far: apart from call.h they are no dead code in the single file. */
#ifndef NORMA_CORE_TABLE_H
#define NORMA_CORE_TABLE_H
#include <stddef.h>
#include <stdint.h>
#include <string.h>

/* Slots for so many numbers: a power of two. */
static inline size_t norma_core_table_size(size_t count) {
    size_t size = 16;
    while (size / 2 < count) size *= 2;
    return size;
}

/* Whether a number stands for what is looked for. */
typedef int core_is_wanted(const void *context, uint32_t number);

/* The slot of the number that is wanted, else a free one. */
static inline uint32_t *norma_core_table_find(
    uint32_t *slots, size_t size, uint64_t hash, core_is_wanted *is_wanted, const void *context) {
    size_t at = (size_t)hash & (size - 1);
    while (slots[at] && !is_wanted(context, slots[at] - 1)) at = (at + 1) & (size - 1);
    return &slots[at];
}

/* Four bytes at a time, each copied in one instruction. Keys are often floats that have just been
 * stored: a load of eight bytes would wait for both stores, and for every store before them. */
static inline uint64_t norma_core_hash(const void *bytes, size_t size) {
    const unsigned char *at = bytes;
    const uint64_t prime = UINT64_C(0x9E3779B97F4A7C15);
    uint64_t hash = size * prime;
    uint32_t word;
    for (; size >= sizeof word; size -= sizeof word, at += sizeof word) {
        memcpy(&word, at, sizeof word);
        hash = (hash ^ hash >> 29 ^ word) * prime;
    }
    for (; size; --size) hash = (hash ^ hash >> 29 ^ *at++) * prime;
    return hash ^ hash >> 32;
}

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
