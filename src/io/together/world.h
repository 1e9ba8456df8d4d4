/* world.h: a surface of a document where a node draws it: positions in the world, which of them are
 * one, and the faces in an order of corners that depends on the positions alone. */
#ifndef NORMA_IO_TOGETHER_WORLD_H
#define NORMA_IO_TOGETHER_WORLD_H
#include "core/mesh/input_mesh.h"
#include "io/format/format.h"

typedef struct near_positions near_positions; /* near.h */

/* Which positions are one: those that are equal, after rounding to floats where rounded is set; or
 * within a distance, where near is not NULL. */
typedef struct equality {
    int rounded;
    const near_positions *near;
} equality;

typedef struct placement {
    double world[16]; /* column-major; the unit of integers is not in it */
    int mirrored, plain;
    uint32_t level; /* of detail, from 0, the finest */
} placement;

typedef struct world_mesh {
    core_mesh mesh; /* with weld: the first position at the same place; one that is not finite is
                       alone */
    double *positions, (*at)[3]; /* at: of each, what tells it from others */
    uint32_t *corners, *weld, *firsts;
    size_t first_count; /* firsts: those that are finite and welded to themselves, in order */
} world_mesh;

/* Returns NORMA_OK, NORMA_ERROR_MEMORY, or what the core finds wrong. Free it in any case. */
norma_result norma_together_place(const document_surface *surface, const placement *place,
    const equality *equal, world_mesh *world);
void norma_together_free_world(world_mesh *world);

/* What tells a position from others. */
void norma_together_at(const equality *equal, const double position[3], double at[3]);
/* The position in the world. */
void norma_together_position(
    const document_surface *surface, const placement *place, size_t index, double position[3]);
#endif
