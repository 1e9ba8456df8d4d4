/* tangent_output.c: one place for what reaches the caller. */
#include "core/face/face_geometry.h"
#include "core/tangent/tangents.h"
#include <math.h>

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

void norma_core_write_tangent(const tangent_output *output, size_t corner,
    const tangent_vertex *vertex, const corner_tangent *tangent, core_tally *tally) {
    float four[4] = {
        tangent->direction[0], tangent->direction[1], tangent->direction[2], tangent->sign};
    int reason = tangent->reason;
    if (!norma_core_tangent_is_finite(vertex)) reason = NORMA_REASON_NON_FINITE;
    if (reason != NORMA_REASON_NONE) any_perpendicular(vertex->normal, four);
    memcpy(output->tangents + corner * output->stride, four, sizeof four);
    if (output->reasons) output->reasons[corner] = (uint8_t)reason;
    norma_core_tally(tally, reason, corner);
}
