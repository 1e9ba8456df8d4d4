/* conflicts.h: N301, what one mesh by itself (edges.c) and the primitives of a glTF mesh together
 * (conflicts_joined.c) have in common. */
#ifndef NORMA_CHECK_CONFLICTS_H
#define NORMA_CHECK_CONFLICTS_H
#include "check/rules/mesh_rules.h"

/* What is shown of the faces along an edge that both run along in the same direction. */
typedef enum conflict_kind {
    CONFLICT_TURNED,
    CONFLICT_UNDECIDED,
    CONFLICT_RIGHT,
    CONFLICT_KINDS
} conflict_kind;
/* Of the faces of two corners that begin such an edge, by the sides of all faces. A face that is
 * there twice is not wound against itself. */
conflict_kind norma_check_conflict_kind(
    const core_topology *topology, size_t first, size_t second, const uint8_t *sides);
/* Reports the hits of each kind and frees them; edges and sides: of the mesh's own faces. */
norma_result norma_check_add_conflicts(
    check_mesh *m, const uint8_t *edges, const uint8_t *sides, check_hits kinds[CONFLICT_KINDS]);

/* Of the primitive whose corners begin at first_corner of a topology that holds all of them; edges:
 * how many conflicts each of the topology's faces has, at most 255; sides: of those faces. An edge
 * between primitives belongs to the one whose face is turned, or has more of them. */
norma_result norma_check_conflicts_joined(check_mesh *m, const core_topology *topology,
    size_t first_corner, const uint8_t *edges, const uint8_t *sides);
int norma_check_count_conflicts(
    const core_topology *topology, uint8_t *edges); /* 1: there are any */
#endif
