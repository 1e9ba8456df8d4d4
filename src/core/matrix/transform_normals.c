/* transform_normals.c: a stream of normals through a matrix, each made unit again.
 *
 * Tight floats, the common case, go in blocks: taken apart into x, y and z, multiplied in double
 * precision, where the product of two floats is exact and the square of a length neither over- nor
 * underflows, and scaled by 1 / length. The same operations in the same order for every vector and
 * on every instruction set, hence the same bits. What is zero, not finite or near the ends of the
 * floats' range is done again one by one. What limits is instructions, not memory: stores past the
 * cache, which spare reading the output's lines, took a fifth longer. */
#include "core/call/instruction_set.h"
#include "core/matrix/stream.h"
#include "core/matrix/transform_normals_avx512.h"

enum { BLOCK = 64 };

typedef struct lanes {
    _Alignas(64) float x[BLOCK];
    float y[BLOCK], z[BLOCK];
} lanes;

/* ---- in between: x y z x y z ... and three rows */

#if defined(__GNUC__) && (defined(__clang__) || __GNUC__ >= 12)
typedef float four __attribute__((vector_size(16)));

/* Four vectors at a time, by shuffles that every instruction set has. */
CORE_INLINE void take_apart(const float *from, lanes *to) {
    for (size_t i = 0; i < BLOCK; i += 4) {
        four a, b, c; /* x0 y0 z0 x1, y1 z1 x2 y2, z2 x3 y3 z3 */
        memcpy(&a, from + 3 * i, sizeof a);
        memcpy(&b, from + 3 * i + 4, sizeof b);
        memcpy(&c, from + 3 * i + 8, sizeof c);
        const four bc = __builtin_shufflevector(b, c, 2, 3, 5, 6); /* x2 y2 x3 y3 */
        const four ab = __builtin_shufflevector(a, b, 1, 2, 4, 5); /* y0 z0 y1 z1 */
        const four x = __builtin_shufflevector(a, bc, 0, 3, 4, 6);
        const four y = __builtin_shufflevector(ab, bc, 0, 2, 5, 7);
        const four z = __builtin_shufflevector(ab, c, 1, 3, 4, 7);
        memcpy(to->x + i, &x, sizeof x);
        memcpy(to->y + i, &y, sizeof y);
        memcpy(to->z + i, &z, sizeof z);
    }
}

CORE_INLINE void put_together(const lanes *from, float *to) {
    for (size_t i = 0; i < BLOCK; i += 4) {
        four x, y, z;
        memcpy(&x, from->x + i, sizeof x);
        memcpy(&y, from->y + i, sizeof y);
        memcpy(&z, from->z + i, sizeof z);
        const four xy = __builtin_shufflevector(x, y, 0, 2, 4, 6); /* x0 x2 y0 y2 */
        const four yz = __builtin_shufflevector(y, z, 1, 3, 5, 7); /* y1 y3 z1 z3 */
        const four zx = __builtin_shufflevector(z, x, 0, 2, 5, 7); /* z0 z2 x1 x3 */
        const four a = __builtin_shufflevector(xy, zx, 0, 2, 4, 6);
        const four b = __builtin_shufflevector(yz, xy, 0, 2, 5, 7);
        const four c = __builtin_shufflevector(zx, yz, 1, 3, 5, 7);
        memcpy(to + 3 * i, &a, sizeof a);
        memcpy(to + 3 * i + 4, &b, sizeof b);
        memcpy(to + 3 * i + 8, &c, sizeof c);
    }
}
#else
CORE_INLINE void take_apart(const float *from, lanes *to) {
    for (size_t i = 0; i < BLOCK; i++) {
        to->x[i] = from[3 * i];
        to->y[i] = from[3 * i + 1];
        to->z[i] = from[3 * i + 2];
    }
}

CORE_INLINE void put_together(const lanes *from, float *to) {
    for (size_t i = 0; i < BLOCK; i++) {
        to[3 * i] = from->x[i];
        to[3 * i + 1] = from->y[i];
        to[3 * i + 2] = from->z[i];
    }
}
#endif

/* ---- one block */

/* A float's root and quotient are quick; one step of Newton's method squares their error, to below
 * 2^-43. */
CORE_INLINE float about_one_over_length(float square) { return 1.0f / sqrtf(square); }

CORE_INLINE double one_over_length(double exact_square, float rounded) {
    const double about = (double)rounded;
    return about * (1.5 - 0.5 * exact_square * (about * about));
}

/* What is between a block's normals and their units. */
typedef struct products {
    _Alignas(64) double x[BLOCK];
    double y[BLOCK], z[BLOCK], exact_square[BLOCK];
    float square[BLOCK], about[BLOCK]; /* rounded; about one over its root */
} products;

/* Three loops without a branch, which compilers make vector code of: one that did it all was a
 * chain of so many steps that the processor could not see the next vectors' beginning. Nonzero:
 * some squared length is not safely within the floats. */
CORE_INLINE int products_of_block(const double m[9], const lanes *in, products *p) {
    int unsafe = 0;
    for (int i = 0; i < BLOCK; i++) {
        const double a = (double)in->x[i], b = (double)in->y[i], c = (double)in->z[i];
        const double x = m[0] * a + m[3] * b + m[6] * c, y = m[1] * a + m[4] * b + m[7] * c,
                     z = m[2] * a + m[5] * b + m[8] * c;
        p->x[i] = x;
        p->y[i] = y;
        p->z[i] = z;
        p->exact_square[i] = x * x + y * y + z * z;
        p->square[i] = (float)p->exact_square[i];
    }
    for (int i = 0; i < BLOCK; i++)
        unsafe |= !(p->square[i] >= 0x1p-120f) | !(p->square[i] <= 0x1p120f);
    return unsafe;
}

CORE_INLINE void units_of_block(products *p, lanes *out) {
    for (int i = 0; i < BLOCK; i++) p->about[i] = about_one_over_length(p->square[i]);
    for (int i = 0; i < BLOCK; i++) {
        const double factor = one_over_length(p->exact_square[i], p->about[i]);
        out->x[i] = (float)(p->x[i] * factor);
        out->y[i] = (float)(p->y[i] * factor);
        out->z[i] = (float)(p->z[i] * factor);
    }
}

/* Whole blocks, up to the first with a vector that is to be done by itself. Returns how many
 * vectors were done. in and out may be the same. */
CORE_INLINE size_t units_of_blocks(const double m[9], const float *in, size_t count, float *out) {
    lanes vectors;
    products between;
    size_t done = 0;
    for (; count - done >= BLOCK; done += BLOCK) {
        take_apart(in + 3 * done, &vectors);
        if (products_of_block(m, &vectors, &between)) break;
        units_of_block(&between, &vectors);
        put_together(&vectors, out + 3 * done);
    }
    return done;
}

typedef size_t block_kernel(const double m[9], const float *in, size_t count, float *out);
static size_t units_portable(const double m[9], const float *in, size_t count, float *out) {
    return units_of_blocks(m, in, count, out);
}
#if defined(CORE_HAS_X86)
CORE_FOR_AVX2 static size_t units_avx2(
    const double m[9], const float *in, size_t count, float *out) {
    return units_of_blocks(m, in, count, out);
}
#if defined(CORE_HAS_AVX512)
static size_t units_avx512(const double m[9], const float *in, size_t count, float *out) {
    return norma_core_units_avx512(m, in, count, out);
}
#endif
#endif

static block_kernel *choose_kernel(void) {
    static block_kernel *const kernels[] = CORE_KERNELS(units);
    return kernels[norma_core_level(NORMA_ISA_BEST)];
}

/* ---- one vector */

/* Near the ends of the doubles' range: scaled first. Zero and what is not finite give zero. */
static void unit_of_any_size(const double m[9], const double in[3], float out[3]) {
    double n[3] = {in[0], in[1], in[2]}, v[3];
    out[0] = out[1] = out[2] = 0.0f;
    if (!norma_vec3_scale(n)) return;
    for (int r = 0; r < 3; r++) v[r] = m[r] * n[0] + m[3 + r] * n[1] + m[6 + r] * n[2];
    if (!norma_vec3_unit(v)) return;
    for (int r = 0; r < 3; r++) out[r] = (float)v[r];
}

/* The same operations as in a block. */
static void unit_of_one(const double m[9], const double in[3], float out[3]) {
    double v[3];
    for (int r = 0; r < 3; r++) v[r] = m[r] * in[0] + m[3 + r] * in[1] + m[6 + r] * in[2];
    const double exact_square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    const float square = (float)exact_square;
    if (!(square >= 0x1p-120f && square <= 0x1p120f)) {
        unit_of_any_size(m, in, out);
        return;
    }
    const double factor = one_over_length(exact_square, about_one_over_length(square));
    for (int r = 0; r < 3; r++) out[r] = (float)(v[r] * factor);
}

static void units_one_by_one(const double m[9], const norma_vec3_view *in, size_t first, size_t end,
    unsigned char *out, size_t out_stride) {
    for (size_t i = first; i < end; i++) {
        double v[3];
        float unit[3];
        norma_view_read(in, i, v);
        unit_of_one(m, v, unit);
        memcpy(out + i * out_stride, unit, sizeof unit);
    }
}

norma_result norma_transform_normals(const float normal_matrix[9], norma_vec3_view in, float *out,
    size_t out_stride, size_t capacity) {
    if (!normal_matrix) return NORMA_ERROR_ARGUMENT;
    norma_result result = norma_input_check(&in);
    if (!result) result = norma_output_check(out, &out_stride, 3 * sizeof *out, in.count, capacity);
    if (result) return result;
    double m[9];
    for (int i = 0; i < 9; i++) m[i] = (double)normal_matrix[i];
    const int blocks = in.format == NORMA_FORMAT_FLOAT && norma_view_stride(&in) == 12 &&
                       out_stride == 12 && (uintptr_t)in.data % sizeof(float) == 0 &&
                       (uintptr_t)out % sizeof(float) == 0;
    block_kernel *kernel = choose_kernel();
    for (size_t done = 0; done < in.count;) {
        if (blocks)
            done += kernel(m, (const float *)in.data + 3 * done, in.count - done, out + 3 * done);
        const size_t end = blocks && in.count - done > BLOCK ? done + BLOCK : in.count;
        units_one_by_one(m, &in, done, end, (unsigned char *)out, out_stride);
        done = end;
    }
    return NORMA_OK;
}
