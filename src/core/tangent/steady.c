/* steady.c: tangents that depend on the mesh alone, not on the order in which it is given.
 *
 * Every number is computed from a face's corners in an order of their own (the rotation that is
 * least by what the corners hold), and sums are sums of integers, so that neither the order of
 * faces nor the first corner of a face changes a bit. */
#include "core/tangent/tangents.h"
#include "core/face/face.h"
#include <math.h>

/* What a corner adds to the sum of its vertex. */
typedef struct steady_part {
    double sum[3]; /* a unit vector times the weight */
    double weight; /* 0: adds nothing */
} steady_part;

/* Texture areas below this part of the products that they are differences of are rounding. */
static const double STEADY_ROUNDING = 0x1p-50;
/* Below this part of a unit vector, what is perpendicular to the normal is rounding. */
static const double STEADY_NOTHING_LEFT = 0x1p-20;

typedef struct steady_mesh {
    core_call *call;
    const tangent_mesh *input;
    uint32_t *vertex_of; /* of each corner */
    steady_part *parts;  /* of each corner of the faces that have a sign */
    int8_t *signs;    /* of each face's texture area, 0: none, or something of it is not finite */
    uint8_t *adopted; /* NULL, or of each face without one whether the sign is negative that it
                         takes from its neighbours */
    core_corners_of_position around;
} steady_mesh;

/* norma_core_length and _normalise, without a call for nearly all vectors: those whose squares fit
 * a double. */
static inline double steady_length(const double v[3]) {
    const double square = norma_core_dot(v, v);
    return square > NORMA_TINIEST && square < NORMA_HUGEST ? sqrt(square) : norma_core_length(v);
}
static inline void steady_normalise(const double v[3], double unit[3]) {
    const double square = norma_core_dot(v, v);
    if (!(square > NORMA_TINIEST && square < NORMA_HUGEST)) {
        norma_core_normalise(v, unit);
        return;
    }
    const double inverse = 1 / sqrt(square);
    for (int k = 0; k < 3; ++k) unit[k] = v[k] * inverse;
}

static inline int steady_make_perpendicular(
    const double v[3], const double normal[3], double out[3]) {
    const double along = norma_core_dot(v, normal);
    for (int k = 0; k < 3; ++k) out[k] = v[k] - along * normal[k];
    const double length = sqrt(norma_core_dot(out, out)); /* of a part of a unit vector */
    if (!(length > STEADY_NOTHING_LEFT)) return 0;
    const double inverse = 1 / length;
    for (int k = 0; k < 3; ++k) out[k] *= inverse;
    return 1;
}

static inline void steady_position(const tangent_mesh *mesh, size_t key, double out[3]) {
    if (mesh->exact)
        memcpy(out, mesh->exact[key], sizeof mesh->exact[key]);
    else
        for (int k = 0; k < 3; ++k) out[k] = (double)mesh->vertices[key].position[k];
}

/* ---- measure_face and part_of_face, many triangles at a time, compiled for each
 * instruction set of the machine's family and chosen at run time: plain C over arrays of
 * lanes, each operation as it is for a face alone. */

enum { STEADY_LANES = 8 };
typedef double steady_lane[STEADY_LANES];

/* In: the corners of each triangle from its least rotation on. */
typedef struct steady_batch {
    _Alignas(64) steady_lane position[3][3]; /* of a corner, along an axis */
    steady_lane normal[3][3], texcoord[3][2];
} steady_batch;

/* Out: of each corner the part of its vertex's sum, of each triangle the sign. */
typedef struct steady_addends {
    _Alignas(64) steady_lane sum[3][3];
    steady_lane weight[3], sign;
    steady_lane is_sure; /* 0: squares of lengths that a double does not hold, or not finite */
} steady_addends;

typedef void steady_kernel(const steady_batch *batch, norma_weight weight, steady_addends *out);

CORE_INLINE void steady_axis_at(steady_lane const *of, int lane, double out[3]) {
    for (int k = 0; k < 3; ++k) out[k] = of[k][lane];
}
CORE_INLINE int is_held_lane(double square) {
    return (square > NORMA_TINIEST) & (square < NORMA_HUGEST);
}

/* along: unit. */
CORE_INLINE void measure_steady_lanes(const steady_batch *restrict b, steady_lane along[3],
    double *restrict twice_area, steady_addends *restrict out) {
    for (int l = 0; l < STEADY_LANES; ++l) {
        double here[3], p[3], q[3], cross[3], v[3];
        steady_axis_at(b->position[0], l, here);
        steady_axis_at(b->position[1], l, p);
        steady_axis_at(b->position[2], l, q);
        norma_core_subtract(p, here, p);
        norma_core_subtract(q, here, q);
        norma_core_cross(p, q, cross);
        const double s0 = b->texcoord[1][0][l] - b->texcoord[0][0][l],
                     s1 = b->texcoord[1][1][l] - b->texcoord[0][1][l],
                     t0 = b->texcoord[2][0][l] - b->texcoord[0][0][l],
                     t1 = b->texcoord[2][1][l] - b->texcoord[0][1][l], area = s0 * t1 - s1 * t0,
                     magnitude = fabs(s0 * t1) + fabs(s1 * t0),
                     square = norma_core_dot(cross, cross);
        for (int k = 0; k < 3; ++k) {
            const double sum = t1 * p[k] - s1 * q[k];
            v[k] = area < 0 ? -sum : sum;
        }
        const double along_square = norma_core_dot(v, v), inverse = 1 / sqrt(along_square);
        for (int k = 0; k < 3; ++k) along[k][l] = v[k] * inverse;
        twice_area[l] = sqrt(square);
        const double sign = area < 0 ? -1 : 1;
        out->sign[l] = fabs(area) > STEADY_ROUNDING * magnitude ? sign : 0;
        out->is_sure[l] = is_held_lane(square) & is_held_lane(along_square) ? 1 : 0;
    }
}

typedef struct corner_lanes {
    steady_lane aa, bb, ab, cross; /* of the edges: squares, dot product, length of the other */
    steady_lane is_there;          /* 0: what is perpendicular to the normal is rounding */
} corner_lanes;

/* Sums: not weighed yet. */
CORE_INLINE void turn_corner(const steady_batch *restrict b, steady_lane along[3], int corner,
    corner_lanes *restrict c, steady_addends *restrict out) {
    for (int l = 0; l < STEADY_LANES; ++l) {
        double n[3], v[3], here[3], next[3], previous[3], cross[3];
        steady_axis_at(b->normal[corner], l, n);
        for (int k = 0; k < 3; ++k) v[k] = along[k][l];
        const double square = norma_core_dot(n, n), inverse = 1 / sqrt(square);
        for (int k = 0; k < 3; ++k) n[k] = n[k] * inverse;
        const double by = norma_core_dot(v, n);
        for (int k = 0; k < 3; ++k) v[k] = v[k] - by * n[k];
        const double length = sqrt(norma_core_dot(v, v)), scale = 1 / length;
        for (int k = 0; k < 3; ++k) out->sum[corner][k][l] = v[k] * scale;
        c->is_there[l] = length > STEADY_NOTHING_LEFT ? 1 : 0;

        steady_axis_at(b->position[corner], l, here);
        steady_axis_at(b->position[(corner + 1) % 3], l, next);
        steady_axis_at(b->position[(corner + 2) % 3], l, previous);
        norma_core_subtract(next, here, next);
        norma_core_subtract(previous, here, previous);
        norma_core_cross(next, previous, cross);
        const double cross_square = norma_core_dot(cross, cross);
        c->aa[l] = norma_core_dot(next, next);
        c->bb[l] = norma_core_dot(previous, previous);
        c->ab[l] = norma_core_dot(next, previous);
        c->cross[l] = sqrt(cross_square);
        out->is_sure[l] = is_held_lane(square) & is_held_lane(cross_square) ? out->is_sure[l] : 0;
    }
}

/* One loop without a question inside for the weight that nearly all meshes have. */
CORE_INLINE void weigh_lanes(const corner_lanes *restrict c, const double *restrict twice_area,
    norma_weight weight, double *restrict out) {
    if (weight == NORMA_WEIGHT_ANGLE)
        for (int l = 0; l < STEADY_LANES; ++l)
            out[l] = norma_core_weight_angle(c->cross[l], c->ab[l]);
    else
        for (int l = 0; l < STEADY_LANES; ++l)
            out[l] = norma_core_weigh(
                weight, c->aa[l], c->bb[l], c->ab[l], c->cross[l], twice_area[l], 0);
}

CORE_INLINE void add_up_steady(
    const steady_batch *restrict b, norma_weight weight, steady_addends *restrict out) {
    steady_lane along[3], twice_area;
    measure_steady_lanes(b, along, twice_area, out);
    for (int corner = 0; corner < 3; ++corner) {
        corner_lanes c;
        steady_lane weights;
        turn_corner(b, along, corner, &c, out);
        weigh_lanes(&c, twice_area, weight, weights);
        for (int l = 0; l < STEADY_LANES; ++l) {
            for (int k = 0; k < 3; ++k)
                out->sum[corner][k][l] =
                    c.is_there[l] > 0 ? out->sum[corner][k][l] * weights[l] : 0;
            out->weight[corner][l] = c.is_there[l] > 0 ? weights[l] : 0;
        }
    }
}

static void add_up_steady_portable(
    const steady_batch *restrict b, norma_weight weight, steady_addends *restrict out) {
    add_up_steady(b, weight, out);
}
#if defined(CORE_HAS_X86)
CORE_FOR_AVX2 static void add_up_steady_avx2(
    const steady_batch *restrict b, norma_weight weight, steady_addends *restrict out) {
    add_up_steady(b, weight, out);
}
#endif

static steady_kernel *core_steady_kernel(norma_isa isa) {
    static steady_kernel *const kernels[] = CORE_KERNELS_TO_AVX2(add_up_steady);
    return kernels[norma_core_level(isa)];
}

/* ---- Of each face the direction in which the first texture coordinate grows, and the
 * sign of its texture area. For a polygon both are means over its area in texture space: by Green's
 * theorem, sums over its edges. And what the face adds at each of its corners. */

enum { FACES_IN_TASK = 1 << 12 };

typedef struct steady_face {
    double along[3];  /* unit: where the first texture coordinate grows */
    double normal[3]; /* twice the vector area */
    double twice_area;
    exact_area area; /* where doubles do not tell whether a corner is reflex */
} steady_face;

typedef struct face_corners {
    const tangent_mesh *mesh;
    size_t first, count, start; /* start: where the least rotation begins */
} face_corners;

static uint32_t key_of_face(const face_corners *f, size_t index) {
    size_t place = f->start + index;
    if (place >= f->count) place -= f->count;
    return norma_core_tangent_key(f->mesh, f->first + place);
}
static const tangent_vertex *corner_of_face(const face_corners *f, size_t index) {
    return &f->mesh->vertices[key_of_face(f, index)];
}

/* -1, 0 or 1, by position, normal and texture coordinates. */
static int compare_area(const tangent_mesh *mesh, uint32_t a, uint32_t b) {
    float x[8], y[8];
    memcpy(x, &mesh->vertices[a], sizeof x);
    memcpy(y, &mesh->vertices[b], sizeof y);
    for (int k = 0; k < 3 && mesh->exact; ++k)
        if (mesh->exact[a][k] != mesh->exact[b][k])
            return mesh->exact[a][k] < mesh->exact[b][k] ? -1 : 1;
    for (int k = 0; k < 8; ++k)
        if (x[k] != y[k]) return x[k] < y[k] ? -1 : 1;
    return 0;
}

/* The least rotation of a sequence, in linear time: two candidates run side by side, and the loser
 * skips all that was compared. */
static size_t least_rotation(const face_corners *f) {
    size_t i = 0, j = 1, same = 0;
    while (i < f->count && j < f->count && same < f->count) {
        const int order = compare_area(
            f->mesh, key_of_face(f, (i + same) % f->count), key_of_face(f, (j + same) % f->count));
        if (!order) {
            ++same;
            continue;
        }
        if (order > 0)
            i += same + 1;
        else
            j += same + 1;
        if (i == j) ++j;
        same = 0;
    }
    return i < j ? i : j;
}

static void difference(const float a[2], const float b[2], double out[2]) {
    for (int k = 0; k < 2; ++k) out[k] = (double)a[k] - (double)b[k];
}

typedef struct face_sums {
    double area, magnitude; /* of the texture, twice; of the products in it */
    double along[3], normal[3];
} face_sums;

/* The triangle between the first corner and two that follow each other. */
static void add_steady_triangle(face_sums *sums, const face_corners *f, size_t index) {
    const uint32_t origin = key_of_face(f, 0), a = key_of_face(f, index),
                   b = key_of_face(f, index + 1);
    const tangent_vertex *v = f->mesh->vertices;
    double here[3], p[3], q[3], s[2], t[2], cross[3];
    steady_position(f->mesh, origin, here);
    steady_position(f->mesh, a, p);
    steady_position(f->mesh, b, q);
    norma_core_subtract(p, here, p);
    norma_core_subtract(q, here, q);
    difference(v[a].texcoord, v[origin].texcoord, s);
    difference(v[b].texcoord, v[origin].texcoord, t);
    norma_core_cross(p, q, cross);
    sums->area += s[0] * t[1] - s[1] * t[0];
    sums->magnitude += fabs(s[0] * t[1]) + fabs(s[1] * t[0]);
    for (int k = 0; k < 3; ++k) {
        sums->along[k] += t[1] * p[k] - s[1] * q[k];
        sums->normal[k] += cross[k];
    }
}

static int is_face_finite(const face_corners *f) {
    for (size_t i = 0; i < f->count; ++i)
        if (!norma_core_tangent_is_finite(corner_of_face(f, i))) return 0;
    return 1;
}

static int8_t measure_face(const face_corners *f, steady_face *face) {
    face_sums sums = {0};
    for (size_t i = 1; i + 1 < f->count; ++i) add_steady_triangle(&sums, f, i);
    memcpy(face->normal, sums.normal, sizeof face->normal);
    face->twice_area = steady_length(sums.normal);
    if (!(fabs(sums.area) > STEADY_ROUNDING * sums.magnitude) || !(face->twice_area > 0)) return 0;
    for (int k = 0; k < 3; ++k) face->along[k] = sums.area < 0 ? -sums.along[k] : sums.along[k];
    steady_normalise(face->along, face->along);
    if (steady_length(face->along) == 0) return 0;
    return sums.area < 0 ? -1 : 1;
}

/* ---- what a corner adds */

static void position_at_corner(const steady_mesh *m, size_t corner, double out[3]) {
    steady_position(m->input, norma_core_tangent_key(m->input, corner), out);
}

typedef struct face_points {
    const steady_mesh *mesh;
    size_t first;
} face_points;

static void texcoord_at(const void *context, size_t index, double point[3]) {
    const face_points *face = context;
    position_at_corner(face->mesh, face->first + index, point);
}

/* As the corner's weight for normals has it; cross: of its edges. */
static int is_corner_reflex(
    const steady_mesh *m, steady_face *face, size_t number, size_t corner, const double cross[3]) {
    const core_mesh *mesh = &m->input->mesh;
    const face_points points = {m, norma_core_face_begin(mesh, number)};
    const double along = norma_core_dot(cross, face->normal),
                 lengths = steady_length(cross) * face->twice_area;
    double here[3], next[3], previous[3];
    if (lengths == 0 || fabs(along) > 0x1p-20 * lengths) return along < 0;
    position_at_corner(m, corner, here);
    position_at_corner(m, norma_core_next_in_face(mesh, number, corner), next);
    position_at_corner(m, norma_core_previous_in_face(mesh, number, corner), previous);
    if (!face->area.known)
        norma_core_sum_polygon(
            texcoord_at, &points, norma_core_face_end(mesh, number) - points.first, &face->area);
    return norma_core_turns_back(&face->area, here, next, previous);
}

static double weight_of_corner(
    const steady_mesh *m, steady_face *face, size_t number, size_t corner) {
    const core_mesh *mesh = &m->input->mesh;
    double at[3], a[3], b[3], cross[3];
    position_at_corner(m, corner, at);
    position_at_corner(m, norma_core_next_in_face(mesh, number, corner), a);
    position_at_corner(m, norma_core_previous_in_face(mesh, number, corner), b);
    norma_core_subtract(a, at, a);
    norma_core_subtract(b, at, b);
    norma_core_cross(a, b, cross);
    return norma_core_weigh(m->call->options.weight, norma_core_dot(a, a), norma_core_dot(b, b),
        norma_core_dot(a, b), steady_length(cross), face->twice_area,
        mesh->face_starts && is_corner_reflex(m, face, number, corner, cross));
}

static steady_part part_of_face(
    const steady_mesh *m, steady_face *face, size_t number, size_t corner) {
    const float *n = m->input->vertices[norma_core_tangent_key(m->input, corner)].normal;
    const double given[3] = {(double)n[0], (double)n[1], (double)n[2]};
    double normal[3];
    steady_part part;
    steady_normalise(given, normal);
    if (!steady_make_perpendicular(face->along, normal, part.sum)) return (steady_part){{0}, 0};
    part.weight = weight_of_corner(m, face, number, corner);
    for (int k = 0; k < 3; ++k) part.sum[k] *= part.weight;
    return part;
}

/* ---- faces */

static void add_steady_face(const steady_mesh *m, size_t number) {
    const core_mesh *mesh = &m->input->mesh;
    const size_t first = norma_core_face_begin(mesh, number),
                 count = norma_core_face_end(mesh, number) - first;
    face_corners f = {m->input, first, count, 0};
    steady_face face;
    face.area.known = 0;
    m->signs[number] = 0;
    if (count < 3 || !is_face_finite(&f)) return;
    f.start = least_rotation(&f);
    m->signs[number] = measure_face(&f, &face);
    for (size_t c = first; c < first + count && m->signs[number]; ++c)
        m->parts[c] = part_of_face(m, &face, number, c);
}

/* Nearly always the first number of one position is less than those of the two others. */
static size_t start_of_triangle(const face_corners *f, const tangent_vertex *const v[3]) {
    const float a = v[0]->position[0], b = v[1]->position[0], c = v[2]->position[0];
    return a < b && a < c      ? 0
           : b < a && b < c    ? 1
           : c < a && c < b    ? 2
           : is_face_finite(f) ? least_rotation(f)
                               : 0;
}

/* Returns where its least rotation starts. */
static size_t load_face_lane(const steady_mesh *m, size_t triangle, int lane, steady_batch *batch) {
    const face_corners f = {m->input, 3 * triangle, 3, 0};
    const tangent_vertex *const v[3] = {
        corner_of_face(&f, 0), corner_of_face(&f, 1), corner_of_face(&f, 2)};
    const size_t start = start_of_triangle(&f, v);
    for (size_t i = 0; i < 3; ++i) {
        const tangent_vertex *from = v[(start + i) % 3];
        double at[3];
        steady_position(m->input, (size_t)(from - m->input->vertices), at);
        for (int k = 0; k < 3; ++k) batch->position[i][k][lane] = at[k];
        for (int k = 0; k < 3; ++k) batch->normal[i][k][lane] = (double)from->normal[k];
        for (int k = 0; k < 2; ++k) batch->texcoord[i][k][lane] = (double)from->texcoord[k];
    }
    return start;
}

static void store_face_lane(
    const steady_mesh *m, size_t triangle, int lane, size_t start, const steady_addends *addends) {
    m->signs[triangle] = (int8_t)addends->sign[lane];
    for (size_t i = 0; i < 3; ++i)
        m->parts[3 * triangle + (start + i) % 3] = (steady_part){
            {addends->sum[i][0][lane], addends->sum[i][1][lane], addends->sum[i][2][lane]},
            addends->weight[i][lane]};
}

static void add_steady_triangles(const steady_mesh *m, size_t begin, size_t end) {
    steady_kernel *kernel = core_steady_kernel(m->call->options.isa);
    steady_batch batch;
    steady_addends out;
    size_t starts[STEADY_LANES];
    memset(&batch, 0, sizeof batch);
    for (size_t t = begin; t < end; t += STEADY_LANES) {
        const int count = end - t < STEADY_LANES ? (int)(end - t) : STEADY_LANES;
        for (int l = 0; l < count; ++l) {
            starts[l] = load_face_lane(m, t + (size_t)l, l, &batch);
        }
        kernel(&batch, m->call->options.weight, &out);
        for (int l = 0; l < count; ++l)
            if (out.is_sure[l] > 0)
                store_face_lane(m, t + (size_t)l, l, starts[l], &out);
            else
                add_steady_face(m, t + (size_t)l);
    }
}

static void face_task(void *context, size_t task) {
    const steady_mesh *m = context;
    const core_mesh *mesh = &m->input->mesh;
    const size_t begin = task * FACES_IN_TASK, end = mesh->face_count - begin < FACES_IN_TASK
                                                         ? mesh->face_count
                                                         : begin + FACES_IN_TASK;
    const size_t last = norma_core_face_begin(mesh, end);
    for (size_t c = norma_core_face_begin(mesh, begin); c < last; ++c)
        m->vertex_of[c] = norma_core_tangent_vertex(m->input, c);
    if (!mesh->face_starts) {
        add_steady_triangles(m, begin, end);
        return;
    }
    for (size_t face = begin; face < end; ++face) {
        add_steady_face(m, face);
    }
}

/* CANCELLED, or every face measured, and what it adds at its corners. */
static norma_result core_steady_faces(steady_mesh *m) {
    const size_t count = m->input->mesh.face_count;
    return norma_core_parallel(
        m->call, count / FACES_IN_TASK + (count % FACES_IN_TASK != 0), face_task, m);
}

/* ---- The sums at each vertex, one over the faces of each sign. */

enum { VERTICES_IN_TASK = 1 << 11 };

typedef struct steady_work {
    const steady_mesh *mesh;
    const tangent_output *output;
    core_tally *tallies; /* one for each task */
} steady_work;

/* ---- sums in any order: of integers */

typedef struct steady_star {
    const uint32_t *corners;
    size_t count;
    double normal[3];
} steady_star;

static int log2_above(size_t count) {
    int log = 0;
    while (count >> log) ++log;
    return log;
}

static int is_negative(const steady_mesh *m, size_t face) {
    return m->signs[face] ? m->signs[face] < 0 : m->adopted && m->adopted[face];
}

/* The faces at a vertex that have one sign, or adopted it. */
typedef struct steady_side {
    int negative;
    size_t count, own; /* faces; those whose sign is their own: only they add to the sum */
    double largest;    /* weight */
} steady_side;

static steady_side side_of_corner(const steady_mesh *m, const steady_star *star, int negative) {
    steady_side side = {.negative = negative};
    for (size_t j = 0; j < star->count; ++j) {
        const size_t face = norma_core_face_of(&m->around, star->corners[j]);
        if (is_negative(m, face) != negative) continue;
        ++side.count;
        if (!m->signs[face]) continue;
        const double weight = m->parts[star->corners[j]].weight;
        ++side.own;
        side.largest = weight > side.largest ? weight : side.largest;
    }
    return side;
}

static corner_tangent sum_of_side(
    const steady_mesh *m, const steady_star *star, const steady_side *side) {
    /* In two steps: doubles do not hold the inverse of every weight. */
    const int shift = 60 - log2_above(star->count) - ilogb(side->largest);
    const double scale = ldexp(1, shift / 2), rest = ldexp(1, shift - shift / 2);
    corner_tangent out = {.reason = NORMA_REASON_CANCELLED};
    int64_t sum[3] = {0}, weight = 0;
    for (size_t j = 0; j < star->count; ++j) {
        const int sign = m->signs[norma_core_face_of(&m->around, star->corners[j])];
        if (!sign || (sign < 0) != side->negative) continue;
        const steady_part *part = &m->parts[star->corners[j]];
        for (int k = 0; k < 3; ++k) sum[k] += (int64_t)(part->sum[k] * scale * rest);
        weight += (int64_t)(part->weight * scale * rest);
    }
    double direction[3] = {(double)sum[0], (double)sum[1], (double)sum[2]};
    if (norma_core_cancels(direction, (double)weight)) return out;
    steady_normalise(direction, direction);
    if (!steady_make_perpendicular(direction, star->normal, direction)) return out;
    out.reason = NORMA_REASON_NONE;
    for (int k = 0; k < 3; ++k) out.direction[k] = (float)direction[k] + 0.0F;
    return out;
}

/* ---- stars */

/* What the corners of one side get. */
static corner_tangent tangent_of_side(
    const steady_mesh *m, const steady_star *star, const steady_side *side) {
    corner_tangent tangent = {.reason = NORMA_REASON_CANCELLED};
    if (side->largest > 0) tangent = sum_of_side(m, star, side);
    if (!side->own) tangent.reason = NORMA_REASON_DEGENERATE;
    tangent.sign = side->negative ? -1 : 1;
    return tangent;
}

static void finish_star(const steady_work *w, uint32_t vertex, core_tally *tally) {
    const steady_mesh *m = w->mesh;
    const tangent_vertex *at = &m->input->vertices[vertex];
    const uint32_t begin = m->around.starts[vertex];
    steady_star star = {
        .corners = m->around.corners + begin, .count = m->around.starts[vertex + 1] - begin};
    const double normal[3] = {(double)at->normal[0], (double)at->normal[1], (double)at->normal[2]};
    if (norma_core_tangent_is_finite(at)) steady_normalise(normal, star.normal);
    for (int negative = 0; negative < 2; ++negative) {
        const steady_side side = side_of_corner(m, &star, negative);
        if (!side.count) continue;
        const corner_tangent tangent = tangent_of_side(m, &star, &side);
        const written_tangent out = norma_core_tangent_to_write(at, &tangent);
        for (size_t j = 0; j < star.count; ++j)
            if (is_negative(m, norma_core_face_of(&m->around, star.corners[j])) == negative)
                norma_core_put_tangent(w->output, star.corners[j], &out, tally);
    }
}

static size_t steady_star_count(const steady_mesh *m, size_t vertex) {
    return m->around.starts[vertex + 1] - m->around.starts[vertex];
}

static void steady_star_task(void *context, size_t task) {
    const steady_work *w = context;
    const size_t count = w->mesh->input->key_count, begin = task * VERTICES_IN_TASK,
                 end = count - begin < VERTICES_IN_TASK ? count : begin + VERTICES_IN_TASK;
    for (size_t v = begin; v < end; ++v) {
        if (steady_star_count(w->mesh, v)) finish_star(w, (uint32_t)v, &w->tallies[task]);
    }
}

static norma_result run_stars(
    const steady_mesh *m, const tangent_output *output, core_tally *tally) {
    const size_t keys = m->input->key_count,
                 tasks = keys / VERTICES_IN_TASK + (keys % VERTICES_IN_TASK != 0);
    steady_work w = {m, output, norma_core_allocate(m->call, tasks, sizeof *w.tallies)};
    if (!w.tallies) return NORMA_ERROR_MEMORY;
    memset(w.tallies, 0, tasks * sizeof *w.tallies);
    const norma_result result = norma_core_parallel(m->call, tasks, steady_star_task, &w);
    for (size_t i = 0; i < tasks && !result; ++i) norma_core_tally_add(tally, &w.tallies[i]);
    norma_core_release(m->call, w.tallies, tasks, sizeof *w.tallies);
    return result;
}

/* ---- faces without texture area take the sign that most of their corners' vertices have */

static void adopt_signs(steady_mesh *m, uint8_t *present) {
    const core_mesh *mesh = &m->input->mesh;
    memset(present, 0, m->input->key_count);
    for (size_t face = 0; face < mesh->face_count; ++face)
        for (size_t c = norma_core_face_begin(mesh, face);
             m->signs[face] && c < norma_core_face_end(mesh, face); ++c)
            present[m->vertex_of[c]] |= m->signs[face] < 0 ? 2 : 1;
    for (size_t face = 0; face < mesh->face_count; ++face) {
        size_t negative = 0, positive = 0;
        for (size_t c = norma_core_face_begin(mesh, face);
             !m->signs[face] && c < norma_core_face_end(mesh, face); ++c) {
            negative += present[m->vertex_of[c]] >> 1;
            positive += present[m->vertex_of[c]] & 1;
        }
        m->adopted[face] = negative > positive;
    }
}

static norma_result adopt(steady_mesh *m) {
    const size_t count = m->input->mesh.face_count;
    int any = 0;
    for (size_t face = 0; face < count; ++face) any |= !m->signs[face];
    if (!any) return NORMA_OK;
    uint8_t *present = norma_core_allocate(m->call, m->input->key_count, 1);
    m->adopted = norma_core_allocate(m->call, count, 1);
    const int ready = present && m->adopted;
    if (ready) adopt_signs(m, present);
    norma_core_release(m->call, present, m->input->key_count, 1);
    return ready ? NORMA_OK : NORMA_ERROR_MEMORY;
}

/* The corners of each vertex. */
static norma_result sort_steady_corners(
    const tangent_mesh *input, uint32_t *vertex_of, core_corners_of_position *around) {
    const core_mesh *mesh = &input->mesh;
    const core_mesh vertices = {.positions = {.count = input->key_count},
        .corners = vertex_of,
        .corner_count = mesh->corner_count,
        .corner_size = 4,
        .face_starts = mesh->face_starts,
        .face_count = mesh->face_count};
    return norma_core_corners_of_position_build(input->call, &vertices, around);
}

/* A face without texture area takes its sign from others. */
static int steady_hangs_on_others(const steady_mesh *m) {
    for (size_t face = 0; face < m->input->mesh.face_count; ++face)
        if (!m->signs[face]) return 1;
    return 0;
}

static norma_result run_steady(steady_mesh *m, const tangent_output *output, core_tally *tally) {
    norma_core_stage(m->call, 0.3, 0.5);
    norma_result result = core_steady_faces(m);
    if (!result && m->input->is_awkward && steady_hangs_on_others(m)) {
        *m->input->is_awkward = 1;
        return NORMA_OK;
    }
    norma_core_stage(m->call, 0.5, 0.6);
    if (!result) result = sort_steady_corners(m->input, m->vertex_of, &m->around);
    if (!result) result = adopt(m);
    norma_core_stage(m->call, 0.6, 0.97);
    return !result ? run_stars(m, output, tally) : result;
}

/* By a power of two, so that squares of squares of lengths are held. */
static void scale_exact_positions(const tangent_mesh *m) {
    double largest = 0;
    for (size_t i = 0; i < m->key_count; ++i)
        for (int k = 0; k < 3; ++k)
            if (isfinite(m->exact[i][k])) largest = fmax(largest, fabs(m->exact[i][k]));
    const int shift = largest > 0 ? -ilogb(largest) : 0;
    for (size_t i = 0; i < m->key_count; ++i)
        for (int k = 0; k < 3; ++k) m->exact[i][k] = ldexp(m->exact[i][k], shift);
}

norma_result norma_core_steady_tangents(
    const tangent_mesh *mesh, const tangent_output *output, core_tally *tally) {
    const core_call *call = mesh->call;
    const size_t corners = mesh->mesh.corner_count, faces = mesh->mesh.face_count;
    if (!corners) return NORMA_OK;
    if (mesh->exact) scale_exact_positions(mesh);
    steady_mesh m = {.call = mesh->call,
        .input = mesh,
        .vertex_of = norma_core_allocate(call, corners, sizeof *m.vertex_of),
        .parts = norma_core_allocate(call, corners, sizeof *m.parts),
        .signs = norma_core_allocate(call, faces, 1)};
    norma_result result = NORMA_ERROR_MEMORY;
    if (m.vertex_of && m.parts && m.signs) result = run_steady(&m, output, tally);
    norma_core_release(call, m.parts, corners, sizeof *m.parts);
    norma_core_release(call, m.signs, faces, 1);
    norma_core_release(call, m.adopted, faces, 1);
    norma_core_release(call, m.vertex_of, corners, sizeof *m.vertex_of);
    if (m.around.starts) norma_core_corners_of_position_release(call, &m.around);
    return result;
}

norma_result norma_core_steady_stars(
    const tangent_mesh *mesh, uint32_t **vertex_of, core_corners_of_position *around) {
    const size_t corners = mesh->mesh.corner_count;
    *vertex_of = norma_core_allocate(mesh->call, corners, sizeof **vertex_of);
    if (!*vertex_of) return NORMA_ERROR_MEMORY;
    for (size_t c = 0; c < corners; ++c) (*vertex_of)[c] = norma_core_tangent_vertex(mesh, c);
    return sort_steady_corners(mesh, *vertex_of, around);
}
