/* normal_cone.c: the most visible normal, the axis of the smallest cone round the face normals
 * (Aubry, Loehner 2008, CNME 24:1641). Its cosine is the distance from the origin to the hull of
 * the normals, and two or three of them hold it. They are found by taking in, again and again, the
 * normal that lies farthest outside: each time the cone of the few grows, so the search ends; ties
 * go to the first. */
#include "core/corner/corner.h"
#include "core/call/call.h"
#include "core/face/face.h"

#if defined(__GNUC__)
#define STANDING_ALONE __attribute__((noinline)) /* called from two loops, and large */
#else
#define STANDING_ALONE
#endif

enum { MOST_HELD = 4 }; /* three, and one more while it is taken in */

typedef struct cone {
    double axis[3], cosine; /* axis: unit */
    size_t held[MOST_HELD]; /* the normals on its rim, by number and as they are */
    double rim[MOST_HELD][3];
    int count;
} cone;

static double lesser_cosine(double a, double b) { return a < b ? a : b; }

/* As norma_core_normalise; 0: no length. */
static int make_unit(const double a[3], double unit[3]) {
    const double square = norma_core_dot(a, a);
    if (square > NORMA_TINIEST && square < NORMA_HUGEST) {
        const double inverse = 1 / sqrt(square);
        for (int k = 0; k < 3; ++k) unit[k] = a[k] * inverse;
        return 1;
    }
    norma_core_normalise(a, unit);
    return norma_core_length(a) > 0;
}

/* At right angles to the plane through three. */
static void across(const double *p, const double *q, const double *r, double a[3]) {
    double u[3], v[3];
    norma_core_subtract(q, p, u);
    norma_core_subtract(r, p, v);
    norma_core_cross(u, v, a);
}

/* The rim through two or three normals: the axis is as near to each. Returns 0 where they have none
 * (opposite, or on one great circle). */
static int axis_of(cone *c) {
    double a[3] = {c->rim[0][0], c->rim[0][1], c->rim[0][2]};
    if (c->count == 2)
        for (int k = 0; k < 3; ++k) a[k] += c->rim[1][k];
    if (c->count == 3) across(c->rim[0], c->rim[1], c->rim[2], a);
    if (!make_unit(a, c->axis)) return 0;
    if (c->count == 3 && norma_core_dot(c->axis, c->rim[0]) < 0)
        for (int k = 0; k < 3; ++k) c->axis[k] = -c->axis[k];
    c->cosine = 1;
    for (int i = 0; i < c->count; ++i)
        c->cosine = lesser_cosine(c->cosine, norma_core_dot(c->axis, c->rim[i]));
    return 1;
}

static const double ROUNDING = 0x1p-48; /* of cosines of unit vectors; those on the rim of a wide
                                           cone differ by more, and are held by name */

static int is_held(const cone *c, size_t member) {
    for (int i = 0; i < c->count; ++i)
        if (c->held[i] == member) return 1;
    return 0;
}

static void hold(cone *c, size_t number, const double normal[3]) {
    c->held[c->count] = number;
    memcpy(c->rim[c->count++], normal, sizeof c->rim[0]);
}

/* ---- which of the few, the held ones and then one more, hold the smallest cone round them all. A
 * set of them is a number, one bit for each; a set of sets as well. Most sets are settled by
 * cosines between the few, beyond what rounding may turn; the others are tried. */

enum { ALL_OF_THREE = 7, ALL_OF_FOUR = 15 };

/* Of cosines of unit vectors too. */
static const double CLEARLY_APART = 1 - 0x1p-40, NOT_WIDE = -0.5;
static const double OUTSIDE = -0x1p-45, FAR_INSIDE = 0x1p-41;

/* Every set of three at most. */
static unsigned all_sets(int count) { return ((1U << (1U << count)) - 2) & ~(1U << ALL_OF_FOUR); }

static int are_apart(double cosine) { return (cosine > NOT_WIDE) & (cosine < CLEARLY_APART); }

/* Of a third normal and the cone of two: with c its cosine, 2c (cos(axis, third) - c), which is
 * (third - one)(other - third). */
static double excess(double pair, double third_one, double third_other) {
    return third_one + third_other - (1 + pair);
}

/* A cone that holds the pair and has a third normal of such an excess on its rim has a cosine that
 * is less by excess^2 / (4 (1 - pair)) at least: more than rounding. */
static int is_far_inside(double pair, double least_excess) {
    return (least_excess > -OUTSIDE) & (least_excess * least_excess > FAR_INSIDE * (1 - pair));
}

/* One set is left where nothing is in doubt. The cone of all but the last is never among them: it
 * does not hold the last. */
static unsigned sets_of_two(const double *a, const double *b) {
    return are_apart(norma_core_dot(a, b)) ? 1U << 3 : all_sets(2);
}

static unsigned sets_of_three(const double *a, const double *b, const double *further) {
    const double ab = norma_core_dot(a, b), af = norma_core_dot(a, further),
                 bf = norma_core_dot(b, further);
    const double with_a = excess(af, ab, bf), with_b = excess(bf, ab, af);
    if (!(are_apart(ab) & are_apart(af) & are_apart(bf))) return all_sets(3);
    if ((with_a < OUTSIDE) & (with_b < OUTSIDE)) return 1U << ALL_OF_THREE;
    if (is_far_inside(af, with_a)) return 1U << 5;
    if (is_far_inside(bf, with_b)) return 1U << 6;
    return all_sets(3);
}

/* Whether the fourth is surely outside the cone round three others, all in the unit of the length
 * of a. */
static int is_surely_outside(
    const double *p, const double *q, const double *r, const double *fourth) {
    double a[3];
    across(p, q, r, a);
    const double margin = 0x1p-44 * (fabs(a[0]) + fabs(a[1]) + fabs(a[2])),
                 first = norma_core_dot(a, p), sign = first < 0 ? -1 : 1;
    const double rim = lesser_cosine(
        sign * first, lesser_cosine(sign * norma_core_dot(a, q), sign * norma_core_dot(a, r)));
    return (sign * first > margin) & (sign * norma_core_dot(a, fourth) < rim - margin);
}

static unsigned sets_of_four(
    const double *a, const double *b, const double *c, const double *further) {
    const double ab = norma_core_dot(a, b), ac = norma_core_dot(a, c), bc = norma_core_dot(b, c);
    const double af = norma_core_dot(a, further), bf = norma_core_dot(b, further),
                 cf = norma_core_dot(c, further);
    const double with_a = lesser_cosine(excess(af, ab, bf), excess(af, ac, cf)),
                 with_b = lesser_cosine(excess(bf, ab, af), excess(bf, bc, cf)),
                 with_c = lesser_cosine(excess(cf, ac, af), excess(cf, bc, bf));
    const double of_ab = lesser_cosine(excess(ab, ac, bc), excess(ab, af, bf)),
                 of_ac = lesser_cosine(excess(ac, ab, bc), excess(ac, af, cf)),
                 of_bc = lesser_cosine(excess(bc, ab, ac), excess(bc, bf, cf));
    if (!(are_apart(ab) & are_apart(ac) & are_apart(bc) & are_apart(af) & are_apart(bf) &
            are_apart(cf)))
        return all_sets(4);
    if (is_far_inside(af, with_a)) return 1U << 9;
    if (is_far_inside(bf, with_b)) return 1U << 10;
    if (is_far_inside(cf, with_c)) return 1U << 12;
    if (!((with_a < OUTSIDE) & (with_b < OUTSIDE) & (with_c < OUTSIDE) & (of_ab < OUTSIDE) &
            (of_ac < OUTSIDE) & (of_bc < OUTSIDE)))
        return all_sets(4);
    unsigned sets = is_surely_outside(a, b, further, c) ? 0 : 1U << 11;
    sets |= is_surely_outside(a, c, further, b) ? 0 : 1U << 13;
    return sets | (is_surely_outside(b, c, further, a) ? 0 : 1U << 14);
}

/* ---- taking one more in */

/* The cone of a set of the few: they stay in order. */
static int choose(const cone *few, unsigned set, cone *c) {
    c->count = 0;
    for (int i = 0; i < few->count; ++i)
        if (set >> i & 1U) hold(c, few->held[i], few->rim[i]);
    return axis_of(c);
}

static int holds(const cone *c, const cone *few) {
    for (int i = 0; i < few->count; ++i)
        if (!is_held(c, few->held[i]) &&
            norma_core_dot(c->axis, few->rim[i]) < c->cosine - ROUNDING)
            return 0;
    return 1;
}

static unsigned sets_of(const cone *few) {
    if (few->count == 2) return sets_of_two(few->rim[0], few->rim[1]);
    if (few->count == 3) return sets_of_three(few->rim[0], few->rim[1], few->rim[2]);
    return sets_of_four(few->rim[0], few->rim[1], few->rim[2], few->rim[3]);
}

/* Of the cones of sets of the few that hold all, the one of greatest cosine. */
STANDING_ALONE
static int narrow(const cone *few, cone *c) {
    unsigned sets = sets_of(few), best = 0, last = 0;
    double cosine = -2;
    if (few->count < 4 && (sets & (sets - 1)) == 0)
        return choose(few, (unsigned)__builtin_ctz(sets), c);
    for (; sets; sets &= sets - 1) {
        last = (unsigned)__builtin_ctz(sets);
        if (!choose(few, last, c) || !(c->cosine > cosine) || !holds(c, few)) continue;
        cosine = c->cosine;
        best = last;
    }
    return best && (best == last || choose(few, best, c));
}

/* ---- the search */

/* The number of the normal with the least dot product, the first of equals (count: there are no
 * normals); *least: that product. */
CORE_INLINE size_t farthest(norma_core_cone_at *at, const void *context, size_t count,
    const double along[3], double *least) {
    size_t found = count;
    *least = 2;
    for (size_t i = 0; i < count; ++i) {
        double n[3];
        if (!at(context, i, n)) continue;
        const double dot = norma_core_dot(along, n);
        found = dot < *least ? i : found;
        *least = dot < *least ? dot : *least;
    }
    return found;
}

/* Takes in one that is outside c; c becomes what few was. 0: no open hemisphere holds them. */
static int take_in(cone **c, cone **few, size_t number, const double normal[3]) {
    cone *held = *c;
    hold(held, number, normal);
    *c = *few;
    *few = held;
    return narrow(held, *c) && (*c)->cosine > 0x1p-30;
}

enum { MOST_STALLS = 32 };

CORE_INLINE int smallest_cone(
    norma_core_cone_at *at, const void *context, size_t count, double axis[3]) {
    cone cones[2], *c = cones, *few = cones + 1;
    double normal[3] = {0, 0, 0};
    size_t first = 0;
    int stalls = 0;
    while (first < count && !at(context, first, normal)) ++first;
    if (first == count) return 0;
    c->count = 0;
    hold(c, first, normal);
    if (!axis_of(c)) return 0;
    for (;;) {
        double least;
        const size_t found = farthest(at, context, count, c->axis, &least);
        const double before = c->cosine;
        if (least >= before - ROUNDING || is_held(c, found)) break;
        at(context, found, normal);
        if (!take_in(&c, &few, found, normal)) return 0;
        if (c->cosine < before) continue;
        /* No wider than before: what is left outside is rounding, or the cone is nearly a
         * hemisphere and grows by less than that. */
        (void)farthest(at, context, count, c->axis, &least);
        const double outside = c->cosine - least;
        if (outside > 0x1p-30 && ++stalls < MOST_STALLS) continue;
        if (outside > 0x1p-20) return 0;
        break;
    }
    memcpy(axis, c->axis, sizeof c->axis);
    return 1;
}

static int listed(const void *context, size_t index, double normal[3]) {
    memcpy(normal, ((const double(*)[3])context)[index], 3 * sizeof *normal);
    return 1;
}

int norma_core_smallest_cone_of(
    norma_core_cone_at *at, const void *context, size_t count, double axis[3]) {
    return smallest_cone(at, context, count, axis);
}

/* Two that are apart hold their cone: what the search would end with, at once. */
static int cone_of_two(const double (*normals)[3], double axis[3]) {
    double a[3];
    for (int k = 0; k < 3; ++k) a[k] = normals[0][k] + normals[1][k];
    return make_unit(a, axis);
}

int norma_core_smallest_cone(const double (*normals)[3], size_t count, double axis[3]) {
    if (count == 2 && are_apart(norma_core_dot(normals[0], normals[1])))
        return cone_of_two(normals, axis);
    return smallest_cone(listed, normals, count, axis);
}
