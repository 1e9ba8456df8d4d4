/* triangle.h: what is computed of a triangle, in double precision and without branches, so that a
 * loop over lanes of triangles becomes vector instructions on every machine, with the same bits as
 * one triangle alone. */
#ifndef NORMA_CORE_TRIANGLE_H
#define NORMA_CORE_TRIANGLE_H
#include "core/call/call.h"
#include "core/call/weight.h"
#include <math.h>
#include <norma/norma.h>

#define NORMA_PI 3.141592653589793

/* atan(t) for |t| <= tan(pi/8): t + t z p(z), z = t^2, p the interpolant of degree 10 at the
 * Chebyshev nodes; its error is below 1.1e-17. */
static inline double norma_core_small_atan(double t) {
    const double z = t * t;
    double p = -0x1.3a31b1c0fd3b7p-6;
    p = p * z + 0x1.4162c02b1dda3p-5;
    p = p * z - 0x1.a0999c632b6edp-5;
    p = p * z + 0x1.dfe6497e96323p-5;
    p = p * z - 0x1.10fa77b1a6d57p-4;
    p = p * z + 0x1.3b1263064f6b9p-4;
    p = p * z - 0x1.745d0b28a7e37p-4;
    p = p * z + 0x1.c71c71853d7fap-4;
    p = p * z - 0x1.2492492436201p-3;
    p = p * z + 0x1.999999999934cp-3;
    p = p * z - 0x1.5555555555555p-2;
    return t + t * (z * p);
}

/* atan2(y, x) for y >= 0: from 0 to pi; 0 where both are 0. Our own, so that its bits are the same
 * on every machine; within 2 ulp. Above tan(pi/8), atan(s / l) = pi/4 + atan((s - l) / (s + l)). */
static inline double norma_core_angle(double y, double x) {
    const double ax = x < 0 ? -x : x;
    const double small = y < ax ? y : ax, large = y < ax ? ax : y;
    const int steep = small > 0.41421356237309503 * large;
    const double above = steep ? small - large : small, below = steep ? small + large : large;
    double angle = (steep ? 0.25 * NORMA_PI : 0) + norma_core_small_atan(above / below);
    angle = y > ax ? 0.5 * NORMA_PI - angle : angle;
    angle = x < 0 ? NORMA_PI - angle : angle;
    return large > 0 ? angle : 0;
}

/* atan(t) for |t| <= tan(pi/8), for weights: the minimax polynomial of degree 6, within 3e-12 of
 * its value. What a weight errs by, the direction of a sum feels by that times sum of weights /
 * |sum|, at most. */
#define CORE_WEIGHT_ATAN_FIRST -0x1.4b3891ff382b2p-5
#define CORE_WEIGHT_ATAN_OTHERS(TERM)                                                              \
    TERM(0x1.24434e877a5ddp-4)                                                                     \
    TERM(-0x1.71d3c10805470p-4)                                                                    \
    TERM(0x1.c6f68737bd590p-4)                                                                     \
    TERM(-0x1.2491c08b2dc95p-3)                                                                    \
    TERM(0x1.99999825954bep-3)                                                                     \
    TERM(-0x1.5555555502188p-2)

static inline double norma_core_weight_atan(double t) {
    const double z = t * t;
    double p = CORE_WEIGHT_ATAN_FIRST;
#define CORE_ADD_TERM(factor) p = p * z + factor;
    CORE_WEIGHT_ATAN_OTHERS(CORE_ADD_TERM)
#undef CORE_ADD_TERM
    return t + t * (z * p);
}

/* atan2(y, x) for y >= 0 and x >= 0 (or below by a rounding) is turn + atan(above / below). */
typedef struct core_slope {
    double above, below, turn;
} core_slope;

static inline core_slope norma_core_slope(double y, double x) {
    const double small = y < x ? y : x, large = y < x ? x : y;
    const int steep = small > 0.41421356237309503 * large, falls = y > x;
    const double flat_above = falls ? -x : y, flat_turn = falls ? 0.5 * NORMA_PI : 0;
    return (core_slope){steep ? y - x : flat_above, steep ? small + large : large,
        steep ? 0.25 * NORMA_PI : flat_turn};
}

static inline double norma_core_slope_angle(core_slope s, double quotient) {
    return s.turn + norma_core_weight_atan(quotient);
}

/* A corner's angle as a weight: atan2(cross, dot), for cross >= 0. */
static inline double norma_core_weight_angle(double cross, double dot) {
    const core_slope s = norma_core_slope(cross, dot < 0 ? -dot : dot);
    const double angle = norma_core_slope_angle(s, s.above / s.below);
    return s.below > 0 ? (dot < 0 ? NORMA_PI - angle : angle) : 0;
}

/* Whether doubles are enough, from the square of the cross product of two edges and their dot
 * product, whose squares are |u|^2 |v|^2 together (Lagrange): each component errs by at most some 6
 * * 2^-53 |u| |v|, below 2^-30 of a length of 2^-20 |u| |v|. Not for NaN, infinity or no area. */
static inline int norma_core_triangle_is_sure(double square, double dot) {
    return (square >= 0x1p-40 * (square + dot * dot)) & (square > NORMA_TINIEST) &
           (square < NORMA_HUGEST);
}

/* The unit normal of the triangle with edges u and v from its first corner, and the length of their
 * cross product, twice its area. Returns whether doubles are enough. */
static inline int norma_core_triangle(
    const double u[3], const double v[3], double normal[3], double *twice_area) {
    double cross[3];
    norma_core_cross(u, v, cross);
    const double square = norma_core_dot(cross, cross), length = sqrt(square), inverse = 1 / length;
    for (int k = 0; k < 3; k++) normal[k] = cross[k] * inverse;
    *twice_area = length;
    return norma_core_triangle_is_sure(square, norma_core_dot(u, v));
}

/* norma_core_weight_of, from the dot product of the edges instead of the angle; interior angles are
 * above pi where reflex. */
static inline double norma_core_weigh(norma_weight weight, double aa, double bb, double ab,
    double cross, double twice_area, int reflex) {
    const double angle =
        core_weighed(weight) == CORE_BY_ANGLE ? norma_core_weight_angle(cross, ab) : 0;
    return norma_core_weight_of(
        weight, aa, bb, reflex ? 2 * NORMA_PI - angle : angle, cross, twice_area);
}
#endif
