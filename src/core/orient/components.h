/* components.h: the parts that edges hold together, which of them are closed, and how they lie in
 * one another. */
#ifndef NORMA_CORE_COMPONENTS_H
#define NORMA_CORE_COMPONENTS_H
#include "core/orient/edge_partners.h"

enum {
    COMPONENT_OPEN = 1,
    COMPONENT_CONFLICT = 2,
    COMPONENT_MANY = 4,
    COMPONENT_ONE_SIDED = 8,
    COMPONENT_UNBALANCED = 16,
    COMPONENT_UNDECIDED = 32
};
/* It has an edge of one face; one of two that run the same way; one of more than two; no winding of
 * its faces agrees with itself (only where conflicts were followed); an edge of more than two along
 * which its own faces do not run as often one way as the other; rays do not say which side of it is
 * outward. */

typedef enum component_verdict {
    COMPONENT_FINE = 0,
    COMPONENT_INWARD,
    COMPONENT_NESTED
} component_verdict;
/* Nothing is wrong, or nothing can be known; of negative volume that nothing encloses or that lies
 * right inside a cavity; a solid right inside a solid. */

typedef struct core_component {
    double low[3], high[3];
    double volume;   /* times six; 0 where it is within rounding. Only of those without flags that
                        matter */
    uint32_t parent; /* the smallest component that it lies in, UINT32_MAX: none. Set by
                        norma_core_judge_nesting */
    uint8_t flags, verdict;
} core_component;

typedef struct core_components {
    uint32_t *of;     /* of each face; UINT32_MAX: it has no edges */
    uint32_t *faces;  /* by component: faces[starts[i]] is the least face of component i */
    uint32_t *starts; /* count + 1 */
    core_component *each;
    uint8_t *reverse; /* NULL, or nonzero: the face is to be taken the other way round */
    size_t count;
    size_t face_count, room; /* of faces; of starts and each */
} core_components;

typedef enum core_joining {
    CORE_JOIN_BODIES = 0, /* an edge joins its faces, and each keeps its winding; one of more than
                             two joins only parts that do not balance there by themselves: closed
                             bodies that touch along it stay two */
    CORE_JOIN_CUT,  /* edges of more than two faces join none; across conflicts one of the two is
                       reversed, so that reverse is made */
    CORE_JOIN_ALIKE /* neither those nor conflicts join; reverse is made, all zero */
} core_joining;

/* In order of their least faces. O(corners). MEMORY leaves nothing to release. topology: its edges
 * are paired. */
norma_result norma_core_find_components(
    const core_topology *topology, core_joining joining, core_components *components);
void norma_core_release_components(const core_call *call, core_components *components);

/* Boxes of all; volumes of those that have none of the flags in not_closed, with reverse where
 * there is one. */
norma_result norma_core_measure_components(
    const core_topology *topology, core_components *components, uint8_t not_closed);

/* inside.c: parent and verdict of each component without the flags, from outside in: one that is
 * found inward counts as put right for those in it. */
norma_result norma_core_judge_nesting(
    const core_topology *topology, core_components *components, uint8_t not_closed);
#endif
