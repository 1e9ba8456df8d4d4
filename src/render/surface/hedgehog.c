/* hedgehog.c: hedgehog lines: from each vertex along its normal, from each face's middle along its
 * own, and from points on edges along the interpolated one (Phong 1975); each as long as the edges
 * about it are. And each edge of a polygon once, for a wireframe. */
#include "render/surface/surface_vertices.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double
    shortest = 0.01,
    longest = 0.5; /* reach in the box, which is two wide: lines on a fine mesh can still be seen */

typedef struct liner {
    const render_surface *surface;
    const norma_mesh *mesh;
    render_box box;
    double reach;
    size_t step; /* every so many is drawn */
    render_line_set *set;
} liner;

static int make_room_for_lines(liner *l, size_t candidates, size_t most) {
    l->step = most > 0 ? (candidates + most - 1) / most : 1;
    l->step = l->step > 0 ? l->step : 1;
    size_t kept = (candidates + l->step - 1) / l->step;
    l->set->floats = malloc((kept + 1) * RENDER_LINE_FLOATS * sizeof(float));
    l->set->left_out = candidates - kept;
    return l->set->floats != NULL;
}

static void add_direction_line(liner *l, const double from[3], const float to[3], double reach) {
    float *out = l->set->floats + RENDER_LINE_FLOATS * l->set->count++;
    for (int k = 0; k < 3; ++k) out[k] = (float)from[k];
    memcpy(out + 3, to, 12);
    out[6] = (float)fmin(fmax(reach * l->reach, shortest), longest);
}

/* Where a corner's position lies in the box; 0: nowhere. */
static int boxed(const liner *l, uint32_t position, double p[3]) {
    if (!render_position(l->mesh, position, p)) return 0;
    for (int k = 0; k < 3; ++k) p[k] = (p[k] - l->box.origin[k]) * l->box.scale;
    return 1;
}

static double length_between(const double a[3], const double b[3]) {
    double d[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    return sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
}

/* Calls visit for each edge of each face: corners and where they lie. */
typedef void visit_edge(
    void *user, size_t corner, size_t next, const double a[3], const double b[3]);
static void each_edge(const liner *l, visit_edge *visit, void *user) {
    for (size_t face = 0; face < render_face_count(l->mesh); ++face) {
        size_t first, count;
        render_face(l->mesh, face, &first, &count);
        for (size_t i = 0; i < count; ++i) {
            double a[3], b[3];
            size_t corner = first + i, next = first + (i + 1) % count;
            if (boxed(l, norma_mesh_corner(l->mesh, corner), a) &&
                boxed(l, norma_mesh_corner(l->mesh, next), b))
                visit(user, corner, next, a, b);
        }
    }
}

/* ---- of vertices */

typedef struct edge_lengths {
    const render_split *split;
    double *sums;
    uint32_t *counts;
} edge_lengths;

static void add_length(
    void *user, size_t corner, size_t next, const double a[3], const double b[3]) {
    edge_lengths *lengths = user;
    const uint32_t ends[2] = {lengths->split->corners[corner], lengths->split->corners[next]};
    for (int k = 0; k < 2; ++k) {
        lengths->sums[ends[k]] += length_between(a, b);
        ++lengths->counts[ends[k]];
    }
}

static int vertex_lines(liner *l, const render_split *split, size_t most) {
    edge_lengths lengths = {split, calloc(split->count + 1, sizeof(double)),
        calloc(split->count + 1, sizeof(uint32_t))};
    const int ready = lengths.sums && lengths.counts && make_room_for_lines(l, split->count, most);
    if (ready) each_edge(l, add_length, &lengths);
    for (size_t i = 0; ready && i < split->count; i += l->step) {
        double p[3];
        if (lengths.counts[i] && boxed(l, split->sources ? split->sources[i] : (uint32_t)i, p))
            add_direction_line(l, p, split->normals + 3 * i, lengths.sums[i] / lengths.counts[i]);
    }
    free(lengths.sums);
    free(lengths.counts);
    return ready;
}

/* ---- of faces */

static void face_line(liner *l, size_t face, const float normal[3]) {
    size_t first, count;
    double middle[3] = {0}, last[3] = {0}, around = 0;
    render_face(l->mesh, face, &first, &count);
    for (size_t i = 0; i <= count && count > 0; ++i) {
        double p[3];
        if (!boxed(l, norma_mesh_corner(l->mesh, first + i % count), p)) return;
        around += i > 0 ? length_between(p, last) : 0;
        for (int k = 0; k < 3 && i < count; ++k) middle[k] += p[k] / (double)count;
        memcpy(last, p, sizeof last);
    }
    if (count > 2 && (normal[0] != 0 || normal[1] != 0 || normal[2] != 0))
        add_direction_line(l, middle, normal, around / (double)count);
}

static int face_lines(liner *l, size_t most) {
    const size_t faces = render_face_count(l->mesh);
    const norma_options options = {.struct_size = sizeof options, .threads = NORMA_ALL_THREADS};
    float *normals = malloc((3 * faces + 1) * sizeof *normals);
    const int ready = normals && make_room_for_lines(l, faces, most) &&
                      !norma_face_normals(l->mesh, &options, normals, faces, NULL);
    for (size_t face = 0; ready && face < faces; face += l->step)
        face_line(l, face, normals + 3 * face);
    free(normals);
    return ready;
}

/* ---- along edges */

enum { EDGE_STEPS = 8 };

typedef struct edge_normals {
    liner *l;
    const render_split *split;
    size_t edge;
} edge_normals;

static void add_interpolated(
    void *user, size_t corner, size_t next, const double a[3], const double b[3]) {
    edge_normals *along = user;
    const render_split *split = along->split;
    if (along->edge++ % along->l->step) return;
    if (memcmp(split->normals + (size_t)3 * split->corners[corner],
            split->normals + (size_t)3 * split->corners[next], 12) == 0)
        return; /* nothing changes on the way */
    for (int i = 1; i < EDGE_STEPS; ++i) {
        const float t = (float)i / EDGE_STEPS, weights[3] = {1 - t, t, 0};
        const float *from = split->normals + (size_t)3 * split->corners[corner],
                    *to = split->normals + (size_t)3 * split->corners[next];
        float normal[3];
        double p[3];
        norma_interpolate_normal(from, to, to, weights, normal);
        for (int k = 0; k < 3; ++k) p[k] = a[k] + (double)t * (b[k] - a[k]);
        add_direction_line(along->l, p, normal, length_between(a, b));
    }
}

static int edge_lines(liner *l, const render_split *split, size_t most) {
    edge_normals along = {l, split, 0};
    const size_t edges = l->mesh->corner_count, kept = most / EDGE_STEPS + 1;
    l->step = (edges + kept - 1) / kept;
    l->step = l->step > 0 ? l->step : 1;
    l->set->floats =
        malloc((edges / l->step + 1) * EDGE_STEPS * RENDER_LINE_FLOATS * sizeof(float));
    l->set->left_out = edges - (edges + l->step - 1) / l->step;
    if (l->set->floats) each_edge(l, add_interpolated, &along);
    return l->set->floats != NULL;
}

/* ---- a wireframe: the edges of each position that lead to a later one, each once */

typedef struct edge_table {
    liner *l;
    uint32_t *starts, *others; /* of each position: where its edges begin in others */
    int filling;
} edge_table;

static void note_edge(
    void *user, size_t corner, size_t next, const double a[3], const double b[3]) {
    edge_table *table = user;
    uint32_t p = norma_mesh_corner(table->l->mesh, corner),
             q = norma_mesh_corner(table->l->mesh, next);
    (void)a, (void)b;
    if (p == q) return;
    if (!table->filling)
        ++table->starts[(p < q ? p : q) + 1];
    else
        table->others[table->starts[p < q ? p : q]++] = p < q ? q : p;
}

static int ascending(const void *a, const void *b) {
    uint32_t x = *(const uint32_t *)a, y = *(const uint32_t *)b;
    return (x > y) - (x < y);
}

static void add_edges_of(liner *l, uint32_t position, uint32_t *others, size_t count) {
    double a[3], b[3];
    qsort(others, count, sizeof *others, ascending);
    for (size_t i = 0; i < count; ++i) {
        float to[3];
        if ((i > 0 && others[i] == others[i - 1]) || !boxed(l, position, a) ||
            !boxed(l, others[i], b))
            continue;
        for (int k = 0; k < 3; ++k) to[k] = (float)b[k];
        add_direction_line(l, a, to, 0);
    }
}

static int wireframe(liner *l) {
    const size_t positions = l->mesh->positions.count, corners = l->mesh->corner_count;
    edge_table table = {
        l, calloc(positions + 2, sizeof(uint32_t)), malloc((corners + 1) * sizeof(uint32_t)), 0};
    const int ready = table.starts && table.others && make_room_for_lines(l, corners, 0);
    if (ready) {
        each_edge(l, note_edge, &table);
        for (size_t i = 0; i < positions; ++i) table.starts[i + 1] += table.starts[i];
        table.filling = 1;
        each_edge(l, note_edge, &table);
    }
    /* Filling has moved each start to the next one's. */
    for (size_t i = 0; ready && i < positions; ++i) {
        const uint32_t begin = i ? table.starts[i - 1] : 0;
        add_edges_of(l, (uint32_t)i, table.others + begin, table.starts[i] - begin);
    }
    free(table.starts);
    free(table.others);
    return ready;
}

/* ---- dots: lines from a point to itself, which are as wide as they are long */

static int dots(liner *l) {
    const render_surface *surface = l->surface;
    l->set->colours = malloc((4 * surface->dot_count + 1) * sizeof(float));
    if (!l->set->colours || !make_room_for_lines(l, surface->dot_count, 0)) return 0;
    for (size_t i = 0; i < surface->dot_count; ++i) {
        const render_dot *dot = &surface->dots[i];
        float at[3], *colour = l->set->colours + 4 * i;
        double from[3];
        render_into_box(&l->box, dot->position, at);
        for (int k = 0; k < 3; ++k) {
            from[k] = (double)at[k];
            colour[k] = render_linear(dot->colour >> (16 - 8 * k) & 0xFF);
        }
        colour[3] = 1;
        add_direction_line(l, from, at, 0);
    }
    return 1;
}

void render_lines_free(render_line_set *set) {
    free(set->floats);
    free(set->colours);
    *set = (render_line_set){0};
}

enum render_result render_lines_make(const render_surface *surface, unsigned kind, double reach,
    size_t most, render_line_set *set, render_error *error) {
    liner l = {.surface = surface,
        .mesh = &surface->mesh,
        .box = render_box_of(&surface->mesh),
        .reach = reach,
        .step = 1,
        .set = set};
    render_split split = {0};
    int good = 0;
    *set = (render_line_set){0};
    if ((kind == RENDER_VERTEX_LINES || kind == RENDER_EDGE_LINES) &&
        render_split_make(surface, &split, error))
        return error->result;
    if (kind == RENDER_VERTEX_LINES)
        good = vertex_lines(&l, &split, most);
    else if (kind == RENDER_FACE_LINES)
        good = face_lines(&l, most);
    else if (kind == RENDER_EDGE_LINES)
        good = edge_lines(&l, &split, most);
    else if (kind == RENDER_DOTS)
        good = dots(&l);
    else
        good = wireframe(&l);
    render_split_free(&split);
    if (good) return RENDER_OK;
    render_lines_free(set);
    return render_fail_memory(error);
}
