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
static uint32_t find_borrowed_from(const core_prepared_mesh *prepared, const core_star *star,
    const edge_side *own, const edge_side *other, uint64_t key) {
    const size_t partners = norma_core_partner_count(other, key);
    uint32_t found = UINT32_MAX;
    if (partners == 1 &&
        norma_core_partner_count(own, norma_core_only_partner(other, key)->key) == 1) {
        const star_corner *c = &star->corners[norma_core_only_partner(other, key)->corner];
        return c->flags & STAR_VOTES ? c->face : UINT32_MAX;
    }
    if (prepared->call->options.non_manifold != NORMA_NON_MANIFOLD_SMOOTH) return UINT32_MAX;
    for (size_t i = 0; i < other->count; i++) {
        const star_corner *c = &star->corners[other->edges[i].corner];
        if (other->edges[i].key != key && (c->flags & STAR_VOTES) && c->face < found)
            found = c->face;
    }
    return found;
}

static void borrow_for_side(const core_prepared_mesh *prepared, const core_star *star,
    const edge_side *own, const edge_side *other, const uint32_t *longest,
    uint32_t *borrowed_from) {
    for (size_t i = 0; i < own->count; i++) {
        const star_corner *c = &star->corners[own->edges[i].corner];
        if (!(c->flags & STAR_FLAT)) continue;
        const uint32_t begin = own->edges[i].back ? c->previous_corner : c->corner;
        if (longest[c->face] == begin)
            borrowed_from[c->face] =
                find_borrowed_from(prepared, star, own, other, own->edges[i].key);
    }
}

void norma_core_star_borrow_directions(const core_prepared_mesh *prepared, core_star *star,
    const uint32_t *longest, uint32_t *borrowed_from) {
    norma_core_list_edges(star);
    for (size_t begin = 0, end; begin < star->edge_count; begin = end) {
        const edge e = norma_core_edge_at(star, begin, &end);
        if (star->position > star->edges[begin].other) continue;
        borrow_for_side(prepared, star, &e.out, &e.back, longest, borrowed_from);
        borrow_for_side(prepared, star, &e.back, &e.out, longest, borrowed_from);
    }
}
