/* normalize_simd.h: eight sums made normals, lane by lane, to be compiled into the kernels of each
 * instruction set. There are two steps, because a root followed by a division takes so long
 * that callers do other work in between. */
#ifndef NORMA_CORE_FINISH_LANES_H
#define NORMA_CORE_FINISH_LANES_H
#include "core/face/eight_vectors.h"
#include "core/face/face.h"
#include "core/vertex/vertex.h"

typedef struct core_lengths {
    core_lane x, y, z, length;
} core_lengths;

/* fine: 1 more for each lane whose sum has a direction; what is said of others is not to be used:
 * they have no votes, cancel, or are beyond what doubles square. */
CORE_INLINE void core_lanes_lengths(const vertex_sum *sums, core_lengths *out, double *fine) {
    core_lane x, y, z, weight;
    core_rows_to_lanes((const double(*)[4])(const void *)sums, x, y, z, weight);
    for (int i = 0; i < CORE_LANES; i++) {
        const double square = x[i] * x[i] + y[i] * y[i] + z[i] * z[i], length = sqrt(square);
        const int is_fine = (square > NORMA_TINIEST) & (square < NORMA_HUGEST) &
                            (length > 0x1p-20 * weight[i]) & (weight[i] > 0);
        out->x[i] = x[i];
        out->y[i] = y[i];
        out->z[i] = z[i];
        out->length[i] = length;
        fine[i] += is_fine ? 1 : 0;
    }
}

CORE_INLINE void core_lanes_directions(const core_lengths *of, float (*normals)[3]) {
    float out[3][CORE_LANES];
    for (int i = 0; i < CORE_LANES; i++) {
        const double inverse = 1 / of->length[i];
        out[0][i] = (float)(of->x[i] * inverse) + 0.0F;
        out[1][i] = (float)(of->y[i] * inverse) + 0.0F;
        out[2][i] = (float)(of->z[i] * inverse) + 0.0F;
    }
    core_floats_to_threes(out[0], out[1], out[2], normals);
}

CORE_INLINE double core_lanes_total(const double *v) {
    return ((v[0] + v[1]) + (v[2] + v[3])) + ((v[4] + v[5]) + (v[6] + v[7]));
}
#endif
