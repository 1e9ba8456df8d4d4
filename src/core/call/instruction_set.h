/* instruction_set.h: which instruction sets this machine runs, and how a loop is compiled for each.
 * Every one gives the bits of the portable C code. */
#ifndef NORMA_CORE_ISA_H
#define NORMA_CORE_ISA_H
#include <norma/norma.h>

int norma_core_has_isa(norma_isa isa);

/* A kernel is an inline function in plain C over arrays of lanes, and one wrapper for each of
 * these, whose target decides what instructions it becomes. Portable code becomes SSE2, NEON or
 * SIMD128 where the compiler's target has them. */
typedef enum core_level { CORE_PORTABLE = 0, CORE_AVX2, CORE_AVX512 } core_level;
core_level norma_core_level(norma_isa isa); /* the highest that the machine has and isa allows */

#if defined(NORMA_COVERAGE) || defined(NORMA_SANITIZED)
#define CORE_INLINE                                                                                \
    static inline /* what is counted is the source, once, not each copy of a kernel; with the      \
                     checks of a sanitizer one file would be 16 MB */
#elif defined(__GNUC__) || defined(__clang__)
#define CORE_INLINE static inline __attribute__((always_inline))
#else
#define CORE_INLINE static inline
#endif

#if defined(__GNUC__) && (defined(__x86_64__) || defined(__i386__))
#define CORE_HAS_X86
#if !defined(NORMA_WITHOUT_AVX512) /* a choice of the single file's users: less code */
#define CORE_HAS_AVX512
#endif
#define CORE_FOR_AVX2 __attribute__((target("avx2")))
#if defined(CORE_FOR_AVX512) /* tests/bits/avx512_in_c.h */
#elif defined(__clang__)
#define CORE_FOR_AVX512 __attribute__((target("avx512f,avx512dq,avx512vl")))
#else
#define CORE_FOR_AVX512 __attribute__((target("avx512f,avx512dq,avx512vl,prefer-vector-width=512")))
#endif
#define CORE_IN_REGISTERS                                                                          \
    CORE_FOR_AVX512 CORE_INLINE /* a step of a loop that is written for AVX-512 */
#endif

/* The kernels of one name, by level. */
#if defined(CORE_HAS_AVX512)
#define CORE_KERNELS(name)                                                                         \
    { name##_portable, name##_avx2, name##_avx512 }
#elif defined(CORE_HAS_X86)
#define CORE_KERNELS(name)                                                                         \
    { name##_portable, name##_avx2 }
#else
#define CORE_KERNELS(name)                                                                         \
    { name##_portable }
#endif
#endif
