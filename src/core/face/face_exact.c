/* face_exact.c: areas and turns where doubles do not decide: in 128 bits where they fit (nearly
 * always), else in sums without rounding (exact_sum.c). */
#include "core/face/face.h"
#include <limits.h>
#include <math.h>
#include <string.h>
#include <stdint.h>

/* ---- every finite double is an integer times a power of two, so all points of a face are integers
 * in the unit of the least bit among them, and sums of products of their differences are integers
 * too. */

__extension__ typedef __int128 wide;
__extension__ typedef unsigned __int128 unsigned_wide;

/* The least and the highest bit that any coordinate uses, as powers of two; 0 where all coordinates
 * are zero. */
static int bit_range(
    exact_point *point, const void *context, size_t count, int *least, int *highest) {
    int any = 0;
    for (size_t i = 0; i < count; ++i) {
        double p[3];
        point(context, i, p);
        for (int k = 0; k < 3; ++k) {
            if (p[k] == 0) continue;
            int exponent;
            uint64_t mantissa = (uint64_t)ldexp(fabs(frexp(p[k], &exponent)), 53);
            const int top = exponent - 1;
            int bottom = exponent - 53;
            while (!(mantissa & 1)) {
                mantissa >>= 1;
                ++bottom;
            }
            if (!any || bottom < *least) *least = bottom;
            if (!any || top > *highest) *highest = top;
            any = 1;
        }
    }
    return any;
}

static void integer_point(
    exact_point *point, const void *context, size_t index, int unit, int64_t out[3]) {
    double p[3];
    point(context, index, p);
    for (int k = 0; k < 3; ++k) out[k] = (int64_t)ldexp(p[k], -unit);
}

static double wide_to_double(wide value) {
    const unsigned_wide magnitude = value < 0 ? -(unsigned_wide)value : (unsigned_wide)value;
    const double high = (double)(uint64_t)(magnitude >> 64), low = (double)(uint64_t)magnitude;
    const double result = high * 0x1p64 + low;
    return value < 0 ? -result : result;
}

static void wide_area(
    exact_point *point, const void *context, size_t count, int unit, double area[3]) {
    int64_t origin[3], p[3], u[3], v[3] = {0, 0, 0};
    wide sum[3] = {0, 0, 0};
    integer_point(point, context, 0, unit, origin);
    for (size_t i = 1; i < count; ++i) {
        integer_point(point, context, i, unit, p);
        for (int k = 0; k < 3; ++k) {
            u[k] = v[k];
            v[k] = p[k] - origin[k];
        }
        sum[0] += (wide)u[1] * v[2] - (wide)u[2] * v[1];
        sum[1] += (wide)u[2] * v[0] - (wide)u[0] * v[2];
        sum[2] += (wide)u[0] * v[1] - (wide)u[1] * v[0];
    }
    for (int k = 0; k < 3; ++k) area[k] = wide_to_double(sum[k]);
}

/* ---- and where they do not fit, each product of coordinates is one of doubles, whose sum is
 * exact. */

static void add_cross(exact_sum area[3], const double p[3], const double q[3]) {
    for (int k = 0; k < 3; ++k) {
        const int x = (k + 1) % 3, y = (k + 2) % 3;
        norma_exact_add(&area[k], (const double[]){p[x], q[y]}, 2, 0);
        norma_exact_add(&area[k], (const double[]){p[y], q[x]}, 2, 1);
    }
}

void norma_core_sum_polygon(
    exact_point *point, const void *context, size_t count, exact_area *area) {
    double first[3], p[3], q[3];
    for (int k = 0; k < 3; ++k) norma_exact_clear(&area->sum[k]);
    area->known = 1;
    point(context, 0, first);
    memcpy(q, first, sizeof q);
    for (size_t i = 1; i < count; ++i) {
        memcpy(p, q, sizeof p);
        point(context, i, q);
        add_cross(area->sum, p, q);
    }
    add_cross(area->sum, q, first);
}

/* A component that the largest leaves no bit of becomes zero. */
static void summed_area(
    exact_point *point, const void *context, size_t count, double area[3], int *exponent) {
    exact_area exact;
    scaled_number twice[3];
    *exponent = INT_MIN;
    norma_core_sum_polygon(point, context, count, &exact);
    for (int k = 0; k < 3; ++k) {
        twice[k] = norma_exact_round(&exact.sum[k]);
        if (twice[k].mantissa != 0 && twice[k].exponent > *exponent) *exponent = twice[k].exponent;
    }
    for (int k = 0; k < 3; ++k)
        if (twice[k].mantissa != 0)
            area[k] = ldexp(twice[k].mantissa, twice[k].exponent - *exponent);
}

static int bits_of(size_t count) {
    int bits = 0;
    for (; count; count >>= 1) ++bits;
    return bits;
}

int norma_core_exact_area(
    exact_point *point, const void *context, size_t count, double area[3], int *exponent) {
    int least = 0, highest = 0;
    area[0] = area[1] = area[2] = 0;
    *exponent = 0;
    if (!bit_range(point, context, count, &least, &highest)) return 0;
    const int coordinate_bits = highest - least + 1;
    const int sum_bits = 2 * (coordinate_bits + 1) + 1 + bits_of(count) + 1;
    if (coordinate_bits <= 61 && sum_bits <= 126) {
        wide_area(point, context, count, least, area);
        *exponent = 2 * least;
    } else {
        summed_area(point, context, count, area, exponent);
    }
    return area[0] != 0 || area[1] != 0 || area[2] != 0;
}

/* ---- the sign of the dot product of two vector areas, the corner's and the polygon's, each the
 * sum of p x q over its edges from p to q. The polygon's is summed exactly, once for all corners,
 * and multiplied with the corner's a double at a time. */

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

int norma_core_turns_back(
    const exact_area *area, const double here[3], const double next[3], const double previous[3]) {
    const double *const corner[4] = {previous, here, next, previous};
    exact_sum turn;
    double part[2];
    norma_exact_clear(&turn);
    for (int k = 0; k < 3; ++k) {
        exact_sum rest = area->sum[k];
        while (leading_part(&rest, part)) {
            const int x = (k + 1) % 3, y = (k + 2) % 3;
            for (int i = 0; i < 3; ++i) {
                const double *p = corner[i], *q = corner[i + 1];
                norma_exact_add(&turn, (const double[]){part[0], part[1], p[x], q[y]}, 4, 0);
                norma_exact_add(&turn, (const double[]){part[0], part[1], p[y], q[x]}, 4, 1);
            }
            norma_exact_add(&rest, part, 2, 1);
        }
    }
    return norma_exact_round(&turn).mantissa < 0;
}
