/* normal_matrix.c: normal matrices of float models, one and concatenated.
 *
 * A normal is what is left of two tangents: M a x M b = cof(M)(a x b) for every M, so the cofactor
 * matrix carries normals, without a division, at rank 2 too. The columns of cof(M) are the cross
 * products of M's columns. In double precision the products of two floats are exact, and so are the
 * sign and the zero-ness of each difference; nothing overflows or underflows before the last
 * rounding. */
#include "core/matrix/matrix.h"
#include <float.h>
#include <math.h>
#include <string.h>

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

static inline double larger(double a, double b) {
    return a > b ? a : b; /* one instruction, which fmax with its rule about NaN is not */
}

static inline double largest(const double column[3]) {
    return larger(larger(fabs(column[0]), fabs(column[1])), fabs(column[2]));
}

/* Whether each column's largest entry is a normal float, so that no power of two is needed. */
static inline int fits_floats(const double c[9]) {
    const double x = largest(c), y = largest(c + 3), z = largest(c + 6),
                 most = larger(larger(x, y), z);
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
    for (int i = 0; i < 9; i++) numbers[i] = norma_scaled_from_double(c->entry[i]);
    double determinant = 0.0;
    if (winding == NORMA_WINDING_REVERSED) {
        const int certain = fabs(c->determinant) > 0x1p-50 * c->magnitude;
        determinant = certain ? c->determinant : norma_exact_determinant(upper).mantissa;
    }
    norma_matrix_to_floats(numbers, determinant < 0.0 ? -1.0 : 1.0, out);
    return NORMA_OK;
}

norma_result norma_core_normal_matrix_of(
    const float model[16], norma_winding winding, float out[9]) {
    const cofactors c = cofactors_of(model);
    const int certain =
        winding == NORMA_WINDING_KEPT || fabs(c.determinant) > 0x1p-50 * c.magnitude;
    if (!(certain && c.finite == 0.0 && fits_floats(c.entry)))
        return normal_matrix_rarely(model, &c, winding, out);
    const double sign = winding == NORMA_WINDING_REVERSED
                            ? copysign(1.0, c.determinant)
                            : 1.0; /* no branch: mirrors come as they like */
    for (int i = 0; i < 9; i++) out[i] = (float)(c.entry[i] * sign) + 0.0f; /* no negative zeros */
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
    const norma_result result = norma_core_normal_matrix_of(model, winding, normal_matrix);
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
    for (int k = 0; k < 3; k++) {
        const int k1 = (k + 1) % 3, k2 = (k + 2) % 3; /* cof(V)(row, k), cof(M)(k, column) */
        for (int term = 0; term < 4; term++) {
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
    for (int column = 0; column < 3; column++)
        for (int row = 0; row < 3; row++) {
            double sum = 0.0, magnitude = 0.0;
            for (int k = 0; k < 3; k++) {
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
 * model's translation: relative to the terms of the sum. */
static int is_translated(const float view[16], const float model[16]) {
    for (int row = 0; row < 3; row++) {
        double sum = (double)view[12 + row], magnitude = fabs(sum);
        for (int k = 0; k < 3; k++) {
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
    for (int i = 0; i < 9; i++) {
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
    const int translated = is_translated(view, model);
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
