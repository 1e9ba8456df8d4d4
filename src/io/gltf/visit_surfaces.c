/* visit_surfaces.c: the surfaces of a glTF as computing sees them, for those who only look. */
#include "io/gltf/visit_surfaces.h"
#include "io/gltf/gltf_compute.h"
#include <stdlib.h>

/* Integers that stand for numbers from -1 to 1; mixed ones were made floats already. */
static double surface_unit_of(const gltf *g, const gltf_mesh *mesh, norma_format format) {
    for (uint32_t i = mesh->first_primitive; i < mesh->first_primitive + mesh->primitive_count;
         ++i) {
        if (g->primitives[i].not_read) continue;
        const gltf_accessor *a = &g->accessors[g->primitives[i].base.position];
        if (!a->normalized || format == NORMA_FORMAT_FLOAT) return 1;
        return a->component == GLTF_BYTE    ? 1.0 / 127
               : a->component == GLTF_UBYTE ? 1.0 / 255
               : a->component == GLTF_SHORT ? 1.0 / 32767
                                            : 1.0 / 65535;
    }
    return 1;
}

static size_t find_surface_parts(const gltf *g, const gltf_surface *s, surface_part *parts) {
    const gltf_mesh *mesh = &g->meshes[s->mesh];
    size_t count = 0;
    for (uint32_t i = 0; i < mesh->primitive_count; ++i) {
        if (g->primitives[mesh->first_primitive + i].not_read) continue;
        int repeated = 0;
        for (size_t k = 0; k < count && !repeated; ++k)
            repeated = parts[k].first_corner == s->corner_start[i] &&
                       g->primitives[parts[k].mesh].faces > 0;
        parts[count++] = (surface_part){mesh->first_primitive + i, s->position_start[i],
            repeated ? SIZE_MAX : s->corner_start[i]};
    }
    return count;
}

static norma_document_result visit_mesh(
    gltf_job *job, uint32_t mesh, visit_surface *visit, void *user) {
    gltf_surface surface;
    norma_document_result result = norma_gltf_gather(job, mesh, &surface);
    surface_part *parts = norma_io_allocate(job->g->meshes[mesh].primitive_count, sizeof *parts);
    if (!result && !parts) result = norma_document_fail_memory(job->g->document, job->error);
    if (!result) {
        document_surface seen = {.number = mesh, .mesh = &surface.core, .parts = parts};
        seen.unit = surface_unit_of(job->g, &job->g->meshes[mesh], surface.core.positions.format);
        seen.part_count = find_surface_parts(job->g, &surface, parts);
        if (seen.part_count) result = visit(user, &seen);
    }
    free(parts);
    norma_gltf_surface_free(&surface);
    return result;
}

norma_document_result norma_gltf_visit_surfaces(
    norma_document *document, visit_surface *visit, void *user, norma_document_error *error) {
    gltf_job job = {.g = norma_gltf_of(document), .error = error};
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (uint32_t m = 0; !result && m < job.g->mesh_count; ++m)
        result = visit_mesh(&job, m, visit, user);
    return result;
}
