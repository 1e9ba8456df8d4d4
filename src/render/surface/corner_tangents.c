/* corner_tangents.c: the tangents that a normal map is drawn with: those of the file, otherwise
 * MikkTSpace's (Mikkelsen 2008), which baking programs use. */
#include "render/surface/surface_vertices.h"
#include <stdlib.h>
#include <string.h>

static void copy_stored(const render_surface *surface, float *tangents) {
    for (size_t i = 0; i < surface->mesh.corner_count; ++i)
        memcpy(tangents + 4 * i,
            surface->tangents + (size_t)4 * norma_mesh_corner(&surface->mesh, i),
            4 * sizeof *tangents);
}

/* Without tangents, zeros: the shader then takes derivatives. */
static void compute(const render_surface *surface, const float *normals, float *tangents) {
    const size_t corners = surface->mesh.corner_count;
    const norma_attribute normal = {.data = normals, .count = corners, .of = NORMA_PER_CORNER},
                          texcoord = {.data = surface->normal_map.texcoords,
                              .count = surface->mesh.positions.count,
                              .of = NORMA_PER_VERTEX};
    const norma_options options = {.struct_size = sizeof options, .threads = NORMA_ALL_THREADS};
    if (norma_corner_tangents(&surface->mesh, &normal, &texcoord, NORMA_TANGENTS_MIKK, &options,
            tangents, corners, NULL))
        memset(tangents, 0, 4 * corners * sizeof *tangents);
    for (size_t i = 0; i < corners; ++i) tangents[4 * i + 3] *= -1;
}

float *render_tangents(const render_surface *surface, const float *normals) {
    float *tangents = malloc((4 * surface->mesh.corner_count + 1) * sizeof *tangents);
    if (!tangents) return NULL;
    if (surface->tangents)
        copy_stored(surface, tangents);
    else
        compute(surface, normals, tangents);
    return tangents;
}
