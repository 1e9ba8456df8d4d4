/* oracle_sums.c: the weights of a corner and the weighted sums, straight from DESIGN.md's words.
 * See oracle.h.
 *
 * Edge vectors, their products and the sign that tells a reflex corner are exact; what is rounded
 * after that are square roots and arc tangents, to 64 bits. */
#include "oracle/exact.h"
#include "oracle/oracle.h"
#include <math.h>
#include <stdlib.h>

#define MOST_VISIBLE 48 /* distinct normals that are tried in triples */

static const long double PI_LONG = 3.14159265358979323846264338327950288L;

/* a to the next corner, b to the previous one. */
static oracle_corner_measures measure_corner(const oracle *o, size_t corner) {
    const double *p[3] = {o->positions[o->corners[corner]],
        o->positions[o->corners[o->next[corner]]], o->positions[o->corners[o->previous[corner]]]};
    const double numbers[9] = {
        p[0][0], p[0][1], p[0][2], p[1][0], p[1][1], p[1][2], p[2][0], p[2][1], p[2][2]};
    const int exponent = exact_exponent(numbers, 9);
    exact_vec3 here, a, b, cross, dots;
    long double normal[3];
    oracle_corner_measures m = {.known = 1};
    exact_init(&here);
    exact_init(&a);
    exact_init(&b);
    exact_init(&cross);
    exact_init(&dots);
    exact_set(&here, p[0], exponent);
    exact_set(&a, p[1], exponent);
    exact_set(&b, p[2], exponent);
    exact_sub(&a, &a, &here);
    exact_sub(&b, &b, &here);
    exact_cross(&cross, &a, &b);
    exact_dot(dots.x[0], &a, &b);
    exact_dot(dots.x[1], &a, &a);
    exact_dot(dots.x[2], &b, &b);
    exact_round_vec3(normal, &cross, 2 * exponent);
    m.sine_lengths = sqrtl(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
    m.angle = atan2l(m.sine_lengths, exact_round(dots.x[0], 2 * exponent));
    m.a_squared = exact_round(dots.x[1], 2 * exponent);
    m.b_squared = exact_round(dots.x[2], 2 * exponent);
    const long double *n = o->directions[o->faces[corner]];
    const long double along = normal[0] * n[0] + normal[1] * n[1] + normal[2] * n[2];
    if (fabsl(along) > 1e-12L * m.sine_lengths ? along < 0 : oracle_turns_back(o, corner))
        m.angle = 2 * PI_LONG - m.angle;
    exact_clear(&here);
    exact_clear(&a);
    exact_clear(&b);
    exact_clear(&cross);
    exact_clear(&dots);
    return m;
}

long double oracle_weight(const oracle *o, size_t corner, norma_weight weight) {
    const long double area = o->areas[o->faces[corner]];
    if (weight == NORMA_WEIGHT_AREA) return area;
    if (weight == NORMA_WEIGHT_UNIFORM) return 1;
    oracle_corner_measures *known = &o->measures[corner];
    if (!known->known) *known = measure_corner(o, corner); /* sums are taken again and again */
    const oracle_corner_measures m = *known;
    switch (weight) {
    case NORMA_WEIGHT_ANGLE:
        return m.angle;
    case NORMA_WEIGHT_MAX:
        return m.sine_lengths > 0 ? m.sine_lengths / (m.a_squared * m.b_squared)
                                  : 0; /* 0 also beside an edge of no length */
    case NORMA_WEIGHT_ANGLE_AREA:
        return m.angle * area;
    case NORMA_WEIGHT_ANGLE_LENGTHS:
        return m.angle * sqrtl(m.a_squared) * sqrtl(m.b_squared);
    default:
        abort();
    }
}

static long double dot(const long double a[3], const long double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static int normalise(long double v[3]) {
    const long double length = sqrtl(dot(v, v));
    if (length == 0) return 0;
    for (int i = 0; i < 3; ++i) v[i] /= length;
    return 1;
}

/* ---- most visible: the centre whose worst normal is nearest, tried over all pairs and triples, as
 * the smallest cap touches one, two or three of them */

typedef struct visible {
    const long double (*normals)[3];
    size_t count;
    long double best[3], cosine;
} visible;

static void try_centre(visible *v, long double centre[3]) {
    if (!normalise(centre)) return;
    long double worst = 1;
    for (size_t i = 0; i < v->count; ++i) worst = fminl(worst, dot(centre, v->normals[i]));
    if (worst <= v->cosine) return;
    v->cosine = worst;
    for (int i = 0; i < 3; ++i) v->best[i] = centre[i];
}

static void try_triple(visible *v, size_t i, size_t j, size_t k) {
    long double a[3], b[3], centre[3];
    for (int x = 0; x < 3; ++x) {
        a[x] = v->normals[j][x] - v->normals[i][x];
        b[x] = v->normals[k][x] - v->normals[i][x];
    }
    for (int x = 0; x < 3; ++x)
        centre[x] = a[(x + 1) % 3] * b[(x + 2) % 3] - a[(x + 2) % 3] * b[(x + 1) % 3];
    const long double side = dot(centre, v->normals[i]) < 0 ? -1 : 1;
    for (int x = 0; x < 3; ++x) centre[x] *= side;
    try_centre(v, centre);
}

static void find_visible(visible *v) {
    v->cosine = -2;
    for (size_t i = 0; i < v->count; ++i) {
        long double centre[3] = {v->normals[i][0], v->normals[i][1], v->normals[i][2]};
        try_centre(v, centre);
        for (size_t j = 0; j < i; ++j) {
            for (int x = 0; x < 3; ++x) centre[x] = v->normals[i][x] + v->normals[j][x];
            try_centre(v, centre);
            for (size_t k = 0; k < j; ++k) try_triple(v, i, j, k);
        }
    }
}

static oracle_normal sum_visible(const oracle *o, const size_t *corners, size_t count) {
    oracle_normal result = {.reason = NORMA_REASON_UNREFERENCED};
    long double(*normals)[3] = oracle_allocate(count, sizeof *normals);
    visible v = {.normals = (const long double(*)[3])normals};
    for (size_t i = 0; i < count; ++i) {
        const long double *n = o->directions[o->faces[corners[i]]];
        size_t same = 0;
        if (o->kinds[o->faces[corners[i]]] != ORACLE_DIRECTED) continue;
        while (same < v.count &&
               (normals[same][0] != n[0] || normals[same][1] != n[1] || normals[same][2] != n[2]))
            ++same;
        if (same < v.count) continue;
        if (v.count == MOST_VISIBLE) result.doubtful = 1;
        if (v.count == MOST_VISIBLE) break;
        for (int x = 0; x < 3; ++x) normals[v.count][x] = n[x];
        ++v.count;
    }
    if (result.doubtful) result.reason = NORMA_REASON_NONE;
    if (v.count && !result.doubtful) {
        find_visible(&v);
        result.ratio = v.cosine;
        result.reason = v.cosine > 0 ? NORMA_REASON_NONE : NORMA_REASON_CANCELLED;
        for (int x = 0; x < 3; ++x) result.normal[x] = v.best[x];
    }
    free(normals);
    return result;
}

/* ---- sums */

oracle_normal oracle_sum(
    const oracle *o, const size_t *corners, size_t count, norma_weight weight) {
    if (weight == NORMA_WEIGHT_VISIBLE) return sum_visible(o, corners, count);
    oracle_normal result = {.reason = NORMA_REASON_UNREFERENCED};
    long double weights = 0;
    for (size_t i = 0; i < count; ++i) {
        const size_t face = o->faces[corners[i]];
        if (o->kinds[face] != ORACLE_DIRECTED) continue;
        const long double w = oracle_weight(o, corners[i], weight);
        result.reason = NORMA_REASON_NONE;
        weights += w;
        for (int x = 0; x < 3; ++x) result.normal[x] += w * o->directions[face][x];
    }
    if (result.reason == NORMA_REASON_UNREFERENCED) return result;
    const long double length = sqrtl(dot(result.normal, result.normal));
    result.ratio = weights > 0 ? length / weights : 0;
    if (result.ratio <= 0x1p-20L)
        result.reason = NORMA_REASON_CANCELLED;
    else
        normalise(result.normal);
    return result;
}

oracle_normal oracle_own_sum(
    const oracle *o, size_t vertex, const size_t *corners, size_t count, norma_weight weight) {
    size_t *own = oracle_allocate(count, sizeof *own), own_count = 0;
    for (size_t i = 0; i < count; ++i)
        if (o->corners[corners[i]] == vertex) own[own_count++] = corners[i];
    oracle_normal result = oracle_sum(o, own, own_count, weight);
    if (result.reason == NORMA_REASON_UNREFERENCED) result.reason = NORMA_REASON_CANCELLED;
    free(own);
    return result;
}

oracle_normal oracle_face(const oracle *o, size_t face) {
    oracle_normal result = {.reason = NORMA_REASON_NONE, .ratio = 1};
    for (int x = 0; x < 3; ++x) result.normal[x] = o->directions[face][x];
    if (o->kinds[face] == ORACLE_NON_FINITE || o->kinds[face] == ORACLE_NON_FINITE_FEW)
        result.reason = NORMA_REASON_NON_FINITE;
    else if (o->kinds[face] != ORACLE_DIRECTED)
        result.reason = NORMA_REASON_DEGENERATE;
    return result;
}

oracle_normal oracle_corner(
    const oracle *o, const oracle_fans *fans, size_t corner, norma_weight weight) {
    const size_t *start = fans->start + fans->fan[corner];
    if (!oracle_finite(o->positions[o->corners[corner]]))
        return (oracle_normal){.reason = NORMA_REASON_NON_FINITE};
    return oracle_sum(o, fans->corners + start[0], start[1] - start[0], weight);
}
