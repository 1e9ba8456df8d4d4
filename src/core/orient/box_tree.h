/* box_tree.h: trees over boxes: which of them hold a point, which a ray meets; groups of faces seen
 * from afar. */
#ifndef NORMA_CORE_BOX_TREE_H
#define NORMA_CORE_BOX_TREE_H
#include "core/orient/components.h"
#include "core/mesh/kdtree.h"
#include "core/call/sort.h"

typedef struct core_box_node {
    double low[3], high[3]; /* of all boxes below */
    uint32_t begin, count;  /* of numbers */
    uint32_t left, right;   /* nodes; right 0: a leaf */
} core_box_node;

typedef struct core_box_tree {
    core_box_node *nodes;
    uint32_t *numbers;
    size_t node_count, count;
} core_box_tree;

/* O(n log n). */
norma_result norma_core_box_tree_build(
    const core_call *call, const core_box *boxes, size_t count, core_box_tree *tree);
void norma_core_box_tree_release(const core_call *call, core_box_tree *tree);
/* Those in nodes whose box holds the point; the caller looks at each one's own. */
void norma_core_box_tree_stab(const core_box_tree *tree, const double point[3],
    void (*visit)(void *context, uint32_t number), void *context);

typedef struct core_dipole {
    double centre[3], area[3],
        radius;    /* the sum of the faces' area vectors stands for them outside of some radii */
    double weight; /* the sum of their areas */
    uint32_t begin, count, left, right; /* of faces; nodes; right 0: a leaf */
} core_dipole;

typedef struct core_dipoles {
    core_dipole *nodes; /* NULL: there are none */
    uint32_t *faces;
    size_t node_count, count;
} core_dipoles;

/* Over some faces; reverse: NULL, or those that are taken the other way round. O(n log n). */
norma_result norma_core_dipoles_build(const core_topology *topology, const uint8_t *reverse,
    const uint32_t *faces, size_t count, core_dipoles *dipoles);
void norma_core_dipoles_release(const core_call *call, core_dipoles *dipoles);
#endif
