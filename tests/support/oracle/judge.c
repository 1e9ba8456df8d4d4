/* judge.c: see judge.h. Everything is tried against everything, as small meshes allow. */
#include "oracle/judge.h"
#include "oracle/guarded.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void complain(trial *t, const char *what, size_t index) {
    if (++t->total.wrong < 10) printf("# %s: %s %zu\n", t->name, what, index);
}

uint32_t trial_below(trial *t, uint32_t bound) {
    return (uint32_t)((made_case_random(&t->salt) >> 32) % bound);
}

void *trial_array(trial *t, size_t count, size_t size) {
    return guarded_take(count * size, (int)trial_below(t, 2));
}

/* ---- split */

typedef struct split_mesh {
    uint32_t *corners, *sources;
    float *normals;
    size_t count;
} split_mesh;

static void judge_new_vertices(trial *t, const split_mesh *s) {
    size_t next = 0;
    for (size_t c = 0; c < t->o.corner_count; ++c) {
        const size_t v = s->corners[c];
        if (v > next || v >= s->count) {
            complain(t, "split numbers corner", c);
            return;
        }
        next += v == next;
        if (s->sources[v] != t->o.corners[c]) complain(t, "split's source of corner", c);
        if (memcmp(s->normals + 3 * v, t->corner_normals + 3 * c, 12))
            complain(t, "split's normal of corner", c);
    }
    if (next != s->count) complain(t, "split counts vertices", s->count);
    for (size_t v = 0; v < s->count; ++v)
        for (size_t w = 0; w < v; ++w)
            if (s->sources[v] == s->sources[w] &&
                !memcmp(s->normals + 3 * v, s->normals + 3 * w, 12))
                complain(t, "split gives a vertex twice,", v);
}

void judge_split(trial *t) {
    const size_t count = t->o.corner_count;
    const float crease = t->made->crease;
    split_mesh s = {0};
    if (norma_split(&t->mesh, crease, &t->options, NULL, 0, NULL, NULL, 0, &s.count, NULL)) {
        complain(t, "split is refused, corners", count);
        return;
    }
    const size_t expected = s.count;
    s.corners = trial_array(t, count, sizeof *s.corners);
    s.sources = trial_array(t, expected, sizeof *s.sources);
    s.normals = trial_array(t, expected, 3 * sizeof *s.normals);
    if (norma_split(&t->mesh, crease, &t->options, s.corners, count, s.sources, s.normals, expected,
            &s.count, NULL) ||
        s.count != expected)
        complain(t, "split says otherwise what there is room for,", expected);
    else
        judge_new_vertices(t, &s);
}

/* ---- plans */

typedef struct updated {
    norma_options options;
    norma_report report;
    size_t count;
    float *normals;
    uint8_t *reasons;
} updated;

static int update(trial *t, const norma_plan *plan, const norma_vec3_view *positions,
    const uint32_t *moved, size_t moved_count, updated *u) {
    u->options = t->options;
    u->options.reasons = u->reasons;
    const norma_result result = norma_plan_update(
        plan, *positions, moved, moved_count, &u->options, u->normals, u->count, &u->report);
    if (result) complain(t, "an update gives result", (size_t)-result);
    return !result;
}

static void judge_update(trial *t, norma_element of, const oracle *o, const updated *u) {
    const answer a = {u->normals, u->reasons, &u->report, NULL};
    if (of == NORMA_PER_CORNER)
        judge_corners(&t->total, t->name, o, &t->fans, &u->options, &a);
    else
        judge_fans_of_vertices(&t->total, t->name, o, &t->fans, &u->options, &a);
}

/* Of each element whether a moved vertex can change it: of a face with such a vertex all corners,
 * and whatever shares their sums. */
static void find_changing(const trial *t, norma_element of, const unsigned char *moves, char *may) {
    const oracle *o = &t->o;
    char *fans = oracle_allocate(t->fans.fan_count, 1);
    for (size_t f = 0; f < o->face_count; ++f) {
        int touched = 0;
        for (size_t c = o->starts[f]; c < o->starts[f + 1]; ++c) touched |= moves[o->corners[c]];
        for (size_t c = o->starts[f]; c < o->starts[f + 1] && touched; ++c)
            fans[t->fans.fan[c]] = 1;
    }
    for (size_t v = 0; v < o->position_count && of == NORMA_PER_VERTEX; ++v)
        may[v] = (char)moves[v];
    for (size_t c = 0; c < o->corner_count; ++c)
        may[of == NORMA_PER_CORNER ? c : o->corners[c]] |= fans[t->fans.fan[c]];
    free(fans);
}

/* Some vertices move. What an update of them leaves is what one of all gives; what cannot change is
 * not written, which is seen where all was poisoned before. */
static void judge_moved(
    trial *t, norma_element of, const norma_plan *plan, norma_vec3_view positions, updated *some) {
    const oracle *o = &t->o;
    uint32_t moved[4];
    const uint32_t count = 1 + trial_below(t, 4), vertices = (uint32_t)o->position_count;
    unsigned char *moves = oracle_allocate(vertices, 1);
    char *may = oracle_allocate(some->count, 1);
    static const size_t sizes[] = {12, 24, 3, 3, 6, 6};
    const size_t size = sizes[positions.format],
                 stride = positions.stride ? positions.stride : size;
    unsigned char *places = trial_array(t, vertices ? (vertices - 1) * stride + size : 0, 1);
    if (vertices) memcpy(places, positions.data, (vertices - 1) * stride + size);
    positions.data = places;
    for (uint32_t i = 0; i < count; ++i) { /* to where another lies, or some bits beside */
        const uint32_t v = moved[i] = trial_below(t, vertices), from = trial_below(t, vertices);
        moves[v] = 1;
        memmove(places + v * stride, places + from * stride, size);
        unsigned char *number = places + v * stride + trial_below(t, 3) * (size / 3);
        int zero = 1; /* but for its sign */
        for (size_t b = 0; b < size / 3; ++b)
            zero &= (number[b] & (size > 6 && b + 1 == size / 3 ? 0x7f : 0xff)) == 0;
        if (!zero && trial_below(t, 2)) number[size > 12 ? 5 : size > 6 ? 1 : 0] ^= 4;
    }
    find_changing(t, of, moves, may);
    updated all = {.count = some->count,
        .normals = trial_array(t, some->count, 12),
        .reasons = trial_array(t, some->count, 1)};
    const size_t before = t->total.wrong;
    oracle there;
    oracle_create(&there, &t->mesh, t->options.weld, t->options.weld_distance);
    oracle_move(&there, &positions);
    if (update(t, plan, &positions, NULL, 0, &all) &&
        update(t, plan, &positions, moved, count, some)) {
        judge_update(t, of, &there, &all);
        if (memcmp(all.normals, some->normals, 12 * all.count) ||
            memcmp(all.reasons, some->reasons, all.count))
            complain(t, "an update of some leaves other normals than one of all, moved", count);
        memset(some->normals, GUARDED_POISON, 12 * some->count);
        if (update(t, plan, &positions, moved, count, some))
            for (size_t i = 0; i < some->count; ++i) {
                const unsigned char *got = (const unsigned char *)(some->normals + 3 * i);
                int written = 0;
                for (int k = 0; k < 12; ++k) written |= got[k] != GUARDED_POISON;
                if (written && !may[i] &&
                    !(all.reasons[i] && t->options.fallback == NORMA_FALLBACK_NEAREST))
                    complain(t, "what cannot change is written: element", i);
            }
    }
    for (uint32_t i = 0; i < count && t->total.wrong > before; ++i) {
        const double *p = there.positions[moved[i]];
        printf("# with vertex %u at %a %a %a\n", (unsigned)moved[i], p[0], p[1], p[2]);
    }
    oracle_destroy(&there);
    free(moves);
    free(may);
}

static void judge_plan(trial *t, norma_element of) {
    norma_plan *plan = NULL;
    norma_edges edges;
    norma_options options = t->options;
    options.edges = &edges;
    const size_t count = of == NORMA_PER_CORNER ? t->o.corner_count : t->o.position_count;
    updated u = {
        .count = count, .normals = trial_array(t, count, 12), .reasons = trial_array(t, count, 1)};
    if (norma_plan_create(&t->mesh, of, t->made->crease, &options, &plan)) {
        complain(t, "no plan is made, of corners", t->o.corner_count);
        return;
    }
    if (update(t, plan, &t->mesh.positions, NULL, 0, &u)) {
        judge_update(t, of, &t->o, &u);
        if (of == NORMA_PER_CORNER && memcmp(u.normals, t->corner_normals, 12 * count))
            complain(t, "a plan gives other corners, of", count);
        if (t->o.position_count) judge_moved(t, of, plan, t->mesh.positions, &u);
    }
    norma_plan_destroy(plan);
}

void judge_plans(trial *t) {
    judge_plan(t, trial_below(t, 2) ? NORMA_PER_CORNER : NORMA_PER_VERTEX);
}

/* ---- orientation */

typedef struct half_edge {
    size_t from, to, face;
} half_edge;

typedef struct turned_mesh {
    const oracle *o;
    const uint8_t *reverse;
    half_edge *edges;
    size_t edge_count;
    size_t *part; /* of each face: the least face that edges of just two faces join it to */
    unsigned char *open;
} turned_mesh;

static void list_edges(turned_mesh *t) {
    const oracle *o = t->o;
    t->edges = oracle_allocate(o->corner_count, sizeof *t->edges);
    for (size_t c = 0; c < o->corner_count; ++c) {
        const size_t face = o->faces[c];
        if (o->kept[c] != c) continue;
        const size_t a = o->shared[o->corners[c]], b = o->shared[o->corners[o->next[c]]];
        t->edges[t->edge_count++] =
            t->reverse[face] ? (half_edge){b, a, face} : (half_edge){a, b, face};
    }
}

static int along(const half_edge *a, const half_edge *b) {
    return a->from == b->from && a->to == b->to ? 1 : a->from == b->to && a->to == b->from ? -1 : 0;
}

/* The other of just two half-edges along an edge, or NULL. */
static const half_edge *other_of_two(const turned_mesh *t, const half_edge *e) {
    const half_edge *found = NULL;
    for (size_t i = 0; i < t->edge_count; ++i) {
        if (&t->edges[i] == e || !along(&t->edges[i], e)) continue;
        if (found) return NULL;
        found = &t->edges[i];
    }
    return found;
}

static void find_parts(turned_mesh *t) {
    const size_t faces = t->o->face_count;
    t->part = oracle_allocate(faces, sizeof *t->part);
    t->open = oracle_allocate(faces, 1);
    for (size_t f = 0; f < faces; ++f) t->part[f] = f;
    for (size_t i = 0; i < t->edge_count; ++i) {
        const half_edge *other = other_of_two(t, &t->edges[i]);
        if (!other) continue;
        const size_t a = t->part[t->edges[i].face], b = t->part[other->face];
        for (size_t f = 0; f < faces; ++f)
            if (t->part[f] == (a > b ? a : b)) t->part[f] = a < b ? a : b;
    }
    for (size_t i = 0; i < t->edge_count; ++i)
        if (!other_of_two(t, &t->edges[i])) t->open[t->part[t->edges[i].face]] = 1;
    for (size_t f = 0; f < faces; ++f) /* a face without edges closes nothing */
        if (t->o->kinds[f] == ORACLE_FEW) t->open[t->part[f]] = 1;
}

/* Six times the volume of a part of triangles; 0 where it has another face, or a coordinate that is
 * no small whole number. */
static long volume(const turned_mesh *t, size_t part) {
    const oracle *o = t->o;
    long sum = 0;
    for (size_t f = 0; f < o->face_count; ++f) {
        long p[3][3];
        if (t->part[f] != part || o->starts[f + 1] == o->starts[f]) continue;
        if (o->starts[f + 1] - o->starts[f] != 3) return 0;
        for (size_t i = 0; i < 3; ++i)
            for (size_t k = 0; k < 3; ++k) {
                const double x = o->positions[o->corners[o->starts[f] + i]][k];
                if (!(fabs(x) < 1000) || floor(x) < x) return 0;
                p[i][k] = (long)x;
            }
        const long six = p[0][0] * (p[1][1] * p[2][2] - p[1][2] * p[2][1]) +
                         p[0][1] * (p[1][2] * p[2][0] - p[1][0] * p[2][2]) +
                         p[0][2] * (p[1][0] * p[2][1] - p[1][1] * p[2][0]);
        sum += t->reverse[f] ? -six : six;
    }
    return sum;
}

static void box_of(const turned_mesh *t, size_t part, double low[3], double high[3]) {
    const oracle *o = t->o;
    for (int k = 0; k < 3; ++k) low[k] = INFINITY, high[k] = -INFINITY;
    for (size_t c = 0; c < o->corner_count; ++c)
        for (int k = 0; k < 3 && t->part[o->faces[c]] == part; ++k) {
            low[k] = fmin(low[k], o->positions[o->corners[c]][k]);
            high[k] = fmax(high[k], o->positions[o->corners[c]][k]);
        }
}

static int is_apart(const turned_mesh *t, size_t part) {
    double low[3], high[3], l[3], h[3];
    box_of(t, part, low, high);
    for (size_t f = 0; f < t->o->face_count; ++f) {
        if (t->part[f] == part) continue;
        box_of(t, t->part[f], l, h);
        int meets = 1;
        for (int k = 0; k < 3; ++k) meets &= !(h[k] < low[k] || high[k] < l[k]);
        if (meets) return 0;
    }
    return 1;
}

static void judge_turned(trial *r, const turned_mesh *t) {
    for (size_t i = 0; i < t->edge_count; ++i) {
        const half_edge *other = other_of_two(t, &t->edges[i]);
        if (other && along(other, &t->edges[i]) > 0 && other->face != t->edges[i].face)
            complain(r, "turned against a neighbour: face", t->edges[i].face);
    }
    for (size_t f = 0; f < t->o->face_count; ++f)
        if (t->part[f] == f && !t->open[f] && is_apart(t, f) && volume(t, f) < 0)
            complain(r, "inside out: the part of face", f);
}

void judge_orientation(trial *r) {
    const size_t faces = r->o.face_count;
    const norma_orient_open open =
        trial_below(r, 8) ? NORMA_ORIENT_OPEN_KEPT : NORMA_ORIENT_OPEN_BY_RAYS;
    uint8_t *reverse = trial_array(r, faces, 1);
    norma_orient_report report;
    turned_mesh t = {.o = &r->o, .reverse = reverse};
    size_t reversed = 0;
    if (norma_orient(&r->mesh, open, &r->options, reverse, faces, &report)) {
        complain(r, "not oriented, faces", faces);
        return;
    }
    for (size_t f = 0; f < faces; ++f) {
        reversed += reverse[f] == 1;
        if (reverse[f] > 1) complain(r, "neither reversed nor not: face", f);
    }
    if (reversed != report.reversed_faces) complain(r, "reversed faces", reversed);
    if (report.closed + report.open + report.one_sided != report.parts)
        complain(r, "of three kinds, but for parts", report.parts);
    list_edges(&t);
    find_parts(&t);
    if (!report.one_sided) judge_turned(r, &t);
    free(t.edges);
    free(t.part);
    free(t.open);
}
