/* face.h: directions and weights of faces and their corners: many at a time where doubles decide
 * them, exactly where they do not; twins. */
#ifndef NORMA_CORE_FACE_FACE_H
#define NORMA_CORE_FACE_FACE_H
#include "core/call/call.h"
#include "core/mesh/mesh.h"
#include <math.h>
#include <norma/norma.h>
#include <stdint.h>
#include <stddef.h>

/* ---- eight triangles, for what is measured of all at once. */

enum {
    CORE_LANES = 8
}; /* the one vector width: a register of AVX-512, two of AVX2, four of SSE2 or NEON */

typedef double core_lane[CORE_LANES];

/* Before a short loop over lanes: this compiler unrolls such loops before it looks whether they are
 * vectors, and then finds none. */
#if defined(__GNUC__) && !defined(__clang__)
#define CORE_EACH_LANE _Pragma("GCC unroll 1") for (int i = 0; i < CORE_LANES; ++i)
#else
#define CORE_EACH_LANE for (int i = 0; i < CORE_LANES; ++i)
#endif

typedef struct core_batch {
    _Alignas(64) core_lane u[3];
    core_lane v[3]; /* in: the edges from each triangle's first corner to its second and third */
    core_lane a[3]; /* in, for weights: the edge from the second corner to the third */
    core_lane normal[3], twice_area; /* out */
    core_lane weight[3];             /* out: of the three corners */
    double sure[CORE_LANES]; /* out: 1 where doubles are enough, else 0, and what is said of the
                                triangle is not to be used */
} core_batch;

/* Of a triangle, from the positions of its corners. */
CORE_INLINE void core_set_edges(core_batch *batch, int lane, const double p[3][3]) {
    for (int k = 0; k < 3; ++k) {
        batch->u[k][lane] = p[1][k] - p[0][k];
        batch->v[k][lane] = p[2][k] - p[0][k];
        batch->a[k][lane] = p[2][k] - p[1][k];
    }
}

typedef enum core_corners {
    CORE_NO_CORNER = 0,
    CORE_ALL_CORNERS
} core_corners; /* whose weights are wanted */

/* ---- what is computed of a triangle, in double precision and without branches, so that a loop
 * over lanes of triangles becomes vector instructions on every machine, with the same bits as one
 * triangle alone. */

#define NORMA_PI 3.141592653589793

/* atan(t) for |t| <= tan(pi/8): t + t z p(z), z = t^2, p the interpolant of degree 10 at the
 * Chebyshev nodes; its error is below 1.1e-17. */
static inline double norma_core_small_atan(double t) {
    const double z = t * t;
    double p = -0x1.3a31b1c0fd3b7p-6;
    p = p * z + 0x1.4162c02b1dda3p-5;
    p = p * z - 0x1.a0999c632b6edp-5;
    p = p * z + 0x1.dfe6497e96323p-5;
    p = p * z - 0x1.10fa77b1a6d57p-4;
    p = p * z + 0x1.3b1263064f6b9p-4;
    p = p * z - 0x1.745d0b28a7e37p-4;
    p = p * z + 0x1.c71c71853d7fap-4;
    p = p * z - 0x1.2492492436201p-3;
    p = p * z + 0x1.999999999934cp-3;
    p = p * z - 0x1.5555555555555p-2;
    return t + t * (z * p);
}

/* atan2(y, x) for y >= 0: from 0 to pi; 0 where both are 0. Our own, so that its bits are the same
 * on every machine; within 2 ulp. Above tan(pi/8), atan(s / l) = pi/4 + atan((s - l) / (s + l)). */
static inline double norma_core_angle(double y, double x) {
    const double ax = x < 0 ? -x : x;
    const double small = y < ax ? y : ax, large = y < ax ? ax : y;
    const int steep = small > 0.41421356237309503 * large;
    const double above = steep ? small - large : small, below = steep ? small + large : large;
    double angle = (steep ? 0.25 * NORMA_PI : 0) + norma_core_small_atan(above / below);
    angle = y > ax ? 0.5 * NORMA_PI - angle : angle;
    angle = x < 0 ? NORMA_PI - angle : angle;
    return large > 0 ? angle : 0;
}

/* atan(t) for |t| <= tan(pi/8), for weights: the minimax polynomial of degree 6, within 3e-12 of
 * its value. What a weight errs by, the direction of a sum feels by that times sum of weights /
 * |sum|, at most. */
#define CORE_WEIGHT_ATAN_FIRST -0x1.4b3891ff382b2p-5
#define CORE_WEIGHT_ATAN_OTHERS(TERM)                                                              \
    TERM(0x1.24434e877a5ddp-4)                                                                     \
    TERM(-0x1.71d3c10805470p-4)                                                                    \
    TERM(0x1.c6f68737bd590p-4)                                                                     \
    TERM(-0x1.2491c08b2dc95p-3)                                                                    \
    TERM(0x1.99999825954bep-3)                                                                     \
    TERM(-0x1.5555555502188p-2)

static inline double norma_core_weight_atan(double t) {
    const double z = t * t;
    double p = CORE_WEIGHT_ATAN_FIRST;
#define CORE_ADD_TERM(factor) p = p * z + factor;
    CORE_WEIGHT_ATAN_OTHERS(CORE_ADD_TERM)
#undef CORE_ADD_TERM
    return t + t * (z * p);
}

/* atan2(y, x) for y >= 0 and x >= 0 (or below by a rounding) is turn + atan(above / below). */
typedef struct core_slope {
    double above, below, turn;
} core_slope;

static inline core_slope norma_core_slope(double y, double x) {
    const double small = y < x ? y : x, large = y < x ? x : y;
    const int steep = small > 0.41421356237309503 * large, falls = y > x;
    const double flat_above = falls ? -x : y, flat_turn = falls ? 0.5 * NORMA_PI : 0;
    return (core_slope){steep ? y - x : flat_above, steep ? small + large : large,
        steep ? 0.25 * NORMA_PI : flat_turn};
}

static inline double norma_core_slope_angle(core_slope s, double quotient) {
    return s.turn + norma_core_weight_atan(quotient);
}

/* A corner's angle as a weight: atan2(cross, dot), for cross >= 0. */
static inline double norma_core_weight_angle(double cross, double dot) {
    const core_slope s = norma_core_slope(cross, dot < 0 ? -dot : dot);
    const double angle = norma_core_slope_angle(s, s.above / s.below);
    return s.below > 0 ? (dot < 0 ? NORMA_PI - angle : angle) : 0;
}

/* Whether doubles are enough, from the square of the cross product of two edges and their dot
 * product, whose squares are |u|^2 |v|^2 together (Lagrange): each component errs by at most some 6
 * * 2^-53 |u| |v|, below 2^-30 of a length of 2^-20 |u| |v|. Not for NaN, infinity or no area. */
static inline int norma_core_triangle_is_sure(double square, double dot) {
    return (square >= 0x1p-40 * (square + dot * dot)) & (square > NORMA_TINIEST) &
           (square < NORMA_HUGEST);
}

/* The unit normal of the triangle with edges u and v from its first corner, and the length of their
 * cross product, twice its area. Returns whether doubles are enough. */
static inline int norma_core_triangle(
    const double u[3], const double v[3], double normal[3], double *twice_area) {
    double cross[3];
    norma_core_cross(u, v, cross);
    const double square = norma_core_dot(cross, cross), length = sqrt(square), inverse = 1 / length;
    for (int k = 0; k < 3; ++k) normal[k] = cross[k] * inverse;
    *twice_area = length;
    return norma_core_triangle_is_sure(square, norma_core_dot(u, v));
}

/* norma_core_weight_of, from the dot product of the edges instead of the angle; interior angles are
 * above pi where reflex. */
static inline double norma_core_weigh(norma_weight weight, double aa, double bb, double ab,
    double cross, double twice_area, int reflex) {
    const double angle =
        core_weighed(weight) == CORE_BY_ANGLE ? norma_core_weight_angle(cross, ab) : 0;
    return norma_core_weight_of(
        weight, aa, bb, reflex ? 2 * NORMA_PI - angle : angle, cross, twice_area);
}

/* ---- what is computed of a polygon and of its corners where doubles decide it, one at a time in
 * face_geometry.c and many at once in face_kernel.template.h: the same operations, hence the same
 * bits. */

/* Whether a vector area has the right direction. size: the sum of the squares of the distances from
 * the first corner, at least that of the products of their lengths. */
static inline int norma_core_area_is_sure(double square, double size, uint32_t corners) {
    const double bound = 0x1p-22 * (double)(corners + 8) * size;
    return (square >= bound * bound) & (square > NORMA_TINIEST) & (square < NORMA_HUGEST);
}

/* Whether the cross product of a corner's edges is right, from its square and the product of the
 * edges' squares: rounding does not make a needle of nothing, nor turn it over. */
static inline int norma_core_corner_is_sure(double square, double squares) {
    return (square >= 0x1p-40 * squares) & (square > NORMA_TINIEST) & (square < NORMA_HUGEST);
}

/* Whether the side to which a corner turns is the sign of along, its cross product's dot product
 * with the polygon's normal. Both directions are right to 2^-30 rad. */
static inline int norma_core_turn_is_sure(double along, double length) {
    return fabs(along) > 0x1p-28 * length;
}

/* ---- the vector area of a face, exactly (face_exact.c). */

typedef void exact_point(const void *context, size_t index, double point[3]);

/* Twice the vector area of the polygon of count >= 3 finite points, sum of (p_i - p_0) x (p_{i+1} -
 * p_0), in exact integer arithmetic: area * 2^exponent, each component rounded once, relative to
 * the largest. Returns 0 (and zeros) where it is exactly zero. */
int norma_core_exact_area(
    exact_point *point, const void *context, size_t count, double area[3], int *exponent);

/* ---- on which side of straight a corner of a polygon lies, exactly (face_exact.c). */

typedef struct exact_area {
    int known; /* else sum is not set */
    exact_sum sum[3];
} exact_area;

/* Of the polygon of count finite points. O(count). */
void norma_core_sum_polygon(
    exact_point *point, const void *context, size_t count, exact_area *area);

/* Whether the edges at a corner, seen along the polygon's vector area, turn the other way than the
 * polygon: those from previous to here and from here to next, all finite. */
int norma_core_turns_back(
    const exact_area *area, const double here[3], const double next[3], const double previous[3]);

/* ---- a number by which a face's reversed twin is recognised: the face that has the same (welded)
 * positions in opposite order, wherever either begins (face_geometry.c). */

/* The two lowest bits tell the way round: 0 or 1, or 2 for a face that is its own reverse. */
enum { CORE_KEY_WAY = 3 };

/* O(corners of the face). */
uint64_t norma_core_twin_key(const core_mesh *mesh, size_t face);

/* At one edge, a triangle and its twin run opposite ways and have the third position in common. */
static inline uint64_t norma_core_triangle_key(uint32_t third) { return (uint64_t)third << 2 | 2; }

/* The key that the twins of a face with this key have. */
static inline uint64_t norma_core_key_of_twin(uint64_t key) { return key ^ ((~key >> 1) & 1); }

/* ---- face_kernel.template.h: faces of three to eight corners measured many at a time, eight of
 * equally many corners at once. Faces of more corners, and what doubles do not decide, are left to
 * face_geometry.c, whose bits these are. */

enum {
    CORE_FACES_AT_ONCE = 64, /* more would need more stack than a caller's jobs may have */
    CORE_MOST_CORNERS = 8,
    CORE_CORNERS_AT_ONCE = CORE_FACES_AT_ONCE * CORE_MOST_CORNERS,
    CORE_SLOTS = 112 /* batches of eight, one of each number of corners not full */
};

typedef struct core_measured {
    _Alignas(64) double row[CORE_SLOTS][4]; /* the unit normal, and 1; of each slot, as all here */
    core_lane twice_area[CORE_SLOTS / CORE_LANES];
    core_lane weight[CORE_SLOTS / CORE_LANES][CORE_MOST_CORNERS]; /* of each corner, where wanted */
    uint8_t face[CORE_SLOTS];            /* its face, numbered from begin */
    uint8_t slot[CORE_FACES_AT_ONCE];    /* of each face */
    uint8_t corners[CORE_FACES_AT_ONCE]; /* 0: left to others, and nothing else is said of it */
    uint32_t first[CORE_FACES_AT_ONCE];  /* the place of its first corner in at */
    const uint32_t *at;                  /* of each corner its position, welded where they are */
    uint32_t room[CORE_CORNERS_AT_ONCE]; /* for at, where it is not the mesh's */
} core_measured;

/* ---- the direction and size of a face, and what each of its corners weighs (face_geometry.c). */

enum {
    CORE_FACE_DIRECTED = 1,
    CORE_FACE_FINITE = 2,
    CORE_FACE_EDGED = 4
}; /* edged: three corners or more are left */

typedef struct core_face {
    double normal[3];  /* unit where directed, else zero */
    double twice_area; /* 0 where not directed */
    uint64_t
        key; /* by norma_core_twin_key, of polygons with edges whose fans are asked for; else 0 */
    uint32_t kept; /* corners that are left when those at one position in a row are one */
    uint8_t flags;
} core_face;

/* O(corners of the face). */
void norma_core_face_geometry(const core_mesh *mesh, size_t face, core_face *out);

/* The same of count <= CORE_FACES_AT_ONCE faces in a row. */
void norma_core_faces_geometry(
    const core_call *call, const core_mesh *mesh, size_t face, size_t count, core_face *out);

/* Of a mesh of triangles count of them, 1 to CORE_LANES, with the weights of their corners. Returns
 * a bit of each that doubles decide and whose corners are at three positions; the others are left
 * to norma_core_face_geometry. The angles of one that norma_core_corner_weight weighs by itself
 * differ in their last bits. */
unsigned norma_core_measure_triangles(const core_call *call, const core_mesh *mesh,
    norma_weight weight, const size_t *faces, size_t count, core_batch *batch);

/* What a kept corner of a directed face weighs. Constant time, but for runs of corners at one
 * position. */
double norma_core_corner_weight(const core_mesh *mesh, norma_weight weight, size_t number,
    const core_face *face, size_t corner);

/* Marks mesh->reflex, which the caller releases, where a mesh has large polygons and weights are by
 * angle. Without it norma_core_corner_weight takes O(corners of the polygon) where doubles do not
 * decide. O(corners of the mesh); MEMORY or CANCELLED. */
norma_result norma_core_mark_reflex(core_call *call, core_mesh *mesh);

/* ---- the loops that most of the time goes to: faces measured (face_kernel.template.h), added to
 * the sums of positions, and sums made normals (add_kernel.template.h); kernels_portable.c,
 * kernels_avx2.c and kernels_avx512.c include both, each for its instruction set. */

typedef struct core_vertex_sum {
    double x, y, z, weight;
} core_vertex_sum; /* weight: -0 as long as nobody votes */

typedef struct core_adder {
    const core_mesh *mesh;
    const uint32_t *targets; /* NULL, or of each corner the sum that it votes in, instead of that of
                                its position */
    norma_weight weight;
    core_vertex_sum *sums; /* of count positions from first on; corners elsewhere are passed over */
    uint32_t first, count;
    int owns_all;      /* no corner of the faces that are to be added is elsewhere */
    int scattered;     /* corners in a row lie far apart: memory is asked for ahead */
    int by_distance;   /* positions that differ may be welded into one */
    size_t first_face; /* the number of the mesh's first face to add_alone */
    void (*add_alone)(void *context, size_t face); /* one that doubles do not decide */
    void *context;
} core_adder;

typedef struct core_kernels {
    /* Of all corners; the batch's edges are set. */
    void (*measure)(core_batch *batch, norma_weight weight);
    /* The faces from begin to before end, CORE_FACES_AT_ONCE at most. */
    void (*measure_faces)(const core_mesh *mesh, size_t begin, size_t end, norma_weight weight,
        core_corners wanted, core_measured *out);
    /* Add the faces from begin to before end, in ascending order. */
    void (*add_triangles)(const core_adder *adder, size_t begin, size_t end);
    void (*add_polygons)(const core_adder *adder, size_t begin, size_t end);
    /* The normals of CORE_LANES sums. Returns whether each is one; where one has no votes, cancels,
     * or is beyond what doubles square, none of them is to be used. */
    int (*finish)(const core_vertex_sum sums[CORE_LANES], float normals[CORE_LANES][3]);
} core_kernels;

/* face_geometry.c: those of a level. Every level gives the same bits. */
const core_kernels *norma_core_kernels(core_level level);
const core_kernels *norma_core_kernels_portable(void);
#if defined(CORE_HAS_X86)
const core_kernels *norma_core_kernels_avx2(void);
#endif
#if defined(CORE_HAS_AVX512)
const core_kernels *norma_core_kernels_avx512(void);
#endif
#endif
