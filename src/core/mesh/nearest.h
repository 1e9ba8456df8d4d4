/* nearest.h: the nearest element that has a normal, for those that have none. */
#ifndef NORMA_CORE_NEAREST_H
#define NORMA_CORE_NEAREST_H
#include "core/mesh/kdtree.h"

typedef struct core_nearest {
    core_call *call;
    const core_mesh *mesh;
    uint32_t *first_at; /* of each position, the first element there that has a normal; UINT32_MAX:
                           none */
    uint32_t *found_at; /* of each (welded) position that was asked for, the answer; UINT32_MAX: not
                           asked yet */
    uint32_t *sites;    /* positions that have one */
    size_t site_count;
    uint32_t first; /* of all elements */
    int planted;
    core_kdtree tree;
} core_nearest;

/* Between begin and plant the caller tells of elements in ascending order. queries: about how many
 * will be asked. */
norma_result norma_core_nearest_begin(
    core_call *call, const core_mesh *mesh, core_nearest *nearest);
void norma_core_nearest_add(core_nearest *nearest, uint32_t position, uint32_t element);
norma_result norma_core_nearest_plant(core_nearest *nearest, size_t queries);
void norma_core_nearest_end(core_nearest *nearest);

/* For an element at position that has none: the first at its own position, else at the nearest,
 * ties the lower; UINT32_MAX: no element has a normal. Each position is looked up once, however
 * many ask. */
uint32_t norma_core_nearest_find(core_nearest *nearest, uint32_t position);
#endif
