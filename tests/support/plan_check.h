/* plan_check.h: random meshes that move, and what an update of a plan must give: see plan_check.c.
 */
#ifndef NORMA_TESTS_PLAN_CHECK_H
#define NORMA_TESTS_PLAN_CHECK_H
#include "check.h"
#include "mesh_files.h"

typedef struct plan_case {
    mesh_file mesh;  /* as it was when the plan was made */
    norma_mesh view; /* of float_positions or of doubles */
    float *floats;   /* room for the positions of each moment */
    uint8_t *hard;
    uint32_t *groups;
    float crease_rad;
    norma_element of;
    norma_options options;
    size_t elements; /* vertices or corners */
    char name[120];
} plan_case;

/* A small, nasty mesh with random options: degenerate faces, equal positions, seams, twins, edges
 * of many faces, polygons, hard edges, groups; every weight and weld. */
void plan_case_make(plan_case *c, uint64_t seed);
void plan_case_free(plan_case *c);
uint32_t plan_random(uint64_t *seed, uint32_t below);

/* Moves some vertices of the case's view to new places (a copy of the positions it is given), equal
 * positions together or each for itself; some become NaN, some come back, slivers open and close.
 * Names those that it moved, some of them twice. Returns how many it names. */
size_t plan_case_move(plan_case *c, uint64_t *seed, int together, uint32_t *moved, size_t room);
#endif
