/* nesting.c: which components lie in which, by trees over their boxes and faces. */
#include "core/topology/topology.h"
#include "core/face/face.h"

/* Those in nodes whose box holds the point; the caller looks at each one's own. */
static void core_box_tree_stab(const core_box_tree *tree, const double point[3],
    void (*visit)(void *context, uint32_t number), void *context) {
    uint32_t stack[128];
    size_t depth = 0;
    stack[depth++] = 0;
    while (depth) {
        const core_box_node *node = &tree->nodes[stack[--depth]];
        int outside = 0;
        for (int k = 0; k < 3; ++k)
            outside |= !(node->low[k] <= point[k] && node->high[k] >= point[k]);
        if (outside) continue;
        if (node->right) {
            stack[depth++] = node->left;
            stack[depth++] = node->right;
        }
        for (uint32_t i = 0; !node->right && i < node->count; ++i)
            visit(context, tree->numbers[node->begin + i]);
    }
}

/* ---- dipoles of faces */

static void middle_of(const core_mesh *mesh, size_t face, double middle[3]) {
    const size_t begin = norma_core_face_begin(mesh, face), end = norma_core_face_end(mesh, face);
    for (int k = 0; k < 3; ++k) middle[k] = 0;
    for (size_t c = begin; c < end; ++c) {
        double p[3];
        norma_core_position(mesh, norma_core_corner(mesh, c), p);
        for (int k = 0; k < 3; ++k) middle[k] += p[k] / (double)(end - begin);
    }
}

/* Area vector and area of one face, and how far its corners are from a centre. */
static double area_of_face(const core_mesh *mesh, size_t face, double area[3]) {
    core_face geometry;
    norma_core_face_geometry(mesh, face, &geometry);
    for (int k = 0; k < 3; ++k) area[k] = geometry.normal[k] * geometry.twice_area / 2;
    return geometry.twice_area / 2;
}

static double reach_from(const core_mesh *mesh, size_t face, const double centre[3]) {
    double most = 0;
    for (size_t c = norma_core_face_begin(mesh, face); c < norma_core_face_end(mesh, face); ++c) {
        double p[3], d[3];
        norma_core_position(mesh, norma_core_corner(mesh, c), p);
        norma_core_subtract(p, centre, d);
        most = fmax(most, norma_core_dot(d, d));
    }
    return sqrt(most);
}

typedef struct core_dipole {
    double centre[3], area[3],
        radius;    /* the sum of the faces' area vectors stands for them outside of some radii */
    double weight; /* the sum of their areas */
    uint32_t begin, count, left, right; /* of faces; nodes; right 0: a leaf */
} core_dipole;

typedef struct core_dipoles {
    core_dipole *nodes; /* NULL: there are none */
    uint32_t *faces;
    size_t node_count, count;
} core_dipoles;

typedef struct dipole_fill {
    const core_topology *topology;
    const uint8_t *reverse;
    const core_dipoles *dipoles;
    const uint32_t *faces; /* by number */
    const core_tree_item *items;
} dipole_fill;

static void fill_leaf(const dipole_fill *f, core_dipole *node) {
    const core_dipoles *d = f->dipoles;
    const core_mesh *mesh = &f->topology->mesh;
    for (uint32_t i = node->begin; i < node->begin + node->count; ++i) {
        double area[3];
        const uint32_t face = d->faces[i] = f->faces[f->items[i].number];
        const double size = area_of_face(mesh, face, area);
        const int turned = f->reverse && f->reverse[face];
        for (int k = 0; k < 3; ++k) {
            node->area[k] += turned ? -area[k] : area[k];
            node->centre[k] += size * f->items[i].centre[k];
        }
        node->weight += size;
    }
    for (int k = 0; k < 3; ++k)
        node->centre[k] =
            node->weight > 0 ? node->centre[k] / node->weight : f->items[node->begin].centre[k];
    for (uint32_t i = node->begin; i < node->begin + node->count; ++i)
        node->radius = fmax(node->radius, reach_from(mesh, d->faces[i], node->centre));
}

static void fill_from_children(const core_dipoles *d, core_dipole *node) {
    const core_dipole *half[2] = {&d->nodes[node->left], &d->nodes[node->right]};
    node->weight = half[0]->weight + half[1]->weight;
    for (int k = 0; k < 3; ++k) {
        node->area[k] = half[0]->area[k] + half[1]->area[k];
        node->centre[k] =
            node->weight > 0
                ? (half[0]->weight * half[0]->centre[k] + half[1]->weight * half[1]->centre[k]) /
                      node->weight
                : half[0]->centre[k];
    }
    for (int i = 0; i < 2; ++i) {
        double away[3];
        norma_core_subtract(half[i]->centre, node->centre, away);
        node->radius = fmax(node->radius, half[i]->radius + sqrt(norma_core_dot(away, away)));
    }
}

static void fill_dipole(void *context, const core_tree_part *part) {
    const dipole_fill *f = context;
    core_dipole *node = &f->dipoles->nodes[part->node];
    *node = (core_dipole){.begin = part->begin, .count = part->count};
    if (!part->halves) {
        fill_leaf(f, node);
        return;
    }
    node->left = part->halves;
    node->right = part->halves + 1;
    fill_from_children(f->dipoles, node);
}

/* Over some faces; reverse: NULL, or those that are taken the other way round. O(n log n). */
static void core_dipoles_release(const core_call *call, core_dipoles *d) {
    norma_core_release(call, d->faces, d->count, sizeof *d->faces);
    norma_core_release(call, d->nodes, norma_core_tree_nodes(d->count), sizeof *d->nodes);
    *d = (core_dipoles){0};
}

static norma_result core_dipoles_build(const core_topology *t, const uint8_t *reverse,
    const uint32_t *faces, size_t count, core_dipoles *d) {
    *d = (core_dipoles){.count = count};
    core_tree_item *items = norma_core_allocate(t->call, count, sizeof *items);
    d->faces = norma_core_allocate(t->call, count, sizeof *d->faces);
    d->nodes = norma_core_allocate(t->call, norma_core_tree_nodes(count), sizeof *d->nodes);
    norma_result result = items && d->faces && d->nodes ? NORMA_OK : NORMA_ERROR_MEMORY;
    for (size_t i = 0; !result && i < count; ++i) {
        items[i].number = (uint32_t)i;
        middle_of(&t->mesh, faces[i], items[i].centre);
    }
    dipole_fill fill = {t, reverse, d, faces, items};
    if (!result) result = norma_core_tree_grow(t->call, items, count, fill_dipole, &fill);
    norma_core_release(t->call, items, count, sizeof *items);
    if (result) core_dipoles_release(t->call, d);
    return result;
}

/* ---- Which components lie in which, by winding numbers (solid angle over 4 pi; van Oosterom,
 * Strackee 1983). Where many points are asked of one large component, faces far away count as one
 * dipole for each group (Barill, Dickson, Schmidt, Levin, Jacobson 2018), and the sum is trusted
 * where it is far from 1/2. */

typedef struct nesting {
    const core_topology *topology;
    core_components *components;
    core_box_tree tree; /* of the components' boxes */
    uint8_t not_closed;
    float *winding;        /* of each component in its parent */
    uint32_t *asked;       /* of each component: how many others may lie in it */
    core_dipoles *dipoles; /* of each component that has them */
} nesting;

/* ---- boxes in boxes */

static double extent(const core_component *c) {
    return (c->high[0] - c->low[0]) + (c->high[1] - c->low[1]) + (c->high[2] - c->low[2]);
}

/* A box of the same size lies in that of the lower number only, so that no two lie in each other.
 */
static int may_hold(const nesting *n, uint32_t outer, uint32_t inner) {
    const core_component *o = &n->components->each[outer], *i = &n->components->each[inner];
    if (outer == inner) return 0;
    for (int k = 0; k < 3; ++k)
        if (!(o->low[k] <= i->low[k] && o->high[k] >= i->high[k])) return 0;
    return extent(o) > extent(i) || (extent(o) == extent(i) && outer < inner);
}

/* ---- winding numbers */

static void solid_angle(const double a[3], const double b[3], const double c[3], double *sum) {
    const double la = sqrt(norma_core_dot(a, a)), lb = sqrt(norma_core_dot(b, b)),
                 lc = sqrt(norma_core_dot(c, c));
    double cross[3];
    norma_core_cross(b, c, cross);
    const double triple = norma_core_dot(a, cross), lengths = la * lb * lc;
    const double below =
        lengths + norma_core_dot(a, b) * lc + norma_core_dot(b, c) * la + norma_core_dot(c, a) * lb;
    if (fabs(triple) <= 1e-13 * lengths)
        return; /* relative to the box of these lengths: the point lies in the plane of the face,
                   seen from its edge, or within it, where neither side counts */
    *sum +=
        triple > 0 ? 2 * norma_core_angle(triple, below) : -2 * norma_core_angle(-triple, below);
}

static double face_angle(const core_mesh *mesh, size_t face, const double point[3]) {
    const size_t begin = norma_core_face_begin(mesh, face), end = norma_core_face_end(mesh, face);
    double p[3], first[3], a[3], b[3], sum = 0;
    norma_core_position(mesh, norma_core_corner(mesh, begin), p);
    norma_core_subtract(p, point, first);
    norma_core_position(mesh, norma_core_corner(mesh, begin + 1), p);
    norma_core_subtract(p, point, a);
    for (size_t c = begin + 2; c < end; ++c) {
        norma_core_position(mesh, norma_core_corner(mesh, c), p);
        norma_core_subtract(p, point, b);
        solid_angle(first, a, b, &sum);
        memcpy(a, b, sizeof a);
    }
    return sum;
}

static double winding_by_faces(
    const nesting *n, const uint32_t *faces, size_t count, const double point[3]) {
    double sum = 0;
    for (size_t i = 0; i < count; ++i) {
        const double angle = face_angle(&n->topology->mesh, faces[i], point);
        sum += n->components->reverse && n->components->reverse[faces[i]] ? -angle : angle;
    }
    return sum / (4 * NORMA_PI);
}

static double winding_by_dipoles(
    const nesting *n, const core_dipoles *d, const double point[3], double opening) {
    size_t stack[128], depth = 0;
    double sum = 0;
    stack[depth++] = 0;
    while (depth) {
        const core_dipole *node = &d->nodes[stack[--depth]];
        double away[3];
        norma_core_subtract(node->centre, point, away);
        const double square = norma_core_dot(away, away), reach = opening * node->radius;
        if (square > reach * reach)
            sum += norma_core_dot(node->area, away) / (square * sqrt(square)) / (4 * NORMA_PI);
        else if (!node->right)
            sum += winding_by_faces(n, &d->faces[node->begin], node->count, point);
        else {
            stack[depth++] = node->left;
            stack[depth++] = node->right;
        }
    }
    return sum;
}

/* In turn more carefully, until the sum is far enough from limit for what it may err. */
static double winding_of(const nesting *n, uint32_t outer, const double point[3], double limit) {
    static const struct { double opening, margin; } tries[] = {{2, .2}, {4, .06}, {8, .02}};
    const core_components *c = n->components;
    const core_dipoles *d = &n->dipoles[outer];
    for (size_t i = 0; d->nodes && i < sizeof tries / sizeof *tries; ++i) {
        const double w = winding_by_dipoles(n, d, point, tries[i].opening);
        if (fabs(fabs(w) - limit) > tries[i].margin) return w;
    }
    return winding_by_faces(
        n, &c->faces[c->starts[outer]], c->starts[outer + 1] - c->starts[outer], point);
}

/* ---- the parent of each: the smallest box first */

typedef struct candidates {
    uint32_t *numbers;
    size_t count, room;
    int failed;
} candidates;

static int is_judged(const nesting *n, uint32_t number) {
    const core_component *c = &n->components->each[number];
    return !(c->flags & n->not_closed) && c->volume != 0;
}

typedef struct ask {
    nesting *n;
    uint32_t inner;
    const double *point;
    double extent;
} ask;

static void count_asked(void *context, uint32_t outer) {
    const ask *a = context;
    if (may_hold(a->n, outer, a->inner)) ++a->n->asked[outer];
}

static void try_parent(void *context, uint32_t outer) {
    ask *a = context;
    core_component *inner = &a->n->components->each[a->inner];
    const double size = extent(&a->n->components->each[outer]);
    if (!may_hold(a->n, outer, a->inner)) return;
    if (inner->parent != UINT32_MAX &&
        (size > a->extent || (size == a->extent && outer < inner->parent)))
        return; /* a smaller one is known */
    const double winding = winding_of(a->n, outer, a->point, .5);
    if (!(fabs(winding) > .5 + 1e-9)) return; /* a number of turns, whatever the size */
    inner->parent = outer;
    a->n->winding[a->inner] = (float)winding;
    a->extent = size;
}

static void find_parent(void *context, size_t index) {
    nesting *n = context;
    const core_topology *t = n->topology;
    const core_components *c = n->components;
    core_component *inner = &c->each[index];
    double point[3];
    if (!is_judged(n, (uint32_t)index)) return;
    norma_core_position(
        &t->mesh, t->corners[norma_core_face_begin(&t->mesh, c->faces[c->starts[index]])], point);
    ask a = {n, (uint32_t)index, point, INFINITY};
    core_box_tree_stab(&n->tree, inner->low, try_parent, &a);
}

/* ---- verdicts, from outside in: a parent's box is larger than its child's */

typedef struct ranked {
    double extent;
    uint32_t number;
} ranked;

static int is_larger(const void *first, const void *second) {
    const ranked *a = first, *b = second;
    return a->extent != b->extent ? a->extent > b->extent : a->number < b->number;
}

/* The parent's sense where the child lies: 1 solid, -1 cavity, once what was found inward in it is
 * put right. */
static int sense_of_parent(const nesting *n, uint32_t child) {
    const core_component *c = &n->components->each[child];
    const int sense = n->winding[child] > 0 ? 1 : -1;
    return n->components->each[c->parent].verdict == COMPONENT_INWARD ? -sense : sense;
}

enum { FACES_WORTH_DIPOLES = 64, WORK_WORTH_DIPOLES = 1 << 11, CORNERS_ASKED = 100 };
static const double LEAST_WITHIN = .1; /* below the winding number at the corner of a box */

static norma_result build_dipoles(const nesting *n, uint32_t number) {
    const core_components *c = n->components;
    return core_dipoles_build(n->topology, c->reverse, &c->faces[c->starts[number]],
        c->starts[number + 1] - c->starts[number], &n->dipoles[number]);
}

/* Corners, evenly: a point on the parent's surface, or at an edge or a corner of it, is not
 * outside.
 */
static norma_result find_whether_it_reaches(const nesting *n, uint32_t number) {
    const core_components *c = n->components;
    const core_topology *t = n->topology;
    core_component *inner = &c->each[number];
    const size_t end = c->starts[number + 1],
                 stride = 1 + 3 * (end - c->starts[number]) / CORNERS_ASKED,
                 room = c->starts[inner->parent + 1] - c->starts[inner->parent];
    size_t passed = 0;
    if (!n->dipoles[inner->parent].nodes && room >= FACES_WORTH_DIPOLES) {
        const norma_result result = build_dipoles(n, inner->parent);
        if (result) return result;
    }
    for (size_t i = c->starts[number]; i < end; ++i)
        for (size_t k = norma_core_face_begin(&t->mesh, c->faces[i]);
             k < norma_core_face_end(&t->mesh, c->faces[i]); ++k) {
            double point[3];
            if (passed++ % stride) continue;
            norma_core_position(&t->mesh, t->corners[k], point);
            if (fabs(winding_of(n, inner->parent, point, LEAST_WITHIN)) < LEAST_WITHIN) {
                inner->flags |= COMPONENT_REACHES;
                return NORMA_OK;
            }
        }
    return NORMA_OK;
}

static norma_result judge_component(const nesting *n, uint32_t number) {
    core_component *c = &n->components->each[number];
    const int sense = c->parent == UINT32_MAX ? 0 : sense_of_parent(n, number);
    if (c->volume < 0)
        c->verdict = sense > 0 ? COMPONENT_FINE : COMPONENT_INWARD;
    else
        c->verdict = sense > 0 ? COMPONENT_NESTED : COMPONENT_FINE;
    return c->verdict == COMPONENT_NESTED ? find_whether_it_reaches(n, number) : NORMA_OK;
}

static norma_result judge_components(const nesting *n) {
    const core_components *c = n->components;
    ranked *order = norma_core_allocate(n->topology->call, c->count, sizeof *order);
    size_t count = 0;
    if (!order) return NORMA_ERROR_MEMORY;
    for (uint32_t i = 0; i < c->count; ++i)
        if (is_judged(n, i)) order[count++] = (ranked){extent(&c->each[i]), i};
    norma_core_sort(order, count, sizeof *order, is_larger);
    norma_result result = NORMA_OK;
    for (size_t i = 0; i < count && !result; ++i) result = judge_component(n, order[i].number);
    norma_core_release(n->topology->call, order, c->count, sizeof *order);
    return result;
}

/* ---- all */

static norma_result prepare_dipoles(nesting *n) {
    const core_components *c = n->components;
    for (uint32_t i = 0; i < c->count; ++i) {
        const size_t faces = c->starts[i + 1] - c->starts[i];
        if (faces < FACES_WORTH_DIPOLES || faces * n->asked[i] < WORK_WORTH_DIPOLES) continue;
        const norma_result result = build_dipoles(n, i);
        if (result) return result;
    }
    return NORMA_OK;
}

static norma_result find_parents(nesting *n) {
    const core_components *c = n->components;
    for (uint32_t i = 0; i < c->count; ++i)
        if (is_judged(n, i))
            core_box_tree_stab(&n->tree, c->each[i].low, count_asked, &(ask){n, i, NULL, 0});
    norma_result result = prepare_dipoles(n);
    if (!result) result = norma_core_parallel(n->topology->call, c->count, find_parent, n);
    return !result ? judge_components(n) : result;
}

static void box_of_component(void *context, uint32_t number, size_t place, core_box *box) {
    const core_component *c = &((const core_components *)context)->each[number];
    (void)place;
    memcpy(box->low, c->low, sizeof box->low);
    memcpy(box->high, c->high, sizeof box->high);
}

norma_result norma_core_judge_nesting(
    const core_topology *topology, core_components *components, uint8_t not_closed) {
    const core_call *call = topology->call;
    const size_t count = components->count;
    nesting n = {.topology = topology, .components = components, .not_closed = not_closed};
    if (!count) return NORMA_OK;
    n.winding = norma_core_allocate(call, count, sizeof *n.winding);
    n.asked = norma_core_allocate(call, count, sizeof *n.asked);
    n.dipoles = norma_core_allocate(call, count, sizeof *n.dipoles);
    norma_result result = n.winding && n.asked && n.dipoles ? NORMA_OK : NORMA_ERROR_MEMORY;
    if (!result) {
        memset(n.winding, 0, count * sizeof *n.winding);
        memset(n.asked, 0, count * sizeof *n.asked);
        memset(n.dipoles, 0, count * sizeof *n.dipoles);
        result =
            norma_core_box_tree_build(topology->call, count, box_of_component, components, &n.tree);
    }
    if (!result) result = find_parents(&n);
    for (size_t i = 0; n.dipoles && n.tree.nodes && i < count; ++i)
        core_dipoles_release(call, &n.dipoles[i]);
    norma_core_box_tree_release(call, &n.tree);
    norma_core_release(call, n.winding, count, sizeof *n.winding);
    norma_core_release(call, n.asked, count, sizeof *n.asked);
    norma_core_release(call, n.dipoles, count, sizeof *n.dipoles);
    return result;
}
