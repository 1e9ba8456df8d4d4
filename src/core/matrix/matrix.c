/* matrix.c: exact determinants and cofactors, their common power of two, and the matrices that
 * norma.h gives by name in double precision. */
#include "core/matrix/matrix.h"
#include <math.h>
#include <string.h>

const number_range norma_float_range = {-126, 127, 0x1.fffffep0},
                   norma_double_range = {-1022, 1023, 0x1.fffffffffffffp0};

int norma_matrix_upper_float(const float model[16], double upper[9]) {
    int finite = 1;
    for (int i = 0; i < 9; i++) {
        upper[i] = (double)model[i / 3 * 4 + i % 3];
        finite &= isfinite(upper[i]) != 0;
    }
    return finite;
}

int norma_matrix_upper_double(const double model[16], double upper[9]) {
    int finite = 1;
    for (int i = 0; i < 9; i++) {
        upper[i] = model[i / 3 * 4 + i % 3];
        finite &= isfinite(upper[i]) != 0;
    }
    return finite;
}

scaled_number norma_exact_determinant(const double upper[9]) {
    exact_sum sum;
    norma_exact_clear(&sum);
    for (int i = 0; i < 3; i++) { /* Sarrus: a_0i (a_1j a_2k - a_1k a_2j) */
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        norma_exact_add(&sum, (const double[]){upper[i], upper[3 + j], upper[6 + k]}, 3, 0);
        norma_exact_add(&sum, (const double[]){upper[i], upper[3 + k], upper[6 + j]}, 3, 1);
    }
    return norma_exact_round(&sum);
}

/* Neither products of three nor their parts leave the range of doubles. */
static int is_mild(const double upper[9]) {
    int mild = 1;
    for (int i = 0; i < 9; i++)
        mild &= upper[i] == 0.0 || (fabs(upper[i]) > 0x1p-300 && fabs(upper[i]) < 0x1p300);
    return mild;
}

int norma_matrix_mirrors(const double upper[9]) {
    double sum = 0, sizes = 0; /* of six products, each twice rounded, and five sums: wrong by less
                                  than 8 * 2^-53 of their sizes */
    for (int i = 0; i < 3; i++) {
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
void norma_exact_cofactors(const double upper[9], scaled_number cofactors[9]) {
    for (int c = 0; c < 3; c++) {
        const double *a = upper + 3 * ((c + 1) % 3), *b = upper + 3 * ((c + 2) % 3);
        for (int r = 0; r < 3; r++) {
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
static int fits(const scaled_number numbers[9], number_range range) {
    for (int c = 0; c < 3; c++) {
        int zero = 1, kept = 0;
        for (int r = 0; r < 3; r++) {
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

int norma_matrix_common_shift(const scaled_number numbers[9], number_range range) {
    if (fits(numbers, range)) return 0;
    int least = INT32_MAX, most = INT32_MIN;
    double mantissa = 0.0; /* of the largest */
    for (int i = 0; i < 9; i++) {
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
    const int shift = norma_matrix_common_shift(numbers, norma_float_range);
    for (int i = 0; i < 9; i++)
        out[i] = (float)ldexp(sign * numbers[i].mantissa, numbers[i].exponent + shift) + 0.0f;
}

void norma_matrix_to_doubles(const scaled_number numbers[9], double sign, double out[9]) {
    const int shift = norma_matrix_common_shift(numbers, norma_double_range);
    for (int i = 0; i < 9; i++)
        out[i] = ldexp(sign * numbers[i].mantissa, numbers[i].exponent + shift) + 0.0;
}

static int is_translated(const double model[16]) {
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
    const int translated =
        is_translated(model); /* read before anything is written: the output may be the model */
    scaled_number cofactors[9];
    norma_exact_cofactors(upper, cofactors);
    const scaled_number determinant = norma_exact_determinant(upper);
    const double sign =
        winding == NORMA_WINDING_REVERSED && determinant.mantissa < 0.0 ? -1.0 : 1.0;
    norma_matrix_to_doubles(cofactors, sign, normal_matrix);
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
    norma_exact_cofactors(upper, numbers);
    for (int i = 0; i < 9; i++) {
        const int exponent = numbers[i].exponent - determinant.exponent;
        numbers[i] = norma_scaled_from_double(numbers[i].mantissa / determinant.mantissa);
        numbers[i].exponent += exponent;
    }
    norma_matrix_to_doubles(numbers, 1.0, inverse_transpose);
    return NORMA_OK;
}

/* Column / (its length)^2, as numbers without a range; 0 for a column of zeros. */
static int divide_by_square(const double column[3], scaled_number out[3]) {
    const double largest = fmax(fmax(fabs(column[0]), fabs(column[1])), fabs(column[2]));
    if (largest == 0.0) return 0;
    const int exponent = norma_scaled_from_double(largest).exponent;
    double square = 0.0;
    for (int r = 0; r < 3; r++) {
        const double scaled = ldexp(column[r], -exponent);
        square += scaled * scaled;
    }
    for (int r = 0; r < 3; r++) {
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
    for (int c = 0; c < 3; c++)
        if (!divide_by_square(upper + 3 * c, numbers + 3 * c)) return NORMA_ERROR_ARGUMENT;
    norma_matrix_to_doubles(numbers, 1.0, normal_matrix);
    return NORMA_OK;
}
