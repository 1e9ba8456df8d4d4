/* stl_compute.c: facet normals from the winding, and an STL under a matrix. */
#include "io/stl/stl.h"
#include "io/format/compute_policy.h"
#include "io/format/transform_stored_normals.h"
#include "io/file/large_memory.h"
#include "io/stream/tasks.h"
#include <float.h>
#include <math.h>
#include <stdlib.h>

/* ---- computing */

/* Puts the stored normals back where they are not to change, and the sign of zeros, which says
 * nothing. */
static void keep_stored(stl_state *state, norma_only only) {
    for (size_t i = 0; i < state->facets; ++i) {
        const float *stored = state->stored + 3 * i;
        const int stays = !norma_policy_wants_facet(only, stored);
        for (size_t axis = 0; axis < 3; ++axis) {
            float *number = &state->normals[3 * i + axis];
            *number = stays ? stored[axis] : norma_policy_keep_zero(*number, (double)stored[axis]);
        }
    }
}

/* All at once: a facet without a direction looks for the nearest among all. */
static norma_document_result compute_whole(
    norma_document *document, compute_policy *policy, norma_document_error *error) {
    stl_state *state = document->state;
    const norma_only only = policy->options->only;
    norma_document_result result = norma_stl_decode(document, error);
    uint8_t *wanted = norma_io_allocate(state->facets, 1);
    if (!result && !wanted) result = norma_document_fail_memory(document, error);
    for (size_t i = 0; !result && i < state->facets; ++i)
        wanted[i] = (uint8_t)norma_policy_wants_facet(only, state->stored + 3 * i);
    const norma_mesh mesh = norma_stl_core_mesh(state);
    computed_normals made = {.elements = NORMALS_OF_FACES, .with_reasons = 1};
    if (!result)
        result =
            norma_document_fail_core(document, error, norma_policy_compute(policy, &mesh, &made));
    if (!result) {
        norma_policy_fill(policy, made.normals, made.reasons, made.count, wanted, made.count);
        state->normals = made.normals;
        made.normals = NULL;
    }
    norma_computed_normals_free(&made);
    free(wanted);
    return result;
}

enum { BLOCK_FACETS = 1 << 10 };

enum { BLOCK_DONE, BLOCK_CHANGED, BLOCK_FAILED }; /* failed: or some facet has no direction */

typedef struct block_work {
    const stl_state *state;
    unsigned char *bytes; /* the document's own */
    norma_options core;
    unsigned char *done; /* what became of each block */
} block_work;

/* A block of facets at a time, whose positions stay in the cache, and whose normals go straight
 * into the document's bytes. */
static void compute_block(void *context, size_t block) {
    const block_work *work = context;
    const stl_state *state = work->state;
    float positions[9 * BLOCK_FACETS], normals[3 * BLOCK_FACETS];
    const size_t first = block * BLOCK_FACETS, left = state->facets - first,
                 count = left < BLOCK_FACETS ? left : BLOCK_FACETS;
    for (size_t i = 0; i < count; ++i) norma_stl_load(state, first + i, NULL, positions + 9 * i);
    const norma_mesh mesh = {
        .positions = {.data = positions, .count = 3 * count}, .corner_count = 3 * count};
    norma_report report;
    if (norma_face_normals(&mesh, &work->core, normals, count, &report) != NORMA_OK ||
        report.degenerate_faces.count > 0 || report.non_finite.count > 0)
        work->done[block] = BLOCK_FAILED;
    else if (norma_stl_replace_normals(work->bytes, first, count, normals))
        work->done[block] = BLOCK_CHANGED;
}

/* *complete: 0 where some facet has no direction. */
static norma_document_result compute_by_blocks(norma_document *document,
    const norma_options *options, int *complete, int *changed, norma_document_error *error) {
    stl_state *state = document->state;
    const size_t blocks = (state->facets + BLOCK_FACETS - 1) / BLOCK_FACETS;
    block_work work = {.state = state,
        .bytes = norma_edited_own_bytes(document),
        .core = *options,
        .done = norma_io_allocate(blocks, 1)};
    state->bytes = document->source.data;
    if (!work.bytes || !work.done) {
        free(work.done);
        return norma_document_fail_memory(document, error);
    }
    norma_stl_forget_decoded(state);
    work.core.progress = NULL;
    work.core.threads = 0;
    norma_result failed = norma_io_tasks_told(options, blocks, compute_block, &work);
    *complete = !failed && memchr(work.done, BLOCK_FAILED, blocks) == NULL;
    *changed = memchr(work.done, BLOCK_CHANGED, blocks) != NULL;
    free(work.done);
    document->failed = failed != NORMA_OK; /* some blocks have their new normals already */
    return norma_document_fail_core(document, error, failed);
}

static norma_document_result compute_normals(
    norma_document *document, compute_policy *policy, norma_document_error *error) {
    stl_state *state = document->state;
    const norma_only only = policy->options->only;
    int complete = 0, changed = 0;
    if (state->binary && only == NORMA_ONLY_ALL) {
        norma_document_result result =
            compute_by_blocks(document, &policy->core, &complete, &changed, error);
        policy->summary->changed = changed;
        if (result || complete) return result;
        policy->core.progress = NULL; /* a fraction never falls */
    }
    norma_document_result result = compute_whole(document, policy, error);
    if (result) return result;
    keep_stored(state, only);
    result = norma_stl_drop_idle_edit(document, &policy->summary->changed, error);
    policy->summary->changed |= changed;
    return result;
}

norma_document_result norma_stl_compute(norma_document *document,
    const norma_compute_options *options, norma_compute_summary *summary,
    norma_document_error *error) {
    if (options->shading == NORMA_SHADING_SMOOTH || options->shading == NORMA_SHADING_CREASE)
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL,
            "STL holds one normal for each facet: smooth shading and creases cannot be stored; use "
            "neither, or another format");
    norma_document_result result = norma_edited_flush(document, error);
    if (result) return result;
    const stl_state *state = document->state;
    compute_policy policy = norma_policy_begin(options, summary, NORMA_SHADING_FLAT, 0);
    summary->faces = state->facets;
    summary->vertices_before = summary->vertices_after = 3 * state->facets;
    if (state->facets == 0) return NORMA_DOCUMENT_OK;
    return compute_normals(document, &policy, error);
}

/* ---- transforming */

/* Under a mirror the second and the third vertex change places, so that the winding still tells the
 * outside. */
static void swap_vertices(double *vertices, size_t facets) {
    for (size_t i = 0; i < facets; ++i) {
        double second[3];
        memcpy(second, vertices + 9 * i + 3, sizeof second);
        memcpy(vertices + 9 * i + 3, vertices + 9 * i + 6, sizeof second);
        memcpy(vertices + 9 * i + 6, second, sizeof second);
    }
}

static norma_document_result transform_vertices(
    norma_document *document, const double matrix[16], int mirrored, norma_document_error *error) {
    stl_state *state = document->state;
    const norma_mesh mesh = norma_stl_core_mesh(state);
    state->vertices = norma_io_allocate(state->facets, 9 * sizeof *state->vertices);
    if (!state->vertices) return norma_document_fail_memory(document, error);
    norma_result failed = norma_transform_positions_double(
        matrix, mesh.positions, state->vertices, 0, mesh.positions.count);
    if (failed) return norma_document_fail_core(document, error, failed);
    norma_document_result result =
        norma_check_transformed_range(document, &mesh.positions, state->vertices,
            state->binary || !state->many_digits ? (double)FLT_MAX : DBL_MAX, "facet", 3, error);
    if (!result && mirrored) swap_vertices(state->vertices, state->facets);
    return result;
}

static norma_document_result transform_normals(
    norma_document *document, const normal_carrier *carrier, norma_document_error *error) {
    stl_state *state = document->state;
    const size_t numbers = 3 * state->facets;
    double *stored = norma_io_allocate(numbers, sizeof *stored);
    state->normals = norma_io_allocate(numbers, sizeof *state->normals);
    norma_document_result result =
        stored && state->normals ? NORMA_DOCUMENT_OK : norma_document_fail_memory(document, error);
    for (size_t i = 0; i < numbers && !result; ++i) stored[i] = (double)state->stored[i];
    if (!result)
        result = norma_transform_stored_normals(
            document, carrier, stored, state->facets, state->normals, error);
    free(stored);
    return result;
}

norma_document_result norma_stl_transform(norma_document *document,
    const norma_transform_options *options, norma_transform_summary *summary,
    norma_document_error *error) {
    norma_document_result result = norma_edited_flush(document, error);
    if (result) return result;
    summary->vertices = 3 * ((const stl_state *)document->state)->facets;
    summary->meshes = 1;
    if (norma_stored_normals_is_identity(options->matrix)) return NORMA_DOCUMENT_OK;
    normal_carrier carrier;
    result = norma_stored_normals_begin(document, options, summary, &carrier, error);
    if (result) return result;
    result = norma_stl_decode(document, error);
    if (!result) result = transform_vertices(document, options->matrix, carrier.mirrored, error);
    if (!result) result = transform_normals(document, &carrier, error);
    if (!result) result = norma_stl_drop_idle_edit(document, &summary->changed, error);
    return result ? result : norma_stored_normals_progress(document, options, 1, error);
}
