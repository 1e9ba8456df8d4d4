/* stl_state.c: the state of an STL document: read, decoded, let go, and read again once its changes
 * have become bytes. */
#include "io/stl/stl.h"
#include <stdlib.h>

static void free_content(void *content) {
    stl_state *state = content;
    free(state->name);
    free(state->positions);
    free(state->stored);
    free(state->normals);
    free(state->vertices);
}

static int has_edit(const void *content) {
    const stl_state *state = content;
    return state->normals || state->vertices;
}

static norma_document_result read_source(norma_document *document, norma_document_error *error) {
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

const edited_format norma_stl_edited = {sizeof(stl_state), 0, has_edit, free_content, read_source};

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

norma_document_result norma_stl_decode(norma_document *document, norma_document_error *error) {
    const stl_state *state = document->state;
    if (state->positions) return NORMA_DOCUMENT_OK;
    return state->binary ? norma_stl_decode_binary(document, error)
                         : norma_stl_decode_text(document, error);
}

void norma_stl_forget_decoded(stl_state *state) {
    free(state->positions);
    free(state->stored);
    state->positions = NULL;
    state->stored = NULL;
}

norma_mesh norma_stl_core_mesh(const stl_state *state) {
    const size_t corners = 3 * state->facets;
    return (norma_mesh){.positions = {.data = state->positions,
                            .count = corners,
                            .format = state->binary ? NORMA_FORMAT_FLOAT : NORMA_FORMAT_DOUBLE},
        .corner_count = corners};
}
