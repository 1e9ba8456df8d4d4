/* mikk_groups.c: the groups of triangles at one vertex, and the sum over each. */
#include "core/tangent/mikk_star.h"

/* Along one of the two lists of links, until a triangle is of another sign or another group. */
static uint32_t spread(
    mikk_star *star, const uint32_t *links, uint32_t seed, uint32_t group, uint32_t sequence) {
    const int sign = mikk_flags_of(star, seed) & MIKK_POSITIVE;
    for (uint32_t j = links[seed]; j != MIKK_NONE && star->space[j] == MIKK_NONE; j = links[j]) {
        if ((mikk_flags_of(star, j) & MIKK_POSITIVE) != sign) break;
        star->space[j] = group;
        star->sequence[j] = sequence++;
    }
    return sequence;
}

static void find_groups(mikk_star *star) {
    uint32_t sequence = 0;
    memset(star->space, 0xff, star->count * sizeof *star->space);
    star->space_count = 0;
    for (uint32_t j = 0; j < star->count; j++) {
        const uint8_t flags = mikk_flags_of(star, j);
        if (star->space[j] != MIKK_NONE || (flags & MIKK_FOLLOWS)) continue;
        const uint32_t group = (uint32_t)star->space_count++;
        star->seeds[group] = j;
        star->spaces[group] = (mikk_space){.positive = flags & MIKK_POSITIVE};
        star->space[j] = group;
        star->sequence[j] = sequence++;
        sequence = spread(star, star->links.left, j, group, sequence);
        sequence = spread(star, star->links.right, j, group, sequence);
    }
}

/* Two tangents that each lie well within a right angle of a third are not opposed to each other. */
static int lies_near(const mikk_star *star, size_t j, size_t seed) {
    enum { AXES = 3 };
    const mikk_corners *a = mikk_block(star, j), *b = mikk_block(star, seed);
    const size_t at = mikk_lane_of(star, j), to = mikk_lane_of(star, seed);
    float s = 0, t = 0;
    for (int k = 0; k < AXES; k++) {
        s += a->s[k][at] * b->s[k][to];
        t += a->t[k][at] * b->t[k][to];
    }
    return (s > 0.0625F) & (t > 0.0625F);
}

void norma_core_mikk_groups(mikk_star *star) {
    int opposed = 0;
    norma_core_mikk_link(star->next, star->previous, star->count, star->table, &star->links);
    find_groups(star);
    for (size_t j = 0; j < star->count; j++) {
        const uint32_t g = star->space[j];
        if (g == MIKK_NONE || (mikk_flags_of(star, j) & MIKK_FOLLOWS)) continue;
        norma_core_mikk_add(star, j, &star->spaces[g]);
        if (lies_near(star, j, star->seeds[g])) continue;
        star->spaces[g].opposed = opposed = 1;
    }
    const size_t groups = star->space_count;
    if (opposed) norma_core_mikk_divide(star);
    for (size_t g = 0; g < groups; g++) norma_core_mikk_finish(star, &star->spaces[g]);
}
