/* rays.c: which side of an open part is outward, by rays from points all over it, one to each side:
 * the side from which more of them leave the scene (Takayama, Jacobson, Kavan, Sorkine-Hornung 2014
 * count such rays as well). Fewer than a quarter more decide nothing. Points and directions are
 * numbers of a fixed sequence, and the same whichever way round a face is wound, so that a part
 * that was turned is not turned again. The steps of all rays are at most of the order of n log n,
 * however densely the n triangles lie, and each part has the same share of them; a part that uses
 * it up is judged by the rays that were cast until then. Where triangles coincide a single ray
 * could use up a share; then the rays of that part end with it. */
#include "core/topology/topology.h"
#include "core/face/face.h"
#include <float.h>
#include <stdlib.h>

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
    for (int k = 0; k < 3; k++) {
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
    for (int k = 0; k < 3; k++) {
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
        r->steps++;
        if (node->right) {
            depth += push_children(all, node, r, stack + depth);
            continue;
        }
        r->steps += node->count;
        for (uint32_t i = node->begin; i < node->begin + node->count; i++)
            if (meets_triangle(r, &all->tree.triangles[i])) return 0;
    }
    return 1;
}

/* ---- where rays start and where they go */

/* Of the sequence's number: three numbers from 0 to 1 (splitmix64, Steele, Lea, Flood 2014). */
static void three_numbers(uint64_t number, double out[3]) {
    for (int k = 0; k < 3; k++) {
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
        for (int k = 0; k < 3; k++) direction[k] = 2 * direction[k] - 1;
        square = norma_core_dot(direction, direction);
        number += UINT64_C(1) << 40;
    } while (square > 1 || square < 0x1p-8 || direction[0] == 0 || direction[1] == 0 ||
             direction[2] == 0);
    const double sign = norma_core_dot(direction, normal) < 0 ? -1 : 1;
    for (int k = 0; k < 3; k++) direction[k] *= sign / sqrt(square);
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
    for (int k = 0; k < 3; k++) origin[k] = p0[k] + a * (p1[k] - p0[k]) + b * (p2[k] - p0[k]);
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
    while (axis < 2 && normal[axis] == 0) axis++;
    return normal[axis] < 0;
}

/* 1: the front sees more of what is outside, -1: the back does, 0: both do, or neither. */
static int vote_of_face(const rays *all, size_t face, uint64_t number, ray *r) {
    double place[3], direction[3];
    core_face geometry;
    norma_core_face_geometry(&all->topology->mesh, face, &geometry);
    if (!(geometry.flags & CORE_FACE_DIRECTED)) return 0;
    const int reversed = looks_down(geometry.normal);
    for (int k = 0; k < 3 && reversed; k++) geometry.normal[k] = -geometry.normal[k];
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
    for (size_t i = c->starts[part]; i < c->starts[part + 1]; i++)
        total += twice_area_of(all->topology, c->faces[i]);
    for (size_t i = c->starts[part]; i < c->starts[part + 1] && total > 0; i++) {
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
        p->cast++;
    }
    p->steps = r.steps;
    if (p->cast < FEWEST_RAYS || 4 * abs(p->votes) < p->cast) p->votes = 0;
}

/* ---- all parts */

static void follow_votes(rays *all, core_ray_votes *votes) {
    core_components *c = all->components;
    for (size_t i = 0; i < c->count; i++) {
        if (!(c->each[i].flags & all->open_flags) || (c->each[i].flags & COMPONENT_ONE_SIDED))
            continue;
        const poll *p = &all->polls[i];
        votes->steps += p->steps;
        if (!p->votes) {
            votes->undecided++;
            c->each[i].flags |= COMPONENT_UNDECIDED;
            continue;
        }
        votes->decided++;
        votes->least_confidence =
            fmin(votes->least_confidence, fabs((double)p->votes) / (double)p->cast);
        if (p->votes > 0) continue;
        votes->reversed++;
        for (size_t k = c->starts[i]; k < c->starts[i + 1]; k++)
            c->reverse[c->faces[k]] = !c->reverse[c->faces[k]];
    }
}

norma_result norma_core_ray_scene_open(
    const core_topology *topology, core_components *components, core_ray_scene **scene) {
    const core_call *call = topology->call;
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
    if (result == NORMA_OK)
        *scene = all;
    else
        norma_core_ray_scene_close(all);
    return result;
}

norma_result norma_core_ray_scene_vote(
    core_ray_scene *scene, uint8_t open_flags, core_ray_votes *votes) {
    const size_t parts = scene->components->count;
    *votes = (core_ray_votes){.least_confidence = 1};
    scene->open_flags = open_flags;
    memset(scene->polls, 0, parts * sizeof *scene->polls);
    const norma_result result = norma_core_parallel(scene->topology->call, parts, poll_part, scene);
    if (result == NORMA_OK) follow_votes(scene, votes);
    return result;
}

void norma_core_ray_scene_close(core_ray_scene *scene) {
    if (!scene) return;
    const core_call *call = scene->topology->call;
    norma_core_triangle_tree_release(call, &scene->tree);
    norma_core_release(call, scene->polls, scene->components->count, sizeof *scene->polls);
    norma_core_release(call, scene, 1, sizeof *scene);
}

norma_result norma_core_orient_by_rays(const core_topology *topology, core_components *components,
    uint8_t open_flags, core_ray_votes *votes) {
    core_ray_scene *scene = NULL;
    *votes = (core_ray_votes){.least_confidence = 1};
    norma_result result = norma_core_ray_scene_open(topology, components, &scene);
    if (result == NORMA_OK) result = norma_core_ray_scene_vote(scene, open_flags, votes);
    norma_core_ray_scene_close(scene);
    return result;
}
