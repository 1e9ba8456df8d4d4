/* vertex_add_avx512.h: the one loop of vertex_add.c that is written for an instruction set. */
#ifndef NORMA_CORE_VERTEX_ADD_AVX512_H
#define NORMA_CORE_VERTEX_ADD_AVX512_H
#include "isa.h"
#include "vertex_add.h"

#if defined(CORE_HAS_X86)
/* Adds as many of the faces as it can, from begin on; returns the first that is left. */
size_t norma_core_add_eights_avx512(const core_adder *adder, size_t begin, size_t end);
#endif
#endif
