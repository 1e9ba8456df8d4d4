/* measured_faces.h: the triangles that a batch of stars needs, measured many at a time, and kept
 * for the batches that follow: among neighbours, each is at three stars not far from each other.
 * Those of a small mesh are measured all at once before the first batch. */
#ifndef NORMA_CORE_MEASURED_FACES_H
#define NORMA_CORE_MEASURED_FACES_H
#include "core/corner/prepared_mesh.h"

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
#endif
