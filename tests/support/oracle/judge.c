/* judge.c: see judge.h. Everything is tried against everything, as small meshes allow. */
#include "oracle/judge.h"
#include "oracle/compare.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static size_t wrong(const char *name, const char *what, size_t index) {
    printf("# %s: %s %zu\n", name, what, index);
    return 1;
}

static norma_options plain(const norma_options *options) {
    norma_options copy = *options;
    copy.reasons = NULL;
    copy.edges = NULL;
    copy.normal_stride = 0;
    return copy;
}

static size_t old_vertex(const norma_mesh *mesh, size_t corner) {
    return mesh->corners ? ((const uint32_t *)mesh->corners)[corner] : corner;
}

/* ---- split */

typedef struct split_mesh {
    uint32_t *corners, *sources;
    float *normals;
    size_t count;
} split_mesh;

static size_t judge_vertices(
    const char *name, const norma_mesh *mesh, const float *normals, const split_mesh *s) {
    size_t found = 0, next = 0;
    for (size_t c = 0; c < mesh->corner_count; ++c) {
        const size_t v = s->corners[c];
        if (v > next || v >= s->count) return wrong(name, "split numbers corner", c);
        next += v == next;
        if (s->sources[v] != old_vertex(mesh, c)) found += wrong(name, "split's source of", c);
        if (memcmp(s->normals + 3 * v, normals + 3 * c, 12))
            found += wrong(name, "split's normal of corner", c);
    }
    if (next != s->count) found += wrong(name, "split counts vertices", s->count);
    for (size_t v = 0; v < s->count; ++v)
        for (size_t w = 0; w < v; ++w)
            if (s->sources[v] == s->sources[w] &&
                !memcmp(s->normals + 3 * v, s->normals + 3 * w, 12))
                found += wrong(name, "split gives a vertex twice,", v);
    return found;
}

size_t judge_split(
    const char *name, const norma_mesh *mesh, float crease_rad, const norma_options *options) {
    const size_t count = mesh->corner_count;
    const norma_options bare = plain(options);
    float *normals = oracle_allocate(count, 3 * sizeof *normals);
    split_mesh s = {oracle_allocate(count, sizeof *s.corners),
        oracle_allocate(count, sizeof *s.sources), oracle_allocate(count, 12), 0};
    size_t found;
    if (norma_corner_normals(mesh, crease_rad, &bare, normals, count, NULL) ||
        norma_split(
            mesh, crease_rad, &bare, s.corners, count, s.sources, s.normals, count, &s.count, NULL))
        found = wrong(name, "split is refused, corners", count);
    else
        found = judge_vertices(name, mesh, normals, &s);
    free(normals);
    free(s.corners);
    free(s.sources);
    free(s.normals);
    return found;
}

/* ---- plans */

static size_t update(const char *name, const norma_mesh *mesh, norma_element of, float crease_rad,
    const norma_options *options, float *normals, uint8_t *reasons) {
    const size_t count = of == NORMA_PER_VERTEX ? mesh->positions.count : mesh->corner_count;
    norma_options bare = plain(options);
    norma_plan *plan = NULL;
    if (norma_plan_create(mesh, of, crease_rad, &bare, &plan))
        return wrong(name, "no plan of elements", count);
    bare.reasons = reasons;
    const norma_result result =
        norma_plan_update(plan, mesh->positions, NULL, 0, &bare, normals, count, NULL);
    norma_plan_destroy(plan);
    return result ? wrong(name, "no update of elements", count) : 0;
}

/* The kept corners of all fans in which a corner of the vertex lies; returns how many. */
static size_t gather(
    const oracle *o, const oracle_fans *fans, size_t vertex, size_t *corners, int *doubtful) {
    unsigned char *taken = oracle_allocate(fans->fan_count, 1);
    size_t count = 0;
    *doubtful = 0;
    for (size_t c = 0; c < o->corner_count; ++c) {
        const size_t fan = fans->fan[c];
        if (o->corners[c] != vertex || taken[fan]) continue;
        taken[fan] = 1;
        *doubtful |= fans->doubtful[fan];
        for (size_t i = fans->start[fan]; i < fans->start[fan + 1]; ++i)
            corners[count++] = fans->corners[i];
    }
    free(taken);
    return count;
}

static size_t judge_per_vertex(const char *name, const oracle *o, const oracle_fans *fans,
    const norma_options *options, const float *normals, const uint8_t *reasons) {
    size_t *corners = oracle_allocate(o->corner_count, sizeof *corners), found = 0;
    for (size_t v = 0; v < o->position_count; ++v) {
        int doubtful;
        const size_t count = gather(o, fans, v, corners, &doubtful);
        const oracle_normal e = oracle_sum(o, corners, count, options->weight);
        if (doubtful || e.doubtful || !oracle_finite(o->positions[v])) continue;
        if (e.reason == NORMA_REASON_UNREFERENCED) {
            if (reasons[v] != NORMA_REASON_UNREFERENCED)
                found += wrong(name, "a plan gives a normal to vertex", v);
            continue;
        }
        if (e.ratio <= 1e-3L) continue;
        const long double n[3] = {(long double)normals[3 * v], (long double)normals[3 * v + 1],
            (long double)normals[3 * v + 2]};
        if (reasons[v] || !(oracle_angle(n, e.normal) <= COMPARE_SUM_RAD))
            found += wrong(name, "a plan gives another normal to vertex", v);
    }
    free(corners);
    return found;
}

size_t judge_plans(const char *name, const oracle *o, const norma_mesh *mesh, float crease_rad,
    const norma_options *options) {
    const size_t corners = mesh->corner_count,
                 most = corners > mesh->positions.count ? corners : mesh->positions.count;
    const norma_options bare = plain(options);
    float *normals = oracle_allocate(corners, 12), *given = oracle_allocate(most, 12);
    uint8_t *reasons = oracle_allocate(most, 1);
    oracle_fans fans;
    oracle_fans_create(&fans, o, crease_rad, options->non_manifold, COMPARE_DOUBT_RAD);
    size_t found = update(name, mesh, NORMA_PER_CORNER, crease_rad, options, given, reasons);
    if (norma_corner_normals(mesh, crease_rad, &bare, normals, corners, NULL) ||
        memcmp(given, normals, 12 * corners))
        found += wrong(name, "a plan gives other corners, of", corners);
    found += update(name, mesh, NORMA_PER_VERTEX, crease_rad, options, given, reasons);
    found += judge_per_vertex(name, o, &fans, options, given, reasons);
    oracle_fans_destroy(&fans);
    free(normals);
    free(given);
    free(reasons);
    return found;
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

static size_t judge_turned(const char *name, const turned_mesh *t, int two_sided) {
    size_t found = 0;
    for (size_t i = 0; i < t->edge_count && two_sided; ++i) {
        const half_edge *other = other_of_two(t, &t->edges[i]);
        if (other && along(other, &t->edges[i]) > 0 && other->face != t->edges[i].face)
            found += wrong(name, "turned against a neighbour: face", t->edges[i].face);
    }
    for (size_t f = 0; f < t->o->face_count && two_sided; ++f)
        if (t->part[f] == f && !t->open[f] && is_apart(t, f) && volume(t, f) < 0)
            found += wrong(name, "inside out: the part of face", f);
    return found;
}

size_t judge_orientation(
    const char *name, const oracle *o, const norma_mesh *mesh, const norma_options *options) {
    uint8_t *reverse = oracle_allocate(o->face_count, 1);
    norma_orient_report report;
    const norma_options bare = plain(options);
    turned_mesh t = {.o = o, .reverse = reverse};
    size_t found = 0, reversed = 0;
    if (norma_orient(mesh, NORMA_ORIENT_OPEN_KEPT, &bare, reverse, o->face_count, &report)) {
        free(reverse);
        return wrong(name, "not oriented, faces", o->face_count);
    }
    for (size_t f = 0; f < o->face_count; ++f) reversed += reverse[f] != 0;
    if (reversed != report.reversed_faces) found += wrong(name, "reversed faces", reversed);
    list_edges(&t);
    find_parts(&t);
    found += judge_turned(name, &t, !report.one_sided);
    free(t.edges);
    free(t.part);
    free(t.open);
    free(reverse);
    return found;
}
