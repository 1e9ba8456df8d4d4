/* obj_edit.c: faces of an OBJ reversed, cut or left out, single vn and v lines with other numbers,
 * v lines that go and come: the text is written so and read anew. */
#include "io/format/edit.h"
#include "io/obj/vertex_lines.h"
#include "io/stream/sink.h"
#include <stdlib.h>
#include <string.h>

static void take_numbers(obj_state *state, const norma_mesh_edit *edit) {
    for (size_t i = 0; edit->set_normals && i < state->normal_count; ++i)
        if (edit->set_normals[i])
            memcpy(state->normals + 3 * i, edit->normals + 3 * i, 3 * sizeof *state->normals);
    for (size_t i = 0; edit->set_positions && i < state->position_count; ++i)
        if (edit->set_positions[i])
            memcpy(state->positions + 3 * i, edit->positions + 3 * i, 3 * sizeof *state->positions);
    state->normals_turned |= edit->set_normals != NULL;
    state->positions_moved |= edit->set_positions != NULL;
}

norma_document_result norma_obj_edit(
    norma_document *document, const norma_mesh_edit *edit, norma_document_error *error) {
    norma_document_result result = norma_edited_flush(document, error);
    if (result) return result;
    obj_state *state = document->state;
    if (edit->set_normals && !state->has_normals) /* there may be vn lines, but none that a face
                                                     names, so none that the caller was told of */
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL,
            "has no normals that could be replaced");
    result =
        edit->source_vertices ? norma_obj_edit_vertices(document, edit, error) : NORMA_DOCUMENT_OK;
    if (result) return result;
    take_numbers(state, edit);
    state->reverse_faces = edit->reverse_faces;
    state->drop_faces = edit->drop_faces;
    state->cut_faces = edit->cut_faces;
    state->cut_corners = edit->cut_corners;
    result = norma_edited_flush(document, error);
    state = document->state;
    if (result && state)
        state->reverse_faces = state->drop_faces = state->cut_faces = NULL; /* the caller's */
    return result;
}
