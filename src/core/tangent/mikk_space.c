/* mikk_space.c: the sum of what corners contribute, and the tangent space that it comes to. */
#include "core/tangent/mikk_star.h"

void norma_core_mikk_add(const mikk_star *star, size_t j, mikk_space *space) {
    const mikk_corners *c = mikk_block(star, j);
    const size_t lane = mikk_lane_of(star, j);
    const float angle = c->angle[lane];
    for (int k = 0; k < 3; k++) space->s[k] += angle * c->s[k][lane];
    if (!star->mesh->has_quads) return;
    for (int k = 0; k < 3; k++) space->t[k] += angle * c->t[k][lane];
    space->length_s += angle * c->length_s[lane];
    space->length_t += angle * c->length_t[lane];
    space->angle += angle;
}

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
