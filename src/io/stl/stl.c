/* stl.c: STL documents. The file's bytes stay as they are; new normals and vertices are kept beside
 * them until they are written, or until another change needs to see them: then they become the
 * document's bytes, which are read anew. */
#include "io/stl/stl.h"
#include "io/format/edit.h"
#include <stdlib.h>

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
    norma_document_result result = norma_edited_flush(document, error);
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

static norma_document_result write_stl(norma_document *document, const char *path,
    norma_write *write, void *user, norma_document_error *error) {
    (void)path;
    return norma_rewrite(document, write_body, write, user, error);
}

const format_functions norma_stl_functions = {
    .open = norma_edited_open,
    .close = norma_edited_close,
    .edited = &norma_stl_edited,
    .mesh_count = count_meshes,
    .mesh_info = describe_mesh,
    .mesh_data = give_mesh,
    .compute = norma_stl_compute,
    .transform = norma_stl_transform,
    .edit = norma_stl_edit,
    .write = write_stl,
};
