/* solids.c: N302 and N304: components that look inward, solids in solids, and components of which neither can be said. */
#include "../core/components.h"
#include "check_internal.h"

static const uint8_t NOT_CLOSED = COMPONENT_OPEN | COMPONENT_CONFLICT | COMPONENT_MANY;

static check_spot spot_of(const core_components *c, size_t number) { return norma_check_face(c->faces[c->starts[number]]); }

/* ---- N302 */

static norma_result add_inward(check_mesh *m, check_hits *hits, size_t count) {
    char message[CHECK_MESSAGE];
    norma_severity severity = m->run->profile == NORMA_CHECK_PROFILE_PRINT ? NORMA_SEVERITY_ERROR : NORMA_SEVERITY_WARNING;
    norma_check_message(message, "%z of %z components are inside out: closed, and their faces look inward", hits->count, count);
    return norma_check_add(m->run, &m->place, m, &(check_report){.rule = RULE_N302, .severity = severity, .unit = "volume", .hits = hits, .message = message});
}

static norma_result add_nested(check_mesh *m, check_hits *hits) {
    char message[CHECK_MESSAGE];
    norma_severity severity = m->run->profile == NORMA_CHECK_PROFILE_PRINT ? NORMA_SEVERITY_WARNING : NORMA_SEVERITY_INFO;
    norma_check_message(message, "%z components are solids right inside a solid: cavities that were turned, or bodies of their own", hits->count);
    return norma_check_add(m->run, &m->place, m, &(check_report){.rule = RULE_N302, .severity = severity, .unit = "volume", .no_fix = 1, .hits = hits, .message = message});
}

static norma_result check_inward(check_mesh *m, core_components *c) {
    norma_result result = norma_core_measure_components(&m->topology, c, NOT_CLOSED);
    if (!result)
        result = norma_core_judge_nesting(&m->topology, c, NOT_CLOSED);
    check_hits inward = {.least = 1}, nested = {0};
    for (size_t i = 0; !result && i < c->count; i++) {
        const core_component *component = &c->each[i];
        if (component->verdict == COMPONENT_INWARD)
            norma_check_hit(m->run, &inward, component->volume / 6, spot_of(c, i));
        else if (component->verdict == COMPONENT_NESTED)
            norma_check_hit(m->run, &nested, component->volume / 6, spot_of(c, i));
    }
    if (!result && inward.count)
        result = add_inward(m, &inward, c->count);
    if (!result && nested.count)
        result = add_nested(m, &nested);
    norma_check_hits_free(&inward);
    norma_check_hits_free(&nested);
    return result;
}

/* ---- N304: open, or of one side whichever faces are reversed */

/* Whether a component that has conflicts is of one side: its faces are wound alike as far as that goes, and some part then still disagrees with itself. */
static norma_result find_one_sided(check_mesh *m, core_components *c) {
    core_components parts;
    size_t conflicts = 0;
    for (size_t i = 0; i < c->count; i++) conflicts += (c->each[i].flags & COMPONENT_CONFLICT) != 0 && !(c->each[i].flags & COMPONENT_OPEN);
    if (!conflicts)
        return NORMA_OK;
    norma_result result = norma_core_find_components(&m->topology, CORE_JOIN_CUT, &parts);
    if (result)
        return result;
    for (size_t i = 0; i < parts.count; i++)
        if (parts.each[i].flags & COMPONENT_ONE_SIDED)
            c->each[c->of[parts.faces[parts.starts[i]]]].flags |= COMPONENT_ONE_SIDED;
    norma_core_release_components(&m->run->call, &parts);
    return NORMA_OK;
}

static norma_result check_undecidable(check_mesh *m, core_components *c) {
    char message[CHECK_MESSAGE];
    check_hits hits = {0};
    size_t one_sided = 0;
    norma_result result = find_one_sided(m, c);
    for (size_t i = 0; !result && i < c->count; i++) {
        uint8_t flags = c->each[i].flags;
        one_sided += (flags & COMPONENT_ONE_SIDED) != 0;
        if (flags & (COMPONENT_OPEN | COMPONENT_ONE_SIDED | COMPONENT_UNBALANCED))
            norma_check_hit(m->run, &hits, (double)(c->starts[i + 1] - c->starts[i]), spot_of(c, i));
    }
    if (!result && hits.count) {
        norma_check_message(message, one_sided ? "%z of %z components are open or of one side (%z): which side is outward cannot be decided" : "%z of %z components are open: which side is outward cannot be decided", hits.count,
                            c->count, one_sided);
        return norma_check_add(m->run, &m->place, m, &(check_report){.rule = RULE_N304, .severity = NORMA_SEVERITY_INFO, .unit = "faces", .hits = &hits, .message = message});
    }
    norma_check_hits_free(&hits);
    return result;
}

norma_result norma_check_solids(check_mesh *m) {
    core_components components;
    if (!m->mesh.face_count || !(norma_check_wants(m, RULE_N302) || norma_check_wants(m, RULE_N304)))
        return NORMA_OK;
    norma_result result = norma_check_pairs(m);
    if (!result)
        result = norma_core_find_components(&m->topology, CORE_JOIN_ALL_EDGES, &components);
    if (result)
        return result;
    if (norma_check_wants(m, RULE_N302))
        result = check_inward(m, &components);
    if (!result && norma_check_wants(m, RULE_N304))
        result = check_undecidable(m, &components);
    norma_core_release_components(&m->run->call, &components);
    return result;
}
