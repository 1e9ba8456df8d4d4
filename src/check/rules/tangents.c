/* tangents.c: N801 to N807: tangents. */
#include "check/rules/rules.h"
#include "check/explain/explain.h"
#include "core/face/unit_length.h"
#include <math.h>
#include <string.h>

/* Tangents serve normal maps only: without one, what is wrong with them is worth knowing, no more.
 */
static norma_severity tangent_severity(const check_mesh *m) {
    return m->given->material.normal_map ? NORMA_SEVERITY_WARNING : NORMA_SEVERITY_INFO;
}

/* ---- N804: the sign of tangents against the winding of the UVs as they are stored, v
 * downwards: +1 if a triangle's signed area in UV is negative, -1 if it is positive. Public sample
 * files follow this, except some that are wrong throughout or in their mirrored islands. A vertex
 * is against its UVs if every face there whose UVs have an area disagrees with its sign. If some
 * vertices of a primitive are against and some with their UVs, one side is wrong, most likely the
 * smaller. If all are against, the normal map may have been made for that. */

enum { WITH = 1, AGAINST = 2 };

static inline double greater(double a, double b) { return a > b ? a : b; }
static inline double largest_of(double a, double b, double c) {
    return greater(fabs(a), greater(fabs(b), fabs(c)));
}

/* Of a triangle in UV: twice its signed area; 0 where that is no more than what rounding the
 * numbers to floats can make, or a sliver's. Relative to the triangle, so that the smallest island
 * counts. */
static double uv_area(const float *a, const float *b, const float *c) {
    const double ab[2] = {(double)b[0] - (double)a[0], (double)b[1] - (double)a[1]},
                 ac[2] = {(double)c[0] - (double)a[0], (double)c[1] - (double)a[1]};
    double area = ab[0] * ac[1] - ab[1] * ac[0];
    double longest =
        greater(largest_of(ab[0], ac[0], ac[0] - ab[0]), largest_of(ab[1], ac[1], ac[1] - ab[1]));
    double far = greater(largest_of((double)a[0], (double)b[0], (double)c[0]),
        largest_of((double)a[1], (double)b[1], (double)c[1]));
    double noise = greater(0x1p-22 * far * longest, 1e-6 * longest * longest);
    return fabs(area) > noise ? area
                              : 0; /* also where one is not finite: nothing is greater than NaN */
}

static uint32_t texcoord_of(const check_mesh *m, size_t corner) {
    const norma_mesh_attributes *a = &m->given->attributes;
    uint32_t number =
        a->corner_texcoords ? a->corner_texcoords[corner] : norma_core_corner(&m->mesh, corner);
    return number < a->texcoord_count ? number : UINT32_MAX;
}

/* A polygon as the fan from its first corner. */
static double face_area(const check_mesh *m, size_t begin, size_t end) {
    const float *uvs = m->given->attributes.texcoords;
    double sum = 0;
    for (size_t c = begin + 1; c + 1 < end; ++c) {
        const uint32_t t[3] = {texcoord_of(m, begin), texcoord_of(m, c), texcoord_of(m, c + 1)};
        if (t[0] == UINT32_MAX || t[1] == UINT32_MAX || t[2] == UINT32_MAX) return 0;
        sum += uv_area(uvs + 2 * (size_t)t[0], uvs + 2 * (size_t)t[1], uvs + 2 * (size_t)t[2]);
    }
    return sum;
}

static void judge_signs(const check_mesh *m, uint8_t *verdicts) {
    const norma_mesh_attributes *a = &m->given->attributes;
    for (size_t f = 0; f < m->mesh.face_count; ++f) {
        size_t begin = norma_core_face_begin(&m->mesh, f), end = norma_core_face_end(&m->mesh, f);
        double area = face_area(m, begin, end);
        if (area == 0) continue;
        float expected = area < 0 ? 1 : -1;
        for (size_t c = begin; c < end; ++c) {
            size_t v = norma_core_corner(&m->mesh, c);
            float sign = v < a->tangent_count ? a->tangents[4 * v + 3] : 0;
            if (sign == 1 || sign == -1) verdicts[v] |= sign == expected ? WITH : AGAINST;
        }
    }
}

/* The normal map that is read through the tangents: " \"wood.png\"", or "" where it has no name. */
static void name_of_map(const check_mesh *m, char text[CHECK_MESSAGE]) {
    const char *name = m->given->material.normal_map && m->run->map_name
                           ? m->run->map_name(m->run->map_names, m->given->attributes.material)
                           : NULL;
    norma_check_message(text, name ? " \"%s\"" : "", name);
}

static norma_result add_signs(check_mesh *m, const uint8_t *verdicts, size_t with, size_t against) {
    char message[CHECK_MESSAGE], map[CHECK_MESSAGE];
    check_hits hits = {0};
    int mixed = with > 0, side = mixed && with < against ? WITH : AGAINST;
    for (size_t v = 0; v < m->mesh.positions.count; ++v)
        if (verdicts[v] == side) norma_check_hit(m->run, &hits, 0, norma_check_vertex(v));
    name_of_map(m, map);
    if (!mixed)
        norma_check_message(message,
            "bumps become dents, unless the normal map%s was made for it: the UVs give the "
            "opposite sign for all tangents whose UVs have an area (%z)",
            map, against);
    else if (side == AGAINST)
        norma_check_message(message,
            "bumps of the normal map%s become dents in one of two groups: %z tangent%s %s the "
            "opposite of the sign that the UVs give, and %z agree%s with the UVs",
            map, against, norma_check_plural(against), against == 1 ? "has" : "have", with,
            with == 1 ? "s" : "");
    else
        norma_check_message(message,
            "bumps of the normal map%s become dents in one of two groups: %z tangent%s %s the sign "
            "that the UVs give, and %z the opposite",
            map, with, norma_check_plural(with), with == 1 ? "has" : "have", against);
    return norma_check_report(m,
        &(check_finding){.rule = RULE_N804,
            .severity = mixed ? tangent_severity(m) : NORMA_SEVERITY_INFO,
            .no_value = 1,
            .no_fix = !mixed,
            .hits = &hits},
        "%s", message);
}

/* N804, where there are tangents */
static norma_result check_tangent_signs(check_mesh *m) {
    size_t count = m->mesh.positions.count, with = 0, against = 0;
    if (!m->given->attributes.texcoords || !count) return NORMA_OK;
    uint8_t *verdicts = norma_core_allocate(&m->run->call, count, 1);
    if (!verdicts) return NORMA_ERROR_MEMORY;
    memset(verdicts, 0, count);
    judge_signs(m, verdicts);
    for (size_t v = 0; v < count; ++v) {
        with += verdicts[v] == WITH;
        against += verdicts[v] == AGAINST;
    }
    norma_result result = against ? add_signs(m, verdicts, with, against) : NORMA_OK;
    norma_core_release(&m->run->call, verdicts, count, 1);
    return result;
}

/* ---- N807: how far the stored tangents are from those of the way to make tangents
 * that explains them best. */

static void describe(const norma_tangent_deviation *d, char message[CHECK_MESSAGE]) {
    const double degrees = 180 / 3.141592653589793;
    norma_check_message(message,
        "tangents are best explained by %s%s, with the sign %s: median %g, 99 %% within %g, at "
        "most %g degrees off; %z of %z corners explained. A normal map baked for these errs by up "
        "to %g degrees (99 %% within %g) if a renderer makes MikkTSpace's tangents on triangles, "
        "%g (%g) with meshoptimizer's, %g (%g) with sums per vertex",
        norma_tangent_source_name(d->source),
        d->transformed ? " through the texture transform" : "", d->negated ? "negated" : "as it is",
        d->p50_rad * degrees, d->p99_rad * degrees, d->max_rad * degrees, d->explained, d->corners,
        d->under_mikk.max_rad * degrees, d->under_mikk.p99_rad * degrees,
        d->under_meshopt.max_rad * degrees, d->under_meshopt.p99_rad * degrees,
        d->under_vertex_sums.max_rad * degrees, d->under_vertex_sums.p99_rad * degrees);
}

norma_result norma_check_tangent_deviation(check_mesh *m) {
    norma_tangent_deviation deviation;
    char message[CHECK_MESSAGE];
    size_t worst;
    check_hits hits = {0};
    if (!norma_check_wants(m, RULE_N807) || !m->given->attributes.tangents) return NORMA_OK;
    norma_result result = norma_explain_tangents_with(
        &m->run->call, &m->given->data, &m->given->attributes, &m->mesh, &deviation, &worst);
    if (result || !deviation.corners) return result;
    describe(&deviation, message);
    norma_check_hit_greatest(m, &hits, deviation.max_rad * (180 / 3.141592653589793), worst);
    return norma_check_report(m,
        &(check_finding){
            .rule = RULE_N807, .severity = NORMA_SEVERITY_INFO, .unit = "deg", .hits = &hits},
        "%s", message);
}

/* ---- N801 to N803, N805, N806, N813: tangents that are no unit vectors, signs that are
 * none, tangents that lean on their normals, tangents and normal maps without a part that they
 * need. */

enum { TANGENTS_IN_BLOCK = 1 << 14 };
static const double LEANS = 0.1;

enum { BAD_TANGENTS, BAD_SIGNS, LEANING }; /* hits */

typedef struct tangent_pass {
    const check_mesh *m;
    double tolerance;
    size_t normals; /* of vertices; 0: none to compare with */
} tangent_pass;

static double length_tolerance(const check_mesh *m) {
    const double bound = norma_check_encoding_bound(m->given->attributes.tangent_encoding);
    return norma_core_unit_tolerance(
        bound > .1 * (3.141592653589793 / 180) ? 8 : 32, m->run->options.strict);
}

/* The cosine between a tangent and its normal; 0 where there is nothing to compare. */
static double lean_of(const tangent_pass *pass, size_t v, const double tangent[3], double length) {
    double n[3], normal_length;
    if (v >= pass->normals) return 0;
    norma_check_normal(pass->m, v, n);
    if (norma_core_judge_length(n, 0, &normal_length) >= CORE_LENGTH_ZERO) return 0;
    return fabs(tangent[0] * n[0] + tangent[1] * n[1] + tangent[2] * n[2]) /
           (length * normal_length);
}

static void judge_tangent(const tangent_pass *pass, check_sum *part, size_t v) {
    const check_run *run = pass->m->run;
    const float *stored = pass->m->given->attributes.tangents + 4 * v;
    const double t[3] = {(double)stored[0], (double)stored[1], (double)stored[2]};
    double length;
    const core_length is = norma_core_judge_length(t, pass->tolerance, &length);
    if (is != CORE_LENGTH_UNIT)
        norma_check_hit(run, &part->hits[BAD_TANGENTS],
            is == CORE_LENGTH_NON_FINITE ? INFINITY : fabs(length - 1), norma_check_vertex(v));
    if (stored[3] != 1 && stored[3] != -1)
        norma_check_hit(run, &part->hits[BAD_SIGNS], (double)stored[3], norma_check_vertex(v));
    if (is >= CORE_LENGTH_ZERO) return;
    double lean = lean_of(pass, v, t, length);
    if (lean > LEANS)
        norma_check_hit(run, &part->hits[LEANING],
            norma_check_arc_sine(fmin(lean, 1)) * (180 / 3.141592653589793), norma_check_vertex(v));
}

static void judge_tangents(const void *pass, check_sum *part, size_t begin, size_t end) {
    for (size_t v = begin; v < end; ++v) judge_tangent(pass, part, v);
}

static norma_result add_tangent_findings(check_mesh *m, check_sum *sum) {
    check_hits *bad = &sum->hits[BAD_TANGENTS], *sign = &sum->hits[BAD_SIGNS],
               *leaning = &sum->hits[LEANING];
    norma_result result = NORMA_OK;
    char map[CHECK_MESSAGE];
    name_of_map(m, map);
    if (norma_check_wants(m, RULE_N801))
        result = norma_check_report(m,
            &(check_finding){
                .rule = RULE_N801, .severity = NORMA_SEVERITY_ERROR, .unit = "length", .hits = bad},
            "black spots, or light from a wrong side, %s%s: %z tangent%s with a component that is "
            "not finite or a length other than 1",
            *map ? "through the normal map" : "where a normal map is read", map, bad->count,
            norma_check_plural(bad->count));
    if (!result && norma_check_wants(m, RULE_N802))
        result = norma_check_report(m,
            &(check_finding){
                .rule = RULE_N802, .severity = NORMA_SEVERITY_ERROR, .no_value = 1, .hits = sign},
            "bumps%s%s become dents or have the wrong height: %z tangent%s with a sign that is "
            "neither 1 nor -1",
            *map ? " of the normal map" : "", map, sign->count, norma_check_plural(sign->count));
    if (!result && norma_check_wants(m, RULE_N803))
        result = norma_check_report(m,
            &(check_finding){
                .rule = RULE_N803, .severity = tangent_severity(m), .unit = "deg", .hits = leaning},
            "%s%s%s: %z tangent%s up to %g degrees off perpendicular to the normal",
            !m->given->material.normal_map ? "not seen, as no normal map uses them here"
            : *map                         ? "the normal map"
                                           : "a normal map",
            map, m->given->material.normal_map ? " bends light the wrong way" : "", leaning->count,
            norma_check_plural(leaning->count), leaning->worst);
    return result;
}

static norma_result judge_values(check_mesh *m) {
    const size_t count = m->given->attributes.tangents ? m->given->attributes.tangent_count : 0;
    if (!count || !norma_check_wants_any(m, RULE_N801, RULE_N803)) return NORMA_OK;
    check_sum sum = {.twice_area = 0};
    const tangent_pass pass = {.m = m,
        .tolerance = length_tolerance(m),
        .normals =
            m->given->info.normals == NORMA_NORMALS_PER_VERTEX ? norma_check_normal_count(m) : 0};
    norma_result result =
        norma_check_gather(m->run, count, TANGENTS_IN_BLOCK, judge_tangents, &pass, &sum);
    if (!result) result = add_tangent_findings(m, &sum);
    norma_check_sum_free(&sum);
    return result;
}

/* Tangents are computed from texture coordinates. */
static norma_result add_no_tangents(check_mesh *m, int has_tangents) {
    check_hits one = {0};
    norma_check_hit(m->run, &one, 0, CHECK_NOWHERE);
    return norma_check_report(m,
        &(check_finding){.rule = RULE_N805,
            .severity = NORMA_SEVERITY_INFO,
            .no_value = 1,
            .no_fix = has_tangents || !m->given->attributes.texcoords,
            .hits = &one},
        has_tangents ? "a normal map, but tangents that count for nothing without normals (N806); "
                       "readers compute MikkTSpace's, as the specification asks"
                     : "a normal map but no tangents; readers compute MikkTSpace's, as the "
                       "specification asks");
}

static norma_result judge_map(check_mesh *m) {
    const norma_material_info *material = &m->given->material;
    if (!material->normal_map || m->given->attributes.texcoords || !m->mesh.face_count ||
        !norma_check_wants(m, RULE_N813))
        return NORMA_OK;
    return norma_check_report_one(m, RULE_N813, NORMA_SEVERITY_ERROR, NAN,
        "the normal map uses TEXCOORD_%z, which is not among the primitive's attributes",
        material->normal_texcoord);
}

norma_result norma_check_tangents(check_mesh *m) {
    const norma_check_mesh *given = m->given;
    int tangents = given->attributes.tangents != NULL || given->info.has_tangents,
        normals = given->info.normals != NORMA_NORMALS_NONE;
    norma_result result = judge_values(m);
    if (!result && given->attributes.tangents && norma_check_wants(m, RULE_N804))
        result = check_tangent_signs(m);
    if (!result) result = judge_map(m);
    const int usable = tangents && normals; /* without normals readers must ignore them */
    if (!result && !usable && given->material.normal_map && !given->material.unlit &&
        m->mesh.face_count && norma_check_wants(m, RULE_N805))
        result = add_no_tangents(m, tangents);
    if (!result && tangents && !normals && norma_check_wants(m, RULE_N806))
        result = norma_check_report_one(m, RULE_N806, NORMA_SEVERITY_WARNING, NAN,
            "tangents but no normals; readers must ignore the tangents");
    return result;
}
