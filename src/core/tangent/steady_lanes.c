/* steady_lanes.c: steady_faces.c's measure and part_of, many triangles at a time, compiled for each
 * instruction set of the machine's family and chosen at run time. */
#include "core/tangent/steady_lanes.h"
#include "core/face/triangle.h"
#include "core/tangent/steady.h"

CORE_INLINE void at(steady_lane const *of, int lane, double out[3]) {
    for (int k = 0; k < 3; k++) out[k] = of[k][lane];
}
CORE_INLINE int is_held(double square) {
    return (square > NORMA_TINIEST) & (square < NORMA_HUGEST);
}

/* along: unit. */
CORE_INLINE void measure(const steady_batch *restrict b, steady_lane along[3],
    double *restrict twice_area, steady_addends *restrict out) {
    for (int l = 0; l < STEADY_LANES; l++) {
        double here[3], p[3], q[3], cross[3], v[3];
        at(b->position[0], l, here);
        at(b->position[1], l, p);
        at(b->position[2], l, q);
        norma_core_subtract(p, here, p);
        norma_core_subtract(q, here, q);
        norma_core_cross(p, q, cross);
        const double s0 = b->texcoord[1][0][l] - b->texcoord[0][0][l],
                     s1 = b->texcoord[1][1][l] - b->texcoord[0][1][l],
                     t0 = b->texcoord[2][0][l] - b->texcoord[0][0][l],
                     t1 = b->texcoord[2][1][l] - b->texcoord[0][1][l], area = s0 * t1 - s1 * t0,
                     magnitude = fabs(s0 * t1) + fabs(s1 * t0),
                     square = norma_core_dot(cross, cross);
        for (int k = 0; k < 3; k++) {
            const double sum = t1 * p[k] - s1 * q[k];
            v[k] = area < 0 ? -sum : sum;
        }
        const double along_square = norma_core_dot(v, v), inverse = 1 / sqrt(along_square);
        for (int k = 0; k < 3; k++) along[k][l] = v[k] * inverse;
        twice_area[l] = sqrt(square);
        const double sign = area < 0 ? -1 : 1;
        out->sign[l] = fabs(area) > STEADY_ROUNDING * magnitude ? sign : 0;
        out->is_sure[l] = is_held(square) & is_held(along_square) ? 1 : 0;
    }
}

typedef struct corner_lanes {
    steady_lane aa, bb, ab, cross; /* of the edges: squares, dot product, length of the other */
    steady_lane is_there;          /* 0: what is perpendicular to the normal is rounding */
} corner_lanes;

/* Sums: not weighed yet. */
CORE_INLINE void turn_corner(const steady_batch *restrict b, steady_lane along[3], int corner,
    corner_lanes *restrict c, steady_addends *restrict out) {
    for (int l = 0; l < STEADY_LANES; l++) {
        double n[3], v[3], here[3], next[3], previous[3], cross[3];
        at(b->normal[corner], l, n);
        for (int k = 0; k < 3; k++) v[k] = along[k][l];
        const double square = norma_core_dot(n, n), inverse = 1 / sqrt(square);
        for (int k = 0; k < 3; k++) n[k] = n[k] * inverse;
        const double by = norma_core_dot(v, n);
        for (int k = 0; k < 3; k++) v[k] = v[k] - by * n[k];
        const double length = sqrt(norma_core_dot(v, v)), scale = 1 / length;
        for (int k = 0; k < 3; k++) out->sum[corner][k][l] = v[k] * scale;
        c->is_there[l] = length > STEADY_NOTHING_LEFT ? 1 : 0;

        at(b->position[corner], l, here);
        at(b->position[(corner + 1) % 3], l, next);
        at(b->position[(corner + 2) % 3], l, previous);
        norma_core_subtract(next, here, next);
        norma_core_subtract(previous, here, previous);
        norma_core_cross(next, previous, cross);
        const double cross_square = norma_core_dot(cross, cross);
        c->aa[l] = norma_core_dot(next, next);
        c->bb[l] = norma_core_dot(previous, previous);
        c->ab[l] = norma_core_dot(next, previous);
        c->cross[l] = sqrt(cross_square);
        out->is_sure[l] = is_held(square) & is_held(cross_square) ? out->is_sure[l] : 0;
    }
}

/* One loop without a question inside for the weight that nearly all meshes have. */
CORE_INLINE void weigh(const corner_lanes *restrict c, const double *restrict twice_area,
    norma_weight weight, double *restrict out) {
    if (weight == NORMA_WEIGHT_ANGLE)
        for (int l = 0; l < STEADY_LANES; l++)
            out[l] = norma_core_weight_angle(c->cross[l], c->ab[l]);
    else
        for (int l = 0; l < STEADY_LANES; l++)
            out[l] = norma_core_weigh(
                weight, c->aa[l], c->bb[l], c->ab[l], c->cross[l], twice_area[l], 0);
}

CORE_INLINE void add_up(
    const steady_batch *restrict b, norma_weight weight, steady_addends *restrict out) {
    steady_lane along[3], twice_area;
    measure(b, along, twice_area, out);
    for (int corner = 0; corner < 3; corner++) {
        corner_lanes c;
        steady_lane weights;
        turn_corner(b, along, corner, &c, out);
        weigh(&c, twice_area, weight, weights);
        for (int l = 0; l < STEADY_LANES; l++) {
            for (int k = 0; k < 3; k++)
                out->sum[corner][k][l] =
                    c.is_there[l] > 0 ? out->sum[corner][k][l] * weights[l] : 0;
            out->weight[corner][l] = c.is_there[l] > 0 ? weights[l] : 0;
        }
    }
}

static void add_up_portable(
    const steady_batch *restrict b, norma_weight weight, steady_addends *restrict out) {
    add_up(b, weight, out);
}
#if defined(CORE_HAS_X86)
CORE_FOR_AVX2 static void add_up_avx2(
    const steady_batch *restrict b, norma_weight weight, steady_addends *restrict out) {
    add_up(b, weight, out);
}
#endif
#if defined(CORE_HAS_AVX512)
CORE_FOR_AVX512 static void add_up_avx512(
    const steady_batch *restrict b, norma_weight weight, steady_addends *restrict out) {
    add_up(b, weight, out);
}
#endif

steady_kernel *norma_core_steady_kernel(norma_isa isa) {
    static steady_kernel *const kernels[] = CORE_KERNELS(add_up);
    return kernels[norma_core_level(isa)];
}
