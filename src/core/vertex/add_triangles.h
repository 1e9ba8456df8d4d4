/* add_triangles.h: the loops that most of the time of norma_vertex_normals goes to: triangles added
 * to the sums of positions, at once or by way of queues, and sums made normals. */
#ifndef NORMA_CORE_VERTEX_ADD_H
#define NORMA_CORE_VERTEX_ADD_H
#include "core/vertex/face_chain.h"
#include "core/vertex/vertex_normals.h"

typedef struct core_adder {
    const core_mesh *mesh;
    norma_weight weight;
    vertex_sum *sums; /* of count positions from first on; corners elsewhere are passed over */
    uint32_t first, count;
    int owns_all;      /* no corner of the faces that are to be added is elsewhere */
    int scattered;     /* corners in a row lie far apart: memory is asked for ahead */
    int by_distance;   /* positions that differ may be welded into one */
    size_t first_face; /* the number of the mesh's first face to add_face */
    void (*add_face)(void *context, size_t face); /* one that doubles do not decide */
    void *context;
    face_chains *chains; /* beside the sums; by angle only, NULL: none. What add_face is called for
                           has broken them */
    float chain_cosine;  /* norma_core_chain_cosine */
} core_adder;

/* Adds the faces from begin to before end, in ascending order. */
typedef void core_add_faces(const core_adder *adder, size_t begin, size_t end);
/* By add. Corners of other than 32 bits are made so first, so that one
 * loop is enough. */
void norma_core_add_chunk(core_add_faces *add, const core_adder *adder, size_t begin, size_t end);
/* The normals of CORE_LANES sums. Returns whether each is one; where one has no votes, cancels, or
 * is beyond what doubles square, none of them is to be used. */
typedef int core_finish_sums(const vertex_sum sums[CORE_LANES], float normals[CORE_LANES][3]);

/* What a chunk of faces adds, waiting for who owns the sums: of each face a row and the weight of
 * each corner, and the corners in the order of the parts of the positions where they lie, within a
 * part in their own, as 4 face + corner. Position p is in part p * scale / 2^CORE_PART_BITS. */
enum {
    CORE_PARTS = 64 /* at most */,
    CORE_PART_BITS = 40,
    CORE_CORNERS_IN_CHUNK = 3 * CORE_FACES_IN_CHUNK
};
static const uint32_t CORE_NOWHERE = UINT32_MAX; /* the position of a corner that adds nothing */
typedef struct core_queue {
    _Alignas(64) double row[CORE_FACES_IN_CHUNK][4];
    double weight[CORE_FACES_IN_CHUNK][4];
    uint32_t at[CORE_CORNERS_IN_CHUNK];
    uint16_t begin[CORE_PARTS + 2]; /* of each part its first in list; the last part: nowhere */
    uint16_t list[CORE_CORNERS_IN_CHUNK];
} core_queue;

/* The faces from begin to before end, a chunk at most, queued: adder->sums are not touched. */
typedef void core_queue_triangles(
    const core_adder *adder, size_t begin, size_t end, uint64_t scale, core_queue *queue);
/* What waits for one part is added to the sums of all. */
typedef void core_drain_queue(const core_queue *queue, size_t part, vertex_sum *sums);

core_add_faces *norma_core_choose_add(norma_isa isa);
core_queue_triangles *norma_core_choose_queue(norma_isa isa);
core_drain_queue *norma_core_choose_drain(norma_isa isa);
core_finish_sums *norma_core_choose_finish(norma_isa isa);
#endif
