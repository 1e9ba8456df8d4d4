/* tangents.h: the vertices that corners share, the caller's tangents, and each way of making them.
 */
#ifndef NORMA_CORE_TANGENTS_H
#define NORMA_CORE_TANGENTS_H
#include "core/mesh/mesh.h"
#include <float.h>
#include <math.h>

/* ---- what every way of making tangents works on: the vertices that corners share
 * (tangent_vertices.c) */

typedef struct tangent_vertex {
    float position[3], normal[3], texcoord[2];
} tangent_vertex;

/* A key is a position where all attributes are per vertex, else a corner. */
typedef struct tangent_mesh {
    core_call *call;
    core_mesh mesh;
    const norma_attribute *normals, *texcoords;
    int by_position;
    size_t key_count;
    tangent_vertex *vertices; /* of each key */
    int in_doubles;           /* floats do not do for its positions */
    double (*exact)[3];       /* NULL, or of each key its position; in vertices are zeros, or NaN
                                 where it is not finite */
    uint32_t *weld;           /* NULL, or of each key the least that is equal to it (-0 = 0); NaN is
                                 equal to nothing */
    int *is_awkward; /* NULL, or the mesh is a part: where its tangents may hang on the rest of the
                        mesh, this is set and nothing written */
} tangent_mesh;

/* ARGUMENT or OVERFLOW: what can be told without reading the arrays; mesh->mesh is checked. */
norma_result norma_core_tangent_attributes(tangent_mesh *mesh, norma_tangent_mode mode,
    const norma_attribute *normals, const norma_attribute *texcoords);
/* INDEX, MEMORY or CANCELLED; on success norma_core_tangent_close releases it. */
norma_result norma_core_tangent_open(tangent_mesh *mesh);
void norma_core_tangent_close(tangent_mesh *mesh);

/* The two steps of opening, for a plan. */
norma_result norma_core_tangent_read(tangent_mesh *mesh);
norma_result norma_core_tangent_weld(tangent_mesh *mesh);
/* Reads one vertex. key: the position or, unless it is by_position, the corner. 0: a corner names
 * no value. */
int norma_core_tangent_read_key(
    const tangent_mesh *mesh, size_t key, tangent_vertex *vertex, double exact[3]);
/* weld: of each vertex the least that is equal to it. *found: how many are equal to an earlier one.
 * exact: NULL, or of each vertex. */
norma_result norma_core_tangent_weld_vertices(core_call *call, const tangent_vertex *vertices,
    const double (*exact)[3], size_t count, uint32_t *weld, size_t *found);

static inline uint32_t norma_core_tangent_key(const tangent_mesh *mesh, size_t corner) {
    return mesh->by_position ? norma_core_corner(&mesh->mesh, corner) : (uint32_t)corner;
}
static inline uint32_t norma_core_tangent_vertex(const tangent_mesh *mesh, size_t corner) {
    const uint32_t key = norma_core_tangent_key(mesh, corner);
    return mesh->weld ? mesh->weld[key] : key;
}

static inline int norma_core_tangent_is_finite(const tangent_vertex *v) {
    float zero = 0; /* NaN minus itself is NaN, and so is infinity minus itself */
    for (int k = 0; k < 3; ++k) zero += v->position[k] - v->position[k];
    for (int k = 0; k < 3; ++k) zero += v->normal[k] - v->normal[k];
    for (int k = 0; k < 2; ++k) zero += v->texcoord[k] - v->texcoord[k];
    return zero == 0;
}

/* ---- the caller's tangents (tangent_vertices.c) */

typedef struct tangent_output {
    unsigned char *tangents;
    size_t stride;
    uint8_t *reasons;
} tangent_output;

typedef struct corner_tangent {
    float direction[3];
    float sign;
    int reason; /* other than NONE: the direction is not looked at */
} corner_tangent;

/* ARGUMENT, CAPACITY or OVERFLOW where count tangents cannot go to tangents. */
norma_result norma_core_tangent_output_open(const norma_options *options, float *tangents,
    size_t count, size_t capacity, tangent_output *output);

/* Writes the tangent of a corner whose own vertex this is, or what it gets instead; counts the
 * latter. */
void norma_core_write_tangent(const tangent_output *output, size_t corner,
    const tangent_vertex *vertex, const corner_tangent *tangent, core_tally *tally);

/* The same in two steps, for tangents that many corners of one vertex have. */
typedef struct written_tangent {
    float numbers[4];
    int reason;
} written_tangent;
written_tangent norma_core_tangent_to_write(
    const tangent_vertex *vertex, const corner_tangent *tangent);

static inline void norma_core_put_tangent(const tangent_output *output, size_t corner,
    const written_tangent *tangent, core_tally *tally) {
    memcpy(output->tangents + corner * output->stride, tangent->numbers, sizeof tangent->numbers);
    if (output->reasons) output->reasons[corner] = (uint8_t)tangent->reason;
    if (tangent->reason != NORMA_REASON_NONE) norma_core_tally(tally, tangent->reason, corner);
}

/* The ways to make tangents (mikk.c, steady.c, meshopt.c): each writes every corner once. */
typedef norma_result tangent_maker(
    const tangent_mesh *mesh, const tangent_output *output, core_tally *tally);
tangent_maker norma_core_mikk_tangents, norma_core_steady_tangents;
tangent_maker norma_core_meshopt_tangents; /* of triangles; ARGUMENT for other faces */

/* tangents.c: norma_corner_tangents by any of them. maker NULL: ARGUMENT. */
norma_result norma_core_corner_tangents(const norma_mesh *mesh, const norma_attribute *normals,
    const norma_attribute *texcoords, tangent_maker *maker, const norma_options *options,
    float *tangents, size_t capacity, norma_report *report);

/* ---- mikk_kernel.c: many triangles' derivatives, or many corners' contributions, at once. Plain C
 * over arrays of lanes, in single precision, each operation as the reference has it, so that every
 * instruction set gives its bits. */

enum { MIKK_LANES = 16, MIKK_ALL_ENDS = 0xfff };
typedef float mikk_lane[MIKK_LANES];

/* In: the three vertices of each triangle. */
typedef struct mikk_batch {
    _Alignas(64) mikk_lane position[3][3]; /* of a vertex, along an axis */
    mikk_lane normal[3][3];
    mikk_lane texcoord[3][2];
    mikk_lane turn; /* contribute: which of the three the corner is at: 0, 1 or 2 */
} mikk_batch;

/* Out: of each corner. */
typedef struct mikk_corners {
    mikk_lane s[3], t[3]; /* the tangent and the bitangent, made perpendicular to the
                                          normal, unit or next to nothing */
    mikk_lane angle, length_s, length_t;
} mikk_corners;

typedef struct mikk_derivative {
    _Alignas(64) mikk_lane area, length_s, length_t; /* lengths: |dP/du| and |dP/dv|; 0: no area */
} mikk_derivative;

/* Out: of each triangle, and of all three corners what a record holds (mikk_record). */
typedef struct mikk_addends {
    mikk_derivative derivative;
    mikk_lane sum[3][3]; /* of a corner, along an axis */
    uint32_t ends[3][MIKK_LANES];
} mikk_addends;

typedef struct mikk_kernels {
    void (*derive)(const mikk_batch *batch, mikk_derivative *out); /* normals are not looked at */
    void (*contribute)(const mikk_batch *batch, mikk_corners *out);
    void (*add_up)(const mikk_batch *batch, mikk_addends *out);
} mikk_kernels;

const mikk_kernels *norma_core_mikk_kernels(norma_isa isa);

/* acos of each x in [-1, 1] as a correctly rounded function of doubles gives it, rounded to a
 * float. */
float norma_core_mikk_acos(float x);

/* ---- MikkTSpace (Mikkelsen 2008): the mesh as its triangles.
 *
 * Two triangles at a vertex belong to one group where a chain of shared edges leads from one to the
 * other round the vertex and all have the same orientation in texture space. A group's tangent is
 * the sum of its triangles' tangents, made perpendicular to the normal and unit, times their angles
 * at the vertex. Floats are computed as the reference writes them, sums in ascending order of
 * triangles: the result is defined to the last bit. */

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
} mikk_mesh;
/* norma-mesh/normals has triangles only. */
static inline int mikk_has_records(const mikk_mesh *m) { return CORE_IS_SMALL || m->records; }

static inline int mikk_is_zero(float x) { return !(fabsf(x) > FLT_MIN); }

/* ---- mikk_groups.c: vertex by vertex the groups of triangles, which mikk.c has listed and
 * flagged, and their tangents, which are written. */

norma_result norma_core_mikk_stars(
    mikk_mesh *mesh, const tangent_output *output, core_tally *tally);

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

/* ---- steady.c: the vertex of each corner, and the corners around each vertex. */
norma_result norma_core_steady_stars(
    const tangent_mesh *mesh, uint32_t **vertex_of, core_corners_of_position *around);
#endif
