/* plan.c: norma_plan_create, _bytes, _destroy. */
#include "core/plan/plan.h"
#include <math.h>

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

static norma_result fill(norma_plan *plan, core_prepared_mesh *prepared) {
    plan_groups groups;
    const size_t count = prepared->mesh.positions.count;
    norma_core_stage(prepared->call, 0.5, 0.8);
    norma_result result = norma_core_plan_groups_open(prepared, plan->of, &groups);
    if (result != NORMA_OK) return result;
    uint8_t *overflow = norma_core_allocate(prepared->call, count, 1);
    if (overflow) memset(overflow, 0, count);
    result = overflow ? find_lonely(plan, prepared) : NORMA_ERROR_MEMORY;
    if (result == NORMA_OK) result = norma_core_plan_block(plan, &groups, overflow);
    if (result == NORMA_OK) result = norma_core_plan_list_overflow(plan, &groups, overflow);
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
    if (result == NORMA_OK)
        result = norma_core_prepare_fans(&call, &checked, crease_angle_rad, &prepared);
    if (result != NORMA_OK) return result;
    norma_plan *made = new_plan(&prepared, of);
    result = norma_core_finish(&call, made ? fill(made, &prepared) : NORMA_ERROR_MEMORY);
    norma_core_prepared_mesh_close(&prepared);
    if (result == NORMA_OK)
        *plan = made;
    else
        norma_plan_destroy(made);
    return result;
}
