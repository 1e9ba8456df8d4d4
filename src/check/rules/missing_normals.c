/* missing_normals.c: N104 to N106: normals that are not there, that nobody reads, that are too few,
 * too many or named wrongly. */
#include "check/rules/scene_rules.h"

/* ---- N104: faces without any normal; a face that names one wrongly is N106's */

static int lacks_normals(const check_mesh *m, size_t face) {
    const uint8_t *faults = m->given->attributes.face_faults;
    if (faults && faults[face]) return 0;
    for (size_t c = norma_core_face_begin(&m->mesh, face); c < norma_core_face_end(&m->mesh, face);
         c++)
        if (norma_check_normal_of(m, face, c) != SIZE_MAX) return 0;
    return 1;
}

static norma_result add_missing(check_mesh *m) {
    check_hits hits = {0};
    int some = m->given->info.normals != NORMA_NORMALS_NONE;
    int too_few = m->given->attributes.normals_missing > 0 &&
                  !m->given->attributes.face_faults; /* of vertices: N106's */
    if (m->given->material.unlit || too_few || (some && !m->given->data.corner_normals))
        return NORMA_OK;
    for (size_t f = 0; f < m->mesh.face_count; f++)
        if (!some || lacks_normals(m, f)) norma_check_hit(m->run, &hits, 0, norma_check_face(f));
    int obj = m->run->format == NORMA_FILE_OBJ, gltf = !obj && m->run->format != NORMA_FILE_PLY;
    return norma_check_report(m,
        &(check_report){.rule = RULE_N104,
            .severity = obj && some ? NORMA_SEVERITY_WARNING : NORMA_SEVERITY_INFO,
            .no_value = 1,
            .hits = &hits},
        "%z face%s without normals; %s", hits.count, norma_check_plural(hits.count),
        gltf ? "readers make them flat" : "each reader chooses flat or smooth");
}

/* ---- N105 */

static norma_result add_unused(check_mesh *m) {
    char message[CHECK_MESSAGE];
    check_hits hits = {.count = norma_check_normal_count(m)};
    if (!m->given->material.unlit || !hits.count) return NORMA_OK;
    norma_check_message(message, "%z normal%s on an unlit material; nothing reads them", hits.count,
        norma_check_plural(hits.count));
    hits.worst_spot = CHECK_NOWHERE;
    return norma_check_add(m->run, &m->place, m,
        &(check_report){.rule = RULE_N105,
            .severity = NORMA_SEVERITY_INFO,
            .no_value = 1,
            .hits = &hits,
            .message = message});
}

/* ---- N106 */

static void hit_faults(const check_mesh *m, check_hits *hits) {
    const norma_mesh_attributes *a = &m->given->attributes;
    size_t total = a->normals_missing + a->normals_surplus + a->normals_out_of_range;
    if (a->face_faults)
        for (size_t f = 0; f < m->mesh.face_count; f++)
            if (a->face_faults[f]) norma_check_hit(m->run, hits, 0, norma_check_face(f));
    for (size_t v = norma_check_normal_count(m);
         !a->face_faults && a->normals_missing && v < m->mesh.positions.count &&
         hits->count < a->normals_missing;
         v++)
        norma_check_hit(m->run, hits, 0, norma_check_vertex(v));
    if (hits->count == 0) hits->worst_spot = CHECK_NOWHERE;
    hits->count = total;
}

static norma_result add_mismatch(check_mesh *m) {
    const norma_mesh_attributes *a = &m->given->attributes;
    char message[CHECK_MESSAGE];
    check_hits hits = {0};
    hit_faults(m, &hits);
    if (!hits.count) return NORMA_OK;
    const int none = a->face_faults && !norma_check_normal_count(m);
    if (none)
        norma_check_message(message,
            "%z face%s with a vn index, but the file has no vn at all; readers refuse it, or shade "
            "it as they would without",
            a->normals_out_of_range, norma_check_plural(a->normals_out_of_range));
    else if (a->face_faults)
        norma_check_message(message,
            "%z face%s with a vn index that does not exist, %z with normals at some corners only; "
            "readers treat them differently",
            a->normals_out_of_range, norma_check_plural(a->normals_out_of_range),
            a->normals_missing);
    else if (a->normals_missing)
        norma_check_message(message,
            "%z normal%s fewer than positions; readers refuse the file, or read beyond the normals",
            a->normals_missing, norma_check_plural(a->normals_missing));
    else
        norma_check_message(message,
            "%z normal%s more than positions; readers refuse the file, or take the wrong ones",
            a->normals_surplus, norma_check_plural(a->normals_surplus));
    return norma_check_add(m->run, &m->place, m,
        &(check_report){.rule = RULE_N106,
            .severity = NORMA_SEVERITY_ERROR,
            .no_value = 1,
            .fix_is_unsafe = none,
            .hits = &hits,
            .message = message});
}

norma_result norma_check_missing_normals(check_mesh *m) {
    norma_result result = norma_check_wants(m, RULE_N104) ? add_missing(m) : NORMA_OK;
    if (!result && norma_check_wants(m, RULE_N105)) result = add_unused(m);
    return !result && norma_check_wants(m, RULE_N106) ? add_mismatch(m) : result;
}
