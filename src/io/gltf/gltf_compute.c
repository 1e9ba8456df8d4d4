/* gltf_compute.c: normals for an asset, and the differences of its morph targets. */
#include "io/gltf/gltf.h"
#include <stdlib.h>
#include <string.h>

/* ---- Normal deltas of morph targets, by norma_morph_normals over the points of a
 * surface: those at one position with one normal share in the base, and so in every target, so that
 * no seam opens. Targets are looked at some at a time. */

enum { TARGETS_AT_A_TIME = 8 };

typedef struct morph {
    gltf_job *job;
    const gltf_surface *s;
    float *positions, *displaced; /* of the surface: decoded, and in one target */
    float *base, *moved;          /* of points: in the base, and in each of some targets */
    uint32_t *vertices;           /* norma_morph_normals' */
    float *sparse;
    float *deltas; /* of points, in one target */
    uint32_t targets[TARGETS_AT_A_TIME];
    size_t target_count;
} morph;

static void free_morph(morph *m) {
    void *const blocks[] = {
        m->positions, m->displaced, m->base, m->moved, m->vertices, m->sparse, m->deltas};
    for (size_t i = 0; i < sizeof blocks / sizeof blocks[0]; ++i) free(blocks[i]);
}

static norma_document_result decode_positions(morph *m) {
    gltf *g = m->job->g;
    const gltf_mesh *mesh = &g->meshes[m->s->mesh];
    for (uint32_t i = 0; i < mesh->primitive_count; ++i) {
        gltf_array array;
        if (g->primitives[mesh->first_primitive + i].not_read) continue;
        norma_document_result result = norma_gltf_array(
            g, g->primitives[mesh->first_primitive + i].base.position, &array, m->job->error);
        for (size_t v = 0; !result && v < array.count; ++v)
            norma_gltf_floats(&array, v, m->positions + 3 * (m->s->position_start[i] + v));
        if (result) return result;
    }
    return NORMA_DOCUMENT_OK;
}

static void take_morph_points(const morph *m, const float *of_surface, float *points) {
    for (size_t p = 0; p < m->s->point_count; ++p)
        memcpy(points + 3 * p, of_surface + 3 * (size_t)m->s->sources[p], 3 * sizeof(float));
}

static norma_document_result begin_morph(morph *m) {
    const size_t positions = m->s->core.positions.count, points = m->s->point_count;
    m->positions = norma_io_allocate(positions, 3 * sizeof *m->positions);
    m->displaced = norma_io_allocate(positions, 3 * sizeof *m->displaced);
    m->base = norma_io_allocate(points, 3 * sizeof *m->base);
    m->moved = norma_io_allocate(points, 3 * TARGETS_AT_A_TIME * sizeof *m->moved);
    m->vertices = norma_io_allocate(points, TARGETS_AT_A_TIME * sizeof *m->vertices);
    m->sparse = norma_io_allocate(points, 3 * TARGETS_AT_A_TIME * sizeof *m->sparse);
    m->deltas = norma_io_allocate(points, 3 * sizeof *m->deltas);
    if (!m->positions || !m->displaced || !m->base || !m->moved || !m->vertices || !m->sparse ||
        !m->deltas)
        return norma_gltf_job_memory(m->job);
    norma_document_result result = decode_positions(m);
    if (!result) take_morph_points(m, m->positions, m->base);
    return result;
}

/* ---- one target */

static int wants(const gltf_job *job, uint32_t primitive, uint32_t target) {
    const gltf_primitive *p = &job->g->primitives[primitive];
    uint32_t set = job->set_of[primitive];
    if (set == GLTF_NONE || !job->sets[set].wanted || target >= p->target_count) return 0;
    const gltf_attributes *attributes = &job->g->targets[p->first_target + target];
    if (job->options->only == NORMA_ONLY_MISSING && p->base.normal != GLTF_NONE &&
        attributes->normal != GLTF_NONE)
        return 0;
    return attributes->normal != GLTF_NONE ||
           (job->options->morphs && attributes->position != GLTF_NONE);
}

static norma_document_result add_displacements(morph *m, uint32_t target, float *positions) {
    gltf *g = m->job->g;
    const gltf_mesh *mesh = &g->meshes[m->s->mesh];
    memcpy(positions, m->positions, m->s->core.positions.count * 3 * sizeof *positions);
    for (uint32_t i = 0; i < mesh->primitive_count; ++i) {
        const gltf_primitive *p = &g->primitives[mesh->first_primitive + i];
        uint32_t accessor = p->not_read || target >= p->target_count
                                ? GLTF_NONE
                                : g->targets[p->first_target + target].position;
        gltf_array array;
        if (accessor == GLTF_NONE) continue;
        norma_document_result result = norma_gltf_array(g, accessor, &array, m->job->error);
        if (result) return result;
        if (array.width != 3)
            return norma_gltf_malformed(
                g, m->job->error, g->accessors[accessor].token, "displacements of three numbers");
        for (size_t v = 0; v < array.count; ++v) {
            float delta[3];
            size_t at = 3 * (m->s->position_start[i] + v);
            norma_gltf_floats(&array, v, delta);
            for (size_t k = 0; k < 3; ++k) positions[at + k] = m->positions[at + k] + delta[k];
        }
    }
    return NORMA_DOCUMENT_OK;
}

static norma_document_result store_deltas(const morph *m, gltf_set *set, uint32_t target) {
    size_t count = set->vertices + set->added_count;
    if (!set->deltas && !(set->deltas = norma_io_allocate(
                              m->job->g->primitives[set->lead].target_count, sizeof *set->deltas)))
        return norma_gltf_job_memory(m->job);
    if (set->deltas[target]) return NORMA_DOCUMENT_OK;
    float *deltas = set->deltas[target] = norma_io_allocate(count, 3 * sizeof *deltas);
    if (!deltas) return norma_gltf_job_memory(m->job);
    for (size_t v = 0; v < count; ++v)
        if (set->point_of[v] != GLTF_NONE)
            memcpy(deltas + 3 * v, m->deltas + 3 * (size_t)set->point_of[v], 3 * sizeof *deltas);
    return NORMA_DOCUMENT_OK;
}

static norma_document_result store_target(const morph *m, size_t number, const size_t *starts) {
    const gltf_mesh *mesh = &m->job->g->meshes[m->s->mesh];
    norma_document_result result = NORMA_DOCUMENT_OK;
    memset(m->deltas, 0, m->s->point_count * 3 * sizeof *m->deltas);
    for (size_t i = starts[number]; i < starts[number + 1]; ++i)
        memcpy(m->deltas + 3 * (size_t)m->vertices[i], m->sparse + 3 * i, 3 * sizeof *m->deltas);
    for (uint32_t i = 0; !result && i < mesh->primitive_count; ++i)
        if (wants(m->job, mesh->first_primitive + i, m->targets[number]))
            result = store_deltas(
                m, &m->job->sets[m->job->set_of[mesh->first_primitive + i]], m->targets[number]);
    return result;
}

/* The targets gathered so far. */
static norma_document_result finish_targets(morph *m) {
    const gltf_surface *s = m->s;
    const size_t points = s->point_count;
    const norma_mesh base = {
        .positions = {.data = m->base, .count = points, .format = NORMA_FORMAT_FLOAT},
        .corners = norma_gltf_points(s),
        .corner_count = s->core.corner_count};
    const norma_vec3_view normals = {
        .data = s->normals, .count = points, .format = NORMA_FORMAT_FLOAT};
    norma_vec3_view targets[TARGETS_AT_A_TIME];
    size_t starts[TARGETS_AT_A_TIME + 1];
    norma_options options = m->job->policy.core;
    options.weld = m->job->options->weld == NORMA_WELD_NONE ? NORMA_WELD_NONE : NORMA_WELD_EXACT;
    for (size_t t = 0; t < m->target_count; ++t)
        targets[t] = (norma_vec3_view){
            .data = m->moved + 3 * points * t, .count = points, .format = NORMA_FORMAT_FLOAT};
    norma_result found = norma_morph_normals(&base, &normals, targets, m->target_count, 0, &options,
        starts, m->vertices, m->sparse, points * m->target_count);
    norma_document_result result =
        found ? norma_document_fail_core(m->job->g->document, m->job->error, found)
              : NORMA_DOCUMENT_OK;
    for (size_t t = 0; !result && t < m->target_count; ++t) result = store_target(m, t, starts);
    m->target_count = 0;
    return result;
}

static norma_document_result gather_target(morph *m, uint32_t target) {
    const gltf_mesh *mesh = &m->job->g->meshes[m->s->mesh];
    int wanted = 0;
    for (uint32_t i = 0; i < mesh->primitive_count; ++i)
        wanted |= wants(m->job, mesh->first_primitive + i, target);
    if (!wanted) return NORMA_DOCUMENT_OK;
    norma_document_result result = m->positions ? NORMA_DOCUMENT_OK : begin_morph(m);
    if (!result) result = add_displacements(m, target, m->displaced);
    if (result) return result;
    take_morph_points(m, m->displaced, m->moved + 3 * m->s->point_count * m->target_count);
    m->targets[m->target_count++] = target;
    return m->target_count == TARGETS_AT_A_TIME ? finish_targets(m) : NORMA_DOCUMENT_OK;
}

/* gltf_compute.c */
static norma_document_result gltf_morph(gltf_job *job, const gltf_surface *surface) {
    morph m = {.job = job, .s = surface};
    const gltf_mesh *mesh = &job->g->meshes[surface->mesh];
    uint32_t targets = 0;
    for (uint32_t i = 0; i < mesh->primitive_count; ++i)
        if (job->g->primitives[mesh->first_primitive + i].target_count > targets)
            targets = job->g->primitives[mesh->first_primitive + i].target_count;
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (uint32_t t = 0; !result && t < targets; ++t) result = gather_target(&m, t);
    if (!result && m.target_count) result = finish_targets(&m);
    free_morph(&m);
    return result;
}

/* ---- Normals for a glTF asset: mesh by mesh the surface, its points, the deltas of its
 * morph targets; then set by set what the accessors are to hold. */

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
    if (!result) result = gltf_morph(job, &surface);
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
