/* crease.c: the threshold, and the angles that a cosine does not decide. */
#include "core/corner/crease.h"
#include "core/call/call.h"
#include "core/face/face.h"

/* An angle, whatever the size of the mesh: flat quads and hexagonal prisms, rounded to floats, bend
 * by 1e-7 rad; the contract allows this much over the crease. */
static const double CREASE_TOLERANCE_RAD = 0x1.0c6f7a0b5ed8dp-20; /* 1e-6 */

/* Also an angle: programs that compute pi in floats, or from degrees, may be this much above it. */
static const double ABOVE_PI_RAD = 1e-3;

norma_result norma_core_check_crease(float crease_angle_rad, norma_fault *fault) {
    if (isfinite(crease_angle_rad) && (double)crease_angle_rad <= NORMA_PI + ABOVE_PI_RAD)
        return NORMA_OK;
    return norma_core_refuse(fault, NORMA_ERROR_ARGUMENT, "crease_angle_rad", SIZE_MAX,
        "an angle in radians, not in degrees: at most pi");
}

core_crease norma_core_crease_at(double crease_angle_rad) {
    const double angle = crease_angle_rad >= NORMA_PI ? 4 : crease_angle_rad + CREASE_TOLERANCE_RAD;
    return (core_crease){angle, angle < 0 ? 2 : angle >= NORMA_PI ? -2 : cos(angle)};
}

int norma_core_is_within_crease(const core_crease *crease, const double a[3], const double b[3]) {
    const double cosine = norma_core_dot(a, b);
    const core_crease_verdict verdict = norma_core_crease_by_cosine(crease, cosine);
    double cross[3];
    if (verdict != CORE_CREASE_UNDECIDED) return verdict == CORE_CREASE_SMOOTH;
    norma_core_cross(a, b, cross);
    return norma_core_angle(norma_core_length(cross), cosine) <= crease->angle;
}
