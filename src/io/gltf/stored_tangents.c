/* stored_tangents.c: what became of the tangents that stood on the normals which were computed
 * anew: kept, made perpendicular, or marked to be computed anew as well. */
#include "io/gltf/gltf_tangents.h"
#include <stdlib.h>

/* Whether norma_gltf_tangents will give tangents to all primitives of the set, now that each has
 * normals. */
static int can_renew(const tangent_job *job, const gltf_job *computed, const gltf_set *set) {
    if (job->sets.g->primitives[set->lead].base.tangent == GLTF_NONE) return 0;
    for (uint32_t i = set->lead; i != GLTF_NONE; i = computed->next_in_set[i])
        if (job->sets.g->primitives[i].faces == 0 ||
            !norma_gltf_has_map_texcoords(job, &job->sets.g->primitives[i]))
            return 0;
    return 1;
}

/* Vertices count once for each primitive, as those of the summary do. */
static void count_set_tangents(const gltf_job *job, const gltf_set *set) {
    norma_compute_summary *summary = job->policy.summary;
    uint8_t *renew = job->g->document->renew;
    for (uint32_t i = set->lead; i != GLTF_NONE; i = job->next_in_set[i]) {
        if (renew && renew[i]) {
            summary->tangents_regenerated += set->vertices + set->added_count;
        } else {
            summary->tangents_kept += set->tangents_kept;
            summary->tangents_orthogonalised += set->tangents_turned;
        }
    }
}

static norma_document_result mark_renewed(const gltf_job *job) {
    const norma_tangent_options options = {0};
    tangent_job tangents = {.sets = {.g = job->g, .error = job->error}, .options = &options};
    norma_document_result result = norma_gltf_find_materials(&tangents);
    uint8_t *renew = norma_io_allocate((size_t)job->g->primitive_count + 1, 1);
    if (!result && !renew) result = norma_document_fail_memory(job->g->document, job->error);
    for (uint32_t s = 0; !result && s < job->set_count; ++s) {
        const gltf_set *set = &job->sets[s];
        if (!set->wanted || !can_renew(&tangents, job, set)) continue;
        for (uint32_t i = set->lead; i != GLTF_NONE; i = job->next_in_set[i]) renew[i] = 1;
    }
    free(tangents.materials);
    job->g->document->renew = renew;
    return result;
}

norma_document_result norma_gltf_account_tangents(gltf_job *job) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    if (job->options->tangents == NORMA_STORED_TANGENTS_REGENERATE) result = mark_renewed(job);
    for (uint32_t s = 0; !result && s < job->set_count; ++s)
        if (job->sets[s].wanted) count_set_tangents(job, &job->sets[s]);
    return result;
}
