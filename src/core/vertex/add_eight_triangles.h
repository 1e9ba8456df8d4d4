/* add_eight_triangles.h: eight measured triangles added to the sums of their corners, to be
 * compiled into the kernels of each instruction set. */
#ifndef NORMA_CORE_VERTEX_ADD_EIGHT_H
#define NORMA_CORE_VERTEX_ADD_EIGHT_H
#include "core/call/weight.h"
#include "core/face/eight_vectors.h"
#include "core/vertex/vertex.h"

/* Eight triangles, or fewer at the end of all: what each adds to the sums of its corners, its row
 * times the weight of each; where all corners weigh the same, the row itself. */
typedef struct core_eight {
    const double (*row)[4];
    const double (*weight)[CORE_LANES]; /* of each corner */
    const unsigned char *at; /* the corners' positions, welded where they are: three indices of 32
                                bits for each triangle */
    unsigned sure;           /* a bit for each: doubles decide it */
} core_eight;

enum { CORE_ALL_SURE = (1 << CORE_LANES) - 1 };

CORE_INLINE int core_weighs_evenly(norma_weight weight) {
    return core_weighed(weight) == CORE_BY_FACE;
}

CORE_INLINE uint32_t core_eight_at(const core_eight *e, int lane, int corner) {
    uint32_t at;
    memcpy(&at, e->at + sizeof at * (size_t)(3 * lane + corner), sizeof at);
    return at;
}

CORE_INLINE void core_add_corner(
    vertex_sum *sum, const core_eight *e, int lane, int corner, norma_weight weight) {
    if (core_weighs_evenly(weight))
        core_add_whole(&sum->x, e->row[lane]);
    else
        core_add_row(&sum->x, e->row[lane], e->weight[corner][lane]);
}

/* Corners of a range that is another's are passed over. */
CORE_INLINE void core_add_lane(
    const core_adder *adder, const core_eight *e, int lane, norma_weight weight) {
    for (int k = 0; k < 3; k++) {
        const uint32_t sum = core_eight_at(e, lane, k) - adder->first;
        if (sum < adder->count) core_add_corner(&adder->sums[sum], e, lane, k, weight);
    }
}

/* The same of all lanes, for those who own all their corners. */
CORE_INLINE void core_add_all_lanes(
    const core_adder *adder, const core_eight *e, norma_weight weight) {
    const uintptr_t origin = (uintptr_t)adder->sums - adder->first * sizeof *adder->sums;
    for (int i = 0; i < CORE_LANES; i++)
        for (int k = 0; k < 3; k++)
            core_add_corner((vertex_sum *)(origin + core_eight_at(e, i, k) * sizeof *adder->sums),
                e, i, k, weight);
}

/* By doubles, and its corners are at three places. */
CORE_INLINE int core_is_decided(const core_eight *e, int lane) {
    const uint32_t a = core_eight_at(e, lane, 0), b = core_eight_at(e, lane, 1),
                   c = core_eight_at(e, lane, 2);
    return (e->sure >> lane & 1U) && a != b && b != c && c != a;
}

/* What doubles decide has three places, unless those that differ are welded. */
CORE_INLINE int core_all_are_decided(const core_adder *adder, const core_eight *e, int lanes) {
    return lanes == CORE_LANES && !adder->by_distance && e->sure == CORE_ALL_SURE;
}

/* The same with chains. */
CORE_INLINE void core_chain_lane(const core_adder *adder, const core_eight *e, int lane) {
    const float normal[3] = {
        (float)e->row[lane][0], (float)e->row[lane][1], (float)e->row[lane][2]};
    uint32_t at[5]; /* round the face, so that each corner's neighbours follow it */
    for (int k = 0; k < 3; k++) at[k] = core_eight_at(e, lane, k);
    at[3] = at[0];
    at[4] = at[1];
    for (int k = 0; k < 3; k++) {
        const uint32_t sum = at[k] - adder->first;
        if (sum >= adder->count) continue;
        core_add_row(&adder->sums[sum].x, e->row[lane], e->weight[k][lane]);
        core_follow_chains(&adder->chains[sum], normal, adder->chain_cosine, at[k + 1], at[k + 2]);
    }
}

CORE_INLINE void core_break_lane(const core_adder *adder, const core_eight *e, int lane) {
    for (int k = 0; k < 3; k++) {
        const uint32_t sum = core_eight_at(e, lane, k) - adder->first;
        if (sum < adder->count) core_break_chains(&adder->chains[sum]);
    }
}

CORE_INLINE void core_chain_eight(const core_adder *adder, const core_eight *e, int lanes) {
    for (int i = 0; i < lanes; i++)
        if (core_is_decided(e, i))
            core_chain_lane(adder, e, i);
        else
            core_break_lane(adder, e, i);
}

/* Face f is the first of them. */
CORE_INLINE void core_add_eight(
    const core_adder *adder, const core_eight *e, size_t f, int lanes, norma_weight weight) {
    if (weight == NORMA_WEIGHT_ANGLE && adder->chains) {
        core_chain_eight(adder, e, lanes);
        return;
    }
    if (adder->owns_all && core_all_are_decided(adder, e, lanes)) {
        core_add_all_lanes(adder, e, weight);
        return;
    }
    for (int i = 0; i < lanes; i++) {
        if (core_is_decided(e, i))
            core_add_lane(adder, e, i, weight);
        else
            adder->add_face(adder->context, adder->first_face + f + (size_t)i);
    }
}
#endif
