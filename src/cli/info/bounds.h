/* bounds.h: the box that a file's surfaces fill. */
#ifndef NORMA_CLI_INFO_BOUNDS_H
#define NORMA_CLI_INFO_BOUNDS_H
#include <norma/document.h>

typedef struct info_bounds {
    int known; /* 0: no finite position, or too many instances to look at each vertex of each */
    double least[3], most[3];
} info_bounds;

/* Of the positions as they are drawn: of a glTF under the world matrices of the nodes, each
 * instance; without such nodes, and in other formats, as stored. Skins and morphs are left out. */
norma_document_result info_find_bounds(
    norma_document *document, info_bounds *bounds, norma_document_error *error);
#endif
