/* tangent_inputs.c: what the tangents of a primitive are made of: normals, and the set of texture
 * coordinates that its normal map uses, through that map's KHR_texture_transform. */
#include "io/gltf/gltf_tangents.h"
#include "io/gltf/gltf_scene.h"
#include "io/file/large_memory.h"
#include <stdio.h>
#include <stdlib.h>

norma_document_result norma_gltf_find_materials(tangent_job *job) {
    const gltf *g = job->sets.g;
    const uint32_t list = norma_json_member(&g->json, 0, "materials");
    size_t number = 0;
    job->materials = norma_io_allocate((size_t)g->material_count + 1, sizeof *job->materials);
    if (!job->materials) return norma_document_fail_memory(g->document, job->sets.error);
    for (uint32_t item = norma_json_first(&g->json, list);
         item != JSON_NONE && number < g->material_count;
         item = norma_json_next(&g->json, list, item))
        job->materials[number++] = item;
    return NORMA_DOCUMENT_OK;
}

static norma_texture_info placement_of_map(const tangent_job *job, const gltf_primitive *p) {
    const gltf *g = job->sets.g;
    norma_texture_info place = {.scale = {1, 1}};
    if (p->material < g->material_count)
        place = norma_gltf_normal_map(g, job->materials[p->material]);
    if (job->options->texcoord_given && place.texcoord != job->options->texcoord)
        place = (norma_texture_info){.texcoord = job->options->texcoord, .scale = {1, 1}};
    return place;
}

static uint32_t texcoord_accessor(const gltf *g, const gltf_primitive *p, size_t set) {
    char name[40];
    snprintf(name, sizeof name, "TEXCOORD_%zu", set);
    const uint32_t found = norma_gltf_find(g, &p->base, name);
    const uint32_t accessor = found == GLTF_NONE ? GLTF_NONE : g->attributes[found].accessor;
    return accessor != GLTF_NONE && g->accessors[accessor].width == 2 &&
                   g->accessors[accessor].count == p->vertices
               ? accessor
               : GLTF_NONE;
}

int norma_gltf_has_map_texcoords(const tangent_job *job, const gltf_primitive *p) {
    return texcoord_accessor(job->sets.g, p, placement_of_map(job, p).texcoord) != GLTF_NONE;
}

int norma_gltf_takes_tangents(const tangent_job *job, const gltf_primitive *p) {
    const gltf *g = job->sets.g;
    return !p->not_read && p->faces > 0 && p->base.normal != GLTF_NONE &&
           g->accessors[p->base.normal].width == 3 &&
           g->accessors[p->base.normal].count == p->vertices &&
           norma_gltf_has_map_texcoords(job, p);
}

norma_document_result norma_gltf_tangent_texcoords(
    tangent_job *job, const gltf_primitive *p, const float **texcoords, float **owned) {
    gltf *g = job->sets.g;
    const norma_texture_info place = placement_of_map(job, p);
    *owned = NULL;
    norma_document_result result = norma_gltf_decode(
        g, texcoord_accessor(g, p, place.texcoord), 2, texcoords, job->sets.error);
    if (result || !norma_gltf_moves(&place)) return result;
    *owned = norma_io_block(p->vertices, 2 * sizeof **owned);
    if (!*owned) return norma_document_fail_memory(g->document, job->sets.error);
    norma_texture_place(&place, *texcoords, p->vertices, 2, *owned);
    *texcoords = *owned;
    return NORMA_DOCUMENT_OK;
}
