/* measure_faces.h: faces of three to eight corners measured many at a time, eight of equally many
 * corners at once. Faces of more corners, and what doubles do not decide, are left to
 * face_geometry.c, whose bits these are. */
#ifndef NORMA_CORE_MEASURE_FACES_H
#define NORMA_CORE_MEASURE_FACES_H
#include "core/face/measure.h"
#include "core/mesh/mesh.h"

enum {
    CORE_FACES_AT_ONCE = 64, /* more would need more stack than a caller's jobs may have */
    CORE_MOST_CORNERS = 8,
    CORE_CORNERS_AT_ONCE = CORE_FACES_AT_ONCE * CORE_MOST_CORNERS,
    CORE_SLOTS = 112 /* batches of eight, one of each number of corners not full */
};

static const double CORE_FLAT_COSINE = 0.98481; /* of 10 degrees and a little less */

typedef struct core_measured {
    _Alignas(64) double row[CORE_SLOTS][4]; /* the unit normal, and 1; of each slot, as all here */
    core_lane twice_area[CORE_SLOTS / CORE_LANES];
    core_lane weight[CORE_SLOTS / CORE_LANES][CORE_MOST_CORNERS]; /* of each corner, where wanted */
    uint8_t face[CORE_SLOTS];            /* its face, numbered from begin */
    uint8_t slot[CORE_FACES_AT_ONCE];    /* of each face */
    uint8_t corners[CORE_FACES_AT_ONCE]; /* 0: left to others, and nothing else is said of it */
    uint8_t flat[CORE_FACES_AT_ONCE];    /* where weights are by angle: whether each corner's edges
                                            turn about its normal, to CORE_FLAT_COSINE */
    uint32_t first[CORE_FACES_AT_ONCE];  /* the place of its first corner in at */
    const uint32_t *at;                  /* of each corner its position, welded where they are */
    uint32_t room[CORE_CORNERS_AT_ONCE]; /* for at, where it is not the mesh's */
} core_measured;

/* The faces from begin to before end, CORE_FACES_AT_ONCE at most. */
void norma_core_measure_faces(core_level level, const core_mesh *mesh, size_t begin, size_t end,
    norma_weight weight, core_corners wanted, core_measured *out);
#endif
