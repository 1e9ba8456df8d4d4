/* recentre.h: how far positions that lie far from their origin are moved, so that floats hold the
 * step and what becomes of them exactly. */
#ifndef NORMA_IO_RECENTRE_H
#define NORMA_IO_RECENTRE_H
#include "io/format/format.h"

typedef struct recentre_box {
    double low[3], high[3]; /* of finite positions */
} recentre_box;

recentre_box norma_recentre_empty(void);
void norma_recentre_add(recentre_box *box, const double position[3]);
/* What is to be taken from each position; 0 along an axis that is near. Whether there is anything.
 */
int norma_recentre_step(const recentre_box *box, double step[3]);

norma_document_result norma_gltf_recentre(
    norma_document *document, const uint8_t *meshes, int *changed, norma_document_error *error);
#endif
