/* fans.c: which edges of a ring are smooth, the fans that they join, and the counts of edges. */
#include "core/corner/star_edges.h"
#include "core/face/triangle.h"

uint32_t norma_core_fan_of(core_ring *ring, uint32_t corner) {
    ring_corner *c = ring->corners;
    while (c[corner].fan != corner) {
        c[corner].fan = c[c[corner].fan].fan;
        corner = c[corner].fan;
    }
    return corner;
}

void norma_core_join(core_ring *ring, uint32_t a, uint32_t b) {
    const uint32_t fan_a = norma_core_fan_of(ring, a), fan_b = norma_core_fan_of(ring, b);
    if (fan_a < fan_b)
        ring->corners[fan_b].fan = fan_a;
    else
        ring->corners[fan_a].fan = fan_b;
}

/* Far from the threshold the cosine tells; near it, where it cannot, the angle does. */
static int within_crease(const core_surface *surface, const ring_corner *a, const ring_corner *b) {
    static const double doubt = 0x1p-30;
    double cross[3];
    const double cosine = norma_core_dot(a->normal, b->normal);
    if (cosine > surface->crease_cosine + doubt) return 1;
    if (cosine < surface->crease_cosine - doubt) return 0;
    norma_core_cross(a->normal, b->normal, cross);
    return norma_core_angle(norma_core_length(cross), cosine) <= surface->crease;
}

int norma_core_edge_is_smooth(const core_surface *surface, const core_ring *ring,
    const ring_edge *out, const ring_edge *back) {
    const ring_corner *a = &ring->corners[out->corner], *b = &ring->corners[back->corner];
    const core_mesh *mesh = &surface->mesh;
    if (!(a->flags & RING_HAS_NORMAL) || !(b->flags & RING_HAS_NORMAL)) return 0;
    if (mesh->hard_edges && (mesh->hard_edges[a->corner] || mesh->hard_edges[b->previous_corner]))
        return 0;
    if (mesh->smoothing_groups &&
        !(mesh->smoothing_groups[a->face] & mesh->smoothing_groups[b->face]))
        return 0;
    if (surface->crease >= NORMA_PI) return 1;
    return within_crease(surface, a, b);
}

/* ---- counting */

static uint32_t least_begin(const core_ring *ring, const edge *e) {
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

static int each_has_one_partner(const edge_side *side, const edge_side *other) {
    for (size_t i = 0; i < side->count; i++)
        if (norma_core_partner_count(other, side->edges[i].key) != 1) return 0;
    return 1;
}

typedef struct pairs {
    size_t smooth, hard;
} pairs; /* of faces that are each other's only partner */

static void count_edge(const core_ring *ring, const edge *e, pairs pair, ring_counts *counts) {
    const size_t faces = e->out.count + e->back.count;
    const int of_one_face = faces == 1 || (faces == 2 && e->out.count == 1 &&
                                              ring->corners[e->out.edges[0].corner].face ==
                                                  ring->corners[e->back.edges[0].corner].face);
    counts->edges.count++;
    if (of_one_face)
        counts->edges.open++;
    else if (pair.hard || (faces == 2 && !pair.smooth))
        counts->edges.hard++;
    else if (pair.smooth)
        counts->edges.smooth++;
    if (faces == 2 && (e->out.count == 2 || e->back.count == 2))
        norma_core_count_one(&counts->conflicts, least_begin(ring, e));
    if (faces > 2 &&
        !(each_has_one_partner(&e->out, &e->back) && each_has_one_partner(&e->back, &e->out)))
        norma_core_count_one(&counts->non_manifold, least_begin(ring, e));
}

/* ---- joining */

enum { MOST_PAIRS_TO_TRY = 4096 };

static void edge_direction(
    const core_surface *surface, const core_ring *ring, uint32_t other, double along[3]) {
    double p[3], q[3], d[3];
    norma_core_position(&surface->mesh, ring->position, p);
    norma_core_position(&surface->mesh, other, q);
    norma_core_subtract(q, p, d);
    norma_core_normalise(d, along);
}

/* Between all partners, whether or not they are each other's only one. */
static void join_all_partners(
    const core_surface *surface, core_ring *ring, const edge *e, uint32_t other) {
    double along[3];
    edge_direction(surface, ring, other, along);
    if (e->out.count * e->back.count > MOST_PAIRS_TO_TRY &&
        norma_core_join_fins(surface, ring, e, along))
        return;
    for (size_t i = 0; i < e->out.count; i++)
        for (size_t j = 0; j < e->back.count; j++) {
            const ring_edge *out = &e->out.edges[i], *back = &e->back.edges[j];
            if (out->key == back->key ||
                norma_core_fan_of(ring, out->corner) == norma_core_fan_of(ring, back->corner))
                continue;
            if (norma_core_edge_is_smooth(surface, ring, out, back))
                norma_core_join(ring, out->corner, back->corner);
        }
}

static pairs join_only_partners(const core_surface *surface, core_ring *ring, const edge *e) {
    pairs pair = {0, 0};
    for (size_t i = 0; i < e->out.count; i++) {
        const ring_edge *out = &e->out.edges[i];
        if (norma_core_partner_count(&e->back, out->key) != 1) continue;
        const ring_edge *back = norma_core_only_partner(&e->back, out->key);
        if (norma_core_partner_count(&e->out, back->key) != 1) continue;
        if (norma_core_edge_is_smooth(surface, ring, out, back)) {
            norma_core_join(ring, out->corner, back->corner);
            pair.smooth++;
        } else {
            pair.hard++;
        }
    }
    return pair;
}

/* A corner that the next one of its face repeats shares that one's fan. */
static void join_repeated(const core_surface *surface, core_ring *ring) {
    if (!surface->faces) return;
    for (uint32_t i = 0; i < ring->count; i++) {
        const ring_corner *c = &ring->corners[i];
        if ((c->flags & RING_KEPT) || !(surface->faces[c->face].flags & CORE_FACE_EDGED)) continue;
        const uint32_t next = (uint32_t)norma_core_next_in_face(&surface->mesh, c->face, c->corner);
        size_t low = 0, high = ring->count;
        while (low < high) {
            const size_t middle = low + (high - low) / 2;
            if (ring->corners[middle].corner < next)
                low = middle + 1;
            else
                high = middle;
        }
        norma_core_join(ring, i, (uint32_t)low);
    }
}

/* ---- ordinary rings, nearly all there are: along each edge runs one face out and one back, or one
 * alone; paired without sorting, to the same fans and counts */

enum { FEW_CORNERS = 16, NO_PARTNER = -1 };

typedef struct ordinary_ring {
    uint32_t next[FEW_CORNERS], previous[FEW_CORNERS];
    int back[FEW_CORNERS]; /* of each corner: the one whose face runs back along its edge to next */
    int met[FEW_CORNERS];  /* of each corner: whether its edge from previous is another's edge to
                              next */
} ordinary_ring;

static int pair_up(const core_ring *ring, ordinary_ring *o) {
    const int count = (int)ring->count;
    for (int i = 0; i < count; i++) {
        if (!(ring->corners[i].flags & RING_KEPT)) return 0;
        o->next[i] = ring->corners[i].next;
        o->previous[i] = ring->corners[i].previous;
        o->met[i] = 0;
    }
    for (int i = 0; i < count; i++) {
        int outs = 0, backs = 0, alike = 0;
        o->back[i] = NO_PARTNER;
        for (int j = 0; j < count; j++) {
            outs += o->next[j] == o->next[i];
            alike += o->previous[j] == o->previous[i];
            if (o->previous[j] != o->next[i]) continue;
            backs++;
            o->back[i] = j;
        }
        if (outs != 1 || alike != 1 || backs > 1) return 0;
        if (!backs) continue;
        if (ring->corners[i].next_key == ring->corners[o->back[i]].previous_key) return 0;
        o->met[o->back[i]] = 1;
    }
    return 1;
}

static int join_ordinary(const core_surface *surface, core_ring *ring, ring_counts *counts) {
    ordinary_ring o;
    norma_edges edges = {0, 0, 0, 0};
    if (ring->count > FEW_CORNERS || !pair_up(ring, &o)) return 0;
    for (uint32_t i = 0; i < ring->count; i++) {
        const size_t counted = ring->position < o.next[i];
        edges.count += counted;
        if (o.back[i] == NO_PARTNER) {
            edges.open += counted;
        } else {
            const ring_edge out = {.corner = i}, back = {.corner = (uint32_t)o.back[i]};
            const int smooth = norma_core_edge_is_smooth(surface, ring, &out, &back);
            if (smooth) norma_core_join(ring, out.corner, back.corner);
            *(smooth ? &edges.smooth : &edges.hard) += counted;
        }
        if (o.met[i] || ring->position >= o.previous[i]) continue;
        edges.count++;
        edges.open++;
    }
    if (counts) norma_core_edges_add(&counts->edges, &edges);
    return 1;
}

static void settle_fans(core_ring *ring) {
    for (uint32_t i = 0; i < ring->count; i++) ring->corners[i].fan = norma_core_fan_of(ring, i);
}

void norma_core_ring_join_listed(
    const core_surface *surface, core_ring *ring, ring_counts *counts) {
    for (size_t begin = 0, end; begin < ring->edge_count; begin = end) {
        const edge e = norma_core_edge_at(ring, begin, &end);
        const pairs pair = join_only_partners(surface, ring, &e);
        if (surface->call->options.non_manifold == NORMA_NON_MANIFOLD_SMOOTH && end - begin > 2)
            join_all_partners(surface, ring, &e, ring->edges[begin].other);
        if (counts && ring->position < ring->edges[begin].other) count_edge(ring, &e, pair, counts);
    }
}

void norma_core_ring_join_fans(const core_surface *surface, core_ring *ring, ring_counts *counts) {
    if (join_ordinary(surface, ring, counts)) {
        settle_fans(ring);
        return;
    }
    norma_core_list_edges(ring);
    norma_core_ring_join_listed(surface, ring, counts);
    join_repeated(surface, ring);
    settle_fans(ring);
}
