/* edge_parts.c: see edge_parts.h. */
#include "check/fix/edge_parts.h"
#include <string.h>

int norma_fix_compare_points(const double a[3], const double b[3]) {
    for (int axis = 0; axis < 3; axis++)
        if (a[axis] != b[axis]) return a[axis] < b[axis] ? -1 : 1;
    return 0;
}

int norma_fix_compare_edges(const void *a, const void *b) {
    const fix_edge *one = a, *other = b;
    int order = norma_fix_compare_points(one->a, other->a);
    order = order ? order : norma_fix_compare_points(one->b, other->b);
    return order ? order : one->mesh != other->mesh ? (one->mesh < other->mesh ? -1 : 1) : 0;
}

size_t norma_fix_face_edges(const core_mesh *mesh, size_t face, uint32_t face_number,
    uint32_t mesh_number, fix_edge *edges) {
    const size_t begin = norma_core_face_begin(mesh, face), end = norma_core_face_end(mesh, face);
    size_t count = 0;
    for (size_t c = begin; c < end; c++) {
        double from[3], to[3];
        norma_core_position(mesh, norma_core_corner(mesh, c), from);
        norma_core_position(mesh, norma_core_corner(mesh, c + 1 < end ? c + 1 : begin), to);
        const int order = norma_fix_compare_points(from, to);
        if (!norma_core_finite(from) || !norma_core_finite(to) || order == 0) continue;
        fix_edge *edge = &edges[count++];
        memcpy(edge->a, order < 0 ? from : to, sizeof from);
        memcpy(edge->b, order < 0 ? to : from, sizeof to);
        edge->face = face_number;
        edge->mesh = mesh_number;
        edge->way = order < 0;
    }
    return count;
}

uint32_t norma_fix_root(uint32_t *parents, uint32_t face) {
    while (parents[face] != face) face = parents[face] = parents[parents[face]];
    return face;
}

void norma_fix_unite(uint32_t *parents, uint32_t one, uint32_t other) {
    const uint32_t a = norma_fix_root(parents, one), b = norma_fix_root(parents, other);
    parents[a > b ? a : b] = a < b ? a : b;
}
