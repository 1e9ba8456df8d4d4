/* plan_tile_sums.c: the loops in which an update spends its time: eight triangles at a time are read, measured and kept as rows; slots sum rows in the order of their members.
 * Compiled for each instruction set; what is computed is what norma_vertex_normals computes, by the same steps. */
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

/* at: the vertices of eight triangles, three by three. Rows of four floats are read whole. */
#if defined(CORE_HAS_SHUFFLES)
CORE_INLINE core_f8 two_rows(const float *one, const float *other)
{
    core_f4 a, b;
    memcpy(&a, one, sizeof a);
    memcpy(&b, other, sizeof b);
    return __builtin_shufflevector(a, b, 0, 1, 2, 3, 4, 5, 6, 7);
}

CORE_INLINE void read_floats(const float (*rows)[4], const uint16_t *at, double out[3][CORE_LANES])
{
    const core_f8 r0 = two_rows(rows[at[0]], rows[at[12]]), r1 = two_rows(rows[at[3]], rows[at[15]]);
    const core_f8 r2 = two_rows(rows[at[6]], rows[at[18]]), r3 = two_rows(rows[at[9]], rows[at[21]]);
    const core_f8 xy01 = __builtin_shufflevector(r0, r1, 0, 8, 1, 9, 4, 12, 5, 13), xy23 = __builtin_shufflevector(r2, r3, 0, 8, 1, 9, 4, 12, 5, 13);
    const core_f8 z01 = __builtin_shufflevector(r0, r1, 2, 10, 3, 11, 6, 14, 7, 15), z23 = __builtin_shufflevector(r2, r3, 2, 10, 3, 11, 6, 14, 7, 15);
    const core_f8 axes[3] = {__builtin_shufflevector(xy01, xy23, 0, 1, 8, 9, 4, 5, 12, 13), __builtin_shufflevector(xy01, xy23, 2, 3, 10, 11, 6, 7, 14, 15),
                             __builtin_shufflevector(z01, z23, 0, 1, 8, 9, 4, 5, 12, 13)};
    for (int axis = 0; axis < 3; axis++) {
        float lanes[CORE_LANES];
        memcpy(lanes, &axes[axis], sizeof lanes);
        for (int i = 0; i < CORE_LANES; i++) out[axis][i] = (double)lanes[i];
    }
}
#else
CORE_INLINE void read_floats(const float (*rows)[4], const uint16_t *at, double out[3][CORE_LANES])
{
    for (int axis = 0; axis < 3; axis++)
        for (int i = 0; i < CORE_LANES; i++) out[axis][i] = (double)rows[at[3 * i]][axis];
}
#endif

CORE_INLINE void read_doubles(const double (*rows)[4], const uint16_t *at, double out[3][CORE_LANES])
{
    core_rows eight;
    double nothing[CORE_LANES];
    for (int i = 0; i < CORE_LANES; i++) memcpy(eight.row[i], rows[at[3 * i]], sizeof eight.row[i]);
    core_rows_to_lanes((const double(*)[4])eight.row, out[0], out[1], out[2], nothing);
}

CORE_INLINE void read_edges(const tile_room *room, const uint16_t *at, core_batch *batch)
{
    double p[3][3][CORE_LANES];
    for (int k = 0; k < 3; k++) {
        if (room->format == NORMA_FORMAT_FLOAT) read_floats((const float(*)[4])room->positions.floats, at + k, p[k]);
        else read_doubles((const double(*)[4])room->positions.doubles, at + k, p[k]);
    }
    for (int axis = 0; axis < 3; axis++)
        for (int i = 0; i < CORE_LANES; i++) {
            batch->u[axis][i] = p[1][axis][i] - p[0][axis][i];
            batch->v[axis][i] = p[2][axis][i] - p[0][axis][i];
            batch->a[axis][i] = p[2][axis][i] - p[1][axis][i];
        }
}

CORE_INLINE void turn_normals(const core_batch *batch, core_rows *rows)
{
    static const double ones[CORE_LANES] = {1, 1, 1, 1, 1, 1, 1, 1};
    core_lanes_to_rows(batch->normal[0], batch->normal[1], batch->normal[2], ones, rows);
}

CORE_INLINE int all_sure(const core_batch *batch)
{
    double sure = 0;
    for (int i = 0; i < CORE_LANES; i++) sure += batch->sure[i];
    return sure == CORE_LANES;
}

static void list_doubted(const core_batch *batch, const uint32_t *faces, tile_room *room)
{
    for (int i = 0; i < CORE_LANES; i++)
        if (batch->sure[i] == 0 && (i == 0 || faces[i] != faces[i - 1])) room->doubted[room->doubted_count++] = (uint16_t)faces[i];
}

/* Eight by number. */
CORE_INLINE void measure_some(const tile_view *t, tile_some faces, uint32_t begin, norma_weight weight, tile_room *room)
{
    core_batch batch;
    core_rows rows;
    uint32_t names[CORE_LANES];
    uint16_t at[3 * CORE_LANES];
    name_some(faces, begin, CORE_LANES, names);
    for (int i = 0; i < CORE_LANES; i++) memcpy(at + 3 * i, t->corners + 3 * (size_t)names[i], 3 * sizeof *at);
    read_edges(room, at, &batch);
    core_lanes_measure(&batch, weight, CORE_ALL_CORNERS);
    turn_normals(&batch, &rows);
    for (int i = 0; i < CORE_LANES; i++) {
        memcpy(room->normals[names[i]], rows.row[i], sizeof rows.row[i]);
        for (uint32_t k = 0; k < 3; k++) room->weights[k << TILE_FACE_BITS | names[i]] = batch.weight[k][i];
    }
    if (!all_sure(&batch)) list_doubted(&batch, names, room);
}

/* Eight in a row. */
CORE_INLINE void measure_row(const tile_view *t, uint32_t begin, norma_weight weight, tile_room *room)
{
    core_batch batch;
    read_edges(room, t->corners + 3 * (size_t)begin, &batch);
    core_lanes_measure(&batch, weight, CORE_ALL_CORNERS);
    turn_normals(&batch, (core_rows *)(void *)room->normals[begin]);
    for (uint32_t k = 0; k < 3; k++) memcpy(&room->weights[k << TILE_FACE_BITS | begin], batch.weight[k], sizeof batch.weight[k]);
    if (all_sure(&batch)) return;
    uint32_t names[CORE_LANES];
    for (uint32_t i = 0; i < CORE_LANES; i++) names[i] = begin + i;
    list_doubted(&batch, names, room);
}

CORE_INLINE void measure_weighted(const tile_view *t, tile_some faces, norma_weight weight, tile_room *room)
{
    uint32_t begin = 0;
    for (; !faces.numbers && begin + CORE_LANES <= faces.count; begin += CORE_LANES) measure_row(t, begin, weight, room);
    for (; begin < faces.count; begin += CORE_LANES) measure_some(t, faces, begin, weight, room);
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

CORE_INLINE vertex_sum sum_slot(const tile_view *t, uint32_t slot, const tile_room *room, int polygons)
{
    const uint32_t end = norma_core_tile_start(t, slot + 1);
    vertex_sum sum = {0, 0, 0, -0.0};
    for (uint32_t i = norma_core_tile_start(t, slot); i < end; i++) {
        const uint32_t member = t->members[i];
        core_add_row(&sum.x, room->normals[polygons ? t->corner_faces[member] : member & (TILE_FACES - 1U)], room->weights[member]);
    }
    return sum;
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
        for (uint32_t i = 0; i < CORE_LANES; i++) sums[i] = sum_slot(t, number_at(slots, begin + i < slots.count ? begin + i : slots.count - 1), room, polygons);
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
