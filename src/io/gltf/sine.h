/* sine.h: sines of our own, for results with the same bits everywhere: the C library's differ
 * between systems. */
#ifndef NORMA_IO_GLTF_SINE_H
#define NORMA_IO_GLTF_SINE_H
#include "core/face/triangle.h"
#include <math.h>

/* sin(x) from 0 to pi/2 by its series, within an ulp or two. */
static inline double norma_gltf_sine(double x) {
    const int steep = x > NORMA_PI / 4;
    const double y = steep ? NORMA_PI / 2 - x : x, z = y * y;
    double sum = 1;
    for (int n = steep ? 16 : 17; n > 1; n -= 2) sum = 1 - sum * z / (n * (n - 1));
    return steep ? sum : y * sum;
}

/* The cosine and the sine of any finite angle; the larger it is, the fewer of its digits count. */
static inline void norma_gltf_turn(double angle, double *cosine, double *sine) {
    const double size = fabs(angle), quarters = floor(size / (NORMA_PI / 2)),
                 rest = fmin(fmax(size - quarters * (NORMA_PI / 2), 0), NORMA_PI / 2);
    const double near = norma_gltf_sine(rest), far = norma_gltf_sine(NORMA_PI / 2 - rest);
    const int quarter = (int)(quarters - 4 * floor(quarters / 4)), odd = quarter & 1;
    *cosine = (quarter == 1 || quarter == 2 ? -1 : 1) * (odd ? near : far);
    *sine = (quarter >= 2 ? -1 : 1) * (odd ? far : near) * (angle < 0 ? -1 : 1);
}
#endif
