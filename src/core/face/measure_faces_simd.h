/* measure_faces_simd.h: the loops of measure_faces.c, one for each instruction set, all from
 * measure_faces.template.h. */
#ifndef NORMA_CORE_MEASURE_FACES_SIMD_H
#define NORMA_CORE_MEASURE_FACES_SIMD_H
#include "core/face/face.h"

/* Faces of one block, of which those from one slot to before another have equally many corners. */
typedef struct core_faces_alike {
    const core_mesh *mesh;
    const uint32_t *at; /* of each corner of the block its position, as the mesh names it */
    norma_weight weight;
    core_corners wanted;
    core_measured *out;
} core_faces_alike;

typedef void core_measure_alike(
    const core_faces_alike *faces, size_t begin, size_t end, size_t corners);
core_measure_alike norma_core_measure_alike_portable;
#if defined(CORE_HAS_X86)
core_measure_alike norma_core_measure_alike_avx2;
#endif
#if defined(CORE_HAS_AVX512)
core_measure_alike norma_core_measure_alike_avx512;
#endif

/* Whether no corner is at the position of the one before it. */
CORE_INLINE int core_has_kept_corners(const uint32_t *at, size_t corners) {
    int kept = at[corners - 1] != at[0];
    for (size_t k = 1; k < corners; k++) kept &= at[k - 1] != at[k];
    return kept;
}
#endif
