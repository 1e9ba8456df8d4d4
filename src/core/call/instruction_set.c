/* instruction_set.c: what the machine can run, asked of the processor, not of the compiler. */
#include "core/call/instruction_set.h"

#if defined(CORE_HAS_X86)
static int has_x86(norma_isa isa) {
    __builtin_cpu_init();
    if (isa == NORMA_ISA_SSE2) return __builtin_cpu_supports("sse2") != 0;
    if (isa == NORMA_ISA_AVX2) return __builtin_cpu_supports("avx2") != 0;
#if defined(CORE_HAS_AVX512)
    if (isa == NORMA_ISA_AVX512)
        return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
               __builtin_cpu_supports("avx512vl");
#endif
    return 0;
}
#endif

int norma_core_has_isa(norma_isa isa) {
    if (isa == NORMA_ISA_BEST || isa == NORMA_ISA_PORTABLE) return 1;
#if defined(CORE_HAS_X86)
    return has_x86(isa);
#elif defined(__x86_64__)
    return isa == NORMA_ISA_SSE2;
#elif defined(__aarch64__)
    return isa == NORMA_ISA_NEON;
#elif defined(__wasm_simd128__)
    return isa == NORMA_ISA_SIMD128;
#else
    return 0;
#endif
}

core_level norma_core_level(norma_isa isa) {
#if defined(CORE_HAS_X86)
    if (isa == NORMA_ISA_PORTABLE || isa == NORMA_ISA_SSE2)
        return CORE_PORTABLE; /* SSE2 is what portable code compiles to on this family */
    if (isa != NORMA_ISA_AVX2 && norma_core_has_isa(NORMA_ISA_AVX512)) return CORE_AVX512;
    if (norma_core_has_isa(NORMA_ISA_AVX2)) return CORE_AVX2;
#endif
    (void)isa;
    return CORE_PORTABLE;
}
