/* page_triangles.c: polygons as triangles, for drawing only; normals are those of the polygon as it
 * is. */
#include "model.h"
#include <math.h>

typedef struct flat_polygon {
    const double (*points)[3];
    int u, v;    /* the two axes that stay */
    double sign; /* so that it runs counter-clockwise */
} flat_polygon;

static double cross(const flat_polygon *flat, uint32_t a, uint32_t b, uint32_t c) {
    const double *p = flat->points[a], *q = flat->points[b], *r = flat->points[c];
    return flat->sign * ((q[flat->u] - p[flat->u]) * (r[flat->v] - p[flat->v]) -
                            (q[flat->v] - p[flat->v]) * (r[flat->u] - p[flat->u]));
}

/* Drops the axis along which the area vector (Newell) is longest. */
static flat_polygon flatten(const double (*points)[3], size_t count) {
    double area[3] = {0, 0, 0};
    for (size_t i = 1; i + 1 < count; ++i)
        for (int axis = 0; axis < 3; ++axis) {
            const int u = (axis + 1) % 3, v = (axis + 2) % 3;
            area[axis] += (points[i][u] - points[0][u]) * (points[i + 1][v] - points[0][v]) -
                          (points[i][v] - points[0][v]) * (points[i + 1][u] - points[0][u]);
        }
    int longest = fabs(area[1]) > fabs(area[0]) ? 1 : 0;
    if (fabs(area[2]) > fabs(area[longest])) longest = 2;
    return (flat_polygon){points, (longest + 1) % 3, (longest + 2) % 3, area[longest] < 0 ? -1 : 1};
}

static int is_inside(const flat_polygon *flat, uint32_t a, uint32_t b, uint32_t c, uint32_t p) {
    return cross(flat, a, b, p) >= 0 && cross(flat, b, c, p) >= 0 && cross(flat, c, a, p) >= 0;
}

static int is_same(const flat_polygon *flat, uint32_t a, uint32_t b) {
    return flat->points[a][flat->u] == flat->points[b][flat->u] &&
           flat->points[a][flat->v] == flat->points[b][flat->v];
}

static int is_ear(const flat_polygon *flat, const uint32_t *left, size_t count, size_t at) {
    const uint32_t a = left[(at + count - 1) % count], b = left[at], c = left[(at + 1) % count];
    if (!(cross(flat, a, b, c) > 0)) return 0;
    for (size_t i = 0; i < count; ++i) {
        const uint32_t p = left[i];
        if (p != a && p != b && p != c && !is_same(flat, p, a) && !is_same(flat, p, b) &&
            !is_same(flat, p, c) && is_inside(flat, a, b, c, p))
            return 0;
    }
    return 1;
}

/* Beyond this many corners the square of their number is too much for a page: a fan has to do. */
enum { MOST_CORNERS = 20000 };

void model_triangulate(
    const double (*points)[3], size_t corner_count, uint32_t *scratch, uint32_t *triangles) {
    const flat_polygon flat = flatten(points, corner_count);
    size_t left = corner_count, at = 0, written = 0, misses = 0;
    for (size_t i = 0; i < corner_count; ++i) scratch[i] = (uint32_t)i;
    while (left > 3) {
        at %= left;
        /* What has no ear crosses itself or has no area: any corner will do. */
        if (corner_count <= MOST_CORNERS && misses < left && !is_ear(&flat, scratch, left, at)) {
            ++at;
            ++misses;
            continue;
        }
        const size_t before = (at + left - 1) % left, after = (at + 1) % left;
        triangles[written++] = scratch[before];
        triangles[written++] = scratch[at];
        triangles[written++] = scratch[after];
        for (size_t i = at; i + 1 < left; ++i) scratch[i] = scratch[i + 1];
        --left;
        misses = 0;
    }
    for (size_t i = 0; i < 3; ++i) triangles[written++] = scratch[i];
}
