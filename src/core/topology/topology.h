/* topology.h: which faces lie side by side, the parts that edges hold together, how these lie in
 * one another, and which way they face. */
#ifndef NORMA_CORE_TOPOLOGY_H
#define NORMA_CORE_TOPOLOGY_H
#include "core/mesh/mesh.h"
#include "core/face/face.h"
#include "core/call/call.h"
#include <stdatomic.h>

/* ---- topology.c: which faces lie side by side: the faces along each edge of (welded) positions,
 * and what is out of the ordinary there. */

/* What is at the other side of the edge that runs from a kept corner to the face's next kept
 * corner. */
#define CORE_EDGE_NONE                                                                             \
    UINT32_MAX /* no edge begins at this corner: it is one with the next, or its face has fewer    \
                  than three left */
#define CORE_EDGE_OPEN     (UINT32_MAX - 1) /* an edge of one face */
#define CORE_EDGE_CONFLICT (UINT32_MAX - 2) /* of exactly two, which run along it the same way */
#define CORE_EDGE_MANY     (UINT32_MAX - 3) /* of more than two */
#define CORE_EDGE_SPECIAL                                                                          \
    (UINT32_MAX - 3) /* from here on; below: the corner at which the other face's edge begins,     \
                        which runs the other way */

typedef struct core_polygon {
    uint64_t key; /* by norma_core_twin_key */
    uint32_t
        anchor; /* the corner at its least position, the first of several; UINT32_MAX: no edges */
    uint32_t kept; /* corners that are left */
} core_polygon;

typedef struct core_topology {
    core_call *call;
    core_mesh mesh; /* its corners are welded positions: the least of those that are one; no weld of
                       its own */
    uint32_t *corners; /* those, owned */
    core_corners_of_position corners_of;
    core_polygon *polygons; /* of each face; NULL for triangles */
    uint32_t *partners;     /* of each corner: see above. NULL before norma_core_pair_edges */
    uint32_t *others; /* at corners with CORE_EDGE_CONFLICT or _MANY, and there only: the corner of
                         the edge's next face, round about */
} core_topology;

typedef struct core_edge_run { /* a face runs along an edge between the star's position and another
                                  one */
    uint64_t key;              /* by norma_core_twin_key */
    uint32_t other;            /* position */
    uint32_t corner;           /* at which the run begins */
    uint32_t slot;             /* of the star */
    uint32_t out;              /* nonzero: from the star's position to the other */
} core_edge_run;

typedef struct core_twin {
    uint64_t key; /* the same for a face and its twins */
    uint32_t face, way;
} core_twin; /* way: 0 or 1; faces of one group with the same way are wound alike */

/* Told of what is not two faces that run opposite ways. Any may be NULL. Called by several threads,
 * each with a block of its own; positions ascend in a block; positions with very many corners come
 * last, in the block numbered norma_core_topology_blocks() - 1. */
typedef struct core_topology_visitor {
    void *context;
    void (*edge)(void *context, size_t block, uint32_t position, const core_edge_run *runs,
        size_t count); /* open, conflict, many; each once, at its lower position */
    void (*bow_tie)(void *context, size_t block, uint32_t position,
        size_t fans); /* two fans or more meet in nothing but the position */
    void (*twins)(void *context, size_t block, const core_twin *twins,
        size_t count); /* faces with the same edges, ascending */
} core_topology_visitor;

/* checked: as norma_core_mesh_content left it. Welds as call's options say. What it returns but
 * NORMA_OK leaves nothing to close. O(positions + corners). */
norma_result norma_core_topology_open(
    core_call *call, const core_mesh *checked, core_topology *topology);
void norma_core_topology_close(core_topology *topology);

/* Into how many blocks a visitor is told. */
size_t norma_core_topology_blocks(const core_topology *topology);
/* Sorts the corners around each position and pairs the edges. O(corners log of the valence). */
norma_result norma_core_pair_edges(core_topology *topology, const core_topology_visitor *visitor);

/* The kept corner behind a kept corner, and the one before it. */
static inline size_t norma_core_topology_next(const core_topology *t, size_t face, size_t corner) {
    return t->polygons       ? norma_core_next_kept(&t->mesh, face, corner)
           : corner % 3 == 2 ? corner - 2
                             : corner + 1;
}
/* Of a corner of any mesh. */
static inline size_t norma_core_topology_face(const core_topology *t, size_t corner) {
    return t->polygons ? t->corners_of.faces[corner] : corner / 3;
}

/* ---- components.c: the parts that edges hold together, which of them are closed, and how they lie
 * in one another (nesting.c). */

enum {
    COMPONENT_OPEN = 1,        /* it has an edge of one face */
    COMPONENT_CONFLICT = 2,    /* an edge of two that run the same way */
    COMPONENT_MANY = 4,        /* an edge of more than two */
    COMPONENT_ONE_SIDED = 8,   /* no winding of its faces agrees with itself (only where conflicts
                                  were followed) */
    COMPONENT_UNBALANCED = 16, /* an edge of more than two along which its own faces do not run as
                                  often one way as the other */
    COMPONENT_UNDECIDED = 32,  /* rays do not say which side of it is outward */
    COMPONENT_REACHES = 64     /* nested, and some of it lies outside its parent: they overlap */
};

typedef enum component_verdict {
    COMPONENT_FINE = 0, /* nothing is wrong, or nothing can be known */
    COMPONENT_INWARD, /* of negative volume that nothing encloses or that lies right inside a cavity
                       */
    COMPONENT_NESTED  /* a solid right inside a solid */
} component_verdict;

typedef struct core_component {
    double low[3], high[3];
    double volume;   /* times six; 0 where it is within rounding. Only of those without flags that
                        matter */
    uint32_t parent; /* the smallest component that it lies in, UINT32_MAX: none. Set by
                        norma_core_judge_nesting */
    uint8_t flags, verdict;
} core_component;

typedef struct core_components {
    uint32_t *of;     /* of each face; UINT32_MAX: it has no edges */
    uint32_t *faces;  /* by component: faces[starts[i]] is the least face of component i */
    uint32_t *starts; /* count + 1 */
    core_component *each;
    uint8_t *reverse; /* NULL, or nonzero: the face is to be taken the other way round */
    size_t count;
    size_t face_count, room; /* of faces; of starts and each */
} core_components;

typedef enum core_joining {
    CORE_JOIN_BODIES = 0, /* an edge joins its faces, and each keeps its winding; one of more than
                             two joins only parts that do not balance there by themselves: closed
                             bodies that touch along it stay two */
    CORE_JOIN_CUT,  /* edges of more than two faces join none; across conflicts one of the two is
                       reversed, so that reverse is made */
    CORE_JOIN_ALIKE /* neither those nor conflicts join; reverse is made, all zero */
} core_joining;

/* In order of their least faces. O(corners). MEMORY leaves nothing to release. topology: its edges
 * are paired. */
norma_result norma_core_find_components(
    const core_topology *topology, core_joining joining, core_components *components);
void norma_core_release_components(const core_call *call, core_components *components);

/* Boxes of all; volumes of those that have none of the flags in not_closed, with reverse where
 * there is one. */
norma_result norma_core_measure_components(
    const core_topology *topology, core_components *components, uint8_t not_closed);

/* nesting.c: parent and verdict of each component without the flags, from outside in: one that is
 * found inward counts as put right for those in it. */
norma_result norma_core_judge_nesting(
    const core_topology *topology, core_components *components, uint8_t not_closed);

/* ---- Trees: sets that are halved along the widest side of their centres, again and again; over
 * boxes: which of them hold a point, which a ray meets; groups of faces seen from afar. */

typedef struct core_tree_item {
    double centre[3]; /* NaN counts as 0 */
    uint32_t number;
} core_tree_item;

typedef struct core_tree_part {
    uint32_t begin, count; /* of items */
    uint32_t node, halves; /* halves, halves + 1: their nodes, which are greater; 0: a leaf */
} core_tree_part;

/* tree.c. How many nodes a tree has. */
size_t norma_core_tree_nodes(size_t count);
/* Orders items, whose number is their index. fill: told of each part once, after its halves, by
 * several threads. O(n log n). MEMORY is impossible. */
norma_result norma_core_tree_grow(core_call *call, core_tree_item *items, size_t count,
    void (*fill)(void *context, const core_tree_part *part), void *context);

typedef struct core_box_node {
    double low[3], high[3]; /* of all boxes below */
    uint32_t begin, count;  /* of numbers */
    uint32_t left, right;   /* nodes; right 0: a leaf */
} core_box_node;

typedef struct core_box_tree {
    core_box_node *nodes;
    uint32_t *numbers;
    size_t count;
} core_box_tree;

/* Sets the box of a number. place: SIZE_MAX, or, once, where it stands among the tree's numbers. By
 * several threads. */
typedef void core_box_of(void *context, uint32_t number, size_t place, core_box *box);

/* O(n log n). What it returns but OK leaves nothing to release. */
norma_result norma_core_box_tree_build(
    core_call *call, size_t count, core_box_of *box_of, void *context, core_box_tree *tree);
void norma_core_box_tree_release(const core_call *call, core_box_tree *tree);

/* The finite triangles of a mesh's faces: by fans from their first corners; or by
 * cutting them as they are drawn, without those of no area. */
typedef enum core_triangles_by { CORE_TRIANGLES_FANS = 0, CORE_TRIANGLES_CUT } core_triangles_by;

typedef struct core_triangle { /* a corner, and the edges from there */
    double corner[3], u[3], v[3];
    uint32_t face, corners[3]; /* of the mesh */
} core_triangle;

typedef struct core_triangle_tree {
    core_box_tree boxes;
    core_triangle *triangles; /* in the order of the tree's numbers */
    size_t count;
    atomic_ullong *steps; /* counts the boxes that searches for near triangles open; NULL: nobody
                             asks */
} core_triangle_tree;

/* O(n log n). What it returns but OK leaves nothing to release. */
norma_result norma_core_triangle_tree_build(
    core_call *call, const core_mesh *mesh, core_triangles_by by, core_triangle_tree *tree);
void norma_core_triangle_tree_release(const core_call *call, core_triangle_tree *tree);

/* The squared distance from a point to a triangle. weights: those of the second and third corner
 * at the nearest point. */
double norma_core_nearest_in_triangle(
    const core_triangle *t, const double point[3], double weights[2]);
/* That to the nearest of all; *triangle: in, any number, best that of one nearby; out, its number.
 * INFINITY: there are none. */
double norma_core_triangle_tree_nearest(
    const core_triangle_tree *tree, const double point[3], size_t *triangle);
/* The number of the nearest that faces within 30 degrees of a direction (unit), within a squared
 * distance; tree->count: there is none. */
#define CORE_FACES_ALIKE 0.8660254037844387
size_t norma_core_triangle_tree_facing(
    const core_triangle_tree *tree, const double point[3], const double facing[3], double squared);
enum { CORE_MOST_NEAR = 64 };
/* As norma_core_triangle_tree_nearest; also writes the numbers of those that are at most by slack
 * further away than the nearest, CORE_MOST_NEAR at most. *count: how many there are; above
 * CORE_MOST_NEAR, any number. */
double norma_core_triangle_tree_around(const core_triangle_tree *tree, const double point[3],
    double slack, size_t *triangle, uint32_t near[CORE_MOST_NEAR], size_t *count);

/* ---- Which way an open part is seen most from outside. */

/* orient.c: of each open part whether most rays say that it should be reversed, as
 * components->reverse now has it. Parts of no opinion keep what they have. */
typedef struct core_ray_votes {
    size_t decided, undecided, reversed;
    double least_confidence;
    uint64_t steps; /* nodes and corners that rays looked at: O(parts log faces) */
} core_ray_votes;
norma_result norma_core_orient_by_rays(const core_topology *topology, core_components *components,
    uint8_t open_flags, core_ray_votes *votes);

typedef struct core_ray_scene core_ray_scene; /* built once; votes may be asked for again */

/* orient.c: which faces are turned. A closed part, once its faces agree, shows it by its volume and
 * what it lies in. In an open one each piece whose faces agree is judged by rays for itself, as two
 * pieces that touch may both be right. What is one-sided, or what rays do not decide on, shows
 * nothing, and there the bit of what is turned means the faces that differ from most of their part.
 */
enum { CORE_SIDE_TURNED = 1, CORE_SIDE_UNDECIDED = 2, CORE_SIDE_BY_RAYS = 4 };

/* mesh: stays as it is until the judge is released. The judge is kept by address. */
typedef struct core_side_judge {
    core_call call;
    core_topology topology;
    core_components parts, pieces;
    core_ray_scene *rays; /* NULL: nothing was asked yet that rays must say */
    uint8_t *known;       /* of each piece: what rays said, since all was forgotten */
    uint8_t *cast;        /* the same, ever: they would say it again */
    size_t room;
} core_side_judge;
norma_result norma_core_side_judge_open(
    const norma_mesh *mesh, const norma_options *options, core_side_judge *judge);
/* sides: of count faces from first on. asked: NULL, or a mark of each of them: rays are cast only
 * from pieces in which one is marked. */
norma_result norma_core_side_judge_ask(
    core_side_judge *judge, size_t first, size_t count, const uint8_t *asked, uint8_t *sides);
/* What was asked counts no more, as if the judge were new; nothing is cast twice. */
void norma_core_side_judge_forget(core_side_judge *judge);
void norma_core_side_judge_close(core_side_judge *judge);
#endif
