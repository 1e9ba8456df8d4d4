/* edge_partners.h: which faces lie side by side: the faces along each edge of (welded) positions,
 * and what is out of the ordinary there. */
#ifndef NORMA_CORE_TOPOLOGY_H
#define NORMA_CORE_TOPOLOGY_H
#include "core/mesh/corners_of_position.h"
#include "core/face/face_geometry.h"

/* What is at the other side of the edge that runs from a kept corner to the face's next kept
 * corner. */
#define CORE_EDGE_NONE                                                                             \
    UINT32_MAX /* no edge begins at this corner: it is one with the next, or its face has fewer    \
                  than three left */
#define CORE_EDGE_OPEN     (UINT32_MAX - 1) /* an edge of one face */
#define CORE_EDGE_CONFLICT (UINT32_MAX - 2) /* of exactly two, which run along it the same way */
#define CORE_EDGE_MANY     (UINT32_MAX - 3) /* of more than two */
#define CORE_EDGE_SPECIAL                                                                          \
    (UINT32_MAX - 3) /* from here on; below: the corner at which the other face's edge begins,     \
                        which runs the other way */

typedef struct core_polygon {
    uint64_t key; /* by twin_key.h */
    uint32_t
        anchor; /* the corner at its least position, the first of several; UINT32_MAX: no edges */
    uint32_t kept; /* corners that are left */
} core_polygon;

typedef struct core_topology {
    core_call *call;
    core_mesh mesh; /* its corners are welded positions: the least of those that are one; no weld of
                       its own */
    uint32_t *corners; /* those, owned */
    core_corners_of_position corners_of;
    core_polygon *polygons; /* of each face; NULL for triangles */
    uint32_t *partners;     /* of each corner: see above. NULL before norma_core_pair_edges */
    uint32_t *others; /* at corners with CORE_EDGE_CONFLICT or _MANY, and there only: the corner of
                         the edge's next face, round about */
} core_topology;

typedef struct core_edge_run { /* a face runs along an edge between the star's position and another
                                  one */
    uint64_t key;              /* by twin_key.h */
    uint32_t other;            /* position */
    uint32_t corner;           /* at which the run begins */
    uint32_t slot;             /* of the star */
    uint32_t out;              /* nonzero: from the star's position to the other */
} core_edge_run;

typedef struct core_twin {
    uint64_t key; /* the same for a face and its twins */
    uint32_t face, way;
} core_twin; /* way: 0 or 1; faces of one group with the same way are wound alike */

/* Told of what is not two faces that run opposite ways. Any may be NULL. Called by several threads,
 * each with a block of its own; positions ascend in a block; positions with very many corners come
 * last, in the block numbered norma_core_topology_blocks() - 1. */
typedef struct core_topology_visitor {
    void *context;
    void (*edge)(void *context, size_t block, uint32_t position, const core_edge_run *runs,
        size_t count); /* open, conflict, many; each once, at its lower position */
    void (*bow_tie)(void *context, size_t block, uint32_t position,
        size_t fans); /* two fans or more meet in nothing but the position */
    void (*twins)(void *context, size_t block, const core_twin *twins,
        size_t count); /* faces with the same edges, ascending */
} core_topology_visitor;

/* checked: as norma_core_mesh_content left it. Welds as call's options say. What it returns but
 * NORMA_OK leaves nothing to close. O(positions + corners). */
norma_result norma_core_topology_open(
    core_call *call, const core_mesh *checked, core_topology *topology);
void norma_core_topology_close(core_topology *topology);

/* Sorts the corners around each position and pairs the edges. O(corners log of the valence). */
size_t norma_core_topology_blocks(const core_topology *topology);
norma_result norma_core_pair_edges(core_topology *topology, const core_topology_visitor *visitor);

/* The kept corner behind a kept corner, and the one before it. */
static inline size_t norma_core_topology_next(const core_topology *t, size_t face, size_t corner) {
    return t->polygons       ? norma_core_next_kept(&t->mesh, face, corner)
           : corner % 3 == 2 ? corner - 2
                             : corner + 1;
}
/* Of a corner of any mesh. */
static inline size_t norma_core_topology_face(const core_topology *t, size_t corner) {
    return t->polygons ? t->corners_of.faces[corner] : corner / 3;
}
#endif
