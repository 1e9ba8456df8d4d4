/* cone.c: the most visible normal, the axis of the smallest cone round the face normals (Aubry, Loehner 2008, CNME 24:1641). Its cosine is the distance from
 * the origin to the hull of the normals, and two or three of them hold it. They are found by taking in, again and again, the normal that lies farthest outside:
 * each time the cone of the few grows, so the search ends; ties go to the first. */
#include "cone.h"
#include "ring.h"

enum { MOST_HELD = 3 };

typedef struct cone {
    double axis[3], cosine;          /* axis: unit */
    size_t held[MOST_HELD];          /* the normals on its rim, by number and as they are */
    double rim[MOST_HELD][3];
    int    count;
} cone;

static double least(double a, double b) { return a < b ? a : b; }

/* The rim through two or three normals: the axis is as near to each. Returns 0 where they have none (opposite, or on one great circle). */
static int axis_of(cone *c)
{
    double a[3];
    if (c->count == 1) {
        memcpy(a, c->rim[0], sizeof a);
    } else if (c->count == 2) {
        for (int k = 0; k < 3; k++) a[k] = c->rim[0][k] + c->rim[1][k];
    } else {
        double u[3], v[3];
        norma_core_subtract(c->rim[1], c->rim[0], u);
        norma_core_subtract(c->rim[2], c->rim[0], v);
        norma_core_cross(u, v, a);
    }
    if (!(norma_core_length(a) > 0)) return 0;
    norma_core_normalise(a, c->axis);
    if (c->count == 3 && norma_core_dot(c->axis, c->rim[0]) < 0)
        for (int k = 0; k < 3; k++) c->axis[k] = -c->axis[k];
    c->cosine = 1;
    for (int i = 0; i < c->count; i++) c->cosine = least(c->cosine, norma_core_dot(c->axis, c->rim[i]));
    return 1;
}

static const double ROUNDING = 0x1p-48; /* of cosines of unit vectors; those on the rim of a wide cone differ by more, and are held by name */

static int is_held(const cone *c, size_t member)
{
    for (int i = 0; i < c->count; i++)
        if (c->held[i] == member) return 1;
    return 0;
}

static void hold(cone *c, size_t number, const double normal[3])
{
    c->held[c->count] = number;
    memcpy(c->rim[c->count++], normal, sizeof c->rim[0]);
}

/* all: the few normals of which c is to hold every one. */
static int holds(const cone *c, const cone *all, const double further[3], size_t number)
{
    for (int i = 0; i < all->count; i++)
        if (!is_held(c, all->held[i]) && norma_core_dot(c->axis, all->rim[i]) < c->cosine - ROUNDING) return 0;
    return is_held(c, number) || norma_core_dot(c->axis, further) >= c->cosine - ROUNDING;
}

/* The smallest cone round the held ones and one more: the widest is not asked for, since among the cones that hold all of them the one of greatest cosine is it. */
static int take_in(cone *c, size_t number, const double further[3])
{
    const int count = c->count + 1;
    cone best = {.cosine = -2};
    for (unsigned chosen = 1; chosen < 1u << count; chosen++) {
        cone candidate = {.count = 0};
        int size = 0;
        for (int i = 0; i < count; i++) size += (int)(chosen >> i & 1u);
        if (size > MOST_HELD) continue;
        for (int i = 0; i < count; i++)
            if (chosen >> i & 1u) hold(&candidate, i < c->count ? c->held[i] : number, i < c->count ? c->rim[i] : further);
        if (axis_of(&candidate) && candidate.cosine > best.cosine && holds(&candidate, c, further, number)) best = candidate;
    }
    if (!(best.cosine > -2)) return 0;
    *c = best;
    return 1;
}

/* The one whose cosine to the axis is least; count where there is none. */
static size_t farthest(norma_core_cone_at *at, const void *context, size_t count, const double axis[3], double *cosine, double normal[3])
{
    size_t found = count;
    *cosine = 2;
    for (size_t i = 0; i < count; i++) {
        double n[3];
        if (!at(context, i, n)) continue;
        const double dot = norma_core_dot(axis, n);
        if (dot < *cosine) {
            *cosine = dot;
            found = i;
            memcpy(normal, n, sizeof n);
        }
    }
    return found;
}

int norma_core_smallest_cone_of(norma_core_cone_at *at, const void *context, size_t count, double axis[3])
{
    cone c = {.count = 0};
    double normal[3] = {0, 0, 0};
    size_t first = 0;
    while (first < count && !at(context, first, normal)) first++;
    if (first == count) return 0;
    hold(&c, first, normal);
    if (!axis_of(&c)) return 0;
    for (;;) {
        double cosine;
        const double before = c.cosine;
        const size_t outside = farthest(at, context, count, c.axis, &cosine, normal);
        if (cosine >= c.cosine - ROUNDING || is_held(&c, outside)) break;
        if (!take_in(&c, outside, normal) || c.cosine <= 0x1p-30) return 0;
        if (c.cosine >= before) {                /* no wider than before: what is left outside must be rounding */
            farthest(at, context, count, c.axis, &cosine, normal);
            if (cosine < c.cosine - 0x1p-20) return 0;
            break;
        }
    }
    memcpy(axis, c.axis, sizeof c.axis);
    return 1;
}

static int listed(const void *context, size_t index, double normal[3])
{
    memcpy(normal, ((const double(*)[3])context)[index], 3 * sizeof *normal);
    return 1;
}

int norma_core_smallest_cone(const double (*normals)[3], size_t count, double axis[3]) { return norma_core_smallest_cone_of(listed, normals, count, axis); }
