/* gltf_compute.c: normals for a glTF asset: mesh by mesh the surface, its points, the deltas of its
 * morph targets; then set by set what the accessors are to hold. */
#include "io/gltf/gltf_compute.h"
#include <stdlib.h>
#include <string.h>

static int is_mesh_wanted(const gltf_job *job, uint32_t mesh) {
    const gltf_mesh *m = &job->g->meshes[mesh];
    for (uint32_t i = m->first_primitive; i < m->first_primitive + m->primitive_count; ++i)
        if (job->set_of[i] != GLTF_NONE && job->sets[job->set_of[i]].wanted) return 1;
    return 0;
}

/* The core's progress over one mesh as that over all of them. */
static int pass_on_mesh(void *user, double fraction) {
    const gltf_job *job = user;
    return job->options->progress(
        job->options->progress_user, job->progress_base + fraction * job->progress_scale);
}

static norma_document_result compute_mesh(gltf_job *job, uint32_t mesh) {
    gltf_surface surface;
    norma_document_result result = norma_gltf_gather(job, mesh, &surface);
    job->policy.surface = mesh;
    if (!result) result = norma_gltf_find_points(job, &surface);
    job->policy.core.progress = NULL;
    if (!result) result = norma_gltf_take_points(job, &surface);
    if (!result) result = norma_gltf_morph(job, &surface);
    norma_gltf_surface_free(&surface);
    return result;
}

static norma_document_result compute_meshes(gltf_job *job) {
    const gltf *g = job->g;
    norma_document_result result = NORMA_DOCUMENT_OK;
    size_t wanted = 0;
    for (uint32_t m = 0; m < g->mesh_count; ++m) wanted += (size_t)is_mesh_wanted(job, m);
    job->progress_scale = wanted ? 1 / (double)wanted : 0;
    for (uint32_t m = 0; !result && m < g->mesh_count; ++m) {
        if (!is_mesh_wanted(job, m)) continue;
        job->policy.core.progress = job->options->progress ? pass_on_mesh : NULL;
        job->policy.core.progress_user = job;
        result = compute_mesh(job, m);
        job->progress_base += job->progress_scale;
    }
    return result;
}

/* Between one step and the next, once the core has told that it is done. */
static norma_document_result look_for_cancel(const gltf_job *job) {
    const norma_compute_options *options = job->options;
    if (options->progress && options->progress(options->progress_user, 1))
        return norma_document_fail_core(job->g->document, job->error, NORMA_CANCELLED);
    return NORMA_DOCUMENT_OK;
}

static norma_document_result put_all(gltf_job *job) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    norma_policy_forget(&job->policy.summary->report);
    for (uint32_t s = 0; !result && s < job->set_count; ++s) {
        if (!job->sets[s].wanted) continue;
        result = look_for_cancel(job);
        if (!result) result = norma_gltf_fill_unreferenced(job, &job->sets[s]);
        if (!result) result = norma_gltf_put_set(job, s);
    }
    for (uint32_t i = 0; !result && i < job->g->primitive_count; ++i)
        if (job->set_of[i] != GLTF_NONE && job->sets[job->set_of[i]].wanted)
            result = norma_gltf_put_indices(job, i);
    if (!result) result = norma_gltf_account_tangents(job);
    return result ? result : look_for_cancel(job);
}

static void count_computed_vertices(const gltf_job *job) {
    norma_compute_summary *summary = job->policy.summary;
    for (uint32_t i = 0; i < job->g->primitive_count; ++i) {
        const gltf_primitive *p = &job->g->primitives[i];
        const gltf_set *set = job->set_of[i] == GLTF_NONE ? NULL : &job->sets[job->set_of[i]];
        summary->faces += p->faces;
        summary->vertices_before += p->vertices;
        summary->vertices_after += p->vertices + (set && set->wanted ? set->added_count : 0);
    }
}

/* Where none of the surfaces can be read, there is nothing that could have been asked for. */
static norma_document_result check_any_surface(const gltf *g, norma_document_error *error) {
    const gltf_primitive *unread = NULL;
    for (uint32_t i = 0; i < g->primitive_count; ++i) {
        const gltf_primitive *p = &g->primitives[i];
        if (p->mode < GLTF_TRIANGLES || p->base.position == GLTF_NONE) continue;
        if (!p->not_read) return NORMA_DOCUMENT_OK;
        unread = unread ? unread : p;
    }
    return unread ? norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED,
                        unread->where, "no surface of the file can be read: %s", unread->not_read)
                  : NORMA_DOCUMENT_OK;
}

norma_document_result norma_gltf_compute(norma_document *document,
    const norma_compute_options *options, norma_compute_summary *summary,
    norma_document_error *error) {
    gltf *g = norma_gltf_of(document);
    gltf_job job = {.g = g,
        .options = options,
        .error = error,
        .policy = norma_policy_begin(options, summary, NORMA_SHADING_CREASE, 0)};
    job.policy.core.progress = NULL;
    job.policy.shared = document->shared;
    norma_document_result result = NORMA_DOCUMENT_OK;
    norma_gltf_begin_change(g);
    if (!result) result = check_any_surface(g, error);
    if (!result) result = norma_gltf_find_vertex_sharing(&job);
    if (!result) result = compute_meshes(&job);
    if (!result) result = put_all(&job);
    if (!result) {
        count_computed_vertices(&job);
        result = norma_gltf_finish(g, error);
        summary->changed = g->changed;
    }
    norma_gltf_vertex_sharing_free(&job);
    return result;
}
