/* kdtree.h: a balanced tree over positions (Bentley 1975), for the two questions about distance:
 * what is nearest, and what lies within a step. */
#ifndef NORMA_CORE_KDTREE_H
#define NORMA_CORE_KDTREE_H
#include "core/mesh/input_mesh.h"

typedef struct core_box {
    double low[3], high[3];
} core_box;

typedef struct core_kdtree {
    const core_mesh *mesh;
    const uint32_t *rank; /* among equally near sites, that of the least rank[site] is nearest;
                             NULL: the least site */
    uint32_t *sites;      /* positions, in the order of the leaves */
    size_t count;
    core_box *boxes; /* of each node; node i has the children 2 i + 1 and 2 i + 2, which halve its
                        range of sites */
    size_t box_count;
} core_kdtree;

/* LEAF: sites of a branch that is not divided. MANY: those of one before which the caller is asked
 * whether to go on. */
enum { KDTREE_LEAF = 8, KDTREE_MANY = 1 << 13 };

/* Takes sites over as they are (finite positions; the caller releases them after the tree), and
 * orders them. MEMORY where the boxes find no room; where that or CANCELLED is returned, there is
 * nothing to release. */
norma_result norma_core_kdtree_build(core_call *call, const core_mesh *mesh, const uint32_t *rank,
    uint32_t *sites, size_t count, core_kdtree *tree);
void norma_core_kdtree_release(const core_call *call, core_kdtree *tree);

/* The site nearest to point (Euclid). The tree is not empty. */
uint32_t norma_core_kdtree_nearest(const core_kdtree *tree, const double point[3]);

/* Least and greatest squared distance between points of two boxes. */
double norma_core_box_least(const core_box *a, const core_box *b);
double norma_core_box_greatest(const core_box *a, const core_box *b);
#endif
