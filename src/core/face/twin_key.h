/* twin_key.h: a number by which a face's reversed twin is recognised: the face that has the same
 * (welded) positions in opposite order, wherever either begins. */
#ifndef NORMA_CORE_TWIN_KEY_H
#define NORMA_CORE_TWIN_KEY_H
#include "core/mesh/mesh.h"

/* The two lowest bits tell the way round: 0 or 1, or 2 for a face that is its own reverse. */
enum { CORE_KEY_WAY = 3 };

/* O(corners of the face). */
uint64_t norma_core_twin_key(const core_mesh *mesh, size_t face);

/* At one edge, a triangle and its twin run opposite ways and have the third position in common. */
static inline uint64_t norma_core_triangle_key(uint32_t third) { return (uint64_t)third << 2 | 2; }

/* The key that the twins of a face with this key have. */
static inline uint64_t norma_core_key_of_twin(uint64_t key) { return key ^ ((~key >> 1) & 1); }
#endif
