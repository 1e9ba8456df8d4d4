/* vectors_avx2.h: what measure_triangles.template.h and its like need of four doubles in a register
 * of AVX2. Sums, products and quotients are the compiler's own operators. */
#ifndef NORMA_CORE_VECTORS_AVX2_H
#define NORMA_CORE_VECTORS_AVX2_H
#include "core/call/call.h"
#if defined(CORE_HAS_X86)
#include "core/face/face.h"
#include "core/mesh/mesh.h"
#include <immintrin.h>

enum { CORE_AVX2_LANES = 4 };
typedef __m256d core_avx2_vector;
typedef __m256d core_avx2_mask;
#define CORE_IN_AVX2 CORE_FOR_AVX2 CORE_INLINE

CORE_IN_AVX2 __m256d core_avx2_all(double x) { return _mm256_set1_pd(x); }
CORE_IN_AVX2 __m256d core_avx2_negative(__m256d x) {
    return _mm256_xor_pd(x, _mm256_set1_pd(-0.0));
}
CORE_IN_AVX2 __m256d core_avx2_root(__m256d x) { return _mm256_sqrt_pd(x); }

/* a < b ? a : b, and a > b ? a : b */
CORE_IN_AVX2 __m256d core_avx2_lesser(__m256d a, __m256d b) { return _mm256_min_pd(a, b); }
CORE_IN_AVX2 __m256d core_avx2_greater(__m256d a, __m256d b) { return _mm256_max_pd(a, b); }

CORE_IN_AVX2 __m256d core_avx2_is_less(__m256d a, __m256d b) {
    return _mm256_cmp_pd(a, b, _CMP_LT_OS);
}
CORE_IN_AVX2 __m256d core_avx2_is_equal(__m256d a, __m256d b) {
    return _mm256_cmp_pd(a, b, _CMP_EQ_OS);
}
CORE_IN_AVX2 __m256d core_avx2_is_at_most(__m256d a, __m256d b) {
    return _mm256_cmp_pd(a, b, _CMP_LE_OS);
}
CORE_IN_AVX2 __m256d core_avx2_both(__m256d a, __m256d b) { return _mm256_and_pd(a, b); }
CORE_IN_AVX2 __m256d core_avx2_choose(__m256d condition, __m256d yes, __m256d no) {
    return _mm256_blendv_pd(no, yes, condition);
}
CORE_IN_AVX2 unsigned core_avx2_bits(__m256d mask) { return (unsigned)_mm256_movemask_pd(mask); }

CORE_IN_AVX2 void core_avx2_store(double *at, __m256d x) { _mm256_storeu_pd(at, x); }

/* The rows x[i], y[i], z[i], w[i]. */
CORE_IN_AVX2 void core_avx2_store_rows(
    __m256d x, __m256d y, __m256d z, __m256d w, double (*rows)[4]) {
    const __m256d a = _mm256_unpacklo_pd(x, y), b = _mm256_unpackhi_pd(x, y),
                  c = _mm256_unpacklo_pd(z, w), d = _mm256_unpackhi_pd(z, w);
    _mm256_storeu_pd(rows[0], _mm256_permute2f128_pd(a, c, 0x20));
    _mm256_storeu_pd(rows[1], _mm256_permute2f128_pd(b, d, 0x20));
    _mm256_storeu_pd(rows[2], _mm256_permute2f128_pd(a, c, 0x31));
    _mm256_storeu_pd(rows[3], _mm256_permute2f128_pd(b, d, 0x31));
}

/* ---- positions of four corners, named by indices each some corners behind the one before */

CORE_IN_AVX2 const unsigned char *core_avx2_point(
    const core_mesh *mesh, const unsigned char *index) {
    uint32_t at;
    memcpy(&at, index, sizeof at);
    return (const unsigned char *)mesh->positions.data + at * mesh->positions.stride;
}

/* Three floats, and not a byte beyond them. */
CORE_IN_AVX2 __m128 core_avx2_floats(const core_mesh *mesh, const unsigned char *index) {
    return _mm_maskload_ps(
        (const float *)(const void *)core_avx2_point(mesh, index), _mm_set_epi32(0, -1, -1, -1));
}

CORE_IN_AVX2 __m256d core_avx2_pairs(__m128d a, __m128d b, int high) {
    return _mm256_cvtps_pd(_mm_castpd_ps(high ? _mm_unpackhi_pd(a, b) : _mm_unpacklo_pd(a, b)));
}

CORE_IN_AVX2 void core_avx2_read_floats(
    const core_mesh *mesh, const unsigned char *index, size_t step, __m256d axis[3]) {
    const __m128 a = core_avx2_floats(mesh, index), b = core_avx2_floats(mesh, index + step),
                 c = core_avx2_floats(mesh, index + 2 * step),
                 d = core_avx2_floats(mesh, index + 3 * step);
    const __m128d xy01 = _mm_castps_pd(_mm_unpacklo_ps(a, b)),
                  xy23 = _mm_castps_pd(_mm_unpacklo_ps(c, d)),
                  z01 = _mm_castps_pd(_mm_unpackhi_ps(a, b)),
                  z23 = _mm_castps_pd(_mm_unpackhi_ps(c, d));
    axis[0] = core_avx2_pairs(xy01, xy23, 0);
    axis[1] = core_avx2_pairs(xy01, xy23, 1);
    axis[2] = core_avx2_pairs(z01, z23, 0);
}

/* Three doubles, and not a byte beyond them. */
CORE_IN_AVX2 __m256d core_avx2_doubles(const core_mesh *mesh, const unsigned char *index) {
    return _mm256_maskload_pd((const double *)(const void *)core_avx2_point(mesh, index),
        _mm256_set_epi64x(0, -1, -1, -1));
}

CORE_IN_AVX2 void core_avx2_read_doubles(
    const core_mesh *mesh, const unsigned char *index, size_t step, __m256d axis[3]) {
    const __m256d scale = _mm256_set1_pd(mesh->scale), a = core_avx2_doubles(mesh, index),
                  b = core_avx2_doubles(mesh, index + step),
                  c = core_avx2_doubles(mesh, index + 2 * step),
                  d = core_avx2_doubles(mesh, index + 3 * step);
    const __m256d xz01 = _mm256_unpacklo_pd(a, b), xz23 = _mm256_unpacklo_pd(c, d);
    axis[0] = _mm256_permute2f128_pd(xz01, xz23, 0x20) * scale;
    axis[1] =
        _mm256_permute2f128_pd(_mm256_unpackhi_pd(a, b), _mm256_unpackhi_pd(c, d), 0x20) * scale;
    axis[2] = _mm256_permute2f128_pd(xz01, xz23, 0x31) * scale;
}
#endif
#endif
