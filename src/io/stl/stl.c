/* stl.c: STL documents. The file's bytes stay as they are; new normals and vertices are kept beside
 * them until they are written, or until another change needs to see them: then they become the
 * document's bytes, which are read anew. */
#include "io/stl/stl.h"
#include "io/format/edit.h"
#include <stdlib.h>

static void free_state_content(stl_state *state) {
    free(state->own);
    free(state->name);
    free(state->positions);
    free(state->stored);
    free(state->normals);
    free(state->vertices);
    *state = (stl_state){0};
}

static norma_document_result read_bytes(norma_document *document, norma_document_error *error) {
    stl_state *state = document->state;
    state->binary = norma_stl_is_binary(state);
    norma_document_result result = state->binary ? norma_stl_read_binary(document, error)
                                                 : norma_stl_read_text(document, error);
    if (!result && state->facets > UINT32_MAX / 3)
        return norma_document_fail(
            document, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, NULL, "more than 1431655765 facets");
    return result;
}

static norma_document_result open_stl(norma_document *document, norma_document_error *error) {
    stl_state *state = norma_io_allocate(1, sizeof *state);
    if (!state) return norma_document_fail_memory(document, error);
    document->state = state;
    state->bytes = document->source.data;
    state->size = document->source.size;
    return read_bytes(document, error);
}

static void close_stl(norma_document *document) {
    if (!document->state) return;
    free_state_content(document->state);
    free(document->state);
    document->state = NULL;
}

norma_document_result norma_stl_decode(norma_document *document, norma_document_error *error) {
    const stl_state *state = document->state;
    if (state->positions) return NORMA_DOCUMENT_OK;
    return state->binary ? norma_stl_decode_binary(document, error)
                         : norma_stl_decode_text(document, error);
}

norma_mesh norma_stl_core_mesh(const stl_state *state) {
    const size_t corners = 3 * state->facets;
    return (norma_mesh){.positions = {.data = state->positions,
                            .count = corners,
                            .format = state->binary ? NORMA_FORMAT_FLOAT : NORMA_FORMAT_DOUBLE},
        .corner_count = corners};
}

/* ---- describing */

static size_t count_meshes(const norma_document *document) {
    (void)document;
    return 1;
}

static norma_document_result describe_mesh(
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

static norma_document_result give_mesh(
    norma_document *document, size_t index, norma_mesh_data *data, norma_document_error *error) {
    (void)index;
    norma_document_result result = norma_stl_flush_edits(document, error);
    if (!result) result = norma_stl_decode(document, error);
    if (result) return result;
    const stl_state *state = document->state;
    data->mesh = norma_stl_core_mesh(state);
    data->normals = (norma_vec3_view){
        .data = state->stored, .count = state->facets, .format = NORMA_FORMAT_FLOAT};
    return NORMA_DOCUMENT_OK;
}

/* ---- writing */

static norma_document_result write_changed(
    norma_document *document, norma_sink *sink, norma_document_error *error) {
    const stl_state *state = document->state;
    return state->binary ? norma_stl_write_binary(document, sink, error)
                         : norma_stl_write_text(document, sink, error);
}

static norma_document_result write_body(
    norma_document *document, norma_sink *sink, norma_document_error *error) {
    const stl_state *state = document->state;
    if (state->normals || state->vertices) return write_changed(document, sink, error);
    norma_sink_put(sink, state->bytes, state->size);
    return NORMA_DOCUMENT_OK;
}

norma_document_result norma_stl_write(norma_document *document, const char *path,
    norma_write *write, void *user, norma_document_error *error) {
    (void)path;
    return norma_rewrite(document, write_body, write, user, error);
}

norma_document_result norma_stl_take_bytes(
    norma_document *document, unsigned char *bytes, size_t size, norma_document_error *error) {
    stl_state *state = document->state;
    free_state_content(state);
    state->own = bytes;
    state->bytes = bytes;
    state->size = size;
    return norma_rewrite_read(document, read_bytes, error);
}

norma_document_result norma_stl_flush_edits(norma_document *document, norma_document_error *error) {
    const stl_state *state = document->state;
    if (!state->normals && !state->vertices) return NORMA_DOCUMENT_OK;
    unsigned char *bytes;
    size_t size;
    norma_document_result result = norma_rewrite_to_memory(document, &bytes, &size, error);
    return result ? result : norma_stl_take_bytes(document, bytes, size, error);
}

norma_document_result norma_stl_drop_idle_edit(
    norma_document *document, int *changed, norma_document_error *error) {
    stl_state *state = document->state;
    norma_document_result result =
        norma_rewrite_compare(document, state->bytes, state->size, changed, error);
    if (!*changed) {
        free(state->normals);
        free(state->vertices);
        state->normals = NULL;
        state->vertices = NULL;
    }
    return result;
}

const format_functions norma_stl_functions = {
    .open = open_stl,
    .close = close_stl,
    .mesh_count = count_meshes,
    .mesh_info = describe_mesh,
    .mesh_data = give_mesh,
    .compute = norma_stl_compute,
    .transform = norma_stl_transform,
    .edit = norma_stl_edit,
    .write = norma_stl_write,
};
