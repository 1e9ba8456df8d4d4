/* triangulate.c: a mesh of polygons as triangles for the graphics processor: fans where they do,
 * and cut by the core where a polygon is concave. */
#include "core/face/cut_polygon.h"
#include "render/surface/surface_vertices.h"
#include <stdlib.h>

static uint32_t *add(uint32_t *out, size_t first, size_t a, size_t b, size_t c) {
    *out++ = (uint32_t)(first + a);
    *out++ = (uint32_t)(first + b);
    *out++ = (uint32_t)(first + c);
    return out;
}

static uint32_t *cut_face(
    const norma_mesh *mesh, size_t first, size_t count, core_cutter *cutter, uint32_t *out) {
    for (size_t i = 0; i < count; ++i)
        render_position(mesh, norma_mesh_corner(mesh, first + i), cutter->points[i]);
    if (norma_core_polygon_fans(cutter, count)) {
        for (size_t i = 1; i + 1 < count; ++i) out = add(out, first, 0, i, i + 1);
        return out;
    }
    (void)norma_core_cut_polygon(cutter, count, out);
    for (size_t i = 0; i < 3 * (count - 2); ++i) *out++ += (uint32_t)first;
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
    core_cutter cutter;
    void *memory = malloc(norma_core_cutter_size(largest));
    uint32_t *out = *corners = malloc((3 * *triangle_count + 1) * sizeof *out);
    const int ready = out && memory;
    if (ready) norma_core_cutter_begin(&cutter, memory, largest, mesh->corner_count);
    for (size_t face = 0; ready && face < mesh->face_count; ++face) {
        size_t first, count;
        render_face(mesh, face, &first, &count);
        if (count >= 3) out = cut_face(mesh, first, count, &cutter, out);
    }
    free(memory);
    if (ready) return RENDER_OK;
    free(*corners);
    *corners = NULL;
    return render_fail_memory(error);
}
