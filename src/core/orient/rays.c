/* rays.c: which side of an open part is outward, by rays from points all over it: the side from
 * which they run farther before they meet something (Takayama, Jacobson, Kavan, Sorkine-Hornung
 * 2014). Points and directions are numbers of a fixed sequence, so that the answer is the mesh's
 * own. */
#include "core/orient/orient.h"
#include "core/orient/box_tree.h"
#include "core/face/triangle.h"
#include <float.h>

enum { RAYS_OF_PART = 256 };

typedef struct rays {
    const core_topology *topology;
    core_components *components;
    core_box_tree tree;
    uint8_t open_flags;
    int *votes; /* of each part: for as it is, less those against */
} rays;

/* ---- a ray */

typedef struct ray {
    double origin[3], direction[3];
    size_t face;
} ray; /* face: that it starts from, which it does not meet */

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

static double meet_face(const core_topology *t, const ray *r, size_t face) {
    const size_t begin = norma_core_face_begin(&t->mesh, face),
                 end = norma_core_face_end(&t->mesh, face);
    double p0[3], p1[3], p2[3], nearest = INFINITY;
    if (face == r->face || end - begin < 3) return INFINITY;
    norma_core_position(&t->mesh, t->corners[begin], p0);
    norma_core_position(&t->mesh, t->corners[begin + 1], p1);
    for (size_t c = begin + 2; c < end; c++) {
        norma_core_position(&t->mesh, t->corners[c], p2);
        nearest = fmin(nearest, meet_triangle(r, p0, p1, p2));
        memcpy(p1, p2, sizeof p1);
    }
    return nearest;
}

static int misses_box(const core_box_node *node, const ray *r, double nearest) {
    double from = 0, to = nearest;
    for (int k = 0; k < 3; k++) {
        if (r->direction[k] == 0) {
            if (r->origin[k] < node->low[k] || r->origin[k] > node->high[k]) return 1;
            continue;
        }
        const double a = (node->low[k] - r->origin[k]) / r->direction[k],
                     b = (node->high[k] - r->origin[k]) / r->direction[k];
        from = fmax(from, fmin(a, b));
        to = fmin(to, fmax(a, b));
    }
    return from > to * (1 + 4 * DBL_EPSILON);
}

static double meet_anything(const rays *all, const ray *r) {
    uint32_t stack[128];
    size_t depth = 0;
    double nearest = INFINITY;
    stack[depth++] = 0;
    while (depth) {
        const core_box_node *node = &all->tree.nodes[stack[--depth]];
        if (misses_box(node, r, nearest)) continue;
        if (node->right) {
            stack[depth++] = node->left;
            stack[depth++] = node->right;
        }
        for (uint32_t i = 0; !node->right && i < node->count; i++)
            nearest =
                fmin(nearest, meet_face(all->topology, r, all->tree.numbers[node->begin + i]));
    }
    return nearest;
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

/* In the fan triangle of the face's first corner that the numbers choose. */
static void start(const core_topology *t, size_t face, const double numbers[3], double origin[3]) {
    const size_t begin = norma_core_face_begin(&t->mesh, face),
                 triangles = norma_core_face_end(&t->mesh, face) - begin - 2;
    const size_t at = begin + 1 + (size_t)(numbers[2] * (double)triangles) % triangles;
    double p[3][3], a = numbers[0], b = numbers[1];
    if (a + b > 1) {
        a = 1 - a;
        b = 1 - b;
    }
    norma_core_position(&t->mesh, t->corners[begin], p[0]);
    norma_core_position(&t->mesh, t->corners[at], p[1]);
    norma_core_position(&t->mesh, t->corners[at + 1], p[2]);
    for (int k = 0; k < 3; k++)
        origin[k] = p[0][k] + a * (p[1][k] - p[0][k]) + b * (p[2][k] - p[0][k]);
}

static double twice_area_of(const core_topology *t, size_t face) {
    core_face geometry;
    norma_core_face_geometry(&t->mesh, face, &geometry);
    return geometry.flags & CORE_FACE_FINITE ? geometry.twice_area : 0;
}

/* 1: the front runs farther, -1: the back, 0: no opinion. */
static int vote(const rays *all, size_t face, uint64_t number) {
    const core_topology *t = all->topology;
    double place[3];
    core_face geometry;
    ray r = {.face = face};
    norma_core_face_geometry(&t->mesh, face, &geometry);
    if (!(geometry.flags & CORE_FACE_DIRECTED)) return 0;
    three_numbers(2 * number + 1, place);
    start(t, face, place, r.origin);
    aim(geometry.normal, 2 * number, r.direction);
    const double front = meet_anything(all, &r);
    for (int k = 0; k < 3; k++) r.direction[k] = -r.direction[k];
    const double back = meet_anything(all, &r);
    const int outward = (front > back) - (front < back);
    return all->components->reverse[face] ? -outward : outward;
}

/* Rays start where equal shares of the part's area end. */
static void poll_part(void *context, size_t part) {
    const rays *all = context;
    const core_components *c = all->components;
    const size_t begin = c->starts[part], end = c->starts[part + 1];
    double total = 0, passed = 0;
    size_t cast = 0;
    if (!(c->each[part].flags & all->open_flags) || (c->each[part].flags & COMPONENT_ONE_SIDED))
        return;
    for (size_t i = begin; i < end; i++) total += twice_area_of(all->topology, c->faces[i]);
    for (size_t i = begin; i < end && total > 0; i++) {
        passed += twice_area_of(all->topology, c->faces[i]);
        for (; cast < RAYS_OF_PART && passed * RAYS_OF_PART >= ((double)cast + .5) * total;
             cast++) {
            const int says = vote(all, c->faces[i], (uint64_t)cast);
            all->votes[part] += says;
        }
    }
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
        if (!all->votes[i]) {
            votes->undecided++;
            continue;
        }
        votes->decided++;
        votes->least_confidence =
            fmin(votes->least_confidence, fabs((double)all->votes[i]) / RAYS_OF_PART);
        if (all->votes[i] > 0) continue;
        votes->reversed++;
        for (size_t k = c->starts[i]; k < c->starts[i + 1]; k++)
            c->reverse[c->faces[k]] = !c->reverse[c->faces[k]];
    }
}

norma_result norma_core_orient_by_rays(const core_topology *topology, core_components *components,
    uint8_t open_flags, core_ray_votes *votes) {
    const core_call *call = topology->call;
    const size_t parts = components->count;
    rays all = {.topology = topology, .components = components, .open_flags = open_flags};
    *votes = (core_ray_votes){.least_confidence = 1};
    all.votes = norma_core_allocate(call, parts, sizeof *all.votes);
    norma_result result = all.votes ? build_tree(&all) : NORMA_ERROR_MEMORY;
    if (result == NORMA_OK) {
        memset(all.votes, 0, parts * sizeof *all.votes);
        result = norma_core_parallel(topology->call, parts, poll_part, &all);
        if (result == NORMA_OK) follow_votes(&all, votes);
        norma_core_box_tree_release(call, &all.tree);
    }
    norma_core_release(call, all.votes, parts, sizeof *all.votes);
    return result;
}
