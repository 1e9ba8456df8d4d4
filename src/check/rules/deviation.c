/* deviation.c: N204: how far the stored normals are from the computed ones that explain them best.
 */
#include "core/face/triangle.h"
#include "check/explain/explain_normals.h"
#include "check/rules/mesh_rules.h"
#include <math.h>

static void describe_deviation(
    const norma_deviation *d, size_t count, char message[CHECK_MESSAGE]) {
    char how[CHECK_MESSAGE];
    double degrees = 180 / NORMA_PI;
    if (d->shading == NORMA_SHADING_FLAT)
        norma_check_message(how, "flat shading");
    else if (d->shading == NORMA_SHADING_SMOOTH)
        norma_check_message(how, "%s weights, smooth", norma_weight_name(d->weight));
    else
        norma_check_message(how, "%s weights, crease %g", norma_weight_name(d->weight),
            d->crease_angle_rad * degrees);
    norma_check_message(message,
        "%z stored normals are best explained by %s: median %g, 99 %% within %g, at most %g "
        "degrees off",
        count, how, d->p50_rad * degrees, d->p99_rad * degrees, d->max_rad * degrees);
}

/* Normals that corners use: each vertex, each vn. */
static size_t count_normals(const check_mesh *m) {
    size_t count = norma_check_normal_count(m), used = 0;
    for (size_t i = 0; i < count && m->users; i++) used += m->users[i] != UINT32_MAX;
    return m->users ? used : count;
}

norma_result norma_check_deviation_of(check_mesh *m, const norma_deviation **deviation) {
    *deviation = &m->deviation;
    if (m->has_deviation || !m->mesh.corner_count || !norma_check_normal_count(m) ||
        m->given->info.normals == NORMA_NORMALS_PER_FACET)
        return NORMA_OK;
    norma_result result = norma_check_users(m);
    if (!result) result = norma_check_around(m);
    if (!result)
        result = norma_explain_with(
            &m->run->call, &m->given->data, &m->mesh, &m->topology, &m->deviation);
    m->has_deviation = !result;
    return result;
}

norma_result norma_check_deviation(check_mesh *m) {
    const norma_deviation *deviation;
    char message[CHECK_MESSAGE];
    if (!norma_check_wants(m, RULE_N204)) return NORMA_OK;
    const norma_result result = norma_check_deviation_of(m, &deviation);
    if (result || !deviation->corners) return result;
    check_hits hits = {0};
    norma_check_hit(m->run, &hits, deviation->max_rad * (180 / NORMA_PI), CHECK_NOWHERE);
    hits.count = count_normals(m);
    describe_deviation(deviation, hits.count, message);
    return norma_check_add(m->run, &m->place, m,
        &(check_report){.rule = RULE_N204,
            .severity = NORMA_SEVERITY_INFO,
            .unit = "deg",
            .hits = &hits,
            .message = message,
            .deviation = deviation});
}
