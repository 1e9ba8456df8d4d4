/* exact_sum.h: sums of products of up to four doubles without any rounding, for signs and zeros
 * that must be exact.
 *
 * A long fixed-point register holds every bit that such a product can have (Kulisch's accumulator).
 * It is slow beside two or three floating-point operations, so callers ask a floating-point filter
 * first and come here only where that cannot decide. */
#ifndef NORMA_CORE_EXACT_SUM_H
#define NORMA_CORE_EXACT_SUM_H
#include <stdint.h>

enum { EXACT_SUM_FACTORS = 4, EXACT_SUM_LIMBS = 264 };

/* Two's complement; the lowest bit weighs 2^(-4 * 1074). The widest sum, 2^12 products near 2^4096,
 * leaves the sign bit free. */
typedef struct exact_sum {
    uint32_t limb[EXACT_SUM_LIMBS];
} exact_sum;

/* mantissa * 2^exponent with 1 <= |mantissa| < 2, or mantissa 0: a double without its narrow range.
 */
typedef struct scaled_number {
    double mantissa;
    int exponent;
} scaled_number;

void norma_exact_clear(exact_sum *sum);
void norma_exact_add(
    exact_sum *sum, const double *factors, int count, int negative); /* all finite; count 1 to 4 */
scaled_number norma_exact_round(const exact_sum *sum);               /* to nearest, ties to even */

scaled_number norma_scaled_from_double(double value); /* finite */
double norma_scaled_to_double(
    scaled_number number); /* rounded: infinite or zero beyond a double's range */
#endif
