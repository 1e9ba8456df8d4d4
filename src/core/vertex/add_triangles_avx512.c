/* add_triangles_avx512.c: add_triangles.template.h for AVX-512, eight triangles at once. */
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC optimize("no-tree-slp-vectorize") /* as in add_triangles.c */
#endif
#include "core/vertex/add_triangles_simd.h"
#if defined(CORE_HAS_AVX512)
#include "core/face/vectors_avx512.h"
#include "core/vertex/add_eight_triangles.h"

#define VECTORS(name) core_avx512_##name
#define FOR_VECTORS   CORE_FOR_AVX512 __attribute__((noinline))
#define IN_VECTORS    CORE_IN_REGISTERS
typedef core_avx512_vector vector;
typedef core_avx512_mask mask;
enum { LANES = CORE_AVX512_LANES };
#include "core/face/measure_triangles.template.h"
#include "core/vertex/add_triangles.template.h"

size_t norma_core_add_eights_avx512(const core_adder *adder, size_t begin, size_t end) {
    return add_eights(adder, begin, end);
}
#endif
