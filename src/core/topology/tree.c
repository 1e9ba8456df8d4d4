/* tree.c: halves a set along the widest side of its centres, again and again; boxes over the
 * halves. The order is that of the centres, then of the numbers, so that the tree is the mesh's
 * own. The triangles of a mesh in such a tree, and norma_closest_points. */
#include "core/topology/topology.h"
#include "core/face/cut_polygon.h"

enum { LEAF = 8, FEW_ITEMS = 32 };

/* ---- one set */

static int is_before(const core_tree_item *a, const core_tree_item *b, int axis) {
    return a->centre[axis] != b->centre[axis] ? a->centre[axis] < b->centre[axis]
                                              : a->number < b->number;
}

static int is_before_x(const void *a, const void *b) { return is_before(a, b, 0); }
static int is_before_y(const void *a, const void *b) { return is_before(a, b, 1); }
static int is_before_z(const void *a, const void *b) { return is_before(a, b, 2); }

static void sort_few(core_tree_item *items, size_t count, int axis) {
    for (size_t i = 1; i < count; ++i) {
        const core_tree_item moved = items[i];
        size_t at = i;
        for (; at > 0 && is_before(&moved, &items[at - 1], axis); --at) items[at] = items[at - 1];
        items[at] = moved;
    }
}

/* Selects the middle (Hoare's quickselect with a fallback to sorting where pivots are bad): smaller
 * ones before it, larger ones behind. */
static void halve_along(core_tree_item *items, size_t count, int axis) {
    static int (*const before[])(const void *, const void *) = {
        is_before_x, is_before_y, is_before_z};
    size_t low = 0, high = count, middle = count / 2;
    for (int tries = 0; high - low > FEW_ITEMS; ++tries) {
        if (tries > 64) {
            norma_core_sort(items + low, high - low, sizeof *items, before[axis]);
            return;
        }
        const core_tree_item pivot = items[low + (high - low) / 2];
        size_t i = low, k = high - 1;
        for (;;) {
            while (is_before(&items[i], &pivot, axis)) ++i;
            while (is_before(&pivot, &items[k], axis)) --k;
            if (i >= k) break;
            const core_tree_item swap = items[i];
            items[i] = items[k];
            items[k] = swap;
            ++i;
            --k;
        }
        /* items before i are not above the pivot, those behind k not below it */
        if (middle <= k)
            high = k + 1;
        else
            low = k + 1;
    }
    sort_few(items + low, high - low, axis);
}

static void halve_items(core_tree_item *items, size_t count) {
    double low[3], high[3];
    int axis = 0;
    memcpy(low, items[0].centre, sizeof low);
    memcpy(high, items[0].centre, sizeof high);
    for (size_t i = 1; i < count; ++i)
        for (int k = 0; k < 3; ++k) {
            const double at = items[i].centre[k];
            low[k] = at < low[k] ? at : low[k];
            high[k] = at > high[k] ? at : high[k];
        }
    for (int k = 1; k < 3; ++k)
        if (high[k] - low[k] > high[axis] - low[axis]) axis = k;
    halve_along(items, count, axis);
}

/* ---- all: the nodes of two halves lie side by side, then those below the first, then those below
 * the second, so that threads that grow them need not know of each other */

/* At depth d the sets have count / 2^d items, count % 2^d of them one more. */
static size_t nodes_below(size_t count) {
    size_t nodes = 0;
    int depth = 0;
    for (; count >> depth > LEAF; ++depth) nodes += (size_t)2 << depth;
    if (count >> depth == LEAF) nodes += 2 * (count & (((size_t)1 << depth) - 1));
    return nodes;
}

size_t norma_core_tree_nodes(size_t count) { return 1 + nodes_below(count); }

static core_tree_part make_part(size_t begin, size_t count, size_t node, size_t below) {
    return (core_tree_part){
        (uint32_t)begin, (uint32_t)count, (uint32_t)node, count > LEAF ? (uint32_t)below : 0};
}

static void halve_part(
    core_tree_item *items, const core_tree_part *part, core_tree_part halves[2]) {
    const uint32_t half = part->count / 2, first = part->halves;
    halve_items(items + part->begin, part->count);
    halves[0] = make_part(part->begin, half, first, first + 2);
    halves[1] =
        make_part(part->begin + half, part->count - half, first + 1, first + 2 + nodes_below(half));
}

enum { SHARED_PARTS = 32, WORTH_SHARING = 1 << 14 };

typedef struct growth {
    core_tree_item *items;
    void (*fill)(void *context, const core_tree_part *part);
    void *context;
    core_tree_part parts[2 * SHARED_PARTS]; /* that of i has the halves of 2 i and 2 i + 1 */
    size_t first;                           /* of those at hand */
} growth;

static void grow_part(const growth *g, const core_tree_part *part) {
    core_tree_part halves[2];
    if (part->halves) {
        halve_part(g->items, part, halves);
        grow_part(g, &halves[0]);
        grow_part(g, &halves[1]);
    }
    g->fill(g->context, part);
}

static void halve_shared_part(void *context, size_t index) {
    growth *g = context;
    const size_t i = g->first + index;
    halve_part(g->items, &g->parts[i], &g->parts[2 * i]);
}

static void grow_shared_part(void *context, size_t index) {
    const growth *g = context;
    grow_part(g, &g->parts[g->first + index]);
}

/* One of many steps of a stage, after none of which the stage is over. */
static norma_result run_tree_step(core_call *call, size_t count, norma_task *task, void *context) {
    const double to = call->progress_to;
    call->progress_to = call->progress_from;
    const norma_result result = norma_core_parallel(call, count, task, context);
    call->progress_to = to;
    return result;
}

norma_result norma_core_tree_grow(core_call *call, core_tree_item *items, size_t count,
    void (*fill)(void *context, const core_tree_part *part), void *context) {
    growth g = {.items = items, .fill = fill, .context = context, .first = 1};
    norma_result result = NORMA_OK;
    for (size_t i = 0; i < count; ++i)
        for (int k = 0; k < 3; ++k)
            if (items[i].centre[k] != items[i].centre[k]) items[i].centre[k] = 0;
    g.parts[1] = make_part(0, count, 0, 1);
    for (; count >= WORTH_SHARING && g.first < SHARED_PARTS && !result; g.first *= 2)
        result = run_tree_step(call, g.first, halve_shared_part, &g);
    if (!result) result = run_tree_step(call, g.first, grow_shared_part, &g);
    for (size_t i = g.first; i-- > 1 && !result;) fill(context, &g.parts[i]);
    return result;
}

/* ---- boxes */

enum { BOXES_AT_ONCE = 4096 };

typedef struct boxing {
    core_box_tree *tree;
    core_tree_item *items;
    core_box_of *box_of;
    void *context;
} boxing;

static void measure_boxes(void *context, size_t chunk) {
    const boxing *b = context;
    const size_t first = chunk * BOXES_AT_ONCE, left = b->tree->count - first;
    for (size_t i = first; i < first + (left < BOXES_AT_ONCE ? left : BOXES_AT_ONCE); ++i) {
        core_box box;
        b->box_of(b->context, (uint32_t)i, SIZE_MAX, &box);
        b->items[i].number = (uint32_t)i;
        for (int k = 0; k < 3; ++k) b->items[i].centre[k] = box.low[k] / 2 + box.high[k] / 2;
    }
}

static void join_boxes(core_box_node *node, const double low[3], const double high[3]) {
    for (int k = 0; k < 3; ++k) {
        node->low[k] = low[k] < node->low[k] ? low[k] : node->low[k];
        node->high[k] = high[k] > node->high[k] ? high[k] : node->high[k];
    }
}

static void fill_box(void *context, const core_tree_part *part) {
    const boxing *b = context;
    core_box_node *node = &b->tree->nodes[part->node];
    *node = (core_box_node){{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY},
        part->begin, part->count, part->halves, part->halves ? part->halves + 1 : 0};
    for (uint32_t i = 0; part->halves && i < 2; ++i) {
        const core_box_node *half = &b->tree->nodes[part->halves + i];
        join_boxes(node, half->low, half->high);
    }
    for (uint32_t i = part->begin; !part->halves && i < part->begin + part->count; ++i) {
        core_box box;
        b->box_of(b->context, b->items[i].number, i, &box);
        b->tree->numbers[i] = b->items[i].number;
        join_boxes(node, box.low, box.high);
    }
}

norma_result norma_core_box_tree_build(
    core_call *call, size_t count, core_box_of *box_of, void *context, core_box_tree *tree) {
    *tree = (core_box_tree){.count = count};
    boxing b = {tree, norma_core_allocate(call, count, sizeof *b.items), box_of, context};
    tree->numbers = norma_core_allocate(call, count, sizeof *tree->numbers);
    tree->nodes = norma_core_allocate(call, norma_core_tree_nodes(count), sizeof *tree->nodes);
    norma_result result = b.items && tree->numbers && tree->nodes ? NORMA_OK : NORMA_ERROR_MEMORY;
    if (!result)
        result =
            run_tree_step(call, (count + BOXES_AT_ONCE - 1) / BOXES_AT_ONCE, measure_boxes, &b);
    if (!result) result = norma_core_tree_grow(call, b.items, count, fill_box, &b);
    norma_core_release(call, b.items, count, sizeof *b.items);
    if (result) norma_core_box_tree_release(call, tree);
    return result;
}

void norma_core_box_tree_release(const core_call *call, core_box_tree *tree) {
    norma_core_release(call, tree->numbers, tree->count, sizeof *tree->numbers);
    norma_core_release(call, tree->nodes, norma_core_tree_nodes(tree->count), sizeof *tree->nodes);
    *tree = (core_box_tree){0};
}

/* ---- the triangles of a mesh in a tree of boxes, for rays, and for the points nearest to others
 * (Ericson 2005, Real-Time Collision Detection, 5.1.5). */

/* ---- the triangles of all faces */

typedef struct listed_triangle {
    uint32_t face, corners[3];
} listed_triangle;

typedef struct triangle_list {
    const core_mesh *mesh;
    listed_triangle *each;
    size_t count, room;
    core_triangles_by by;
    core_triangle *ordered; /* in the order of the leaves, so that those of one lie side by side */
} triangle_list;

static void read_three_corners(const core_mesh *mesh, const uint32_t corners[3], double p[3][3]) {
    for (int i = 0; i < 3; ++i)
        norma_core_position(mesh, norma_core_corner(mesh, corners[i]), p[i]);
}

static int has_area(const double p[3][3]) {
    double u[3], v[3], across[3];
    norma_core_subtract(p[1], p[0], u);
    norma_core_subtract(p[2], p[0], v);
    norma_core_cross(u, v, across);
    return across[0] != 0 || across[1] != 0 || across[2] != 0;
}

/* Unless it is not finite. */
static void list_triangle(triangle_list *list, size_t face, const uint32_t corners[3]) {
    double p[3][3];
    read_three_corners(list->mesh, corners, p);
    for (int i = 0; i < 3; ++i)
        if (!norma_core_finite(p[i])) return;
    if (list->by == CORE_TRIANGLES_CUT && !has_area((const double(*)[3])p)) return;
    list->each[list->count++] =
        (listed_triangle){(uint32_t)face, {corners[0], corners[1], corners[2]}};
}

/* Numbers of corners within the face. */
static void cut_face_by_ears(
    const core_mesh *mesh, size_t begin, size_t count, core_cutter *cutter, uint32_t *triangles) {
    for (size_t i = 0; i < count; ++i)
        norma_core_position(mesh, norma_core_corner(mesh, begin + i), cutter->points[i]);
    if (norma_core_polygon_fans(cutter, count)) return;
    (void)norma_core_cut_polygon(cutter, count, triangles);
}

static void list_face(triangle_list *list, size_t face, core_cutter *cutter, uint32_t *triangles) {
    const size_t begin = norma_core_face_begin(list->mesh, face),
                 count = norma_core_face_end(list->mesh, face) - begin;
    for (uint32_t i = 2; i < count; ++i)
        memcpy(triangles + 3 * (i - 2), (const uint32_t[]){0, i - 1, i}, 3 * sizeof *triangles);
    if (list->by == CORE_TRIANGLES_CUT && count > 3)
        cut_face_by_ears(list->mesh, begin, count, cutter, triangles);
    for (size_t i = 0; i + 2 < count; ++i) {
        uint32_t corners[3];
        for (size_t k = 0; k < 3; ++k) corners[k] = (uint32_t)begin + triangles[3 * i + k];
        list_triangle(list, face, corners);
    }
}

static norma_result list_triangles(const core_call *call, triangle_list *list) {
    const core_mesh *mesh = list->mesh;
    core_cutter cutter;
    size_t largest = 3;
    for (size_t f = 0; f < mesh->face_count; ++f) {
        const size_t corners = norma_core_face_end(mesh, f) - norma_core_face_begin(mesh, f);
        list->room += corners > 2 ? corners - 2 : 0;
        largest = corners > largest ? corners : largest;
    }
    const size_t size = norma_core_cutter_size(largest);
    list->each = norma_core_allocate(call, list->room, sizeof *list->each);
    uint32_t *triangles = norma_core_allocate(call, largest, 3 * sizeof *triangles);
    void *memory = norma_core_allocate(call, 1, size);
    const norma_result result = list->each && triangles && memory ? NORMA_OK : NORMA_ERROR_MEMORY;
    if (memory) norma_core_cutter_begin(&cutter, memory, largest, mesh->corner_count);
    for (size_t f = 0; !result && f < mesh->face_count; ++f) list_face(list, f, &cutter, triangles);
    norma_core_release(call, triangles, largest, 3 * sizeof *triangles);
    norma_core_release(call, memory, 1, size);
    return result;
}

static void box_of_triangle(void *context, uint32_t number, size_t place, core_box *box) {
    const triangle_list *list = context;
    const listed_triangle *listed = &list->each[number];
    double p[3][3];
    read_three_corners(list->mesh, listed->corners, p);
    for (int k = 0; k < 3; ++k) {
        box->low[k] = box->high[k] = p[0][k];
        for (int i = 1; i < 3; ++i) {
            box->low[k] = p[i][k] < box->low[k] ? p[i][k] : box->low[k];
            box->high[k] = p[i][k] > box->high[k] ? p[i][k] : box->high[k];
        }
    }
    if (place == SIZE_MAX) return;
    core_triangle *to = &list->ordered[place];
    to->face = listed->face;
    memcpy(to->corners, listed->corners, sizeof to->corners);
    memcpy(to->corner, p[0], sizeof p[0]);
    norma_core_subtract(p[1], p[0], to->u);
    norma_core_subtract(p[2], p[0], to->v);
}

norma_result norma_core_triangle_tree_build(
    core_call *call, const core_mesh *mesh, core_triangles_by by, core_triangle_tree *tree) {
    triangle_list list = {.mesh = mesh, .by = by};
    *tree = (core_triangle_tree){.count = 0};
    norma_result result = list_triangles(call, &list);
    if (!result) {
        tree->count = list.count;
        tree->triangles = list.ordered =
            norma_core_allocate(call, list.count, sizeof *list.ordered);
        result = list.ordered ? norma_core_box_tree_build(
                                    call, list.count, box_of_triangle, &list, &tree->boxes)
                              : NORMA_ERROR_MEMORY;
    }
    norma_core_release(call, list.each, list.room, sizeof *list.each);
    if (result) norma_core_triangle_tree_release(call, tree);
    return result;
}

void norma_core_triangle_tree_release(const core_call *call, core_triangle_tree *tree) {
    norma_core_box_tree_release(call, &tree->boxes);
    norma_core_release(call, tree->triangles, tree->count, sizeof *tree->triangles);
    tree->triangles = NULL;
}

/* ---- nearest points */

/* Sets the weights of the second and third corner; the names are those of the source. */
static void nearest_weights(const core_triangle *t, const double from[3], double weights[2]) {
    const double uu = norma_core_dot(t->u, t->u), uv = norma_core_dot(t->u, t->v),
                 vv = norma_core_dot(t->v, t->v), d1 = norma_core_dot(t->u, from),
                 d2 = norma_core_dot(t->v, from), d3 = d1 - uu, d4 = d2 - uv, d5 = d1 - uv,
                 d6 = d2 - vv, vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6,
                 va = d3 * d6 - d5 * d4;
    weights[0] = weights[1] = 0;
    if (d1 <= 0 && d2 <= 0) return;
    if (d3 >= 0 && d4 <= d3) {
        weights[0] = 1;
    } else if (d6 >= 0 && d5 <= d6) {
        weights[1] = 1;
    } else if (vc <= 0 && d1 >= 0 && d3 <= 0) {
        weights[0] = d1 / uu;
    } else if (vb <= 0 && d2 >= 0 && d6 <= 0) {
        weights[1] = d2 / vv;
    } else if (va <= 0 && d4 >= d3 && d5 >= d6) {
        weights[1] = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        weights[0] = 1 - weights[1];
    } else {
        weights[0] = vb / (va + vb + vc);
        weights[1] = vc / (va + vb + vc);
    }
}

double norma_core_nearest_in_triangle(
    const core_triangle *t, const double point[3], double weights[2]) {
    double from[3];
    norma_core_subtract(point, t->corner, from);
    nearest_weights(t, from, weights);
    for (int k = 0; k < 3; ++k) from[k] -= weights[0] * t->u[k] + weights[1] * t->v[k];
    return norma_core_dot(from, from);
}

typedef struct box_at {
    double distance; /* squared */
    uint32_t node;
} box_at;

static box_at box_from(const core_triangle_tree *tree, uint32_t node, const double p[3]) {
    const core_box_node *box = &tree->boxes.nodes[node];
    double sum = 0;
    for (int k = 0; k < 3; ++k) {
        const double below = box->low[k] - p[k], above = p[k] - box->high[k];
        const double gap = below > above ? below : above;
        sum += gap > 0 ? gap * gap : 0;
    }
    return (box_at){sum, node};
}

/* visit: told of each triangle within the squared distance *within, which it may lower. */
static void visit_near(const core_triangle_tree *tree, const double point[3], const double *within,
    void (*visit)(void *context, size_t triangle, double distance), void *context) {
    box_at stack[128];
    size_t depth = 0;
    unsigned long long steps = 0;
    if (tree->count) stack[depth++] = box_from(tree, 0, point);
    while (depth) {
        const box_at at = stack[--depth];
        if (at.distance > *within) continue;
        const core_box_node *node = &tree->boxes.nodes[at.node];
        ++steps;
        if (node->right) {
            const box_at left = box_from(tree, node->left, point),
                         right = box_from(tree, node->right, point);
            const int left_first = left.distance <= right.distance;
            stack[depth++] = left_first ? right : left;
            stack[depth++] = left_first ? left : right;
            continue;
        }
        for (size_t i = node->begin; i < node->begin + node->count; ++i) {
            double weights[2];
            const double distance =
                norma_core_nearest_in_triangle(&tree->triangles[i], point, weights);
            if (distance <= *within) visit(context, i, distance);
        }
    }
    if (tree->steps) atomic_fetch_add_explicit(tree->steps, steps, memory_order_relaxed);
}

typedef struct nearest_triangle {
    double distance, within; /* nothing is nearer than 0 */
    size_t number;
    const core_triangle_tree *tree;
    const double *facing; /* NULL: any */
} nearest_triangle;

static void take_nearer(void *context, size_t triangle, double distance) {
    nearest_triangle *nearest = context;
    const core_triangle *t = &nearest->tree->triangles[triangle];
    double across[3];
    norma_core_cross(t->u, t->v, across);
    if (nearest->facing &&
        !(norma_core_dot(across, nearest->facing) >= CORE_FACES_ALIKE * norma_core_length(across)))
        return;
    nearest->distance = distance;
    nearest->within = distance > 0 ? distance : -1;
    nearest->number = triangle;
}

double norma_core_triangle_tree_nearest(
    const core_triangle_tree *tree, const double point[3], size_t *triangle) {
    double weights[2];
    nearest_triangle nearest = {INFINITY, INFINITY, *triangle, tree, NULL};
    if (*triangle < tree->count)
        take_nearer(&nearest, *triangle,
            norma_core_nearest_in_triangle(&tree->triangles[*triangle], point, weights));
    visit_near(tree, point, &nearest.within, take_nearer, &nearest);
    *triangle = nearest.number;
    return nearest.distance;
}

size_t norma_core_triangle_tree_facing(
    const core_triangle_tree *tree, const double point[3], const double facing[3], double squared) {
    nearest_triangle nearest = {INFINITY, squared, tree->count, tree, facing};
    visit_near(tree, point, &nearest.within, take_nearer, &nearest);
    return nearest.number;
}

enum { KEPT_NEAR = 2 * CORE_MOST_NEAR };

/* What may still be near enough, in the order of the search. */
typedef struct triangles_near {
    double slack, squared, within; /* squared: to the nearest */
    size_t nearest, count;
    int overflowed, nothing_nearer;
    double distances[KEPT_NEAR];
    uint32_t numbers[KEPT_NEAR];
} triangles_near;

static void approach(triangles_near *near, size_t triangle, double squared) {
    const double within = sqrt(squared) + near->slack;
    near->nearest = triangle;
    near->squared = squared;
    near->within = fmax(squared, within * within);
}

static void drop_far(triangles_near *near) {
    size_t kept = 0;
    for (size_t i = 0; i < near->count; ++i) {
        if (!(near->distances[i] <= near->within)) continue;
        near->distances[kept] = near->distances[i];
        near->numbers[kept++] = near->numbers[i];
    }
    near->count = kept;
}

static void take_near(void *context, size_t triangle, double distance) {
    triangles_near *near = context;
    if (distance < near->squared) approach(near, triangle, distance);
    if (near->overflowed && !near->nothing_nearer) return; /* they are counted again */
    if (near->count == KEPT_NEAR) drop_far(near);
    if (near->count < KEPT_NEAR) {
        near->distances[near->count] = distance;
        near->numbers[near->count++] = (uint32_t)triangle;
    } else if (near->nothing_nearer) {
        near->within = -1; /* no more are asked for */
    } else {
        near->overflowed = 1;
    }
}

/* Where more than are kept seem near, they are counted once the nearest is known. */
double norma_core_triangle_tree_around(const core_triangle_tree *tree, const double point[3],
    double slack, size_t *triangle, uint32_t numbers[CORE_MOST_NEAR], size_t *count) {
    double weights[2];
    triangles_near near;
    near.slack = slack;
    near.squared = near.within = INFINITY;
    near.nearest = *triangle;
    near.count = 0;
    near.overflowed = near.nothing_nearer = 0;
    if (*triangle < tree->count)
        approach(&near, *triangle,
            norma_core_nearest_in_triangle(&tree->triangles[*triangle], point, weights));
    visit_near(tree, point, &near.within, take_near, &near);
    if (near.overflowed) {
        near.nothing_nearer = 1;
        near.count = 0;
        visit_near(tree, point, &near.within, take_near, &near);
    } else {
        drop_far(&near);
    }
    *triangle = near.nearest;
    *count = near.count;
    memcpy(numbers, near.numbers,
        (near.count < CORE_MOST_NEAR ? near.count : CORE_MOST_NEAR) * sizeof *numbers);
    return near.squared;
}

/* ---- the points of a mesh that are nearest to given ones, by its tree of triangles. */

enum { CLOSEST_AT_ONCE = 1024 };

static const double MOST_SCALED = 0x1p300; /* its square times an area's fits a double */

typedef struct closest_points {
    core_call call;
    core_mesh mesh;
    core_triangle_tree tree;
    norma_vec3_view points;
    norma_closest *found;
} closest_points;

static int is_near_enough(const double scaled[3]) {
    for (int k = 0; k < 3; ++k)
        if (!(fabs(scaled[k]) <= MOST_SCALED)) return 0;
    return 1;
}

static void find_closest(const closest_points *c, size_t index, size_t *nearest) {
    static const norma_closest none = {.distance = -1, .face = UINT32_MAX};
    norma_closest found = none;
    double point[3], weights[2];
    norma_view_read(&c->points, index, point);
    for (int k = 0; k < 3; ++k) point[k] *= c->mesh.scale;
    if (c->tree.count && is_near_enough(point)) {
        norma_core_triangle_tree_nearest(&c->tree, point, nearest);
        const core_triangle *t = &c->tree.triangles[*nearest];
        found.distance = sqrt(norma_core_nearest_in_triangle(t, point, weights)) / c->mesh.scale;
        found.face = t->face;
        for (int k = 0; k < 3; ++k) {
            found.corners[k] = t->corners[k];
            found.point[k] =
                (t->corner[k] + weights[0] * t->u[k] + weights[1] * t->v[k]) / c->mesh.scale;
        }
        found.weights[0] = 1 - weights[0] - weights[1];
        memcpy(&found.weights[1], weights, sizeof weights);
    }
    c->found[index] = isfinite(found.distance) ? found : none;
}

static void find_closest_points(void *context, size_t chunk) {
    const closest_points *c = context;
    const size_t first = chunk * CLOSEST_AT_ONCE, left = c->points.count - first;
    size_t nearest = 0;
    for (size_t i = 0; i < (left < CLOSEST_AT_ONCE ? left : CLOSEST_AT_ONCE); ++i)
        find_closest(c, first + i, &nearest);
}

norma_result norma_closest_points(const norma_mesh *mesh, norma_vec3_view points,
    const norma_options *options, norma_closest *found, size_t capacity) {
    closest_points c = {.points = points, .found = found};
    norma_result result = norma_core_begin(&c.call, options);
    if (!result) result = norma_core_mesh_shape(mesh, &c.mesh);
    if (!result) result = norma_core_mesh_content(&c.call, &c.mesh);
    if (result) return result;
    if (points.count && (!points.data || !norma_format_size(points.format) || !found))
        return NORMA_ERROR_ARGUMENT;
    if (norma_view_overflows(&points)) return NORMA_ERROR_OVERFLOW;
    if (capacity < points.count) return NORMA_ERROR_CAPACITY;
    norma_core_share(&c.call, c.mesh.corner_count + points.count);
    norma_core_gather(&c.call);
    norma_core_stage(&c.call, 0, 0.5);
    result = norma_core_triangle_tree_build(&c.call, &c.mesh, CORE_TRIANGLES_CUT, &c.tree);
    if (!result) {
        norma_core_stage(&c.call, 0.5, 1);
        result = norma_core_parallel(&c.call,
            (points.count + CLOSEST_AT_ONCE - 1) / CLOSEST_AT_ONCE, find_closest_points, &c);
        norma_core_triangle_tree_release(&c.call, &c.tree);
    }
    norma_core_dismiss(&c.call);
    return norma_core_finish(&c.call, result);
}
