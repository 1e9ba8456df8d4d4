/* tree.c: halves a set along the widest side of its centres, again and again; boxes over the
 * halves. The order is that of the centres, then of the numbers, so that the tree is the mesh's
 * own. */
#include "core/topology/topology.h"

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
