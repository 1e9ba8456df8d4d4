/* ply_transform.c: a PLY under a matrix: positions in their own types where those hold the result,
 * normals through the normal matrix, faces turned round under a mirror. */
#include "io/ply/ply.h"
#include "io/format/transform_stored_normals.h"
#include <float.h>
#include <stdlib.h>

/* ---- positions */

/* Whole numbers that do not hold the result become floats (32-bit ones doubles), and floats
 * doubles. */
static void choose_types(const ply_state *state, ply_edit *edit) {
    const ply_header *header = &state->header;
    const ply_element *vertex = norma_ply_element(header, header->vertex);
    int whole = 1, wide = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const ply_type type = norma_ply_property(header, vertex, header->position[axis])->type;
        edit->position_types[axis] = type;
        wide |= type == PLY_INT32 || type == PLY_UINT32;
        for (size_t i = 0; i < state->vertices && type < PLY_FLOAT && whole; ++i)
            whole = norma_ply_type_holds(type, edit->positions[3 * i + (size_t)axis]);
    }
    for (int axis = 0; axis < 3; ++axis) {
        if (edit->position_types[axis] < PLY_FLOAT && !whole)
            edit->position_types[axis] = wide ? PLY_DOUBLE : PLY_FLOAT;
        for (size_t i = 0; i < state->vertices && edit->position_types[axis] == PLY_FLOAT; ++i)
            if (!norma_ply_type_holds(PLY_FLOAT, edit->positions[3 * i + (size_t)axis]))
                edit->position_types[axis] = PLY_DOUBLE;
    }
}

/* Positions that are all written as floats become floats at once: rows take them as they lie. */
static norma_document_result narrow_positions(
    norma_document *document, ply_edit *edit, norma_document_error *error) {
    const size_t count = ((const ply_state *)document->state)->vertices;
    for (int axis = 0; axis < 3; ++axis)
        if (edit->position_types[axis] != PLY_FLOAT) return NORMA_DOCUMENT_OK;
    edit->float_positions = norma_io_allocate(count, 3 * sizeof *edit->float_positions);
    if (!edit->float_positions) return norma_document_fail_memory(document, error);
    for (size_t i = 0; i < 3 * count; ++i) edit->float_positions[i] = (float)edit->positions[i];
    free(edit->positions);
    edit->positions = NULL;
    return NORMA_DOCUMENT_OK;
}

static norma_document_result transform_positions(
    norma_document *document, const double matrix[16], norma_document_error *error) {
    ply_state *state = document->state;
    ply_edit *edit = &state->edit;
    edit->positions = norma_io_allocate(state->vertices, 3 * sizeof *edit->positions);
    if (!edit->positions) return norma_document_fail_memory(document, error);
    norma_result result = norma_transform_positions_double(
        matrix, state->mesh.positions, edit->positions, 0, state->vertices);
    if (result) return norma_document_fail_core(document, error, result);
    choose_types(state, edit);
    const norma_document_result told = norma_check_transformed_range(
        document, &state->mesh.positions, edit->positions, DBL_MAX, "vertex", 1, error);
    return told ? told : narrow_positions(document, edit, error);
}

/* ---- normals */

typedef struct carried_normals {
    float *normals;
    ply_type types[3];
} carried_normals;

static norma_document_result transform_column(norma_document *document,
    const normal_carrier *carrier, const ply_element *element, const int properties[3],
    carried_normals *carried, norma_document_error *error) {
    const ply_header *header = &((const ply_state *)document->state)->header;
    const size_t count = (size_t)element->count;
    double *stored = NULL;
    norma_document_result result =
        norma_ply_read_columns(document, element, properties, &stored, error);
    carried->normals = result ? NULL : norma_io_allocate(count, 3 * sizeof *carried->normals);
    if (!result && !carried->normals) result = norma_document_fail_memory(document, error);
    if (!result)
        result = norma_transform_stored_normals(
            document, carrier, stored, count, carried->normals, error);
    if (!result) {
        norma_ply_normal_types(header, element, properties, carried->types);
        result = norma_ply_encode_normals(document, carried->types, carried->normals, count, error);
    }
    free(stored);
    return result;
}

static norma_document_result transform_normals(
    norma_document *document, const normal_carrier *carrier, norma_document_error *error) {
    ply_state *state = document->state;
    const ply_header *header = &state->header;
    norma_document_result result = NORMA_DOCUMENT_OK;
    carried_normals carried = {0};
    if (header->normal[0] != PLY_NONE) {
        result = transform_column(document, carrier, norma_ply_element(header, header->vertex),
            header->normal, &carried, error);
        state->edit.normals = carried.normals;
        memcpy(state->edit.normal_types, carried.types, sizeof carried.types);
    }
    if (!result && header->face_normal[0] != PLY_NONE) {
        result = transform_column(document, carrier, norma_ply_element(header, header->face),
            header->face_normal, &carried, error);
        state->edit.face_normals = carried.normals;
        memcpy(state->edit.face_normal_types, carried.types, sizeof carried.types);
    }
    return result;
}

/* ---- faces */

static norma_document_result reverse_faces(norma_document *document, norma_document_error *error) {
    ply_state *state = document->state;
    const ply_mesh *mesh = &state->mesh;
    if (mesh->corner_count == 0) return NORMA_DOCUMENT_OK;
    uint32_t *corners = malloc(mesh->corner_count * sizeof *corners);
    if (!corners) return norma_document_fail_memory(document, error);
    state->edit.corners = corners;
    state->edit.reversed = 1;
    memcpy(corners, mesh->corners, mesh->corner_count * sizeof *corners);
    norma_result result = norma_reverse_winding(
        corners, sizeof *corners, mesh->corner_count, mesh->face_starts, mesh->face_count);
    return result ? norma_document_fail_core(document, error, result) : NORMA_DOCUMENT_OK;
}

norma_document_result norma_ply_transform(norma_document *document,
    const norma_transform_options *options, norma_transform_summary *summary,
    norma_document_error *error) {
    norma_document_result result = norma_edited_flush(document, error);
    if (result) return result;
    ply_state *state = document->state;
    summary->vertices = state->vertices;
    summary->meshes = 1;
    if (norma_stored_normals_is_identity(options->matrix)) return NORMA_DOCUMENT_OK;
    normal_carrier carrier;
    result = norma_stored_normals_begin(document, options, summary, &carrier, error);
    if (result) return result;
    result = transform_positions(document, options->matrix, error);
    if (!result) result = transform_normals(document, &carrier, error);
    if (!result && carrier.mirrored) result = reverse_faces(document, error);
    if (!result) result = norma_ply_drop_idle_edit(document, &summary->changed, error);
    return result ? result : norma_stored_normals_progress(document, options, 1, error);
}
