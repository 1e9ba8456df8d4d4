/* triangle_strips.c: triangle strips as VRML and old scanning tools write them into PLY: one list
 * of vertices, -1 where a strip ends and the next begins. Every second triangle of a strip runs the
 * other way. */
#include "io/ply/ply.h"

size_t norma_ply_strip_triangles(const int64_t *items, size_t count, uint32_t *corners) {
    size_t length = 0, triangles = 0;
    for (size_t i = 0; i < count; ++i) {
        length = items[i] < 0 ? 0 : length + 1;
        if (length < 3) continue;
        if (corners) {
            int odd = length % 2 == 0;
            corners[3 * triangles] = (uint32_t)items[odd ? i - 1 : i - 2];
            corners[3 * triangles + 1] = (uint32_t)items[odd ? i - 2 : i - 1];
            corners[3 * triangles + 2] = (uint32_t)items[i];
        }
        ++triangles;
    }
    return triangles;
}

/* The corner that completes the triangle after the directed edge from -> to, or -1. */
static int64_t completing(const uint32_t triangle[3], int64_t from, int64_t to) {
    for (int k = 0; k < 3; ++k)
        if (triangle[k] == from && triangle[(k + 1) % 3] == to) return triangle[(k + 2) % 3];
    return -1;
}

/* The rotation of a strip's first triangle after which the second can follow. */
static int first_rotation(const uint32_t *triangle, const uint32_t *next) {
    for (int k = 0; k < 3 && next; ++k)
        if (completing(next, triangle[(k + 2) % 3], triangle[(k + 1) % 3]) >= 0) return k;
    return 0;
}

size_t norma_ply_strip_encode(const uint32_t *corners, size_t triangles, int64_t *out) {
    size_t size = 0, length = 0;
    for (size_t t = 0; t < triangles; ++t) {
        const uint32_t *triangle = corners + 3 * t;
        int odd = length % 2 == 1; /* the next triangle of a strip of `length` vertices */
        int64_t more =
            length < 3 ? -1
                       : completing(triangle, out[size - (odd ? 1 : 2)], out[size - (odd ? 2 : 1)]);
        if (more >= 0) {
            out[size++] = more;
            ++length;
            continue;
        }
        if (size > 0) out[size++] = -1;
        int first = first_rotation(triangle, t + 1 < triangles ? triangle + 3 : NULL);
        for (int k = 0; k < 3; ++k) out[size++] = triangle[(first + k) % 3];
        length = 3;
    }
    return size;
}
