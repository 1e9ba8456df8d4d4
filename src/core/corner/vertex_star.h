/* vertex_star.h: the corners around one position, joined into fans by the smooth edges between
 * their faces, and the sum of each fan. */
#ifndef NORMA_CORE_RING_H
#define NORMA_CORE_RING_H
#include "core/corner/prepared_mesh.h"

enum {
    RING_VOTES = 1,
    RING_KEPT = 2,
    RING_HAS_NORMAL = 4,
    RING_FLAT = 8
}; /* flat: finite, with edges, without a direction of its own */

typedef struct ring_corner {
    double normal[3];                /* of its face, its own or borrowed; with RING_HAS_NORMAL */
    double weight;                   /* with RING_VOTES */
    uint64_t next_key, previous_key; /* what its face has in common with its twin at the edge to
                                        next, from previous */
    uint32_t corner, face;
    uint32_t next, previous;  /* welded positions of its kept neighbours; with RING_KEPT */
    uint32_t previous_corner; /* where the edge from previous begins */
    uint32_t fan;             /* ring number of a corner of the same fan, lower or its own; after
                                 ring_close_fans the lowest */
    uint8_t flags;
} ring_corner;

typedef struct ring_edge { /* a face runs along the edge from the ring's position to the other one,
                              or back */
    uint64_t key;
    uint32_t other, back;
    uint32_t corner; /* ring number */
} ring_edge;

typedef struct ring_sum {
    double sum[3], weight;
    size_t votes;
} ring_sum;

typedef struct core_fan {
    float normal[3]; /* with NORMA_REASON_NONE */
    uint32_t reason; /* NORMA_REASON_NONE, UNREFERENCED, CANCELLED or NON_FINITE */
} core_fan;

typedef struct core_ring {
    ring_corner *corners;
    ring_edge *edges, *sorted; /* two for each corner */
    ring_sum *sums;            /* these two of each fan */
    core_fan *fans;
    uint32_t
        *fan_of; /* of each corner, the number of its fan, in the order of their first corners */
    double (*normals)[3]; /* scratch of the visible weight */
    size_t count, edge_count, fan_count;
    uint32_t position;
    int finite; /* the position itself */
    int waits;  /* a face here must borrow a direction, and nobody has looked yet whose */
    norma_count degenerate; /* triangles without a direction whose first corner is here */
} core_ring;

enum { RING_ROOM = 64 };
typedef struct ring_room { /* what a ring of ordinary size needs, for the stack */
    ring_corner corners[RING_ROOM];
    ring_edge edges[2 * RING_ROOM], sorted[2 * RING_ROOM];
    ring_sum sums[RING_ROOM];
    core_fan fans[RING_ROOM];
    uint32_t fan_of[RING_ROOM];
    double normals[RING_ROOM][3];
} ring_room;

typedef struct ring_counts {
    norma_count non_manifold, conflicts;
    norma_edges edges;
} ring_counts;

void norma_core_ring_in_room(core_ring *ring, ring_room *room);
norma_result norma_core_ring_allocate(const core_call *call, core_ring *ring, size_t corners);
void norma_core_ring_release(const core_call *call, core_ring *ring, size_t corners);

/* Of a position, no corners yet. */
void norma_core_ring_begin(const core_surface *surface, uint32_t position, core_ring *ring);
/* Fills the ring with some of the corners at its position, ascending, whatever it held before;
 * weights only where asked, since joining needs none. */
void norma_core_ring_fill(const core_surface *surface, const uint32_t *corners, size_t count,
    int with_weights, core_ring *ring);
/* With all of them. */
void norma_core_ring_load(
    const core_surface *surface, uint32_t position, int with_weights, core_ring *ring);
/* One fan of each; or fans by smooth edges, counts (may be NULL) of the edges to positions of
 * higher number. */
void norma_core_ring_join_all(core_ring *ring);
void norma_core_ring_join_fans(const core_surface *surface, core_ring *ring, ring_counts *counts);
/* The edges that are listed in the ring, sorted. */
void norma_core_ring_join_listed(const core_surface *surface, core_ring *ring, ring_counts *counts);
/* Adds a corner's vote, if it has one. */
void norma_core_ring_vote(const ring_corner *corner, ring_sum *sum);
/* Sums each fan in ascending order of corners, and gives it a normal or the reason why it has none.
 */
void norma_core_ring_sum(const core_surface *surface, core_ring *ring);
/* The normal of a fan of voters, or that they cancel. */
void norma_core_decide_sum(const double sum[3], double weight, core_fan *fan);
/* The most visible normal of some corners alone, given as ring numbers. */
void norma_core_ring_see_some(
    core_ring *ring, const uint32_t *members, size_t count, core_fan *fan);

/* The corner at which the face's longest edge begins; ties: the first one's. */
uint32_t norma_core_longest_edge(const core_mesh *mesh, size_t face);
/* For flat faces whose longest edge (by face) runs between this position and one of higher number:
 * who lends them a direction. */
void norma_core_ring_lend(
    const core_surface *surface, core_ring *ring, const uint32_t *longest, uint32_t *lender);

/* The axis of the smallest cone round unit vectors; 0 where no open hemisphere holds them. O(count)
 * for each of the few vectors that widen it. */
int norma_core_smallest_cone(const double (*normals)[3], size_t count, double axis[3]);
#endif
