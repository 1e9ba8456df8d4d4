/* mikk_divide.c: groups with tangents that are opposed to each other. The reference joins two
 * triangles of a group if the cosines between their tangents and between their bitangents are above
 * -1, in floats; so those that point exactly the other way, give or take a rounding, are left out
 * of each other's sums. Finding them takes the square of the corners, and so there is a bound. */
#include "core/tangent/mikk_star.h"

enum { MOST_DIVIDED = 2048 }; /* corners of a group */

static float cosine(const mikk_lane *a, size_t at, const mikk_lane *b, size_t to) {
    return a[0][at] * b[0][to] + a[1][at] * b[1][to] + a[2][at] * b[2][to];
}

static int are_one_quad(const mikk_star *star, size_t i, size_t j) {
    const size_t first = i < j ? i : j, second = i < j ? j : i;
    return star->corners[first] / 3 + 1 == star->corners[second] / 3 &&
           (mikk_flags_of(star, second) & MIKK_SECOND);
}

/* Whether neither of two corners of a group is left out of the other's sum. */
static int are_joined(const mikk_star *star, size_t i, size_t j) {
    const mikk_corners *a = mikk_block(star, i), *b = mikk_block(star, j);
    const size_t at = mikk_lane_of(star, i), to = mikk_lane_of(star, j);
    if (i == j || mikk_follows(star, i) || mikk_follows(star, j)) return 1;
    return (cosine(a->s, at, b->s, to) > -1 && cosine(a->t, at, b->t, to) > -1) ||
           are_one_quad(star, i, j);
}

typedef struct division {
    mikk_star *star;
    const uint32_t *first, *following; /* of each group, of each corner: the next in the group */
} division;

static int joins_all(const division *d, uint32_t group, uint32_t j) {
    for (uint32_t i = d->first[group]; i != MIKK_NONE; i = d->following[i])
        if (!are_joined(d->star, j, i)) return 0;
    return 1;
}

static void divide_group(const division *d, uint32_t group) {
    mikk_star *star = d->star;
    for (uint32_t j = d->first[group]; j != MIKK_NONE; j = d->following[j]) {
        if (joins_all(d, group, j)) continue;
        mikk_space *space = &star->spaces[star->space_count];
        *space = (mikk_space){.positive = star->spaces[group].positive};
        for (uint32_t i = d->first[group]; i != MIKK_NONE; i = d->following[i])
            if (are_joined(star, j, i) && !mikk_follows(star, i))
                norma_core_mikk_add(star, i, space);
        norma_core_mikk_finish(star, space);
        star->space[j] = (uint32_t)star->space_count++;
    }
}

/* Of a group that is too large to compare all with all: each corner has its own triangle's tangent,
 * which is what it comes to where a texture goes round a pole. */
static void part_group(const division *d, uint32_t group) {
    mikk_star *star = d->star;
    for (uint32_t j = d->first[group]; j != MIKK_NONE; j = d->following[j]) {
        if (mikk_follows(star, j)) continue;
        mikk_space *space = &star->spaces[star->space_count];
        *space = (mikk_space){.positive = star->spaces[group].positive};
        norma_core_mikk_add(star, j, space);
        norma_core_mikk_finish(star, space);
        star->space[j] = (uint32_t)star->space_count++;
    }
}

static size_t count_corners(const division *d, uint32_t group) {
    size_t count = 0;
    for (uint32_t j = d->first[group]; j != MIKK_NONE; j = d->following[j]) count++;
    return count;
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
    for (uint32_t g = 0; g < groups; g++) {
        if (!star->spaces[g].opposed) continue;
        if (count_corners(&d, g) > MOST_DIVIDED)
            part_group(&d, g);
        else
            divide_group(&d, g);
    }
}
