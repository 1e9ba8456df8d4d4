/* obj_state.c: the state of an OBJ document: read, let go, and read again once its changes have
 * become bytes; and the core's view of it. */
#include "io/obj/vertex_lines.h"
#include <stdlib.h>

static void free_vertices(obj_vertices *v) {
    if (!v) return;
    free(v->kept_before);
    free(v->numbers);
    free(v->corners);
    free(v->lines);
    free(v);
}

static void free_content(void *content) {
    obj_state *state = content;
    free_vertices(state->vertices);
    free(state->stretches);
    free(state->positions);
    free(state->corners);
    free(state->corner_normals);
    free(state->face_starts);
    free(state->normals);
    free(state->normal_offsets);
    free(state->other_normals);
    free(state->runs);
    free(state->name);
    free(state->shown_normals);
    free(state->group_masks);
    free(state->hard_edges);
}

static int has_edit(const void *content) {
    const obj_state *state = content;
    return state->normals_replaced || state->normals_turned || state->positions_moved ||
           state->faces_reversed || state->reverse_faces || state->drop_faces || state->cut_faces ||
           state->vertices;
}

const edited_format norma_obj_edited = {
    sizeof(obj_state), 1, has_edit, free_content, norma_obj_read};

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
