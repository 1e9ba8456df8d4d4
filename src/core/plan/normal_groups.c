/* normal_groups.c: from fans to slots. Per vertex, fans matter only where several vertices share a
 * position: elsewhere the vertex's sum is over all corners there. */
#include "core/plan/plan.h"
#include "core/corner/visit_positions.h"
#include "core/call/sort.h"

typedef struct slot_vertex {
    uint64_t hash;
    uint32_t vertex, begin, count;
} slot_vertex; /* a vertex, and its fans among by_vertex */

/* ---- fans */

static void note_fans(void *context, const core_fans *fans, core_tally *tally) {
    uint32_t *lead = context, seen = 0;
    (void)tally;
    for (size_t i = 0; i < fans->count; i++) {
        ring_member *first = &fans->members[fans->fan_of[i]]; /* fans are numbered in the order of
                                                                 their first corners */
        if (fans->fan_of[i] == seen) fans->members[seen++].index = fans->corners[i];
        lead[fans->corners[i]] = first->index;
    }
}

static int one_vertex(const core_surface *surface, size_t position) {
    const core_around *around = &surface->around;
    const uint32_t begin = around->starts[position], end = around->starts[position + 1];
    for (uint32_t i = begin + 1; i < end; i++)
        if (norma_core_corner(&surface->mesh, around->corners[i]) !=
            norma_core_corner(&surface->mesh, around->corners[begin]))
            return 0;
    return 1;
}

/* Nonzero where nobody asks for the fans; NULL where all positions are asked for. */
static norma_result choose_rings(
    const core_surface *surface, norma_element of, uint8_t **skip, int *any) {
    const size_t count = surface->mesh.positions.count;
    *skip = NULL;
    *any = 1;
    if (of == NORMA_PER_CORNER || surface->call->options.edges) return NORMA_OK;
    *any = 0;
    if (!surface->mesh.weld) return NORMA_OK;
    *skip = norma_core_allocate(surface->call, count, 1);
    if (!*skip) return NORMA_ERROR_MEMORY;
    for (size_t p = 0; p < count; p++) {
        (*skip)[p] = (uint8_t)one_vertex(surface, p);
        *any |= !(*skip)[p];
    }
    return NORMA_OK;
}

static norma_result find_fans(core_surface *surface, norma_element of, uint32_t **lead) {
    const size_t count = surface->mesh.corner_count;
    uint8_t *skip;
    int any;
    rings_part sum;
    norma_result result = choose_rings(surface, of, &skip, &any);
    if (result != NORMA_OK) return result;
    if (any) {
        *lead = norma_core_allocate(surface->call, count, sizeof **lead);
        const ring_visit visit = {.join = CORE_JOIN_FANS,
            .counting = surface->call->options.edges != NULL,
            .skip = skip,
            .see = note_fans,
            .context = *lead,
            .target = *lead,
            .target_size = sizeof **lead};
        result = *lead ? norma_core_visit_rings(surface, &visit, &sum) : NORMA_ERROR_MEMORY;
        if (result == NORMA_OK && surface->call->options.edges)
            *surface->call->options.edges = sum.counts.edges;
    }
    norma_core_release(surface->call, skip, surface->mesh.positions.count, 1);
    return result;
}

norma_result norma_core_plan_slots_open(
    core_surface *surface, norma_element of, plan_slots *slots) {
    core_call *call = surface->call;
    const size_t room = surface->around.most;
    *slots = (plan_slots){.surface = surface, .of = of, .room = room};
    norma_result result = find_fans(surface, of, &slots->lead);
    slots->by_fan = norma_core_allocate(call, room, sizeof *slots->by_fan);
    slots->by_vertex = norma_core_allocate(call, room, sizeof *slots->by_vertex);
    slots->merged = norma_core_allocate(call, room, sizeof *slots->merged);
    slots->sets = norma_core_allocate(call, room, sizeof *slots->sets);
    slots->members = norma_core_allocate(call, room, sizeof *slots->members);
    slots->vertices = norma_core_allocate(call, room, sizeof *slots->vertices);
    if (!slots->by_fan || !slots->by_vertex || !slots->merged || !slots->sets || !slots->members ||
        !slots->vertices)
        result = NORMA_ERROR_MEMORY;
    if (result != NORMA_OK) norma_core_plan_slots_close(slots);
    return result;
}

void norma_core_plan_slots_close(plan_slots *slots) {
    const core_call *call = slots->surface->call;
    norma_core_release(call, slots->lead, slots->surface->mesh.corner_count, sizeof *slots->lead);
    norma_core_release(call, slots->by_fan, slots->room, sizeof *slots->by_fan);
    norma_core_release(call, slots->by_vertex, slots->room, sizeof *slots->by_vertex);
    norma_core_release(call, slots->merged, slots->room, sizeof *slots->merged);
    norma_core_release(call, slots->sets, slots->room, sizeof *slots->sets);
    norma_core_release(call, slots->members, slots->room, sizeof *slots->members);
    norma_core_release(call, slots->vertices, slots->room, sizeof *slots->vertices);
}

/* ---- pairs of numbers, sorted */

static uint64_t pair(uint32_t high, uint32_t low) { return (uint64_t)high << 32 | low; }
static uint32_t high_of(uint64_t p) { return (uint32_t)(p >> 32); }
static uint32_t low_of(uint64_t p) { return (uint32_t)p; }

static int pair_less(const void *a, const void *b) {
    uint64_t one, other;
    memcpy(&one, a, sizeof one);
    memcpy(&other, b, sizeof other);
    return one < other;
}

enum { FEW_PAIRS = 24 };

static void sort_pairs(uint64_t *pairs, size_t count) {
    if (count > FEW_PAIRS) {
        norma_core_sort(pairs, count, sizeof *pairs, pair_less);
        return;
    }
    for (size_t i = 1; i < count; i++) {
        const uint64_t moved = pairs[i];
        size_t at = i;
        for (; at > 0 && moved < pairs[at - 1]; at--) pairs[at] = pairs[at - 1];
        pairs[at] = moved;
    }
}

static size_t drop_repeated(uint64_t *pairs, size_t count) {
    size_t kept = 0;
    for (size_t i = 0; i < count; i++)
        if (i == 0 || pairs[i] != pairs[i - 1]) pairs[kept++] = pairs[i];
    return kept;
}

/* ---- per corner: a slot of each fan */

static uint32_t fan_lead(const plan_slots *slots, uint32_t corner, uint32_t first) {
    return slots->lead ? slots->lead[corner] : first;
}

static int one_fan(const plan_slots *slots, const uint32_t *corners, size_t count) {
    for (size_t i = 1; i < count && slots->lead; i++)
        if (slots->lead[corners[i]] != slots->lead[corners[0]]) return 0;
    return 1;
}

static void sort_by_fan(plan_slots *slots, const uint32_t *corners, size_t count) {
    for (size_t i = 0; i < count; i++)
        slots->by_fan[i] = pair(fan_lead(slots, corners[i], corners[0]), corners[i]);
    sort_pairs(slots->by_fan, count);
}

static void tell_fans(plan_slots *slots, const uint32_t *corners, size_t count,
    plan_slot_receiver *receive, void *context) {
    sort_by_fan(slots, corners, count);
    for (size_t begin = 0, end; begin < count; begin = end) {
        for (end = begin;
             end < count && high_of(slots->by_fan[end]) == high_of(slots->by_fan[begin]); end++)
            slots->members[end - begin] = low_of(slots->by_fan[end]);
        receive(context, slots->members, end - begin, NULL, 0);
    }
}

/* ---- per vertex: a slot of each set of fans */

static uint64_t hash_fan(uint64_t hash, uint32_t fan) {
    hash = (hash ^ fan) * UINT64_C(0x9e3779b97f4a7c15);
    return hash ^ (hash >> 29);
}

static int set_less(const void *a, const void *b) {
    const slot_vertex *one = a, *other = b;
    if (one->hash != other->hash) return one->hash < other->hash;
    return one->vertex < other->vertex;
}

static int same_set(const plan_slots *slots, const slot_vertex *a, const slot_vertex *b) {
    if (a->hash != b->hash || a->count != b->count) return 0;
    for (uint32_t i = 0; i < a->count; i++)
        if (low_of(slots->by_vertex[a->begin + i]) != low_of(slots->by_vertex[b->begin + i]))
            return 0;
    return 1;
}

/* The fans of each vertex, vertices of the same set side by side. Returns how many vertices there
 * are. */
static size_t find_sets(plan_slots *slots, const uint32_t *corners, size_t count) {
    size_t sets = 0;
    for (size_t i = 0; i < count; i++)
        slots->by_vertex[i] = pair(norma_core_corner(&slots->surface->mesh, corners[i]),
            fan_lead(slots, corners[i], corners[0]));
    sort_pairs(slots->by_vertex, count);
    const size_t pairs = drop_repeated(slots->by_vertex, count);
    for (size_t begin = 0, end; begin < pairs; begin = end) {
        slot_vertex set = {.vertex = high_of(slots->by_vertex[begin]), .begin = (uint32_t)begin};
        for (end = begin; end < pairs && high_of(slots->by_vertex[end]) == set.vertex; end++)
            set.hash = hash_fan(set.hash, low_of(slots->by_vertex[end]));
        set.count = (uint32_t)(end - begin);
        slots->sets[sets++] = set;
    }
    norma_core_sort(slots->sets, sets, sizeof *slots->sets, set_less);
    return sets;
}

static size_t first_of_fan(const plan_slots *slots, size_t count, uint32_t fan) {
    size_t low = 0, high = count;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (high_of(slots->by_fan[middle]) < fan)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

/* The corners of all fans of a set, ascending. */
static size_t merge_fans(plan_slots *slots, const slot_vertex *set, size_t count) {
    size_t found = 0;
    for (uint32_t i = 0; i < set->count; i++) {
        const uint32_t fan = low_of(slots->by_vertex[set->begin + i]);
        for (size_t at = first_of_fan(slots, count, fan);
             at < count && high_of(slots->by_fan[at]) == fan; at++)
            slots->merged[found++] = low_of(slots->by_fan[at]);
    }
    if (set->count > 1) sort_pairs(slots->merged, found);
    for (size_t i = 0; i < found; i++) slots->members[i] = (uint32_t)slots->merged[i];
    return found;
}

static void tell_sets(plan_slots *slots, const uint32_t *corners, size_t count,
    plan_slot_receiver *receive, void *context) {
    const size_t sets = find_sets(slots, corners, count);
    sort_by_fan(slots, corners, count);
    for (size_t begin = 0, end; begin < sets; begin = end) {
        for (end = begin; end < sets && same_set(slots, &slots->sets[end], &slots->sets[begin]);
             end++)
            slots->vertices[end - begin] = slots->sets[end].vertex;
        receive(context, slots->members, merge_fans(slots, &slots->sets[begin], count),
            slots->vertices, end - begin);
    }
}

static size_t distinct_vertices(plan_slots *slots, const uint32_t *corners, size_t count) {
    for (size_t i = 0; i < count; i++)
        slots->by_vertex[i] = norma_core_corner(&slots->surface->mesh, corners[i]);
    sort_pairs(slots->by_vertex, count);
    const size_t distinct = drop_repeated(slots->by_vertex, count);
    for (size_t i = 0; i < distinct; i++) slots->vertices[i] = (uint32_t)slots->by_vertex[i];
    return distinct;
}

void norma_core_plan_slots_at(
    plan_slots *slots, uint32_t position, plan_slot_receiver *receive, void *context) {
    const core_around *around = &slots->surface->around;
    const uint32_t *corners = around->corners + around->starts[position];
    const size_t count = around->starts[position + 1] - around->starts[position];
    if (!count) return;
    if (slots->of == NORMA_PER_CORNER) {
        if (one_fan(slots, corners, count))
            receive(context, corners, count, NULL, 0);
        else
            tell_fans(slots, corners, count, receive, context);
    } else if (one_vertex(slots->surface, position)) {
        slots->vertices[0] = norma_core_corner(&slots->surface->mesh, corners[0]);
        receive(context, corners, count, slots->vertices, 1);
    } else if (one_fan(slots, corners, count)) {
        const size_t distinct = distinct_vertices(slots, corners, count);
        receive(context, corners, count, slots->vertices, distinct);
    } else {
        tell_sets(slots, corners, count, receive, context);
    }
}
