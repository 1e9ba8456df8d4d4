/* obj.c: OBJ as a document: one mesh, its positions as doubles, a normal for each corner that names
 * one. */
#include "io/obj/obj.h"
#include "io/format/edit.h"
#include "io/obj/vertex_lines.h"
#include "io/format/flush_edits.h"
#include "io/format/scene.h"
#include <stdlib.h>

static norma_document_result open_obj(norma_document *document, norma_document_error *error) {
    obj_state *state = norma_io_allocate(1, sizeof *state);
    if (!state) return norma_document_fail_memory(document, error);
    document->state = state;
    return norma_obj_read(document, state, error);
}

static void close_obj(norma_document *document) {
    obj_state *state = document->state;
    if (!state) return;
    norma_obj_free(state);
    free(state);
    document->state = NULL;
}

static norma_document_result read_anew(norma_document *document, norma_document_error *error) {
    return norma_obj_read(document, document->state, error);
}

norma_document_result norma_obj_flush_edits(norma_document *document, norma_document_error *error) {
    obj_state *state = document->state;
    unsigned char *bytes;
    size_t size;
    if (!norma_obj_has_change(state)) return NORMA_DOCUMENT_OK;
    norma_document_result result = norma_rewrite_to_memory(document, &bytes, &size, error);
    if (result) return result;
    norma_obj_free(state);
    *state = (obj_state){0};
    norma_file_close(&document->source);
    document->source = (file_bytes){.data = bytes, .size = size, .owned = 1};
    return norma_rewrite_read(document, read_anew, error);
}

static size_t mesh_count(const norma_document *document) {
    (void)document;
    return 1;
}

static norma_document_result mesh_info(
    const norma_document *document, size_t index, norma_mesh_info *info) {
    const obj_state *state = document->state;
    (void)index;
    info->name = state->name ? state->name : "";
    info->vertices = state->position_count;
    info->faces = state->face_count;
    info->triangles = state->corner_count - 2 * state->face_count;
    info->normals = state->has_normals ? NORMA_NORMALS_PER_CORNER : NORMA_NORMALS_NONE;
    info->encoding = state->has_normals ? "text" : "";
    info->has_smoothing_groups = state->has_groups;
    return NORMA_DOCUMENT_OK;
}

norma_mesh norma_obj_mesh(const obj_state *state) {
    static const double nowhere[3];
    static const uint32_t nothing[1];
    const norma_vec3_view positions = {state->positions ? state->positions : nowhere,
        state->position_count, 0, NORMA_FORMAT_DOUBLE};
    return (norma_mesh){.positions = positions,
        .corners = state->corners ? state->corners : nothing,
        .corner_count = state->corner_count,
        .face_starts = state->face_starts,
        .face_count = state->face_count};
}

/* Normals that are not there are shown as none. */
static const uint32_t *shown_normals(obj_state *state) {
    if (!state->bad_normal_count) return state->corner_normals;
    if (!state->shown_normals)
        state->shown_normals = norma_io_allocate(state->corner_count, sizeof *state->shown_normals);
    for (size_t i = 0; state->shown_normals && i < state->corner_count; ++i)
        state->shown_normals[i] =
            state->corner_normals[i] == OBJ_BAD_NORMAL ? OBJ_NO_NORMAL : state->corner_normals[i];
    return state->shown_normals;
}

static norma_document_result mesh_data(
    norma_document *document, size_t index, norma_mesh_data *data, norma_document_error *error) {
    obj_state *state = document->state;
    (void)index;
    data->mesh = norma_obj_mesh(state);
    if (state->has_groups) {
        const norma_options options = {.struct_size = sizeof options};
        norma_result result = norma_obj_groups(state, &options);
        if (result) return norma_document_fail_core(document, error, result);
        data->mesh.smoothing_groups = state->group_masks;
        data->mesh.hard_edges = state->hard_edges;
    }
    if (state->has_normals) {
        data->normals =
            (norma_vec3_view){state->normals, state->normal_count, 0, NORMA_FORMAT_FLOAT};
        data->corner_normals = shown_normals(state);
        if (!data->corner_normals) return norma_document_fail_memory(document, error);
    }
    return NORMA_DOCUMENT_OK;
}

const format_functions norma_obj_functions = {.open = open_obj,
    .close = close_obj,
    .mesh_count = mesh_count,
    .mesh_info = mesh_info,
    .mesh_data = mesh_data,
    .compute = norma_obj_compute,
    .transform = norma_obj_transform,
    .edit = norma_obj_edit,
    .equal_vertices = norma_obj_equal_vertices,
    .write = norma_obj_write,
    .scene = &norma_obj_scene};
