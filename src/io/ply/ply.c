/* ply.c: PLY documents. The file's bytes stay as they are; what compute and transform change is
 * kept beside them until it is written, or until another change needs to see it: then it becomes
 * the document's bytes, which are read anew. */
#include "io/ply/ply.h"
#include "io/format/edit.h"
#include "io/format/scene.h"
#include <stdlib.h>
#include <string.h>

static size_t count_meshes(const norma_document *document) {
    (void)document;
    return 1;
}

static const char *encoding_of(const ply_state *state) {
    const ply_header *header = &state->header;
    const ply_element *vertex = norma_ply_element(header, header->vertex);
    if (header->encoding == PLY_ASCII) return "text";
    const ply_type first = norma_ply_property(header, vertex, header->normal[0])->type;
    for (int axis = 1; axis < 3; ++axis)
        if (norma_ply_property(header, vertex, header->normal[axis])->type != first) return "mixed";
    return first == PLY_INT8    ? "snorm8"
           : first == PLY_INT16 ? "snorm16"
                                : norma_ply_type_name(first, first < PLY_FLOAT);
}

static norma_document_result describe_mesh(
    const norma_document *document, size_t index, norma_mesh_info *info) {
    ply_state *state = document->state;
    (void)index;
    info->vertices = state->vertices + state->edit.added_count;
    info->faces = state->faces;
    info->triangles = state->triangles;
    if (state->header.normal[0] != PLY_NONE) {
        info->normals = NORMA_NORMALS_PER_VERTEX;
        info->encoding = encoding_of(state);
    } else if (state->edit.normals || state->edit.stored_normals) {
        info->normals = NORMA_NORMALS_PER_VERTEX;
        info->encoding = state->header.encoding == PLY_ASCII ? "text" : "float";
    }
    return NORMA_DOCUMENT_OK;
}

/* As floats of unit length where whole codes stand for fractions. */
static norma_document_result decode_normals(norma_document *document, norma_document_error *error) {
    ply_state *state = document->state;
    const ply_element *vertex = norma_ply_element(&state->header, state->header.vertex);
    double *values = NULL;
    norma_document_result result =
        norma_ply_read_columns(document, vertex, state->header.normal, &values, error);
    const size_t count = 3 * state->vertices;
    state->normals = result || count > SIZE_MAX / sizeof(float)
                         ? NULL
                         : norma_io_allocate(count, sizeof *state->normals);
    if (state->normals) {
        const double scale = norma_ply_normal_scale(&state->header, vertex, state->header.normal);
        for (size_t i = 0; i < count; ++i)
            state->normals[i] = norma_ply_normal_value(values[i], scale);
    } else if (!result) {
        result = norma_document_fail_memory(document, error);
    }
    free(values);
    return result;
}

static norma_document_result give_mesh(
    norma_document *document, size_t index, norma_mesh_data *data, norma_document_error *error) {
    (void)index;
    norma_document_result result = norma_edited_flush(document, error);
    ply_state *state = document->state;
    if (!result && !state->normals && state->header.normal[0] != PLY_NONE)
        result = decode_normals(document, error);
    if (result) return result;
    data->mesh = norma_ply_core_mesh(state);
    if (state->normals)
        data->normals = (norma_vec3_view){
            .data = state->normals, .count = state->vertices, .format = NORMA_FORMAT_FLOAT};
    return NORMA_DOCUMENT_OK;
}

/* "comment TextureFile NAME" in the header, as MeshLab and others write it. */
static int visit_files(const norma_document *document, norma_visit_file *visit, void *user) {
    static const char word[] = "comment TextureFile ", last[] = "end_header";
    const char *at = (const char *)document->source.data, *end = at + document->source.size;
    int stop = 0;
    while (at < end && !stop) {
        const char *line_end = memchr(at, '\n', (size_t)(end - at)), *stops = line_end;
        if (!line_end || strncmp(at, last, sizeof last - 1) == 0) break;
        if (stops > at && stops[-1] == '\r') --stops;
        if ((size_t)(stops - at) > sizeof word - 1 && memcmp(at, word, sizeof word - 1) == 0)
            stop = norma_document_visit_names(document, at + sizeof word - 1,
                (size_t)(stops - at) - (sizeof word - 1), visit, user);
        at = line_end + 1;
    }
    return stop;
}

const format_functions norma_ply_functions = {
    .open = norma_edited_open,
    .close = norma_edited_close,
    .edited = &norma_ply_edited,
    .mesh_count = count_meshes,
    .mesh_info = describe_mesh,
    .mesh_data = give_mesh,
    .compute = norma_ply_compute,
    .transform = norma_ply_transform,
    .edit = norma_ply_edit,
    .equal_vertices = norma_ply_equal_vertices,
    .write = norma_ply_write,
    .visit_files = visit_files,
    .scene = &norma_ply_scene,
};
