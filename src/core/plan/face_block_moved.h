/* face_block_moved.h: from vertices that moved to what of each tile they touch. */
#ifndef NORMA_CORE_PLAN_TILE_MOVED_H
#define NORMA_CORE_PLAN_TILE_MOVED_H
#include "core/plan/face_block.h"

enum { MARKS_IN_BLOCK = 1 << 17 }; /* occurrences that the stack has bits for */

typedef struct tile_marks {
    size_t first_tile, tile_count, busy; /* the tiles in which anything that is marked now may lie,
                                            and how many it does lie in */
    size_t next_tile;
    uint32_t first_occurrence;
    uint64_t *bits; /* of each occurrence from there on */
    int borrowed;   /* the plan's, which has bits for all */
    uint64_t own[MARKS_IN_BLOCK / 64];
} tile_marks;

typedef enum tile_moved { TILE_NOT_MOVED = 0, TILE_PARTLY_MOVED, TILE_ALL_MOVED } tile_moved;

typedef struct tile_touch {
    uint16_t faces[TILE_FACES + 1],
        slots[TILE_SLOTS + 1]; /* of triangles the eights; room for one that is not listed */
    uint32_t face_count, slot_count;
    uint8_t slot_is_touched[TILE_VERTICES]; /* of slots; where each vertex has one to itself, while
                                               they are found, of vertices */
} tile_touch;

void norma_core_marks_open(const plan_work *work, tile_marks *marks);
/* Marks what moved in the next tiles; 0 where none are left. */
int norma_core_marks_next(const plan_work *work, tile_marks *marks);
void norma_core_marks_close(const plan_work *work, tile_marks *marks);

tile_moved norma_core_tile_moved(const tile_marks *marks, const plan_tile *tile);
/* Of a tile that has moved in part, the slots whose normals may change, and the faces that vote in
 * them. */
void norma_core_tile_touch(
    const tile_marks *marks, const tile_view *t, norma_element of, tile_touch *touch);

/* Whether the normal of a member's corner (its vertex) is written: by a slot of this tile, and one
 * of those that are written (NULL: all). */
int norma_core_tile_writes(
    const tile_view *t, norma_element of, uint32_t member, const uint8_t *slot_is_written);
#endif
