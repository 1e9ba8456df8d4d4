/* transform.c: normals, tangents and positions through matrices. */
#include "core/matrix/matrix.h"
#include "core/face/eight_vectors.h"

/* ---- Sixteen normals through a matrix in the registers of AVX-512, from
 * the line they are read from to the one they are written to. The numbers and their bits are those
 * of the loops over blocks below, step by step; it is said once more here because a compiler that
 * makes instructions of loops over a block writes what each step leaves and reads it again: 50
 * cycles for eight normals against 38. */

#if defined(CORE_HAS_AVX512)
#include <immintrin.h>

/* Of 48 numbers in three registers, x y z x y z ..., those of one axis lie at places that are each
 * another: one from each, then in order. */
enum {
    FIRST_THIRD = 0x9249,
    SECOND_THIRD = 0x4924,
    LAST_THIRD = 0x2492
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
    axis[0] = _mm512_permutexvar_ps(places(3, 0), of_three(a, b, SECOND_THIRD, c, LAST_THIRD));
    axis[1] = _mm512_permutexvar_ps(places(3, 1), of_three(a, b, FIRST_THIRD, c, SECOND_THIRD));
    axis[2] = _mm512_permutexvar_ps(places(3, 2), of_three(a, b, LAST_THIRD, c, FIRST_THIRD));
}

CORE_IN_REGISTERS void put_axes_together(const __m512 axis[3], float *to) {
    const __m512 x = _mm512_permutexvar_ps(places(11, 0), axis[0]),
                 y = _mm512_permutexvar_ps(places(11, 16 - 11), axis[1]),
                 z = _mm512_permutexvar_ps(places(11, 32 - 22), axis[2]);
    _mm512_storeu_ps(to, of_three(x, y, LAST_THIRD, z, SECOND_THIRD));
    _mm512_storeu_ps(to + 16, of_three(x, y, FIRST_THIRD, z, LAST_THIRD));
    _mm512_storeu_ps(to + 32, of_three(x, y, SECOND_THIRD, z, FIRST_THIRD));
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
    for (int r = 0; r < 3; ++r)
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
    for (int k = 0; k < 3; ++k)
        v[k] = as_floats(_mm512_mul_pd(o->low.axis[k], low), _mm512_mul_pd(o->high.axis[k], high));
    put_axes_together(v, out);
}

/* The next sixteen are multiplied while the root and the quotient of these are under way: what
 * waits for them would fill the processor's registers before it saw that far ahead. */
static CORE_FOR_AVX512 size_t core_units_avx512(
    const double matrix[9], const float *in, size_t count, float *out) {
    __m512d m[9];
    opened_sixteen o, next;
    size_t done = 0;
    for (int i = 0; i < 9; ++i) m[i] = _mm512_set1_pd(matrix[i]);
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

/* ---- A stream of normals through a matrix, each made unit again.
 *
 * Tight floats, the common case, go in blocks: taken apart into x, y and z, multiplied in double
 * precision, where the product of two floats is exact and the square of a length neither over- nor
 * underflows, and scaled by 1 / length. The same operations in the same order for every vector and
 * on every instruction set, hence the same bits. What is zero, not finite or near the ends of the
 * floats' range is done again one by one. What limits is instructions, not memory: stores past the
 * cache, which spare reading the output's lines, took a fifth longer. */

enum { NORMALS_IN_BLOCK = 64 };

typedef struct lanes {
    _Alignas(64) float x[NORMALS_IN_BLOCK];
    float y[NORMALS_IN_BLOCK], z[NORMALS_IN_BLOCK];
} lanes;

/* ---- one block */

/* A float's root and quotient are quick; one step of Newton's method squares their error, to below
 * 2^-43. */
CORE_INLINE float about_one_over_length(float square) { return 1.0f / sqrtf(square); }

CORE_INLINE double one_over_length_of(double exact_square, float rounded) {
    const double about = (double)rounded;
    return about * (1.5 - 0.5 * exact_square * (about * about));
}

/* What is between a block's normals and their units. */
typedef struct products {
    _Alignas(64) double x[NORMALS_IN_BLOCK];
    double y[NORMALS_IN_BLOCK], z[NORMALS_IN_BLOCK], exact_square[NORMALS_IN_BLOCK];
    float square[NORMALS_IN_BLOCK], about[NORMALS_IN_BLOCK]; /* rounded; about one over its root */
} products;

/* Three loops without a branch, which compilers make vector code of: one that did it all was a
 * chain of so many steps that the processor could not see the next vectors' beginning. Nonzero:
 * some squared length is not safely within the floats. */
CORE_INLINE int products_of_block(const double m[9], const lanes *in, products *p) {
    int unsafe = 0;
    for (int i = 0; i < NORMALS_IN_BLOCK; ++i) {
        const double a = (double)in->x[i], b = (double)in->y[i], c = (double)in->z[i];
        const double x = m[0] * a + m[3] * b + m[6] * c, y = m[1] * a + m[4] * b + m[7] * c,
                     z = m[2] * a + m[5] * b + m[8] * c;
        p->x[i] = x;
        p->y[i] = y;
        p->z[i] = z;
        p->exact_square[i] = x * x + y * y + z * z;
        p->square[i] = (float)p->exact_square[i];
    }
    for (int i = 0; i < NORMALS_IN_BLOCK; ++i)
        unsafe |= !(p->square[i] >= 0x1p-120f) | !(p->square[i] <= 0x1p120f);
    return unsafe;
}

CORE_INLINE void units_of_block(products *p, lanes *out) {
    for (int i = 0; i < NORMALS_IN_BLOCK; ++i) p->about[i] = about_one_over_length(p->square[i]);
    for (int i = 0; i < NORMALS_IN_BLOCK; ++i) {
        const double factor = one_over_length_of(p->exact_square[i], p->about[i]);
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
    for (; count - done >= NORMALS_IN_BLOCK; done += NORMALS_IN_BLOCK) {
        core_threes_to_lanes(in + 3 * done, NORMALS_IN_BLOCK, vectors.x, vectors.y, vectors.z);
        if (products_of_block(m, &vectors, &between)) break;
        units_of_block(&between, &vectors);
        core_lanes_to_threes(vectors.x, vectors.y, vectors.z, NORMALS_IN_BLOCK, out + 3 * done);
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
    return core_units_avx512(m, in, count, out);
}
#endif
#endif

static block_kernel *choose_unit_kernel(void) {
    static block_kernel *const kernels[] = CORE_KERNELS(units);
    return kernels[norma_core_level(NORMA_ISA_BEST)];
}

/* ---- one vector */

/* Near the ends of the doubles' range: scaled first. Zero and what is not finite give zero. */
static void unit_of_any_size(const double m[9], const double in[3], float out[3]) {
    double n[3] = {in[0], in[1], in[2]}, v[3];
    out[0] = out[1] = out[2] = 0.0f;
    if (!norma_vec3_scale(n)) return;
    for (int r = 0; r < 3; ++r) v[r] = m[r] * n[0] + m[3 + r] * n[1] + m[6 + r] * n[2];
    if (!norma_vec3_unit(v)) return;
    for (int r = 0; r < 3; ++r) out[r] = (float)v[r];
}

/* The same operations as in a block. */
static void unit_of_one(const double m[9], const double in[3], float out[3]) {
    double v[3];
    for (int r = 0; r < 3; ++r) v[r] = m[r] * in[0] + m[3 + r] * in[1] + m[6 + r] * in[2];
    const double exact_square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    const float square = (float)exact_square;
    if (!(square >= 0x1p-120f && square <= 0x1p120f)) {
        unit_of_any_size(m, in, out);
        return;
    }
    const double factor = one_over_length_of(exact_square, about_one_over_length(square));
    for (int r = 0; r < 3; ++r) out[r] = (float)(v[r] * factor);
}

static void units_one_by_one(const double m[9], const norma_vec3_view *in, size_t first, size_t end,
    unsigned char *out, size_t out_stride) {
    for (size_t i = first; i < end; ++i) {
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
    for (int i = 0; i < 9; ++i) m[i] = (double)normal_matrix[i];
    const int blocks = in.format == NORMA_FORMAT_FLOAT && norma_view_stride(&in) == 12 &&
                       out_stride == 12 && (uintptr_t)in.data % sizeof(float) == 0 &&
                       (uintptr_t)out % sizeof(float) == 0;
    block_kernel *kernel = choose_unit_kernel();
    for (size_t done = 0; done < in.count;) {
        if (blocks)
            done += kernel(m, (const float *)in.data + 3 * done, in.count - done, out + 3 * done);
        const size_t end =
            blocks && in.count - done > NORMALS_IN_BLOCK ? done + NORMALS_IN_BLOCK : in.count;
        units_one_by_one(m, &in, done, end, (unsigned char *)out, out_stride);
        done = end;
    }
    return NORMA_OK;
}

/* ---- Streams of positions through a matrix.
 *
 * Blocks of vectors are taken apart into x, y and z, worked on in double precision, and put
 * together again: loops of one fixed length that compilers turn into vector instructions, with the
 * same operations in the same order for every vector, hence the same bits. In double precision the
 * product of two floats is exact. */

enum { POSITIONS_IN_BLOCK = 16 };

typedef struct block {
    double x[POSITIONS_IN_BLOCK], y[POSITIONS_IN_BLOCK], z[POSITIONS_IN_BLOCK];
} block;

static void load_block_floats(const unsigned char *from, size_t stride, size_t count, block *b) {
    for (size_t i = 0; i < count; ++i, from += stride) {
        float v[3];
        memcpy(v, from, sizeof v);
        b->x[i] = (double)v[0];
        b->y[i] = (double)v[1];
        b->z[i] = (double)v[2];
    }
}

static void load_tight_floats(const unsigned char *from, block *b) {
    float v[3 * POSITIONS_IN_BLOCK];
    memcpy(v, from, sizeof v);
    for (size_t i = 0; i < POSITIONS_IN_BLOCK; ++i) {
        b->x[i] = (double)v[3 * i];
        b->y[i] = (double)v[3 * i + 1];
        b->z[i] = (double)v[3 * i + 2];
    }
}

/* count is POSITIONS_IN_BLOCK but at the end of the stream; the lanes beyond it keep harmless old
 * numbers. */
static inline void load_block(const norma_vec3_view *in, size_t first, size_t count, block *b) {
    const size_t stride = norma_view_stride(in);
    const unsigned char *from = (const unsigned char *)in->data + first * stride;
    if (in->format == NORMA_FORMAT_FLOAT) {
        if (stride == 12 && count == POSITIONS_IN_BLOCK)
            load_tight_floats(from, b);
        else
            load_block_floats(from, stride, count, b);
        return;
    }
    for (size_t i = 0; i < count; ++i) {
        double v[3];
        norma_view_read(in, first + i, v);
        b->x[i] = v[0];
        b->y[i] = v[1];
        b->z[i] = v[2];
    }
}

static inline void store_block(const block *b, size_t count, unsigned char *to, size_t stride) {
    if (stride == 12 && count == POSITIONS_IN_BLOCK) {
        float v[3 * POSITIONS_IN_BLOCK];
        for (size_t i = 0; i < POSITIONS_IN_BLOCK; ++i) {
            v[3 * i] = (float)b->x[i];
            v[3 * i + 1] = (float)b->y[i];
            v[3 * i + 2] = (float)b->z[i];
        }
        memcpy(to, v, sizeof v);
        return;
    }
    for (size_t i = 0; i < count; ++i, to += stride) {
        const float v[3] = {(float)b->x[i], (float)b->y[i], (float)b->z[i]};
        memcpy(to, v, sizeof v);
    }
}

static void store_doubles(const block *b, size_t count, unsigned char *to, size_t stride) {
    for (size_t i = 0; i < count; ++i, to += stride)
        memcpy(to, (const double[]){b->x[i], b->y[i], b->z[i]}, 3 * sizeof(double));
}

static void positions_of_block(const double a[16], block *b) {
    for (int i = 0; i < POSITIONS_IN_BLOCK; ++i) {
        const double x = b->x[i], y = b->y[i], z = b->z[i];
        b->x[i] = a[0] * x + a[4] * y + a[8] * z + a[12];
        b->y[i] = a[1] * x + a[5] * y + a[9] * z + a[13];
        b->z[i] = a[2] * x + a[6] * y + a[10] * z + a[14];
    }
}

/* size: of one number of the output. */
static norma_result transform(const double model[16], const norma_vec3_view *in, unsigned char *out,
    size_t stride, size_t size, size_t capacity) {
    if (!model) return NORMA_ERROR_ARGUMENT;
    norma_result result = norma_input_check(in);
    if (!result) result = norma_output_check(out, &stride, 3 * size, in->count, capacity);
    if (result) return result;
    double a[16];
    memcpy(a, model, sizeof a);
    block b = {{0}, {0}, {0}};
    for (size_t first = 0; first < in->count; first += POSITIONS_IN_BLOCK) {
        const size_t count =
            in->count - first < POSITIONS_IN_BLOCK ? in->count - first : POSITIONS_IN_BLOCK;
        load_block(in, first, count, &b);
        positions_of_block(a, &b);
        if (size == sizeof(float))
            store_block(&b, count, out + first * stride, stride);
        else
            store_doubles(&b, count, out + first * stride, stride);
    }
    return NORMA_OK;
}

norma_result norma_transform_positions(
    const double model[16], norma_vec3_view in, float *out, size_t out_stride, size_t capacity) {
    return transform(model, &in, (unsigned char *)out, out_stride, sizeof *out, capacity);
}

norma_result norma_transform_positions_double(
    const double model[16], norma_vec3_view in, double *out, size_t out_stride, size_t capacity) {
    return transform(model, &in, (unsigned char *)out, out_stride, sizeof *out, capacity);
}

/* ---- Tangents with their sign through a matrix, and made perpendicular to
 * normals.
 *
 * A tangent is a vector: it goes through M itself, never through the normal matrix, and is then
 * made perpendicular to the new normal (Gram-Schmidt). The sign, which gives the bitangent as sign
 * * cross(normal, tangent), turns where M mirrors. */

/* Any unit vector perpendicular to the unit vector n: the axis that n leans on least, made
 * perpendicular. */
static void perpendicular_to(const double n[3], double out[3]) {
    int axis = 0;
    for (int i = 1; i < 3; ++i)
        if (fabs(n[i]) < fabs(n[axis])) axis = i;
    for (int i = 0; i < 3; ++i) out[i] = (i == axis ? 1.0 : 0.0) - n[axis] * n[i];
    (void)norma_vec3_unit(out);
}

void norma_core_perpendicular_tangent(
    const double normal[3], const double tangent[3], double out[3]) {
    double n[3] = {normal[0], normal[1], normal[2]}, t[3] = {tangent[0], tangent[1], tangent[2]};
    const int has_normal = norma_vec3_unit(n), has_tangent = norma_vec3_unit(t);
    if (!has_normal) {
        for (int i = 0; i < 3; ++i) out[i] = has_tangent ? t[i] : (i == 0 ? 1.0 : 0.0);
        return;
    }
    if (has_tangent) {
        const double along = norma_core_dot(n, t);
        for (int i = 0; i < 3; ++i) out[i] = t[i] - along * n[i];
        if (norma_core_dot(out, out) > NOTHING_LEFT * NOTHING_LEFT) {
            (void)norma_vec3_unit(out);
            return;
        }
    }
    perpendicular_to(n, out);
}

typedef struct tangent_stream {
    const float *tangents;
    size_t stride;
    const norma_vec3_view *normals;
    size_t count;
    float *out;
    size_t out_stride;
} tangent_stream;

static norma_result check_tangent_stream(tangent_stream *s, size_t capacity) {
    norma_result result = norma_input_check(s->normals);
    if (result || !s->count) return result;
    if (!s->tangents || s->normals->count < s->count) return NORMA_ERROR_ARGUMENT;
    if (!s->stride) s->stride = 4 * sizeof(float);
    if (s->count > SIZE_MAX / s->stride) return NORMA_ERROR_OVERFLOW;
    return norma_output_check(s->out, &s->out_stride, 4 * sizeof(float), s->count, capacity);
}

/* linear: nine numbers, column after column, or NULL for tangents that stay where they are. */
static void run_tangents(const tangent_stream *s, const double *linear, float sign) {
    for (size_t i = 0; i < s->count; ++i) {
        float in[4], out[4];
        memcpy(in, (const unsigned char *)s->tangents + i * s->stride, sizeof in);
        double t[3] = {(double)in[0], (double)in[1], (double)in[2]}, moved[3], normal[3], unit[3];
        for (int r = 0; r < 3; ++r)
            moved[r] =
                linear ? linear[r] * t[0] + linear[3 + r] * t[1] + linear[6 + r] * t[2] : t[r];
        norma_view_read(s->normals, i, normal);
        norma_core_perpendicular_tangent(normal, moved, unit);
        for (int r = 0; r < 3; ++r) out[r] = (float)unit[r];
        out[3] = in[3] * sign;
        memcpy((unsigned char *)s->out + i * s->out_stride, out, sizeof out);
    }
}

norma_result norma_transform_tangents(const float model[16], const float *tangents,
    size_t tangent_stride, norma_vec3_view normals, size_t count, float *out, size_t out_stride,
    size_t capacity) {
    tangent_stream s = {tangents, tangent_stride, &normals, count, out, out_stride};
    double linear[9];
    if (!model || !norma_matrix_upper_float(model, linear)) return NORMA_ERROR_ARGUMENT;
    const norma_result result = check_tangent_stream(&s, capacity);
    if (result) return result;
    run_tangents(&s, linear, norma_exact_determinant(linear).mantissa < 0.0 ? -1.0f : 1.0f);
    return NORMA_OK;
}

norma_result norma_orthogonalise_tangents(const float *tangents, size_t tangent_stride,
    norma_vec3_view normals, size_t count, float *out, size_t out_stride, size_t capacity) {
    tangent_stream s = {tangents, tangent_stride, &normals, count, out, out_stride};
    const norma_result result = check_tangent_stream(&s, capacity);
    if (!result) run_tangents(&s, NULL, 1.0f);
    return result;
}

/* ---- The normal inside a face (Phong 1975, p. 314): the corners' normals summed by
 * barycentric weights, made unit again. */

#define CANCELLED 0x1p-20 /* of the sum's terms: below it the sum's direction is rounding */

norma_result norma_interpolate_normal(const float a[3], const float b[3], const float c[3],
    const float barycentric[3], float normal[3]) {
    if (!a || !b || !c || !barycentric || !normal) return NORMA_ERROR_ARGUMENT;
    const float *corner[3] = {a, b, c};
    double sum[3] = {0.0, 0.0, 0.0}, terms = 0.0;
    for (int k = 0; k < 3; ++k) {
        double term[3];
        for (int i = 0; i < 3; ++i) {
            term[i] = (double)corner[k][i] * (double)barycentric[k];
            sum[i] += term[i];
        }
        terms += sqrt(norma_core_dot(term, term));
    }
    const double length = sqrt(norma_core_dot(sum, sum));
    const int kept = length > CANCELLED * terms && length <= DBL_MAX;
    for (int i = 0; i < 3; ++i) normal[i] = kept ? (float)(sum[i] / length) : 0.0f;
    return NORMA_OK;
}
