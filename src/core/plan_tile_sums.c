/* plan_tile_sums.c: the loops in which an update spends its time, compiled for each instruction set as measure.c is. Records of four doubles (a position, a normal and 1, a
 * sum) are what sums and tables want, lanes of eight what roots and quotients want; between the two, four records at a time are turned round in registers. */
#include "plan_tile.h"
#include "isa.h"
#include "triangle.h"

#if defined(__GNUC__)
#define INLINE static inline __attribute__((always_inline))
typedef double quad __attribute__((vector_size(32), aligned(8), may_alias));
#define QUAD(address) (*(quad *)(void *)(address))
#define QUAD_IN(address) (*(const quad *)(const void *)(address))

/* Four records r to three lanes at x, y, z. */
#define TURN(r, x, y, z)                                                                                                                                            \
    do {                                                                                                                                                            \
        const quad xz_ = __builtin_shufflevector((r)[0], (r)[1], 0, 4, 2, 6), yw_ = __builtin_shufflevector((r)[0], (r)[1], 1, 5, 3, 7);                            \
        const quad xz2_ = __builtin_shufflevector((r)[2], (r)[3], 0, 4, 2, 6), yw2_ = __builtin_shufflevector((r)[2], (r)[3], 1, 5, 3, 7);                          \
        QUAD(x) = __builtin_shufflevector(xz_, xz2_, 0, 1, 4, 5);                                                                                                   \
        QUAD(y) = __builtin_shufflevector(yw_, yw2_, 0, 1, 4, 5);                                                                                                   \
        QUAD(z) = __builtin_shufflevector(xz_, xz2_, 2, 3, 6, 7);                                                                                                   \
    } while (0)
#else
#define INLINE static inline
#endif

INLINE uint32_t number_at(tile_some some, uint32_t i) { return some.numbers ? some.numbers[i] : i; }

/* ---- triangles: edges into lanes, results out of them */

INLINE void load_faces(const tile_view *t, const tile_room *room, const uint32_t *faces, core_batch *batch)
{
#if defined(__GNUC__)
    for (int half = 0; half < CORE_LANES; half += 4) {
        quad u[4], v[4], a[4];
        for (int i = 0; i < 4; i++) {
            const uint16_t *at = t->corners + 3 * (size_t)faces[half + i];
            const quad p = QUAD_IN(room->positions[at[0]]), q = QUAD_IN(room->positions[at[1]]), r = QUAD_IN(room->positions[at[2]]);
            u[i] = q - p;
            v[i] = r - p;
            a[i] = r - q;
        }
        TURN(u, &batch->u[0][half], &batch->u[1][half], &batch->u[2][half]);
        TURN(v, &batch->v[0][half], &batch->v[1][half], &batch->v[2][half]);
        TURN(a, &batch->a[0][half], &batch->a[1][half], &batch->a[2][half]);
    }
#else
    for (int i = 0; i < CORE_LANES; i++) {
        const uint16_t *at = t->corners + 3 * (size_t)faces[i];
        for (int k = 0; k < 3; k++) {
            batch->u[k][i] = room->positions[at[1]][k] - room->positions[at[0]][k];
            batch->v[k][i] = room->positions[at[2]][k] - room->positions[at[0]][k];
            batch->a[k][i] = room->positions[at[2]][k] - room->positions[at[1]][k];
        }
    }
#endif
}

INLINE void store_normals(const core_batch *batch, const uint32_t *faces, tile_room *room)
{
#if defined(__GNUC__)
    const quad one = {1, 1, 1, 1};
    for (int half = 0; half < CORE_LANES; half += 4) {
        const quad x = QUAD_IN(&batch->normal[0][half]), y = QUAD_IN(&batch->normal[1][half]), z = QUAD_IN(&batch->normal[2][half]);
        const quad xy = __builtin_shufflevector(x, y, 0, 4, 2, 6), xy2 = __builtin_shufflevector(x, y, 1, 5, 3, 7);
        const quad z1 = __builtin_shufflevector(z, one, 0, 4, 2, 6), z12 = __builtin_shufflevector(z, one, 1, 5, 3, 7);
        QUAD(room->normals[faces[half]]) = __builtin_shufflevector(xy, z1, 0, 1, 4, 5);
        QUAD(room->normals[faces[half + 1]]) = __builtin_shufflevector(xy2, z12, 0, 1, 4, 5);
        QUAD(room->normals[faces[half + 2]]) = __builtin_shufflevector(xy, z1, 2, 3, 6, 7);
        QUAD(room->normals[faces[half + 3]]) = __builtin_shufflevector(xy2, z12, 2, 3, 6, 7);
    }
#else
    for (int i = 0; i < CORE_LANES; i++) {
        for (int k = 0; k < 3; k++) room->normals[faces[i]][k] = batch->normal[k][i];
        room->normals[faces[i]][3] = 1;
    }
#endif
}

INLINE void store_weights(const core_batch *batch, const uint32_t *faces, int in_a_row, tile_room *room)
{
    double least = 1;
    for (uint32_t k = 0; k < 3; k++) {
        if (in_a_row) memcpy(&room->weights[k << TILE_FACE_BITS | faces[0]], batch->weight[k], sizeof batch->weight[k]);
        else
            for (int i = 0; i < CORE_LANES; i++) room->weights[k << TILE_FACE_BITS | faces[i]] = batch->weight[k][i];
    }
    for (int i = 0; i < CORE_LANES; i++) least = batch->sure[i] < least ? batch->sure[i] : least;
    if (least > 0) return;
    for (int i = 0; i < CORE_LANES; i++)
        if (batch->sure[i] == 0 && (i == 0 || faces[i] != faces[i - 1])) room->doubted[room->doubted_count++] = (uint16_t)faces[i];
}

/* Some in a row, or by number; the last ones again where there are no more. */
INLINE void name_some(tile_some faces, uint32_t begin, uint32_t *out)
{
    for (uint32_t i = 0; i < CORE_LANES; i++) out[i] = number_at(faces, begin + i < faces.count ? begin + i : faces.count - 1);
}

/* A batch is filled while the one before waits: what was just written in parts cannot be read at once as a whole. */
INLINE void measure_triangles(const tile_view *t, tile_some faces, core_measure *measure, norma_weight weight, tile_room *room)
{
    core_batch batches[2];
    uint32_t names[2][CORE_LANES];
    if (!faces.count) return;
    name_some(faces, 0, names[0]);
    load_faces(t, room, names[0], &batches[0]);
    for (uint32_t begin = 0, turn = 0; begin < faces.count; begin += CORE_LANES, turn = 1 - turn) {
        name_some(faces, begin + CORE_LANES, names[1 - turn]);
        load_faces(t, room, names[1 - turn], &batches[1 - turn]);
        measure(&batches[turn], weight, CORE_ALL_CORNERS);
        store_normals(&batches[turn], names[turn], room);
        store_weights(&batches[turn], names[turn], !faces.numbers && begin + CORE_LANES <= faces.count, room);
    }
}

/* ---- sums: each in the order of its members */

INLINE void sum_slot(const tile_view *t, uint32_t slot, const tile_room *room, int polygons, double *out)
{
    const uint32_t end = norma_core_tile_start(t, slot + 1);
#if defined(__GNUC__)
    quad sum = {0, 0, 0, -0.0};
#else
    double sum[4] = {0, 0, 0, -0.0};
#endif
    for (uint32_t i = norma_core_tile_start(t, slot); i < end; i++) {
        const uint32_t member = t->members[i];
        const double *normal = room->normals[polygons ? t->corner_faces[member] : member & (TILE_FACES - 1U)], weight = room->weights[member];
#if defined(__GNUC__)
        sum += (quad){weight, weight, weight, weight} * QUAD_IN(normal);
#else
        for (int k = 0; k < 4; k++) sum[k] += weight * normal[k];
#endif
    }
    memcpy(out, &sum, sizeof sum);
}

/* Four sums to lanes. */
INLINE void store_sums(const double (*sums)[4], uint32_t at, tile_room *room)
{
#if defined(__GNUC__)
    const quad r[4] = {QUAD_IN(sums[0]), QUAD_IN(sums[1]), QUAD_IN(sums[2]), QUAD_IN(sums[3])};
    TURN(r, &room->sums[0][at], &room->sums[1][at], &room->sums[2][at]);
    for (uint32_t i = 0; i < 4; i++) room->sums[3][at + i] = sums[i][3];
#else
    for (uint32_t i = 0; i < 4; i++)
        for (int k = 0; k < 4; k++) room->sums[k][at + i] = sums[i][k];
#endif
}

INLINE void sum_some(const tile_view *t, tile_some slots, tile_room *room, int polygons)
{
    for (uint32_t begin = 0; begin < slots.count; begin += 4) {
        double sums[4][4];
        for (uint32_t i = 0; i < 4; i++) sum_slot(t, number_at(slots, begin + i < slots.count ? begin + i : slots.count - 1), room, polygons, sums[i]);
        store_sums((const double(*)[4])sums, begin, room);
    }
}

/* Directions of all sums at once, by the very steps of norma_core_plan_decide, which decides by itself where they do not do. Returns whether all have one. */
INLINE int decide_all(uint32_t count, tile_room *room)
{
    const double *x = room->sums[0], *y = room->sums[1], *z = room->sums[2], *weight = room->sums[3];
    float *nx = room->results[0], *ny = room->results[1], *nz = room->results[2];
    uint32_t plain = 0, all = 0;
    for (uint32_t i = 0; i < count; i++) {
        const double square = x[i] * x[i] + y[i] * y[i] + z[i] * z[i], length = sqrt(square);
        nx[i] = (float)(x[i] / length) + 0.0F;
        ny[i] = (float)(y[i] / length) + 0.0F;
        nz[i] = (float)(z[i] / length) + 0.0F;
        plain += (square > NORMA_TINIEST) & (square < NORMA_HUGEST) & (length > 0x1p-20 * weight[i]);
    }
    memset(room->reasons, NORMA_REASON_NONE, count);
    if (plain == count) return 1;
    for (uint32_t i = 0; i < count; i++) {
        const double sum[4] = {x[i], y[i], z[i], weight[i]};
        float normal[3] = {0, 0, 0};
        room->reasons[i] = (uint8_t)norma_core_plan_decide(sum, normal);
        for (int k = 0; k < 3; k++) room->results[k][i] = normal[k];
        all += room->reasons[i] == NORMA_REASON_NONE;
    }
    return all == count;
}

INLINE int sum_slots(const tile_view *t, tile_some slots, tile_room *room, int polygons)
{
    sum_some(t, slots, room, polygons);
    return decide_all(slots.count, room);
}

/* ---- for each instruction set */

#define KERNELS(name, target)                                                                                                                                       \
    target static void measure_##name(const tile_view *t, tile_some faces, core_measure *measure, norma_weight weight, tile_room *room)                             \
    {                                                                                                                                                               \
        measure_triangles(t, faces, measure, weight, room);                                                                                                         \
    }                                                                                                                                                               \
    target static int sum_##name(const tile_view *t, tile_some slots, tile_room *room)                                                                              \
    {                                                                                                                                                               \
        return t->corner_faces ? sum_slots(t, slots, room, 1) : sum_slots(t, slots, room, 0);                                                                       \
    }

KERNELS(portable, )
#if defined(__GNUC__) && (defined(__x86_64__) || defined(__i386__))
KERNELS(avx2, __attribute__((target("avx2"))))

tile_kernels norma_core_tile_kernels(norma_isa isa)
{
    if (isa != NORMA_ISA_PORTABLE && isa != NORMA_ISA_SSE2 && norma_core_has_isa(NORMA_ISA_AVX2)) return (tile_kernels){measure_avx2, sum_avx2};
    return (tile_kernels){measure_portable, sum_portable};
}
#else
tile_kernels norma_core_tile_kernels(norma_isa isa)
{
    (void)isa;
    return (tile_kernels){measure_portable, sum_portable};
}
#endif
