/* mikk_divide.c: groups with tangents that are opposed to each other. The reference joins two
 * triangles of a group if the cosines between their tangents and between their bitangents are above
 * -1, in floats; so those that point exactly the other way, give or take a rounding, are left out
 * of each other's sums. */
#include "core/tangent/mikk_apart.h"

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

/* ---- large groups */

enum { GAPS_PER_CORNER = 24, ADDENDS = 9, ADDENDS_OF_TRIANGLES = 3 };

typedef struct large_division {
    mikk_star *star;
    uint32_t group;
    mikk_crowd crowd;
    uint64_t *opponents;
    mikk_left_out left_out;
    size_t gap_room;
    uint32_t *owners; /* of each sum: the star's corner */
    float *addends, *sums;
    int not_numbers; /* corners whose vectors are not numbers: opposed to all others */
} large_division;

static int is_number(const mikk_star *star, uint32_t j) {
    const mikk_corners *c = mikk_block(star, j);
    const size_t lane = mikk_lane_of(star, j);
    int number = 1;
    for (int k = 0; k < 3; k++)
        number &= (c->s[k][lane] == c->s[k][lane]) & (c->t[k][lane] == c->t[k][lane]);
    return number;
}

static int open_large(large_division *l, size_t count) {
    const core_call *call = l->star->mesh->call;
    l->crowd.room = count;
    l->gap_room = GAPS_PER_CORNER * count;
    l->crowd.corners = norma_core_allocate(call, count, sizeof *l->crowd.corners);
    l->opponents = norma_core_allocate(call, count, sizeof *l->opponents);
    l->left_out.starts = norma_core_allocate(call, count + 1, sizeof *l->left_out.starts);
    l->left_out.positions = norma_core_allocate(call, l->gap_room, sizeof *l->left_out.positions);
    l->owners = norma_core_allocate(call, count, sizeof *l->owners);
    l->addends = norma_core_allocate(call, 2 * count, sizeof *l->addends);
    l->sums = l->addends ? l->addends + count : NULL;
    return l->crowd.corners && l->opponents && l->left_out.starts && l->left_out.positions &&
           l->owners && l->addends;
}

static void close_large(large_division *l) {
    const core_call *call = l->star->mesh->call;
    const size_t count = l->crowd.room;
    norma_core_release(call, l->crowd.corners, count, sizeof *l->crowd.corners);
    norma_core_release(call, l->opponents, count, sizeof *l->opponents);
    norma_core_release(call, l->left_out.starts, count + 1, sizeof *l->left_out.starts);
    norma_core_release(call, l->left_out.positions, l->gap_room, sizeof *l->left_out.positions);
    norma_core_release(call, l->owners, count, sizeof *l->owners);
    norma_core_release(call, l->addends, 2 * count, sizeof *l->addends);
}

static float addend_of(const mikk_star *star, uint32_t j, int which) {
    const mikk_corners *c = mikk_block(star, j);
    const size_t lane = mikk_lane_of(star, j);
    const float angle = c->angle[lane];
    if (which < 3) return angle * c->s[which][lane];
    if (which < 6) return angle * c->t[which - 3][lane];
    return which == 6 ? angle * c->length_s[lane] : which == 7 ? angle * c->length_t[lane] : angle;
}

static float *sum_in(mikk_space *space, int which) {
    if (which < 3) return &space->s[which];
    if (which < 6) return &space->t[which - 3];
    return which == 6 ? &space->length_s : which == 7 ? &space->length_t : &space->angle;
}

/* The sums that have been gathered become spaces. 0: no memory. */
static int sum_gathered(large_division *l, mikk_space *whole) {
    mikk_star *star = l->star;
    const size_t first = star->space_count, count = l->left_out.sum_count;
    const int addends = star->mesh->has_quads ? ADDENDS : ADDENDS_OF_TRIANGLES;
    mikk_sums *sums = norma_core_mikk_sums_open(star->mesh->call, &l->left_out, l->crowd.count);
    if (!sums) return 0;
    for (size_t i = 0; i < count; i++)
        star->spaces[first + i] = (mikk_space){.positive = whole->positive};
    for (int which = 0; which < addends; which++) {
        for (size_t i = 0; i < l->crowd.count; i++)
            l->addends[i] = addend_of(star, l->crowd.corners[i], which);
        *sum_in(whole, which) = norma_core_mikk_sums_run(sums, l->addends, l->sums);
        for (size_t i = 0; i < count; i++) *sum_in(&star->spaces[first + i], which) = l->sums[i];
    }
    norma_core_mikk_sums_close(sums);
    for (size_t i = 0; i < count; i++) {
        norma_core_mikk_finish(star, &star->spaces[first + i]);
        star->space[l->owners[i]] = (uint32_t)(first + i);
    }
    star->space_count += count;
    l->left_out.sum_count = 0;
    return 1;
}

/* Those that are opposed to some get sums of their own, as many at a time as there is room for.
 * joined: marks those that are opposed to none. 0: no memory. */
static int divide_crowd(large_division *l, mikk_space *whole) {
    mikk_left_out *out = &l->left_out;
    out->starts[0] = 0;
    for (uint32_t i = 0; i < l->crowd.count; i++) {
        const size_t count = norma_core_mikk_opponents(&l->crowd, i, l->opponents);
        if (!count) continue;
        if (out->starts[out->sum_count] + count > l->gap_room && !sum_gathered(l, whole)) return 0;
        uint32_t *positions = out->positions + out->starts[out->sum_count];
        for (size_t k = 0; k < count; k++) positions[k] = (uint32_t)l->opponents[k];
        l->owners[out->sum_count++] = l->crowd.corners[i];
        out->starts[out->sum_count] = out->starts[out->sum_count - 1] + (uint32_t)count;
    }
    return sum_gathered(l, whole);
}

/* A corner that is not a number is alone, and the others go on without it. */
static void part_from_not_numbers(const division *d, large_division *l, const mikk_space *whole) {
    mikk_star *star = d->star;
    uint32_t rest = MIKK_NONE; /* none if no other is left in the group: spaces have their number */
    for (uint32_t j = d->first[l->group]; j != MIKK_NONE; j = d->following[j]) {
        if (mikk_follows(star, j)) continue;
        if (is_number(star, j)) {
            if (star->space[j] != l->group) continue;
            if (rest == MIKK_NONE) {
                rest = (uint32_t)star->space_count++;
                star->spaces[rest] = *whole;
                norma_core_mikk_finish(star, &star->spaces[rest]);
            }
            star->space[j] = rest;
            continue;
        }
        mikk_space *space = &star->spaces[star->space_count];
        *space = (mikk_space){.positive = whole->positive};
        norma_core_mikk_add(star, j, space);
        norma_core_mikk_finish(star, space);
        star->space[j] = (uint32_t)star->space_count++;
    }
}

static int divide_gathered(const division *d, large_division *l) {
    mikk_space whole = {.positive = d->star->spaces[l->group].positive};
    const int done = norma_core_mikk_crowd_open(&l->crowd) && divide_crowd(l, &whole);
    norma_core_mikk_crowd_close(&l->crowd);
    if (done && l->not_numbers) part_from_not_numbers(d, l, &whole);
    return done;
}

/* 0: it has to be divided corner by corner. */
static int divide_large_group(const division *d, uint32_t group) {
    mikk_star *star = d->star;
    large_division l = {.star = star, .group = group, .crowd = {.star = star}};
    const size_t spaces = star->space_count;
    size_t count = 0;
    if (star->count <= MIKK_SMALL_STAR) return 0;
    for (uint32_t j = d->first[group]; j != MIKK_NONE; j = d->following[j]) count++;
    int done = open_large(&l, count);
    for (uint32_t j = d->first[group]; done && j != MIKK_NONE; j = d->following[j]) {
        if (mikk_follows(star, j)) continue;
        if (is_number(star, j))
            l.crowd.corners[l.crowd.count++] = j;
        else
            l.not_numbers = 1;
    }
    /* A quad's two triangles are joined even where one of them is not a number. */
    if (l.not_numbers && star->mesh->has_quads) done = 0;
    done = done && divide_gathered(d, &l);
    close_large(&l);
    if (!done) star->space_count = spaces;
    return done;
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
