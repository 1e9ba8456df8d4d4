/* mesh.h: the checked input: its faces' corners, welding, the corners at each position, and the
 * nearest of some points. */
#ifndef NORMA_CORE_MESH_MESH_H
#define NORMA_CORE_MESH_MESH_H
#include "core/call/call.h"

/* ---- the caller's mesh, checked, and read corner by corner (mesh.c). Corners and positions are
 * numbered in 32 bits. */

typedef struct core_mesh {
    norma_vec3_view positions; /* its stride is never 0 */
    const void *corners;
    size_t corner_count, corner_size; /* size 0: corner c is at position c */
    const uint32_t *face_starts;      /* NULL: triangles */
    size_t face_count;
    const uint32_t *smoothing_groups;
    const uint8_t *hard_edges;
    double
        scale; /* exact power of two that brings double positions near 1; 1 for all other formats */
    const uint32_t *weld;  /* NULL, or for each position the least of those that it is one with */
    const uint8_t *reflex; /* NULL, or of each corner of large polygons whether it is reflex */
} core_mesh;

/* ARGUMENT or OVERFLOW: what of it can be told without reading the arrays. */
norma_result norma_core_mesh_shape(const norma_mesh *mesh, core_mesh *checked);
/* The same for who asks what is wrong, and of the offsets alone. fault may be NULL. */
norma_result norma_core_check_shape(const norma_mesh *mesh, core_mesh *checked, norma_fault *fault);
norma_result norma_core_check_face_starts(const core_mesh *mesh, norma_fault *fault);
/* ARGUMENT (face_starts) or INDEX or CANCELLED: reads the arrays. */
norma_result norma_core_mesh_content(core_call *call, core_mesh *mesh);

/* norma_core_mesh_content; and of each CORE_FACES_IN_CHUNK faces in a row, the least and the
 * greatest position that their corners name. */
enum { CORE_FACES_IN_CHUNK = 1024 };
typedef struct core_range {
    uint32_t least, most;
} core_range;
norma_result norma_core_mesh_ranges(core_call *call, core_mesh *mesh, core_range *ranges);

/* Of positions in doubles: the largest coordinate of those that are finite, 0 without any; and the
 * scale for it. */
double norma_core_largest_coordinate(const core_mesh *mesh);
double norma_core_scale_for(double largest);

/* For norma_core_corner and norma_core_position below: out of line, so that these stay short. */
uint32_t norma_core_small_corner(const core_mesh *mesh, size_t corner);
void norma_core_other_position(const core_mesh *mesh, uint32_t index, double out[3]);

/* Of count corners in a row. */
void norma_core_read_corners(
    const core_mesh *mesh, size_t begin, size_t count, uint32_t *positions);

static inline uint32_t norma_core_corner(const core_mesh *mesh, size_t corner) {
    uint32_t index;
    if (mesh->corner_size != 4) return norma_core_small_corner(mesh, corner);
    memcpy(&index, (const unsigned char *)mesh->corners + 4 * corner, sizeof index);
    return index;
}

static inline void norma_core_double_position(
    const core_mesh *mesh, uint32_t index, double out[3]) {
    const unsigned char *at =
        (const unsigned char *)mesh->positions.data + index * mesh->positions.stride;
    for (size_t i = 0; i < 3; ++i) {
        double p;
        memcpy(&p, at + i * sizeof p, sizeof p);
        out[i] = p * mesh->scale;
    }
}

static inline void norma_core_position(const core_mesh *mesh, uint32_t index, double out[3]) {
    if (mesh->positions.format != NORMA_FORMAT_FLOAT) {
        norma_core_other_position(mesh, index, out);
        return;
    }
    const unsigned char *at =
        (const unsigned char *)mesh->positions.data + index * mesh->positions.stride;
    for (size_t i = 0; i < 3; ++i) {
        float p;
        memcpy(&p, at + i * sizeof p, sizeof p); /* one by one: no detour through memory */
        out[i] = (double)p;
    }
}

static inline uint32_t norma_core_welded(const core_mesh *mesh, uint32_t index) {
    return mesh->weld ? mesh->weld[index] : index;
}

static inline uint32_t norma_core_welded_corner(const core_mesh *mesh, size_t corner) {
    return norma_core_welded(mesh, norma_core_corner(mesh, corner));
}

static inline const uint32_t *norma_core_face_starts(const core_mesh *mesh) {
    return CORE_IS_SMALL ? NULL : mesh->face_starts;
}
static inline size_t norma_core_face_begin(const core_mesh *mesh, size_t face) {
    return norma_core_face_starts(mesh) ? norma_core_face_starts(mesh)[face] : 3 * face;
}
static inline size_t norma_core_face_end(const core_mesh *mesh, size_t face) {
    return norma_core_face_starts(mesh) ? norma_core_face_starts(mesh)[face + 1] : 3 * face + 3;
}

/* ---- from corner to corner within a face. Corners in a row at one (welded) position count as one:
 * the last of them is kept. */

static inline size_t norma_core_next_in_face(const core_mesh *mesh, size_t face, size_t corner) {
    return corner + 1 < norma_core_face_end(mesh, face) ? corner + 1
                                                        : norma_core_face_begin(mesh, face);
}
static inline size_t norma_core_previous_in_face(
    const core_mesh *mesh, size_t face, size_t corner) {
    return corner > norma_core_face_begin(mesh, face) ? corner - 1
                                                      : norma_core_face_end(mesh, face) - 1;
}
static inline int norma_core_is_kept(const core_mesh *mesh, size_t face, size_t corner) {
    return norma_core_welded_corner(mesh, corner) !=
           norma_core_welded_corner(mesh, norma_core_next_in_face(mesh, face, corner));
}

/* From a kept corner of a face with edges to the next one and the previous one that is kept. */
static inline size_t norma_core_next_kept(const core_mesh *mesh, size_t face, size_t corner) {
    do corner = norma_core_next_in_face(mesh, face, corner);
    while (!norma_core_is_kept(mesh, face, corner));
    return corner;
}
static inline size_t norma_core_previous_kept(const core_mesh *mesh, size_t face, size_t corner) {
    do corner = norma_core_previous_in_face(mesh, face, corner);
    while (!norma_core_is_kept(mesh, face, corner));
    return corner;
}

/* ---- which of many keys are one, for whatever the caller calls a key (weld.c). */

typedef struct weld_keys {
    size_t count;
    const void *context;
    /* Of count keys in a row; 0 for a key that is equal to nothing. */
    void (*hash)(const void *context, size_t first, size_t count, uint64_t *hashes);
    int (*same)(const void *context, uint32_t one, uint32_t other);
} weld_keys;

/* A sum of products by odd numbers to a hash of which the highest bits depend on every bit of the
 * key; never 0. */
static inline uint64_t norma_core_weld_mix(uint64_t sum) {
    const uint64_t hash = (sum ^ (sum >> 32)) * UINT64_C(0xd6e8feb86659fd93);
    return hash ? hash : 1;
}

/* weld: for each key the least that it is one with. *found: how many keys are one with an earlier
 * one. MEMORY or CANCELLED leave weld undefined. */
norma_result norma_core_weld_keys(
    core_call *call, const weld_keys *keys, uint32_t *weld, size_t *found);

/* ---- which positions are one (weld.c). */

/* Sets mesh->weld as the options ask: NULL for NORMA_WELD_NONE and where no two positions are one,
 * else for each position the least index of those that are one with it. NaN is equal to nothing.
 * MEMORY or CANCELLED leave it NULL. Release with norma_core_unweld. */
norma_result norma_core_weld(core_call *call, core_mesh *mesh);
void norma_core_unweld(const core_call *call, core_mesh *mesh);

/* ---- the corners around each position (mesh.c). */

typedef struct core_corners_of_position {
    uint32_t *starts;  /* position_count + 1 offsets into corners */
    uint32_t *corners; /* by (welded) position, ascending */
    uint32_t *faces;   /* of each corner; NULL for triangles */
    size_t position_count, corner_count;
    size_t most; /* corners at one position */
} core_corners_of_position;

/* Two counting passes, O(positions + corners). MEMORY or CANCELLED leave nothing to release. */
norma_result norma_core_corners_of_position_build(
    core_call *call, const core_mesh *mesh, core_corners_of_position *corners_of);
void norma_core_corners_of_position_release(
    const core_call *call, core_corners_of_position *corners_of);

static inline size_t norma_core_face_of(const core_corners_of_position *corners_of, size_t corner) {
    return corners_of->faces ? corners_of->faces[corner] : corner / 3;
}

/* mesh.c: whether faces in a row touch positions all over the mesh; its indices are checked.
 * Looks at some of them. */
int norma_core_is_scattered(const core_mesh *mesh);

/* ---- nearest.c: a balanced tree over positions (Bentley 1975), for the two questions about
 * distance: what is nearest, and what lies within a step. */

typedef struct core_box {
    double low[3], high[3];
} core_box;

typedef struct core_kdtree {
    const core_mesh *mesh;
    const uint32_t *rank; /* among equally near sites, that of the least rank[site] is nearest;
                             NULL: the least site */
    uint32_t *sites;      /* positions, in the order of the leaves */
    size_t count;
    core_box *boxes; /* of each node; node i has the children 2 i + 1 and 2 i + 2, which halve its
                        range of sites */
    size_t box_count;
} core_kdtree;

/* LEAF: sites of a branch that is not divided. MANY: those of one before which the caller is asked
 * whether to go on. */
enum { KDTREE_LEAF = 8, KDTREE_MANY = 1 << 13 };

/* Takes sites over as they are (finite positions; the caller releases them after the tree), and
 * orders them. MEMORY where the boxes find no room; where that or CANCELLED is returned, there is
 * nothing to release. */
norma_result norma_core_kdtree_build(core_call *call, const core_mesh *mesh, const uint32_t *rank,
    uint32_t *sites, size_t count, core_kdtree *tree);
void norma_core_kdtree_release(const core_call *call, core_kdtree *tree);

/* The site nearest to point (Euclid). The tree is not empty. */
uint32_t norma_core_kdtree_nearest(const core_kdtree *tree, const double point[3]);

/* Least and greatest squared distance between points of two boxes. */
double norma_core_box_least(const core_box *a, const core_box *b);
double norma_core_box_greatest(const core_box *a, const core_box *b);

/* ---- the nearest element that has a normal, for those that have none (nearest.c). */

typedef struct core_nearest {
    core_call *call;
    const core_mesh *mesh;
    uint32_t *first_at; /* of each position, the first element there that has a normal; UINT32_MAX:
                           none */
    uint32_t *found_at; /* of each (welded) position that was asked for, the answer; UINT32_MAX: not
                           asked yet */
    uint32_t *sites;    /* positions that have one */
    size_t site_count;
    uint32_t first; /* of all elements */
    int planted;
    core_kdtree tree;
} core_nearest;

/* Between begin and plant the caller tells of elements in ascending order. queries: about how many
 * will be asked. */
norma_result norma_core_nearest_begin(
    core_call *call, const core_mesh *mesh, core_nearest *nearest);
void norma_core_nearest_add(core_nearest *nearest, uint32_t position, uint32_t element);
norma_result norma_core_nearest_plant(core_nearest *nearest, size_t queries);
void norma_core_nearest_end(core_nearest *nearest);

/* For an element at position that has none: the first at its own position, else at the nearest,
 * ties the lower; UINT32_MAX: no element has a normal. Each position is looked up once, however
 * many ask. */
uint32_t norma_core_nearest_find(core_nearest *nearest, uint32_t position);

/* Elements that can be asked for what they have. */
typedef struct core_elements {
    const core_mesh *mesh;
    size_t count;
    const void *context;
    /* Returns NORMA_REASON_NONE and the normal, or why there is none. */
    int (*normal)(const void *context, size_t element, float normal[3]);
    /* Where it lies; UINT32_MAX: nowhere, and it gets the first of all normals. NULL: element
     * number i at position i. */
    uint32_t (*position)(const void *context, size_t element);
} core_elements;
/* Writes, for each that has none, the nearest normal; zeros where there is none at all. */
norma_result norma_core_fill_nearest(
    core_call *call, const core_elements *of, const core_output *output, size_t queries);
#endif
