/* ply_edit.c: faces of a PLY reversed, cut into triangles or left out, normals and positions of
 * single vertices replaced, vertices listed anew: kept as changes beside the bytes, then made
 * bytes. */
#include "io/format/edit.h"
#include "io/ply/ply.h"
#include <stdlib.h>
#include <string.h>

static uint8_t *copy_marks(const uint8_t *marks, size_t count) {
    uint8_t *copy = norma_io_allocate(count, 1);
    if (copy && count) memcpy(copy, marks, count);
    return copy;
}

/* Where the values of a vertex of the edit lie among those of a change: by old rows, added ones
 * behind them. */
static size_t place_of(
    const ply_state *state, const norma_mesh_edit *edit, size_t kept, size_t vertex) {
    if (!edit->source_vertices) return vertex;
    return vertex < kept ? edit->source_vertices[vertex] : state->vertices + vertex - kept;
}

static size_t vertex_count(const ply_state *state, const norma_mesh_edit *edit) {
    return edit->source_vertices ? edit->vertex_count : state->vertices;
}

/* Three properties of each vertex as stored, those of the added ones behind them. */
static norma_document_result read_columns(norma_document *document, const int properties[3],
    double **values, norma_document_error *error) {
    const ply_state *state = document->state;
    const size_t count = state->vertices, added = state->edit.added_count;
    norma_document_result result = norma_ply_read_columns(document,
        norma_ply_element(&state->header, state->header.vertex), properties, values, error);
    if (result || added == 0) return result;
    double *grown = count > SIZE_MAX / (6 * sizeof *grown) || added > SIZE_MAX / (6 * sizeof *grown)
                        ? NULL
                        : realloc(*values, 3 * (count + added) * sizeof *grown);
    if (!grown) return norma_document_fail_memory(document, error);
    *values = grown;
    for (size_t i = 0; i < added; ++i)
        memcpy(
            grown + 3 * (count + i), grown + 3 * (size_t)state->edit.added[i], 3 * sizeof *grown);
    return NORMA_DOCUMENT_OK;
}

/* As stored, with codes for the new ones. */
static norma_document_result edit_normals(
    norma_document *document, const norma_mesh_edit *edit, norma_document_error *error) {
    ply_state *state = document->state;
    const ply_element *vertex = norma_ply_element(&state->header, state->header.vertex);
    ply_edit *change = &state->edit;
    double *values = NULL;
    const size_t count = vertex_count(state, edit),
                 kept = edit->source_vertices ? norma_ply_kept(edit) : count;
    float *codes = norma_io_allocate(count, 3 * sizeof *codes);
    norma_document_result result =
        codes ? read_columns(document, state->header.normal, &values, error)
              : norma_document_fail_memory(document, error);
    if (!result) {
        norma_ply_normal_types(&state->header, vertex, state->header.normal, change->normal_types);
        for (size_t i = 0; i < count; ++i)
            if (norma_edit_says(edit->set_normals, i))
                memcpy(codes + 3 * i, edit->normals + 3 * i, 3 * sizeof *codes);
        result = norma_ply_encode_normals(document, change->normal_types, codes, count, error);
    }
    for (size_t i = 0; !result && i < count; ++i)
        for (size_t axis = 0; axis < 3 && norma_edit_says(edit->set_normals, i); ++axis)
            values[3 * place_of(state, edit, kept, i) + axis] = (double)codes[3 * i + axis];
    free(codes);
    if (result)
        free(values);
    else
        change->stored_normals = values;
    return result;
}

static norma_document_result edit_positions(
    norma_document *document, const norma_mesh_edit *edit, norma_document_error *error) {
    ply_state *state = document->state;
    const ply_element *vertex = norma_ply_element(&state->header, state->header.vertex);
    const size_t count = vertex_count(state, edit),
                 kept = edit->source_vertices ? norma_ply_kept(edit) : count;
    norma_document_result result =
        read_columns(document, state->header.position, &state->edit.positions, error);
    for (int axis = 0; axis < 3; ++axis)
        state->edit.position_types[axis] =
            norma_ply_property(&state->header, vertex, state->header.position[axis])->type;
    for (size_t i = 0; !result && i < count; ++i)
        if (norma_edit_says(edit->set_positions, i))
            memcpy(state->edit.positions + 3 * place_of(state, edit, kept, i),
                edit->positions + 3 * i, 3 * sizeof(double));
    return result;
}

/* Of the polygons alone: a strip has no other faces than triangles. */
static norma_document_result cut_faces(
    norma_document *document, const norma_mesh_edit *edit, norma_document_error *error) {
    ply_state *state = document->state;
    const ply_mesh *mesh = &state->mesh;
    ply_edit *change = &state->edit;
    if (mesh->polygon_corners == 0) return NORMA_DOCUMENT_OK;
    change->cut_rows = copy_marks(edit->cut_faces, mesh->polygon_count);
    change->cut_corners = norma_io_allocate(mesh->polygon_corners, 3 * sizeof *change->cut_corners);
    if (!change->corners)
        change->corners = norma_io_allocate(mesh->corner_count, sizeof *change->corners);
    if (!change->cut_rows || !change->cut_corners || !change->corners)
        return norma_document_fail_memory(document, error);
    memcpy(change->corners, edit->source_vertices ? edit->new_corners : mesh->corners,
        mesh->corner_count * sizeof *change->corners);
    for (size_t face = 0; face < mesh->polygon_count; ++face) {
        const size_t begin = mesh->face_starts ? mesh->face_starts[face] : 3 * face,
                     count = mesh->face_starts ? mesh->face_starts[face + 1] - begin : 3;
        change->cut_rows[face] = change->cut_rows[face] && count > 3;
        for (size_t i = 0; change->cut_rows[face] && i < 3 * (count - 2); ++i) {
            if (edit->cut_corners[3 * begin + i] >= count)
                return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL,
                    "a triangle of face %zu was given a corner that the face does not have", face);
            change->cut_corners[3 * begin + i] = edit->cut_corners[3 * begin + i];
        }
    }
    return NORMA_DOCUMENT_OK;
}

static norma_document_result edit_faces(
    norma_document *document, const norma_mesh_edit *edit, norma_document_error *error) {
    ply_state *state = document->state;
    const ply_mesh *mesh = &state->mesh;
    ply_edit *change = &state->edit;
    const uint32_t *corners = edit->source_vertices ? edit->new_corners : mesh->corners;
    if (edit->drop_faces &&
        !(change->dropped_rows = copy_marks(edit->drop_faces, mesh->face_count)))
        return norma_document_fail_memory(document, error);
    const int makes_strips =
        edit->drop_faces && mesh->polygon_count < mesh->face_count && !change->corners;
    if (makes_strips || edit->reverse_faces)
        change->corners = change->corners
                              ? change->corners
                              : norma_io_allocate(mesh->corner_count, sizeof *change->corners);
    if (makes_strips && change->corners)
        memcpy(change->corners, corners, mesh->corner_count * sizeof *change->corners);
    if (!edit->reverse_faces)
        return change->corners || !makes_strips ? NORMA_DOCUMENT_OK
                                                : norma_document_fail_memory(document, error);
    change->reversed_rows = copy_marks(edit->reverse_faces, mesh->polygon_count);
    if (!change->corners || !change->reversed_rows)
        return norma_document_fail_memory(document, error);
    change->reversed = 1;
    if (mesh->corner_count == 0) /* faces without a list of corners */
        return NORMA_DOCUMENT_OK;
    memcpy(change->corners, corners, mesh->corner_count * sizeof *change->corners);
    for (size_t face = 0; face < mesh->face_count; ++face) {
        size_t begin = mesh->face_starts ? mesh->face_starts[face] : 3 * face,
               end = mesh->face_starts ? mesh->face_starts[face + 1] : begin + 3;
        for (size_t i = begin + 1; edit->reverse_faces[face] && i < end; ++i)
            change->corners[i] = corners[end + begin - i];
    }
    return NORMA_DOCUMENT_OK;
}

norma_document_result norma_ply_edit(
    norma_document *document, const norma_mesh_edit *edit, norma_document_error *error) {
    norma_document_result result = norma_edited_flush(document, error);
    ply_state *state = document->state;
    if (!result && edit->set_normals && state->header.normal[0] == PLY_NONE)
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL,
            "has no normals that could be replaced");
    if (!result && edit->source_vertices) result = norma_ply_edit_vertices(document, edit, error);
    if (!result && edit->set_normals) result = edit_normals(document, edit, error);
    if (!result && edit->set_positions) result = edit_positions(document, edit, error);
    if (!result && edit->cut_faces)
        result = edit->reverse_faces
                     ? norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL,
                           "faces cannot be cut and reversed at once; do one after the other")
                     : cut_faces(document, edit, error);
    if (!result && (edit->reverse_faces || edit->drop_faces))
        result = edit_faces(document, edit, error);
    return result ? result : norma_edited_flush(document, error);
}
