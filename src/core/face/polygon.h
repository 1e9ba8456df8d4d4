/* polygon.h: what is computed of a polygon and of its corners where doubles decide it, one at a
 * time in face_geometry.c and many at once in measure_faces.c: the same operations, hence the same
 * bits. */
#ifndef NORMA_CORE_POLYGON_H
#define NORMA_CORE_POLYGON_H
#include "core/face/triangle.h"

/* Whether a vector area has the right direction. size: the sum of the squares of the distances from
 * the first corner, at least that of the products of their lengths. */
static inline int norma_core_area_is_sure(double square, double size, uint32_t corners) {
    const double bound = 0x1p-22 * (double)(corners + 8) * size;
    return (square >= bound * bound) & (square > NORMA_TINIEST) & (square < NORMA_HUGEST);
}

/* Whether the cross product of a corner's edges is right, from its square and the product of the
 * edges' squares: rounding does not make a needle of nothing, nor turn it over. */
static inline int norma_core_corner_is_sure(double square, double squares) {
    return (square >= 0x1p-40 * squares) & (square > NORMA_TINIEST) & (square < NORMA_HUGEST);
}

/* Whether the side to which a corner turns is the sign of along, its cross product's dot product
 * with the polygon's normal. Both directions are right to 2^-30 rad. */
static inline int norma_core_turn_is_sure(double along, double length) {
    return fabs(along) > 0x1p-28 * length;
}
#endif
