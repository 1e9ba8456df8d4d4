/* matrix.h: what the files about matrices share. A 3x3 is nine numbers, column after column. */
#ifndef NORMA_CORE_MATRIX_INTERNAL_H
#define NORMA_CORE_MATRIX_INTERNAL_H
#include "core/face/exact_sum.h"
#include <norma/norma.h>

/* The upper 3x3 of a model; 0 where an entry is not finite. */
int norma_matrix_upper_float(const float model[16], double upper[9]);
int norma_matrix_upper_double(const double model[16], double upper[9]);

/* Both rounded once from the exact value: the sign and whether it is zero are exact. */
scaled_number norma_exact_determinant(const double upper[9]);
void norma_exact_cofactors(const double upper[9], scaled_number cofactors[9]);

/* Whether a finite 3x3's determinant is below zero, exactly: by doubles where their rounding cannot
 * turn the sign, else by exact sums, which take a hundred times as long. */
int norma_matrix_mirrors(const double upper[9]);

/* The common power of two of nine numbers that are to be floats or doubles, as norma.h tells it
 * under norma_normal_matrix: 0 where they fit as they are. lowest, highest: exponents of the
 * smallest and largest normal number of the type, whose last value is largest. */
typedef struct number_range {
    int lowest, highest;
    double largest; /* mantissa of the largest number */
} number_range;
extern const number_range norma_float_range, norma_double_range;
int norma_matrix_common_shift(const scaled_number numbers[9], number_range range);
void norma_matrix_to_floats(const scaled_number numbers[9], double sign, float out[9]);
void norma_matrix_to_doubles(const scaled_number numbers[9], double sign, double out[9]);

/* Fills info for a finite upper 3x3. */
void norma_matrix_describe(
    const double upper[9], int translated, scaled_number determinant, norma_matrix_info *info);

/* Singular values of a finite 3x3 in no order, and its right singular vectors (columns of v), v
 * orthonormal. The largest entry must be near 1. */
void norma_singular_values(const double matrix[9], double values[3], double v[9]);

/* A tangent made unit and perpendicular to the normal; the normal may be zero or not finite: then
 * it asks nothing of the tangent. */
void norma_core_perpendicular_tangent(
    const double normal[3], const double tangent[3], double out[3]);

/* The normal matrix of one model; the error is that some entry is not finite, and zeros were
 * written. */
norma_result norma_core_normal_matrix_of(
    const float model[16], norma_winding winding, float out[9]);
#endif
