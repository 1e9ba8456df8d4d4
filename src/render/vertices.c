/* vertices.c: a surface as the graphics processor takes it: triangles, split where normals differ,
 * with the attributes of their corners; and lines along normals and edges. */
#include "render/parts.h"
#include "core/face/cut_polygon.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- the box that a mesh lies in */

/* Positions that no face uses may lie anywhere, and are left out: they would take the others'
 * precision. */
static uint8_t *used_positions(const norma_mesh *mesh) {
    uint8_t *used = calloc(mesh->positions.count + 1, 1);
    for (size_t i = 0; used && i < mesh->corner_count; ++i) used[norma_mesh_corner(mesh, i)] = 1;
    return used;
}

render_box render_box_of(const norma_mesh *mesh) {
    uint8_t *used = used_positions(mesh);
    double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY},
           half = 0;
    render_box box = {.scale = 1};
    for (size_t i = 0; i < mesh->positions.count; ++i) {
        double p[3];
        if ((used && !used[i]) || !render_position(mesh, (uint32_t)i, p)) continue;
        for (int k = 0; k < 3; ++k) {
            low[k] = p[k] < low[k] ? p[k] : low[k];
            high[k] = p[k] > high[k] ? p[k] : high[k];
        }
    }
    for (int k = 0; k < 3 && low[0] <= high[0]; ++k) {
        box.origin[k] = 0.5 * low[k] + 0.5 * high[k];
        half = fmax(half, 0.5 * high[k] - 0.5 * low[k]);
    }
    if (half > 0 && isfinite(1 / half)) box.scale = 1 / half;
    free(used);
    return box;
}

void render_into_box(const render_box *box, const double p[3], float out[3]) {
    for (int k = 0; k < 3; ++k) out[k] = (float)((p[k] - box->origin[k]) * box->scale);
}

/* The normals of all faces, for free(). */
static norma_result face_normals(const norma_mesh *mesh, float **normals) {
    const size_t faces = render_face_count(mesh);
    const norma_options options = {.struct_size = sizeof options, .threads = NORMA_ALL_THREADS};
    *normals = malloc((3 * faces + 1) * sizeof **normals);
    return *normals ? norma_face_normals(mesh, &options, *normals, faces, NULL)
                    : NORMA_ERROR_MEMORY;
}

/* ---- A mesh of polygons as triangles for the graphics processor: fans where they do,
 * and cut by the core where a polygon is concave. */

static uint32_t *add_triangle_of(uint32_t *out, size_t first, size_t a, size_t b, size_t c) {
    *out++ = (uint32_t)(first + a);
    *out++ = (uint32_t)(first + b);
    *out++ = (uint32_t)(first + c);
    return out;
}

static uint32_t *cut_face(
    const norma_mesh *mesh, size_t first, size_t count, core_cutter *cutter, uint32_t *out) {
    for (size_t i = 0; i < count; ++i)
        render_position(mesh, norma_mesh_corner(mesh, first + i), cutter->points[i]);
    if (norma_core_polygon_fans(cutter, count)) {
        for (size_t i = 1; i + 1 < count; ++i) out = add_triangle_of(out, first, 0, i, i + 1);
        return out;
    }
    (void)norma_core_cut_polygon(cutter, count, out);
    for (size_t i = 0; i < 3 * (count - 2); ++i) *out++ += (uint32_t)first;
    return out;
}

static size_t largest_face(const norma_mesh *mesh, size_t *triangles) {
    size_t largest = 0, first, count;
    *triangles = 0;
    for (size_t face = 0; face < mesh->face_count; ++face) {
        render_face(mesh, face, &first, &count);
        largest = count > largest ? count : largest;
        *triangles += count > 2 ? count - 2 : 0;
    }
    return largest;
}

/* Triangles of polygons as corner numbers, three each; concave ones are cut rightly. *corners:
 * owned by the caller, NULL for triangles: 0, 1, 2, ... */
static enum render_result triangulate(
    const norma_mesh *mesh, uint32_t **corners, size_t *triangle_count, render_error *error) {
    *corners = NULL;
    *triangle_count = mesh->corner_count / 3;
    if (!mesh->face_starts) return RENDER_OK;
    const size_t largest = largest_face(mesh, triangle_count);
    core_cutter cutter;
    void *memory = malloc(norma_core_cutter_size(largest));
    uint32_t *out = *corners = malloc((3 * *triangle_count + 1) * sizeof *out);
    const int ready = out && memory;
    if (ready) norma_core_cutter_begin(&cutter, memory, largest, mesh->corner_count);
    for (size_t face = 0; ready && face < mesh->face_count; ++face) {
        size_t first, count;
        render_face(mesh, face, &first, &count);
        if (count >= 3) out = cut_face(mesh, first, count, &cutter, out);
    }
    free(memory);
    if (ready) return RENDER_OK;
    free(*corners);
    *corners = NULL;
    return render_fail_memory(error);
}

/* ---- The tangents that a normal map is drawn with: those of the file, otherwise
 * MikkTSpace's (Mikkelsen 2008), which baking programs use. */

static void copy_stored(const render_surface *surface, float *tangents) {
    for (size_t i = 0; i < surface->mesh.corner_count; ++i)
        memcpy(tangents + 4 * i,
            surface->tangents + (size_t)4 * norma_mesh_corner(&surface->mesh, i),
            4 * sizeof *tangents);
}

/* Without tangents, zeros: the shader then takes derivatives. */
static void compute_mikk(
    const render_surface *surface, const render_split *split, float *tangents) {
    const size_t corners = surface->mesh.corner_count;
    const norma_attribute normal = {.data = split->normals,
                              .count = split->count,
                              .corners = split->corners},
                          texcoord = {.data = surface->normal_map.texcoords,
                              .count = surface->mesh.positions.count,
                              .of = NORMA_PER_VERTEX};
    const norma_options options = {.struct_size = sizeof options, .threads = NORMA_ALL_THREADS};
    if (norma_corner_tangents(&surface->mesh, &normal, &texcoord, NORMA_TANGENTS_MIKK, &options,
            tangents, corners, NULL))
        memset(tangents, 0, 4 * corners * sizeof *tangents);
    for (size_t i = 0; i < corners; ++i) tangents[4 * i + 3] *= -1;
}

/* The tangents of a normal map, four for each corner, for texture coordinates whose v runs
 * downwards: the file's, or MikkTSpace's. Owned by the caller; NULL: out of memory. */
static float *find_tangents(const render_surface *surface, const render_split *split) {
    float *tangents = malloc((4 * surface->mesh.corner_count + 1) * sizeof *tangents);
    if (!tangents) return NULL;
    if (surface->tangents)
        copy_stored(surface, tangents);
    else
        compute_mikk(surface, split, tangents);
    return tangents;
}

/* ---- A surface made ready for the graphics processor: indexed triangles where
 * vertices can be shared, three vertices each where they cannot. */

void render_vertices_free(render_vertices *vertices) {
    free(vertices->positions);
    free(vertices->normals);
    free(vertices->colours);
    free(vertices->values);
    free(vertices->texcoords);
    free(vertices->tangents);
    free(vertices->indices);
    free(vertices->kept);
    *vertices = (render_vertices){0};
}

/* What making vertices works with. */
typedef struct maker {
    const render_surface *surface;
    const norma_mesh *mesh;
    render_vertices *out;
    uint32_t *triangles; /* corner numbers; NULL: 0, 1, 2, ... */
    size_t triangle_count;
    render_split split;
} maker;

static uint32_t triangle_corner(const maker *m, size_t k) {
    return m->triangles ? m->triangles[k] : (uint32_t)k;
}

static int allocate_vertices(maker *m, size_t vertices, int with_indices) {
    render_vertices *out = m->out;
    out->positions = malloc((3 * vertices + 1) * sizeof *out->positions);
    out->normals = malloc((3 * vertices + 1) * sizeof *out->normals);
    if (with_indices) out->indices = malloc((3 * m->triangle_count + 1) * sizeof *out->indices);
    if (m->surface->colours || m->surface->face_marks || m->surface->corner_marks)
        out->colours = malloc((4 * vertices + 1) * sizeof *out->colours);
    return out->positions && out->normals && (out->indices || !with_indices) &&
           (out->colours ||
               !(m->surface->colours || m->surface->face_marks || m->surface->corner_marks));
}

/* The part of a vertex that its position decides. A position that is not finite is left at the
 * origin; no triangle uses it. */
static void place_vertex(const maker *m, uint32_t position, size_t vertex) {
    double p[3];
    float *out = m->out->positions + 3 * vertex;
    out[0] = out[1] = out[2] = 0;
    if (render_position(m->mesh, position, p)) render_into_box(&m->out->box, p, out);
    if (m->out->colours && m->surface->colours)
        memcpy(m->out->colours + 4 * vertex, m->surface->colours + (size_t)4 * position,
            4 * sizeof(float));
    else if (m->out->colours)
        for (int k = 0; k < 4; ++k) m->out->colours[4 * vertex + (size_t)k] = 1;
}

static int triangle_is_finite(const maker *m, size_t triangle) {
    double p[3];
    for (size_t k = 0; k < 3; ++k)
        if (!render_position(
                m->mesh, norma_mesh_corner(m->mesh, triangle_corner(m, 3 * triangle + k)), p))
            return 0;
    return 1;
}

/* ---- shared vertices */

static int all_finite(const norma_mesh *mesh) {
    double p[3];
    for (size_t i = 0; i < mesh->positions.count; ++i)
        if (!render_position(mesh, (uint32_t)i, p)) return 0;
    return 1;
}

static enum render_result make_smooth(maker *m, render_error *error) {
    render_vertices *out = m->out;
    if (!allocate_vertices(m, m->split.count, 1)) return render_fail_memory(error);
    const int finite = all_finite(m->mesh);
    out->count = m->split.count;
    for (size_t i = 0; i < out->count; ++i)
        place_vertex(m, m->split.sources ? m->split.sources[i] : (uint32_t)i, i);
    memcpy(out->normals, m->split.normals, 3 * out->count * sizeof *out->normals);
    for (size_t t = 0; t < m->triangle_count; ++t) {
        if (!finite && !triangle_is_finite(m, t)) continue;
        for (size_t k = 0; k < 3; ++k)
            out->indices[out->index_count++] = m->split.corners[triangle_corner(m, 3 * t + k)];
    }
    return RENDER_OK;
}

/* ---- one normal for each face, in the last vertex of each of its triangles */

enum { NO_FACE = -1 };

/* Turns a triangle so that its last vertex is free, or its face's already; a fourth vertex is made
 * where none is. owner: the face of each vertex, from 1 up; 0: free. */
static void add_faceted(
    maker *m, uint32_t *owner, uint32_t face, const uint32_t v[3], const float normal[3]) {
    render_vertices *out = m->out;
    int last = NO_FACE;
    for (int k = 2; k >= 0 && last == NO_FACE; --k)
        if (owner[v[k]] == 0 || owner[v[k]] == face + 1) last = k;
    uint32_t bearer = last == NO_FACE ? (uint32_t)out->count : v[last];
    if (last == NO_FACE) {
        last = 2;
        memcpy(out->positions + 3 * out->count, out->positions + (size_t)3 * v[2], 12);
        if (out->colours)
            memcpy(out->colours + 4 * out->count, out->colours + (size_t)4 * v[2], 16);
        ++out->count;
    }
    owner[bearer] = face + 1;
    memcpy(out->normals + (size_t)3 * bearer, normal, 12);
    out->indices[out->index_count++] = v[(last + 1) % 3];
    out->indices[out->index_count++] = v[(last + 2) % 3];
    out->indices[out->index_count++] = bearer;
}

static void make_faceted_triangles(maker *m, uint32_t *owner, const float *normals) {
    const int finite = all_finite(m->mesh);
    size_t t = 0;
    for (size_t face = 0; face < render_face_count(m->mesh); ++face) {
        size_t first, corners;
        render_face(m->mesh, face, &first, &corners);
        for (size_t i = 2; i < corners; ++i, ++t) {
            uint32_t v[3];
            if (!finite && !triangle_is_finite(m, t)) continue;
            for (size_t k = 0; k < 3; ++k)
                v[k] = norma_mesh_corner(m->mesh, triangle_corner(m, 3 * t + k));
            add_faceted(m, owner, (uint32_t)face, v, normals + 3 * face);
        }
    }
}

static enum render_result make_faceted(maker *m, render_error *error) {
    const size_t positions = m->mesh->positions.count, most = positions + m->triangle_count;
    uint32_t *owner = calloc(most + 1, sizeof *owner);
    float *normals = NULL;
    norma_result result = allocate_vertices(m, most, 1) && owner ? face_normals(m->mesh, &normals)
                                                                 : NORMA_ERROR_MEMORY;
    if (!result) {
        m->out->count = positions;
        for (size_t i = 0; i < positions; ++i) place_vertex(m, (uint32_t)i, i);
        memset(m->out->normals, 0, 3 * positions * sizeof *m->out->normals);
        make_faceted_triangles(m, owner, normals);
    }
    free(owner);
    free(normals);
    return render_fail_core(result, error);
}

/* ---- three vertices for each triangle. Marks are colours as they are, what is not marked has the
 * surface's: such vertices are drawn with a base colour of 1 */

static void mark(const maker *m, size_t face, uint32_t corner, size_t vertex) {
    uint32_t colour = m->surface->corner_marks ? m->surface->corner_marks[corner] : 0;
    if (!colour && m->surface->face_marks) colour = m->surface->face_marks[face];
    for (int k = 0; k < 3; ++k) {
        float *level = &m->out->colours[4 * vertex + (size_t)k];
        *level = colour ? render_linear(colour >> (16 - 8 * k) & 0xFF)
                        : *level * m->surface->base_colour[k];
    }
}

static void copy_texcoords(const render_texture *map, uint32_t position, float out[2]) {
    out[0] = map->texcoords ? map->texcoords[(size_t)2 * position] : 0;
    out[1] = map->texcoords ? map->texcoords[(size_t)2 * position + 1] : 0;
}

/* What faces and corners have, each where it is wanted: normals of their own, tangents, degrees. */
typedef struct corner_data {
    const float *face_normals, *tangents, *values;
    int marked;
} corner_data;

static void unroll_corner(maker *m, const corner_data *of, size_t face, uint32_t corner) {
    render_vertices *out = m->out;
    const uint32_t position = norma_mesh_corner(m->mesh, corner);
    const size_t vertex = out->count++;
    place_vertex(m, position, vertex);
    memcpy(out->normals + 3 * vertex,
        of->face_normals ? of->face_normals + 3 * face
                         : m->split.normals + (size_t)3 * m->split.corners[corner],
        12);
    if (out->texcoords) {
        copy_texcoords(&m->surface->mask, position, out->texcoords + 4 * vertex);
        copy_texcoords(&m->surface->normal_map, position, out->texcoords + 4 * vertex + 2);
    }
    if (of->tangents) memcpy(out->tangents + 4 * vertex, of->tangents + (size_t)4 * corner, 16);
    if (of->values) {
        out->values[vertex] = of->values[corner];
        out->uncompared |= of->values[corner] < 0;
    }
    if (of->marked && out->colours) mark(m, face, corner, vertex);
}

static void unroll(maker *m, const corner_data *of) {
    const int finite = all_finite(m->mesh);
    size_t t = 0;
    for (size_t face = 0; face < render_face_count(m->mesh); ++face) {
        size_t first, corners;
        render_face(m->mesh, face, &first, &corners);
        for (size_t i = 2; i < corners; ++i, ++t)
            if (finite || triangle_is_finite(m, t))
                for (size_t k = 0; k < 3; ++k)
                    unroll_corner(m, of, face, triangle_corner(m, 3 * t + k));
    }
}

static enum render_result make_unrolled(maker *m, enum render_kind kind, render_error *error) {
    render_vertices *out = m->out;
    const render_surface *surface = m->surface;
    const size_t vertices = 3 * m->triangle_count;
    const int flat = kind == RENDER_MAPPED_FLAT, mapped = kind >= RENDER_MAPPED,
              bent = kind == RENDER_MAPPED && (surface->normal_map.texcoords || surface->tangents);
    float *normals = NULL, *tangents = NULL, *values = NULL;
    int ready = allocate_vertices(m, vertices, 0);
    if (flat) ready = ready && !face_normals(m->mesh, &normals);
    if (mapped) out->texcoords = malloc((4 * vertices + 1) * sizeof *out->texcoords);
    if (bent) out->tangents = malloc((4 * vertices + 1) * sizeof *out->tangents);
    if (bent) tangents = find_tangents(surface, &m->split);
    if (kind == RENDER_ERRORS) {
        values = render_errors(surface->stored_surface ? surface->stored_surface : surface,
            &out->worst_error_rad, &out->most_errors_rad);
        out->values = malloc((vertices + 1) * sizeof *out->values);
    }
    ready = ready && (out->texcoords || !mapped) && ((tangents && out->tangents) || !bent) &&
            ((values && out->values) || kind != RENDER_ERRORS);
    if (ready) unroll(m, &(corner_data){normals, tangents, values, kind == RENDER_MARKED});
    free(normals);
    free(tangents);
    free(values);
    return ready ? RENDER_OK : render_fail_memory(error);
}

/* ---- what a camera has to show: positions that nothing uses may lie anywhere */

static int find_points(render_vertices *v) {
    uint8_t *used = v->indices ? calloc(v->count + 1, 1) : NULL;
    size_t count = 0;
    v->points = v->positions;
    v->point_count = v->count;
    if (!v->indices) return 1;
    for (size_t i = 0; used && i < v->index_count; ++i) {
        count += !used[v->indices[i]];
        used[v->indices[i]] = 1;
    }
    if (used && count < v->count && (v->kept = malloc((3 * count + 1) * sizeof *v->kept))) {
        v->points = v->kept;
        v->point_count = 0;
        for (size_t i = 0; i < v->count; ++i)
            if (used[i]) memcpy(v->kept + 3 * v->point_count++, v->positions + 3 * i, 12);
    }
    const int good = used && (count == v->count || v->kept);
    free(used);
    return good;
}

static const size_t most_numbers =
    UINT32_MAX / 4; /* so that every vertex that is made has a number */

static int corners_are_in_range(const norma_mesh *mesh) {
    for (size_t i = 0; i < mesh->corner_count; ++i)
        if (norma_mesh_corner(mesh, i) >= mesh->positions.count) return 0;
    return 1;
}

enum render_result render_vertices_make(const render_surface *surface, enum render_kind kind,
    render_vertices *vertices, render_error *error) {
    maker m = {.surface = surface, .mesh = &surface->mesh, .out = vertices};
    *vertices = (render_vertices){.worst_error_rad = NAN};
    if (!corners_are_in_range(m.mesh))
        return render_fail(error, RENDER_ERROR_ARGUMENT, "a corner names no position");
    if (m.mesh->positions.count > most_numbers || m.mesh->corner_count > most_numbers)
        return render_fail(error, RENDER_ERROR_ARGUMENT, "more vertices than can be drawn at once");
    vertices->box = render_box_of(m.mesh);
    enum render_result result = triangulate(m.mesh, &m.triangles, &m.triangle_count, error);
    if (!result && kind != RENDER_FACETED) result = render_split_make(surface, &m.split, error);
    if (!result)
        result = kind == RENDER_SMOOTH    ? make_smooth(&m, error)
                 : kind == RENDER_FACETED ? make_faceted(&m, error)
                                          : make_unrolled(&m, kind, error);
    if (!result && !find_points(vertices)) result = render_fail_memory(error);
    render_split_free(&m.split);
    free(m.triangles);
    if (result) render_vertices_free(vertices);
    return result;
}

/* ---- Hedgehog lines: from each vertex along its normal, from each face's middle along its own,
 * and from points on edges along the interpolated one (Phong 1975); each as long as the edges about
 * it are. And each edge of a polygon once, for a wireframe. */

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

/* Of candidates with so many lines each; most: of candidates, 0: all. */
static int make_room_for_lines(liner *l, size_t candidates, size_t most, size_t each) {
    l->step = most > 0 ? (candidates + most - 1) / most : 1;
    l->step = l->step > 0 ? l->step : 1;
    size_t kept = (candidates + l->step - 1) / l->step;
    l->set->floats = malloc((kept + 1) * each * RENDER_LINE_FLOATS * sizeof(float));
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
    const int ready =
        lengths.sums && lengths.counts && make_room_for_lines(l, split->count, most, 1);
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
    float *normals = NULL;
    const int ready = make_room_for_lines(l, faces, most, 1) && !face_normals(l->mesh, &normals);
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
    if (!make_room_for_lines(l, l->mesh->corner_count, most / EDGE_STEPS + 1, EDGE_STEPS)) return 0;
    each_edge(l, add_interpolated, &along);
    return 1;
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
    const int ready = table.starts && table.others && make_room_for_lines(l, corners, 0, 1);
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
    if (!l->set->colours || !make_room_for_lines(l, surface->dot_count, 0, 1)) return 0;
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
