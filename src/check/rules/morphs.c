/* morphs.c: N901 to N903: morph targets that turn the surface and not its normals, that cancel
 * normals, that have normals where the mesh has none. */
#include "check/rules/rules.h"
#include "check/findings/check_run.h"
#include "core/face/face.h"
#include <math.h>
#include <string.h>

static const double BENDS_DEG = 5, BENDS_MUCH_DEG = 30, CANCELS = 0.1, NO_LENGTH = 1e-6,
                    DEGENERATE = 1e-6;

static inline double greater_square(double a, double b) { return a > b ? a : b; }

/* ---- N901 */

static void moved_position(
    const check_mesh *m, const norma_vec3_view *deltas, uint32_t v, double p[3]) {
    double delta[3];
    norma_core_position(&m->mesh, v, p);
    norma_view_read(deltas, v, delta);
    for (int k = 0; k < 3; ++k) p[k] += delta[k];
}

static int moves(const check_mesh *m, const norma_vec3_view *deltas, size_t face) {
    double delta[3];
    for (size_t c = norma_core_face_begin(&m->mesh, face); c < norma_core_face_end(&m->mesh, face);
         ++c) {
        norma_view_read(deltas, norma_core_corner(&m->mesh, c), delta);
        if (delta[0] != 0 || delta[1] != 0 || delta[2] != 0) return 1;
    }
    return 0;
}

/* A normal of the moved face; 0 where it has become degenerate. */
static int moved_normal(
    const check_mesh *m, const norma_vec3_view *deltas, size_t face, double normal[3]) {
    size_t begin = norma_core_face_begin(&m->mesh, face), end = norma_core_face_end(&m->mesh, face);
    double first[3], before[3], p[3], longest = 0;
    moved_position(m, deltas, norma_core_corner(&m->mesh, begin), first);
    memset(before, 0, sizeof before);
    memset(normal, 0, 3 * sizeof *normal);
    for (size_t c = begin + 1; c < end; ++c) {
        double edge[3];
        moved_position(m, deltas, norma_core_corner(&m->mesh, c), p);
        norma_core_subtract(p, first, edge);
        longest = greater_square(longest, norma_core_dot(edge, edge));
        if (c > begin + 1) {
            double between[3];
            norma_core_subtract(edge, before, between);
            longest = greater_square(longest, norma_core_dot(between, between));
            normal[0] += before[1] * edge[2] - before[2] * edge[1];
            normal[1] += before[2] * edge[0] - before[0] * edge[2];
            normal[2] += before[0] * edge[1] - before[1] * edge[0];
        }
        memcpy(before, edge, sizeof before);
    }
    double twice_area = norma_core_length(normal);
    return twice_area > DEGENERATE * longest && isfinite(twice_area);
}

/* 0 where it is no more than BENDS_DEG. */
static double bend_of_face_deg(const check_mesh *m, const norma_vec3_view *deltas, size_t face) {
    static const double tangent = 0.08748866352592401; /* of BENDS_DEG */
    const check_face *at_rest = &m->faces[face];
    double moved[3];
    if (!norma_check_directed(at_rest) || !moves(m, deltas, face) ||
        !moved_normal(m, deltas, face, moved))
        return 0;
    const double n[3] = {
        (double)at_rest->normal[0], (double)at_rest->normal[1], (double)at_rest->normal[2]};
    const double cross[3] = {n[1] * moved[2] - n[2] * moved[1], n[2] * moved[0] - n[0] * moved[2],
        n[0] * moved[1] - n[1] * moved[0]};
    double sine = norma_core_length(cross), cosine = norma_core_dot(n, moved);
    return cosine > 0 && sine <= tangent * cosine
               ? 0
               : norma_core_angle(sine, cosine) * (180 / 3.141592653589793);
}

enum { FACES_IN_BLOCK = 1 << 13 };

typedef struct bend_pass {
    const check_mesh *m;
    const norma_vec3_view *deltas;
} bend_pass;

static void judge_bends(const void *context, check_sum *part, size_t begin, size_t end) {
    const bend_pass *pass = context;
    for (size_t f = begin; f < end; ++f) {
        double bend = bend_of_face_deg(pass->m, pass->deltas, f);
        if (bend > BENDS_DEG)
            norma_check_hit(pass->m->run, &part->hits[0], bend, norma_check_face(f));
    }
}

static norma_result judge_targets(check_mesh *m) {
    check_sum sum = {.twice_area = 0};
    check_hits *hits = &sum.hits[0];
    size_t targets = 0;
    norma_result result = norma_check_faces(m);
    for (size_t t = 0; t < m->given->morph_count && !result; ++t) {
        const norma_morph_data *morph = &m->given->morphs[t];
        const bend_pass pass = {m, &morph->positions};
        const size_t before = hits->count;
        if (morph->normals.count || morph->positions.count < m->mesh.positions.count) continue;
        result = norma_check_gather(
            m->run, m->mesh.face_count, FACES_IN_BLOCK, judge_bends, &pass, &sum);
        targets += hits->count > before;
    }
    if (result) {
        norma_check_sum_free(&sum);
        return result;
    }
    return norma_check_report(m,
        &(check_finding){.rule = RULE_N901,
            .severity = hits->worst > BENDS_MUCH_DEG ? NORMA_SEVERITY_WARNING : NORMA_SEVERITY_INFO,
            .unit = "deg",
            .hits = hits},
        "the moved surface is shaded as if it had not moved: %z of %z morph targets turn faces "
        "(by up to %g degrees) but have no normals",
        targets, m->given->morph_count, hits->worst);
}

/* ---- N902 */

static norma_result judge_sums(check_mesh *m) {
    check_hits hits = {.least = 1};
    size_t normals = norma_check_normal_count(m);
    for (size_t t = 0; t < m->given->morph_count; ++t) {
        const norma_vec3_view *deltas = &m->given->morphs[t].normals;
        for (size_t v = 0; v < deltas->count && v < normals; ++v) {
            double n[3], delta[3];
            norma_check_normal(m, v, n);
            norma_view_read(deltas, v, delta);
            if (!(norma_core_length(n) >= NO_LENGTH)) /* already none: N101, N102 */
                continue;
            for (int k = 0; k < 3; ++k) n[k] += delta[k];
            if (norma_core_length(n) < CANCELS)
                norma_check_hit(m->run, &hits, norma_core_length(n), norma_check_vertex(v));
        }
    }
    if (!hits.count) return NORMA_OK;
    return norma_check_report(m,
        &(check_finding){
            .rule = RULE_N902, .severity = NORMA_SEVERITY_WARNING, .unit = "length", .hits = &hits},
        "spots and sparks: %z normal%s reduced to less than a tenth by a morph target at weight 1 "
        "(to %g)",
        hits.count, norma_check_plural(hits.count), hits.worst);
}

/* ---- N903 */

static norma_result judge_bases(check_mesh *m) {
    size_t normals = 0, tangents = 0;
    for (size_t t = 0; t < m->given->morph_count; ++t) {
        normals +=
            m->given->morphs[t].normals.count && m->given->info.normals == NORMA_NORMALS_NONE;
        tangents += m->given->morphs[t].tangents.count && !m->given->attributes.tangents &&
                    !m->given->info.has_tangents;
    }
    if (!normals && !tangents) return NORMA_OK;
    return norma_check_report_one(m, RULE_N903, NORMA_SEVERITY_ERROR, NAN,
        "refused by validators: %z morph target%s with %s to add to those of the mesh, which has "
        "none",
        normals ? normals : tangents, norma_check_plural(normals ? normals : tangents),
        normals ? "normals" : "tangents");
}

norma_result norma_check_morphs(check_mesh *m) {
    if (!m->given->morph_count || !m->given->morphs) return NORMA_OK;
    int lit = norma_check_normal_count(m) > 0 && !m->given->material.unlit;
    norma_result result = lit && norma_check_wants(m, RULE_N901) ? judge_targets(m) : NORMA_OK;
    if (!result && norma_check_wants(m, RULE_N902) &&
        m->given->info.normals == NORMA_NORMALS_PER_VERTEX)
        result = judge_sums(m);
    return !result && norma_check_wants(m, RULE_N903) ? judge_bases(m) : result;
}
