/* edit.h: single faces and vectors of a document changed, for norma_document_edit. Each format has
 * a file of its own. */
#ifndef NORMA_IO_EDIT_H
#define NORMA_IO_EDIT_H
#include "io/format/format.h"

norma_document_result norma_obj_edit(
    norma_document *document, const norma_mesh_edit *edits, norma_document_error *error);
norma_document_result norma_ply_edit(
    norma_document *document, const norma_mesh_edit *edits, norma_document_error *error);
norma_document_result norma_stl_edit(
    norma_document *document, const norma_mesh_edit *edits, norma_document_error *error);
norma_document_result norma_gltf_edit(
    norma_document *document, const norma_mesh_edit *edits, norma_document_error *error);

static inline int norma_edit_has_faces(const norma_mesh_edit *edit) {
    return edit->reverse_faces || edit->drop_faces || edit->source_vertices;
}
static inline int norma_edit_says(const uint8_t *marks, size_t index) {
    return marks && marks[index];
}
#endif
