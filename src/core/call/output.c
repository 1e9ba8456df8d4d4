/* output.c: one place for what reaches the caller. */
#include "core/call/output.h"
#include "core/call/vector.h"

norma_result norma_core_output_open(
    const core_call *call, float *normals, size_t count, size_t capacity, core_output *output) {
    const norma_options *o = &call->options;
    *output = (core_output){.normals = (unsigned char *)normals,
        .stride = o->normal_stride,
        .reasons = o->reasons,
        .nearest = o->fallback == NORMA_FALLBACK_NEAREST};
    for (int k = 0; k < 3 && o->fallback == NORMA_FALLBACK_GIVEN; k++)
        output->fallback[k] = o->fallback_normal[k] + 0.0F; /* no -0 */
    if (count && !normals) return NORMA_ERROR_ARGUMENT;
    if (count > capacity) return NORMA_ERROR_CAPACITY;
    return count && count > SIZE_MAX / o->normal_stride ? NORMA_ERROR_OVERFLOW : NORMA_OK;
}

void norma_core_direction(const double direction[3], float normal[3]) {
    double unit[3];
    norma_core_normalise(direction, unit);
    for (int k = 0; k < 3; k++) normal[k] = (float)unit[k] + 0.0F;
}

int norma_core_cancels(const double sum[3], double weight) {
    return norma_core_length(sum) <= 0x1p-20 * weight;
}

void norma_core_tally(core_tally *tally, int reason, size_t index) {
    if (reason == NORMA_REASON_NON_FINITE) norma_core_count_one(&tally->non_finite, index);
    if (reason == NORMA_REASON_UNREFERENCED) norma_core_count_one(&tally->unreferenced, index);
    if (reason == NORMA_REASON_CANCELLED) norma_core_count_one(&tally->cancelled, index);
    if (reason == NORMA_REASON_DEGENERATE) norma_core_count_one(&tally->degenerate, index);
}

void norma_core_write_element(
    const core_output *output, size_t index, int reason, const float normal[3], core_tally *tally) {
    if (reason == NORMA_REASON_NONE)
        norma_core_write_normal(output, index, normal);
    else if (!output->nearest)
        norma_core_write_normal(output, index, output->fallback);
    if (output->reasons) output->reasons[index] = (uint8_t)reason;
    norma_core_tally(tally, reason, index);
}

void norma_core_tally_add(core_tally *sum, const core_tally *part) {
    norma_core_count_add(&sum->non_finite, &part->non_finite);
    norma_core_count_add(&sum->unreferenced, &part->unreferenced);
    norma_core_count_add(&sum->cancelled, &part->cancelled);
    norma_core_count_add(&sum->degenerate, &part->degenerate);
}

static norma_count reported(const norma_count *count) {
    return count && count->count ? *count : (norma_count){0, SIZE_MAX};
}

void norma_core_write_report(norma_report *report, const core_tally *tally,
    const norma_count *non_manifold, const norma_count *conflicts) {
    if (!report) return;
    *report = (norma_report){
        .degenerate_faces = reported(&tally->degenerate),
        .non_finite = reported(&tally->non_finite),
        .unreferenced = reported(&tally->unreferenced),
        .cancelled = reported(&tally->cancelled),
        .non_manifold_edges = reported(non_manifold),
        .winding_conflicts = reported(conflicts),
    };
}
