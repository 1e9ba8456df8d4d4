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

typedef struct vertex_sum {
    double x, y, z, weight;
} vertex_sum; /* weight: -0 as long as nobody votes */

static inline int norma_core_has_votes(const vertex_sum *sum) { return !signbit(sum->weight); }
int norma_core_record_cancels(const vertex_sum *sum);
void norma_core_clear_sums(vertex_sum *sums, size_t count);
void norma_core_add_vote(vertex_sum *sum, double weight, const double normal[3]);

/* One face added by itself: a polygon, or a triangle that doubles do not decide. Corners elsewhere
 * than at the count positions from first on are passed over. The first corner's owner counts the
 * degenerate. */
typedef struct core_face_adder {
    const core_prepared_mesh *prepared;
    vertex_sum *sums;
    uint32_t first, count;
    norma_count *degenerate;
} core_face_adder;
void norma_core_add_face(void *face_adder, size_t face);

/* Returns NORMA_REASON_NONE and the normal, or the reason why it has no normal. */
int norma_core_resolve_record(
    const core_mesh *mesh, const vertex_sum *sum, size_t vertex, float normal[3]);

/* ---- what becomes of each vertex, by sums or by cones, before it is written. */

typedef struct core_vertices {
    core_prepared_mesh *prepared;
    size_t count;         /* vertices */
    vertex_sum *sums;     /* of positions */
    uint32_t *own;        /* NULL where nothing cancels; else of each vertex its number in own_sums,
                             UINT32_MAX: its position's sum stands */
    vertex_sum *own_sums; /* of the corners of one vertex alone */
    size_t own_count;
    float (*normals)[3]; /* of cones, instead of sums: of positions, and of vertices with a result
                            of their own */
    uint8_t *reasons;
} core_vertices;

static inline void norma_core_release_vertices(core_vertices *vertices) {
    const core_call *call = vertices->prepared->call;
    norma_core_release(call, vertices->sums, vertices->count, sizeof *vertices->sums);
    norma_core_release(call, vertices->own, vertices->count, sizeof *vertices->own);
    norma_core_release(call, vertices->own_sums, vertices->own_count, sizeof *vertices->own_sums);
    norma_core_release(call, vertices->normals, vertices->count, sizeof *vertices->normals);
    norma_core_release(call, vertices->reasons, vertices->count, 1);
    *vertices = (core_vertices){.prepared = vertices->prepared};
}

/* vertex_sums.c, vertex_normals.c. What they return but NORMA_OK leaves nothing to release.
 * tally: degenerate faces are added. scattered: faces in a row lie far apart. */
norma_result norma_core_sum_vertices(
    core_prepared_mesh *prepared, int scattered, core_vertices *vertices, core_tally *tally);
norma_result norma_core_cone_vertices(
    core_prepared_mesh *prepared, core_vertices *vertices, core_tally *tally);

/* binned_sums.c: where faces in a row touch positions near each other, and none is welded, range by
 * range of positions, from the corners to the output. *written: whether it could, and all but what
 * takes the nearest normal is written; ranges: of the chunks of faces. */
norma_result norma_core_bin_vertices(core_prepared_mesh *prepared, const core_range *ranges,
    const core_output *output, core_tally *tally, int *written);

int norma_core_resolve_sum(const core_vertices *vertices, size_t vertex, float normal[3]);
int norma_core_resolve_cone(const core_vertices *vertices, size_t vertex, float normal[3]);

/* ---- whether the faces at a position are one smooth fan, followed as they are added to its sum,
 * so that nobody has to sort them: nearly all positions of most meshes are. Each face leads from
 * its next to its previous neighbour of the position. Faces whose ends meet are chained, whatever
 * order they come in, in a few chains at a time. All faces are one fan, every edge between them
 * shared by just two and smooth, where at the end there is one chain, all normals lie within half
 * the crease and 30 degrees of one axis, and the angles add up to what one turn can hold. For then,
 * seen along that axis, each face turns the same way round the position by less than pi, and by cos
 * 30 to 1 / cos 30 times its own angle: a closed chain turns by a multiple of 2 pi, which is 2 pi
 * where its angles add up to less than 4 pi cos 30, and an open one by less than 2 pi where they
 * add up to less than 2 pi cos 30. So no neighbour is met twice, each edge has one face on either
 * side, none is another's reversed twin, and every dihedral angle is within the crease. A polygon
 * counts for as much where no corner of it bends by more than 10 degrees from its normal: then 40
 * degrees take the place of 30. What fails may still be one fan: stars are made of it. */

enum { CORE_CHAINS = 3 };

typedef struct face_chains {
    float axis[3]; /* the first face's normal; NaN: stars are needed */
    int wide;      /* some normal is too far from it; another axis may do */
    uint32_t first[CORE_CHAINS], last[CORE_CHAINS]; /* where each begins and ends */
} face_chains;

static const uint32_t CORE_NO_CHAIN = UINT32_MAX; /* as first; of the first chain: no face */

/* The least cosine between normals and the axis for a crease; above 1: none will do. Floats lose
 * less of a cosine than is added here. */
static inline float norma_core_chain_cosine(double crease_angle_rad) {
    const double thirty = NORMA_PI / 6, half = 0.5 * crease_angle_rad;
    return (float)(cos(half < thirty ? half : thirty) + 1e-5);
}

CORE_INLINE void core_clear_chains(face_chains *c) {
    *c = (face_chains){.axis = {0, 0, 0}, .first = {CORE_NO_CHAIN, CORE_NO_CHAIN, CORE_NO_CHAIN}};
}

CORE_INLINE void core_break_chains(face_chains *c) {
    c->axis[0] = NAN;
    c->first[0] = 0;
}

CORE_INLINE int core_is_broken(const face_chains *c) { return !(c->axis[0] == c->axis[0]); }
CORE_INLINE int core_has_faces(const face_chains *c) { return c->first[0] != CORE_NO_CHAIN; }

/* Appends chain j to chain i, if it goes on where that ends. */
static inline int norma_core_append_chain(face_chains *c, int i, int j) {
    if (c->first[i] == CORE_NO_CHAIN || c->first[j] != c->last[i]) return 0;
    c->last[i] = c->last[j];
    c->first[j] = CORE_NO_CHAIN;
    return 1;
}

/* Into lower ones, so that all end in the first. */
static inline void norma_core_join_chains(face_chains *c) {
    for (int i = 0; i < CORE_CHAINS; i++)
        for (int j = i + 1; j < CORE_CHAINS; j++) {
            if (c->first[j] == CORE_NO_CHAIN) continue;
            if (!norma_core_append_chain(c, i, j) && norma_core_append_chain(c, j, i)) {
                c->first[i] = c->first[j];
                c->last[i] = c->last[j];
                c->first[j] = CORE_NO_CHAIN;
            } else if (c->first[j] != CORE_NO_CHAIN) {
                continue;
            }
            j = i; /* its ends are others now */
        }
}

/* A face that neither end of the first chain meets. */
static inline void norma_core_chain_apart(face_chains *c, uint32_t next, uint32_t previous) {
    for (int i = 1; i < CORE_CHAINS; i++) {
        const int is_there = c->first[i] != CORE_NO_CHAIN;
        if (is_there && c->last[i] == next) {
            c->last[i] = previous;
            return;
        }
        if (is_there && c->first[i] == previous) {
            c->first[i] = next;
            return;
        }
    }
    norma_core_join_chains(c);
    for (int i = 1; i < CORE_CHAINS; i++) {
        if (c->first[i] != CORE_NO_CHAIN) continue;
        c->first[i] = next;
        c->last[i] = previous;
        return;
    }
    core_break_chains(c);
}

/* One more face, of this normal. */
CORE_INLINE void core_follow_chains(
    face_chains *c, const float normal[3], float cosine, uint32_t next, uint32_t previous) {
    if (!core_has_faces(c)) {
        for (int k = 0; k < 3; k++) c->axis[k] = normal[k];
        c->first[0] = next;
        c->last[0] = previous;
        return;
    }
    const float along = c->axis[0] * normal[0] + c->axis[1] * normal[1] + c->axis[2] * normal[2];
    const int ends = c->last[0] == next, begins = c->first[0] == previous;
    c->wide |= !(along >= cosine);
    c->last[0] = ends ? previous : c->last[0];
    c->first[0] = (begins & !ends) ? next : c->first[0];
    if (!(ends | begins)) norma_core_chain_apart(c, next, previous);
}

static inline int norma_core_is_one_chain(const face_chains *c) {
    uint32_t others = CORE_NO_CHAIN;
    for (int i = 1; i < CORE_CHAINS; i++) others &= c->first[i];
    return others == CORE_NO_CHAIN;
}

/* Whether all faces are one chain that turns less than twice (an open one: less than once), if
 * their angles add up to this and their normals are near one axis. The limits are below 4 pi cos
 * 40, or 9.62, and 2 pi cos 30 and cos 40, or 5.44 and 4.81. */
static inline int norma_core_is_one_turn(face_chains *c, double angles, int polygons) {
    if (!core_has_faces(c) || core_is_broken(c)) return 0;
    if (!norma_core_is_one_chain(c)) norma_core_join_chains(c);
    if (!norma_core_is_one_chain(c)) return 0;
    return angles < (c->first[0] == c->last[0] ? 9 : polygons ? 4.8 : 5.4);
}

/* ---- the loops that most of the time of norma_vertex_normals goes to: triangles added to the sums
 * of positions, at once or by way of queues, and sums made normals. */

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

/* ---- faces of any number of corners added to the sums of their positions. */

core_add_faces *norma_core_choose_add_polygons(norma_isa isa);

/* ---- work on ranges of positions, each with all faces that touch it, where faces in a row touch
 * positions near each other. What is kept of a range's positions lies in memory that stays in the
 * cache from one range to the next. A chunk of faces that touches two ranges is measured for both.
 */

typedef struct core_bins {
    const core_mesh *mesh;
    const core_range *ranges; /* of positions, of each chunk of faces */
    size_t chunks;
    size_t count, size; /* bins; positions in each but the last */
    size_t buffers;     /* at most so many are worked on at once */
    size_t step;        /* each task takes every step-th bin */
} core_bins;

static inline size_t norma_core_count_chunks(const core_mesh *mesh) {
    return mesh->face_count / CORE_FACES_IN_CHUNK + (mesh->face_count % CORE_FACES_IN_CHUNK != 0);
}

typedef struct core_bin_limits { /* of positions */
    size_t in_one, in_all;       /* in one buffer; in all together, where there are several */
} core_bin_limits;

/* 0: the mesh is in no such order, and bins are not worth it. */
int norma_core_plan_bins(const core_call *call, const core_mesh *mesh, const core_range *ranges,
    core_bin_limits limits, core_bins *bins);

typedef struct core_bin {
    size_t number, buffer; /* buffer: below bins->buffers, nobody else's */
    uint32_t first, count; /* positions */
} core_bin;
typedef void core_bin_work(void *context, const core_bin *bin);
/* All bins; MEMORY never, CANCELLED: some were left out. */
norma_result norma_core_each_bin(
    core_call *call, const core_bins *bins, core_bin_work *work, void *context);

/* The next chunk, from this one on, that touches the bin; bins->chunks: none. */
static inline size_t norma_core_chunk_of_bin(
    const core_bins *bins, const core_bin *bin, size_t chunk) {
    const uint32_t last = bin->first + (bin->count - 1);
    while (chunk < bins->chunks &&
           (bins->ranges[chunk].least > last || bins->ranges[chunk].most < bin->first))
        chunk++;
    return chunk;
}
static inline int norma_core_bin_owns(const core_bins *bins, const core_bin *bin, size_t chunk) {
    return bins->ranges[chunk].least >= bin->first &&
           bins->ranges[chunk].most - bin->first < bin->count;
}
static inline size_t norma_core_chunk_end(const core_bins *bins, size_t chunk) {
    const size_t begin = chunk * CORE_FACES_IN_CHUNK, faces = bins->mesh->face_count;
    return faces - begin < CORE_FACES_IN_CHUNK ? faces : begin + CORE_FACES_IN_CHUNK;
}

/* Adds all faces that touch the bin. */
void norma_core_add_to_bin(
    const core_bins *bins, const core_bin *bin, core_add_faces *add, core_adder *adder);

/* ---- the sums of large meshes of triangles in no order, by several at once. */

/* mesh: the surface's, its positions perhaps copied. sums: of all its positions. *done: 0, and
 * nothing is touched, if there are too few faces for the memory that this takes (not quite 2 bytes
 * for each), or no memory. */
norma_result norma_core_queue_vertices(const core_prepared_mesh *prepared, const core_mesh *mesh,
    vertex_sum *sums, norma_count *degenerate, int *done);

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
