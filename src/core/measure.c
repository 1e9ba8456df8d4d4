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

INLINE void weigh_one(core_batch *t, norma_weight weight)
{
    for (int i = 0; i < CORE_LANES; i++)
        t->weight[0][i] = norma_core_weigh(weight, dot(t->a, t->a, i), dot(t->b, t->b, i), dot(t->a, t->b, i), t->twice_area[i], t->twice_area[i], 0);
}

/* The edges of the three corners are u, v and the third, w = v - u taken from the points; turning one round only changes the sign of a dot product. */
INLINE void weigh_all(core_batch *t, norma_weight weight)
{
    for (int i = 0; i < CORE_LANES; i++) {
        const double uu = dot(t->u, t->u, i), vv = dot(t->v, t->v, i), ww = dot(t->a, t->a, i);
        const double uv = dot(t->u, t->v, i), uw = dot(t->u, t->a, i), vw = dot(t->v, t->a, i), area = t->twice_area[i];
        t->weight[0][i] = norma_core_weigh(weight, uu, vv, uv, area, area, 0);
        t->weight[1][i] = norma_core_weigh(weight, ww, uu, -uw, area, area, 0);
        t->weight[2][i] = norma_core_weigh(weight, vv, ww, vw, area, area, 0);
    }
}

INLINE void weigh(core_batch *t, norma_weight weight, core_corners wanted)
{
    if (wanted == CORE_ONE_CORNER) weigh_one(t, weight);
    if (wanted == CORE_ALL_CORNERS) weigh_all(t, weight);
}

/* One loop for each weight, so that none asks inside. */
INLINE void measure(core_batch *t, norma_weight weight, core_corners wanted)
{
    measure_normals(t);
    switch (weight) {
    case NORMA_WEIGHT_ANGLE:         weigh(t, NORMA_WEIGHT_ANGLE, wanted); break;
    case NORMA_WEIGHT_AREA:          weigh(t, NORMA_WEIGHT_AREA, wanted); break;
    case NORMA_WEIGHT_MAX:           weigh(t, NORMA_WEIGHT_MAX, wanted); break;
    case NORMA_WEIGHT_ANGLE_AREA:    weigh(t, NORMA_WEIGHT_ANGLE_AREA, wanted); break;
    case NORMA_WEIGHT_ANGLE_LENGTHS: weigh(t, NORMA_WEIGHT_ANGLE_LENGTHS, wanted); break;
    default:                         weigh(t, NORMA_WEIGHT_UNIFORM, wanted); break;
    }
}

static void measure_portable(core_batch *t, norma_weight weight, core_corners wanted) { measure(t, weight, wanted); }

#if defined(__GNUC__) && (defined(__x86_64__) || defined(__i386__))
__attribute__((target("avx2"))) static void measure_avx2(core_batch *t, norma_weight weight, core_corners wanted) { measure(t, weight, wanted); }
#if defined(__clang__)
#define AVX512 "avx512f,avx512dq,avx512vl"
#else
#define AVX512 "avx512f,avx512dq,avx512vl,prefer-vector-width=512"
#endif
__attribute__((target(AVX512))) static void measure_avx512(core_batch *t, norma_weight weight, core_corners wanted)
{
    measure(t, weight, wanted);
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
