/* measure_faces_avx2.c: measure_faces.template.h for AVX2, four faces at once. */
#include "core/face/measure_faces_simd.h"
#if defined(CORE_HAS_X86)
#include "core/face/vectors_avx2.h"

#define VECTORS(name) core_avx2_##name
#define FOR_VECTORS   CORE_FOR_AVX2
#define IN_VECTORS    CORE_IN_AVX2
typedef core_avx2_vector vector;
typedef core_avx2_mask mask;
enum { LANES = CORE_AVX2_LANES };
#include "core/face/measure_faces.template.h"

void norma_core_measure_alike_avx2(
    const core_faces_alike *faces, size_t begin, size_t end, size_t corners) {
    measure_alike(faces, begin, end, corners);
}
#endif
