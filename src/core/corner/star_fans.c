/* star_fans.c: which edges of a star are smooth, and the fans that they join: the crease rule, the
 * edges that leave a position and who are partners at them, and whose direction a face without one
 * borrows. */
#include "core/corner/corner.h"
#include "core/call/call.h"
#include "core/face/face.h"
#include <math.h>

/* An angle, whatever the size of the mesh: flat quads and hexagonal prisms, rounded to floats, bend
 * by 1e-7 rad; the contract allows this much over the crease. */
static const double CREASE_TOLERANCE_RAD = 0x1.0c6f7a0b5ed8dp-20; /* 1e-6 */

/* Also an angle: programs that compute pi in floats, or from degrees, may be this much above it. */
static const double ABOVE_PI_RAD = 1e-3;

norma_result norma_core_check_crease(float crease_angle_rad, norma_fault *fault) {
    if (isfinite(crease_angle_rad) && (double)crease_angle_rad <= NORMA_PI + ABOVE_PI_RAD)
        return NORMA_OK;
    return norma_core_refuse(fault, NORMA_ERROR_ARGUMENT, "crease_angle_rad", SIZE_MAX,
        "an angle in radians, not in degrees: at most pi");
}

core_crease norma_core_crease_at(double crease_angle_rad) {
    const double angle = crease_angle_rad >= NORMA_PI ? 4 : crease_angle_rad + CREASE_TOLERANCE_RAD;
    return (core_crease){angle, angle < 0 ? 2 : angle >= NORMA_PI ? -2 : cos(angle)};
}

/* By the cosine of the dihedral angle of two unit normals, and where that does not decide by the
 * angle. */
static int core_is_within_crease(const core_crease *crease, const double a[3], const double b[3]) {
    const double cosine = norma_core_dot(a, b);
    double cross[3];
    if (norma_core_is_surely_smooth(crease, cosine)) return 1;
    if (norma_core_is_surely_hard(crease, cosine)) return 0;
    norma_core_cross(a, b, cross);
    return norma_core_angle(norma_core_length(cross), cosine) <= crease->angle;
}

/* ---- the edges that leave a position, and which faces are partners at them. The faces at an edge
 * are sorted by direction and by norma_core_twin_key. A face's partners are then all those that run
 * the other way, less the range of those with its twins' key: found by bisection, so that an edge
 * of a million faces costs no more a face than one of two. */

/* ---- sorting: by the position at the other end, direction, key, order of corners */

static int edge_less(const star_edge *a, const star_edge *b) {
    if (a->other != b->other) return a->other < b->other;
    if (a->back != b->back) return a->back < b->back;
    if (a->key != b->key) return a->key < b->key;
    return a->corner < b->corner;
}

static void sort_run(star_edge *edges, size_t count) {
    for (size_t i = 1; i < count; ++i) {
        const star_edge moved = edges[i];
        size_t at = i;
        for (; at > 0 && edge_less(&moved, &edges[at - 1]); --at) edges[at] = edges[at - 1];
        edges[at] = moved;
    }
}

static void merge(const star_edge *from, size_t begin, size_t middle, size_t end, star_edge *to) {
    size_t left = begin, right = middle;
    for (size_t at = begin; at < end; ++at) {
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
        sort_run(star->edges + begin, least(SORTED_RUN, count - begin));
    for (size_t run = SORTED_RUN; run < count; run *= 2) {
        for (size_t begin = 0; begin < count; begin += 2 * run)
            merge(star->edges, begin, least(begin + run, count), least(begin + 2 * run, count),
                star->sorted);
        star_edge *sorted = star->sorted;
        star->sorted = star->edges;
        star->edges = sorted;
    }
}

/* Sorts the star's edges by the position at the other end, direction, key. O(n log
 * n). */
static void core_list_edges(core_star *star) {
    star->edge_count = 0;
    for (uint32_t i = 0; i < star->count; ++i) {
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

typedef struct edge_side {
    const star_edge *edges;
    size_t count;
} edge_side; /* the faces that run along it one way, by key */
typedef struct edge {
    edge_side out, back;
} edge;

/* Two that run along it opposite ways are partners, unless one is the other's reversed twin: of the
 * same positions in opposite order, back to back. A face that runs both ways is two there, each the
 * other's partner (a slit); but of one that is its own reverse, as (a, b, c, b) is, they are twins.
 */
static inline int core_are_partners(const star_edge *a, const star_edge *b) {
    return b->key != norma_core_key_of_twin(a->key);
}

typedef struct edge_partners {
    size_t count;
    const star_edge *only; /* where there is just one, else NULL */
} edge_partners;

/* The first edge of the side with this key or a higher one; above: with a higher one. */
static size_t core_first_not_below(const edge_side *side, uint64_t key, int above) {
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

/* The partners of own among those that run the other way; by bisection. */
static edge_partners core_partners_of(const star_edge *own, const edge_side *other) {
    const uint64_t twin = norma_core_key_of_twin(own->key);
    const size_t begin = core_first_not_below(other, twin, 0),
                 end = core_first_not_below(other, twin, 1);
    edge_partners partners = {other->count - (end - begin), NULL};
    if (partners.count == 1)
        partners.only = &other->edges[begin ? 0 : end]; /* twins lie together */
    return partners;
}

/* Each other's only one: that of own, or NULL. */
static const star_edge *core_mutual_partner(
    const star_edge *own, const edge_side *side, const edge_side *other) {
    const star_edge *partner = core_partners_of(own, other).only;
    return partner && core_partners_of(partner, side).count == 1 ? partner : NULL;
}

/* The edge that begins at edges[begin]; *end is where the next one does. */
static edge core_edge_at(const core_star *star, size_t begin, size_t *end) {
    size_t middle = begin, stop;
    const uint32_t other = star->edges[begin].other;
    while (middle < star->edge_count && star->edges[middle].other == other &&
           !star->edges[middle].back)
        ++middle;
    for (stop = middle; stop < star->edge_count && star->edges[stop].other == other;) ++stop;
    *end = stop;
    return (edge){{star->edges + begin, middle - begin}, {star->edges + middle, stop - middle}};
}

/* By the crease rule, out begins at the star's position, back ends there. Swapping the two changes
 * no bit, so both ends of the edge agree. */
static int core_edge_is_smooth(const core_prepared_mesh *prepared, const core_star *star,
    const star_edge *out, const star_edge *back) {
    const star_corner *a = &star->corners[out->corner], *b = &star->corners[back->corner];
    return (a->flags & STAR_HAS_NORMAL) && (b->flags & STAR_HAS_NORMAL) &&
           norma_core_is_unmarked(
               &prepared->mesh, a->corner, a->face, b->previous_corner, b->face) &&
           core_is_within_crease(&prepared->crease, a->normal, b->normal);
}

/* ---- an edge of very many faces under the smooth policy, where looking at every pair would take
 * forever. The normals of the faces at an edge stand at right angles to it, so each is one angle
 * round the edge, and two faces bend by the difference of their angles. The faces that run back are
 * joined to their neighbours in angle wherever some face that runs out is near enough to both, and
 * each that runs out to its neighbours among those that run back: the same fans, in O(n log n).
 * Faces whose normals lean (bent polygons) or are borrowed are few, and are compared with all, and
 * so are those that are their own reverse: they run both ways at one angle and are not partners of
 * themselves; and those with twins where a distance welds. Twins among the others stand opposite,
 * beyond any crease that is asked about. */

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
    for (size_t i = 0; i < e->out.count; ++i) {
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
    if (!core_are_partners(out, back) || norma_core_set_of(f->star->joined, out->corner) ==
                                             norma_core_set_of(f->star->joined, back->corner))
        return;
    if (core_edge_is_smooth(f->prepared, f->star, out, back))
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
    for (size_t i = 0; i < f->out_count; ++i) {
        const star_edge *out = &f->e->out.edges[f->out[i].edge];
        const size_t next = first_from(f->back, f->back_count, f->out[i].angle);
        join_pair(f, out, &f->e->back.edges[f->back[next < f->back_count ? next : 0].edge]);
        join_pair(f, out, &f->e->back.edges[f->back[next ? next - 1 : f->back_count - 1].edge]);
    }
    for (size_t i = 0; i < f->back_count && f->back_count > 1; ++i) {
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

/* Compares one face with all of the other side. */
static void join_leaning(const fin_set *f, const star_edge *own, int back) {
    const edge_side *other = back ? &f->e->out : &f->e->back;
    for (size_t i = 0; i < other->count; ++i) {
        if (other->edges[i].key == norma_core_key_of_twin(own->key)) /* its twins lie together */
            i = core_first_not_below(other, other->edges[i].key, 1) - 1;
        else
            join_pair(f, back ? &other->edges[i] : own, back ? own : &other->edges[i]);
    }
}

/* The key of a triangle is that of its twins as well; but no triangle is its own reverse. */
static int is_own_reverse(const core_mesh *mesh, const star_corner *c, const star_edge *run) {
    return norma_core_face_starts(mesh) &&
           mesh->face_starts[c->face + 1] - mesh->face_starts[c->face] > 3 &&
           run->key == norma_core_key_of_twin(run->key);
}

/* Twins that a distance welds may stand at any angle; all others stand opposite. */
static int has_near_twins(
    const core_prepared_mesh *prepared, const edge_side *other, const star_edge *run) {
    if (!norma_core_welds_near(prepared->call)) return 0;
    const uint64_t twin = norma_core_key_of_twin(run->key);
    const size_t at = core_first_not_below(other, twin, 0);
    return at < other->count && other->edges[at].key == twin;
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
    const edge_side *side = back ? &f->e->back : &f->e->out,
                    *other = back ? &f->e->out : &f->e->back;
    size_t count = 0;
    for (size_t i = 0; i < side->count; ++i) {
        const star_corner *c = &f->star->corners[side->edges[i].corner];
        if (!(c->flags & STAR_HAS_NORMAL) || (group && !(mesh->smoothing_groups[c->face] & group)))
            continue;
        if (mesh->hard_edges && mesh->hard_edges[back ? c->previous_corner : c->corner]) continue;
        if (!is_plain(frame, c) || is_own_reverse(mesh, c, &side->edges[i]) ||
            has_near_twins(f->prepared, other, &side->edges[i]))
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
 * not its twins: two of different keys reach all of them. They are among the first of three keys.
 */
static void join_any_angle(
    const fin_set *f, const edge_side *own, const edge_side *other, int back) {
    enum { FIRST_KEYS = 3 };
    const star_edge *firsts[FIRST_KEYS];
    size_t count = 0;
    for (size_t j = 0; j < other->count && count < FIRST_KEYS; ++j) {
        if (!(f->star->corners[other->edges[j].corner].flags & STAR_HAS_NORMAL)) continue;
        firsts[count++] = &other->edges[j];
        j = core_first_not_below(other, other->edges[j].key, 1) - 1; /* on to the next key */
    }
    for (size_t i = 0; i < own->count; ++i) {
        const star_edge *mine = &own->edges[i];
        int found = 0;
        for (size_t k = 0; k < count && found < 2; ++k) {
            if (firsts[k]->key == norma_core_key_of_twin(mine->key)) continue;
            join_pair(f, back ? firsts[k] : mine, back ? mine : firsts[k]);
            ++found;
        }
    }
}

_Static_assert(sizeof(fin) <= sizeof(star_edge), "fins lie in the room of sorted edges");

/* Joins all partners at an edge of very many faces; along: its unit direction. 0:
 * not done, each pair must be tried. */
static int core_join_crowded_edge(
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
    for (int bit = 0; groups && bit < 32; ++bit) join_group(&f, &frame, UINT32_C(1) << bit);
    return 1;
}

/* ---- a face without a direction borrows that of the face it shares its longest edge with. */

/* The corner at which the face's longest edge begins; ties: the first one's. */
static uint32_t core_longest_edge(const core_mesh *mesh, size_t face) {
    core_segment longest = {.square = 0}, side;
    uint32_t at = UINT32_MAX;
    for (size_t c = norma_core_face_begin(mesh, face); c < norma_core_face_end(mesh, face); ++c) {
        if (!norma_core_is_kept(mesh, face, c)) continue;
        const size_t next = norma_core_next_kept(mesh, face, c);
        norma_core_position(mesh, norma_core_corner(mesh, c), side.from);
        norma_core_position(mesh, norma_core_corner(mesh, next), side.to);
        norma_core_measure_segment(&side);
        if (at != UINT32_MAX && norma_core_compare_lengths(&side, &longest) <= 0) continue;
        longest = side;
        at = (uint32_t)c;
    }
    return at;
}

/* The one face that shares the edge with a flat face, if it has a direction of its own. */
static uint32_t find_borrowed_from(const core_prepared_mesh *prepared, const core_star *star,
    const star_edge *flat, const edge_side *own, const edge_side *other) {
    const star_edge *partner = prepared->call->options.non_manifold == NORMA_NON_MANIFOLD_SMOOTH
                                   ? core_partners_of(flat, other).only
                                   : core_mutual_partner(flat, own, other);
    if (!partner || !(star->corners[partner->corner].flags & STAR_VOTES)) return UINT32_MAX;
    return star->corners[partner->corner].face;
}

static void borrow_for_side(const core_prepared_mesh *prepared, const core_star *star,
    const edge_side *own, const edge_side *other, uint32_t *longest, uint32_t *borrowed_from) {
    for (size_t i = 0; i < own->count; ++i) {
        const star_corner *c = &star->corners[own->edges[i].corner];
        if (!(c->flags & STAR_FLAT)) continue;
        const uint32_t begin = own->edges[i].back ? c->previous_corner : c->corner;
        if (longest[c->face] == UINT32_MAX)
            longest[c->face] = core_longest_edge(&prepared->mesh, c->face);
        if (longest[c->face] == begin)
            borrowed_from[c->face] = find_borrowed_from(prepared, star, &own->edges[i], own, other);
    }
}

void norma_core_star_borrow_directions(const core_prepared_mesh *prepared, core_star *star,
    uint32_t *longest, uint32_t *borrowed_from) {
    core_list_edges(star);
    for (size_t begin = 0, end; begin < star->edge_count; begin = end) {
        const edge e = core_edge_at(star, begin, &end);
        if (star->position > star->edges[begin].other) continue;
        borrow_for_side(prepared, star, &e.out, &e.back, longest, borrowed_from);
        borrow_for_side(prepared, star, &e.back, &e.out, longest, borrowed_from);
    }
}

/* ---- which edges of a star are smooth, the fans that they join, and the counts of edges. */

/* ---- counting */

static uint32_t least_begin(const core_star *star, const edge *e) {
    uint32_t first = UINT32_MAX;
    for (size_t i = 0; i < e->out.count; ++i) {
        const uint32_t corner = star->corners[e->out.edges[i].corner].corner;
        if (corner < first) first = corner;
    }
    for (size_t i = 0; i < e->back.count; ++i) {
        const uint32_t corner = star->corners[e->back.edges[i].corner].previous_corner;
        if (corner < first) first = corner;
    }
    return first;
}

static int each_has_one_partner(const edge_side *side, const edge_side *other) {
    for (size_t i = 0; i < side->count; ++i)
        if (core_partners_of(&side->edges[i], other).count != 1) return 0;
    return 1;
}

typedef struct pairs {
    size_t smooth, hard;
} pairs; /* of faces that are each other's only partner */

static void count_edge(const core_star *star, const edge *e, pairs pair, star_counts *counts) {
    const size_t faces = e->out.count + e->back.count;
    ++counts->edges.count;
    if (faces > 2 &&
        !(each_has_one_partner(&e->out, &e->back) && each_has_one_partner(&e->back, &e->out)))
        norma_core_count_one(&counts->non_manifold, least_begin(star, e));
    else if (faces == 2 && e->out.count != 1)
        norma_core_count_one(&counts->conflicts, least_begin(star, e));
    else if (faces == 1)
        ++counts->edges.open;
    else if (pair.hard || !pair.smooth)
        ++counts->edges.hard;
    else
        ++counts->edges.smooth;
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
        core_join_crowded_edge(prepared, star, e, along))
        return;
    for (size_t i = 0; i < e->out.count; ++i) {
        const star_edge *out = &e->out.edges[i];
        if (!(star->corners[out->corner].flags & STAR_HAS_NORMAL)) continue; /* all hard */
        for (size_t j = 0; j < e->back.count; ++j) {
            const star_edge *back = &e->back.edges[j];
            if (!core_are_partners(out, back) || norma_core_set_of(star->joined, out->corner) ==
                                                     norma_core_set_of(star->joined, back->corner))
                continue;
            if (core_edge_is_smooth(prepared, star, out, back))
                norma_core_join_sets(star->joined, out->corner, back->corner);
        }
    }
}

static pairs join_only_partners(
    const core_prepared_mesh *prepared, core_star *star, const edge *e) {
    pairs pair = {0, 0};
    for (size_t i = 0; i < e->out.count; ++i) {
        const star_edge *out = &e->out.edges[i];
        const star_edge *back = core_mutual_partner(out, &e->out, &e->back);
        if (!back) continue;
        if (core_edge_is_smooth(prepared, star, out, back)) {
            norma_core_join_sets(star->joined, out->corner, back->corner);
            ++pair.smooth;
        } else {
            ++pair.hard;
        }
    }
    return pair;
}

/* A corner that the next one of its face repeats shares that one's fan. */
static void join_repeated(const core_prepared_mesh *prepared, core_star *star) {
    if (!norma_core_kept_faces(prepared)) return;
    for (uint32_t i = 0; i < star->count; ++i) {
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

/* ---- plain stars: along each edge runs one face out and one back, or one alone; paired without
 * sorting, to the same fans and counts. Here come stars that are in no batch
 * (norma_core_can_batch), and those that star_kernel.c leaves: a fifth of the most visible normals'
 * time, a tenth of what dream-apartment takes where edges are counted */

enum { FEW_CORNERS = 16, NO_PARTNER = -1 };

typedef struct plain_star {
    uint32_t next[FEW_CORNERS], previous[FEW_CORNERS];
    int back[FEW_CORNERS]; /* of each corner: the one whose face runs back along its edge to next */
    int met[FEW_CORNERS];  /* of each corner: whether its edge from previous is another's edge to
                              next */
} plain_star;

static int pair_up(const core_star *star, plain_star *o) {
    const int count = (int)star->count;
    for (int i = 0; i < count; ++i) {
        if (!(star->corners[i].flags & STAR_KEPT)) return 0;
        o->next[i] = star->corners[i].next;
        o->previous[i] = star->corners[i].previous;
        o->met[i] = 0;
    }
    for (int i = 0; i < count; ++i) {
        int outs = 0, backs = 0, alike = 0;
        o->back[i] = NO_PARTNER;
        for (int j = 0; j < count; ++j) {
            outs += o->next[j] == o->next[i];
            alike += o->previous[j] == o->previous[i];
            if (o->previous[j] != o->next[i]) continue;
            ++backs;
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

static int join_plain(const core_prepared_mesh *prepared, core_star *star, star_counts *counts) {
    plain_star o;
    norma_edges edges = {0, 0, 0, 0};
    if (star->count > FEW_CORNERS || !pair_up(star, &o)) return 0;
    for (uint32_t i = 0; i < star->count; ++i) {
        const size_t counted = star->position < o.next[i];
        edges.count += counted;
        if (o.back[i] == NO_PARTNER) {
            edges.open += counted;
        } else {
            const star_edge out = {.corner = i}, back = {.corner = (uint32_t)o.back[i]};
            const int smooth = core_edge_is_smooth(prepared, star, &out, &back);
            if (smooth) norma_core_join_sets(star->joined, out.corner, back.corner);
            *(smooth ? &edges.smooth : &edges.hard) += counted;
        }
        if (o.met[i] || star->position >= o.previous[i]) continue;
        ++edges.count;
        ++edges.open;
    }
    if (counts) norma_core_edges_add(&counts->edges, &edges);
    return 1;
}

static void settle_fans(core_star *star) {
    for (uint32_t i = 0; i < star->count; ++i) star->joined[i] = norma_core_set_of(star->joined, i);
}

void norma_core_star_join_listed(
    const core_prepared_mesh *prepared, core_star *star, star_counts *counts) {
    for (size_t begin = 0, end; begin < star->edge_count; begin = end) {
        const edge e = core_edge_at(star, begin, &end);
        const pairs pair = join_only_partners(prepared, star, &e);
        if (prepared->call->options.non_manifold == NORMA_NON_MANIFOLD_SMOOTH && end - begin > 2)
            join_all_partners(prepared, star, &e, star->edges[begin].other);
        if (counts && star->position < star->edges[begin].other) count_edge(star, &e, pair, counts);
    }
}

void norma_core_star_join_fans(
    const core_prepared_mesh *prepared, core_star *star, star_counts *counts) {
    if (join_plain(prepared, star, counts)) {
        settle_fans(star);
        return;
    }
    core_list_edges(star);
    norma_core_star_join_listed(prepared, star, counts);
    join_repeated(prepared, star);
    settle_fans(star);
}
