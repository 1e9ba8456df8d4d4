/* measure_faces_portable.c: measure_faces.template.h for any machine. */
#include "core/face/measure_faces_simd.h"
#include "core/face/vectors_portable.h"

#define VECTORS(name) core_portable_##name
#define FOR_VECTORS
#define IN_VECTORS CORE_INLINE
typedef core_portable_vector vector;
typedef core_portable_mask mask;
enum { LANES = CORE_PORTABLE_LANES };
#include "core/face/measure_faces.template.h"

void norma_core_measure_alike_portable(
    const core_faces_alike *faces, size_t begin, size_t end, size_t corners) {
    measure_alike(faces, begin, end, corners);
}
