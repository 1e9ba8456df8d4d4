/* tangent_plan.c: norma_tangent_plan_create, _bytes, _destroy. */
#include "core/tangent/tangent_plan.h"
#include "core/mesh/weld.h"
#include "core/tangent/steady.h"

static size_t sorted_bytes(const core_corners_of_position *sorted) {
    return sorted->starts ? (sorted->position_count + 1) * sizeof *sorted->starts +
                                sorted->corner_count * sizeof *sorted->corners +
                                (sorted->faces ? sorted->corner_count * sizeof *sorted->faces : 0)
                          : 0;
}

static size_t mikk_bytes(const mikk_mesh *m) {
    return m->room * (3 * sizeof *m->triangles + (m->corners ? 3 * sizeof *m->corners : 0) + 1) +
           (m->copy_count ? (m->vertex_count + 1) * sizeof *m->copy_starts : 0) +
           m->copy_count * sizeof *m->copies + sorted_bytes(&m->around);
}

size_t norma_tangent_plan_bytes(const norma_tangent_plan *plan) {
    if (!plan) return 0;
    return plan->bytes + sorted_bytes(&plan->at_place) + sorted_bytes(&plan->at_position) +
           sorted_bytes(&plan->known.around) + mikk_bytes(&plan->mikk);
}

static void release_sorted(const core_call *call, core_corners_of_position *sorted) {
    if (sorted->starts) norma_core_corners_of_position_release(call, sorted);
}

void norma_tangent_plan_destroy(norma_tangent_plan *plan) {
    if (!plan) return;
    core_call memory = plan->memory;
    plan->mikk.call = &memory;
    norma_core_mikk_release(&plan->mikk);
    release_sorted(&memory, &plan->at_place);
    release_sorted(&memory, &plan->at_position);
    release_sorted(&memory, &plan->known.around);
    for (size_t i = 0; i < plan->store_count; i++)
        norma_core_release(
            &memory, plan->stores[i].memory, plan->stores[i].count, plan->stores[i].size);
    norma_core_release(&memory, plan, 1, sizeof *plan);
}

/* ---- creation, step by step */

static norma_result keep_topology(norma_tangent_plan *plan, const tangent_mesh *m) {
    const core_mesh *mesh = &m->mesh;
    plan->mesh = *mesh;
    plan->mesh.positions.data = NULL;
    plan->mesh.smoothing_groups = NULL;
    plan->mesh.hard_edges = NULL;
    if (mesh->corner_size) {
        uint32_t *corners = norma_core_tangent_keep(plan, mesh->corner_count, sizeof *corners);
        if (!corners) return NORMA_ERROR_MEMORY;
        norma_core_read_corners(mesh, 0, mesh->corner_count, corners);
        plan->mesh.corners = corners;
        plan->mesh.corner_size = sizeof *corners;
    }
    for (size_t f = 0; f < mesh->face_count; f++) {
        const size_t count = norma_core_face_end(mesh, f) - norma_core_face_begin(mesh, f);
        if (count > plan->most_corners) plan->most_corners = count;
    }
    if (!mesh->face_starts) return NORMA_OK;
    uint32_t *starts = norma_core_tangent_keep(plan, mesh->face_count + 1, sizeof *starts);
    if (!starts) return NORMA_ERROR_MEMORY;
    memcpy(starts, mesh->face_starts, (mesh->face_count + 1) * sizeof *starts);
    plan->mesh.face_starts = starts;
    return NORMA_OK;
}

/* Also which keys have the same ones: vertices that differ in nothing else. */
static norma_result keep_texcoords(norma_tangent_plan *plan, const tangent_mesh *m) {
    const size_t count = m->key_count;
    size_t found = 0;
    plan->texcoords = norma_core_tangent_keep(plan, count, sizeof *plan->texcoords);
    tangent_vertex *places = norma_core_allocate(m->call, count, sizeof *places);
    uint32_t *place = norma_core_allocate(m->call, count, sizeof *place);
    norma_result result = plan->texcoords && places && place ? NORMA_OK : NORMA_ERROR_MEMORY;
    for (size_t key = 0; result == NORMA_OK && key < count; key++) {
        places[key] = (tangent_vertex){.position = {0}};
        memcpy(places[key].texcoord, m->vertices[key].texcoord, sizeof places->texcoord);
        memcpy(plan->texcoords[key], m->vertices[key].texcoord, sizeof *plan->texcoords);
    }
    if (result == NORMA_OK)
        result = norma_core_tangent_weld_vertices(m->call, places, count, place, &found);
    norma_core_release(m->call, places, count, sizeof *places);
    if (result == NORMA_OK && found)
        norma_core_tangent_adopt(plan, plan->place = place, count, sizeof *place);
    else
        norma_core_release(m->call, place, count, sizeof *place);
    return result;
}

static norma_result keep_positions(norma_tangent_plan *plan, const tangent_mesh *m) {
    core_mesh positions = m->mesh;
    m->call->options.weld = NORMA_WELD_EXACT;
    const norma_result result = norma_core_weld(m->call, &positions);
    plan->position_weld = (uint32_t *)(uintptr_t)positions.weld;
    norma_core_tangent_adopt(
        plan, plan->position_weld, positions.positions.count, sizeof *plan->position_weld);
    return result;
}

/* The corners at each position and at each place. */
static norma_result sort_corners(core_call *call, norma_tangent_plan *plan) {
    core_mesh positions = plan->mesh, places = plan->mesh;
    positions.weld = plan->position_weld;
    places.weld = plan->place;
    if (!plan->by_position) {
        places.positions.count = plan->key_count;
        places.corner_size = 0;
    }
    norma_core_stage(call, 0.5, 0.6);
    norma_result result =
        norma_core_corners_of_position_build(call, &positions, &plan->at_position);
    norma_core_stage(call, 0.6, 0.7);
    if (result == NORMA_OK)
        result = norma_core_corners_of_position_build(call, &places, &plan->at_place);
    return result;
}

static norma_result keep_grouping(norma_tangent_plan *plan, tangent_mesh *m) {
    norma_core_tangent_adopt(plan, plan->weld = m->own_weld, m->key_count, sizeof *plan->weld);
    m->own_weld = NULL;
    norma_core_stage(m->call, 0.7, 0.97);
    if (plan->mode == NORMA_TANGENTS_STEADY)
        return norma_core_steady_keep(m, &plan->known.vertex_of, &plan->known.around);
    plan->known.mikk = &plan->mikk;
    return norma_core_mikk_keep(m, &plan->mikk);
}

static norma_result fill(norma_tangent_plan *plan, tangent_mesh *m) {
    plan->by_position = m->by_position;
    plan->key_count = m->key_count;
    norma_result result = keep_topology(plan, m);
    if (result == NORMA_OK) result = keep_texcoords(plan, m);
    if (result == NORMA_OK) result = keep_positions(plan, m);
    if (result == NORMA_OK) result = sort_corners(m->call, plan);
    if (result == NORMA_OK) result = keep_grouping(plan, m);
    if (plan->known.vertex_of)
        norma_core_tangent_adopt(
            plan, plan->known.vertex_of, m->mesh.corner_count, sizeof *plan->known.vertex_of);
    if (result == NORMA_OK) result = norma_core_tangent_rivals_find(m->call, plan);
    return result;
}

static norma_result make(tangent_mesh *m, norma_tangent_mode mode, norma_tangent_plan **made) {
    norma_core_stage(m->call, 0.05, 0.3);
    norma_result result = norma_core_tangent_open(m);
    if (result != NORMA_OK) return result;
    norma_tangent_plan *plan = norma_core_allocate(m->call, 1, sizeof *plan);
    if (plan) {
        *plan = (norma_tangent_plan){.mode = mode, .mesh = m->mesh, .bytes = sizeof *plan};
        plan->memory.options.allocator = m->call->options.allocator;
        norma_core_stage(m->call, 0.3, 0.5);
        if (m->mesh.corner_count) result = fill(plan, m);
        *made = plan;
    }
    norma_core_tangent_close(m);
    return norma_core_finish(m->call, plan ? result : NORMA_ERROR_MEMORY);
}

norma_result norma_tangent_plan_create(const norma_mesh *mesh, const norma_attribute *normals,
    const norma_attribute *texcoords, norma_tangent_mode mode, const norma_options *options,
    norma_tangent_plan **plan) {
    core_call call;
    tangent_mesh checked = {.call = &call};
    norma_tangent_plan *made = NULL;
    norma_result result = norma_core_begin(&call, options);
    if (result == NORMA_OK &&
        (!plan || (mode != NORMA_TANGENTS_STEADY && mode != NORMA_TANGENTS_MIKK)))
        result = NORMA_ERROR_ARGUMENT;
    if (result == NORMA_OK) result = norma_core_mesh_shape(mesh, &checked.mesh);
    if (result == NORMA_OK) norma_core_share(&call, checked.mesh.corner_count);
    if (result == NORMA_OK) result = norma_core_tangent_attributes(&checked, normals, texcoords);
    norma_core_stage(&call, 0, 0.05);
    if (result == NORMA_OK) result = norma_core_mesh_content(&call, &checked.mesh);
    if (result == NORMA_OK) result = make(&checked, mode, &made);
    if (result == NORMA_OK)
        *plan = made;
    else
        norma_tangent_plan_destroy(made);
    return result;
}
