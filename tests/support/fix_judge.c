/* fix_judge.c: see fix_judge.h. Everything is tried against everything: files are small.
 *
 * - No rule has more elements, or a higher severity, at warning or above.
 * - An edge that is open was not part of a closed component.
 * - No edge has three faces that had two.
 * - No more area opposes its normals.
 * - A face that was turned was not called right by rays. */
#include "fix_judge.h"
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_CORNERS = 64, MOST_EDGES = 2000, RAYS = 128, MOST_TURNED = 24, MOST_INSTANCES = 16 };

typedef struct vec {
    double x[3];
} vec;

typedef struct edge {
    size_t from, to, face;
} edge;

typedef struct face {
    size_t mesh, count;           /* corners left; below three: no edges */
    size_t corners[MOST_CORNERS]; /* positions */
    vec normals[MOST_CORNERS];    /* zeros: none */
    vec area;                     /* vector */
    double thinness;              /* height over longest edge, roughly */
    size_t component;             /* its least face */
} face;

/* A mesh as a node places it, baked or not; one that no node draws stays where it is. */
typedef struct placement {
    size_t mesh;
    double world[16];
} placement;

typedef struct surface {
    placement *placements;
    size_t placement_count;
    vec *positions;
    size_t position_count;
    face *faces;
    size_t face_count;
    edge *edges;
    size_t edge_count, corner_count;
    unsigned char *closed; /* of each component */
    int left_out;          /* something is too large to look at */
    double size;           /* diagonal */
} surface;

typedef struct judging {
    const char *name;
    surface before, after;
    int moved; /* nodes place meshes otherwise than before (baked) */
    size_t wrong;
} judging;

#if defined(__GNUC__)
__attribute__((format(printf, 2, 3)))
#endif
static void
accuse(judging *j, const char *format, ...) {
    va_list arguments;
    if (++j->wrong > 8) return;
    va_start(arguments, format);
    printf("# %s: ", j->name);
    vprintf(format, arguments);
    printf("\n");
    va_end(arguments);
}

static void *take(size_t count, size_t size) {
    void *block = calloc(count + 1, size);
    if (!block) abort();
    return block;
}

static vec minus(vec a, vec b) {
    return (vec){{a.x[0] - b.x[0], a.x[1] - b.x[1], a.x[2] - b.x[2]}};
}
static vec plus(vec a, double s, vec b) {
    return (vec){{a.x[0] + s * b.x[0], a.x[1] + s * b.x[1], a.x[2] + s * b.x[2]}};
}
static vec cross(vec a, vec b) {
    return (vec){{a.x[1] * b.x[2] - a.x[2] * b.x[1], a.x[2] * b.x[0] - a.x[0] * b.x[2],
        a.x[0] * b.x[1] - a.x[1] * b.x[0]}};
}
static double dot(vec a, vec b) { return a.x[0] * b.x[0] + a.x[1] * b.x[1] + a.x[2] * b.x[2]; }
static double length(vec a) { return sqrt(dot(a, a)); }

/* ---- reading */

static size_t number_of(surface *s, vec p) {
    for (size_t i = 0; i < s->position_count; ++i)
        if (p.x[0] == s->positions[i].x[0] && p.x[1] == s->positions[i].x[1] &&
            p.x[2] == s->positions[i].x[2])
            return i;
    s->positions[s->position_count] = p;
    return s->position_count++;
}

static void measure(const surface *s, face *f) {
    double longest = 0;
    const vec p = s->positions[f->corners[0]];
    for (size_t i = 0; i < f->count; ++i) {
        const vec a = s->positions[f->corners[i]], b = s->positions[f->corners[(i + 1) % f->count]];
        f->area = plus(f->area, 0.5, cross(minus(a, p), minus(b, p)));
        longest = fmax(longest, length(minus(a, b)));
    }
    f->thinness = longest > 0 ? 2 * length(f->area) / (longest * longest) : 0;
}

/* Of corners in a row at one position the last is left. */
static void read_face(surface *s, const norma_mesh_data *data, size_t begin, size_t end, face *f) {
    for (size_t c = begin; c < end; ++c) {
        double p[3], n[3] = {0, 0, 0};
        const size_t vertex = norma_mesh_corner(&data->mesh, c);
        norma_view_vector(&data->mesh.positions, vertex, p);
        const size_t number = number_of(s, (vec){{p[0], p[1], p[2]}});
        const size_t normal = data->corner_normals ? data->corner_normals[c] : vertex;
        if (normal < data->normals.count) norma_view_vector(&data->normals, normal, n);
        if (f->count && f->corners[f->count - 1] == number) --f->count;
        f->corners[f->count] = number;
        f->normals[f->count++] = (vec){{n[0], n[1], n[2]}};
    }
    if (f->count > 1 && f->corners[f->count - 1] == f->corners[0]) --f->count;
    if (f->count >= 3) measure(s, f);
}

static void read_mesh(surface *s, norma_document *document, size_t mesh) {
    norma_mesh_info info;
    norma_mesh_data data;
    if (norma_document_mesh_info(document, mesh, &info) || info.not_read ||
        norma_document_mesh_data(document, mesh, &data, NULL))
        return;
    const norma_mesh *m = &data.mesh;
    const size_t faces = m->face_starts ? m->face_count : m->corner_count / 3;
    s->corner_count += m->corner_count;
    s->left_out |= s->corner_count > 2 * MOST_EDGES || faces > MOST_EDGES;
    if (s->left_out) return;
    s->positions = realloc(s->positions, (s->position_count + m->corner_count + 1) * sizeof(vec));
    s->faces = realloc(s->faces, (s->face_count + faces + 1) * sizeof(face));
    if (!s->positions || !s->faces) abort();
    if (info.normals == NORMA_NORMALS_PER_FACET) data.normals.count = 0;
    for (size_t f = 0; f < faces; ++f) {
        const size_t begin = m->face_starts ? m->face_starts[f] : 3 * f,
                     end = m->face_starts ? m->face_starts[f + 1] : 3 * f + 3;
        face *here = &s->faces[s->face_count];
        *here = (face){.mesh = mesh};
        if (end - begin > MOST_CORNERS)
            s->left_out = 1;
        else
            read_face(s, &data, begin, end, here);
        ++s->face_count;
    }
}

static void list_edges(surface *s) {
    size_t count = 0;
    for (size_t f = 0; f < s->face_count; ++f) count += s->faces[f].count;
    s->edges = take(count, sizeof *s->edges);
    for (size_t f = 0; f < s->face_count; ++f) {
        const face *here = &s->faces[f];
        for (size_t i = 0; i < here->count && here->count >= 3; ++i)
            s->edges[s->edge_count++] =
                (edge){here->corners[i], here->corners[(i + 1) % here->count], f};
    }
}

/* How many run along an edge of one mesh, and how many of them the same way. */
static size_t along(const surface *s, const edge *e, size_t *same_way) {
    size_t both = 0;
    *same_way = 0;
    for (size_t i = 0; i < s->edge_count; ++i) {
        const edge *o = &s->edges[i];
        if (s->faces[o->face].mesh != s->faces[e->face].mesh) continue;
        *same_way += o->from == e->from && o->to == e->to;
        both += (o->from == e->from && o->to == e->to) || (o->from == e->to && o->to == e->from);
    }
    return both;
}

static void find_components(surface *s) {
    s->closed = take(s->face_count, 1);
    memset(s->closed, 1, s->face_count);
    for (size_t f = 0; f < s->face_count; ++f) s->faces[f].component = f;
    for (int again = 1; again;) {
        again = 0;
        for (size_t i = 0; i < s->edge_count; ++i)
            for (size_t k = 0; k < i; ++k) {
                const edge *a = &s->edges[i], *b = &s->edges[k];
                face *f = &s->faces[a->face], *g = &s->faces[b->face];
                if (f->component == g->component || f->mesh != g->mesh) continue;
                if (!((a->from == b->to && a->to == b->from) ||
                        (a->from == b->from && a->to == b->to)))
                    continue;
                f->component = g->component =
                    f->component < g->component ? f->component : g->component;
                again = 1;
            }
    }
    for (size_t i = 0; i < s->edge_count; ++i) {
        size_t same_way;
        const size_t both = along(s, &s->edges[i], &same_way);
        if (both != 2 || same_way != 1) s->closed[s->faces[s->edges[i].face].component] = 0;
    }
}

static void place(surface *s, size_t mesh, const double world[16]) {
    s->placements = realloc(s->placements, (s->placement_count + 1) * sizeof *s->placements);
    if (!s->placements) abort();
    placement *here = &s->placements[s->placement_count++];
    here->mesh = mesh;
    memcpy(here->world, world, sizeof here->world);
}

static void read_placements(surface *s, norma_document *document, size_t mesh) {
    static const double same[16] = {[0] = 1, [5] = 1, [10] = 1, [15] = 1};
    const size_t before = s->placement_count;
    norma_mesh_info info;
    norma_node_info node;
    double world[16];
    if (norma_document_mesh_info(document, mesh, &info)) return;
    for (size_t n = 0; n < norma_document_node_count(document); ++n)
        if (!norma_document_node_info(document, n, &node) && node.mesh == info.mesh)
            for (size_t i = 0; i < node.instances && i < MOST_INSTANCES; ++i)
                if (!norma_document_instance_world(document, n, i, world, NULL))
                    place(s, mesh, world);
    if (s->placement_count == before) place(s, mesh, same);
}

static void read_surface(surface *s, norma_document *document) {
    vec low = {{INFINITY, INFINITY, INFINITY}}, high = {{-INFINITY, -INFINITY, -INFINITY}};
    for (size_t m = 0; m < norma_document_mesh_count(document); ++m) {
        read_mesh(s, document, m);
        read_placements(s, document, m);
    }
    for (size_t i = 0; i < s->position_count; ++i)
        for (int k = 0; k < 3; ++k) {
            low.x[k] = fmin(low.x[k], s->positions[i].x[k]);
            high.x[k] = fmax(high.x[k], s->positions[i].x[k]);
        }
    s->size = s->position_count ? length(minus(high, low)) : 0;
    list_edges(s);
    s->left_out |= s->edge_count > MOST_EDGES;
    if (!s->left_out) find_components(s);
}

static void free_surface(surface *s) {
    free(s->placements);
    free(s->positions);
    free(s->faces);
    free(s->edges);
    free(s->closed);
}

/* ---- which is which: fixes may move positions by a millionth of the mesh, and bake nodes */

static vec placed(const double world[16], vec p) {
    vec q;
    for (int k = 0; k < 3; ++k)
        q.x[k] = world[k] * p.x[0] + world[4 + k] * p.x[1] + world[8 + k] * p.x[2] + world[12 + k];
    return q;
}

static int are_placed_alike(const surface *a, const surface *b) {
    return a->placement_count == b->placement_count &&
           !memcmp(a->placements, b->placements, a->placement_count * sizeof *a->placements);
}

/* Whether two positions, as they are placed, are one. */
static int is_near_placed(
    const judging *j, const placement *from, size_t before, const placement *to, size_t after) {
    const vec p = placed(from->world, j->before.positions[before]),
              q = placed(to->world, j->after.positions[after]);
    double scale = 0;
    for (int c = 0; c < 12; ++c) scale = fmax(scale, fabs(from->world[c]));
    return length(minus(p, q)) <= 4e-6 * scale * j->before.size + 1e-6 * length(p);
}

/* f: of before, g: of after; positions of theirs. */
static int is_near(const judging *j, const face *f, size_t before, const face *g, size_t after) {
    if (!j->moved)
        return f->mesh == g->mesh && length(minus(j->before.positions[before],
                                         j->after.positions[after])) <= 4e-6 * j->before.size;
    for (size_t b = 0; b < j->before.placement_count; ++b)
        for (size_t a = 0; a < j->after.placement_count; ++a)
            if (j->before.placements[b].mesh == f->mesh && j->after.placements[a].mesh == g->mesh &&
                is_near_placed(j, &j->before.placements[b], before, &j->after.placements[a], after))
                return 1;
    return 0;
}

/* ---- edges */

static int was_closed(const judging *j, size_t position, const face *now) {
    int found = 0;
    for (size_t i = 0; i < j->before.edge_count; ++i) {
        const edge *e = &j->before.edges[i];
        const face *f = &j->before.faces[e->face];
        if (!is_near(j, f, e->from, now, position) && !is_near(j, f, e->to, now, position))
            continue;
        if (!j->before.closed[f->component]) return 0;
        found = 1;
    }
    return found;
}

static size_t faces_before(const judging *j, const edge *now) {
    const face *g = &j->after.faces[now->face];
    size_t most = 0, same_way;
    for (size_t i = 0; i < j->before.edge_count; ++i) {
        const edge *e = &j->before.edges[i];
        const face *f = &j->before.faces[e->face];
        if (!((is_near(j, f, e->from, g, now->from) && is_near(j, f, e->to, g, now->to)) ||
                (is_near(j, f, e->from, g, now->to) && is_near(j, f, e->to, g, now->from))))
            continue;
        const size_t here = along(&j->before, e, &same_way);
        most = here > most ? here : most;
    }
    return most;
}

static void judge_edges(judging *j) {
    for (size_t i = 0; i < j->after.edge_count; ++i) {
        size_t same_way;
        const edge *e = &j->after.edges[i];
        const face *f = &j->after.faces[e->face];
        const size_t both = along(&j->after, e, &same_way);
        const vec p = j->after.positions[e->from];
        if (both == 1 && was_closed(j, e->from, f) && was_closed(j, e->to, f))
            accuse(j, "an edge of face %zu at (%g %g %g) is open, in what was closed", e->face,
                p.x[0], p.x[1], p.x[2]);
        if (both > 2 && faces_before(j, e) <= 2)
            accuse(j, "an edge of face %zu at (%g %g %g) has %zu faces now", e->face, p.x[0],
                p.x[1], p.x[2], both);
    }
}

/* ---- normals */

static int opposes(const face *f) {
    if (f->count < 3 || f->thinness < 1e-4) return 0;
    for (size_t i = 0; i < f->count; ++i) {
        const double l = length(f->normals[i]);
        if (!(l > 1e-6) || !(dot(f->normals[i], f->area) < -1e-6 * l * length(f->area))) return 0;
    }
    return 1;
}

/* Whether the corners of now, as they are placed, are among those of was. */
static int is_image(const judging *j, const placement *from, const face *was, const placement *to,
    const face *now) {
    size_t found = 0;
    for (size_t i = 0; i < now->count; ++i)
        for (size_t k = 0; k < was->count; ++k)
            if (is_near_placed(j, from, was->corners[k], to, now->corners[i])) {
                ++found;
                break;
            }
    return found == now->count;
}

/* Whether a face of those that opposed their normals had these corners among its own, in the same
 * mesh, or, as a fix may carry nodes into meshes, at the same place of the scene. */
static int opposed_before(const judging *j, const face *now) {
    const surface *before = &j->before, *after = &j->after;
    for (size_t f = 0; f < before->face_count; ++f) {
        const face *was = &before->faces[f];
        if (!opposes(was)) continue;
        for (size_t b = 0; b < before->placement_count; ++b)
            for (size_t a = 0; a < after->placement_count; ++a)
                if (before->placements[b].mesh == was->mesh &&
                    after->placements[a].mesh == now->mesh &&
                    is_image(j, &before->placements[b], was, &after->placements[a], now))
                    return 1;
    }
    return 0;
}

static void judge_normals(judging *j) {
    for (size_t f = 0; f < j->after.face_count; ++f)
        if (opposes(&j->after.faces[f]) && !opposed_before(j, &j->after.faces[f]))
            accuse(j, "face %zu opposes its normals, and did not", f);
}

/* ---- rays */

static int hits(const surface *s, const face *f, vec from, vec along_ray) {
    for (size_t i = 1; i + 1 < f->count; ++i) { /* Moeller, Trumbore 1997 */
        const vec p = s->positions[f->corners[0]], a = minus(s->positions[f->corners[i]], p),
                  b = minus(s->positions[f->corners[i + 1]], p), q = cross(along_ray, b);
        const double det = dot(a, q);
        if (det == 0) continue;
        const vec t = minus(from, p), r = cross(t, a);
        const double u = dot(t, q) / det, v = dot(along_ray, r) / det, w = dot(b, r) / det;
        if (u >= 0 && v >= 0 && u + v <= 1 && w > 0) return 1;
    }
    return 0;
}

static double radical_inverse(unsigned n, unsigned base) {
    double sum = 0, digit = 1.0 / base;
    for (; n; n /= base, digit /= base) sum += (n % base) * digit;
    return sum;
}

/* How many of RAYS rays leave the scene from the side to which up points. */
static int leaving(const surface *s, vec from, vec up) {
    int count = 0;
    for (unsigned i = 1; i <= RAYS; ++i) {
        const double z = 2 * radical_inverse(i, 2) - 1,
                     turn = 6.283185307179586 * radical_inverse(i, 3), r = sqrt(1 - z * z);
        vec ray = {{r * cos(turn), r * sin(turn), z}};
        int blocked = 0;
        if (dot(ray, up) < 0) ray = (vec){{-ray.x[0], -ray.x[1], -ray.x[2]}};
        for (size_t f = 0; f < s->face_count && !blocked; ++f)
            blocked = hits(s, &s->faces[f], from, ray);
        count += !blocked;
    }
    return count;
}

/* Above 0: from the front of the face more leave, by that share of the rays. */
static double front_leaves(const surface *s, const face *f) {
    vec middle = {{0, 0, 0}};
    const double size = length(f->area);
    if (f->count < 3 || !(size > 0)) return 0;
    for (size_t i = 0; i < 3; ++i) middle = plus(middle, 1 / 3.0, s->positions[f->corners[i]]);
    const vec up = plus((vec){{0, 0, 0}}, 1 / size, f->area);
    const double off = 1e-6 * s->size;
    const vec down = plus((vec){{0, 0, 0}}, -1, up);
    return (leaving(s, plus(middle, off, up), up) - leaving(s, plus(middle, off, down), down)) /
           (double)RAYS;
}

static int is_mirrored(const surface *s, const face *f) {
    for (size_t i = 0; i < s->placement_count; ++i) {
        const double *w = s->placements[i].world;
        const vec x = {{w[0], w[1], w[2]}}, y = {{w[4], w[5], w[6]}}, z = {{w[8], w[9], w[10]}};
        if (s->placements[i].mesh == f->mesh) return dot(x, cross(y, z)) < 0;
    }
    return 0;
}

static int is_same_position(
    const judging *j, const surface *s, const face *f, size_t a, const face *g, size_t b) {
    return s == &j->after ? is_near(j, f, a, g, b)
                          : f->mesh == g->mesh &&
                                length(minus(s->positions[a], s->positions[b])) <= 4e-6 * s->size;
}

/* How many faces of s, before or after, have the corners of f, a face before, in its order or
 * turned. */
static size_t count_faces(const judging *j, const surface *s, const face *f, int turned) {
    size_t faces = 0;
    for (size_t i = 0; i < s->face_count && f->count >= 3; ++i) {
        const face *g = &s->faces[i];
        const int back = turned ^ (is_mirrored(&j->before, f) != is_mirrored(s, g));
        int found = 0;
        for (size_t from = 0; from < g->count && g->count == f->count && !found; ++from) {
            size_t same = 0;
            while (same < f->count &&
                   is_same_position(j, s, f, f->corners[same], g,
                       g->corners[(back ? from + g->count - same : from + same) % g->count]))
                ++same;
            found = same == f->count;
        }
        faces += (size_t)found;
    }
    return faces;
}

/* A surface that was turned: its faces together must not have been right by most rays. */
static void judge_turned(judging *j) {
    for (size_t c = 0; c < j->before.face_count; ++c) {
        double for_it = 0, all = 0;
        size_t turned = SIZE_MAX, looked_at = 0;
        for (size_t f = 0; f < j->before.face_count && looked_at < MOST_TURNED; ++f) {
            const face *here = &j->before.faces[f];
            if (here->component != c || count_faces(j, &j->after, here, 0) ||
                count_faces(j, &j->after, here, 1) <= count_faces(j, &j->before, here, 1))
                continue;
            turned = f;
            ++looked_at;
            all += length(here->area);
            for_it += length(here->area) * front_leaves(&j->before, here);
        }
        if (all > 0 && for_it > 0.5 * all)
            accuse(j, "what was right by rays (%.0f %%) was turned: %zu faces of %s part, face %zu",
                100 * for_it / all, looked_at, j->before.closed[c] ? "a closed" : "an open",
                turned);
    }
}

/* ---- rules */

typedef struct tally {
    size_t count; /* at warning or above */
    norma_severity highest;
} tally;

static void count_rules(
    norma_document *document, const norma_check_options *options, tally *tallies) {
    size_t rules;
    norma_findings *findings;
    norma_check_options all = *options;
    const norma_rule *first = norma_rules(&rules);
    all.rules = NULL;
    if (norma_check_document(document, &all, &findings, NULL)) abort();
    for (size_t i = 0; i < norma_findings_count(findings); ++i) {
        const norma_finding *f = norma_findings_get(findings, i);
        tally *t = &tallies[f->rule - first];
        if (f->severity > t->highest) t->highest = f->severity;
        if (f->severity >= NORMA_SEVERITY_WARNING) t->count += f->count;
    }
    norma_findings_free(findings);
}

static void judge_rules(
    judging *j, norma_document *before, norma_document *after, const norma_check_options *options) {
    size_t rules;
    const norma_rule *rule = norma_rules(&rules);
    tally *was = take(rules, sizeof *was), *is = take(rules, sizeof *is);
    count_rules(before, options, was);
    count_rules(after, options, is);
    for (size_t i = 0; i < rules; ++i) {
        if (is[i].highest < NORMA_SEVERITY_WARNING) continue;
        if (is[i].count > was[i].count || is[i].highest > was[i].highest)
            accuse(j, "%s: %zu elements, severity %d; before %zu, severity %d", rule[i].id,
                is[i].count, (int)is[i].highest, was[i].count, (int)was[i].highest);
    }
    free(was);
    free(is);
}

/* ---- one fix */

static norma_document *open(const void *bytes, size_t size, norma_file_format format) {
    const norma_document_options options = {
        .struct_size = sizeof options, .format = format, .threads = 1, .lenient = 1};
    norma_document *document = NULL;
    return norma_document_open_memory(bytes, size, NULL, &options, &document, NULL) ? NULL
                                                                                    : document;
}

typedef struct output {
    unsigned char *bytes;
    size_t size, room;
} output;

static int put(void *user, const void *bytes, size_t size) {
    output *out = user;
    if (out->size + size > out->room) {
        out->room = 2 * (out->size + size);
        out->bytes = realloc(out->bytes, out->room);
        if (!out->bytes) abort();
    }
    if (size) memcpy(out->bytes + out->size, bytes, size);
    out->size += size;
    return 0;
}

static void judge_output(
    judging *j, fix_file file, const output *out, const norma_check_options *options) {
    norma_document *before = open(file.bytes, file.size, file.format),
                   *after = open(out->bytes, out->size, file.format);
    if (!after)
        accuse(j, "what was written cannot be read");
    else {
        read_surface(&j->before, before);
        read_surface(&j->after, after);
        j->moved = !are_placed_alike(&j->before, &j->after);
        judge_rules(j, before, after, options);
        if (!j->before.left_out && !j->after.left_out) {
            judge_edges(j);
            judge_normals(j);
            if (norma_document_node_count(before) <= 1) judge_turned(j);
        }
        free_surface(&j->before);
        free_surface(&j->after);
    }
    norma_document_close(before);
    norma_document_close(after);
}

/* A part that checks have no use for is not there, or there is no memory. */
static int may_happen(const norma_document_error *error) {
    return error->result == NORMA_DOCUMENT_ERROR_UNSUPPORTED ||
           error->result == NORMA_DOCUMENT_ERROR_MALFORMED ||
           error->result == NORMA_DOCUMENT_ERROR_REFUSED ||
           error->result == NORMA_DOCUMENT_ERROR_MEMORY;
}

fix_verdict judge_fix(const char *name, fix_file file, const norma_check_options *options,
    int unsafe, void (*fixed)(void)) {
    judging j = {.name = name};
    output out = {0};
    norma_fix_summary summary = {0};
    norma_document_error error = {0};
    norma_document *document = open(file.bytes, file.size, file.format);
    if (!document) return (fix_verdict){0, 0};
    if (norma_fix_document(document, options, unsafe, &summary, &error)) {
        if (!may_happen(&error)) accuse(&j, "not fixed: %s", error.message);
    } else if (summary.changed) {
        const norma_document_result written = norma_document_write(document, put, &out, &error);
        if (fixed) fixed();
        if (!written)
            judge_output(&j, file, &out, options);
        else if (!may_happen(&error))
            accuse(&j, "not written: %s", error.message);
    }
    norma_document_close(document);
    free(out.bytes);
    return (fix_verdict){summary.changed, j.wrong};
}
