/* face_geometry.h: the direction and size of a face, and what each of its corners weighs. */
#ifndef NORMA_CORE_FACE_GEOMETRY_H
#define NORMA_CORE_FACE_GEOMETRY_H
#include "core/face/measure_faces.h"
#include "core/mesh/mesh.h"

enum {
    CORE_FACE_DIRECTED = 1,
    CORE_FACE_FINITE = 2,
    CORE_FACE_EDGED = 4
}; /* edged: three corners or more are left */

typedef struct core_face {
    double normal[3];  /* unit where directed, else zero */
    double twice_area; /* 0 where not directed */
    uint64_t key;      /* by twin_key.h, of polygons with edges whose fans are asked for; else 0 */
    uint32_t kept;     /* corners that are left when those at one position in a row are one */
    uint8_t flags;
} core_face;

/* O(corners of the face). */
void norma_core_face_geometry(const core_mesh *mesh, size_t face, core_face *out);

/* The same of count <= CORE_FACES_AT_ONCE faces in a row. */
void norma_core_faces_geometry(
    const core_call *call, const core_mesh *mesh, size_t face, size_t count, core_face *out);

/* Loads a triangle into a lane of a batch. Returns whether its corners are at three positions. */
int norma_core_load_lane(const core_mesh *mesh, size_t face, core_batch *batch, int lane);

/* What a kept corner of a directed face weighs. Constant time, but for runs of corners at one
 * position. */
double norma_core_corner_weight(const core_mesh *mesh, norma_weight weight, size_t number,
    const core_face *face, size_t corner);

#endif
