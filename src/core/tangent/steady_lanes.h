/* steady_lanes.h: what many triangles add at their corners, at once: plain C over arrays of lanes,
 * each operation as steady_faces.c has it for a face alone. */
#ifndef NORMA_CORE_STEADY_LANES_H
#define NORMA_CORE_STEADY_LANES_H
#include "core/call/instruction_set.h"

enum { STEADY_LANES = 8 };
typedef double steady_lane[STEADY_LANES];

/* In: the corners of each triangle from its least rotation on. */
typedef struct steady_batch {
    _Alignas(64) steady_lane position[3][3]; /* of a corner, along an axis */
    steady_lane normal[3][3], texcoord[3][2];
} steady_batch;

/* Out: of each corner the part of its vertex's sum, of each triangle the sign. */
typedef struct steady_addends {
    _Alignas(64) steady_lane sum[3][3];
    steady_lane weight[3], sign;
    steady_lane is_sure; /* 0: squares of lengths that a double does not hold, or not finite */
} steady_addends;

typedef void steady_kernel(const steady_batch *batch, norma_weight weight, steady_addends *out);
steady_kernel *norma_core_steady_kernel(norma_isa isa);
#endif
