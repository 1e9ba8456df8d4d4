/* measure.h: triangles measured eight at a time. */
#ifndef NORMA_CORE_MEASURE_H
#define NORMA_CORE_MEASURE_H
#include "core/call/call.h"

enum {
    CORE_LANES = 8
}; /* the one vector width: a register of AVX-512, two of AVX2, four of SSE2 or NEON */

typedef double core_lane[CORE_LANES];

/* Before a short loop over lanes: this compiler unrolls such loops before it looks whether they are
 * vectors, and then finds none. */
#if defined(__GNUC__) && !defined(__clang__)
#define CORE_EACH_LANE _Pragma("GCC unroll 1") for (int i = 0; i < CORE_LANES; i++)
#else
#define CORE_EACH_LANE for (int i = 0; i < CORE_LANES; i++)
#endif

typedef struct core_batch {
    _Alignas(64) core_lane u[3];
    core_lane v[3]; /* in: the edges from each triangle's first corner to its second and third */
    core_lane a[3]; /* in, for weights: the edge from the second corner to the third */
    core_lane normal[3], twice_area; /* out */
    core_lane weight[3];             /* out: of the three corners */
    double sure[CORE_LANES]; /* out: 1 where doubles are enough, else 0, and what is said of the
                                triangle is not to be used */
} core_batch;

/* Of a triangle, from the positions of its corners. */
CORE_INLINE void core_set_edges(core_batch *batch, int lane, const double p[3][3]) {
    for (int k = 0; k < 3; k++) {
        batch->u[k][lane] = p[1][k] - p[0][k];
        batch->v[k][lane] = p[2][k] - p[0][k];
        batch->a[k][lane] = p[2][k] - p[1][k];
    }
}

typedef enum core_corners {
    CORE_NO_CORNER = 0,
    CORE_ALL_CORNERS
} core_corners; /* whose weights are wanted */

/* Every level gives the same bits. */
void norma_core_measure(
    core_level level, core_batch *batch, norma_weight weight, core_corners wanted);
#endif
