/* star_kernel.h: batches of stars that are joined and summed many at a time, as nearly all are. To
 * the same bits as one by one (star.c, star_fans.c), which is how the others are made. */
#ifndef NORMA_CORE_CORNER_STAR_KERNEL_H
#define NORMA_CORE_CORNER_STAR_KERNEL_H
#include "core/corner/corner.h"

/* ---- which stars are ordinary, and may be in a batch: of up to so many corners, all of whose
 * faces have directions that doubles decide. Where edges are counted, of polygons, and where all
 * partners at an edge share it, also with one face out and one back at most along each edge, and no
 * twins; of polygons, with faces that keep all their corners. */

enum { BATCH_CORNERS = 128, FACES_KEPT = 4096, ORDINARY_CORNERS = 16 };

/* The triangles that a batch of stars needs, measured many at a time, and kept for the batches that
 * follow: among neighbours, each is at three stars not far from each other. Each has the place that
 * its number names, or one of the list's corners, behind those. A corner's key is eight times that
 * place, and which of its triangle's corners it is. Polygons are kept for one list, once for each
 * corner there, their first. */
typedef struct kept_faces {
    /* The unit normal, and 1, or 0 where doubles do not decide it; the weights of the corners. */
    double (*row)[8];
    /* The corners' welded positions, and the first two again: after a corner's come those of its
     * next and its previous. */
    uint32_t (*at)[8];
    uint64_t *held; /* which face, and 2^32 times the last list that needs it */
    void *block;    /* of all three */
    uint32_t room, lists;
    atomic_int taken; /* by one who works */
} kept_faces;

/* For each who works at once. MEMORY leaves nothing to release. */
norma_result norma_core_kept_allocate(
    const core_prepared_mesh *prepared, size_t count, kept_faces **kept);
void norma_core_kept_release(const core_prepared_mesh *prepared, size_t count, kept_faces *kept);

typedef struct listed_star {
    uint32_t position;
    uint16_t begin, count;         /* of its corners among those of the list */
    uint16_t first_fan, fan_count; /* once settled; no fan: it is not ordinary. While settling:
                                      whether it may be */
} listed_star;

typedef struct star_list {
    size_t corner_count, star_count;
    const position_visit *visit;
    const uint32_t *corners; /* of each star ascending, as its sums run */
    uint32_t least, most;    /* of the corners */
    int scattered;    /* their faces lie far apart: what memory they need is asked for ahead */
    uint32_t waiting; /* faces to measure; of polygons, one for each corner */
    uint32_t key[BATCH_CORNERS];
    uint32_t face[BATCH_CORNERS + 1];  /* of each that waits its number */
    uint32_t at[BATCH_CORNERS + 8][3]; /* and its positions, as the mesh names them; of polygons'
                                          corners own, next, previous */
    uint16_t place[BATCH_CORNERS + 8]; /* and where it goes */
    listed_star stars[BATCH_CORNERS];
} star_list;

enum { BATCH_ROOM = BATCH_CORNERS + ORDINARY_CORNERS }; /* the last star is read to its end */

typedef struct fan_batch {
    kept_faces *kept;
    uint32_t next[BATCH_ROOM], previous[BATCH_ROOM]; /* of each corner, the positions in its face */
    /* Of each, as bits, the corners of its star whose faces run back along its edge to next, and
     * out along that from previous. */
    uint32_t back[BATCH_ROOM], out[BATCH_ROOM];
    uint32_t other[BATCH_ROOM];             /* of each the one across its edge to next, or itself */
    uint32_t edge[BATCH_ROOM];              /* flags of that edge (star_kernel.c) */
    _Alignas(64) double row[BATCH_ROOM][4]; /* products of each edge; once it is known which are
                                               cut, of each fan its sum and weight */
    double decided[BATCH_ROOM];             /* of each fan, from here on */
    float direction[3][BATCH_ROOM];
    core_fan fans[BATCH_CORNERS];
    int all_decided;             /* each fan has a normal */
    uint32_t fan_of[BATCH_ROOM]; /* of each corner: its fan in the batch */
} fan_batch;

int norma_core_can_batch(const core_prepared_mesh *prepared);
/* Reads the corners of the faces that are not kept yet, and asks for their positions; once the list
 * before the last is settled. */
void norma_core_read_list(const core_prepared_mesh *prepared, fan_batch *batch, star_list *list);
/* Joins and sums the fans of all stars in the list; 0: some are not ordinary. edges
 * may be NULL. */
typedef int fans_simd(
    const core_prepared_mesh *prepared, star_list *list, fan_batch *batch, norma_edges *edges);
fans_simd *norma_core_choose_fans(norma_isa isa);
#endif
