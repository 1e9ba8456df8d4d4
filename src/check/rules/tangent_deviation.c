/* tangent_deviation.c: N807: how far the stored tangents are from those of the way to make tangents
 * that explains them best. */
#include "check/explain/explain_tangents.h"
#include "check/rules/scene_rules.h"

static void describe(const norma_tangent_deviation *d, char message[CHECK_MESSAGE]) {
    const double degrees = 180 / 3.141592653589793;
    norma_check_message(message,
        "tangents are best explained by %s%s, with the sign %s: median %g, 99 %% within %g, at "
        "most "
        "%g degrees off; %z of %z corners explained",
        norma_tangent_source_name(d->source),
        d->transformed ? " through the texture transform" : "", d->negated ? "negated" : "as it is",
        d->p50_rad * degrees, d->p99_rad * degrees, d->max_rad * degrees, d->explained, d->corners);
}

norma_result norma_check_tangent_deviation(check_mesh *m) {
    norma_tangent_deviation deviation;
    char message[CHECK_MESSAGE];
    check_hits hits = {0};
    if (!norma_check_wants(m, RULE_N807) || !m->given->attributes.tangents) return NORMA_OK;
    norma_result result = norma_explain_tangents_with(
        &m->run->call, &m->given->data, &m->given->attributes, &m->mesh, &deviation);
    if (result || !deviation.corners) return result;
    norma_check_hit(m->run, &hits, deviation.max_rad * (180 / 3.141592653589793), CHECK_NOWHERE);
    describe(&deviation, message);
    return norma_check_add(m->run, &m->place, m,
        &(check_report){.rule = RULE_N807,
            .severity = NORMA_SEVERITY_INFO,
            .unit = "deg",
            .hits = &hits,
            .message = message});
}
