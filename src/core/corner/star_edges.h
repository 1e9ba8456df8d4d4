/* star_edges.h: the edges that leave a star's position, one after the other. */
#ifndef NORMA_CORE_STAR_EDGES_H
#define NORMA_CORE_STAR_EDGES_H
#include "core/corner/vertex_star.h"
#include "core/face/face.h"

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

/* Two that run along it opposite ways are partners, unless one is the other's reversed twin: of the
 * same positions in opposite order, back to back. A face that runs both ways is two there, each the
 * other's partner (a slit); but of one that is its own reverse, as (a, b, c, b) is, they are twins.
 */
static inline int norma_core_are_partners(const star_edge *a, const star_edge *b) {
    return b->key != norma_core_key_of_twin(a->key);
}

typedef struct edge_partners {
    size_t count;
    const star_edge *only; /* where there is just one, else NULL */
} edge_partners;
/* The partners of own among those that run the other way; by bisection. */
edge_partners norma_core_partners_of(const star_edge *own, const edge_side *other);
/* Each other's only one: that of own, or NULL. */
const star_edge *norma_core_mutual_partner(
    const star_edge *own, const edge_side *side, const edge_side *other);
/* The first edge of the side with this key or a higher one; above: with a higher one. */
size_t norma_core_first_not_below(const edge_side *side, uint64_t key, int above);

/* By crease.h, out begins at the star's position, back ends there. Swapping the two changes no bit,
 * so both ends of the edge agree. */
int norma_core_edge_is_smooth(const core_prepared_mesh *prepared, const core_star *star,
    const star_edge *out, const star_edge *back);

/* crowded_edge.c: joins all partners at an edge of very many faces; along: its unit direction. 0:
 * not done, each pair must be tried. */
int norma_core_join_crowded_edge(
    const core_prepared_mesh *prepared, core_star *star, const edge *e, const double along[3]);
#endif
