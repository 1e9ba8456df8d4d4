/* orient.c: a consistent winding for each part, cut at edges of more than two faces; outward for
 * what is closed, by signed volume and by how the parts lie in one another. */
#include "core/orient/orient.h"
#include "core/face/triangle.h"

static const uint8_t NOT_CLOSED = COMPONENT_OPEN | COMPONENT_ONE_SIDED | COMPONENT_UNBALANCED;

typedef struct edge_count {
    size_t many, conflicts;
} edge_count;

static void count_edge(
    void *context, size_t block, uint32_t position, const core_edge_run *runs, size_t count) {
    edge_count *counts = context;
    (void)position;
    (void)runs;
    counts[block].many += count > 2;
    counts[block].conflicts += count == 2;
}

static norma_result pair_and_count(core_topology *t, norma_orient_report *report) {
    const size_t blocks = norma_core_topology_blocks(t);
    edge_count *counts = norma_core_allocate(t->call, blocks, sizeof *counts);
    if (!counts) return NORMA_ERROR_MEMORY;
    memset(counts, 0, blocks * sizeof *counts);
    const core_topology_visitor visitor = {.context = counts, .edge = count_edge};
    const norma_result result = norma_core_pair_edges(t, &visitor);
    for (size_t i = 0; i < blocks; i++) {
        report->non_manifold_edges += counts[i].many;
        report->winding_conflicts += counts[i].conflicts;
    }
    norma_core_release(t->call, counts, blocks, sizeof *counts);
    return result;
}

static void turn_round(core_components *c, size_t part) {
    for (size_t k = c->starts[part]; k < c->starts[part + 1]; k++)
        c->reverse[c->faces[k]] = !c->reverse[c->faces[k]];
}

static void turn_outward(core_components *c, norma_orient_report *report) {
    for (size_t i = 0; i < c->count; i++) {
        const core_component *part = &c->each[i];
        report->closed += !(part->flags & NOT_CLOSED);
        report->one_sided += (part->flags & COMPONENT_ONE_SIDED) != 0;
        report->open += (part->flags & NOT_CLOSED) && !(part->flags & COMPONENT_ONE_SIDED);
        report->nested += part->verdict == COMPONENT_NESTED;
        report->inward += part->verdict == COMPONENT_INWARD;
        if (part->verdict == COMPONENT_INWARD) turn_round(c, i);
    }
}

static norma_result orient_parts(
    core_topology *t, norma_orient_open open, core_components *c, norma_orient_report *report) {
    norma_result result = norma_core_measure_components(t, c, NOT_CLOSED);
    if (result == NORMA_OK) result = norma_core_judge_nesting(t, c, NOT_CLOSED);
    if (result != NORMA_OK) return result;
    turn_outward(c, report);
    report->parts = c->count;
    report->undecided = report->open;
    if (open != NORMA_ORIENT_OPEN_BY_RAYS || !report->open) return NORMA_OK;
    core_ray_votes votes;
    result = norma_core_orient_by_rays(t, c, COMPONENT_OPEN | COMPONENT_UNBALANCED, &votes);
    report->undecided = votes.undecided;
    report->by_rays = votes.decided;
    report->least_confidence = votes.least_confidence;
    return result;
}

static norma_result orient(
    core_topology *t, norma_orient_open open, uint8_t *reverse, norma_orient_report *report) {
    core_components components;
    norma_core_stage(t->call, 0.3, 0.6);
    norma_result result = pair_and_count(t, report);
    if (result == NORMA_OK) result = norma_core_find_components(t, CORE_JOIN_CUT, &components);
    if (result != NORMA_OK) return result;
    norma_core_stage(t->call, 0.6, 1);
    result = orient_parts(t, open, &components, report);
    for (size_t f = 0; result == NORMA_OK && f < t->mesh.face_count; f++) {
        reverse[f] = components.reverse[f] != 0;
        report->reversed_faces += reverse[f];
    }
    norma_core_release_components(t->call, &components);
    return result;
}

norma_result norma_orient(const norma_mesh *mesh, norma_orient_open open,
    const norma_options *options, uint8_t *reverse, size_t capacity, norma_orient_report *report) {
    core_call call;
    core_mesh checked;
    core_topology topology;
    norma_orient_report counted = {.least_confidence = 1};
    norma_result result = norma_core_begin(&call, options);
    if (result == NORMA_OK) result = norma_core_mesh_shape(mesh, &checked);
    if (result == NORMA_OK) norma_core_share(&call, checked.corner_count);
    if (result == NORMA_OK && ((checked.face_count && !reverse) || open < NORMA_ORIENT_OPEN_KEPT ||
                                  open > NORMA_ORIENT_OPEN_BY_RAYS))
        result = NORMA_ERROR_ARGUMENT;
    if (result == NORMA_OK && capacity < checked.face_count) result = NORMA_ERROR_CAPACITY;
    norma_core_stage(&call, 0, 0.1);
    if (result == NORMA_OK) result = norma_core_mesh_content(&call, &checked);
    if (result != NORMA_OK) return result;
    if (checked.face_count) {
        norma_core_stage(&call, 0.1, 0.3);
        result = norma_core_topology_open(&call, &checked, &topology);
        if (result != NORMA_OK) return result;
        result = orient(&topology, open, reverse, &counted);
        norma_core_topology_close(&topology);
    }
    if (result == NORMA_OK && report) *report = counted;
    return result;
}
