/* steady_faces.c: of each face the direction in which the first texture coordinate grows, and the
 * sign of its texture area. For a polygon both are means over its area in texture space: by Green's
 * theorem, sums over its edges. And what the face adds at each of its corners. */
#include "core/face/face_geometry.h"
#include "core/face/reflex.h"
#include "core/face/triangle.h"
#include "core/tangent/steady.h"
#include "core/tangent/steady_lanes.h"
#include <math.h>

enum { FACES_IN_TASK = 1 << 12 };

typedef struct steady_face {
    double along[3];  /* unit: where the first texture coordinate grows */
    double normal[3]; /* twice the vector area */
    double twice_area;
} steady_face;

typedef struct face_corners {
    const tangent_mesh *mesh;
    size_t first, count, start; /* start: where the least rotation begins */
} face_corners;

static const tangent_vertex *corner_at(const face_corners *f, size_t index) {
    size_t place = f->start + index;
    if (place >= f->count) place -= f->count;
    return &f->mesh->vertices[norma_core_tangent_key(f->mesh, f->first + place)];
}

/* -1, 0 or 1, by position, normal and texture coordinates. */
static int compare(const tangent_vertex *a, const tangent_vertex *b) {
    float x[8], y[8];
    memcpy(x, a, sizeof x);
    memcpy(y, b, sizeof y);
    for (int k = 0; k < 8; k++)
        if (x[k] != y[k]) return x[k] < y[k] ? -1 : 1;
    return 0;
}

/* The least rotation of a sequence, in linear time: two candidates run side by side, and the loser
 * skips all that was compared. */
static size_t least_rotation(const face_corners *f) {
    size_t i = 0, j = 1, same = 0;
    while (i < f->count && j < f->count && same < f->count) {
        const int order =
            compare(corner_at(f, (i + same) % f->count), corner_at(f, (j + same) % f->count));
        if (!order) {
            same++;
            continue;
        }
        if (order > 0)
            i += same + 1;
        else
            j += same + 1;
        if (i == j) j++;
        same = 0;
    }
    return i < j ? i : j;
}

static void difference(const float *a, const float *b, int count, double *out) {
    for (int k = 0; k < count; k++) out[k] = (double)a[k] - (double)b[k];
}

typedef struct face_sums {
    double area, magnitude; /* of the texture, twice; of the products in it */
    double along[3], normal[3];
} face_sums;

/* The triangle between the first corner and two that follow each other. */
static void add_triangle(face_sums *sums, const tangent_vertex *origin, const tangent_vertex *a,
    const tangent_vertex *b) {
    double p[3], q[3], s[2], t[2], cross[3];
    difference(a->position, origin->position, 3, p);
    difference(b->position, origin->position, 3, q);
    difference(a->texcoord, origin->texcoord, 2, s);
    difference(b->texcoord, origin->texcoord, 2, t);
    norma_core_cross(p, q, cross);
    sums->area += s[0] * t[1] - s[1] * t[0];
    sums->magnitude += fabs(s[0] * t[1]) + fabs(s[1] * t[0]);
    for (int k = 0; k < 3; k++) {
        sums->along[k] += t[1] * p[k] - s[1] * q[k];
        sums->normal[k] += cross[k];
    }
}

static int is_finite(const face_corners *f) {
    for (size_t i = 0; i < f->count; i++)
        if (!norma_core_tangent_is_finite(corner_at(f, i))) return 0;
    return 1;
}

static int8_t measure(const face_corners *f, steady_face *face) {
    face_sums sums = {0};
    const tangent_vertex *origin = corner_at(f, 0);
    for (size_t i = 1; i + 1 < f->count; i++)
        add_triangle(&sums, origin, corner_at(f, i), corner_at(f, i + 1));
    memcpy(face->normal, sums.normal, sizeof face->normal);
    face->twice_area = steady_length(sums.normal);
    if (!(fabs(sums.area) > STEADY_ROUNDING * sums.magnitude) || !(face->twice_area > 0)) return 0;
    for (int k = 0; k < 3; k++) face->along[k] = sums.area < 0 ? -sums.along[k] : sums.along[k];
    steady_normalise(face->along, face->along);
    if (steady_length(face->along) == 0) return 0;
    return sums.area < 0 ? -1 : 1;
}

/* ---- what a corner adds */

static void position_of(const steady_mesh *m, size_t corner, double out[3]) {
    const float *p = m->input->vertices[norma_core_tangent_key(m->input, corner)].position;
    for (int k = 0; k < 3; k++) out[k] = (double)p[k];
}

typedef struct face_points {
    const steady_mesh *mesh;
    size_t first;
} face_points;

static void point_of(const void *context, size_t index, double point[3]) {
    const face_points *face = context;
    position_of(face->mesh, face->first + index, point);
}

/* As the corner's weight for normals has it; cross: of its edges. */
static int is_reflex(const steady_mesh *m, const steady_face *face, size_t number, size_t corner,
    const double cross[3]) {
    const core_mesh *mesh = &m->input->mesh;
    const face_points points = {m, norma_core_face_begin(mesh, number)};
    const double along = norma_core_dot(cross, face->normal),
                 lengths = steady_length(cross) * face->twice_area;
    double here[3], next[3], previous[3];
    if (lengths == 0 || fabs(along) > 0x1p-20 * lengths) return along < 0;
    position_of(m, corner, here);
    position_of(m, norma_core_next_in_face(mesh, number, corner), next);
    position_of(m, norma_core_previous_in_face(mesh, number, corner), previous);
    return norma_core_turns_back(
        point_of, &points, norma_core_face_end(mesh, number) - points.first, here, next, previous);
}

static double weight_of(
    const steady_mesh *m, const steady_face *face, size_t number, size_t corner) {
    const core_mesh *mesh = &m->input->mesh;
    double at[3], a[3], b[3], cross[3];
    position_of(m, corner, at);
    position_of(m, norma_core_next_in_face(mesh, number, corner), a);
    position_of(m, norma_core_previous_in_face(mesh, number, corner), b);
    norma_core_subtract(a, at, a);
    norma_core_subtract(b, at, b);
    norma_core_cross(a, b, cross);
    return norma_core_weigh(m->call->options.weight, norma_core_dot(a, a), norma_core_dot(b, b),
        norma_core_dot(a, b), steady_length(cross), face->twice_area,
        mesh->face_starts && is_reflex(m, face, number, corner, cross));
}

static steady_part part_of(
    const steady_mesh *m, const steady_face *face, size_t number, size_t corner) {
    const float *n = m->input->vertices[norma_core_tangent_key(m->input, corner)].normal;
    const double given[3] = {(double)n[0], (double)n[1], (double)n[2]};
    double normal[3];
    steady_part part = {0};
    steady_normalise(given, normal);
    if (!steady_make_perpendicular(face->along, normal, part.sum)) return part;
    part.weight = weight_of(m, face, number, corner);
    for (int k = 0; k < 3; k++) part.sum[k] *= part.weight;
    return part;
}

/* ---- faces */

static void add_face(const steady_mesh *m, size_t number) {
    const core_mesh *mesh = &m->input->mesh;
    const size_t first = norma_core_face_begin(mesh, number),
                 count = norma_core_face_end(mesh, number) - first;
    face_corners f = {m->input, first, count, 0};
    steady_face face;
    m->signs[number] = 0;
    if (count < 3 || !is_finite(&f)) return;
    f.start = least_rotation(&f);
    m->signs[number] = measure(&f, &face);
    for (size_t c = first; c < first + count && m->signs[number]; c++)
        m->parts[c] = part_of(m, &face, number, c);
}

/* Nearly always the first number of one position is less than those of the two others. */
static size_t start_of_triangle(const face_corners *f, const tangent_vertex *const v[3]) {
    const float a = v[0]->position[0], b = v[1]->position[0], c = v[2]->position[0];
    return a < b && a < c   ? 0
           : b < a && b < c ? 1
           : c < a && c < b ? 2
           : is_finite(f)   ? least_rotation(f)
                            : 0;
}

/* Returns where its least rotation starts. */
static size_t load(const steady_mesh *m, size_t triangle, int lane, steady_batch *batch) {
    const face_corners f = {m->input, 3 * triangle, 3, 0};
    const tangent_vertex *const v[3] = {corner_at(&f, 0), corner_at(&f, 1), corner_at(&f, 2)};
    const size_t start = start_of_triangle(&f, v);
    for (size_t i = 0; i < 3; i++) {
        const tangent_vertex *from = v[(start + i) % 3];
        for (int k = 0; k < 3; k++) batch->position[i][k][lane] = (double)from->position[k];
        for (int k = 0; k < 3; k++) batch->normal[i][k][lane] = (double)from->normal[k];
        for (int k = 0; k < 2; k++) batch->texcoord[i][k][lane] = (double)from->texcoord[k];
    }
    return start;
}

static void store(
    const steady_mesh *m, size_t triangle, int lane, size_t start, const steady_addends *addends) {
    m->signs[triangle] = (int8_t)addends->sign[lane];
    for (size_t i = 0; i < 3; i++)
        m->parts[3 * triangle + (start + i) % 3] = (steady_part){
            {addends->sum[i][0][lane], addends->sum[i][1][lane], addends->sum[i][2][lane]},
            addends->weight[i][lane]};
}

static void add_triangles(const steady_mesh *m, size_t begin, size_t end) {
    steady_kernel *kernel = norma_core_steady_kernel(m->call->options.isa);
    steady_batch batch;
    steady_addends out;
    size_t starts[STEADY_LANES];
    memset(&batch, 0, sizeof batch);
    for (size_t t = begin; t < end; t += STEADY_LANES) {
        const int count = end - t < STEADY_LANES ? (int)(end - t) : STEADY_LANES;
        for (int l = 0; l < count; l++) {
            norma_core_tangent_await(m->input, t + (size_t)l + TANGENT_FACES_AHEAD);
            starts[l] = load(m, t + (size_t)l, l, &batch);
        }
        kernel(&batch, m->call->options.weight, &out);
        for (int l = 0; l < count; l++)
            if (out.is_sure[l] > 0)
                store(m, t + (size_t)l, l, starts[l], &out);
            else
                add_face(m, t + (size_t)l);
    }
}

static void face_task(void *context, size_t task) {
    const steady_mesh *m = context;
    const core_mesh *mesh = &m->input->mesh;
    const size_t begin = task * FACES_IN_TASK, end = mesh->face_count - begin < FACES_IN_TASK
                                                         ? mesh->face_count
                                                         : begin + FACES_IN_TASK;
    const size_t last = norma_core_face_begin(mesh, end);
    for (size_t c = norma_core_face_begin(mesh, begin); c < last && !m->input->known; c++)
        m->vertex_of[c] = norma_core_tangent_vertex(m->input, c);
    if (!mesh->face_starts) {
        add_triangles(m, begin, end);
        return;
    }
    for (size_t face = begin; face < end; face++) {
        norma_core_tangent_await(m->input, face + TANGENT_FACES_AHEAD);
        add_face(m, face);
    }
}

norma_result norma_core_steady_faces(steady_mesh *m) {
    const size_t count = m->input->mesh.face_count;
    return norma_core_parallel(
        m->call, count / FACES_IN_TASK + (count % FACES_IN_TASK != 0), face_task, m);
}
