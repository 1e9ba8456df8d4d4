/* measure_avx512.h: triangles measured and weighed by their angles, eight in the registers of
 * AVX-512. The numbers and their bits are those of measure_simd.h, step by step; it is said once
 * more here because a compiler that makes instructions of loops over lanes writes what each step
 * leaves and reads it again, and compares again what was compared before. */
#ifndef NORMA_CORE_EIGHT_AVX512_H
#define NORMA_CORE_EIGHT_AVX512_H
#include "core/call/instruction_set.h"
#if defined(CORE_HAS_AVX512)
#include "core/face/triangle.h"
#include <immintrin.h>

/* Cross product and its length, dot products of the corners' edges, and which triangles doubles
 * decide. */
typedef struct core_opened_eight {
    __m512d normal[3], length, dots[3];
    __mmask8 sure;
} core_opened_eight;
/* Two of the angles, each turn + atan(tangent), and which corner has which:
 * core_lanes_corner_angles. */
typedef struct core_sloped_eight {
    __m512d tangent[2], turn[2];
    __mmask8 first_is_0, least_is_2, second_is_least, third_is_least;
} core_sloped_eight;

CORE_IN_REGISTERS __m512d core_eight_cross_term(__m512d a, __m512d b, __m512d c, __m512d d) {
    return _mm512_sub_pd(_mm512_mul_pd(a, b), _mm512_mul_pd(c, d));
}

CORE_IN_REGISTERS __m512d core_eight_dot(const __m512d a[3], const __m512d b[3]) {
    return _mm512_add_pd(_mm512_add_pd(_mm512_mul_pd(a[0], b[0]), _mm512_mul_pd(a[1], b[1])),
        _mm512_mul_pd(a[2], b[2]));
}

CORE_IN_REGISTERS __m512d core_eight_negative(__m512d x) {
    return _mm512_xor_pd(x, _mm512_set1_pd(-0.0));
}

/* norma_core_triangle_is_sure */
CORE_IN_REGISTERS __mmask8 core_eight_is_sure(__m512d square, __m512d dot_product) {
    const __m512d together = _mm512_add_pd(square, _mm512_mul_pd(dot_product, dot_product));
    const __mmask8 thick =
        _mm512_cmp_pd_mask(square, _mm512_mul_pd(_mm512_set1_pd(0x1p-40), together), _CMP_GE_OS);
    const __mmask8 not_tiny =
        _mm512_mask_cmp_pd_mask(thick, square, _mm512_set1_pd(NORMA_TINIEST), _CMP_GT_OS);
    return _mm512_mask_cmp_pd_mask(not_tiny, square, _mm512_set1_pd(NORMA_HUGEST), _CMP_LT_OS);
}

/* core_lanes_products. p: of each corner, its three axes. */
CORE_IN_REGISTERS void core_open_eight(__m512d p[3][3], core_opened_eight *o) {
    __m512d u[3], v[3], w[3];
    for (int x = 0; x < 3; x++) {
        u[x] = _mm512_sub_pd(p[1][x], p[0][x]);
        v[x] = _mm512_sub_pd(p[2][x], p[0][x]);
        w[x] = _mm512_sub_pd(p[2][x], p[1][x]);
    }
    o->normal[0] = core_eight_cross_term(u[1], v[2], u[2], v[1]);
    o->normal[1] = core_eight_cross_term(u[2], v[0], u[0], v[2]);
    o->normal[2] = core_eight_cross_term(u[0], v[1], u[1], v[0]);
    const __m512d square = core_eight_dot(o->normal, o->normal);
    o->length = _mm512_sqrt_pd(square);
    o->dots[0] = core_eight_dot(u, v);
    o->dots[1] = core_eight_negative(core_eight_dot(u, w));
    o->dots[2] = core_eight_dot(v, w);
    o->sure = core_eight_is_sure(square, o->dots[0]);
}

/* norma_core_slope; below is returned. */
CORE_IN_REGISTERS __m512d core_eight_slope(__m512d y, __m512d x, __m512d *above, __m512d *turn) {
    const __m512d small = _mm512_min_pd(y, x), large = _mm512_max_pd(x, y);
    const __mmask8 steep = _mm512_cmp_pd_mask(small,
                       _mm512_mul_pd(_mm512_set1_pd(0.41421356237309503), large), _CMP_GT_OS),
                   falls = _mm512_cmp_pd_mask(y, x, _CMP_GT_OS);
    *above =
        _mm512_mask_sub_pd(_mm512_mask_blend_pd(falls, y, core_eight_negative(x)), steep, y, x);
    *turn = _mm512_mask_mov_pd(_mm512_maskz_mov_pd(falls, _mm512_set1_pd(0.5 * NORMA_PI)), steep,
        _mm512_set1_pd(0.25 * NORMA_PI));
    return _mm512_mask_add_pd(large, steep, small, large);
}

/* core_lanes_slopes */
CORE_IN_REGISTERS void core_slope_eight(core_opened_eight *o, core_sloped_eight *s) {
    const __m512d *d = o->dots, one = _mm512_set1_pd(1);
    s->first_is_0 = _mm512_cmp_pd_mask(d[0], d[1], _CMP_LT_OS);
    const __m512d first = _mm512_mask_blend_pd(s->first_is_0, d[1], d[0]),
                  second = _mm512_mask_blend_pd(s->first_is_0, d[0], d[1]);
    s->least_is_2 = _mm512_cmp_pd_mask(d[2], first, _CMP_LT_OS);
    const __m512d third = _mm512_mask_blend_pd(s->least_is_2, d[2], first),
                  least = _mm512_mask_blend_pd(s->least_is_2, first, d[2]);
    s->second_is_least = _mm512_cmp_pd_mask(least, second, _CMP_EQ_OS);
    s->third_is_least = _mm512_cmp_pd_mask(least, third, _CMP_EQ_OS);
    __m512d above[2];
    const __m512d below_a = core_eight_slope(o->length, second, &above[0], &s->turn[0]),
                  below_b = core_eight_slope(o->length, third, &above[1], &s->turn[1]);
    const __m512d inverse = _mm512_div_pd(one, o->length),
                  belows = _mm512_div_pd(one, _mm512_mul_pd(below_a, below_b));
    for (int x = 0; x < 3; x++) o->normal[x] = _mm512_mul_pd(o->normal[x], inverse);
    s->tangent[0] = _mm512_mul_pd(above[0], _mm512_mul_pd(belows, below_b));
    s->tangent[1] = _mm512_mul_pd(above[1], _mm512_mul_pd(belows, below_a));
}

/* norma_core_weight_atan and the turn before it, of both angles side by side. */
CORE_IN_REGISTERS void core_turn_eight(const core_sloped_eight *s, __m512d angle[2]) {
    const __m512d *t = s->tangent, z[2] = {_mm512_mul_pd(t[0], t[0]), _mm512_mul_pd(t[1], t[1])},
                  first = _mm512_set1_pd(CORE_WEIGHT_ATAN_FIRST);
    __m512d p[2] = {first, first};
#define CORE_ADD_TERM(factor)                                                                      \
    for (int k = 0; k < 2; k++)                                                                    \
        p[k] = _mm512_add_pd(_mm512_mul_pd(p[k], z[k]), _mm512_set1_pd(factor));
    CORE_WEIGHT_ATAN_OTHERS(CORE_ADD_TERM)
#undef CORE_ADD_TERM
    for (int k = 0; k < 2; k++)
        angle[k] = _mm512_add_pd(
            s->turn[k], _mm512_add_pd(t[k], _mm512_mul_pd(t[k], _mm512_mul_pd(z[k], p[k]))));
}

CORE_IN_REGISTERS void core_store_four_rows(
    __m256d x, __m256d y, __m256d z, __m256d w, double (*rows)[4]) {
    const __m256d a = _mm256_unpacklo_pd(x, y), b = _mm256_unpackhi_pd(x, y),
                  c = _mm256_unpacklo_pd(z, w), d = _mm256_unpackhi_pd(z, w);
    _mm256_storeu_pd(rows[0], _mm256_permute2f128_pd(a, c, 0x20));
    _mm256_storeu_pd(rows[1], _mm256_permute2f128_pd(b, d, 0x20));
    _mm256_storeu_pd(rows[2], _mm256_permute2f128_pd(a, c, 0x31));
    _mm256_storeu_pd(rows[3], _mm256_permute2f128_pd(b, d, 0x31));
}

CORE_IN_REGISTERS void core_store_eight_rows(const __m512d xyz[3], __m512d w, double (*rows)[4]) {
    core_store_four_rows(_mm512_castpd512_pd256(xyz[0]), _mm512_castpd512_pd256(xyz[1]),
        _mm512_castpd512_pd256(xyz[2]), _mm512_castpd512_pd256(w), rows);
    core_store_four_rows(_mm512_extractf64x4_pd(xyz[0], 1), _mm512_extractf64x4_pd(xyz[1], 1),
        _mm512_extractf64x4_pd(xyz[2], 1), _mm512_extractf64x4_pd(w, 1), rows + 4);
}

/* core_lanes_arcs, core_lanes_corner_angles. */
CORE_IN_REGISTERS void core_weigh_eight(const core_sloped_eight *s, __m512d weight[3]) {
    __m512d angle[2];
    core_turn_eight(s, angle);
    const __m512d left = _mm512_sub_pd(_mm512_set1_pd(NORMA_PI), _mm512_add_pd(angle[0], angle[1]));
    const __m512d rest = _mm512_mask_blend_pd(
        s->third_is_least, _mm512_mask_blend_pd(s->second_is_least, left, angle[0]), angle[1]);
    const __m512d of_first = _mm512_mask_blend_pd(s->least_is_2, rest, angle[1]);
    weight[0] = _mm512_mask_blend_pd(s->first_is_0, angle[0], of_first);
    weight[1] = _mm512_mask_blend_pd(s->first_is_0, of_first, angle[0]);
    weight[2] = _mm512_mask_blend_pd(s->least_is_2, angle[1], rest);
}
#endif
#endif
