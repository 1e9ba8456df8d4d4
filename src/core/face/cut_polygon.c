/* cut_polygon.c: see cut_polygon.h. Which other corners lie in the triangle of a possible ear is
 * remembered from one cut to the next, so that most polygons take far less than the square of their
 * corners. */
#include "core/face/cut_polygon.h"
#include "core/face/face.h"
#include <math.h>
#include <string.h>

enum { LEAST_WORK = 1 << 25, WORK_A_CORNER = 1 << 12, AGREEMENT_WORK = 8 };
static const double FAR_OFF = .5; /* cosine of 60 degrees */

size_t norma_core_cutter_size(size_t largest) {
    const size_t corner = sizeof(double[3]) + sizeof(double[2]) + 2 * sizeof(uint32_t) + 1;
    return largest < (SIZE_MAX - corner) / corner ? (largest + 1) * corner : SIZE_MAX;
}

void norma_core_cutter_begin(
    core_cutter *cutter, void *memory, size_t largest, size_t all_corners) {
    const size_t room = largest + 1;
    *cutter = (core_cutter){.points = memory};
    cutter->flat = (double(*)[2])(cutter->points + room);
    cutter->left = (uint32_t *)(cutter->flat + room);
    cutter->checked = cutter->left + room;
    cutter->gone = (uint8_t *)(cutter->checked + room);
    cutter->work =
        LEAST_WORK +
        (all_corners < SIZE_MAX / 2 / WORK_A_CORNER ? WORK_A_CORNER * all_corners : SIZE_MAX / 2);
}

static void use_work(core_cutter *c, size_t steps) { c->work -= steps < c->work ? steps : c->work; }

/* ---- in the plane */

static double turn(const double a[2], const double b[2], const double c[2]) {
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

static int is_inside(const double a[2], const double b[2], const double c[2], const double p[2]) {
    return turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0;
}

static int is_one_point(const double a[2], const double b[2]) {
    return a[0] == b[0] && a[1] == b[1];
}

/* Moves the first corner to the origin and drops the axis along which the vector area is largest.
 * 0: the polygon has no area, or a corner is not finite. */
static int flatten(core_cutter *c, size_t count) {
    double first[3], *area = c->area;
    memcpy(first, c->points[0], sizeof first);
    memset(c->area, 0, sizeof c->area);
    c->count = count;
    for (size_t i = 0; i < count; ++i)
        for (int k = 0; k < 3; ++k) c->points[i][k] -= first[k];
    for (size_t i = 1; i + 1 < count; ++i)
        for (int k = 0; k < 3; ++k) {
            const double *a = c->points[i], *b = c->points[i + 1];
            area[k] += a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
        }
    int axis = 0;
    for (int k = 1; k < 3; ++k)
        if (fabs(area[k]) > fabs(area[axis])) axis = k;
    if (!(fabs(area[axis]) > 0) || !norma_core_finite(area)) return 0;
    for (size_t i = 0; i < count; ++i) {
        c->flat[i][0] = c->points[i][(axis + 1) % 3];
        c->flat[i][1] = c->points[i][(axis + 2) % 3] * (area[axis] > 0 ? 1 : -1);
    }
    return 1;
}

int norma_core_polygon_fans(core_cutter *c, size_t count) {
    if (count <= 3 || !flatten(c, count)) return 1;
    for (size_t i = 0; i < count; ++i)
        if (turn(c->flat[i], c->flat[(i + 1) % count], c->flat[(i + 2) % count]) < 0) return 0;
    return 1;
}

/* ---- ears. place: in c->left */

typedef struct ear {
    uint32_t before, at, after;
} ear;

static ear ear_at(const core_cutter *c, size_t place) {
    return (ear){c->left[(place + c->left_count - 1) % c->left_count], c->left[place],
        c->left[(place + 1) % c->left_count]};
}

/* Whether the corner can be cut off: convex, and no other corner in the triangle. */
static int is_ear(core_cutter *c, size_t place) {
    const ear e = ear_at(c, place);
    const double *p = c->flat[e.before], *q = c->flat[e.at], *r = c->flat[e.after];
    if (!(turn(p, q, r) > 0)) return 0;
    for (; c->checked[e.at] < c->count; ++c->checked[e.at]) {
        const uint32_t k = c->checked[e.at];
        const double *other = c->flat[k];
        if (!c->work) return 0;
        use_work(c, 1);
        if (!c->gone[k] && k != e.before && k != e.at && k != e.after && !is_one_point(other, p) &&
            !is_one_point(other, q) && !is_one_point(other, r) && is_inside(p, q, r, other))
            return 0;
    }
    return 1;
}

/* Cosine of the angle between a triangle and the polygon's area, at most FAR_OFF: nearer is as
 * good. */
static double agreement(const core_cutter *c, ear e) {
    double u[3], v[3], normal[3];
    norma_core_subtract(c->points[e.at], c->points[e.before], u);
    norma_core_subtract(c->points[e.after], c->points[e.before], v);
    norma_core_cross(u, v, normal);
    const double product = norma_core_length(normal) * norma_core_length(c->area);
    return product > 0 ? fmin(norma_core_dot(normal, c->area) / product, FAR_OFF) : -1;
}

/* Where four corners are left, the triangle that remains counts as well. */
static double cut_agreement(const core_cutter *c, size_t place) {
    const ear e = ear_at(c, place);
    const double here = agreement(c, e);
    return c->left_count == 4
               ? fmin(here, agreement(c, (ear){e.before, e.after, c->left[(place + 2) % 4]}))
               : here;
}

static double cut_length(const core_cutter *c, size_t place) {
    const ear e = ear_at(c, place);
    double cut[3];
    norma_core_subtract(c->points[e.before], c->points[e.after], cut);
    return norma_core_dot(cut, cut);
}

/* The place of the best ear; left_count: the polygon has no ear. */
static size_t find_ear(core_cutter *c) {
    size_t best = c->left_count;
    double best_agreement = 0, best_length = 0;
    for (size_t i = 0; i < c->left_count; ++i) {
        if (!is_ear(c, i)) continue;
        use_work(c, AGREEMENT_WORK);
        const double how = cut_agreement(c, i), length = cut_length(c, i);
        if (best < c->left_count &&
            (how < best_agreement || (how == best_agreement && !(length < best_length))))
            continue;
        best = i;
        best_agreement = how;
        best_length = length;
    }
    return best;
}

static void cut_off(core_cutter *c, size_t place, uint32_t triangle[3]) {
    const ear e = ear_at(c, place);
    triangle[0] = e.before;
    triangle[1] = e.at;
    triangle[2] = e.after;
    c->gone[e.at] = 1;
    c->checked[e.before] = c->checked[e.after] = 0; /* they have other triangles now */
    memmove(c->left + place, c->left + place + 1, (c->left_count - place - 1) * sizeof *c->left);
    --c->left_count;
}

size_t norma_core_cut_polygon(core_cutter *c, size_t count, uint32_t *triangles) {
    const int has_area = flatten(c, count);
    size_t done = 0;
    for (c->left_count = 0; c->left_count < count; ++c->left_count)
        c->left[c->left_count] = (uint32_t)c->left_count;
    memset(c->gone, 0, count);
    memset(c->checked, 0, count * sizeof *c->checked);
    while (has_area && c->left_count >= 3) {
        const size_t best = find_ear(c);
        use_work(c, c->left_count);
        if (best == c->left_count || !c->work) break;
        cut_off(c, best, triangles + 3 * done++);
    }
    uint32_t *to = triangles + 3 * done;
    for (size_t i = 1; i + 1 < c->left_count; ++i, to += 3) {
        to[0] = c->left[0];
        to[1] = c->left[i];
        to[2] = c->left[i + 1];
    }
    return done;
}
