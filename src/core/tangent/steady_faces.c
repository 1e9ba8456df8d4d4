/* steady_faces.c: of each face the direction in which the first texture coordinate grows, and the
 * sign of its texture area. For a polygon both are means over its area in texture space: by Green's
 * theorem, sums over its edges. */
#include "core/face/face_geometry.h"
#include "core/tangent/steady.h"
#include <math.h>

enum { FACES_IN_TASK = 1 << 12 };

/* Texture areas below this part of the products that they are differences of are rounding. */
static const double ROUNDING = 0x1p-50;

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
    if (!(fabs(sums.area) > ROUNDING * sums.magnitude) || !(face->twice_area > 0)) return 0;
    for (int k = 0; k < 3; k++) face->along[k] = sums.area < 0 ? -sums.along[k] : sums.along[k];
    steady_normalise(face->along, face->along);
    if (steady_length(face->along) == 0) return 0;
    return sums.area < 0 ? -1 : 1;
}

static void face_task(void *context, size_t task) {
    const steady_mesh *m = context;
    const core_mesh *mesh = &m->input->mesh;
    const size_t begin = task * FACES_IN_TASK, end = mesh->face_count - begin < FACES_IN_TASK
                                                         ? mesh->face_count
                                                         : begin + FACES_IN_TASK;
    for (size_t face = begin; face < end; face++) {
        norma_core_tangent_await(m->input, face + TANGENT_FACES_AHEAD);
        const size_t first = norma_core_face_begin(mesh, face),
                     count = norma_core_face_end(mesh, face) - first;
        face_corners f = {m->input, first, count, 0};
        for (size_t c = first; c < first + count && !m->input->known; c++)
            m->vertex_of[c] = norma_core_tangent_vertex(m->input, c);
        m->faces[face] = (steady_face){0};
        m->signs[face] = 0;
        if (count < 3 || !is_finite(&f)) continue;
        f.start = least_rotation(&f);
        m->signs[face] = measure(&f, &m->faces[face]);
    }
}

norma_result norma_core_steady_faces(steady_mesh *m) {
    const size_t count = m->input->mesh.face_count;
    return norma_core_parallel(
        m->call, count / FACES_IN_TASK + (count % FACES_IN_TASK != 0), face_task, m);
}
