/* norma.h: surface normals of meshes, and normals under transforms. This is the core of Norma: it
 * does no I/O, has no globals and needs only libc and libm.
 *
 * Conventions:
 * - Vectors are columns. 4x4 matrices are column-major (translation in [12..14]), 3x3 matrices too.
 *   In memory these are the same bytes as row-major matrices for row vectors.
 * - Angles are in radians, strides in bytes, counts and capacities in elements.
 * - A zero-initialised struct means the documented defaults.
 *
 * The comment above each function lists its parameters one per line, then its particular errors,
 * cost and source. Rules that several functions share are listed once, at the start of their
 * section. */
#ifndef NORMA_H
#define NORMA_H
#include <stddef.h>
#include <stdint.h>
#ifdef __cplusplus
extern "C" {
#endif

/* The release that this header belongs to. NORMA_VERSION is a single number to compare:
 * 10000 * major + 100 * minor + patch. norma_version_number() returns that of the linked library.
 */
#define NORMA_VERSION_MAJOR 0
#define NORMA_VERSION_MINOR 1
#define NORMA_VERSION_PATCH 0
#define NORMA_VERSION                                                                              \
    (10000 * NORMA_VERSION_MAJOR + 100 * NORMA_VERSION_MINOR + NORMA_VERSION_PATCH)

/* Marks every public function: the shared library exports these and nothing else. Define it before
 * including this header to mark them differently. */
#ifndef NORMA_API
#if defined(__GNUC__) && !defined(_WIN32)
#define NORMA_API __attribute__((visibility("default")))
#else
#define NORMA_API
#endif
#endif

/* ---- results */

typedef enum norma_result {
    NORMA_OK = 0,
    NORMA_CANCELLED = 1,       /* the progress callback cancelled the call */
    NORMA_ERROR_ARGUMENT = -1, /* an argument is missing, out of range or contradicts another */
    NORMA_ERROR_CAPACITY = -2, /* an output buffer is too small */
    NORMA_ERROR_INDEX = -3,    /* a corner refers to a position that does not exist */
    NORMA_ERROR_MEMORY = -4,   /* out of memory */
    NORMA_ERROR_OVERFLOW = -5  /* a size computed from the counts does not fit */
} norma_result;

/* Returns a one-line description of a result.
 *
 *   result   any number; unknown codes get a generic text
 *
 * Returns a constant string that is never NULL and must not be freed. Any thread, any time. */
NORMA_API const char *norma_result_text(norma_result result);

/* ---- meshes */

typedef enum norma_format {
    NORMA_FORMAT_FLOAT = 0,
    NORMA_FORMAT_DOUBLE,
    NORMA_FORMAT_INT8,
    NORMA_FORMAT_UINT8,
    NORMA_FORMAT_INT16,
    NORMA_FORMAT_UINT16
} norma_format;

/* An array of vectors with three components each. Integers are taken as they are, without
 * normalisation: a common factor changes no direction. */
typedef struct norma_vec3_view {
    const void *data;
    size_t count;        /* vectors */
    size_t stride;       /* bytes from one vector to the next; 0: tightly packed */
    norma_format format; /* of each component */
} norma_vec3_view;

/* A mesh in the caller's memory: positions, and faces made of corners. */
typedef struct norma_mesh {
    norma_vec3_view positions;

    /* For each corner the index of its position, face after face. NULL: 0, 1, 2, ... */
    const void *corners;
    size_t corner_count;
    size_t corner_size; /* bytes of one index: 4 (or 0), 2 or 1 */

    /* face_count + 1 offsets into corners: face f has the corners from face_starts[f] up to but not
     * including face_starts[f + 1]. NULL: every face is a triangle. */
    const uint32_t *face_starts;
    size_t face_count; /* read only if face_starts is given */

    /* A bit mask for each face, or NULL. Faces are smoothed across an edge only if their masks
     * share a bit. */
    const uint32_t *smoothing_groups;

    /* A byte for each corner, or NULL. Nonzero: the edge from this corner to the next corner of the
     * face is hard. */
    const uint8_t *hard_edges;
} norma_mesh;

/* Reads one vector of a view, of any format, stride and alignment.
 *
 *   view    a view with data and a valid format
 *   index   below view->count; nothing is checked
 *   out     the vector; every format fits doubles exactly */
NORMA_API void norma_view_vector(const norma_vec3_view *view, size_t index, double out[3]);

/* Returns the index of a corner's position, of any corner_size; without corners, the corner itself.
 *
 *   mesh     a mesh
 *   corner   below mesh->corner_count; nothing is checked */
NORMA_API uint32_t norma_mesh_corner(const norma_mesh *mesh, size_t corner);

/* ---- options */

/* How much each face counts in an average. A corner lies between the edges a and b, with the
 * interior angle alpha; A is the area of its face. */
typedef enum norma_weight {
    NORMA_WEIGHT_ANGLE = 0,    /* alpha (Thuermer, Wuethrich 1998) */
    NORMA_WEIGHT_AREA,         /* A */
    NORMA_WEIGHT_UNIFORM,      /* 1 (Gouraud 1971) */
    NORMA_WEIGHT_MAX,          /* |a x b| / (|a|^2 |b|^2) (Max 1999) */
    NORMA_WEIGHT_ANGLE_AREA,   /* alpha A */
    NORMA_WEIGHT_VISIBLE,      /* no sum: axis of the smallest cone around the face normals */
                               /* (Aubry, Loehner 2008) */
    NORMA_WEIGHT_ANGLE_LENGTHS /* alpha |a| |b| */
} norma_weight;

/* Returns the name of a weight, such as "angle-area". The command line uses the same names.
 *
 *   weight   any number; the weights are those from 0 up to the first without a name
 *
 * Returns a constant string that must not be freed, or NULL if there is no such weight. Any thread,
 * any time. */
NORMA_API const char *norma_weight_name(norma_weight weight);

/* Which corners lie at the same point of the surface. */
typedef enum norma_weld {
    NORMA_WELD_EXACT = 0, /* corners at exactly equal positions (-0 equals 0) */
    NORMA_WELD_NONE,      /* only corners with the same index */
    NORMA_WELD_DISTANCE   /* positions connected by a chain of steps <= weld_distance */
} norma_weld;

/* How edges of three or more faces are treated. */
typedef enum norma_non_manifold {
    NORMA_NON_MANIFOLD_HARD = 0, /* as hard edges */
    NORMA_NON_MANIFOLD_SMOOTH    /* smooth between all faces within the crease angle */
} norma_non_manifold;

/* The vector that is written for an element without a normal of its own. */
typedef enum norma_fallback {
    NORMA_FALLBACK_ZERO = 0, /* (0, 0, 0) */
    NORMA_FALLBACK_NEAREST,  /* the normal of the nearest element that has one */
    NORMA_FALLBACK_GIVEN     /* fallback_normal */
} norma_fallback;

/* Instruction sets. All give the same bits. */
typedef enum norma_isa {
    NORMA_ISA_BEST = 0, /* the fastest one this machine has */
    NORMA_ISA_PORTABLE,
    NORMA_ISA_SSE2,
    NORMA_ISA_AVX2,
    NORMA_ISA_AVX512,
    NORMA_ISA_NEON,
    NORMA_ISA_SIMD128
} norma_isa;

/* Why an element has no normal of its own and holds the fallback. */
enum norma_reason {
    NORMA_REASON_NONE = 0,     /* it has a normal */
    NORMA_REASON_DEGENERATE,   /* the face has no direction (face normals only) */
    NORMA_REASON_NON_FINITE,   /* its position, or one of its face's, is NaN or infinite */
    NORMA_REASON_UNREFERENCED, /* no face with a direction uses it */
    NORMA_REASON_CANCELLED     /* the normals around it cancel each other */
};

/* One piece of parallel work. */
typedef void norma_task(void *context, size_t index);

/* Runs task(context, i) once for each i below count, in any order and on any threads, and returns
 * when all are done. */
typedef void norma_parallel_for(void *user, size_t count, norma_task *task, void *context);

/* Reports progress from 0 to 1; fraction never decreases. Return nonzero to cancel. */
typedef int norma_progress(void *user, double fraction);

/* The caller's allocator: both functions, or neither for malloc and free. Only the calling thread
 * calls it. */
typedef struct norma_allocator {
    /* alignment: a power of two, at most 64. Returns NULL if out of memory. */
    void *(*allocate)(void *user, size_t size, size_t alignment);
    /* size: as it was allocated. */
    void (*release)(void *user, void *block, size_t size);
    void *user;
} norma_allocator;

#define NORMA_ALL_THREADS UINT32_MAX

typedef struct norma_options {
    size_t struct_size; /* sizeof(norma_options) of the caller; 0: the first version */
    norma_weight weight;
    norma_weld weld;
    double weld_distance; /* in the units of the positions */
    norma_non_manifold non_manifold;
    norma_fallback fallback;
    float fallback_normal[3]; /* must be finite */
    size_t normal_stride;     /* bytes between normals in the output; 0: 12 */
    uint8_t *reasons;         /* written: an enum norma_reason for each normal; or NULL */

    /* How many threads may work. 0 or 1: only the calling one. NORMA_ALL_THREADS: as many as the
     * machine runs at once. */
    uint32_t threads;
    norma_isa isa; /* an argument error if the machine lacks it */
    norma_allocator allocator;

    /* The caller's own job system, used instead of threads if given. */
    norma_parallel_for *parallel_for;
    void *parallel_for_user;
    norma_progress *progress; /* called by the calling thread only; or NULL */
    void *progress_user;

    /* Later than the first version: read only if struct_size covers it. */
    struct norma_edges *edges; /* written by the calls that use creases; or NULL */
} norma_options;

/* Counts of distinct edges: pairs of (welded) positions along which faces run. Edges that the
 * report counts as non-manifold edges or winding conflicts are in count only. */
typedef struct norma_edges {
    size_t count;  /* all edges */
    size_t open;   /* edges of one face */
    size_t smooth; /* shared, within the crease angle, not marked hard */
    size_t hard;   /* the others */
} norma_edges;

typedef struct norma_count {
    size_t count, first;
} norma_count; /* first: the lowest index; SIZE_MAX if count is 0 */

/* Counts elements without a normal and unusual edges. Each element is counted once, in the order of
 * the members. */
typedef struct norma_report {
    norma_count degenerate_faces; /* faces */

    /* Elements of the output: faces, vertices or corners. */
    norma_count non_finite;
    norma_count unreferenced;
    norma_count cancelled;

    /* Edges, counted by the calls that use creases. first: the lowest corner at which such an edge
     * begins. */
    norma_count non_manifold_edges;
    norma_count winding_conflicts;
} norma_report;

/* ---- which argument was wrong */

/* Why a call was refused. The strings are constant. */
typedef struct norma_fault {
    norma_result result;  /* NORMA_OK: nothing is wrong; the rest is then NULL or SIZE_MAX */
    const char *argument; /* "mesh->corners", "options->weight", "crease_angle_rad", ... */
    size_t index;         /* of the wrong element of that array; SIZE_MAX: no single one */
    const char *expected; /* what it should be, a phrase */
} norma_fault;

/* Finds out why a call on a mesh returned an error: the argument, and the corner or offset in it.
 *
 *   mesh               as given to the call
 *   crease_angle_rad   as given to the call; NULL if it has none
 *   options            as given to the call; may be NULL
 *   fault              written; or NULL
 *
 * Returns what the call would return for these arguments. If it returns NORMA_OK and the call
 * failed, an output was at fault: NULL, too small (NORMA_ERROR_CAPACITY) or the mesh's own array.
 * Cost: O(corners), on the calling thread. Allocates nothing. */
NORMA_API norma_result norma_find_fault(const norma_mesh *mesh, const float *crease_angle_rad,
    const norma_options *options, norma_fault *fault);

/* Finds the first model whose upper 3x3 is not finite.
 *
 *   models         as given to norma_normal_matrices_strided
 *   model_stride   bytes from one model to the next; 0: 64
 *   count          number of models
 *   fault          written; or NULL
 *
 * Returns NORMA_OK if all are finite. */
NORMA_API norma_result norma_find_model_fault(
    const float *models, size_t model_stride, size_t count, norma_fault *fault);

/* ---- normals
 *
 * Common to the four calls below:
 *
 * - Output. normals takes three floats for each element (face, vertex or corner): a unit vector, or
 *   the fallback. Each is written once and never read back, so it may be mapped GPU memory. Any
 *   alignment is allowed. Elements lie options->normal_stride bytes apart (12 by default); nothing
 *   is written between or beyond them, and -0 is never written. capacity counts elements, not
 *   floats.
 * - Ownership. All buffers belong to the caller and are used only during the call.
 * - NULL. options and report may be NULL.
 * - Missing normals. An element without a normal gets options->fallback; options->reasons holds the
 *   reason and the report counts it. NaN is never written.
 * - Face directions. A face's direction is that of its vector area. It is within 1e-7 rad of the
 *   exact one for the given positions, however thin the face, for edges from 1e-38 to 1e38 and at
 *   any distance from the origin. Consecutive corners at one (welded) position count as one corner,
 *   the last of them. A face has no direction, and is left out of all sums, if fewer than three
 *   corners are left, if its area is exactly zero, or if one of its positions is not finite.
 * - Errors. NORMA_ERROR_ARGUMENT: mesh is NULL; a buffer is NULL but something has to be read or
 *   written there; corner_count is not a multiple of three without face_starts; face_starts
 *   decrease or do not run from 0 to corner_count; corners is NULL but corner_count exceeds the
 *   number of positions; the crease is NaN, infinite or above pi + 1e-3; an option is out of range;
 *   the machine lacks the instruction set. norma_find_fault names the argument and the element.
 *   NORMA_ERROR_CAPACITY and NORMA_ERROR_INDEX occur as listed at norma_result,
 *   NORMA_ERROR_OVERFLOW also for 2^32 - 1 or more positions, corners or faces. All these are found
 *   before anything is written. After NORMA_ERROR_MEMORY and NORMA_CANCELLED, outputs and report
 *   are undefined. An empty mesh is NORMA_OK.
 * - Reproducibility. The bits are the same for any number of threads, any parallel_for and any
 *   instruction set: each sum runs over its corners in ascending order.
 * - Thread safety. Any number of calls may run at once, as long as their meshes are not changed
 *   meanwhile. */

/* Computes the unit normal of each face, correct for concave polygons too.
 *
 *   mesh       the faces
 *   options    ignores weight and non_manifold; uses weld only if it is NORMA_WELD_DISTANCE
 *   normals    written: face_count normals (triangles: corner_count / 3)
 *   capacity   normals that fit
 *   report     written; or NULL
 *
 * Cost: O(corners); almost no scratch memory, except with NORMA_WELD_DISTANCE and
 * NORMA_FALLBACK_NEAREST.
 * Source: the vector area, (p1 - p0) x (p2 - p0) for a triangle, the sum of (p_i - p_0) x
 * (p_{i+1} - p_0) for a polygon (Newell's method: Sutherland, Sproull, Schumacker 1974). */
NORMA_API norma_result norma_face_normals(const norma_mesh *mesh, const norma_options *options,
    float *normals, size_t capacity, norma_report *report);

/* Computes the unit normal of each position: the weighted sum of the normals of all faces with a
 * corner there. Creases are ignored.
 *
 *   mesh       the faces
 *   options    weight chooses the weights, weld which positions share a normal
 *   normals    written: positions.count normals
 *   capacity   normals that fit
 *   report     written; or NULL
 *
 * If a sum cancels (||sum|| <= 2^-20 times the sum of weights), the sum over the corners of the
 * position's own index is taken instead.
 * Cost: O(positions + corners), whatever the valence; NORMA_WELD_DISTANCE: O(n log n).
 * Source: Gouraud 1971; the weights' sources are at norma_weight. */
NORMA_API norma_result norma_vertex_normals(const norma_mesh *mesh, const norma_options *options,
    float *normals, size_t capacity, norma_report *report);

/* Computes the unit normal of each corner: the weighted sum over its fan, that is, over the corners
 * at its position that are joined to it by smooth edges.
 *
 *   mesh               the faces; smoothing_groups and hard_edges are respected
 *   crease_angle_rad   the largest dihedral angle of a smooth edge; with pi, all angles are smooth,
 *                      with 0 only flat edges, below 0 none
 *   options            as for norma_vertex_normals, and non_manifold and edges
 *   normals            written: corner_count normals
 *   capacity           normals that fit
 *   report             written; or NULL
 *
 * An edge is smooth if two faces share it, their dihedral angle is at most crease_angle_rad + 1e-6,
 * neither marks it hard, and their smoothing groups, if given, have a bit in common. Two faces are
 * partners at an edge if they run along it in opposite directions, unless one is the other
 * reversed. They share the edge if each is the other's only partner. For the dihedral angle only, a
 * face without a direction uses that of the face with which it shares its longest edge.
 * Cost: O(positions + corners * log valence). */
NORMA_API norma_result norma_corner_normals(const norma_mesh *mesh, float crease_angle_rad,
    const norma_options *options, float *normals, size_t capacity, norma_report *report);

/* Computes the same normals as norma_corner_normals, as an indexed mesh: a vertex is split where
 * its corners have different normals. Call it with NULL outputs to learn vertex_count.
 *
 *   mesh               as for norma_corner_normals
 *   crease_angle_rad   as for norma_corner_normals
 *   options            as for norma_corner_normals; reasons: one for each new vertex
 *   corners            written: the new vertex of each corner; or NULL. Not mesh->corners, which is
 *                      read again after this is written
 *   corner_capacity    corners that fit
 *   source_vertices    written: the old vertex of each new vertex; or NULL
 *   normals            written: the normal of each new vertex; or NULL
 *   vertex_capacity    elements that fit in source_vertices and in normals
 *   vertex_count       written on success: the number of new vertices; or NULL
 *   report             written, counting corners; or NULL
 *
 * New vertices are numbered in the order in which corners first use them. Two corners get different
 * new vertices if their old vertex or a bit of their normal differs. Positions without corners are
 * dropped. With NORMA_FALLBACK_NEAREST, a corner without a normal joins the first corner of its
 * vertex that has one, so degenerate faces add no vertices.
 * Cost: that of norma_corner_normals, twice if a position is split. Additional scratch memory: at
 * most 3 bytes per corner and 17 per position; 5 and 17 with normals but no corners; 2 more per
 * corner with NORMA_FALLBACK_NEAREST. Triangle corners at positions of more than 64 corners take
 * 260 bytes instead of the 20 of norma_corner_normals. */
NORMA_API norma_result norma_split(const norma_mesh *mesh, float crease_angle_rad,
    const norma_options *options, uint32_t *corners, size_t corner_capacity,
    uint32_t *source_vertices, float *normals, size_t vertex_capacity, size_t *vertex_count,
    norma_report *report);

/* Output buffers of norma_split_mesh. The caller owns the arrays; each may be NULL. */
typedef struct norma_split_output {
    uint32_t *corners;         /* written: the new vertex of each corner; not mesh->corners */
    size_t corner_capacity;    /* corners that fit */
    uint32_t *source_vertices; /* written: the old vertex of each new vertex */
    float *normals;            /* written: the normal of each new vertex */
    size_t vertex_capacity;    /* elements that fit in source_vertices and in normals */
    size_t vertex_count;       /* written on success: the number of new vertices */
} norma_split_output;

/* norma_split with its outputs in a struct; prefer it in new programs.
 *
 *   mesh, crease_angle_rad, options   as for norma_split
 *   split                             read and written
 *   report                            written, counting corners; or NULL
 *
 * Errors: those of norma_split; NORMA_ERROR_ARGUMENT also if split is NULL. */
NORMA_API norma_result norma_split_mesh(const norma_mesh *mesh, float crease_angle_rad,
    const norma_options *options, norma_split_output *split, norma_report *report);

/* Interpolates the normal inside a triangle: the unit vector along barycentric[0] a +
 * barycentric[1] b + barycentric[2] c, correct over the whole range of floats.
 *
 *   a, b, c       the normals of the corners; their lengths count
 *   barycentric   the weights; they need not sum to 1
 *   normal        written; may be one of the inputs
 *
 * If the sum cancels (its length is at most 2^-20 times the sum of the lengths of its terms) or is
 * not finite, normal becomes zero and the result is NORMA_OK.
 * Errors: NORMA_ERROR_ARGUMENT if a pointer is NULL; then nothing is written.
 * Source: Phong 1975, p. 314. */
NORMA_API norma_result norma_interpolate_normal(const float a[3], const float b[3],
    const float c[3], const float barycentric[3], float normal[3]);

/* ---- meshes that move
 *
 * A plan stores everything that depends only on topology, so an update only has to measure faces
 * and sum. Fans and shared positions are those of the mesh at creation: no edge flickers between
 * hard and soft as it bends. A face that had no direction at creation counts as soon as it has one,
 * in the fan it belongs to.
 *
 * - Thread safety. An update does not change the plan. Any number of updates of one plan may run at
 *   once, each with its own output.
 * - Memory. An update allocates nothing, with one exception: if a normal is missing with
 *   NORMA_FALLBACK_NEAREST, it takes scratch memory from the allocator of its options. With threads
 *   above 1 it starts and joins threads. Each task needs at most 32 KiB of stack, and so does the
 *   call itself. */

typedef enum norma_element {
    NORMA_PER_VERTEX = 0,
    NORMA_PER_CORNER
} norma_element; /* per vertex: the sum over the fans of its corners */

typedef struct norma_plan norma_plan;

/* Makes a plan of a mesh.
 *
 *   mesh               read during the call only
 *   of                 whether the plan is for normals per vertex or per corner
 *   crease_angle_rad   as for norma_corner_normals
 *   options            uses weld, non_manifold, threads, isa, parallel_for, progress, edges and
 *                      allocator; other options are ignored. The allocator must live as long as the
 *                      plan. May be NULL
 *   plan               written on success; release it with norma_plan_destroy
 *
 * Errors: those of norma_corner_normals; NORMA_ERROR_ARGUMENT also if plan is NULL or of is not a
 * norma_element; NORMA_ERROR_MEMORY also for contrived meshes in which the overlapping fans of
 * vertices hold more than 16 times the corners.
 * Cost: about that of norma_corner_normals. */
NORMA_API norma_result norma_plan_create(const norma_mesh *mesh, norma_element of,
    float crease_angle_rad, const norma_options *options, norma_plan **plan);

/* Computes the normals of a plan's mesh at new positions: all of them, or only those that some
 * moved vertices affect. The result of a partial update is that of a full one, bit for bit.
 *
 *   plan          from norma_plan_create
 *   positions     any format and stride; as many as the mesh had
 *   moved         NULL: compute all normals. Otherwise the vertices that moved since the normals
 *                 were last up to date, in any order; repetitions are fine
 *   moved_count   elements of moved
 *   options       uses weight, fallback, normal_stride, reasons, threads, isa, parallel_for,
 *                 progress, and allocator with NORMA_FALLBACK_NEAREST. weld is the plan's. May be
 *                 NULL
 *   normals       written: one normal for each vertex or corner of the plan. With moved, only
 *                 normals and reasons that can change are written: those of all corners of faces
 *                 with a moved vertex, and those that share their sums
 *   capacity      normals that fit
 *   report        written, or NULL; counts what was written. degenerate_faces: faces whose first
 *                 corner (or its vertex) was written. Edges are not counted
 *
 * Per corner, the bits are those of norma_corner_normals with the plan's shared positions and fans.
 * Per vertex, they are the sum over the fans of the vertex's corners, or over its own corners if
 * that cancels; they equal norma_vertex_normals if those fans are all fans at the position. Faces
 * are measured at their own corners' positions, even if positions that were equal have moved apart.
 * With NORMA_FALLBACK_NEAREST, any missing normal may change: all missing ones are written, and a
 * partial update costs at least as much as a full one.
 * Errors: NORMA_ERROR_ARGUMENT if the number of positions differs; NORMA_ERROR_INDEX if moved names
 * a vertex that does not exist. Both are found before anything is written.
 * Cost: O(corners); with moved, O(normals written and the vertices around them). Double positions
 * are always all read, to find their range. */
NORMA_API norma_result norma_plan_update(const norma_plan *plan, norma_vec3_view positions,
    const uint32_t *moved, size_t moved_count, const norma_options *options, float *normals,
    size_t capacity, norma_report *report);

/* Returns the size of a plan in bytes; 0 for NULL. */
NORMA_API size_t norma_plan_bytes(const norma_plan *plan);

/* Releases a plan through its allocator. NULL is allowed. No update of the plan may be running. */
NORMA_API void norma_plan_destroy(norma_plan *plan);

/* ---- morph targets */

/* Computes the normal deltas of morph targets, sparsely: for each target the vertices whose normals
 * differ from those of the base, and the differences. Call it with vertices and deltas NULL to
 * learn the counts.
 *
 *   base            the mesh, with the positions of the base
 *   base_normals    NULL: all vertices at one (welded) position share a sum. Otherwise the normals
 *                   that the base keeps, one for each position: vertices at one position share a
 *                   sum only if they have the same normal; different ones lie across a crease
 *   targets         target_count views of positions (absolute, not displacements), each with as
 *                   many as the base
 *   target_count    number of targets
 *   smallest        deltas of at most this length are omitted; 0 or more
 *   options         weight, weld, threads, isa, allocator, parallel_for and progress are used;
 *                   fallback, normal_stride, reasons and edges are ignored. May be NULL
 *   target_starts   written: target_count + 1 offsets. Target t has the deltas from
 *                   target_starts[t] up to but not including target_starts[t + 1]
 *   vertices        written: the vertex of each delta, ascending within a target; or NULL
 *   deltas          written: three floats for each delta; or NULL
 *   capacity        deltas that fit
 *
 * A delta is the normal of the target minus that of the base, both computed by the weighted sum
 * over the shared vertices, with the target's position of the first vertex of each shared group.
 * So equal positions get equal deltas, no seam opens, and a vertex gets no delta if neither it nor
 * its faces move. Vertices without a normal in the base or in the target get no delta either.
 * Errors: those of norma_vertex_normals; NORMA_ERROR_ARGUMENT also if smallest is NaN or negative,
 * if counts differ or if target_starts is NULL. NORMA_ERROR_CAPACITY is found before anything is
 * written.
 * Cost: half as much if capacity is target_count times the number of positions, because the deltas
 * then need not be counted first. */
NORMA_API norma_result norma_morph_normals(const norma_mesh *base,
    const norma_vec3_view *base_normals, const norma_vec3_view *targets, size_t target_count,
    float smallest, const norma_options *options, size_t *target_starts, uint32_t *vertices,
    float *deltas, size_t capacity);

/* Output buffers of norma_morph_deltas. The caller owns the arrays. */
typedef struct norma_morph_output {
    size_t *target_starts; /* written: target_count + 1 offsets; required */
    uint32_t *vertices;    /* written: the vertex of each delta; or NULL */
    float *deltas;         /* written: three floats for each delta; or NULL */
    size_t capacity;       /* deltas that fit */
} norma_morph_output;

/* norma_morph_normals with its outputs in a struct; prefer it in new programs.
 *
 *   base, base_normals, targets, target_count, smallest, options   as for norma_morph_normals
 *   output                                                         the arrays to write
 *
 * Errors: those of norma_morph_normals; NORMA_ERROR_ARGUMENT also if output is NULL. */
NORMA_API norma_result norma_morph_deltas(const norma_mesh *base,
    const norma_vec3_view *base_normals, const norma_vec3_view *targets, size_t target_count,
    float smallest, const norma_options *options, const norma_morph_output *output);

/* ---- matrices
 *
 * Common to the calls from here on:
 *
 * - Ownership. Buffers belong to the caller and are used only during the call. Without a stride
 *   parameter they need the alignment of their type, with one they need none.
 * - Sizes. Counts and capacities are in elements (matrices, vectors), strides in bytes, 0 for
 *   tightly packed.
 * - Errors. NORMA_ERROR_ARGUMENT: a buffer is NULL but something has to be read or written there; a
 *   number is not a value of its enum; an output stride is shorter than one element.
 *   NORMA_ERROR_OVERFLOW: count * stride exceeds a size_t. NORMA_ERROR_CAPACITY: capacity is below
 *   count. Errors are found before anything is written. If count is 0, the result is NORMA_OK and
 *   buffers may be NULL.
 * - Memory. The calls allocate nothing.
 * - Models. Only the upper 3x3 of a model ([0..2], [4..6], [8..10]) affects normals. Translation
 *   and last row are ignored and need not be finite.
 * - Thread safety. The calls are pure functions: any number may run at once.
 * - Reproducibility. The bits are the same with every compiler, and for batches and single calls.
 *   -0 is never written into a matrix. */

/* What happens to the faces when a matrix mirrors. */
typedef enum norma_winding {
    NORMA_WINDING_KEPT = 0, /* they stay, so the surface turns inside out */
    NORMA_WINDING_REVERSED  /* the caller reverses them */
} norma_winding;

/* The kind of an upper 3x3 or of its mirror image, with a relative tolerance of 1e-5. The first
 * kind in this list that fits is chosen, but rank below 3 is always singular. A translation is an
 * identity whose [12..14] are not all zero. A mirror is never an identity or a translation:
 * reflections are mirrored rotations. */
typedef enum norma_kind {
    NORMA_KIND_IDENTITY = 0, /* entries within 1e-5 */
    NORMA_KIND_TRANSLATION,
    NORMA_KIND_ROTATION,          /* columns perpendicular and of length 1 */
    NORMA_KIND_UNIFORM_SCALE,     /* columns perpendicular and of equal length */
    NORMA_KIND_NON_UNIFORM_SCALE, /* columns perpendicular: axis scales, then a rotation */
    NORMA_KIND_SHEAR,             /* two columns with |cosine| above 1e-5 */
    NORMA_KIND_SINGULAR           /* rank below 3 */
} norma_kind;

typedef struct norma_matrix_info {
    norma_kind kind;
    int rank;           /* singular values above 1e-6 of the largest */
    int mirrored;       /* nonzero: the determinant is negative */
    double determinant; /* of the upper 3x3, correctly rounded */
    double anisotropy;  /* largest over smallest singular value; INFINITY below rank 3 */

    /* The largest angle between M n and the right normal (faces reversed under a mirror):
     * asin((a^2 - 1) / (a^2 + 1)) for an anisotropy of a (Kantorovich 1948); pi/2 below rank 3,
     * where M n is perpendicular to the right normal or one of the two is zero. */
    double worst_error_rad;

    /* A unit normal, before M, for which this error occurs: (v1 + v3) / sqrt 2 of the right
     * singular vectors with the largest and the smallest singular value. */
    float worst_normal[3];
} norma_matrix_info;

/* Computes the normal matrix of a model: the 3x3 that takes normals of faces and vertices through
 * it. Renormalise after applying it. It is cof(M) if the winding is kept, and sign(det) cof(M), the
 * direction of the inverse transpose, if it is reversed (sign(0) = 1).
 *
 *   model           sixteen floats; only the upper 3x3 is used
 *   winding         what happens to the faces if the model mirrors
 *   normal_matrix   written: nine floats, column-major; may be model itself
 *   info            written: what kind of matrix the model is; or NULL
 *
 * cof(M)(a x b) = M a x M b for every M, so there is no division and rank 2 is exact. Each entry is
 * rounded to double and then to float; its sign, whether it is zero, and the sign of the
 * determinant are exact. Entries that would overflow or underflow are scaled by a common power of
 * two: if an entry exceeds a float, or no entry of a nonzero column would remain a normal float,
 * the largest entry is brought into [1, 2), or higher if the smallest would otherwise underflow.
 * Only the direction matters. If all cofactors are exactly zero (rank 0 or 1: every face loses its
 * direction), the result is a matrix of zeros and NORMA_OK; info->rank is then 0 or 1.
 * Errors: NORMA_ERROR_ARGUMENT if the upper 3x3 is not finite; then normal_matrix is zero and info
 * describes a zero matrix.
 * Cost: about ten nanoseconds; with info one or two microseconds.
 * Source: singular values by one-sided Jacobi rotations (Hestenes 1958). */
NORMA_API norma_result norma_normal_matrix(
    const float model[16], norma_winding winding, float normal_matrix[9], norma_matrix_info *info);

/* Computes many normal matrices, with the bits of norma_normal_matrix.
 *
 *   models            count times sixteen floats
 *   count             number of models
 *   winding           as for norma_normal_matrix
 *   normal_matrices   written: count times nine floats; must not overlap models
 *   capacity          matrices that fit
 *
 * Errors: NORMA_ERROR_ARGUMENT if a model is not finite; its matrix is zero, the others are
 * computed. */
NORMA_API norma_result norma_normal_matrices(const float *models, size_t count,
    norma_winding winding, float *normal_matrices, size_t capacity);

/* Computes many normal matrices into a shader's layout. std140 has a matrix_stride of 48 and a
 * column_stride of 16.
 *
 *   models            as for norma_normal_matrices
 *   model_stride      bytes from one model to the next; 0: 64
 *   count             number of models
 *   winding           as for norma_normal_matrix
 *   normal_matrices   written: three columns of three floats each; nothing between columns
 *   matrix_stride     bytes from one matrix to the next; 0: three columns
 *   column_stride     bytes from one column to the next; 0: 12
 *   capacity          matrices that fit
 *
 * Any layout in which no two columns overlap is allowed, for example all first columns, then all
 * second ones, then all third ones.
 * Errors: those of norma_normal_matrices; NORMA_ERROR_ARGUMENT also if columns overlap. */
NORMA_API norma_result norma_normal_matrices_strided(const float *models, size_t model_stride,
    size_t count, norma_winding winding, float *normal_matrices, size_t matrix_stride,
    size_t column_stride, size_t capacity);

/* Transforms normals and makes them unit: out = normalize(normal_matrix n).
 *
 *   normal_matrix   nine floats, column-major
 *   in              normals of any format, stride and length
 *   out             written: three floats each. May begin where in.data does if out_stride is at
 *                   most the input's stride; otherwise the two must not overlap
 *   out_stride      bytes from one result to the next; 0: 12
 *   capacity        normals that fit
 *
 * Directions are right to about the last bit of a float, over the whole range of floats and
 * doubles. Zero stays zero; a normal becomes zero if it or an entry of the matrix is not finite;
 * both are NORMA_OK.
 * Cost: O(count). */
NORMA_API norma_result norma_transform_normals(const float normal_matrix[9], norma_vec3_view in,
    float *out, size_t out_stride, size_t capacity);

/* ---- matrices: double precision and other forms
 *
 * The double forms are exact before their last rounding: each cofactor and the determinant are
 * correctly rounded over the whole range of doubles. Entries that would overflow or underflow a
 * double are scaled as in norma_normal_matrix. If the upper 3x3 is not finite, the result is a
 * matrix of zeros and NORMA_ERROR_ARGUMENT. An output may be its own model. Cost: a few
 * microseconds. */

/* The cheapest correct way to transform normals. For a mirroring matrix, each gives the result of
 * NORMA_WINDING_REVERSED, which points like that of the inverse transpose. */
typedef enum norma_shortcut {
    NORMA_SHORTCUT_NONE = 0,      /* only the normal matrix is right */
    NORMA_SHORTCUT_ROTATION,      /* M itself; nothing to renormalise */
    NORMA_SHORTCUT_UNIFORM_SCALE, /* M itself, renormalised */
    NORMA_SHORTCUT_AXIS_SCALE     /* M (n / s^2), s being the lengths of M's columns */
} norma_shortcut;

/* norma_normal_matrix in double precision, with the same parameters. */
NORMA_API norma_result norma_normal_matrix_double(const double model[16], norma_winding winding,
    double normal_matrix[9], norma_matrix_info *info);

/* Computes the normal matrix of view * model, for normals in view space. It does not form the
 * product, which rounding could make singular, or invertible although it is singular: cof(V M) =
 * cof(V) cof(M), with exact signs and zeros.
 *
 *   model, view     sixteen floats each
 *   winding         as for norma_normal_matrix
 *   normal_matrix   written: nine floats, column-major
 *   info            written: that of the product; or NULL. The kind is translation if the product
 *                   moves the origin by more than 1e-5 of the terms that are summed */
NORMA_API norma_result norma_normal_matrix_model_view(const float model[16], const float view[16],
    norma_winding winding, float normal_matrix[9], norma_matrix_info *info);

/* Computes cof(M): the transpose of the adjugate, and det(M) times the inverse transpose if M is
 * invertible. It transforms area vectors (a face's area times its normal) exactly. The same as
 * norma_normal_matrix_double with NORMA_WINDING_KEPT.
 *
 *   model      sixteen doubles
 *   cofactor   written: nine doubles, column-major */
NORMA_API norma_result norma_cofactor_matrix(const double model[16], double cofactor[9]);

/* Computes the inverse transpose, (M^-1)^T = cof(M) / det(M), each entry within two units in the
 * last place.
 *
 *   model               sixteen doubles
 *   inverse_transpose   written: nine doubles, column-major
 *
 * Errors: NORMA_ERROR_ARGUMENT if M is exactly singular; then nothing is written. */
NORMA_API norma_result norma_inverse_transpose(const double model[16], double inverse_transpose[9]);

/* Returns the shortcut that a kind of matrix allows: rotation for identity, translation and
 * rotation; uniform scale and axis scale for uniform and non-uniform scale; none for shear and
 * singular.
 *
 *   info   from norma_normal_matrix; NULL: none */
NORMA_API norma_shortcut norma_matrix_shortcut(const norma_matrix_info *info);

/* Computes M diag(1/s^2), that is each column of M divided by its squared length. For perpendicular
 * columns this is the inverse transpose: R diag(s) becomes R diag(1/s) (NORMA_SHORTCUT_AXIS_SCALE).
 * For other matrices it is wrong; this is not checked.
 *
 *   model           sixteen doubles
 *   normal_matrix   written: nine doubles, column-major
 *
 * Errors: NORMA_ERROR_ARGUMENT if a column is zero; then nothing is written. */
NORMA_API norma_result norma_axis_scale_matrix(const double model[16], double normal_matrix[9]);

/* ---- positions, tangents and winding under a matrix */

/* Transforms points: out = A p + t, A being the upper 3x3 and t = [12..14]. The last row is
 * ignored; there is no division by w.
 *
 *   model        sixteen doubles
 *   in           positions of any format and stride
 *   out          written: three floats each; may overlap in as in norma_transform_normals
 *   out_stride   bytes from one result to the next; 0: 12
 *   capacity     positions that fit
 *
 * Computed in double precision in one order, ((a x + b y) + c z) + t, then rounded. NaN and
 * infinity stay; values that exceed a float become infinite.
 * Cost: O(count). */
NORMA_API norma_result norma_transform_positions(
    const double model[16], norma_vec3_view in, float *out, size_t out_stride, size_t capacity);

/* norma_transform_positions with doubles as the result; out_stride 0: 24. */
NORMA_API norma_result norma_transform_positions_double(
    const double model[16], norma_vec3_view in, double *out, size_t out_stride, size_t capacity);

/* Transforms tangents: M t made perpendicular to the transformed normal and unit. A tangent is
 * x, y, z, sign; the bitangent is sign * cross(normal, tangent). The sign is multiplied by that of
 * the determinant.
 *
 *   model            sixteen floats, all finite in the upper 3x3
 *   tangents         four floats each
 *   tangent_stride   bytes from one tangent to the next; 0: 16
 *   normals          the transformed normals, from norma_transform_normals with a matrix for
 *                    NORMA_WINDING_REVERSED; at least count, of any format and length
 *   count            number of tangents
 *   out              written: four floats each; may be tangents itself with the same stride
 *   out_stride       bytes from one result to the next; 0: 16
 *   capacity         tangents that fit
 *
 * An arbitrary but reproducible perpendicular vector is used if at most 2^-20 of a tangent remains
 * after its part along the normal is removed, or if M t is zero or not finite. If a normal is zero
 * or not finite, its tangent need not be perpendicular to it.
 * Cost: O(count). Source: the convention of glTF and of Mikkelsen 2008. */
NORMA_API norma_result norma_transform_tangents(const float model[16], const float *tangents,
    size_t tangent_stride, norma_vec3_view normals, size_t count, float *out, size_t out_stride,
    size_t capacity);

/* Makes tangents perpendicular to new normals (Gram-Schmidt) and keeps their signs. The parameters
 * are those of norma_transform_tangents. */
NORMA_API norma_result norma_orthogonalise_tangents(const float *tangents, size_t tangent_stride,
    norma_vec3_view normals, size_t count, float *out, size_t out_stride, size_t capacity);

/* Reverses the winding of every face in place: all corners but the first change their order.
 *
 *   corners        corner_count indices
 *   corner_size    bytes of one index: 4 (or 0), 2 or 1
 *   corner_count   number of corners; without face_starts a multiple of three
 *   face_starts    face_count + 1 offsets that run from 0 to corner_count and never decrease; NULL:
 *                  triangles
 *   face_count     number of faces; ignored without face_starts
 *
 * Data of corners (hard edges, normals per corner) is not moved.
 * Cost: O(corner_count). */
NORMA_API norma_result norma_reverse_winding(void *corners, size_t corner_size, size_t corner_count,
    const uint32_t *face_starts, size_t face_count);

/* ---- orientation */

/* How open parts of a surface are oriented. */
typedef enum norma_orient_open {
    NORMA_ORIENT_OPEN_KEPT = 0, /* as most of their faces are */
    NORMA_ORIENT_OPEN_BY_RAYS   /* by rays: the side from which more of them leave the scene */
} norma_orient_open;

typedef struct norma_orient_report {
    /* Sets of faces connected by shared edges, separated at edges of more than two faces. Each part
     * is closed, open or one-sided. */
    size_t parts;
    /* One-sided: no winding is consistent (a Moebius band); the faces are left as they are. */
    size_t closed, open, one_sided;
    size_t inward; /* closed parts that faced inward after their winding was made consistent */
    size_t nested; /* solids directly inside a solid, left as they are: cavities with the wrong
                    * winding, or separate bodies */

    /* Open parts: turned or confirmed by rays; undecided ones are left as most of their faces
     * were. */
    size_t by_rays, undecided;
    /* The least of these: (rays for the decision - rays against it) / rays; 1 if by_rays is 0. */
    double least_confidence;

    size_t reversed_faces;
    /* Before the change: edges of exactly two faces that run the same way; edges of more than two
     * faces. */
    size_t winding_conflicts, non_manifold_edges;
} norma_orient_report;

/* Finds the faces whose winding should be reversed so that neighbours agree and closed surfaces
 * face outward. The mesh is not changed: reverse a face by swapping two of its corners.
 *
 *   mesh       the faces
 *   open       what to do with open parts
 *   options    uses weld, threads, parallel_for, allocator and progress; may be NULL
 *   reverse    written: 1 or 0 for each face
 *   capacity   faces that fit
 *   report     written; or NULL
 *
 * Each part first gets the winding of most of its faces. A closed part is then turned outward by
 * the sign of its volume. Cavities stay cavities: parts are judged from outside in, and a part with
 * negative volume directly inside a solid (the smallest part that contains it, by winding numbers)
 * is kept. Open parts keep the winding of most of their faces, or are turned by rays, 64 to each
 * side of a part: outward is the side from which more of them leave the scene. A part for which the
 * difference is less than a quarter of the rays is undecided, and kept. A part counts as closed if
 * its own faces cancel at each edge, even if other parts touch it there. The result is the same for
 * any number of threads. Errors: those of norma_face_normals. Cost: O(corners * log valence), plus
 * O(parts log parts + parts log faces) for nesting and rays: if surfaces lie so densely that rays
 * would cost more, fewer rays are cast. Source: Takayama, Jacobson, Kavan, Sorkine-Hornung 2014
 * (rays). */
NORMA_API norma_result norma_orient(const norma_mesh *mesh, norma_orient_open open,
    const norma_options *options, uint8_t *reverse, size_t capacity, norma_orient_report *report);

/* ---- comparing two surfaces */

/* A mesh, and the normals of its corners. */
typedef struct norma_surface {
    norma_mesh mesh;
    norma_vec3_view normals; /* of any format and length */

    /* For each corner the index of its normal, UINT32_MAX for none. NULL: that of its position. */
    const uint32_t *corner_normals;
} norma_surface;

/* What norma_compare finds at one corner. */
typedef struct norma_compare_sample {
    /* The corner's share of the area of its face. 0: the face has no direction, or the position of
     * the corner is not finite; nothing is compared there. */
    double area;
    float angle_rad; /* between the two normals; -1: one of them does not exist */
    float distance;  /* from the corner to the base, in the units of the positions; -1: unknown */
    uint32_t face;   /* of the base, with the nearest point; UINT32_MAX: none */
    float normal[3]; /* of the base at that point; zero: none */
} norma_compare_sample;

/* Compares the normals at the corners of one surface with those of another.
 *
 *   base         the surface that is right
 *   other        the surface that is compared with it
 *   options      uses threads, parallel_for, allocator and progress; may be NULL
 *   samples      written: one for each corner of other
 *   capacity     samples that fit
 *   same_faces   written: nonzero if corners were compared with corners; or NULL
 *
 * If both have the same faces, each corner is compared with the same corner of base. The faces are
 * the same if they have the same numbers of corners in the same order, and no corner is further
 * from its counterpart than a quarter of the shortest edge of the face, or 2^-20 of the size of
 * base.
 * Otherwise each corner is compared with the nearest point of base. The normals of base are
 * interpolated there, each made unit first; polygons are cut into triangles. If several triangles
 * are equally near, within 2^-20 of the size of base, the one whose direction is nearest to that of
 * the corner's own face counts, so a corner at a crease is compared with its own side; among
 * triangles of that direction (within 2^-20 in its cosine), the one whose normal differs least.
 * If even that one faces more than 30 degrees away from the corner's face, the nearest triangle
 * that does not is taken instead, if it is within an eighth of the face's shortest edge: a corner
 * that a compression has moved over a crease. A corner of base without a normal (UINT32_MAX, zero,
 * not finite) has that of its triangle. Errors: those of norma_face_normals for both meshes;
 * NORMA_ERROR_ARGUMENT also if a surface has corners but no normals; NORMA_ERROR_INDEX also if a
 * corner refers to a normal that does not exist; NORMA_ERROR_OVERFLOW also if the search would open
 * more boxes of triangles than 2^22 and 2000 for each point of other and each triangle of base, as
 * where all triangles are equally far from all points. Cost: O(n log n); O(n) if the faces are
 * the same.
 * Source: nearest points by Ericson 2005 (Real-Time Collision Detection, 5.1.5). */
NORMA_API norma_result norma_compare(const norma_surface *base, const norma_surface *other,
    const norma_options *options, norma_compare_sample *samples, size_t capacity, int *same_faces);

/* How much two surfaces differ. Percentiles and shares are of area: half of the area differs by at
 * most p50_rad. */
typedef struct norma_comparison {
    size_t corners; /* with area and an angle */
    size_t missing; /* with area but without an angle; no percentile includes them */
    double area;    /* of both */
    double p50_rad, p99_rad, max_rad;
    double p50_distance, p99_distance, max_distance;

    /* The part of the area whose angle is above the largest allowed one (by more than 1e-6), or
     * missing; from 0 to 1. */
    double share_above;
    size_t worst; /* the first sample with max_rad; SIZE_MAX: none */
} norma_comparison;

/* Sums up what norma_compare found, in one call or in several.
 *
 *   samples         from norma_compare
 *   count           number of samples
 *   max_angle_rad   the largest allowed angle, 0 or more
 *   options         uses the allocator; may be NULL
 *   comparison      written; all zero if no sample has an area
 *
 * Errors: NORMA_ERROR_ARGUMENT if samples or comparison is NULL, or max_angle_rad is NaN or
 * negative. Cost: O(count). */
NORMA_API norma_result norma_compare_summary(const norma_compare_sample *samples, size_t count,
    double max_angle_rad, const norma_options *options, norma_comparison *comparison);

/* ---- nearest points */

/* The nearest point of a mesh. */
typedef struct norma_closest {
    double point[3];
    double distance;     /* -1: none */
    uint32_t face;       /* UINT32_MAX: none */
    uint32_t corners[3]; /* of that face; numbers as in norma_corner_normals */
    double weights[3];   /* of these corners at the point; their sum is 1 */
} norma_closest;

/* Finds the points of a mesh that are nearest to others.
 *
 *   mesh       any faces; polygons are cut into triangles
 *   points     in the coordinates of the mesh
 *   options    uses threads, parallel_for, allocator and progress; may be NULL
 *   found      written: one for each point; none if the mesh has no triangle with an area, or if
 *              the point is not finite, is further away than DBL_MAX, or has a coordinate beyond
 *              2^300 (beyond 2^300 times the largest of the mesh where that is not within 2^-200
 *              to 2^200)
 *   capacity   results that fit
 *
 * Errors: those of norma_face_normals. Cost: O((faces + points) log faces); O(faces) for a point
 * that many triangles are equally far from, as one so far away that doubles do not tell them apart.
 * Source: Ericson 2005 (Real-Time Collision Detection, 5.1.5). */
NORMA_API norma_result norma_closest_points(const norma_mesh *mesh, norma_vec3_view points,
    const norma_options *options, norma_closest *found, size_t capacity);

/* ---- packing: signed normalised integers, as in glTF
 *
 * A code c means max(c / 127, -1) with 8 bits and max(c / 32767, -1) with 16. */

/* Encodes normals as three signed bytes each. Each gets the nearest code (by Euclidean distance)
 * whose length the glTF validator accepts as unit.
 *
 *   normals      any format, stride and length; made unit first
 *   out          written: three codes each. glTF pads three bytes to four; the fourth is not
 *                written
 *   out_stride   bytes from one result to the next; 0: tightly packed
 *   capacity     normals that fit
 *
 * The direction is within 0.3907 degrees. A length is accepted if | length - 1 | <= 0.00674, the
 * rule of the Khronos glTF validator. -n gets the negated code of n. Zero and values that are not
 * finite become zero.
 * Cost: O(count). */
NORMA_API norma_result norma_encode_snorm8(
    norma_vec3_view normals, int8_t *out, size_t out_stride, size_t capacity);

/* norma_encode_snorm8 with 16-bit codes; the direction is within 0.00151 degrees. */
NORMA_API norma_result norma_encode_snorm16(
    norma_vec3_view normals, int16_t *out, size_t out_stride, size_t capacity);

/* Decodes 8-bit codes to floats, correctly rounded and not renormalised.
 *
 *   codes        three codes each
 *   stride       bytes from one normal's codes to the next's; 0: tightly packed
 *   count        number of normals
 *   out          written: three floats each
 *   out_stride   bytes from one result to the next; 0: 12
 *   capacity     normals that fit
 *
 * Cost: O(count). */
NORMA_API norma_result norma_decode_snorm8(const int8_t *codes, size_t stride, size_t count,
    float *out, size_t out_stride, size_t capacity);

/* norma_decode_snorm8 with 16-bit codes. */
NORMA_API norma_result norma_decode_snorm16(const int16_t *codes, size_t stride, size_t count,
    float *out, size_t out_stride, size_t capacity);

/* ---- unit vectors in few bits, within a proven angle
 *
 * A code is 32 bits wide and holds two or three signed numbers, x in its lowest bits. A number of b
 * bits means max(c / (2^(b - 1) - 1), -1). */

typedef enum norma_encoding {
    /* Octahedral (Meyer et al. 2010): two numbers of 8, 12 or 16 bits; higher bits are 0. They mean
     * the direction of (x, y, 1 - |x| - |y|) if its z is not negative, else that of (sx (1 - |y|),
     * sy (1 - |x|), 1 - |x| - |y|), where sx and sy are the signs of x and y. */
    NORMA_ENCODING_OCT8 = 0,
    NORMA_ENCODING_OCT12,
    NORMA_ENCODING_OCT16,
    /* Three numbers of 10 bits; the two highest bits are 0: VK_FORMAT_A2B10G10R10_SNORM_PACK32.
     * They mean the direction of (x, y, z). */
    NORMA_ENCODING_10_10_10_2
} norma_encoding;

/* Returns the largest angle, in radians, between any unit vector and what norma_decode_normals
 * returns for its code; INFINITY for a value that is not an encoding.
 *
 *   encoding   the encoding: 0.638 degrees for OCT8, 0.0396 for OCT12, 0.00248 for OCT16 and 0.0793
 *              for 10_10_10_2
 *
 * The angles were proven by interval arithmetic over all codes; the proof is one of the tests. Any
 * thread, any time. */
NORMA_API double norma_encoding_error_rad(norma_encoding encoding);

/* Encodes normals. Each gets the code whose decoded vector is nearest in angle, compared exactly;
 * of several, the lowest code. With NORMA_ENCODING_10_10_10_2, only codes are considered whose
 * three numbers are each less than one step from 511 n, so that readers that do not make vectors
 * unit get almost unit ones.
 *
 *   normals    any format, stride and length; made unit first
 *   encoding   the encoding
 *   codes      written: one for each normal
 *   stride     bytes from one code to the next; 0: 4
 *   capacity   codes that fit
 *   report     written; or NULL: cancelled counts zero normals, non_finite those that are not
 * finite
 *
 * Normals without a direction are encoded as (0, 0, 1). Numbers of octahedral codes go down to
 * -2^(b
 * - 1), which means -1 as well and is the lower code. The codes are the same on any machine.
 * Errors: NORMA_ERROR_ARGUMENT, NORMA_ERROR_CAPACITY and NORMA_ERROR_OVERFLOW; then nothing has
 * been written. Cost: O(count); no memory. */
NORMA_API norma_result norma_encode_normals(norma_vec3_view normals, norma_encoding encoding,
    uint32_t *codes, size_t stride, size_t capacity, norma_report *report);

/* Decodes normals: the formula of norma_encoding, in floats, made unit.
 *
 *   codes           the codes; unused high bits are ignored
 *   stride          bytes from one code to the next; 0: 4
 *   count           number of codes
 *   encoding        the encoding
 *   normals         written: three floats each, unit; (0, 0, 1) for three zeros
 *   normal_stride   bytes from one normal to the next; 0: 12
 *
 * The floats are the same on any machine, and those of points that differ only in signs or in the
 * order of axes differ only in these. Errors: NORMA_ERROR_ARGUMENT and NORMA_ERROR_OVERFLOW; then
 * nothing has been written. Cost: O(count). */
NORMA_API norma_result norma_decode_normals(const uint32_t *codes, size_t stride, size_t count,
    norma_encoding encoding, float *normals, size_t normal_stride);

/* ---- tangents of corners, from normals and texture coordinates */

/* An attribute of corners besides their positions: normals of three numbers or texture coordinates
 * of two. 8- and 16-bit numbers stand for v / 255 and v / 65535, signed ones for v / 127 and v /
 * 32767 (at least -1), rounded to floats. */
typedef struct norma_attribute {
    const void *data;
    size_t count;  /* values */
    size_t stride; /* bytes from one value to the next; 0: tightly packed */
    norma_format format;

    /* Per vertex: one value for each position, chosen by mesh->corners. Per corner: one value for
     * each corner, in order. Ignored if corners is given. */
    norma_element of;
    const uint32_t *corners; /* the value of each corner; or NULL */
} norma_attribute;

typedef enum norma_tangent_mode {
    /* Independent of the order of faces and corners. Tangents are unit and perpendicular to the
     * normal, have one sign for each face, and are weighted by options->weight. */
    NORMA_TANGENTS_STEADY = 0,
    /* The bits of MikkTSpace (Mikkelsen 2008), for triangles and quads in the given order. */
    NORMA_TANGENTS_MIKK
} norma_tangent_mode;

/* Computes the tangent of each corner: x, y, z and a sign. The bitangent is
 * sign * cross(normal, tangent) for the texture coordinates as they are given; glTF, whose v runs
 * downwards, needs the sign negated.
 *
 *   mesh        the faces
 *   normals     one value for each position or corner, of any length in steady mode
 *   texcoords   one value for each position or corner
 *   mode        steady or MikkTSpace
 *   options     uses weight (steady), normal_stride, reasons, threads, isa, allocator, parallel_for
 *               and progress; weld and fallback are ignored. May be NULL
 *   tangents    written: four floats for each corner, options->normal_stride bytes apart (0: 16)
 *   capacity    corners that fit
 *   report      written, or NULL: degenerate_faces, non_finite and cancelled count corners by
 *               reason
 *
 * Corners share a tangent only if position, normal and texture coordinates are equal (-0 = 0).
 *
 * NORMA_TANGENTS_MIKK gives the floats of MikkTSpace's reference with its default settings,
 * compiled without contraction of products and sums, with every run of its edges sorted. Doubles
 * are first rounded to floats. Quads are cut along the diagonal that is shorter in texture space,
 * then in space. Larger polygons are first cut into triangles; a corner takes the tangent of the
 * first one that contains it. There is one exception: if more than 2,048 corners meet at a vertex
 * and some of their tangents are opposed to each other, each has its own triangle's tangent there.
 *
 * NORMA_TANGENTS_STEADY takes the direction in which u grows in each face, made perpendicular to
 * the normal, and sums it over the corners that share a tangent and whose faces have the same sign
 * of texture area, weighted by options->weight (NORMA_WEIGHT_VISIBLE counts as
 * NORMA_WEIGHT_UNIFORM). |tangent . normal| is at most 1e-6 for unit normals.
 *
 * A corner without a tangent gets a unit vector perpendicular to its normal, the sign that its face
 * got from its neighbours (+1 if it got none), and a reason. NORMA_REASON_NON_FINITE: its position,
 * normal or texture coordinates are not finite. NORMA_REASON_DEGENERATE: no face with texture area
 * contributes to it. NORMA_REASON_CANCELLED: the directions around it cancel each other.
 *
 * Errors: those of norma_corner_normals; NORMA_ERROR_ARGUMENT also for an unknown mode or format
 * and for fewer values than positions or corners; NORMA_ERROR_INDEX for a corner whose value does
 * not exist.
 * Cost: O(corners + positions), whatever the valence. In MikkTSpace mode, corners at a vertex where
 * tangents are opposed to each other are compared in pairs, up to 2,048 of them. The bits are the
 * same for any number of threads. */
NORMA_API norma_result norma_corner_tangents(const norma_mesh *mesh, const norma_attribute *normals,
    const norma_attribute *texcoords, norma_tangent_mode mode, const norma_options *options,
    float *tangents, size_t capacity, norma_report *report);

/* ---- tangents of meshes that move
 *
 * Topology and texture coordinates stay the same; positions and normals change. A tangent plan
 * stores which corners a vertex that moves can affect, so that an update computes those alone. Its
 * tangents, reasons and report are always those of norma_corner_tangents, bit for bit, also where
 * equal positions or normals separate, others become equal, or a quad has to be cut along its other
 * diagonal.
 *
 * - Thread safety. An update does not change the plan. Any number of updates of one plan may run at
 *   once, each with its own output.
 * - Memory. An update takes scratch memory from the allocator of its options. */

typedef struct norma_tangent_plan norma_tangent_plan;

/* Makes a tangent plan of a mesh.
 *
 *   mesh, normals, texcoords   as for norma_corner_tangents; read during the call only
 *   mode                       steady or MikkTSpace
 *   options                    uses threads, isa, parallel_for, progress and allocator; other
 *                              options are ignored. The allocator must live as long as the plan.
 *                              May be NULL
 *   plan                       written on success; release it with norma_tangent_plan_destroy
 *
 * Errors: those of norma_corner_tangents; NORMA_ERROR_ARGUMENT also if plan is NULL.
 * Cost: about half that of norma_corner_tangents. */
NORMA_API norma_result norma_tangent_plan_create(const norma_mesh *mesh,
    const norma_attribute *normals, const norma_attribute *texcoords, norma_tangent_mode mode,
    const norma_options *options, norma_tangent_plan **plan);

/* Computes the tangents of a plan's mesh at new positions and normals: all of them, or only those
 * that some moved vertices affect.
 *
 *   plan          from norma_tangent_plan_create
 *   positions     any format and stride; as many as the mesh had
 *   normals       as for norma_corner_tangents. One for each position, without corners of their
 *                 own, if both normals and texture coordinates were so at creation; otherwise in
 *                 any layout
 *   moved         NULL: compute all tangents. Otherwise the vertices that moved since the tangents
 *                 were last up to date, in any order; repetitions are fine. Normals may have
 *                 changed at the positions of all faces with a moved vertex, as norma_plan_update
 *                 changes them. List other vertices with a new normal too, and vertices whose
 *                 normal was NaN or infinite
 *   moved_count   elements of moved
 *   options       uses weight (steady), normal_stride, reasons, threads, isa, parallel_for,
 *                 progress and allocator. May be NULL
 *   tangents      written: four floats for each corner, options->normal_stride bytes apart (0: 16).
 *                 With moved, only tangents and reasons that can change are written
 *   capacity      corners that fit
 *   report        written, or NULL; counts what was written
 *
 * With moved, all tangents are written in four cases: much of the mesh is affected; a face without
 * texture area is affected; in MikkTSpace mode, a quad with two equal positions is affected, or the
 * mesh has faces of more than four corners.
 * Errors: those of norma_corner_tangents; NORMA_ERROR_ARGUMENT also if plan is NULL or the number
 * of positions differs; NORMA_ERROR_INDEX also if moved names a vertex that does not exist. All are
 * found before anything is written.
 * Cost: O(corners + positions), that of norma_corner_tangents. With moved, O(tangents
 * written and the faces around them), plus a byte to clear for each position, face and vertex. */
NORMA_API norma_result norma_tangent_plan_update(const norma_tangent_plan *plan,
    norma_vec3_view positions, const norma_attribute *normals, const uint32_t *moved,
    size_t moved_count, const norma_options *options, float *tangents, size_t capacity,
    norma_report *report);

/* Returns the size of a tangent plan in bytes; 0 for NULL. */
NORMA_API size_t norma_tangent_plan_bytes(const norma_tangent_plan *plan);

/* Releases a tangent plan through its allocator. NULL is allowed. No update of the plan may be
 * running. */
NORMA_API void norma_tangent_plan_destroy(norma_tangent_plan *plan);

/* ---- an indexed mesh out of values per corner
 *
 * Often each corner has its own normal, texture coordinates, tangent and colour. Vertex buffers
 * need an index for each corner instead: the number of its vertex. Corners whose values agree in
 * every byte become one vertex. */

/* An array with a value for each corner, of any type: its bytes are compared and copied as they
 * are, so 0 and -0 differ, and equal NaNs do not. */
typedef struct norma_stream {
    const void *data;
    size_t count;            /* values */
    size_t size;             /* bytes of one value */
    size_t stride;           /* bytes from one value to the next; 0: tightly packed */
    const uint32_t *corners; /* the value of each corner; NULL: corner c has value c */
} norma_stream;

/* Output buffers for an indexed mesh. The caller owns both arrays. */
typedef struct norma_indexed {
    void *corners;          /* written: the new vertex of each corner; or NULL */
    size_t corner_size;     /* bytes of one of them: 4 (or 0), 2 */
    size_t corner_capacity; /* corners that fit */
    /* Written: for each new vertex the first corner that uses it, from which to copy other values;
     * or NULL. */
    uint32_t *source_corners;
    size_t vertex_capacity; /* elements that fit in source_corners */
    size_t vertex_count;    /* written on success: the number of new vertices */
} norma_indexed;

/* Returns the bytes of an index: 2 if 16 bits are enough for this many vertices, otherwise 4. The
 * 16-bit index 65535 is never used, because graphics interfaces restart primitives at it.
 *
 *   vertex_count   any number */
NORMA_API size_t norma_index_size(size_t vertex_count);

/* Finds the corners that agree in all streams and numbers them as vertices. Call it with corners
 * and source_corners NULL to learn vertex_count, and with it the size of the indices.
 *
 *   streams        at least one; each with a value for each corner
 *   stream_count   number of streams
 *   corner_count   number of corners
 *   options        uses threads, allocator, parallel_for and progress; may be NULL
 *   indexed        read and written
 *
 * New vertices are numbered in the order in which corners first use them, whatever the number of
 * threads.
 * Errors: NORMA_ERROR_ARGUMENT if an array that has to be read is NULL, if a size is 0, if a stream
 * without corners has fewer values than there are corners or if corner_size is neither 4, 0 nor 2;
 * NORMA_ERROR_INDEX if a corner names no value; NORMA_ERROR_OVERFLOW if a size does not fit, also
 * if there are more vertices than indices of 16 bits can number; NORMA_ERROR_CAPACITY,
 * NORMA_ERROR_MEMORY and NORMA_CANCELLED. norma_find_stream_fault names the argument and the
 * element. After an error nothing has been written.
 * Cost: O(bytes of all corners' values), by hashing; 12 to 24 bytes of scratch memory for each
 * corner. */
NORMA_API norma_result norma_index_corners(const norma_stream *streams, size_t stream_count,
    size_t corner_count, const norma_options *options, norma_indexed *indexed);

/* Finds out why norma_index_corners returned an error.
 *
 *   streams        as given to the call
 *   stream_count   as given to the call
 *   corner_count   as given to the call
 *   options        as given to the call; may be NULL
 *   fault          written; or NULL. index: the stream; for "streams->corners" the first corner
 *                  that names no value, in the first stream that has one
 *
 * Returns what the call would return for these arguments. If it returns NORMA_OK and the call
 * failed, the output buffers were at fault. Cost: O(corners), on the calling thread. Allocates
 * nothing. */
NORMA_API norma_result norma_find_stream_fault(const norma_stream *streams, size_t stream_count,
    size_t corner_count, const norma_options *options, norma_fault *fault);

/* Copies a stream's values to new vertices.
 *
 *   stream       the values
 *   sources      for each new vertex the corner (or, for a stream without corners, the value) that
 *                it takes: source_corners of norma_indexed, or source_vertices of norma_split
 *   count        number of new vertices
 *   out          written: count values of stream->size bytes. Must not overlap the stream
 *   out_stride   bytes from one value to the next, at least stream->size; 0: tightly packed.
 *                Nothing is written between them
 *   capacity     values that fit
 *
 * Errors: NORMA_ERROR_ARGUMENT, NORMA_ERROR_CAPACITY, NORMA_ERROR_OVERFLOW; NORMA_ERROR_INDEX if a
 * source names no value; all found before anything is written. If stream->corners is given, every
 * source must be below the number of its corners, which is not checked.
 * Cost: O(count). */
NORMA_API norma_result norma_copy_values(const norma_stream *stream, const uint32_t *sources,
    size_t count, void *out, size_t out_stride, size_t capacity);

/* Computes the tangents of norma_corner_tangents and the indexed mesh that carries them: corners
 * with the same bytes of position, normal, texture coordinates and tangent are one vertex. Call it
 * with corners, source_corners and tangents NULL to learn vertex_count.
 *
 *   mesh, normals, texcoords, mode   as for norma_corner_tangents
 *   options    as for norma_corner_tangents; reasons: one for each corner
 *   tangents   written: four floats for each new vertex, options->normal_stride bytes apart (0:
 *              16), as many as indexed->vertex_capacity says; or NULL
 *   indexed    read and written as by norma_index_corners; not mesh->corners
 *   report     written, counting corners; or NULL
 *
 * Take the other values of a new vertex from its source corner with norma_copy_values. Where other
 * streams differ too, compute tangents per corner and give them to norma_index_corners as one more
 * stream.
 * Errors: those of norma_corner_tangents and of norma_index_corners. reasons and report are written
 * even if an output buffer turns out to be too small.
 * Cost: that of both, and 16 bytes of scratch memory for each corner. */
NORMA_API norma_result norma_split_tangents(const norma_mesh *mesh, const norma_attribute *normals,
    const norma_attribute *texcoords, norma_tangent_mode mode, const norma_options *options,
    float *tangents, norma_indexed *indexed, norma_report *report);

/* Output buffers of norma_build. The caller owns the arrays; each may be NULL. The
 * vertex_capacity of indexed holds for source_corners, source_vertices, normals and tangents. */
typedef struct norma_built {
    norma_indexed indexed;     /* the new vertex of each corner, the first corner of each vertex */
    uint32_t *source_vertices; /* written: the position of each new vertex */
    float *normals;            /* written: three floats for each new vertex */
    size_t normal_stride;      /* bytes from one to the next; 0: 12 */
    float *tangents;           /* written: four floats for each new vertex; needs texcoords */
    size_t tangent_stride;     /* bytes from one to the next; 0: 16 */
} norma_built;

/* Makes a graphics card's mesh out of arrays: computes the normals of norma_corner_normals, with
 * texture coordinates the tangents of norma_corner_tangents, and an index for each corner. Call it
 * with all arrays of built NULL to learn built->indexed.vertex_count, and with that the size of the
 * indices (norma_index_size).
 *
 *   mesh               the faces
 *   texcoords          one value for each position or corner; NULL: no tangents
 *   crease_angle_rad   as for norma_corner_normals; pi lets every edge be smooth
 *   mode               of the tangents: steady or MikkTSpace; ignored without texcoords
 *   options            as for norma_corner_normals; normal_stride is ignored. reasons: one for each
 *                      corner, of its normal. May be NULL
 *   built              read and written; indexed.corners is not mesh->corners
 *   report             written, counting the corners' normals; or NULL
 *
 * Corners become one vertex if they name the same position and agree in every byte of normal,
 * texture coordinates and tangent. In a mesh without corners, equal bytes of positions are the same
 * position. Vertices are numbered in the order in which corners first use them. Copy texture
 * coordinates, colours and whatever else a vertex has from its source corner or source vertex with
 * norma_copy_values.
 * Errors: those of norma_corner_normals, norma_corner_tangents and norma_index_corners;
 * NORMA_ERROR_ARGUMENT also for tangents without texcoords. After an error nothing has been
 * written. Cost: that of the three calls; 16 bytes of scratch memory for each corner, 16 more with
 * texcoords, 4 more if the mesh's corners are not 32-bit indices. */
NORMA_API norma_result norma_build(const norma_mesh *mesh, const norma_attribute *texcoords,
    float crease_angle_rad, norma_tangent_mode mode, const norma_options *options,
    norma_built *built, norma_report *report);

/* ---- skins: positions, normals and tangents of vertices that several joints move
 *
 * Each vertex has a matrix B of its own, blended in double precision from the matrices of its
 * joints, in ascending order of influence. A joint that weighs 0 is not read.
 *
 * - Options. The calls use threads, isa, normal_stride (bytes between vectors of the output),
 *   fallback (zero or given), reasons, allocator, parallel_for and progress. options may be NULL.
 * - Output. Each vector is written once; in place is fine, with the same stride. The bits are the
 *   same for any number of threads and on any machine.
 * - Errors. NORMA_ERROR_INDEX: a joint number is not below joint_count. NORMA_ERROR_ARGUMENT: a
 *   weight is not finite, or one of the twelve numbers of a matrix that a vertex uses; fewer
 * vectors than vertices; NORMA_FALLBACK_NEAREST; a NULL array that has to be read or written. Also
 *   NORMA_ERROR_CAPACITY, NORMA_ERROR_OVERFLOW, NORMA_ERROR_MEMORY and NORMA_CANCELLED. All but the
 *   last two are found before anything is written; norma_find_skin_fault names the argument and the
 *   element.
 * - Cost. O(vertices * influences + joints); 168 bytes of scratch memory for each joint. */

typedef enum norma_blend {
    /* B is the weighted sum of the joints' matrices, as in glTF. */
    NORMA_BLEND_LINEAR = 0,
    /* Rotations and translations are blended as dual quaternions, the stretch of each matrix (its
     * right polar factor: scale and shear) linearly before them (Kavan et al. 2008). */
    NORMA_BLEND_DUAL_QUATERNION
} norma_blend;

/* Which joints move each vertex, and how much. */
typedef struct norma_skin {
    /* Sixteen floats for each joint, column-major: the joint's world matrix times its inverse bind
     * matrix. The last row is ignored. */
    const float *matrices;
    size_t joint_count;
    const void *joints;   /* for each vertex, influences joint numbers */
    size_t joint_size;    /* bytes of a joint number: 2 (or 0), 1 or 4 */
    const float *weights; /* for each vertex, influences weights; neither normalised nor clamped */
    size_t influences;    /* joints of each vertex, 1 to 64 */
    size_t vertex_count;
    norma_blend blend;
} norma_skin;

/* Moves positions: B p, in double precision, rounded once.
 *
 *   skin       the joints of each vertex
 *   in         a position for each vertex, in the space in which the skin was bound
 *   options    see above; may be NULL
 *   out        written: three floats for each vertex
 *   capacity   positions that fit */
NORMA_API norma_result norma_skin_positions(const norma_skin *skin, norma_vec3_view in,
    const norma_options *options, float *out, size_t capacity);

/* Turns normals: sign(det B) cof(B) n, made unit: the normal matrix of the blend, not the blend of
 * normal matrices. It ignores how the weights differ from vertex to vertex (Tarini et al. 2014).
 *
 *   skin       the joints of each vertex
 *   in         a normal for each vertex, of any length
 *   options    see above; may be NULL
 *   out        written: three floats for each vertex, unit, within 2e-7 rad of the exact direction
 *              for the given floats, or the fallback
 *   capacity   normals that fit
 *   report     written; or NULL: cancelled counts zero normals and those of which a singular B
 *              leaves nothing, non_finite those that are not finite */
NORMA_API norma_result norma_skin_normals(const norma_skin *skin, norma_vec3_view in,
    const norma_options *options, float *out, size_t capacity, norma_report *report);

/* Turns tangents: B t, made perpendicular to the skinned normal as norma_transform_tangents does;
 * the sign is negated if B mirrors.
 *
 *   skin              the joints of each vertex
 *   in                four floats for each vertex, tightly packed: the tangent and its sign
 *   skinned_normals   the normals that norma_skin_normals wrote
 *   options           see above; normal_stride 0: 16. May be NULL
 *   out               written: four floats for each vertex
 *   capacity          tangents that fit */
NORMA_API norma_result norma_skin_tangents(const norma_skin *skin, const float *in,
    norma_vec3_view skinned_normals, const norma_options *options, float *out, size_t capacity);

/* Finds out why a call on a skin returned an error: the argument, and the element in it.
 *
 *   skin      as given to the call
 *   options   as given to the call; may be NULL
 *   fault     written; or NULL. index: the influence of "skin->joints" or "skin->weights", counted
 *             over all vertices; the joint of "skin->matrices"
 *
 * Returns what the call would return for these arguments. If it returns NORMA_OK and the call
 * failed, the input or an output buffer was at fault. */
NORMA_API norma_result norma_find_skin_fault(
    const norma_skin *skin, const norma_options *options, norma_fault *fault);

/* ---- the library */

/* Returns the version of the linked library as text, "0.1.0". The string is constant and must not
 * be freed. Any thread, any time. */
NORMA_API const char *norma_version(void);

/* Returns the version of the linked library as a number, 100 for 0.1.0; compare it with
 * NORMA_VERSION. Any thread, any time. */
NORMA_API uint32_t norma_version_number(void);

#ifdef __cplusplus
}
#endif
#endif
