/* plan_tile_sums.c: the loops in which an update spends its time, compiled for each instruction set as measure.c is. */
#include "plan_tile.h"
#include "isa.h"
#include "triangle.h"

#if defined(__GNUC__)
#define INLINE static inline __attribute__((always_inline))
#else
#define INLINE static inline
#endif

INLINE uint32_t number_at(tile_some some, uint32_t i) { return some.numbers ? some.numbers[i] : i; }

/* ---- triangles: edges into lanes, results out of them */

INLINE void load_face(const tile_view *t, const tile_room *room, uint32_t face, core_batch *batch, int lane)
{
    const uint16_t *at = t->corners + 3 * (size_t)face;
    const double *p = room->positions[at[0]], *q = room->positions[at[1]], *r = room->positions[at[2]];
    for (int k = 0; k < 3; k++) {
        batch->u[k][lane] = q[k] - p[k];
        batch->v[k][lane] = r[k] - p[k];
        batch->a[k][lane] = r[k] - q[k];
    }
}

INLINE void store_face(const core_batch *batch, int lane, uint32_t face, tile_room *room)
{
    for (int k = 0; k < 3; k++) room->normals[face][k] = batch->normal[k][lane];
    room->normals[face][3] = 1;
}

INLINE void measure_triangles(const tile_view *t, tile_some faces, core_measure *measure, norma_weight weight, tile_room *room, uint8_t *unsure)
{
    core_batch batch;
    for (uint32_t begin = 0; begin < faces.count; begin += CORE_LANES) {
        uint32_t number[CORE_LANES];
        for (int i = 0; i < CORE_LANES; i++) number[i] = number_at(faces, begin + (uint32_t)i < faces.count ? begin + (uint32_t)i : begin);
        for (int i = 0; i < CORE_LANES; i++) load_face(t, room, number[i], &batch, i);
        measure(&batch, weight, CORE_ALL_CORNERS);
        for (int i = 0; i < CORE_LANES; i++) store_face(&batch, i, number[i], room);
        for (int k = 0; k < 3; k++)
            for (int i = 0; i < CORE_LANES; i++) room->weights[k << TILE_FACE_BITS | (int)number[i]] = batch.weight[k][i];
        for (int i = 0; i < CORE_LANES; i++) unsure[number[i]] = batch.sure[i] == 0;
    }
}

/* ---- sums: each in the order of its members */

INLINE void sum_slot(const tile_view *t, uint32_t slot, tile_room *room, int polygons)
{
    const uint32_t end = norma_core_tile_start(t, slot + 1);
    double sum[4] = {0, 0, 0, -0.0};
    for (uint32_t i = norma_core_tile_start(t, slot); i < end; i++) {
        const uint32_t member = t->members[i];
        const double *normal = room->normals[polygons ? t->corner_faces[member] : member & (TILE_FACES - 1U)], weight = room->weights[member];
        for (int k = 0; k < 4; k++) sum[k] += weight * normal[k];
    }
    for (int k = 0; k < 4; k++) room->sums[slot][k] = sum[k];
}

INLINE void sum_slots(const tile_view *t, tile_some slots, tile_room *room)
{
    if (t->corner_faces)
        for (uint32_t i = 0; i < slots.count; i++) sum_slot(t, number_at(slots, i), room, 1);
    else
        for (uint32_t i = 0; i < slots.count; i++) sum_slot(t, number_at(slots, i), room, 0);
}

/* ---- directions: of most sums at once, by the very steps of norma_core_plan_decide */

INLINE void decide_lanes(const uint32_t *slots, uint32_t count, tile_room *room)
{
    double square[CORE_LANES], length[CORE_LANES], unit[3][CORE_LANES], weight[CORE_LANES];
    for (int i = 0; i < CORE_LANES; i++) {
        const double *s = room->sums[slots[i]];
        square[i] = s[0] * s[0] + s[1] * s[1] + s[2] * s[2];
        weight[i] = s[3];
        for (int k = 0; k < 3; k++) unit[k][i] = s[k];
    }
    for (int i = 0; i < CORE_LANES; i++) length[i] = sqrt(square[i]);
    for (int k = 0; k < 3; k++)
        for (int i = 0; i < CORE_LANES; i++) unit[k][i] = unit[k][i] / length[i];
    for (uint32_t i = 0; i < count; i++) {
        float *result = room->results[slots[i]];
        const int plain = square[i] > NORMA_TINIEST && square[i] < NORMA_HUGEST && length[i] > 0x1p-20 * weight[i];
        for (int k = 0; k < 3; k++) result[k] = (float)unit[k][i] + 0.0F;
        room->reasons[slots[i]] = plain ? NORMA_REASON_NONE : (uint8_t)norma_core_plan_decide(room->sums[slots[i]], result);
    }
}

INLINE void decide_slots(tile_some slots, tile_room *room)
{
    for (uint32_t begin = 0; begin < slots.count; begin += CORE_LANES) {
        uint32_t number[CORE_LANES];
        for (int i = 0; i < CORE_LANES; i++) number[i] = number_at(slots, begin + (uint32_t)i < slots.count ? begin + (uint32_t)i : begin);
        decide_lanes(number, slots.count - begin < CORE_LANES ? slots.count - begin : CORE_LANES, room);
    }
}

/* ---- for each instruction set */

#define KERNELS(name, target)                                                                                                                                       \
    target static void measure_##name(const tile_view *t, tile_some faces, core_measure *measure, norma_weight weight, tile_room *room, uint8_t *unsure)            \
    {                                                                                                                                                               \
        measure_triangles(t, faces, measure, weight, room, unsure);                                                                                                 \
    }                                                                                                                                                               \
    target static void sum_##name(const tile_view *t, tile_some slots, tile_room *room) { sum_slots(t, slots, room); }                                              \
    target static void decide_##name(tile_some slots, tile_room *room) { decide_slots(slots, room); }

KERNELS(portable, )
#if defined(__GNUC__) && (defined(__x86_64__) || defined(__i386__))
KERNELS(avx2, __attribute__((target("avx2"))))

tile_kernels norma_core_tile_kernels(norma_isa isa)
{
    if (isa != NORMA_ISA_PORTABLE && isa != NORMA_ISA_SSE2 && norma_core_has_isa(NORMA_ISA_AVX2)) return (tile_kernels){measure_avx2, sum_avx2, decide_avx2};
    return (tile_kernels){measure_portable, sum_portable, decide_portable};
}
#else
tile_kernels norma_core_tile_kernels(norma_isa isa)
{
    (void)isa;
    return (tile_kernels){measure_portable, sum_portable, decide_portable};
}
#endif
