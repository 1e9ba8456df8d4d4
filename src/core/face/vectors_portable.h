/* vectors_portable.h: what measure_triangles.template.h and its like need where nothing is known of
 * the machine but what the compiler was told: two doubles in a register (SSE2, NEON, SIMD128), one
 * for compilers without vectors. */
#ifndef NORMA_CORE_VECTORS_PORTABLE_H
#define NORMA_CORE_VECTORS_PORTABLE_H
#include "core/face/eight_vectors.h"
#include <math.h>
#if defined(__SSE2__) && defined(CORE_HAS_SHUFFLES)
#include <emmintrin.h>
#elif defined(__wasm_simd128__)
#include <wasm_simd128.h>
#endif

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
    for (int x = 0; x < 3; x++) axis[x] = (core_d2){a[x], b[x]} * mesh->scale;
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
    for (int x = 0; x < 3; x++) axis[x] = (double)p[x];
    (void)step;
}

CORE_INLINE void core_portable_read_doubles(
    const core_mesh *mesh, const unsigned char *index, size_t step, double axis[3]) {
    double p[3];
    memcpy(p, core_portable_point(mesh, index), sizeof p);
    for (int x = 0; x < 3; x++) axis[x] = p[x] * mesh->scale;
    (void)step;
}
#endif
#endif
