/* plan_normal.c: the normal of a group, from its sum or its voters. */
#include "core/plan/plan.h"
#include <math.h>

int norma_core_plan_decide(const double sum[4], float normal[3]) {
    if (signbit(sum[3])) return NORMA_REASON_UNREFERENCED;
    if (norma_core_cancels(sum, sum[3])) return NORMA_REASON_CANCELLED;
    norma_core_direction(sum, normal);
    return NORMA_REASON_NONE;
}

int norma_core_plan_decide_cone(
    double weight, norma_core_cone_at *at, const void *context, size_t count, float normal[3]) {
    double axis[3];
    if (signbit(weight)) return NORMA_REASON_UNREFERENCED;
    if (!norma_core_smallest_cone_of(at, context, count, axis)) return NORMA_REASON_CANCELLED;
    norma_core_direction(axis, normal);
    return NORMA_REASON_NONE;
}
