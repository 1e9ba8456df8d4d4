/* steady_tangents.c: the sums at each vertex, one over the faces of each sign. */
#include "core/face/face_geometry.h"
#include "core/face/reflex.h"
#include "core/face/triangle.h"
#include "core/tangent/steady.h"
#include "core/tangent/tangent_plan.h"
#include <math.h>

enum { SMALL_STAR = 64, VERTICES_IN_TASK = 1 << 11, STARS_AHEAD = 6 };

typedef struct steady_part {
    double sum[3]; /* a unit vector times the weight */
    double weight; /* 0: adds nothing */
} steady_part;

typedef struct steady_work {
    const steady_mesh *mesh;
    const tangent_output *output;
    core_tally *tallies; /* one for each task */
} steady_work;

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
static int is_reflex(const steady_mesh *m, size_t number, size_t corner, const double cross[3]) {
    const core_mesh *mesh = &m->input->mesh;
    const face_points face = {m, norma_core_face_begin(mesh, number)};
    const double along = norma_core_dot(cross, m->faces[number].normal),
                 lengths = steady_length(cross) * m->faces[number].twice_area;
    double here[3], next[3], previous[3];
    if (lengths == 0 || fabs(along) > 0x1p-20 * lengths) return along < 0;
    position_of(m, corner, here);
    position_of(m, norma_core_next_in_face(mesh, number, corner), next);
    position_of(m, norma_core_previous_in_face(mesh, number, corner), previous);
    return norma_core_turns_back(
        point_of, &face, norma_core_face_end(mesh, number) - face.first, here, next, previous);
}

static double weight_of(const steady_mesh *m, size_t number, size_t corner) {
    const core_mesh *mesh = &m->input->mesh;
    const steady_face *face = &m->faces[number];
    double at[3], a[3], b[3], cross[3];
    position_of(m, corner, at);
    position_of(m, norma_core_next_in_face(mesh, number, corner), a);
    position_of(m, norma_core_previous_in_face(mesh, number, corner), b);
    norma_core_subtract(a, at, a);
    norma_core_subtract(b, at, b);
    norma_core_cross(a, b, cross);
    return norma_core_weigh(m->call->options.weight, norma_core_dot(a, a), norma_core_dot(b, b),
        norma_core_dot(a, b), steady_length(cross), face->twice_area,
        mesh->face_starts && is_reflex(m, number, corner, cross));
}

/* Below this part of a unit vector, what is perpendicular to the normal is rounding. */
static const double NOTHING_LEFT = 0x1p-20;

static int make_perpendicular(const double v[3], const double normal[3], double out[3]) {
    const double along = norma_core_dot(v, normal);
    for (int k = 0; k < 3; k++) out[k] = v[k] - along * normal[k];
    const double length = sqrt(norma_core_dot(out, out)); /* of a part of a unit vector */
    if (!(length > NOTHING_LEFT)) return 0;
    const double inverse = 1 / length;
    for (int k = 0; k < 3; k++) out[k] *= inverse;
    return 1;
}

static steady_part part_of(
    const steady_mesh *m, const double normal[3], size_t face, size_t corner) {
    steady_part part = {0};
    if (!make_perpendicular(m->faces[face].along, normal, part.sum)) return part;
    part.weight = weight_of(m, face, corner);
    for (int k = 0; k < 3; k++) part.sum[k] *= part.weight;
    return part;
}

/* ---- sums in any order: of integers */

typedef struct steady_star {
    const uint32_t *corners;
    size_t count;
    double normal[3];
    steady_part *parts; /* of each corner */
} steady_star;

typedef struct steady_sum {
    int present; /* a face of this sign is here */
    int reason;
    float direction[3];
} steady_sum;

static int log2_above(size_t count) {
    int log = 0;
    while (count >> log) log++;
    return log;
}

static void sum_up(
    const steady_mesh *m, const steady_star *star, int sign, double largest, steady_sum *out) {
    const double scale = ldexp(1, 60 - log2_above(star->count) - ilogb(largest));
    int64_t sum[3] = {0}, weight = 0;
    for (size_t j = 0; j < star->count; j++) {
        if (m->signs[norma_core_face_of(&m->around, star->corners[j])] != sign) continue;
        for (int k = 0; k < 3; k++) sum[k] += (int64_t)(star->parts[j].sum[k] * scale);
        weight += (int64_t)(star->parts[j].weight * scale);
    }
    double direction[3] = {(double)sum[0], (double)sum[1], (double)sum[2]};
    if (norma_core_cancels(direction, (double)weight)) return;
    steady_normalise(direction, direction);
    if (!make_perpendicular(direction, star->normal, direction)) return;
    out->reason = NORMA_REASON_NONE;
    for (int k = 0; k < 3; k++) out->direction[k] = (float)direction[k] + 0.0F;
}

static steady_sum sum_of(const steady_mesh *m, const steady_star *star, int sign) {
    steady_sum out = {.reason = NORMA_REASON_CANCELLED};
    double largest = 0;
    for (size_t j = 0; j < star->count; j++) {
        if (m->signs[norma_core_face_of(&m->around, star->corners[j])] != sign) continue;
        out.present = 1;
        largest = fmax(largest, star->parts[j].weight);
    }
    if (largest > 0) sum_up(m, star, sign, largest, &out);
    return out;
}

/* ---- stars */

static int is_negative(const steady_mesh *m, size_t face) {
    return m->signs[face] ? m->signs[face] < 0 : m->adopted && m->adopted[face];
}

/* What the corners of faces of one sign get. */
static written_tangent tangent_of(const tangent_vertex *at, int sign, const steady_sum *sum) {
    corner_tangent tangent = {.sign = (float)sign, .reason = sum->reason};
    if (!sum->present) tangent.reason = NORMA_REASON_DEGENERATE;
    memcpy(tangent.direction, sum->direction, sizeof tangent.direction);
    return norma_core_tangent_to_write(at, &tangent);
}

static void finish_star(
    const steady_work *w, uint32_t vertex, steady_part *parts, core_tally *tally) {
    const steady_mesh *m = w->mesh;
    const tangent_vertex *at = &m->input->vertices[vertex];
    const uint32_t begin = m->around.starts[vertex];
    steady_star star = {.corners = m->around.corners + begin,
        .count = m->around.starts[vertex + 1] - begin,
        .parts = parts};
    const double normal[3] = {(double)at->normal[0], (double)at->normal[1], (double)at->normal[2]};
    if (norma_core_tangent_is_finite(at)) steady_normalise(normal, star.normal);
    for (size_t j = 0; j < star.count; j++) {
        const size_t face = norma_core_face_of(&m->around, star.corners[j]);
        if (m->signs[face]) parts[j] = part_of(m, star.normal, face, star.corners[j]);
    }
    const steady_sum negative = sum_of(m, &star, -1), positive = sum_of(m, &star, 1);
    const written_tangent out[2] = {tangent_of(at, 1, &positive), tangent_of(at, -1, &negative)};
    for (size_t j = 0; j < star.count; j++) {
        const size_t face = norma_core_face_of(&m->around, star.corners[j]);
        norma_core_put_tangent(w->output, star.corners[j], &out[is_negative(m, face)], tally);
    }
}

static size_t star_count(const steady_mesh *m, size_t vertex) {
    return m->around.starts[vertex + 1] - m->around.starts[vertex];
}

/* Asks for what the star of this vertex reads first. */
static void await_faces(const steady_mesh *m, size_t vertex) {
    const core_mesh *mesh = &m->input->mesh;
    if (vertex >= m->input->key_count || star_count(m, vertex) > SMALL_STAR) return;
    for (uint32_t i = m->around.starts[vertex]; i < m->around.starts[vertex + 1]; i++) {
        const uint32_t corner = m->around.corners[i];
        const steady_face *face = &m->faces[norma_core_face_of(&m->around, corner)];
        TANGENT_PREFETCH(face);
        TANGENT_PREFETCH(&face->twice_area);
        TANGENT_PREFETCH(&m->signs[face - m->faces]);
        if (mesh->corners)
            TANGENT_PREFETCH((const unsigned char *)mesh->corners + corner * mesh->corner_size);
    }
}

/* Then for what it reads after that, and for where tangents go. */
static void await_points(const steady_work *w, size_t vertex) {
    const steady_mesh *m = w->mesh;
    const tangent_mesh *in = m->input;
    if (vertex >= in->key_count || star_count(m, vertex) > SMALL_STAR) return;
    for (uint32_t i = m->around.starts[vertex]; i < m->around.starts[vertex + 1]; i++) {
        const uint32_t corner = m->around.corners[i];
        const size_t face = norma_core_face_of(&m->around, corner),
                     next = norma_core_next_in_face(&in->mesh, face, corner),
                     previous = norma_core_previous_in_face(&in->mesh, face, corner);
        TANGENT_PREFETCH(&in->vertices[norma_core_tangent_key(in, next)]);
        TANGENT_PREFETCH(&in->vertices[norma_core_tangent_key(in, previous)]);
        TANGENT_PREFETCH(w->output->tangents + corner * w->output->stride);
    }
}

static void star_task(void *context, size_t task) {
    const steady_work *w = context;
    const size_t count = w->mesh->input->key_count, begin = task * VERTICES_IN_TASK,
                 end = count - begin < VERTICES_IN_TASK ? count : begin + VERTICES_IN_TASK;
    steady_part parts[SMALL_STAR];
    for (size_t v = begin; v < end; v++) {
        const size_t corners = star_count(w->mesh, v);
        await_faces(w->mesh, v + 2 * STARS_AHEAD);
        await_points(w, v + STARS_AHEAD);
        if (corners && corners <= SMALL_STAR) finish_star(w, (uint32_t)v, parts, &w->tallies[task]);
    }
}

static norma_result run_large(const steady_work *w, core_tally *tally) {
    const steady_mesh *m = w->mesh;
    const size_t most = m->around.most;
    if (most <= SMALL_STAR) return NORMA_OK;
    steady_part *parts = norma_core_allocate(m->call, most, sizeof *parts);
    if (!parts) return NORMA_ERROR_MEMORY;
    for (size_t v = 0; v < m->input->key_count; v++)
        if (star_count(m, v) > SMALL_STAR) finish_star(w, (uint32_t)v, parts, tally);
    norma_core_release(m->call, parts, most, sizeof *parts);
    return NORMA_OK;
}

static norma_result run_stars(
    const steady_mesh *m, const tangent_output *output, core_tally *tally) {
    const size_t keys = m->input->key_count,
                 tasks = keys / VERTICES_IN_TASK + (keys % VERTICES_IN_TASK != 0);
    steady_work w = {m, output, norma_core_allocate(m->call, tasks, sizeof *w.tallies)};
    if (!w.tallies) return NORMA_ERROR_MEMORY;
    memset(w.tallies, 0, tasks * sizeof *w.tallies);
    norma_result result = norma_core_parallel(m->call, tasks, star_task, &w);
    if (result == NORMA_OK) result = run_large(&w, tally);
    for (size_t i = 0; i < tasks && result == NORMA_OK; i++)
        norma_core_tally_add(tally, &w.tallies[i]);
    norma_core_release(m->call, w.tallies, tasks, sizeof *w.tallies);
    return result;
}

/* ---- faces without texture area take the sign that most of their corners' vertices have */

static void adopt_signs(steady_mesh *m, uint8_t *present) {
    const core_mesh *mesh = &m->input->mesh;
    memset(present, 0, m->input->key_count);
    for (size_t face = 0; face < mesh->face_count; face++)
        for (size_t c = norma_core_face_begin(mesh, face);
             m->signs[face] && c < norma_core_face_end(mesh, face); c++)
            present[m->vertex_of[c]] |= m->signs[face] < 0 ? 2 : 1;
    for (size_t face = 0; face < mesh->face_count; face++) {
        size_t negative = 0, positive = 0;
        for (size_t c = norma_core_face_begin(mesh, face);
             !m->signs[face] && c < norma_core_face_end(mesh, face); c++) {
            negative += present[m->vertex_of[c]] >> 1;
            positive += present[m->vertex_of[c]] & 1;
        }
        m->adopted[face] = negative > positive;
    }
}

static norma_result adopt(steady_mesh *m) {
    const size_t count = m->input->mesh.face_count;
    int any = 0;
    for (size_t face = 0; face < count; face++) any |= !m->signs[face];
    if (!any) return NORMA_OK;
    uint8_t *present = norma_core_allocate(m->call, m->input->key_count, 1);
    m->adopted = norma_core_allocate(m->call, count, 1);
    const int ready = present && m->adopted;
    if (ready) adopt_signs(m, present);
    norma_core_release(m->call, present, m->input->key_count, 1);
    return ready ? NORMA_OK : NORMA_ERROR_MEMORY;
}

/* The corners of each vertex. */
static norma_result sort_corners(
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
static int hangs_on_others(const steady_mesh *m) {
    for (size_t face = 0; face < m->input->mesh.face_count; face++)
        if (!m->signs[face]) return 1;
    return 0;
}

static norma_result run(steady_mesh *m, const tangent_output *output, core_tally *tally) {
    norma_core_stage(m->call, 0.3, 0.5);
    norma_result result = norma_core_steady_faces(m);
    if (result == NORMA_OK && m->input->is_awkward && hangs_on_others(m)) {
        *m->input->is_awkward = 1;
        return NORMA_OK;
    }
    norma_core_stage(m->call, 0.5, 0.6);
    if (result == NORMA_OK && !m->input->known)
        result = sort_corners(m->input, m->vertex_of, &m->around);
    if (result == NORMA_OK) result = adopt(m);
    norma_core_stage(m->call, 0.6, 0.97);
    return result == NORMA_OK ? run_stars(m, output, tally) : result;
}

/* What a plan does not know. */
static void release_unknown(steady_mesh *m) {
    if (m->input->known) return;
    norma_core_release(m->call, m->vertex_of, m->input->mesh.corner_count, sizeof *m->vertex_of);
    if (m->around.starts) norma_core_corners_of_position_release(m->call, &m->around);
}

norma_result norma_core_steady_tangents(
    const tangent_mesh *mesh, const tangent_output *output, core_tally *tally) {
    const core_call *call = mesh->call;
    const size_t corners = mesh->mesh.corner_count, faces = mesh->mesh.face_count;
    if (!corners) return NORMA_OK;
    steady_mesh m = {.call = mesh->call,
        .input = mesh,
        .faces = norma_core_allocate(call, faces, sizeof *m.faces),
        .signs = norma_core_allocate(call, faces, 1)};
    m.vertex_of = mesh->known ? mesh->known->vertex_of
                              : norma_core_allocate(call, corners, sizeof *m.vertex_of);
    if (mesh->known) m.around = mesh->known->around;
    norma_result result = NORMA_ERROR_MEMORY;
    if (m.vertex_of && m.faces && m.signs) result = run(&m, output, tally);
    norma_core_release(call, m.faces, faces, sizeof *m.faces);
    norma_core_release(call, m.signs, faces, 1);
    norma_core_release(call, m.adopted, faces, 1);
    release_unknown(&m);
    return result;
}

norma_result norma_core_steady_keep(
    const tangent_mesh *mesh, uint32_t **vertex_of, core_corners_of_position *around) {
    const size_t corners = mesh->mesh.corner_count;
    *vertex_of = norma_core_allocate(mesh->call, corners, sizeof **vertex_of);
    if (!*vertex_of) return NORMA_ERROR_MEMORY;
    for (size_t c = 0; c < corners; c++) (*vertex_of)[c] = norma_core_tangent_vertex(mesh, c);
    return sort_corners(mesh, *vertex_of, around);
}
