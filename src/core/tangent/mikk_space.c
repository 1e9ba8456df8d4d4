/* mikk_space.c: the tangent space that a sum of contributions comes to. */
#include "core/tangent/mikk_star.h"

void norma_core_mikk_normalise(float v[3]) {
    if (mikk_is_zero(v[0]) && mikk_is_zero(v[1]) && mikk_is_zero(v[2])) return;
    const float by = 1 / sqrtf(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    for (int k = 0; k < 3; k++) v[k] = by * v[k];
}

void norma_core_mikk_finish(const mikk_star *star, mikk_space *space) {
    norma_core_mikk_normalise(space->s);
    if (!star->mesh->has_quads) return;
    norma_core_mikk_normalise(space->t);
    if (space->angle > 0) {
        space->length_s /= space->angle;
        space->length_t /= space->angle;
    }
}
