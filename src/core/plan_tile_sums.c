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

/* ---- positions */

#if defined(CORE_HAS_SHUFFLES)
CORE_INLINE int load_floats(const tile_view *t, const unsigned char *data, size_t stride, double (*out)[4])
{
    core_d4 zero = {0, 0, 0, 0};
    for (uint32_t v = 0; v < t->vertex_count; v++) {
        const core_d4 at = __builtin_convertvector(core_load_three(data + t->vertices[v] * stride), core_d4);
        core_store_row(out[v], at);
        zero += at - at;
    }
    return (zero[0] + zero[1]) + (zero[2] + zero[3]) == 0;
}
#else
CORE_INLINE int load_floats(const tile_view *t, const unsigned char *data, size_t stride, double (*out)[4])
{
    double zero = 0;
    for (uint32_t v = 0; v < t->vertex_count; v++) {
        float at[3];
        memcpy(at, data + t->vertices[v] * stride, sizeof at);
        for (int k = 0; k < 3; k++) {
            out[v][k] = (double)at[k];
            zero += out[v][k] - out[v][k];
        }
        out[v][3] = 0;
    }
    return zero == 0;
}
#endif

/* ---- triangles */

enum { BATCHES_AT_ONCE = 4 };               /* more would leave the nearest cache less for the tile */

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
    double sure[CORE_LANES] = {0};
    for (uint32_t b = 0; b < count; b++)
        for (int i = 0; i < CORE_LANES; i++) sure[i] += batches[b].measured.sure[i];
    return ((sure[0] + sure[1]) + (sure[2] + sure[3])) + ((sure[4] + sure[5]) + (sure[6] + sure[7])) == (double)count * CORE_LANES;
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

/* x, y, z and the weight of one slot, in a register where there are some. */
#if defined(CORE_HAS_SHUFFLES)
typedef core_d4 slot_sum;
CORE_INLINE slot_sum no_votes(void) { return (slot_sum){0, 0, 0, -0.0}; }
CORE_INLINE slot_sum add_row(slot_sum sum, const double *row, double weight) { return sum + core_load_row(row) * (core_d4){weight, weight, weight, weight}; }
CORE_INLINE void keep_sum(slot_sum sum, vertex_sum *out) { core_store_row(&out->x, sum); }
#else
typedef vertex_sum slot_sum;
CORE_INLINE slot_sum no_votes(void) { return (slot_sum){0, 0, 0, -0.0}; }
CORE_INLINE slot_sum add_row(slot_sum sum, const double *row, double weight)
{
    return (slot_sum){sum.x + row[0] * weight, sum.y + row[1] * weight, sum.z + row[2] * weight, sum.weight + row[3] * weight};
}
CORE_INLINE void keep_sum(slot_sum sum, vertex_sum *out) { *out = sum; }
#endif

typedef struct slot_members { const uint16_t *numbers; uint32_t count; } slot_members;

CORE_INLINE slot_members members_of(const tile_view *t, uint32_t slot)
{
    const uint32_t begin = norma_core_tile_start(t, slot);
    return (slot_members){t->members + begin, norma_core_tile_start(t, slot + 1) - begin};
}

CORE_INLINE slot_sum add_member(const tile_view *t, const tile_room *room, slot_members of, uint32_t i, int polygons, slot_sum sum)
{
    const uint32_t member = of.numbers[i];
    return add_row(sum, room->normals[polygons ? t->corner_faces[member] : member & (TILE_FACES - 1U)], room->weights[member]);
}

CORE_INLINE void add_rest(const tile_view *t, const tile_room *room, slot_members of, uint32_t from, int polygons, slot_sum sum, vertex_sum *out)
{
    for (uint32_t i = from; i < of.count; i++) sum = add_member(t, room, of, i, polygons, sum);
    keep_sum(sum, out);
}

/* Four slots at a time as far as the shortest goes: what is added to one waits for what was added before, not for the others'. */
CORE_INLINE void sum_four(const tile_view *t, const uint32_t slots[4], const tile_room *room, int polygons, vertex_sum *out)
{
    const slot_members a = members_of(t, slots[0]), b = members_of(t, slots[1]), c = members_of(t, slots[2]), d = members_of(t, slots[3]);
    const uint32_t ab = a.count < b.count ? a.count : b.count, cd = c.count < d.count ? c.count : d.count, together = ab < cd ? ab : cd;
    slot_sum sum_a = no_votes(), sum_b = sum_a, sum_c = sum_a, sum_d = sum_a;
    for (uint32_t i = 0; i < together; i++) {
        sum_a = add_member(t, room, a, i, polygons, sum_a);
        sum_b = add_member(t, room, b, i, polygons, sum_b);
        sum_c = add_member(t, room, c, i, polygons, sum_c);
        sum_d = add_member(t, room, d, i, polygons, sum_d);
    }
    add_rest(t, room, a, together, polygons, sum_a, out);
    add_rest(t, room, b, together, polygons, sum_b, out + 1);
    add_rest(t, room, c, together, polygons, sum_c, out + 2);
    add_rest(t, room, d, together, polygons, sum_d, out + 3);
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

enum { SLOTS_AT_ONCE = 64 };

/* Sums first, then their normals: a root and a division that the next eight wait for would be in the way of adding. */
CORE_INLINE int sum_some(const tile_view *t, tile_some slots, uint32_t begin, uint32_t count, core_finish_sums *finish, tile_room *room, int polygons)
{
    vertex_sum sums[SLOTS_AT_ONCE];
    int all = 1;
    for (uint32_t i = 0; i < (count + CORE_LANES - 1) / CORE_LANES * CORE_LANES; i += 4) {
        uint32_t names[4];
        name_some(slots, begin + i, 4, names);
        sum_four(t, names, room, polygons, sums + i);
    }
    for (uint32_t i = 0; i < count; i += CORE_LANES) {
        if (finish(sums + i, room->results + begin + i)) continue;
        all &= decide_each(sums + i, begin + i, count - i < CORE_LANES ? count - i : CORE_LANES, room);
    }
    return all;
}

CORE_INLINE int sum_all(const tile_view *t, tile_some slots, core_finish_sums *finish, tile_room *room, int polygons)
{
    int all = 1;
    memset(room->reasons, NORMA_REASON_NONE, slots.count);
    for (uint32_t begin = 0; begin < slots.count; begin += SLOTS_AT_ONCE)
        all &= sum_some(t, slots, begin, slots.count - begin < SLOTS_AT_ONCE ? slots.count - begin : SLOTS_AT_ONCE, finish, room, polygons);
    return all;
}

CORE_INLINE int sum_slots(const tile_view *t, tile_some slots, core_finish_sums *finish, tile_room *room)
{
    const tile_some row = {NULL, slots.count};
    if (t->corner_faces) return sum_all(t, slots, finish, room, 1);
    return slots.numbers ? sum_all(t, slots, finish, room, 0) : sum_all(t, row, finish, room, 0);
}

/* ---- for each instruction set */

static int load_portable(const tile_view *t, const unsigned char *data, size_t stride, double (*out)[4]) { return load_floats(t, data, stride, out); }
static void measure_portable(const tile_view *t, tile_some faces, norma_weight weight, tile_room *room) { measure_triangles(t, faces, weight, room); }
static int sum_portable(const tile_view *t, tile_some slots, core_finish_sums *finish, tile_room *room) { return sum_slots(t, slots, finish, room); }

#if defined(CORE_HAS_X86)
CORE_FOR_AVX2 static int load_avx2(const tile_view *t, const unsigned char *data, size_t stride, double (*out)[4]) { return load_floats(t, data, stride, out); }
CORE_FOR_AVX2 static void measure_avx2(const tile_view *t, tile_some faces, norma_weight weight, tile_room *room) { measure_triangles(t, faces, weight, room); }
CORE_FOR_AVX2 static int sum_avx2(const tile_view *t, tile_some slots, core_finish_sums *finish, tile_room *room) { return sum_slots(t, slots, finish, room); }
CORE_FOR_AVX512 static void measure_avx512(const tile_view *t, tile_some faces, norma_weight weight, tile_room *room) { measure_triangles(t, faces, weight, room); }

/* Rows are of four: wider registers do not help to sum them. */
tile_kernels norma_core_tile_kernels(norma_isa isa)
{
    core_finish_sums *const finish = norma_core_choose_finish(isa);
    switch (norma_core_level(isa)) {
    case CORE_AVX512: return (tile_kernels){load_avx2, measure_avx512, sum_avx2, finish};
    case CORE_AVX2:   return (tile_kernels){load_avx2, measure_avx2, sum_avx2, finish};
    default:          return (tile_kernels){load_portable, measure_portable, sum_portable, finish};
    }
}
#else
tile_kernels norma_core_tile_kernels(norma_isa isa) { return (tile_kernels){load_portable, measure_portable, sum_portable, norma_core_choose_finish(isa)}; }
#endif
