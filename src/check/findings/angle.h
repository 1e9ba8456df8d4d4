/* angle.h: angles of cosines and sines, by the core's own arc tangent: the C library's differ
 * between systems by a last bit, and findings are the same on all of them. */
#ifndef NORMA_CHECK_ANGLE_H
#define NORMA_CHECK_ANGLE_H
#include <math.h>
#include "core/face/triangle.h"

/* Of a cosine from -1 to 1: 0 to pi. */
static inline double norma_check_arc_cosine(double cosine) {
    return norma_core_angle(sqrt(fmax((1 - cosine) * (1 + cosine), 0)), cosine);
}

/* Of a sine from 0 to 1: 0 to pi/2. */
static inline double norma_check_arc_sine(double sine) {
    return norma_core_angle(sine, sqrt(fmax((1 - sine) * (1 + sine), 0)));
}
#endif
