/* angle.h: the angle of a vector from the x axis, our own, so that its bits are the same on every machine; within 2 ulp of atan2. */
#ifndef NORMA_CORE_ANGLE_H
#define NORMA_CORE_ANGLE_H

#define NORMA_PI 3.141592653589793

/* atan(t) for 0 <= t <= tan(pi/8): t + t z p(z), z = t^2, p the interpolant of degree 10 at the Chebyshev nodes; its error is below 1.1e-17. */
static inline double norma_core_small_atan(double t)
{
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

/* atan2(y, x) for y >= 0: from 0 to pi; 0 where both are 0. */
static inline double norma_core_angle(double y, double x)
{
    const double ax = x < 0 ? -x : x;
    const double small = y < ax ? y : ax, large = y < ax ? ax : y;
    if (!(large > 0)) return 0;
    double t = small / large, angle = 0;
    if (t > 0.41421356237309503) {         /* tan(pi/8): there, atan t = pi/4 + atan((t - 1) / (t + 1)) */
        t = (t - 1) / (t + 1);
        angle = 0.25 * NORMA_PI;
    }
    angle += norma_core_small_atan(t);
    if (y > ax) angle = 0.5 * NORMA_PI - angle;
    return x < 0 ? NORMA_PI - angle : angle;
}
#endif
