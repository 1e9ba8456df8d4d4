/* reflex.c: the sign of the dot product of two vector areas, the corner's and the polygon's, each
 * the sum of p x q over its edges from p to q. The polygon's is summed exactly, and multiplied with
 * the corner's a double at a time. */
#include "core/face/reflex.h"
#include "core/face/exact_sum.h"
#include <math.h>
#include <string.h>

static void add_cross(exact_sum area[3], const double p[3], const double q[3]) {
    for (int k = 0; k < 3; k++) {
        const int x = (k + 1) % 3, y = (k + 2) % 3;
        norma_exact_add(&area[k], (const double[]){p[x], q[y]}, 2, 0);
        norma_exact_add(&area[k], (const double[]){p[y], q[x]}, 2, 1);
    }
}

static void add_polygon(exact_sum area[3], exact_point *point, const void *context, size_t count) {
    double first[3], p[3], q[3];
    point(context, 0, first);
    memcpy(q, first, sizeof q);
    for (size_t i = 1; i < count; i++) {
        memcpy(p, q, sizeof p);
        point(context, i, q);
        add_cross(area, p, q);
    }
    add_cross(area, q, first);
}

/* The sum's leading 53 bits as a product of two doubles, since one may not reach; at the very end
 * of the range a part of them. 0: nothing is left. */
static int leading_part(const exact_sum *sum, double part[2]) {
    const scaled_number number = norma_exact_round(sum);
    const int exponent = number.exponent < 2046 ? number.exponent : 2046;
    const int scale = exponent < -1000 ? -1074 : exponent > 1000 ? 1023 : 0;
    part[0] = ldexp(number.mantissa, exponent - scale);
    part[1] = ldexp(1, scale);
    return part[0] < 0 || part[0] > 0;
}

int norma_core_turns_back(exact_point *point, const void *context, size_t count,
    const double here[3], const double next[3], const double previous[3]) {
    const double *const corner[4] = {previous, here, next, previous};
    exact_sum area[3], turn;
    double part[2];
    for (int k = 0; k < 3; k++) norma_exact_clear(&area[k]);
    norma_exact_clear(&turn);
    add_polygon(area, point, context, count);
    for (int k = 0; k < 3; k++)
        while (leading_part(&area[k], part)) {
            const int x = (k + 1) % 3, y = (k + 2) % 3;
            for (int i = 0; i < 3; i++) {
                const double *p = corner[i], *q = corner[i + 1];
                norma_exact_add(&turn, (const double[]){part[0], part[1], p[x], q[y]}, 4, 0);
                norma_exact_add(&turn, (const double[]){part[0], part[1], p[y], q[x]}, 4, 1);
            }
            norma_exact_add(&area[k], part, 2, 1);
        }
    return norma_exact_round(&turn).mantissa < 0;
}
