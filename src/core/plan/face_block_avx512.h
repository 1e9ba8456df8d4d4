/* face_block_avx512.h: the one loop of plans that is written for an instruction set. */
#ifndef NORMA_CORE_PLAN_BLOCK_AVX512_H
#define NORMA_CORE_PLAN_BLOCK_AVX512_H
#include "core/plan/face_block.h"
#include "core/call/instruction_set.h"

#if defined(CORE_HAS_AVX512)
/* Normals and angles of some eights of triangles; the doubted ones are listed. */
void norma_core_block_angles_avx512(const block_view *t, block_some eights, block_room *room);
#endif
#endif
