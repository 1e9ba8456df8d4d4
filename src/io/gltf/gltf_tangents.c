/* gltf_tangents.c: tangents for a glTF asset: set by set the tangents of its primitives' corners,
 * the vertices that they become, and the new contents of the accessors. */
#include "io/gltf/gltf_tangents.h"
#include <stdlib.h>

/* Each primitive of a set must have what tangents need: they share their vertices. */
static int is_possible(const tangent_job *job, const gltf_set *set) {
    const uint8_t *meshes = job->options->meshes;
    for (uint32_t i = set->lead; i != GLTF_NONE; i = job->sets.next_in_set[i])
        if ((meshes && !meshes[i]) || !norma_gltf_takes_tangents(job, &job->sets.g->primitives[i]))
            return 0;
    return 1;
}

static norma_document_result compute_set(tangent_job *job, gltf_set *set) {
    const gltf *g = job->sets.g;
    tangent_set of;
    norma_document_result result = norma_gltf_begin_tangents(job, set, &of);
    for (uint32_t i = set->lead; !result && set->wanted && i != GLTF_NONE;
         i = job->sets.next_in_set[i]) {
        tangent_corners made;
        result = norma_gltf_corner_tangents(job, i, &of, &made);
        if (!result) result = norma_gltf_take_tangents(job, i, &of, &made);
        norma_gltf_corner_tangents_free(&g->primitives[i], &made);
        job->progress_base += job->progress_scale;
        ++job->summary->primitives;
    }
    if (!result && set->wanted) result = norma_gltf_put_tangents(job, &of);
    norma_gltf_tangent_set_free(g, &of);
    return result;
}

static norma_document_result compute_sets(tangent_job *job) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (uint32_t s = 0; !result && s < job->sets.set_count; ++s) {
        gltf_set *set = &job->sets.sets[s];
        set->wanted = is_possible(job, set);
        if (set->wanted) result = compute_set(job, set);
    }
    for (uint32_t i = 0; !result && i < job->sets.g->primitive_count; ++i)
        if (job->sets.corners[i]) result = norma_gltf_put_indices(&job->sets, i);
    return result;
}

static void count_tangents(const tangent_job *job) {
    for (uint32_t i = 0; i < job->sets.g->primitive_count; ++i) {
        const gltf_primitive *p = &job->sets.g->primitives[i];
        const gltf_set *set =
            job->sets.set_of[i] == GLTF_NONE ? NULL : &job->sets.sets[job->sets.set_of[i]];
        job->summary->vertices_before += p->vertices;
        job->summary->vertices_after += p->vertices + (set && set->wanted ? set->added_count : 0);
        job->summary->left_out += p->mode >= GLTF_TRIANGLES && (!set || !is_possible(job, set));
    }
}

norma_document_result norma_gltf_tangents(norma_document *document,
    const norma_tangent_options *options, norma_tangent_summary *summary,
    norma_document_error *error) {
    gltf *g = norma_gltf_of(document);
    tangent_job job = {.sets = {.g = g, .error = error},
        .options = options,
        .summary = summary,
        .core = {.struct_size = sizeof job.core,
            .weight = options->weight,
            .threads = options->threads},
        .progress_scale = g->primitive_count ? 1 / (double)g->primitive_count : 0};
    job.sets.options = &job.all;
    norma_gltf_begin_change(g);
    norma_document_result result = norma_gltf_find_materials(&job);
    if (!result) result = norma_gltf_find_vertex_sharing(&job.sets);
    if (!result) result = compute_sets(&job);
    if (!result) {
        count_tangents(&job);
        result = norma_gltf_finish(g, error);
        summary->changed = g->changed;
    }
    norma_gltf_vertex_sharing_free(&job.sets);
    free(job.materials);
    return result;
}
