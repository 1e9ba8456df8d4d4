/* measure.h: triangles measured eight at a time. */
#ifndef NORMA_CORE_MEASURE_H
#define NORMA_CORE_MEASURE_H
#include <norma/norma.h>

enum { CORE_LANES = 8 };                     /* the one vector width: a register of AVX-512, two of AVX2, four of SSE2 or NEON */

typedef double core_lane[CORE_LANES];

typedef struct core_batch {
    core_lane u[3], v[3];                    /* in: the edges from each triangle's first corner to its second and third */
    core_lane a[3], b[3];                    /* in, for weights: the edges from one of its corners to the next and the previous one */
    core_lane normal[3], twice_area, weight; /* out */
    double    sure[CORE_LANES];              /* out: 1 where doubles are enough, else 0, and what is said of the triangle is not to be used */
} core_batch;

typedef void core_measure(core_batch *batch, norma_weight weight, int with_weights);

/* The fastest that the machine and the options allow; every one gives the same bits. */
core_measure *norma_core_choose_measure(norma_isa isa);
#endif
