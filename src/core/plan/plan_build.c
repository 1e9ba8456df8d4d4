/* plan_build.c: how a plan is made: groups, the blocks that they are listed in, and lists of those
 * that no block has room for. */
#include "core/plan/plan.h"

/* ---- The lists of overflow groups, filled in two passes: one counts, one writes. */

/* Unions of fans may overlap; a mesh made up so that they hold very many times its corners is
 * refused. */
enum { MOST_MEMBERS_PER_CORNER = 16, MEMBERS_TO_SPARE = 1 << 20 };

typedef struct widening {
    norma_plan *plan;
    plan_groups *groups;
    const core_mesh *mesh;
    const uint8_t *chosen;
    uint32_t *new_corner; /* of each corner of the mesh its number among overflow ones; UINT32_MAX:
                             none */
    size_t group_count, member_count, vertex_count;
} widening;

static void count_group(void *context, const uint32_t *members, size_t member_count,
    const uint32_t *vertices, size_t vertex_count) {
    widening *w = context;
    (void)members;
    (void)vertices;
    w->group_count++;
    w->member_count += member_count;
    w->vertex_count += vertex_count;
}

static void write_overflow_group(void *context, const uint32_t *members, size_t member_count,
    const uint32_t *vertices, size_t vertex_count) {
    widening *w = context;
    overflow_group *overflow = &w->plan->overflow;
    for (size_t i = 0; i < member_count; i++)
        overflow->members[w->member_count++] = w->new_corner[members[i]];
    for (size_t i = 0; i < vertex_count; i++) overflow->vertices[w->vertex_count++] = vertices[i];
    overflow->member_starts[++w->group_count] = (uint32_t)w->member_count;
    if (overflow->vertex_starts)
        overflow->vertex_starts[w->group_count] = (uint32_t)w->vertex_count;
}

static void for_each_group(widening *w, plan_group_receiver *receive) {
    w->group_count = w->member_count = w->vertex_count = 0;
    for (size_t p = 0; p < w->mesh->positions.count; p++)
        if (w->chosen[p]) norma_core_plan_groups_at(w->groups, (uint32_t)p, receive, w);
}

/* ---- faces */

static int meets_chosen(const widening *w, size_t face) {
    for (size_t c = norma_core_face_begin(w->mesh, face); c < norma_core_face_end(w->mesh, face);
         c++)
        if (w->chosen[norma_core_welded_corner(w->mesh, c)]) return 1;
    return 0;
}

static void count_overflow_faces(const widening *w, overflow_group *overflow) {
    for (size_t f = 0; f < w->mesh->face_count; f++) {
        if (!meets_chosen(w, f)) continue;
        overflow->face_count++;
        overflow->corner_count +=
            norma_core_face_end(w->mesh, f) - norma_core_face_begin(w->mesh, f);
    }
}

static int keep_overflow_faces(const widening *w, overflow_group *overflow) {
    const size_t faces = overflow->face_count, corners = overflow->corner_count;
    const int polygons = w->mesh->face_starts != NULL;
    overflow->faces = norma_core_plan_keep(w->plan, faces, sizeof *overflow->faces);
    overflow->corners = norma_core_plan_keep(w->plan, corners, sizeof *overflow->corners);
    overflow->mesh_corners = norma_core_plan_keep(w->plan, corners, sizeof *overflow->mesh_corners);
    if (polygons)
        overflow->face_starts =
            norma_core_plan_keep(w->plan, faces + 1, sizeof *overflow->face_starts);
    if (polygons)
        overflow->corner_faces =
            norma_core_plan_keep(w->plan, corners, sizeof *overflow->corner_faces);
    return overflow->faces && overflow->corners && overflow->mesh_corners &&
           (!polygons || (overflow->face_starts && overflow->corner_faces));
}

static void write_faces(const widening *w, overflow_group *overflow) {
    size_t faces = 0, corners = 0;
    for (size_t f = 0; f < w->mesh->face_count; f++) {
        if (!meets_chosen(w, f)) continue;
        if (overflow->face_starts) overflow->face_starts[faces] = (uint32_t)corners;
        for (size_t c = norma_core_face_begin(w->mesh, f); c < norma_core_face_end(w->mesh, f);
             c++) {
            if (overflow->corner_faces) overflow->corner_faces[corners] = (uint32_t)faces;
            overflow->corners[corners] = norma_core_corner(w->mesh, c);
            overflow->mesh_corners[corners] = (uint32_t)c;
            w->new_corner[c] = (uint32_t)corners++;
        }
        overflow->faces[faces++] = (uint32_t)f;
    }
    if (overflow->face_starts) overflow->face_starts[faces] = (uint32_t)corners;
}

/* ---- lists, and their inverses */

static norma_result keep_lists(widening *w, overflow_group *overflow) {
    if (w->member_count / MOST_MEMBERS_PER_CORNER > w->mesh->corner_count + MEMBERS_TO_SPARE)
        return NORMA_ERROR_MEMORY;
    if (w->member_count > UINT32_MAX - 1) return NORMA_ERROR_MEMORY;
    const int per_vertex = w->plan->of == NORMA_PER_VERTEX;
    overflow->group_count = w->group_count;
    overflow->member_starts =
        norma_core_plan_keep(w->plan, w->group_count + 1, sizeof *overflow->member_starts);
    overflow->members = norma_core_plan_keep(w->plan, w->member_count, sizeof *overflow->members);
    if (per_vertex)
        overflow->vertex_starts =
            norma_core_plan_keep(w->plan, w->group_count + 1, sizeof *overflow->vertex_starts);
    if (per_vertex)
        overflow->vertices =
            norma_core_plan_keep(w->plan, w->vertex_count, sizeof *overflow->vertices);
    overflow->group_starts =
        norma_core_plan_keep(w->plan, overflow->corner_count + 1, sizeof *overflow->group_starts);
    overflow->groups = norma_core_plan_keep(w->plan, w->member_count, sizeof *overflow->groups);
    overflow->at_starts =
        norma_core_plan_keep(w->plan, w->plan->vertex_count + 1, sizeof *overflow->at_starts);
    overflow->at = norma_core_plan_keep(w->plan, overflow->corner_count, sizeof *overflow->at);
    if (!overflow->member_starts || !overflow->members ||
        (per_vertex && (!overflow->vertex_starts || !overflow->vertices)))
        return NORMA_ERROR_MEMORY;
    if (!overflow->group_starts || !overflow->groups || !overflow->at_starts || !overflow->at)
        return NORMA_ERROR_MEMORY;
    overflow->member_starts[0] = 0;
    if (per_vertex) overflow->vertex_starts[0] = 0;
    return NORMA_OK;
}

/* Counts become ends; filling backwards turns them into starts. */
static void counts_to_ends(uint32_t *counts, size_t count) {
    uint32_t sum = 0;
    for (size_t i = 0; i < count; i++) counts[i] = sum += counts[i];
    counts[count] = sum;
}

static void list_corners_of_vertices(const norma_plan *plan, overflow_group *overflow) {
    memset(overflow->at_starts, 0, (plan->vertex_count + 1) * sizeof *overflow->at_starts);
    for (size_t c = 0; c < overflow->corner_count; c++) overflow->at_starts[overflow->corners[c]]++;
    counts_to_ends(overflow->at_starts, plan->vertex_count);
    for (size_t c = overflow->corner_count; c-- > 0;)
        overflow->at[--overflow->at_starts[overflow->corners[c]]] = (uint32_t)c;
}

static void list_groups_of_corners(overflow_group *overflow) {
    const uint32_t members = overflow->member_starts[overflow->group_count];
    memset(
        overflow->group_starts, 0, (overflow->corner_count + 1) * sizeof *overflow->group_starts);
    for (uint32_t i = 0; i < members; i++) overflow->group_starts[overflow->members[i]]++;
    counts_to_ends(overflow->group_starts, overflow->corner_count);
    for (size_t group = overflow->group_count; group-- > 0;)
        for (uint32_t i = overflow->member_starts[group]; i < overflow->member_starts[group + 1];
             i++)
            overflow->groups[--overflow->group_starts[overflow->members[i]]] = (uint32_t)group;
}

static norma_result keep_weld(norma_plan *plan, const core_mesh *mesh) {
    size_t shared = 0;
    for (size_t v = 0; v < plan->vertex_count && mesh->weld; v++) shared += mesh->weld[v] != v;
    if (!shared) return NORMA_OK;
    plan->weld = norma_core_plan_keep(plan, plan->vertex_count, sizeof *plan->weld);
    if (!plan->weld) return NORMA_ERROR_MEMORY;
    memcpy(plan->weld, mesh->weld, plan->vertex_count * sizeof *plan->weld);
    return NORMA_OK;
}

static norma_result core_plan_list_overflow(
    norma_plan *plan, plan_groups *groups, const uint8_t *chosen) {
    const core_call *call = groups->prepared->call;
    widening w = {
        .plan = plan, .groups = groups, .mesh = &groups->prepared->mesh, .chosen = chosen};
    overflow_group *overflow = &plan->overflow;
    if (!memchr(chosen, 1, plan->vertex_count)) return NORMA_OK;
    count_overflow_faces(&w, overflow);
    if (!overflow->face_count) return NORMA_OK;
    w.new_corner = norma_core_allocate(call, w.mesh->corner_count, sizeof *w.new_corner);
    norma_result result = w.new_corner && keep_overflow_faces(&w, overflow)
                              ? keep_weld(plan, w.mesh)
                              : NORMA_ERROR_MEMORY;
    if (result == NORMA_OK) {
        write_faces(&w, overflow);
        for_each_group(&w, count_group);
        result = keep_lists(&w, overflow);
    }
    if (result == NORMA_OK) {
        for_each_group(&w, write_overflow_group);
        list_corners_of_vertices(plan, overflow);
        list_groups_of_corners(overflow);
    }
    norma_core_release(call, w.new_corner, w.mesh->corner_count, sizeof *w.new_corner);
    return result;
}

/* ---- norma_plan_create, _bytes, _destroy */

size_t norma_plan_bytes(const norma_plan *plan) { return plan ? plan->bytes : 0; }

void norma_plan_destroy(norma_plan *plan) {
    if (!plan) return;
    for (size_t i = 0; i < plan->store_count; i++)
        norma_core_release(
            &plan->memory, plan->stores[i].memory, plan->stores[i].count, plan->stores[i].size);
    const core_call memory = plan->memory;
    norma_core_release(&memory, plan, 1, sizeof *plan);
}

static norma_plan *new_plan(const core_prepared_mesh *prepared, norma_element of) {
    norma_plan *plan = norma_core_allocate(prepared->call, 1, sizeof *plan);
    if (!plan) return NULL;
    *plan = (norma_plan){.of = of,
        .vertex_count = prepared->mesh.positions.count,
        .corner_count = prepared->mesh.corner_count,
        .face_count = prepared->mesh.face_count,
        .scale = prepared->mesh.scale};
    plan->memory.options.allocator = prepared->call->options.allocator;
    plan->bytes = sizeof *plan;
    return plan;
}

/* Vertices that no corner names, and faces that name none. */
static norma_result find_lonely(norma_plan *plan, const core_prepared_mesh *prepared) {
    const core_mesh *mesh = &prepared->mesh;
    uint8_t *used = norma_core_allocate(prepared->call, plan->vertex_count, 1);
    if (!used) return NORMA_ERROR_MEMORY;
    memset(used, 0, plan->vertex_count);
    for (size_t c = 0; c < mesh->corner_count; c++) used[norma_core_corner(mesh, c)] = 1;
    for (size_t f = 0; f < mesh->face_count && mesh->face_starts; f++)
        if (norma_core_face_begin(mesh, f) == norma_core_face_end(mesh, f))
            norma_core_count_one(&plan->empty_faces, f);
    for (size_t v = 0; v < plan->vertex_count; v++) plan->lonely_count += !used[v];
    plan->lonely = norma_core_plan_keep(plan, plan->lonely_count, sizeof *plan->lonely);
    for (size_t v = 0, found = 0; v < plan->vertex_count && plan->lonely; v++)
        if (!used[v]) plan->lonely[found++] = (uint32_t)v;
    norma_core_release(prepared->call, used, plan->vertex_count, 1);
    return plan->lonely ? NORMA_OK : NORMA_ERROR_MEMORY;
}

static norma_result fill_plan(norma_plan *plan, core_prepared_mesh *prepared) {
    plan_groups groups;
    const size_t count = prepared->mesh.positions.count;
    norma_core_stage(prepared->call, 0.5, 0.8);
    norma_result result = norma_core_plan_groups_open(prepared, plan->of, &groups);
    if (result != NORMA_OK) return result;
    uint8_t *overflow = norma_core_allocate(prepared->call, count, 1);
    if (overflow) memset(overflow, 0, count);
    result = overflow ? find_lonely(plan, prepared) : NORMA_ERROR_MEMORY;
    if (result == NORMA_OK) result = norma_core_plan_block(plan, &groups, overflow);
    if (result == NORMA_OK) result = core_plan_list_overflow(plan, &groups, overflow);
    norma_core_release(prepared->call, overflow, count, 1);
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
    if (result != NORMA_OK) return result;
    norma_plan *made = NULL;
    norma_core_gather(&call);
    result = norma_core_prepare_fans(&call, &checked, crease_angle_rad, &prepared);
    if (result == NORMA_OK) {
        made = new_plan(&prepared, of);
        result = norma_core_finish(&call, made ? fill_plan(made, &prepared) : NORMA_ERROR_MEMORY);
        norma_core_prepared_mesh_close(&prepared);
    }
    norma_core_dismiss(&call);
    if (result == NORMA_OK)
        *plan = made;
    else
        norma_plan_destroy(made);
    return result;
}
