/* vectors_avx512.h: what measure_triangles.template.h and its like need of eight doubles in a
 * register of AVX-512. */
#ifndef NORMA_CORE_VECTORS_AVX512_H
#define NORMA_CORE_VECTORS_AVX512_H
#include "core/face/vectors_avx2.h"
#if defined(CORE_HAS_AVX512)

enum { CORE_AVX512_LANES = 8 };
typedef __m512d core_avx512_vector;
typedef __mmask8 core_avx512_mask;

CORE_IN_REGISTERS __m512d core_avx512_all(double x) { return _mm512_set1_pd(x); }
CORE_IN_REGISTERS __m512d core_avx512_negative(__m512d x) {
    return _mm512_xor_pd(x, _mm512_set1_pd(-0.0));
}
CORE_IN_REGISTERS __m512d core_avx512_root(__m512d x) { return _mm512_sqrt_pd(x); }

CORE_IN_REGISTERS __m512d core_avx512_lesser(__m512d a, __m512d b) { return _mm512_min_pd(a, b); }
CORE_IN_REGISTERS __m512d core_avx512_greater(__m512d a, __m512d b) { return _mm512_max_pd(a, b); }

CORE_IN_REGISTERS __mmask8 core_avx512_is_less(__m512d a, __m512d b) {
    return _mm512_cmp_pd_mask(a, b, _CMP_LT_OS);
}
CORE_IN_REGISTERS __mmask8 core_avx512_is_equal(__m512d a, __m512d b) {
    return _mm512_cmp_pd_mask(a, b, _CMP_EQ_OS);
}
CORE_IN_REGISTERS __mmask8 core_avx512_is_at_most(__m512d a, __m512d b) {
    return _mm512_cmp_pd_mask(a, b, _CMP_LE_OS);
}
CORE_IN_REGISTERS __mmask8 core_avx512_both(__mmask8 a, __mmask8 b) { return a & b; }
CORE_IN_REGISTERS __m512d core_avx512_choose(__mmask8 condition, __m512d yes, __m512d no) {
    return _mm512_mask_blend_pd(condition, no, yes);
}
CORE_IN_REGISTERS unsigned core_avx512_bits(__mmask8 mask) { return mask; }

CORE_IN_REGISTERS void core_avx512_store(double *at, __m512d x) { _mm512_storeu_pd(at, x); }

CORE_IN_REGISTERS void core_avx512_store_rows(
    __m512d x, __m512d y, __m512d z, __m512d w, double (*rows)[4]) {
    core_avx2_store_rows(_mm512_castpd512_pd256(x), _mm512_castpd512_pd256(y),
        _mm512_castpd512_pd256(z), _mm512_castpd512_pd256(w), rows);
    core_avx2_store_rows(_mm512_extractf64x4_pd(x, 1), _mm512_extractf64x4_pd(y, 1),
        _mm512_extractf64x4_pd(z, 1), _mm512_extractf64x4_pd(w, 1), rows + 4);
}

/* ---- positions of eight corners */

/* Three floats, and not a byte beyond them. */
CORE_IN_REGISTERS __m128 core_avx512_floats(const core_mesh *mesh, const unsigned char *index) {
    return _mm_maskz_loadu_ps(7, core_avx2_point(mesh, index));
}

/* Corners i and i + 4. */
CORE_IN_REGISTERS __m256 core_avx512_two(
    const core_mesh *mesh, const unsigned char *index, size_t step) {
    const __m128 low = core_avx512_floats(mesh, index),
                 high = core_avx512_floats(mesh, index + 4 * step);
    return _mm256_insertf128_ps(_mm256_castps128_ps256(low), high, 1);
}

CORE_IN_REGISTERS __m512d core_avx512_pairs(__m256d a, __m256d b, int high) {
    return _mm512_cvtps_pd(
        _mm256_castpd_ps(high ? _mm256_unpackhi_pd(a, b) : _mm256_unpacklo_pd(a, b)));
}

CORE_IN_REGISTERS void core_avx512_read_floats(
    const core_mesh *mesh, const unsigned char *index, size_t step, __m512d axis[3]) {
    const __m256 a = core_avx512_two(mesh, index, step),
                 b = core_avx512_two(mesh, index + step, step),
                 c = core_avx512_two(mesh, index + 2 * step, step),
                 d = core_avx512_two(mesh, index + 3 * step, step);
    const __m256d xy01 = _mm256_castps_pd(_mm256_unpacklo_ps(a, b)),
                  xy23 = _mm256_castps_pd(_mm256_unpacklo_ps(c, d)),
                  z01 = _mm256_castps_pd(_mm256_unpackhi_ps(a, b)),
                  z23 = _mm256_castps_pd(_mm256_unpackhi_ps(c, d));
    axis[0] = core_avx512_pairs(xy01, xy23, 0);
    axis[1] = core_avx512_pairs(xy01, xy23, 1);
    axis[2] = core_avx512_pairs(z01, z23, 0);
}

/* Three doubles, and not a byte beyond them. */
CORE_IN_REGISTERS __m256d core_avx512_doubles(const core_mesh *mesh, const unsigned char *index) {
    return _mm256_maskz_loadu_pd(7, core_avx2_point(mesh, index));
}

/* Corners i and i + 4. */
CORE_IN_REGISTERS __m512d core_avx512_two_rows(
    const core_mesh *mesh, const unsigned char *index, size_t step) {
    return _mm512_insertf64x4(_mm512_castpd256_pd512(core_avx512_doubles(mesh, index)),
        core_avx512_doubles(mesh, index + 4 * step), 1);
}

CORE_IN_REGISTERS void core_avx512_read_doubles(
    const core_mesh *mesh, const unsigned char *index, size_t step, __m512d axis[3]) {
    const __m512i low = _mm512_set_epi64(13, 12, 5, 4, 9, 8, 1, 0),
                  high = _mm512_set_epi64(15, 14, 7, 6, 11, 10, 3, 2);
    const __m512d scale = _mm512_set1_pd(mesh->scale);
    const __m512d a = core_avx512_two_rows(mesh, index, step),
                  b = core_avx512_two_rows(mesh, index + step, step),
                  c = core_avx512_two_rows(mesh, index + 2 * step, step),
                  d = core_avx512_two_rows(mesh, index + 3 * step, step);
    const __m512d x01 = _mm512_unpacklo_pd(a, b), x23 = _mm512_unpacklo_pd(c, d),
                  y01 = _mm512_unpackhi_pd(a, b), y23 = _mm512_unpackhi_pd(c, d);
    axis[0] = _mm512_permutex2var_pd(x01, low, x23) * scale;
    axis[1] = _mm512_permutex2var_pd(y01, low, y23) * scale;
    axis[2] = _mm512_permutex2var_pd(x01, high, x23) * scale;
}
#endif
#endif
