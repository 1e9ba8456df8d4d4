/* stored_normals.c: N101 to N106 and N205: lengths of stored normals, whether there are as many as
 * there should be, and those of STL facets against their winding. */
#include "check/rules/rules.h"
#include "core/face/unit_length.h"
#include <math.h>
#include <string.h>

/* ---- N101 to N103: normals that are no unit vectors, by what their encoding can hold. */

enum { NORMALS_IN_BLOCK = 1 << 14 };
static const double TWO_DIGITS = .025; /* what writing numbers with two digits does to a length */

typedef struct length_pass {
    const check_mesh *m;
    double tolerance;
} length_pass;

static double normal_tolerance(const check_mesh *m) {
    const char *encoding = m->given->info.encoding ? m->given->info.encoding : "";
    const int bits = !strcmp(encoding, "snorm8") || !strcmp(encoding, "int8") ? 8
                     : !strcmp(encoding, "snorm10")                           ? 10
                                                                              : 32;
    return norma_core_unit_tolerance(bits, m->run->options.strict);
}

static void judge_normal(const length_pass *pass, check_sum *part, size_t number) {
    const check_mesh *m = pass->m;
    double n[3], length;
    norma_check_normal(m, number, n);
    const core_length is = norma_core_judge_length(n, pass->tolerance, &length);
    if (is == CORE_LENGTH_UNIT || (m->users && m->users[number] == UINT32_MAX)) return;
    const check_spot spot = norma_check_normal_spot(m, number);
    if (is == CORE_LENGTH_NON_FINITE)
        norma_check_hit(m->run, &part->hits[CHECK_LENGTH_NOT_FINITE], 0, spot);
    else if (is == CORE_LENGTH_ZERO)
        norma_check_hit(m->run, &part->hits[CHECK_LENGTH_NONE], length, spot);
    else
        norma_check_hit(m->run,
            &part->hits[m->run->format == NORMA_FILE_OBJ && fabs(length - 1) <= TWO_DIGITS
                            ? CHECK_LENGTH_ROUNDED
                            : CHECK_LENGTH_OFF],
            fabs(length - 1), spot);
}

static void judge_normals(const void *pass, check_sum *part, size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) judge_normal(pass, part, i);
}

/* ---- how many normals of no length belong to degenerate faces only, or to no face: a word of
 * comfort in the message, since recomputing takes the nearest normal for them */

enum { USED = 1, BUSY = 2 }; /* by a face; by one that has a direction */

static void mark_users(const check_mesh *m, uint8_t *marks) {
    for (size_t f = 0; f < m->mesh.face_count; ++f)
        for (size_t c = norma_core_face_begin(&m->mesh, f); c < norma_core_face_end(&m->mesh, f);
             ++c) {
            const size_t number = norma_check_normal_of(m, f, c);
            if (number != SIZE_MAX)
                marks[number] |= norma_check_directed(&m->faces[f]) ? USED | BUSY : USED;
        }
}

static norma_result count_idle(check_mesh *m, check_idle *idle) {
    const size_t count = norma_check_normal_count(m);
    const norma_result result = norma_check_faces(m);
    uint8_t *marks = result ? NULL : norma_core_allocate(&m->run->call, count, 1);
    if (result || !marks) return result ? result : NORMA_ERROR_MEMORY;
    memset(marks, 0, count);
    mark_users(m, marks);
    for (size_t i = 0; i < count; ++i) {
        double n[3], length;
        if (marks[i] & BUSY || (m->users && m->users[i] == UINT32_MAX)) continue;
        norma_check_normal(m, i, n);
        if (norma_core_judge_length(n, 0, &length) != CORE_LENGTH_ZERO) continue;
        idle->degenerate += marks[i] != 0;
        idle->unused += !marks[i];
    }
    norma_core_release(&m->run->call, marks, count, 1);
    return NORMA_OK;
}

static norma_result add_zero(check_mesh *m, check_hits *hits, const check_idle *idle) {
    char message[CHECK_MESSAGE], who[CHECK_MESSAGE] = "", none[CHECK_MESSAGE] = "";
    if (idle->degenerate)
        norma_check_message(who, "; %z used only by degenerate faces (N401)", idle->degenerate);
    if (idle->unused) norma_check_message(none, "; %z used by no face", idle->unused);
    if (who[0] || none[0])
        norma_check_message(message, "%s: %z zero-length normal%s%s%s",
            idle->degenerate + idle->unused < hits->count ? "black spots" : "without direction",
            hits->count, norma_check_plural(hits->count), who, none);
    else
        norma_check_message(message,
            "black spots: %z zero-length normal%s; normalising one divides by zero", hits->count,
            norma_check_plural(hits->count));
    return norma_check_report(m,
        &(check_finding){
            .rule = RULE_N102, .severity = NORMA_SEVERITY_ERROR, .unit = "length", .hits = hits},
        "%s", message);
}

/* The lengths of facet normals are N205's. */
static int wants_lengths(const check_mesh *m, check_rule rule) {
    return m->given->info.normals != NORMA_NORMALS_PER_FACET && norma_check_wants(m, rule);
}

static norma_result add_non_unit(check_mesh *m, norma_severity severity, check_hits *hits) {
    if (!wants_lengths(m, RULE_N103)) return NORMA_OK;
    return norma_check_report(m,
        &(check_finding){.rule = RULE_N103, .severity = severity, .unit = "length", .hits = hits},
        "too bright or too dark, if a shader does not renormalise: %z normal%s whose length "
        "differs from 1, by up to %g",
        hits->count, norma_check_plural(hits->count), hits->worst);
}

norma_result norma_check_lengths_add(check_mesh *m, check_sum *sum, const check_idle *idle) {
    check_hits *not_finite = &sum->hits[CHECK_LENGTH_NOT_FINITE],
               *zero = &sum->hits[CHECK_LENGTH_NONE];
    norma_result result = NORMA_OK;
    if (norma_check_wants(m, RULE_N101))
        result = norma_check_report(m,
            &(check_finding){.rule = RULE_N101,
                .severity = NORMA_SEVERITY_ERROR,
                .no_value = 1,
                .hits = not_finite},
            "black or white spots: %z normal%s with a component that is NaN or infinite",
            not_finite->count, norma_check_plural(not_finite->count));
    if (!result && wants_lengths(m, RULE_N102)) result = add_zero(m, zero, idle);
    if (!result) result = add_non_unit(m, NORMA_SEVERITY_ERROR, &sum->hits[CHECK_LENGTH_OFF]);
    return result ? result
                  : add_non_unit(m, NORMA_SEVERITY_WARNING, &sum->hits[CHECK_LENGTH_ROUNDED]);
}

norma_result norma_check_lengths_look(check_mesh *m, check_sum *sum) {
    const size_t count = norma_check_normal_count(m);
    const length_pass pass = {m, normal_tolerance(m)};
    sum->hits[CHECK_LENGTH_NONE].least = 1;
    if (!count || !norma_check_wants_any(m, RULE_N101, RULE_N103)) return NORMA_OK;
    const norma_result result = norma_check_users(m);
    return result ? result
                  : norma_check_gather(m->run, count, NORMALS_IN_BLOCK, judge_normals, &pass, sum);
}

norma_result norma_check_lengths(check_mesh *m) {
    check_sum sum = {.twice_area = 0};
    check_idle idle = {0};
    norma_result result = norma_check_lengths_look(m, &sum);
    if (!result && sum.hits[CHECK_LENGTH_NONE].count && wants_lengths(m, RULE_N102))
        result = count_idle(m, &idle);
    if (!result) result = norma_check_lengths_add(m, &sum, &idle);
    norma_check_sum_free(&sum);
    return result;
}

/* ---- N104 to N106: normals that are not there, that nobody reads, that are too few,
 * too many or named wrongly. */

/* ---- N104: faces without any normal; a face that names one wrongly is N106's */

static int lacks_normals(const check_mesh *m, size_t face) {
    const uint8_t *faults = m->given->attributes.face_faults;
    if (faults && faults[face]) return 0;
    for (size_t c = norma_core_face_begin(&m->mesh, face); c < norma_core_face_end(&m->mesh, face);
         ++c)
        if (norma_check_normal_of(m, face, c) != SIZE_MAX) return 0;
    return 1;
}

static norma_result add_faces_without(check_mesh *m) {
    check_hits hits = {0};
    int some = m->given->info.normals != NORMA_NORMALS_NONE;
    int too_few = m->given->attributes.normals_missing > 0 &&
                  !m->given->attributes.face_faults; /* of vertices: N106's */
    if (m->given->material.unlit || too_few || (some && !m->given->data.corner_normals))
        return NORMA_OK;
    for (size_t f = 0; f < m->mesh.face_count; ++f)
        if (!some || lacks_normals(m, f)) norma_check_hit(m->run, &hits, 0, norma_check_face(f));
    int obj = m->run->format == NORMA_FILE_OBJ, gltf = !obj && m->run->format != NORMA_FILE_PLY;
    return norma_check_report(m,
        &(check_finding){.rule = RULE_N104,
            .severity = obj && some ? NORMA_SEVERITY_WARNING : NORMA_SEVERITY_INFO,
            .no_value = 1,
            .hits = &hits},
        "shaded flat%s: %z face%s without normals",
        gltf ? "" : " or smooth, as each reader chooses", hits.count,
        norma_check_plural(hits.count));
}

/* ---- N105 */

static norma_result add_unused(check_mesh *m) {
    check_hits hits = {.count = norma_check_normal_count(m), .worst_spot = CHECK_NOWHERE};
    if (!m->given->material.unlit || !hits.count) return NORMA_OK;
    return norma_check_report(m,
        &(check_finding){
            .rule = RULE_N105, .severity = NORMA_SEVERITY_INFO, .no_value = 1, .hits = &hits},
        "never read: %z normal%s on an unlit material", hits.count, norma_check_plural(hits.count));
}

/* ---- N106 */

static void hit_faults(const check_mesh *m, check_hits *hits) {
    const norma_mesh_attributes *a = &m->given->attributes;
    size_t total = a->normals_missing + a->normals_surplus + a->normals_out_of_range;
    if (a->face_faults)
        for (size_t f = 0; f < m->mesh.face_count; ++f)
            if (a->face_faults[f]) norma_check_hit(m->run, hits, 0, norma_check_face(f));
    for (size_t v = norma_check_normal_count(m);
         !a->face_faults && a->normals_missing && v < m->mesh.positions.count &&
         hits->count < a->normals_missing;
         ++v)
        norma_check_hit(m->run, hits, 0, norma_check_vertex(v));
    if (hits->count == 0) hits->worst_spot = CHECK_NOWHERE;
    hits->count = total;
}

static void describe_face_faults(const norma_mesh_attributes *a, char message[CHECK_MESSAGE]) {
    const size_t astray = a->normals_out_of_range, partly = a->normals_missing;
    char text[CHECK_MESSAGE] = "";
    if (astray)
        norma_check_message(text, " %z face%s with a vn index that does not exist%s", astray,
            norma_check_plural(astray), partly ? "," : "");
    if (partly && astray)
        norma_check_message(message,
            "shaded differently by each reader:%s %z with normals at some corners only", text,
            partly);
    else if (partly)
        norma_check_message(message,
            "shaded differently by each reader: %z face%s with normals at some corners only",
            partly, norma_check_plural(partly));
    else
        norma_check_message(message, "shaded differently by each reader:%s", text);
}

static norma_result add_mismatch(check_mesh *m) {
    const norma_mesh_attributes *a = &m->given->attributes;
    const int none = a->face_faults && !norma_check_normal_count(m);
    const size_t count = none                 ? a->normals_out_of_range
                         : a->normals_missing ? a->normals_missing
                                              : a->normals_surplus;
    char faults[CHECK_MESSAGE];
    check_hits hits = {0};
    hit_faults(m, &hits);
    if (a->face_faults && !none) describe_face_faults(a, faults);
    return norma_check_report(m,
        &(check_finding){.rule = RULE_N106,
            .severity = NORMA_SEVERITY_ERROR,
            .no_value = 1,
            .fix_is_unsafe = none,
            .hits = &hits},
        none ? "refused by readers, or shaded as if without normals: %z face%s with a vn index, "
               "but the file has no vn at all"
        : a->face_faults ? faults
        : a->normals_missing
            ? "refused by readers, or read beyond the normals: %z normal%s fewer than positions"
            : "refused by readers, or shaded by the wrong normals: %z normal%s more than positions",
        count, norma_check_plural(count));
}

norma_result norma_check_missing_normals(check_mesh *m) {
    const int lacks = norma_check_wants(m, RULE_N104) && m->run->format != NORMA_FILE_3MF;
    norma_result result = lacks ? add_faces_without(m) : NORMA_OK; /* a 3MF has none */
    if (!result && norma_check_wants(m, RULE_N105)) result = add_unused(m);
    return !result && norma_check_wants(m, RULE_N106) ? add_mismatch(m) : result;
}

/* ---- N205: the normals of STL facets against their winding. */

enum { FACETS_IN_BLOCK = 1 << 14 };
static const double NEAR_COSINE = 0.9961946980917455; /* of 5 degrees */
static const double CLEAR_COSINE =
    0.984807753012208;                  /* of 10 degrees: what leans less, or is zero, informs */
static const double LEAST_SHARE = .001; /* of the area: below it, the rule informs */

typedef struct facet_pass {
    const check_mesh *m;
    uint8_t *behind; /* of each face: 1: its normal is on the other side; 2: nearly the opposite of
                        its winding; or NULL */
} facet_pass;

/* A facet that is degenerate has no direction to compare with; its zero normal is as right as any.
 */
static void judge_facet(const facet_pass *pass, check_sum *part, size_t facet) {
    const check_mesh *m = pass->m;
    double n[3], length;
    norma_check_normal(m, facet, n);
    const core_length is = norma_core_judge_length(n, 0, &length);
    const double cosine = norma_check_dot(m->faces[facet].normal, n) / length;
    if (is == CORE_LENGTH_NON_FINITE || !norma_check_directed(&m->faces[facet]) ||
        norma_check_is_sliver(&m->faces[facet]))
        return;
    if (is != CORE_LENGTH_ZERO && cosine < CLEAR_COSINE)
        part->twice_area += norma_check_twice_area(m, facet);
    if (is == CORE_LENGTH_ZERO) {
        ++part->counts[CHECK_FACETS_ZERO];
        norma_check_hit(m->run, &part->hits[0], NAN, norma_check_face(facet));
    } else if (cosine < NEAR_COSINE) {
        if (pass->behind)
            pass->behind[facet] = (uint8_t)((cosine < 0) + (cosine <= -CHECK_LEAN_COSINE));
        norma_check_hit(m->run, &part->hits[0],
            norma_check_arc_cosine(fmax(cosine, -1)) * (180 / 3.141592653589793),
            norma_check_face(facet));
    }
}

static void judge_facets(const void *pass, check_sum *part, size_t begin, size_t end) {
    for (size_t f = begin; f < end; ++f) judge_facet(pass, part, f);
}

/* Those that no fix of normals is for: wound wrongly while their normals are right, or perhaps. */
static norma_result count_turned(check_mesh *m, const uint8_t *behind, check_sum *sum) {
    const size_t faces = m->mesh.face_count;
    if (!memchr(behind, 1, faces) && !memchr(behind, 2, faces)) return NORMA_OK;
    uint8_t *sides = norma_core_allocate(&m->run->call, faces, 1);
    const norma_result result = sides ? norma_check_sides(m, behind, sides) : NORMA_ERROR_MEMORY;
    for (size_t f = 0; !result && f < faces; ++f) {
        sum->counts[CHECK_FACETS_TURNED] += behind[f] && norma_check_is_turned(sides[f]);
        sum->counts[CHECK_FACETS_UNDECIDED] += behind[f] > 1 && sides[f] & CORE_SIDE_UNDECIDED;
    }
    norma_core_release(&m->run->call, sides, faces, 1);
    return result;
}

norma_result norma_check_facets_add(check_mesh *m, check_sum *sum, double whole_area) {
    check_hits *hits = &sum->hits[0];
    const size_t zeros = sum->counts[CHECK_FACETS_ZERO], turned = sum->counts[CHECK_FACETS_TURNED],
                 undecided = sum->counts[CHECK_FACETS_UNDECIDED];
    const int matters = sum->twice_area > 0 && sum->twice_area >= LEAST_SHARE * whole_area;
    return norma_check_report(m,
        &(check_finding){.rule = RULE_N205,
            .severity = matters ? NORMA_SEVERITY_WARNING : NORMA_SEVERITY_INFO,
            .unit = "deg",
            .no_value = zeros == hits->count,
            .no_fix = turned + undecided == hits->count,
            .hits = hits},
        zeros == hits->count ? "shaded by the winding alone: %z of %z facets have a zero normal"
        : zeros ? "shaded differently by each reader: %z of %z facet normals disagree with the "
                  "winding, by up to %g degrees; %z of them are zero"
        : turned == hits->count
            ? "shaded differently by each reader: %z of %z facet normals disagree with the "
              "winding, by up to %g degrees; there the winding is wrong and the normals are right "
              "(N301, N302)"
        : turned + undecided == hits->count
            ? "shaded differently by each reader: %z of %z facet normals disagree with the "
              "winding, by up to %g degrees; neither volume nor rays nor neighbours show for %z of "
              "them which is wrong"
            : "shaded differently by each reader: %z of %z facet normals disagree with the "
              "winding, by up to %g degrees; some use the normal, others the winding",
        hits->count, m->mesh.face_count, hits->worst, zeros ? zeros : undecided);
}

norma_result norma_check_facets_look(check_mesh *m, check_sum *sum, uint8_t *behind) {
    const size_t normals = norma_check_normal_count(m), faces = m->mesh.face_count,
                 count = normals < faces ? normals : faces;
    const facet_pass pass = {m, behind};
    const norma_result result = count ? norma_check_faces(m) : NORMA_OK;
    return result ? result
                  : norma_check_gather(m->run, count, FACETS_IN_BLOCK, judge_facets, &pass, sum);
}

norma_result norma_check_facets(check_mesh *m) {
    const core_call *call = &m->run->call;
    const size_t faces = m->mesh.face_count;
    check_sum sum = {.twice_area = 0};
    if (m->given->info.normals != NORMA_NORMALS_PER_FACET || !faces ||
        !norma_check_wants(m, RULE_N205))
        return NORMA_OK;
    uint8_t *behind = norma_core_allocate(call, faces, 1);
    if (!behind) return NORMA_ERROR_MEMORY;
    memset(behind, 0, faces);
    norma_result result = norma_check_facets_look(m, &sum, behind);
    if (!result) result = count_turned(m, behind, &sum);
    norma_core_release(call, behind, faces, 1);
    if (!result && sum.hits[0].count)
        result = norma_check_facets_add(m, &sum, norma_check_add_areas(m, 0));
    norma_check_sum_free(&sum);
    return result;
}
