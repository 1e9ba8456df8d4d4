/* add_triangles_avx512.h: the one loop of add_triangles.c that is written for an instruction set.
 */
#ifndef NORMA_CORE_VERTEX_ADD_AVX512_H
#define NORMA_CORE_VERTEX_ADD_AVX512_H
#include "core/call/instruction_set.h"
#include "core/vertex/add_triangles.h"

#if defined(CORE_HAS_AVX512)
/* Adds as many of the faces as it can, from begin on; returns the first that is left. */
size_t norma_core_add_eights_avx512(const core_adder *adder, size_t begin, size_t end);
#endif
#endif
