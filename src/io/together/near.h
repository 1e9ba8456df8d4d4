/* near.h: positions of all files that chains of short steps join, and the one that stands for each
 * chain. */
#ifndef NORMA_IO_TOGETHER_NEAR_H
#define NORMA_IO_TOGETHER_NEAR_H
#include <norma/norma.h>

typedef struct near_positions near_positions;

/* NULL: out of memory. */
near_positions *norma_near_begin(void);
void norma_near_free(near_positions *near); /* NULL is fine */
/* Before the end, all positions are added, in any order. 0: out of memory. */
int norma_near_add(near_positions *near, const double at[3]);
norma_result norma_near_end(near_positions *near, double distance, uint32_t threads);
/* The least position of its chain, in the place of one that was added. */
void norma_near_find(const near_positions *near, double at[3]);
#endif
