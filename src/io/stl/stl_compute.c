/* stl_compute.c: facet normals from the winding, and an STL under a matrix.
 *
 * A facet normal of zero is a custom that means "take the winding": it counts as missing, so `only
 * missing` and `only broken` fill it; broken beyond that is what is not finite (of N101 to N103,
 * N101 alone is for facets). */
#include "io/stl/stl.h"
#include "io/format/transform_stored_normals.h"
#include "io/stream/large_memory.h"
#include "io/stream/tasks.h"
#include <float.h>
#include <math.h>
#include <stdlib.h>

/* ---- computing */

static int is_wanted(const float stored[3], norma_only only) {
    double square = 0;
    for (int axis = 0; axis < 3; ++axis) {
        if (!isfinite(stored[axis])) return only == NORMA_ONLY_BROKEN;
        square += (double)stored[axis] * (double)stored[axis];
    }
    return square < 1e-12;
}

/* A binary file is computed without being decoded as a whole; its stored normals are then in the
 * bytes alone. */
static void stored_normal(const stl_state *state, size_t facet, float normal[3]) {
    if (state->stored)
        memcpy(normal, state->stored + 3 * facet, 3 * sizeof *normal);
    else
        norma_stl_load(state, facet, normal, NULL);
}

/* Puts the stored normals back where they are not to change, and the sign of zeros, which says
 * nothing. */
static void keep_stored(stl_state *state, norma_only only, size_t first, size_t end) {
    for (size_t i = first; i < end; ++i) {
        float stored[3];
        stored_normal(state, i, stored);
        const int stays = only != NORMA_ONLY_ALL && !is_wanted(stored, only);
        for (size_t axis = 0; axis < 3; ++axis)
            if (stays || state->normals[3 * i + axis] == stored[axis])
                state->normals[3 * i + axis] = stored[axis];
    }
}

/* Counts the facets that got another's normal. Where no facet has a direction at all, files get the
 * z axis. */
static size_t fill(stl_state *state, const uint8_t *reasons, norma_only only) {
    size_t filled = 0;
    for (size_t i = 0; i < state->facets; ++i) {
        float *normal = state->normals + 3 * i;
        if (!reasons[i]) continue;
        filled += only == NORMA_ONLY_ALL || is_wanted(state->stored + 3 * i, only);
        if (normal[0] == 0 && normal[1] == 0 && normal[2] == 0) normal[2] = 1;
    }
    return filled;
}

/* All at once: a facet without a direction looks for the nearest among all. */
static norma_document_result compute_whole(norma_document *document, const norma_options *options,
    norma_only only, norma_compute_summary *summary, norma_document_error *error) {
    stl_state *state = document->state;
    norma_document_result result = norma_stl_decode(document, error);
    if (result) return result;
    const norma_mesh mesh = norma_stl_core_mesh(state);
    norma_options core = *options;
    core.reasons = norma_io_allocate(state->facets, 1);
    if (!core.reasons) return norma_document_fail_memory(document, error);
    norma_result failed =
        norma_face_normals(&mesh, &core, state->normals, state->facets, &summary->report);
    if (failed)
        result = norma_document_fail_core(document, error, failed);
    else
        summary->filled = fill(state, core.reasons, only);
    free(core.reasons);
    return result;
}

enum { BLOCK_FACETS = 1 << 10 };

typedef struct block_work {
    stl_state *state;
    norma_options core;
    unsigned char
        *failed; /* of each block: it could not be computed, or some facet has no direction */
} block_work;

/* A block of facets at a time, whose positions stay in the cache. */
static void compute_block(void *context, size_t block) {
    const block_work *work = context;
    stl_state *state = work->state;
    float positions[9 * BLOCK_FACETS];
    const size_t first = block * BLOCK_FACETS, left = state->facets - first,
                 count = left < BLOCK_FACETS ? left : BLOCK_FACETS;
    for (size_t i = 0; i < count; ++i) norma_stl_load(state, first + i, NULL, positions + 9 * i);
    const norma_mesh mesh = {
        .positions = {.data = positions, .count = 3 * count}, .corner_count = 3 * count};
    norma_report report;
    work->failed[block] = norma_face_normals(&mesh, &work->core, state->normals + 3 * first, count,
                              &report) != NORMA_OK ||
                          report.degenerate_faces.count > 0 || report.non_finite.count > 0;
    keep_stored(state, NORMA_ONLY_ALL, first, first + count);
}

/* *complete: 0 where some facet has no direction. */
static norma_document_result compute_by_blocks(norma_document *document,
    const norma_options *options, int *complete, norma_document_error *error) {
    stl_state *state = document->state;
    const size_t blocks = (state->facets + BLOCK_FACETS - 1) / BLOCK_FACETS;
    block_work work = {.state = state, .core = *options, .failed = norma_io_allocate(blocks, 1)};
    if (!work.failed) return norma_document_fail_memory(document, error);
    work.core.progress = NULL;
    work.core.threads = 0;
    norma_result failed = norma_io_tasks_told(options, blocks, compute_block, &work);
    *complete = !failed && memchr(work.failed, 1, blocks) == NULL;
    free(work.failed);
    return norma_document_fail_core(document, error, failed);
}

static norma_document_result compute_normals(norma_document *document,
    const norma_compute_options *options, norma_compute_summary *summary,
    norma_document_error *error) {
    stl_state *state = document->state;
    norma_options core;
    norma_options_of_compute(options, &core);
    state->normals = norma_io_block(state->facets, 3 * sizeof *state->normals);
    if (!state->normals) return norma_document_fail_memory(document, error);
    int complete = 0;
    norma_document_result result = NORMA_DOCUMENT_OK;
    if (state->binary && options->only == NORMA_ONLY_ALL) {
        result = compute_by_blocks(document, &core, &complete, error);
        core.progress = NULL; /* a fraction never falls */
    }
    if (!result && !complete)
        result = compute_whole(document, &core, options->only, summary, error);
    if (!result && !(complete && state->binary))
        keep_stored(state, options->only, 0, state->facets);
    return result;
}

norma_document_result norma_stl_compute(norma_document *document,
    const norma_compute_options *options, norma_compute_summary *summary,
    norma_document_error *error) {
    if (options->shading == NORMA_SHADING_SMOOTH || options->shading == NORMA_SHADING_CREASE)
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL,
            "STL holds one normal for each facet: smooth shading and creases cannot be stored; "
            "expected neither, or another format");
    norma_document_result result = norma_stl_flush_edits(document, error);
    if (result) return result;
    const stl_state *state = document->state;
    const norma_count none = {0, SIZE_MAX};
    summary->report = (norma_report){none, none, none, none, none, none};
    summary->faces = state->facets;
    summary->vertices_before = summary->vertices_after = 3 * state->facets;
    summary->shading = NORMA_SHADING_FLAT;
    if (state->facets == 0) return NORMA_DOCUMENT_OK;
    result = compute_normals(document, options, summary, error);
    return result ? result : norma_stl_drop_idle_edit(document, &summary->changed, error);
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
    norma_document_result result = norma_stl_flush_edits(document, error);
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
