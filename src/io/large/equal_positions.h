/* equal_positions.h: vertices that may share their position with another one. */
#ifndef NORMA_IO_LARGE_EQUAL_H
#define NORMA_IO_LARGE_EQUAL_H
#include "io/large/bits.h"
#include "io/large/ply_body.h"

/* Marks every vertex whose position another vertex has too, and hardly any other. any: whether
 * there is one. Reads the vertices as often as its table must be filled. */
norma_document_result norma_large_find_equal(large_ply *ply, large_bits *equal, int *any);

/* Marks in members each vertex of equal that may lie where one of those from begin to before end
 * does. MEMORY: the range is too large. */
norma_document_result norma_large_add_equal(
    large_ply *ply, const large_bits *equal, size_t begin, size_t end, large_bits *members);
#endif
