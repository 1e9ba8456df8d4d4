/* ply_state.c: the state of a PLY document: read, let go, and read again once its changes have
 * become bytes. */
#include "io/ply/ply.h"
#include <stdlib.h>

static void free_content(void *content) {
    ply_state *state = content;
    norma_ply_free_edit(&state->edit);
    norma_ply_free_mesh(&state->mesh);
    free(state->normals);
    free(state->header.elements);
    free(state->header.properties);
}

static int has_edit(const void *state) { return norma_ply_has_edit(state); }

static norma_document_result read_source(norma_document *document, norma_document_error *error) {
    ply_state *state = document->state;
    state->bytes = document->source.data;
    state->size = document->source.size;
    norma_document_result result = norma_ply_read_header(document, error);
    if (!result) result = norma_ply_locate(document, error);
    return result ? result : norma_ply_read_mesh(document, error);
}

const edited_format norma_ply_edited = {sizeof(ply_state), 0, has_edit, free_content, read_source};
