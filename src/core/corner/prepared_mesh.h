/* prepared_mesh.h: a mesh made ready for normals at its positions: checked, welded, its corners
 * sorted by position, its polygons measured. */
#ifndef NORMA_CORE_SURFACE_H
#define NORMA_CORE_SURFACE_H
#include "core/mesh/corners_of_position.h"
#include "core/face/face_geometry.h"
#include <stdatomic.h>

typedef struct core_surface {
    core_call *call;
    core_mesh mesh;
    core_around around;
    core_face *faces; /* of each face of a mesh of polygons; NULL for triangles, which are measured
                         where they are met */
    uint32_t *lender; /* NULL where no face needs one; else of each face without a direction the
                         face whose direction it borrows, UINT32_MAX: none */
    atomic_uchar *flat_at; /* with lender: nonzero at the positions of faces that have edges but no
                              direction */
    norma_count degenerate_faces; /* of polygons; triangles are counted where they are met */
    double crease; /* the greatest dihedral angle that is smooth, the tolerance in it; beyond pi:
                      every angle */
    double crease_cosine; /* about its cosine */
} core_surface;

typedef enum core_use {
    CORE_FOR_SUMS = 0,
    CORE_FOR_RINGS,
    CORE_FOR_FANS
} core_use; /* sums need no corners sorted; fans are rings cut at edges */

/* call stays the caller's. What it returns but NORMA_OK leaves nothing to release. */
norma_result norma_core_surface_open(core_call *call, core_mesh *checked, core_use use,
    double crease_angle_rad, core_surface *surface);
/* Another crease for the same surface: nothing else in it hangs on that. */
void norma_core_surface_crease(core_surface *surface, double crease_angle_rad);
/* For triangles, once one without a direction has been met: finds whose directions such borrow.
 * MEMORY or CANCELLED: it has not. */
norma_result norma_core_surface_lend(core_surface *surface);
void norma_core_surface_close(core_surface *surface);

static inline void norma_core_surface_face(
    const core_surface *surface, size_t face, core_face *out) {
    if (surface->faces)
        *out = surface->faces[face];
    else
        norma_core_face_geometry(&surface->mesh, face, out);
}

static inline void norma_core_count_one(norma_count *count, size_t index) {
    if (!count->count || index < count->first) count->first = index;
    count->count++;
}
static inline void norma_core_count_add(norma_count *sum, const norma_count *part) {
    if (!part->count) return;
    if (!sum->count || part->first < sum->first) sum->first = part->first;
    sum->count += part->count;
}
static inline void norma_core_edges_add(norma_edges *sum, const norma_edges *part) {
    sum->count += part->count;
    sum->open += part->open;
    sum->smooth += part->smooth;
    sum->hard += part->hard;
}
#endif
