/* measure.c: batches measured, compiled for each instruction set of the machine's family and chosen
 * at run time. */
#include "core/face/measure_simd.h"

CORE_INLINE void measure(core_batch *t, norma_weight weight, core_corners wanted) {
    CORE_LOOP_FOR_WEIGHT(weight, core_lanes_measure, t, wanted)
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
