/* facing.h: what the rules on normals against faces share: N201 (facing.c), N202
 * (far_normals.c), N206 (frame.c). */
#ifndef NORMA_CHECK_FACING_H
#define NORMA_CHECK_FACING_H
#include "check/rules/mesh_rules.h"
#include <math.h>

#define CHECK_FAR_COSINE 0.25881904510252074 /* of 75 degrees */

/* Cosine between a face and a stored normal; NaN: there is none, or it has no direction. */
static inline double norma_check_cosine_to(const check_mesh *m, size_t face, size_t number) {
    double n[3];
    if (number == SIZE_MAX) return NAN;
    norma_check_normal(m, number, n);
    const double square = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
    if (!(square >= 1e-12 && square < INFINITY)) /* N101 and N102 tell of it */
        return NAN;
    const double dot = norma_check_dot(m->faces[face].normal, n);
    return square > .99 && square < 1.01 ? dot : dot / sqrt(square);
}

/* opposed.c: the greatest over the face's corners; NaN: a normal there has no direction. far:
 * counts corners whose normal is far from the face. */
double norma_check_greatest_cosine(const check_mesh *m, size_t face, size_t *far);

/* far_normals.c; m->opposed is filled. */
norma_result norma_check_far(check_mesh *m);
#endif
