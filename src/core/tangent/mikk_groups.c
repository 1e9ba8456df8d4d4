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

typedef struct seed_vectors {
    float s[3], t[3];
} seed_vectors;

static seed_vectors seed_of(const mikk_star *star, uint32_t group) {
    const mikk_corners *c = mikk_block(star, star->seeds[group]);
    const size_t lane = mikk_lane_of(star, star->seeds[group]);
    return (seed_vectors){{c->s[0][lane], c->s[1][lane], c->s[2][lane]},
        {c->t[0][lane], c->t[1][lane], c->t[2][lane]}};
}

/* Two tangents that each lie well within a right angle of a third are not opposed to each other. */
static int lies_near(const mikk_corners *c, size_t lane, const seed_vectors *seed) {
    float s = 0, t = 0;
    for (int k = 0; k < 3; k++) {
        s += c->s[k][lane] * seed->s[k];
        t += c->t[k][lane] * seed->t[k];
    }
    return (s > 0.0625F) & (t > 0.0625F);
}

/* Returns whether some group's tangents may be opposed to each other. */
static int sum_groups(mikk_star *star) {
    const int has_quads = star->mesh->has_quads;
    uint32_t seeded = MIKK_NONE; /* the group that seed is of */
    seed_vectors seed = {{0}, {0}};
    int opposed = 0;
    for (size_t j = 0; j < star->count; j++) {
        const uint32_t g = star->space[j];
        if (g == MIKK_NONE || (mikk_flags_of(star, j) & MIKK_FOLLOWS)) continue;
        const mikk_corners *c = mikk_block(star, j);
        const size_t lane = mikk_lane_of(star, j);
        if (g != seeded) seed = seed_of(star, seeded = g);
        mikk_add(c, lane, has_quads, &star->spaces[g]);
        if (!lies_near(c, lane, &seed)) star->spaces[g].opposed = opposed = 1;
    }
    return opposed;
}

/* Returns whether some group's tangents may be opposed to each other. */
static int sum_records(mikk_star *star) {
    int opposed = 0;
    for (size_t j = 0; j < star->count; j++) {
        if (mikk_flags_of(star, j) & MIKK_FOLLOWS) continue;
        const mikk_record *r = &star->mesh->records[star->corners[j]];
        mikk_space *space = &star->spaces[star->space[j]];
        for (int k = 0; k < 3; k++) space->s[k] += r->sum[k];
        space->ends |= r->ends;
        opposed |= mikk_ends_oppose(space->ends);
    }
    return opposed;
}

int norma_core_mikk_groups_of_records(mikk_star *star) {
    norma_core_mikk_link(star->next, star->previous, star->count, star->table, &star->links);
    find_groups(star);
    if (sum_records(star)) return 0;
    for (size_t g = 0; g < star->space_count; g++) norma_core_mikk_finish(star, &star->spaces[g]);
    return 1;
}

void norma_core_mikk_groups(mikk_star *star) {
    norma_core_mikk_link(star->next, star->previous, star->count, star->table, &star->links);
    find_groups(star);
    const size_t groups = star->space_count;
    if (sum_groups(star)) norma_core_mikk_divide(star);
    for (size_t g = 0; g < groups; g++) norma_core_mikk_finish(star, &star->spaces[g]);
}
