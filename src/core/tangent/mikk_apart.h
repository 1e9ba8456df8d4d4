/* mikk_apart.h: large groups in which tangents are opposed to each other. */
#ifndef NORMA_CORE_MIKK_APART_H
#define NORMA_CORE_MIKK_APART_H
#include "core/tangent/mikk_star.h"

/* ---- mikk_opposed.c: who is opposed to whom */

typedef struct mikk_cell {
    uint32_t key, first, count; /* of the corners in order */
} mikk_cell;

/* Corners by the cell in which one of their two vectors ends. */
typedef struct mikk_grid {
    int of_t;
    size_t room; /* of the table, a power of two */
    mikk_cell *cells;
    uint32_t *order; /* numbers of the crowd, cell by cell */
    float *numbers;  /* s and t of each of them: six rows of row_length */
    size_t row_length;
} mikk_grid;

/* The corners of a group that add to its sum, but for those that are not numbers. */
typedef struct mikk_crowd {
    const mikk_star *star;
    size_t count, room;
    uint32_t *corners; /* of the star, ascending */
    uint32_t *wild;    /* numbers of the crowd: vectors that are longer than unit */
    size_t wild_count;
    mikk_grid grids[2];
} mikk_crowd;

/* With corners filled in. 0: no memory; norma_core_mikk_crowd_close in any case. */
int norma_core_mikk_crowd_open(mikk_crowd *crowd);
void norma_core_mikk_crowd_close(mikk_crowd *crowd);

/* Those that are opposed to corner i of the crowd: ascending numbers of the crowd. opponents has
 * room for as many as the crowd has. Returns how many there are. */
size_t norma_core_mikk_opponents(const mikk_crowd *crowd, uint32_t i, uint64_t *opponents);

/* ---- mikk_left_out.c: sums that leave out some */

/* Sum i leaves out the addends at positions[starts[i]], ..., ascending and at least one. */
typedef struct mikk_left_out {
    size_t sum_count;
    uint32_t *starts, *positions;
} mikk_left_out;

typedef struct mikk_sums mikk_sums;

/* NULL: no memory. addend_count: of each run. */
mikk_sums *norma_core_mikk_sums_open(
    const core_call *call, const mikk_left_out *left_out, size_t addend_count);
void norma_core_mikk_sums_close(mikk_sums *sums);

/* Float sums in ascending order. Returns the one that leaves out nothing. */
float norma_core_mikk_sums_run(mikk_sums *sums, const float *addends, float *out);
#endif
