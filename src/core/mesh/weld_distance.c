/* weld_distance.c: the components of "at most a step apart", by walking a tree of positions against
 * itself. Two branches are joined whole where even their farthest points are a step apart, and
 * passed over where their nearest are not, or where they are joined already: so dense clusters cost
 * no more than sparse ones, and the answer does not depend on any order. */
#include "core/call/call.h"
#include "core/mesh/kdtree.h"
#include "core/mesh/weld.h"

typedef struct joiner {
    core_call *call;
    core_kdtree tree;
    uint32_t *weld; /* a forest: each points to a lower number or to itself */
    uint8_t *whole; /* of each node of the tree: all its sites are known to be joined */
    double squared_step;
} joiner;

static void join_range(joiner *j, size_t node, size_t begin, size_t end) {
    if (j->whole[node]) return;
    for (size_t i = begin + 1; i < end; i++)
        norma_core_join_sets(j->weld, j->tree.sites[begin], j->tree.sites[i]);
    j->whole[node] = 1;
}

static double squared_distance(const core_mesh *mesh, uint32_t a, uint32_t b) {
    double p[3], q[3], sum = 0;
    norma_core_position(mesh, a, p);
    norma_core_position(mesh, b, q);
    for (int k = 0; k < 3; k++) sum += (p[k] - q[k]) * (p[k] - q[k]);
    return sum;
}

typedef struct branch {
    size_t node, begin, end;
} branch;

static size_t sites_of(branch b) { return b.end - b.begin; }

static branch half(branch b, int second) {
    const size_t middle = b.begin + (b.end - b.begin) / 2;
    return second ? (branch){2 * b.node + 2, middle, b.end}
                  : (branch){2 * b.node + 1, b.begin, middle};
}

static int is_leaf(const joiner *j, branch b) {
    const core_box *box = &j->tree.boxes[b.node];
    return sites_of(b) <= KDTREE_LEAF ||
           (box->low[0] == box->high[0] && box->low[1] == box->high[1] &&
               box->low[2] == box->high[2]);
}

static void join_leaves(joiner *j, branch a, branch b) {
    for (size_t i = a.begin; i < a.end; i++)
        for (size_t k = b.begin; k < b.end; k++)
            if (squared_distance(j->tree.mesh, j->tree.sites[i], j->tree.sites[k]) <=
                j->squared_step)
                norma_core_join_sets(j->weld, j->tree.sites[i], j->tree.sites[k]);
}

/* Whether the caller wants to stop, who is asked at large branches. */
static int is_stopped(joiner *j, size_t sites) {
    return sites >= KDTREE_MANY ? norma_core_progress(j->call, 0) : j->call->cancelled;
}

static void join_across(joiner *j, branch a, branch b) {
    if (is_stopped(j, sites_of(a) + sites_of(b))) return;
    const core_box *box_a = &j->tree.boxes[a.node], *box_b = &j->tree.boxes[b.node];
    if (norma_core_box_least(box_a, box_b) > j->squared_step) return;
    if (j->whole[a.node] && j->whole[b.node] &&
        norma_core_set_of(j->weld, j->tree.sites[a.begin]) ==
            norma_core_set_of(j->weld, j->tree.sites[b.begin]))
        return;
    if (norma_core_box_greatest(box_a, box_b) <= j->squared_step) {
        join_range(j, a.node, a.begin, a.end);
        join_range(j, b.node, b.begin, b.end);
        norma_core_join_sets(j->weld, j->tree.sites[a.begin], j->tree.sites[b.begin]);
        return;
    }
    const int leaf_a = is_leaf(j, a), leaf_b = is_leaf(j, b);
    if (leaf_a && leaf_b) {
        join_leaves(j, a, b);
        return;
    }
    const int split_a = !leaf_a && (leaf_b || sites_of(a) >= sites_of(b));
    join_across(j, split_a ? half(a, 0) : a, split_a ? b : half(b, 0));
    join_across(j, split_a ? half(a, 1) : a, split_a ? b : half(b, 1));
}

static void join_within(joiner *j, branch b) {
    if (is_stopped(j, sites_of(b))) return;
    const core_box *box = &j->tree.boxes[b.node];
    if (norma_core_box_greatest(box, box) <= j->squared_step) {
        join_range(j, b.node, b.begin, b.end);
    } else if (is_leaf(j, b)) {
        join_leaves(j, b, b);
    } else {
        const branch first = half(b, 0), second = half(b, 1);
        join_within(j, first);
        join_within(j, second);
        join_across(j, first, second);
        j->whole[b.node] = j->whole[first.node] && j->whole[second.node] &&
                           norma_core_set_of(j->weld, j->tree.sites[first.begin]) ==
                               norma_core_set_of(j->weld, j->tree.sites[second.begin]);
    }
}

static size_t collect_distinct(const core_mesh *mesh, const uint32_t *weld, uint32_t *sites) {
    size_t count = 0;
    for (size_t i = 0; i < mesh->positions.count; i++) {
        double p[3];
        norma_core_position(mesh, (uint32_t)i, p);
        if (weld[i] == i && norma_core_finite(p)) sites[count++] = (uint32_t)i;
    }
    return count;
}

static norma_result join_sites(core_call *call, const core_mesh *mesh, double distance,
    uint32_t *weld, uint32_t *sites, size_t count) {
    joiner j = {.call = call, .weld = weld, .squared_step = distance * distance};
    norma_result result = norma_core_kdtree_build(call, mesh, NULL, sites, count, &j.tree);
    if (result != NORMA_OK) return result;
    j.whole = norma_core_allocate(call, j.tree.box_count, 1);
    if (j.whole) {
        memset(j.whole, 0, j.tree.box_count);
        join_within(&j, (branch){0, 0, count});
        if (call->cancelled) result = NORMA_CANCELLED;
    } else {
        result = NORMA_ERROR_MEMORY;
    }
    norma_core_release(call, j.whole, j.tree.box_count, 1);
    norma_core_kdtree_release(call, &j.tree);
    return result;
}

norma_result norma_core_weld_near(
    core_call *call, const core_mesh *mesh, double distance, uint32_t *weld) {
    uint32_t *sites = norma_core_allocate(call, mesh->positions.count, sizeof *sites);
    if (!sites) return NORMA_ERROR_MEMORY;
    const size_t count = collect_distinct(mesh, weld, sites);
    const norma_result result =
        count ? join_sites(call, mesh, distance, weld, sites, count) : NORMA_OK;
    norma_core_release(call, sites, mesh->positions.count, sizeof *sites);
    if (result != NORMA_OK) return result;
    for (size_t i = 0; i < mesh->positions.count; i++) weld[i] = weld[weld[i]];
    return NORMA_OK;
}
