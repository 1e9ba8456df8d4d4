/* plan_build.c: how a plan is made: the mesh's corners, the groups that they vote in, and of each
 * vertex its corners. Per vertex, fans matter only where several vertices share a position:
 * elsewhere the vertex's sum is over all corners there. */
#include "core/plan/plan.h"

static inline uint64_t pair_numbers(uint32_t high, uint32_t low) {
    return (uint64_t)high << 32 | low;
}
static void mark_bit(uint64_t *bits, size_t i) { bits[i / 64] |= (uint64_t)1 << (i % 64); }
/* Memory that is the plan's, from the allocator of its creation. */
static void *keep_memory(norma_plan *plan, size_t count, size_t size) {
    if (plan->store_count == PLAN_MOST_STORES) return NULL;
    void *memory = norma_core_allocate(&plan->memory, count, size);
    if (!memory) return NULL;
    plan->stores[plan->store_count++] = (plan_store){memory, count, size};
    plan->bytes += count * size;
    return memory;
}

typedef void plan_group_receiver(void *context, const uint32_t *members, size_t member_count,
    const uint32_t *vertices, size_t vertex_count);

typedef struct plan_groups {
    const core_prepared_mesh *prepared;
    norma_element of;
    uint32_t *lead; /* of each corner the first of its fan; NULL where a vertex has each position to
                       itself */
    size_t room;    /* of the rest: corners at one position */
    uint64_t *by_fan, *by_vertex, *merged;
    struct group_vertex *sets;
    uint32_t *members, *vertices;
} plan_groups;

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
            .context = *lead};
        result = *lead ? norma_core_visit_positions(prepared, &visit, &sum) : NORMA_ERROR_MEMORY;
        if (!result && prepared->call->options.edges)
            *prepared->call->options.edges = sum.counts.edges;
    }
    norma_core_release(prepared->call, skip, prepared->mesh.positions.count, 1);
    return result;
}

static void close_groups(plan_groups *groups) {
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

static norma_result open_groups(
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
    if (result) close_groups(groups);
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
        groups->by_fan[i] = pair_numbers(fan_lead(groups, corners[i], corners[0]), corners[i]);
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
        groups->by_vertex[i] = pair_numbers(norma_core_corner(&groups->prepared->mesh, corners[i]),
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

/* Tells of each group at a position, always in the same order; vertices per vertex only. */
static void groups_at(
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

/* Unions of fans may overlap; a mesh made up so that they hold very many times its corners is
 * refused. */
enum {
    MOST_MEMBERS_PER_CORNER = 16,
    MEMBERS_TO_SPARE = 1 << 20,
    POSITIONS_BETWEEN_TELLING = 1 << 16
};

typedef struct listing {
    norma_plan *plan;
    plan_groups *groups;
    size_t group_count, member_count, vertex_count;
} listing;

/* ---- the mesh without its positions */

static norma_result keep_mesh(norma_plan *plan, const core_mesh *mesh) {
    const size_t corners = mesh->corner_count;
    uint32_t *kept = keep_memory(plan, corners, sizeof *kept), *starts = NULL;
    if (!kept) return NORMA_ERROR_MEMORY;
    norma_core_read_corners(mesh, 0, corners, kept);
    if (norma_core_face_starts(mesh)) {
        starts = keep_memory(plan, mesh->face_count + 1, sizeof *starts);
        plan->corner_faces = keep_memory(plan, corners, sizeof *plan->corner_faces);
        if (!starts || !plan->corner_faces) return NORMA_ERROR_MEMORY;
        memcpy(starts, mesh->face_starts, (mesh->face_count + 1) * sizeof *starts);
    }
    plan->mesh = (core_mesh){.corners = kept,
        .corner_count = corners,
        .corner_size = sizeof *kept,
        .face_starts = starts,
        .face_count = mesh->face_count,
        .scale = mesh->scale};
    for (size_t f = 0; f < mesh->face_count && starts; ++f) {
        if (starts[f] == starts[f + 1]) norma_core_count_one(&plan->empty_faces, f);
        for (uint32_t c = starts[f]; c < starts[f + 1]; ++c) plan->corner_faces[c] = (uint32_t)f;
    }
    return NORMA_OK;
}

static norma_result keep_weld(norma_plan *plan, const core_mesh *mesh) {
    size_t shared = 0;
    for (size_t v = 0; v < plan->vertex_count && mesh->weld; ++v) shared += mesh->weld[v] != v;
    if (!shared) return NORMA_OK;
    uint32_t *weld = keep_memory(plan, plan->vertex_count, sizeof *weld);
    if (!weld) return NORMA_ERROR_MEMORY;
    memcpy(weld, mesh->weld, plan->vertex_count * sizeof *weld);
    plan->mesh.weld = weld;
    for (size_t c = 0; c < mesh->corner_count && !plan->corner_faces; ++c)
        plan->narrow |= !norma_core_is_kept(&plan->mesh, c / 3, c);
    return NORMA_OK;
}

/* Of each vertex its corners, ascending: counts become ends, and filling backwards turns them into
 * starts. */
static norma_result list_corners_of_vertices(norma_plan *plan) {
    const core_mesh *mesh = &plan->mesh;
    uint32_t *starts = keep_memory(plan, plan->vertex_count + 1, sizeof *starts),
             *at = keep_memory(plan, mesh->corner_count, sizeof *at), sum = 0;
    if (!starts || !at) return NORMA_ERROR_MEMORY;
    memset(starts, 0, (plan->vertex_count + 1) * sizeof *starts);
    for (size_t c = 0; c < mesh->corner_count; ++c) ++starts[norma_core_corner(mesh, c)];
    for (size_t v = 0; v < plan->vertex_count; ++v) {
        plan->unreferenced_count += !starts[v];
        starts[v] = sum += starts[v];
    }
    starts[plan->vertex_count] = sum;
    for (size_t c = mesh->corner_count; c-- > 0;)
        at[--starts[norma_core_corner(mesh, c)]] = (uint32_t)c;
    plan->at_starts = starts;
    plan->at = at;
    return NORMA_OK;
}

/* ---- groups, in two passes: one counts, one writes */

static void count_group(void *context, const uint32_t *members, size_t member_count,
    const uint32_t *vertices, size_t vertex_count) {
    listing *l = context;
    (void)members;
    (void)vertices;
    ++l->group_count;
    l->member_count += member_count;
    l->vertex_count += vertex_count;
}

static void list_group(void *context, const uint32_t *members, size_t member_count,
    const uint32_t *vertices, size_t vertex_count) {
    listing *l = context;
    norma_plan *plan = l->plan;
    if (member_count)
        memcpy(plan->members + l->member_count, members, member_count * sizeof *members);
    if (vertex_count)
        memcpy(plan->vertices + l->vertex_count, vertices, vertex_count * sizeof *vertices);
    l->member_count += member_count;
    l->vertex_count += vertex_count;
    plan->member_starts[++l->group_count] = (uint32_t)l->member_count;
    if (plan->vertex_starts) plan->vertex_starts[l->group_count] = (uint32_t)l->vertex_count;
}

static norma_result for_each_group(listing *l, plan_group_receiver *receive) {
    const size_t positions = l->plan->vertex_count;
    l->group_count = l->member_count = l->vertex_count = 0;
    for (size_t p = 0; p < positions; ++p) {
        if (p % POSITIONS_BETWEEN_TELLING == 0 &&
            norma_core_progress(l->groups->prepared->call, (double)p / (double)positions))
            return NORMA_CANCELLED;
        groups_at(l->groups, (uint32_t)p, receive, l);
    }
    return NORMA_OK;
}

/* Vertices that no corner names, per vertex: each with a group that has no member. */
static norma_result list_unreferenced(listing *l) {
    norma_plan *plan = l->plan;
    size_t found = 0;
    plan->first_unreferenced = l->group_count;
    plan->unreferenced = keep_memory(plan, plan->unreferenced_count, sizeof *plan->unreferenced);
    if (!plan->unreferenced) return NORMA_ERROR_MEMORY;
    for (uint32_t v = 0; v < plan->vertex_count; ++v) {
        if (plan->at_starts[v] != plan->at_starts[v + 1]) continue;
        plan->unreferenced[found++] = v;
        list_group(l, NULL, 0, &v, 1);
    }
    return NORMA_OK;
}

static norma_result keep_lists(listing *l) {
    norma_plan *plan = l->plan;
    const int per_vertex = plan->of == NORMA_PER_VERTEX;
    if (per_vertex) l->group_count += plan->unreferenced_count;
    if (l->member_count / MOST_MEMBERS_PER_CORNER > plan->mesh.corner_count + MEMBERS_TO_SPARE)
        return NORMA_ERROR_MEMORY;
    if (l->member_count > UINT32_MAX - 1) return NORMA_ERROR_MEMORY;
    plan->group_count = l->group_count;
    plan->member_starts = keep_memory(plan, l->group_count + 1, sizeof *plan->members);
    plan->members = keep_memory(plan, l->member_count, sizeof *plan->members);
    if (!plan->member_starts || !plan->members) return NORMA_ERROR_MEMORY;
    plan->member_starts[0] = 0;
    if (!per_vertex) return NORMA_OK;
    plan->vertex_starts = keep_memory(plan, l->group_count + 1, sizeof *plan->vertices);
    plan->vertices =
        keep_memory(plan, l->vertex_count + plan->unreferenced_count, sizeof *plan->vertices);
    if (!plan->vertex_starts || !plan->vertices) return NORMA_ERROR_MEMORY;
    plan->vertex_starts[0] = 0;
    return NORMA_OK;
}

/* ---- the groups of each corner */

/* Returns how many corners vote in another group than their first, each as often as it does. */
static size_t set_targets(norma_plan *plan, uint32_t *targets, uint64_t *others) {
    size_t found = 0;
    memset(targets, 0xff, plan->mesh.corner_count * sizeof *targets);
    for (uint32_t g = 0; g < plan->group_count; ++g)
        for (uint32_t i = plan->member_starts[g]; i < plan->member_starts[g + 1]; ++i) {
            uint32_t *target = &targets[plan->members[i]];
            if (*target == UINT32_MAX) {
                *target = g;
                continue;
            }
            if (others) others[found] = pair_numbers(plan->members[i], g);
            if (others) mark_bit(plan->apart, g);
            if (others) mark_bit(plan->apart, *target);
            ++found;
        }
    return found;
}

static norma_result list_targets(norma_plan *plan) {
    const size_t words = plan->group_count / 64 + 1;
    uint32_t *targets = keep_memory(plan, plan->mesh.corner_count, sizeof *targets);
    if (!targets) return NORMA_ERROR_MEMORY;
    plan->targets = targets;
    plan->other_count = set_targets(plan, targets, NULL);
    if (!plan->other_count) return NORMA_OK;
    plan->others = keep_memory(plan, plan->other_count, sizeof *plan->others);
    plan->apart = keep_memory(plan, words, sizeof *plan->apart);
    if (!plan->others || !plan->apart) return NORMA_ERROR_MEMORY;
    memset(plan->apart, 0, words * sizeof *plan->apart);
    set_targets(plan, targets, plan->others);
    norma_core_sort_numbers(plan->others, plan->other_count);
    return NORMA_OK;
}

static norma_result list_groups(listing *l) {
    norma_plan *plan = l->plan;
    if (plan->of == NORMA_PER_VERTEX && !plan->mesh.weld) {
        plan->group_count = plan->vertex_count;
        plan->member_starts = plan->at_starts;
        plan->members = plan->at;
        plan->targets = plan->mesh.corners;
        return NORMA_OK;
    }
    norma_result result = for_each_group(l, count_group);
    if (!result) result = keep_lists(l);
    if (!result) result = for_each_group(l, list_group);
    if (!result && plan->of == NORMA_PER_VERTEX) result = list_unreferenced(l);
    return !result ? list_targets(plan) : result;
}

/* ---- what updates write */

static norma_result keep_shared(norma_plan *plan) {
    const size_t groups = plan->group_count / 64 + 1, faces = plan->mesh.face_count / 64 + 1;
    plan_shared *shared = keep_memory(plan, 1, sizeof *shared);
    core_vertex_sum *sums = keep_memory(plan, plan->group_count, sizeof *sums);
    uint64_t *bits = keep_memory(plan, groups + faces, sizeof *bits);
    if (!shared || !sums || !bits) return NORMA_ERROR_MEMORY;
    memset(bits, 0, (groups + faces) * sizeof *bits);
    *shared = (plan_shared){ATOMIC_FLAG_INIT, sums, bits, bits + groups};
    plan->shared = shared;
    return NORMA_OK;
}

static norma_result find_ranges(norma_plan *plan, core_call *call) {
    const size_t chunks = norma_core_count_chunks(&plan->mesh);
    plan->ranges = keep_memory(plan, chunks, sizeof *plan->ranges);
    if (!plan->ranges) return NORMA_ERROR_MEMORY;
    return norma_core_find_ranges(&(core_voting){
        .call = call, .mesh = &plan->mesh, .targets = plan->targets, .ranges = plan->ranges});
}

/* ---- norma_plan_create, _bytes, _destroy */

size_t norma_plan_bytes(const norma_plan *plan) { return plan ? plan->bytes : 0; }

void norma_plan_destroy(norma_plan *plan) {
    if (!plan) return;
    for (size_t i = 0; i < plan->store_count; ++i)
        norma_core_release(
            &plan->memory, plan->stores[i].memory, plan->stores[i].count, plan->stores[i].size);
    const core_call memory = plan->memory;
    norma_core_release(&memory, plan, 1, sizeof *plan);
}

static norma_plan *new_plan(const core_prepared_mesh *prepared, norma_element of) {
    norma_plan *plan = norma_core_allocate(prepared->call, 1, sizeof *plan);
    if (!plan) return NULL;
    *plan = (norma_plan){.of = of, .vertex_count = prepared->mesh.positions.count};
    plan->memory.options.allocator = prepared->call->options.allocator;
    plan->bytes = sizeof *plan;
    return plan;
}

static norma_result fill_plan(norma_plan *plan, core_prepared_mesh *prepared) {
    plan_groups groups;
    norma_core_stage(prepared->call, 0.5, 0.8);
    norma_result result = open_groups(prepared, plan->of, &groups);
    if (result) return result;
    listing l = {.plan = plan, .groups = &groups};
    result = keep_mesh(plan, &prepared->mesh);
    if (!result) result = keep_weld(plan, &prepared->mesh);
    if (!result) result = list_corners_of_vertices(plan);
    if (!result) result = list_groups(&l);
    if (!result) result = keep_shared(plan);
    if (!result) result = find_ranges(plan, prepared->call);
    close_groups(&groups);
    return result;
}

norma_result norma_plan_create(const norma_mesh *mesh, norma_element of, float crease_angle_rad,
    const norma_options *options, norma_plan **plan) {
    core_call call;
    core_mesh checked;
    core_prepared_mesh prepared;
    if (!plan || (of != NORMA_PER_VERTEX && of != NORMA_PER_CORNER)) return NORMA_ERROR_ARGUMENT;
    norma_result result =
        norma_core_begin_with_crease(&call, options, mesh, crease_angle_rad, &checked);
    if (result) return result;
    norma_plan *made = NULL;
    norma_core_gather(&call);
    result = norma_core_prepare_fans(&call, &checked, crease_angle_rad, &prepared);
    if (!result) {
        made = new_plan(&prepared, of);
        result = norma_core_finish(&call, made ? fill_plan(made, &prepared) : NORMA_ERROR_MEMORY);
        norma_core_prepared_mesh_close(&prepared);
    }
    norma_core_dismiss(&call);
    if (!result)
        *plan = made;
    else
        norma_plan_destroy(made);
    return result;
}
