/* number_big.c: schoolbook arithmetic on positive integers for the rare decimals that machine words
 * cannot decide. */
#include "io/text/number_big.h"
#include <assert.h>
#include <string.h>

void norma_big_set(big_number *big, uint64_t value) {
    big->limb[0] = (uint32_t)value;
    big->limb[1] = (uint32_t)(value >> 32);
    big->count = value >> 32 ? 2 : value ? 1 : 0;
}

void norma_big_multiply_add(big_number *big, uint32_t factor, uint32_t summand) {
    uint64_t carry = summand;
    for (int i = 0; i < big->count; ++i) {
        carry += (uint64_t)big->limb[i] * factor;
        big->limb[i] = (uint32_t)carry;
        carry >>= 32;
    }
    if (carry) {
        assert(big->count < BIG_LIMBS);
        big->limb[big->count++] = (uint32_t)carry;
    }
}

void norma_big_multiply_power(big_number *big, uint32_t base, int exponent) {
    for (; exponent > 0; --exponent) norma_big_multiply_add(big, base, 0);
}

void norma_big_shift_left(big_number *big, int bits) {
    int limbs = bits / 32;
    int rest = bits % 32;
    if (!big->count) return;
    assert(big->count + limbs + 1 <= BIG_LIMBS);
    memmove(big->limb + limbs, big->limb, (size_t)big->count * sizeof big->limb[0]);
    memset(big->limb, 0, (size_t)limbs * sizeof big->limb[0]);
    big->count += limbs;
    if (!rest) return;
    uint32_t carry = 0;
    for (int i = limbs; i < big->count; ++i) {
        uint32_t limb = big->limb[i];
        big->limb[i] = limb << rest | carry;
        carry = limb >> (32 - rest);
    }
    if (carry) big->limb[big->count++] = carry;
}

int norma_big_bits(const big_number *big) {
    if (!big->count) return 0;
    int bits = 32 * (big->count - 1);
    for (uint32_t top = big->limb[big->count - 1]; top; top >>= 1) ++bits;
    return bits;
}

int norma_big_compare(const big_number *a, const big_number *b) {
    if (a->count != b->count) return a->count - b->count;
    for (int i = a->count - 1; i >= 0; --i)
        if (a->limb[i] != b->limb[i]) return a->limb[i] < b->limb[i] ? -1 : 1;
    return 0;
}

void norma_big_subtract(big_number *big, const big_number *smaller) {
    uint64_t borrow = 0;
    for (int i = 0; i < big->count; ++i) {
        uint64_t less = borrow + (i < smaller->count ? smaller->limb[i] : 0);
        borrow = big->limb[i] < less;
        big->limb[i] = (uint32_t)(big->limb[i] - less);
    }
    while (big->count && !big->limb[big->count - 1]) --big->count;
}
