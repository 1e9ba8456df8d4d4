/* exact_area.h: the vector area of a face, exactly. */
#ifndef NORMA_CORE_EXACT_H
#define NORMA_CORE_EXACT_H
#include <stddef.h>

typedef void exact_point(const void *context, size_t index, double point[3]);

/* Twice the vector area of the polygon of count >= 3 finite points, sum of (p_i - p_0) x (p_{i+1} -
 * p_0), in exact integer arithmetic: area * 2^exponent, each component rounded once, relative to
 * the largest. Returns 0 (and zeros) where it is exactly zero. */
int norma_core_exact_area(
    exact_point *point, const void *context, size_t count, double area[3], int *exponent);
#endif
