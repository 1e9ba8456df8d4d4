/* corner_normals.c: norma_corner_normals. The fans of all stars, written to the corners that are in
 * them. */
#include "core/corner/corner.h"
#include <math.h>

typedef struct corner_work {
    const core_output *output;
    uint8_t *reasons; /* of each corner; NULL unless the nearest is asked for */
} corner_work;

static void write_fans(void *context, const core_fans *fans, core_tally *tally) {
    const corner_work *work = context;
    const core_output *output = work->output;
    const uint32_t *corners = fans->corners, *fan_of = fans->fan_of;
    const int reasons = work->reasons || output->reasons;
    for (size_t i = 0; i < fans->count; ++i) {
        const core_fan *fan = &fans->fans[fan_of ? fan_of[i] : 0];
        if (fan->reason == NORMA_REASON_NONE && !reasons) {
            norma_core_write_normal(output, corners[i], fan->normal);
            continue;
        }
        norma_core_write_element(output, corners[i], (int)fan->reason, fan->normal, tally);
        if (work->reasons) work->reasons[corners[i]] = (uint8_t)fan->reason;
    }
}

static void take_corner_normal(void *output, uint32_t corner, const float normal[3]) {
    norma_core_write_normal(output, corner, normal);
}

static norma_result compute_corners(
    core_prepared_mesh *prepared, const core_output *output, norma_report *report) {
    core_call *call = prepared->call;
    const size_t count = prepared->mesh.corner_count;
    corner_work work = {.output = output};
    stars_part sum = {.tally.degenerate = prepared->degenerate_faces};
    const position_visit visit = {.join = CORE_JOIN_FANS,
        .counting = norma_core_counts_edges(call, report),
        .by_fan = 1,
        .see = write_fans,
        .context = &work,
        .output = output->nearest || output->reasons ? NULL : output,
        .target = output->normals,
        .target_size = output->stride};
    if (output->nearest && !(work.reasons = norma_core_allocate(call, count, 1)))
        return NORMA_ERROR_MEMORY;
    if (work.reasons) memset(work.reasons, NORMA_REASON_NONE, count);
    norma_core_stage(call, 0.5, 0.97);
    norma_result result = norma_core_visit_positions(prepared, &visit, &sum);
    const size_t without =
        sum.tally.non_finite.count + sum.tally.unreferenced.count + sum.tally.cancelled.count;
    if (!result && work.reasons && without)
        result = norma_core_fill_corners(
            prepared, work.reasons, NULL, take_corner_normal, (void *)(uintptr_t)output);
    norma_core_release(call, work.reasons, count, 1);
    if (result) return result;
    norma_core_write_report(report, &sum.tally, &sum.counts.non_manifold, &sum.counts.conflicts);
    if (call->options.edges) *call->options.edges = sum.counts.edges;
    return NORMA_OK;
}

norma_result norma_corner_normals(const norma_mesh *mesh, float crease_angle_rad,
    const norma_options *options, float *normals, size_t capacity, norma_report *report) {
    core_call call;
    core_mesh checked;
    core_output output;
    core_prepared_mesh prepared;
    norma_result result =
        norma_core_begin_with_crease(&call, options, mesh, crease_angle_rad, &checked);
    if (!result)
        result = norma_core_output_open(&call, normals, checked.corner_count, capacity, &output);
    if (result) return result;
    norma_core_gather(&call);
    result = norma_core_prepare_fans(&call, &checked, crease_angle_rad, &prepared);
    if (!result) {
        result = norma_core_finish(&call, compute_corners(&prepared, &output, report));
        norma_core_prepared_mesh_close(&prepared);
    }
    norma_core_dismiss(&call);
    return result;
}
