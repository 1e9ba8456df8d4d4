/* smooth_fans.h: positions whose faces are all one smooth fan, nearly all of most meshes: the sum
 * at the position is the normal of all corners there, and no star needs to be made. Each face is
 * measured once. */
#ifndef NORMA_CORE_SMOOTH_FANS_H
#define NORMA_CORE_SMOOTH_FANS_H
#include "core/vertex/position_bins.h"

typedef struct smooth_fans {
    uint8_t *others; /* 1 at the positions whose corners are left to stars, else 0; NULL: all are */
    uint8_t *chunks; /* of each chunk of faces: whether one has a corner there */
    size_t other_count;
    norma_edges edges; /* of the smooth fans, to positions of higher number; where counted */
} smooth_fans;

/* Writes the normals of the corners at such positions. ranges: of the chunks of faces, as the mesh
 * names positions; changed where positions are welded. */
norma_result norma_core_write_smooth_fans(core_prepared_mesh *prepared, core_range *ranges,
    const core_output *output, int counting, smooth_fans *fans);
void norma_core_release_smooth_fans(const core_prepared_mesh *prepared, smooth_fans *fans);
#endif
