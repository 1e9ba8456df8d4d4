/* transform_normals_avx512.c: sixteen normals through a matrix in the registers of AVX-512, from
 * the line they are read from to the one they are written to. The numbers and their bits are those
 * of transform_normals.c, step by step; it is said once more here because a compiler that makes
 * instructions of loops over a block writes what each step leaves and reads it again: 50 cycles for
 * eight normals against 38. */
#include "core/matrix/transform_normals_avx512.h"
#if defined(CORE_HAS_AVX512)
#include <immintrin.h>

/* Of 48 numbers in three registers, x y z x y z ..., those of one axis lie at places that are each
 * another: one from each, then in order. */
enum {
    FIRST = 0x9249,
    SECOND = 0x4924,
    THIRD = 0x2492
}; /* every third place, from 0, 2 and 1 on */

/* Lane i of an axis is at place 3 i + axis, modulo 16; and back: what is at place j comes from lane
 * 11 (j - axis), modulo 16. */
CORE_IN_REGISTERS __m512i places(int factor, int from) {
    const __m512i lane = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
    return _mm512_and_si512(_mm512_add_epi32(_mm512_mullo_epi32(lane, _mm512_set1_epi32(factor)),
                                _mm512_set1_epi32(from)),
        _mm512_set1_epi32(15));
}

CORE_IN_REGISTERS __m512 of_three(
    __m512 a, __m512 b, __mmask16 from_b, __m512 c, __mmask16 from_c) {
    return _mm512_mask_blend_ps(from_c, _mm512_mask_blend_ps(from_b, a, b), c);
}

CORE_IN_REGISTERS void take_apart(const float *from, __m512 axis[3]) {
    const __m512 a = _mm512_loadu_ps(from), b = _mm512_loadu_ps(from + 16),
                 c = _mm512_loadu_ps(from + 32);
    axis[0] = _mm512_permutexvar_ps(places(3, 0), of_three(a, b, SECOND, c, THIRD));
    axis[1] = _mm512_permutexvar_ps(places(3, 1), of_three(a, b, FIRST, c, SECOND));
    axis[2] = _mm512_permutexvar_ps(places(3, 2), of_three(a, b, THIRD, c, FIRST));
}

CORE_IN_REGISTERS void put_together(const __m512 axis[3], float *to) {
    const __m512 x = _mm512_permutexvar_ps(places(11, 0), axis[0]),
                 y = _mm512_permutexvar_ps(places(11, 16 - 11), axis[1]),
                 z = _mm512_permutexvar_ps(places(11, 32 - 22), axis[2]);
    _mm512_storeu_ps(to, of_three(x, y, THIRD, z, SECOND));
    _mm512_storeu_ps(to + 16, of_three(x, y, FIRST, z, THIRD));
    _mm512_storeu_ps(to + 32, of_three(x, y, SECOND, z, FIRST));
}

CORE_IN_REGISTERS __m512d low_as_doubles(__m512 v) {
    return _mm512_cvtps_pd(_mm512_castps512_ps256(v));
}
CORE_IN_REGISTERS __m512d high_as_doubles(__m512 v) {
    return _mm512_cvtps_pd(_mm512_extractf32x8_ps(v, 1));
}
CORE_IN_REGISTERS __m512 as_floats(__m512d low, __m512d high) {
    return _mm512_insertf32x8(
        _mm512_castps256_ps512(_mm512_cvtpd_ps(low)), _mm512_cvtpd_ps(high), 1);
}

typedef struct product_eight {
    __m512d axis[3], square;
} product_eight;

/* The products of two floats are exact in doubles, so that one rounding of a product and a sum is
 * the rounding of the sum. */
CORE_IN_REGISTERS product_eight product(const __m512d m[9], __m512d x, __m512d y, __m512d z) {
    product_eight p;
    for (int r = 0; r < 3; r++)
        p.axis[r] =
            _mm512_fmadd_pd(m[6 + r], z, _mm512_fmadd_pd(m[3 + r], y, _mm512_mul_pd(m[r], x)));
    p.square = _mm512_add_pd(
        _mm512_add_pd(_mm512_mul_pd(p.axis[0], p.axis[0]), _mm512_mul_pd(p.axis[1], p.axis[1])),
        _mm512_mul_pd(p.axis[2], p.axis[2]));
    return p;
}

/* one_over_length */
CORE_IN_REGISTERS __m512d one_over_length(__m512d exact_square, __m512d about) {
    const __m512d half = _mm512_mul_pd(_mm512_set1_pd(0.5), exact_square);
    return _mm512_mul_pd(about,
        _mm512_sub_pd(_mm512_set1_pd(1.5), _mm512_mul_pd(half, _mm512_mul_pd(about, about))));
}

/* Sixteen normals multiplied, and about one over their lengths. */
typedef struct opened_sixteen {
    product_eight low, high;
    __m512 about;
    __mmask16 safe;
} opened_sixteen;

CORE_IN_REGISTERS void open_sixteen(const __m512d m[9], const float *in, opened_sixteen *o) {
    __m512 v[3];
    take_apart(in, v);
    o->low = product(m, low_as_doubles(v[0]), low_as_doubles(v[1]), low_as_doubles(v[2]));
    o->high = product(m, high_as_doubles(v[0]), high_as_doubles(v[1]), high_as_doubles(v[2]));
    const __m512 square = as_floats(o->low.square, o->high.square);
    o->safe =
        _mm512_mask_cmp_ps_mask(_mm512_cmp_ps_mask(square, _mm512_set1_ps(0x1p-120f), _CMP_GE_OQ),
            square, _mm512_set1_ps(0x1p120f), _CMP_LE_OQ);
    o->about = _mm512_div_ps(_mm512_set1_ps(1), _mm512_sqrt_ps(square));
}

CORE_IN_REGISTERS void close_sixteen(const opened_sixteen *o, float *out) {
    const __m512d low = one_over_length(o->low.square, low_as_doubles(o->about)),
                  high = one_over_length(o->high.square, high_as_doubles(o->about));
    __m512 v[3];
    for (int k = 0; k < 3; k++)
        v[k] = as_floats(_mm512_mul_pd(o->low.axis[k], low), _mm512_mul_pd(o->high.axis[k], high));
    put_together(v, out);
}

/* The next sixteen are multiplied while the root and the quotient of these are under way: what
 * waits for them would fill the processor's registers before it saw that far ahead. */
CORE_FOR_AVX512 size_t norma_core_units_avx512(
    const double matrix[9], const float *in, size_t count, float *out) {
    __m512d m[9];
    opened_sixteen o, next;
    size_t done = 0;
    for (int i = 0; i < 9; i++) m[i] = _mm512_set1_pd(matrix[i]);
    if (count < 16) return 0;
    open_sixteen(m, in, &o);
    for (; o.safe == UINT16_MAX && count - done >= 32; done += 16) {
        open_sixteen(m, in + 3 * (done + 16), &next);
        close_sixteen(&o, out + 3 * done);
        o = next;
    }
    if (o.safe != UINT16_MAX) return done;
    close_sixteen(&o, out + 3 * done);
    return done + 16;
}
#endif
