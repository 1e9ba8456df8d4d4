/* corner.h: creases; a mesh made ready for stars; stars, their edges and fans, one by one and all
 * of them. */
#ifndef NORMA_CORE_CORNER_CORNER_H
#define NORMA_CORE_CORNER_CORNER_H
#include "core/mesh/mesh.h"
#include "core/call/call.h"
#include "core/face/face.h"
#include <stddef.h>
#include <stdatomic.h>

/* ---- the crease rule (star_fans.c): a shared edge is smooth where the dihedral angle is at most
 * the crease, no side marks the edge hard, and where smoothing groups are given the two faces have
 * one in common. Most angles are decided by their cosine, which the loops of star_kernel.c compare
 * for many edges; the angle itself is taken only where the cosine is too near the crease's. */

typedef struct core_crease {
    double angle;  /* the greatest dihedral angle that is smooth, the tolerance in it; beyond pi:
                      every angle */
    double cosine; /* about its cosine; 2 where no angle is smooth, -2 where all are */
} core_crease;

/* ARGUMENT where it is NaN, infinite or above pi, as degrees would be; fault may be NULL. */
norma_result norma_core_check_crease(float crease_angle_rad, norma_fault *fault);
core_crease norma_core_crease_at(double crease_angle_rad);

/* cosine: of the dihedral angle, the dot product of the two unit normals. Its doubt is beyond the
 * rounding of both. Neither: the angle has to be taken. */
static const double CORE_COSINE_DOUBT = 0x1p-30;
static inline int norma_core_is_surely_smooth(const core_crease *crease, double cosine) {
    return cosine > crease->cosine + CORE_COSINE_DOUBT;
}
static inline int norma_core_is_surely_hard(const core_crease *crease, double cosine) {
    return cosine < crease->cosine - CORE_COSINE_DOUBT;
}
/* Whether the caller's marks leave the edge smooth. It begins at corner in one face, and at
 * other_corner in the face that runs along it the other way. */
static inline int norma_core_is_unmarked(const core_mesh *mesh, uint32_t corner, uint32_t face,
    uint32_t other_corner, uint32_t other_face) {
    if (CORE_IS_SMALL) return 1;
    if (mesh->hard_edges && (mesh->hard_edges[corner] || mesh->hard_edges[other_corner])) return 0;
    return !mesh->smoothing_groups ||
           (mesh->smoothing_groups[face] & mesh->smoothing_groups[other_face]);
}

/* ---- the smallest cone round unit vectors (normal_cone.c): O(count) for each of the few vectors
 * that widen it. Returns 0 where no open hemisphere holds them. */

int norma_core_smallest_cone(const double (*normals)[3], size_t count, double axis[3]);

/* Normal index of count; 0 where that one is left out. The same each time it is asked for. */
typedef int norma_core_cone_at(const void *context, size_t index, double normal[3]);

/* Of normals that are not kept in an array: the same bits. */
int norma_core_smallest_cone_of(
    norma_core_cone_at *at, const void *context, size_t count, double axis[3]);

/* ---- an indexed mesh out of values per corner, for calls that make some of them
 * (index_corners.c). */

norma_result norma_core_check_indexed(const norma_indexed *indexed);

/* Of checked streams. CAPACITY, OVERFLOW, MEMORY and CANCELLED leave everything as it was. */
norma_result norma_core_index_corners(core_call *call, const norma_stream *streams,
    size_t stream_count, size_t corner_count, norma_indexed *to);

/* ---- a mesh made ready for normals at its positions: checked, welded, its corners sorted by
 * position, its polygons measured (star.c). */

typedef struct core_prepared_mesh {
    core_call *call;
    core_mesh mesh;
    core_corners_of_position corners_of;
    core_face *faces; /* of each face of a mesh of polygons, for stars; NULL for triangles and sums,
                         whose faces are measured where they are met */
    uint32_t *borrowed_from; /* NULL where no face needs one; else of each face without a direction
                         the face whose direction it borrows, UINT32_MAX: none */
    atomic_uchar *flat_at;   /* NULL, or nonzero at the positions of faces that have edges but no
                                direction; of triangles, of those that have been met */
    norma_count degenerate_faces; /* of polygons, for sums only those without corners; others are
                                     counted where they are met */
    core_crease crease;           /* may be changed: nothing else here hangs on it */
} core_prepared_mesh;

typedef enum core_use {
    CORE_FOR_SUMS = 0,
    CORE_FOR_STARS,
    CORE_FOR_FANS
} core_use; /* sums need no corners sorted; fans are stars cut at edges */

static inline const core_face *norma_core_kept_faces(const core_prepared_mesh *prepared) {
    return CORE_IS_SMALL ? NULL : prepared->faces;
}
/* The beginning of a call that cuts fans: options, crease and the mesh's shape are checked. */
norma_result norma_core_begin_with_crease(core_call *call, const norma_options *options,
    const norma_mesh *mesh, float crease_angle_rad, core_mesh *checked);
/* Then its content is checked, and it is opened for fans. */
norma_result norma_core_prepare_fans(
    core_call *call, core_mesh *checked, float crease_angle_rad, core_prepared_mesh *prepared);
/* call stays the caller's. What it returns but NORMA_OK leaves nothing to release. */
norma_result norma_core_prepared_mesh_open(core_call *call, core_mesh *checked, core_use use,
    double crease_angle_rad, core_prepared_mesh *prepared);
/* From here on, stars that meet a triangle without a direction mark its positions. */
norma_result norma_core_watch_for_flat(core_prepared_mesh *prepared);
static inline void norma_core_mark_flat(const core_prepared_mesh *prepared, uint32_t position) {
    atomic_store_explicit(&prepared->flat_at[position], 1, memory_order_relaxed);
}
/* Once all stars have been made that can be: finds whose directions such triangles borrow. */
norma_result norma_core_borrow_directions(core_prepared_mesh *prepared);
void norma_core_prepared_mesh_close(core_prepared_mesh *prepared);

static inline void norma_core_prepared_mesh_face(
    const core_prepared_mesh *prepared, size_t face, core_face *out) {
    if (norma_core_kept_faces(prepared))
        *out = prepared->faces[face];
    else
        norma_core_face_geometry(&prepared->mesh, face, out);
}

/* ---- the corners around one position (star.c), joined into fans by the smooth edges between their
 * faces (star_fans.c), and the sum of each fan. */

enum {
    STAR_VOTES = 1,
    STAR_KEPT = 2,
    STAR_HAS_NORMAL = 4,
    STAR_FLAT = 8
}; /* flat: finite, with edges, without a direction of its own */

typedef struct star_corner {
    double normal[3];                /* of its face, its own or borrowed; with STAR_HAS_NORMAL */
    double weight;                   /* with STAR_VOTES */
    uint64_t next_key, previous_key; /* by norma_core_twin_key, of its face at the edge to next,
                                        from previous */
    uint32_t corner, face;
    uint32_t next, previous;  /* welded positions of its kept neighbours; with STAR_KEPT */
    uint32_t previous_corner; /* where the edge from previous begins */
    uint8_t flags;
} star_corner;

typedef struct star_edge { /* a face runs along the edge from the star's position to the other one,
                              or back */
    uint64_t key;
    uint32_t other, back;
    uint32_t corner; /* star number */
} star_edge;

typedef struct star_sum {
    double sum[3], weight;
    size_t votes;
} star_sum;

typedef struct core_fan {
    float normal[3]; /* with NORMA_REASON_NONE */
    uint32_t reason; /* NORMA_REASON_NONE, UNREFERENCED, CANCELLED or NON_FINITE */
} core_fan;

typedef struct core_star {
    star_corner *corners;
    star_edge *edges, *sorted; /* two for each corner */
    star_sum *sums;            /* these two of each fan */
    core_fan *fans;
    uint32_t *joined; /* of each corner, a star number of the same fan, lower or its own; once fans
                         are joined the lowest */
    uint32_t
        *fan_of; /* of each corner, the number of its fan, in the order of their first corners */
    double (*normals)[3]; /* scratch of the visible weight */
    size_t count, edge_count, fan_count;
    uint32_t position;
    int finite; /* the position itself */
    int waits;  /* a face here must borrow a direction, and nobody has looked yet whose */
    norma_count degenerate; /* triangles without a direction whose first corner is here */
} core_star;

enum { STAR_ROOM = 64 };
typedef struct star_room { /* what a star of ordinary size needs, for the stack */
    star_corner corners[STAR_ROOM];
    star_edge edges[2 * STAR_ROOM], sorted[2 * STAR_ROOM];
    star_sum sums[STAR_ROOM];
    core_fan fans[STAR_ROOM];
    uint32_t joined[STAR_ROOM], fan_of[STAR_ROOM];
    double normals[STAR_ROOM][3];
} star_room;

typedef struct star_counts {
    norma_count non_manifold, conflicts;
    norma_edges edges;
} star_counts;

void norma_core_star_in_room(core_star *star, star_room *room);
norma_result norma_core_star_allocate(const core_call *call, core_star *star, size_t corners);
void norma_core_star_release(const core_call *call, core_star *star, size_t corners);

/* Of a position, no corners yet. */
void norma_core_star_begin(const core_prepared_mesh *prepared, uint32_t position, core_star *star);
/* Fills the star with some of the corners at its position, ascending, whatever it held before;
 * weights only where asked, since joining needs none. */
void norma_core_star_fill(const core_prepared_mesh *prepared, const uint32_t *corners, size_t count,
    int with_weights, core_star *star);
/* Begins the star, and fills it with all corners at the position. */
void norma_core_star_load(
    const core_prepared_mesh *prepared, uint32_t position, int with_weights, core_star *star);
/* All its corners become one fan. */
void norma_core_star_join_all(core_star *star);
/* Fans by smooth edges. counts: NULL, or edges to positions of higher number are added. */
void norma_core_star_join_fans(
    const core_prepared_mesh *prepared, core_star *star, star_counts *counts);
/* The same by those edges alone that are listed in the star, sorted, for stars of very many
 * corners: the caller makes joined the lowest of each fan. */
void norma_core_star_join_listed(
    const core_prepared_mesh *prepared, core_star *star, star_counts *counts);
/* Adds a corner's vote, if it has one. */
void norma_core_star_vote(const star_corner *corner, star_sum *sum);
/* Sums each fan in ascending order of corners, and gives it a normal or the reason why it has none.
 */
void norma_core_star_sum(const core_prepared_mesh *prepared, core_star *star);
/* The normal of a fan of voters, or that they cancel. */
void norma_core_decide_sum(const double sum[3], double weight, core_fan *fan);
/* The most visible normal of some corners alone, given as star numbers. */
void norma_core_star_see_some(
    core_star *star, const uint32_t *members, size_t count, core_fan *fan);

/* For flat faces whose longest edge runs between this position and one of higher number: who lends
 * them a direction. longest: by face, UINT32_MAX where nobody has asked yet. */
void norma_core_star_borrow_directions(const core_prepared_mesh *prepared, core_star *star,
    uint32_t *longest, uint32_t *borrowed_from);

/* Sorts the star's edges, which are listed: by the position at the other end, direction, key. */
void norma_core_sort_edges(core_star *star);

/* ---- the corners of a star, sorted by vertex and by the bits of their normals. */

typedef struct star_member {
    uint32_t vertex;
    uint32_t bits[3]; /* of the normal; zero where it does not matter */
    uint32_t index;   /* star number, ascending as corners are */
} star_member;

/* The room of a star's edges, which nobody needs once its fans are joined, holds its members. */
static inline star_member *norma_core_star_members(core_star *star) {
    return (star_member *)(void *)star->edges;
}
/* The same of the copy that sorting edges took: room for a number of each corner. */
static inline uint32_t *norma_core_star_numbers(core_star *star) {
    return (uint32_t *)(void *)star->sorted;
}

static inline int norma_core_same_normal(const star_member *a, const star_member *b) {
    return a->vertex == b->vertex && a->bits[0] == b->bits[0] && a->bits[1] == b->bits[1] &&
           a->bits[2] == b->bits[2];
}

/* By vertex, bits, index; O(n log n). */
void norma_core_sort_corners(star_member *members, size_t count);

/* ---- every star of a prepared mesh, visited in parallel (corner_normals.c). */

typedef enum core_join { CORE_JOIN_ALL = 0, CORE_JOIN_FANS } core_join;
typedef struct stars_part { /* what some visits add up to; waiting: stars not made yet */
    core_tally tally;
    star_counts counts;
    size_t waiting;
} stars_part;

/* What becomes of the corners at one position. */
typedef struct core_fans {
    uint32_t position, count, fan_count;
    const uint32_t *corners; /* ascending */
    const uint32_t *fan_of;  /* of each corner, the number of its fan; NULL with by_fan, and one
                                fan */
    const core_fan *fans;
    star_member *members; /* room for one of each corner */
    core_star *star;      /* with CORE_JOIN_ALL */
} core_fans;

/* Sees each position at which there are corners once, its fans joined and summed. What it adds to
 * tally is summed over all. */
typedef void position_visitor(void *context, const core_fans *fans, core_tally *tally);

typedef struct position_visit {
    core_join join;
    int counting; /* whether edges are counted */
    int by_fan;   /* the fans of a large star may be seen one by one, with nothing but their corners
                   */
    const uint8_t *skip; /* NULL, or nonzero at positions that are passed over */
    position_visitor *see;
    void *context;
    const core_output *output; /* NULL, or where see does nothing but write fans that have normals,
                                  which many stars' may then be at once */
} position_visit;

/* Whether a call asks for what edges are counted for. */
static inline int norma_core_counts_edges(const core_call *call, const norma_report *report) {
    return report || call->options.edges;
}

/* sum: what all visits added up to, degenerate faces among it. MEMORY or CANCELLED: some were not
 * made. */
norma_result norma_core_visit_positions(
    core_prepared_mesh *prepared, const position_visit *visit, stars_part *sum);

/* ---- batches of stars that are joined and summed many at a time, as nearly all are
 * (star_kernel.c). To the same bits as one by one, which is how the others are made. Ordinary, and
 * in a batch, are those of up to so many corners, all of whose faces have directions that doubles
 * decide. Where edges are counted, of polygons, and where all partners at an edge share it, also
 * with one face out and one back at most along each edge, and no twins; of polygons, with faces
 * that keep all their corners. */

enum { BATCH_CORNERS = 128, FACES_KEPT = 4096, ORDINARY_CORNERS = 16 };

/* The triangles that a batch of stars needs, measured many at a time, and kept for the batches that
 * follow: among neighbours, each is at three stars not far from each other. Each has the place that
 * its number names, or one of the list's corners, behind those. A corner's key is eight times that
 * place, and which of its triangle's corners it is. Polygons are kept for one list, once for each
 * corner there, their first. */
typedef struct kept_faces {
    /* The unit normal, and 1, or 0 where doubles do not decide it; the weights of the corners. */
    double (*row)[8];
    /* The corners' welded positions, and the first two again: after a corner's come those of its
     * next and its previous. */
    uint32_t (*at)[8];
    uint64_t *held; /* which face, and 2^32 times the last list that needs it */
    void *block;    /* of all three */
    uint32_t room, lists;
    atomic_int taken; /* by one who works */
} kept_faces;

/* For each who works at once. MEMORY leaves nothing to release. */
norma_result norma_core_kept_allocate(
    const core_prepared_mesh *prepared, size_t count, kept_faces **kept);
void norma_core_kept_release(const core_prepared_mesh *prepared, size_t count, kept_faces *kept);

typedef struct listed_star {
    uint32_t position;
    uint16_t begin, count;         /* of its corners among those of the list */
    uint16_t first_fan, fan_count; /* once settled; no fan: it is not ordinary. While settling:
                                      whether it may be */
} listed_star;

typedef struct star_list {
    size_t corner_count, star_count;
    const uint32_t *corners; /* of each star ascending, as its sums run */
    uint32_t least, most;    /* of the corners */
    uint32_t waiting;        /* faces to measure; of polygons, one for each corner */
    uint32_t key[BATCH_CORNERS];
    uint32_t face[BATCH_CORNERS + 1];  /* of each that waits its number */
    uint32_t at[BATCH_CORNERS + 8][3]; /* and its positions, as the mesh names them; of polygons'
                                          corners own, next, previous */
    uint16_t place[BATCH_CORNERS + 8]; /* and where it goes */
    listed_star stars[BATCH_CORNERS];
} star_list;

enum { BATCH_ROOM = BATCH_CORNERS + ORDINARY_CORNERS }; /* the last star is read to its end */

typedef struct fan_batch {
    kept_faces *kept;
    uint32_t next[BATCH_ROOM], previous[BATCH_ROOM]; /* of each corner, the positions in its face */
    /* Of each, as bits, the corners of its star whose faces run back along its edge to next, and
     * out along that from previous. */
    uint32_t back[BATCH_ROOM], out[BATCH_ROOM];
    uint32_t other[BATCH_ROOM];             /* of each the one across its edge to next, or itself */
    uint32_t edge[BATCH_ROOM];              /* flags of that edge (star_kernel.c) */
    _Alignas(64) double row[BATCH_ROOM][4]; /* products of each edge; once it is known which are
                                               cut, of each fan its sum and weight */
    double decided[BATCH_ROOM];             /* of each fan, from here on */
    float direction[3][BATCH_ROOM];
    core_fan fans[BATCH_CORNERS];
    int all_decided;             /* each fan has a normal */
    uint32_t fan_of[BATCH_ROOM]; /* of each corner: its fan in the batch */
} fan_batch;

int norma_core_can_batch(const core_prepared_mesh *prepared);
/* Reads the corners of the faces that are not kept yet; once the list before is settled. */
void norma_core_read_list(const core_prepared_mesh *prepared, fan_batch *batch, star_list *list);
/* Joins and sums the fans of all stars in the list; 0: some are not ordinary. edges
 * may be NULL. */
typedef int fans_simd(
    const core_prepared_mesh *prepared, star_list *list, fan_batch *batch, norma_edges *edges);
fans_simd *norma_core_choose_fans(norma_isa isa);

/* ---- corners without a normal get that of the nearest corner that has one (corner_normals.c).
 */

/* reasons: of each corner. For each corner of which wanted (NULL: each without a normal) is
 * nonzero, take gets the nearest normal; zeros where no corner of the mesh has one. All stars can
 * be made. */
typedef void corner_taker(void *context, uint32_t corner, const float normal[3]);
norma_result norma_core_fill_corners(const core_prepared_mesh *prepared, const uint8_t *reasons,
    const uint8_t *wanted, corner_taker *take, void *context);
#endif
