/* measure_faces_avx512.c: measure_faces.template.h for AVX-512, eight faces at once. */
#include "core/face/measure_faces_simd.h"
#if defined(CORE_HAS_AVX512)
#include "core/face/vectors_avx512.h"

#define VECTORS(name) core_avx512_##name
#define FOR_VECTORS   CORE_FOR_AVX512
#define IN_VECTORS    CORE_IN_REGISTERS
typedef core_avx512_vector vector;
typedef core_avx512_mask mask;
enum { LANES = CORE_AVX512_LANES };
#include "core/face/measure_faces.template.h"

void norma_core_measure_alike_avx512(
    const core_faces_alike *faces, size_t begin, size_t end, size_t corners) {
    measure_alike(faces, begin, end, corners);
}
#endif
