/* plan_build.c: how a plan is made: the mesh's corners, the groups that they vote in, and of each
 * vertex its corners. */
#include "core/plan/plan.h"

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
    uint32_t *kept = norma_core_plan_keep(plan, corners, sizeof *kept), *starts = NULL;
    if (!kept) return NORMA_ERROR_MEMORY;
    norma_core_read_corners(mesh, 0, corners, kept);
    if (norma_core_face_starts(mesh)) {
        starts = norma_core_plan_keep(plan, mesh->face_count + 1, sizeof *starts);
        plan->corner_faces = norma_core_plan_keep(plan, corners, sizeof *plan->corner_faces);
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
    uint32_t *weld = norma_core_plan_keep(plan, plan->vertex_count, sizeof *weld);
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
    uint32_t *starts = norma_core_plan_keep(plan, plan->vertex_count + 1, sizeof *starts),
             *at = norma_core_plan_keep(plan, mesh->corner_count, sizeof *at), sum = 0;
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
        norma_core_plan_groups_at(l->groups, (uint32_t)p, receive, l);
    }
    return NORMA_OK;
}

/* Vertices that no corner names, per vertex: each with a group that has no member. */
static norma_result list_unreferenced(listing *l) {
    norma_plan *plan = l->plan;
    size_t found = 0;
    plan->first_unreferenced = l->group_count;
    plan->unreferenced =
        norma_core_plan_keep(plan, plan->unreferenced_count, sizeof *plan->unreferenced);
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
    plan->member_starts = norma_core_plan_keep(plan, l->group_count + 1, sizeof *plan->members);
    plan->members = norma_core_plan_keep(plan, l->member_count, sizeof *plan->members);
    if (!plan->member_starts || !plan->members) return NORMA_ERROR_MEMORY;
    plan->member_starts[0] = 0;
    if (!per_vertex) return NORMA_OK;
    plan->vertex_starts = norma_core_plan_keep(plan, l->group_count + 1, sizeof *plan->vertices);
    plan->vertices = norma_core_plan_keep(
        plan, l->vertex_count + plan->unreferenced_count, sizeof *plan->vertices);
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
            if (others) others[found] = norma_core_pair(plan->members[i], g);
            if (others) norma_core_mark_bit(plan->apart, g);
            if (others) norma_core_mark_bit(plan->apart, *target);
            ++found;
        }
    return found;
}

static norma_result list_targets(norma_plan *plan) {
    const size_t words = plan->group_count / 64 + 1;
    uint32_t *targets = norma_core_plan_keep(plan, plan->mesh.corner_count, sizeof *targets);
    if (!targets) return NORMA_ERROR_MEMORY;
    plan->targets = targets;
    plan->other_count = set_targets(plan, targets, NULL);
    if (!plan->other_count) return NORMA_OK;
    plan->others = norma_core_plan_keep(plan, plan->other_count, sizeof *plan->others);
    plan->apart = norma_core_plan_keep(plan, words, sizeof *plan->apart);
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
    plan_shared *shared = norma_core_plan_keep(plan, 1, sizeof *shared);
    core_vertex_sum *sums = norma_core_plan_keep(plan, plan->group_count, sizeof *sums);
    uint64_t *bits = norma_core_plan_keep(plan, groups + faces, sizeof *bits);
    if (!shared || !sums || !bits) return NORMA_ERROR_MEMORY;
    memset(bits, 0, (groups + faces) * sizeof *bits);
    *shared = (plan_shared){ATOMIC_FLAG_INIT, sums, bits, bits + groups};
    plan->shared = shared;
    return NORMA_OK;
}

static norma_result find_ranges(norma_plan *plan, core_call *call) {
    const size_t chunks = norma_core_count_chunks(&plan->mesh);
    plan->ranges = norma_core_plan_keep(plan, chunks, sizeof *plan->ranges);
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
    norma_result result = norma_core_plan_groups_open(prepared, plan->of, &groups);
    if (result) return result;
    listing l = {.plan = plan, .groups = &groups};
    result = keep_mesh(plan, &prepared->mesh);
    if (!result) result = keep_weld(plan, &prepared->mesh);
    if (!result) result = list_corners_of_vertices(plan);
    if (!result) result = list_groups(&l);
    if (!result) result = keep_shared(plan);
    if (!result) result = find_ranges(plan, prepared->call);
    norma_core_plan_groups_close(&groups);
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
