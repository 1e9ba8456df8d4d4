/* kernels_avx2.c: the kernels for AVX2, four doubles in a register. */
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC optimize(                                                                              \
    "no-tree-slp-vectorize") /* this compiler gathers neighbouring addresses into                  \
                                vectors, only to take them out again one by one */
#endif
#include "core/face/vectors.h"

#if defined(CORE_HAS_X86)
#define VECTORS(name) core_avx2_##name
#define FOR_VECTORS   CORE_FOR_AVX2 __attribute__((noinline))
#define FOR_ROWS      CORE_FOR_AVX2
#define IN_VECTORS    CORE_IN_AVX2
typedef core_avx2_vector vector;
typedef core_avx2_mask mask;
enum { LANES = CORE_AVX2_LANES };
#include "core/face/face_kernel.template.h"
#include "core/face/add_kernel.template.h"

const core_kernels *norma_core_kernels_avx2(void) { return &KERNELS; }
#endif
