/* broken_normal.h: what a broken normal is, for every format and for --only broken (rules N101 to
 * N103): not finite, or not of unit length within what its encoding can do. */
#ifndef NORMA_IO_BROKEN_NORMAL_H
#define NORMA_IO_BROKEN_NORMAL_H
#include <math.h>

/* How far from 1 the length of a stored unit normal may be: eight bits hold no better. */
static inline double norma_unit_tolerance(int bits) { return bits == 8 ? .00682 : 5e-4; }

/* A normal of no length is far from 1 as well; a comparison with NaN is false. */
static inline int norma_normal_is_broken(const double normal[3], double tolerance) {
    const double length =
        sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
    return !(fabs(length - 1) <= tolerance);
}
#endif
