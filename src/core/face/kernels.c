/* kernels.c: which kernels a machine runs. */
#include "core/face/face.h"

const core_kernels *norma_core_kernels(core_level level) {
#if defined(CORE_HAS_AVX512)
    if (level == CORE_AVX512) return norma_core_kernels_avx512();
#endif
#if defined(CORE_HAS_X86)
    if (level == CORE_AVX2) return norma_core_kernels_avx2();
#endif
    (void)level;
    return norma_core_kernels_portable();
}
