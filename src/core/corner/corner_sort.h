/* corner_sort.h: the corners of a star, sorted by vertex and by the bits of their normals. */
#ifndef NORMA_CORE_MEMBERS_H
#define NORMA_CORE_MEMBERS_H
#include "core/corner/vertex_star.h"

typedef struct star_member {
    uint32_t vertex;
    uint32_t bits[3]; /* of the normal; zero where it does not matter */
    uint32_t index;   /* star number, ascending as corners are */
} star_member;

/* The room of a star's edges, which nobody needs once its fans are joined, holds its members. */
static inline star_member *norma_core_star_members(core_star *star) {
    return (star_member *)(void *)star->edges;
}
/* The same of the copy that sorting edges took: room for a number of each corner. */
static inline uint32_t *norma_core_star_numbers(core_star *star) {
    return (uint32_t *)(void *)star->sorted;
}

static inline int norma_core_same_normal(const star_member *a, const star_member *b) {
    return a->vertex == b->vertex && a->bits[0] == b->bits[0] && a->bits[1] == b->bits[1] &&
           a->bits[2] == b->bits[2];
}

/* By vertex, bits, index; O(n log n). */
void norma_core_sort_corners(star_member *members, size_t count);
#endif
