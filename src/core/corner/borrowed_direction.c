/* borrowed_direction.c: a face without a direction borrows that of the face it shares its longest
 * edge with. */
#include "core/corner/star_edges.h"

static double squared_edge(const core_mesh *mesh, size_t from, size_t to) {
    double p[3], q[3], d[3];
    norma_core_position(mesh, norma_core_corner(mesh, from), p);
    norma_core_position(mesh, norma_core_corner(mesh, to), q);
    norma_core_subtract(p, q, d);
    return norma_core_dot(d, d);
}

uint32_t norma_core_longest_edge(const core_mesh *mesh, size_t face) {
    uint32_t longest = UINT32_MAX;
    double length = -1;
    for (size_t c = norma_core_face_begin(mesh, face); c < norma_core_face_end(mesh, face); c++) {
        if (!norma_core_is_kept(mesh, face, c)) continue;
        const double square = squared_edge(mesh, c, norma_core_next_kept(mesh, face, c));
        if (!(square > length)) continue;
        length = square;
        longest = (uint32_t)c;
    }
    return longest;
}

/* Of the partners that share the edge with a flat face: the only one, or under the smooth policy
 * the first that has a direction. */
static uint32_t lender_among(const core_surface *surface, const core_ring *ring,
    const edge_side *own, const edge_side *other, uint64_t key) {
    const size_t partners = norma_core_partner_count(other, key);
    uint32_t found = UINT32_MAX;
    if (partners == 1 &&
        norma_core_partner_count(own, norma_core_only_partner(other, key)->key) == 1) {
        const ring_corner *c = &ring->corners[norma_core_only_partner(other, key)->corner];
        return c->flags & RING_VOTES ? c->face : UINT32_MAX;
    }
    if (surface->call->options.non_manifold != NORMA_NON_MANIFOLD_SMOOTH) return UINT32_MAX;
    for (size_t i = 0; i < other->count; i++) {
        const ring_corner *c = &ring->corners[other->edges[i].corner];
        if (other->edges[i].key != key && (c->flags & RING_VOTES) && c->face < found)
            found = c->face;
    }
    return found;
}

static void lend_to_side(const core_surface *surface, const core_ring *ring, const edge_side *own,
    const edge_side *other, const uint32_t *longest, uint32_t *lender) {
    for (size_t i = 0; i < own->count; i++) {
        const ring_corner *c = &ring->corners[own->edges[i].corner];
        if (!(c->flags & RING_FLAT)) continue;
        const uint32_t begin = own->edges[i].back ? c->previous_corner : c->corner;
        if (longest[c->face] == begin)
            lender[c->face] = lender_among(surface, ring, own, other, own->edges[i].key);
    }
}

void norma_core_ring_lend(
    const core_surface *surface, core_ring *ring, const uint32_t *longest, uint32_t *lender) {
    norma_core_list_edges(ring);
    for (size_t begin = 0, end; begin < ring->edge_count; begin = end) {
        const edge e = norma_core_edge_at(ring, begin, &end);
        if (ring->position > ring->edges[begin].other) continue;
        lend_to_side(surface, ring, &e.out, &e.back, longest, lender);
        lend_to_side(surface, ring, &e.back, &e.out, longest, lender);
    }
}
