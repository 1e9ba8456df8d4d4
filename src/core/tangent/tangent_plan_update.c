/* tangent_plan_update.c: norma_tangent_plan_update. What the plan knows is used where it is still
 * true, so that the bits are always those of norma_corner_tangents. */
#include "core/tangent/tangent_plan.h"

static norma_result compute(const norma_tangent_plan *plan, const tangent_mesh *m,
    const tangent_output *output, core_tally *tally) {
    return plan->mode == NORMA_TANGENTS_MIKK ? norma_core_mikk_tangents(m, output, tally)
                                             : norma_core_steady_tangents(m, output, tally);
}

static norma_result update_all(const norma_tangent_plan *plan, tangent_mesh *m,
    const tangent_output *output, core_tally *tally) {
    int holds = 0;
    norma_core_stage(m->call, 0, 0.3);
    norma_result result = norma_core_tangent_read(m);
    if (result == NORMA_OK) result = norma_core_tangent_weld_holds(plan, m, &holds);
    if (result == NORMA_OK && holds) {
        m->weld = plan->weld;
        m->known = &plan->known;
    }
    if (result == NORMA_OK && !holds) result = norma_core_tangent_weld(m);
    norma_core_stage(m->call, 0.3, 0.97);
    if (result == NORMA_OK) result = compute(plan, m, output, tally);
    norma_core_tangent_close(m);
    return result;
}

/* How far a polygon is cut well hangs on all polygons: their time is limited together. */
static int hangs_together(const norma_tangent_plan *plan) {
    return plan->mode == NORMA_TANGENTS_MIKK && plan->most_corners > 4;
}

static norma_result update_some(const norma_tangent_plan *plan, tangent_mesh *m,
    const uint32_t *moved, size_t moved_count, const tangent_output *output, core_tally *tally) {
    tangent_region region;
    int all = 1;
    if (hangs_together(plan)) return update_all(plan, m, output, tally);
    norma_result result =
        norma_core_tangent_region_open(m->call, plan, moved, moved_count, &region);
    if (result != NORMA_OK) return result;
    if (!region.is_large)
        result = norma_core_tangent_update_part(plan, m, &region, output, tally, &all);
    norma_core_tangent_region_close(m->call, plan, &region);
    return result == NORMA_OK && all ? update_all(plan, m, output, tally) : result;
}

/* Also of the corners that an update of some vertices does not read. */
static norma_result check_indices(const norma_tangent_plan *plan, const norma_attribute *normals,
    const uint32_t *moved, size_t moved_count) {
    for (size_t i = 0; i < moved_count; i++)
        if (moved[i] >= plan->mesh.positions.count) return NORMA_ERROR_INDEX;
    for (size_t c = 0; c < plan->mesh.corner_count && normals->corners; c++)
        if (normals->corners[c] >= normals->count) return NORMA_ERROR_INDEX;
    return NORMA_OK;
}

/* The plan's mesh at new positions. */
static norma_result open_mesh(const norma_tangent_plan *plan, norma_vec3_view positions,
    const norma_attribute *normals, const norma_attribute *texcoords, tangent_mesh *m) {
    const norma_mesh points = {.positions = positions};
    norma_result result = norma_core_mesh_shape(&points, &m->mesh);
    if (result == NORMA_OK && positions.count != plan->mesh.positions.count)
        result = NORMA_ERROR_ARGUMENT;
    if (result != NORMA_OK) return result;
    const norma_vec3_view view = m->mesh.positions;
    m->mesh = plan->mesh;
    m->mesh.positions = view;
    m->by_position = plan->by_position;
    m->key_count = plan->key_count;
    result = norma_core_tangent_attributes(m, normals, texcoords);
    if (result == NORMA_OK && plan->by_position &&
        (normals->of != NORMA_PER_VERTEX || normals->corners))
        result = NORMA_ERROR_ARGUMENT;
    return result;
}

norma_result norma_tangent_plan_update(const norma_tangent_plan *plan, norma_vec3_view positions,
    const norma_attribute *normals, const uint32_t *moved, size_t moved_count,
    const norma_options *options, float *tangents, size_t capacity, norma_report *report) {
    core_call call;
    core_tally tally = {0};
    tangent_mesh m = {.call = &call};
    tangent_output output;
    if (!plan) return NORMA_ERROR_ARGUMENT;
    const size_t corners = plan->mesh.corner_count;
    const norma_attribute texcoords = {.data = plan->texcoords,
        .count = plan->key_count,
        .of = plan->by_position ? NORMA_PER_VERTEX : NORMA_PER_CORNER};
    norma_result result = norma_core_begin(&call, options);
    if (result == NORMA_OK) norma_core_share(&call, corners);
    if (result == NORMA_OK) result = open_mesh(plan, positions, normals, &texcoords, &m);
    if (result == NORMA_OK)
        result = norma_core_tangent_output_open(options, tangents, corners, capacity, &output);
    if (result == NORMA_OK && moved) result = check_indices(plan, normals, moved, moved_count);
    if (result == NORMA_OK && corners)
        result = moved ? update_some(plan, &m, moved, moved_count, &output, &tally)
                       : update_all(plan, &m, &output, &tally);
    result = norma_core_finish(&call, result);
    if (result == NORMA_OK) norma_core_write_report(report, &tally, NULL, NULL);
    return result;
}
