/* unit_length.h: what a broken normal or tangent is, for computing (--only broken) and for the
 * rules (N101 to N103, N205, N801): not finite, of no length, or not of unit length within what its
 * encoding can do. */
#ifndef NORMA_IO_UNIT_LENGTH_H
#define NORMA_IO_UNIT_LENGTH_H
#include <math.h>

typedef enum length_verdict {
    LENGTH_UNIT = 0,
    LENGTH_OTHER,
    LENGTH_ZERO, /* no direction either */
    LENGTH_NON_FINITE
} length_verdict;

/* How far from 1 the length of a unit vector may be in so many bits: half a step of each number, or
 * what programs lose that write floats and texts. strict: the latter are held to 1e-4. */
static inline double norma_unit_tolerance(int bits, int strict) {
    return bits == 8 ? .00682 : bits == 10 ? .0017 : strict ? 1e-4 : 5e-4;
}

/* length: written; it has no meaning where a number is not finite. */
static inline length_verdict norma_judge_length(
    const double v[3], double tolerance, double *length) {
    *length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    if (fabs(*length - 1) <= tolerance) return LENGTH_UNIT;
    if (!isfinite(v[0]) || !isfinite(v[1]) || !isfinite(v[2])) return LENGTH_NON_FINITE;
    return *length < 1e-6 ? LENGTH_ZERO : LENGTH_OTHER;
}
#endif
