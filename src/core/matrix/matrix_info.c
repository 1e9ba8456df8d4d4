/* matrix_info.c: exact determinants and cofactors, what kind of matrix one is, and by how much
 * plain M errs. */
#include "core/matrix/matrix.h"
#include <math.h>
#include <string.h>

/* ---- Exact determinants and cofactors, their common power of two, and the matrices that
 * norma.h gives by name in double precision. */

const number_range norma_float_range = {-126, 127, 0x1.fffffep0},
                   norma_double_range = {-1022, 1023, 0x1.fffffffffffffp0};

int norma_matrix_upper_float(const float model[16], double upper[9]) {
    int finite = 1;
    for (int i = 0; i < 9; ++i) {
        upper[i] = (double)model[i / 3 * 4 + i % 3];
        finite &= isfinite(upper[i]) != 0;
    }
    return finite;
}

int norma_matrix_upper_double(const double model[16], double upper[9]) {
    int finite = 1;
    for (int i = 0; i < 9; ++i) {
        upper[i] = model[i / 3 * 4 + i % 3];
        finite &= isfinite(upper[i]) != 0;
    }
    return finite;
}

scaled_number norma_exact_determinant(const double upper[9]) {
    exact_sum sum;
    norma_exact_clear(&sum);
    for (int i = 0; i < 3; ++i) { /* Sarrus: a_0i (a_1j a_2k - a_1k a_2j) */
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        norma_exact_add(&sum, (const double[]){upper[i], upper[3 + j], upper[6 + k]}, 3, 0);
        norma_exact_add(&sum, (const double[]){upper[i], upper[3 + k], upper[6 + j]}, 3, 1);
    }
    return norma_exact_round(&sum);
}

/* Neither products of three nor their parts leave the range of doubles. */
static int is_mild(const double upper[9]) {
    int mild = 1;
    for (int i = 0; i < 9; ++i)
        mild &= upper[i] == 0.0 || (fabs(upper[i]) > 0x1p-300 && fabs(upper[i]) < 0x1p300);
    return mild;
}

int norma_matrix_mirrors(const double upper[9]) {
    double sum = 0, sizes = 0; /* of six products, each twice rounded, and five sums: wrong by less
                                  than 8 * 2^-53 of their sizes */
    for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        const double with = upper[i] * upper[3 + j] * upper[6 + k],
                     against = upper[i] * upper[3 + k] * upper[6 + j];
        sum += with - against;
        sizes += fabs(with) + fabs(against);
    }
    if (is_mild(upper) && (sizes == 0.0 || fabs(sum) > 0x1p-48 * sizes)) return sum < 0.0;
    return norma_exact_determinant(upper).mantissa < 0.0;
}

/* Column c of the cofactor matrix is the cross product of the two columns after c. */
static void exact_cofactors(const double upper[9], scaled_number cofactors[9]) {
    for (int c = 0; c < 3; ++c) {
        const double *a = upper + 3 * ((c + 1) % 3), *b = upper + 3 * ((c + 2) % 3);
        for (int r = 0; r < 3; ++r) {
            const int s = (r + 1) % 3, t = (r + 2) % 3;
            exact_sum sum;
            norma_exact_clear(&sum);
            norma_exact_add(&sum, (const double[]){a[s], b[t]}, 2, 0);
            norma_exact_add(&sum, (const double[]){a[t], b[s]}, 2, 1);
            cofactors[3 * c + r] = norma_exact_round(&sum);
        }
    }
}

/* A column whose largest entry keeps all its digits loses nothing that a rounding would have kept;
 * so only then is there nothing to do. */
static int fits_range(const scaled_number numbers[9], number_range range) {
    for (int c = 0; c < 3; ++c) {
        int zero = 1, kept = 0;
        for (int r = 0; r < 3; ++r) {
            const scaled_number n = numbers[3 * c + r];
            if (n.mantissa == 0.0) continue;
            zero = 0;
            kept |= n.exponent >= range.lowest;
            if (n.exponent > range.highest ||
                (n.exponent == range.highest && fabs(n.mantissa) > range.largest))
                return 0;
        }
        if (!zero && !kept) return 0;
    }
    return 1;
}

static int matrix_common_shift(const scaled_number numbers[9], number_range range) {
    if (fits_range(numbers, range)) return 0;
    int least = INT32_MAX, most = INT32_MIN;
    double mantissa = 0.0; /* of the largest */
    for (int i = 0; i < 9; ++i) {
        const scaled_number n = numbers[i];
        if (n.mantissa == 0.0) continue;
        if (n.exponent < least) least = n.exponent;
        if (n.exponent > most || (n.exponent == most && fabs(n.mantissa) > mantissa))
            mantissa = fabs(n.mantissa);
        if (n.exponent > most) most = n.exponent;
    }
    /* The largest entry near 1; higher where the smallest would then fall below the range, as far
     * as there is room. */
    int target = range.lowest + (most - least);
    const int highest = mantissa > range.largest ? range.highest - 1 : range.highest;
    if (target < 0) target = 0;
    if (target > highest) target = highest;
    return target - most;
}

/* Adding zero makes +0 of -0. */
void norma_matrix_to_floats(const scaled_number numbers[9], double sign, float out[9]) {
    const int shift = matrix_common_shift(numbers, norma_float_range);
    for (int i = 0; i < 9; ++i)
        out[i] = (float)ldexp(sign * numbers[i].mantissa, numbers[i].exponent + shift) + 0.0f;
}

static void matrix_to_doubles(const scaled_number numbers[9], double sign, double out[9]) {
    const int shift = matrix_common_shift(numbers, norma_double_range);
    for (int i = 0; i < 9; ++i)
        out[i] = ldexp(sign * numbers[i].mantissa, numbers[i].exponent + shift) + 0.0;
}

static int is_model_translated(const double model[16]) {
    return model[12] != 0.0 || model[13] != 0.0 || model[14] != 0.0;
}

static norma_result refuse_not_finite(double out[9], norma_matrix_info *info) {
    static const double zeros[9] = {0};
    memset(out, 0, sizeof zeros);
    if (info) norma_matrix_describe(zeros, 0, (scaled_number){0.0, 0}, info);
    return NORMA_ERROR_ARGUMENT;
}

norma_result norma_normal_matrix_double(const double model[16], norma_winding winding,
    double normal_matrix[9], norma_matrix_info *info) {
    if (!model || !normal_matrix ||
        (winding != NORMA_WINDING_KEPT && winding != NORMA_WINDING_REVERSED))
        return NORMA_ERROR_ARGUMENT;
    double upper[9];
    if (!norma_matrix_upper_double(model, upper)) return refuse_not_finite(normal_matrix, info);
    const int translated = is_model_translated(
        model); /* read before anything is written: the output may be the model */
    scaled_number cofactors[9];
    exact_cofactors(upper, cofactors);
    const scaled_number determinant = norma_exact_determinant(upper);
    const double sign =
        winding == NORMA_WINDING_REVERSED && determinant.mantissa < 0.0 ? -1.0 : 1.0;
    matrix_to_doubles(cofactors, sign, normal_matrix);
    if (info) norma_matrix_describe(upper, translated, determinant, info);
    return NORMA_OK;
}

norma_result norma_cofactor_matrix(const double model[16], double cofactor[9]) {
    return norma_normal_matrix_double(model, NORMA_WINDING_KEPT, cofactor, NULL);
}

norma_result norma_inverse_transpose(const double model[16], double inverse_transpose[9]) {
    if (!model || !inverse_transpose) return NORMA_ERROR_ARGUMENT;
    double upper[9];
    if (!norma_matrix_upper_double(model, upper)) return refuse_not_finite(inverse_transpose, NULL);
    const scaled_number determinant = norma_exact_determinant(upper);
    if (determinant.mantissa == 0.0) return NORMA_ERROR_ARGUMENT;
    scaled_number numbers[9];
    exact_cofactors(upper, numbers);
    for (int i = 0; i < 9; ++i) {
        const int exponent = numbers[i].exponent - determinant.exponent;
        numbers[i] = norma_scaled_from_double(numbers[i].mantissa / determinant.mantissa);
        numbers[i].exponent += exponent;
    }
    matrix_to_doubles(numbers, 1.0, inverse_transpose);
    return NORMA_OK;
}

/* Column / (its length)^2, as numbers without a range; 0 for a column of zeros. */
static int divide_by_square(const double column[3], scaled_number out[3]) {
    const double largest = fmax(fmax(fabs(column[0]), fabs(column[1])), fabs(column[2]));
    if (largest == 0.0) return 0;
    const int exponent = norma_scaled_from_double(largest).exponent;
    double square = 0.0;
    for (int r = 0; r < 3; ++r) {
        const double scaled = ldexp(column[r], -exponent);
        square += scaled * scaled;
    }
    for (int r = 0; r < 3; ++r) {
        out[r] = norma_scaled_from_double(column[r]);
        const int column_exponent = out[r].exponent;
        out[r] = norma_scaled_from_double(out[r].mantissa / square);
        out[r].exponent += column_exponent - 2 * exponent;
    }
    return 1;
}

norma_result norma_axis_scale_matrix(const double model[16], double normal_matrix[9]) {
    if (!model || !normal_matrix) return NORMA_ERROR_ARGUMENT;
    double upper[9];
    if (!norma_matrix_upper_double(model, upper)) return refuse_not_finite(normal_matrix, NULL);
    scaled_number numbers[9];
    for (int c = 0; c < 3; ++c)
        if (!divide_by_square(upper + 3 * c, numbers + 3 * c)) return NORMA_ERROR_ARGUMENT;
    matrix_to_doubles(numbers, 1.0, normal_matrix);
    return NORMA_OK;
}

/* ---- Singular values of a 3x3 by one-sided Jacobi rotations (Hestenes 1958),
 * accurate to a few units in the last place of the largest. Only + - * / and sqrt: the same bits
 * everywhere. */

enum {
    SWEEPS = 40
}; /* quadratic convergence needs five or six; the limit only guards against cycling in the last bit
    */

static void rotate_columns_by(double a[3], double b[3], double c, double s) {
    for (int i = 0; i < 3; ++i) {
        const double x = a[i], y = b[i];
        a[i] = c * x - s * y;
        b[i] = s * x + c * y;
    }
}

/* Makes columns p and q perpendicular; 0 where they already are to the last bits. */
static int rotate_column_pair(double *u, double *v, int p, int q) {
    double *a = u + 3 * p, *b = u + 3 * q;
    const double alpha = norma_core_dot(a, a), beta = norma_core_dot(b, b),
                 gamma = norma_core_dot(a, b);
    if (fabs(gamma) <= 0x1p-53 * sqrt(alpha) * sqrt(beta) || gamma == 0.0) return 0;
    const double zeta = (beta - alpha) / (2.0 * gamma);
    const double t = (zeta < 0.0 ? -1.0 : 1.0) / (fabs(zeta) + sqrt(1.0 + zeta * zeta));
    const double c = 1.0 / sqrt(1.0 + t * t), s = c * t;
    rotate_columns_by(a, b, c, s);
    rotate_columns_by(v + 3 * p, v + 3 * q, c, s);
    return s != 0.0;
}

void norma_singular_values(const double matrix[9], double values[3], double v[9]) {
    static const double identity[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    double u[9];
    memcpy(u, matrix, sizeof u);
    memcpy(v, identity, sizeof identity);
    for (int sweep = 0, turned = 1; turned && sweep < SWEEPS; ++sweep) {
        turned = rotate_column_pair(u, v, 0, 1);
        turned |= rotate_column_pair(u, v, 0, 2);
        turned |= rotate_column_pair(u, v, 1, 2);
    }
    for (int i = 0; i < 3; ++i) values[i] = sqrt(norma_core_dot(u + 3 * i, u + 3 * i));
}

/* ---- What kind of matrix a model is, and how wrong plain M would be for its normals.
 *
 * With M = U S V^T and n = V x, plain M gives S x and the right normal is S^-1 x (up to the common
 * U). The cosine between them is 1 / (|S x| |S^-1 x|), least (Kantorovich 1948) half way between
 * the directions of the largest and the smallest singular value: 2a / (a^2 + 1), a being their
 * ratio. */

/* Of cosines between columns, of ratios of their lengths, and of a matrix beside the identity,
 * whose entries are 1: none hangs on the size of what the matrix is used on. 84 times the 2^-23 by
 * which floats differ, so products of some rotations stay rotations, while what a kind leaves out
 * turns a normal by 1e-5 radians, 0.0006 degrees. */
#define KIND_TOLERANCE 1e-5
/* Of the largest singular value. Rounding a matrix of rank 2 to floats gives it a third one of up
 * to 3 * 2^-24 = 1.8e-7; this is five times as much. */
#define RANK_TOLERANCE 1e-6
#define HALF_PI        1.57079632679489661923

/* upper times the power of two that brings its largest entry into [1, 2). */
static int scale_to_one(const double upper[9], double scaled[9]) {
    double largest = 0.0;
    for (int i = 0; i < 9; ++i) largest = fmax(largest, fabs(upper[i]));
    const int exponent = norma_scaled_from_double(largest).exponent;
    for (int i = 0; i < 9; ++i) scaled[i] = ldexp(upper[i], -exponent);
    return exponent;
}

/* Never under a mirror: who skips identities would skip the mirror. */
static int is_identity_matrix(const double m[9], int mirrored) {
    for (int i = 0; i < 9; ++i)
        if (fabs(m[i] - (i % 4 == 0)) > KIND_TOLERANCE) return 0;
    return !mirrored;
}

static norma_kind kind_of_matrix(
    const double scaled[9], int exponent, int mirrored, int translated) {
    double length[3];
    for (int i = 0; i < 3; ++i) length[i] = sqrt(norma_core_dot(scaled + 3 * i, scaled + 3 * i));
    for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3;
        if (fabs(norma_core_dot(scaled + 3 * i, scaled + 3 * j)) >
            KIND_TOLERANCE * length[i] * length[j])
            return NORMA_KIND_SHEAR;
    }
    const double longest = fmax(fmax(length[0], length[1]), length[2]),
                 shortest = fmin(fmin(length[0], length[1]), length[2]);
    if (longest - shortest > KIND_TOLERANCE * longest) return NORMA_KIND_NON_UNIFORM_SCALE;
    if (fabs(ldexp(longest, exponent) - 1.0) > KIND_TOLERANCE ||
        fabs(ldexp(shortest, exponent) - 1.0) > KIND_TOLERANCE)
        return NORMA_KIND_UNIFORM_SCALE;
    double m[9];
    for (int i = 0; i < 9; ++i) m[i] = ldexp(scaled[i], exponent);
    if (!is_identity_matrix(m, mirrored)) return NORMA_KIND_ROTATION;
    return translated ? NORMA_KIND_TRANSLATION : NORMA_KIND_IDENTITY;
}

/* Each singular vector has two signs; that with its largest component positive makes the answer the
 * same however it was found. */
static double upright(const double v[3]) {
    int largest = 0;
    for (int i = 1; i < 3; ++i)
        if (fabs(v[i]) > fabs(v[largest])) largest = i;
    return v[largest] < 0.0 ? -1.0 : 1.0;
}

static void half_way(const double a[3], const double b[3], float normal[3]) {
    const double sa = upright(a), sb = upright(b);
    double n[3];
    for (int i = 0; i < 3; ++i) n[i] = sa * a[i] + sb * b[i];
    const double length = sqrt(norma_core_dot(n, n));
    for (int i = 0; i < 3; ++i) normal[i] = (float)(n[i] / length + 0.0);
}

void norma_matrix_describe(
    const double upper[9], int translated, scaled_number determinant, norma_matrix_info *info) {
    double scaled[9], values[3], v[9];
    const int exponent = scale_to_one(upper, scaled);
    norma_singular_values(scaled, values, v);
    int largest = 0, smallest = 2; /* where all are equal, still two different ones */
    for (int i = 1; i < 3; ++i)
        if (values[i] > values[largest]) largest = i;
    for (int i = 1; i >= 0; --i)
        if (values[i] < values[smallest]) smallest = i;

    info->rank = 0;
    for (int i = 0; i < 3; ++i) info->rank += values[i] > RANK_TOLERANCE * values[largest];
    info->mirrored = determinant.mantissa < 0.0;
    info->determinant = norma_scaled_to_double(determinant);
    info->kind = info->rank < 3 ? NORMA_KIND_SINGULAR
                                : kind_of_matrix(scaled, exponent, info->mirrored, translated);
    if (info->rank < 3) {
        info->anisotropy = (double)INFINITY;
        info->worst_error_rad = HALF_PI;
    } else {
        const double a = values[largest] / values[smallest];
        info->anisotropy = a;
        info->worst_error_rad = norma_core_angle((a - 1.0) * (a + 1.0), 2.0 * a);
    }
    half_way(v + 3 * largest, v + 3 * smallest, info->worst_normal);
}

norma_shortcut norma_matrix_shortcut(const norma_matrix_info *info) {
    if (!info) return NORMA_SHORTCUT_NONE;
    switch (info->kind) {
    case NORMA_KIND_IDENTITY:
    case NORMA_KIND_TRANSLATION:
    case NORMA_KIND_ROTATION:
        return NORMA_SHORTCUT_ROTATION;
    case NORMA_KIND_UNIFORM_SCALE:
        return NORMA_SHORTCUT_UNIFORM_SCALE;
    case NORMA_KIND_NON_UNIFORM_SCALE:
        return NORMA_SHORTCUT_AXIS_SCALE;
    case NORMA_KIND_SHEAR:
    case NORMA_KIND_SINGULAR:
        return NORMA_SHORTCUT_NONE;
    }
    return NORMA_SHORTCUT_NONE;
}

/* ---- Norma_find_model_fault. */

static int is_model_finite(const unsigned char *model) {
    float m[16];
    memcpy(m, model, sizeof m);
    for (int column = 0; column < 3; ++column)
        for (int row = 0; row < 3; ++row)
            if (!isfinite(m[4 * column + row])) return 0;
    return 1;
}

norma_result norma_find_model_fault(
    const float *models, size_t model_stride, size_t count, norma_fault *fault) {
    const size_t stride = model_stride ? model_stride : 16 * sizeof(float);
    norma_core_refuse(fault, NORMA_OK, NULL, SIZE_MAX, NULL);
    if (count && !models)
        return norma_core_refuse(fault, NORMA_ERROR_ARGUMENT, "models", SIZE_MAX, "not NULL");
    if (count > SIZE_MAX / stride)
        return norma_core_refuse(
            fault, NORMA_ERROR_OVERFLOW, "count", SIZE_MAX, "count * model_stride fits a size_t");
    for (size_t i = 0; i < count; ++i)
        if (!is_model_finite((const unsigned char *)models + i * stride))
            return norma_core_refuse(
                fault, NORMA_ERROR_ARGUMENT, "models", i, "finite in [0..2], [4..6] and [8..10]");
    return NORMA_OK;
}
