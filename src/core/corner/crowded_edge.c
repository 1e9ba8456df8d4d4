/* crowded_edge.c: an edge of very many faces under the smooth policy, where looking at every pair
 * would take forever.
 *
 * The normals of the faces at an edge stand at right angles to it, so each is one angle round the
 * edge, and two faces bend by the difference of their angles. The faces that run back are joined to
 * their neighbours in angle wherever some face that runs out is near enough to both, and each that
 * runs out to its neighbours among those that run back: the same fans, in O(n log n). Faces whose
 * normals lean (bent polygons) or are borrowed are few, and are compared with all; twins among the
 * others stand opposite, beyond any crease that is asked about. */
#include "core/corner/star_edges.h"
#include "core/call/call.h"
#include "core/face/face.h"

typedef struct fin {
    double angle;
    uint32_t back, edge;
} fin; /* edge: its number among those of its side */

typedef struct fin_set {
    const core_prepared_mesh *prepared;
    core_star *star;
    const edge *e;
    fin *out, *back; /* by angle */
    size_t out_count, back_count;
} fin_set;

static int fin_less(const void *one, const void *other) {
    const fin *a = one, *b = other;
    if (a->back != b->back) return a->back < b->back;
    return a->angle < b->angle || (a->angle == b->angle && a->edge < b->edge);
}

/* ---- angles round the edge */

typedef struct edge_frame {
    double along[3], x[3], y[3];
} edge_frame;

static const double LEAN =
    0x1p-40; /* cosine between a normal and its edge that is more than rounding */

/* From the edge's own direction and any normal that stands at right angles to it; 0 where none
 * does. */
static int frame_of(
    const core_star *star, const edge *e, const double along[3], edge_frame *frame) {
    memcpy(frame->along, along, sizeof frame->along);
    for (size_t i = 0; i < e->out.count; i++) {
        const star_corner *c = &star->corners[e->out.edges[i].corner];
        if (!(c->flags & STAR_HAS_NORMAL) || fabs(norma_core_dot(c->normal, along)) > LEAN)
            continue;
        memcpy(frame->x, c->normal, sizeof frame->x);
        norma_core_cross(along, frame->x, frame->y);
        return 1;
    }
    return 0;
}

static double angle_in(const edge_frame *frame, const double normal[3]) {
    const double x = norma_core_dot(normal, frame->x), y = norma_core_dot(normal, frame->y);
    const double angle = norma_core_angle(fabs(y), x);
    return y < 0 ? 2 * NORMA_PI - angle : angle;
}

/* ---- joining */

static void join_pair(const fin_set *f, const star_edge *out, const star_edge *back) {
    if (!norma_core_are_partners(out, back) || norma_core_set_of(f->star->joined, out->corner) ==
                                                   norma_core_set_of(f->star->joined, back->corner))
        return;
    if (norma_core_edge_is_smooth(f->prepared, f->star, out, back))
        norma_core_join_sets(f->star->joined, out->corner, back->corner);
}

/* The first fin at or after angle; count where all are before it. */
static size_t first_from(const fin *fins, size_t count, double angle) {
    size_t low = 0, high = count;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (fins[middle].angle < angle)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

/* Whether a fin that runs out lies in the arc that begins at angle, of some width. */
static int any_out(const fin_set *f, double angle, double width) {
    if (width < 0 || !f->out_count) return 0;
    while (angle < 0) angle += 2 * NORMA_PI;
    while (angle >= 2 * NORMA_PI) angle -= 2 * NORMA_PI;
    const size_t at = first_from(f->out, f->out_count, angle);
    const double found = at < f->out_count ? f->out[at].angle : f->out[0].angle + 2 * NORMA_PI;
    return found - angle <= width;
}

static void join_neighbours(const fin_set *f) {
    const double crease = f->prepared->crease.angle;
    if (!f->back_count) return;
    for (size_t i = 0; i < f->out_count; i++) {
        const star_edge *out = &f->e->out.edges[f->out[i].edge];
        const size_t next = first_from(f->back, f->back_count, f->out[i].angle);
        join_pair(f, out, &f->e->back.edges[f->back[next < f->back_count ? next : 0].edge]);
        join_pair(f, out, &f->e->back.edges[f->back[next ? next - 1 : f->back_count - 1].edge]);
    }
    for (size_t i = 0; i < f->back_count && f->back_count > 1; i++) {
        const fin *a = &f->back[i], *b = &f->back[i + 1 < f->back_count ? i + 1 : 0];
        const double gap = b->angle - a->angle + (i + 1 < f->back_count ? 0 : 2 * NORMA_PI);
        const int near = any_out(f, a->angle + gap - crease, 2 * crease - gap);
        const int round_the_other_side =
            any_out(f, a->angle - crease, gap + 2 * crease - 2 * NORMA_PI);
        if (near || round_the_other_side)
            norma_core_join_sets(f->star->joined, f->e->back.edges[a->edge].corner,
                f->e->back.edges[b->edge].corner);
    }
}

/* Compares a leaning face with all of the other side. */
static void join_leaning(const fin_set *f, const star_edge *own, int back) {
    const edge_side *other = back ? &f->e->out : &f->e->back;
    for (size_t i = 0; i < other->count; i++)
        join_pair(f, back ? &other->edges[i] : own, back ? own : &other->edges[i]);
}

/* Whether its angle round the edge says all: a direction of its own, at right angles to the edge.
 */
static int is_plain(const edge_frame *frame, const star_corner *c) {
    return (c->flags & STAR_VOTES) && fabs(norma_core_dot(c->normal, frame->along)) <= LEAN;
}

/* Fins of one side that take part: a normal, no hard mark, the group bit asked for (0: none are in
 * use). */
static size_t list_side(
    const fin_set *f, const edge_frame *frame, int back, uint32_t group, fin *fins) {
    const core_mesh *mesh = &f->prepared->mesh;
    const edge_side *side = back ? &f->e->back : &f->e->out;
    size_t count = 0;
    for (size_t i = 0; i < side->count; i++) {
        const star_corner *c = &f->star->corners[side->edges[i].corner];
        if (!(c->flags & STAR_HAS_NORMAL) || (group && !(mesh->smoothing_groups[c->face] & group)))
            continue;
        if (mesh->hard_edges && mesh->hard_edges[back ? c->previous_corner : c->corner]) continue;
        if (!is_plain(frame, c))
            join_leaning(f, &side->edges[i], back);
        else
            fins[count++] = (fin){angle_in(frame, c->normal), (uint32_t)back, (uint32_t)i};
    }
    return count;
}

static void join_group(fin_set *f, const edge_frame *frame, uint32_t group) {
    fin *fins = (fin *)(void *)f->star->sorted;
    f->out_count = list_side(f, frame, 0, group, fins);
    f->back_count = list_side(f, frame, 1, group, fins + f->out_count);
    norma_core_sort(fins, f->out_count + f->back_count, sizeof *fins, fin_less);
    f->out = fins;
    f->back = fins + f->out_count;
    join_neighbours(f);
}

/* Where no angle is asked, a face's partners are all of the other side that have a normal and are
 * not its twins: two of different keys reach all of them. */
static void join_any_angle(
    const fin_set *f, const edge_side *own, const edge_side *other, int back) {
    for (size_t i = 0; i < own->count; i++) {
        const star_edge *mine = &own->edges[i];
        int found = 0;
        for (size_t j = 0; j < other->count && found < 2; j++) {
            const star_edge *partner = &other->edges[j];
            const int is_twin = partner->key == norma_core_key_of_twin(mine->key);
            if (!is_twin && !(f->star->corners[partner->corner].flags & STAR_HAS_NORMAL)) continue;
            if (!is_twin) {
                join_pair(f, back ? partner : mine, back ? mine : partner);
                found++;
            }
            j = norma_core_first_not_below(other, partner->key, 1) - 1; /* on to the next key */
        }
    }
}

_Static_assert(sizeof(fin) <= sizeof(star_edge), "fins lie in the room of sorted edges");

int norma_core_join_crowded_edge(
    const core_prepared_mesh *prepared, core_star *star, const edge *e, const double along[3]) {
    fin_set f = {.prepared = prepared, .star = star, .e = e};
    edge_frame frame;
    const int groups = prepared->mesh.smoothing_groups != NULL;
    if (prepared->crease.angle >= NORMA_PI) {
        if (groups || prepared->mesh.hard_edges) return 0;
        join_any_angle(&f, &e->out, &e->back, 0);
        join_any_angle(&f, &e->back, &e->out, 1);
        return 1;
    }
    if (!frame_of(star, e, along, &frame)) return 0;
    if (!groups) join_group(&f, &frame, 0);
    for (int bit = 0; groups && bit < 32; bit++) join_group(&f, &frame, UINT32_C(1) << bit);
    return 1;
}
