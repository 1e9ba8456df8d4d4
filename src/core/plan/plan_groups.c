/* plan_groups.c: the groups at each position. Per vertex, fans matter only where several vertices
 * share a position: elsewhere the vertex's sum is over all corners there. */
#include "core/plan/plan.h"

typedef struct group_vertex {
    uint64_t hash;
    uint32_t vertex, begin, count;
} group_vertex; /* a vertex, and its fans among by_vertex */

/* ---- fans */

/* Of each corner the first one of its fan. */
static void note_fans(void *context, const core_fans *fans, core_tally *tally) {
    uint32_t *lead = context;
    (void)tally;
    for (size_t i = fans->count; i-- > 0;) fans->members[fans->fan_of[i]].index = fans->corners[i];
    for (size_t i = 0; i < fans->count; ++i)
        lead[fans->corners[i]] = fans->members[fans->fan_of[i]].index;
}

static int one_vertex(const core_prepared_mesh *prepared, size_t position) {
    const core_corners_of_position *corners_of = &prepared->corners_of;
    const uint32_t begin = corners_of->starts[position], end = corners_of->starts[position + 1];
    for (uint32_t i = begin + 1; i < end; ++i)
        if (norma_core_corner(&prepared->mesh, corners_of->corners[i]) !=
            norma_core_corner(&prepared->mesh, corners_of->corners[begin]))
            return 0;
    return 1;
}

/* Nonzero where nobody asks for the fans; NULL where all positions are asked for. */
static norma_result choose_stars(
    const core_prepared_mesh *prepared, norma_element of, uint8_t **skip, int *any) {
    const size_t count = prepared->mesh.positions.count;
    *skip = NULL;
    *any = 1;
    if (of == NORMA_PER_CORNER || prepared->call->options.edges) return NORMA_OK;
    *any = 0;
    if (!prepared->mesh.weld) return NORMA_OK;
    *skip = norma_core_allocate(prepared->call, count, 1);
    if (!*skip) return NORMA_ERROR_MEMORY;
    for (size_t p = 0; p < count; ++p) {
        (*skip)[p] = (uint8_t)one_vertex(prepared, p);
        *any |= !(*skip)[p];
    }
    return NORMA_OK;
}

static norma_result find_group_fans(
    core_prepared_mesh *prepared, norma_element of, uint32_t **lead) {
    const size_t count = prepared->mesh.corner_count;
    uint8_t *skip;
    int any;
    stars_part sum;
    norma_result result = choose_stars(prepared, of, &skip, &any);
    if (result) return result;
    if (any) {
        *lead = norma_core_allocate(prepared->call, count, sizeof **lead);
        const position_visit visit = {.join = CORE_JOIN_FANS,
            .counting = prepared->call->options.edges != NULL,
            .skip = skip,
            .see = note_fans,
            .context = *lead,
            .target = *lead,
            .target_size = sizeof **lead};
        result = *lead ? norma_core_visit_positions(prepared, &visit, &sum) : NORMA_ERROR_MEMORY;
        if (!result && prepared->call->options.edges)
            *prepared->call->options.edges = sum.counts.edges;
    }
    norma_core_release(prepared->call, skip, prepared->mesh.positions.count, 1);
    return result;
}

void norma_core_plan_groups_close(plan_groups *groups) {
    const core_call *call = groups->prepared->call;
    norma_core_release(
        call, groups->lead, groups->prepared->mesh.corner_count, sizeof *groups->lead);
    norma_core_release(call, groups->by_fan, groups->room, sizeof *groups->by_fan);
    norma_core_release(call, groups->by_vertex, groups->room, sizeof *groups->by_vertex);
    norma_core_release(call, groups->merged, groups->room, sizeof *groups->merged);
    norma_core_release(call, groups->sets, groups->room, sizeof *groups->sets);
    norma_core_release(call, groups->members, groups->room, sizeof *groups->members);
    norma_core_release(call, groups->vertices, groups->room, sizeof *groups->vertices);
}

norma_result norma_core_plan_groups_open(
    core_prepared_mesh *prepared, norma_element of, plan_groups *groups) {
    core_call *call = prepared->call;
    const size_t room = prepared->corners_of.most;
    *groups = (plan_groups){.prepared = prepared, .of = of, .room = room};
    norma_result result = find_group_fans(prepared, of, &groups->lead);
    groups->by_fan = norma_core_allocate(call, room, sizeof *groups->by_fan);
    groups->by_vertex = norma_core_allocate(call, room, sizeof *groups->by_vertex);
    groups->merged = norma_core_allocate(call, room, sizeof *groups->merged);
    groups->sets = norma_core_allocate(call, room, sizeof *groups->sets);
    groups->members = norma_core_allocate(call, room, sizeof *groups->members);
    groups->vertices = norma_core_allocate(call, room, sizeof *groups->vertices);
    if (!groups->by_fan || !groups->by_vertex || !groups->merged || !groups->sets ||
        !groups->members || !groups->vertices)
        result = NORMA_ERROR_MEMORY;
    if (result) norma_core_plan_groups_close(groups);
    return result;
}

/* ---- pairs of numbers */

static uint32_t high_of(uint64_t p) { return (uint32_t)(p >> 32); }
static uint32_t low_of(uint64_t p) { return (uint32_t)p; }

static size_t drop_repeated_pairs(uint64_t *pairs, size_t count) {
    size_t kept = 0;
    for (size_t i = 0; i < count; ++i)
        if (i == 0 || pairs[i] != pairs[i - 1]) pairs[kept++] = pairs[i];
    return kept;
}

/* ---- per corner: a group of each fan */

static uint32_t fan_lead(const plan_groups *groups, uint32_t corner, uint32_t first) {
    return groups->lead ? groups->lead[corner] : first;
}

static int one_fan(const plan_groups *groups, const uint32_t *corners, size_t count) {
    for (size_t i = 1; i < count && groups->lead; ++i)
        if (groups->lead[corners[i]] != groups->lead[corners[0]]) return 0;
    return 1;
}

static void sort_by_fan(plan_groups *groups, const uint32_t *corners, size_t count) {
    for (size_t i = 0; i < count; ++i)
        groups->by_fan[i] = norma_core_pair(fan_lead(groups, corners[i], corners[0]), corners[i]);
    norma_core_sort_numbers(groups->by_fan, count);
}

static void tell_fans(plan_groups *groups, const uint32_t *corners, size_t count,
    plan_group_receiver *receive, void *context) {
    sort_by_fan(groups, corners, count);
    for (size_t begin = 0, end; begin < count; begin = end) {
        for (end = begin;
             end < count && high_of(groups->by_fan[end]) == high_of(groups->by_fan[begin]); ++end)
            groups->members[end - begin] = low_of(groups->by_fan[end]);
        receive(context, groups->members, end - begin, NULL, 0);
    }
}

/* ---- per vertex: a group of each set of fans */

static uint64_t hash_fan(uint64_t hash, uint32_t fan) {
    hash = (hash ^ fan) * UINT64_C(0x9e3779b97f4a7c15);
    return hash ^ (hash >> 29);
}

static int set_less(const void *a, const void *b) {
    const group_vertex *one = a, *other = b;
    if (one->hash != other->hash) return one->hash < other->hash;
    return one->vertex < other->vertex;
}

static int same_fans(const plan_groups *groups, const group_vertex *a, const group_vertex *b) {
    if (a->hash != b->hash || a->count != b->count) return 0;
    for (uint32_t i = 0; i < a->count; ++i)
        if (low_of(groups->by_vertex[a->begin + i]) != low_of(groups->by_vertex[b->begin + i]))
            return 0;
    return 1;
}

/* The fans of each vertex, vertices of the same set side by side. Returns how many vertices there
 * are. */
static size_t find_sets(plan_groups *groups, const uint32_t *corners, size_t count) {
    size_t sets = 0;
    for (size_t i = 0; i < count; ++i)
        groups->by_vertex[i] =
            norma_core_pair(norma_core_corner(&groups->prepared->mesh, corners[i]),
                fan_lead(groups, corners[i], corners[0]));
    norma_core_sort_numbers(groups->by_vertex, count);
    const size_t pairs = drop_repeated_pairs(groups->by_vertex, count);
    for (size_t begin = 0, end; begin < pairs; begin = end) {
        group_vertex set = {.vertex = high_of(groups->by_vertex[begin]), .begin = (uint32_t)begin};
        for (end = begin; end < pairs && high_of(groups->by_vertex[end]) == set.vertex; ++end)
            set.hash = hash_fan(set.hash, low_of(groups->by_vertex[end]));
        set.count = (uint32_t)(end - begin);
        groups->sets[sets++] = set;
    }
    norma_core_sort(groups->sets, sets, sizeof *groups->sets, set_less);
    return sets;
}

static size_t first_of_fan(const plan_groups *groups, size_t count, uint32_t fan) {
    size_t low = 0, high = count;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (high_of(groups->by_fan[middle]) < fan)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

/* The corners of all fans of a set, ascending. */
static size_t merge_fans(plan_groups *groups, const group_vertex *set, size_t count) {
    size_t found = 0;
    for (uint32_t i = 0; i < set->count; ++i) {
        const uint32_t fan = low_of(groups->by_vertex[set->begin + i]);
        for (size_t at = first_of_fan(groups, count, fan);
             at < count && high_of(groups->by_fan[at]) == fan; ++at)
            groups->merged[found++] = low_of(groups->by_fan[at]);
    }
    if (set->count > 1) norma_core_sort_numbers(groups->merged, found);
    for (size_t i = 0; i < found; ++i) groups->members[i] = (uint32_t)groups->merged[i];
    return found;
}

static void tell_sets(plan_groups *groups, const uint32_t *corners, size_t count,
    plan_group_receiver *receive, void *context) {
    const size_t sets = find_sets(groups, corners, count);
    sort_by_fan(groups, corners, count);
    for (size_t begin = 0, end; begin < sets; begin = end) {
        for (end = begin; end < sets && same_fans(groups, &groups->sets[end], &groups->sets[begin]);
             ++end)
            groups->vertices[end - begin] = groups->sets[end].vertex;
        receive(context, groups->members, merge_fans(groups, &groups->sets[begin], count),
            groups->vertices, end - begin);
    }
}

static size_t distinct_vertices(plan_groups *groups, const uint32_t *corners, size_t count) {
    for (size_t i = 0; i < count; ++i)
        groups->by_vertex[i] = norma_core_corner(&groups->prepared->mesh, corners[i]);
    norma_core_sort_numbers(groups->by_vertex, count);
    const size_t distinct = drop_repeated_pairs(groups->by_vertex, count);
    for (size_t i = 0; i < distinct; ++i) groups->vertices[i] = (uint32_t)groups->by_vertex[i];
    return distinct;
}

void norma_core_plan_groups_at(
    plan_groups *groups, uint32_t position, plan_group_receiver *receive, void *context) {
    const core_corners_of_position *corners_of = &groups->prepared->corners_of;
    const uint32_t *corners = corners_of->corners + corners_of->starts[position];
    const size_t count = corners_of->starts[position + 1] - corners_of->starts[position];
    if (!count) return;
    if (groups->of == NORMA_PER_CORNER) {
        if (one_fan(groups, corners, count))
            receive(context, corners, count, NULL, 0);
        else
            tell_fans(groups, corners, count, receive, context);
    } else if (one_vertex(groups->prepared, position)) {
        groups->vertices[0] = norma_core_corner(&groups->prepared->mesh, corners[0]);
        receive(context, corners, count, groups->vertices, 1);
    } else if (one_fan(groups, corners, count)) {
        const size_t distinct = distinct_vertices(groups, corners, count);
        receive(context, corners, count, groups->vertices, distinct);
    } else {
        tell_sets(groups, corners, count, receive, context);
    }
}
