/* star_kernel.h: ordinary stars, nearly all there are, made many at a time. To the same bits as one
 * by one. */
#ifndef NORMA_CORE_CORNER_STAR_KERNEL_H
#define NORMA_CORE_CORNER_STAR_KERNEL_H
#include "core/corner/corner.h"

/* ---- the triangles that a batch of stars needs, measured many at a time, and kept for the batches
 * that follow: among neighbours, each is at three stars not far from each other. Those of a small
 * mesh are measured all at once before the first batch. */

enum { BATCH_CORNERS = 128, FACES_KEPT = 256 };

typedef struct measured_faces {
    _Alignas(64) measured_face room[FACES_KEPT + BATCH_CORNERS]; /* kept ones, each at the place
                                           that its number names; places of the batch's corners */
    uint32_t number[FACES_KEPT], used[FACES_KEPT]; /* of kept ones: the face; the last batch */
    uint32_t batch;
    uint32_t waiting_count, waiting[BATCH_CORNERS + 8]; /* faces to measure, */
    uint16_t waiting_place[BATCH_CORNERS + 8];          /* and where they go */
} measured_faces;

void norma_core_clear_measured(measured_faces *m);
/* Those that wait; then another batch may begin. */
void norma_core_measure_waiting(const core_prepared_mesh *prepared, measured_faces *m);
/* Of a small mesh of triangles, most of whose corners are at stars: prepared->measured, unless it
 * is there. */
norma_result norma_core_measure_small(core_prepared_mesh *prepared);

/* The place of a corner of this batch. */
static inline uint16_t norma_core_place_of_corner(size_t corner) {
    return (uint16_t)(FACES_KEPT + corner);
}

/* Where the face of a corner of the batch will be, once none waits. Whether it is there already is
 * written beyond the end of the list, or not: no branch could foretell it. */
static inline uint16_t norma_core_place_of_face(measured_faces *m, uint32_t face, size_t corner) {
    uint16_t place = (uint16_t)(face % FACES_KEPT);
    const int is_there = m->number[place] == face;
    if (!is_there && m->used[place] == m->batch) {
        place = norma_core_place_of_corner(corner); /* another face of this batch is there */
    } else {
        m->number[place] = face;
        m->used[place] = m->batch;
    }
    m->waiting[m->waiting_count] = face;
    m->waiting_place[m->waiting_count] = place;
    m->waiting_count += !is_there;
    return place;
}

/* ---- ordinary stars, nearly all there are, made many at a time: up to so many corners, along each
 * edge one face out and one back, with at most one gap, and directions that doubles decide; of
 * polygons, faces that keep all their corners. To the same bits as one by one. */

enum { ORDINARY_CORNERS = 16, NOTE_BITS = 10 };

typedef struct listed_star {
    uint32_t position;
    uint16_t begin, count;         /* of its corners among those of the list */
    uint16_t first_fan, fan_count; /* once settled; no fan: it is not ordinary */
    uint16_t open;                 /* its first and last face share no edge */
    uint16_t scattered; /* its faces lie far apart: what memory they need is asked for ahead */
} listed_star;

typedef struct star_list {
    size_t corner_count, star_count;
    const position_visit *visit;
    uint32_t corners[BATCH_CORNERS]; /* of each star ascending, as its sums run */
    uint32_t next[BATCH_CORNERS + ORDINARY_CORNERS],
        previous[BATCH_CORNERS +
                 ORDINARY_CORNERS]; /* the face's other corners, as the mesh names them */
    uint32_t face[BATCH_CORNERS];
    uint32_t turn[BATCH_CORNERS]; /* which of its triangle's corners it is; of polygons 0 */
    listed_star stars[BATCH_CORNERS];
} star_list;

enum { EDGE_CUT = 1, EDGE_NEAR_CREASE = 2, EDGE_UNSURE = 4 };

typedef struct fan_batch {
    measured_faces measured;
    const measured_face *faces;    /* its own, or those of the whole mesh */
    uint16_t place[BATCH_CORNERS]; /* of each corner of the list: its face among these */
    uint8_t order[BATCH_CORNERS + ORDINARY_CORNERS]; /* the corners of a star, numbered from its
                                                        first, from each to the one whose edge to
                                                        next is its own edge from previous */
    uint8_t notes[1 << NOTE_BITS];                   /* corners by position, of one star only */
    uint32_t edge[BATCH_CORNERS];                    /* EDGE_ flags of each */
    _Alignas(
        64) double row[BATCH_CORNERS + ORDINARY_CORNERS][4]; /* products of each edge; once it
                                       is known which are cut, of each fan its sum and weight */
    double decided[BATCH_CORNERS + ORDINARY_CORNERS];        /* of each fan, from here on */
    float direction[3][BATCH_CORNERS + ORDINARY_CORNERS];
    core_fan fans[BATCH_CORNERS];
    uint32_t fan_of[BATCH_CORNERS]; /* of each corner of the list: its fan, numbered from the star's
                                       first */
} fan_batch;

int norma_core_can_batch(const core_prepared_mesh *prepared);
void norma_core_clear_batch(fan_batch *batch);
void norma_core_clear_list(star_list *list, const position_visit *visit);
/* Adds a star. 0: the list is full. */
int norma_core_list_star(
    const core_prepared_mesh *prepared, uint32_t position, uint32_t count, star_list *list);
/* Reads the corners of all stars, and asks for their positions. */
void norma_core_read_list(const core_prepared_mesh *prepared, star_list *list);
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
