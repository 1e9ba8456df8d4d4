/* plan.h: what of a mesh's normals depends on topology alone. Its unit is the group: the corners
 * whose votes make up one sum. Per corner a group is a fan; per vertex it is the fans that a
 * vertex's corners lie in, shared by all vertices of the same fans. A group's corners are listed in
 * ascending order, that of every sum. */
#ifndef NORMA_CORE_PLAN_H
#define NORMA_CORE_PLAN_H
#include "core/corner/corner.h"
#include "core/vertex/vertex.h"
#include <stdatomic.h>

enum { PLAN_MOST_STORES = 24 };

typedef struct plan_store {
    void *memory;
    size_t count, size;
} plan_store;

/* The one part of a plan that updates write. Whoever comes while another has it does without. */
typedef struct plan_shared {
    atomic_flag taken;
    core_vertex_sum *sums;    /* of each group */
    uint64_t *groups, *faces; /* a bit of each; zero between updates */
} plan_shared;

struct norma_plan {
    core_call memory; /* of the creation's allocator, and of nothing else */
    norma_element of;
    core_mesh mesh;         /* without positions; weld: NULL where each vertex is its own position.
                               scale: of the positions that it was made with, for all updates by
                               doubles: one of their own would hang on vertices that are not near */
    uint32_t *corner_faces; /* NULL: triangles */
    size_t vertex_count, group_count;
    uint32_t *member_starts, *members;  /* of each group its corners */
    uint32_t *vertex_starts, *vertices; /* per vertex: of each group those that it serves; NULL:
                                           group i serves vertex i */
    uint32_t *at_starts, *at;           /* of each vertex its corners */
    uint32_t *unreferenced; /* vertices without corners, ascending; each has a group, from
                         first_unreferenced on (per vertex, unless each vertex has the group of its
                         number) */
    size_t unreferenced_count, first_unreferenced;
    const uint32_t *targets; /* of each corner the first group that it votes in */
    uint64_t *apart;         /* NULL, or a bit of each group that shares corners with others, and is
                                summed by itself */
    uint64_t *others;        /* pairs, ascending: a corner, and another group that it votes in */
    size_t other_count;
    core_range *ranges;      /* of groups, of each chunk of faces */
    int narrow;              /* a triangle has two corners at one position */
    norma_count empty_faces; /* of no corner at all */
    plan_shared *shared;
    plan_store stores[PLAN_MOST_STORES];
    size_t store_count, bytes;
};
#endif
