/* star_edges.c: the edges that leave a position, and which faces are partners at them.
 *
 * The faces at an edge are sorted by direction and by twin_key.h. A face's partners are then all
 * those that run the other way, less the range of those with its twins' key: found by bisection, so
 * that an edge of a million faces costs no more a face than one of two. */
#include "core/corner/star_edges.h"

/* ---- sorting: by the position at the other end, direction, key, order of corners */

static int edge_less(const star_edge *a, const star_edge *b) {
    if (a->other != b->other) return a->other < b->other;
    if (a->back != b->back) return a->back < b->back;
    if (a->key != b->key) return a->key < b->key;
    return a->corner < b->corner;
}

static void insertion_sort(star_edge *edges, size_t count) {
    for (size_t i = 1; i < count; i++) {
        const star_edge moved = edges[i];
        size_t at = i;
        for (; at > 0 && edge_less(&moved, &edges[at - 1]); at--) edges[at] = edges[at - 1];
        edges[at] = moved;
    }
}

static void merge(const star_edge *from, size_t begin, size_t middle, size_t end, star_edge *to) {
    size_t left = begin, right = middle;
    for (size_t at = begin; at < end; at++) {
        const int take_right =
            left == middle || (right < end && edge_less(&from[right], &from[left]));
        to[at] = take_right ? from[right++] : from[left++];
    }
}

enum { SORTED_RUN = 16 };

static size_t least(size_t a, size_t b) { return a < b ? a : b; }

/* Sorts star->edges; merging from runs that insertion has sorted, O(n log n) for any star. */
void norma_core_sort_edges(core_star *star) {
    const size_t count = star->edge_count;
    for (size_t begin = 0; begin < count; begin += SORTED_RUN)
        insertion_sort(star->edges + begin, least(SORTED_RUN, count - begin));
    for (size_t run = SORTED_RUN; run < count; run *= 2) {
        for (size_t begin = 0; begin < count; begin += 2 * run)
            merge(star->edges, begin, least(begin + run, count), least(begin + 2 * run, count),
                star->sorted);
        star_edge *sorted = star->sorted;
        star->sorted = star->edges;
        star->edges = sorted;
    }
}

void norma_core_list_edges(core_star *star) {
    star->edge_count = 0;
    for (uint32_t i = 0; i < star->count; i++) {
        const star_corner *c = &star->corners[i];
        if (!(c->flags & STAR_KEPT)) continue;
        star->edges[star->edge_count++] =
            (star_edge){.key = c->next_key, .other = c->next, .corner = i};
        star->edges[star->edge_count++] =
            (star_edge){.key = c->previous_key, .other = c->previous, .back = 1, .corner = i};
    }
    norma_core_sort_edges(star);
}

/* ---- one edge */

size_t norma_core_first_not_below(const edge_side *side, uint64_t key, int above) {
    size_t low = 0, high = side->count;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (side->edges[middle].key < key || (above && side->edges[middle].key == key))
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

edge_partners norma_core_partners_of(const star_edge *own, const edge_side *other) {
    const uint64_t twin = norma_core_key_of_twin(own->key);
    const size_t begin = norma_core_first_not_below(other, twin, 0),
                 end = norma_core_first_not_below(other, twin, 1);
    edge_partners partners = {other->count - (end - begin), NULL};
    if (partners.count == 1)
        partners.only = &other->edges[begin ? 0 : end]; /* twins lie together */
    return partners;
}

const star_edge *norma_core_mutual_partner(
    const star_edge *own, const edge_side *side, const edge_side *other) {
    const star_edge *partner = norma_core_partners_of(own, other).only;
    return partner && norma_core_partners_of(partner, side).count == 1 ? partner : NULL;
}

edge norma_core_edge_at(const core_star *star, size_t begin, size_t *end) {
    size_t middle = begin, stop;
    const uint32_t other = star->edges[begin].other;
    while (middle < star->edge_count && star->edges[middle].other == other &&
           !star->edges[middle].back)
        middle++;
    for (stop = middle; stop < star->edge_count && star->edges[stop].other == other;) stop++;
    *end = stop;
    return (edge){{star->edges + begin, middle - begin}, {star->edges + middle, stop - middle}};
}

int norma_core_edge_is_smooth(const core_prepared_mesh *prepared, const core_star *star,
    const star_edge *out, const star_edge *back) {
    const star_corner *a = &star->corners[out->corner], *b = &star->corners[back->corner];
    return (a->flags & STAR_HAS_NORMAL) && (b->flags & STAR_HAS_NORMAL) &&
           norma_core_is_unmarked(
               &prepared->mesh, a->corner, a->face, b->previous_corner, b->face) &&
           norma_core_is_within_crease(&prepared->crease, a->normal, b->normal);
}
