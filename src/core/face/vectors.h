/* vectors.h: what face_kernel.template.h and its like need of a register of doubles: eight in one
 * of AVX-512, four of AVX2, and where nothing is known of the machine but what the compiler was
 * told two (SSE2, NEON, SIMD128), or one for compilers without vectors. Sums, products and
 * quotients are the compiler's own operators. */
#ifndef NORMA_CORE_FACE_VECTORS_H
#define NORMA_CORE_FACE_VECTORS_H
#include "core/face/eight_vectors.h"
#include <math.h>
#if defined(CORE_HAS_X86)
#include <immintrin.h>
#elif defined(__SSE2__) && defined(CORE_HAS_SHUFFLES)
#include <emmintrin.h>
#elif defined(__wasm_simd128__)
#include <wasm_simd128.h>
#endif

/* ---- two or one */

CORE_INLINE const unsigned char *core_portable_point(
    const core_mesh *mesh, const unsigned char *index) {
    uint32_t at;
    memcpy(&at, index, sizeof at);
    return (const unsigned char *)mesh->positions.data + at * mesh->positions.stride;
}

#if defined(CORE_HAS_SHUFFLES)
enum { CORE_PORTABLE_LANES = 2 };
typedef core_d2 core_portable_vector;
typedef long long core_portable_mask __attribute__((vector_size(16)));

CORE_INLINE core_d2 core_portable_all(double x) { return (core_d2){x, x}; }
CORE_INLINE core_d2 core_portable_negative(core_d2 x) { return -x; }
CORE_INLINE core_portable_mask core_portable_is_less(core_d2 a, core_d2 b) {
    return (core_portable_mask)(a < b);
}
CORE_INLINE core_portable_mask core_portable_is_equal(core_d2 a, core_d2 b) {
    return (core_portable_mask)(a == b);
}
CORE_INLINE core_portable_mask core_portable_is_at_most(core_d2 a, core_d2 b) {
    return (core_portable_mask)(a <= b);
}
CORE_INLINE core_portable_mask core_portable_both(core_portable_mask a, core_portable_mask b) {
    return a & b;
}
CORE_INLINE core_d2 core_portable_choose(core_portable_mask condition, core_d2 yes, core_d2 no) {
    return (core_d2)((condition & (core_portable_mask)yes) | (~condition & (core_portable_mask)no));
}

/* a < b ? a : b, and a > b ? a : b */
#if defined(__SSE2__)
CORE_INLINE core_d2 core_portable_lesser(core_d2 a, core_d2 b) { return _mm_min_pd(a, b); }
CORE_INLINE core_d2 core_portable_greater(core_d2 a, core_d2 b) { return _mm_max_pd(a, b); }
CORE_INLINE core_d2 core_portable_root(core_d2 x) { return _mm_sqrt_pd(x); }
CORE_INLINE unsigned core_portable_bits(core_portable_mask mask) {
    return (unsigned)_mm_movemask_pd((__m128d)mask);
}
#elif defined(__wasm_simd128__)
CORE_INLINE core_d2 core_portable_lesser(core_d2 a, core_d2 b) {
    return (core_d2)wasm_f64x2_pmin((v128_t)b, (v128_t)a);
}
CORE_INLINE core_d2 core_portable_greater(core_d2 a, core_d2 b) {
    return (core_d2)wasm_f64x2_pmax((v128_t)b, (v128_t)a);
}
CORE_INLINE core_d2 core_portable_root(core_d2 x) { return (core_d2)wasm_f64x2_sqrt((v128_t)x); }
CORE_INLINE unsigned core_portable_bits(core_portable_mask mask) {
    return wasm_i64x2_bitmask((v128_t)mask);
}
#else
CORE_INLINE core_d2 core_portable_lesser(core_d2 a, core_d2 b) {
    return core_portable_choose(core_portable_is_less(a, b), a, b);
}
CORE_INLINE core_d2 core_portable_greater(core_d2 a, core_d2 b) {
    return core_portable_choose(core_portable_is_less(b, a), a, b);
}
CORE_INLINE core_d2 core_portable_root(core_d2 x) { return (core_d2){sqrt(x[0]), sqrt(x[1])}; }
CORE_INLINE unsigned core_portable_bits(core_portable_mask mask) {
    return (unsigned)((mask[0] & 1) | (mask[1] & 2));
}
#endif

CORE_INLINE core_d2 core_portable_load(const double *at) {
    core_d2 x;
    memcpy(&x, at, sizeof x);
    return x;
}
CORE_INLINE void core_portable_store(double *at, core_d2 x) { memcpy(at, &x, sizeof x); }

CORE_INLINE core_d2 core_portable_firsts(core_d2 a, core_d2 b) {
    return __builtin_shufflevector(a, b, 0, 2);
}
CORE_INLINE core_d2 core_portable_seconds(core_d2 a, core_d2 b) {
    return __builtin_shufflevector(a, b, 1, 3);
}

/* The rows x[i], y[i], z[i], w[i]. */
CORE_INLINE void core_portable_store_rows(
    core_d2 x, core_d2 y, core_d2 z, core_d2 w, double (*rows)[4]) {
    core_portable_store(rows[0], core_portable_firsts(x, y));
    core_portable_store(rows[0] + 2, core_portable_firsts(z, w));
    core_portable_store(rows[1], core_portable_seconds(x, y));
    core_portable_store(rows[1] + 2, core_portable_seconds(z, w));
}

/* Two floats. */
CORE_INLINE core_d2 core_portable_xy(const unsigned char *at) {
    typedef float two_floats __attribute__((vector_size(8)));
    two_floats xy;
    memcpy(&xy, at, sizeof xy);
    return __builtin_convertvector(xy, core_d2);
}

CORE_INLINE double core_portable_z(const unsigned char *at) {
    float z;
    memcpy(&z, at + 2 * sizeof z, sizeof z);
    return (double)z;
}

/* The positions of corners that are named by indices step bytes apart. */
CORE_INLINE void core_portable_read_floats(
    const core_mesh *mesh, const unsigned char *index, size_t step, core_d2 axis[3]) {
    const unsigned char *a = core_portable_point(mesh, index),
                        *b = core_portable_point(mesh, index + step);
    const core_d2 xy0 = core_portable_xy(a), xy1 = core_portable_xy(b);
    axis[0] = core_portable_firsts(xy0, xy1);
    axis[1] = core_portable_seconds(xy0, xy1);
    axis[2] = (core_d2){core_portable_z(a), core_portable_z(b)};
}

CORE_INLINE void core_portable_read_doubles(
    const core_mesh *mesh, const unsigned char *index, size_t step, core_d2 axis[3]) {
    double a[3], b[3];
    memcpy(a, core_portable_point(mesh, index), sizeof a);
    memcpy(b, core_portable_point(mesh, index + step), sizeof b);
    for (int x = 0; x < 3; ++x) axis[x] = (core_d2){a[x], b[x]} * mesh->scale;
}
#else
enum { CORE_PORTABLE_LANES = 1 };
typedef double core_portable_vector;
typedef int core_portable_mask;

CORE_INLINE double core_portable_all(double x) { return x; }
CORE_INLINE double core_portable_negative(double x) { return -x; }
CORE_INLINE double core_portable_root(double x) { return sqrt(x); }
CORE_INLINE double core_portable_lesser(double a, double b) { return a < b ? a : b; }
CORE_INLINE double core_portable_greater(double a, double b) { return a > b ? a : b; }
CORE_INLINE int core_portable_is_less(double a, double b) { return a < b; }
CORE_INLINE int core_portable_is_equal(double a, double b) { return a == b; }
CORE_INLINE int core_portable_is_at_most(double a, double b) { return a <= b; }
CORE_INLINE int core_portable_both(int a, int b) { return a & b; }
CORE_INLINE double core_portable_choose(int condition, double yes, double no) {
    return condition ? yes : no;
}
CORE_INLINE unsigned core_portable_bits(int mask) { return (unsigned)mask; }
CORE_INLINE double core_portable_load(const double *at) { return *at; }
CORE_INLINE void core_portable_store(double *at, double x) { *at = x; }
CORE_INLINE void core_portable_store_rows(
    double x, double y, double z, double w, double (*rows)[4]) {
    rows[0][0] = x;
    rows[0][1] = y;
    rows[0][2] = z;
    rows[0][3] = w;
}

CORE_INLINE void core_portable_read_floats(
    const core_mesh *mesh, const unsigned char *index, size_t step, double axis[3]) {
    float p[3];
    memcpy(p, core_portable_point(mesh, index), sizeof p);
    for (int x = 0; x < 3; ++x) axis[x] = (double)p[x];
    (void)step;
}

CORE_INLINE void core_portable_read_doubles(
    const core_mesh *mesh, const unsigned char *index, size_t step, double axis[3]) {
    double p[3];
    memcpy(p, core_portable_point(mesh, index), sizeof p);
    for (int x = 0; x < 3; ++x) axis[x] = p[x] * mesh->scale;
    (void)step;
}
#endif

/* ---- four */

#if defined(CORE_HAS_X86)
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

CORE_IN_AVX2 __m256d core_avx2_load(const double *at) { return _mm256_loadu_pd(at); }
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

/* ---- eight */

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

CORE_IN_REGISTERS __m512d core_avx512_load(const double *at) { return _mm512_loadu_pd(at); }
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
