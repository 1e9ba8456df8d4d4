/* turn_bodies.c: which faces are reversed with the whole body that they belong to: bodies that look
 * inward (N302), and, where that is asked for, open ones (N304) as a majority of rays has it. The
 * primitives of a glTF mesh are looked at together, as those rules do. */
#include "check/fix/fix.h"
#include "core/topology/topology.h"
#include <stdlib.h>
#include <string.h>

int norma_fix_mark_named(const fix_whole *t, check_rule rule, uint8_t *marks) {
    const fix_group *g = t->group;
    size_t begin = 0;
    int any = 0;
    for (size_t i = 0; i < g->count; begin += t->meshes[i++].face_count)
        for (size_t k = 0; k < norma_findings_count(g->findings); k++) {
            const norma_finding *finding = norma_findings_get(g->findings, k);
            if (!norma_fix_is_rule(finding, rule) || !norma_fix_may(g->request, finding) ||
                strcmp(finding->where, g->wheres[i]) != 0)
                continue;
            for (size_t s = 0; s < finding->sample_count; s++)
                if (finding->samples[s].face < t->meshes[i].face_count)
                    marks[begin + finding->samples[s].face] = 1, any = 1;
        }
    return any;
}

/* ---- rays */

static void add_votes(fix_plan *plan, const norma_orient_report *report) {
    plan->least_confidence = plan->by_rays == 0 || report->least_confidence < plan->least_confidence
                                 ? report->least_confidence
                                 : plan->least_confidence;
    plan->by_rays += report->by_rays;
    plan->undecided += report->undecided;
}

/* What rays turn is what differs from winding alike alone. marks: in, the faces that are open; out,
 * those of them to be reversed. */
static norma_result ask_rays(fix_whole *t, uint8_t *marks) {
    const norma_options options = {
        .struct_size = sizeof options, .threads = t->group->request->options.threads};
    norma_orient_report report;
    uint8_t *alike = malloc(t->face_count + 1), *rays = malloc(t->face_count + 1);
    norma_result result = alike && rays && norma_fix_join(t) ? NORMA_OK : NORMA_ERROR_MEMORY;
    if (!result)
        result =
            norma_orient(&t->mesh, NORMA_ORIENT_OPEN_KEPT, &options, alike, t->face_count, NULL);
    if (!result)
        result = norma_orient(
            &t->mesh, NORMA_ORIENT_OPEN_BY_RAYS, &options, rays, t->face_count, &report);
    for (size_t f = 0; f < t->face_count && !result; f++)
        marks[f] = marks[f] && alike[f] != rays[f];
    if (!result && report.open) add_votes(t->group->plan, &report);
    free(alike);
    free(rays);
    return result;
}

/* ---- whole bodies; and those of which every shell has the wrong sign: what lies right inside one
 * that looks inward is turned with it, if all of it looks outward */

static void mark_bodies(const core_components *c, uint8_t *marks) {
    for (size_t i = 0; i < c->count; i++) {
        int any = 0;
        for (size_t k = c->starts[i]; k < c->starts[i + 1]; k++) any |= marks[c->faces[k]];
        for (size_t k = c->starts[i]; k < c->starts[i + 1]; k++) marks[c->faces[k]] = (uint8_t)any;
    }
}

static void mark_shells(const core_components *c, uint8_t *marks, uint8_t *keeps) {
    for (size_t i = 0; i < c->count; i++)
        if (c->each[i].parent != UINT32_MAX && c->each[i].verdict != COMPONENT_NESTED)
            keeps[c->each[i].parent] = 1;
    for (size_t i = 0; i < c->count; i++) {
        const uint32_t parent = c->each[i].parent;
        if (parent == UINT32_MAX || keeps[parent] || c->each[parent].verdict != COMPONENT_INWARD ||
            !marks[c->faces[c->starts[parent]]])
            continue;
        for (size_t k = c->starts[i]; k < c->starts[i + 1]; k++) marks[c->faces[k]] = 1;
    }
}

static norma_result judge_shells(core_topology *topology, uint8_t *marks) {
    static const uint8_t not_closed = COMPONENT_OPEN | COMPONENT_CONFLICT | COMPONENT_UNBALANCED;
    const core_topology_visitor nobody = {NULL, NULL, NULL, NULL};
    core_components c;
    norma_result result = norma_core_pair_edges(topology, &nobody);
    if (!result) result = norma_core_find_components(topology, CORE_JOIN_BODIES, &c);
    if (result) return result;
    uint8_t *keeps = calloc(c.count + 1, 1);
    result = keeps ? norma_core_measure_components(topology, &c, not_closed) : NORMA_ERROR_MEMORY;
    if (!result) result = norma_core_judge_nesting(topology, &c, not_closed);
    if (!result) mark_bodies(&c, marks);
    if (!result) mark_shells(&c, marks, keeps);
    free(keeps);
    norma_core_release_components(topology->call, &c);
    return result;
}

static norma_result turn_shells(fix_whole *t, uint8_t *marks) {
    const norma_options options = {
        .struct_size = sizeof options, .threads = t->group->request->options.threads};
    core_call call;
    core_mesh checked;
    core_topology topology;
    norma_result result = norma_core_begin(&call, &options);
    if (!result && !norma_fix_join(t)) result = NORMA_ERROR_MEMORY;
    if (!result) result = norma_core_mesh_shape(&t->mesh, &checked);
    if (!result) result = norma_core_mesh_content(&call, &checked);
    if (!result) result = norma_core_topology_open(&call, &checked, &topology);
    if (result) return result;
    result = judge_shells(&topology, marks);
    norma_core_topology_close(&topology);
    return result;
}

/* ---- all of it */

static norma_result turn(fix_whole *t, uint8_t *inward, uint8_t *open) {
    norma_result result = NORMA_OK;
    if (norma_fix_mark_named(t, RULE_N302, inward)) result = turn_shells(t, inward);
    if (result || !norma_fix_mark_named(t, RULE_N304, open)) return result;
    result = norma_fix_whole_bodies(t->meshes, t->group->count, open);
    return result ? result : ask_rays(t, open);
}

/* Of each mesh marks of its own, where there are any. */
static norma_result share_out(const fix_whole *t, const uint8_t *inward, const uint8_t *open) {
    size_t begin = 0;
    for (size_t i = 0; i < t->group->count; begin += t->meshes[i++].face_count) {
        uint8_t *marks = malloc(t->meshes[i].face_count + 1);
        int any = 0;
        if (!marks) return NORMA_ERROR_MEMORY;
        for (size_t f = 0; f < t->meshes[i].face_count; f++)
            any |= marks[f] = inward[begin + f] ^ open[begin + f];
        if (any)
            t->group->turned[t->group->indices[i]] = marks;
        else
            free(marks);
    }
    return NORMA_OK;
}

norma_document_result norma_fix_turn(const fix_group *group, norma_result *how) {
    fix_whole t;
    norma_document_result result = norma_fix_open_whole(group, &t, how);
    uint8_t *inward = calloc(t.face_count + 1, 1), *open = calloc(t.face_count + 1, 1);
    if (!result && !*how) *how = inward && open ? turn(&t, inward, open) : NORMA_ERROR_MEMORY;
    if (!result && !*how) *how = share_out(&t, inward, open);
    norma_fix_close_whole(&t);
    free(inward);
    free(open);
    return result;
}
