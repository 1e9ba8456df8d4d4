/* rays.c: which side of an open part is outward, by rays from points all over it: the side from
 * which they run farther before they meet something (Takayama, Jacobson, Kavan, Sorkine-Hornung
 * 2014). Points and directions are numbers of a fixed sequence, and the same whichever way round a
 * face is wound, so that a part that was turned is not turned again. Each part has a budget of
 * steps that grows with the logarithm of all faces, so that parts whose boxes all overlap cost no
 * more than others; a part that uses it up is judged by the rays that were cast until then. */
#include "core/orient/orient.h"
#include "core/orient/box_tree.h"
#include "core/face/triangle.h"
#include <float.h>

enum {
    MOST_RAYS = 256,   /* of a part: a power of two, as are fewer, see scramble */
    RAYS_OF_MANY = 64, /* of each part where there are more than MANY_PARTS */
    MANY_PARTS = 256,
    FEWEST_RAYS = 16, /* of a part whose budget is used up; with fewer it stays undecided */
    STEPS_OF_RAY = 16 /* times the logarithm of all faces: nodes and corners looked at */
};

typedef struct poll { /* of one part */
    int votes;        /* for the part as it is, less those against */
    uint32_t cast;
    uint64_t steps;
} poll;

typedef struct rays {
    const core_topology *topology;
    core_components *components;
    core_box_tree tree;
    uint8_t open_flags;
    uint32_t rays;       /* of each part */
    uint64_t budget;     /* of each ray, in steps; those of a part share theirs */
    double (*points)[3]; /* positions of the corners' numbers, as doubles */
    poll *polls;         /* of each part */
} rays;

/* ---- a ray */

typedef struct ray {
    double origin[3], direction[3], inverse[3]; /* inverse: 1 / direction */
    size_t face;                                /* it starts there, and does not meet it */
    double enough;        /* a hit nearer than this is near enough: no nearer one is looked for */
    uint64_t steps, most; /* nodes and corners looked at; no more are once they are most */
} ray;

static void point_ray(ray *r, const double direction[3], double sign) {
    for (int k = 0; k < 3; k++) {
        r->direction[k] = sign * direction[k];
        r->inverse[k] = 1 / r->direction[k];
    }
}

/* Distance along the ray to a triangle (Moller, Trumbore 1997); infinite: it passes by. */
static double meet_triangle(
    const ray *r, const double p0[3], const double p1[3], const double p2[3]) {
    double u[3], v[3], across[3], from[3], other[3];
    norma_core_subtract(p1, p0, u);
    norma_core_subtract(p2, p0, v);
    norma_core_cross(r->direction, v, across);
    const double determinant = norma_core_dot(u, across);
    if (determinant == 0) return INFINITY;
    norma_core_subtract(r->origin, p0, from);
    const double a = norma_core_dot(from, across) / determinant;
    norma_core_cross(from, u, other);
    const double b = norma_core_dot(r->direction, other) / determinant,
                 distance = norma_core_dot(v, other) / determinant;
    return a >= 0 && b >= 0 && a + b <= 1 && distance > 0 ? distance : INFINITY;
}

static double meet_face(const rays *all, const ray *r, size_t face) {
    const core_topology *t = all->topology;
    const size_t begin = norma_core_face_begin(&t->mesh, face),
                 end = norma_core_face_end(&t->mesh, face);
    double nearest = INFINITY;
    if (face == r->face || end - begin < 3) return INFINITY;
    const double *p0 = all->points[t->corners[begin]], *p1 = all->points[t->corners[begin + 1]];
    for (size_t c = begin + 2; c < end; c++) {
        const double *p2 = all->points[t->corners[c]];
        const double distance = meet_triangle(r, p0, p1, p2);
        nearest = distance < nearest ? distance : nearest;
        p1 = p2;
    }
    return nearest;
}

/* Where the ray enters the box; infinite: it misses the box, or enters it behind nearest. Relative
 * to the distance, this much is the rounding of both. */
static double enter_box(const core_box_node *node, const ray *r, double nearest) {
    double from = 0, to = nearest;
    for (int k = 0; k < 3; k++) {
        if (r->direction[k] == 0) {
            if (r->origin[k] < node->low[k] || r->origin[k] > node->high[k]) return INFINITY;
            continue;
        }
        const double a = (node->low[k] - r->origin[k]) * r->inverse[k],
                     b = (node->high[k] - r->origin[k]) * r->inverse[k];
        const double in = a < b ? a : b, out = a < b ? b : a;
        from = in > from ? in : from;
        to = out < to ? out : to;
    }
    return from > to * (1 + 8 * DBL_EPSILON) ? INFINITY : from;
}

typedef struct waiting {
    uint32_t node;
    double from; /* where the ray enters it */
} waiting;

/* Both children that the ray enters, the nearer one on top. */
static size_t push_children(
    const rays *all, const core_box_node *node, const ray *r, double nearest, waiting *to) {
    waiting near = {node->left, enter_box(&all->tree.nodes[node->left], r, nearest)},
            far = {node->right, enter_box(&all->tree.nodes[node->right], r, nearest)};
    size_t count = 0;
    if (far.from < near.from) {
        const waiting swap = near;
        near = far;
        far = swap;
    }
    if (far.from < INFINITY) to[count++] = far;
    if (near.from < INFINITY) to[count++] = near;
    return count;
}

/* The nearest hit not beyond limit, or some hit nearer than r->enough; infinite: nothing is
 * hit. Has no meaning once r->steps has reached r->most. */
static double meet_anything(const rays *all, ray *r, double limit) {
    waiting stack[128];
    size_t depth = 0;
    double nearest = limit;
    int met = 0;
    stack[depth++] = (waiting){0, enter_box(&all->tree.nodes[0], r, limit)};
    while (depth && r->steps < r->most && !(met && nearest < r->enough)) {
        const waiting top = stack[--depth];
        const core_box_node *node = &all->tree.nodes[top.node];
        r->steps++;
        if (!(top.from < INFINITY) || top.from > nearest * (1 + 8 * DBL_EPSILON)) continue;
        if (node->right) {
            depth += push_children(all, node, r, nearest, stack + depth);
            continue;
        }
        for (uint32_t i = 0; i < node->count; i++) {
            const size_t face = all->tree.numbers[node->begin + i];
            const double hit = meet_face(all, r, face);
            r->steps += norma_core_face_end(&all->topology->mesh, face) -
                        norma_core_face_begin(&all->topology->mesh, face);
            if (!(hit <= nearest) || hit == INFINITY) continue;
            nearest = hit;
            met = 1;
        }
    }
    return met ? nearest : INFINITY;
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

/* A direction to the normal's side: the normal and a point of the unit ball, together. */
static void aim(const double normal[3], uint64_t number, double direction[3]) {
    double p[3];
    do {
        three_numbers(number, p);
        for (int k = 0; k < 3; k++) p[k] = 2 * p[k] - 1;
        number += UINT64_C(1) << 40;
    } while (norma_core_dot(p, p) > 1);
    for (int k = 0; k < 3; k++) direction[k] = normal[k] + 0.999 * p[k];
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
    const double *p0 = all->points[t->corners[begin]],
                 *p1 = all->points[t->corners[reversed ? at + 1 : at]],
                 *p2 = all->points[t->corners[reversed ? at : at + 1]];
    double a = numbers[0], b = numbers[1];
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

/* 1: the front runs farther, -1: the back, 0: no opinion. */
static int vote(const rays *all, size_t face, uint64_t number, ray *r) {
    double place[3], direction[3];
    core_face geometry;
    r->face = face;
    r->enough = 0;
    norma_core_face_geometry(&all->topology->mesh, face, &geometry);
    if (!(geometry.flags & CORE_FACE_DIRECTED)) return 0;
    const int reversed = looks_down(geometry.normal);
    for (int k = 0; k < 3 && reversed; k++) geometry.normal[k] = -geometry.normal[k];
    three_numbers(2 * number + 1, place);
    start(all, face, reversed, place, r->origin);
    aim(geometry.normal, 2 * number, direction);
    point_ray(r, direction, 1);
    const double front = meet_anything(all, r, INFINITY);
    point_ray(r, direction, -1);
    r->enough = front; /* how much nearer the back is does not matter */
    const double back = meet_anything(all, r, front);
    const int outward = (front > back) - (front < back);
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

static void poll_part(void *context, size_t part) {
    const rays *all = context;
    const core_components *c = all->components;
    const uint32_t count = all->rays;
    poll *p = &all->polls[part];
    uint32_t faces[MOST_RAYS];
    if (!(c->each[part].flags & all->open_flags) || (c->each[part].flags & COMPONENT_ONE_SIDED) ||
        !choose_faces(all, part, count, faces))
        return;
    ray r = {.most = 2 * count * all->budget};
    for (; p->cast < count; p->cast++) {
        const uint32_t number = scramble(p->cast, count);
        const int says = vote(all, faces[number], number, &r);
        if (r.steps >= r.most) break;
        p->votes += says;
    }
    p->steps = r.steps;
    if (p->cast < FEWEST_RAYS) p->votes = 0;
}

/* ---- all parts */

static norma_result build_tree(rays *all) {
    const core_topology *t = all->topology;
    core_box *boxes = norma_core_allocate(t->call, t->mesh.face_count, sizeof *boxes);
    if (!boxes) return NORMA_ERROR_MEMORY;
    for (size_t f = 0; f < t->mesh.face_count; f++) {
        boxes[f] = (core_box){{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
        for (size_t c = norma_core_face_begin(&t->mesh, f); c < norma_core_face_end(&t->mesh, f);
             c++) {
            double p[3];
            norma_core_position(&t->mesh, t->corners[c], p);
            for (int k = 0; k < 3; k++) {
                boxes[f].low[k] = fmin(boxes[f].low[k], p[k]);
                boxes[f].high[k] = fmax(boxes[f].high[k], p[k]);
            }
        }
    }
    const norma_result result =
        norma_core_box_tree_build(t->call, boxes, t->mesh.face_count, &all->tree);
    norma_core_release(t->call, boxes, t->mesh.face_count, sizeof *boxes);
    return result;
}

static void follow_votes(rays *all, core_ray_votes *votes) {
    core_components *c = all->components;
    for (size_t i = 0; i < c->count; i++) {
        if (!(c->each[i].flags & all->open_flags) || (c->each[i].flags & COMPONENT_ONE_SIDED))
            continue;
        const poll *p = &all->polls[i];
        votes->steps += p->steps;
        if (!p->votes) {
            votes->undecided++;
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

norma_result norma_core_orient_by_rays(const core_topology *topology, core_components *components,
    uint8_t open_flags, core_ray_votes *votes) {
    const core_call *call = topology->call;
    const size_t parts = components->count, positions = topology->mesh.positions.count;
    rays all = {.topology = topology,
        .components = components,
        .open_flags = open_flags,
        .rays = parts > MANY_PARTS ? RAYS_OF_MANY : MOST_RAYS};
    *votes = (core_ray_votes){.least_confidence = 1};
    all.polls = norma_core_allocate(call, parts, sizeof *all.polls);
    all.points = norma_core_allocate(call, positions, sizeof *all.points);
    for (size_t faces = topology->mesh.face_count; faces > 0; faces /= 2)
        all.budget += STEPS_OF_RAY;
    norma_result result = all.polls && all.points ? build_tree(&all) : NORMA_ERROR_MEMORY;
    if (result == NORMA_OK) {
        memset(all.polls, 0, parts * sizeof *all.polls);
        for (size_t i = 0; i < positions; i++)
            norma_core_position(&topology->mesh, (uint32_t)i, all.points[i]);
        result = norma_core_parallel(topology->call, parts, poll_part, &all);
        if (result == NORMA_OK) follow_votes(&all, votes);
        norma_core_box_tree_release(call, &all.tree);
    }
    norma_core_release(call, all.points, positions, sizeof *all.points);
    norma_core_release(call, all.polls, parts, sizeof *all.polls);
    return result;
}
