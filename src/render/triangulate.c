/* page_triangles.c: polygons cut into triangles. Convex ones fan out from their first corner;
 * concave ones lose an ear at a time (Meisters 1975), looked at along the polygon's normal. An ear
 * is a corner that turns left and whose triangle holds no other corner that turns right. */
#include "render/surface_vertices.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct flat_polygon {
    size_t count;
    double (*points)[2];
    uint32_t *left; /* corners not yet cut off, of the polygon */
} flat_polygon;

static double turn(const double a[2], const double b[2], const double c[2]) {
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/* Onto the plane of two axes in which the polygon's area (Newell) is largest, wound
 * counter-clockwise. 0: not finite. */
static int flatten(const norma_mesh *mesh, size_t first, flat_polygon *polygon) {
    double origin[3], last[3] = {0}, area[3] = {0};
    for (size_t i = 0; i < polygon->count; ++i) {
        double p[3];
        if (!render_position(mesh, render_corner(mesh, first + i), p)) return 0;
        if (i == 0) memcpy(origin, p, sizeof origin);
        for (int k = 0; k < 3; ++k) p[k] -= origin[k];
        for (int k = 0; k < 3; ++k)
            area[k] += last[(k + 1) % 3] * p[(k + 2) % 3] - last[(k + 2) % 3] * p[(k + 1) % 3];
        memcpy(last, p, sizeof last);
    }
    const double ax = fabs(area[0]), ay = fabs(area[1]), az = fabs(area[2]);
    const int axis = ax >= ay && ax >= az ? 0 : ay >= az ? 1 : 2;
    const int u = area[axis] < 0 ? (axis + 2) % 3 : (axis + 1) % 3,
              v = area[axis] < 0 ? (axis + 1) % 3 : (axis + 2) % 3;
    for (size_t i = 0; i < polygon->count; ++i) {
        double p[3];
        render_position(mesh, render_corner(mesh, first + i), p);
        polygon->points[i][0] = p[u] - origin[u];
        polygon->points[i][1] = p[v] - origin[v];
        polygon->left[i] = (uint32_t)i;
    }
    return 1;
}

static int within(const double a[2], const double b[2], const double c[2], const double p[2]) {
    return turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0;
}

static int same_point(const double a[2], const double b[2]) { return a[0] == b[0] && a[1] == b[1]; }

static int is_ear(const flat_polygon *polygon, size_t count, size_t at) {
    const uint32_t *left = polygon->left;
    const double *a = polygon->points[left[(at + count - 1) % count]],
                 *b = polygon->points[left[at]], *c = polygon->points[left[(at + 1) % count]];
    if (!(turn(a, b, c) > 0)) return 0;
    for (size_t i = 0; i < count; ++i) {
        const double *p = polygon->points[left[i]];
        if (same_point(p, a) || same_point(p, b) || same_point(p, c) || !within(a, b, c, p))
            continue;
        const double *before = polygon->points[left[(i + count - 1) % count]],
                     *after = polygon->points[left[(i + 1) % count]];
        if (turn(before, p, after) <= 0) return 0;
    }
    return 1;
}

static int is_convex(const flat_polygon *polygon) {
    const size_t n = polygon->count;
    for (size_t i = 0; i < n; ++i)
        if (turn(polygon->points[i], polygon->points[(i + 1) % n], polygon->points[(i + 2) % n]) <
            0)
            return 0;
    return 1;
}

static uint32_t *add(uint32_t *out, size_t first, size_t a, size_t b, size_t c) {
    *out++ = (uint32_t)(first + a);
    *out++ = (uint32_t)(first + b);
    *out++ = (uint32_t)(first + c);
    return out;
}

/* So much work is more than any polygon that was drawn by someone asks for; what is left then fans
 * out. */
static const size_t most_work = 100000000;

static uint32_t *cut_ears(flat_polygon *polygon, size_t first, uint32_t *out) {
    size_t count = polygon->count, at = 0, tried = 0, work = 0;
    uint32_t *left = polygon->left;
    while (count > 3 && work < most_work) {
        work += count;
        /* A polygon that crosses itself may have no ear left: any corner goes then. */
        if (tried < count && !is_ear(polygon, count, at)) {
            at = (at + 1) % count;
            ++tried;
            continue;
        }
        out = add(out, first, left[(at + count - 1) % count], left[at], left[(at + 1) % count]);
        memmove(left + at, left + at + 1, (count - at - 1) * sizeof *left);
        --count;
        at = at % count;
        tried = 0;
    }
    for (size_t i = 1; i + 1 < count; ++i) out = add(out, first, left[0], left[i], left[i + 1]);
    return out;
}

static size_t largest_face(const norma_mesh *mesh, size_t *triangles) {
    size_t largest = 0, first, count;
    *triangles = 0;
    for (size_t face = 0; face < mesh->face_count; ++face) {
        render_face(mesh, face, &first, &count);
        largest = count > largest ? count : largest;
        *triangles += count > 2 ? count - 2 : 0;
    }
    return largest;
}

enum render_result render_triangulate(
    const norma_mesh *mesh, uint32_t **corners, size_t *triangle_count, render_error *error) {
    *corners = NULL;
    *triangle_count = mesh->corner_count / 3;
    if (!mesh->face_starts) return RENDER_OK;
    const size_t largest = largest_face(mesh, triangle_count);
    flat_polygon polygon = {.points = malloc((largest + 1) * sizeof *polygon.points),
        .left = malloc((largest + 1) * sizeof *polygon.left)};
    uint32_t *out = *corners = malloc((3 * *triangle_count + 1) * sizeof *out);
    const int ready = out && polygon.points && polygon.left;
    for (size_t face = 0; ready && face < mesh->face_count; ++face) {
        size_t first;
        render_face(mesh, face, &first, &polygon.count);
        if (polygon.count > 3 && flatten(mesh, first, &polygon) && !is_convex(&polygon))
            out = cut_ears(&polygon, first, out);
        else
            for (size_t i = 1; i + 1 < polygon.count; ++i) out = add(out, first, 0, i, i + 1);
    }
    free(polygon.points);
    free(polygon.left);
    if (ready) return RENDER_OK;
    free(*corners);
    *corners = NULL;
    return render_fail_memory(error);
}
