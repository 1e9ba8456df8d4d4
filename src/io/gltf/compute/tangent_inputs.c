/* tangent_inputs.c: what the tangents of a primitive are made of: normals, and the set of texture
 * coordinates that its normal map uses, through that map's KHR_texture_transform. */
#include "io/gltf/compute/gltf_tangents.h"
#include "io/gltf/read/gltf_scene.h"
#include "io/gltf/read/sine.h"
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

static gltf_map_place place_of(const tangent_job *job, const gltf_primitive *p) {
    const gltf *g = job->sets.g;
    gltf_map_place place = {.scale = {1, 1}};
    if (p->material < g->material_count)
        place = norma_gltf_normal_map(g, job->materials[p->material]);
    if (job->options->texcoord_given && place.set != job->options->texcoord)
        place = (gltf_map_place){.set = job->options->texcoord, .scale = {1, 1}};
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
    return texcoord_accessor(job->sets.g, p, place_of(job, p).set) != GLTF_NONE;
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
    const gltf_map_place place = place_of(job, p);
    *owned = NULL;
    norma_document_result result =
        norma_gltf_decode(g, texcoord_accessor(g, p, place.set), 2, texcoords, job->sets.error);
    if (result || !place.moves) return result;
    *owned = norma_io_block(p->vertices, 2 * sizeof **owned);
    if (!*owned) return norma_document_fail_memory(g->document, job->sets.error);
    double c, s;
    norma_gltf_turn((double)place.rotation, &c, &s);
    for (size_t v = 0; v < p->vertices; ++v) {
        const double x = (double)place.scale[0] * (double)(*texcoords)[2 * v],
                     y = (double)place.scale[1] * (double)(*texcoords)[2 * v + 1];
        (*owned)[2 * v] = (float)(c * x + s * y + (double)place.offset[0]);
        (*owned)[2 * v + 1] = (float)(c * y - s * x + (double)place.offset[1]);
    }
    *texcoords = *owned;
    return NORMA_DOCUMENT_OK;
}
