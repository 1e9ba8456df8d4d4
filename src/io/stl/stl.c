/* stl.c: STL documents: opened, read again, computed, transformed and written. */
#include "io/stl/stl.h"
#include "io/text/text.h"
#include <float.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- The state of an STL document: read, decoded, let go, and read again once its changes
 * have become bytes. */

static void stl_forget_edit(void *content) {
    stl_state *state = content;
    free(state->normals);
    free(state->vertices);
    state->normals = NULL;
    state->vertices = NULL;
}

static void stl_free_content(void *content) {
    stl_state *state = content;
    free(state->name);
    free(state->positions);
    free(state->stored);
    stl_forget_edit(state);
}

static int stl_has_edit(const void *content) {
    const stl_state *state = content;
    return state->normals || state->vertices;
}

static norma_document_result stl_read_source(
    norma_document *document, norma_document_error *error) {
    stl_state *state = document->state;
    state->bytes = document->source.data;
    state->size = document->source.size;
    state->binary = norma_stl_is_binary(state);
    norma_document_result result = state->binary ? norma_stl_read_binary(document, error)
                                                 : norma_stl_read_text(document, error);
    if (!result && state->facets > UINT32_MAX / 3)
        return norma_document_fail(
            document, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, NULL, "more than 1431655765 facets");
    return result;
}

static norma_document_result stl_write_changed(
    norma_document *document, norma_sink *sink, norma_document_error *error) {
    const stl_state *state = document->state;
    return state->binary ? norma_stl_write_binary(document, sink, error)
                         : norma_stl_write_text(document, sink, error);
}

static const edited_format STL_EDITED = {sizeof(stl_state), 0, stl_has_edit, stl_free_content,
    stl_read_source, stl_write_changed, stl_forget_edit};

static norma_document_result stl_decode(norma_document *document, norma_document_error *error) {
    const stl_state *state = document->state;
    if (state->positions) return NORMA_DOCUMENT_OK;
    return state->binary ? norma_stl_decode_binary(document, error)
                         : norma_stl_decode_text(document, error);
}

static void stl_forget_decoded(stl_state *state) {
    free(state->positions);
    free(state->stored);
    state->positions = NULL;
    state->stored = NULL;
}

static norma_mesh stl_core_mesh(const stl_state *state) {
    const size_t corners = 3 * state->facets;
    return (norma_mesh){.positions = {.data = state->positions,
                            .count = corners,
                            .format = state->binary ? NORMA_FORMAT_FLOAT : NORMA_FORMAT_DOUBLE},
        .corner_count = corners};
}

/* ---- Facet normals from the winding, and an STL under a matrix. */

/* ---- computing */

/* Puts the stored normals back where they are not to change, and the sign of zeros, which says
 * nothing. */
static void stl_keep_stored(stl_state *state, norma_only only) {
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
    norma_document_result result = stl_decode(document, error);
    uint8_t *wanted = norma_io_allocate(state->facets, 1);
    if (!result && !wanted) result = norma_document_fail_memory(document, error);
    for (size_t i = 0; !result && i < state->facets; ++i)
        wanted[i] = (uint8_t)norma_policy_wants_facet(only, state->stored + 3 * i);
    const norma_mesh mesh = stl_core_mesh(state);
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
    if (norma_face_normals(&mesh, &work->core, normals, count, &report) ||
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
    stl_forget_decoded(state);
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
    stl_keep_stored(state, only);
    result = norma_edited_drop_idle(document, &policy->summary->changed, error);
    policy->summary->changed |= changed;
    return result;
}

norma_document_result norma_stl_check_shading(const norma_document *document,
    const norma_compute_options *options, norma_document_error *error) {
    if (options->shading == NORMA_SHADING_DEFAULT || options->shading == NORMA_SHADING_FLAT)
        return NORMA_DOCUMENT_OK;
    return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL,
        "STL holds one normal for each facet: smooth shading and creases cannot be stored; use "
        "neither, or another format");
}

static norma_document_result stl_compute(norma_document *document,
    const norma_compute_options *options, norma_compute_summary *summary,
    norma_document_error *error) {
    norma_document_result result = norma_stl_check_shading(document, options, error);
    if (!result) result = norma_edited_flush(document, error);
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
    const norma_mesh mesh = stl_core_mesh(state);
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

static norma_document_result stl_transform_normals(
    norma_document *document, const normal_mapping *mapping, norma_document_error *error) {
    stl_state *state = document->state;
    const size_t numbers = 3 * state->facets;
    double *stored = norma_io_allocate(numbers, sizeof *stored);
    state->normals = norma_io_allocate(numbers, sizeof *state->normals);
    norma_document_result result =
        stored && state->normals ? NORMA_DOCUMENT_OK : norma_document_fail_memory(document, error);
    for (size_t i = 0; i < numbers && !result; ++i) stored[i] = (double)state->stored[i];
    if (!result)
        result = norma_transform_stored_normals(
            document, mapping, stored, state->facets, state->normals, error);
    free(stored);
    return result;
}

static norma_document_result stl_transform(norma_document *document,
    const norma_transform_options *options, norma_transform_summary *summary,
    norma_document_error *error) {
    norma_document_result result = norma_edited_flush(document, error);
    if (result) return result;
    summary->vertices = 3 * ((const stl_state *)document->state)->facets;
    summary->meshes = 1;
    if (norma_matrix_is_identity(options->matrix)) return NORMA_DOCUMENT_OK;
    normal_mapping mapping;
    result = norma_stored_normals_begin(document, options, summary, &mapping, error);
    if (result) return result;
    result = stl_decode(document, error);
    if (!result) result = transform_vertices(document, options->matrix, mapping.mirrored, error);
    if (!result) result = stl_transform_normals(document, &mapping, error);
    if (!result) result = norma_edited_drop_idle(document, &summary->changed, error);
    return result ? result : norma_stored_normals_progress(document, options, 1, error);
}

/* ---- editing */

static norma_document_result stl_edit(
    norma_document *document, const norma_mesh_edit *edit, norma_document_error *error) {
    growing_bytes memory = {0};
    norma_document_result result = NORMA_DOCUMENT_OK;
    const stl_state *state = document->state;
    norma_sink *sink = norma_sink_create(norma_memory_sink_write, &memory);
    if (!sink) return norma_document_fail_memory(document, error);
    if (edit->reverse_faces && edit->set_positions)
        result = norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL,
            "facets cannot be reversed and moved at once; do one after the other");
    else if (state->binary)
        norma_stl_edit_binary(state, edit, sink);
    else
        result = norma_stl_edit_text(document, edit, sink, error);
    int failed = norma_sink_finish(sink);
    if (!result && failed) result = norma_document_fail_memory(document, error);
    if (!result) return norma_edited_replace(document, &memory, error);
    free(memory.data);
    return result;
}

/* ---- STL documents. The file's bytes stay as they are; new normals and vertices are kept beside
 * them until they are written, or until another change needs to see them: then they become the
 * document's bytes, which are read anew. */

/* ---- describing */

static norma_document_result stl_describe_mesh(
    const norma_document *document, size_t index, norma_mesh_info *info) {
    const stl_state *state = document->state;
    (void)index;
    info->name = state->name ? state->name : "";
    info->vertices = 3 * state->facets;
    info->faces = info->triangles = state->facets;
    info->normals = NORMA_NORMALS_PER_FACET;
    info->encoding = state->binary ? "float" : "text";
    return NORMA_DOCUMENT_OK;
}

static norma_document_result stl_give_mesh(
    norma_document *document, size_t index, norma_mesh_data *data, norma_document_error *error) {
    (void)index;
    const norma_document_result result = stl_decode(document, error);
    if (result) return result;
    const stl_state *state = document->state;
    data->mesh = stl_core_mesh(state);
    data->normals = (norma_vec3_view){
        .data = state->stored, .count = state->facets, .format = NORMA_FORMAT_FLOAT};
    return NORMA_DOCUMENT_OK;
}

static norma_document_result stl_read_unread(
    norma_document *document, norma_document_error *error) {
    const stl_state *state = document->state;
    char *texts = norma_scene_allocate(document->scene, 2, sizeof(char[120]));
    if (!texts) return norma_document_fail_memory(document, error);
    norma_unread *unread = norma_scene_tell_unread(document, state->tail > 0, error);
    if (!unread) return NORMA_DOCUMENT_ERROR_MEMORY;
    if (state->tail) {
        snprintf(texts, 120, "byte %zu", state->tail);
        const size_t size = state->size - state->tail;
        const int length =
            snprintf(texts + 120, 120, "%zu %s the %zu facets that the header declares", size,
                size == 1 ? "byte follows" : "bytes follow", state->facets);
        if (size >= STL_FACET)
            snprintf(texts + 120 + length, 120 - (size_t)length, "; they may be %zu more",
                size / STL_FACET);
        *unread = (norma_unread){texts, texts + 120};
    }
    return NORMA_DOCUMENT_OK;
}

static const scene_functions STL_SCENE = {.unread = stl_read_unread};

const format_functions norma_stl_functions = {
    .open = norma_edited_open,
    .close = norma_edited_close,
    .edited = &STL_EDITED,
    .mesh_count = norma_edited_mesh_count,
    .mesh_info = stl_describe_mesh,
    .mesh_data = stl_give_mesh,
    .scene = &STL_SCENE,
    .compute = stl_compute,
    .transform = stl_transform,
    .edit = stl_edit,
    .write = norma_edited_write,
};
