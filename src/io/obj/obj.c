/* obj.c: OBJ as a document: one mesh, its positions as doubles, a normal for each corner that names
 * one. */
#include "io/obj/obj.h"
#include "io/obj/statements.h"
#include "io/format/edit.h"
#include "io/obj/vertex_lines.h"
#include "io/format/scene.h"
#include <stdlib.h>
#include <string.h>

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

/* mtllib statements, from the first one to the last. The word is searched for, since those between
 * are not remembered. */
static int visit_files(const norma_document *document, norma_visit_file *visit, void *user) {
    static const char word[] = "mtllib";
    const size_t length = sizeof word - 1;
    const obj_state *state = document->state;
    if (!state || state->first_library == SIZE_MAX) return 0;
    const char *text = (const char *)document->source.data, *at = text + state->first_library,
               *last = text + state->last_library, *end = text + document->source.size;
    int stop = 0;
    while (!stop && at <= last && (at = memchr(at, 'm', (size_t)(end - at)))) {
        const char *rest = at + length;
        if (end - at > (ptrdiff_t)length && memcmp(at, word, length) == 0 &&
            (*rest == ' ' || *rest == '\t')) {
            const char *stops = norma_obj_statement_end(rest, end, NULL);
            stop = norma_document_visit_names(document, rest, (size_t)(stops - rest), visit, user);
        }
        ++at;
    }
    return stop;
}

const format_functions norma_obj_functions = {.open = norma_edited_open,
    .close = norma_edited_close,
    .edited = &norma_obj_edited,
    .mesh_count = mesh_count,
    .mesh_info = mesh_info,
    .mesh_data = mesh_data,
    .compute = norma_obj_compute,
    .transform = norma_obj_transform,
    .edit = norma_obj_edit,
    .equal_vertices = norma_obj_equal_vertices,
    .write = norma_obj_write,
    .visit_files = visit_files,
    .scene = &norma_obj_scene};
