/* unit_length.h: what a broken normal or tangent is, for computing (--only broken) and for the
 * rules (N101 to N103, N205, N801): not finite, of no length, or not of unit length within what its
 * encoding can do. */
#ifndef NORMA_CORE_UNIT_LENGTH_H
#define NORMA_CORE_UNIT_LENGTH_H
#include <math.h>

typedef enum core_length {
    CORE_LENGTH_UNIT = 0,
    CORE_LENGTH_OTHER,
    CORE_LENGTH_ZERO, /* no direction either */
    CORE_LENGTH_NON_FINITE
} core_length;

/* How far from 1 the length of a unit vector may be in so many bits: half a step of each number, or
 * what programs lose that write floats and texts. strict: the latter are held to 1e-4. */
static inline double norma_core_unit_tolerance(int bits, int strict) {
    return bits == 8 ? .00682 : bits == 10 ? .0017 : strict ? 1e-4 : 5e-4;
}

/* length: written; it has no meaning if a number is not finite. Below 1e-6 of the length 1 that it
 * ought to have, a stored vector counts as zero: its direction is rounding. */
static inline core_length norma_core_judge_length(
    const double v[3], double tolerance, double *length) {
    *length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    if (fabs(*length - 1) <= tolerance) return CORE_LENGTH_UNIT;
    if (!isfinite(v[0]) || !isfinite(v[1]) || !isfinite(v[2])) return CORE_LENGTH_NON_FINITE;
    return *length < 1e-6 ? CORE_LENGTH_ZERO : CORE_LENGTH_OTHER;
}
#endif
