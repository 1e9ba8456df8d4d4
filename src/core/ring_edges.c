/* ring_edges.c: who shares the edges that leave a position, and which of those edges are smooth.
 *
 * The faces at an edge are sorted by direction and by what twins have in common. A face's partners are then all those that run the other way, less the
 * equal range of its own twins: found by bisection, so that an edge of a million faces costs no more a face than one of two. */
#include "ring.h"
#include "triangle.h"

/* ---- sorting: by the position at the other end, direction, key, order of corners */

static int edge_less(const ring_edge *a, const ring_edge *b)
{
    if (a->other != b->other) return a->other < b->other;
    if (a->back != b->back) return a->back < b->back;
    if (a->key != b->key) return a->key < b->key;
    return a->corner < b->corner;
}

static void insertion_sort(ring_edge *edges, size_t count)
{
    for (size_t i = 1; i < count; i++) {
        const ring_edge edge = edges[i];
        size_t at = i;
        for (; at > 0 && edge_less(&edge, &edges[at - 1]); at--) edges[at] = edges[at - 1];
        edges[at] = edge;
    }
}

static void merge(const ring_edge *from, size_t begin, size_t middle, size_t end, ring_edge *to)
{
    size_t left = begin, right = middle;
    for (size_t at = begin; at < end; at++) {
        const int take_right = left == middle || (right < end && edge_less(&from[right], &from[left]));
        to[at] = take_right ? from[right++] : from[left++];
    }
}

enum { SORTED_RUN = 16 };

static size_t least(size_t a, size_t b) { return a < b ? a : b; }

/* Sorts ring->edges; merging from runs that insertion has sorted, O(n log n) for any ring. */
static void sort_edges(core_ring *ring)
{
    const size_t count = ring->edge_count;
    for (size_t begin = 0; begin < count; begin += SORTED_RUN) insertion_sort(ring->edges + begin, least(SORTED_RUN, count - begin));
    for (size_t run = SORTED_RUN; run < count; run *= 2) {
        for (size_t begin = 0; begin < count; begin += 2 * run) merge(ring->edges, begin, least(begin + run, count), least(begin + 2 * run, count), ring->sorted);
        ring_edge *sorted = ring->sorted;
        ring->sorted = ring->edges;
        ring->edges = sorted;
    }
}

static void list_edges(core_ring *ring)
{
    ring->edge_count = 0;
    for (uint32_t i = 0; i < ring->count; i++) {
        const ring_corner *c = &ring->corners[i];
        if (!(c->flags & RING_KEPT)) continue;
        ring->edges[ring->edge_count++] = (ring_edge){.key = c->next_key, .other = c->next, .corner = i};
        ring->edges[ring->edge_count++] = (ring_edge){.key = c->previous_key, .other = c->previous, .back = 1, .corner = i};
    }
    sort_edges(ring);
}

/* ---- one edge */

typedef struct edge_side { const ring_edge *edges; size_t count; } edge_side;  /* the faces that run along it one way, by key */
typedef struct edge { edge_side out, back; } edge;

static size_t first_not_below(const edge_side *side, uint64_t key, int above)
{
    size_t low = 0, high = side->count;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (side->edges[middle].key < key || (above && side->edges[middle].key == key)) low = middle + 1;
        else high = middle;
    }
    return low;
}

static size_t partner_count(const edge_side *other, uint64_t key)
{
    return other->count - (first_not_below(other, key, 1) - first_not_below(other, key, 0));
}

/* The one of another key, where there is just one: twins lie together, so it is first or last. */
static const ring_edge *only_partner(const edge_side *other, uint64_t key)
{
    return other->edges[0].key != key ? &other->edges[0] : &other->edges[other->count - 1];
}

/* The edge that begins at edges[begin]; *end is where the next one does. */
static edge edge_at(const core_ring *ring, size_t begin, size_t *end)
{
    size_t middle = begin, stop;
    const uint32_t other = ring->edges[begin].other;
    while (middle < ring->edge_count && ring->edges[middle].other == other && !ring->edges[middle].back) middle++;
    for (stop = middle; stop < ring->edge_count && ring->edges[stop].other == other;) stop++;
    *end = stop;
    return (edge){{ring->edges + begin, middle - begin}, {ring->edges + middle, stop - middle}};
}

/* ---- smooth or hard */

static uint32_t fan_of(core_ring *ring, uint32_t corner)
{
    ring_corner *c = ring->corners;
    while (c[corner].fan != corner) {
        c[corner].fan = c[c[corner].fan].fan;
        corner = c[corner].fan;
    }
    return corner;
}

static void join(core_ring *ring, uint32_t a, uint32_t b)
{
    const uint32_t fan_a = fan_of(ring, a), fan_b = fan_of(ring, b);
    if (fan_a < fan_b) ring->corners[fan_b].fan = fan_a;
    else ring->corners[fan_a].fan = fan_b;
}

/* Far from the threshold the cosine tells; near it, where it cannot, the angle does. */
static int within_crease(const core_surface *surface, const ring_corner *a, const ring_corner *b)
{
    static const double doubt = 0x1p-30;
    double cross[3];
    const double cosine = norma_core_dot(a->normal, b->normal);
    if (cosine > surface->crease_cosine + doubt) return 1;
    if (cosine < surface->crease_cosine - doubt) return 0;
    norma_core_cross(a->normal, b->normal, cross);
    return norma_core_angle(norma_core_length(cross), cosine) <= surface->crease;
}

/* out begins at the ring's position, back ends there. Swapping the two changes no bit, so both ends of the edge agree. */
static int is_smooth(const core_surface *surface, const core_ring *ring, const ring_edge *out, const ring_edge *back)
{
    const ring_corner *a = &ring->corners[out->corner], *b = &ring->corners[back->corner];
    const core_mesh *mesh = &surface->mesh;
    if (!(a->flags & RING_HAS_NORMAL) || !(b->flags & RING_HAS_NORMAL)) return 0;
    if (mesh->hard_edges && (mesh->hard_edges[a->corner] || mesh->hard_edges[b->previous_corner])) return 0;
    if (mesh->smoothing_groups && !(mesh->smoothing_groups[a->face] & mesh->smoothing_groups[b->face])) return 0;
    if (surface->crease >= NORMA_PI) return 1;
    return within_crease(surface, a, b);
}

/* ---- counting */

static uint32_t least_begin(const core_ring *ring, const edge *e)
{
    uint32_t first = UINT32_MAX;
    for (size_t i = 0; i < e->out.count; i++) {
        const uint32_t corner = ring->corners[e->out.edges[i].corner].corner;
        if (corner < first) first = corner;
    }
    for (size_t i = 0; i < e->back.count; i++) {
        const uint32_t corner = ring->corners[e->back.edges[i].corner].previous_corner;
        if (corner < first) first = corner;
    }
    return first;
}

static int each_has_one_partner(const edge_side *side, const edge_side *other)
{
    for (size_t i = 0; i < side->count; i++)
        if (partner_count(other, side->edges[i].key) != 1) return 0;
    return 1;
}

typedef struct pairs { size_t smooth, hard; } pairs;                      /* of faces that are each other's only partner */

static void count_edge(const core_ring *ring, const edge *e, pairs pair, ring_counts *counts)
{
    const size_t faces = e->out.count + e->back.count;
    const int of_one_face = faces == 1 || (faces == 2 && e->out.count == 1 && ring->corners[e->out.edges[0].corner].face == ring->corners[e->back.edges[0].corner].face);
    counts->edges.count++;
    if (of_one_face) counts->edges.open++;
    else if (pair.hard || (faces == 2 && !pair.smooth)) counts->edges.hard++;
    else if (pair.smooth) counts->edges.smooth++;
    if (faces == 2 && (e->out.count == 2 || e->back.count == 2)) norma_core_count_one(&counts->conflicts, least_begin(ring, e));
    if (faces > 2 && !(each_has_one_partner(&e->out, &e->back) && each_has_one_partner(&e->back, &e->out)))
        norma_core_count_one(&counts->non_manifold, least_begin(ring, e));
}

/* ---- joining */

/* Between all partners, whether or not they are each other's only one. */
static void join_all_partners(const core_surface *surface, core_ring *ring, const edge *e)
{
    for (size_t i = 0; i < e->out.count; i++)
        for (size_t j = 0; j < e->back.count; j++) {
            const ring_edge *out = &e->out.edges[i], *back = &e->back.edges[j];
            if (out->key == back->key || fan_of(ring, out->corner) == fan_of(ring, back->corner)) continue;
            if (is_smooth(surface, ring, out, back)) join(ring, out->corner, back->corner);
        }
}

static pairs join_only_partners(const core_surface *surface, core_ring *ring, const edge *e)
{
    pairs pair = {0, 0};
    for (size_t i = 0; i < e->out.count; i++) {
        const ring_edge *out = &e->out.edges[i];
        if (partner_count(&e->back, out->key) != 1) continue;
        const ring_edge *back = only_partner(&e->back, out->key);
        if (partner_count(&e->out, back->key) != 1) continue;
        if (is_smooth(surface, ring, out, back)) {
            join(ring, out->corner, back->corner);
            pair.smooth++;
        } else {
            pair.hard++;
        }
    }
    return pair;
}

/* A corner that the next one of its face repeats shares that one's fan. */
static void join_repeated(const core_surface *surface, core_ring *ring)
{
    if (!surface->faces) return;
    for (uint32_t i = 0; i < ring->count; i++) {
        const ring_corner *c = &ring->corners[i];
        if ((c->flags & RING_KEPT) || !(surface->faces[c->face].flags & CORE_FACE_EDGED)) continue;
        const uint32_t next = (uint32_t)norma_core_next_in_face(&surface->mesh, c->face, c->corner);
        size_t low = 0, high = ring->count;
        while (low < high) {
            const size_t middle = low + (high - low) / 2;
            if (ring->corners[middle].corner < next) low = middle + 1;
            else high = middle;
        }
        join(ring, i, (uint32_t)low);
    }
}

void norma_core_ring_join_fans(const core_surface *surface, core_ring *ring, ring_counts *counts)
{
    list_edges(ring);
    for (size_t begin = 0, end; begin < ring->edge_count; begin = end) {
        const edge e = edge_at(ring, begin, &end);
        const pairs pair = join_only_partners(surface, ring, &e);
        if (surface->call->options.non_manifold == NORMA_NON_MANIFOLD_SMOOTH && end - begin > 2) join_all_partners(surface, ring, &e);
        if (counts && ring->position < ring->edges[begin].other) count_edge(ring, &e, pair, counts);
    }
    join_repeated(surface, ring);
    for (uint32_t i = 0; i < ring->count; i++) ring->corners[i].fan = fan_of(ring, i);
}

/* ---- lending a direction */

static double squared_edge(const core_mesh *mesh, size_t from, size_t to)
{
    double p[3], q[3], d[3];
    norma_core_position(mesh, norma_core_corner(mesh, from), p);
    norma_core_position(mesh, norma_core_corner(mesh, to), q);
    norma_core_subtract(p, q, d);
    return norma_core_dot(d, d);
}

uint32_t norma_core_longest_edge(const core_mesh *mesh, size_t face)
{
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

/* Of the partners that share the edge with a flat face: the only one, or under the smooth policy the first that has a direction. */
static uint32_t lender_among(const core_surface *surface, const core_ring *ring, const edge_side *own, const edge_side *other, uint64_t key)
{
    const size_t partners = partner_count(other, key);
    uint32_t found = UINT32_MAX;
    if (partners == 1 && partner_count(own, only_partner(other, key)->key) == 1) {
        const ring_corner *c = &ring->corners[only_partner(other, key)->corner];
        return c->flags & RING_VOTES ? c->face : UINT32_MAX;
    }
    if (surface->call->options.non_manifold != NORMA_NON_MANIFOLD_SMOOTH) return UINT32_MAX;
    for (size_t i = 0; i < other->count; i++) {
        const ring_corner *c = &ring->corners[other->edges[i].corner];
        if (other->edges[i].key != key && (c->flags & RING_VOTES) && c->face < found) found = c->face;
    }
    return found;
}

static void lend_to_side(const core_surface *surface, const core_ring *ring, const edge_side *own, const edge_side *other, const uint32_t *longest, uint32_t *lender)
{
    for (size_t i = 0; i < own->count; i++) {
        const ring_corner *c = &ring->corners[own->edges[i].corner];
        if (!(c->flags & RING_FLAT)) continue;
        const uint32_t begin = own->edges[i].back ? c->previous_corner : c->corner;
        if (longest[c->face] == begin) lender[c->face] = lender_among(surface, ring, own, other, own->edges[i].key);
    }
}

void norma_core_ring_lend(const core_surface *surface, core_ring *ring, const uint32_t *longest, uint32_t *lender)
{
    list_edges(ring);
    for (size_t begin = 0, end; begin < ring->edge_count; begin = end) {
        const edge e = edge_at(ring, begin, &end);
        if (ring->position > ring->edges[begin].other) continue;
        lend_to_side(surface, ring, &e.out, &e.back, longest, lender);
        lend_to_side(surface, ring, &e.back, &e.out, longest, lender);
    }
}
