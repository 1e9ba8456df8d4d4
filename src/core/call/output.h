/* output.h: the caller's normals, reasons and report: checked before anything is written, written
 * once, never read. */
#ifndef NORMA_CORE_OUTPUT_H
#define NORMA_CORE_OUTPUT_H
#include "core/call/call.h"
#include "core/call/count.h"
#include <string.h>

typedef struct core_output {
    unsigned char *normals; /* NULL: only counted (norma_split) */
    size_t stride;
    uint8_t *reasons;
    float fallback[3]; /* what an element without a normal gets, but for the nearest */
    int nearest;
} core_output;

typedef struct core_tally {
    norma_count non_finite, unreferenced, cancelled, degenerate;
} core_tally;

/* ARGUMENT, CAPACITY or OVERFLOW where count normals cannot go to normals. */
norma_result norma_core_output_open(
    const core_call *call, float *normals, size_t count, size_t capacity, core_output *output);

static inline void norma_core_write_normal(
    const core_output *output, size_t index, const float normal[3]) {
    memcpy(output->normals + index * output->stride, normal, 3 * sizeof(float));
}
/* Of count elements in a row, all with a normal of their own. */
static inline void norma_core_write_normals(
    const core_output *output, size_t first, size_t count, const float (*normals)[3]) {
    if (output->stride == 3 * sizeof(float))
        memcpy(output->normals + first * output->stride, normals, count * sizeof *normals);
    else
        for (size_t i = 0; i < count; i++) norma_core_write_normal(output, first + i, normals[i]);
    if (output->reasons) memset(output->reasons + first, NORMA_REASON_NONE, count);
}
/* Writes the normal of an element that has one, or the fallback (not the nearest, which is written
 * later), and its reason; counts what has none. */
void norma_core_write_element(
    const core_output *output, size_t index, int reason, const float normal[3], core_tally *tally);

/* Of any scale, to a unit vector of floats, never -0. */
void norma_core_direction(const double direction[3], float normal[3]);
/* What is left of a sum must be more than rounding: 2^-20 of the weights that were put in. */
int norma_core_cancels(const double sum[3], double weight);

void norma_core_tally(core_tally *tally, int reason, size_t index);
void norma_core_tally_add(core_tally *sum, const core_tally *part);
/* Sets what the counts say; the firsts of empty counts become SIZE_MAX. report may be NULL. */
void norma_core_write_report(norma_report *report, const core_tally *tally,
    const norma_count *non_manifold, const norma_count *conflicts);
#endif
