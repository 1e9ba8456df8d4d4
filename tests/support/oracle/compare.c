/* compare.c: see compare.h. */
#include "oracle/compare.h"
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MESSAGES_PER_CALL 3

typedef struct call {
    comparison *total;
    const char *name;
    char what[80];
    size_t wrong;
} call;

#if defined(__GNUC__)
__attribute__((format(printf, 2, 3)))
#endif
static void
differ(call *c, const char *format, ...) {
    ++c->total->wrong;
    if (++c->wrong > MESSAGES_PER_CALL) return;
    va_list arguments;
    va_start(arguments, format);
    printf("# %s: %s: ", c->name, c->what);
    vprintf(format, arguments);
    printf("\n");
    va_end(arguments);
}

typedef struct tally { /* the oracle's report, element by element */
    norma_count non_finite, unreferenced, cancelled, degenerate;
    int doubtful;
} tally;

static void tally_reason(tally *t, enum norma_reason reason, size_t element) {
    norma_count *count = reason == NORMA_REASON_NON_FINITE     ? &t->non_finite
                         : reason == NORMA_REASON_UNREFERENCED ? &t->unreferenced
                         : reason == NORMA_REASON_CANCELLED    ? &t->cancelled
                                                               : NULL;
    if (!count) return;
    if (count->count++ == 0) count->first = element;
}

static void check_count(call *c, const char *what, norma_count got, norma_count expected) {
    if (expected.count == 0) expected.first = SIZE_MAX;
    if (got.count != expected.count || got.first != expected.first)
        differ(c, "report.%s is {%zu, %zu}, expected {%zu, %zu}", what, got.count, got.first,
            expected.count, expected.first);
}

static void check_report(call *c, const oracle *o, const norma_report *report, const tally *t) {
    norma_count degenerate = {0, SIZE_MAX};
    for (size_t f = 0; f < o->face_count; ++f)
        if ((o->kinds[f] == ORACLE_FEW || o->kinds[f] == ORACLE_NO_AREA) && degenerate.count++ == 0)
            degenerate.first = f;
    check_count(c, "degenerate_faces", report->degenerate_faces, degenerate);
    check_count(c, "non_finite", report->non_finite, t->non_finite);
    if (t->doubtful) return;
    check_count(c, "unreferenced", report->unreferenced, t->unreferenced);
    check_count(c, "cancelled", report->cancelled, t->cancelled);
}

/* The library may err by 1e-7 rad in each direction: what is cancelled is in doubt that near to the
 * limit. */
static int in_doubt(const oracle_normal *e, norma_weight weight) {
    if (e->doubtful) return 1;
    if (e->reason != NORMA_REASON_NONE && e->reason != NORMA_REASON_CANCELLED) return 0;
    if (weight == NORMA_WEIGHT_VISIBLE) return fabsl(e->ratio) < 1e-6L;
    return fabsl(e->ratio - 0x1p-20L) < 2e-7L;
}

static void check_fallback(call *c, const norma_options *options, size_t index, const float *got) {
    for (int k = 0; k < 3 && options->fallback != NORMA_FALLBACK_NEAREST; ++k) {
        const float there =
            options->fallback == NORMA_FALLBACK_GIVEN ? options->fallback_normal[k] : 0;
        if (got[k] == there && !(got[k] == 0 && signbit(got[k]))) continue;
        differ(c, "element %zu does not hold the fallback", index);
        return;
    }
}

static void check_normal(call *c, tally *t, size_t index, const oracle_normal *e,
    const norma_options *options, long double limit, const answer *a) {
    const float *got = a->normals + 3 * index;
    const unsigned reason = a->reasons[index];
    const long double n[3] = {(long double)got[0], (long double)got[1], (long double)got[2]};
    const long double length = sqrtl(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    ++c->total->elements;
    tally_reason(t, e->reason, index);
    if (!(reason || fabsl(length - 1) < 3e-7L)) differ(c, "element %zu is %Lg long", index, length);
    if (reason) check_fallback(c, options, index, got);
    if (in_doubt(e, options->weight)) {
        t->doubtful = 1;
        ++c->total->doubtful;
        return;
    }
    if (reason != (unsigned)e->reason)
        differ(c, "element %zu has reason %u, expected %u (ratio %Lg)", index, reason,
            (unsigned)e->reason, e->ratio);
    if (reason || e->reason) return;
    const long double angle = oracle_angle(n, e->normal);
    if (e->ratio <= 1e-3L) { /* what each direction may err, as the sum makes more of it */
        ++c->total->doubtful;
        limit = COMPARE_FACE_RAD * (1 + 1 / e->ratio);
    } else if (!(angle <= c->total->worst))
        c->total->worst = angle;
    if (!(angle <= limit))
        differ(c, "element %zu is (%.9g %.9g %.9g), %Lg rad off (%.9Lg %.9Lg %.9Lg), ratio %Lg",
            index, (double)got[0], (double)got[1], (double)got[2], angle, e->normal[0],
            e->normal[1], e->normal[2], e->ratio);
}

/* An element without a normal holds the bits of the nearest that has one. */
static void check_nearest(call *c, const oracle *o, const norma_options *options, const answer *a,
    const size_t *vertices, size_t count) {
    static const float zero[3] = {0, 0, 0};
    for (size_t i = 0; i < count && options->fallback == NORMA_FALLBACK_NEAREST; ++i) {
        if (!a->reasons[i] || vertices[i] == ORACLE_NONE) continue;
        const size_t from = oracle_nearest(o, vertices, a->reasons, count, i);
        const float *expected = from == ORACLE_NONE ? zero : a->normals + 3 * from;
        if (memcmp(a->normals + 3 * i, expected, 12))
            differ(c, "element %zu does not hold the normal of the nearest, %zu", i, from);
    }
}

static void judge_all(call *c, const oracle *o, const norma_options *options, const answer *a,
    const oracle_normal *expected, const size_t *vertices, size_t count, long double limit) {
    tally t = {0};
    for (size_t i = 0; i < count; ++i) check_normal(c, &t, i, &expected[i], options, limit, a);
    check_nearest(c, o, options, a, vertices, count);
    check_report(c, o, a->report, &t);
}

void judge_faces(comparison *total, const char *name, const oracle *o, const norma_options *options,
    const answer *a) {
    call c = {.total = total, .name = name, .what = "faces"};
    oracle_normal *expected = oracle_allocate(o->face_count, sizeof *expected);
    size_t *first = oracle_allocate(o->face_count, sizeof *first);
    for (size_t f = 0; f < o->face_count; ++f) {
        expected[f] = oracle_face(o, f);
        first[f] = o->starts[f] < o->starts[f + 1] ? o->corners[o->starts[f]] : ORACLE_NONE;
    }
    judge_all(&c, o, options, a, expected, first, o->face_count, COMPARE_FACE_RAD);
    free(expected);
    free(first);
}

/* Of a sum that cancels, that over the vertex's own corners, which must then be cancelled beyond
 * doubt for this to be the answer. */
static oracle_normal sum_of_vertex(
    const oracle *o, size_t vertex, const size_t *corners, size_t count, norma_weight weight) {
    oracle_normal e = oracle_sum(o, corners, count, weight);
    if (!oracle_finite(o->positions[vertex]))
        return (oracle_normal){.reason = NORMA_REASON_NON_FINITE};
    if (e.reason != NORMA_REASON_CANCELLED) return e;
    const int doubtful = in_doubt(&e, weight);
    e = oracle_own_sum(o, vertex, corners, count, weight);
    e.doubtful |= doubtful;
    return e;
}

void judge_vertices(comparison *total, const char *name, const oracle *o,
    const norma_options *options, const answer *a, size_t every) {
    call c = {.total = total, .name = name};
    tally t = {0};
    oracle_normal *expected = oracle_allocate(o->position_count, sizeof *expected);
    size_t *vertices = oracle_allocate(o->position_count, sizeof *vertices);
    snprintf(c.what, sizeof c.what, "vertices, %s", norma_weight_name(options->weight));
    for (size_t v = 0; v < o->position_count; v += every) {
        const size_t *start = o->by_shared_start + o->shared[v];
        expected[v] =
            sum_of_vertex(o, v, o->by_shared + start[0], start[1] - start[0], options->weight);
        vertices[v] = v;
        if (every > 1) check_normal(&c, &t, v, &expected[v], options, COMPARE_SUM_RAD, a);
    }
    if (every == 1)
        judge_all(&c, o, options, a, expected, vertices, o->position_count, COMPARE_SUM_RAD);
    free(expected);
    free(vertices);
}

void judge_fans_of_vertices(comparison *total, const char *name, const oracle *o,
    const oracle_fans *fans, const norma_options *options, const answer *a) {
    call c = {.total = total, .name = name, .what = "plan of vertices"};
    oracle_normal *expected = oracle_allocate(o->position_count, sizeof *expected);
    size_t *vertices = oracle_allocate(o->position_count, sizeof *vertices),
           *corners = oracle_allocate(o->corner_count, sizeof *corners);
    for (size_t v = 0; v < o->position_count; ++v) {
        int doubtful;
        const size_t count = oracle_fans_of(o, fans, v, corners, &doubtful);
        expected[v] = sum_of_vertex(o, v, corners, count, options->weight);
        expected[v].doubtful |= doubtful && expected[v].reason != NORMA_REASON_NON_FINITE;
        vertices[v] = v;
    }
    judge_all(&c, o, options, a, expected, vertices, o->position_count, COMPARE_SUM_RAD);
    free(expected);
    free(vertices);
    free(corners);
}

static void check_edges(call *c, const oracle *o, const oracle_fans *fans,
    const norma_report *report, const norma_edges *edges, int doubtful) {
    int finite = 1;
    for (size_t i = 0; i < o->corner_count; ++i)
        finite &= oracle_finite(o->positions[o->corners[i]]);
    if (!finite) return; /* whether two infinite positions are one is left open */
    check_count(c, "non_manifold_edges", report->non_manifold_edges, fans->non_manifold);
    check_count(c, "winding_conflicts", report->winding_conflicts, fans->conflicts);
    const norma_edges *e = &fans->edges;
    if (edges->count != e->count || edges->open != e->open ||
        edges->smooth + edges->hard != e->smooth + e->hard || (!doubtful && edges->hard != e->hard))
        differ(c, "edges are %zu, open %zu, smooth %zu, hard %zu; expected %zu, %zu, %zu, %zu",
            edges->count, edges->open, edges->smooth, edges->hard, e->count, e->open, e->smooth,
            e->hard);
}

/* All corners of a fan hold the same bits (where it has a normal); that those of other fans differ
 * follows from each being near its own sum. */
static void check_fans(call *c, const oracle *o, const oracle_fans *fans, const answer *a) {
    size_t *first = oracle_allocate(fans->fan_count, sizeof *first);
    for (size_t i = 0; i < o->corner_count; ++i) {
        const size_t fan = fans->fan[i];
        if (a->reasons[i] || fans->doubtful[fan]) continue;
        if (!first[fan])
            first[fan] = i + 1;
        else if (memcmp(a->normals + 3 * i, a->normals + 3 * (first[fan] - 1), 12))
            differ(c, "corners %zu and %zu of one fan differ", first[fan] - 1, i);
    }
    free(first);
}

void judge_corners(comparison *total, const char *name, const oracle *o, const oracle_fans *fans,
    const norma_options *options, const answer *a) {
    call c = {.total = total, .name = name};
    int doubtful = 0;
    snprintf(c.what, sizeof c.what, "corners, %s, crease %g%s", norma_weight_name(options->weight),
        (double)fans->crease_rad, options->non_manifold ? ", non-manifold smooth" : "");
    oracle_normal *sums = oracle_allocate(fans->fan_count, sizeof *sums),
                  *expected = oracle_allocate(o->corner_count, sizeof *expected);
    for (size_t f = 0; f < fans->fan_count; ++f) {
        const size_t *start = fans->start + f;
        sums[f] = oracle_sum(o, fans->corners + start[0], start[1] - start[0], options->weight);
        sums[f].doubtful |= fans->doubtful[f];
    }
    for (size_t i = 0; i < o->corner_count; ++i) {
        expected[i] = oracle_finite(o->positions[o->corners[i]])
                          ? sums[fans->fan[i]]
                          : (oracle_normal){.reason = NORMA_REASON_NON_FINITE};
        doubtful |= expected[i].doubtful;
    }
    judge_all(&c, o, options, a, expected, o->corners, o->corner_count, COMPARE_SUM_RAD);
    check_fans(&c, o, fans, a);
    if (a->edges) check_edges(&c, o, fans, a->report, a->edges, doubtful);
    free(sums);
    free(expected);
}

/* ---- one call, judged */

typedef struct outputs {
    float *normals;
    uint8_t *reasons;
    norma_options options;
    norma_report report;
    norma_edges edges;
    answer answer;
} outputs;

static void outputs_create(outputs *out, const norma_options *options, size_t count) {
    memset(out, 0, sizeof *out);
    out->normals = oracle_allocate(count, 3 * sizeof *out->normals);
    out->reasons = oracle_allocate(count, 1);
    if (options) out->options = *options;
    out->options.struct_size = sizeof out->options;
    out->options.normal_stride = 0;
    out->options.reasons = out->reasons;
    out->options.edges = &out->edges;
    out->answer = (answer){out->normals, out->reasons, &out->report, &out->edges};
    memset(out->normals, 0x7f, 3 * count * sizeof *out->normals);
    memset(out->reasons, 0x7f, count);
}

static void outputs_destroy(outputs *out) {
    free(out->normals);
    free(out->reasons);
}

static int refused(comparison *total, const char *name, norma_result result) {
    if (!result) return 0;
    printf("# %s: %s\n", name, norma_result_text(result));
    ++total->wrong;
    return 1;
}

void compare_faces(comparison *total, const char *name, const oracle *o, const norma_mesh *mesh,
    const norma_options *options) {
    outputs out;
    outputs_create(&out, options, o->face_count);
    if (!refused(total, name,
            norma_face_normals(mesh, &out.options, out.normals, o->face_count, &out.report)))
        judge_faces(total, name, o, &out.options, &out.answer);
    outputs_destroy(&out);
}

void compare_vertices(comparison *total, const char *name, const oracle *o, const norma_mesh *mesh,
    const norma_options *options, size_t every) {
    outputs out;
    outputs_create(&out, options, o->position_count);
    if (!refused(total, name,
            norma_vertex_normals(mesh, &out.options, out.normals, o->position_count, &out.report)))
        judge_vertices(total, name, o, &out.options, &out.answer, every);
    outputs_destroy(&out);
}

void compare_corners(comparison *total, const char *name, const oracle *o, const norma_mesh *mesh,
    float crease_rad, const norma_options *options) {
    outputs out;
    oracle_fans fans;
    outputs_create(&out, options, o->corner_count);
    oracle_fans_create(&fans, o, crease_rad, out.options.non_manifold, COMPARE_DOUBT_RAD);
    if (!refused(total, name,
            norma_corner_normals(
                mesh, crease_rad, &out.options, out.normals, o->corner_count, &out.report)))
        judge_corners(total, name, o, &fans, &out.options, &out.answer);
    oracle_fans_destroy(&fans);
    outputs_destroy(&out);
}

size_t compare_everything(
    const char *name, const norma_mesh *mesh, norma_weld weld, double distance) {
    static const float creases[] = {0, 0.523598776f, 1.04719755f, 3.14159274f};
    comparison total = {0};
    norma_options options = {.weld = weld, .weld_distance = distance};
    oracle o;
    oracle_create(&o, mesh, weld, distance);
    compare_faces(&total, name, &o, mesh, &options);
    for (int w = NORMA_WEIGHT_ANGLE; norma_weight_name((norma_weight)w); ++w) {
        options.weight = (norma_weight)w;
        compare_vertices(&total, name, &o, mesh, &options, 1);
        for (int i = 0; i < 8; ++i) {
            options.non_manifold = i & 1 ? NORMA_NON_MANIFOLD_SMOOTH : NORMA_NON_MANIFOLD_HARD;
            compare_corners(&total, name, &o, mesh, creases[i / 2], &options);
        }
    }
    oracle_destroy(&o);
    return total.wrong;
}
