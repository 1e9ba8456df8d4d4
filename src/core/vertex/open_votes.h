/* open_votes.h: what the faces of a mesh add at its positions, in sums that depend on no order. */
#ifndef NORMA_CORE_OPEN_VOTES_H
#define NORMA_CORE_OPEN_VOTES_H
#include "core/mesh/mesh.h"
#include "core/vertex/open_sum.h"

typedef struct open_voting {
    const core_mesh *mesh; /* checked, welded */
    norma_weight weight;   /* not "visible", which is no sum */
    const uint8_t *silent; /* nonzero: this face does not vote; NULL: all do */
    int reversed;          /* nonzero: the faces' other sides vote */
} open_voting;

/* sums: of each position of the mesh; faces add to those of the positions that corners are welded
 * to. degenerate counts faces without a direction. */
void norma_core_open_votes(const open_voting *voting, open_sum *sums, norma_count *degenerate);
/* The direction of a sum. Returns NORMA_REASON_NONE, UNREFERENCED (no votes) or CANCELLED. */
int norma_core_open_direction(const open_sum *sum, double direction[3]);
#endif
