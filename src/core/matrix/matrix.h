/* matrix.h: what the files about matrices share, and every call that maps one array of vectors to
 * another. A 3x3 is nine numbers, column after column. */
#ifndef NORMA_CORE_MATRIX_INTERNAL_H
#define NORMA_CORE_MATRIX_INTERNAL_H
#include "core/face/face.h"
#include <norma/norma.h>
#include <float.h>
#include <math.h>

/* ---- matrix_info.c */

/* The upper 3x3 of a model; 0 where an entry is not finite. */
int norma_matrix_upper_float(const float model[16], double upper[9]);
int norma_matrix_upper_double(const double model[16], double upper[9]);

/* Both rounded once from the exact value: the sign and whether it is zero are exact. */
scaled_number norma_exact_determinant(const double upper[9]);

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
void norma_matrix_to_floats(const scaled_number numbers[9], double sign, float out[9]);

/* Fills info for a finite upper 3x3. */
void norma_matrix_describe(
    const double upper[9], int translated, scaled_number determinant, norma_matrix_info *info);

/* Singular values of a finite 3x3 in no order, and its right singular vectors (columns of v), v
 * orthonormal. The largest entry must be near 1. */
void norma_singular_values(const double matrix[9], double values[3], double v[9]);

/* Below this part of a tangent's length, what is perpendicular to the normal is rounding noise
 * rather than a direction. */
#define NOTHING_LEFT 0x1p-20

/* transform.c: a tangent made unit and perpendicular to the normal; the normal may be zero or not
 * finite: then it asks nothing of the tangent. */
void norma_core_perpendicular_tangent(
    const double normal[3], const double tangent[3], double out[3]);

/* ---- What every call that maps one array of vectors to another shares: the checks of its
 * arguments, and directions without a range. */

/* An output, or codes that are read, of count elements of size bytes; *stride becomes size where it
 * is 0. */
static inline norma_result norma_output_check(
    const void *out, size_t *stride, size_t size, size_t count, size_t capacity) {
    if (!count) return NORMA_OK;
    if (!out) return NORMA_ERROR_ARGUMENT;
    if (!*stride) *stride = size;
    if (*stride < size) return NORMA_ERROR_ARGUMENT;
    if (count > SIZE_MAX / *stride) return NORMA_ERROR_OVERFLOW;
    return capacity < count ? NORMA_ERROR_CAPACITY : NORMA_OK;
}

static inline norma_result norma_input_check(const norma_vec3_view *view) {
    if (!norma_format_size(view->format)) return NORMA_ERROR_ARGUMENT;
    if (view->count && !view->data) return NORMA_ERROR_ARGUMENT;
    return norma_view_overflows(view) ? NORMA_ERROR_OVERFLOW : NORMA_OK;
}

/* Multiplies v by the power of two that brings its largest component into [1, 2); 0 where v is zero
 * or not finite. */
static inline int norma_vec3_scale(double v[3]) {
    double largest = 0.0;
    for (int i = 0; i < 3; ++i) {
        if (!(fabs(v[i]) <= DBL_MAX)) return 0;
        if (fabs(v[i]) > largest) largest = fabs(v[i]);
    }
    if (largest == 0.0) return 0;
    int exponent;
    (void)frexp(largest, &exponent);
    for (int i = 0; i < 3; ++i) v[i] = ldexp(v[i], 1 - exponent);
    return 1;
}

/* Makes v a unit vector, whatever its length; 0, and v unspecified, where it is zero or not finite.
 */
static inline int norma_vec3_unit(double v[3]) {
    double square = norma_core_dot(v, v);
    if (!(square > NORMA_TINIEST && square < NORMA_HUGEST)) {
        if (!norma_vec3_scale(v)) return 0;
        square = norma_core_dot(v, v);
    }
    const double length = sqrt(square);
    for (int i = 0; i < 3; ++i) v[i] /= length;
    return 1;
}

/* ---- What the files about skins share (skin.c, skin_block.c). */

/* A matrix as a row of sixteen doubles, two registers of AVX-512: the first nine of it, its
 * translation, and its size, the largest of the nine. Rows are added up whole. */
enum { SKIN_TRANSLATION = 9, SKIN_SIZE = 12, SKIN_ROW = 16, SKIN_MOST_INFLUENCES = 64 };

typedef struct skin_stream {
    core_call call;
    const norma_skin *skin;
    const unsigned char *joints;
    size_t joint_size, influences;
    /* Of each joint; zeros where it is not finite, and so not in use. For dual quaternions the rows
     * are stretches, and eight doubles are the rotation (x, y, z, w) and the dual part. */
    double (*rows)[SKIN_ROW], (*duals)[8];
    double largest; /* size of them all */
    norma_vec3_view in;
    const float *tangents;
    core_output out;
    core_tally *tallies; /* of each task */
} skin_stream;

/* Moves count vertices, from first on. tally: for normals only. */
void norma_skin_move(const skin_stream *s, size_t first, size_t count, core_tally *tally);

/* The matrix in row becomes its stretch, and dual its rotation and translation. */
void norma_skin_prepare_dual(double row[SKIN_ROW], double dual[8]);
#endif
