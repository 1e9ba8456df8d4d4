/* measure_simd.h: a batch of triangles measured, lane by lane, to be compiled into the kernels of
 * each instruction set. */
#ifndef NORMA_CORE_MEASURE_LANES_H
#define NORMA_CORE_MEASURE_LANES_H
#include "core/call/call.h"
#include "core/face/face.h"

CORE_INLINE void core_lanes_normals(core_batch *t) {
    for (int i = 0; i < CORE_LANES; i++) {
        const double u[3] = {t->u[0][i], t->u[1][i], t->u[2][i]},
                     v[3] = {t->v[0][i], t->v[1][i], t->v[2][i]};
        double normal[3];
        t->sure[i] = norma_core_triangle(u, v, normal, &t->twice_area[i]) ? 1 : 0;
        for (int k = 0; k < 3; k++) t->normal[k][i] = normal[k];
    }
}

CORE_INLINE double core_lanes_dot(core_lane *a, core_lane *b, int i) {
    return a[0][i] * b[0][i] + a[1][i] * b[1][i] + a[2][i] * b[2][i];
}

/* Normals and all angles. The two smaller angles by arc tangents, the largest as what they leave of
 * pi, which loses nothing since it is at least pi/3; its corner is that of the least dot product.
 * One division serves the two quotients: dividing is the slowest of all that is done here.
 *
 * In four steps, each a chain short enough a processor overlaps it with the next batch's where the
 * step is taken for some batches in a row; from end to end it could not. */
typedef struct core_arcs {
    core_lane tangent[2], turn[2];
} core_arcs;

/* Normals: cross products; twice_area: their lengths; weights: dot products. */
CORE_INLINE void core_lanes_products(core_batch *t) {
    for (int i = 0; i < CORE_LANES; i++) {
        const double ux = t->u[0][i], uy = t->u[1][i], uz = t->u[2][i], vx = t->v[0][i],
                     vy = t->v[1][i], vz = t->v[2][i];
        const double x = uy * vz - uz * vy, y = uz * vx - ux * vz, z = ux * vy - uy * vx,
                     square = x * x + y * y + z * z, d0 = core_lanes_dot(t->u, t->v, i);
        t->normal[0][i] = x;
        t->normal[1][i] = y;
        t->normal[2][i] = z;
        t->twice_area[i] = sqrt(square);
        t->weight[0][i] = d0;
        t->weight[1][i] = -core_lanes_dot(t->u, t->a, i);
        t->weight[2][i] = core_lanes_dot(t->v, t->a, i);
        t->sure[i] = norma_core_triangle_is_sure(square, d0) ? 1 : 0;
    }
}

/* Of three, the middle one and the greatest; the least of the first two is first. */
CORE_INLINE void core_lanes_slopes(core_batch *t, core_arcs *arcs) {
    for (int i = 0; i < CORE_LANES; i++) {
        const double d0 = t->weight[0][i], d1 = t->weight[1][i], d2 = t->weight[2][i],
                     length = t->twice_area[i];
        const double first = d0 < d1 ? d0 : d1, second = d0 < d1 ? d1 : d0,
                     third = d2 < first ? first : d2; /* the least is left out: first or d2 */
        const core_slope a = norma_core_slope(length, second), b = norma_core_slope(length, third);
        const double inverse = 1 / length, belows = 1 / (a.below * b.below);
        t->normal[0][i] *= inverse;
        t->normal[1][i] *= inverse;
        t->normal[2][i] *= inverse;
        arcs->tangent[0][i] = a.above * (belows * b.below);
        arcs->tangent[1][i] = b.above * (belows * a.below);
        arcs->turn[0][i] = a.turn;
        arcs->turn[1][i] = b.turn;
    }
}

/* Turns: the two angles. */
CORE_INLINE void core_lanes_arcs(core_arcs *arcs) {
    for (int a = 0; a < 2; a++)
        for (int i = 0; i < CORE_LANES; i++)
            arcs->turn[a][i] += norma_core_weight_atan(arcs->tangent[a][i]);
}

/* Which corner has which. */
CORE_INLINE void core_lanes_corner_angles(core_batch *t, const core_arcs *arcs) {
    for (int i = 0; i < CORE_LANES; i++) {
        const double d0 = t->weight[0][i], d1 = t->weight[1][i], d2 = t->weight[2][i],
                     angle_a = arcs->turn[0][i], angle_b = arcs->turn[1][i];
        const double first = d0 < d1 ? d0 : d1, second = d0 < d1 ? d1 : d0,
                     third = d2 < first ? first : d2, least = d2 < first ? d2 : first;
        const double left = NORMA_PI - (angle_a + angle_b),
                     second_or_left = least == second ? angle_a : left;
        const double rest =
            least == third ? angle_b : second_or_left; /* of equal corners none is another's rest:
                                                          reversed faces weigh the same */
        const double of_first = d2 < first ? angle_b : rest;
        t->weight[0][i] = d0 < d1 ? of_first : angle_a;
        t->weight[1][i] = d0 < d1 ? angle_a : of_first;
        t->weight[2][i] = d2 < first ? rest : angle_b;
    }
}

CORE_INLINE void core_lanes_angles(core_batch *t) {
    core_arcs arcs;
    core_lanes_products(t);
    core_lanes_slopes(t, &arcs);
    core_lanes_arcs(&arcs);
    core_lanes_corner_angles(t, &arcs);
}

/* The edges of the three corners are u, v and the third, w = v - u taken from the points; turning
 * one round only changes the sign of a dot product. */
CORE_INLINE void core_lanes_weigh_all(core_batch *t, norma_weight weight) {
    for (int i = 0; i < CORE_LANES; i++) {
        const double uu = core_lanes_dot(t->u, t->u, i), vv = core_lanes_dot(t->v, t->v, i),
                     ww = core_lanes_dot(t->a, t->a, i), area = t->twice_area[i];
        const double angles[3] = {t->weight[0][i], t->weight[1][i], t->weight[2][i]};
        t->weight[0][i] = norma_core_weight_of(weight, uu, vv, angles[0], area, area);
        t->weight[1][i] = norma_core_weight_of(weight, ww, uu, angles[1], area, area);
        t->weight[2][i] = norma_core_weight_of(weight, vv, ww, angles[2], area, area);
    }
}

CORE_INLINE void core_lanes_measure(core_batch *t, core_corners wanted, norma_weight weight) {
    if (wanted == CORE_ALL_CORNERS && core_weighed(weight) == CORE_BY_ANGLE)
        core_lanes_angles(t);
    else
        core_lanes_normals(t);
    if (wanted == CORE_ALL_CORNERS && weight != NORMA_WEIGHT_ANGLE) core_lanes_weigh_all(t, weight);
}
#endif
