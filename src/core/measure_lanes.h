/* measure_lanes.h: a batch of triangles measured, lane by lane, to be compiled into the kernels of each instruction set. */
#ifndef NORMA_CORE_MEASURE_LANES_H
#define NORMA_CORE_MEASURE_LANES_H
#include "isa.h"
#include "measure.h"
#include "triangle.h"

CORE_INLINE void core_lanes_normals(core_batch *t)
{
    for (int i = 0; i < CORE_LANES; i++) {
        const int sure = norma_core_triangle(t->u[0][i], t->u[1][i], t->u[2][i], t->v[0][i], t->v[1][i], t->v[2][i], &t->normal[0][i], &t->normal[1][i],
                                             &t->normal[2][i], &t->twice_area[i]);
        t->sure[i] = sure ? 1 : 0;
    }
}

CORE_INLINE double core_lanes_dot(core_lane *a, core_lane *b, int i) { return a[0][i] * b[0][i] + a[1][i] * b[1][i] + a[2][i] * b[2][i]; }

/* Normals and all angles. The two smaller angles by arc tangents, the largest as what they leave of pi, which loses nothing since it is at least pi/3; its corner is that of the
 * least dot product. One division serves the two quotients: dividing is the slowest of all that is done here. */
CORE_INLINE void core_lanes_angles(core_batch *t)
{
    for (int i = 0; i < CORE_LANES; i++) {
        const double ux = t->u[0][i], uy = t->u[1][i], uz = t->u[2][i], vx = t->v[0][i], vy = t->v[1][i], vz = t->v[2][i];
        const double x = uy * vz - uz * vy, y = uz * vx - ux * vz, z = ux * vy - uy * vx;
        const double square = x * x + y * y + z * z, length = sqrt(square);
        const double d0 = core_lanes_dot(t->u, t->v, i), d1 = -core_lanes_dot(t->u, t->a, i), d2 = core_lanes_dot(t->v, t->a, i);
        const double first = d0 < d1 ? d0 : d1, second = d0 < d1 ? d1 : d0, third = d2 < first ? first : d2;   /* the least is left out: first or d2 */
        const core_slope a = norma_core_slope(length, second), b = norma_core_slope(length, third);
        const double inverse = 1 / length, belows = 1 / (a.below * b.below);
        const double angle_a = norma_core_slope_angle(a, a.above * (belows * b.below)), angle_b = norma_core_slope_angle(b, b.above * (belows * a.below));
        const double least = d2 < first ? d2 : first, left = NORMA_PI - (angle_a + angle_b);
        const double rest = least == third ? angle_b : least == second ? angle_a : left;      /* of equal corners none is another's rest: reversed faces weigh the same */
        const double of_first = d2 < first ? angle_b : rest;
        t->normal[0][i] = x * inverse;
        t->normal[1][i] = y * inverse;
        t->normal[2][i] = z * inverse;
        t->twice_area[i] = length;
        t->sure[i] = norma_core_triangle_is_sure(square, d0) ? 1 : 0;
        t->weight[0][i] = d0 < d1 ? of_first : angle_a;
        t->weight[1][i] = d0 < d1 ? angle_a : of_first;
        t->weight[2][i] = d2 < first ? rest : angle_b;
    }
}

/* The edges of the three corners are u, v and the third, w = v - u taken from the points; turning one round only changes the sign of a dot product. */
CORE_INLINE void core_lanes_weigh_all(core_batch *t, norma_weight weight)
{
    for (int i = 0; i < CORE_LANES; i++) {
        const double uu = core_lanes_dot(t->u, t->u, i), vv = core_lanes_dot(t->v, t->v, i), ww = core_lanes_dot(t->a, t->a, i), area = t->twice_area[i];
        const double angles[3] = {t->weight[0][i], t->weight[1][i], t->weight[2][i]};
        t->weight[0][i] = norma_core_weight_of(weight, uu, vv, angles[0], area, area);
        t->weight[1][i] = norma_core_weight_of(weight, ww, uu, angles[1], area, area);
        t->weight[2][i] = norma_core_weight_of(weight, vv, ww, angles[2], area, area);
    }
}

CORE_INLINE void core_lanes_measure(core_batch *t, norma_weight weight, core_corners wanted)
{
    const int by_angle = weight == NORMA_WEIGHT_ANGLE || weight == NORMA_WEIGHT_ANGLE_AREA || weight == NORMA_WEIGHT_ANGLE_LENGTHS;
    if (wanted == CORE_ALL_CORNERS && by_angle) core_lanes_angles(t);
    else core_lanes_normals(t);
    if (wanted == CORE_ALL_CORNERS && weight != NORMA_WEIGHT_ANGLE) core_lanes_weigh_all(t, weight);
}
#endif
