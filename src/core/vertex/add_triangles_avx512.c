/* add_triangles_avx512.c: triangles of floats and doubles added to the sums of their corners, eight
 * in the registers of AVX-512 from corners to rows. The numbers and their bits are those of
 * add_triangles.c; 8.5 instead of 12.4 ns a triangle by angle, 6.8 instead of 10.7 by area. */
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC optimize("no-tree-slp-vectorize") /* as in add_triangles.c */
#endif
#include "core/vertex/add_triangles_avx512.h"
#if defined(CORE_HAS_AVX512)
#include "core/face/measure_avx512.h"
#include "core/vertex/add_eight_triangles.h"

/* What is kept of eight triangles until they are added. */
typedef struct kept_eight {
    _Alignas(64) double row[CORE_LANES][4];
    double weight[3][CORE_LANES];
    uint32_t welded[3 * CORE_LANES];
    unsigned sure;
} kept_eight;

static const unsigned char *corners_of(const core_mesh *mesh, size_t f) {
    return (const unsigned char *)mesh->corners + 3 * sizeof(uint32_t) * f;
}

/* ---- reading */

/* Three floats, and not a byte beyond them. */
CORE_IN_REGISTERS __m128 read_point(const core_mesh *mesh, const unsigned char *corner) {
    uint32_t at;
    memcpy(&at, corner, sizeof at);
    return _mm_maskz_loadu_ps(
        7, (const unsigned char *)mesh->positions.data + at * mesh->positions.stride);
}

/* Corner k of triangles i and i + 4. */
CORE_IN_REGISTERS __m256d two_points(
    const core_mesh *mesh, const unsigned char *corners, int i, int k) {
    const __m128 low = read_point(mesh, corners + 4 * (3 * i + k)),
                 high = read_point(mesh, corners + 4 * (3 * i + 12 + k));
    return _mm256_castps_pd(_mm256_insertf128_ps(_mm256_castps128_ps256(low), high, 1));
}

CORE_IN_REGISTERS __m256d low_pairs(__m256d a, __m256d b) {
    return _mm256_castps_pd(_mm256_unpacklo_ps(_mm256_castpd_ps(a), _mm256_castpd_ps(b)));
}
CORE_IN_REGISTERS __m256d high_pairs(__m256d a, __m256d b) {
    return _mm256_castps_pd(_mm256_unpackhi_ps(_mm256_castpd_ps(a), _mm256_castpd_ps(b)));
}
CORE_IN_REGISTERS __m512d to_doubles(__m256d floats) {
    return _mm512_cvtps_pd(_mm256_castpd_ps(floats));
}

/* Three doubles, and not a byte beyond them. */
CORE_IN_REGISTERS __m256d read_doubles(const core_mesh *mesh, const unsigned char *corner) {
    uint32_t at;
    memcpy(&at, corner, sizeof at);
    return _mm256_maskz_loadu_pd(
        7, (const unsigned char *)mesh->positions.data + at * mesh->positions.stride);
}

/* Corner k of triangles i and i + 4, and of i + 1 and i + 5. */
CORE_IN_REGISTERS void two_rows(const core_mesh *mesh, const unsigned char *corners, int i, int k,
    __m512d *first, __m512d *second) {
    *first =
        _mm512_insertf64x4(_mm512_castpd256_pd512(read_doubles(mesh, corners + 4 * (3 * i + k))),
            read_doubles(mesh, corners + 4 * (3 * i + 12 + k)), 1);
    *second = _mm512_insertf64x4(
        _mm512_castpd256_pd512(read_doubles(mesh, corners + 4 * (3 * i + 3 + k))),
        read_doubles(mesh, corners + 4 * (3 * i + 15 + k)), 1);
}

/* read_corner of doubles. */
CORE_IN_REGISTERS void read_corner_doubles(
    const core_mesh *mesh, const unsigned char *corners, int k, __m512d axis[3]) {
    const __m512i low = _mm512_set_epi64(13, 12, 5, 4, 9, 8, 1, 0),
                  high = _mm512_set_epi64(15, 14, 7, 6, 11, 10, 3, 2);
    const __m512d scale = _mm512_set1_pd(mesh->scale);
    __m512d a, b, c, d;
    two_rows(mesh, corners, 0, k, &a, &b);
    two_rows(mesh, corners, 2, k, &c, &d);
    const __m512d x01 = _mm512_unpacklo_pd(a, b), x23 = _mm512_unpacklo_pd(c, d),
                  y01 = _mm512_unpackhi_pd(a, b), y23 = _mm512_unpackhi_pd(c, d);
    axis[0] = _mm512_mul_pd(_mm512_permutex2var_pd(x01, low, x23), scale);
    axis[1] = _mm512_mul_pd(_mm512_permutex2var_pd(y01, low, y23), scale);
    axis[2] = _mm512_mul_pd(_mm512_permutex2var_pd(x01, high, x23), scale);
}

/* Corner k of eight triangles, axis by axis. */
CORE_IN_REGISTERS void read_corner(
    const core_mesh *mesh, const unsigned char *corners, int k, __m512d axis[3]) {
    __m256d r[4];
    for (int i = 0; i < 4; i++) r[i] = two_points(mesh, corners, i, k);
    const __m256d xy01 = low_pairs(r[0], r[1]), xy23 = low_pairs(r[2], r[3]),
                  z01 = high_pairs(r[0], r[1]), z23 = high_pairs(r[2], r[3]);
    axis[0] = to_doubles(_mm256_unpacklo_pd(xy01, xy23));
    axis[1] = to_doubles(_mm256_unpackhi_pd(xy01, xy23));
    axis[2] = to_doubles(_mm256_unpacklo_pd(z01, z23));
}

CORE_IN_REGISTERS void open_faces(
    const core_mesh *mesh, size_t f, int doubles, core_opened_eight *o) {
    __m512d p[3][3];
    for (int k = 0; k < 3; k++)
        if (doubles)
            read_corner_doubles(mesh, corners_of(mesh, f), k, p[k]);
        else
            read_corner(mesh, corners_of(mesh, f), k, p[k]);
    core_open_eight(p, o);
}

/* ---- adding */

CORE_IN_REGISTERS void keep_welded(const core_mesh *mesh, size_t f, kept_eight *kept) {
    const unsigned char *corners = corners_of(mesh, f);
    for (size_t c = 0; c < 3 * CORE_LANES; c++) {
        uint32_t at;
        memcpy(&at, corners + c * sizeof at, sizeof at);
        kept->welded[c] = mesh->weld[at];
    }
}

CORE_IN_REGISTERS void add_kept(
    const core_adder *adder, const kept_eight *kept, size_t f, norma_weight weight) {
    const core_eight eight = {(const double(*)[4])kept->row,
        (const double(*)[CORE_LANES])kept->weight,
        adder->mesh->weld ? (const unsigned char *)kept->welded : corners_of(adder->mesh, f),
        kept->sure};
    core_add_eight(adder, &eight, f, CORE_LANES, weight);
}

/* ---- each weight */

CORE_IN_REGISTERS void keep_angles(
    const core_opened_eight *o, const core_sloped_eight *s, kept_eight *kept) {
    __m512d weight[3];
    core_weigh_eight(s, weight);
    core_store_eight_rows(o->normal, _mm512_set1_pd(1), kept->row);
    for (int k = 0; k < 3; k++) _mm512_storeu_pd(kept->weight[k], weight[k]);
}

/* Where all corners weigh the same. */
CORE_IN_REGISTERS void keep_even(
    const core_opened_eight *o, __m512d inverse, norma_weight weight, kept_eight *kept) {
    const int by_area = weight == NORMA_WEIGHT_AREA;
    __m512d row[3];
    for (int x = 0; x < 3; x++) {
        const __m512d unit = _mm512_mul_pd(o->normal[x], inverse);
        row[x] = by_area ? _mm512_mul_pd(unit, o->length) : unit;
    }
    core_store_eight_rows(row, by_area ? o->length : _mm512_set1_pd(1), kept->row);
}

/* The next eight are read and multiplied and the last eight added while this one's divisions are
 * under way: what waits for them would otherwise keep the processor from seeing that far ahead. */
CORE_IN_REGISTERS size_t add_weighted(
    const core_adder *adder, size_t begin, size_t end, int doubles, norma_weight weight) {
    const core_mesh *mesh = adder->mesh;
    const size_t eights = (end - begin) / CORE_LANES;
    const int evenly = core_weighs_evenly(weight);
    kept_eight kept[2];
    core_opened_eight next;
    if (eights) open_faces(mesh, begin, doubles, &next);
    for (size_t i = 0; i < eights; i++) {
        const size_t f = begin + i * CORE_LANES;
        kept_eight *this = &kept[i % 2], *last = &kept[(i + 1) % 2];
        core_opened_eight o = next;
        core_sloped_eight s;
        __m512d inverse;
        if (evenly)
            inverse = _mm512_div_pd(_mm512_set1_pd(1), o.length);
        else
            core_slope_eight(&o, &s);
        open_faces(mesh, i + 1 < eights ? f + CORE_LANES : f, doubles, &next);
        if (i > 0) add_kept(adder, last, f - CORE_LANES, weight);
        if (evenly)
            keep_even(&o, inverse, weight, this);
        else
            keep_angles(&o, &s, this);
        if (mesh->weld) keep_welded(mesh, f, this);
        this->sure = o.sure;
    }
    if (eights) add_kept(adder, &kept[(eights - 1) % 2], begin + (eights - 1) * CORE_LANES, weight);
    return begin + eights * CORE_LANES;
}

CORE_IN_REGISTERS size_t add_by_weight(
    const core_adder *adder, size_t begin, size_t end, int doubles) {
    switch (adder->weight) {
    case NORMA_WEIGHT_ANGLE:
        return add_weighted(adder, begin, end, doubles, NORMA_WEIGHT_ANGLE);
    case NORMA_WEIGHT_AREA:
        return add_weighted(adder, begin, end, doubles, NORMA_WEIGHT_AREA);
    case NORMA_WEIGHT_UNIFORM:
        return add_weighted(adder, begin, end, doubles, NORMA_WEIGHT_UNIFORM);
    default:
        return begin;
    }
}

/* Functions of their own: in one with the other, each would be a tenth slower for want of
 * registers.
 */
CORE_FOR_AVX512 static __attribute__((noinline)) size_t add_floats(
    const core_adder *adder, size_t begin, size_t end) {
    return add_by_weight(adder, begin, end, 0);
}

CORE_FOR_AVX512 static __attribute__((noinline)) size_t add_doubles(
    const core_adder *adder, size_t begin, size_t end) {
    return add_by_weight(adder, begin, end, 1);
}

CORE_FOR_AVX512 size_t norma_core_add_eights_avx512(
    const core_adder *adder, size_t begin, size_t end) {
    const core_mesh *mesh = adder->mesh;
    if (adder->scattered)
        return begin; /* waits for memory, for which it is better to ask for much at once: 46 to 63
                         ns here, 43 there */
    if (mesh->corner_size != sizeof(uint32_t)) return begin;
    if (mesh->positions.format == NORMA_FORMAT_FLOAT) return add_floats(adder, begin, end);
    if (mesh->positions.format == NORMA_FORMAT_DOUBLE) return add_doubles(adder, begin, end);
    return begin;
}
#endif
