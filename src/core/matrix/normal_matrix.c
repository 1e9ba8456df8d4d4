/* normal_matrix.c: the normal matrix of one model, of a model and a view, and of many. */
#include "core/matrix/matrix.h"
#include "core/face/eight_vectors.h"
#include <float.h>
#include <math.h>
#include <string.h>

/* ---- Normal matrices of float models, one and concatenated.
 *
 * A normal is what is left of two tangents: M a x M b = cof(M)(a x b) for every M, so the cofactor
 * matrix carries normals, without a division, at rank 2 too. The columns of cof(M) are the cross
 * products of M's columns. In double precision the products of two floats are exact, and so are the
 * sign and the zero-ness of each difference; nothing overflows or underflows before the last
 * rounding. */

typedef struct cofactors {
    double entry[9];
    double determinant;
    double magnitude; /* of the terms of the determinant; its error is below 2^-50 of this */
    double finite;    /* 0, or NaN where an entry of the model is not finite */
} cofactors;

/* Each rounding below adds at most 2^-53 of what it rounds; the determinant's terms pass five of
 * them. */
static inline cofactors cofactors_of(const float m[16]) {
    const double a0 = (double)m[0], a1 = (double)m[1], a2 = (double)m[2], b0 = (double)m[4],
                 b1 = (double)m[5], b2 = (double)m[6], c0 = (double)m[8], c1 = (double)m[9],
                 c2 = (double)m[10];
    cofactors c = {{b1 * c2 - b2 * c1, b2 * c0 - b0 * c2, b0 * c1 - b1 * c0, c1 * a2 - c2 * a1,
                       c2 * a0 - c0 * a2, c0 * a1 - c1 * a0, a1 * b2 - a2 * b1, a2 * b0 - a0 * b2,
                       a0 * b1 - a1 * b0},
        0.0, 0.0, 0.0};
    const double x = a0 * c.entry[0], y = a1 * c.entry[1], z = a2 * c.entry[2];
    c.determinant = x + y + z;
    c.magnitude = fabs(x) + fabs(y) + fabs(z);
    c.finite = (a0 + a1 + a2 + b0 + b1 + b2 + c0 + c1 + c2) * 0.0;
    return c;
}

static inline double larger_of(double a, double b) {
    return a > b ? a : b; /* one instruction, which fmax with its rule about NaN is not */
}

static inline double largest(const double column[3]) {
    return larger_of(larger_of(fabs(column[0]), fabs(column[1])), fabs(column[2]));
}

/* Whether each column's largest entry is a normal float, so that no power of two is needed. */
static inline int fits_floats(const double c[9]) {
    const double x = largest(c), y = largest(c + 3), z = largest(c + 6),
                 most = larger_of(larger_of(x, y), z);
    const double least = x < y ? (x < z ? x : z) : (y < z ? y : z);
    return least >= (double)FLT_MIN && most <= (double)FLT_MAX;
}

/* What the common path leaves: not finite, a determinant that may be 0, a column of zeros, numbers
 * beyond the floats. */
static norma_result normal_matrix_rarely(
    const float model[16], const cofactors *c, norma_winding winding, float out[9]) {
    double upper[9];
    if (!norma_matrix_upper_float(model, upper)) {
        memset(out, 0, 9 * sizeof *out);
        return NORMA_ERROR_ARGUMENT;
    }
    scaled_number numbers[9];
    for (int i = 0; i < 9; ++i) numbers[i] = norma_scaled_from_double(c->entry[i]);
    double determinant = 0.0;
    if (winding == NORMA_WINDING_REVERSED) {
        const int certain = fabs(c->determinant) > 0x1p-50 * c->magnitude;
        determinant = certain ? c->determinant : norma_exact_determinant(upper).mantissa;
    }
    norma_matrix_to_floats(numbers, determinant < 0.0 ? -1.0 : 1.0, out);
    return NORMA_OK;
}

/* The normal matrix of one model; the error is that some entry is not finite, and zeros were
 * written. */
static norma_result core_normal_matrix_of(
    const float model[16], norma_winding winding, float out[9]) {
    const cofactors c = cofactors_of(model);
    const int certain =
        winding == NORMA_WINDING_KEPT || fabs(c.determinant) > 0x1p-50 * c.magnitude;
    if (!(certain && c.finite == 0.0 && fits_floats(c.entry)))
        return normal_matrix_rarely(model, &c, winding, out);
    const double sign = winding == NORMA_WINDING_REVERSED
                            ? copysign(1.0, c.determinant)
                            : 1.0; /* no branch: mirrors come as they like */
    for (int i = 0; i < 9; ++i) out[i] = (float)(c.entry[i] * sign) + 0.0f; /* no negative zeros */
    return NORMA_OK;
}

static int is_winding(norma_winding winding) {
    return winding == NORMA_WINDING_KEPT || winding == NORMA_WINDING_REVERSED;
}

norma_result norma_normal_matrix(
    const float model[16], norma_winding winding, float normal_matrix[9], norma_matrix_info *info) {
    if (!model || !normal_matrix || !is_winding(winding)) return NORMA_ERROR_ARGUMENT;
    double upper[9];
    const int finite = norma_matrix_upper_float(model, upper),
              translated = model[12] != 0.0f || model[13] != 0.0f || model[14] != 0.0f;
    const norma_result result = core_normal_matrix_of(model, winding, normal_matrix);
    if (!finite) memset(upper, 0, sizeof upper);
    if (info) norma_matrix_describe(upper, translated, norma_exact_determinant(upper), info);
    return result;
}

/* ---- concatenated: cof(V M) = cof(V) cof(M), so that what is exact about each stays so */

/* Entry (row, column) of cof(view) cof(model), each cofactor itself a difference of two products of
 * floats. */
static scaled_number exact_entry(const double view[9], const double model[9], int row, int column) {
    exact_sum sum;
    norma_exact_clear(&sum);
    const int r1 = (row + 1) % 3, r2 = (row + 2) % 3, c1 = (column + 1) % 3, c2 = (column + 2) % 3;
    for (int k = 0; k < 3; ++k) {
        const int k1 = (k + 1) % 3, k2 = (k + 2) % 3; /* cof(V)(row, k), cof(M)(k, column) */
        for (int term = 0; term < 4; ++term) {
            const int v = term / 2, m = term % 2;
            norma_exact_add(&sum,
                (const double[]){view[3 * k1 + (v ? r2 : r1)], view[3 * k2 + (v ? r1 : r2)],
                    model[3 * c1 + (m ? k2 : k1)], model[3 * c2 + (m ? k1 : k2)]},
                4, v ^ m);
        }
    }
    return norma_exact_round(&sum);
}

static void multiply_cofactors(const double view[9], const double model[9], const double v[9],
    const double m[9], scaled_number out[9]) {
    for (int column = 0; column < 3; ++column)
        for (int row = 0; row < 3; ++row) {
            double sum = 0.0, magnitude = 0.0;
            for (int k = 0; k < 3; ++k) {
                const double term = v[3 * k + row] * m[3 * column + k];
                sum += term;
                magnitude += fabs(term);
            }
            const int certain = fabs(sum) > 0x1p-20 * magnitude || magnitude == 0.0;
            out[3 * column + row] =
                certain ? norma_scaled_from_double(sum) : exact_entry(view, model, row, column);
        }
}

/* Whether view * model moves the origin, beyond what rounding makes of a view that undoes the
 * model's translation: relative to the terms of the sum, each of two floats that may be off by
 * 2^-24; 1e-5 is 80 times that, as much as kinds of matrices tolerate (matrix_info.c). */
static int is_product_translated(const float view[16], const float model[16]) {
    for (int row = 0; row < 3; ++row) {
        double sum = (double)view[12 + row], magnitude = fabs(sum);
        for (int k = 0; k < 3; ++k) {
            const double term = (double)view[4 * k + row] * (double)model[12 + k];
            sum += term;
            magnitude += fabs(term);
        }
        if (!(fabs(sum) <= 1e-5 * magnitude)) return 1;
    }
    return 0;
}

static void describe_product(
    const double view[9], const double model[9], int translated, norma_matrix_info *info) {
    double product[9];
    for (int i = 0; i < 9; ++i) {
        const double *m = model + i / 3 * 3;
        product[i] = view[i % 3] * m[0] + view[3 + i % 3] * m[1] + view[6 + i % 3] * m[2];
    }
    const scaled_number v = norma_exact_determinant(view), m = norma_exact_determinant(model);
    scaled_number determinant = norma_scaled_from_double(v.mantissa * m.mantissa);
    determinant.exponent += v.exponent + m.exponent;
    norma_matrix_describe(product, translated, determinant, info);
}

norma_result norma_normal_matrix_model_view(const float model[16], const float view[16],
    norma_winding winding, float normal_matrix[9], norma_matrix_info *info) {
    if (!model || !view || !normal_matrix || !is_winding(winding)) return NORMA_ERROR_ARGUMENT;
    double m[9], v[9];
    const int finite = norma_matrix_upper_float(model, m) & norma_matrix_upper_float(view, v);
    if (!finite) {
        memset(m, 0, sizeof m);
        memset(v, 0, sizeof v);
    }
    const int translated = is_product_translated(view, model);
    if (finite) {
        const cofactors cm = cofactors_of(model), cv = cofactors_of(view);
        scaled_number numbers[9];
        multiply_cofactors(v, m, cv.entry, cm.entry, numbers);
        double sign = 1.0;
        if (winding == NORMA_WINDING_REVERSED)
            sign = norma_exact_determinant(v).mantissa * norma_exact_determinant(m).mantissa < 0.0
                       ? -1.0
                       : 1.0;
        norma_matrix_to_floats(numbers, sign, normal_matrix);
    } else {
        memset(normal_matrix, 0, 9 * sizeof *normal_matrix);
    }
    if (info) describe_product(v, m, translated, info);
    return finite ? NORMA_OK : NORMA_ERROR_ARGUMENT;
}

/* ---- Normal matrices of many models, eight at a time: the same operations as for
 * one (normal_matrix.c), side by side; what is not certain or does not fit is done again by itself.
 */

enum { MATRICES_AT_ONCE = 8 };

typedef struct matrix_stream {
    const unsigned char *models;
    size_t model_stride;
    unsigned char *matrices;
    size_t matrix_stride, column_stride;
    norma_winding winding;
} matrix_stream;

typedef struct matrix_lanes {
    _Alignas(64) float entry[9][MATRICES_AT_ONCE];
} matrix_lanes;

static void store_matrix(const matrix_stream *s, size_t number, const float matrix[9]) {
    unsigned char *to = s->matrices + number * s->matrix_stride;
    for (size_t c = 0; c < 3; ++c)
        memcpy(to + c * s->column_stride, matrix + 3 * c, 3 * sizeof *matrix);
}

static void store_lane(
    const matrix_stream *s, size_t number, const matrix_lanes *out, size_t lane) {
    float matrix[9];
    for (size_t k = 0; k < 9; ++k) matrix[k] = out->entry[k][lane];
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
    for (size_t c = 0; c < 3; ++c) {
        core_f8 r[4], axis[3];
        for (size_t i = 0; i < 4; ++i) {
            r[i] = load_twos(models + i * s->model_stride, models + (i + 4) * s->model_stride,
                c < 2 ? 4 * c : 7);
            if (c == 2) r[i] = __builtin_shufflevector(r[i], r[i], 1, 2, 3, 0, 5, 6, 7, 4);
        }
        core_turn_threes(r, axis);
        for (size_t k = 0; k < 3; ++k) memcpy(in->entry[3 * c + k], &axis[k], sizeof axis[k]);
    }
}

/* Tight matrices: each is written once, from its first float to its last. */
CORE_INLINE void store_eight(const matrix_stream *s, size_t first, const matrix_lanes *out) {
    unsigned char *to = s->matrices + first * s->matrix_stride;
    core_f8 a[4], b[4];
    for (size_t k = 0; k < 4; ++k) {
        memcpy(&a[k], out->entry[k], sizeof a[k]);
        memcpy(&b[k], out->entry[4 + k], sizeof b[k]);
    }
    core_turn_fours(a);
    core_turn_fours(b);
    for (size_t i = 0; i < MATRICES_AT_ONCE; ++i, to += s->matrix_stride) {
        const size_t half = sizeof a[0] / 2, from = i < 4 ? 0 : half;
        memcpy(to, (const unsigned char *)&a[i % 4] + from, half);
        memcpy(to + half, (const unsigned char *)&b[i % 4] + from, half);
        memcpy(to + 2 * half, &out->entry[8][i], sizeof(float));
    }
}
#else
CORE_INLINE void load_models(const matrix_stream *s, size_t first, matrix_lanes *in) {
    for (size_t i = 0; i < MATRICES_AT_ONCE; ++i) {
        float model[11];
        memcpy(model, s->models + (first + i) * s->model_stride,
            sizeof model); /* the rest is translation and padding */
        for (size_t c = 0; c < 3; ++c)
            for (size_t r = 0; r < 3; ++r) in->entry[3 * c + r][i] = model[4 * c + r];
    }
}

CORE_INLINE void store_eight(const matrix_stream *s, size_t first, const matrix_lanes *out) {
    for (size_t i = 0; i < MATRICES_AT_ONCE; ++i) store_lane(s, first + i, out, i);
}
#endif

CORE_INLINE double larger_lane(double a, double b) { return a > b ? a : b; }
CORE_INLINE double lesser(double a, double b) { return a < b ? a : b; }

/* Which of the eight are to be done by themselves: nonzero. */
CORE_INLINE int matrices_of_lanes(
    const matrix_lanes *in, int reversed, matrix_lanes *out, int unsafe[MATRICES_AT_ONCE]) {
    int any = 0;
    for (int i = 0; i < MATRICES_AT_ONCE; ++i) {
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
        const double u = larger_lane(larger_lane(fabs(u0), fabs(u1)), fabs(u2)),
                     v = larger_lane(larger_lane(fabs(v0), fabs(v1)), fabs(v2)),
                     w = larger_lane(larger_lane(fabs(w0), fabs(w1)), fabs(w2));
        const double most = larger_lane(larger_lane(u, v), w), least = lesser(lesser(u, v), w),
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
    for (size_t i = first; i < end; ++i) {
        float model[16], matrix[9];
        memcpy(model, s->models + i * s->model_stride, 11 * sizeof *model);
        if (core_normal_matrix_of(model, s->winding, matrix)) result = NORMA_ERROR_ARGUMENT;
        store_matrix(s, i, matrix);
    }
    return result;
}

/* Those that are not safe by themselves. */
static norma_result store_some(const matrix_stream *s, size_t first, const matrix_lanes *out,
    const int unsafe[MATRICES_AT_ONCE]) {
    norma_result result = NORMA_OK;
    for (size_t i = 0; i < MATRICES_AT_ONCE; ++i) {
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
    int unsafe[MATRICES_AT_ONCE];
    size_t first = 0;
    for (; count - first >= MATRICES_AT_ONCE; first += MATRICES_AT_ONCE) {
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

static matrix_kernel *choose_matrix_kernel(void) {
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
    for (size_t c = 1; c <= 2 && count > 1; ++c) {
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
    return choose_matrix_kernel()(&stream, count);
}
