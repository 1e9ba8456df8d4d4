/* skin_dual.c: skins by dual quaternions: Kavan, Collins, Zara, O'Sullivan 2008, Geometric Skinning
 * with Approximate Dual Quaternion Blending, eq. 18. Each joint is a rotation after a stretch, M =
 * R S, with S symmetric (the right polar factor, by singular values). Where M mirrors, both are
 * negated, so that R is a rotation (Shoemake, Duff 1992). Stretches are blended linearly, rotations
 * and translations on the sphere. */
#include "core/matrix/matrix.h"

/* ---- one joint */

/* A unit vector perpendicular to the unit vector a: along the axis that a leans on least. */
static void any_perpendicular_to(const double a[3], double out[3]) {
    const double x = fabs(a[0]), y = fabs(a[1]), z = fabs(a[2]);
    const double axis[3] = {
        x <= y && x <= z, !(x <= y && x <= z) && y <= z, !(x <= y && x <= z) && !(y <= z)};
    norma_core_cross(a, axis, out);
    norma_core_normalise(out, out);
}

/* The columns of U, unit: M v / s, largest first; what a singular matrix leaves open is made
 * perpendicular to them. */
static void left_vectors(
    const double m[9], const double v[9], const double values[3], int mirrored, double u[9]) {
    int order[3] = {0, 1, 2};
    for (int i = 0; i < 2; ++i)
        for (int k = 0; k < 2; ++k)
            if (values[order[k]] < values[order[k + 1]]) {
                const int swapped = order[k];
                order[k] = order[k + 1];
                order[k + 1] = swapped;
            }
    double *first = u + 3 * order[0], *second = u + 3 * order[1], *third = u + 3 * order[2];
    for (int i = 0; i < 3; ++i)
        for (int r = 0; r < 3; ++r)
            u[3 * i + r] = m[r] * v[3 * i] + m[3 + r] * v[3 * i + 1] + m[6 + r] * v[3 * i + 2];
    const double least = 0x1p-40 * values[order[0]];
    if (values[order[0]] > 0.0)
        norma_core_normalise(first, first);
    else
        memcpy(first, v + 3 * order[0], 3 * sizeof *first);
    if (values[order[1]] > least)
        norma_core_normalise(second, second);
    else
        any_perpendicular_to(first, second);
    /* The third by the first two, so that U turns as V does, or mirrors. */
    double turn[3];
    norma_core_cross(v + 3 * order[0], v + 3 * order[1], turn);
    const double side = norma_core_dot(turn, v + 3 * order[2]) < 0.0 ? -1.0 : 1.0;
    norma_core_cross(first, second, third);
    for (int r = 0; r < 3; ++r) third[r] *= mirrored ? -side : side;
    norma_core_normalise(third, third);
}

static void quaternion_of(const double r[9], double q[4]) {
    const double trace = r[0] + r[4] + r[8];
    if (trace > 0.0) {
        const double s = 2.0 * sqrt(trace + 1.0);
        q[3] = s / 4.0;
        q[0] = (r[5] - r[7]) / s;
        q[1] = (r[6] - r[2]) / s;
        q[2] = (r[1] - r[3]) / s;
        return;
    }
    const int i = r[0] >= r[4] && r[0] >= r[8] ? 0 : (r[4] >= r[8] ? 1 : 2), j = (i + 1) % 3,
              k = (i + 2) % 3;
    const double s = 2.0 * sqrt(1.0 + r[4 * i] - r[4 * j] - r[4 * k]);
    q[i] = s / 4.0;
    q[j] = (r[3 * i + j] + r[3 * j + i]) / s;
    q[k] = (r[3 * i + k] + r[3 * k + i]) / s;
    q[3] = (r[3 * j + k] - r[3 * k + j]) / s;
}

static void split_stretch(const double m[9], double rotation[9], double stretch[9]) {
    double scaled[9], values[3], v[9], u[9], s[9], largest = 0.0;
    int exponent = 0;
    for (int i = 0; i < 9; ++i) largest = fmax(largest, fabs(m[i]));
    if (largest > 0.0) (void)frexp(largest, &exponent);
    for (int i = 0; i < 9; ++i) scaled[i] = ldexp(m[i], 1 - exponent);
    const int mirrored = norma_matrix_mirrors(m);
    norma_singular_values(scaled, values, v);
    left_vectors(scaled, v, values, mirrored, u);
    for (int c = 0; c < 3; ++c)
        for (int r = 0; r < 3; ++r) {
            const double entry = u[r] * v[c] + u[3 + r] * v[3 + c] + u[6 + r] * v[6 + c];
            rotation[3 * c + r] = mirrored ? -entry : entry;
        }
    for (int c = 0; c < 3; ++c) /* S = R^T M, made symmetric */
        for (int r = 0; r < 3; ++r) s[3 * c + r] = norma_core_dot(rotation + 3 * r, m + 3 * c);
    for (int c = 0; c < 3; ++c)
        for (int r = 0; r < 3; ++r) stretch[3 * c + r] = (s[3 * c + r] + s[3 * r + c]) / 2.0;
}

void norma_skin_prepare_dual(double row[SKIN_ROW], double dual[8]) {
    double m[9], rotation[9], t[3], cross[3], *q = dual, *d = q + 4;
    memcpy(m, row, sizeof m);
    memcpy(t, row + SKIN_TRANSLATION, sizeof t);
    split_stretch(m, rotation, row);
    quaternion_of(rotation, q);
    /* (t, 0) q / 2 */
    norma_core_cross(t, q, cross);
    for (int i = 0; i < 3; ++i) d[i] = (t[i] * q[3] + cross[i]) / 2.0;
    d[3] = -norma_core_dot(t, q) / 2.0;
}

/* ---- one vertex */

static void rotate_columns(const double q[4], double square, double b[9]) {
    const double x = q[0], y = q[1], z = q[2], w = q[3], s = 2.0 / square;
    const double r[9] = {1 - s * (y * y + z * z), s * (x * y + z * w), s * (x * z - y * w),
        s * (x * y - z * w), 1 - s * (x * x + z * z), s * (y * z + x * w), s * (x * z + y * w),
        s * (y * z - x * w), 1 - s * (x * x + y * y)};
    for (int c = 0; c < 3; ++c) {
        const double v[3] = {b[3 * c], b[3 * c + 1], b[3 * c + 2]};
        for (int i = 0; i < 3; ++i) b[3 * c + i] = r[i] * v[0] + r[3 + i] * v[1] + r[6 + i] * v[2];
    }
}

/* 2 d conj(q) / |q|^2: the translation of a dual quaternion that need not be of unit length. */
static void translation_of(const double q[4], const double d[4], double square, double out[3]) {
    double cross[3];
    norma_core_cross(q, d, cross);
    for (int i = 0; i < 3; ++i) out[i] = 2 * (q[3] * d[i] - d[3] * q[i] + cross[i]) / square;
}

/* Of the two quaternions of a rotation, the one on the side of the first joint that weighs
 * something (Kavan 2008, section 4.1). Where they cancel, that joint's rotation is kept. */
void norma_skin_blend_dual(const skin_stream *s, size_t vertex, double b[SKIN_ROW]) {
    const size_t first = vertex * s->influences;
    double sum[8] = {0};
    const double *pivot = NULL;
    for (int i = 0; i < SKIN_ROW; ++i) b[i] = 0.0;
    for (size_t k = 0; k < s->influences; ++k) {
        const double weight = (double)s->skin->weights[first + k];
        if (weight == 0.0) continue;
        const uint32_t j = norma_index_read(s->joints, s->joint_size, first + k);
        if (!pivot) pivot = s->duals[j];
        double along = 0.0;
        for (int i = 0; i < 4; ++i) along += s->duals[j][i] * pivot[i];
        for (int i = 0; i < 8; ++i) sum[i] += (along < 0 ? -weight : weight) * s->duals[j][i];
        for (int i = 0; i < 9; ++i) b[i] += weight * s->rows[j][i];
    }
    if (!pivot) return;
    double square = sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2] + sum[3] * sum[3];
    if (!(square > 0x1p-80)) {
        memcpy(sum, pivot, sizeof sum);
        square = 1.0;
    }
    rotate_columns(sum, square, b);
    translation_of(sum, sum + 4, square, b + SKIN_TRANSLATION);
}
