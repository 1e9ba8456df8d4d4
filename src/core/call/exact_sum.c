/* exact_sum.c: sums of products of up to four doubles without any rounding, in 32-bit limbs, so
 * that only integer arithmetic that every compiler has is needed; and what is compared by them. */
#include "core/call/call.h"
#include <math.h>

enum { LOWEST_BIT = -EXACT_SUM_FACTORS * 1074, PRODUCT_LIMBS = 2 * EXACT_SUM_FACTORS + 1 };

void norma_exact_clear(exact_sum *sum) { memset(sum->limb, 0, sizeof sum->limb); }

/* |value| as an integer of at most 53 bits times 2^*exponent. */
static uint64_t integer_and_exponent(double value, int *exponent) {
    int e = 0;
    const double fraction = frexp(fabs(value), &e);
    *exponent = e - 53;
    uint64_t bits = (uint64_t)ldexp(fraction, 53);
    while (*exponent < -1074) { /* subnormal: frexp shifted zeros in from below */
        bits >>= 1;
        ++*exponent;
    }
    return bits;
}

static void multiply(uint32_t product[PRODUCT_LIMBS], uint64_t by) {
    const uint32_t half[2] = {(uint32_t)by, (uint32_t)(by >> 32)};
    uint32_t result[PRODUCT_LIMBS] = {0};
    for (int h = 0; h < 2; ++h) {
        uint64_t carry = 0;
        for (int i = 0; i + h < PRODUCT_LIMBS; ++i) {
            carry += (uint64_t)product[i] * half[h] + result[i + h];
            result[i + h] = (uint32_t)carry;
            carry >>= 32;
        }
    }
    memcpy(product, result, sizeof result);
}

static void shift_left(uint32_t product[PRODUCT_LIMBS], int bits) {
    if (bits == 0) return;
    for (int i = PRODUCT_LIMBS - 1; i >= 0; --i)
        product[i] = product[i] << bits | (i ? product[i - 1] >> (32 - bits) : 0);
}

static void add_at(exact_sum *sum, const uint32_t product[PRODUCT_LIMBS], int limb, int negative) {
    uint64_t carry = negative ? 1 : 0; /* minus x is the complement of x, plus one */
    for (int i = limb; i < EXACT_SUM_LIMBS; ++i) {
        const uint32_t digit = i - limb < PRODUCT_LIMBS ? product[i - limb] : 0;
        carry += (uint64_t)sum->limb[i] + (negative ? (uint32_t)~digit : digit);
        sum->limb[i] = (uint32_t)carry;
        carry >>= 32;
        if (i - limb >= PRODUCT_LIMBS && carry == (negative ? 1U : 0U)) return;
    }
}

void norma_exact_add(exact_sum *sum, const double *factors, int count, int negative) {
    uint32_t product[PRODUCT_LIMBS] = {1};
    int exponent = 0;
    for (int i = 0; i < count; ++i) {
        if (factors[i] == 0.0) return;
        int e;
        multiply(product, integer_and_exponent(factors[i], &e));
        exponent += e;
        negative ^= factors[i] < 0.0;
    }
    const int bit =
        exponent - LOWEST_BIT; /* at least 0: each factor's exponent is at least -1074 */
    shift_left(product, bit % 32);
    add_at(sum, product, bit / 32, negative);
}

static void negate(exact_sum *sum) {
    uint64_t carry = 1;
    for (int i = 0; i < EXACT_SUM_LIMBS; ++i) {
        carry += (uint32_t)~sum->limb[i];
        sum->limb[i] = (uint32_t)carry;
        carry >>= 32;
    }
}

scaled_number norma_exact_round(const exact_sum *sum) {
    exact_sum s = *sum;
    const int negative = s.limb[EXACT_SUM_LIMBS - 1] >> 31 != 0;
    if (negative) negate(&s);
    int top = EXACT_SUM_LIMBS - 1;
    while (top >= 0 && !s.limb[top]) --top;
    if (top < 0) return (scaled_number){0.0, 0};

    int leading = 0;
    while (!(s.limb[top] >> (31 - leading))) ++leading;
    const uint32_t high = s.limb[top], middle = top > 0 ? s.limb[top - 1] : 0,
                   low = top > 1 ? s.limb[top - 2] : 0;
    uint64_t bits = ((uint64_t)high << 32 | middle)
                    << leading; /* the highest 64 bits; below them: sticky */
    if (leading) bits |= low >> (32 - leading);
    int sticky = leading < 32 && (uint32_t)(low << leading) != 0;
    for (int i = top - 3; i >= 0 && !sticky; --i) sticky = s.limb[i] != 0;

    const uint64_t rest = bits & 0x7ff, half = 0x400;
    bits >>= 11;
    if (rest > half || (rest == half && (sticky || (bits & 1)))) ++bits;
    scaled_number rounded = norma_scaled_from_double((double)bits);
    rounded.exponent += top * 32 + 31 - leading - 52 + LOWEST_BIT;
    if (negative) rounded.mantissa = -rounded.mantissa;
    return rounded;
}

scaled_number norma_scaled_from_double(double value) {
    if (value == 0.0) return (scaled_number){0.0, 0};
    int e;
    const double fraction = frexp(value, &e);
    return (scaled_number){2.0 * fraction, e - 1};
}

double norma_scaled_to_double(scaled_number number) {
    return ldexp(number.mantissa, number.exponent);
}

/* ---- lengths */

/* Plus or minus |to - from|^2 = from^2 - 2 from to + to^2. */
static void add_square(exact_sum *sum, const double from[3], const double to[3], int negative) {
    for (int k = 0; k < 3; ++k) {
        norma_exact_add(sum, (const double[]){from[k], from[k]}, 2, negative);
        norma_exact_add(sum, (const double[]){to[k], to[k]}, 2, negative);
        norma_exact_add(sum, (const double[]){2, from[k], to[k]}, 3, !negative);
    }
}

void norma_core_measure_segment(core_segment *segment) {
    double along[3];
    norma_core_subtract(segment->to, segment->from, along);
    segment->square = norma_core_dot(along, along);
}

/* Whether the square is exact, as between points of a grid, where many are as near. A sum or
 * difference is if each part can be had back from it, a product if its factors have half a double's
 * bits. */
static int lost_nothing(const core_segment *segment) {
    double sum = 0;
    for (int k = 0; k < 3; ++k) {
        const double from = segment->from[k], to = segment->to[k], along = to - from,
                     square = along * along, next = sum + square, scaled = (0x1p27 + 1) * along;
        if (from + along != to || to - along != from || scaled - (scaled - along) != along ||
            next - square != sum || next - sum != square || (along != 0 && square < NORMA_TINIEST))
            return 0;
        sum = next;
    }
    return 1;
}

int norma_core_compare_lengths(const core_segment *a, const core_segment *b) {
    const double difference = a->square - b->square, sum = a->square + b->square;
    exact_sum exact;
    if (fabs(difference) > 0x1p-48 * sum && sum > NORMA_TINIEST && sum < NORMA_HUGEST)
        return difference > 0 ? 1 : -1;
    if (lost_nothing(a) && lost_nothing(b)) return (difference > 0) - (difference < 0);
    norma_exact_clear(&exact);
    add_square(&exact, a->from, a->to, 0);
    add_square(&exact, b->from, b->to, 1);
    const double sign = norma_exact_round(&exact).mantissa;
    return (sign > 0) - (sign < 0);
}
