/* mikk.h: MikkTSpace (Mikkelsen 2008): the mesh as its triangles.
 *
 * Two triangles at a vertex belong to one group where a chain of shared edges leads from one to the
 * other round the vertex and all have the same orientation in texture space. A group's tangent is
 * the sum of its triangles' tangents, made perpendicular to the normal and unit, times their angles
 * at the vertex. Floats are computed as the reference writes them, sums in ascending order of
 * triangles: the result is defined to the last bit. */
#ifndef NORMA_CORE_MIKK_H
#define NORMA_CORE_MIKK_H
#include "core/mesh/corners_of_position.h"
#include "core/tangent/mikk_lanes.h"
#include "core/tangent/tangents.h"
#include <float.h>
#include <math.h>

enum {
    MIKK_POSITIVE = 1, /* the texture's area has a positive sign, or is of a sort that follows its
                          neighbours, and they are positive */
    MIKK_FOLLOWS = 2,  /* no texture area: joins any group, and adds nothing to it */
    MIKK_FOLLOWED = 4, /* it follows, and a group has reached it */
    MIKK_DEGENERATE = 8,
    MIKK_SECOND = 16, /* of two triangles of one quad, the one before being the other */
    MIKK_HELD = 32    /* << corner: a triangle before it has this corner of the caller's face */
};

static const uint32_t MIKK_NONE = UINT32_MAX;

/* A corner that no triangle holds takes the tangent of one that a triangle does. */
typedef struct mikk_copy {
    uint32_t source; /* a corner of a triangle, or MIKK_NONE for the first at the vertex */
    uint32_t target; /* a corner of the caller's */
} mikk_copy;

/* What a triangle adds to the sum at one of its corners, and the vertices beside it there. ends: in
 * which directions along the axes its tangent and its bitangent point. Unit vectors that are
 * opposed to each other have ends that are (mikk_ends_oppose). */
typedef struct mikk_record {
    float sum[3];
    uint16_t ends;
    uint8_t flags; /* the triangle's */
    uint32_t next, previous;
} mikk_record;

/* A corner of a triangle has the number 3 * triangle + 0, 1 or 2. */
typedef struct mikk_mesh {
    core_call *call;
    const tangent_mesh *input;
    const tangent_vertex *vertices;
    size_t vertex_count;
    size_t count, room;  /* triangles, degenerate ones left out; for how many there is room */
    uint32_t *triangles; /* three vertices each */
    uint32_t *corners;   /* NULL, or of each corner the caller's; else they are the same */
    uint8_t *flags;      /* of each triangle */
    int has_quads;
    mikk_record *records;            /* NULL, or of each corner; of meshes of triangles */
    core_corners_of_position around; /* of each vertex the corners, ascending */
    uint32_t *copy_starts;           /* NULL, or vertex_count + 1 offsets into copies */
    mikk_copy *copies;
    size_t copy_count;
    int is_sorted; /* around is a plan's */
} mikk_mesh;

/* MEMORY or CANCELLED; norma_core_mikk_release in any case. */
norma_result norma_core_mikk_triangles(mikk_mesh *mesh);
norma_result norma_core_mikk_copies(mikk_mesh *mesh, const uint32_t *holders);
/* Triangles that have records have their flags already. */
norma_result norma_core_mikk_flags(mikk_mesh *mesh);
/* Of at most MIKK_LANES triangles from this one on, the flags, and the records where there are
 * some. batch: what they are loaded into. */
void norma_core_mikk_flag_lanes(const mikk_mesh *mesh, const mikk_kernels *kernels, size_t triangle,
    size_t count, mikk_batch *batch);
norma_result norma_core_mikk_follow(mikk_mesh *mesh);
norma_result norma_core_mikk_stars(
    mikk_mesh *mesh, const tangent_output *output, core_tally *tally);
void norma_core_mikk_release(mikk_mesh *mesh);

/* For a plan: triangles and what is there before their texture is looked at. MEMORY or CANCELLED
 * leave nothing to release. */
norma_result norma_core_mikk_keep(const tangent_mesh *mesh, mikk_mesh *kept);

static inline int mikk_is_zero(float x) { return !(fabsf(x) > FLT_MIN); }

/* ends: of some vectors together. Six bits for the ends of each axis that grow, six for the others.
 */
static inline int mikk_ends_oppose(unsigned ends) { return (ends & ends >> 6 & 63) != 0; }

static inline uint32_t mikk_target(const mikk_mesh *mesh, uint32_t corner) {
    return mesh->corners ? mesh->corners[corner] : corner;
}

/* The links between the corners of one vertex: to which one a shared edge leads, out along the edge
 * to the triangle's next corner (left) or in along the edge from its previous one (right). */
typedef struct mikk_links {
    uint32_t *left, *right; /* numbers of the star's corners, or MIKK_NONE */
} mikk_links;

/* Where many corners meet: a table of the vertices that their edges lead to. */
typedef struct mikk_edge_table {
    size_t room; /* a power of two */
    struct mikk_edge {
        uint32_t vertex, first, last;
    } * edges;
    uint32_t *following; /* of each corner twice: of its edge out and its edge in */
} mikk_edge_table;

enum { MIKK_SMALL_STAR = 64 };

/* next and previous: the vertices of each corner's triangle, in ascending order of triangles. A
 * table is needed beyond MIKK_SMALL_STAR corners only. */
void norma_core_mikk_link(const uint32_t *next, const uint32_t *previous, size_t count,
    mikk_edge_table *table, mikk_links *links);
norma_result norma_core_mikk_table_open(
    const core_call *call, size_t most_corners, mikk_edge_table *table);
void norma_core_mikk_table_close(
    const core_call *call, size_t most_corners, mikk_edge_table *table);
#endif
