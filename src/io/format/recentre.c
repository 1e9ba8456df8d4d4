/* recentre.c: the step that brings the middle of a box to the origin, or nearly: a multiple of a
 * power of two not below the box's size, so that it has few bits. Where the box lies eight times
 * its size away, step and positions are within a factor of two of one another, and their difference
 * is exact (Sterbenz 1974). */
#include "io/format/recentre.h"
#include <math.h>

static const double FAR = 8;

recentre_box norma_recentre_empty(void) {
    return (recentre_box){{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
}

void norma_recentre_add(recentre_box *box, const double position[3]) {
    if (!isfinite(position[0]) || !isfinite(position[1]) || !isfinite(position[2])) return;
    for (int axis = 0; axis < 3; ++axis) {
        box->low[axis] = fmin(box->low[axis], position[axis]);
        box->high[axis] = fmax(box->high[axis], position[axis]);
    }
}

int norma_recentre_step(const recentre_box *box, double step[3]) {
    double size = 0;
    int any = 0, exponent;
    for (int axis = 0; axis < 3; ++axis) size = fmax(size, box->high[axis] - box->low[axis]);
    for (int axis = 0; axis < 3; ++axis) {
        const double middle = box->low[axis] / 2 + box->high[axis] / 2;
        step[axis] = 0;
        if (!(box->low[axis] <= box->high[axis]) || !(fabs(middle) > FAR * size) || !isfinite(size))
            continue;
        frexp(size, &exponent);
        const double unit = ldexp(1, size > 0 ? exponent : 0),
                     rounded = size > 0 ? unit * round(middle / unit) : middle;
        step[axis] = (double)(float)rounded;
        any |= step[axis] != 0;
    }
    return any;
}
