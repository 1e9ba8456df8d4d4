/* plan_calls.c: plans as WebAssembly exports. */
#include "calls.h"
#include "exports.h"
#include <stdlib.h>

typedef struct web_plan {
    norma_plan *plan;
    norma_options options; /* of every update */
} web_plan;

web_plan *WEB_EXPORT(web_plan_create)(const void *positions, size_t position_count,
    size_t position_stride, norma_format format, const void *corners, size_t corner_count,
    size_t corner_size, norma_weight weight, norma_weld weld, double weld_distance,
    norma_non_manifold non_manifold, norma_fallback fallback, norma_element of, double crease_deg,
    int32_t *result) {
    const web_mesh_arguments given = {positions, position_count, position_stride, format, corners,
        corner_count, corner_size, weight, weld, weld_distance, non_manifold, fallback};
    const norma_mesh mesh = web_mesh(&given);
    web_plan *plan = calloc(1, sizeof *plan);
    *result = plan ? NORMA_OK : NORMA_ERROR_MEMORY;
    if (!plan) return NULL;
    plan->options = web_options(&given);
    *result = norma_plan_create(&mesh, of, web_radians(crease_deg), &plan->options, &plan->plan);
    if (*result == NORMA_OK) return plan;
    free(plan);
    return NULL;
}

/* moved: NULL for all. report: as in calls.c. */
norma_result WEB_EXPORT(web_plan_update)(const web_plan *plan, const void *positions,
    size_t position_count, size_t position_stride, norma_format format, const uint32_t *moved,
    size_t moved_count, float *normals, size_t capacity, norma_report *report) {
    return norma_plan_update(plan->plan,
        (norma_vec3_view){positions, position_count, position_stride, format}, moved, moved_count,
        &plan->options, normals, capacity, report);
}

size_t WEB_EXPORT(web_plan_bytes)(const web_plan *plan) { return norma_plan_bytes(plan->plan); }

void WEB_EXPORT(web_plan_free)(web_plan *plan) {
    if (plan) norma_plan_destroy(plan->plan);
    free(plan);
}
