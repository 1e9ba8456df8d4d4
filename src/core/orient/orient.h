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

/* The same in steps: a scene is built once, and votes may be asked for again after the parts' flags
 * have changed. What it says of a part does not depend on what else was asked. */
typedef struct core_ray_scene core_ray_scene;
norma_result norma_core_ray_scene_open(
    const core_topology *topology, core_components *components, core_ray_scene **scene);
norma_result norma_core_ray_scene_vote(
    core_ray_scene *scene, uint8_t open_flags, core_ray_votes *votes);
void norma_core_ray_scene_close(core_ray_scene *scene); /* NULL is fine */

/* sides.c: which faces are turned. A closed part, once its faces agree, shows it by its volume and
 * what it lies in. In an open one each piece whose faces agree is judged by rays for itself, as two
 * pieces that touch may both be right. What is one-sided, or what rays do not decide on, shows
 * nothing, and there the bit of what is turned means the faces that differ from most of their part.
 */
enum { CORE_SIDE_TURNED = 1, CORE_SIDE_UNDECIDED = 2, CORE_SIDE_BY_RAYS = 4 };

/* mesh: stays as it is until the judge is released. The judge is kept by address. */
typedef struct core_side_judge {
    core_call call;
    core_topology topology;
    core_components parts, pieces;
    core_ray_scene *rays; /* NULL: nothing was asked yet that rays must say */
    uint8_t *known;       /* of each piece: what rays said */
    size_t room;
} core_side_judge;
norma_result norma_core_side_judge_open(
    const norma_mesh *mesh, const norma_options *options, core_side_judge *judge);
/* sides: of count faces from first on. asked: NULL, or a mark of each of them: rays are cast only
 * from pieces in which one is marked. */
norma_result norma_core_side_judge_ask(
    core_side_judge *judge, size_t first, size_t count, const uint8_t *asked, uint8_t *sides);
void norma_core_side_judge_close(core_side_judge *judge);
#endif
