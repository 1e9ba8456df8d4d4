/* plan.h: what of a mesh's normals depends on topology alone. Its unit is the group: the corners
 * whose votes make up one sum. Per corner a group is a fan; per vertex it is the fans that a
 * vertex's corners lie in, shared by all vertices of the same fans. A group's corners are listed in
 * ascending order, that of every sum. */
#ifndef NORMA_CORE_PLAN_H
#define NORMA_CORE_PLAN_H
#include "core/corner/corner.h"
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

typedef struct plan_block plan_block;

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

static inline int norma_core_plan_borrow(const norma_plan *plan) {
    return plan->shared &&
           !atomic_flag_test_and_set_explicit(&plan->shared->taken, memory_order_acquire);
}
static inline void norma_core_plan_give_back(const norma_plan *plan) {
    atomic_flag_clear_explicit(&plan->shared->taken, memory_order_release);
}

/* Memory that is the plan's, from the allocator of its creation. */
static inline void *norma_core_plan_keep(norma_plan *plan, size_t count, size_t size) {
    if (plan->store_count == PLAN_MOST_BLOCKS) return NULL;
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

/* plan_blocks.c: all positions whose stars a block has room for; overflow becomes nonzero at the
 * others. */
norma_result norma_core_plan_block(norma_plan *plan, plan_groups *groups, uint8_t *overflow);

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

/* plan_kernel.c: what a sum of three components and a weight amounts to: NORMA_REASON_NONE and the
 * normal, UNREFERENCED where nobody voted (the weight is -0), or CANCELLED. */
int norma_core_plan_decide(const double sum[4], float normal[3]);

/* The same of the normals that voted, by the most visible one. */
int norma_core_plan_decide_cone(
    double weight, norma_core_cone_at *at, const void *context, size_t count, float normal[3]);

/* face_block_update.c: an update's normals, and of each corner of their
 * faces the vertex, by the corner's number in the mesh. */
norma_result norma_core_plan_update_blocks(plan_work *work);
void norma_core_plan_block_vertices(const norma_plan *plan, uint32_t *vertices);

/* Tasks are few enough that what each one counts fits the stack. */
enum { PLAN_MOST_TASKS = 128 };
typedef struct plan_range {
    size_t begin, end;
} plan_range;
static inline plan_range norma_core_plan_range(size_t count, size_t tasks, size_t task) {
    return (plan_range){
        (size_t)((uint64_t)count * task / tasks), (size_t)((uint64_t)count * (task + 1) / tasks)};
}

/* ---- Blocks (plan_blocks.c, plan_build.c): some hundred neighbouring groups, and all faces that
 * vote in them, numbered anew in 16 bits, so that a block is measured and summed within the nearest
 * cache, on the stack of the thread that does it. Faces on the rim lie in more than one block and
 * are measured in each; nothing else is shared, and only normals are written.
 *
 * How much longer an update takes without each speciality, on eleven real meshes of 35,000 to
 * 100,000 faces, the median and the most: members listed by fours 16 and 29 %; eight triangles in
 * registers of AVX-512 18 and 23 %; writing plain blocks at once 13 and 19 %; asking ahead 4 and
 * 20 % (faces in no order). Of 1 % moved vertices: touching plain blocks by vertex 14 and 39 %; of
 * one: loading some faces only 17 and 37 %. */

/* So many that a task needs less than 32 KiB of stack, as much as jobs and fibers have: of 1,024
 * faces a full update takes 15 % less time, and needs 110 KiB. */
enum {
    BLOCK_FACES = 1 << 8,
    BLOCK_MOST_FACES = BLOCK_FACES - CORE_LANES,
    BLOCK_CORNERS = 3 * BLOCK_FACES,
    BLOCK_VERTICES = 192,
    BLOCK_SLOTS = 96,
    BLOCK_MEMBERS = (1 << 15) - 1 - BLOCK_CORNERS,
    BLOCK_STAR = 128,    /* corners at one position; with more its groups are overflow */
    BLOCK_FACE_BITS = 8, /* a corner of a block of triangles is its number in the face, then the
                            face; of others, its place in corners */
    BLOCK_NOBODY = BLOCK_FACES - 1, /* a member without a vote, of blocks of triangles: what it adds
                                     changes no bit of a sum */
    BLOCK_JOINED = 1 << 15 /* in member_starts: the group is at the position of the one before */
};

/* One block's lists, all in one store of words. own: vertices at the block's positions; the others
 * only take part in its faces. */
typedef struct block_view {
    uint32_t vertex_count, own_count, group_count, face_count, corner_count, member_count;
    uint32_t first_occurrence, four_count;
    int plain; /* per vertex, each group has its position, and each position its vertex, to itself
                */
    const uint32_t
        *vertices; /* of the mesh; own ones first, per vertex in the order of their groups */
    const uint32_t *faces;        /* of the mesh */
    const uint32_t *mesh_corners; /* polygons: of each face its first corner in the mesh */
    const uint32_t *face_starts;  /* polygons: into corners */
    const uint32_t *weld;         /* NULL, or of each vertex the first one at its position */
    const uint16_t
        *corners; /* vertices; triangles: up to a multiple of eight, the last one again */
    const uint16_t *corner_faces;            /* polygons */
    const uint16_t *member_starts, *members; /* of each group; behind group_count those of vertices
                                                that are not own, one for each */
    const uint16_t *four_counts,
        *fours; /* of each four groups in a row how many members the longest has, and so many times
                   one of each; NULL: see plan_build.c */
    const uint16_t *vertex_starts; /* per vertex, of each group; NULL: group i serves vertex i */
    const uint16_t *group_of;      /* of each own vertex its group, per corner the first one at its
                                     position; NULL: vertex i's is i */
} block_view;

/* What is kept of a block beside its store. */
struct plan_block {
    size_t at; /* first word */
    uint32_t
        first_occurrence; /* occurrences are numbered block by block, in each as its vertices are */
    uint32_t four_count;  /* numbers in fours; 0: none */
    uint16_t vertex_count, own_count, group_count, face_count, corner_count, member_count;
    uint8_t polygons, welded, one_each, plain;
};

block_view norma_core_block(const norma_plan *plan, size_t block);

/* How many eights hold so many: triangles are taken by eights, and groups are finished by eights.
 */
static inline uint32_t norma_core_block_eights(uint32_t count) {
    return (count + CORE_LANES - 1) / CORE_LANES;
}

static inline uint32_t norma_core_block_start(const block_view *t, size_t group) {
    return t->member_starts[group] & (BLOCK_JOINED - 1U);
}
static inline uint32_t norma_core_block_face_of(const block_view *t, uint32_t member) {
    return t->corner_faces ? t->corner_faces[member] : member & (BLOCK_FACES - 1U);
}
/* The place of a member in corners. */
static inline uint32_t norma_core_block_corner_of(const block_view *t, uint32_t member) {
    return t->corner_faces ? member
                           : 3 * (member & (BLOCK_FACES - 1U)) + (member >> BLOCK_FACE_BITS);
}
static inline size_t norma_core_block_mesh_corner(const block_view *t, uint32_t member) {
    const uint32_t face = norma_core_block_face_of(t, member);
    if (!t->corner_faces) return 3 * (size_t)t->faces[face] + (member >> BLOCK_FACE_BITS);
    return (size_t)t->mesh_corners[face] + (member - t->face_starts[face]);
}
/* The code of a corner as a member. */
static inline uint32_t norma_core_block_member(
    int polygons, uint32_t face, uint32_t number, uint32_t corner) {
    return polygons ? corner : number << BLOCK_FACE_BITS | face;
}
static inline uint32_t norma_core_block_group_of(const block_view *t, uint32_t own) {
    return t->group_of ? t->group_of[own] : own;
}

/* ---- one block, measured and summed, on the stack (face_block_update.c, plan_kernel.c) */

/* What later blocks will read and this one will write, asked for little by little while this one is
 * measured: asked for all at once it fills the list of what is under way, and every read waits
 * behind it (10 million triangles: 11.5 instead of 9.8 ns). */
typedef struct block_list {
    const unsigned char *at, *end;
} block_list;
typedef struct block_elements {
    const uint32_t *vertices;
    size_t count;
    const unsigned char *data;
    size_t stride;
} block_elements;
typedef struct block_ahead {
    block_list lists[3];
    block_elements read, written;
} block_ahead;

typedef struct block_room {
    _Alignas(64) double positions[BLOCK_VERTICES][4]; /* of each vertex; the fourth: 0 */
    double normals[BLOCK_FACES]
                  [4]; /* of each face; the fourth: 1; zero where there is no direction */
    double weights[BLOCK_CORNERS]; /* of each member's corner; -0: no vote */
    float results[BLOCK_SLOTS][3]; /* of each group asked for, in the order asked */
    uint8_t reasons[BLOCK_SLOTS];
    uint16_t doubted[BLOCK_FACES];    /* triangles that doubles do not decide */
    uint16_t degenerate[BLOCK_FACES]; /* faces, finite and without a direction */
    uint32_t doubted_count, degenerate_count;
    block_ahead ahead;
    int all_finite, all_normal; /* each position; each group summed has a normal */
} block_room;

/* As much as eight triangles take of a block, and a little more. */
static inline void norma_core_ask_ahead(block_ahead *a) {
    enum { LINE = 64, LINES = 2, VERTICES = 6 };
    for (int k = 0; k < 3; k++)
        for (int i = 0; i < LINES && a->lists[k].at < a->lists[k].end; i++, a->lists[k].at += LINE)
            __builtin_prefetch(a->lists[k].at);
    for (int i = 0; i < VERTICES && a->read.count; i++, a->read.count--)
        __builtin_prefetch(a->read.data + *a->read.vertices++ * a->read.stride);
    for (int i = 0; i < VERTICES && a->written.count; i++, a->written.count--)
        __builtin_prefetch(a->written.data + *a->written.vertices++ * a->written.stride, 1);
}

typedef struct block_some {
    const uint16_t *numbers;
    uint32_t count;
} block_some; /* numbers NULL: 0, 1, 2, ... */

typedef struct block_kernels {
    /* The positions of a block's vertices, or of those of some eights of triangles (NULL: all),
     * three floats each; whether all are finite. */
    int (*load)(const block_view *t, const block_some *eights, const unsigned char *data,
        size_t stride, double (*positions)[4]);
    /* Triangles: normals and weights of some eights; the doubted ones are listed. */
    void (*measure)(const block_view *t, block_some eights, norma_weight weight, block_room *room);
    /* Results and reasons of some groups; whether all have a normal. */
    int (*sum)(const block_view *t, block_some groups, block_room *room);
} block_kernels;

/* plan_kernel.c: the same bits from each. */
block_kernels norma_core_block_kernels(norma_isa isa);

/* ---- from vertices that moved to what of each block they touch. */

enum { MARKS_IN_BLOCK = 1 << 17 }; /* occurrences that the stack has bits for */

typedef struct block_marks {
    size_t first_block, block_count, busy; /* the blocks in which anything that is marked now may
                                            lie, and how many it does lie in */
    size_t next_block;
    uint32_t first_occurrence;
    uint64_t *bits; /* of each occurrence from there on */
    int borrowed;   /* the plan's, which has bits for all */
    uint64_t own[MARKS_IN_BLOCK / 64];
} block_marks;

typedef enum block_moved { BLOCK_NOT_MOVED = 0, BLOCK_PARTLY_MOVED, BLOCK_ALL_MOVED } block_moved;

typedef struct block_touch {
    uint16_t faces[BLOCK_FACES + 1],
        groups[BLOCK_SLOTS + 1]; /* of triangles the eights; room for one that is not listed */
    uint32_t face_count, group_count;
    uint8_t group_is_touched[BLOCK_VERTICES]; /* of groups; where each vertex has one to itself,
                                               while they are found, of vertices */
} block_touch;

static inline void norma_core_mark_bit(uint64_t *bits, size_t i) {
    bits[i / 64] |= (uint64_t)1 << (i % 64);
}

#endif
