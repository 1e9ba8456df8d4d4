/* N201 to N204, N206 and N207: stored normals against the faces around them. Begin at
 * norma_check_facing, at the end. */
#include "check/explain/explain.h"
#include "check/rules/rules.h"
#include "core/face/face.h"
#include <math.h>
#include <string.h>

/* ---- Which faces have normals on their other side at every corner, for the rules on normals
 * against faces. */

enum { FACES_IN_BLOCK = 1 << 13 };
static const double ACROSS = 1e-6; /* a normal along its face, up to rounding, opposes nothing */

#define FAR_COSINE 0.25881904510252074 /* of 75 degrees */

enum { OPPOSED_FACES, FAR_CORNERS }; /* counts; the area is that of the faces */

typedef struct facing_pass {
    const check_mesh *m;
    double across;
} facing_pass;

/* The greatest over the face's corners; NaN: a normal there has no direction. far:
 * counts corners whose normal is far from the face. */
static double check_greatest_cosine(const check_mesh *m, size_t face, size_t *far) {
    double greatest = -2;
    int whole = 1;
    for (size_t c = norma_core_face_begin(&m->mesh, face); c < norma_core_face_end(&m->mesh, face);
         ++c) {
        const size_t number = norma_check_normal_of(m, face, c);
        const double cosine = norma_check_cosine_to(m, face, number);
        if (cosine < FAR_COSINE) {
            ++*far;
            atomic_store_explicit(&m->far[number], 1, memory_order_relaxed);
        }
        whole &= !isnan(cosine);
        greatest = cosine > greatest ? cosine : greatest;
    }
    return whole ? greatest : NAN;
}

static void judge_opposed(const void *context, check_sum *part, size_t begin, size_t end) {
    const facing_pass *pass = context;
    const check_mesh *m = pass->m;
    for (size_t f = begin; f < end; ++f) {
        m->opposed[f] = 0;
        if (!norma_check_directed(&m->faces[f]) || norma_check_is_sliver(&m->faces[f])) continue;
        const double greatest = check_greatest_cosine(m, f, &part->counts[FAR_CORNERS]);
        if (!(greatest < -pass->across) || greatest < -1.5) continue;
        m->opposed[f] = 1;
        ++part->counts[OPPOSED_FACES];
        part->twice_area += norma_check_twice_area(m, f);
    }
}

/* Fills m->opposed. */
static norma_result check_opposed(check_mesh *m) {
    check_sum sum = {.twice_area = 0};
    if (m->opposed) return NORMA_OK;
    norma_result result = norma_check_faces(m);
    if (!result) result = norma_check_users(m);
    if (result) return result;
    const facing_pass pass = {m, fmax(ACROSS, norma_check_encoding_bound(m->given->info.encoding))};
    m->opposed = norma_core_allocate(&m->run->call, m->mesh.face_count, 1);
    m->far = norma_core_allocate(&m->run->call, norma_check_normal_count(m), sizeof *m->far);
    if (!m->opposed || !m->far) return NORMA_ERROR_MEMORY;
    memset((void *)m->far, 0, norma_check_normal_count(m) * sizeof *m->far);
    result =
        norma_check_gather(m->run, m->mesh.face_count, FACES_IN_BLOCK, judge_opposed, &pass, &sum);
    m->opposed_count = sum.counts[OPPOSED_FACES];
    m->opposed_area = sum.twice_area;
    m->far_count = sum.counts[FAR_CORNERS];
    return result;
}

/* ---- N203: one and the same normal nearly everywhere, on a mesh that is curved. */

static const double MOST_ALIKE = .95; /* of the normals */
static const double MOST_FLAT = .95;  /* of the faces: more of them within the angle of one
                                         direction, or against it, make a flat mesh */
static const double FLAT_COSINE = 0.9961946980917455; /* of 5 degrees */

static int is_used(const check_mesh *m, size_t number) {
    return !m->users || m->users[number] != UINT32_MAX;
}

static int same(const double a[3], const double b[3]) {
    return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

/* The one that more than half of them are, if there is one (Boyer and Moore 1981). */
static void find_majority(const check_mesh *m, double majority[3]) {
    size_t count = norma_check_normal_count(m), lead = 0;
    for (size_t i = 0; i < count; ++i) {
        double n[3];
        if (!is_used(m, i)) continue;
        norma_check_normal(m, i, n);
        if (!lead) memcpy(majority, n, sizeof n);
        lead = !lead || same(n, majority) ? lead + 1 : lead - 1;
    }
}

static size_t count_alike_normals(const check_mesh *m, const double normal[3], size_t *used) {
    size_t count = norma_check_normal_count(m), alike = 0;
    *used = 0;
    for (size_t i = 0; i < count; ++i) {
        double n[3];
        if (!is_used(m, i)) continue;
        norma_check_normal(m, i, n);
        ++*used;
        alike += same(n, normal) != 0;
    }
    return alike;
}

/* Flat: nearly all faces that have a direction look along one line. Whether it is that of most of
 * them is tried with each of a few. */
static int is_curved(const check_mesh *m) {
    enum { TRIES = 16 };
    size_t directed = 0, best = 0, faces = m->mesh.face_count;
    for (size_t f = 0; f < faces; ++f) directed += norma_check_directed(&m->faces[f]) != 0;
    for (size_t i = 0; i < TRIES && i < faces; ++i) {
        size_t try = i * (faces / (faces < TRIES ? faces : TRIES)), alike = 0;
        const double n[3] = {(double)m->faces[try].normal[0], (double)m->faces[try].normal[1],
            (double)m->faces[try].normal[2]};
        for (size_t f = 0; f < faces; ++f)
            alike += fabs(norma_check_dot(m->faces[f].normal, n)) > FLAT_COSINE;
        best = alike > best ? alike : best;
    }
    return directed > 1 && (double)best < MOST_FLAT * (double)directed;
}

typedef struct placeholder {
    double normal[3];
    size_t alike, used;
} placeholder;

static norma_result find_placeholder(check_mesh *m, placeholder *p) {
    const int known = m->placeholder;
    *p = (placeholder){.used = 0};
    m->placeholder = CHECK_NO;
    if (known == CHECK_NO || !norma_check_normal_count(m) ||
        m->given->info.normals == NORMA_NORMALS_PER_FACET || !m->mesh.face_count)
        return NORMA_OK;
    norma_result result = norma_check_users(m);
    if (result) return result;
    find_majority(m, p->normal);
    p->alike = count_alike_normals(m, p->normal, &p->used);
    if (!p->used || (double)p->alike <= MOST_ALIKE * (double)p->used ||
        !norma_core_finite(p->normal) ||
        (p->normal[0] == 0 && p->normal[1] == 0 && p->normal[2] == 0))
        return NORMA_OK;
    result = norma_check_faces(m);
    if (!result && is_curved(m)) m->placeholder = CHECK_YES;
    return result;
}

static norma_result holds_placeholder(check_mesh *m, int *is) {
    placeholder p;
    const norma_result result = m->placeholder ? NORMA_OK : find_placeholder(m, &p);
    *is = m->placeholder == CHECK_YES;
    return result;
}

norma_result norma_check_placeholder(check_mesh *m) {
    placeholder p;
    if (!norma_check_wants(m, RULE_N203)) return NORMA_OK;
    const norma_result result = find_placeholder(m, &p);
    if (result || m->placeholder != CHECK_YES) return result;
    return norma_check_report_one(m, RULE_N203,
        m->on_purpose ? NORMA_SEVERITY_INFO : NORMA_SEVERITY_WARNING, NAN,
        "lit like a flat plate: %z of %z normals are (%g, %g, %g), although the mesh is curved",
        p.alike, p.used, p.normal[0], p.normal[1], p.normal[2]);
}

/* ---- N204: how far the stored normals are from the computed ones that explain them best. */

static void describe_way(const norma_deviation *d, char text[CHECK_MESSAGE]) {
    norma_check_message(text,
        d->shading == NORMA_SHADING_FLAT     ? "flat shading"
        : d->shading == NORMA_SHADING_SMOOTH ? "%s weights, smooth"
                                             : "%s weights, crease %g",
        norma_weight_name(d->weight), d->crease_angle_rad * (180 / NORMA_PI));
}

/* Normals that corners use: each vertex, each vn. */
static size_t count_normals(const check_mesh *m) {
    size_t count = norma_check_normal_count(m), used = 0;
    for (size_t i = 0; i < count && m->users; ++i) used += m->users[i] != UINT32_MAX;
    return m->users ? used : count;
}

/* Each looks at what the rule is about, whether it is wanted or not, once a mesh. */
static norma_result check_deviation_of(check_mesh *m, const norma_deviation **deviation) {
    *deviation = &m->deviation;
    if (m->has_deviation || !m->mesh.corner_count || !norma_check_normal_count(m) ||
        m->given->info.normals == NORMA_NORMALS_PER_FACET)
        return NORMA_OK;
    norma_result result = norma_check_users(m);
    if (!result) result = norma_check_around(m);
    if (!result)
        result = norma_explain_with(&m->run->call, &m->given->data, &m->mesh, &m->topology,
            &m->deviation, &m->deviation_corner);
    m->has_deviation = !result;
    return result;
}

norma_result norma_check_deviation(check_mesh *m) {
    const norma_deviation *deviation;
    const double degrees = 180 / NORMA_PI;
    char how[CHECK_MESSAGE];
    if (!norma_check_wants(m, RULE_N204)) return NORMA_OK;
    const norma_result result = check_deviation_of(m, &deviation);
    if (result || !deviation->corners) return result;
    check_hits hits = {0};
    norma_check_hit_greatest(m, &hits, deviation->max_rad * degrees, m->deviation_corner);
    hits.count = count_normals(m);
    describe_way(deviation, how);
    return norma_check_report(m,
        &(check_finding){.rule = RULE_N204,
            .severity = NORMA_SEVERITY_INFO,
            .unit = "deg",
            .hits = &hits,
            .deviation = deviation},
        "best explained by %s: %z stored normals, median %g, 99 %% within %g, at most %g degrees "
        "off",
        how, hits.count, deviation->p50_rad * degrees, deviation->p99_rad * degrees,
        deviation->max_rad * degrees);
}

/* ---- N206: normals of another frame. Nothing that could have been computed from the surface
 * is near them; often they were reversed, mirrored or rotated and the surface was not. */

static const double OTHER_FRAME_RAD = 0.52359877559829882; /* 30 degrees */

typedef struct opposed_sides {
    size_t turned, right, undecided;
    double right_area; /* twice */
} opposed_sides;

/* Of the faces that normals oppose, after check_opposed. */
static norma_result find_sides(check_mesh *m, opposed_sides *sides) {
    uint8_t *of_faces = norma_core_allocate(&m->run->call, m->mesh.face_count, 1);
    norma_result result =
        of_faces ? norma_check_sides(m, m->opposed, of_faces) : NORMA_ERROR_MEMORY;
    *sides = (opposed_sides){0};
    for (size_t f = 0; !result && f < m->mesh.face_count; ++f) {
        if (!m->opposed[f]) continue;
        const int undecided = (of_faces[f] & CORE_SIDE_UNDECIDED) != 0,
                  turned = !undecided && of_faces[f] & CORE_SIDE_TURNED;
        sides->undecided += (size_t)undecided;
        sides->turned += (size_t)turned;
        if (undecided || turned) continue;
        ++sides->right;
        sides->right_area += norma_check_twice_area(m, f);
    }
    norma_core_release(&m->run->call, of_faces, m->mesh.face_count, 1);
    return result;
}

/* The winding is shown to be wrong, or that is undecided, for more than a hundredth of the area
 * where normals and winding disagree: then N201 says so, and to compute all normals again would
 * reverse some that are right. */
static norma_result is_winding_in_doubt(check_mesh *m, int *in_doubt) {
    opposed_sides sides;
    *in_doubt = 0;
    norma_result result = check_opposed(m);
    if (result || !m->opposed_count) return result;
    result = find_sides(m, &sides);
    *in_doubt = !(sides.right_area > 0.99 * m->opposed_area);
    return result;
}

/* The best explanation need not be looked for where a likely one is good enough. */
static norma_result is_near_surface(check_mesh *m, int *is_near) {
    *is_near = 0;
    if (m->has_deviation || !m->mesh.face_count || !norma_check_normal_count(m) ||
        m->given->info.normals == NORMA_NORMALS_PER_FACET)
        return NORMA_OK;
    const norma_result result = norma_check_around(m);
    const norma_deviation *likely = norma_places_deviation(m->run->known, m->given->info.where);
    return result ? result
                  : norma_explain_is_near(
                        &m->run->call, &m->given->data, &m->mesh, &m->topology, likely, is_near);
}

norma_result norma_check_is_of_another_frame(check_mesh *m, int *is) {
    const norma_deviation *deviation;
    int is_near = 0, is_placeholder = 0, in_doubt = 0;
    *is = m->frame == CHECK_YES;
    if (m->frame) return NORMA_OK;
    m->frame = CHECK_NO;
    norma_result result = is_near_surface(m, &is_near);
    if (result || is_near) return result;
    result = check_deviation_of(m, &deviation);
    if (result || !deviation->corners || !(deviation->p50_rad > OTHER_FRAME_RAD)) return result;
    result = holds_placeholder(m, &is_placeholder);
    if (!result && !is_placeholder) result = is_winding_in_doubt(m, &in_doubt);
    if (result || is_placeholder || in_doubt) return result;
    m->frame = CHECK_YES;
    *is = 1;
    return NORMA_OK;
}

/* ---- in words */

static void describe_frame(const explain_frame *f, char text[CHECK_MESSAGE]) {
    const double *axis = f->axis, degrees = f->angle_rad * (180 / NORMA_PI);
    switch (f->kind) {
    case EXPLAIN_FRAME_REVERSED:
        norma_check_message(text, "they are reversed");
        break;
    case EXPLAIN_FRAME_MIRROR:
        norma_check_message(text, "a mirror along the axis (%g, %g, %g) puts them right", axis[0],
            axis[1], axis[2]);
        break;
    case EXPLAIN_FRAME_ROTATION:
        norma_check_message(text,
            "a rotation of %g degrees about the axis (%g, %g, %g) puts them right", degrees,
            axis[0], axis[1], axis[2]);
        break;
    case EXPLAIN_FRAME_BOTH:
        norma_check_message(text,
            "a mirror along the axis (%g, %g, %g) and a rotation of %g degrees about it put them "
            "right",
            axis[0], axis[1], axis[2], degrees);
        break;
    default:
        norma_check_message(text, "no mirror or rotation puts them right, so they may belong to "
                                  "another surface");
    }
}

static norma_result add_frame(check_mesh *m, const explain_frame *frame) {
    char how[CHECK_MESSAGE], way[CHECK_MESSAGE];
    norma_deviation trial;
    const norma_severity severity = m->on_purpose ? NORMA_SEVERITY_INFO : NORMA_SEVERITY_ERROR;
    const double degrees = 180 / NORMA_PI, median = m->deviation.p50_rad * degrees;
    describe_frame(frame, how);
    norma_explain_tell(&frame->trial, &trial);
    describe_way(&trial, way);
    return norma_check_report_one(m, RULE_N206, severity, median,
        frame->kind
            ? "lit from a wrong direction: half of the normals are %g degrees off the surface's or "
              "more; %s, to within %g degrees at half of them (%s)"
            : "lit from a wrong direction: half of the normals are %g degrees off the surface's or "
              "more; %s",
        median, how, frame->median_rad * degrees, way);
}

norma_result norma_check_frame(check_mesh *m) {
    explain_frame frame = {.kind = EXPLAIN_FRAME_NONE};
    int holds = 0;
    if (!norma_check_wants(m, RULE_N206) || !m->mesh.face_count) return NORMA_OK;
    norma_result result = norma_check_is_of_another_frame(m, &holds);
    if (result || !holds) return result;
    if (!m->run->is_trial) result = norma_check_around(m);
    if (!m->run->is_trial && !result)
        result = norma_explain_find_frame(
            &m->run->call, &m->given->data, &m->mesh, &m->topology, &frame);
    return result ? result : add_frame(m, &frame);
}

/* ---- N202: normals far from every face at their position, and from every average of
 * those faces. */

enum {
    LARGEST_STAR = 1 << 10
}; /* corners at one position: where more meet, a normal is held
      against its own faces and the averages only, or the work would
      grow with their square */
static const double AVERAGE_COSINE = 0.90630778703664994; /* of 25 degrees */

typedef struct far_state {
    float *greatest; /* cosine of each normal: 2: of no face that says anything, or near an average
                      */
    uint8_t *open;   /* of each normal: NOT_OPPOSED of some face at its positions, LARGE of one that
                        is shaded by it */
    double large;    /* four times the area of a face */
    int turned;      /* N201 names most of the faces */
} far_state;
enum { NOT_OPPOSED = 1, LARGE = 2 };   /* not named by N201; large enough for a spot to be seen */
static const double LARGE_SHARE = .02; /* of the diagonal: the longest edge of half a square */

static int says_something(const check_mesh *m, size_t face) {
    return norma_check_directed(&m->faces[face]) && !norma_check_is_sliver(&m->faces[face]);
}

/* Against the faces of its own vertices, of those that are far from one of them. */
static void find_nearest(const check_mesh *m, far_state *state) {
    for (size_t i = 0; i < norma_check_normal_count(m); ++i) state->greatest[i] = 2;
    for (size_t f = 0; f < m->mesh.face_count; ++f) {
        for (size_t c = norma_core_face_begin(&m->mesh, f); c < norma_core_face_end(&m->mesh, f);
             ++c) {
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
    return number != SIZE_MAX && (double)state->greatest[number] < FAR_COSINE;
}

/* ---- a position: where vertices are split, as in a triangle soup, a smooth normal is the average
 * of faces that use other vertices */

typedef struct star {
    const check_mesh *m;
    const uint32_t *corners;
    size_t count;
    double averages[6][3]; /* uniform, by area, by angle, then again with those faces turned that
                              N201 names, whose winding may be wrong; not of unit length */
    int open;              /* as in far_state */
    int opposed;           /* > 0: N201 names most of its faces */
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
    s->open = s->opposed = 0;
    for (size_t i = 0; i < s->count; ++i) {
        const size_t face = norma_check_face_of(m, s->corners[i]);
        if (!says_something(m, face)) continue;
        const double weights[3] = {
            1, norma_check_twice_area(m, face), angle_at(m, face, s->corners[i])};
        for (int w = 0; w < 6; ++w)
            for (int k = 0; k < 3; ++k)
                s->averages[w][k] += (w > 2 && m->opposed[face] ? -1 : 1) * weights[w % 3] *
                                     (double)m->faces[face].normal[k];
        s->opposed += m->opposed[face] ? 1 : -1;
        if (!m->opposed[face]) s->open |= NOT_OPPOSED;
    }
}

/* Or of the faces as turned, where most are: their winding may be wrong, and the normals right. */
static int is_average(const star *s, size_t number, int turned) {
    double n[3];
    norma_check_normal(s->m, number, n);
    const double length = norma_core_length(n);
    for (int w = 0; w < 6; ++w) {
        const double along = norma_core_dot(n, s->averages[w]);
        if ((turned || s->opposed > 0 ? fabs(along) : along) >
            AVERAGE_COSINE * length * norma_core_length(s->averages[w]))
            return 1;
    }
    return 0;
}

static void judge_star(const star *s, far_state *state) {
    for (size_t i = 0; i < s->count; ++i) {
        const size_t own = norma_check_face_of(s->m, s->corners[i]),
                     number = norma_check_normal_of(s->m, own, s->corners[i]);
        if (!is_far(state, number)) continue;
        state->open[number] |= (uint8_t)s->open;
        if (2 * norma_check_twice_area(s->m, own) >= state->large) state->open[number] |= LARGE;
        if (is_average(s, number, state->turned)) state->greatest[number] = 2;
        for (size_t k = 0; k < s->count && s->count <= LARGEST_STAR; ++k) {
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
    for (size_t f = 0; f < m->mesh.face_count; ++f)
        for (size_t c = norma_core_face_begin(&m->mesh, f); c < norma_core_face_end(&m->mesh, f);
             ++c)
            if (is_far(state, norma_check_normal_of(m, f, c))) marks[m->topology.corners[c]] = 1;
}

static void judge_far_position(const check_mesh *m, size_t position, far_state *state) {
    const core_corners_of_position *around = &m->topology.corners_of;
    star s = {.m = m,
        .corners = &around->corners[around->starts[position]],
        .count = around->starts[position + 1] - around->starts[position]};
    int any = 0; /* none, if all turned out to be averages at positions before */
    for (size_t i = 0; i < s.count && !any; ++i)
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
        for (size_t p = 0; p < m->topology.corners_of.position_count; ++p)
            if (marks[p]) judge_far_position(m, p, state);
    }
    norma_core_release(call, marks, m->mesh.positions.count, 1);
    return result;
}

/* ---- the finding */

static norma_result add_far(check_mesh *m, const far_state *state, int large) {
    check_hits hits = {0};
    for (size_t i = 0; i < norma_check_normal_count(m); ++i)
        if (is_far(state, i) && state->open[i] & NOT_OPPOSED &&
            ((state->open[i] & LARGE) != 0 || m->on_purpose) == large)
            norma_check_hit(m->run, &hits,
                norma_check_arc_cosine(fmax((double)state->greatest[i], -1)) * (180 / NORMA_PI),
                norma_check_normal_spot(m, i));
    return norma_check_report(m,
        &(check_finding){.rule = RULE_N202,
            .severity = m->on_purpose || !large ? NORMA_SEVERITY_INFO : NORMA_SEVERITY_WARNING,
            .unit = "deg",
            .hits = &hits},
        "spots or smears in the shading: %z normal%s more than 75 degrees from every face at the "
        "position, up to %g, and far from every average of those faces%s",
        hits.count, hits.count == 1 ? " is" : "s are", hits.worst,
        large ? "" : "; all of them are small");
}

/* m->opposed is filled. */
static norma_result check_far(check_mesh *m) {
    const core_call *call = &m->run->call;
    const size_t count = norma_check_normal_count(m);
    const double edge = LARGE_SHARE * norma_check_diagonal(&m->mesh);
    far_state state = {norma_core_allocate(call, count, sizeof *state.greatest),
        norma_core_allocate(call, count, 1), edge * edge,
        m->opposed_count > m->mesh.face_count / 2};
    norma_result result = state.greatest && state.open ? NORMA_OK : NORMA_ERROR_MEMORY;
    if (!result) {
        memset(state.open, 0, count);
        find_nearest(m, &state);
        result = judge_stars(m, &state);
    }
    if (!result) result = add_far(m, &state, 1);
    if (!result) result = add_far(m, &state, 0);
    norma_core_release(call, state.open, count, 1);
    norma_core_release(call, state.greatest, count, sizeof *state.greatest);
    return result;
}

/* ---- N201: normals on the other side of their faces. */

/* ---- which is wrong, the normals or the winding */

static void describe_sides(const opposed_sides *s, char text[CHECK_MESSAGE]) {
    const char *turn = s->turned == 1 ? "face" : "faces";
    if (!s->turned && !s->undecided)
        norma_check_message(text, "the normals are wrong, the winding is right");
    else if (!s->right && !s->undecided)
        norma_check_message(
            text, "the winding is wrong (%z %s to turn), the normals are right", s->turned, turn);
    else if (!s->right && !s->turned)
        norma_check_message(
            text, "neither volume nor rays show whether the normals or the winding are wrong");
    else if (!s->undecided)
        norma_check_message(text,
            "the normals are wrong at %z of them, the winding of %z %s is wrong", s->right,
            s->turned, turn);
    else
        norma_check_message(text,
            "the normals are wrong at %z of them, the winding of %z %s is wrong, and for %z "
            "neither "
            "volume nor rays show which",
            s->right, s->turned, turn, s->undecided);
}

static void gather_hits(check_mesh *m, check_hits *hits) {
    for (size_t f = 0; f < m->mesh.face_count; ++f) {
        size_t far = 0;
        if (!m->opposed[f]) continue;
        norma_check_hit(m->run, hits,
            norma_check_arc_cosine(fmax(check_greatest_cosine(m, f, &far), -1)) *
                (180 / 3.141592653589793),
            norma_check_face(f));
    }
}

static norma_result add_opposed(check_mesh *m) {
    char which[CHECK_MESSAGE];
    const double whole = norma_check_add_areas(m, 0),
                 part = whole > 0 ? m->opposed_area / whole : 0;
    const norma_severity severity = m->on_purpose || part < SPECK ? NORMA_SEVERITY_INFO
                                    : part > .01                  ? NORMA_SEVERITY_ERROR
                                                                  : NORMA_SEVERITY_WARNING;
    opposed_sides sides;
    check_hits hits = {0};
    const norma_result result = find_sides(m, &sides);
    if (result) return result;
    gather_hits(m, &hits);
    describe_sides(&sides, which);
    return norma_check_report(m,
        &(check_finding){.rule = RULE_N201,
            .severity = severity,
            .unit = "deg",
            .no_fix = !sides.turned && !sides.right,
            .hits = &hits},
        "lit from behind: at %z of %z faces (%g %% of the area) every corner's normal points to "
        "the back of the face; %s",
        hits.count, m->mesh.face_count, 100 * part, which);
}

/* ---- both rules */

norma_result norma_check_facing(check_mesh *m) {
    int other_frame = 0;
    if (!norma_check_normal_count(m) || m->given->info.normals == NORMA_NORMALS_PER_FACET ||
        !m->mesh.face_count || !norma_check_wants_any(m, RULE_N201, RULE_N202))
        return NORMA_OK;
    norma_result result = check_opposed(m);
    if (!result && (m->opposed_count || m->far_count))
        result = norma_check_is_of_another_frame(m, &other_frame);
    if (result || other_frame) return result;
    if (m->opposed_count && norma_check_wants(m, RULE_N201)) result = add_opposed(m);
    return !result && m->far_count && norma_check_wants(m, RULE_N202) ? check_far(m) : result;
}

/* ---- N207: hard edges that are shaded as if they were round. */

static const double HARD_COSINE = .5;               /* of 60 degrees */
static const double OFF_COSINE = .7071067811865476; /* of 45 degrees */
static const double SMOOTHED_SHARE = .05;           /* of the area */

typedef struct smoothed_pass {
    const check_mesh *m;
    double same_cosine; /* normals that are nearer are the same */
} smoothed_pass;

/* Of unit length; 0: there is none. */
static int unit_normal(const check_mesh *m, size_t face, size_t corner, double normal[3]) {
    const size_t number = norma_check_normal_of(m, face, corner);
    if (number == SIZE_MAX) return 0;
    norma_check_normal(m, number, normal);
    const double length = norma_core_length(normal);
    for (int k = 0; k < 3; ++k) normal[k] /= length;
    return length > 1e-6 && length < INFINITY;
}

static int is_same_normal(
    const smoothed_pass *pass, size_t face, size_t corner, size_t other, size_t other_corner) {
    double a[3], b[3];
    return unit_normal(pass->m, face, corner, a) && unit_normal(pass->m, other, other_corner, b) &&
           norma_core_dot(a, b) > pass->same_cosine;
}

/* The edge that begins at the corner bends, and both faces have one normal at each of its ends. */
static int is_smoothed_over(const smoothed_pass *pass, size_t face, size_t corner) {
    const check_mesh *m = pass->m;
    const core_topology *t = &m->topology;
    const uint32_t partner = t->partners[corner];
    if (partner >= CORE_EDGE_SPECIAL) return 0;
    const size_t other = norma_core_topology_face(t, partner);
    const float *n = m->faces[other].normal;
    if (!norma_check_directed(&m->faces[other]) || norma_check_is_sliver(&m->faces[other]) ||
        norma_check_dot(m->faces[face].normal,
            (const double[3]){(double)n[0], (double)n[1], (double)n[2]}) >= HARD_COSINE)
        return 0;
    return is_same_normal(pass, face, corner, other, norma_core_topology_next(t, other, partner)) &&
           is_same_normal(pass, face, norma_core_topology_next(t, face, corner), other, partner);
}

/* Between the face and the normal interpolated at the middle of one of its triangles; from the back
 * of a face that all its normals oppose: N201 says so, and smoothing is something else. */
static double cosine_at_middle(double normals[3][3], const float face[3]) {
    double n[3];
    int opposed = 1;
    for (int k = 0; k < 3; ++k) opposed &= norma_check_dot(face, normals[k]) < 0;
    for (int d = 0; d < 3; ++d) n[d] = normals[0][d] + normals[1][d] + normals[2][d];
    const double length = norma_core_length(n),
                 cosine = length > 0 ? norma_check_dot(face, n) / length : 1;
    return opposed ? -cosine : cosine;
}

static double twice_triangle_area(
    const core_mesh *mesh, const size_t corners[3], const float face[3]) {
    double p[3][3], a[3], b[3], cross[3];
    for (int k = 0; k < 3; ++k)
        norma_core_position(mesh, norma_core_corner(mesh, corners[k]), p[k]);
    norma_core_subtract(p[1], p[0], a);
    norma_core_subtract(p[2], p[0], b);
    norma_core_cross(a, b, cross);
    return fabs(norma_check_dot(face, cross));
}

/* Of a face, as a fan. Returns twice the area over which it is shaded far from itself. */
static double area_far(const check_mesh *m, size_t face, double *worst) {
    const size_t begin = norma_core_face_begin(&m->mesh, face),
                 end = norma_core_face_end(&m->mesh, face);
    double sum = 0;
    for (size_t c = begin + 1; c + 1 < end; ++c) {
        const size_t corners[3] = {begin, c, c + 1};
        double normals[3][3];
        int whole = 1;
        for (int k = 0; k < 3; ++k) whole &= unit_normal(m, face, corners[k], normals[k]);
        const double cosine = whole ? cosine_at_middle(normals, m->faces[face].normal) : 1;
        *worst = fmin(*worst, cosine);
        if (cosine < OFF_COSINE)
            sum += twice_triangle_area(&m->mesh, corners, m->faces[face].normal);
    }
    return sum;
}

static void judge_shading(const void *context, check_sum *part, size_t begin, size_t end) {
    const smoothed_pass *pass = context;
    const check_mesh *m = pass->m;
    for (size_t f = begin; f < end; ++f) {
        size_t c = norma_core_face_begin(&m->mesh, f);
        const size_t last = norma_core_face_end(&m->mesh, f);
        double worst = 1;
        if (!norma_check_directed(&m->faces[f]) || norma_check_is_sliver(&m->faces[f])) continue;
        while (c < last && !is_smoothed_over(pass, f, c)) ++c;
        const double area = c < last ? area_far(m, f, &worst) : 0;
        if (!(area > 0)) continue;
        part->twice_area += area;
        norma_check_hit(m->run, &part->hits[0],
            norma_check_arc_cosine(fmax(worst, -1)) * (180 / NORMA_PI), norma_check_face(f));
    }
}

static norma_result add_smoothed(check_mesh *m, double twice_area, check_hits *hits) {
    const double whole = norma_check_add_areas(m, 0);
    int is_placeholder = 0, other_frame = 0;
    if (!(twice_area > SMOOTHED_SHARE * whole)) return NORMA_OK;
    norma_result result = holds_placeholder(m, &is_placeholder);
    if (!result) result = norma_check_is_of_another_frame(m, &other_frame);
    if (result || is_placeholder || other_frame) return result;
    return norma_check_report(m,
        &(check_finding){.rule = RULE_N207,
            .severity = m->on_purpose ? NORMA_SEVERITY_INFO : NORMA_SEVERITY_WARNING,
            .unit = "deg",
            .hits = hits},
        "shaded as if round: at %z of %z faces, all with hard edges, the shading is more than 45 "
        "degrees off the face, by up to %g, over %g %% of the area; a crease of 60 degrees makes "
        "these edges hard",
        hits->count, m->mesh.face_count, hits->worst, 100 * twice_area / whole);
}

norma_result norma_check_smoothed(check_mesh *m) {
    if (!m->mesh.face_count || !norma_check_wants(m, RULE_N207) || !norma_check_normal_count(m) ||
        m->given->info.normals == NORMA_NORMALS_PER_FACET)
        return NORMA_OK;
    norma_result result = norma_check_pairs(m);
    check_sum sum = {.twice_area = 0};
    const smoothed_pass pass = {m,
        cos(fmax(1 / (180 / NORMA_PI), 2 * norma_check_encoding_bound(m->given->info.encoding)))};
    if (!result)
        result = norma_check_gather(
            m->run, m->mesh.face_count, FACES_IN_BLOCK, judge_shading, &pass, &sum);
    if (!result) result = add_smoothed(m, sum.twice_area, &sum.hits[0]);
    norma_check_sum_free(&sum);
    return result;
}
