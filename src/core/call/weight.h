/* weight.h: all that is particular to a weight, in one table, and what follows from it: names, the
 * weight of a corner, loops compiled once for each weight. */
#ifndef NORMA_CORE_WEIGHT_H
#define NORMA_CORE_WEIGHT_H
#include "core/call/call.h"
#include <math.h>

/* What a weight is made of. */
typedef enum core_weighed_by {
    CORE_BY_FACE,  /* twice_area at most: the same at all corners of a face */
    CORE_BY_EDGES, /* also aa and bb, the squares of the corner's edges, and cross, the length of
                      their cross product */
    CORE_BY_ANGLE  /* also angle, between them */
} core_weighed_by;

/* The constant without NORMA_WEIGHT_, its name, what it is made of, and how. W is used with these
 * and the other arguments. */
#define CORE_SUMMED_WEIGHTS(W, ...)                                                                \
    W(ANGLE, "angle", CORE_BY_ANGLE, angle, __VA_ARGS__)                                           \
    W(AREA, "area", CORE_BY_FACE, twice_area, __VA_ARGS__)                                         \
    W(UNIFORM, "uniform", CORE_BY_FACE, 1, __VA_ARGS__)                                            \
    W(MAX, "max", CORE_BY_EDGES, (aa * bb > 0 ? cross / (aa * bb) : 0), __VA_ARGS__)               \
    W(ANGLE_AREA, "angle-area", CORE_BY_ANGLE, (angle * twice_area), __VA_ARGS__)                  \
    W(ANGLE_LENGTHS, "angle-lengths", CORE_BY_ANGLE, (angle * (sqrt(aa) * sqrt(bb))), __VA_ARGS__)

/* The same with the one that is no sum; where there must be a sum, it is uniform. */
#define CORE_WEIGHTS(W, ...)                                                                       \
    CORE_SUMMED_WEIGHTS(W, __VA_ARGS__)                                                            \
    W(VISIBLE, "visible", CORE_BY_FACE, 1, __VA_ARGS__)

#define CORE_CASE_OF_NEED(name, text, by, formula, unused)                                         \
    case NORMA_WEIGHT_##name:                                                                      \
        return by;
#define CORE_CASE_OF_FORMULA(name, text, by, formula, unused)                                      \
    case NORMA_WEIGHT_##name:                                                                      \
        return formula;
#define CORE_CASE_OF_LOOP(name, text, by, formula, loop, ...)                                      \
    case NORMA_WEIGHT_##name:                                                                      \
        loop(__VA_ARGS__, NORMA_WEIGHT_##name);                                                    \
        break;

CORE_INLINE core_weighed_by core_weighed(norma_weight weight) {
    switch (weight) { CORE_WEIGHTS(CORE_CASE_OF_NEED, ) }
    return CORE_BY_FACE;
}

/* What a corner weighs. Of what its weight is not made of, anything may be given. */
CORE_INLINE double norma_core_weight_of(
    norma_weight weight, double aa, double bb, double angle, double cross, double twice_area) {
    switch (weight) { CORE_WEIGHTS(CORE_CASE_OF_FORMULA, ) }
    return 1;
}

/* loop(..., weight), where the compiler knows the weight, so that nothing inside asks for it; made
 * small (norma-mesh/normals), once for all weights. */
#if defined(NORMA_SMALL)
#define CORE_LOOP_FOR_WEIGHT(weight, loop, ...)                                                    \
    loop(__VA_ARGS__, (weight) == NORMA_WEIGHT_VISIBLE ? NORMA_WEIGHT_UNIFORM : (weight));
#else
#define CORE_LOOP_FOR_WEIGHT(weight, loop, ...)                                                    \
    switch (weight) {                                                                              \
        CORE_SUMMED_WEIGHTS(CORE_CASE_OF_LOOP, loop, __VA_ARGS__)                                  \
    case NORMA_WEIGHT_VISIBLE:                                                                     \
        loop(__VA_ARGS__, NORMA_WEIGHT_UNIFORM);                                                   \
        break;                                                                                     \
    }
#endif
#endif
