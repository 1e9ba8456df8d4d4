/* orient.h: which way an open part is seen most from outside. */
#ifndef NORMA_CORE_ORIENT_H
#define NORMA_CORE_ORIENT_H
#include "core/orient/components.h"

/* rays.c: of each open part whether most rays say that it should be reversed, as
 * components->reverse now has it. Parts of no opinion keep what they have. */
typedef struct core_ray_votes {
    size_t decided, undecided, reversed;
    double least_confidence;
    uint64_t steps; /* nodes and corners that rays looked at: O(parts log faces) */
} core_ray_votes;
norma_result norma_core_orient_by_rays(const core_topology *topology, core_components *components,
    uint8_t open_flags, core_ray_votes *votes);

/* orient.c: which faces are turned. A closed part shows it by its volume and what it lies in, an
 * open one by rays; what is one-sided, or what rays do not decide on, shows nothing, and there the
 * bit of what is turned means the faces that differ from most of their part. */
enum { CORE_SIDE_TURNED = 1, CORE_SIDE_UNDECIDED = 2, CORE_SIDE_BY_RAYS = 4 };
norma_result norma_core_judge_sides(
    const norma_mesh *mesh, const norma_options *options, uint8_t *sides);
#endif
