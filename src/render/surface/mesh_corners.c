/* mesh_corners.c: a norma_mesh corner by corner, and the box that it lies in. */
#include "render/surface/surface_vertices.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

float render_linear(uint32_t level) {
    const double c = level / 255.0;
    return (float)(c <= 0.04045 ? c / 12.92 : pow((c + 0.055) / 1.055, 2.4));
}

int render_position(const norma_mesh *mesh, uint32_t index, double p[3]) {
    norma_view_vector(&mesh->positions, index, p);
    return isfinite(p[0]) && isfinite(p[1]) && isfinite(p[2]);
}

size_t render_face_count(const norma_mesh *mesh) {
    return mesh->face_starts ? mesh->face_count : mesh->corner_count / 3;
}

void render_face(const norma_mesh *mesh, size_t face, size_t *first, size_t *count) {
    *first = mesh->face_starts ? mesh->face_starts[face] : 3 * face;
    *count = mesh->face_starts ? mesh->face_starts[face + 1] - mesh->face_starts[face] : 3;
}

/* Positions that no face uses may lie anywhere, and are left out: they would take the others'
 * precision. */
static uint8_t *used_positions(const norma_mesh *mesh) {
    uint8_t *used = calloc(mesh->positions.count + 1, 1);
    for (size_t i = 0; used && i < mesh->corner_count; ++i) used[norma_mesh_corner(mesh, i)] = 1;
    return used;
}

render_box render_box_of(const norma_mesh *mesh) {
    uint8_t *used = used_positions(mesh);
    double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY},
           half = 0;
    render_box box = {.scale = 1};
    for (size_t i = 0; i < mesh->positions.count; ++i) {
        double p[3];
        if ((used && !used[i]) || !render_position(mesh, (uint32_t)i, p)) continue;
        for (int k = 0; k < 3; ++k) {
            low[k] = p[k] < low[k] ? p[k] : low[k];
            high[k] = p[k] > high[k] ? p[k] : high[k];
        }
    }
    for (int k = 0; k < 3 && low[0] <= high[0]; ++k) {
        box.origin[k] = 0.5 * low[k] + 0.5 * high[k];
        half = fmax(half, 0.5 * high[k] - 0.5 * low[k]);
    }
    if (half > 0 && isfinite(1 / half)) box.scale = 1 / half;
    free(used);
    return box;
}

void render_into_box(const render_box *box, const double p[3], float out[3]) {
    for (int k = 0; k < 3; ++k) out[k] = (float)((p[k] - box->origin[k]) * box->scale);
}
