/* vertex_rows.c: vertices of a PLY as a list of copies of old ones: rows that stay or go, further
 * ones behind them; and which rows are equal. */
#include "io/format/edit.h"
#include "io/stream/equal_rows.h"
#include "io/ply/ply.h"
#include <stdlib.h>
#include <string.h>

/* Elements other than those that are read (edges, say) may name vertices by their numbers. */
static int names_vertices(const ply_state *state) {
    const ply_header *header = &state->header;
    for (size_t i = 0; i < header->element_count; ++i)
        if ((int)i != header->vertex && (int)i != header->face && (int)i != header->strips &&
            header->elements[i].count > 0)
            return 1;
    return 0;
}

/* ---- equal ones */

typedef struct span_rows {
    const unsigned char *bytes;
    const ply_span *spans;
} span_rows;

static const unsigned char *row_of(const void *context, size_t row, size_t *length) {
    const span_rows *rows = context;
    *length = rows->spans[row].length;
    return rows->bytes + rows->spans[row].offset;
}

norma_document_result norma_ply_equal_vertices(
    norma_document *document, size_t mesh, uint32_t *first, norma_document_error *error) {
    norma_document_result result = norma_edited_flush(document, error);
    const ply_state *state = document->state;
    ply_span *spans = NULL;
    (void)mesh;
    if (!result && names_vertices(state)) {
        for (size_t v = 0; v < state->vertices; ++v) first[v] = (uint32_t)v;
        return NORMA_DOCUMENT_OK;
    }
    if (!result)
        result = norma_ply_row_spans(
            document, norma_ply_element(&state->header, state->header.vertex), &spans, error);
    const span_rows rows = {state->bytes, spans};
    if (!result && !norma_equal_rows(row_of, &rows, state->vertices, first))
        result = norma_document_fail_memory(document, error);
    free(spans);
    return result;
}

/* ---- copies */

size_t norma_ply_kept(const norma_mesh_edit *edit) {
    size_t kept = edit->vertex_count > 0;
    while (
        kept < edit->vertex_count && edit->source_vertices[kept] > edit->source_vertices[kept - 1])
        ++kept;
    return kept;
}

norma_document_result norma_ply_edit_vertices(
    norma_document *document, const norma_mesh_edit *edit, norma_document_error *error) {
    ply_state *state = document->state;
    ply_edit *change = &state->edit;
    const size_t kept = norma_ply_kept(edit), added = edit->vertex_count - kept;
    if (kept < state->vertices && names_vertices(state))
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, NULL,
            "cannot renumber vertices: an element that is not read may refer to them");
    change->corners = norma_io_allocate(state->mesh.corner_count, sizeof *change->corners);
    change->added = norma_io_allocate(added, sizeof *change->added);
    if (!change->corners || !change->added) return norma_document_fail_memory(document, error);
    if (state->mesh.corner_count)
        memcpy(
            change->corners, edit->new_corners, state->mesh.corner_count * sizeof *change->corners);
    if (added) memcpy(change->added, edit->source_vertices + kept, added * sizeof *change->added);
    change->added_count = added;
    if (kept == state->vertices) return NORMA_DOCUMENT_OK;
    change->dropped_vertices = norma_io_allocate(state->vertices, 1);
    if (!change->dropped_vertices) return norma_document_fail_memory(document, error);
    memset(change->dropped_vertices, 1, state->vertices);
    for (size_t v = 0; v < kept; ++v) change->dropped_vertices[edit->source_vertices[v]] = 0;
    return NORMA_DOCUMENT_OK;
}
