/* mikk_star.h: the corners at one vertex, and the tangent spaces that they share. */
#ifndef NORMA_CORE_MIKK_STAR_H
#define NORMA_CORE_MIKK_STAR_H
#include "core/tangent/mikk.h"

typedef struct mikk_space {
    float s[3], t[3]; /* t and the lengths: only of meshes with quads */
    float length_s, length_t, angle;
    int positive;
    uint32_t ends; /* of all tangents of a group that records sum */
    int opposed;   /* of a group: some of its tangents may be opposed to each other */
} mikk_space;

typedef struct mikk_star {
    const mikk_mesh *mesh;
    uint32_t vertex;
    size_t count;
    const uint32_t *corners;           /* of triangles, ascending */
    const uint32_t *next, *previous;   /* the vertices beside it in each corner's triangle */
    const uint8_t *flags;              /* of each corner's triangle */
    const mikk_corners *contributions; /* corner j's are in lane first + j */
    size_t first;
    mikk_edge_table *table; /* NULL: the star is small */
    mikk_links links;
    uint32_t *space;    /* of each corner, or MIKK_NONE */
    uint32_t *sequence; /* of each corner: how many got their space before it */
    uint32_t *seeds;    /* of each space: the corner that its group began with */
    mikk_space *spaces; /* room for twice the corners */
    size_t space_count;
} mikk_star;

static inline uint8_t mikk_flags_of(const mikk_star *star, size_t j) { return star->flags[j]; }
static inline const mikk_corners *mikk_block(const mikk_star *star, size_t j) {
    return &star->contributions[(star->first + j) / MIKK_LANES];
}
static inline size_t mikk_lane_of(const mikk_star *star, size_t j) {
    return (star->first + j) % MIKK_LANES;
}

/* Adds what a corner contributes. */
static inline void mikk_add(const mikk_corners *c, size_t lane, int has_quads, mikk_space *space) {
    const float angle = c->angle[lane];
    for (int k = 0; k < 3; k++) space->s[k] += angle * c->s[k][lane];
    if (!has_quads) return;
    for (int k = 0; k < 3; k++) space->t[k] += angle * c->t[k][lane];
    space->length_s += angle * c->length_s[lane];
    space->length_t += angle * c->length_t[lane];
    space->angle += angle;
}
static inline void norma_core_mikk_add(const mikk_star *star, size_t j, mikk_space *space) {
    mikk_add(mikk_block(star, j), mikk_lane_of(star, j), star->mesh->has_quads, space);
}

/* Makes the sum a space. */
void norma_core_mikk_finish(const mikk_star *star, mikk_space *space);

/* Finds groups and sums their spaces. */
void norma_core_mikk_groups(mikk_star *star);
/* The same from records. 0: some tangents may be opposed to each other, and contributions are
 * needed. */
int norma_core_mikk_groups_of_records(mikk_star *star);

/* mikk_fan.c: 0: the corners of a vertex may be more than one group, or some tangents opposed to
 * each other. Else space is what they sum to. */
int norma_core_mikk_fan(
    const mikk_record *records, const uint32_t *corners, size_t count, mikk_space *space);

/* In groups in which tangents may be opposed to each other, each corner gets the space of all
 * corners of the group that are not opposed to it. Links are used up. */
void norma_core_mikk_divide(mikk_star *star);

void norma_core_mikk_normalise(float v[3]);

static inline int mikk_follows(const mikk_star *star, size_t j) {
    return mikk_flags_of(star, j) & MIKK_FOLLOWS;
}
#endif
