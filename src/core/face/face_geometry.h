/* face_geometry.h: the direction and size of a face, and what each of its corners weighs. */
#ifndef NORMA_CORE_FACE_GEOMETRY_H
#define NORMA_CORE_FACE_GEOMETRY_H
#include "core/mesh/input_mesh.h"

enum {
    CORE_FACE_DIRECTED = 1,
    CORE_FACE_FINITE = 2,
    CORE_FACE_EDGED = 4
}; /* edged: three corners or more are left */

typedef struct core_face {
    double normal[3];  /* unit where directed, else zero */
    double twice_area; /* 0 where not directed */
    uint64_t key;  /* the same for a face and its reversed twin; only of faces of more than three
                      corners */
    uint32_t kept; /* corners that are left when those at one position in a row are one */
    uint8_t flags;
} core_face;

/* Kept corners: the last of each run of corners at one welded position. */
static inline size_t norma_core_next_in_face(const core_mesh *mesh, size_t face, size_t corner) {
    return corner + 1 < norma_core_face_end(mesh, face) ? corner + 1
                                                        : norma_core_face_begin(mesh, face);
}
static inline size_t norma_core_previous_in_face(
    const core_mesh *mesh, size_t face, size_t corner) {
    return corner > norma_core_face_begin(mesh, face) ? corner - 1
                                                      : norma_core_face_end(mesh, face) - 1;
}
static inline uint32_t norma_core_welded_corner(const core_mesh *mesh, size_t corner) {
    return norma_core_welded(mesh, norma_core_corner(mesh, corner));
}
static inline int norma_core_is_kept(const core_mesh *mesh, size_t face, size_t corner) {
    return norma_core_welded_corner(mesh, corner) !=
           norma_core_welded_corner(mesh, norma_core_next_in_face(mesh, face, corner));
}
/* Of a kept corner of a face with edges: the kept corner behind it and before it. */
size_t norma_core_next_kept(const core_mesh *mesh, size_t face, size_t corner);
size_t norma_core_previous_kept(const core_mesh *mesh, size_t face, size_t corner);

/* O(corners of the face). */
void norma_core_face_geometry(const core_mesh *mesh, size_t face, core_face *out);

/* The same of count <= CORE_LANES faces in a row, triangles at once. */
void norma_core_faces_geometry(
    const core_call *call, const core_mesh *mesh, size_t face, size_t count, core_face *out);

/* What a kept corner of a directed face weighs. Constant time, but for runs of corners at one
 * position. */
double norma_core_corner_weight(const core_mesh *mesh, norma_weight weight, size_t number,
    const core_face *face, size_t corner);

/* Three doubles of any scale to a unit vector; zeros stay zeros. */
void norma_core_normalise(const double v[3], double unit[3]);
double norma_core_length(const double v[3]);

static inline double norma_core_dot(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
static inline void norma_core_cross(const double a[3], const double b[3], double out[3]) {
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}
static inline void norma_core_subtract(const double a[3], const double b[3], double out[3]) {
    for (int k = 0; k < 3; k++) out[k] = a[k] - b[k];
}
#endif
