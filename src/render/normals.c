/* normals.c: the normals that a picture draws of a surface: the stored ones, or computed ones where
 * there are none; by how much they differ; and those of several surfaces that make up one body. */
#include "render/parts.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- a norma_mesh corner by corner */

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

/* Room for as many vertices; sources: those have numbers of their own. */
static int allocate_split(render_split *split, size_t corners, size_t vertices, int sources) {
    split->corners = malloc((corners + 1) * sizeof *split->corners);
    split->normals = malloc((3 * vertices + 1) * sizeof *split->normals);
    if (sources) split->sources = malloc((vertices + 1) * sizeof *split->sources);
    return split->corners && split->normals && (split->sources || !sources);
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
    if (!allocate_split(split, mesh->corner_count, count, 0)) return render_fail_memory(error);
    copy_corners(mesh, split->corners);
    if (surface->stored == RENDER_NORMALS_PER_VERTEX) {
        for (size_t i = 0; i < count; ++i)
            read_normal(&surface->normals, i, split->normals + 3 * i);
        return RENDER_OK;
    }
    const norma_options options = usual(surface);
    norma_result result = norma_vertex_normals(mesh, &options, split->normals, count, NULL);
    return render_fail_core(result, error);
}

/* ---- normals that a crease parts */

static enum render_result computed(
    const render_surface *surface, render_split *split, render_error *error) {
    const norma_mesh *mesh = &surface->mesh;
    const norma_options options = usual(surface);
    const size_t most = mesh->corner_count;
    if (!allocate_split(split, most, most, 1)) return render_fail_memory(error);
    norma_result result = norma_split(mesh, (float)surface->crease_rad, &options, split->corners,
        most, split->sources, split->normals, most, &split->count, NULL);
    return render_fail_core(result, error);
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
    const int ready =
        allocate_split(split, most, most, 1) && j.first && j.next && (missing || !compute);
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
    return render_fail_core(result, error);
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

float *render_errors(const render_surface *surface, double *worst_rad, double *most_rad) {
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

/* ---- The normals of several surfaces that make up one body, such as the primitives of a glTF
 * mesh: computed as one mesh, told surface by surface. */

typedef struct body {
    double *positions;
    uint32_t *corners, *starts;
    size_t position_count, corner_count, face_count;
    float *normals;
} body;

static int allocate_body(const render_surface *surfaces, size_t count, body *b) {
    size_t positions = 0, corners = 0, faces = 0;
    for (size_t i = 0; i < count; ++i) {
        positions += surfaces[i].mesh.positions.count;
        corners += surfaces[i].mesh.corner_count;
        faces += render_face_count(&surfaces[i].mesh);
    }
    if (positions > UINT32_MAX / 2 || corners > UINT32_MAX / 2) return 0;
    b->positions = malloc((3 * positions + 1) * sizeof *b->positions);
    b->corners = malloc((corners + 1) * sizeof *b->corners);
    b->starts = malloc((faces + 1) * sizeof *b->starts);
    b->normals = malloc((3 * corners + 1) * sizeof *b->normals);
    return b->positions && b->corners && b->starts && b->normals;
}

static void append_to_body(body *b, const norma_mesh *mesh) {
    const size_t base = b->position_count;
    for (size_t i = 0; i < mesh->positions.count; ++i)
        render_position(mesh, (uint32_t)i, b->positions + 3 * b->position_count++);
    for (size_t face = 0; face < render_face_count(mesh); ++face) {
        size_t first, count;
        render_face(mesh, face, &first, &count);
        b->starts[b->face_count++] = (uint32_t)b->corner_count;
        for (size_t i = 0; i < count; ++i)
            b->corners[b->corner_count++] = (uint32_t)base + norma_mesh_corner(mesh, first + i);
    }
    b->starts[b->face_count] = (uint32_t)b->corner_count;
}

static norma_result compute_body_normals(const render_surface *like, body *b) {
    const norma_options options = {.struct_size = sizeof options,
        .weight = like->weight,
        .fallback = NORMA_FALLBACK_NEAREST,
        .threads = NORMA_ALL_THREADS};
    const norma_mesh mesh = {.positions = {.data = b->positions,
                                 .count = b->position_count,
                                 .format = NORMA_FORMAT_DOUBLE},
        .corners = b->corners,
        .corner_count = b->corner_count,
        .face_starts = b->starts,
        .face_count = b->face_count};
    return norma_corner_normals(
        &mesh, (float)like->crease_rad, &options, b->normals, b->corner_count, NULL);
}

enum render_result render_expect(
    render_surface *surfaces, size_t count, float **normals, render_error *error) {
    body b = {0};
    norma_result result = allocate_body(surfaces, count, &b) ? NORMA_OK : NORMA_ERROR_MEMORY;
    for (size_t i = 0; i < count && !result; ++i) {
        surfaces[i].expected = b.normals + 3 * b.corner_count;
        append_to_body(&b, &surfaces[i].mesh);
    }
    if (!result) result = compute_body_normals(&surfaces[0], &b);
    free(b.positions);
    free(b.corners);
    free(b.starts);
    if (!result)
        *normals = b.normals;
    else
        free(b.normals);
    return render_fail_core(result, error);
}
