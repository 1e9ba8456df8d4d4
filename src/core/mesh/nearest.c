/* nearest.c: the nearest of some positions by a k-d tree, built by halving at the median of the
 * widest side, so its depth is the logarithm of its size whatever the input; a range of one single
 * point is a leaf however many sites it has, with the site of least rank first. */
#include "core/mesh/mesh.h"

static double greater_of(double a, double b) { return a > b ? a : b; }
static double smaller_of(double a, double b) { return a < b ? a : b; }

double norma_core_box_least(const core_box *a, const core_box *b) {
    double sum = 0;
    for (int k = 0; k < 3; ++k) {
        const double gap =
            greater_of(0, greater_of(a->low[k] - b->high[k], b->low[k] - a->high[k]));
        sum += gap * gap;
    }
    return sum;
}

double norma_core_box_greatest(const core_box *a, const core_box *b) {
    double sum = 0;
    for (int k = 0; k < 3; ++k) {
        const double span = greater_of(a->high[k] - b->low[k], b->high[k] - a->low[k]);
        sum += span * span;
    }
    return sum;
}

static core_box box_of(const core_kdtree *tree, size_t begin, size_t end) {
    core_box box;
    norma_core_position(tree->mesh, tree->sites[begin], box.low);
    memcpy(box.high, box.low, sizeof box.high);
    for (size_t i = begin + 1; i < end; ++i) {
        double p[3];
        norma_core_position(tree->mesh, tree->sites[i], p);
        for (int k = 0; k < 3; ++k) {
            box.low[k] = smaller_of(box.low[k], p[k]);
            box.high[k] = greater_of(box.high[k], p[k]);
        }
    }
    return box;
}

static int widest_side(const core_box *box) {
    int axis = 0;
    for (int k = 1; k < 3; ++k)
        if (box->high[k] - box->low[k] > box->high[axis] - box->low[axis]) axis = k;
    return axis;
}

static int is_point(const core_box *box) {
    return box->low[0] == box->high[0] && box->low[1] == box->high[1] &&
           box->low[2] == box->high[2];
}

typedef struct site_key {
    double coordinate;
    uint32_t site;
} site_key;

static site_key key_of(const core_kdtree *tree, uint32_t site, int axis) {
    double p[3];
    norma_core_position(tree->mesh, site, p);
    return (site_key){p[axis], site};
}

static int key_less(site_key a, site_key b) {
    return a.coordinate < b.coordinate || (a.coordinate == b.coordinate && a.site < b.site);
}

/* Hoare's selection: afterwards what stands before middle is not greater, what stands behind not
 * less. The pivot is taken at a place that hashing the range gives, so that no input is slow on
 * purpose. */
static void select_middle(core_kdtree *tree, size_t begin, size_t end, size_t middle, int axis) {
    while (end - begin > 1) {
        const uint64_t mixed = ((uint64_t)begin * UINT64_C(0x9e3779b97f4a7c15)) ^
                               ((uint64_t)end * UINT64_C(0xbf58476d1ce4e5b9));
        const site_key pivot =
            key_of(tree, tree->sites[begin + (size_t)((mixed >> 20) % (end - begin))], axis);
        size_t i = begin, j = end - 1;
        for (;;) {
            while (key_less(key_of(tree, tree->sites[i], axis), pivot)) ++i;
            while (key_less(pivot, key_of(tree, tree->sites[j], axis))) --j;
            if (i >= j) break;
            const uint32_t site = tree->sites[i];
            tree->sites[i++] = tree->sites[j];
            tree->sites[j--] = site;
        }
        const size_t split = key_less(key_of(tree, tree->sites[i], axis), pivot) ? i + 1 : i;
        if (middle < split)
            end = split == end ? end - 1 : split;
        else
            begin = split == begin ? begin + 1 : split;
    }
}

static uint32_t rank_of(const core_kdtree *tree, uint32_t site) {
    return tree->rank ? tree->rank[site] : site;
}

static void least_rank_first(core_kdtree *tree, size_t begin, size_t end) {
    size_t least = begin;
    for (size_t i = begin + 1; i < end; ++i)
        if (rank_of(tree, tree->sites[i]) < rank_of(tree, tree->sites[least])) least = i;
    const uint32_t site = tree->sites[least];
    tree->sites[least] = tree->sites[begin];
    tree->sites[begin] = site;
}

/* Nonzero: the caller wants to stop. */
static int build_node(core_call *call, core_kdtree *tree, size_t node, size_t begin, size_t end) {
    if (end - begin >= KDTREE_MANY && norma_core_progress(call, 0)) return 1;
    tree->boxes[node] = box_of(tree, begin, end);
    if (is_point(&tree->boxes[node])) {
        least_rank_first(tree, begin, end);
        return 0;
    }
    if (end - begin <= KDTREE_LEAF) return 0;
    const size_t middle = begin + (end - begin) / 2;
    select_middle(tree, begin, end, middle, widest_side(&tree->boxes[node]));
    return build_node(call, tree, 2 * node + 1, begin, middle) ||
           build_node(call, tree, 2 * node + 2, middle, end);
}

norma_result norma_core_kdtree_build(core_call *call, const core_mesh *mesh, const uint32_t *rank,
    uint32_t *sites, size_t count, core_kdtree *tree) {
    size_t nodes = 1;
    for (size_t range = count; range > KDTREE_LEAF; range = range - range / 2)
        nodes = 2 * nodes + 1;
    *tree = (core_kdtree){
        .mesh = mesh, .rank = rank, .sites = sites, .count = count, .box_count = nodes};
    tree->boxes = norma_core_allocate(call, nodes, sizeof *tree->boxes);
    if (!tree->boxes) return NORMA_ERROR_MEMORY;
    if (!count || !build_node(call, tree, 0, 0, count)) return NORMA_OK;
    norma_core_kdtree_release(call, tree);
    return NORMA_CANCELLED;
}

void norma_core_kdtree_release(const core_call *call, core_kdtree *tree) {
    norma_core_release(call, tree->boxes, tree->box_count, sizeof *tree->boxes);
    tree->boxes = NULL;
}

/* A squared distance that doubles say is longer, by more than what they lose. */
static int is_surely_farther(double square, double than) {
    return square > NORMA_TINIEST && square > (1 + 0x1p-48) * than;
}

typedef struct nearest_search {
    const core_kdtree *tree;
    core_box from;     /* the point asked for */
    core_segment best; /* from there to the best site so far */
    uint32_t site;     /* that one; UINT32_MAX: none yet */
} nearest_search;

static void try_site(nearest_search *search, uint32_t site) {
    core_segment to = search->best;
    norma_core_position(search->tree->mesh, site, to.to);
    norma_core_measure_segment(&to);
    if (search->site != UINT32_MAX) {
        const int longer = norma_core_compare_lengths(&to, &search->best);
        if (longer > 0 ||
            (!longer && rank_of(search->tree, site) > rank_of(search->tree, search->site)))
            return;
    }
    search->best = to;
    search->site = site;
}

static void search_node(nearest_search *search, size_t node, size_t begin, size_t end) {
    const core_box *boxes = search->tree->boxes;
    if (search->site != UINT32_MAX &&
        is_surely_farther(norma_core_box_least(&boxes[node], &search->from), search->best.square))
        return;
    if (is_point(&boxes[node])) {
        try_site(search, search->tree->sites[begin]);
        return;
    }
    if (end - begin <= KDTREE_LEAF) {
        for (size_t i = begin; i < end; ++i) try_site(search, search->tree->sites[i]);
        return;
    }
    const size_t middle = begin + (end - begin) / 2;
    const double left = norma_core_box_least(&boxes[2 * node + 1], &search->from),
                 right = norma_core_box_least(&boxes[2 * node + 2], &search->from);
    if (left <= right) search_node(search, 2 * node + 1, begin, middle);
    search_node(search, 2 * node + 2, middle, end);
    if (left > right) search_node(search, 2 * node + 1, begin, middle);
}

uint32_t norma_core_kdtree_nearest(const core_kdtree *tree, const double point[3]) {
    nearest_search search = {.tree = tree, .site = UINT32_MAX};
    memcpy(search.from.low, point, sizeof search.from.low);
    memcpy(search.from.high, point, sizeof search.from.high);
    memcpy(search.best.from, point, sizeof search.best.from);
    search_node(&search, 0, 0, tree->count);
    return search.site;
}

/* ---- few askers look at every site, many get a tree. Both give the same answer. */

enum { FEW_QUERIES = 48 };

norma_result norma_core_nearest_begin(
    core_call *call, const core_mesh *mesh, core_nearest *nearest) {
    const size_t count = mesh->positions.count;
    *nearest = (core_nearest){.call = call, .mesh = mesh, .first = UINT32_MAX};
    nearest->first_at = norma_core_allocate(call, count, sizeof *nearest->first_at);
    nearest->found_at = norma_core_allocate(call, count, sizeof *nearest->found_at);
    nearest->sites = norma_core_allocate(call, count, sizeof *nearest->sites);
    if (!nearest->first_at || !nearest->found_at || !nearest->sites) {
        norma_core_nearest_end(nearest);
        return NORMA_ERROR_MEMORY;
    }
    memset(nearest->first_at, 0xff, count * sizeof *nearest->first_at);
    memset(nearest->found_at, 0xff, count * sizeof *nearest->found_at);
    return NORMA_OK;
}

void norma_core_nearest_add(core_nearest *nearest, uint32_t position, uint32_t element) {
    if (nearest->first == UINT32_MAX) nearest->first = element;
    if (nearest->first_at[position] != UINT32_MAX) return;
    nearest->first_at[position] = element;
    nearest->sites[nearest->site_count++] = position;
}

norma_result norma_core_nearest_plant(core_nearest *nearest, size_t queries) {
    if (queries <= FEW_QUERIES || !nearest->site_count) return NORMA_OK;
    const norma_result result = norma_core_kdtree_build(nearest->call, nearest->mesh,
        nearest->first_at, nearest->sites, nearest->site_count, &nearest->tree);
    nearest->planted = !result;
    return result;
}

void norma_core_nearest_end(core_nearest *nearest) {
    const size_t count = nearest->mesh->positions.count;
    if (nearest->planted) norma_core_kdtree_release(nearest->call, &nearest->tree);
    norma_core_release(nearest->call, nearest->first_at, count, sizeof *nearest->first_at);
    norma_core_release(nearest->call, nearest->found_at, count, sizeof *nearest->found_at);
    norma_core_release(nearest->call, nearest->sites, count, sizeof *nearest->sites);
    *nearest = (core_nearest){.mesh = nearest->mesh};
}

static uint32_t look_at_every_site(const core_nearest *nearest, const double point[3]) {
    uint32_t best = UINT32_MAX;
    core_segment least = {.square = 0}, to;
    memcpy(to.from, point, sizeof to.from);
    for (size_t i = 0; i < nearest->site_count; ++i) {
        const uint32_t element = nearest->first_at[nearest->sites[i]];
        norma_core_position(nearest->mesh, nearest->sites[i], to.to);
        norma_core_measure_segment(&to);
        const int longer = best == UINT32_MAX ? -1 : norma_core_compare_lengths(&to, &least);
        if (longer > 0 || (!longer && element > best)) continue;
        least = to;
        best = element;
    }
    return best;
}

/* Equal positions ask for the same; those that are one by a distance need not be at one place. */
static uint32_t place_to_ask(const core_nearest *nearest, uint32_t position) {
    return norma_core_welds_near(nearest->call) ? position
                                                : norma_core_welded(nearest->mesh, position);
}

static uint32_t look_up(const core_nearest *nearest, uint32_t position) {
    double point[3];
    norma_core_position(nearest->mesh, position, point);
    if (!norma_core_finite(point)) return nearest->first;
    if (!nearest->planted) return look_at_every_site(nearest, point);
    return nearest->first_at[norma_core_kdtree_nearest(&nearest->tree, point)];
}

uint32_t norma_core_nearest_find(core_nearest *nearest, uint32_t position) {
    if (nearest->first == UINT32_MAX) return UINT32_MAX;
    if (nearest->first_at[position] != UINT32_MAX) return nearest->first_at[position];
    uint32_t *found = &nearest->found_at[place_to_ask(nearest, position)];
    if (*found == UINT32_MAX) *found = look_up(nearest, position);
    return *found;
}

/* ---- all that have none, of elements that are asked one by one */

static uint32_t position_of_element(const core_elements *of, size_t element) {
    return of->position ? of->position(of->context, element) : (uint32_t)element;
}

static void write_nearest(
    const core_elements *of, const core_output *output, core_nearest *nearest) {
    for (size_t i = 0; i < of->count; ++i) {
        float normal[3];
        if (of->normal(of->context, i, normal) == NORMA_REASON_NONE) continue;
        const uint32_t position = position_of_element(of, i),
                       source = position == UINT32_MAX ? nearest->first
                                                       : norma_core_nearest_find(nearest, position);
        if (source == UINT32_MAX)
            normal[0] = normal[1] = normal[2] = 0;
        else
            of->normal(of->context, source, normal);
        norma_core_write_normal(output, i, normal);
    }
}

norma_result norma_core_fill_nearest(
    core_call *call, const core_elements *of, const core_output *output, size_t queries) {
    core_nearest nearest;
    norma_result result = norma_core_nearest_begin(call, of->mesh, &nearest);
    if (result) return result;
    for (size_t i = 0; i < of->count; ++i) {
        float normal[3];
        if (of->normal(of->context, i, normal) == NORMA_REASON_NONE)
            norma_core_nearest_add(&nearest, position_of_element(of, i), (uint32_t)i);
    }
    result = norma_core_nearest_plant(&nearest, queries);
    if (!result) write_nearest(of, output, &nearest);
    norma_core_nearest_end(&nearest);
    return result;
}
