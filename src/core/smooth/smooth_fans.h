/* smooth_fans.h: positions whose faces are all one smooth fan, in meshes that are smooth all over:
 * the sum at the position is the normal of all corners there, and no star needs to be made. Each
 * face is measured once. */
#ifndef NORMA_CORE_SMOOTH_FANS_H
#define NORMA_CORE_SMOOTH_FANS_H
#include "core/vertex/vertex.h"

typedef struct smooth_fans {
    core_range *ranges; /* of the chunks of faces, as the mesh names positions; NULL: the mesh is
                           prepared for stars, and none is looked for */
    uint8_t *others; /* 1 at the positions whose corners are left to stars, else 0; NULL: all are */
    uint8_t *chunks; /* of each chunk of faces: whether one has a corner there */
    size_t other_count;
    norma_edges edges; /* of the smooth fans, to positions of higher number; where counted */
} smooth_fans;

/* What is done with the normals of smooth fans: either each corner's is written, */
typedef struct smooth_target {
    const core_output *output;
    /* or, where that is NULL, vertices are told apart: */
    float (*normals)[3]; /* of positions; NULL: nobody asks */
    uint8_t *single;     /* of each position, and of each vertex there: set to 1 */
    uint8_t *firsts;     /* of each corner: set to 1 where it is the first of its vertex */
} smooth_target;

/* Checks the mesh's content and opens it: for sums and *fans where smooth fans can be found, else
 * for stars. */
norma_result norma_core_open_smooth_fans(core_call *call, core_mesh *checked,
    double crease_angle_rad, core_prepared_mesh *prepared, smooth_fans *fans);
/* Finds smooth fans, if it was opened so; then stars may be made of the others. */
norma_result norma_core_find_smooth_fans(
    core_prepared_mesh *prepared, const smooth_target *target, int counting, smooth_fans *fans);
/* Of all corners, whatever has been found. */
norma_result norma_core_prepare_all_stars(core_prepared_mesh *prepared, const smooth_fans *fans);
static inline int norma_core_has_others(const smooth_fans *fans) {
    return !fans->others || fans->other_count;
}
void norma_core_release_smooth_fans(const core_prepared_mesh *prepared, smooth_fans *fans);
#endif
