/* judge_tangents.c: steady tangents of triangles by their definition: the direction in which u
 * grows, made perpendicular to the normal, summed over the corners of equal position, normal and
 * texture coordinates whose faces have one sign of texture area. Of other faces, and of MikkTSpace
 * (whose reference the tests of tests/tangent compile), what holds for any tangent. See judge.h. */
#include "oracle/guarded.h"
#include "oracle/judge.h"
#include <math.h>
#include <string.h>
#include <stdlib.h>

typedef long double vec[3];

typedef struct corner {
    double position[3];
    float normal[3], texcoord[2];
    int finite;
    int sign;      /* of its face; 0: that has no texture area, or is not finite */
    vec direction; /* unit, perpendicular to the normal; zeros: none */
    long double weight;
    int doubtful;
} corner;

typedef struct tangents {
    trial *t;
    corner *corners;
    norma_attribute normals, texcoords;
    norma_options options;
    norma_report report;
    float *out;
    uint8_t *reasons;
} tangents;

static long double dot(const vec a, const vec b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static int normalise(vec v) {
    const long double l = sqrtl(dot(v, v));
    for (int k = 0; k < 3 && l > 0; ++k) v[k] /= l;
    return l > 0;
}

static float any_number(trial *t, float scale) {
    const uint32_t kind = trial_below(t, 200);
    return kind == 0 ? NAN : kind == 1 ? INFINITY : scale * ((float)(kind % 7) - 3);
}

/* Values of vertices or corners, few of them different. */
static norma_attribute attribute(trial *t, size_t width, float scale) {
    const norma_element of = trial_below(t, 2) ? NORMA_PER_CORNER : NORMA_PER_VERTEX;
    const size_t count = of == NORMA_PER_CORNER ? t->o.corner_count : t->o.position_count;
    float *values = trial_array(t, count, 4 * width);
    for (size_t i = 0; i < count * width; ++i) values[i] = any_number(t, scale);
    return (norma_attribute){.data = values, .count = count, .of = of};
}

static const float *value_of(const tangents *g, const norma_attribute *a, size_t c, size_t width) {
    return (const float *)a->data + width * (a->of == NORMA_PER_CORNER ? c : g->t->o.corners[c]);
}

static void read_corners(tangents *g) {
    const oracle *o = &g->t->o;
    for (size_t c = 0; c < o->corner_count; ++c) {
        corner *here = &g->corners[c];
        memcpy(here->position, o->positions[o->corners[c]], sizeof here->position);
        memcpy(here->normal, value_of(g, &g->normals, c, 3), sizeof here->normal);
        memcpy(here->texcoord, value_of(g, &g->texcoords, c, 2), sizeof here->texcoord);
        here->finite = oracle_finite(here->position);
        for (int k = 0; k < 3; ++k) here->finite &= isfinite(here->normal[k]) != 0;
        for (int k = 0; k < 2; ++k) here->finite &= isfinite(here->texcoord[k]) != 0;
    }
}

/* The direction in which u grows across a triangle. */
static void read_triangle(tangents *g, size_t face) {
    const oracle *o = &g->t->o;
    corner *c = g->corners + o->starts[face];
    const long double u1 = (long double)c[1].texcoord[0] - (long double)c[0].texcoord[0],
                      v1 = (long double)c[1].texcoord[1] - (long double)c[0].texcoord[1],
                      u2 = (long double)c[2].texcoord[0] - (long double)c[0].texcoord[0],
                      v2 = (long double)c[2].texcoord[1] - (long double)c[0].texcoord[1];
    const long double area = u1 * v2 - u2 * v1;
    int doubtful = 0;
    vec t;
    long double size = 0, a_squared = 0, b_squared = 0;
    if (!c[0].finite || !c[1].finite || !c[2].finite || area == 0) return;
    for (int k = 0; k < 3; ++k) {
        const long double a = (long double)c[1].position[k] - (long double)c[0].position[k],
                          b = (long double)c[2].position[k] - (long double)c[0].position[k];
        t[k] = (a * v2 - b * v1) * (area > 0 ? 1 : -1);
        size += fabsl(a * v2) + fabsl(b * v1);
        a_squared += a * a;
        b_squared += b * b;
    }
    doubtful |= !(o->areas[face] > 1e-6L * fmaxl(a_squared, b_squared));
    doubtful |= !(fmaxl(a_squared, b_squared) < 1e76L &&
                  fmaxl(a_squared, b_squared) < 1e24L * fminl(a_squared, b_squared));
    for (int i = 0; i < 3; ++i) {
        vec n = {
            (long double)c[i].normal[0], (long double)c[i].normal[1], (long double)c[i].normal[2]};
        const int has_normal = normalise(n);
        const long double along = dot(n, t);
        c[i].sign = area > 0 ? 1 : -1;
        for (int k = 0; k < 3; ++k) c[i].direction[k] = t[k] - along * n[k];
        c[i].doubtful = doubtful || !has_normal ||
                        sqrtl(dot(c[i].direction, c[i].direction)) < 1e-5L * size ||
                        o->kinds[face] != ORACLE_DIRECTED;
        normalise(c[i].direction);
    }
}

/* All corners that share a tangent with this one. */
static int shares(const corner *a, const corner *b) {
    int same = a->finite && b->finite && a->sign == b->sign;
    for (int k = 0; k < 3; ++k)
        same &= a->position[k] == b->position[k] && a->normal[k] == b->normal[k];
    return same && a->texcoord[0] == b->texcoord[0] && a->texcoord[1] == b->texcoord[1];
}

static void judge_sum(tangents *g, size_t c) {
    const oracle *o = &g->t->o;
    const norma_weight weight =
        g->options.weight == NORMA_WEIGHT_VISIBLE ? NORMA_WEIGHT_UNIFORM : g->options.weight;
    vec sum = {0, 0, 0};
    long double weights = 0;
    int doubtful = 0;
    for (size_t i = 0; i < o->corner_count; ++i) {
        const corner *other = &g->corners[i];
        if (!shares(&g->corners[c], other)) continue;
        doubtful |= other->doubtful;
        if (other->doubtful || o->kept[i] != i) continue;
        const long double w = oracle_weight(o, i, weight);
        weights += w;
        for (int k = 0; k < 3; ++k) sum[k] += w * other->direction[k];
    }
    const float *got = g->out + 4 * c;
    const vec t = {(long double)got[0], (long double)got[1], (long double)got[2]};
    if (doubtful || !(sqrtl(dot(sum, sum)) > 1e-3L * weights)) return;
    if (g->reasons[c])
        complain(g->t, "a tangent is missing at corner", c);
    else if (!(oracle_angle(t, sum) < 1e-5L))
        complain(g->t, "not the sum of tangents: corner", c);
}

/* What holds for any tangent. */
static void judge_corner(tangents *g, size_t c, norma_tangent_mode mode) {
    const corner *here = &g->corners[c];
    const float *got = g->out + 4 * c;
    const vec t = {(long double)got[0], (long double)got[1], (long double)got[2]};
    vec n = {
        (long double)here->normal[0], (long double)here->normal[1], (long double)here->normal[2]};
    /* MikkTSpace's reference is less exact where squares of small numbers underflow. */
    if (!(fabsl(sqrtl(dot(t, t)) - 1) < (mode == NORMA_TANGENTS_MIKK ? 0.01L : 1e-5L)))
        complain(g->t, "no unit tangent: corner", c);
    if (got[3] != 1 && got[3] != -1) complain(g->t, "a tangent's sign: corner", c);
    if (mode == NORMA_TANGENTS_STEADY && here->finite && normalise(n) &&
        !(fabsl(dot(t, n)) < 1e-6L))
        complain(g->t, "a tangent that leans: corner", c);
    if (mode == NORMA_TANGENTS_STEADY && here->sign && !here->doubtful &&
        got[3] != (float)here->sign)
        complain(g->t, "not the sign of the texture's area: corner", c);
    if (!here->finite != (g->reasons[c] == NORMA_REASON_NON_FINITE))
        complain(g->t, "not finite, or not said: corner", c);
}

static norma_result run(tangents *g, norma_tangent_mode mode, int plain) {
    const size_t count = g->t->o.corner_count;
    g->options = g->t->options;
    g->out = trial_array(g->t, count, 16);
    g->reasons = g->options.reasons = trial_array(g->t, count, 1);
    if (plain) {
        g->options.threads = 1;
        g->options.isa = NORMA_ISA_PORTABLE;
        g->options.parallel_for = NULL;
        g->options.allocator = (norma_allocator){0};
    }
    return norma_corner_tangents(
        &g->t->mesh, &g->normals, &g->texcoords, mode, &g->options, g->out, count, &g->report);
}

void judge_tangents(trial *t) {
    const oracle *o = &t->o;
    const norma_tangent_mode mode = trial_below(t, 3) ? NORMA_TANGENTS_STEADY : NORMA_TANGENTS_MIKK;
    tangents g = {.t = t, .corners = oracle_allocate(o->corner_count, sizeof(corner))};
    g.normals = attribute(t, 3, 0.5F);
    g.texcoords = attribute(t, 2, 0.25F);
    read_corners(&g);
    const norma_result result = run(&g, mode, 0);
    tangents plain = g;
    int triangles = 1;
    for (size_t f = 0; f < o->face_count; ++f) triangles &= o->starts[f + 1] - o->starts[f] == 3;
    for (size_t f = 0; f < o->face_count && triangles; ++f) read_triangle(&g, f);
    if (result || run(&plain, mode, 1))
        complain(t, "no tangents: result", (size_t)-result);
    else {
        if (memcmp(g.out, plain.out, 16 * o->corner_count) ||
            memcmp(g.reasons, plain.reasons, o->corner_count))
            complain(t, "other tangents by threads or instructions: mode", (size_t)mode);
        for (size_t c = 0; c < o->corner_count; ++c) {
            judge_corner(&g, c, mode);
            if (mode == NORMA_TANGENTS_STEADY && g.corners[c].finite && g.corners[c].sign)
                judge_sum(&g, c);
        }
    }
    free(g.corners);
}
