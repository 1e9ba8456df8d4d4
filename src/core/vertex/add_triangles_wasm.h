/* add_triangles_wasm.h: for WebAssembly, triangles added two at a time, weighed by area, from their
 * corners to the sums in registers. The batches of eight that suit other machines go through memory
 * at every step where a register holds two lanes. The same operations in the same order, hence the
 * same bits, at half the time. */
#ifndef NORMA_CORE_VERTEX_ADD_SIMD128_H
#define NORMA_CORE_VERTEX_ADD_SIMD128_H
#if defined(__wasm_simd128__)
#include "core/call/instruction_set.h"
#include "core/face/triangle.h"
#include "core/vertex/add_triangles.h"
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

CORE_INLINE v128_t core_two_dot(v128_t ax, v128_t ay, v128_t az, v128_t bx, v128_t by, v128_t bz) {
    return wasm_f64x2_add(
        wasm_f64x2_add(wasm_f64x2_mul(ax, bx), wasm_f64x2_mul(ay, by)), wasm_f64x2_mul(az, bz));
}

CORE_INLINE v128_t core_two_cross(v128_t a, v128_t b, v128_t c, v128_t d) {
    return wasm_f64x2_sub(wasm_f64x2_mul(a, d), wasm_f64x2_mul(b, c));
}

/* norma_core_triangle_is_sure of both. */
CORE_INLINE int core_two_are_sure(v128_t square, v128_t dot) {
    const v128_t thin = wasm_f64x2_mul(
        wasm_f64x2_const_splat(0x1p-40), wasm_f64x2_add(square, wasm_f64x2_mul(dot, dot)));
    const v128_t inside =
        wasm_v128_and(wasm_f64x2_gt(square, wasm_f64x2_const_splat(NORMA_TINIEST)),
            wasm_f64x2_lt(square, wasm_f64x2_const_splat(NORMA_HUGEST)));
    return wasm_i64x2_all_true(wasm_v128_and(wasm_f64x2_ge(square, thin), inside));
}

/* norma_core_triangle, at: the three points of one and those of the other. Returns whether doubles
 * are enough for both. */
CORE_INLINE int core_two_measure(const unsigned char *const at[6], core_two *t) {
    const v128_t p = core_two_xy(at[0]), q = core_two_xy(at[3]), z = core_two_z(at[0], at[3]);
    const v128_t pu = wasm_f64x2_sub(core_two_xy(at[1]), p),
                 pv = wasm_f64x2_sub(core_two_xy(at[2]), p);
    const v128_t qu = wasm_f64x2_sub(core_two_xy(at[4]), q),
                 qv = wasm_f64x2_sub(core_two_xy(at[5]), q);
    const v128_t ux = core_two_firsts(pu, qu), uy = core_two_seconds(pu, qu),
                 uz = wasm_f64x2_sub(core_two_z(at[1], at[4]), z);
    const v128_t vx = core_two_firsts(pv, qv), vy = core_two_seconds(pv, qv),
                 vz = wasm_f64x2_sub(core_two_z(at[2], at[5]), z);
    const v128_t nx = core_two_cross(uy, uz, vy, vz), ny = core_two_cross(uz, ux, vz, vx),
                 nz = core_two_cross(ux, uy, vx, vy);
    const v128_t square = core_two_dot(nx, ny, nz, nx, ny, nz), length = wasm_f64x2_sqrt(square),
                 inverse = wasm_f64x2_div(wasm_f64x2_const_splat(1), length);
    t->x = wasm_f64x2_mul(wasm_f64x2_mul(nx, inverse), length);
    t->y = wasm_f64x2_mul(wasm_f64x2_mul(ny, inverse), length);
    t->z = wasm_f64x2_mul(wasm_f64x2_mul(nz, inverse), length);
    t->area = length;
    return core_two_are_sure(square, core_two_dot(ux, uy, uz, vx, vy, vz));
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
#endif
#endif
