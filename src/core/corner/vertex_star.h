/* vertex_star.h: the corners around one position, joined into fans by the smooth edges between
 * their faces, and the sum of each fan. */
#ifndef NORMA_CORE_STAR_H
#define NORMA_CORE_STAR_H
#include "core/call/call.h"
#include "core/corner/prepared_mesh.h"

enum {
    STAR_VOTES = 1,
    STAR_KEPT = 2,
    STAR_HAS_NORMAL = 4,
    STAR_FLAT = 8
}; /* flat: finite, with edges, without a direction of its own */

typedef struct star_corner {
    double normal[3];                /* of its face, its own or borrowed; with STAR_HAS_NORMAL */
    double weight;                   /* with STAR_VOTES */
    uint64_t next_key, previous_key; /* by twin_key.h, of its face at the edge to next, from
                                        previous */
    uint32_t corner, face;
    uint32_t next, previous;  /* welded positions of its kept neighbours; with STAR_KEPT */
    uint32_t previous_corner; /* where the edge from previous begins */
    uint8_t flags;
} star_corner;

typedef struct star_edge { /* a face runs along the edge from the star's position to the other one,
                              or back */
    uint64_t key;
    uint32_t other, back;
    uint32_t corner; /* star number */
} star_edge;

typedef struct star_sum {
    double sum[3], weight;
    size_t votes;
} star_sum;

typedef struct core_fan {
    float normal[3]; /* with NORMA_REASON_NONE */
    uint32_t reason; /* NORMA_REASON_NONE, UNREFERENCED, CANCELLED or NON_FINITE */
} core_fan;

typedef struct core_star {
    star_corner *corners;
    star_edge *edges, *sorted; /* two for each corner */
    star_sum *sums;            /* these two of each fan */
    core_fan *fans;
    uint32_t *joined; /* of each corner, a star number of the same fan, lower or its own; once fans
                         are joined the lowest */
    uint32_t
        *fan_of; /* of each corner, the number of its fan, in the order of their first corners */
    double (*normals)[3]; /* scratch of the visible weight */
    size_t count, edge_count, fan_count;
    uint32_t position;
    int finite; /* the position itself */
    int waits;  /* a face here must borrow a direction, and nobody has looked yet whose */
    norma_count degenerate; /* triangles without a direction whose first corner is here */
} core_star;

enum { STAR_ROOM = 64 };
typedef struct star_room { /* what a star of ordinary size needs, for the stack */
    star_corner corners[STAR_ROOM];
    star_edge edges[2 * STAR_ROOM], sorted[2 * STAR_ROOM];
    star_sum sums[STAR_ROOM];
    core_fan fans[STAR_ROOM];
    uint32_t joined[STAR_ROOM], fan_of[STAR_ROOM];
    double normals[STAR_ROOM][3];
} star_room;

typedef struct star_counts {
    norma_count non_manifold, conflicts;
    norma_edges edges;
} star_counts;

void norma_core_star_in_room(core_star *star, star_room *room);
norma_result norma_core_star_allocate(const core_call *call, core_star *star, size_t corners);
void norma_core_star_release(const core_call *call, core_star *star, size_t corners);

/* Of a position, no corners yet. */
void norma_core_star_begin(const core_prepared_mesh *prepared, uint32_t position, core_star *star);
/* Fills the star with some of the corners at its position, ascending, whatever it held before;
 * weights only where asked, since joining needs none. */
void norma_core_star_fill(const core_prepared_mesh *prepared, const uint32_t *corners, size_t count,
    int with_weights, core_star *star);
/* With all of them. */
void norma_core_star_load(
    const core_prepared_mesh *prepared, uint32_t position, int with_weights, core_star *star);
/* One fan of each; or fans by smooth edges, counts (may be NULL) of the edges to positions of
 * higher number. */
void norma_core_star_join_all(core_star *star);
void norma_core_star_join_fans(
    const core_prepared_mesh *prepared, core_star *star, star_counts *counts);
/* The edges that are listed in the star, sorted. */
void norma_core_star_join_listed(
    const core_prepared_mesh *prepared, core_star *star, star_counts *counts);
/* Adds a corner's vote, if it has one. */
void norma_core_star_vote(const star_corner *corner, star_sum *sum);
/* Sums each fan in ascending order of corners, and gives it a normal or the reason why it has none.
 */
void norma_core_star_sum(const core_prepared_mesh *prepared, core_star *star);
/* The normal of a fan of voters, or that they cancel. */
void norma_core_decide_sum(const double sum[3], double weight, core_fan *fan);
/* The most visible normal of some corners alone, given as star numbers. */
void norma_core_star_see_some(
    core_star *star, const uint32_t *members, size_t count, core_fan *fan);

/* The corner at which the face's longest edge begins; ties: the first one's. */
uint32_t norma_core_longest_edge(const core_mesh *mesh, size_t face);
/* For flat faces whose longest edge (by face) runs between this position and one of higher number:
 * who lends them a direction. */
void norma_core_star_borrow_directions(const core_prepared_mesh *prepared, core_star *star,
    const uint32_t *longest, uint32_t *borrowed_from);

/* The axis of the smallest cone round unit vectors; 0 where no open hemisphere holds them. O(count)
 * for each of the few vectors that widen it. */
int norma_core_smallest_cone(const double (*normals)[3], size_t count, double axis[3]);
#endif
