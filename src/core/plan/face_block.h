/* face_block.h: some hundred neighbouring slots, and all faces that vote in them, numbered anew in
 * 16 bits, so that a tile is measured and summed within the nearest cache, on the stack of whoever
 * does it. Faces on the rim lie in more than one tile and are measured in each; nothing else is
 * shared, and nothing is written but normals. */
#ifndef NORMA_CORE_PLAN_TILE_H
#define NORMA_CORE_PLAN_TILE_H
#include "core/plan/plan.h"
#include "core/face/measure.h"

enum {
    TILE_FACES = 1 << 10,
    TILE_MOST_FACES = TILE_FACES - CORE_LANES,
    TILE_CORNERS = 3 * TILE_FACES,
    TILE_VERTICES = 768,
    TILE_SLOTS = 384,
    TILE_MEMBERS = (1 << 15) - 1 - TILE_CORNERS,
    TILE_RING = 512,     /* corners at one position; with more its slots are wide */
    TILE_FACE_BITS = 10, /* a corner of a tile of triangles is its number in the face, then the
                            face; of others, its place in corners */
    TILE_NOBODY = TILE_FACES - 1, /* a member without a vote, of tiles of triangles: what it adds
                                     changes no bit of a sum */
    TILE_JOINED = 1 << 15 /* in member_starts: the slot is at the position of the one before */
};

/* One tile's lists, all in one block of words. own: vertices at the tile's positions; the others
 * only take part in its faces. */
typedef struct tile_view {
    uint32_t vertex_count, own_count, slot_count, face_count, corner_count, member_count;
    uint32_t first_occurrence, four_count;
    int plain; /* per vertex, each slot has its position, and each position its vertex, to itself */
    const uint32_t
        *vertices;         /* of the mesh; own ones first, per vertex in the order of their slots */
    const uint32_t *faces; /* of the mesh */
    const uint32_t *mesh_corners; /* polygons: of each face its first corner in the mesh */
    const uint32_t *face_starts;  /* polygons: into corners */
    const uint32_t *weld;         /* NULL, or of each vertex the first one at its position */
    const uint16_t
        *corners; /* vertices; triangles: up to a multiple of eight, the last one again */
    const uint16_t *corner_faces;            /* polygons */
    const uint16_t *member_starts, *members; /* of each slot; behind slot_count those of vertices
                                                that are not own, one for each */
    const uint16_t *four_counts,
        *fours; /* of each four slots in a row how many members the longest has, and so many times
                   one of each; NULL: see face_block_build.c */
    const uint16_t *vertex_starts; /* per vertex, of each slot; NULL: slot i serves vertex i */
    const uint16_t *slot_of;       /* of each own vertex its slot, per corner the first one at its
                                      position; NULL: vertex i's is i */
} tile_view;

/* What is kept of a tile beside its block. */
struct plan_tile {
    size_t at; /* first word */
    uint32_t
        first_occurrence; /* occurrences are numbered tile by tile, in each as its vertices are */
    uint32_t four_count;  /* numbers in fours; 0: none */
    uint16_t vertex_count, own_count, slot_count, face_count, corner_count, member_count;
    uint8_t polygons, welded, one_each, plain;
};

tile_view norma_core_tile(const norma_plan *plan, size_t tile);

/* How many eights hold so many: triangles are taken by eights, and slots are finished by eights. */
static inline uint32_t norma_core_tile_eights(uint32_t count) {
    return (count + CORE_LANES - 1) / CORE_LANES;
}

static inline uint32_t norma_core_tile_start(const tile_view *t, size_t slot) {
    return t->member_starts[slot] & (TILE_JOINED - 1U);
}
static inline uint32_t norma_core_tile_face_of(const tile_view *t, uint32_t member) {
    return t->corner_faces ? t->corner_faces[member] : member & (TILE_FACES - 1U);
}
/* The place of a member in corners. */
static inline uint32_t norma_core_tile_corner_of(const tile_view *t, uint32_t member) {
    return t->corner_faces ? member : 3 * (member & (TILE_FACES - 1U)) + (member >> TILE_FACE_BITS);
}
static inline size_t norma_core_tile_mesh_corner(const tile_view *t, uint32_t member) {
    const uint32_t face = norma_core_tile_face_of(t, member);
    if (!t->corner_faces) return 3 * (size_t)t->faces[face] + (member >> TILE_FACE_BITS);
    return (size_t)t->mesh_corners[face] + (member - t->face_starts[face]);
}
/* The code of a corner as a member. */
static inline uint32_t norma_core_tile_member(
    int polygons, uint32_t face, uint32_t number, uint32_t corner) {
    return polygons ? corner : number << TILE_FACE_BITS | face;
}
static inline uint32_t norma_core_tile_slot_of(const tile_view *t, uint32_t own) {
    return t->slot_of ? t->slot_of[own] : own;
}

/* ---- one tile, measured and summed; on the stack */

/* What later tiles will read and this one will write, asked for little by little while this one is
 * measured: asked for all at once it fills the list of what is under way, and every read waits
 * behind it (10 million triangles: 11.5 instead of 9.8 ns). */
typedef struct tile_list {
    const unsigned char *at, *end;
} tile_list;
typedef struct tile_elements {
    const uint32_t *vertices;
    size_t count;
    const unsigned char *data;
    size_t stride;
} tile_elements;
typedef struct tile_ahead {
    tile_list lists[3];
    tile_elements read, written;
} tile_ahead;

typedef struct tile_room {
    _Alignas(64) double positions[TILE_VERTICES][4]; /* of each vertex; the fourth: 0 */
    double normals[TILE_FACES]
                  [4]; /* of each face; the fourth: 1; zero where there is no direction */
    double weights[TILE_CORNERS]; /* of each member's corner; -0: no vote */
    float results[TILE_SLOTS][3]; /* of each slot asked for, in the order asked */
    uint8_t reasons[TILE_SLOTS];
    uint16_t doubted[TILE_FACES];    /* triangles that doubles do not decide */
    uint16_t degenerate[TILE_FACES]; /* faces, finite and without a direction */
    uint32_t doubted_count, degenerate_count;
    tile_ahead ahead;
    int all_finite, all_normal; /* each position; each slot summed has a normal */
} tile_room;

/* As much as eight triangles take of a tile, and a little more. */
static inline void norma_core_ask_ahead(tile_ahead *a) {
    enum { LINE = 64, LINES = 2, VERTICES = 6 };
    for (int k = 0; k < 3; k++)
        for (int i = 0; i < LINES && a->lists[k].at < a->lists[k].end; i++, a->lists[k].at += LINE)
            __builtin_prefetch(a->lists[k].at);
    for (int i = 0; i < VERTICES && a->read.count; i++, a->read.count--)
        __builtin_prefetch(a->read.data + *a->read.vertices++ * a->read.stride);
    for (int i = 0; i < VERTICES && a->written.count; i++, a->written.count--)
        __builtin_prefetch(a->written.data + *a->written.vertices++ * a->written.stride, 1);
}

typedef struct tile_some {
    const uint16_t *numbers;
    uint32_t count;
} tile_some; /* numbers NULL: 0, 1, 2, ... */

typedef struct tile_kernels {
    /* The positions of a tile's vertices, or of those of some eights of triangles (NULL: all),
     * three floats each; whether all are finite. */
    int (*load)(const tile_view *t, const tile_some *eights, const unsigned char *data,
        size_t stride, double (*positions)[4]);
    /* Triangles: normals and weights of some eights; the doubted ones are listed. */
    void (*measure)(const tile_view *t, tile_some eights, norma_weight weight, tile_room *room);
    /* Results and reasons of some slots; whether all have a normal. */
    int (*sum)(const tile_view *t, tile_some slots, tile_room *room);
} tile_kernels;

/* face_block_sums.c: the same bits from each. */
tile_kernels norma_core_tile_kernels(norma_isa isa);
#endif
