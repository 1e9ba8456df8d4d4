/* steady.h: tangents that depend on the mesh alone, not on the order in which it is given.
 *
 * Every number is computed from a face's corners in an order of their own (the rotation that is
 * least by what the corners hold), and sums are sums of integers, so that neither the order of
 * faces nor the first corner of a face changes a bit. */
#ifndef NORMA_CORE_STEADY_H
#define NORMA_CORE_STEADY_H
#include "core/mesh/corners_of_position.h"
#include "core/tangent/tangents.h"
#include <math.h>

/* What a corner adds to the sum of its vertex. */
typedef struct steady_part {
    double sum[3]; /* a unit vector times the weight */
    double weight; /* 0: adds nothing */
} steady_part;

/* Texture areas below this part of the products that they are differences of are rounding. */
static const double STEADY_ROUNDING = 0x1p-50;
/* Below this part of a unit vector, what is perpendicular to the normal is rounding. */
static const double STEADY_NOTHING_LEFT = 0x1p-20;

typedef struct steady_mesh {
    core_call *call;
    const tangent_mesh *input;
    uint32_t *vertex_of; /* of each corner */
    steady_part *parts;  /* of each corner of the faces that have a sign */
    int8_t *signs;    /* of each face's texture area, 0: none, or something of it is not finite */
    uint8_t *adopted; /* NULL, or of each face without one whether the sign is negative that it
                         takes from its neighbours */
    core_corners_of_position around;
} steady_mesh;

/* norma_core_length and _normalise, without a call for nearly all vectors: those whose squares fit
 * a double. */
static inline double steady_length(const double v[3]) {
    const double square = norma_core_dot(v, v);
    return square > NORMA_TINIEST && square < NORMA_HUGEST ? sqrt(square) : norma_core_length(v);
}
static inline void steady_normalise(const double v[3], double unit[3]) {
    const double square = norma_core_dot(v, v);
    if (!(square > NORMA_TINIEST && square < NORMA_HUGEST)) {
        norma_core_normalise(v, unit);
        return;
    }
    const double inverse = 1 / sqrt(square);
    for (int k = 0; k < 3; k++) unit[k] = v[k] * inverse;
}

static inline int steady_make_perpendicular(
    const double v[3], const double normal[3], double out[3]) {
    const double along = norma_core_dot(v, normal);
    for (int k = 0; k < 3; k++) out[k] = v[k] - along * normal[k];
    const double length = sqrt(norma_core_dot(out, out)); /* of a part of a unit vector */
    if (!(length > STEADY_NOTHING_LEFT)) return 0;
    const double inverse = 1 / length;
    for (int k = 0; k < 3; k++) out[k] *= inverse;
    return 1;
}

/* CANCELLED, or every face measured, and what it adds at its corners. */
norma_result norma_core_steady_faces(steady_mesh *mesh);

/* For a plan: what steady_mesh has of the same names. */
norma_result norma_core_steady_keep(
    const tangent_mesh *mesh, uint32_t **vertex_of, core_corners_of_position *around);
#endif
