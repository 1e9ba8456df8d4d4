/* orient.c: which faces are turned: those of closed parts by volume and nesting, those of open
 * parts by rays; norma_orient and norma_reverse_winding. */
#include "core/face/face.h"
#include "core/topology/topology.h"
#include <float.h>
#include <norma/norma.h>
#include <stdlib.h>
#include <string.h>

/* ---- which side of an open part is outward, by rays from points all over it, one to each side:
 * the side from which more of them leave the scene (Takayama, Jacobson, Kavan, Sorkine-Hornung 2014
 * count such rays as well). Fewer than a quarter more decide nothing. Points and directions are
 * numbers of a fixed sequence, and the same whichever way round a face is wound, so that a part
 * that was turned is not turned again. The steps of all rays are at most of the order of n log n,
 * however densely the n triangles lie, and each part has the same share of them; a part that uses
 * it up is judged by the rays that were cast until then. Where triangles coincide a single ray
 * could use up a share; then the rays of that part end with it. */

enum {
    RAYS = 64,        /* to each side of a part: a power of two, see scramble */
    FEWEST_RAYS = 32, /* of a part whose budget is used up; with fewer it stays undecided */
    STEPS_OF_RAY = 2, /* times the logarithm of all triangles: nodes and triangles looked at */
    LARGE_SHARE = 8   /* two rays that take more than this part of a budget are the last ones */
};
static const double JUST_OFF = 0x1p-20; /* of the size of the face: where a ray begins */

typedef struct poll { /* of one part */
    int votes;        /* for the part as it is, less those against */
    int cast;
    uint64_t steps;
} poll;

typedef core_ray_scene rays;
struct core_ray_scene {
    const core_topology *topology;
    core_components *components;
    core_triangle_tree tree;
    uint8_t open_flags;
    uint64_t budget; /* of each part, in steps */
    poll *polls;     /* of each part */
};

/* ---- a ray */

typedef struct ray {
    double origin[3], direction[3], inverse[3]; /* inverse: 1 / direction */
    double least;         /* what is nearer is the face where it starts, or lies on it */
    uint32_t face;        /* where it starts */
    uint64_t steps, most; /* nodes and triangles looked at; no more are once they are most */
} ray;

static void point_ray(ray *r, const double direction[3], double sign) {
    for (int k = 0; k < 3; ++k) {
        r->direction[k] = sign * direction[k];
        r->inverse[k] = 1 / r->direction[k];
    }
}

/* Whether the ray meets a triangle (Moller, Trumbore 1997). */
static int meets_triangle(const ray *r, const core_triangle *t) {
    double across[3], from[3], other[3];
    norma_core_cross(r->direction, t->v, across);
    const double determinant = norma_core_dot(t->u, across), size = fabs(determinant),
                 sign = determinant < 0 ? -1 : 1;
    norma_core_subtract(r->origin, t->corner, from);
    const double a = sign * norma_core_dot(from, across);
    if (!(a >= 0 && a <= size && size > 0)) return 0;
    norma_core_cross(from, t->u, other);
    const double b = sign * norma_core_dot(r->direction, other);
    return b >= 0 && a + b <= size && sign * norma_core_dot(t->v, other) > r->least * size &&
           t->face != r->face;
}

/* Where the ray enters the box; infinite: it misses it. No component of its direction is zero.
 * Relative to the distance, this much is the rounding of both. */
static double enter_box(const core_box_node *node, const ray *r) {
    double from = 0, to = INFINITY;
    for (int k = 0; k < 3; ++k) {
        const double a = (node->low[k] - r->origin[k]) * r->inverse[k],
                     b = (node->high[k] - r->origin[k]) * r->inverse[k];
        const double in = a < b ? a : b, out = a < b ? b : a;
        from = in > from ? in : from;
        to = out < to ? out : to;
    }
    return from > to * (1 + 8 * DBL_EPSILON) ? INFINITY : from;
}

/* Both children that the ray enters, the nearer one on top. */
static size_t push_children(
    const rays *all, const core_box_node *node, const ray *r, uint32_t *stack) {
    const double left = enter_box(&all->tree.boxes.nodes[node->left], r),
                 right = enter_box(&all->tree.boxes.nodes[node->right], r);
    const int left_first = left <= right;
    size_t count = 0;
    if ((left_first ? right : left) < INFINITY)
        stack[count++] = left_first ? node->right : node->left;
    if ((left_first ? left : right) < INFINITY)
        stack[count++] = left_first ? node->left : node->right;
    return count;
}

/* Has no meaning once r->steps has reached r->most. */
static int leaves_scene(const rays *all, ray *r) {
    uint32_t stack[128];
    size_t depth = 0;
    stack[depth++] = 0;
    while (depth && r->steps < r->most) {
        const core_box_node *node = &all->tree.boxes.nodes[stack[--depth]];
        ++r->steps;
        if (node->right) {
            depth += push_children(all, node, r, stack + depth);
            continue;
        }
        r->steps += node->count;
        for (uint32_t i = node->begin; i < node->begin + node->count; ++i)
            if (meets_triangle(r, &all->tree.triangles[i])) return 0;
    }
    return 1;
}

/* ---- where rays start and where they go */

/* Of the sequence's number: three numbers from 0 to 1 (splitmix64, Steele, Lea, Flood 2014). */
static void three_numbers(uint64_t number, double out[3]) {
    for (int k = 0; k < 3; ++k) {
        uint64_t z = (number * 3 + (uint64_t)k + 1) * UINT64_C(0x9e3779b97f4a7c15);
        z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
        z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
        out[k] = (double)((z ^ (z >> 31)) >> 11) * 0x1p-53;
    }
}

/* A direction to the normal's side, each as likely as any other: that of a point of the unit ball.
 */
static void aim(const double normal[3], uint64_t number, double direction[3]) {
    double square;
    do {
        three_numbers(number, direction);
        for (int k = 0; k < 3; ++k) direction[k] = 2 * direction[k] - 1;
        square = norma_core_dot(direction, direction);
        number += UINT64_C(1) << 40;
    } while (square > 1 || square < 0x1p-8 || direction[0] == 0 || direction[1] == 0 ||
             direction[2] == 0);
    const double sign = norma_core_dot(direction, normal) < 0 ? -1 : 1;
    for (int k = 0; k < 3; ++k) direction[k] *= sign / sqrt(square);
}

/* A point of the face, in the triangle of the fan from its first corner that the numbers choose.
 * reversed: that of the face as it is wound the other way round. */
static void start(
    const rays *all, size_t face, int reversed, const double numbers[3], double origin[3]) {
    const core_topology *t = all->topology;
    const size_t begin = norma_core_face_begin(&t->mesh, face),
                 triangles = norma_core_face_end(&t->mesh, face) - begin - 2,
                 chosen = (size_t)(numbers[2] * (double)triangles) % triangles,
                 at = begin + 1 + (reversed ? triangles - 1 - chosen : chosen);
    double p0[3], p1[3], p2[3], a = numbers[0], b = numbers[1];
    norma_core_position(&t->mesh, t->corners[begin], p0);
    norma_core_position(&t->mesh, t->corners[reversed ? at + 1 : at], p1);
    norma_core_position(&t->mesh, t->corners[reversed ? at : at + 1], p2);
    if (a + b > 1) {
        a = 1 - a;
        b = 1 - b;
    }
    for (int k = 0; k < 3; ++k) origin[k] = p0[k] + a * (p1[k] - p0[k]) + b * (p2[k] - p0[k]);
}

static double twice_area_of(const core_topology *t, size_t face) {
    core_face geometry;
    norma_core_face_geometry(&t->mesh, face, &geometry);
    return geometry.flags & CORE_FACE_FINITE ? geometry.twice_area : 0;
}

/* Whether the first component of a normal that is not zero is negative: so it is for one of the two
 * ways to wind a face. */
static int looks_down(const double normal[3]) {
    int axis = 0;
    while (axis < 2 && normal[axis] == 0) ++axis;
    return normal[axis] < 0;
}

/* 1: the front sees more of what is outside, -1: the back does, 0: both do, or neither. */
static int vote_of_face(const rays *all, size_t face, uint64_t number, ray *r) {
    double place[3], direction[3];
    core_face geometry;
    norma_core_face_geometry(&all->topology->mesh, face, &geometry);
    if (!(geometry.flags & CORE_FACE_DIRECTED)) return 0;
    const int reversed = looks_down(geometry.normal);
    for (int k = 0; k < 3 && reversed; ++k) geometry.normal[k] = -geometry.normal[k];
    r->face = (uint32_t)face;
    r->least = JUST_OFF * sqrt(geometry.twice_area);
    three_numbers(2 * number + 1, place);
    start(all, face, reversed, place, r->origin);
    aim(geometry.normal, 2 * number, direction);
    point_ray(r, direction, 1);
    const int front = leaves_scene(all, r);
    point_ray(r, direction, -1);
    const int outward = front - leaves_scene(all, r);
    return reversed != (all->components->reverse[face] != 0) ? -outward : outward;
}

/* The faces of the part in which the middles of count equal shares of its area lie. 0: it has no
 * area. */
static int choose_faces(const rays *all, size_t part, size_t count, uint32_t *faces) {
    const core_components *c = all->components;
    double total = 0, passed = 0;
    size_t chosen = 0;
    for (size_t i = c->starts[part]; i < c->starts[part + 1]; ++i)
        total += twice_area_of(all->topology, c->faces[i]);
    for (size_t i = c->starts[part]; i < c->starts[part + 1] && total > 0; ++i) {
        passed += twice_area_of(all->topology, c->faces[i]);
        while (chosen < count && passed * (double)count >= ((double)chosen + .5) * total)
            faces[chosen++] = c->faces[i];
    }
    return chosen == count;
}

/* The bits of a number below count in reverse, so that any beginning of the sequence is spread over
 * the part. */
static uint32_t scramble(uint32_t number, uint32_t count) {
    uint32_t out = 0;
    for (uint32_t bit = 1; bit < count; bit *= 2) out = 2 * out + ((number & bit) != 0);
    return out;
}

/* Whether the rays that are left cannot change what those cast say. */
static int is_settled(const poll *p) {
    const int left = RAYS - p->cast, clear = abs(p->votes);
    return clear - left >= RAYS / 4 || clear + left < RAYS / 4;
}

static void poll_part(void *context, size_t part) {
    const rays *all = context;
    const core_components *c = all->components;
    poll *p = &all->polls[part];
    uint32_t faces[RAYS];
    if (!(c->each[part].flags & all->open_flags) || (c->each[part].flags & COMPONENT_ONE_SIDED) ||
        !choose_faces(all, part, RAYS, faces))
        return;
    ray r = {.steps = 0};
    while (p->cast < RAYS && !is_settled(p)) {
        const uint64_t share = r.steps + all->budget / LARGE_SHARE;
        r.most = share < all->budget ? share : all->budget;
        const uint32_t number = scramble((uint32_t)p->cast, RAYS);
        const int says = vote_of_face(all, faces[number], number, &r);
        if (r.steps >= r.most) break;
        p->votes += says;
        ++p->cast;
    }
    p->steps = r.steps;
    if (p->cast < FEWEST_RAYS || 4 * abs(p->votes) < p->cast) p->votes = 0;
}

/* ---- all parts */

static void follow_votes(rays *all, core_ray_votes *votes) {
    core_components *c = all->components;
    for (size_t i = 0; i < c->count; ++i) {
        if (!(c->each[i].flags & all->open_flags) || (c->each[i].flags & COMPONENT_ONE_SIDED))
            continue;
        const poll *p = &all->polls[i];
        votes->steps += p->steps;
        if (!p->votes) {
            ++votes->undecided;
            c->each[i].flags |= COMPONENT_UNDECIDED;
            continue;
        }
        ++votes->decided;
        votes->least_confidence =
            fmin(votes->least_confidence, fabs((double)p->votes) / (double)p->cast);
        if (p->votes > 0) continue;
        ++votes->reversed;
        for (size_t k = c->starts[i]; k < c->starts[i + 1]; ++k)
            c->reverse[c->faces[k]] = !c->reverse[c->faces[k]];
    }
}

static void core_ray_scene_close(core_ray_scene *scene) {
    if (!scene) return;
    const core_call *call = scene->topology->call;
    norma_core_triangle_tree_release(call, &scene->tree);
    norma_core_release(call, scene->polls, scene->components->count, sizeof *scene->polls);
    norma_core_release(call, scene, 1, sizeof *scene);
}

static norma_result core_ray_scene_open(
    const core_topology *topology, core_components *components, core_ray_scene **scene) {
    core_call *call = topology->call;
    const size_t parts = components->count;
    rays *all = norma_core_allocate(call, 1, sizeof *all);
    if (!all) return NORMA_ERROR_MEMORY;
    *all = (rays){.topology = topology, .components = components};
    all->polls = norma_core_allocate(call, parts, sizeof *all->polls);
    const norma_result result = all->polls ? norma_core_triangle_tree_build(call, &topology->mesh,
                                                 CORE_TRIANGLES_FANS, &all->tree)
                                           : NORMA_ERROR_MEMORY;
    for (size_t count = all->tree.count; count > 0; count /= 2)
        all->budget += 2 * RAYS * STEPS_OF_RAY * ((all->tree.count + parts - 1) / parts);
    if (!result)
        *scene = all;
    else
        core_ray_scene_close(all);
    return result;
}

static norma_result core_ray_scene_vote(
    core_ray_scene *scene, uint8_t open_flags, core_ray_votes *votes) {
    const size_t parts = scene->components->count;
    *votes = (core_ray_votes){.least_confidence = 1};
    scene->open_flags = open_flags;
    memset(scene->polls, 0, parts * sizeof *scene->polls);
    const norma_result result = norma_core_parallel(scene->topology->call, parts, poll_part, scene);
    if (!result) follow_votes(scene, votes);
    return result;
}

norma_result norma_core_orient_by_rays(const core_topology *topology, core_components *components,
    uint8_t open_flags, core_ray_votes *votes) {
    core_ray_scene *scene = NULL;
    *votes = (core_ray_votes){.least_confidence = 1};
    norma_result result = core_ray_scene_open(topology, components, &scene);
    if (!result) result = core_ray_scene_vote(scene, open_flags, votes);
    core_ray_scene_close(scene);
    return result;
}

/* ---- Which faces are turned: those of closed parts by volume and nesting; those of open parts by
 * rays from each piece whose faces agree. An open part may wind by little more than one half round
 * what lies beside it: of that, rays are asked first. */

static const uint8_t PART_NOT_CLOSED = COMPONENT_OPEN | COMPONENT_ONE_SIDED | COMPONENT_UNBALANCED;

enum { UNASKED = 0, RIGHT, TURNED, UNDECIDED }; /* what is known of a piece */

/* ---- opening */

static void turn_inward_parts(core_components *c) {
    for (size_t i = 0; i < c->count; ++i)
        for (size_t k = c->starts[i]; k < c->starts[i + 1]; ++k)
            c->reverse[c->faces[k]] ^= c->each[i].verdict == COMPONENT_INWARD;
}

static norma_result find_side_parts(core_side_judge *j) {
    core_topology *t = &j->topology;
    const core_topology_visitor nobody = {NULL, NULL, NULL, NULL};
    norma_result result = norma_core_pair_edges(t, &nobody);
    if (!result) result = norma_core_find_components(t, CORE_JOIN_CUT, &j->parts);
    if (result) return result;
    result = norma_core_measure_components(t, &j->parts, PART_NOT_CLOSED);
    if (!result) result = norma_core_judge_nesting(t, &j->parts, PART_NOT_CLOSED);
    if (!result) result = norma_core_find_components(t, CORE_JOIN_ALIKE, &j->pieces);
    if (result) return result;
    turn_inward_parts(&j->parts);
    j->room = j->pieces.count + 1;
    j->known = norma_core_allocate(&j->call, j->room, 1);
    j->cast = norma_core_allocate(&j->call, j->room, 1);
    if (!j->known || !j->cast) return NORMA_ERROR_MEMORY;
    memset(j->cast, UNASKED, j->room);
    norma_core_side_judge_forget(j);
    return NORMA_OK;
}

void norma_core_side_judge_forget(core_side_judge *j) { memset(j->known, UNASKED, j->room); }

norma_result norma_core_side_judge_open(
    const norma_mesh *mesh, const norma_options *options, core_side_judge *judge) {
    core_mesh checked;
    *judge = (core_side_judge){.room = 0};
    norma_result result = norma_core_begin(&judge->call, options);
    if (!result) result = norma_core_mesh_shape(mesh, &checked);
    if (!result) result = norma_core_mesh_content(&judge->call, &checked);
    if (!result) result = norma_core_topology_open(&judge->call, &checked, &judge->topology);
    if (result) return result;
    result = find_side_parts(judge);
    if (result) norma_core_side_judge_close(judge);
    return result;
}

void norma_core_side_judge_close(core_side_judge *j) {
    core_ray_scene_close(j->rays);
    norma_core_release(&j->call, j->cast, j->room, 1);
    norma_core_release(&j->call, j->known, j->room, 1);
    norma_core_release_components(&j->call, &j->pieces);
    norma_core_release_components(&j->call, &j->parts);
    norma_core_topology_close(&j->topology);
}

/* ---- asking */

static int has_flags(const core_side_judge *j, size_t face, uint8_t flags) {
    const core_components *parts = &j->parts;
    return parts->of[face] == UINT32_MAX || (parts->each[parts->of[face]].flags & flags) != 0;
}

static int lies_in_open(const core_side_judge *j, size_t face) {
    const core_components *parts = &j->parts;
    const uint32_t parent = parts->each[parts->of[face]].parent;
    return parent != UINT32_MAX && (parts->each[parent].flags & PART_NOT_CLOSED) != 0;
}

static int is_for_rays(const core_side_judge *j, size_t face) {
    return has_flags(j, face, PART_NOT_CLOSED) || lies_in_open(j, face);
}

/* The pieces that rays must be cast from. */
static size_t choose_pieces(core_side_judge *j, size_t first, size_t count, const uint8_t *asked) {
    core_components *pieces = &j->pieces;
    size_t chosen = 0;
    for (size_t f = first; f < first + count; ++f) {
        const uint32_t piece = pieces->of[f];
        if ((asked && !asked[f - first]) || piece == UINT32_MAX || j->known[piece] != UNASKED ||
            !is_for_rays(j, f) || has_flags(j, f, COMPONENT_ONE_SIDED))
            continue;
        j->known[piece] = j->cast[piece];
        if (j->cast[piece] != UNASKED) continue;
        pieces->each[piece].flags |= COMPONENT_OPEN;
        ++chosen;
    }
    return chosen;
}

static norma_result ask_side_rays(core_side_judge *j) {
    core_components *pieces = &j->pieces;
    core_ray_votes votes;
    norma_result result = j->rays ? NORMA_OK : core_ray_scene_open(&j->topology, pieces, &j->rays);
    if (!result) result = core_ray_scene_vote(j->rays, COMPONENT_OPEN, &votes);
    for (size_t i = 0; i < pieces->count; ++i) {
        core_component *piece = &pieces->each[i];
        if (piece->flags & COMPONENT_OPEN && !result)
            j->known[i] = j->cast[i] = piece->flags & COMPONENT_UNDECIDED ? UNDECIDED
                                       : pieces->reverse[pieces->faces[pieces->starts[i]]] ? TURNED
                                                                                           : RIGHT;
        piece->flags = 0;
    }
    return result;
}

/* A sheet that lies on another of the same winding: made to agree, the two are closed, but hold
 * nothing that says which of them is turned. */
static int is_doubled_sheet(const core_side_judge *j, size_t face) {
    const core_component *part = &j->parts.each[j->parts.of[face]];
    return part->flags & COMPONENT_CONFLICT && part->volume == 0;
}

static uint8_t side_of(const core_side_judge *j, size_t face) {
    const uint8_t turned = j->parts.reverse[face] ? CORE_SIDE_TURNED : 0;
    const uint32_t piece = j->pieces.of[face];
    const uint8_t known = is_for_rays(j, face) && piece != UINT32_MAX ? j->known[piece] : UNDECIDED;
    const int is_silent = known == UNASKED || known == UNDECIDED;
    if (is_silent && !has_flags(j, face, PART_NOT_CLOSED))
        return turned | (is_doubled_sheet(j, face) ? CORE_SIDE_UNDECIDED : 0);
    if (is_silent) return turned | CORE_SIDE_UNDECIDED;
    return known == TURNED ? CORE_SIDE_TURNED | CORE_SIDE_BY_RAYS : CORE_SIDE_BY_RAYS;
}

norma_result norma_core_side_judge_ask(
    core_side_judge *judge, size_t first, size_t count, const uint8_t *asked, uint8_t *sides) {
    for (size_t i = 0; i < judge->pieces.count; ++i) judge->pieces.each[i].flags = 0;
    norma_result result = NORMA_OK;
    if (choose_pieces(judge, first, count, asked)) result = ask_side_rays(judge);
    for (size_t f = 0; f < count && !result; ++f) sides[f] = side_of(judge, first + f);
    return result;
}

/* ---- A consistent winding for each part, cut at edges of more than two faces; outward for
 * what is closed, by signed volume and by how the parts lie in one another. */

typedef struct edge_count {
    size_t many, conflicts;
} edge_count;

static void count_odd_edge(
    void *context, size_t block, uint32_t position, const core_edge_run *runs, size_t count) {
    edge_count *counts = context;
    (void)position;
    (void)runs;
    counts[block].many += count > 2;
    counts[block].conflicts += count == 2;
}

static norma_result pair_and_count(core_topology *t, norma_orient_report *report) {
    const size_t blocks = norma_core_topology_blocks(t);
    edge_count *counts = norma_core_allocate(t->call, blocks, sizeof *counts);
    if (!counts) return NORMA_ERROR_MEMORY;
    memset(counts, 0, blocks * sizeof *counts);
    const core_topology_visitor visitor = {.context = counts, .edge = count_odd_edge};
    const norma_result result = norma_core_pair_edges(t, &visitor);
    for (size_t i = 0; i < blocks; ++i) {
        report->non_manifold_edges += counts[i].many;
        report->winding_conflicts += counts[i].conflicts;
    }
    norma_core_release(t->call, counts, blocks, sizeof *counts);
    return result;
}

static void turn_round(core_components *c, size_t part) {
    for (size_t k = c->starts[part]; k < c->starts[part + 1]; ++k)
        c->reverse[c->faces[k]] = !c->reverse[c->faces[k]];
}

static void turn_outward(core_components *c, norma_orient_report *report) {
    for (size_t i = 0; i < c->count; ++i) {
        const core_component *part = &c->each[i];
        report->closed += !(part->flags & PART_NOT_CLOSED);
        report->one_sided += (part->flags & COMPONENT_ONE_SIDED) != 0;
        report->open += (part->flags & PART_NOT_CLOSED) && !(part->flags & COMPONENT_ONE_SIDED);
        report->nested += part->verdict == COMPONENT_NESTED;
        report->inward += part->verdict == COMPONENT_INWARD;
        if (part->verdict == COMPONENT_INWARD) turn_round(c, i);
    }
}

static norma_result orient_parts(
    core_topology *t, norma_orient_open open, core_components *c, norma_orient_report *report) {
    norma_result result = norma_core_measure_components(t, c, PART_NOT_CLOSED);
    if (!result) result = norma_core_judge_nesting(t, c, PART_NOT_CLOSED);
    if (result) return result;
    turn_outward(c, report);
    report->parts = c->count;
    report->undecided = report->open;
    if (open != NORMA_ORIENT_OPEN_BY_RAYS || !report->open) return NORMA_OK;
    core_ray_votes votes;
    result = norma_core_orient_by_rays(t, c, COMPONENT_OPEN | COMPONENT_UNBALANCED, &votes);
    report->undecided = votes.undecided;
    report->by_rays = votes.decided;
    report->least_confidence = votes.least_confidence;
    return result;
}

static norma_result orient(
    core_topology *t, norma_orient_open open, uint8_t *reverse, norma_orient_report *report) {
    core_components components;
    norma_core_stage(t->call, 0.3, 0.6);
    norma_result result = pair_and_count(t, report);
    if (!result) result = norma_core_find_components(t, CORE_JOIN_CUT, &components);
    if (result) return result;
    norma_core_stage(t->call, 0.6, 1);
    result = orient_parts(t, open, &components, report);
    for (size_t f = 0; !result && f < t->mesh.face_count; ++f) {
        reverse[f] = components.reverse[f] != 0;
        report->reversed_faces += reverse[f];
    }
    norma_core_release_components(t->call, &components);
    return result;
}

norma_result norma_orient(const norma_mesh *mesh, norma_orient_open open,
    const norma_options *options, uint8_t *reverse, size_t capacity, norma_orient_report *report) {
    core_call call;
    core_mesh checked;
    core_topology topology;
    norma_orient_report counted = {.least_confidence = 1};
    norma_result result = norma_core_begin(&call, options);
    if (!result) result = norma_core_mesh_shape(mesh, &checked);
    if (!result) norma_core_share(&call, checked.corner_count);
    if (!result && ((checked.face_count && !reverse) || open < NORMA_ORIENT_OPEN_KEPT ||
                       open > NORMA_ORIENT_OPEN_BY_RAYS))
        result = NORMA_ERROR_ARGUMENT;
    if (!result && capacity < checked.face_count) result = NORMA_ERROR_CAPACITY;
    norma_core_stage(&call, 0, 0.1);
    if (!result) result = norma_core_mesh_content(&call, &checked);
    if (result) return result;
    if (checked.face_count) {
        norma_core_stage(&call, 0.1, 0.3);
        result = norma_core_topology_open(&call, &checked, &topology);
        if (result) return result;
        result = orient(&topology, open, reverse, &counted);
        norma_core_topology_close(&topology);
    }
    if (!result && report) *report = counted;
    return result;
}

/* ---- Turning faces round, in place. The first corner of each face stays, so that
 * what was said of it stays true. */

static void swap_elements(unsigned char *a, unsigned char *b, size_t size) {
    unsigned char kept[4];
    memcpy(kept, a, size);
    memcpy(a, b, size);
    memcpy(b, kept, size);
}

static norma_result check_winding(
    size_t corner_size, size_t corner_count, const uint32_t *face_starts, size_t face_count) {
    if (corner_size != 1 && corner_size != 2 && corner_size != 4) return NORMA_ERROR_ARGUMENT;
    if (corner_count > SIZE_MAX / corner_size) return NORMA_ERROR_OVERFLOW;
    if (!face_starts) return corner_count % 3 ? NORMA_ERROR_ARGUMENT : NORMA_OK;
    if (face_count >= SIZE_MAX / sizeof *face_starts) return NORMA_ERROR_OVERFLOW;
    if (face_starts[0] != 0 || face_starts[face_count] != corner_count) return NORMA_ERROR_ARGUMENT;
    for (size_t f = 0; f < face_count; ++f)
        if (face_starts[f + 1] < face_starts[f]) return NORMA_ERROR_ARGUMENT;
    return NORMA_OK;
}

norma_result norma_reverse_winding(void *corners, size_t corner_size, size_t corner_count,
    const uint32_t *face_starts, size_t face_count) {
    if (!corner_size) corner_size = 4;
    const norma_result result = check_winding(corner_size, corner_count, face_starts, face_count);
    if (result || !corner_count) return result;
    if (!corners) return NORMA_ERROR_ARGUMENT;
    if (!face_starts) face_count = corner_count / 3;
    for (size_t f = 0; f < face_count; ++f) {
        size_t low = (face_starts ? face_starts[f] : 3 * f) + 1,
               end = face_starts ? face_starts[f + 1] : 3 * f + 3;
        for (; low + 1 < end; ++low, --end)
            swap_elements((unsigned char *)corners + low * corner_size,
                (unsigned char *)corners + (end - 1) * corner_size, corner_size);
    }
    return NORMA_OK;
}
