/* corners_of_position.h: the corners around each position. */
#ifndef NORMA_CORE_AROUND_H
#define NORMA_CORE_AROUND_H
#include "core/mesh/input_mesh.h"

typedef struct core_corners_of_position {
    uint32_t *starts;  /* position_count + 1 offsets into corners */
    uint32_t *corners; /* by (welded) position, ascending */
    uint32_t *faces;   /* of each corner; NULL for triangles */
    size_t position_count, corner_count;
    size_t most; /* corners at one position */
} core_corners_of_position;

/* Two counting passes, O(positions + corners). MEMORY or CANCELLED leave nothing to release. */
norma_result norma_core_corners_of_position_build(
    core_call *call, const core_mesh *mesh, core_corners_of_position *corners_of);
/* The same of some positions. */
typedef struct core_some_positions {
    const uint8_t *wanted; /* 1 at these, 0 at all others */
    const uint8_t *chunks; /* of each CORE_FACES_IN_CHUNK faces: 0 where none has a corner there */
} core_some_positions;
norma_result norma_core_corners_of_some_positions(core_call *call, const core_mesh *mesh,
    const core_some_positions *some, core_corners_of_position *corners_of);
void norma_core_corners_of_position_release(
    const core_call *call, core_corners_of_position *corners_of);

static inline size_t norma_core_face_of(const core_corners_of_position *corners_of, size_t corner) {
    return corners_of->faces ? corners_of->faces[corner] : corner / 3;
}
#endif
