/* face_block_avx512.c: triangles weighed by their angles, eight in the registers of AVX-512, from
 * corners to rows. Loops over lanes take 16.8 cycles a triangle, these 14.4. */
#include "core/plan/face_block_avx512.h"
#if defined(CORE_HAS_AVX512)
#include "core/face/vectors_avx512.h"

#define VECTORS(name) core_avx512_##name
#define IN_VECTORS    CORE_IN_REGISTERS
typedef core_avx512_vector vector;
typedef core_avx512_mask mask;
#include "core/face/measure_triangles.template.h"

CORE_IN_REGISTERS __m512d two_rows(const double *low, const double *high) {
    return _mm512_insertf64x4(
        _mm512_castpd256_pd512(_mm256_loadu_pd(low)), _mm256_loadu_pd(high), 1);
}

/* Corner k of eight triangles, axis by axis. at: their vertices, three by three. */
CORE_IN_REGISTERS void read_corner_of_eight(
    const double (*rows)[4], const uint16_t *at, int k, __m512d axis[3]) {
    const __m512d a = two_rows(rows[at[k]], rows[at[6 + k]]),
                  b = two_rows(rows[at[3 + k]], rows[at[9 + k]]);
    const __m512d c = two_rows(rows[at[12 + k]], rows[at[18 + k]]),
                  d = two_rows(rows[at[15 + k]], rows[at[21 + k]]);
    const __m512d xz_low = _mm512_unpacklo_pd(a, b), xz_high = _mm512_unpacklo_pd(c, d);
    axis[0] = _mm512_shuffle_f64x2(xz_low, xz_high, 0x88);
    axis[1] = _mm512_shuffle_f64x2(_mm512_unpackhi_pd(a, b), _mm512_unpackhi_pd(c, d), 0x88);
    axis[2] = _mm512_shuffle_f64x2(xz_low, xz_high, 0xdd);
}

CORE_IN_REGISTERS void open_faces(const double (*rows)[4], const uint16_t *at, opened_faces *o) {
    __m512d p[3][3];
    for (int k = 0; k < 3; k++) read_corner_of_eight(rows, at, k, p[k]);
    open_points(p, NORMA_WEIGHT_ANGLE, o);
}

CORE_IN_REGISTERS void keep_faces(
    const opened_faces *o, const sloped_faces *s, uint32_t begin, block_room *room) {
    __m512d weight[3];
    weigh_faces(s, weight);
    core_avx512_store_rows(
        o->normal[0], o->normal[1], o->normal[2], _mm512_set1_pd(1), room->normals + begin);
    for (int k = 0; k < 3; k++)
        _mm512_storeu_pd(room->weights + ((size_t)k << BLOCK_FACE_BITS) + begin, weight[k]);
}

static void list_doubted(const block_view *t, uint32_t begin, unsigned sure, block_room *room) {
    for (uint32_t i = 0; i < CORE_LANES && begin + i < t->face_count; i++)
        if (!(sure >> i & 1U)) room->doubted[room->doubted_count++] = (uint16_t)(begin + i);
}

/* The next eight are read and multiplied while this one's divisions are under way: what waits for
 * them would otherwise keep the processor from seeing that far ahead. */
CORE_FOR_AVX512 void norma_core_block_angles_avx512(
    const block_view *t, block_some eights, block_room *room) {
    const double(*rows)[4] = (const double(*)[4])room->positions;
    uint32_t number = eights.count && eights.numbers ? eights.numbers[0] : 0;
    opened_faces o;
    if (eights.count) open_faces(rows, t->corners + (size_t)3 * CORE_LANES * number, &o);
    for (uint32_t i = 0; i < eights.count; i++) {
        const uint32_t after = i + 1 < eights.count ? i + 1 : i,
                       next = eights.numbers ? eights.numbers[after] : after;
        sloped_faces s;
        opened_faces opened;
        slope_faces(&o, &s);
        open_faces(rows, t->corners + (size_t)3 * CORE_LANES * next, &opened);
        norma_core_ask_ahead(&room->ahead);
        keep_faces(&o, &s, number * CORE_LANES, room);
        if (o.sure != UINT8_MAX) list_doubted(t, number * CORE_LANES, o.sure, room);
        o = opened;
        number = next;
    }
}
#endif
