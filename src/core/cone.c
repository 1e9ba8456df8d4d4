/* cone.c: the most visible normal, the axis of the smallest cone round the face normals (Aubry, Loehner 2008, CNME 24:1641). Its cosine is the distance from
 * the origin to the hull of the normals, and two or three of them hold it. They are found by taking in, again and again, the normal that lies farthest outside:
 * each time the cone of the few grows, so the search ends; ties go to the first. */
#include "ring.h"

enum { MOST_HELD = 3 };

typedef struct cone {
    double axis[3], cosine;          /* axis: unit */
    size_t held[MOST_HELD];          /* the normals on its rim */
    int    count;
} cone;

static double least(double a, double b) { return a < b ? a : b; }

/* The rim through two or three normals: the axis is as near to each. Returns 0 where they have none (opposite, or on one great circle). */
static int axis_of(const double (*n)[3], cone *c)
{
    double a[3];
    if (c->count == 1) {
        memcpy(a, n[c->held[0]], sizeof a);
    } else if (c->count == 2) {
        for (int k = 0; k < 3; k++) a[k] = n[c->held[0]][k] + n[c->held[1]][k];
    } else {
        double u[3], v[3];
        norma_core_subtract(n[c->held[1]], n[c->held[0]], u);
        norma_core_subtract(n[c->held[2]], n[c->held[0]], v);
        norma_core_cross(u, v, a);
    }
    if (!(norma_core_length(a) > 0)) return 0;
    norma_core_normalise(a, c->axis);
    if (c->count == 3 && norma_core_dot(c->axis, n[c->held[0]]) < 0)
        for (int k = 0; k < 3; k++) c->axis[k] = -c->axis[k];
    c->cosine = 1;
    for (int i = 0; i < c->count; i++) c->cosine = least(c->cosine, norma_core_dot(c->axis, n[c->held[i]]));
    return 1;
}

static const double ROUNDING = 0x1p-48; /* of cosines of unit vectors; those on the rim of a wide cone differ by more, and are held by name */

static int is_held(const cone *c, size_t member)
{
    for (int i = 0; i < c->count; i++)
        if (c->held[i] == member) return 1;
    return 0;
}

static int holds(const double (*n)[3], const cone *c, const size_t *members, int count)
{
    for (int i = 0; i < count; i++)
        if (!is_held(c, members[i]) && norma_core_dot(c->axis, n[members[i]]) < c->cosine - ROUNDING) return 0;
    return 1;
}

/* The smallest cone round the held ones and one more: the widest is not asked for, since among the cones that hold all of them the one of greatest cosine is it. */
static int take_in(const double (*n)[3], cone *c, size_t further)
{
    size_t members[MOST_HELD + 1];
    const int count = c->count + 1;
    cone best = {.cosine = -2};
    memcpy(members, c->held, (size_t)c->count * sizeof *members);
    members[c->count] = further;
    for (unsigned chosen = 1; chosen < 1u << count; chosen++) {
        cone candidate = {.count = 0};
        int size = 0;
        for (int i = 0; i < count; i++) size += (int)(chosen >> i & 1u);
        if (size > MOST_HELD) continue;
        for (int i = 0; i < count; i++)
            if (chosen >> i & 1u) candidate.held[candidate.count++] = members[i];
        if (axis_of(n, &candidate) && candidate.cosine > best.cosine && holds(n, &candidate, members, count)) best = candidate;
    }
    if (!(best.cosine > -2)) return 0;
    *c = best;
    return 1;
}

static size_t farthest(const double (*n)[3], size_t count, const double axis[3], double *cosine)
{
    size_t found = 0;
    *cosine = 2;
    for (size_t i = 0; i < count; i++) {
        const double dot = norma_core_dot(axis, n[i]);
        if (dot < *cosine) {
            *cosine = dot;
            found = i;
        }
    }
    return found;
}

int norma_core_smallest_cone(const double (*normals)[3], size_t count, double axis[3])
{
    cone c = {.held = {0}, .count = 1};
    if (!axis_of(normals, &c)) return 0;
    for (;;) {
        double cosine;
        const double before = c.cosine;
        const size_t outside = farthest(normals, count, c.axis, &cosine);
        if (cosine >= c.cosine - ROUNDING || is_held(&c, outside)) break;
        if (!take_in(normals, &c, outside) || c.cosine <= 0x1p-30) return 0;
        if (c.cosine >= before) {                /* no wider than before: what is left outside must be rounding */
            farthest(normals, count, c.axis, &cosine);
            if (cosine < c.cosine - 0x1p-20) return 0;
            break;
        }
    }
    memcpy(axis, c.axis, sizeof c.axis);
    return 1;
}
