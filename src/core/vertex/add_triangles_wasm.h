/* add_triangles_wasm.h: for WebAssembly, triangles measured two at a time in registers: weighed by
 * area, they go from their corners to the sums; by angle, to eight that are added as elsewhere. The
 * batches of eight that suit other machines go through memory at every step where a register holds
 * two lanes. The same operations in the same order, hence the same bits, at half the time. */
#ifndef NORMA_CORE_VERTEX_ADD_SIMD128_H
#define NORMA_CORE_VERTEX_ADD_SIMD128_H
#if defined(__wasm_simd128__)
#include "core/call/call.h"
#include "core/face/face.h"
#include "core/vertex/add_eight_triangles.h"
#include <wasm_simd128.h>

/* Lane i of each: of triangle i. The normal times twice the area, and that. */
typedef struct core_two {
    v128_t x, y, z, area;
} core_two;

CORE_INLINE v128_t core_two_firsts(v128_t a, v128_t b) { return wasm_i64x2_shuffle(a, b, 0, 2); }
CORE_INLINE v128_t core_two_seconds(v128_t a, v128_t b) { return wasm_i64x2_shuffle(a, b, 1, 3); }

CORE_INLINE v128_t core_two_xy(const unsigned char *point) {
    return wasm_f64x2_promote_low_f32x4(wasm_v128_load64_zero(point));
}

/* Of a point of each. */
CORE_INLINE v128_t core_two_z(const unsigned char *one, const unsigned char *other) {
    return wasm_f64x2_promote_low_f32x4(
        wasm_v128_load32_lane(other + 8, wasm_v128_load32_zero(one + 8), 1));
}

CORE_INLINE v128_t core_two_dot(const v128_t a[3], const v128_t b[3]) {
    return wasm_f64x2_add(wasm_f64x2_add(wasm_f64x2_mul(a[0], b[0]), wasm_f64x2_mul(a[1], b[1])),
        wasm_f64x2_mul(a[2], b[2]));
}

CORE_INLINE v128_t core_two_cross(v128_t a, v128_t b, v128_t c, v128_t d) {
    return wasm_f64x2_sub(wasm_f64x2_mul(a, d), wasm_f64x2_mul(b, c));
}

/* norma_core_triangle_is_sure: a bit for each. */
CORE_INLINE unsigned core_two_are_sure(v128_t square, v128_t dot) {
    const v128_t thin = wasm_f64x2_mul(
        wasm_f64x2_const_splat(0x1p-40), wasm_f64x2_add(square, wasm_f64x2_mul(dot, dot)));
    const v128_t inside =
        wasm_v128_and(wasm_f64x2_gt(square, wasm_f64x2_const_splat(NORMA_TINIEST)),
            wasm_f64x2_lt(square, wasm_f64x2_const_splat(NORMA_HUGEST)));
    return wasm_i64x2_bitmask(wasm_v128_and(wasm_f64x2_ge(square, thin), inside));
}

/* at: the three points of one and those of the other. edge: from corner one to another. */
CORE_INLINE void core_two_edge(const unsigned char *const at[6], int from, int to, v128_t edge[3]) {
    const v128_t a = wasm_f64x2_sub(core_two_xy(at[to]), core_two_xy(at[from])),
                 b = wasm_f64x2_sub(core_two_xy(at[3 + to]), core_two_xy(at[3 + from]));
    edge[0] = core_two_firsts(a, b);
    edge[1] = core_two_seconds(a, b);
    edge[2] = wasm_f64x2_sub(core_two_z(at[to], at[3 + to]), core_two_z(at[from], at[3 + from]));
}

CORE_INLINE void core_two_normals(const v128_t u[3], const v128_t v[3], v128_t n[3]) {
    n[0] = core_two_cross(u[1], u[2], v[1], v[2]);
    n[1] = core_two_cross(u[2], u[0], v[2], v[0]);
    n[2] = core_two_cross(u[0], u[1], v[0], v[1]);
}

/* norma_core_triangle. Returns whether doubles are enough for both. */
CORE_INLINE int core_two_measure(const unsigned char *const at[6], core_two *t) {
    v128_t u[3], v[3], n[3];
    core_two_edge(at, 0, 1, u);
    core_two_edge(at, 0, 2, v);
    core_two_normals(u, v, n);
    const v128_t square = core_two_dot(n, n), length = wasm_f64x2_sqrt(square),
                 inverse = wasm_f64x2_div(wasm_f64x2_const_splat(1), length);
    t->x = wasm_f64x2_mul(wasm_f64x2_mul(n[0], inverse), length);
    t->y = wasm_f64x2_mul(wasm_f64x2_mul(n[1], inverse), length);
    t->z = wasm_f64x2_mul(wasm_f64x2_mul(n[2], inverse), length);
    t->area = length;
    return core_two_are_sure(square, core_two_dot(u, v)) == 3;
}

CORE_INLINE void core_two_add(double *sum, v128_t xy, v128_t zw) {
    wasm_v128_store(sum, wasm_f64x2_add(wasm_v128_load(sum), xy));
    wasm_v128_store(sum + 2, wasm_f64x2_add(wasm_v128_load(sum + 2), zw));
}

/* Whether core_add_pairs can: float positions without gaps, corners of 32 bits, all of them owned.
 */
static inline int core_can_add_pairs(const core_adder *a) {
    return a->owns_all && !a->by_distance && a->mesh->corner_size == 4 &&
           a->mesh->positions.format == NORMA_FORMAT_FLOAT &&
           a->mesh->positions.stride == 3 * sizeof(float);
}

/* Adds faces by area, two at a time, until fewer are left or doubles do not decide one of them.
 * Returns the first that is not added. */
static inline size_t core_add_pairs(const core_adder *adder, size_t f, size_t end) {
    const unsigned char *points = adder->mesh->positions.data;
    const uint32_t *corners = adder->mesh->corners, *weld = adder->mesh->weld;
    for (; f + 2 <= end; f += 2) {
        const uint32_t *c = corners + 3 * f;
        const unsigned char *at[6];
        core_two t;
        for (int i = 0; i < 6; i++) at[i] = points + 3 * sizeof(float) * c[i];
        if (!core_two_measure(at, &t)) break;
        const v128_t xy[2] = {core_two_firsts(t.x, t.y), core_two_seconds(t.x, t.y)},
                     zw[2] = {core_two_firsts(t.z, t.area), core_two_seconds(t.z, t.area)};
        for (int i = 0; i < 6; i++)
            core_two_add(
                &adder->sums[(weld ? weld[c[i]] : c[i]) - adder->first].x, xy[i / 3], zw[i / 3]);
    }
    return f;
}

/* ---- by angle: what measure_simd.h does to eight lanes */

CORE_INLINE v128_t core_two_choose(v128_t condition, v128_t yes, v128_t no) {
    return wasm_v128_bitselect(yes, no, condition);
}

/* a < b ? a : b */
CORE_INLINE v128_t core_two_lesser(v128_t a, v128_t b) { return wasm_f64x2_pmin(b, a); }
/* a < b ? b : a */
CORE_INLINE v128_t core_two_greater(v128_t a, v128_t b) { return wasm_f64x2_pmax(a, b); }

typedef struct core_two_slope {
    v128_t above, below, turn;
} core_two_slope;

/* norma_core_slope */
CORE_INLINE core_two_slope core_two_slope_of(v128_t y, v128_t x) {
    const v128_t small = core_two_lesser(y, x), large = core_two_greater(y, x);
    const v128_t steep = wasm_f64x2_gt(
                     small, wasm_f64x2_mul(wasm_f64x2_const_splat(0.41421356237309503), large)),
                 falls = wasm_f64x2_gt(y, x);
    const v128_t flat_turn = wasm_v128_and(falls, wasm_f64x2_const_splat(0.5 * NORMA_PI));
    return (core_two_slope){
        core_two_choose(steep, wasm_f64x2_sub(y, x), core_two_choose(falls, wasm_f64x2_neg(x), y)),
        core_two_choose(steep, wasm_f64x2_add(small, large), large),
        core_two_choose(steep, wasm_f64x2_const_splat(0.25 * NORMA_PI), flat_turn)};
}

/* norma_core_weight_atan */
CORE_INLINE v128_t core_two_atan(v128_t t) {
    const v128_t z = wasm_f64x2_mul(t, t);
    v128_t p = wasm_f64x2_const_splat(CORE_WEIGHT_ATAN_FIRST);
#define CORE_ADD_TERM(factor)                                                                      \
    p = wasm_f64x2_add(wasm_f64x2_mul(p, z), wasm_f64x2_const_splat(factor));
    CORE_WEIGHT_ATAN_OTHERS(CORE_ADD_TERM)
#undef CORE_ADD_TERM
    return wasm_f64x2_add(t, wasm_f64x2_mul(t, wasm_f64x2_mul(z, p)));
}

/* core_lanes_slopes and core_lanes_arcs; normal: made unit. d: the corners' dot products, length:
 * twice the area. */
CORE_INLINE void core_two_arcs(const v128_t d[3], v128_t length, v128_t normal[3], v128_t arc[2]) {
    const v128_t one = wasm_f64x2_const_splat(1), first = core_two_lesser(d[0], d[1]);
    const core_two_slope a = core_two_slope_of(length, core_two_greater(d[0], d[1])),
                         b = core_two_slope_of(length, core_two_greater(d[2], first));
    const v128_t inverse = wasm_f64x2_div(one, length),
                 belows = wasm_f64x2_div(one, wasm_f64x2_mul(a.below, b.below));
    for (int k = 0; k < 3; k++) normal[k] = wasm_f64x2_mul(normal[k], inverse);
    const v128_t tangents[2] = {wasm_f64x2_mul(a.above, wasm_f64x2_mul(belows, b.below)),
        wasm_f64x2_mul(b.above, wasm_f64x2_mul(belows, a.below))};
    arc[0] = wasm_f64x2_add(a.turn, core_two_atan(tangents[0]));
    arc[1] = wasm_f64x2_add(b.turn, core_two_atan(tangents[1]));
}

/* core_lanes_corner_angles */
CORE_INLINE void core_two_corner_angles(
    const v128_t d[3], const v128_t arc[2], double (*weight)[CORE_LANES]) {
    const v128_t less = wasm_f64x2_lt(d[0], d[1]), first = core_two_lesser(d[0], d[1]),
                 second = core_two_greater(d[0], d[1]), last = wasm_f64x2_lt(d[2], first),
                 third = core_two_greater(d[2], first), least = core_two_lesser(d[2], first);
    const v128_t left =
        wasm_f64x2_sub(wasm_f64x2_const_splat(NORMA_PI), wasm_f64x2_add(arc[0], arc[1]));
    const v128_t second_or_left = core_two_choose(wasm_f64x2_eq(least, second), arc[0], left),
                 rest = core_two_choose(wasm_f64x2_eq(least, third), arc[1], second_or_left),
                 of_first = core_two_choose(last, arc[1], rest);
    wasm_v128_store(weight[0], core_two_choose(less, of_first, arc[0]));
    wasm_v128_store(weight[1], core_two_choose(less, arc[0], of_first));
    wasm_v128_store(weight[2], core_two_choose(last, rest, arc[1]));
}

/* Two unit normals, as the rows that are added. */
CORE_INLINE void core_two_store_rows(const v128_t n[3], double (*row)[4]) {
    const v128_t one = wasm_f64x2_const_splat(1);
    wasm_v128_store(row[0], core_two_firsts(n[0], n[1]));
    wasm_v128_store(row[0] + 2, core_two_firsts(n[2], one));
    wasm_v128_store(row[1], core_two_seconds(n[0], n[1]));
    wasm_v128_store(row[1] + 2, core_two_seconds(n[2], one));
}

/* Returns which doubles decide. */
CORE_INLINE unsigned core_two_weigh(
    const unsigned char *const at[6], double (*row)[4], double (*weight)[CORE_LANES]) {
    v128_t u[3], v[3], across[3], n[3], arc[2];
    core_two_edge(at, 0, 1, u);
    core_two_edge(at, 0, 2, v);
    core_two_edge(at, 1, 2, across);
    core_two_normals(u, v, n);
    const v128_t square = core_two_dot(n, n), length = wasm_f64x2_sqrt(square);
    const v128_t d[3] = {
        core_two_dot(u, v), wasm_f64x2_neg(core_two_dot(u, across)), core_two_dot(v, across)};
    core_two_arcs(d, length, n, arc);
    core_two_corner_angles(d, arc, weight);
    core_two_store_rows(n, row);
    return core_two_are_sure(square, d[0]);
}

/* Whether core_measure_eight can: float positions, corners of 32 bits. */
static inline int core_can_measure_eight(const core_mesh *mesh) {
    return mesh->corner_size == sizeof(uint32_t) && mesh->positions.format == NORMA_FORMAT_FLOAT;
}

/* Face f and the seven that follow it. */
CORE_INLINE core_eight core_measure_eight(const core_mesh *mesh, size_t f, core_rows *rows,
    double (*weight)[CORE_LANES], uint32_t at[3 * CORE_LANES]) {
    const unsigned char *points = mesh->positions.data;
    const size_t stride = mesh->positions.stride;
    unsigned sure = 0;
    memcpy(at, (const uint32_t *)mesh->corners + 3 * f, 3 * CORE_LANES * sizeof *at);
    for (int i = 0; i < CORE_LANES; i += 2) {
        const unsigned char *corner[6];
        for (int k = 0; k < 6; k++) corner[k] = points + stride * at[3 * i + k];
        double(*const of_two)[CORE_LANES] = (double(*)[CORE_LANES])(void *)&weight[0][i];
        sure |= core_two_weigh(corner, &rows->row[i], of_two) << i;
    }
    for (int i = 0; i < 3 * CORE_LANES && mesh->weld; i++) at[i] = mesh->weld[at[i]];
    return (core_eight){(const double(*)[4])rows->row, weight, (const unsigned char *)at, sure};
}

/* Adds faces by angle, eight at a time, until fewer are left. Returns the first that is not added.
 */
static inline size_t core_add_eights(const core_adder *adder, size_t f, size_t end) {
    core_rows rows;
    double weight[3][CORE_LANES];
    uint32_t at[3 * CORE_LANES];
    for (; f + CORE_LANES <= end; f += CORE_LANES) {
        const core_eight eight = core_measure_eight(adder->mesh, f, &rows, weight, at);
        core_add_eight(adder, &eight, f, CORE_LANES, NORMA_WEIGHT_ANGLE);
    }
    return f;
}
#endif
#endif
