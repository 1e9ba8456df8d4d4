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
complain(call *c, const char *format, ...) {
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
        complain(c, "report.%s is {%zu, %zu}, expected {%zu, %zu}", what, got.count, got.first,
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
static int nearly_cancelled(const oracle_normal *e, norma_weight weight) {
    if (e->reason != NORMA_REASON_NONE && e->reason != NORMA_REASON_CANCELLED) return 0;
    if (e->doubtful) return 1;
    if (weight == NORMA_WEIGHT_VISIBLE) return fabsl(e->ratio) < 1e-6L;
    return fabsl(e->ratio - 0x1p-20L) < 2e-7L;
}

static void check_normal(call *c, tally *t, const char *element, size_t index,
    const oracle_normal *e, const norma_options *options, norma_weight weight, long double limit,
    const float *got, unsigned reason) {
    static const float zero[3] = {0, 0, 0};
    const float *fallback =
        options->fallback == NORMA_FALLBACK_GIVEN ? options->fallback_normal : zero;
    ++c->total->elements;
    tally_reason(t, e->reason, index);
    if (nearly_cancelled(e, weight)) {
        t->doubtful = 1;
        ++c->total->doubtful;
        return;
    }
    if (reason != (unsigned)e->reason) {
        complain(c, "%s %zu has reason %u, expected %u (ratio %Lg)", element, index, reason,
            (unsigned)e->reason, e->ratio);
        return;
    }
    if (reason) {
        if (options->fallback != NORMA_FALLBACK_NEAREST && memcmp(got, fallback, sizeof zero))
            complain(c, "%s %zu does not hold the fallback", element, index);
        return;
    }
    const long double n[3] = {(long double)got[0], (long double)got[1], (long double)got[2]};
    const long double length = sqrtl(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]),
                      angle = oracle_angle(n, e->normal);
    if (!(fabsl(length - 1) < 3e-7L)) complain(c, "%s %zu is %Lg long", element, index, length);
    if (e->ratio <= 1e-3L) {
        ++c->total->doubtful;
        return;
    }
    if (!(angle <= c->total->worst)) c->total->worst = angle;
    if (!(angle <= limit))
        complain(c, "%s %zu is (%.9g %.9g %.9g), %Lg rad off (%.9Lg %.9Lg %.9Lg), ratio %Lg",
            element, index, (double)got[0], (double)got[1], (double)got[2], angle, e->normal[0],
            e->normal[1], e->normal[2], e->ratio);
}

typedef struct outputs {
    float *normals;
    uint8_t *reasons;
    norma_options options;
    norma_report report;
} outputs;

static void outputs_create(outputs *out, const norma_options *options, size_t count) {
    memset(out, 0, sizeof *out);
    out->normals = oracle_allocate(count, 3 * sizeof *out->normals);
    out->reasons = oracle_allocate(count, 1);
    if (options) out->options = *options;
    out->options.normal_stride = 0;
    out->options.reasons = out->reasons;
    memset(out->normals, 0x7f, 3 * count * sizeof *out->normals);
    memset(out->reasons, 0x7f, count);
}

static void outputs_destroy(outputs *out) {
    free(out->normals);
    free(out->reasons);
}

void compare_faces(comparison *total, const char *name, const oracle *o, const norma_mesh *mesh,
    const norma_options *options) {
    call c = {.total = total, .name = name, .what = "faces"};
    tally t = {0};
    outputs out;
    outputs_create(&out, options, o->face_count);
    const norma_result result =
        norma_face_normals(mesh, &out.options, out.normals, o->face_count, &out.report);
    if (result) complain(&c, "%s", norma_result_text(result));
    for (size_t f = 0; f < o->face_count && !result; ++f) {
        const oracle_normal e = oracle_face(o, f);
        check_normal(&c, &t, "face", f, &e, &out.options, NORMA_WEIGHT_UNIFORM, COMPARE_FACE_RAD,
            out.normals + 3 * f, out.reasons[f]);
    }
    if (!result) check_report(&c, o, &out.report, &t);
    outputs_destroy(&out);
}

void compare_vertices(comparison *total, const char *name, const oracle *o, const norma_mesh *mesh,
    const norma_options *options, size_t every) {
    call c = {.total = total, .name = name};
    tally t = {0};
    outputs out;
    const norma_weight weight = options ? options->weight : NORMA_WEIGHT_ANGLE;
    snprintf(c.what, sizeof c.what, "vertices, %s", norma_weight_name(weight));
    outputs_create(&out, options, o->position_count);
    const norma_result result =
        norma_vertex_normals(mesh, &out.options, out.normals, o->position_count, &out.report);
    if (result) complain(&c, "%s", norma_result_text(result));
    for (size_t v = 0; v < o->position_count && !result; v += every) {
        const oracle_normal e = oracle_vertex(o, v, weight);
        check_normal(&c, &t, "vertex", v, &e, &out.options, weight, COMPARE_SUM_RAD,
            out.normals + 3 * v, out.reasons[v]);
        if (e.own_index && e.reason == NORMA_REASON_CANCELLED) continue;
        if (e.own_index) { /* the sum over all must itself be cancelled beyond doubt for this to be
                              the answer */
            oracle_normal whole = oracle_sum(o, o->by_shared + o->by_shared_start[o->shared[v]],
                o->by_shared_start[o->shared[v] + 1] - o->by_shared_start[o->shared[v]], weight);
            if (nearly_cancelled(&whole, weight)) t.doubtful = 1;
        }
    }
    if (!result && every == 1) check_report(&c, o, &out.report, &t);
    outputs_destroy(&out);
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
        complain(c, "edges are %zu, open %zu, smooth %zu, hard %zu; expected %zu, %zu, %zu, %zu",
            edges->count, edges->open, edges->smooth, edges->hard, e->count, e->open, e->smooth,
            e->hard);
}

/* All corners of a fan hold the same bits (where it has a normal); that those of other fans differ
 * follows from each being near its own sum. */
static void check_fans(call *c, const oracle *o, const oracle_fans *fans, const outputs *out) {
    size_t *first = oracle_allocate(fans->fan_count, sizeof *first);
    for (size_t i = 0; i < o->corner_count; ++i) {
        const size_t fan = fans->fan[i];
        if (out->reasons[i] || fans->doubtful[fan]) continue;
        if (!first[fan])
            first[fan] = i + 1;
        else if (memcmp(out->normals + 3 * i, out->normals + 3 * (first[fan] - 1), 12))
            complain(c, "corners %zu and %zu of one fan differ", first[fan] - 1, i);
    }
    free(first);
}

void compare_corners(comparison *total, const char *name, const oracle *o, const norma_mesh *mesh,
    float crease_rad, const norma_options *options) {
    call c = {.total = total, .name = name};
    tally t = {0};
    outputs out;
    oracle_fans fans;
    norma_edges edges = {0};
    int doubtful = 0;
    const norma_weight weight = options ? options->weight : NORMA_WEIGHT_ANGLE;
    snprintf(c.what, sizeof c.what, "corners, %s, crease %g%s", norma_weight_name(weight),
        (double)crease_rad, options && options->non_manifold ? ", non-manifold smooth" : "");
    outputs_create(&out, options, o->corner_count);
    out.options.struct_size = sizeof out.options;
    out.options.edges = &edges;
    const norma_result result = norma_corner_normals(
        mesh, crease_rad, &out.options, out.normals, o->corner_count, &out.report);
    if (result) complain(&c, "%s", norma_result_text(result));
    oracle_fans_create(&fans, o, crease_rad, out.options.non_manifold, COMPARE_DOUBT_RAD);
    oracle_normal *sums = oracle_allocate(fans.fan_count, sizeof *sums);
    for (size_t f = 0; f < fans.fan_count && !result; ++f)
        sums[f] =
            oracle_sum(o, fans.corners + fans.start[f], fans.start[f + 1] - fans.start[f], weight);
    for (size_t i = 0; i < o->corner_count && !result; ++i) {
        oracle_normal e = sums[fans.fan[i]];
        if (!oracle_finite(o->positions[o->corners[i]]))
            e = (oracle_normal){.reason = NORMA_REASON_NON_FINITE};
        if (fans.doubtful[fans.fan[i]] && e.reason != NORMA_REASON_NON_FINITE) {
            doubtful = t.doubtful = 1;
            ++total->doubtful;
        } else {
            check_normal(&c, &t, "corner", i, &e, &out.options, weight, COMPARE_SUM_RAD,
                out.normals + 3 * i, out.reasons[i]);
        }
    }
    if (!result) {
        check_report(&c, o, &out.report, &t);
        check_fans(&c, o, &fans, &out);
        check_edges(&c, o, &fans, &out.report, &edges, doubtful);
    }
    free(sums);
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
