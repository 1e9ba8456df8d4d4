/* face_exact.c: areas, sums and turns where doubles do not decide. The register of exact_sum, in
 * 32-bit limbs, so that only integer arithmetic that every compiler has is needed. */
#include "core/face/face.h"
#include <math.h>
#include <string.h>
#include <stdint.h>

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

/* ---- every finite double is an integer times a power of two, so all points of a face are integers
 * in the unit of the least bit among them, and sums of products of their differences are integers
 * too: in 128 bits where they fit (nearly always), else in as many words as it takes. */

__extension__ typedef __int128 wide;
__extension__ typedef unsigned __int128 unsigned_wide;

/* The least and the highest bit that any coordinate uses, as powers of two; 0 where all coordinates
 * are zero. */
static int bit_range(
    exact_point *point, const void *context, size_t count, int *least, int *highest) {
    int any = 0;
    for (size_t i = 0; i < count; ++i) {
        double p[3];
        point(context, i, p);
        for (int k = 0; k < 3; ++k) {
            if (p[k] == 0) continue;
            int exponent;
            uint64_t mantissa = (uint64_t)ldexp(fabs(frexp(p[k], &exponent)), 53);
            const int top = exponent - 1;
            int bottom = exponent - 53;
            while (!(mantissa & 1)) {
                mantissa >>= 1;
                ++bottom;
            }
            if (!any || bottom < *least) *least = bottom;
            if (!any || top > *highest) *highest = top;
            any = 1;
        }
    }
    return any;
}

/* ---- 128 bits */

static void integer_point(
    exact_point *point, const void *context, size_t index, int unit, int64_t out[3]) {
    double p[3];
    point(context, index, p);
    for (int k = 0; k < 3; ++k) out[k] = (int64_t)ldexp(p[k], -unit);
}

static double wide_to_double(wide value) {
    const unsigned_wide magnitude = value < 0 ? -(unsigned_wide)value : (unsigned_wide)value;
    const double high = (double)(uint64_t)(magnitude >> 64), low = (double)(uint64_t)magnitude;
    const double result = high * 0x1p64 + low;
    return value < 0 ? -result : result;
}

static void wide_area(
    exact_point *point, const void *context, size_t count, int unit, double area[3]) {
    int64_t origin[3], p[3], u[3], v[3] = {0, 0, 0};
    wide sum[3] = {0, 0, 0};
    integer_point(point, context, 0, unit, origin);
    for (size_t i = 1; i < count; ++i) {
        integer_point(point, context, i, unit, p);
        for (int k = 0; k < 3; ++k) {
            u[k] = v[k];
            v[k] = p[k] - origin[k];
        }
        sum[0] += (wide)u[1] * v[2] - (wide)u[2] * v[1];
        sum[1] += (wide)u[2] * v[0] - (wide)u[0] * v[2];
        sum[2] += (wide)u[0] * v[1] - (wide)u[1] * v[0];
    }
    for (int k = 0; k < 3; ++k) area[k] = wide_to_double(sum[k]);
}

/* ---- as many words as it takes: two's complement, least word first, all of one length */

enum {
    MOST_WORDS = 144
}; /* products of two differences of doubles: 2 * (2098 + 2) bits, and 64 for a sum of 2^64 of them
    */

typedef struct integer {
    uint32_t word[MOST_WORDS];
} integer;

static void integer_from_double(double value, int unit, int words, integer *out) {
    memset(out, 0, sizeof *out);
    if (value == 0) return;
    int exponent;
    const uint64_t mantissa = (uint64_t)ldexp(fabs(frexp(value, &exponent)), 53);
    const int shift =
        exponent - 53 -
        unit; /* the mantissa's own unit, in ours; negative only over bits that are zero */
    const uint64_t bits = shift < 0 ? mantissa >> -shift : mantissa;
    const int at = shift < 0 ? 0 : shift / 32, within = shift < 0 ? 0 : shift % 32;
    const unsigned_wide placed = (unsigned_wide)bits << within;
    for (int i = 0; i < 3 && at + i < words; ++i)
        out->word[at + i] = (uint32_t)(placed >> (32 * i));
    if (value > 0) return;
    uint64_t carry = 1;
    for (int i = 0; i < words; ++i) {
        carry += (uint32_t)~out->word[i];
        out->word[i] = (uint32_t)carry;
        carry >>= 32;
    }
}

static void integer_subtract(const integer *a, const integer *b, int words, integer *out) {
    uint64_t carry = 1;
    for (int i = 0; i < words; ++i) {
        carry += (uint64_t)a->word[i] + (uint32_t)~b->word[i];
        out->word[i] = (uint32_t)carry;
        carry >>= 32;
    }
}

/* sum += a b, or -= where subtract, all modulo 2^(32 words), which two's complement makes right for
 * either sign. */
static void integer_add_product(
    const integer *a, const integer *b, int subtract, int words, integer *sum) {
    integer product;
    memset(&product, 0, sizeof product);
    for (int i = 0; i < words; ++i) {
        uint64_t carry = 0;
        if (!a->word[i]) continue;
        for (int j = 0; i + j < words; ++j) {
            carry += (uint64_t)a->word[i] * b->word[j] + product.word[i + j];
            product.word[i + j] = (uint32_t)carry;
            carry >>= 32;
        }
    }
    uint64_t carry = subtract ? 1 : 0;
    for (int i = 0; i < words; ++i) {
        carry += (uint64_t)sum->word[i] + (subtract ? (uint32_t)~product.word[i] : product.word[i]);
        sum->word[i] = (uint32_t)carry;
        carry >>= 32;
    }
}

/* Makes value its magnitude; returns whether it was negative. */
static int integer_magnitude(integer *value, int words) {
    if (!(value->word[words - 1] >> 31)) return 0;
    const integer zero = {{0}}, negative = *value;
    integer_subtract(&zero, &negative, words, value);
    return 1;
}

static int top_word(const integer *value, int words) {
    while (words > 0 && !value->word[words - 1]) --words;
    return words;
}

/* The three as doubles in the unit of 2^(32 * base): the three words from base on hold at least 64
 * bits of the largest. */
static int integers_to_doubles(integer sum[3], int words, double out[3], int *exponent) {
    int negative[3], top = 0;
    for (int k = 0; k < 3; ++k) {
        negative[k] = integer_magnitude(&sum[k], words);
        const int highest = top_word(&sum[k], words);
        if (highest > top) top = highest;
    }
    const int base = top > 3 ? top - 3 : 0;
    for (int k = 0; k < 3; ++k) {
        const double value =
            ((double)sum[k].word[base + 2] * 0x1p32 + (double)sum[k].word[base + 1]) * 0x1p32 +
            (double)sum[k].word[base];
        out[k] = negative[k] ? -value : value;
    }
    *exponent = 32 * base;
    return top > 0;
}

static int long_area(exact_point *point, const void *context, size_t count, int unit, int words,
    double area[3], int *exponent) {
    integer origin[3], p, u[3], v[3], sum[3];
    double at[3];
    point(context, 0, at);
    memset(v, 0, sizeof v);
    memset(sum, 0, sizeof sum);
    for (int k = 0; k < 3; ++k) integer_from_double(at[k], unit, words, &origin[k]);
    for (size_t i = 1; i < count; ++i) {
        point(context, i, at);
        for (int k = 0; k < 3; ++k) {
            u[k] = v[k];
            integer_from_double(at[k], unit, words, &p);
            integer_subtract(&p, &origin[k], words, &v[k]);
        }
        for (int k = 0; k < 3; ++k) {
            integer_add_product(&u[(k + 1) % 3], &v[(k + 2) % 3], 0, words, &sum[k]);
            integer_add_product(&u[(k + 2) % 3], &v[(k + 1) % 3], 1, words, &sum[k]);
        }
    }
    return integers_to_doubles(sum, words, area, exponent);
}

static int bits_of(size_t count) {
    int bits = 0;
    for (; count; count >>= 1) ++bits;
    return bits;
}

int norma_core_exact_area(
    exact_point *point, const void *context, size_t count, double area[3], int *exponent) {
    int least = 0, highest = 0;
    area[0] = area[1] = area[2] = 0;
    *exponent = 0;
    if (!bit_range(point, context, count, &least, &highest)) return 0;
    const int coordinate_bits = highest - least + 1;
    const int sum_bits = 2 * (coordinate_bits + 1) + 1 + bits_of(count) + 1;
    if (coordinate_bits <= 61 && sum_bits <= 126) {
        wide_area(point, context, count, least, area);
        *exponent = 2 * least;
        return area[0] != 0 || area[1] != 0 || area[2] != 0;
    }
    int words = (sum_bits + 31) / 32 + 1;
    if (words < 3) words = 3;
    if (words > MOST_WORDS) words = MOST_WORDS;
    const int found = long_area(point, context, count, least, words, area, exponent);
    *exponent += 2 * least;
    return found;
}

/* ---- the sign of the dot product of two vector areas, the corner's and the polygon's, each the
 * sum of p x q over its edges from p to q. The polygon's is summed exactly, once for all corners,
 * and multiplied with the corner's a double at a time. */

static void add_cross(exact_sum area[3], const double p[3], const double q[3]) {
    for (int k = 0; k < 3; ++k) {
        const int x = (k + 1) % 3, y = (k + 2) % 3;
        norma_exact_add(&area[k], (const double[]){p[x], q[y]}, 2, 0);
        norma_exact_add(&area[k], (const double[]){p[y], q[x]}, 2, 1);
    }
}

void norma_core_sum_polygon(
    exact_point *point, const void *context, size_t count, exact_area *area) {
    double first[3], p[3], q[3];
    for (int k = 0; k < 3; ++k) norma_exact_clear(&area->sum[k]);
    area->known = 1;
    point(context, 0, first);
    memcpy(q, first, sizeof q);
    for (size_t i = 1; i < count; ++i) {
        memcpy(p, q, sizeof p);
        point(context, i, q);
        add_cross(area->sum, p, q);
    }
    add_cross(area->sum, q, first);
}

/* The sum's leading 53 bits as a product of two doubles, since one may not reach; at the very end
 * of the range a part of them. 0: nothing is left. */
static int leading_part(const exact_sum *sum, double part[2]) {
    const scaled_number number = norma_exact_round(sum);
    const int exponent = number.exponent < 2046 ? number.exponent : 2046;
    const int scale = exponent < -1000 ? -1074 : exponent > 1000 ? 1023 : 0;
    part[0] = ldexp(number.mantissa, exponent - scale);
    part[1] = ldexp(1, scale);
    return part[0] < 0 || part[0] > 0;
}

int norma_core_turns_back(
    const exact_area *area, const double here[3], const double next[3], const double previous[3]) {
    const double *const corner[4] = {previous, here, next, previous};
    exact_sum turn;
    double part[2];
    norma_exact_clear(&turn);
    for (int k = 0; k < 3; ++k) {
        exact_sum rest = area->sum[k];
        while (leading_part(&rest, part)) {
            const int x = (k + 1) % 3, y = (k + 2) % 3;
            for (int i = 0; i < 3; ++i) {
                const double *p = corner[i], *q = corner[i + 1];
                norma_exact_add(&turn, (const double[]){part[0], part[1], p[x], q[y]}, 4, 0);
                norma_exact_add(&turn, (const double[]){part[0], part[1], p[y], q[x]}, 4, 1);
            }
            norma_exact_add(&rest, part, 2, 1);
        }
    }
    return norma_exact_round(&turn).mantissa < 0;
}
