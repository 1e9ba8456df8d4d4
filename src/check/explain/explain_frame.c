/* explain_frame.c: what all normals of a surface have been turned by: reversed, mirrored or
 * rotated. For each weight and crease, the mirror and the rotations that bring stored normals
 * nearest to computed ones (Horn 1987: unit quaternions; the sum of angles rather than of their
 * squares, by weights that are found again and again, so that a minority that was not turned does
 * not matter). */
#include "check/explain/explain.h"
#include "core/call/table.h"
#include "core/face/face.h"
#include <stdlib.h>

static const double FRAME_NEAR_RAD = 0.017453292519943295; /* 1 degree */
enum { ROUNDS = 10, FEW_PAIRS = 128 };

typedef double matrix3[3][3];

typedef struct frame_pair {
    double stored[3], computed[3]; /* unit */
} frame_pair;

typedef struct frame_search {
    core_call *call;
    explain_surface *surface;
    frame_pair *pairs;
    double *angles;
    size_t count;
    int done;
    explain_frame *best;
} frame_search;

/* ---- eigenvectors of symmetric matrices (Jacobi 1846) */

typedef struct symmetric {
    int size;                      /* at most 4 */
    double a[4][4], vectors[4][4]; /* vectors: in columns */
} symmetric;

static void rotate(double *x, double *y, double c, double s) {
    const double a = *x, b = *y;
    *x = c * a - s * b;
    *y = s * a + c * b;
}

static void annihilate(symmetric *m, int p, int q) {
    if (fabs(m->a[p][q]) < 1e-300) return;
    const double theta = (m->a[q][q] - m->a[p][p]) / (2 * m->a[p][q]),
                 t = (theta < 0 ? -1 : 1) / (fabs(theta) + sqrt(theta * theta + 1)),
                 c = 1 / sqrt(t * t + 1), s = t * c;
    for (int k = 0; k < m->size; ++k) rotate(&m->a[k][p], &m->a[k][q], c, s);
    for (int k = 0; k < m->size; ++k) rotate(&m->a[p][k], &m->a[q][k], c, s);
    for (int k = 0; k < m->size; ++k) rotate(&m->vectors[k][p], &m->vectors[k][q], c, s);
}

static void diagonalise(symmetric *m) {
    enum { SWEEPS = 12 };
    for (int i = 0; i < m->size; ++i)
        for (int k = 0; k < m->size; ++k) m->vectors[i][k] = i == k;
    for (int sweep = 0; sweep < SWEEPS; ++sweep)
        for (int p = 0; p < m->size; ++p)
            for (int q = p + 1; q < m->size; ++q) annihilate(m, p, q);
}

static int extreme(const symmetric *m, double sign) {
    int best = 0;
    for (int i = 1; i < m->size; ++i)
        if (sign * m->a[i][i] > sign * m->a[best][best]) best = i;
    return best;
}

/* ---- fits; sums: of weight * stored * computed */

/* The matrix of a unit quaternion, times sign. */
static void matrix_of_turn(const double q[4], double sign, matrix3 out) {
    const matrix3 cross = {{0, -q[3], q[2]}, {q[3], 0, -q[1]}, {-q[2], q[1], 0}};
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k)
            out[i][k] = sign * ((i == k) * (2 * q[0] * q[0] - 1) + 2 * q[0] * cross[i][k] +
                                   2 * q[i + 1] * q[k + 1]);
}

/* Half a turn about the axis, reversed. */
static void fit_mirror(matrix3 sums, explain_frame *frame) {
    symmetric m = {.size = 3};
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) m.a[i][k] = sums[i][k] + sums[k][i];
    diagonalise(&m);
    const int least = extreme(&m, -1);
    frame->turn[0] = 0;
    for (int k = 0; k < 3; ++k) frame->turn[k + 1] = m.vectors[k][least];
}

/* All normals much the same, before and after: the smallest rotation does it. */
static int fit_single(const frame_search *s, double sign, explain_frame *frame) {
    double from[3] = {0}, to[3] = {0};
    for (size_t i = 0; i < s->count; ++i)
        for (int k = 0; k < 3; ++k) {
            from[k] += sign * s->pairs[i].stored[k];
            to[k] += s->pairs[i].computed[k];
        }
    const double alike = .9999 * (double)s->count;
    if (norma_core_length(from) < alike || norma_core_length(to) < alike) return 0;
    norma_core_cross(from, to, frame->turn + 1);
    frame->turn[0] = norma_core_length(from) * norma_core_length(to) + norma_core_dot(from, to);
    const double length =
        sqrt(frame->turn[0] * frame->turn[0] + norma_core_dot(frame->turn + 1, frame->turn + 1));
    for (int k = 0; k < 4; ++k) frame->turn[k] /= length > 0 ? length : 1;
    return length > 0;
}

static void fit_rotation(matrix3 sums, double sign, explain_frame *frame) {
    symmetric m = {.size = 4};
    const double trace = sums[0][0] + sums[1][1] + sums[2][2];
    m.a[0][0] = sign * trace;
    for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        m.a[0][i + 1] = m.a[i + 1][0] = sign * (sums[j][k] - sums[k][j]);
        for (int l = 0; l < 3; ++l)
            m.a[i + 1][l + 1] = sign * (sums[i][l] + sums[l][i] - (i == l) * trace);
    }
    diagonalise(&m);
    const int most = extreme(&m, 1);
    for (int k = 0; k < 4; ++k) frame->turn[k] = m.vectors[k][most];
}

/* The angle that is left at each pair. */
static void measure_pairs(frame_search *s, const explain_frame *frame) {
    matrix3 m;
    matrix_of_turn(frame->turn, frame->kind == EXPLAIN_FRAME_ROTATION ? 1 : -1, m);
    for (size_t i = 0; i < s->count; ++i) {
        double turned[3], cross[3];
        for (int k = 0; k < 3; ++k) turned[k] = norma_core_dot(m[k], s->pairs[i].stored);
        norma_core_cross(turned, s->pairs[i].computed, cross);
        s->angles[i] = norma_core_angle(
            norma_core_length(cross), norma_core_dot(turned, s->pairs[i].computed));
    }
}

static void fit(const frame_search *s, const double *angles, explain_frame *frame) {
    matrix3 sums = {{0}};
    const double sign = frame->kind == EXPLAIN_FRAME_BOTH ? -1 : 1;
    for (size_t i = 0; i < s->count; ++i) {
        const double weight = angles ? 1 / (angles[i] + 1e-4) : 1;
        for (int k = 0; k < 3; ++k)
            for (int l = 0; l < 3; ++l)
                sums[k][l] += weight * s->pairs[i].stored[k] * s->pairs[i].computed[l];
    }
    if (frame->kind == EXPLAIN_FRAME_MIRROR)
        fit_mirror(sums, frame);
    else if (!fit_single(s, sign, frame))
        fit_rotation(sums, sign, frame);
}

/* ---- one trial */

static int number_is_less(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double quantile_of(frame_search *s, double share) {
    qsort(s->angles, s->count, sizeof *s->angles, number_is_less);
    return s->angles[(size_t)((double)(s->count - 1) * share)];
}

static void fit_in_rounds(frame_search *s, explain_frame *frame) {
    if (frame->kind != EXPLAIN_FRAME_REVERSED) fit(s, NULL, frame);
    measure_pairs(s, frame);
    for (int i = 0; i < ROUNDS && frame->kind != EXPLAIN_FRAME_REVERSED; ++i) {
        fit(s, s->angles, frame);
        measure_pairs(s, frame);
    }
}

/* Of many pairs a few first: where less than three tenths of them are near, half of all are not. */
static int may_be_turned(const frame_search *s, explain_frame frame) {
    frame_pair few[FEW_PAIRS];
    double angles[FEW_PAIRS];
    frame_search part = {.pairs = few, .angles = angles, .count = FEW_PAIRS};
    if (s->count < 2 * (size_t)FEW_PAIRS) return 1;
    for (uint64_t i = 0; i < FEW_PAIRS; ++i) { /* not in step with parts that are alike */
        const uint64_t begin = i * s->count / FEW_PAIRS, end = (i + 1) * s->count / FEW_PAIRS;
        few[i] = s->pairs[begin + norma_core_hash(&i, sizeof i) % (end - begin)];
    }
    fit_in_rounds(&part, &frame);
    return quantile_of(&part, .3) < 2 * FRAME_NEAR_RAD;
}

static void try_kind(frame_search *s, const explain_trial *trial, explain_frame_kind kind) {
    explain_frame frame = {.kind = kind, .trial = *trial, .turn = {1, 0, 0, 0}};
    if (s->best->kind && s->best->kind < kind) return; /* in this order */
    if (!may_be_turned(s, frame)) return;
    fit_in_rounds(s, &frame);
    frame.median_rad = quantile_of(s, .5);
    if (frame.median_rad >= FRAME_NEAR_RAD ||
        (s->best->kind == kind && frame.median_rad >= s->best->median_rad - 1e-6))
        return;
    *s->best = frame;
    s->done |= frame.median_rad < 2e-6 && kind == EXPLAIN_FRAME_REVERSED;
}

static int make_unit_double(const float *from, double to[3]) {
    for (int k = 0; k < 3; ++k) to[k] = (double)from[k];
    const double length = norma_core_length(to);
    for (int k = 0; k < 3; ++k) to[k] /= length > 0 ? length : 1;
    return length > 0 && length < INFINITY;
}

static void gather_pairs(frame_search *s, const explain_trial *trial) {
    const explain_surface *surface = s->surface;
    s->count = 0;
    for (size_t f = 0; f < surface->checked.face_count; ++f)
        for (size_t c = norma_core_face_begin(&surface->checked, f);
             c < norma_core_face_end(&surface->checked, f); ++c) {
            frame_pair *pair = &s->pairs[s->count];
            const size_t stored = norma_explain_stored_of(surface, c),
                         computed = norma_explain_computed_of(surface, trial, f, c);
            s->count += surface->angles[c] >= 0 &&
                        make_unit_double(surface->stored + 3 * stored, pair->stored) &&
                        make_unit_double(surface->computed + 3 * computed, pair->computed);
        }
}

static norma_result try_trial(const explain_trial *trial, void *context) {
    frame_search *s = context;
    const norma_result result = norma_explain_measure(s->call, s->surface, trial);
    if (result) return result;
    gather_pairs(s, trial);
    for (int kind = EXPLAIN_FRAME_REVERSED; kind <= EXPLAIN_FRAME_BOTH && s->count; ++kind)
        try_kind(s, trial, (explain_frame_kind)kind);
    return NORMA_OK;
}

static norma_result search_surface(core_call *call, explain_surface *surface, void *best) {
    const size_t corners = surface->checked.corner_count;
    frame_search s = {.call = call,
        .surface = surface,
        .best = best,
        .pairs = norma_core_allocate(call, corners + 1, sizeof *s.pairs),
        .angles = norma_core_allocate(call, corners, sizeof *s.angles)};
    norma_result result = s.pairs && s.angles ? NORMA_OK : NORMA_ERROR_MEMORY;
    if (!result) result = norma_explain_each_trial(call, surface, try_trial, &s, &s.done);
    norma_core_release(call, s.angles, corners, sizeof *s.angles);
    norma_core_release(call, s.pairs, corners + 1, sizeof *s.pairs);
    return result;
}

/* ---- in words: a rotation by at most half a turn, its axis the way that reads better */

static void tidy_frame(explain_frame *frame) {
    double *axis = frame->axis;
    const double sine = norma_core_length(frame->turn + 1);
    double angle = 2 * norma_core_angle(sine, frame->turn[0]);
    for (int k = 0; k < 3; ++k) {
        axis[k] = sine > 0 ? frame->turn[k + 1] / sine : k == 0;
        if (fabs(axis[k]) < 5e-4) axis[k] = 0;
    }
    /* -R is a mirror along the axis, and half a turn about it more. */
    if (frame->kind == EXPLAIN_FRAME_BOTH || frame->kind == EXPLAIN_FRAME_MIRROR) angle += NORMA_PI;
    if (angle > 2 * NORMA_PI) angle -= 2 * NORMA_PI;
    int first = 0, turns = angle > NORMA_PI;
    if (turns) angle = 2 * NORMA_PI - angle;
    while (first < 2 && axis[first] == 0) ++first;
    if (NORMA_PI - angle < 1e-3 || frame->kind == EXPLAIN_FRAME_MIRROR) turns = axis[first] < 0;
    for (int k = 0; k < 3; ++k) axis[k] = (turns ? -axis[k] : axis[k]) + 0.0;
    frame->angle_rad = angle;
}

norma_result norma_explain_find_frame(core_call *call, const norma_mesh_data *data,
    const core_mesh *checked, const core_topology *topology, explain_frame *frame) {
    *frame = (explain_frame){.trial = {.crease_rad = NAN}};
    const norma_result result =
        norma_explain_on_sample(call, data, checked, topology, search_surface, frame);
    tidy_frame(frame);
    return result;
}
