/* transform_normals_avx512.h: the one loop of transform_normals.c that is written for an
 * instruction set. */
#ifndef NORMA_CORE_TRANSFORM_NORMALS_AVX512_H
#define NORMA_CORE_TRANSFORM_NORMALS_AVX512_H
#include "core/call/instruction_set.h"

#if defined(CORE_HAS_AVX512)
/* Normals in a row, up to the first sixteen with one that is to be done by itself. Returns how many
 * were done. in and out may be the same. */
size_t norma_core_units_avx512(const double matrix[9], const float *in, size_t count, float *out);
#endif
#endif
