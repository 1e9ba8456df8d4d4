/* node_matrix.c: what a node's matrix, or its translation, rotation and scale, can say, and how the
 * rest is said by two nodes. Rotation from a matrix: Shepperd 1978. Singular values by Hestenes'
 * one-sided Jacobi rotations (1958), which keep small ones accurate. */
#include "io/gltf/node_matrix.h"
#include <math.h>
#include <string.h>

void norma_gltf_matrix_identity(double m[16]) {
    for (int i = 0; i < 16; i++) m[i] = i % 5 == 0;
}

int norma_gltf_matrix_is_identity(const double m[16]) {
    for (int i = 0; i < 16; i++)
        if (m[i] != (i % 5 == 0)) return 0;
    return 1;
}

void norma_gltf_matrix_multiply(const double a[16], const double b[16], double ab[16]) {
    double product[16];
    for (int column = 0; column < 4; column++) {
        const double *c = b + 4 * column;
        for (int row = 0; row < 3; row++)
            product[4 * column + row] = a[row] * c[0] + a[4 + row] * c[1] + a[8 + row] * c[2] +
                                        (column == 3 ? a[12 + row] : 0);
        product[4 * column + 3] = column == 3;
    }
    memcpy(ab, product, sizeof product);
}

void norma_gltf_matrix_compose(const gltf_trs *trs, double m[16]) {
    const double *q = trs->rotation, *s = trs->scale;
    const double x = q[0], y = q[1], z = q[2], w = q[3];
    const double rotation[9] = {1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w),
        2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w), 2 * (x * z + y * w),
        2 * (y * z - x * w), 1 - 2 * (x * x + y * y)};
    for (int column = 0; column < 3; column++) {
        for (int row = 0; row < 3; row++)
            m[4 * column + row] = rotation[3 * column + row] * s[column];
        m[4 * column + 3] = 0;
    }
    memcpy(m + 12, trs->translation, 3 * sizeof *m);
    m[15] = 1;
}

static double matrix_dot(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void matrix_cross(const double a[3], const double b[3], double c[3]) {
    c[0] = a[1] * b[2] - a[2] * b[1];
    c[1] = a[2] * b[0] - a[0] * b[2];
    c[2] = a[0] * b[1] - a[1] * b[0];
}

/* The columns of the upper 3x3 times a power of two that brings the largest number near 1, so that
 * no square overflows. Returns its exponent. */
static int scaled_columns(const double m[16], double columns[9]) {
    double largest = 0;
    for (int i = 0; i < 9; i++) {
        columns[i] = m[4 * (i / 3) + i % 3];
        largest = fmax(largest, fabs(columns[i]));
    }
    int exponent = 0;
    if (largest > 0 && isfinite(largest)) frexp(largest, &exponent);
    for (int i = 0; i < 9; i++) columns[i] = ldexp(columns[i], -exponent);
    return exponent;
}

int norma_gltf_matrix_invert(const double m[16], double inverse[16]) {
    double c[9], cofactor[9];
    const int exponent = scaled_columns(m, c);
    matrix_cross(c + 3, c + 6, cofactor);
    matrix_cross(c + 6, c, cofactor + 3);
    matrix_cross(c, c + 3, cofactor + 6);
    const double determinant = matrix_dot(c, cofactor);
    if (determinant == 0) return 0;
    for (int row = 0; row < 3; row++) {
        for (int column = 0; column < 3; column++)
            inverse[4 * column + row] = ldexp(cofactor[3 * row + column] / determinant, -exponent);
        inverse[4 * row + 3] = 0;
    }
    for (int row = 0; row < 3; row++)
        inverse[12 + row] =
            -(inverse[row] * m[12] + inverse[4 + row] * m[13] + inverse[8 + row] * m[14]);
    inverse[15] = 1;
    for (int i = 0; i < 16; i++)
        if (!isfinite(inverse[i])) return 0;
    return 1;
}

void norma_gltf_complete_basis(double columns[9], int count) {
    if (count < 1) {
        const double x[3] = {1, 0, 0};
        memcpy(columns, x, sizeof x);
    }
    if (count < 2) { /* perpendicular to the first, away from the axis that is nearest to it */
        const double *a = columns;
        int axis = 0;
        for (int i = 1; i < 3; i++)
            if (fabs(a[i]) < fabs(a[axis])) axis = i;
        double e[3] = {0, 0, 0};
        e[axis] = 1;
        matrix_cross(a, e, columns + 3);
        const double length = sqrt(matrix_dot(columns + 3, columns + 3));
        for (int i = 3; i < 6; i++) columns[i] /= length;
    }
    if (count < 3) matrix_cross(columns, columns + 3, columns + 6);
}

/* Unit columns in place, their lengths into lengths; what is zero is filled with what completes the
 * basis. */
static void normalise_columns(double columns[9], double lengths[3]) {
    int order[3] = {0, 1, 2}, whole = 0;
    for (int i = 0; i < 3; i++) {
        lengths[i] = sqrt(matrix_dot(columns + 3 * i, columns + 3 * i));
        if (lengths[i] > 0) order[whole++] = i;
    }
    int at = whole;
    for (int i = 0; i < 3; i++)
        if (!(lengths[i] > 0)) order[at++] = i;
    double basis[9];
    for (int i = 0; i < whole; i++)
        for (int k = 0; k < 3; k++)
            basis[3 * i + k] = columns[3 * order[i] + k] / lengths[order[i]];
    norma_gltf_complete_basis(basis, whole);
    for (int i = 0; i < 3; i++) memcpy(columns + 3 * order[i], basis + 3 * i, 3 * sizeof *columns);
}

/* Shepperd's method: the largest of four sums decides which component is taken by a root. */
static void quaternion_of(const double r[9], double q[4]) {
    const double sums[4] = {
        r[0] - r[4] - r[8], r[4] - r[0] - r[8], r[8] - r[0] - r[4], r[0] + r[4] + r[8]};
    int largest = 3;
    for (int i = 0; i < 3; i++)
        if (sums[i] > sums[largest]) largest = i;
    const double first = sqrt(fmax(0, 1 + sums[largest])) / 2, quarter = 1 / (4 * first);
    const double skew[3] = {r[5] - r[7], r[6] - r[2], r[1] - r[3]};
    q[largest] = first;
    for (int i = 0; i < 3; i++) {
        if (largest == 3)
            q[i] = skew[i] * quarter;
        else if (i != largest)
            q[i] = (r[3 * i + largest] + r[3 * largest + i]) * quarter;
    }
    if (largest != 3) q[3] = skew[largest] * quarter;
    double length = sqrt(matrix_dot(q, q) + q[3] * q[3]);
    if (q[3] < 0) length = -length;
    for (int i = 0; i < 4; i++) q[i] = q[i] / length + 0.0; /* no negative zeros in files */
}

/* rotation and scale of orthogonal columns; a mirror goes into the first scale, that of columns
 * made up for a singular matrix into theirs. */
static void rotation_and_scale(
    double columns[9], const double lengths[3], int exponent, gltf_trs *trs) {
    double normal[3];
    matrix_cross(columns, columns + 3, normal);
    const int mirrored = matrix_dot(normal, columns + 6) < 0;
    int flip = 0;
    for (int i = 0; i < 3; i++) {
        trs->scale[i] = ldexp(lengths[i], exponent);
        if (!(lengths[i] > 0)) flip = i;
    }
    if (mirrored) {
        trs->scale[flip] = lengths[flip] > 0 ? -trs->scale[flip] : 0;
        for (int k = 0; k < 3; k++) columns[3 * flip + k] = -columns[3 * flip + k];
    }
    quaternion_of(columns, trs->rotation);
}

double norma_gltf_matrix_decompose(const double m[16], gltf_trs *trs) {
    double columns[9], lengths[3], worst = 0;
    const int exponent = scaled_columns(m, columns);
    for (int i = 0; i < 3; i++) {
        const double *a = columns + 3 * i, *b = columns + 3 * ((i + 1) % 3);
        const double product = sqrt(matrix_dot(a, a)) * sqrt(matrix_dot(b, b));
        if (product > 0) worst = fmax(worst, fabs(matrix_dot(a, b)) / product);
    }
    memcpy(trs->translation, m + 12, sizeof trs->translation);
    if (worst < 1e-3) {
        normalise_columns(columns, lengths);
        rotation_and_scale(columns, lengths, exponent, trs);
    }
    return worst;
}

/* Rotates columns p and q of a, and of v with them, so that those of a become perpendicular.
 * Returns whether they were not. */
static int rotate_column_pair(double a[9], double v[9], int p, int q) {
    double *x = a + 3 * p, *y = a + 3 * q;
    const double xx = matrix_dot(x, x), yy = matrix_dot(y, y), xy = matrix_dot(x, y);
    if (fabs(xy) <= 1e-16 * sqrt(xx) * sqrt(yy)) return 0;
    const double zeta = (yy - xx) / (2 * xy);
    const double t = (zeta < 0 ? -1 : 1) / (fabs(zeta) + sqrt(1 + zeta * zeta)),
                 c = 1 / sqrt(1 + t * t), s = c * t;
    for (int k = 0; k < 3; k++) {
        const double ax = x[k], vx = v[3 * p + k], vy = v[3 * q + k];
        x[k] = c * ax - s * y[k];
        y[k] = s * ax + c * y[k];
        v[3 * p + k] = c * vx - s * vy;
        v[3 * q + k] = s * vx + c * vy;
    }
    return 1;
}

void norma_gltf_matrix_split(const double m[16], gltf_trs *outer, gltf_trs *inner) {
    double a[9], lengths[3], v[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    const int exponent = scaled_columns(m, a);
    for (int sweep = 0, turned = 1; turned && sweep < 60; sweep++) { /* converges in about six */
        turned = rotate_column_pair(a, v, 0, 1);
        turned |= rotate_column_pair(a, v, 0, 2); /* in this order, which no compiler may change */
        turned |= rotate_column_pair(a, v, 1, 2);
    }
    normalise_columns(a, lengths);
    memcpy(outer->translation, m + 12, sizeof outer->translation);
    rotation_and_scale(a, lengths, exponent, outer);

    quaternion_of(v, inner->rotation); /* its inverse: m = outer v^T */
    for (int k = 0; k < 3; k++) {
        inner->rotation[k] = 0.0 - inner->rotation[k];
        inner->translation[k] = 0;
        inner->scale[k] = 1;
    }
}
