/* plan.h: what of a mesh's normals depends on topology alone. Its unit is the group: the corners
 * whose votes make up one sum. Per corner a group is a fan; per vertex it is the fans that a
 * vertex's corners lie in, shared by all vertices of the same fans. A group's corners are listed in
 * ascending order, that of every sum. */
#ifndef NORMA_CORE_PLAN_H
#define NORMA_CORE_PLAN_H
#include "core/corner/normal_cone.h"
#include "core/call/output.h"
#include "core/corner/prepared_mesh.h"
#include <stdatomic.h>

enum { PLAN_MOST_BLOCKS = 24 };

typedef struct plan_store {
    void *memory;
    size_t count, size;
} plan_store;

/* Groups whose sums are streamed through, face by face as they are met: those at positions with
 * more corners, or with larger faces, than a block holds. Its faces are those that meet such a
 * position, with their corners numbered anew. */
typedef struct overflow_group {
    size_t face_count, corner_count, group_count;
    uint32_t *faces;                    /* of the mesh; ascending */
    uint32_t *corners;                  /* vertices */
    uint32_t *face_starts;              /* NULL: triangles */
    uint32_t *corner_faces;             /* NULL: triangles */
    uint32_t *mesh_corners;             /* per corner: of each corner its number in the mesh */
    uint32_t *member_starts, *members;  /* of each group its corners */
    uint32_t *vertex_starts, *vertices; /* per vertex: of each group those that it serves */
    uint32_t *group_starts, *groups;    /* of each corner the groups that it votes in */
    uint32_t *at_starts, *at;           /* of each vertex of the mesh its corners here */
} overflow_group;

typedef struct plan_block plan_block; /* face_block.h */

/* The one part of a plan that updates write: marks for what moved, of a mesh that is larger than
 * the stack has bits for. Whoever comes while another has them does without, in more passes. */
typedef struct plan_shared {
    atomic_flag taken;
    uint64_t *bits;
} plan_shared;

struct norma_plan {
    core_call memory; /* of the creation's allocator, and of nothing else */
    norma_element of;
    size_t vertex_count, corner_count, face_count;
    double scale;     /* core_mesh's, of the positions that it was made with, for all updates by
                         doubles: one of their own would hang on vertices that are not near */
    uint32_t *weld;   /* NULL where every vertex is its own position */
    uint32_t *lonely; /* vertices without corners, ascending */
    size_t lonely_count;
    norma_count empty_faces; /* of no corner at all */
    plan_block *blocks;
    size_t block_count;
    uint32_t *words;                           /* the blocks' lists */
    uint32_t *occurrence_starts, *occurrences; /* of each vertex, where the blocks have it */
    size_t occurrence_count;
    plan_shared *shared; /* NULL where the stack suffices */
    overflow_group overflow;
    plan_store stores[PLAN_MOST_BLOCKS];
    size_t store_count, bytes;
};

/* Memory that lives as long as the plan does. */
void *norma_core_plan_keep(norma_plan *plan, size_t count, size_t size);

static inline int norma_core_plan_borrow(const norma_plan *plan) {
    return plan->shared &&
           !atomic_flag_test_and_set_explicit(&plan->shared->taken, memory_order_acquire);
}
static inline void norma_core_plan_give_back(const norma_plan *plan) {
    atomic_flag_clear_explicit(&plan->shared->taken, memory_order_release);
}

/* ---- normal_groups.c: the groups at a position */

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

/* position_order.c: the positions that have corners, in an order in which neighbours are near each
 * other; order has room for all positions. */
norma_result norma_core_plan_order(
    const core_prepared_mesh *prepared, uint32_t *order, size_t *count);

/* face_block_build.c: all positions whose stars a block has room for; overflow becomes nonzero at
 * the others. */
norma_result norma_core_plan_block(norma_plan *plan, plan_groups *groups, uint8_t *overflow);

/* ---- overflow_group.c: chosen: nonzero at each position whose groups are overflow. */
norma_result norma_core_plan_list_overflow(
    norma_plan *plan, plan_groups *groups, const uint8_t *chosen);

/* ---- one update */

typedef struct plan_work {
    const norma_plan *plan;
    core_call *call;
    core_mesh mesh; /* positions and scale */
    const core_output *output;
    const uint32_t *moved; /* NULL: all */
    size_t moved_count;
    core_tally *tally; /* what the calling thread sums up */
} plan_work;

/* face_block_update.c, overflow_group_update.c */
norma_result norma_core_plan_update_blocks(plan_work *work);
void norma_core_plan_block_vertices(const norma_plan *plan, uint32_t *vertices);
norma_result norma_core_plan_update_overflow(plan_work *work);
/* Of each corner of its faces the vertex, by the corner's number in the mesh. */
void norma_core_plan_overflow_vertices(const norma_plan *plan, uint32_t *vertices);

/* What a sum of three components and a weight amounts to: NORMA_REASON_NONE and the normal,
 * UNREFERENCED where nobody voted (the weight is -0), or CANCELLED. */
int norma_core_plan_decide(const double sum[4], float normal[3]);
/* The same of the normals that voted, by the most visible one. */
int norma_core_plan_decide_cone(
    double weight, norma_core_cone_at *at, const void *context, size_t count, float normal[3]);

/* Tasks are few enough that what each one counts fits the stack. */
enum { PLAN_MOST_TASKS = 128 };
typedef struct plan_range {
    size_t begin, end;
} plan_range;
static inline plan_range norma_core_plan_range(size_t count, size_t tasks, size_t task) {
    return (plan_range){
        (size_t)((uint64_t)count * task / tasks), (size_t)((uint64_t)count * (task + 1) / tasks)};
}
#endif
