/* weld.h: which positions are one. */
#ifndef NORMA_CORE_WELD_H
#define NORMA_CORE_WELD_H
#include "core/mesh/input_mesh.h"

/* Sets mesh->weld as the options ask: NULL for NORMA_WELD_NONE and where no two positions are one,
 * else for each position the least index of those that are one with it. NaN is equal to nothing.
 * MEMORY or CANCELLED leave it NULL. Release with norma_core_unweld. */
norma_result norma_core_weld(core_call *call, core_mesh *mesh);
void norma_core_unweld(const core_call *call, core_mesh *mesh);

/* weld_distance.c: joins, in a map of equal positions, those that a chain of steps of at most
 * distance (in the unit that positions are read in) connects. */
norma_result norma_core_weld_near(
    core_call *call, const core_mesh *mesh, double distance, uint32_t *weld);
#endif
