/* smoothed.c: N207: hard edges that are shaded as if they were round. */
#include "check/rules/rules.h"
#include "core/face/face.h"
#include <string.h>

enum { FACES_IN_BLOCK = 1 << 13 };
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
    norma_result result = norma_check_is_placeholder(m, &is_placeholder);
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
