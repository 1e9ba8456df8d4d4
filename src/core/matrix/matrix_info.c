/* matrix_info.c: what kind of matrix a model is, and how wrong plain M would be for its normals.
 *
 * With M = U S V^T and n = V x, plain M gives S x and the right normal is S^-1 x (up to the common
 * U). The cosine between them is 1 / (|S x| |S^-1 x|), least (Kantorovich 1948) half way between
 * the directions of the largest and the smallest singular value: 2a / (a^2 + 1), a being their
 * ratio. */
#include "core/matrix/matrix.h"
#include "core/face/triangle.h"
#include <math.h>

/* Of cosines between columns, of ratios of their lengths, and of a matrix beside the identity,
 * whose entries are 1: none hangs on the size of what the matrix is used on. */
#define KIND_TOLERANCE 1e-5
/* Of the largest singular value. */
#define RANK_TOLERANCE 1e-6
#define HALF_PI        1.57079632679489661923

/* upper times the power of two that brings its largest entry into [1, 2). */
static int scale_to_one(const double upper[9], double scaled[9]) {
    double largest = 0.0;
    for (int i = 0; i < 9; i++) largest = fmax(largest, fabs(upper[i]));
    const int exponent = norma_scaled_from_double(largest).exponent;
    for (int i = 0; i < 9; i++) scaled[i] = ldexp(upper[i], -exponent);
    return exponent;
}

/* Never under a mirror: who skips identities would skip the mirror. */
static int is_identity(const double m[9], int mirrored) {
    for (int i = 0; i < 9; i++)
        if (fabs(m[i] - (i % 4 == 0)) > KIND_TOLERANCE) return 0;
    return !mirrored;
}

static norma_kind kind_of(const double scaled[9], int exponent, int mirrored, int translated) {
    double length[3];
    for (int i = 0; i < 3; i++) length[i] = sqrt(norma_core_dot(scaled + 3 * i, scaled + 3 * i));
    for (int i = 0; i < 3; i++) {
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
    for (int i = 0; i < 9; i++) m[i] = ldexp(scaled[i], exponent);
    if (!is_identity(m, mirrored)) return NORMA_KIND_ROTATION;
    return translated ? NORMA_KIND_TRANSLATION : NORMA_KIND_IDENTITY;
}

/* Each singular vector has two signs; that with its largest component positive makes the answer the
 * same however it was found. */
static double upright(const double v[3]) {
    int largest = 0;
    for (int i = 1; i < 3; i++)
        if (fabs(v[i]) > fabs(v[largest])) largest = i;
    return v[largest] < 0.0 ? -1.0 : 1.0;
}

static void half_way(const double a[3], const double b[3], float normal[3]) {
    const double sa = upright(a), sb = upright(b);
    double n[3];
    for (int i = 0; i < 3; i++) n[i] = sa * a[i] + sb * b[i];
    const double length = sqrt(norma_core_dot(n, n));
    for (int i = 0; i < 3; i++) normal[i] = (float)(n[i] / length + 0.0);
}

void norma_matrix_describe(
    const double upper[9], int translated, scaled_number determinant, norma_matrix_info *info) {
    double scaled[9], values[3], v[9];
    const int exponent = scale_to_one(upper, scaled);
    norma_singular_values(scaled, values, v);
    int largest = 0, smallest = 2; /* where all are equal, still two different ones */
    for (int i = 1; i < 3; i++)
        if (values[i] > values[largest]) largest = i;
    for (int i = 1; i >= 0; i--)
        if (values[i] < values[smallest]) smallest = i;

    info->rank = 0;
    for (int i = 0; i < 3; i++) info->rank += values[i] > RANK_TOLERANCE * values[largest];
    info->mirrored = determinant.mantissa < 0.0;
    info->determinant = norma_scaled_to_double(determinant);
    info->kind = info->rank < 3 ? NORMA_KIND_SINGULAR
                                : kind_of(scaled, exponent, info->mirrored, translated);
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
