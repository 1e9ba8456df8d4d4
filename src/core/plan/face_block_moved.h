/* face_block_moved.h: from vertices that moved to what of each block they touch. */
#ifndef NORMA_CORE_PLAN_BLOCK_MOVED_H
#define NORMA_CORE_PLAN_BLOCK_MOVED_H
#include "core/plan/face_block.h"

enum { MARKS_IN_BLOCK = 1 << 17 }; /* occurrences that the stack has bits for */

typedef struct block_marks {
    size_t first_block, block_count, busy; /* the blocks in which anything that is marked now may
                                            lie, and how many it does lie in */
    size_t next_block;
    uint32_t first_occurrence;
    uint64_t *bits; /* of each occurrence from there on */
    int borrowed;   /* the plan's, which has bits for all */
    uint64_t own[MARKS_IN_BLOCK / 64];
} block_marks;

typedef enum block_moved { BLOCK_NOT_MOVED = 0, BLOCK_PARTLY_MOVED, BLOCK_ALL_MOVED } block_moved;

typedef struct block_touch {
    uint16_t faces[BLOCK_FACES + 1],
        groups[BLOCK_SLOTS + 1]; /* of triangles the eights; room for one that is not listed */
    uint32_t face_count, group_count;
    uint8_t group_is_touched[BLOCK_VERTICES]; /* of groups; where each vertex has one to itself,
                                               while they are found, of vertices */
} block_touch;

void norma_core_marks_open(const plan_work *work, block_marks *marks);
/* Marks what moved in the next blocks; 0 where none are left. */
int norma_core_marks_next(const plan_work *work, block_marks *marks);
void norma_core_marks_close(const plan_work *work, block_marks *marks);

block_moved norma_core_block_moved(const block_marks *marks, const plan_block *block);
/* Of a block that has moved in part, the groups whose normals may change, and the faces that vote
 * in them. */
void norma_core_block_touch(
    const block_marks *marks, const block_view *t, norma_element of, block_touch *touch);

/* Whether the normal of a member's corner (its vertex) is written: by a group of this block, and
 * one of those that are written (NULL: all). */
int norma_core_block_writes(
    const block_view *t, norma_element of, uint32_t member, const uint8_t *group_is_written);
#endif
