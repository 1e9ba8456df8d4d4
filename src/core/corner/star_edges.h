/* star_edges.h: the edges that leave a star's position, one after the other. */
#ifndef NORMA_CORE_STAR_EDGES_H
#define NORMA_CORE_STAR_EDGES_H
#include "core/corner/vertex_star.h"

typedef struct edge_side {
    const star_edge *edges;
    size_t count;
} edge_side; /* the faces that run along it one way, by key */
typedef struct edge {
    edge_side out, back;
} edge;

/* star_edges.c: sorts the star's edges by the position at the other end, direction, key. O(n log
 * n). */
void norma_core_list_edges(core_star *star);
/* Sorts those that are listed already. */
void norma_core_sort_edges(core_star *star);
/* The edge that begins at edges[begin]; *end is where the next one does. */
edge norma_core_edge_at(const core_star *star, size_t begin, size_t *end);

/* Those that run the other way, twins left out; by bisection. */
size_t norma_core_partner_count(const edge_side *other, uint64_t key);
size_t norma_core_first_not_below(const edge_side *side, uint64_t key, int above);
/* The one of another key, where there is just one: twins lie together, so it is first or last. */
const star_edge *norma_core_only_partner(const edge_side *other, uint64_t key);

/* By crease.h, out begins at the star's position, back ends there. Swapping the two changes no bit,
 * so both ends of the edge agree. */
int norma_core_edge_is_smooth(const core_prepared_mesh *prepared, const core_star *star,
    const star_edge *out, const star_edge *back);

/* crowded_edge.c: joins all partners at an edge of very many faces; along: its unit direction. 0:
 * not done, each pair must be tried. */
int norma_core_join_crowded_edge(
    const core_prepared_mesh *prepared, core_star *star, const edge *e, const double along[3]);
#endif
