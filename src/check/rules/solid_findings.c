/* solid_findings.c: N302 and N304: components that look inward, solids in solids, and components of
 * which neither can be said. */
#include "check/rules/solids.h"

static const uint8_t NOT_CLOSED = COMPONENT_OPEN | COMPONENT_CONFLICT | COMPONENT_UNBALANCED;

/* Whether a component is told of here: its first face is. */
static int is_here(const check_solids *s, size_t number) {
    const size_t face = s->components->faces[s->components->starts[number]];
    return face >= s->begin && face < s->end;
}

static check_spot spot_of(const check_solids *s, size_t number) {
    return norma_check_face(s->components->faces[s->components->starts[number]] - s->begin);
}

static size_t count_here(const check_solids *s) {
    size_t count = 0;
    for (size_t i = 0; i < s->components->count; i++) count += (size_t)is_here(s, i);
    return count;
}

/* ---- N302 */

static norma_result add_inward(check_mesh *m, check_hits *hits, size_t count) {
    norma_severity severity = m->run->profile == NORMA_CHECK_PROFILE_PRINT ? NORMA_SEVERITY_ERROR
                                                                           : NORMA_SEVERITY_WARNING;
    return norma_check_report(m,
        &(check_report){.rule = RULE_N302, .severity = severity, .unit = "volume", .hits = hits},
        "%z of %z component%s %s inside out: closed, and the faces look inward", hits->count, count,
        norma_check_plural(count), hits->count == 1 ? "is" : "are");
}

static norma_result add_nested(check_mesh *m, check_hits *hits) {
    norma_severity severity =
        m->run->profile == NORMA_CHECK_PROFILE_PRINT ? NORMA_SEVERITY_WARNING : NORMA_SEVERITY_INFO;
    return norma_check_report(m,
        &(check_report){
            .rule = RULE_N302, .severity = severity, .unit = "volume", .no_fix = 1, .hits = hits},
        "%z component%s directly inside a solid and facing outward; either cavities that were "
        "turned, or separate bodies",
        hits->count, norma_check_plural(hits->count));
}

static norma_result tell_inward(const check_solids *s) {
    check_mesh *m = s->m;
    const core_components *c = s->components;
    check_hits inward = {.least = 1}, nested = {0};
    norma_result result = NORMA_OK;
    for (size_t i = 0; i < c->count; i++) {
        const core_component *component = &c->each[i];
        if (component->verdict == COMPONENT_INWARD && is_here(s, i))
            norma_check_hit(m->run, &inward, component->volume / 6, spot_of(s, i));
        else if (component->verdict == COMPONENT_NESTED && is_here(s, i))
            norma_check_hit(m->run, &nested, component->volume / 6, spot_of(s, i));
    }
    if (inward.count) result = add_inward(m, &inward, count_here(s));
    if (!result && nested.count) result = add_nested(m, &nested);
    norma_check_hits_free(&inward);
    norma_check_hits_free(&nested);
    return result;
}

/* ---- N304: open, or of one side whichever faces are reversed */

/* Whether a component that has conflicts is of one side: its faces are wound alike as far as that
 * goes, and some part then still disagrees with itself. */
static norma_result find_one_sided(const core_topology *topology, core_components *c) {
    core_components parts;
    size_t conflicts = 0;
    for (size_t i = 0; i < c->count; i++)
        conflicts +=
            (c->each[i].flags & COMPONENT_CONFLICT) != 0 && !(c->each[i].flags & COMPONENT_OPEN);
    if (!conflicts) return NORMA_OK;
    norma_result result = norma_core_find_components(topology, CORE_JOIN_CUT, &parts);
    if (result) return result;
    for (size_t i = 0; i < parts.count; i++)
        if (parts.each[i].flags & COMPONENT_ONE_SIDED)
            c->each[c->of[parts.faces[parts.starts[i]]]].flags |= COMPONENT_ONE_SIDED;
    norma_core_release_components(topology->call, &parts);
    return NORMA_OK;
}

static norma_result tell_undecidable(const check_solids *s) {
    check_mesh *m = s->m;
    const core_components *c = s->components;
    check_hits hits = {0};
    size_t one_sided = 0;
    for (size_t i = 0; i < c->count; i++) {
        uint8_t flags = c->each[i].flags;
        if (!(flags & (COMPONENT_OPEN | COMPONENT_ONE_SIDED | COMPONENT_UNBALANCED)) ||
            !is_here(s, i))
            continue;
        one_sided += (flags & COMPONENT_ONE_SIDED) != 0;
        norma_check_hit(m->run, &hits, (double)(c->starts[i + 1] - c->starts[i]), spot_of(s, i));
    }
    if (hits.count) {
        return norma_check_report(m,
            &(check_report){
                .rule = RULE_N304, .severity = NORMA_SEVERITY_INFO, .unit = "faces", .hits = &hits},
            one_sided ? "%z of %z component%s %s open or one-sided (%z): which side is outward "
                        "cannot be decided"
                      : "%z of %z component%s %s open: which side is outward cannot be decided",
            hits.count, count_here(s), norma_check_plural(count_here(s)),
            hits.count == 1 ? "is" : "are", one_sided);
    }
    norma_check_hits_free(&hits);
    return NORMA_OK;
}

/* ---- both */

static int any_is_closed(const core_components *c) {
    size_t i = 0;
    while (i < c->count && c->each[i].flags & NOT_CLOSED) i++;
    return i < c->count;
}

norma_result norma_check_judge_solids(
    const core_topology *topology, core_components *c, int nesting, int sides) {
    nesting = nesting && any_is_closed(c);
    norma_result result =
        nesting ? norma_core_measure_components(topology, c, NOT_CLOSED) : NORMA_OK;
    if (!result && nesting) result = norma_core_judge_nesting(topology, c, NOT_CLOSED);
    return !result && sides ? find_one_sided(topology, c) : result;
}

norma_result norma_check_tell_solids(const check_solids *s) {
    norma_result result = norma_check_wants(s->m, RULE_N302) ? tell_inward(s) : NORMA_OK;
    return !result && norma_check_wants(s->m, RULE_N304) ? tell_undecidable(s) : result;
}
