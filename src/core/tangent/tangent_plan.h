/* tangent_plan.h: what of a mesh's tangents depends on topology and texture coordinates, and on
 * positions and normals only by which of them are equal. An update looks whether they still are;
 * where not, it does without. */
#ifndef NORMA_CORE_TANGENT_PLAN_H
#define NORMA_CORE_TANGENT_PLAN_H
#include "core/tangent/mikk.h"

/* True as long as the weld is. */
typedef struct tangent_known {
    const mikk_mesh *mikk;           /* NULL for steady tangents; else the rest is not there */
    uint32_t *vertex_of;             /* of each corner */
    core_corners_of_position around; /* of each vertex */
} tangent_known;

/* Vertices that are not equal, but have the same texture coordinates, may become so. */
typedef struct tangent_rivals {
    size_t few_count, crowd_count;
    uint32_t *few;   /* groups of a few: their size, then the keys */
    uint32_t *crowd; /* keys of all larger groups */
} tangent_rivals;

typedef struct tangent_store {
    void *memory;
    size_t count, size;
} tangent_store;

enum { TANGENT_PLAN_STORES = 12 };

struct norma_tangent_plan {
    core_call memory; /* of the creation's allocator, and of nothing else */
    norma_tangent_mode mode;
    core_mesh mesh; /* with corners of its own, and without positions */
    int by_position;
    size_t key_count, most_corners; /* most_corners: of a face */
    float (*texcoords)[2];          /* of each key */
    uint32_t *weld;                 /* as tangent_mesh has it */
    uint32_t *place;         /* NULL, or of each key the least with its texture coordinates */
    uint32_t *position_weld; /* NULL, or of each position the least that is equal to it */
    core_corners_of_position at_place, at_position;
    tangent_rivals rivals;
    tangent_known known;
    mikk_mesh mikk;
    tangent_store stores[TANGENT_PLAN_STORES];
    size_t store_count, bytes;
};

/* tangent_rivals.c. MEMORY or CANCELLED; the plan keeps what is allocated. */
norma_result norma_core_tangent_rivals_find(core_call *call, norma_tangent_plan *plan);
/* Whether the vertices that were equal at the plan's creation are, and no others. *holds is set. */
norma_result norma_core_tangent_weld_holds(
    const norma_tangent_plan *plan, const tangent_mesh *mesh, int *holds);

/* tangent_plan_memory.c: memory that lives as long as the plan; adopt: that its allocator gave out
 * before, or NULL. */
void norma_core_tangent_adopt(norma_tangent_plan *plan, void *memory, size_t count, size_t size);
void *norma_core_tangent_keep(norma_tangent_plan *plan, size_t count, size_t size);

/* tangent_region.c: the faces that some moved vertices have to do with. */
typedef struct tangent_region {
    uint8_t *wanted; /* of each key that stands for a place: its tangents may change */
    uint8_t *near;   /* of each face: it has a corner at such a place */
    size_t face_count, corner_count; /* of faces that are near */
    int is_large;                    /* nothing is won by looking at it alone */
} tangent_region;
norma_result norma_core_tangent_region_open(const core_call *call, const norma_tangent_plan *plan,
    const uint32_t *moved, size_t moved_count, tangent_region *region);
void norma_core_tangent_region_close(
    const core_call *call, const norma_tangent_plan *plan, tangent_region *region);

/* tangent_part.c: *is_awkward: the whole mesh has to be computed; nothing has been written. */
norma_result norma_core_tangent_update_part(const norma_tangent_plan *plan,
    const tangent_mesh *whole, const tangent_region *region, const tangent_output *output,
    core_tally *tally, int *is_awkward);

static inline uint32_t norma_core_tangent_place(const norma_tangent_plan *plan, size_t corner) {
    const uint32_t key =
        plan->by_position ? norma_core_corner(&plan->mesh, corner) : (uint32_t)corner;
    return plan->place ? plan->place[key] : key;
}
#endif
