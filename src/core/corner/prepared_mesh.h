/* prepared_mesh.h: a mesh made ready for normals at its positions: checked, welded, its corners
 * sorted by position, its polygons measured. */
#ifndef NORMA_CORE_SURFACE_H
#define NORMA_CORE_SURFACE_H
#include "core/call/call.h"
#include "core/corner/crease.h"
#include "core/mesh/mesh.h"
#include "core/face/face.h"
#include <stdatomic.h>

typedef struct measured_face {
    double normal[4]; /* unit, and 1; 0 where doubles do not decide it, and nothing here is said */
    double weight[4]; /* of its corners */
} measured_face;

typedef struct core_prepared_mesh {
    core_call *call;
    core_mesh mesh;
    core_corners_of_position corners_of;
    core_face *faces; /* of each face of a mesh of polygons, for stars; NULL for triangles and sums,
                         whose faces are measured where they are met */
    measured_face *measured; /* of each face of a small mesh of triangles (measured_faces.h); or
                                NULL */
    uint32_t *borrowed_from; /* NULL where no face needs one; else of each face without a direction
                         the face whose direction it borrows, UINT32_MAX: none */
    atomic_uchar *flat_at; /* with borrowed_from: nonzero at the positions of faces that have edges
                              but no direction */
    norma_count degenerate_faces; /* of polygons, for sums only those without corners; others are
                                     counted where they are met */
    core_crease crease;           /* may be changed: nothing else here hangs on it */
} core_prepared_mesh;

typedef enum core_use {
    CORE_FOR_SUMS = 0,
    CORE_FOR_STARS,
    CORE_FOR_FANS
} core_use; /* sums need no corners sorted; fans are stars cut at edges */

/* The beginning of a call that cuts fans: options, crease and the mesh's shape are checked. */
norma_result norma_core_begin_with_crease(core_call *call, const norma_options *options,
    const norma_mesh *mesh, float crease_angle_rad, core_mesh *checked);
/* Then its content is checked, and it is opened for fans. */
norma_result norma_core_prepare_fans(
    core_call *call, core_mesh *checked, float crease_angle_rad, core_prepared_mesh *prepared);
/* call stays the caller's. What it returns but NORMA_OK leaves nothing to release. */
norma_result norma_core_prepared_mesh_open(core_call *call, core_mesh *checked, core_use use,
    double crease_angle_rad, core_prepared_mesh *prepared);
/* For a mesh that was opened for sums: the corners at some positions, or at all (NULL), are sorted
 * and polygons measured, those of the chunks alone, so that stars may be made, or fans. */
norma_result norma_core_prepare_stars(
    core_prepared_mesh *prepared, const core_some_positions *some);
/* For triangles, once one without a direction has been met: finds whose directions such borrow.
 * MEMORY or CANCELLED: it has not. */
norma_result norma_core_find_borrowed_directions(core_prepared_mesh *prepared);
void norma_core_prepared_mesh_close(core_prepared_mesh *prepared);

static inline void norma_core_prepared_mesh_face(
    const core_prepared_mesh *prepared, size_t face, core_face *out) {
    if (prepared->faces)
        *out = prepared->faces[face];
    else
        norma_core_face_geometry(&prepared->mesh, face, out);
}
#endif
