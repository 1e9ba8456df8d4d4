/* fans.c: which edges of a star are smooth, the fans that they join, and the counts of edges. */
#include "core/corner/star_edges.h"
#include "core/face/face.h"

/* ---- counting */

static uint32_t least_begin(const core_star *star, const edge *e) {
    uint32_t first = UINT32_MAX;
    for (size_t i = 0; i < e->out.count; i++) {
        const uint32_t corner = star->corners[e->out.edges[i].corner].corner;
        if (corner < first) first = corner;
    }
    for (size_t i = 0; i < e->back.count; i++) {
        const uint32_t corner = star->corners[e->back.edges[i].corner].previous_corner;
        if (corner < first) first = corner;
    }
    return first;
}

static int each_has_one_partner(const edge_side *side, const edge_side *other) {
    for (size_t i = 0; i < side->count; i++)
        if (norma_core_partners_of(&side->edges[i], other).count != 1) return 0;
    return 1;
}

typedef struct pairs {
    size_t smooth, hard;
} pairs; /* of faces that are each other's only partner */

static void count_edge(const core_star *star, const edge *e, pairs pair, star_counts *counts) {
    const size_t faces = e->out.count + e->back.count;
    counts->edges.count++;
    if (faces > 2 &&
        !(each_has_one_partner(&e->out, &e->back) && each_has_one_partner(&e->back, &e->out)))
        norma_core_count_one(&counts->non_manifold, least_begin(star, e));
    else if (faces == 2 && e->out.count != 1)
        norma_core_count_one(&counts->conflicts, least_begin(star, e));
    else if (faces == 1)
        counts->edges.open++;
    else if (pair.hard || !pair.smooth)
        counts->edges.hard++;
    else
        counts->edges.smooth++;
}

/* ---- joining */

enum { MOST_PAIRS_TO_TRY = 4096 };

static void edge_direction(
    const core_prepared_mesh *prepared, const core_star *star, uint32_t other, double along[3]) {
    double p[3], q[3], d[3];
    norma_core_position(&prepared->mesh, star->position, p);
    norma_core_position(&prepared->mesh, other, q);
    norma_core_subtract(q, p, d);
    norma_core_normalise(d, along);
}

/* Between all partners, whether or not they are each other's only one. */
static void join_all_partners(
    const core_prepared_mesh *prepared, core_star *star, const edge *e, uint32_t other) {
    double along[3];
    edge_direction(prepared, star, other, along);
    if (e->out.count * e->back.count > MOST_PAIRS_TO_TRY &&
        norma_core_join_crowded_edge(prepared, star, e, along))
        return;
    for (size_t i = 0; i < e->out.count; i++)
        for (size_t j = 0; j < e->back.count; j++) {
            const star_edge *out = &e->out.edges[i], *back = &e->back.edges[j];
            if (!norma_core_are_partners(out, back) ||
                norma_core_set_of(star->joined, out->corner) ==
                    norma_core_set_of(star->joined, back->corner))
                continue;
            if (norma_core_edge_is_smooth(prepared, star, out, back))
                norma_core_join_sets(star->joined, out->corner, back->corner);
        }
}

static pairs join_only_partners(
    const core_prepared_mesh *prepared, core_star *star, const edge *e) {
    pairs pair = {0, 0};
    for (size_t i = 0; i < e->out.count; i++) {
        const star_edge *out = &e->out.edges[i];
        const star_edge *back = norma_core_mutual_partner(out, &e->out, &e->back);
        if (!back) continue;
        if (norma_core_edge_is_smooth(prepared, star, out, back)) {
            norma_core_join_sets(star->joined, out->corner, back->corner);
            pair.smooth++;
        } else {
            pair.hard++;
        }
    }
    return pair;
}

/* A corner that the next one of its face repeats shares that one's fan. */
static void join_repeated(const core_prepared_mesh *prepared, core_star *star) {
    if (!prepared->faces) return;
    for (uint32_t i = 0; i < star->count; i++) {
        const star_corner *c = &star->corners[i];
        if ((c->flags & STAR_KEPT) || !(prepared->faces[c->face].flags & CORE_FACE_EDGED)) continue;
        const uint32_t next =
            (uint32_t)norma_core_next_in_face(&prepared->mesh, c->face, c->corner);
        size_t low = 0, high = star->count;
        while (low < high) {
            const size_t middle = low + (high - low) / 2;
            if (star->corners[middle].corner < next)
                low = middle + 1;
            else
                high = middle;
        }
        norma_core_join_sets(star->joined, i, (uint32_t)low);
    }
}

/* ---- ordinary stars, nearly all there are: along each edge runs one face out and one back, or one
 * alone; paired without sorting, to the same fans and counts */

enum { FEW_CORNERS = 16, NO_PARTNER = -1 };

typedef struct ordinary_star {
    uint32_t next[FEW_CORNERS], previous[FEW_CORNERS];
    int back[FEW_CORNERS]; /* of each corner: the one whose face runs back along its edge to next */
    int met[FEW_CORNERS];  /* of each corner: whether its edge from previous is another's edge to
                              next */
} ordinary_star;

static int pair_up(const core_star *star, ordinary_star *o) {
    const int count = (int)star->count;
    for (int i = 0; i < count; i++) {
        if (!(star->corners[i].flags & STAR_KEPT)) return 0;
        o->next[i] = star->corners[i].next;
        o->previous[i] = star->corners[i].previous;
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
        if (norma_core_key_of_twin(star->corners[i].next_key) ==
            star->corners[o->back[i]].previous_key)
            return 0; /* its twin */
        o->met[o->back[i]] = 1;
    }
    return 1;
}

static int join_ordinary(const core_prepared_mesh *prepared, core_star *star, star_counts *counts) {
    ordinary_star o;
    norma_edges edges = {0, 0, 0, 0};
    if (star->count > FEW_CORNERS || !pair_up(star, &o)) return 0;
    for (uint32_t i = 0; i < star->count; i++) {
        const size_t counted = star->position < o.next[i];
        edges.count += counted;
        if (o.back[i] == NO_PARTNER) {
            edges.open += counted;
        } else {
            const star_edge out = {.corner = i}, back = {.corner = (uint32_t)o.back[i]};
            const int smooth = norma_core_edge_is_smooth(prepared, star, &out, &back);
            if (smooth) norma_core_join_sets(star->joined, out.corner, back.corner);
            *(smooth ? &edges.smooth : &edges.hard) += counted;
        }
        if (o.met[i] || star->position >= o.previous[i]) continue;
        edges.count++;
        edges.open++;
    }
    if (counts) norma_core_edges_add(&counts->edges, &edges);
    return 1;
}

static void settle_fans(core_star *star) {
    for (uint32_t i = 0; i < star->count; i++) star->joined[i] = norma_core_set_of(star->joined, i);
}

void norma_core_star_join_listed(
    const core_prepared_mesh *prepared, core_star *star, star_counts *counts) {
    for (size_t begin = 0, end; begin < star->edge_count; begin = end) {
        const edge e = norma_core_edge_at(star, begin, &end);
        const pairs pair = join_only_partners(prepared, star, &e);
        if (prepared->call->options.non_manifold == NORMA_NON_MANIFOLD_SMOOTH && end - begin > 2)
            join_all_partners(prepared, star, &e, star->edges[begin].other);
        if (counts && star->position < star->edges[begin].other) count_edge(star, &e, pair, counts);
    }
}

void norma_core_star_join_fans(
    const core_prepared_mesh *prepared, core_star *star, star_counts *counts) {
    if (join_ordinary(prepared, star, counts)) {
        settle_fans(star);
        return;
    }
    norma_core_list_edges(star);
    norma_core_star_join_listed(prepared, star, counts);
    join_repeated(prepared, star);
    settle_fans(star);
}
