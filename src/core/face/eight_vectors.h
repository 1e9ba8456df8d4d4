/* eight_vectors.h: eight vectors of three, one after the other as they lie in memory, to eight
 * lanes of each axis, and back. No number is changed on the way. With the compilers that have
 * vectors of their own these are shuffles of registers; going through memory, number by number,
 * took three times as long. */
#ifndef NORMA_CORE_FACE_EIGHT_VECTORS_H
#define NORMA_CORE_FACE_EIGHT_VECTORS_H
#include "core/call/call.h"
#include "core/face/face.h"
#include "core/mesh/mesh.h"
#include <string.h>

/* Where the corners of eight faces lie: corner k of face i at position at[corners i + k]. */
typedef struct core_points {
    const unsigned char *data;
    size_t stride;
    const uint32_t *at;
    int corners; /* of each face */
    int doubles; /* three doubles each, which are read times scale; else three floats */
    double scale;
} core_points;

CORE_INLINE core_points core_points_of(const core_mesh *mesh, const uint32_t *at, int corners) {
    return (core_points){mesh->positions.data, mesh->positions.stride, at, corners,
        mesh->positions.format == NORMA_FORMAT_DOUBLE, mesh->scale};
}

/* Of other formats, positions are read one by one. */
CORE_INLINE int core_can_gather(const core_mesh *mesh) {
    return mesh->positions.format == NORMA_FORMAT_FLOAT ||
           mesh->positions.format == NORMA_FORMAT_DOUBLE;
}

CORE_INLINE const unsigned char *core_point_at(core_points p, int i, int k) {
    return p.data + p.at[p.corners * i + k] * p.stride;
}

typedef struct core_rows {
    double row[CORE_LANES][4];
} core_rows;

#if defined(__has_builtin) &&                                                                      \
    !defined(CORE_NO_SHUFFLES) /* what compilers without them get, for tests */
#if __has_builtin(__builtin_shufflevector)
#define CORE_HAS_SHUFFLES
#endif
#endif

#if defined(CORE_HAS_SHUFFLES)
#if defined(__GNUC__)
#pragma GCC diagnostic ignored                                                                     \
    "-Wpsabi" /* how a vector would be passed to a function: all here are inlined */
#endif
typedef double core_d2 __attribute__((vector_size(16)));
typedef double core_d4 __attribute__((vector_size(32)));
typedef double core_d8 __attribute__((vector_size(64)));
typedef float core_f4 __attribute__((vector_size(16)));
typedef float core_f8 __attribute__((vector_size(32)));

/* Three floats, and not a byte beyond them. */
CORE_INLINE core_f4 core_load_three(const unsigned char *at) {
    double xy;
    float z;
    memcpy(&xy, at, sizeof xy);
    memcpy(&z, at + sizeof xy, sizeof z);
    core_f4 v = (core_f4)(core_d2){xy, 0};
    v[2] = z;
    return v;
}

/* Corners k of faces i and i + 4. */
CORE_INLINE core_f8 core_two_corners(core_points p, int i, int k) {
    return __builtin_shufflevector(core_load_three(core_point_at(p, i, k)),
        core_load_three(core_point_at(p, i + 4, k)), 0, 1, 2, 3, 4, 5, 6, 7);
}

/* r[i]: what begins with the three numbers of i, and then of i + 4. axis[x]: number x of each of
 * the eight. */
CORE_INLINE void core_turn_threes(const core_f8 r[4], core_f8 axis[3]) {
    const core_f8 xy01 = __builtin_shufflevector(r[0], r[1], 0, 8, 1, 9, 4, 12, 5, 13),
                  xy23 = __builtin_shufflevector(r[2], r[3], 0, 8, 1, 9, 4, 12, 5, 13);
    const core_f8 z01 = __builtin_shufflevector(r[0], r[1], 2, 10, 3, 11, 6, 14, 7, 15),
                  z23 = __builtin_shufflevector(r[2], r[3], 2, 10, 3, 11, 6, 14, 7, 15);
    axis[0] = __builtin_shufflevector(xy01, xy23, 0, 1, 8, 9, 4, 5, 12, 13);
    axis[1] = __builtin_shufflevector(xy01, xy23, 2, 3, 10, 11, 6, 7, 14, 15);
    axis[2] = __builtin_shufflevector(z01, z23, 0, 1, 8, 9, 4, 5, 12, 13);
}

/* Four lanes of eight, turned over: r[i] becomes the four numbers of i, and then of i + 4. */
CORE_INLINE void core_turn_fours(core_f8 r[4]) {
    const core_f8 a = __builtin_shufflevector(r[0], r[1], 0, 8, 1, 9, 4, 12, 5, 13),
                  b = __builtin_shufflevector(r[0], r[1], 2, 10, 3, 11, 6, 14, 7, 15);
    const core_f8 c = __builtin_shufflevector(r[2], r[3], 0, 8, 1, 9, 4, 12, 5, 13),
                  d = __builtin_shufflevector(r[2], r[3], 2, 10, 3, 11, 6, 14, 7, 15);
    r[0] = __builtin_shufflevector(a, c, 0, 1, 8, 9, 4, 5, 12, 13);
    r[1] = __builtin_shufflevector(a, c, 2, 3, 10, 11, 6, 7, 14, 15);
    r[2] = __builtin_shufflevector(b, d, 0, 1, 8, 9, 4, 5, 12, 13);
    r[3] = __builtin_shufflevector(b, d, 2, 3, 10, 11, 6, 7, 14, 15);
}

/* x y z x y z ... to three rows, four vectors at a time, by shuffles that every instruction set
 * has. count: a multiple of four. Back below. */
CORE_INLINE void core_threes_to_lanes(const void *from, int count, float *x, float *y, float *z) {
    for (int i = 0; i < count; i += 4) {
        const char *at = (const char *)from + 12 * (size_t)i;
        core_f4 a, b, c; /* x0 y0 z0 x1, y1 z1 x2 y2, z2 x3 y3 z3 */
        memcpy(&a, at, sizeof a);
        memcpy(&b, at + 16, sizeof b);
        memcpy(&c, at + 32, sizeof c);
        const core_f4 bc = __builtin_shufflevector(b, c, 2, 3, 5, 6); /* x2 y2 x3 y3 */
        const core_f4 ab = __builtin_shufflevector(a, b, 1, 2, 4, 5); /* y0 z0 y1 z1 */
        const core_f4 xs = __builtin_shufflevector(a, bc, 0, 3, 4, 6);
        const core_f4 ys = __builtin_shufflevector(ab, bc, 0, 2, 5, 7);
        const core_f4 zs = __builtin_shufflevector(ab, c, 1, 3, 4, 7);
        memcpy(x + i, &xs, sizeof xs);
        memcpy(y + i, &ys, sizeof ys);
        memcpy(z + i, &zs, sizeof zs);
    }
}

CORE_INLINE void core_lanes_to_threes(
    const float *x, const float *y, const float *z, int count, void *to) {
    for (int i = 0; i < count; i += 4) {
        char *at = (char *)to + 12 * (size_t)i;
        core_f4 xs, ys, zs;
        memcpy(&xs, x + i, sizeof xs);
        memcpy(&ys, y + i, sizeof ys);
        memcpy(&zs, z + i, sizeof zs);
        const core_f4 xy = __builtin_shufflevector(xs, ys, 0, 2, 4, 6); /* x0 x2 y0 y2 */
        const core_f4 yz = __builtin_shufflevector(ys, zs, 1, 3, 5, 7); /* y1 y3 z1 z3 */
        const core_f4 zx = __builtin_shufflevector(zs, xs, 0, 2, 5, 7); /* z0 z2 x1 x3 */
        const core_f4 a = __builtin_shufflevector(xy, zx, 0, 2, 4, 6);
        const core_f4 b = __builtin_shufflevector(yz, xy, 0, 2, 5, 7);
        const core_f4 c = __builtin_shufflevector(zx, yz, 1, 3, 5, 7);
        memcpy(at, &a, sizeof a);
        memcpy(at + 16, &b, sizeof b);
        memcpy(at + 32, &c, sizeof c);
    }
}

CORE_INLINE core_d4 core_load_row(const double *row) {
    core_d4 v;
    memcpy(&v, row, sizeof v);
    return v;
}

CORE_INLINE void core_store_row(double *row, core_d4 v) { memcpy(row, &v, sizeof v); }

/* Four rows of four, turned over. */
CORE_INLINE void core_turn_rows(core_d4 r[4]) {
    const core_d4 a = __builtin_shufflevector(r[0], r[1], 0, 4, 2, 6),
                  b = __builtin_shufflevector(r[0], r[1], 1, 5, 3, 7);
    const core_d4 c = __builtin_shufflevector(r[2], r[3], 0, 4, 2, 6),
                  d = __builtin_shufflevector(r[2], r[3], 1, 5, 3, 7);
    r[0] = __builtin_shufflevector(a, c, 0, 1, 4, 5);
    r[1] = __builtin_shufflevector(b, d, 0, 1, 4, 5);
    r[2] = __builtin_shufflevector(a, c, 2, 3, 6, 7);
    r[3] = __builtin_shufflevector(b, d, 2, 3, 6, 7);
}

/* Three doubles, and not a byte beyond them. */
CORE_INLINE core_d4 core_load_three_doubles(const unsigned char *at) {
    core_d2 xy;
    double z;
    memcpy(&xy, at, sizeof xy);
    memcpy(&z, at + sizeof xy, sizeof z);
    return __builtin_shufflevector(xy, (core_d2){z, 0}, 0, 1, 2, 3);
}

CORE_INLINE void core_gather_doubles(core_points p, int k, core_d8 axis[3]) {
    core_d4 r[2][4];
    for (int i = 0; i < CORE_LANES; ++i)
        r[i / 4][i % 4] = core_load_three_doubles(core_point_at(p, i, k));
    core_turn_rows(r[0]);
    core_turn_rows(r[1]);
    for (int x = 0; x < 3; ++x)
        axis[x] = __builtin_shufflevector(r[0][x], r[1][x], 0, 1, 2, 3, 4, 5, 6, 7) * p.scale;
}

/* axis[x]: coordinate x of corner k of each face. */
CORE_INLINE void core_gather_corners(core_points p, int k, core_d8 axis[3]) {
    if (p.doubles) {
        core_gather_doubles(p, k, axis);
        return;
    }
    const core_f8 r[4] = {core_two_corners(p, 0, k), core_two_corners(p, 1, k),
        core_two_corners(p, 2, k), core_two_corners(p, 3, k)};
    core_f8 floats[3];
    core_turn_threes(r, floats);
    for (int x = 0; x < 3; ++x) axis[x] = __builtin_convertvector(floats[x], core_d8);
}

/* The edges of triangles. */
CORE_INLINE void core_gather_edges(core_points p, core_batch *out) {
    core_d8 corner[3][3];
    for (int k = 0; k < 3; ++k) core_gather_corners(p, k, corner[k]);
    for (int x = 0; x < 3; ++x) {
        const core_d8 u = corner[1][x] - corner[0][x], v = corner[2][x] - corner[0][x],
                      a = corner[2][x] - corner[1][x];
        memcpy(out->u[x], &u, sizeof u);
        memcpy(out->v[x], &v, sizeof v);
        memcpy(out->a[x], &a, sizeof a);
    }
}

CORE_INLINE void core_lanes_to_rows(
    const double *x, const double *y, const double *z, const double *w, core_rows *out) {
    for (int i = 0; i < CORE_LANES; i += 4) {
        core_d4 r[4] = {
            core_load_row(x + i), core_load_row(y + i), core_load_row(z + i), core_load_row(w + i)};
        core_turn_rows(r);
        for (int k = 0; k < 4; ++k) core_store_row(out->row[i + k], r[k]);
    }
}

CORE_INLINE void core_rows_to_lanes(
    const double (*rows)[4], double *x, double *y, double *z, double *w) {
    for (int i = 0; i < CORE_LANES; i += 4) {
        core_d4 r[4] = {core_load_row(rows[i]), core_load_row(rows[i + 1]),
            core_load_row(rows[i + 2]), core_load_row(rows[i + 3])};
        core_turn_rows(r);
        core_store_row(x + i, r[0]);
        core_store_row(y + i, r[1]);
        core_store_row(z + i, r[2]);
        core_store_row(w + i, r[3]);
    }
}

/* sum += factor row */
CORE_INLINE void core_add_row(double *sum, const double *row, double factor) {
    core_store_row(
        sum, core_load_row(sum) + core_load_row(row) * (core_d4){factor, factor, factor, factor});
}

CORE_INLINE void core_add_whole(double *sum, const double *row) {
    core_store_row(sum, core_load_row(sum) + core_load_row(row));
}
#else
CORE_INLINE void core_read_point(core_points points, int i, int k, double p[3]) {
    const unsigned char *at = core_point_at(points, i, k);
    if (points.doubles) {
        memcpy(p, at, 3 * sizeof *p);
        for (int x = 0; x < 3; ++x) p[x] *= points.scale;
        return;
    }
    float floats[3];
    memcpy(floats, at, sizeof floats);
    for (int x = 0; x < 3; ++x) p[x] = (double)floats[x];
}

CORE_INLINE void core_gather_edges(core_points points, core_batch *out) {
    for (int i = 0; i < CORE_LANES; ++i) {
        double p[3][3];
        for (int k = 0; k < 3; ++k) core_read_point(points, i, k, p[k]);
        for (int x = 0; x < 3; ++x) {
            out->u[x][i] = p[1][x] - p[0][x];
            out->v[x][i] = p[2][x] - p[0][x];
            out->a[x][i] = p[2][x] - p[1][x];
        }
    }
}

CORE_INLINE void core_threes_to_lanes(const void *from, int count, float *x, float *y, float *z) {
    for (int i = 0; i < count; ++i) {
        const char *at = (const char *)from + 12 * (size_t)i;
        memcpy(x + i, at, sizeof *x);
        memcpy(y + i, at + 4, sizeof *y);
        memcpy(z + i, at + 8, sizeof *z);
    }
}

CORE_INLINE void core_lanes_to_threes(
    const float *x, const float *y, const float *z, int count, void *to) {
    for (int i = 0; i < count; ++i)
        memcpy((char *)to + 12 * (size_t)i, (const float[]){x[i], y[i], z[i]}, 12);
}

CORE_INLINE void core_lanes_to_rows(
    const double *x, const double *y, const double *z, const double *w, core_rows *out) {
    for (int i = 0; i < CORE_LANES; ++i) {
        out->row[i][0] = x[i];
        out->row[i][1] = y[i];
        out->row[i][2] = z[i];
        out->row[i][3] = w[i];
    }
}

CORE_INLINE void core_rows_to_lanes(
    const double (*rows)[4], double *x, double *y, double *z, double *w) {
    for (int i = 0; i < CORE_LANES; ++i) {
        x[i] = rows[i][0];
        y[i] = rows[i][1];
        z[i] = rows[i][2];
        w[i] = rows[i][3];
    }
}

CORE_INLINE void core_add_row(double *sum, const double *row, double factor) {
    for (int k = 0; k < 4; ++k) sum[k] += row[k] * factor;
}

CORE_INLINE void core_add_whole(double *sum, const double *row) {
    for (int k = 0; k < 4; ++k) sum[k] += row[k];
}
#endif

/* The edges of eight triangles, whatever the format of their positions. */
CORE_INLINE void core_load_edges(
    const core_mesh *mesh, const uint32_t (*at)[3], core_batch *batch) {
    double p[3][3];
    if (core_can_gather(mesh)) {
        core_gather_edges(core_points_of(mesh, *at, 3), batch);
        return;
    }
    for (int i = 0; i < CORE_LANES; ++i) {
        for (int k = 0; k < 3; ++k) norma_core_position(mesh, at[i][k], p[k]);
        core_set_edges(batch, i, (const double(*)[3])p);
    }
}

/* ---- eight sums made normals, in two steps, because a root followed by a division takes so long
 * that callers do other work in between. */

typedef struct core_lengths {
    core_lane x, y, z, length;
} core_lengths;

/* fine: 1 more for each lane whose sum has a direction; what is said of others is not to be used:
 * they have no votes, cancel, or are beyond what doubles square. */
CORE_INLINE void core_lanes_lengths(const core_vertex_sum *sums, core_lengths *out, double *fine) {
    core_lane x, y, z, weight;
    core_rows_to_lanes((const double(*)[4])(const void *)sums, x, y, z, weight);
    for (int i = 0; i < CORE_LANES; ++i) {
        const double square = x[i] * x[i] + y[i] * y[i] + z[i] * z[i], length = sqrt(square);
        const int is_fine = (square > NORMA_TINIEST) & (square < NORMA_HUGEST) &
                            (length > 0x1p-20 * weight[i]) & (weight[i] > 0);
        out->x[i] = x[i];
        out->y[i] = y[i];
        out->z[i] = z[i];
        out->length[i] = length;
        fine[i] += is_fine ? 1 : 0;
    }
}

CORE_INLINE void core_lanes_directions(const core_lengths *of, float (*normals)[3]) {
    float out[3][CORE_LANES];
    for (int i = 0; i < CORE_LANES; ++i) {
        const double inverse = 1 / of->length[i];
        out[0][i] = (float)(of->x[i] * inverse) + 0.0F;
        out[1][i] = (float)(of->y[i] * inverse) + 0.0F;
        out[2][i] = (float)(of->z[i] * inverse) + 0.0F;
    }
    core_lanes_to_threes(out[0], out[1], out[2], CORE_LANES, normals);
}

CORE_INLINE double core_lanes_total(const double *v) {
    return ((v[0] + v[1]) + (v[2] + v[3])) + ((v[4] + v[5]) + (v[6] + v[7]));
}
#endif
