/* tangents.h: the vertices that corners share, the caller's tangents, and each way of making them.
 */
#ifndef NORMA_CORE_TANGENTS_H
#define NORMA_CORE_TANGENTS_H
#include "core/mesh/mesh.h"
#include <float.h>
#include <math.h>

/* ---- What every way of making tangents works on: the vertices that corners share, and the
 * caller's tangents. */

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

/* The two steps of opening. */
norma_result norma_core_tangent_read(tangent_mesh *mesh);
norma_result norma_core_tangent_weld(tangent_mesh *mesh);
/* Reads one vertex; key: the position or, unless it is by_position, the corner. 0: a corner names
 * no value. */
int norma_core_tangent_read_key(
    const tangent_mesh *mesh, size_t key, tangent_vertex *vertex, double exact[3]);
/* exact: NULL, or of each vertex. */
norma_result norma_core_tangent_weld_vertices(core_call *call, const tangent_vertex *vertices,
    const double (*exact)[3], size_t count, uint32_t *weld, size_t *found);

static inline uint32_t norma_core_tangent_key(const tangent_mesh *mesh, size_t corner) {
    return mesh->by_position ? norma_core_corner(&mesh->mesh, corner) : (uint32_t)corner;
}
static inline uint32_t norma_core_tangent_vertex(const tangent_mesh *mesh, size_t corner) {
    const uint32_t key = norma_core_tangent_key(mesh, corner);
    return mesh->weld ? mesh->weld[key] : key;
}

/* Where meshes are in no order, memory is slow, and asked for what is read soon. */
#if defined(__GNUC__)
#define TANGENT_PREFETCH(at) __builtin_prefetch(at)
#else
#define TANGENT_PREFETCH(at) ((void)(at))
#endif
enum { TANGENT_FACES_AHEAD = 12 };

/* Asks for the vertices of a face. */
static inline void norma_core_tangent_await(const tangent_mesh *m, size_t face) {
    if (face >= m->mesh.face_count) return;
    const size_t end = norma_core_face_end(&m->mesh, face);
    for (size_t c = norma_core_face_begin(&m->mesh, face); c < end; c++)
        TANGENT_PREFETCH(&m->vertices[norma_core_tangent_key(m, c)]);
}

static inline void norma_core_tangent_position(
    const tangent_mesh *mesh, size_t key, double out[3]) {
    if (mesh->exact)
        memcpy(out, mesh->exact[key], sizeof mesh->exact[key]);
    else
        for (int k = 0; k < 3; k++) out[k] = (double)mesh->vertices[key].position[k];
}

static inline int norma_core_tangent_is_finite(const tangent_vertex *v) {
    float zero = 0; /* NaN minus itself is NaN, and so is infinity minus itself */
    for (int k = 0; k < 3; k++) zero += v->position[k] - v->position[k];
    for (int k = 0; k < 3; k++) zero += v->normal[k] - v->normal[k];
    for (int k = 0; k < 2; k++) zero += v->texcoord[k] - v->texcoord[k];
    return zero == 0;
}

/* ---- the caller's tangents */

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

/* The ways to make tangents: each writes every corner once. */
typedef norma_result tangent_maker(
    const tangent_mesh *mesh, const tangent_output *output, core_tally *tally);
tangent_maker norma_core_mikk_tangents, norma_core_steady_tangents;
tangent_maker norma_core_meshopt_tangents; /* of triangles; ARGUMENT for other faces */

/* norma_corner_tangents by any of them. NULL: ARGUMENT. */
norma_result norma_core_corner_tangents(const norma_mesh *mesh, const norma_attribute *normals,
    const norma_attribute *texcoords, tangent_maker *maker, const norma_options *options,
    float *tangents, size_t capacity, norma_report *report);

/* ---- Many triangles' derivatives, or many corners' contributions, at once. Plain C over
 * arrays of lanes, in single precision, each operation as the reference has it, so that every
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

/* Of at most MIKK_LANES triangles from this one on, the flags, and the records where there are
 * some. batch: what they are loaded into. */
norma_result norma_core_mikk_stars(
    mikk_mesh *mesh, const tangent_output *output, core_tally *tally);

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

/* ---- The corners at one vertex, and the tangent spaces that they share. */

typedef struct mikk_space {
    float s[3], t[3]; /* t and the lengths: only of meshes with quads */
    float length_s, length_t, angle;
    int positive;
    uint32_t ends; /* of all tangents of a group that records sum */
    int opposed;   /* of a group: some of its tangents may be opposed to each other */
} mikk_space;

typedef struct mikk_star {
    const mikk_mesh *mesh;
    uint32_t vertex;
    size_t count;
    const uint32_t *corners;           /* of triangles, ascending */
    const uint32_t *next, *previous;   /* the vertices beside it in each corner's triangle */
    const uint8_t *flags;              /* of each corner's triangle */
    const mikk_corners *contributions; /* corner j's are in lane first + j */
    size_t first;
    mikk_edge_table *table; /* NULL: the star is small */
    mikk_links links;
    uint32_t *space;    /* of each corner, or MIKK_NONE */
    uint32_t *sequence; /* of each corner: how many got their space before it */
    uint32_t *seeds;    /* of each space: the corner that its group began with */
    mikk_space *spaces; /* room for twice the corners */
    size_t space_count;
} mikk_star;

static inline uint8_t mikk_flags_of(const mikk_star *star, size_t j) { return star->flags[j]; }
static inline const mikk_corners *mikk_block(const mikk_star *star, size_t j) {
    return &star->contributions[(star->first + j) / MIKK_LANES];
}
static inline size_t mikk_lane_of(const mikk_star *star, size_t j) {
    return (star->first + j) % MIKK_LANES;
}

/* Adds what a corner contributes. */
static inline void mikk_add(const mikk_corners *c, size_t lane, int has_quads, mikk_space *space) {
    const float angle = c->angle[lane];
    for (int k = 0; k < 3; k++) space->s[k] += angle * c->s[k][lane];
    if (!has_quads) return;
    for (int k = 0; k < 3; k++) space->t[k] += angle * c->t[k][lane];
    space->length_s += angle * c->length_s[lane];
    space->length_t += angle * c->length_t[lane];
    space->angle += angle;
}
static inline void norma_core_mikk_add(const mikk_star *star, size_t j, mikk_space *space) {
    mikk_add(mikk_block(star, j), mikk_lane_of(star, j), star->mesh->has_quads, space);
}

static inline int mikk_follows(const mikk_star *star, size_t j) {
    return mikk_flags_of(star, j) & MIKK_FOLLOWS;
}

/* ---- What many triangles add at their corners, at once: plain C over arrays of lanes,
 * each operation as steady.c has it for a face alone. */

enum { STEADY_LANES = 8 };
typedef double steady_lane[STEADY_LANES];

/* In: the corners of each triangle from its least rotation on. */
typedef struct steady_batch {
    _Alignas(64) steady_lane position[3][3]; /* of a corner, along an axis */
    steady_lane normal[3][3], texcoord[3][2];
} steady_batch;

/* Out: of each corner the part of its vertex's sum, of each triangle the sign. */
typedef struct steady_addends {
    _Alignas(64) steady_lane sum[3][3];
    steady_lane weight[3], sign;
    steady_lane is_sure; /* 0: squares of lengths that a double does not hold, or not finite */
} steady_addends;

typedef void steady_kernel(const steady_batch *batch, norma_weight weight, steady_addends *out);

/* ---- Tangents that depend on the mesh alone, not on the order in which it is given.
 *
 * Every number is computed from a face's corners in an order of their own (the rotation that is
 * least by what the corners hold), and sums are sums of integers, so that neither the order of
 * faces nor the first corner of a face changes a bit. */

/* What a corner adds to the sum of its vertex. */
typedef struct steady_part {
    double sum[3]; /* a unit vector times the weight */
    double weight; /* 0: adds nothing */
} steady_part;

/* Texture areas below this part of the products that they are differences of are rounding. */
static const double STEADY_ROUNDING = 0x1p-50;
/* Below this part of a unit vector, what is perpendicular to the normal is rounding. */
static const double STEADY_NOTHING_LEFT = 0x1p-20;

typedef struct steady_mesh {
    core_call *call;
    const tangent_mesh *input;
    uint32_t *vertex_of; /* of each corner */
    steady_part *parts;  /* of each corner of the faces that have a sign */
    int8_t *signs;    /* of each face's texture area, 0: none, or something of it is not finite */
    uint8_t *adopted; /* NULL, or of each face without one whether the sign is negative that it
                         takes from its neighbours */
    core_corners_of_position around;
} steady_mesh;

/* norma_core_length and _normalise, without a call for nearly all vectors: those whose squares fit
 * a double. */
static inline double steady_length(const double v[3]) {
    const double square = norma_core_dot(v, v);
    return square > NORMA_TINIEST && square < NORMA_HUGEST ? sqrt(square) : norma_core_length(v);
}
static inline void steady_normalise(const double v[3], double unit[3]) {
    const double square = norma_core_dot(v, v);
    if (!(square > NORMA_TINIEST && square < NORMA_HUGEST)) {
        norma_core_normalise(v, unit);
        return;
    }
    const double inverse = 1 / sqrt(square);
    for (int k = 0; k < 3; k++) unit[k] = v[k] * inverse;
}

static inline int steady_make_perpendicular(
    const double v[3], const double normal[3], double out[3]) {
    const double along = norma_core_dot(v, normal);
    for (int k = 0; k < 3; k++) out[k] = v[k] - along * normal[k];
    const double length = sqrt(norma_core_dot(out, out)); /* of a part of a unit vector */
    if (!(length > STEADY_NOTHING_LEFT)) return 0;
    const double inverse = 1 / length;
    for (int k = 0; k < 3; k++) out[k] *= inverse;
    return 1;
}

/* What steady_mesh has of the same names. */
norma_result norma_core_steady_stars(
    const tangent_mesh *mesh, uint32_t **vertex_of, core_corners_of_position *around);

/* ---- What of a mesh that moves stays: topology and texture coordinates, and so which corners a
 * vertex that moves may change. An update of all corners uses none of it: to know their groups
 * saved 12 % on models of games. */

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
    uint32_t *place;         /* NULL, or of each key the least with its texture coordinates */
    uint32_t *position_weld; /* NULL, or of each position the least that is equal to it */
    core_corners_of_position at_place, at_position;
    tangent_store stores[TANGENT_PLAN_STORES];
    size_t store_count, bytes;
};

/* The faces that some moved vertices have to do with. */
typedef struct tangent_region {
    uint8_t *wanted; /* of each key that stands for a place: its tangents may change */
    uint8_t *near;   /* of each face: it has a corner at such a place */
    size_t face_count, corner_count; /* of faces that are near */
    int is_large;                    /* nothing is won by looking at it alone */
} tangent_region;

static inline uint32_t norma_core_tangent_place(const norma_tangent_plan *plan, size_t corner) {
    const uint32_t key =
        plan->by_position ? norma_core_corner(&plan->mesh, corner) : (uint32_t)corner;
    return plan->place ? plan->place[key] : key;
}
#endif
