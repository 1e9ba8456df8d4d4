/* bits.c: a set of vertices, a bit each. Members before one are counted from a number for each word
 * of 64, so that members can be numbered without a list of them. */
#include "io/large/bits.h"
#include <string.h>

static size_t words_of(size_t count) { return count / 64 + 1; }

int norma_large_bits_open(large_budget *budget, size_t count, large_bits *bits) {
    *bits = (large_bits){.count = count};
    bits->words = norma_large_take_zeroed(budget, words_of(count), sizeof *bits->words);
    bits->before = norma_large_take_zeroed(budget, words_of(count), sizeof *bits->before);
    if (bits->words && bits->before) return 1;
    norma_large_bits_close(budget, bits);
    return 0;
}

void norma_large_bits_close(large_budget *budget, large_bits *bits) {
    norma_large_give(budget, bits->words, words_of(bits->count), sizeof *bits->words);
    norma_large_give(budget, bits->before, words_of(bits->count), sizeof *bits->before);
    *bits = (large_bits){0};
}

void norma_large_bits_clear(large_bits *bits) {
    memset(bits->words, 0, words_of(bits->count) * sizeof *bits->words);
}

void norma_large_bits_set_range(large_bits *bits, size_t begin, size_t end) {
    while (begin < end && begin & 63) norma_large_bits_set(bits, begin++);
    while (end > begin && end & 63) norma_large_bits_set(bits, --end);
    if (begin < end) memset(bits->words + begin / 64, 0xff, (end - begin) / 8);
}

/* Without an instruction for it, which not every machine has. */
static uint32_t ones(uint64_t word) {
    word -= word >> 1 & UINT64_C(0x5555555555555555);
    word = (word & UINT64_C(0x3333333333333333)) + (word >> 2 & UINT64_C(0x3333333333333333));
    word = (word + (word >> 4)) & UINT64_C(0x0f0f0f0f0f0f0f0f);
    return (uint32_t)(word * UINT64_C(0x0101010101010101) >> 56);
}

size_t norma_large_bits_count(large_bits *bits) {
    uint32_t sum = 0;
    for (size_t word = 0; word < words_of(bits->count); ++word) {
        bits->before[word] = sum;
        sum += ones(bits->words[word]);
    }
    return sum;
}

size_t norma_large_bits_before(const large_bits *bits, size_t index) {
    const uint64_t below = (UINT64_C(1) << (index & 63)) - 1;
    return bits->before[index / 64] + ones(bits->words[index / 64] & below);
}
