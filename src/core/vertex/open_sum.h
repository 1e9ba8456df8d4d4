/* open_sum.h: weighted sums of vectors that do not depend on the order in which they are added, nor
 * on how they are grouped: for one surface in many files.
 *
 * Each number is cut into digits of 32 bits at fixed places, and the digits of a place are added as
 * integers. A sum keeps three places, from that of the largest weight on; what lies below is cut
 * off each number, also of those that were added before (their lowest digits are dropped). So the
 * sum follows from the set of what was added. It errs by less than 2^-64 of the largest weight for
 * each of them. (Demmel, Nguyen 2013, "Fast reproducible floating-point summation", with integers.)
 */
#ifndef NORMA_CORE_OPEN_SUM_H
#define NORMA_CORE_OPEN_SUM_H
#include <stdint.h>

enum { OPEN_SUM_PLACES = 3 };

/* Zeroed, it has no votes. Up to 2^31 may be added. */
typedef struct open_sum {
    int64_t digits[4][OPEN_SUM_PLACES]; /* of x, y, z and the weight; the lowest place first */
    int32_t top;                        /* the highest place: its digits count 2^(32 top) */
    uint32_t votes;                     /* nonzero: some */
} open_sum;

/* Adds weight * vector, whose length is at most 1. A weight that is not finite is left out. */
void norma_core_open_sum_add(open_sum *sum, double weight, const double vector[3]);
void norma_core_open_sum_join(open_sum *sum, const open_sum *other);
/* The sum, and the sum of the weights, both times a power of two. */
void norma_core_open_sum_value(const open_sum *sum, double vector[3], double *weight);
#endif
