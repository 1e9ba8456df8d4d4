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

/* Tasks are few enough that what each one counts fits the stack. */
enum { PLAN_MOST_TASKS = 128 };

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

static inline uint32_t norma_core_plan_face(const norma_plan *plan, uint32_t corner) {
    return plan->corner_faces ? plan->corner_faces[corner] : corner / 3;
}
static inline uint64_t norma_core_pair(uint32_t high, uint32_t low) {
    return (uint64_t)high << 32 | low;
}
static inline void norma_core_mark_bit(uint64_t *bits, size_t i) {
    bits[i / 64] |= (uint64_t)1 << (i % 64);
}
static inline int norma_core_has_bit(const uint64_t *bits, size_t i) {
    return bits && (bits[i / 64] >> (i % 64) & 1);
}

/* Memory that is the plan's, from the allocator of its creation. */
static inline void *norma_core_plan_keep(norma_plan *plan, size_t count, size_t size) {
    if (plan->store_count == PLAN_MOST_STORES) return NULL;
    void *memory = norma_core_allocate(&plan->memory, count, size);
    if (!memory) return NULL;
    plan->stores[plan->store_count++] = (plan_store){memory, count, size};
    plan->bytes += count * size;
    return memory;
}

/* ---- plan_groups.c: the groups at a position */

typedef void plan_group_receiver(void *context, const uint32_t *members, size_t member_count,
    const uint32_t *vertices, size_t vertex_count);

typedef struct plan_groups {
    const core_prepared_mesh *prepared;
    norma_element of;
    uint32_t *lead; /* of each corner the first of its fan; NULL where a vertex has each position to
                       itself */
    size_t room;    /* of the rest: corners at one position */
    uint64_t *by_fan, *by_vertex, *merged;
    struct group_vertex *sets;
    uint32_t *members, *vertices;
} plan_groups;

norma_result norma_core_plan_groups_open(
    core_prepared_mesh *prepared, norma_element of, plan_groups *groups);
void norma_core_plan_groups_close(plan_groups *groups);

/* Tells of each group at a position, always in the same order; vertices per vertex only. */
void norma_core_plan_groups_at(
    plan_groups *groups, uint32_t position, plan_group_receiver *receive, void *context);

/* ---- one update */

typedef struct plan_work {
    const norma_plan *plan;
    core_call *call;
    core_mesh mesh; /* the plan's, at the update's positions */
    const core_output *output;
    const uint32_t *moved; /* NULL: all */
    size_t moved_count;
    core_tally *tally; /* what the calling thread sums up */
} plan_work;

typedef struct plan_some {
    const uint64_t *bits; /* of each of count groups from first on; NULL: all */
    size_t first, count;
} plan_some;

/* plan_sums.c: groups one by one, each from its members, with no memory but the stack. */
norma_result norma_core_plan_sum_some(const plan_work *work, plan_some some);
/* The same by the sums of norma_vertex_normals, for which all faces between the first and the last
 * are measured; whoever calls this has plan->shared. */
norma_result norma_core_plan_sum_row(const plan_work *work, plan_some some);
#endif
