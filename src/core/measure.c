/* measure.c: one loop over lanes, compiled for each instruction set of the machine's family and chosen at run time. */
#include "measure.h"
#include "isa.h"
#include "triangle.h"

#if defined(__GNUC__)
#define INLINE static inline __attribute__((always_inline))
#else
#define INLINE static inline
#endif

INLINE void measure_normals(core_batch *t)
{
    for (int i = 0; i < CORE_LANES; i++) {
        const int sure = norma_core_triangle(t->u[0][i], t->u[1][i], t->u[2][i], t->v[0][i], t->v[1][i], t->v[2][i], &t->normal[0][i], &t->normal[1][i],
                                             &t->normal[2][i], &t->twice_area[i]);
        t->sure[i] = sure ? 1 : 0;
    }
}

INLINE double dot(core_lane *a, core_lane *b, int i) { return a[0][i] * b[0][i] + a[1][i] * b[1][i] + a[2][i] * b[2][i]; }

INLINE void measure_weights(core_batch *t, norma_weight weight)
{
    for (int i = 0; i < CORE_LANES; i++)
        t->weight[i] = norma_core_weigh(weight, dot(t->a, t->a, i), dot(t->b, t->b, i), dot(t->a, t->b, i), t->twice_area[i], t->twice_area[i], 0);
}

/* One loop for each weight, so that none asks inside. */
INLINE void measure(core_batch *t, norma_weight weight, int with_weights)
{
    measure_normals(t);
    if (!with_weights) return;
    switch (weight) {
    case NORMA_WEIGHT_ANGLE:         measure_weights(t, NORMA_WEIGHT_ANGLE); break;
    case NORMA_WEIGHT_AREA:          measure_weights(t, NORMA_WEIGHT_AREA); break;
    case NORMA_WEIGHT_MAX:           measure_weights(t, NORMA_WEIGHT_MAX); break;
    case NORMA_WEIGHT_ANGLE_AREA:    measure_weights(t, NORMA_WEIGHT_ANGLE_AREA); break;
    case NORMA_WEIGHT_ANGLE_LENGTHS: measure_weights(t, NORMA_WEIGHT_ANGLE_LENGTHS); break;
    default:                         measure_weights(t, NORMA_WEIGHT_UNIFORM); break;
    }
}

static void measure_portable(core_batch *t, norma_weight weight, int with_weights) { measure(t, weight, with_weights); }

#if defined(__GNUC__) && (defined(__x86_64__) || defined(__i386__))
__attribute__((target("avx2"))) static void measure_avx2(core_batch *t, norma_weight weight, int with_weights) { measure(t, weight, with_weights); }
__attribute__((target("avx512f,avx512dq,avx512vl,prefer-vector-width=512"))) static void measure_avx512(core_batch *t, norma_weight weight, int with_weights)
{
    measure(t, weight, with_weights);
}

core_measure *norma_core_choose_measure(norma_isa isa)
{
    if (isa == NORMA_ISA_PORTABLE || isa == NORMA_ISA_SSE2) return measure_portable;   /* SSE2 is what portable code compiles to on this family */
    if (isa != NORMA_ISA_AVX2 && norma_core_has_isa(NORMA_ISA_AVX512)) return measure_avx512;
    return norma_core_has_isa(NORMA_ISA_AVX2) ? measure_avx2 : measure_portable;
}
#else
core_measure *norma_core_choose_measure(norma_isa isa)
{
    (void)isa;
    return measure_portable;
}
#endif
