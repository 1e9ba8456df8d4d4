/* steady_tangents.c: the sums at each vertex, one over the faces of each sign. */
#include "core/face/face_geometry.h"
#include "core/tangent/steady.h"
#include "core/tangent/tangent_plan.h"
#include <math.h>

enum { VERTICES_IN_TASK = 1 << 11, STARS_AHEAD = 8, MOST_AHEAD = 64 };

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
    while (count >> log) log++;
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

static steady_side side_of(const steady_mesh *m, const steady_star *star, int negative) {
    steady_side side = {.negative = negative};
    for (size_t j = 0; j < star->count; j++) {
        const size_t face = norma_core_face_of(&m->around, star->corners[j]);
        if (is_negative(m, face) != negative) continue;
        side.count++;
        if (!m->signs[face]) continue;
        const double weight = m->parts[star->corners[j]].weight;
        side.own++;
        side.largest = weight > side.largest ? weight : side.largest;
    }
    return side;
}

static corner_tangent sum_of(
    const steady_mesh *m, const steady_star *star, const steady_side *side) {
    const double scale = ldexp(1, 60 - log2_above(star->count) - ilogb(side->largest));
    corner_tangent out = {.reason = NORMA_REASON_CANCELLED};
    int64_t sum[3] = {0}, weight = 0;
    for (size_t j = 0; j < star->count; j++) {
        const int sign = m->signs[norma_core_face_of(&m->around, star->corners[j])];
        if (!sign || (sign < 0) != side->negative) continue;
        const steady_part *part = &m->parts[star->corners[j]];
        for (int k = 0; k < 3; k++) sum[k] += (int64_t)(part->sum[k] * scale);
        weight += (int64_t)(part->weight * scale);
    }
    double direction[3] = {(double)sum[0], (double)sum[1], (double)sum[2]};
    if (norma_core_cancels(direction, (double)weight)) return out;
    steady_normalise(direction, direction);
    if (!steady_make_perpendicular(direction, star->normal, direction)) return out;
    out.reason = NORMA_REASON_NONE;
    for (int k = 0; k < 3; k++) out.direction[k] = (float)direction[k] + 0.0F;
    return out;
}

/* ---- stars */

/* What the corners of one side get. */
static corner_tangent tangent_of(
    const steady_mesh *m, const steady_star *star, const steady_side *side) {
    corner_tangent tangent = {.reason = NORMA_REASON_CANCELLED};
    if (side->largest > 0) tangent = sum_of(m, star, side);
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
    for (int negative = 0; negative < 2; negative++) {
        const steady_side side = side_of(m, &star, negative);
        if (!side.count) continue;
        const corner_tangent tangent = tangent_of(m, &star, &side);
        const written_tangent out = norma_core_tangent_to_write(at, &tangent);
        for (size_t j = 0; j < star.count; j++)
            if (is_negative(m, norma_core_face_of(&m->around, star.corners[j])) == negative)
                norma_core_put_tangent(w->output, star.corners[j], &out, tally);
    }
}

static size_t star_count(const steady_mesh *m, size_t vertex) {
    return m->around.starts[vertex + 1] - m->around.starts[vertex];
}

/* Asks for what the star of this vertex reads, and for where its tangents go. */
static void await_star(const steady_work *w, size_t vertex) {
    const steady_mesh *m = w->mesh;
    if (vertex >= m->input->key_count || star_count(m, vertex) > MOST_AHEAD) return;
    for (uint32_t i = m->around.starts[vertex]; i < m->around.starts[vertex + 1]; i++) {
        const uint32_t corner = m->around.corners[i];
        TANGENT_PREFETCH(&m->parts[corner]);
        TANGENT_PREFETCH(&m->signs[norma_core_face_of(&m->around, corner)]);
        TANGENT_PREFETCH(w->output->tangents + corner * w->output->stride);
    }
}

static void star_task(void *context, size_t task) {
    const steady_work *w = context;
    const size_t count = w->mesh->input->key_count, begin = task * VERTICES_IN_TASK,
                 end = count - begin < VERTICES_IN_TASK ? count : begin + VERTICES_IN_TASK;
    for (size_t v = begin; v < end; v++) {
        await_star(w, v + STARS_AHEAD);
        if (star_count(w->mesh, v)) finish_star(w, (uint32_t)v, &w->tallies[task]);
    }
}

static norma_result run_stars(
    const steady_mesh *m, const tangent_output *output, core_tally *tally) {
    const size_t keys = m->input->key_count,
                 tasks = keys / VERTICES_IN_TASK + (keys % VERTICES_IN_TASK != 0);
    steady_work w = {m, output, norma_core_allocate(m->call, tasks, sizeof *w.tallies)};
    if (!w.tallies) return NORMA_ERROR_MEMORY;
    memset(w.tallies, 0, tasks * sizeof *w.tallies);
    const norma_result result = norma_core_parallel(m->call, tasks, star_task, &w);
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
        .parts = norma_core_allocate(call, corners, sizeof *m.parts),
        .signs = norma_core_allocate(call, faces, 1)};
    m.vertex_of = mesh->known ? mesh->known->vertex_of
                              : norma_core_allocate(call, corners, sizeof *m.vertex_of);
    if (mesh->known) m.around = mesh->known->around;
    norma_result result = NORMA_ERROR_MEMORY;
    if (m.vertex_of && m.parts && m.signs) result = run(&m, output, tally);
    norma_core_release(call, m.parts, corners, sizeof *m.parts);
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
