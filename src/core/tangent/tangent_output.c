/* tangent_output.c: one place for what reaches the caller. */
#include "core/face/face_geometry.h"
#include "core/tangent/tangents.h"
#include <math.h>

norma_result norma_core_tangent_output_open(const norma_options *options, float *tangents,
    size_t count, size_t capacity, tangent_output *output) {
    const size_t least = 4 * sizeof(float), asked = options ? options->normal_stride : 0;
    *output = (tangent_output){.tangents = (unsigned char *)tangents,
        .stride = asked ? asked : least,
        .reasons = options ? options->reasons : NULL};
    if (output->stride < least || (count && !tangents)) return NORMA_ERROR_ARGUMENT;
    if (count > capacity) return NORMA_ERROR_CAPACITY;
    return count && count > SIZE_MAX / output->stride ? NORMA_ERROR_OVERFLOW : NORMA_OK;
}

/* A unit vector perpendicular to n, the same on every machine: the axis that n leans on least, made
 * perpendicular; the first axis where n has no direction. */
static void any_perpendicular(const float normal[3], float out[3]) {
    const double given[3] = {(double)normal[0], (double)normal[1], (double)normal[2]};
    double n[3] = {0}, v[3], unit[3];
    int axis = 0;
    if (norma_core_finite(given)) norma_core_normalise(given, n);
    for (int k = 1; k < 3; k++)
        if (fabs(n[k]) < fabs(n[axis])) axis = k;
    for (int k = 0; k < 3; k++) v[k] = (k == axis ? 1.0 : 0.0) - n[axis] * n[k];
    norma_core_normalise(v, unit);
    for (int k = 0; k < 3; k++) out[k] = (float)unit[k] + 0.0F;
}

written_tangent norma_core_tangent_to_write(
    const tangent_vertex *vertex, const corner_tangent *tangent) {
    written_tangent out = {.reason = tangent->reason};
    memcpy(out.numbers, tangent->direction, sizeof tangent->direction);
    out.numbers[3] = tangent->sign;
    if (!norma_core_tangent_is_finite(vertex)) out.reason = NORMA_REASON_NON_FINITE;
    if (out.reason != NORMA_REASON_NONE) any_perpendicular(vertex->normal, out.numbers);
    return out;
}

void norma_core_write_tangent(const tangent_output *output, size_t corner,
    const tangent_vertex *vertex, const corner_tangent *tangent, core_tally *tally) {
    const written_tangent out = norma_core_tangent_to_write(vertex, tangent);
    norma_core_put_tangent(output, corner, &out, tally);
}
