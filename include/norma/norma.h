/* norma.h: normals of meshes, and normals through transforms. The core of Norma: no I/O, no
 * globals, libc and libm alone.
 *
 * Vectors are columns, 4x4 matrices column-major (translation in [12..14]), 3x3 matrices
 * column-major: the same bytes as row-major matrices for row vectors. Angles are radians, strides
 * bytes. Zero-initialised structs mean the documented defaults. */
#ifndef NORMA_H
#define NORMA_H
#include <stddef.h>
#include <stdint.h>

/* The release this header belongs to, and the same as one number to compare with:
 * 10000 * major + 100 * minor + patch. norma_version_number() is that of the linked library. */
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

#ifdef __cplusplus
extern "C" {
#endif

typedef enum norma_result {
    NORMA_OK = 0,
    NORMA_CANCELLED = 1, /* by the progress callback */
    NORMA_ERROR_ARGUMENT = -1,
    NORMA_ERROR_CAPACITY = -2,
    NORMA_ERROR_INDEX = -3, /* a corner names no position */
    NORMA_ERROR_MEMORY = -4,
    NORMA_ERROR_OVERFLOW = -5 /* counts whose product no size_t holds */
} norma_result;
/* One English sentence for each result, and one for a number that is none; never NULL. The text is
 * the library's and never freed. Any thread, any time. */
NORMA_API const char *norma_result_text(
    norma_result result); /* one sentence, each its own; never NULL */

/* ---- meshes */

typedef enum norma_format {
    NORMA_FORMAT_FLOAT = 0,
    NORMA_FORMAT_DOUBLE,
    NORMA_FORMAT_INT8,
    NORMA_FORMAT_UINT8,
    NORMA_FORMAT_INT16,
    NORMA_FORMAT_UINT16
} norma_format;

typedef struct norma_vec3_view { /* count vectors of three numbers; integers as they are, since a
                                    common factor turns no direction */
    const void *data;
    size_t count;
    size_t stride; /* from one vector to the next; 0 = tight */
    norma_format format;
} norma_vec3_view;

typedef struct norma_mesh {
    norma_vec3_view positions;
    const void *corners; /* position of each corner; NULL: 0, 1, 2, ... */
    size_t corner_count;
    size_t corner_size;               /* bytes of one corner: 4 (or 0), 2, 1 */
    const uint32_t *face_starts;      /* face_count + 1 offsets into corners; NULL: triangles */
    size_t face_count;                /* used with face_starts */
    const uint32_t *smoothing_groups; /* bit mask of each face, or NULL */
    const uint8_t *hard_edges; /* for each corner, nonzero: the edge to the face's next corner is
                                  hard; or NULL */
} norma_mesh;

/* ---- options */

typedef enum norma_weight {
    NORMA_WEIGHT_ANGLE = 0, /* Thuermer, Wuethrich 1998 */
    NORMA_WEIGHT_AREA,      /* Gouraud's average, weighted */
    NORMA_WEIGHT_UNIFORM,
    NORMA_WEIGHT_MAX, /* sin(angle) / (|a| |b|), Max 1999 */
    NORMA_WEIGHT_ANGLE_AREA,
    NORMA_WEIGHT_VISIBLE, /* centre of the smallest cone round the face normals, Aubry, Loehner 2008
                           */
    NORMA_WEIGHT_ANGLE_LENGTHS /* angle |a| |b| */
} norma_weight;

typedef enum norma_weld {
    NORMA_WELD_EXACT = 0, /* corners at exactly equal positions share (-0 = 0) */
    NORMA_WELD_NONE,      /* only corners of the same index do */
    NORMA_WELD_DISTANCE   /* positions joined by a chain of steps <= weld_distance */
} norma_weld;

typedef enum norma_non_manifold {
    NORMA_NON_MANIFOLD_HARD = 0,
    NORMA_NON_MANIFOLD_SMOOTH
} norma_non_manifold;
typedef enum norma_fallback {
    NORMA_FALLBACK_ZERO = 0,
    NORMA_FALLBACK_NEAREST,
    NORMA_FALLBACK_GIVEN
} norma_fallback;
typedef enum norma_isa {
    NORMA_ISA_BEST = 0,
    NORMA_ISA_PORTABLE,
    NORMA_ISA_SSE2,
    NORMA_ISA_AVX2,
    NORMA_ISA_AVX512,
    NORMA_ISA_NEON,
    NORMA_ISA_SIMD128
} norma_isa;

enum norma_reason { /* why an element has no normal of its own, and holds the fallback */
    NORMA_REASON_NONE = 0,
    NORMA_REASON_DEGENERATE,   /* the face has no direction (face normals only) */
    NORMA_REASON_NON_FINITE,   /* its own position (a face: one of its positions) is NaN or infinite
                                */
    NORMA_REASON_UNREFERENCED, /* no face that has a direction shares in it */
    NORMA_REASON_CANCELLED     /* what shares in it sums to nothing */
};

typedef void norma_task(void *context, size_t index);
typedef void norma_parallel_for(void *user, size_t count, norma_task *task,
    void *context); /* each index once, in any order; returns when all are done */
typedef int norma_progress(void *user, double fraction); /* never falls; nonzero cancels */
/* Both functions or neither (malloc and free). Called by the calling thread only; size and
 * alignment (a power of two, at most 64) as they were asked for. */
typedef struct norma_allocator {
    void *(*allocate)(void *user, size_t size, size_t alignment); /* NULL: out of memory */
    void (*release)(void *user, void *block, size_t size);
    void *user;
} norma_allocator;

#define NORMA_ALL_THREADS UINT32_MAX

typedef struct norma_options {
    size_t struct_size; /* sizeof(norma_options) of the caller's header; 0: this first version */
    norma_weight weight;
    norma_weld weld;
    double weld_distance;            /* in the units of the positions */
    norma_non_manifold non_manifold; /* edges of three or more faces: hard, or smooth between all
                                        faces within the crease */
    norma_fallback fallback;
    float fallback_normal[3];
    size_t normal_stride; /* of the output; 0 = 12 */
    uint8_t *reasons;     /* NULL, or room for an enum norma_reason of each normal */
    uint32_t threads; /* how many may work: 0 or 1 the calling one alone, NORMA_ALL_THREADS as many
                         as the machine runs */
    norma_isa isa;    /* one that the machine lacks is an argument error */
    norma_allocator allocator;
    norma_parallel_for
        *parallel_for; /* an engine's own jobs instead of threads, used whenever given */
    void *parallel_for_user;
    norma_progress *progress;
    void *progress_user;
    /* From here on later than the first version: read only where struct_size says so. */
    struct norma_edges *edges; /* NULL, or where the calls that look at edges count them */
} norma_options;

typedef struct norma_edges { /* distinct pairs of (welded) positions along which faces run, each
                                counted once */
    size_t count;            /* all of them */
    size_t open;             /* of one face */
    size_t smooth;           /* shared, within the crease, not marked hard */
    size_t hard;             /* of two faces, and not smooth */
} norma_edges;

typedef struct norma_count {
    size_t count, first;
} norma_count; /* first: the least index, SIZE_MAX where count is 0 */

typedef struct norma_report {
    norma_count degenerate_faces; /* faces */
    norma_count non_finite; /* these three: elements of the output (faces, vertices, corners), each
                               counted once, in this order */
    norma_count unreferenced;
    norma_count cancelled;
    norma_count non_manifold_edges; /* these two: by the calls that look at edges; first: the least
                                       corner at which such an edge begins */
    norma_count winding_conflicts;
} norma_report;

/* ---- normals: three floats for each face, vertex, corner, of unit length or the fallback. Options
 * and report may be NULL.
 *
 * What holds for the four calls below:
 * - Buffers are the caller's, read or written during the call only. normals: the first three floats
 * of each element at options->normal_stride bytes (12 by default) from one to the next, of any
 * alignment; capacity counts elements, not floats. Each is written once and never read, so it may
 * be mapped memory of a GPU; nothing is written between or beyond them. -0 is never written.
 * - Errors: NORMA_ERROR_ARGUMENT for a NULL mesh, a NULL buffer where there is something to read or
 * write, triangles whose corner_count is no multiple of three, face_starts that fall or do not run
 * from 0 to corner_count, no corners and more corners than positions, a NaN crease, an option out
 * of its range, an instruction set that the machine lacks; _CAPACITY, _INDEX, _OVERFLOW (also from
 * 2^32 - 1 positions, corners or faces on), _MEMORY. All but _MEMORY and NORMA_CANCELLED are found
 * before anything is written; after those two, outputs and report are undefined. An empty mesh is
 * NORMA_OK.
 * - A face's direction is that of its vector area, within 1e-7 rad of the exact one for the
 * positions given, however thin the face, from edges of 1e-38 to 1e38 and at any distance from the
 * origin. Consecutive corners at one (welded) position are one, the last of them. A face with fewer
 * than three left, of exactly no area, or with a position that is not finite has no direction and
 * no vote.
 * - What has no normal gets options->fallback, its reason in options->reasons, and is counted in
 * the report. Never NaN.
 * - The same bits for any number of threads, any parallel_for and any instruction set: each sum
 * runs over its corners in ascending order.
 * - Threads: any number of calls may run at once on meshes that nobody changes. progress is called
 * by the calling thread only. */

/* The unit normal of each face: that of its vector area, (p1 - p0) x (p2 - p0) for a triangle, for
 * a polygon the sum of (p_i - p_0) x (p_{i+1} - p_0) (Newell's method, Sutherland, Sproull,
 * Schumacker 1974, relative to a vertex), right for concave polygons too. normals: face_count of
 * them (triangles: corner_count / 3). O(corners); no scratch memory to speak of but with
 * NORMA_WELD_DISTANCE, the only weld that matters here, and the nearest fallback. */
NORMA_API norma_result norma_face_normals(const norma_mesh *mesh, const norma_options *options,
    float *normals, size_t capacity, norma_report *report);
/* The unit normal of each position: the sum over all corners at it (welded as options->weld says),
 * each face's normal weighted by options->weight; where that sum cancels, ||sum|| <= 2^-20 sum of
 * weights, over the corners of the position's own index. Nobody's creases are looked at. normals:
 * positions.count of them. O(positions + corners), whatever the valence; NORMA_WELD_DISTANCE O(n
 * log n). Weights of a corner between edges a and b, its interior angle alpha (above pi where it is
 * reflex), the face's area A: alpha (Thuermer, Wuethrich 1998), A, 1, |a x b| / (|a|^2 |b|^2) (Max
 * 1999), alpha A, alpha |a| |b|; or no sum but the axis of the smallest cone (Aubry, Loehner 2008).
 */
NORMA_API norma_result norma_vertex_normals(const norma_mesh *mesh, const norma_options *options,
    float *normals, size_t capacity, norma_report *report);
/* The unit normal of each corner: the sum over its fan, the corners at its position that smooth
 * edges join. An edge is smooth where two faces share it (each the other's only partner: the faces
 * that run along it the other way, its own reversed twin left out), the dihedral angle is at most
 * crease_angle_rad + 1e-6, no side marks it hard, and, where groups are given, their masks share a
 * bit. A crease of pi or more lets every angle pass, 0 only what is flat, below 0 nothing. A face
 * without a direction borrows, for the dihedral alone, that of the face it shares its longest edge
 * with. normals: corner_count of them. O(positions + corners * log of the valence). */
NORMA_API norma_result norma_corner_normals(const norma_mesh *mesh, float crease_angle_rad,
    const norma_options *options, float *normals, size_t capacity, norma_report *report);

/* The same normals as an indexed mesh: the new vertex of each corner; for each new vertex the old
 * one and its normal. New vertices are numbered as corners first use them. corners, source_vertices
 * and normals may be NULL, to count. New vertices are told apart by old vertex and the bits of the
 * normal; positions that no corner uses are left out. corner_capacity counts corners,
 * vertex_capacity the elements of source_vertices and of normals; *vertex_count (may be NULL) is
 * set on success. The report is that of norma_corner_normals, in corners; options->reasons, where
 * given, has room for one of each new vertex. With the nearest fallback, a corner without a normal
 * is one with the first corner of its vertex that has one, so degenerate faces add no vertex.
 * corners may not be mesh->corners, which are read again after it has been written. Cost as
 * norma_corner_normals, twice where a position splits; of scratch, on top, at most 3 bytes a corner
 * and 17 a position, with normals but no corners 5 and 17; for each corner at a position of more
 * than 64 of a mesh of triangles 260 where that takes 20; and 2 a corner where the nearest is
 * looked for. */
NORMA_API norma_result norma_split(const norma_mesh *mesh, float crease_angle_rad,
    const norma_options *options, uint32_t *corners, size_t corner_capacity,
    uint32_t *source_vertices, float *normals, size_t vertex_capacity, size_t *vertex_count,
    norma_report *report);

/* Phong's interpolation (1975, p. 314): the normal inside a face, renormalised: barycentric[0] a +
 * barycentric[1] b + barycentric[2] c made unit. a, b, c: the corners' normals, used with the
 * lengths they have; the weights need not sum to 1. Where the sum cancels (its length is at most
 * 2^-20 of its terms' lengths together) or is not finite, normal becomes zero and the result is
 * still NORMA_OK. NORMA_ERROR_ARGUMENT for a NULL, nothing written. normal may be one of the
 * inputs. Right over the whole float range. */
NORMA_API norma_result norma_interpolate_normal(const float a[3], const float b[3],
    const float c[3], const float barycentric[3], float normal[3]);

/* ---- meshes that move: what depends on topology alone, done once. Fans and shared positions are
 * those of the mesh at creation.
 *
 * A plan keeps who votes where, so that an update has nothing left to do but to measure faces and
 * sum. Creases stay those of the mesh at creation, so that no edge flickers between hard and soft
 * as it bends; a face that had no direction then votes as soon as it has one, in the fan that it
 * lay in.
 * - Threads: an update writes nothing of the plan. Any number of updates of one plan may run at
 * once, each with its own output.
 * - Memory: an update allocates nothing, but where NORMA_FALLBACK_NEAREST is asked for and some
 * normal is missing: then scratch from its options' allocator. With threads above 1, threads of the
 * system are started and joined. An update's tasks need some 128 KiB of stack. */

typedef enum norma_element {
    NORMA_PER_VERTEX = 0,
    NORMA_PER_CORNER
} norma_element; /* per vertex: the fans that its corners lie in, summed */
typedef struct norma_plan norma_plan;
/* Makes a plan. mesh is read during the call only; options: weld, non_manifold, allocator (kept
 * until norma_plan_destroy: it must live as long), threads, isa, parallel_for, progress, edges
 * (where they are counted) are of use, the rest is not. *plan is written on success alone; it is
 * the caller's, to be given to norma_plan_destroy. Errors as for norma_corner_normals, and
 * NORMA_ERROR_ARGUMENT for plan NULL or an element that is none; NORMA_ERROR_MEMORY also for a mesh
 * made up so that its vertices' overlapping fans hold more than 16 times its corners. Cost about
 * that of norma_corner_normals. */
NORMA_API norma_result norma_plan_create(const norma_mesh *mesh, norma_element of,
    float crease_angle_rad, const norma_options *options, norma_plan **plan);
/* The normals of the plan's mesh at new positions, of any format and stride, as many as the mesh
 * had (else NORMA_ERROR_ARGUMENT). Per corner: the bits that norma_corner_normals would give if
 * shared positions and fans were the plan's. Per vertex: the sum over the fans that its corners lie
 * in, where that cancels over its own corners; so the bits of norma_vertex_normals wherever those
 * fans are all there are at its position. Each face is measured by the positions that its own
 * corners name, also where positions that were one have parted. moved: NULL, and all is computed;
 * or the numbers of the vertices that moved since normals were last right, in any order, repeated
 * or not (one that does not exist: NORMA_ERROR_INDEX, before anything is written). Then the
 * normals, and reasons, that these positions can change are written and nothing else: of all
 * corners of all faces that name a moved vertex, with those that share their sums. The outcome is
 * that of a full update, bit for bit. normals: norma_plan's vertices or corners of them; capacity,
 * stride, reasons, fallback as for the calls above. Options: weight, fallback, normal_stride,
 * reasons, threads, isa, parallel_for, progress are of use, and with NORMA_FALLBACK_NEAREST
 * allocator; the weld is the plan's. With that fallback, normals that are missing may change
 * wherever they are: all of them are written, and an update of some costs as much as one of all,
 * and more. report (may be NULL): of what was written; degenerate_faces: faces of which the first
 * corner's (its vertex's) normal was written; edges are not looked at, and not counted. Cost:
 * O(corners), or O(what is written and the vertices around it); double positions are all looked at,
 * for the range they lie in. */
NORMA_API norma_result norma_plan_update(const norma_plan *plan, norma_vec3_view positions,
    const uint32_t *moved, size_t moved_count, /* NULL: all */
    const norma_options *options, float *normals, size_t capacity, norma_report *report);
/* What the plan holds, in bytes; 0 for NULL. */
NORMA_API size_t norma_plan_bytes(const norma_plan *plan);
/* Gives all of it back to the allocator it came from. NULL is fine. No update of it may be running.
 */
NORMA_API void norma_plan_destroy(norma_plan *plan);

/* ---- morph targets
 *
 * Normal deltas of morph targets, sparse: of each target, the vertices whose normals differ from
 * the base's, and by how much. base: the mesh with the positions of the base. base_normals: NULL,
 * or the base's own normals, one for each position, which are kept: vertices at one (welded)
 * position with one normal then share a sum, those with different ones lie across a crease and do
 * not. With NULL all vertices at one position share. targets: target_count views of positions
 * (places, not displacements), each as many as the base's. A delta is the normal of the target less
 * that of the base, both summed by options->weight over the shared vertices; the target's positions
 * are those of each group's first vertex. So equal positions get equal deltas, no seam opens, and
 * where nothing moves there is none. Deltas of a length of at most smallest (0 or more) are left
 * out, and those where base or target have no normal. target_starts: room for target_count + 1;
 * target t has the deltas from target_starts[t] to before target_starts[t + 1]. For each of them
 * vertices receives the vertex, ascending within a target, and deltas three floats; either or both
 * may be NULL, to count. capacity counts deltas. Errors as for norma_vertex_normals, and
 * NORMA_ERROR_ARGUMENT for a NaN or negative bound, counts that differ, target_starts NULL;
 * NORMA_ERROR_CAPACITY is found before anything is written; where capacity is target_count times
 * the positions it need not be looked for, which halves the cost. Of the options, fallback,
 * normal_stride, reasons and edges are of no use. */
NORMA_API norma_result norma_morph_normals(const norma_mesh *base,
    const norma_vec3_view *base_normals, const norma_vec3_view *targets, size_t target_count,
    float smallest, const norma_options *options, size_t *target_starts, uint32_t *vertices,
    float *deltas, size_t capacity);

/* ---- matrices
 *
 * What holds for the calls from here on:
 * - Buffers are the caller's, read or written during the call only; they need no more alignment
 * than their type's, and where a stride is given, none. Counts and capacities are in elements
 * (matrices, vectors), strides in bytes, 0 for tight.
 * - Errors: NORMA_ERROR_ARGUMENT for a NULL where there is something to read or write, a number
 * that is no value of its enum, an output stride shorter than what is written at it;
 * NORMA_ERROR_OVERFLOW where count * stride exceeds a size_t; NORMA_ERROR_CAPACITY where capacity
 * is below count. They are found before anything is written. A count of 0 is NORMA_OK, and buffers
 * may then be NULL. No memory is allocated.
 * - Of a model only the upper 3x3 matters ([0..2], [4..6], [8..10]); a translation or a last row
 * never reaches a normal, and neither need be finite.
 * - Calls are pure functions of what they are given: any number may run at once. The same bits from
 * every compiler, one or many at a time. -0 is never written into a matrix. */

typedef enum norma_winding {
    NORMA_WINDING_KEPT = 0,
    NORMA_WINDING_REVERSED
} norma_winding; /* reversed: where the matrix mirrors, the caller reverses the faces */

typedef enum norma_kind { /* of the upper 3x3, a mirror aside; relative tolerance 1e-5 */
    NORMA_KIND_IDENTITY = 0,
    NORMA_KIND_TRANSLATION,
    NORMA_KIND_ROTATION,
    NORMA_KIND_UNIFORM_SCALE,
    NORMA_KIND_NON_UNIFORM_SCALE, /* columns perpendicular: rotation after scales along the axes */
    NORMA_KIND_SHEAR,
    NORMA_KIND_SINGULAR
} norma_kind;
/* Judged in this order: singular, rank below 3; shear, two columns with |cosine| above 1e-5;
 * non-uniform scale, lengths of columns that differ by more than 1e-5 of the longest; uniform
 * scale, that length not 1 within 1e-5; rotation, the rest but for the identity, entries within
 * 1e-5. The identity "a mirror aside" is I, -I, or I with one axis turned round (mirrored is set);
 * any other mirror is a mirrored rotation. Translation: an identity with [12..14] not all zero. */

typedef struct norma_matrix_info {
    norma_kind kind;
    int rank;               /* singular values above 1e-6 of the largest */
    int mirrored;           /* determinant below 0 */
    double determinant;     /* of the upper 3x3 */
    double anisotropy;      /* largest over smallest singular value; INFINITY below rank 3 */
    double worst_error_rad; /* between M n and the right normal, faces reversed under a mirror:
                               asin((a^2-1)/(a^2+1)); pi/2 below rank 3 */
    float worst_normal[3];  /* a unit normal for which plain M errs so */
} norma_matrix_info;

/* The normal matrix of a model: the 3x3 that carries the normals of faces and vertices through it.
 * Renormalise after it. Kept: cof(M). Reversed: sign(det) cof(M), the direction of the inverse
 * transpose; sign is +1 where the determinant is exactly 0. Times a power of two where a float
 * would overflow or underflow.
 *
 * cof(M)(a x b) = M a x M b for every M, so nothing is divided by and rank 2 is exact. Each entry
 * is rounded to a double and then to a float; its sign and whether it is zero are exact, and so is
 * the determinant's sign. The power of two is 1 unless an entry exceeds a float or a column that is
 * not zero would have no normal float; then the largest entry comes to lie in [1, 2), or higher
 * where the smallest needs the room: direction is all that it carries. A model whose cofactors are
 * all exactly zero (rank 0 or 1: no face keeps a direction) gives zeros and NORMA_OK; rank says so.
 * An upper 3x3 that is not finite gives zeros, the info of a matrix of zeros, and
 * NORMA_ERROR_ARGUMENT. normal_matrix: nine floats, column-major; may be model itself. info: NULL,
 * or what the model is: determinant correctly rounded, singular values by one-sided Jacobi
 * rotations (Hestenes 1958), worst_normal in the model's own space (before M), unit: (v1 + v3) /
 * sqrt 2 of the right singular vectors that belong to the largest and the smallest singular value,
 * where Kantorovich's bound (1948) is reached. Below rank 3, M n lies across the right normal
 * there, or one of the two is zero. Cost: some ten nanoseconds, with info a microsecond or two. */
NORMA_API norma_result norma_normal_matrix(
    const float model[16], norma_winding winding, float normal_matrix[9], norma_matrix_info *info);
/* Many: models are count times 16 floats, normal_matrices takes count times nine; the same bits as
 * one by one. A model that is not finite gets zeros, the others are done, and then the result is
 * NORMA_ERROR_ARGUMENT. The two arrays must not overlap. */
NORMA_API norma_result norma_normal_matrices(const float *models, size_t count,
    norma_winding winding, float *normal_matrices, size_t capacity);
/* The same into a shader's layout: model_stride from one model to the next (0: 64), matrix_stride
 * from one result to the next (0: three columns), column_stride from one column to the next (0:
 * 12). Between columns nothing is written. Any layout in which no column lies on another, also all
 * first columns, then all second, then all third; others are NORMA_ERROR_ARGUMENT. */
NORMA_API norma_result norma_normal_matrices_strided(const float *models, size_t model_stride,
    size_t count, norma_winding winding, float *normal_matrices, size_t matrix_stride,
    size_t column_stride, size_t capacity); /* std140: 48 and 16 */
/* Normals through a 3x3, each made unit again: out = normalize(normal_matrix n). in: any format and
 * stride, integers as they are, lengths as they are, over the whole range of floats and doubles;
 * out: three floats at each out_stride (0: 12). Zero stays zero, and what is not finite, or meets
 * an entry of the matrix that is not, becomes zero: NORMA_OK. Directions to the last bit or so of a
 * float. out may begin where in.data does if out_stride is at most the input's stride; otherwise
 * they must not overlap. O(count). */
NORMA_API norma_result norma_transform_normals(const float normal_matrix[9], norma_vec3_view in,
    float *out, size_t out_stride, size_t capacity);

/* ---- beyond the first contract: forms by name, double precision, the concatenated case
 *
 * The double forms are exact before their last rounding: each cofactor and the determinant are
 * correctly rounded, over the whole range of doubles. The power of two of norma_normal_matrix
 * applies where a double would overflow or underflow. An upper 3x3 that is not finite gives zeros
 * and NORMA_ERROR_ARGUMENT. Each output may be its own model. Cost: a few microseconds. */

typedef enum norma_shortcut { /* what carries normals without an inverse, a mirror aside */
    NORMA_SHORTCUT_NONE = 0,
    NORMA_SHORTCUT_ROTATION,      /* M itself, nothing to renormalise */
    NORMA_SHORTCUT_UNIFORM_SCALE, /* M itself, renormalised */
    NORMA_SHORTCUT_AXIS_SCALE     /* M(n / s^2), s the lengths of M's columns; not with shear */
} norma_shortcut;
/* Where mirrored is set, these give the sense of NORMA_WINDING_REVERSED: that of the inverse
 * transpose. */

/* norma_normal_matrix in double precision. */
NORMA_API norma_result norma_normal_matrix_double(const double model[16], norma_winding winding,
    double normal_matrix[9], norma_matrix_info *info);
/* The normal matrix and the info of view * model, without forming a product that rounding could
 * make singular or regular: cof(V M) = cof(V) cof(M), with exact signs and zeros. For normals in
 * view space. The kind is translation where the product moves the origin by more than 1e-5 of the
 * terms that make it up. */
NORMA_API norma_result norma_normal_matrix_model_view(const float model[16], const float view[16],
    norma_winding winding, float normal_matrix[9], norma_matrix_info *info);
/* cof(M): the transpose of the adjugate, also det(M) times the inverse transpose where there is
 * one. The area vector of a face (its area times its normal) goes through it. The same as
 * norma_normal_matrix_double with NORMA_WINDING_KEPT. */
NORMA_API norma_result norma_cofactor_matrix(const double model[16], double cofactor[9]);
/* (M^-1)^T = cof(M) / det(M), entries within two units in the last place. */
NORMA_API norma_result norma_inverse_transpose(const double model[16],
    double inverse_transpose[9]); /* exactly singular: argument error, nothing written */
/* What info allows: rotation for the identity, a translation and a rotation; uniform scale and axis
 * scale for theirs; none for shear, singular and NULL. */
NORMA_API norma_shortcut norma_matrix_shortcut(const norma_matrix_info *info);
/* Each column of M over its squared length: the inverse transpose where the columns are
 * perpendicular (NORMA_SHORTCUT_AXIS_SCALE; R diag(s) gives R diag(1/s)), and wrong where they are
 * not, which is not looked at. A column of zeros: argument error, nothing written. */
NORMA_API norma_result norma_axis_scale_matrix(
    const double model[16], double normal_matrix[9]); /* M diag(1/s^2) */

/* Positions as points: out = A p + t, A the upper 3x3 and t = [12..14]; the last row is ignored,
 * there is no division by w. in: any format and stride; out: three floats (doubles) at each
 * out_stride (0: tight). Computed in double precision in one order, ((a x + b y) + c z) + t, then
 * rounded. What is not finite stays so; what exceeds a float becomes infinite. Overlap as for
 * norma_transform_normals. O(count). */
NORMA_API norma_result norma_transform_positions(
    const double model[16], norma_vec3_view in, float *out, size_t out_stride, size_t capacity);
NORMA_API norma_result norma_transform_positions_double(
    const double model[16], norma_vec3_view in, double *out, size_t out_stride, size_t capacity);
/* Tangents x, y, z, sign (four floats each): M t made perpendicular to the transformed normal,
 * unit; the sign times that of the determinant. tangents: four floats at each tangent_stride (0:
 * 16); the sign gives the bitangent as sign * cross(normal, tangent) (glTF, Mikkelsen 2008).
 * normals: those of the result, as norma_transform_normals gave them with NORMA_WINDING_REVERSED,
 * at least count of them, any format and length. A normal that is zero or not finite asks nothing
 * of its tangent. Where at most 2^-20 of a tangent is left beside its normal, or M t is zero or not
 * finite, any perpendicular is taken, always the same. out: four floats at each out_stride (0: 16);
 * may be tangents itself with the same stride. A model that is not finite: argument error.
 * O(count). */
NORMA_API norma_result norma_transform_tangents(const float model[16], const float *tangents,
    size_t tangent_stride, norma_vec3_view normals, size_t count, float *out, size_t out_stride,
    size_t capacity);
/* Tangents made perpendicular to new normals (Gram-Schmidt), sign kept; where nothing is left of
 * one, any perpendicular. All else as for norma_transform_tangents. */
NORMA_API norma_result norma_orthogonalise_tangents(const float *tangents, size_t tangent_stride,
    norma_vec3_view normals, size_t count, float *out, size_t out_stride, size_t capacity);
/* Reverses the winding in place: of each face its corners but the first.
 * corners: corner_count indices of corner_size bytes (4 or 0, 2, 1). face_starts: face_count + 1
 * offsets from 0 to corner_count that do not fall, or NULL for triangles (face_count is then not
 * looked at; a corner_count that is no multiple of three is an argument error). What belongs to
 * corners (hard edges, normals per corner) is not moved. O(corner_count). */
NORMA_API norma_result norma_reverse_winding(void *corners, size_t corner_size, size_t corner_count,
    const uint32_t *face_starts, size_t face_count);

typedef enum norma_orient_open {
    NORMA_ORIENT_OPEN_KEPT = 0,
    NORMA_ORIENT_OPEN_BY_RAYS
} norma_orient_open;

typedef struct norma_orient_report {
    size_t parts; /* that shared edges hold together, cut at edges of more than two faces; each is
                     one of the next three */
    size_t closed, open, one_sided; /* one-sided: no winding agrees with itself (a Moebius band);
                                       its faces are left as they are */
    size_t inward;                  /* closed ones that looked inward once their faces agreed */
    size_t nested; /* solids right inside a solid: cavities that were turned, or bodies of their
                      own; left as they are */
    size_t by_rays,
        undecided; /* open ones: turned or confirmed by rays; left as most of their faces were */
    double least_confidence; /* of those by rays: (rays for it - rays against it) / 256; 1 where
                                there are none */
    size_t reversed_faces;
    size_t winding_conflicts, non_manifold_edges; /* before: edges of exactly two faces that run the
                                                     same way; of more than two */
} norma_orient_report;

/* Which faces should be wound the other way round, so that neighbours agree and what is closed
 * looks outward: reverse[f] becomes 1 or 0 for each face.
 *
 * Each part is wound as most of its faces are. A closed one then looks outward by the sign of its
 * volume, unless it is a cavity: negative volume right inside (the smallest part in which it lies,
 * by winding numbers) a solid, judged from outside in. Open parts keep the winding of most of their
 * faces, or are turned by a majority of 256 rays each, towards the side from which rays run farther
 * (Takayama, Jacobson, Kavan, Sorkine-Hornung 2014): a guess, with a confidence. A part counts as
 * closed where its own faces cancel at each edge, though others touch it there. The mesh is not
 * changed; norma_reverse_winding of single faces, or swapping two corners, does that. options:
 * weld, threads, parallel_for, allocator and progress are used; may be NULL, as report. capacity:
 * elements of reverse, one for each face. Errors are those of norma_face_normals. The same answer
 * for any number of threads. O(corners log of the valence), and of nesting and rays O(parts log
 * parts + rays log faces). */
NORMA_API norma_result norma_orient(const norma_mesh *mesh, norma_orient_open open,
    const norma_options *options, uint8_t *reverse, size_t capacity, norma_orient_report *report);

/* Signed normalised integers (glTF: c / 127, c / 32767, at least -1). Encoding takes the nearest
 * code whose length a reader accepts as unit. normals: any format and length; made unit first. out:
 * three integers at each out_stride (0: tight; glTF pads three bytes to four, which stay as they
 * are). The reader is the Khronos validator: | length - 1 | <= 0.00674; nearest by Euclid, so that
 * the direction is within .3907 degrees (8 bits) or .00151 (16). -n gets the negated code. Zero and
 * what is not finite become zero. O(count). */
NORMA_API norma_result norma_encode_snorm8(
    norma_vec3_view normals, int8_t *out, size_t out_stride, size_t capacity);
NORMA_API norma_result norma_encode_snorm16(
    norma_vec3_view normals, int16_t *out, size_t out_stride, size_t capacity);
/* Back to floats: max(c / 127, -1) or max(c / 32767, -1), correctly rounded and not renormalised.
 * codes: three integers at each stride (0: tight), count of them. */
NORMA_API norma_result norma_decode_snorm8(const int8_t *codes, size_t stride, size_t count,
    float *out, size_t out_stride, size_t capacity);
NORMA_API norma_result norma_decode_snorm16(const int16_t *codes, size_t stride, size_t count,
    float *out, size_t out_stride, size_t capacity);

/* ---- the library */

/* The version of the linked library as text, "0.1.0". Never freed. */
NORMA_API const char *norma_version(void);
/* The same as a number that compares with NORMA_VERSION: 100 for 0.1.0. */
NORMA_API uint32_t norma_version_number(void);

#ifdef __cplusplus
}
#endif
#endif
