/* mesh_arrays.c: the caller's arrays, element by element, for callers. */
#include "core/call/call.h"

void norma_view_vector(const norma_vec3_view *view, size_t index, double out[3]) {
    norma_view_read(view, index, out);
}

uint32_t norma_mesh_corner(const norma_mesh *mesh, size_t corner) {
    const unsigned char *corners = mesh->corners;
    if (!corners) return (uint32_t)corner;
    return norma_index_read(
        corners, mesh->corner_size ? mesh->corner_size : sizeof(uint32_t), corner);
}
