/* measure.c: batches measured, compiled for each instruction set of the machine's family and chosen
 * at run time. */
#include "core/face/measure_simd.h"

/* One loop for each weight, so that none asks inside. */
CORE_INLINE void measure(core_batch *t, norma_weight weight, core_corners wanted) {
    switch (weight) {
    case NORMA_WEIGHT_ANGLE:
        core_lanes_measure(t, NORMA_WEIGHT_ANGLE, wanted);
        break;
    case NORMA_WEIGHT_AREA:
        core_lanes_measure(t, NORMA_WEIGHT_AREA, wanted);
        break;
    case NORMA_WEIGHT_MAX:
        core_lanes_measure(t, NORMA_WEIGHT_MAX, wanted);
        break;
    case NORMA_WEIGHT_ANGLE_AREA:
        core_lanes_measure(t, NORMA_WEIGHT_ANGLE_AREA, wanted);
        break;
    case NORMA_WEIGHT_ANGLE_LENGTHS:
        core_lanes_measure(t, NORMA_WEIGHT_ANGLE_LENGTHS, wanted);
        break;
    default:
        core_lanes_measure(t, NORMA_WEIGHT_UNIFORM, wanted);
        break;
    }
}

static void measure_portable(core_batch *t, norma_weight weight, core_corners wanted) {
    measure(t, weight, wanted);
}

#if defined(CORE_HAS_X86)
CORE_FOR_AVX2 static void measure_avx2(core_batch *t, norma_weight weight, core_corners wanted) {
    measure(t, weight, wanted);
}
#if defined(CORE_HAS_AVX512)
CORE_FOR_AVX512 static void measure_avx512(
    core_batch *t, norma_weight weight, core_corners wanted) {
    measure(t, weight, wanted);
}
#endif
#endif

void norma_core_measure(
    core_level level, core_batch *batch, norma_weight weight, core_corners wanted) {
    typedef void measure_for(core_batch * t, norma_weight weight, core_corners wanted);
    static measure_for *const measures[] = CORE_KERNELS(measure);
    measures[level](batch, weight, wanted);
}
