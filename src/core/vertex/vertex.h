/* vertex.h: weighted sums at positions, and the normals of vertices. */
#ifndef NORMA_CORE_VERTEX_VERTEX_H
#define NORMA_CORE_VERTEX_VERTEX_H
#include "core/corner/corner.h"
#include "core/call/call.h"
#include "core/face/face.h"
#include "core/mesh/mesh.h"
#include <math.h>
#include <stdint.h>

/* ---- the sum of the votes at one position, and what becomes of it. */

static inline int norma_core_has_votes(const core_vertex_sum *sum) { return !signbit(sum->weight); }
void norma_core_clear_sums(core_vertex_sum *sums, size_t count);
static inline void norma_core_add_vote(
    core_vertex_sum *sum, double weight, const double normal[3]) {
    sum->x += weight * normal[0];
    sum->y += weight * normal[1];
    sum->z += weight * normal[2];
    sum->weight += weight;
}

/* ---- vertex_normals.c: votes of all faces of a mesh, added up. */

typedef struct core_voting {
    core_call *call;
    const core_mesh *mesh;
    const uint32_t *targets; /* NULL, or of each corner the sum that it votes in, below count,
                                instead of that of its position */
    core_range *ranges;      /* of sums, of each chunk of faces */
    size_t first, count;     /* of all sums those that are wanted; others' votes are passed over */
    int by_distance;         /* positions that differ may be welded into one */
    /* NULL, or whether a face without a direction counts whose first corner votes in this sum. */
    int (*counts)(const void *context, uint32_t sum);
    const void *context;
} core_voting;

static inline size_t norma_core_count_chunks(const core_mesh *mesh) {
    return mesh->face_count / CORE_FACES_IN_CHUNK + (mesh->face_count % CORE_FACES_IN_CHUNK != 0);
}

/* Sets the ranges. */
norma_result norma_core_find_ranges(const core_voting *voting);

/* Takes count sums from first on. What it counts is added to tally. */
typedef void core_sums_receiver(
    void *context, const core_vertex_sum *sums, size_t first, size_t count, core_tally *tally);

/* Where faces in a row touch sums near each other: bin by bin (a range of sums with the faces that
 * touch it), each told of when it is taken. *taken: whether it could; else nothing is done. sums:
 * room for count, or NULL: as much as it needs is allocated. Degenerate faces are added to tally.
 */
norma_result norma_core_sum_bins(const core_voting *voting, core_vertex_sum *sums,
    core_sums_receiver *receive, void *context, core_tally *tally, int *taken);
/* All count sums, kept. */
norma_result norma_core_sum_all(
    const core_voting *voting, core_vertex_sum *sums, core_tally *tally);

/* ---- weighted sums of vectors that do not depend on the order in which they are added, nor on how
 * they are grouped: for one surface in many files. Each number is cut into digits of 32 bits at
 * fixed places, and the digits of a place are added as integers. A sum keeps three places, from
 * that of the largest weight on; what lies below is cut off each number, also of those that were
 * added before (their lowest digits are dropped). So the sum follows from the set of what was
 * added. It errs by less than 2^-64 of the largest weight for each of them. (Demmel, Nguyen 2013,
 * "Fast reproducible floating-point summation", with integers.) */

enum { OPEN_SUM_PLACES = 3 };

/* Zeroed, it has no votes. Up to 2^31 may be added. */
typedef struct open_sum {
    int64_t digits[4][OPEN_SUM_PLACES]; /* of x, y, z and the weight; the lowest place first */
    int32_t top;                        /* the highest place: its digits count 2^(32 top) */
    uint32_t votes;                     /* nonzero: some */
} open_sum;

/* Adds weight * vector, whose length is at most 1. A weight that is not finite is left out. */
void norma_core_open_sum_add(open_sum *sum, double weight, const double vector[3]);
void norma_core_open_sum_join(open_sum *sum, const open_sum *other);
/* The sum, and the sum of the weights, both times a power of two. */
void norma_core_open_sum_value(const open_sum *sum, double vector[3], double *weight);

/* ---- what the faces of a mesh add at its positions, in sums that depend on no order. */

typedef struct open_voting {
    const core_mesh *mesh; /* checked, welded */
    norma_weight weight;   /* not "visible", which is no sum */
    const uint8_t *silent; /* nonzero: this face does not vote; NULL: all do */
    int reversed;          /* nonzero: the faces' other sides vote */
} open_voting;

/* sums: of each position of the mesh; faces add to those of the positions that corners are welded
 * to. degenerate counts faces without a direction. */
void norma_core_open_votes(const open_voting *voting, open_sum *sums, norma_count *degenerate);
/* The direction of a sum. Returns NORMA_REASON_NONE, UNREFERENCED (no votes) or CANCELLED. */
int norma_core_open_direction(const open_sum *sum, double direction[3]);
#endif
