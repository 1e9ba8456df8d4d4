/* plan_tile_sums.c: the loops in which an update spends its time: eight triangles at a time are read, measured and kept as rows; slots sum rows in the order of their members.
 * Compiled for each instruction set; what is computed is what norma_vertex_normals computes, by the same steps. */
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC optimize("no-tree-slp-vectorize")    /* this compiler takes rows that are read whole apart again, number by number */
#endif
#include "lanes.h"
#include "measure_lanes.h"
#include "plan_tile.h"

CORE_INLINE uint32_t number_at(tile_some some, uint32_t i) { return some.numbers ? some.numbers[i] : i; }

/* Some in a row, or by number; the last one again where there are no more. */
CORE_INLINE void name_some(tile_some some, uint32_t begin, uint32_t count, uint32_t *out)
{
    for (uint32_t i = 0; i < count; i++) out[i] = number_at(some, begin + i < some.count ? begin + i : some.count - 1);
}

/* ---- triangles */

enum { BATCHES_AT_ONCE = 8 };

typedef struct tile_batch {
    core_batch measured;
    core_arcs  arcs;
} tile_batch;

/* at: the vertices of eight triangles, three by three. */
#if defined(CORE_HAS_SHUFFLES)
CORE_INLINE void read_four(const double (*rows)[4], const uint16_t *at, int first, core_batch *batch)
{
    core_d4 p[3][4];
    for (int k = 0; k < 3; k++) {
        for (int i = 0; i < 4; i++) p[k][i] = core_load_row(rows[at[3 * (first + i) + k]]);
        core_turn_rows(p[k]);
    }
    for (int x = 0; x < 3; x++) {
        core_store_row(batch->u[x] + first, p[1][x] - p[0][x]);
        core_store_row(batch->v[x] + first, p[2][x] - p[0][x]);
        core_store_row(batch->a[x] + first, p[2][x] - p[1][x]);
    }
}

CORE_INLINE void read_batch(const double (*rows)[4], const uint16_t *at, core_batch *batch)
{
    for (int first = 0; first < CORE_LANES; first += 4) read_four(rows, at, first, batch);
}
#else
CORE_INLINE void read_batch(const double (*rows)[4], const uint16_t *at, core_batch *batch)
{
    for (int x = 0; x < 3; x++)
        for (int i = 0; i < CORE_LANES; i++) {
            const double p0 = rows[at[3 * i]][x], p1 = rows[at[3 * i + 1]][x], p2 = rows[at[3 * i + 2]][x];
            batch->u[x][i] = p1 - p0;
            batch->v[x][i] = p2 - p0;
            batch->a[x][i] = p2 - p1;
        }
}
#endif

CORE_INLINE void read_named(const tile_view *t, const uint32_t names[CORE_LANES], const tile_room *room, core_batch *batch)
{
    uint16_t at[3 * CORE_LANES];
    for (int i = 0; i < CORE_LANES; i++) memcpy(at + 3 * i, t->corners + 3 * (size_t)names[i], 3 * sizeof *at);
    read_batch((const double(*)[4])room->positions, at, batch);
}

CORE_INLINE void measure_batches(tile_batch *batches, uint32_t count, norma_weight weight)
{
    if (weight != NORMA_WEIGHT_ANGLE) {
        for (uint32_t i = 0; i < count; i++) core_lanes_measure(&batches[i].measured, weight, CORE_ALL_CORNERS);
        return;
    }
    for (uint32_t i = 0; i < count; i++) core_lanes_products(&batches[i].measured);
    for (uint32_t i = 0; i < count; i++) core_lanes_slopes(&batches[i].measured, &batches[i].arcs);
    for (uint32_t i = 0; i < count; i++) core_lanes_arcs(&batches[i].arcs);
    for (uint32_t i = 0; i < count; i++) core_lanes_corner_angles(&batches[i].measured, &batches[i].arcs);
}

CORE_INLINE void turn_normals(const core_batch *batch, core_rows *rows)
{
    static const double ones[CORE_LANES] = {1, 1, 1, 1, 1, 1, 1, 1};
    core_lanes_to_rows(batch->normal[0], batch->normal[1], batch->normal[2], ones, rows);
}

CORE_INLINE void keep_row(const core_batch *batch, uint32_t begin, tile_room *room)
{
    turn_normals(batch, (core_rows *)(void *)room->normals[begin]);
    for (uint32_t k = 0; k < 3; k++) memcpy(&room->weights[k << TILE_FACE_BITS | begin], batch->weight[k], sizeof batch->weight[k]);
}

CORE_INLINE void keep_named(const core_batch *batch, const uint32_t names[CORE_LANES], tile_room *room)
{
    core_rows rows;
    turn_normals(batch, &rows);
    for (int i = 0; i < CORE_LANES; i++) {
        memcpy(room->normals[names[i]], rows.row[i], sizeof rows.row[i]);
        for (uint32_t k = 0; k < 3; k++) room->weights[k << TILE_FACE_BITS | names[i]] = batch->weight[k][i];
    }
}

CORE_INLINE int all_sure(const tile_batch *batches, uint32_t count)
{
    double sure[CORE_LANES] = {0}, all = 0;
    for (uint32_t b = 0; b < count; b++)
        for (int i = 0; i < CORE_LANES; i++) sure[i] += batches[b].measured.sure[i];
    for (int i = 0; i < CORE_LANES; i++) all += sure[i];
    return all == (double)count * CORE_LANES;
}

static void list_doubted(const tile_batch *batches, uint32_t count, tile_some faces, uint32_t begin, tile_room *room)
{
    for (uint32_t i = 0; i < count * CORE_LANES && begin + i < faces.count; i++)
        if (batches[i / CORE_LANES].measured.sure[i % CORE_LANES] == 0) room->doubted[room->doubted_count++] = (uint16_t)number_at(faces, begin + i);
}

/* Eight in a row each. */
CORE_INLINE void measure_rows(const tile_view *t, tile_some faces, uint32_t begin, uint32_t count, norma_weight weight, tile_room *room)
{
    tile_batch batches[BATCHES_AT_ONCE];
    for (uint32_t i = 0; i < count; i++) read_batch((const double(*)[4])room->positions, t->corners + 3 * (size_t)(begin + i * CORE_LANES), &batches[i].measured);
    measure_batches(batches, count, weight);
    for (uint32_t i = 0; i < count; i++) keep_row(&batches[i].measured, begin + i * CORE_LANES, room);
    if (!all_sure(batches, count)) list_doubted(batches, count, faces, begin, room);
}

/* Eight by number each. */
CORE_INLINE void measure_named(const tile_view *t, tile_some faces, uint32_t begin, uint32_t count, norma_weight weight, tile_room *room)
{
    tile_batch batches[BATCHES_AT_ONCE];
    uint32_t names[BATCHES_AT_ONCE][CORE_LANES];
    for (uint32_t i = 0; i < count; i++) {
        name_some(faces, begin + i * CORE_LANES, CORE_LANES, names[i]);
        read_named(t, names[i], room, &batches[i].measured);
    }
    measure_batches(batches, count, weight);
    for (uint32_t i = 0; i < count; i++) keep_named(&batches[i].measured, names[i], room);
    if (!all_sure(batches, count)) list_doubted(batches, count, faces, begin, room);
}

/* One batch after the other from end to end is a chain of some 200 steps that each wait for the one before, too long for the processor to see the next one's beginning. So
 * each step is taken for some batches at a time: they wait for nothing of each other. */
CORE_INLINE void measure_weighted(const tile_view *t, tile_some faces, norma_weight weight, tile_room *room)
{
    const uint32_t rows = faces.numbers ? 0 : faces.count / CORE_LANES, all = (faces.count + CORE_LANES - 1) / CORE_LANES;
    for (uint32_t i = 0; i < rows; i += BATCHES_AT_ONCE) measure_rows(t, faces, i * CORE_LANES, rows - i < BATCHES_AT_ONCE ? rows - i : BATCHES_AT_ONCE, weight, room);
    for (uint32_t i = rows; i < all; i += BATCHES_AT_ONCE) measure_named(t, faces, i * CORE_LANES, all - i < BATCHES_AT_ONCE ? all - i : BATCHES_AT_ONCE, weight, room);
}

/* One loop for each weight, so that none asks inside. */
CORE_INLINE void measure_triangles(const tile_view *t, tile_some faces, norma_weight weight, tile_room *room)
{
    switch (weight) {
    case NORMA_WEIGHT_ANGLE:         measure_weighted(t, faces, NORMA_WEIGHT_ANGLE, room); break;
    case NORMA_WEIGHT_AREA:          measure_weighted(t, faces, NORMA_WEIGHT_AREA, room); break;
    case NORMA_WEIGHT_MAX:           measure_weighted(t, faces, NORMA_WEIGHT_MAX, room); break;
    case NORMA_WEIGHT_ANGLE_AREA:    measure_weighted(t, faces, NORMA_WEIGHT_ANGLE_AREA, room); break;
    case NORMA_WEIGHT_ANGLE_LENGTHS: measure_weighted(t, faces, NORMA_WEIGHT_ANGLE_LENGTHS, room); break;
    default:                         measure_weighted(t, faces, NORMA_WEIGHT_UNIFORM, room); break;
    }
}

/* ---- slots */

CORE_INLINE void add_member(const tile_view *t, const tile_room *room, uint32_t member, int polygons, vertex_sum *sum)
{
    core_add_row(&sum->x, room->normals[polygons ? t->corner_faces[member] : member & (TILE_FACES - 1U)], room->weights[member]);
}

/* Four slots at a time as far as the shortest goes: what is added to one waits for what was added before, not for the others'. */
CORE_INLINE void sum_four(const tile_view *t, const uint32_t slots[4], const tile_room *room, int polygons, vertex_sum *out)
{
    const uint16_t *members[4];
    uint32_t counts[4], together = UINT32_MAX;
    for (int i = 0; i < 4; i++) {
        const uint32_t begin = norma_core_tile_start(t, slots[i]);
        members[i] = t->members + begin;
        counts[i] = norma_core_tile_start(t, slots[i] + 1) - begin;
        together = counts[i] < together ? counts[i] : together;
    }
    vertex_sum a = {0, 0, 0, -0.0}, b = a, c = a, d = a;
    for (uint32_t j = 0; j < together; j++) {
        add_member(t, room, members[0][j], polygons, &a);
        add_member(t, room, members[1][j], polygons, &b);
        add_member(t, room, members[2][j], polygons, &c);
        add_member(t, room, members[3][j], polygons, &d);
    }
    for (uint32_t j = together; j < counts[0]; j++) add_member(t, room, members[0][j], polygons, &a);
    for (uint32_t j = together; j < counts[1]; j++) add_member(t, room, members[1][j], polygons, &b);
    for (uint32_t j = together; j < counts[2]; j++) add_member(t, room, members[2][j], polygons, &c);
    for (uint32_t j = together; j < counts[3]; j++) add_member(t, room, members[3][j], polygons, &d);
    out[0] = a;
    out[1] = b;
    out[2] = c;
    out[3] = d;
}

static int decide_each(const vertex_sum *sums, uint32_t begin, uint32_t count, tile_room *room)
{
    int all = 1;
    for (uint32_t i = 0; i < count; i++) {
        const double sum[4] = {sums[i].x, sums[i].y, sums[i].z, sums[i].weight};
        room->reasons[begin + i] = (uint8_t)norma_core_plan_decide(sum, room->results[begin + i]);
        all &= room->reasons[begin + i] == NORMA_REASON_NONE;
    }
    return all;
}

CORE_INLINE int sum_weighted(const tile_view *t, tile_some slots, core_finish_sums *finish, tile_room *room, int polygons)
{
    int all = 1;
    memset(room->reasons, NORMA_REASON_NONE, slots.count);
    for (uint32_t begin = 0; begin < slots.count; begin += CORE_LANES) {
        vertex_sum sums[CORE_LANES];
        uint32_t names[CORE_LANES];
        name_some(slots, begin, CORE_LANES, names);
        for (uint32_t i = 0; i < CORE_LANES; i += 4) sum_four(t, names + i, room, polygons, sums + i);
        if (finish(sums, room->results + begin)) continue;
        all &= decide_each(sums, begin, slots.count - begin < CORE_LANES ? slots.count - begin : CORE_LANES, room);
    }
    return all;
}

CORE_INLINE int sum_slots(const tile_view *t, tile_some slots, core_finish_sums *finish, tile_room *room)
{
    return t->corner_faces ? sum_weighted(t, slots, finish, room, 1) : sum_weighted(t, slots, finish, room, 0);
}

/* ---- for each instruction set */

static void measure_portable(const tile_view *t, tile_some faces, norma_weight weight, tile_room *room) { measure_triangles(t, faces, weight, room); }
static int sum_portable(const tile_view *t, tile_some slots, core_finish_sums *finish, tile_room *room) { return sum_slots(t, slots, finish, room); }

#if defined(CORE_HAS_X86)
CORE_FOR_AVX2 static void measure_avx2(const tile_view *t, tile_some faces, norma_weight weight, tile_room *room) { measure_triangles(t, faces, weight, room); }
CORE_FOR_AVX2 static int sum_avx2(const tile_view *t, tile_some slots, core_finish_sums *finish, tile_room *room) { return sum_slots(t, slots, finish, room); }
CORE_FOR_AVX512 static void measure_avx512(const tile_view *t, tile_some faces, norma_weight weight, tile_room *room) { measure_triangles(t, faces, weight, room); }

/* Rows are of four: wider registers do not help to sum them. */
tile_kernels norma_core_tile_kernels(norma_isa isa)
{
    core_finish_sums *const finish = norma_core_choose_finish(isa);
    switch (norma_core_level(isa)) {
    case CORE_AVX512: return (tile_kernels){measure_avx512, sum_avx2, finish};
    case CORE_AVX2:   return (tile_kernels){measure_avx2, sum_avx2, finish};
    default:          return (tile_kernels){measure_portable, sum_portable, finish};
    }
}
#else
tile_kernels norma_core_tile_kernels(norma_isa isa) { return (tile_kernels){measure_portable, sum_portable, norma_core_choose_finish(isa)}; }
#endif
