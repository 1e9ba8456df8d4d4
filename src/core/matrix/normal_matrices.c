/* normal_matrices.c: normal matrices of many models, eight at a time: the same operations as for
 * one (normal_matrix.c), side by side; what is not certain or does not fit is done again by itself.
 */
#include "core/face/eight_vectors.h"
#include "core/matrix/matrix.h"
#include <float.h>
#include <math.h>
#include <string.h>

enum { AT_ONCE = 8 };

typedef struct matrix_stream {
    const unsigned char *models;
    size_t model_stride;
    unsigned char *matrices;
    size_t matrix_stride, column_stride;
    norma_winding winding;
} matrix_stream;

typedef struct matrix_lanes {
    _Alignas(64) float entry[9][AT_ONCE];
} matrix_lanes;

static void store_matrix(const matrix_stream *s, size_t number, const float matrix[9]) {
    unsigned char *to = s->matrices + number * s->matrix_stride;
    for (size_t c = 0; c < 3; c++)
        memcpy(to + c * s->column_stride, matrix + 3 * c, 3 * sizeof *matrix);
}

static void store_lane(
    const matrix_stream *s, size_t number, const matrix_lanes *out, size_t lane) {
    float matrix[9];
    for (size_t k = 0; k < 9; k++) matrix[k] = out->entry[k][lane];
    store_matrix(s, number, matrix);
}

#if defined(CORE_HAS_SHUFFLES)
/* Four floats at a place in each of two models; the last column is read with the float before it,
 * since what is behind it may be another's. */
CORE_INLINE core_f8 load_twos(
    const unsigned char *model, const unsigned char *other, size_t number) {
    core_f4 low, high;
    memcpy(&low, model + number * sizeof(float), sizeof low);
    memcpy(&high, other + number * sizeof(float), sizeof high);
    return __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7);
}

CORE_INLINE void load_models(const matrix_stream *s, size_t first, matrix_lanes *in) {
    const unsigned char *models = s->models + first * s->model_stride;
    for (size_t c = 0; c < 3; c++) {
        core_f8 r[4], axis[3];
        for (size_t i = 0; i < 4; i++) {
            r[i] = load_twos(models + i * s->model_stride, models + (i + 4) * s->model_stride,
                c < 2 ? 4 * c : 7);
            if (c == 2) r[i] = __builtin_shufflevector(r[i], r[i], 1, 2, 3, 0, 5, 6, 7, 4);
        }
        core_turn_threes(r, axis);
        for (size_t k = 0; k < 3; k++) memcpy(in->entry[3 * c + k], &axis[k], sizeof axis[k]);
    }
}

/* Tight matrices: each is written once, from its first float to its last. */
CORE_INLINE void store_eight(const matrix_stream *s, size_t first, const matrix_lanes *out) {
    unsigned char *to = s->matrices + first * s->matrix_stride;
    core_f8 a[4], b[4];
    for (size_t k = 0; k < 4; k++) {
        memcpy(&a[k], out->entry[k], sizeof a[k]);
        memcpy(&b[k], out->entry[4 + k], sizeof b[k]);
    }
    core_turn_fours(a);
    core_turn_fours(b);
    for (size_t i = 0; i < AT_ONCE; i++, to += s->matrix_stride) {
        const size_t half = sizeof a[0] / 2, from = i < 4 ? 0 : half;
        memcpy(to, (const unsigned char *)&a[i % 4] + from, half);
        memcpy(to + half, (const unsigned char *)&b[i % 4] + from, half);
        memcpy(to + 2 * half, &out->entry[8][i], sizeof(float));
    }
}
#else
CORE_INLINE void load_models(const matrix_stream *s, size_t first, matrix_lanes *in) {
    for (size_t i = 0; i < AT_ONCE; i++) {
        float model[11];
        memcpy(model, s->models + (first + i) * s->model_stride,
            sizeof model); /* the rest is translation and padding */
        for (size_t c = 0; c < 3; c++)
            for (size_t r = 0; r < 3; r++) in->entry[3 * c + r][i] = model[4 * c + r];
    }
}

CORE_INLINE void store_eight(const matrix_stream *s, size_t first, const matrix_lanes *out) {
    for (size_t i = 0; i < AT_ONCE; i++) store_lane(s, first + i, out, i);
}
#endif

CORE_INLINE double larger(double a, double b) { return a > b ? a : b; }
CORE_INLINE double lesser(double a, double b) { return a < b ? a : b; }

/* Which of the eight are to be done by themselves: nonzero. */
CORE_INLINE int matrices_of_lanes(
    const matrix_lanes *in, int reversed, matrix_lanes *out, int unsafe[AT_ONCE]) {
    int any = 0;
    for (int i = 0; i < AT_ONCE; i++) {
        const double a0 = (double)in->entry[0][i], a1 = (double)in->entry[1][i],
                     a2 = (double)in->entry[2][i], b0 = (double)in->entry[3][i],
                     b1 = (double)in->entry[4][i], b2 = (double)in->entry[5][i],
                     c0 = (double)in->entry[6][i], c1 = (double)in->entry[7][i],
                     c2 = (double)in->entry[8][i];
        const double u0 = b1 * c2 - b2 * c1, u1 = b2 * c0 - b0 * c2, u2 = b0 * c1 - b1 * c0,
                     v0 = c1 * a2 - c2 * a1, v1 = c2 * a0 - c0 * a2, v2 = c0 * a1 - c1 * a0,
                     w0 = a1 * b2 - a2 * b1, w1 = a2 * b0 - a0 * b2, w2 = a0 * b1 - a1 * b0;
        const double x = a0 * u0, y = a1 * u1, z = a2 * u2, determinant = x + y + z,
                     magnitude = fabs(x) + fabs(y) + fabs(z);
        const double finite = (a0 + a1 + a2 + b0 + b1 + b2 + c0 + c1 + c2) * 0.0;
        const double u = larger(larger(fabs(u0), fabs(u1)), fabs(u2)),
                     v = larger(larger(fabs(v0), fabs(v1)), fabs(v2)),
                     w = larger(larger(fabs(w0), fabs(w1)), fabs(w2));
        const double most = larger(larger(u, v), w), least = lesser(lesser(u, v), w),
                     sign = reversed ? copysign(1.0, determinant) : 1.0;
        unsafe[i] = !(finite == 0.0) | !(least >= (double)FLT_MIN) | !(most <= (double)FLT_MAX) |
                    (reversed & !(fabs(determinant) > 0x1p-50 * magnitude));
        any |= unsafe[i];
        out->entry[0][i] = (float)(u0 * sign) + 0.0f; /* no negative zeros */
        out->entry[1][i] = (float)(u1 * sign) + 0.0f;
        out->entry[2][i] = (float)(u2 * sign) + 0.0f;
        out->entry[3][i] = (float)(v0 * sign) + 0.0f;
        out->entry[4][i] = (float)(v1 * sign) + 0.0f;
        out->entry[5][i] = (float)(v2 * sign) + 0.0f;
        out->entry[6][i] = (float)(w0 * sign) + 0.0f;
        out->entry[7][i] = (float)(w1 * sign) + 0.0f;
        out->entry[8][i] = (float)(w2 * sign) + 0.0f;
    }
    return any;
}

static norma_result one_by_one(const matrix_stream *s, size_t first, size_t end) {
    norma_result result = NORMA_OK;
    for (size_t i = first; i < end; i++) {
        float model[16], matrix[9];
        memcpy(model, s->models + i * s->model_stride, 11 * sizeof *model);
        if (norma_core_normal_matrix_of(model, s->winding, matrix)) result = NORMA_ERROR_ARGUMENT;
        store_matrix(s, i, matrix);
    }
    return result;
}

/* Those that are not safe by themselves. */
static norma_result store_some(
    const matrix_stream *s, size_t first, const matrix_lanes *out, const int unsafe[AT_ONCE]) {
    norma_result result = NORMA_OK;
    for (size_t i = 0; i < AT_ONCE; i++) {
        if (!unsafe[i])
            store_lane(s, first + i, out, i);
        else if (one_by_one(s, first + i, first + i + 1))
            result = NORMA_ERROR_ARGUMENT;
    }
    return result;
}

CORE_INLINE norma_result many(const matrix_stream *s, size_t count) {
    const int tight = s->column_stride == 3 * sizeof(float);
    norma_result result = NORMA_OK;
    matrix_lanes in, out;
    int unsafe[AT_ONCE];
    size_t first = 0;
    for (; count - first >= AT_ONCE; first += AT_ONCE) {
        load_models(s, first, &in);
        const int any = s->winding == NORMA_WINDING_REVERSED
                            ? matrices_of_lanes(&in, 1, &out, unsafe)
                            : matrices_of_lanes(&in, 0, &out, unsafe);
        if (tight && !any)
            store_eight(s, first, &out);
        else if (store_some(s, first, &out, unsafe))
            result = NORMA_ERROR_ARGUMENT;
    }
    return one_by_one(s, first, count) ? NORMA_ERROR_ARGUMENT : result;
}

typedef norma_result matrix_kernel(const matrix_stream *s, size_t count);
static norma_result many_portable(const matrix_stream *s, size_t count) { return many(s, count); }
#if defined(CORE_HAS_X86)
CORE_FOR_AVX2 static norma_result many_avx2(const matrix_stream *s, size_t count) {
    return many(s, count);
}
#if defined(CORE_HAS_AVX512)
CORE_FOR_AVX512 static norma_result many_avx512(const matrix_stream *s, size_t count) {
    return many(s, count);
}
#endif
#endif

static matrix_kernel *choose_kernel(void) {
    static matrix_kernel *const kernels[] = CORE_KERNELS(many);
    return kernels[norma_core_level(NORMA_ISA_BEST)];
}

norma_result norma_normal_matrices(const float *models, size_t count, norma_winding winding,
    float *normal_matrices, size_t capacity) {
    return norma_normal_matrices_strided(
        models, 0, count, winding, normal_matrices, 0, 0, capacity);
}

/* Whether a column of one matrix would be written over a column of another. */
static int columns_collide(size_t count, size_t matrix_stride, size_t column_stride) {
    const size_t column = 3 * sizeof(float);
    if (column_stride < column || (count > 1 && matrix_stride < column)) return 1;
    for (size_t c = 1; c <= 2 && count > 1; c++) {
        const size_t before = c * column_stride / matrix_stride,
                     apart = c * column_stride % matrix_stride;
        if ((before > 0 && before < count && apart < column) ||
            (before + 1 < count && matrix_stride - apart < column))
            return 1;
    }
    return 0;
}

norma_result norma_normal_matrices_strided(const float *models, size_t model_stride, size_t count,
    norma_winding winding, float *normal_matrices, size_t matrix_stride, size_t column_stride,
    size_t capacity) {
    if (winding != NORMA_WINDING_KEPT && winding != NORMA_WINDING_REVERSED)
        return NORMA_ERROR_ARGUMENT;
    if (!count) return NORMA_OK;
    if (!models || !normal_matrices) return NORMA_ERROR_ARGUMENT;
    if (!column_stride) column_stride = 3 * sizeof(float);
    if (column_stride > SIZE_MAX / 4) return NORMA_ERROR_OVERFLOW;
    if (!matrix_stride) matrix_stride = 3 * column_stride;
    if (!model_stride) model_stride = 16 * sizeof(float);
    if (count > SIZE_MAX / model_stride || count > (SIZE_MAX - 3 * column_stride) / matrix_stride)
        return NORMA_ERROR_OVERFLOW;
    if (columns_collide(count, matrix_stride, column_stride)) return NORMA_ERROR_ARGUMENT;
    if (capacity < count) return NORMA_ERROR_CAPACITY;

    const matrix_stream stream = {(const unsigned char *)models, model_stride,
        (unsigned char *)normal_matrices, matrix_stride, column_stride, winding};
    return choose_kernel()(&stream, count);
}
