/* vector.c: lengths and directions of any scale: what squares of doubles cannot hold is brought
 * near 1 first, by an exact power of two. */
#include "core/call/vector.h"
#include <math.h>

double norma_core_length(const double v[3]) {
    const double square = norma_core_dot(v, v);
    if (square > NORMA_TINIEST && square < NORMA_HUGEST) return sqrt(square);
    const double largest = fmax(fabs(v[0]), fmax(fabs(v[1]), fabs(v[2])));
    if (!(largest > 0) || largest > 0x1.fffffffffffffp1023) return largest;
    const int exponent = ilogb(largest);
    const double scaled[3] = {
        ldexp(v[0], -exponent), ldexp(v[1], -exponent), ldexp(v[2], -exponent)};
    return ldexp(sqrt(norma_core_dot(scaled, scaled)), exponent);
}

void norma_core_normalise(const double v[3], double unit[3]) {
    double scaled[3] = {v[0], v[1], v[2]};
    const double square = norma_core_dot(v, v);
    if (!(square > NORMA_TINIEST && square < NORMA_HUGEST)) {
        const double largest = fmax(fabs(v[0]), fmax(fabs(v[1]), fabs(v[2])));
        if (!(largest > 0)) {
            unit[0] = unit[1] = unit[2] = 0;
            return;
        }
        const int exponent = ilogb(largest);
        for (int k = 0; k < 3; k++) scaled[k] = ldexp(v[k], -exponent);
    }
    const double inverse =
        1 / sqrt(norma_core_dot(scaled, scaled)); /* as the kernel that makes eight at once */
    for (int k = 0; k < 3; k++) unit[k] = scaled[k] * inverse;
}
