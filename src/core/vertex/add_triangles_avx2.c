/* add_triangles_avx2.c: add_triangles.template.h for AVX2, four triangles at once. */
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC optimize("no-tree-slp-vectorize") /* as in add_triangles.c */
#endif
#include "core/vertex/add_triangles_simd.h"
#if defined(CORE_HAS_X86)
#include "core/face/vectors_avx2.h"
#include "core/vertex/add_eight_triangles.h"

#define VECTORS(name) core_avx2_##name
#define FOR_VECTORS   CORE_FOR_AVX2 __attribute__((noinline))
#define IN_VECTORS    CORE_IN_AVX2
typedef core_avx2_vector vector;
typedef core_avx2_mask mask;
enum { LANES = CORE_AVX2_LANES };
#include "core/face/measure_triangles.template.h"
#include "core/vertex/add_triangles.template.h"

size_t norma_core_add_eights_avx2(const core_adder *adder, size_t begin, size_t end) {
    return add_eights(adder, begin, end);
}
#endif
