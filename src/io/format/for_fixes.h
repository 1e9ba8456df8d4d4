/* for_fixes.h: what norma check uses of documents besides their public functions: notes, the green
 * channel of normal maps turned (N812), a copy to try changes on, the instances of a tile, changes
 * that show. */
#ifndef NORMA_IO_FOR_FIXES_H
#define NORMA_IO_FOR_FIXES_H
#include <norma/document.h>

/* Usable, and nothing waits to be written: what cannot be is an error here, with its words, which
 * functions that only ask have none for. */
norma_document_result norma_document_ready(norma_document *document, norma_document_error *error);

/* Adds a note; 0 where memory is out (the note is then lost, nothing else). */
#if defined(__GNUC__)
__attribute__((format(printf, 2, 3)))
#endif
int norma_document_add_note(norma_document *document, const char *format, ...);

/* Of the materials of the marked meshes. What else shows the same texture or image keeps it: these
 * materials then get one of their own. A note tells of each image that stays as it is, and why.
 * changed: written. */
norma_document_result norma_document_turn_green(
    norma_document *document, const uint8_t *meshes, int *changed, norma_document_error *error);

/* A document that is read, leniently, from the bytes that the document would be written as; it is
 * not to be saved. To be closed. */
norma_document_result norma_document_copy(
    norma_document *document, norma_document **copy, norma_document_error *error);

/* After models of a composite (norma_document_tile) were changed by themselves. */
void norma_document_tiles_changed(norma_document *document);

/* How often a tile of 3D Tiles draws its whole scene turned or scaled (i3dm); 0: not at all.
 * matrix: of one of them, if there are so many; from the scene to the tile, whose z points up,
 * without the place. */
size_t norma_document_tile_instance(
    const norma_document *document, size_t index, double matrix[16]);
#endif
