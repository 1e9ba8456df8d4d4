/* borrowed_direction.c: a face without a direction borrows that of the face it shares its longest
 * edge with. */
#include "core/corner/star_edges.h"
#include "core/face/face.h"
#include <math.h>

typedef struct face_edge {
    uint32_t corner; /* at which it begins */
    double from[3], to[3], square;
} face_edge;

static face_edge load_edge(const core_mesh *mesh, size_t face, size_t corner) {
    face_edge e = {.corner = (uint32_t)corner};
    double along[3];
    norma_core_position(mesh, norma_core_corner(mesh, corner), e.from);
    norma_core_position(
        mesh, norma_core_corner(mesh, norma_core_next_kept(mesh, face, corner)), e.to);
    norma_core_subtract(e.to, e.from, along);
    e.square = norma_core_dot(along, along);
    return e;
}

/* |from - to|^2 = from^2 - 2 from to + to^2 */
static void add_square(exact_sum *sum, const face_edge *e, int negative) {
    for (int k = 0; k < 3; k++) {
        norma_exact_add(sum, (const double[]){e->from[k], e->from[k]}, 2, negative);
        norma_exact_add(sum, (const double[]){e->to[k], e->to[k]}, 2, negative);
        norma_exact_add(sum, (const double[]){2, e->from[k], e->to[k]}, 3, !negative);
    }
}

/* Exactly, where rounded squares are too near each other to tell. */
static int is_longer(const face_edge *a, const face_edge *b) {
    const double difference = a->square - b->square, sum = a->square + b->square;
    if (fabs(difference) > 0x1p-48 * sum && sum > NORMA_TINIEST && sum < NORMA_HUGEST)
        return difference > 0;
    exact_sum exact;
    norma_exact_clear(&exact);
    add_square(&exact, a, 0);
    add_square(&exact, b, 1);
    return norma_exact_round(&exact).mantissa > 0;
}

uint32_t norma_core_longest_edge(const core_mesh *mesh, size_t face) {
    face_edge longest = {.corner = UINT32_MAX};
    for (size_t c = norma_core_face_begin(mesh, face); c < norma_core_face_end(mesh, face); c++) {
        if (!norma_core_is_kept(mesh, face, c)) continue;
        const face_edge e = load_edge(mesh, face, c);
        if (longest.corner == UINT32_MAX || is_longer(&e, &longest)) longest = e;
    }
    return longest.corner;
}

/* The one face that shares the edge with a flat face, if it has a direction of its own. */
static uint32_t find_borrowed_from(const core_prepared_mesh *prepared, const core_star *star,
    const star_edge *flat, const edge_side *own, const edge_side *other) {
    const star_edge *partner = prepared->call->options.non_manifold == NORMA_NON_MANIFOLD_SMOOTH
                                   ? norma_core_partners_of(flat, other).only
                                   : norma_core_mutual_partner(flat, own, other);
    if (!partner || !(star->corners[partner->corner].flags & STAR_VOTES)) return UINT32_MAX;
    return star->corners[partner->corner].face;
}

static void borrow_for_side(const core_prepared_mesh *prepared, const core_star *star,
    const edge_side *own, const edge_side *other, const uint32_t *longest,
    uint32_t *borrowed_from) {
    for (size_t i = 0; i < own->count; i++) {
        const star_corner *c = &star->corners[own->edges[i].corner];
        if (!(c->flags & STAR_FLAT)) continue;
        const uint32_t begin = own->edges[i].back ? c->previous_corner : c->corner;
        if (longest[c->face] == begin)
            borrowed_from[c->face] = find_borrowed_from(prepared, star, &own->edges[i], own, other);
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
