/* fan_batch.h: ordinary stars, nearly all there are, made many at a time: up to so many corners,
 * along each edge one face out and one back, with at most one gap, and directions that doubles
 * decide; of polygons, faces that keep all their corners. To the same bits as one by one. */
#ifndef NORMA_CORE_STAR_BATCH_H
#define NORMA_CORE_STAR_BATCH_H
#include "core/corner/visit_positions.h"

enum { BATCH_CORNERS = 128, ORDINARY_CORNERS = 16 };

typedef struct listed_star {
    uint32_t position;
    uint8_t begin, count;         /* of its corners among those of the list */
    uint8_t first_fan, fan_count; /* once settled; no fan: it is not ordinary */
    uint8_t open;                 /* its first and last face share no edge */
    uint8_t higher;               /* of a closed one: neighbours of higher number */
    uint8_t scattered; /* its faces lie far apart: what memory they need is asked for ahead */
} listed_star;

typedef struct star_list {
    size_t corner_count, star_count;
    const position_visit *visit;
    uint32_t corners[BATCH_CORNERS]; /* of each star ascending, as its sums run */
    uint32_t next[BATCH_CORNERS + ORDINARY_CORNERS],
        previous[BATCH_CORNERS +
                 ORDINARY_CORNERS]; /* the face's other corners, as the mesh names them */
    double turn[BATCH_CORNERS];     /* which of its face's corners it is; of polygons: whether that
                                       is a triangle */
    uint32_t face[BATCH_CORNERS];   /* of polygons only */
    listed_star stars[BATCH_CORNERS];
} star_list;

typedef double batch_lane[BATCH_CORNERS + ORDINARY_CORNERS]; /* a star may be written beyond its
                                                                end, where the next one follows */

/* Lanes of a star go round it from face to face: what is previous in one is next in the following
 * one. */
typedef struct fan_batch {
    uint8_t lane_of[BATCH_CORNERS];                     /* of each corner of the list */
    batch_lane at[3], next_at[3], previous_at[3], turn; /* in: positions */
    batch_lane area;                                    /* in: twice that of polygons */
    batch_lane normal[3], vote[3], weight, sure;        /* of each face; its weighted normal */
    batch_lane
        cosine; /* between its normal and the following lane's; UNSURE where its own is not sure */
    batch_lane sum[3], total, decided; /* of each fan, from here on */
    float direction[3][BATCH_CORNERS + ORDINARY_CORNERS];
    core_fan fans[BATCH_CORNERS];
    uint32_t fan_of[BATCH_CORNERS]; /* of each corner of the list, in stars of several fans */
} fan_batch;

int norma_core_can_batch(const core_prepared_mesh *prepared);
void norma_core_clear_list(star_list *list, const position_visit *visit);
/* Adds a star, and asks for its positions. 0: the list is full. */
int norma_core_list_star(
    const core_prepared_mesh *prepared, uint32_t position, uint32_t count, star_list *list);
/* Asks for the places where its normals will go; for the mesh's corners of the stars that come two
 * lists later. */
void norma_core_ask_for_targets(const star_list *list, const listed_star *star);
void norma_core_ask_for_corners(const core_prepared_mesh *prepared, const listed_star *star);
/* fans_simd.c: joins and sums the fans of all stars in the list; 0: some are not ordinary. edges
 * may be NULL. */
typedef int fans_simd(
    const core_prepared_mesh *prepared, star_list *list, fan_batch *batch, norma_edges *edges);
fans_simd *norma_core_choose_fans(norma_isa isa);
#endif
