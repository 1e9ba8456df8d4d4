/* mikk_divide.c: groups with tangents that are opposed to each other. The reference joins two
 * triangles of a group if the cosines between their tangents and between their bitangents are above
 * -1, in floats; so those that point exactly the other way, give or take a rounding, are left out
 * of each other's sums. */
#include "core/tangent/mikk_star.h"

typedef struct division {
    mikk_star *star;
    const uint32_t *first, *following; /* of each group, of each corner: the next in the group */
} division;

static int joins_all(const division *d, uint32_t group, uint32_t j) {
    for (uint32_t i = d->first[group]; i != MIKK_NONE; i = d->following[i])
        if (!norma_core_mikk_are_joined(d->star, j, i)) return 0;
    return 1;
}

static void divide_group(const division *d, uint32_t group) {
    mikk_star *star = d->star;
    for (uint32_t j = d->first[group]; j != MIKK_NONE; j = d->following[j]) {
        if (joins_all(d, group, j)) continue;
        mikk_space *space = &star->spaces[star->space_count];
        *space = (mikk_space){.positive = star->spaces[group].positive};
        for (uint32_t i = d->first[group]; i != MIKK_NONE; i = d->following[i])
            if (norma_core_mikk_are_joined(star, j, i) && !mikk_follows(star, i))
                norma_core_mikk_add(star, i, space);
        norma_core_mikk_finish(star, space);
        star->space[j] = (uint32_t)star->space_count++;
    }
}

/* ---- large groups: only marked corners get sums of their own, sixteen of them at a time */

static void gather_marked(const division *d, uint32_t group, mikk_apart *apart) {
    const mikk_star *star = d->star;
    size_t count = 0;
    for (uint32_t j = d->first[group]; j != MIKK_NONE; j = d->following[j]) {
        if (!star->marks[j]) continue;
        const mikk_corners *c = mikk_block(star, j);
        const size_t from = mikk_lane_of(star, j), lane = count % MIKK_LANES;
        mikk_apart *to = &apart[count++ / MIKK_LANES];
        for (int k = 0; k < 3; k++) {
            to->s[k][lane] = c->s[k][from];
            to->t[k][lane] = c->t[k][from];
        }
    }
}

static void add_group(const division *d, uint32_t group, size_t blocks, mikk_apart *apart) {
    enum { AT_A_TIME = 64 };
    const mikk_star *star = d->star;
    mikk_other others[AT_A_TIME];
    size_t count = 0;
    for (uint32_t i = d->first[group]; i != MIKK_NONE; i = d->following[i]) {
        const mikk_corners *c = mikk_block(star, i);
        const size_t lane = mikk_lane_of(star, i);
        if (!mikk_follows(star, i)) {
            for (int k = 0; k < 3; k++) {
                others[count].s[k] = c->s[k][lane];
                others[count].t[k] = c->t[k][lane];
                others[count].weighted[k] = c->angle[lane] * c->s[k][lane];
            }
            count++;
        }
        if (count < AT_A_TIME && d->following[i] != MIKK_NONE) continue;
        for (size_t b = 0; b < blocks; b++) star->kernels->add_others(others, count, &apart[b]);
        count = 0;
    }
}

static void take_sums(const division *d, uint32_t group, const mikk_apart *apart) {
    mikk_star *star = d->star;
    size_t count = 0;
    for (uint32_t j = d->first[group]; j != MIKK_NONE; j = d->following[j]) {
        if (!star->marks[j]) continue;
        mikk_space *space = &star->spaces[star->space_count];
        *space = (mikk_space){.positive = star->spaces[group].positive};
        for (int k = 0; k < 3; k++)
            space->s[k] = apart[count / MIKK_LANES].sum[k][count % MIKK_LANES];
        norma_core_mikk_finish(star, space);
        star->space[j] = (uint32_t)star->space_count++;
        count++;
    }
}

/* 0: it has to be divided corner by corner. */
static int divide_large_group(const division *d, uint32_t group) {
    mikk_star *star = d->star;
    if (star->count <= MIKK_SMALL_STAR || star->mesh->has_quads ||
        !norma_core_mikk_mark_opposed(star, d->first[group], d->following))
        return 0;
    size_t marked = 0;
    for (uint32_t j = d->first[group]; j != MIKK_NONE; j = d->following[j])
        marked += star->marks[j];
    if (!marked) return 1;
    const size_t blocks = marked / MIKK_LANES + (marked % MIKK_LANES != 0);
    mikk_apart *apart = norma_core_allocate(star->mesh->call, blocks, sizeof *apart);
    if (!apart) return 0;
    memset(apart, 0, blocks * sizeof *apart);
    gather_marked(d, group, apart);
    add_group(d, group, blocks, apart);
    take_sums(d, group, apart);
    norma_core_release(star->mesh->call, apart, blocks, sizeof *apart);
    return 1;
}

void norma_core_mikk_divide(mikk_star *star) {
    uint32_t *first = star->links.right, *following = star->links.left;
    const division d = {star, first, following};
    const size_t groups = star->space_count;
    memset(first, 0xff, groups * sizeof *first);
    for (uint32_t j = (uint32_t)star->count; j-- > 0;) {
        const uint32_t group = star->space[j];
        if (group == MIKK_NONE) continue;
        following[j] = first[group];
        first[group] = j;
    }
    for (uint32_t g = 0; g < groups; g++)
        if (star->spaces[g].opposed && !divide_large_group(&d, g)) divide_group(&d, g);
}
