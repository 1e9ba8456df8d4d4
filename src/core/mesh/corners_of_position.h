/* corners_of_position.h: the corners around each position. */
#ifndef NORMA_CORE_AROUND_H
#define NORMA_CORE_AROUND_H
#include "core/mesh/input_mesh.h"

typedef struct core_around {
    uint32_t *starts;  /* position_count + 1 offsets into corners */
    uint32_t *corners; /* by (welded) position, ascending */
    uint32_t *faces;   /* of each corner; NULL for triangles */
    size_t position_count, corner_count;
    size_t most; /* corners at one position */
} core_around;

/* Two counting passes, O(positions + corners). MEMORY or CANCELLED leave nothing to release. */
norma_result norma_core_around_build(core_call *call, const core_mesh *mesh, core_around *around);
void norma_core_around_release(const core_call *call, core_around *around);

static inline size_t norma_core_face_of(const core_around *around, size_t corner) {
    return around->faces ? around->faces[corner] : corner / 3;
}
#endif
