/* surface_vertices.c: the vertices that a picture draws of a mesh: split where normals differ, and
 * with the attributes of their corners. */
#include "render/surface/surface_vertices.h"
#include "core/face/cut_polygon.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- Which vertices a surface needs so that each has one normal: the stored normals,
 * or computed ones where there are none. */

void render_split_free(render_split *split) {
    free(split->sources);
    free(split->corners);
    free(split->normals);
    *split = (render_split){0};
}

static void read_normal(const norma_vec3_view *view, size_t index, float n[3]) {
    memcpy(n, (const unsigned char *)view->data + index * (view->stride ? view->stride : 12), 12);
    for (int k = 0; k < 3; ++k)
        if (!isfinite(n[k])) n[0] = n[1] = n[2] = 0;
}

static norma_options usual(const render_surface *surface) {
    return (norma_options){.struct_size = sizeof(norma_options),
        .weight = surface->weight,
        .fallback = NORMA_FALLBACK_NEAREST,
        .threads = NORMA_ALL_THREADS};
}

static enum render_result fail_core(norma_result result, render_error *error) {
    return result == NORMA_ERROR_MEMORY
               ? render_fail_memory(error)
               : render_fail(error, RENDER_ERROR_ARGUMENT, "%s", norma_result_text(result));
}

/* ---- one normal for each position */

static void copy_corners(const norma_mesh *mesh, uint32_t *corners) {
    if (mesh->corners && mesh->corner_size != 1 && mesh->corner_size != 2)
        memcpy(corners, mesh->corners, mesh->corner_count * sizeof *corners);
    else
        for (size_t i = 0; i < mesh->corner_count; ++i) corners[i] = norma_mesh_corner(mesh, i);
}

static enum render_result one_each(
    const render_surface *surface, render_split *split, render_error *error) {
    const norma_mesh *mesh = &surface->mesh;
    const size_t count = mesh->positions.count;
    split->count = count;
    split->corners = malloc((mesh->corner_count + 1) * sizeof *split->corners);
    split->normals = malloc((3 * count + 1) * sizeof *split->normals);
    if (!split->corners || !split->normals) return render_fail_memory(error);
    copy_corners(mesh, split->corners);
    if (surface->stored == RENDER_NORMALS_PER_VERTEX) {
        for (size_t i = 0; i < count; ++i)
            read_normal(&surface->normals, i, split->normals + 3 * i);
        return RENDER_OK;
    }
    const norma_options options = usual(surface);
    norma_result result = norma_vertex_normals(mesh, &options, split->normals, count, NULL);
    return result ? fail_core(result, error) : RENDER_OK;
}

/* ---- normals that a crease parts */

static enum render_result computed(
    const render_surface *surface, render_split *split, render_error *error) {
    const norma_mesh *mesh = &surface->mesh;
    const norma_options options = usual(surface);
    const size_t most = mesh->corner_count;
    split->corners = malloc((most + 1) * sizeof *split->corners);
    split->sources = malloc((most + 1) * sizeof *split->sources);
    split->normals = malloc((3 * most + 1) * sizeof *split->normals);
    if (!split->corners || !split->sources || !split->normals) return render_fail_memory(error);
    norma_result result = norma_split(mesh, (float)surface->crease_rad, &options, split->corners,
        most, split->sources, split->normals, most, &split->count, NULL);
    return result ? fail_core(result, error) : RENDER_OK;
}

/* ---- stored normals of corners or facets: corners at one position with one normal become a vertex
 */

typedef struct joiner {
    uint32_t *first, *next; /* the vertices of each position, as a chain */
    render_split *split;
} joiner;

static uint32_t join(joiner *j, uint32_t position, const float normal[3]) {
    render_split *split = j->split;
    uint32_t at = j->first[position];
    for (int steps = 0; at != UINT32_MAX && steps < 64;
         ++steps, at = j->next[at]) /* a longer chain is rather doubled than searched */
        if (memcmp(split->normals + (size_t)3 * at, normal, 12) == 0) return at;
    at = (uint32_t)split->count++;
    split->sources[at] = position;
    memcpy(split->normals + (size_t)3 * at, normal, 12);
    j->next[at] = j->first[position];
    j->first[position] = at;
    return at;
}

static void join_corners(const render_surface *surface, const float *missing, joiner *j) {
    const norma_mesh *mesh = &surface->mesh;
    for (size_t face = 0; face < render_face_count(mesh); ++face) {
        size_t first, count;
        render_face(mesh, face, &first, &count);
        for (size_t corner = first; corner < first + count; ++corner) {
            float n[3];
            const uint32_t number = surface->stored == RENDER_NORMALS_NONE ? UINT32_MAX
                                    : surface->corner_normals ? surface->corner_normals[corner]
                                    : surface->stored == RENDER_NORMALS_PER_FACET
                                        ? (uint32_t)face
                                        : norma_mesh_corner(mesh, corner);
            if (number < surface->normals.count) read_normal(&surface->normals, number, n);
            const int stored = number < surface->normals.count &&
                               !(surface->replace_zeros && n[0] == 0 && n[1] == 0 && n[2] == 0);
            if (!stored)
                memcpy(n, missing ? missing + 3 * corner : (const float[3]){0, 0, 0}, sizeof n);
            j->split->corners[corner] = join(j, norma_mesh_corner(mesh, corner), n);
        }
    }
}

static int some_are_missing(const render_surface *surface) {
    if (surface->stored == RENDER_NORMALS_NONE || surface->replace_zeros) return 1;
    for (size_t i = 0; surface->corner_normals && i < surface->mesh.corner_count; ++i)
        if (surface->corner_normals[i] >= surface->normals.count) return 1;
    return 0;
}

static enum render_result joined(
    const render_surface *surface, render_split *split, render_error *error) {
    const norma_mesh *mesh = &surface->mesh;
    const norma_options options = usual(surface);
    const size_t most = mesh->corner_count;
    const int compute = some_are_missing(surface) && !surface->expected;
    float *missing = compute ? malloc((3 * most + 1) * sizeof *missing) : NULL;
    joiner j = {malloc((mesh->positions.count + 1) * sizeof(uint32_t)),
        malloc((most + 1) * sizeof(uint32_t)), split};
    split->corners = malloc((most + 1) * sizeof *split->corners);
    split->sources = malloc((most + 1) * sizeof *split->sources);
    split->normals = malloc((3 * most + 1) * sizeof *split->normals);
    const int ready = j.first && j.next && split->corners && split->sources && split->normals &&
                      (missing || !compute);
    norma_result result = ready ? NORMA_OK : NORMA_ERROR_MEMORY;
    if (!result && missing)
        result =
            norma_corner_normals(mesh, (float)surface->crease_rad, &options, missing, most, NULL);
    if (!result) {
        memset(j.first, 0xFF, mesh->positions.count * sizeof *j.first);
        join_corners(surface, missing ? missing : surface->expected, &j);
    }
    free(missing);
    free(j.first);
    free(j.next);
    return result ? fail_core(result, error) : RENDER_OK;
}

static const double all_angles = 3.1415926; /* a crease of so much or more parts nothing */

enum render_result render_split_make(
    const render_surface *surface, render_split *split, render_error *error) {
    *split = (render_split){0};
    enum render_result result;
    const int without = surface->stored == RENDER_NORMALS_NONE;
    if (without ? surface->expected != NULL : surface->stored != RENDER_NORMALS_PER_VERTEX)
        result = joined(surface, split, error);
    else if (!without || (surface->crease_rad >= all_angles && !surface->mesh.smoothing_groups))
        result = one_each(surface, split, error);
    else
        result = computed(surface, split, error);
    if (result) render_split_free(split);
    return result;
}

/* ---- stored against computed */

static double angle_deg(const float a[3], const float b[3]) {
    const double x[3] = {(double)a[0], (double)a[1], (double)a[2]},
                 y[3] = {(double)b[0], (double)b[1], (double)b[2]};
    const double c[3] = {
        x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]};
    return atan2(sqrt(c[0] * c[0] + c[1] * c[1] + c[2] * c[2]),
               x[0] * y[0] + x[1] * y[1] + x[2] * y[2]) *
           57.29577951308232;
}

static int compute_for_errors(const render_surface *surface, float *normals) {
    const norma_mesh *mesh = &surface->mesh;
    norma_options options = usual(surface);
    options.fallback = NORMA_FALLBACK_ZERO;
    if (surface->stored != RENDER_NORMALS_PER_VERTEX || surface->crease_rad < all_angles ||
        mesh->smoothing_groups)
        return !norma_corner_normals(
            mesh, (float)surface->crease_rad, &options, normals, mesh->corner_count, NULL);
    float *each = malloc((3 * mesh->positions.count + 1) * sizeof *each);
    const int good =
        each && !norma_vertex_normals(mesh, &options, each, mesh->positions.count, NULL);
    for (size_t i = 0; good && i < mesh->corner_count; ++i)
        memcpy(normals + 3 * i, each + (size_t)3 * norma_mesh_corner(mesh, i), 12);
    free(each);
    return good;
}

static int has_no_direction(const float n[3]) { return n[0] == 0 && n[1] == 0 && n[2] == 0; }

enum { TENTHS = 1800 };

/* To a tenth of a degree, upwards. */
static double least_of_most(const size_t histogram[TENTHS + 1], size_t count) {
    size_t seen = 0;
    for (size_t tenth = 0; tenth <= TENTHS; ++tenth)
        if ((seen += histogram[tenth]) >= count - count / 100) return 0.1 * (double)(tenth + 1);
    return 180;
}

/* Degrees between the stored and the computed normal of each corner; -1 where either is not there.
 * Owned by the caller; NULL: out of memory. *worst_rad: NaN if nothing is stored; *most_rad: what
 * 99 of 100 do not exceed. */
static float *render_errors(const render_surface *surface, double *worst_rad, double *most_rad) {
    size_t histogram[TENTHS + 1] = {0};
    const size_t count = surface->mesh.corner_count;
    size_t compared = 0;
    float *degrees = malloc((count + 1) * sizeof *degrees), *own = NULL;
    const float *expected = surface->expected;
    render_split split;
    render_error ignored;
    *worst_rad = NAN;
    *most_rad = 0;
    for (size_t i = 0; i < count && degrees; ++i) degrees[i] = -1;
    if (surface->stored == RENDER_NORMALS_NONE || !degrees) return degrees;
    if (!expected) expected = own = malloc((3 * count + 1) * sizeof *own);
    if (!expected || (own && !compute_for_errors(surface, own)) ||
        render_split_make(surface, &split, &ignored)) {
        free(degrees);
        free(own);
        return NULL;
    }
    *worst_rad = 0;
    for (size_t i = 0; i < count; ++i) {
        const float *stored = split.normals + (size_t)3 * split.corners[i];
        if (has_no_direction(stored) || has_no_direction(expected + 3 * i)) continue;
        degrees[i] = (float)angle_deg(stored, expected + 3 * i);
        *worst_rad = fmax(*worst_rad, (double)degrees[i] / 57.29577951308232);
        ++histogram[(size_t)fmin(10 * (double)degrees[i], TENTHS)];
        ++compared;
    }
    *most_rad = compared ? least_of_most(histogram, compared) / 57.29577951308232 : 0;
    free(own);
    render_split_free(&split);
    return degrees;
}

/* ---- A norma_mesh corner by corner, and the box that it lies in. */

float render_linear(uint32_t level) {
    const double c = level / 255.0;
    return (float)(c <= 0.04045 ? c / 12.92 : pow((c + 0.055) / 1.055, 2.4));
}

int render_position(const norma_mesh *mesh, uint32_t index, double p[3]) {
    norma_view_vector(&mesh->positions, index, p);
    return isfinite(p[0]) && isfinite(p[1]) && isfinite(p[2]);
}

size_t render_face_count(const norma_mesh *mesh) {
    return mesh->face_starts ? mesh->face_count : mesh->corner_count / 3;
}

void render_face(const norma_mesh *mesh, size_t face, size_t *first, size_t *count) {
    *first = mesh->face_starts ? mesh->face_starts[face] : 3 * face;
    *count = mesh->face_starts ? mesh->face_starts[face + 1] - mesh->face_starts[face] : 3;
}

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
static void compute_mikk(const render_surface *surface, const float *normals, float *tangents) {
    const size_t corners = surface->mesh.corner_count;
    const norma_attribute normal = {.data = normals, .count = corners, .of = NORMA_PER_CORNER},
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
 * downwards: the file's, or MikkTSpace's. normals: three for each corner. Owned by the caller;
 * NULL: out of memory. */
static float *find_tangents(const render_surface *surface, const float *normals) {
    float *tangents = malloc((4 * surface->mesh.corner_count + 1) * sizeof *tangents);
    if (!tangents) return NULL;
    if (surface->tangents)
        copy_stored(surface, tangents);
    else
        compute_mikk(surface, normals, tangents);
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
    const size_t positions = m->mesh->positions.count, most = positions + m->triangle_count,
                 faces = render_face_count(m->mesh);
    const norma_options options = {.struct_size = sizeof options, .threads = NORMA_ALL_THREADS};
    uint32_t *owner = calloc(most + 1, sizeof *owner);
    float *normals = malloc((3 * faces + 1) * sizeof *normals);
    const int ready = allocate_vertices(m, most, 1) && owner && normals;
    norma_result result =
        ready ? norma_face_normals(m->mesh, &options, normals, faces, NULL) : NORMA_ERROR_MEMORY;
    if (!result) {
        m->out->count = positions;
        for (size_t i = 0; i < positions; ++i) place_vertex(m, (uint32_t)i, i);
        memset(m->out->normals, 0, 3 * positions * sizeof *m->out->normals);
        make_faceted_triangles(m, owner, normals);
    }
    free(owner);
    free(normals);
    if (result == NORMA_ERROR_MEMORY) return render_fail_memory(error);
    return result ? render_fail(error, RENDER_ERROR_ARGUMENT, "%s", norma_result_text(result))
                  : RENDER_OK;
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

static void unroll(maker *m, const float *values) {
    render_vertices *out = m->out;
    size_t t = 0;
    for (size_t face = 0; face < render_face_count(m->mesh); ++face) {
        size_t first, corners;
        render_face(m->mesh, face, &first, &corners);
        for (size_t i = 2; i < corners; ++i, ++t) {
            if (!triangle_is_finite(m, t)) continue;
            for (size_t k = 0; k < 3; ++k) {
                const uint32_t corner = triangle_corner(m, 3 * t + k);
                const size_t vertex = out->count++;
                place_vertex(m, norma_mesh_corner(m->mesh, corner), vertex);
                memcpy(out->normals + 3 * vertex,
                    m->split.normals + (size_t)3 * m->split.corners[corner], 12);
                if (values) {
                    out->values[vertex] = values[corner];
                    out->uncompared |= values[corner] < 0;
                } else if (out->colours)
                    mark(m, face, corner, vertex);
            }
        }
    }
}

/* ---- the same with images */

/* Three numbers for each corner: of its vertex, or of its face. */
static int corner_normals(const maker *m, int flat, float *normals) {
    const norma_mesh *mesh = m->mesh;
    const size_t faces = render_face_count(mesh);
    const norma_options options = {.struct_size = sizeof options, .threads = NORMA_ALL_THREADS};
    float *of_faces = flat ? malloc((3 * faces + 1) * sizeof *of_faces) : NULL;
    if (flat && (!of_faces || norma_face_normals(mesh, &options, of_faces, faces, NULL))) {
        free(of_faces);
        return 0;
    }
    for (size_t face = 0; face < faces; ++face) {
        size_t first, count;
        render_face(mesh, face, &first, &count);
        for (size_t corner = first; corner < first + count; ++corner)
            memcpy(normals + 3 * corner,
                flat ? of_faces + 3 * face
                     : m->split.normals + (size_t)3 * m->split.corners[corner],
                3 * sizeof *normals);
    }
    free(of_faces);
    return 1;
}

static void copy_texcoords(const render_texture *map, uint32_t position, float out[2]) {
    out[0] = map->texcoords ? map->texcoords[(size_t)2 * position] : 0;
    out[1] = map->texcoords ? map->texcoords[(size_t)2 * position + 1] : 0;
}

static void unroll_mapped(maker *m, const float *normals, const float *tangents) {
    render_vertices *out = m->out;
    for (size_t t = 0; t < m->triangle_count; ++t) {
        if (!triangle_is_finite(m, t)) continue;
        for (size_t k = 0; k < 3; ++k) {
            const uint32_t corner = triangle_corner(m, 3 * t + k),
                           position = norma_mesh_corner(m->mesh, corner);
            const size_t vertex = out->count++;
            place_vertex(m, position, vertex);
            memcpy(out->normals + 3 * vertex, normals + (size_t)3 * corner, 12);
            copy_texcoords(&m->surface->mask, position, out->texcoords + 4 * vertex);
            copy_texcoords(&m->surface->normal_map, position, out->texcoords + 4 * vertex + 2);
            if (tangents) memcpy(out->tangents + 4 * vertex, tangents + (size_t)4 * corner, 16);
        }
    }
}

static enum render_result make_mapped(maker *m, int flat, render_error *error) {
    render_vertices *out = m->out;
    const size_t vertices = 3 * m->triangle_count;
    const int maps_normals = m->surface->normal_map.texcoords || m->surface->tangents;
    float *normals = malloc((3 * m->mesh->corner_count + 1) * sizeof *normals);
    int ready = normals && allocate_vertices(m, vertices, 0) && corner_normals(m, flat, normals);
    float *tangents = ready && maps_normals ? find_tangents(m->surface, normals) : NULL;
    out->texcoords = malloc((4 * vertices + 1) * sizeof *out->texcoords);
    if (maps_normals) out->tangents = malloc((4 * vertices + 1) * sizeof *out->tangents);
    ready = ready && out->texcoords && (!maps_normals || (tangents && out->tangents));
    if (ready) unroll_mapped(m, normals, tangents);
    free(normals);
    free(tangents);
    return ready ? RENDER_OK : render_fail_memory(error);
}

static enum render_result make_unrolled(maker *m, enum render_kind kind, render_error *error) {
    render_vertices *out = m->out;
    float *values = NULL;
    int ready = allocate_vertices(m, 3 * m->triangle_count, 0);
    if (kind == RENDER_ERRORS) {
        values = render_errors(m->surface->stored_surface ? m->surface->stored_surface : m->surface,
            &out->worst_error_rad, &out->most_errors_rad);
        out->values = malloc((3 * m->triangle_count + 1) * sizeof *out->values);
        ready = ready && values && out->values;
    }
    if (ready) unroll(m, values);
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
                 : kind >= RENDER_MAPPED  ? make_mapped(&m, kind == RENDER_MAPPED_FLAT, error)
                                          : make_unrolled(&m, kind, error);
    if (!result && !find_points(vertices)) result = render_fail_memory(error);
    render_split_free(&m.split);
    free(m.triangles);
    if (result) render_vertices_free(vertices);
    return result;
}
