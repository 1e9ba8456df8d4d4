/* face_corners.h: from corner to corner within a face. Corners in a row at one (welded) position
 * count as one: the last of them is kept. */
#ifndef NORMA_CORE_FACE_CORNERS_H
#define NORMA_CORE_FACE_CORNERS_H
#include "core/mesh/input_mesh.h"

static inline size_t norma_core_next_in_face(const core_mesh *mesh, size_t face, size_t corner) {
    return corner + 1 < norma_core_face_end(mesh, face) ? corner + 1
                                                        : norma_core_face_begin(mesh, face);
}
static inline size_t norma_core_previous_in_face(
    const core_mesh *mesh, size_t face, size_t corner) {
    return corner > norma_core_face_begin(mesh, face) ? corner - 1
                                                      : norma_core_face_end(mesh, face) - 1;
}
static inline int norma_core_is_kept(const core_mesh *mesh, size_t face, size_t corner) {
    return norma_core_welded_corner(mesh, corner) !=
           norma_core_welded_corner(mesh, norma_core_next_in_face(mesh, face, corner));
}

/* From a kept corner of a face with edges to the next one and the previous one that is kept. */
static inline size_t norma_core_next_kept(const core_mesh *mesh, size_t face, size_t corner) {
    do corner = norma_core_next_in_face(mesh, face, corner);
    while (!norma_core_is_kept(mesh, face, corner));
    return corner;
}
static inline size_t norma_core_previous_kept(const core_mesh *mesh, size_t face, size_t corner) {
    do corner = norma_core_previous_in_face(mesh, face, corner);
    while (!norma_core_is_kept(mesh, face, corner));
    return corner;
}
#endif
