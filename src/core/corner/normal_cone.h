/* normal_cone.h: the smallest cone round normals that are not kept in an array. */
#ifndef NORMA_CORE_CONE_H
#define NORMA_CORE_CONE_H
#include <stddef.h>

/* Normal index of count; 0 where that one is left out. The same each time it is asked for. */
typedef int norma_core_cone_at(const void *context, size_t index, double normal[3]);

/* As norma_core_smallest_cone (vertex_star.h), with the same bits. */
int norma_core_smallest_cone_of(
    norma_core_cone_at *at, const void *context, size_t count, double axis[3]);
#endif
