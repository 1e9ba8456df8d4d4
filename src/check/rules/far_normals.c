/* far_normals.c: N202: normals far from every face at their position, and from every average of
 * those faces. */
#include "check/rules/facing.h"
#include "check/findings/angle.h"
#include "core/face/triangle.h"
#include <string.h>

enum {
    LARGEST_STAR = 1 << 10
}; /* corners at one position: where more meet, a normal is held
      against its own faces and the averages only, or the work would
      grow with their square */
static const double AVERAGE_COSINE = 0.90630778703664994; /* of 25 degrees */

typedef struct far_state {
    float *greatest; /* cosine of each normal: 2: of no face that says anything, or near an average
                      */
    uint8_t *open;   /* of each normal: some face at its positions is not named by N201 */
} far_state;

static int says_something(const check_mesh *m, size_t face) {
    return norma_check_directed(&m->faces[face]) && !norma_check_is_sliver(&m->faces[face]);
}

/* Against the faces of its own vertices, of those that are far from one of them. */
static void find_nearest(const check_mesh *m, far_state *state) {
    for (size_t i = 0; i < norma_check_normal_count(m); i++) state->greatest[i] = 2;
    for (size_t f = 0; f < m->mesh.face_count; f++) {
        for (size_t c = norma_core_face_begin(&m->mesh, f); c < norma_core_face_end(&m->mesh, f);
             c++) {
            const size_t number = norma_check_normal_of(m, f, c);
            if (number == SIZE_MAX || !m->far[number] || !says_something(m, f)) continue;
            const double cosine = norma_check_cosine_to(m, f, number);
            if (!isnan(cosine) &&
                (state->greatest[number] > 1.5f || cosine > (double)state->greatest[number]))
                state->greatest[number] = (float)cosine;
        }
    }
}

static int is_far(const far_state *state, size_t number) {
    return number != SIZE_MAX && (double)state->greatest[number] < CHECK_FAR_COSINE;
}

/* ---- a position: where vertices are split, as in a triangle soup, a smooth normal is the average
 * of faces that use other vertices */

typedef struct star {
    const check_mesh *m;
    const uint32_t *corners;
    size_t count;
    double averages[3][3]; /* uniform, by area, by angle; not of unit length */
    int open;              /* some face is not named by N201 */
} star;

static double angle_at(const check_mesh *m, size_t face, size_t corner) {
    const size_t begin = norma_core_face_begin(&m->mesh, face),
                 end = norma_core_face_end(&m->mesh, face);
    double p[3], a[3], b[3], u[3], v[3], cross[3];
    norma_core_position(&m->mesh, norma_core_corner(&m->mesh, corner), p);
    norma_core_position(
        &m->mesh, norma_core_corner(&m->mesh, corner + 1 < end ? corner + 1 : begin), a);
    norma_core_position(
        &m->mesh, norma_core_corner(&m->mesh, corner > begin ? corner - 1 : end - 1), b);
    norma_core_subtract(a, p, u);
    norma_core_subtract(b, p, v);
    norma_core_cross(u, v, cross);
    const double across = norma_core_length(cross), along = norma_core_dot(u, v);
    return across > 0 || along != 0 ? norma_core_angle(across, along) : 0;
}

static void sum_star(star *s) {
    const check_mesh *m = s->m;
    memset(s->averages, 0, sizeof s->averages);
    s->open = 0;
    for (size_t i = 0; i < s->count; i++) {
        const size_t face = norma_check_face_of(m, s->corners[i]);
        if (!says_something(m, face)) continue;
        const double weights[3] = {
            1, norma_check_twice_area(m, face), angle_at(m, face, s->corners[i])};
        for (int w = 0; w < 3; w++)
            for (int k = 0; k < 3; k++)
                s->averages[w][k] += weights[w] * (double)m->faces[face].normal[k];
        s->open |= !m->opposed[face];
    }
}

static int is_average(const star *s, size_t number) {
    double n[3];
    norma_check_normal(s->m, number, n);
    const double length = norma_core_length(n);
    for (int w = 0; w < 3; w++) {
        const double size = norma_core_length(s->averages[w]);
        if (norma_core_dot(n, s->averages[w]) > AVERAGE_COSINE * length * size) return 1;
    }
    return 0;
}

static void judge_star(const star *s, far_state *state) {
    for (size_t i = 0; i < s->count; i++) {
        const size_t own = norma_check_face_of(s->m, s->corners[i]),
                     number = norma_check_normal_of(s->m, own, s->corners[i]);
        if (!is_far(state, number)) continue;
        state->open[number] |= (uint8_t)s->open;
        if (is_average(s, number)) state->greatest[number] = 2;
        for (size_t k = 0; k < s->count && s->count <= LARGEST_STAR; k++) {
            const size_t face = norma_check_face_of(s->m, s->corners[k]);
            const double cosine =
                says_something(s->m, face) ? norma_check_cosine_to(s->m, face, number) : -2;
            state->greatest[number] = fmaxf(state->greatest[number], (float)cosine);
        }
    }
}

/* Marks the positions at which a corner has a far normal. */
static void mark_positions(const check_mesh *m, const far_state *state, uint8_t *marks) {
    memset(marks, 0, m->mesh.positions.count);
    for (size_t f = 0; f < m->mesh.face_count; f++)
        for (size_t c = norma_core_face_begin(&m->mesh, f); c < norma_core_face_end(&m->mesh, f);
             c++)
            if (is_far(state, norma_check_normal_of(m, f, c))) marks[m->topology.corners[c]] = 1;
}

static void judge_position(const check_mesh *m, size_t position, far_state *state) {
    const core_corners_of_position *around = &m->topology.corners_of;
    star s = {.m = m,
        .corners = &around->corners[around->starts[position]],
        .count = around->starts[position + 1] - around->starts[position]};
    int any = 0; /* none, if all turned out to be averages at positions before */
    for (size_t i = 0; i < s.count && !any; i++)
        any = is_far(
            state, norma_check_normal_of(m, norma_check_face_of(m, s.corners[i]), s.corners[i]));
    if (!any) return;
    sum_star(&s);
    judge_star(&s, state);
}

static norma_result judge_stars(check_mesh *m, far_state *state) {
    const core_call *call = &m->run->call;
    norma_result result = norma_check_around(m);
    uint8_t *marks = norma_core_allocate(call, m->mesh.positions.count, 1);
    if (!result && !marks) result = NORMA_ERROR_MEMORY;
    if (!result) {
        mark_positions(m, state, marks);
        for (size_t p = 0; p < m->topology.corners_of.position_count; p++)
            if (marks[p]) judge_position(m, p, state);
    }
    norma_core_release(call, marks, m->mesh.positions.count, 1);
    return result;
}

/* ---- the finding */

static norma_result add_far(check_mesh *m, const far_state *state) {
    check_hits hits = {0};
    for (size_t i = 0; i < norma_check_normal_count(m); i++)
        if (is_far(state, i) && state->open[i])
            norma_check_hit(m->run, &hits,
                norma_check_arc_cosine(fmax((double)state->greatest[i], -1)) * (180 / NORMA_PI),
                norma_check_normal_spot(m, i));
    return norma_check_report(m,
        &(check_report){.rule = RULE_N202,
            .severity = m->on_purpose ? NORMA_SEVERITY_INFO : NORMA_SEVERITY_WARNING,
            .unit = "deg",
            .hits = &hits},
        "%z normal%s more than 75 degrees from every face at the position, up to %g, and far "
        "from every average of those faces",
        hits.count, norma_check_plural(hits.count), hits.worst);
}

norma_result norma_check_far(check_mesh *m) {
    const core_call *call = &m->run->call;
    const size_t count = norma_check_normal_count(m);
    far_state state = {norma_core_allocate(call, count, sizeof *state.greatest),
        norma_core_allocate(call, count, 1)};
    norma_result result = state.greatest && state.open ? NORMA_OK : NORMA_ERROR_MEMORY;
    if (!result) {
        memset(state.open, 0, count);
        find_nearest(m, &state);
        result = judge_stars(m, &state);
    }
    if (!result) result = add_far(m, &state);
    norma_core_release(call, state.open, count, 1);
    norma_core_release(call, state.greatest, count, sizeof *state.greatest);
    return result;
}
