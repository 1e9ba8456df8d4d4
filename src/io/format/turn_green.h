/* turn_green.h: the green channel of normal maps inverted, for the fix of N812. */
#ifndef NORMA_IO_TURN_GREEN_H
#define NORMA_IO_TURN_GREEN_H
#include "io/format/format.h"

/* Of the materials of the marked meshes. What else shows the same texture or image keeps it: these
 * materials then get one of their own. A note tells of each image that stays as it is, and why.
 * changed: written. */
norma_document_result norma_document_turn_green(
    norma_document *document, const uint8_t *meshes, int *changed, norma_document_error *error);

norma_document_result norma_gltf_turn_green(
    norma_document *document, const uint8_t *meshes, int *changed, norma_document_error *error);
#endif
