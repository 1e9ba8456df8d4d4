/* add_triangles_simd.h: the loops of add_triangles.c that are written for registers, one for each
 * instruction set, all from add_triangles.template.h. Each adds as many of the faces as it can,
 * from begin on, and returns the first that is left. */
#ifndef NORMA_CORE_VERTEX_ADD_SIMD_H
#define NORMA_CORE_VERTEX_ADD_SIMD_H
#include "core/call/call.h"
#include "core/vertex/vertex.h"

#if defined(CORE_HAS_X86)
size_t norma_core_add_eights_avx2(const core_adder *adder, size_t begin, size_t end);
#endif
#if defined(CORE_HAS_AVX512)
size_t norma_core_add_eights_avx512(const core_adder *adder, size_t begin, size_t end);
#endif
#endif
