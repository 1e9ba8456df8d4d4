/* vertex_add.c: eight triangles at a time are read, measured and added; eight sums at a time become normals. Compiled for each instruction set. */
#include "vertex_add.h"
#include "lanes.h"
#include "measure_lanes.h"

enum { AHEAD = 32 };                      /* triangles between asking for memory and using it */

typedef struct triangle_batch {
    core_batch measured;
    uint32_t   at[3][CORE_LANES];         /* the corners' positions */
} triangle_batch;

/* ---- reading */

CORE_INLINE void read_corners(const core_mesh *mesh, size_t f, int lanes, triangle_batch *t)
{
    for (int i = 0; i < CORE_LANES; i++) {
        const size_t c = 3 * (i < lanes ? f + (size_t)i : f);             /* lanes beyond the end repeat the first */
        for (size_t k = 0; k < 3; k++) t->at[k][i] = norma_core_corner(mesh, c + k);
    }
}

CORE_INLINE void read_floats(const core_mesh *mesh, const uint32_t at[CORE_LANES], core_floats *out)
{
    const unsigned char *from[CORE_LANES];
    for (int i = 0; i < CORE_LANES; i++) from[i] = (const unsigned char *)mesh->positions.data + at[i] * mesh->positions.stride;
    core_gather_floats(from, out);
}

CORE_INLINE void read_edges(const core_mesh *mesh, triangle_batch *t)
{
    core_floats p[3];
    core_batch *m = &t->measured;
    for (int k = 0; k < 3; k++) read_floats(mesh, t->at[k], &p[k]);
    for (int k = 0; k < 3; k++)
        for (int i = 0; i < CORE_LANES; i++) {
            const double p0 = (double)p[0].axis[k][i], p1 = (double)p[1].axis[k][i], p2 = (double)p[2].axis[k][i];
            m->u[k][i] = p1 - p0;
            m->v[k][i] = p2 - p0;
            m->a[k][i] = p2 - p1;
        }
}

static void read_other_edges(const core_mesh *mesh, triangle_batch *t)
{
    core_batch *m = &t->measured;
    for (int i = 0; i < CORE_LANES; i++) {
        double p[3][3];
        for (int k = 0; k < 3; k++) norma_core_position(mesh, t->at[k][i], p[k]);
        for (int k = 0; k < 3; k++) {
            m->u[k][i] = p[1][k] - p[0][k];
            m->v[k][i] = p[2][k] - p[0][k];
            m->a[k][i] = p[2][k] - p[1][k];
        }
    }
}

/* Asks for the memory of triangles to come, into the second cache, to which twice as many requests are under way at once as to the first: positions, which may lie
 * across two lines, and sums. Where there is a map of welded positions, that is asked for earlier still. */
CORE_INLINE void look_ahead(const core_adder *adder, size_t f)
{
    const core_mesh *mesh = adder->mesh;
    const size_t begin = 3 * (f + AHEAD), end = begin + (size_t)3 * CORE_LANES, map = (size_t)3 * AHEAD;
    for (size_t c = begin; c < end && c < mesh->corner_count; c++) {
        const uint32_t at = norma_core_corner(mesh, c);
        const unsigned char *position = (const unsigned char *)mesh->positions.data + at * mesh->positions.stride;
        __builtin_prefetch(position, 0, 2);
        __builtin_prefetch(position + 11, 0, 2);
        const uint32_t sum = norma_core_welded(mesh, at) - adder->first;
        if (sum < adder->count) __builtin_prefetch(&adder->sums[sum], 0, 2);
        if (mesh->weld && c + map < mesh->corner_count) __builtin_prefetch(&mesh->weld[norma_core_corner(mesh, c + map)], 0, 2);
    }
}

/* ---- adding */

/* Corners of a range that is another's are added where nobody looks: to take no branch costs less than to guess it. */
CORE_INLINE void add_lane(const core_adder *adder, const triangle_batch *t, const core_rows *rows, int lane, vertex_sum nobodys[3])
{
    for (int k = 0; k < 3; k++) {
        const uint32_t sum = t->at[k][lane] - adder->first;
        core_add_row(sum < adder->count ? &adder->sums[sum].x : &nobodys[k].x, rows->row[lane], t->measured.weight[k][lane]);
    }
}

CORE_INLINE int all_sure(const core_batch *m)
{
    double sure = 0;
    for (int i = 0; i < CORE_LANES; i++) sure += m->sure[i];
    return sure == CORE_LANES;
}

static int has_three_places(const triangle_batch *t, int lane) { return t->at[0][lane] != t->at[1][lane] && t->at[1][lane] != t->at[2][lane] && t->at[2][lane] != t->at[0][lane]; }

CORE_INLINE void add_batch(const core_adder *adder, const triangle_batch *t, size_t f, int lanes, vertex_sum nobodys[3])
{
    static const double ones[CORE_LANES] = {1, 1, 1, 1, 1, 1, 1, 1};
    const core_batch *m = &t->measured;
    core_rows rows;
    core_lanes_to_rows(m->normal[0], m->normal[1], m->normal[2], ones, &rows);
    if (all_sure(m) && lanes == CORE_LANES && !adder->by_distance) {
        for (int i = 0; i < CORE_LANES; i++) add_lane(adder, t, &rows, i, nobodys);
        return;
    }
    for (int i = 0; i < lanes; i++) {
        if (m->sure[i] != 0 && has_three_places(t, i)) add_lane(adder, t, &rows, i, nobodys);
        else adder->add_face(adder->context, f + (size_t)i);
    }
}

CORE_INLINE void weld_batch(const core_mesh *mesh, triangle_batch *t)
{
    for (int k = 0; k < 3; k++)
        for (int i = 0; i < CORE_LANES; i++) t->at[k][i] = mesh->weld[t->at[k][i]];
}

CORE_INLINE void add_weighted(const core_adder *adder, size_t begin, size_t end, norma_weight weight)
{
    const core_mesh *mesh = adder->mesh;
    vertex_sum nobodys[3] = {{0, 0, 0, 0}, {0, 0, 0, 0}, {0, 0, 0, 0}};
    triangle_batch t;
    for (size_t f = begin; f < end; f += CORE_LANES) {
        const int lanes = end - f < CORE_LANES ? (int)(end - f) : CORE_LANES;
        if (adder->scattered) look_ahead(adder, f);
        read_corners(mesh, f, lanes, &t);
        if (mesh->positions.format == NORMA_FORMAT_FLOAT) read_edges(mesh, &t);
        else read_other_edges(mesh, &t);
        if (mesh->weld) weld_batch(mesh, &t);
        core_lanes_measure(&t.measured, weight, CORE_ALL_CORNERS);
        add_batch(adder, &t, f, lanes, nobodys);
    }
}

CORE_INLINE void add_triangles(const core_adder *adder, size_t begin, size_t end)
{
    switch (adder->weight) {
    case NORMA_WEIGHT_ANGLE:         add_weighted(adder, begin, end, NORMA_WEIGHT_ANGLE); break;
    case NORMA_WEIGHT_AREA:          add_weighted(adder, begin, end, NORMA_WEIGHT_AREA); break;
    case NORMA_WEIGHT_MAX:           add_weighted(adder, begin, end, NORMA_WEIGHT_MAX); break;
    case NORMA_WEIGHT_ANGLE_AREA:    add_weighted(adder, begin, end, NORMA_WEIGHT_ANGLE_AREA); break;
    case NORMA_WEIGHT_ANGLE_LENGTHS: add_weighted(adder, begin, end, NORMA_WEIGHT_ANGLE_LENGTHS); break;
    default:                         add_weighted(adder, begin, end, NORMA_WEIGHT_UNIFORM); break;
    }
}

/* ---- finishing */

CORE_INLINE int finish_sums(const vertex_sum *sums, float (*normals)[3])
{
    double x[CORE_LANES], y[CORE_LANES], z[CORE_LANES], weight[CORE_LANES], fine[CORE_LANES], all = 0;
    core_rows_to_lanes((const double(*)[4])(const void *)sums, x, y, z, weight);
    float out[3][CORE_LANES];
    for (int i = 0; i < CORE_LANES; i++) {
        const double square = x[i] * x[i] + y[i] * y[i] + z[i] * z[i], length = sqrt(square), inverse = 1 / length;
        fine[i] = (square > NORMA_TINIEST) & (square < NORMA_HUGEST) & (length > 0x1p-20 * weight[i]) & (weight[i] > 0) ? 1 : 0;
        out[0][i] = (float)(x[i] * inverse) + 0.0F;
        out[1][i] = (float)(y[i] * inverse) + 0.0F;
        out[2][i] = (float)(z[i] * inverse) + 0.0F;
    }
    for (int i = 0; i < CORE_LANES; i++) all += fine[i];
    for (int i = 0; i < CORE_LANES; i++)
        for (int k = 0; k < 3; k++) normals[i][k] = out[k][i];
    return all == CORE_LANES;
}

/* ---- for each instruction set */

static void add_portable(const core_adder *adder, size_t begin, size_t end) { add_triangles(adder, begin, end); }
static int finish_portable(const vertex_sum *sums, float (*normals)[3]) { return finish_sums(sums, normals); }

#if defined(CORE_HAS_X86)
CORE_FOR_AVX2 static void add_avx2(const core_adder *adder, size_t begin, size_t end) { add_triangles(adder, begin, end); }
CORE_FOR_AVX512 static void add_avx512(const core_adder *adder, size_t begin, size_t end) { add_triangles(adder, begin, end); }
CORE_FOR_AVX2 static int finish_avx2(const vertex_sum *sums, float (*normals)[3]) { return finish_sums(sums, normals); }
CORE_FOR_AVX512 static int finish_avx512(const vertex_sum *sums, float (*normals)[3]) { return finish_sums(sums, normals); }
static core_add_triangles *const ADD[] = {add_portable, add_avx2, add_avx512};
static core_finish_sums *const FINISH[] = {finish_portable, finish_avx2, finish_avx512};
#else
static core_add_triangles *const ADD[] = {add_portable};
static core_finish_sums *const FINISH[] = {finish_portable};
#endif

core_add_triangles *norma_core_choose_add(norma_isa isa) { return ADD[norma_core_level(isa)]; }
core_finish_sums   *norma_core_choose_finish(norma_isa isa) { return FINISH[norma_core_level(isa)]; }
