/* fix_trial.c: what fixes would make of a document, found out on a copy of it, and measured. */
#include "check/fix/fix.h"
#include "core/topology/topology.h"
#include "io/format/for_fixes.h"
#include <stdlib.h>
#include <string.h>

static norma_document_result fail_trial(
    norma_document_error *error, norma_document_result result, const char *text) {
    if (error) {
        error->result = result;
        norma_check_message(error->message, "cannot be fixed: %s", text);
    }
    return result;
}

/* ---- edges: of the primitives of a glTF mesh together */

typedef struct edge_count { /* of a block */
    size_t loose, surplus;
} edge_count;

static void tally_edge(
    void *context, size_t block, uint32_t position, const core_edge_run *runs, size_t count) {
    edge_count *counts = context;
    size_t out = 0;
    (void)position;
    for (size_t i = 0; i < count; i++) out += runs[i].out != 0;
    counts[block].loose += 2 * out != count;
    counts[block].surplus += count > 2 ? count - 2 : 0;
}

static norma_result count_odd_edges(
    const norma_mesh *mesh, uint32_t threads, fix_measure *measure) {
    core_call call;
    core_mesh checked;
    core_topology topology;
    const norma_options options = {.struct_size = sizeof options, .threads = threads};
    norma_result result = norma_core_begin(&call, &options);
    if (!result) result = norma_core_mesh_shape(mesh, &checked);
    if (!result) result = norma_core_mesh_content(&call, &checked);
    if (!result) result = norma_core_topology_open(&call, &checked, &topology);
    if (result) return result;
    const size_t blocks = norma_core_topology_blocks(&topology);
    edge_count *counts = calloc(blocks + 1, sizeof *counts);
    const core_topology_visitor visitor = {.context = counts, .edge = tally_edge};
    result = counts ? norma_core_pair_edges(&topology, &visitor) : NORMA_ERROR_MEMORY;
    for (size_t i = 0; counts && i < blocks; i++) {
        measure->loose += counts[i].loose;
        measure->surplus += counts[i].surplus;
    }
    free(counts);
    norma_core_topology_close(&topology);
    return result;
}

/* ---- normals on the other side */

static int is_opposed(const fix_mesh *m, size_t face, const core_face *geometry, double across) {
    const size_t begin = norma_core_face_begin(&m->mesh, face),
                 end = norma_core_face_end(&m->mesh, face);
    int opposed = end > begin;
    for (size_t c = begin; c < end && opposed; c++) {
        double n[3];
        const size_t number = norma_fix_normal_of(m, face, c);
        if (number == SIZE_MAX) return 0;
        norma_view_read(&m->data.normals, number, n);
        opposed = norma_core_dot(geometry->normal, n) < -across * norma_core_length(n);
    }
    return opposed;
}

/* Whatever else is wrong with them: rules are silent where others hold. */
static norma_document_result measure_normals(
    const fix_group *group, size_t index, fix_measure *measure) {
    fix_mesh m = {.document = group->document};
    norma_document_result result = norma_document_mesh_info(group->document, index, &m.info);
    if (!result) result = norma_document_mesh_data(group->document, index, &m.data, group->error);
    if (result || norma_core_mesh_shape(&m.data.mesh, &m.mesh)) return result;
    m.mesh.scale = 1;
    const double across = fmax(1e-6, norma_check_encoding_bound(m.info.encoding));
    for (size_t face = 0; face < m.mesh.face_count; face++) {
        core_face geometry;
        norma_core_face_geometry(&m.mesh, face, &geometry);
        if (!(geometry.flags & CORE_FACE_FINITE)) continue;
        measure->area += geometry.twice_area;
        if (geometry.flags & CORE_FACE_DIRECTED && is_opposed(&m, face, &geometry, across))
            measure->opposed += geometry.twice_area;
    }
    return result;
}

norma_document_result norma_fix_measure_shape(norma_document *document, const fix_request *request,
    fix_measure *measure, norma_document_error *error) {
    const size_t meshes = norma_document_mesh_count(document);
    size_t *indices = calloc(meshes + 1, sizeof *indices), of;
    norma_document_result result = NORMA_DOCUMENT_OK;
    norma_result how = indices ? NORMA_OK : NORMA_ERROR_MEMORY;
    for (size_t first = 0; first < meshes && !result && !how;) {
        const fix_group group = {.document = document, .indices = indices, .error = error};
        fix_whole whole;
        first = norma_fix_gather_group(document, first, indices, NULL, &of);
        if (!of) continue;
        fix_group these = group;
        these.count = of;
        result = norma_fix_open_whole(&these, &whole, &how);
        if (!result && !how && whole.face_count)
            how = norma_fix_join(&whole)
                      ? count_odd_edges(&whole.mesh, request->options.threads, measure)
                      : NORMA_ERROR_MEMORY;
        norma_fix_close_whole(&whole);
        for (size_t i = 0; i < of && !result && !how; i++)
            result = measure_normals(&these, indices[i], measure);
    }
    free(indices);
    measure->has_shape = 1;
    if (result || !how) return result;
    return fail_trial(error,
        how == NORMA_ERROR_MEMORY ? NORMA_DOCUMENT_ERROR_MEMORY : NORMA_DOCUMENT_ERROR_MALFORMED,
        norma_result_text(how));
}

/* ---- better or worse */

/* By all rules; by those that look into images only where that is asked for. */
static norma_document_result find_by_all(norma_document *document, const fix_request *request,
    int maps, size_t max_samples, norma_findings **findings, norma_document_error *error) {
    norma_check_options options = request->options;
    uint8_t rules[CHECK_RULE_COUNT];
    memset(rules, 1, sizeof rules);
    rules[RULE_N811] = rules[RULE_N812] = (uint8_t)(maps != 0);
    options.rules = rules;
    options.max_samples = max_samples;
    return norma_check_document(document, &options, findings, error);
}

norma_document_result norma_fix_find(norma_document *document, const fix_request *request,
    norma_findings **findings, norma_document_error *error) {
    return find_by_all(document, request, request->reads_maps, SIZE_MAX, findings, error);
}

static norma_document_result measure_copy(norma_document *copy, const fix_request *request,
    fix_measure *measure, norma_document_error *error) {
    const norma_document_result result =
        find_by_all(copy, request, request->changes_maps, 1, &measure->findings, error);
    return result ? result : norma_fix_measure_shape(copy, request, measure, error);
}

void norma_fix_measure_free(fix_measure *measure) {
    norma_findings_free(measure->findings);
    *measure = (fix_measure){0};
}

typedef struct verdict { /* of each rule: elements at warning or above, and the gravest severity */
    size_t counts[CHECK_RULE_COUNT];
    norma_severity gravest[CHECK_RULE_COUNT];
} verdict;

static verdict weigh_findings(const norma_findings *findings) {
    verdict sum = {0};
    size_t count;
    for (size_t i = 0; i < norma_findings_count(findings); i++) {
        const norma_finding *finding = norma_findings_get(findings, i);
        const size_t rule = (size_t)(finding->rule - norma_rules(&count));
        if (finding->severity < NORMA_SEVERITY_WARNING) continue;
        sum.counts[rule] += finding->count;
        if (finding->severity > sum.gravest[rule]) sum.gravest[rule] = finding->severity;
    }
    return sum;
}

static int is_found_at(const norma_findings *findings, check_rule rule, const char *where) {
    for (size_t i = 0; i < norma_findings_count(findings); i++) {
        const norma_finding *finding = norma_findings_get(findings, i);
        if (norma_fix_is_rule(finding, rule) && strcmp(finding->where, where) == 0) return 1;
    }
    return 0;
}

/* Whether one part of a map is right now, and another wrong. */
static int changes_place(const fix_measure *before, const fix_measure *after, check_rule rule) {
    for (size_t i = 0; i < norma_findings_count(after->findings); i++) {
        const norma_finding *finding = norma_findings_get(after->findings, i);
        if (norma_fix_is_rule(finding, rule) &&
            !is_found_at(before->findings, rule, finding->where))
            return 1;
    }
    return 0;
}

const char *norma_fix_worse_shape(const fix_measure *before, const fix_measure *after) {
    const double whole = fmax(before->area, after->area);
    return after->loose > before->loose       ? "closed edges would become open"
           : after->surplus > before->surplus ? "an edge would get a third face"
           : after->opposed > before->opposed + 1e-9 * whole
               ? "a face would have its normals on the other side"
               : NULL;
}

int norma_fix_find_worse(const fix_measure *before, const fix_measure *after, uint8_t *worse) {
    const verdict was = weigh_findings(before->findings), is = weigh_findings(after->findings);
    int any = norma_fix_worse_shape(before, after) != NULL;
    for (size_t i = 0; i < CHECK_RULE_COUNT; i++)
        worse[i] = is.counts[i] > was.counts[i] || is.gravest[i] > was.gravest[i];
    worse[RULE_N812] |= (uint8_t)changes_place(before, after, RULE_N812);
    for (size_t i = 0; i < CHECK_RULE_COUNT; i++) any |= worse[i];
    return any;
}

/* ---- a trial */

static norma_document_result take_steps(norma_document *copy, const fix_request *request,
    fix_trial *trial, norma_document_error *error) {
    fix_request next = *request;
    norma_document_result result = NORMA_DOCUMENT_OK;
    int changed = 1;
    while (!result && changed && trial->count <= FIX_MOST_STEPS) {
        fix_plan *plan = &trial->plans[trial->count - 1];
        changed = 0;
        if (norma_fix_plan_is_empty(plan)) break;
        result = norma_fix_apply(copy, plan, request->options.threads, &changed, error);
        if (result || !changed || trial->count == FIX_MOST_STEPS) break;
        /* What rays said they would say again, but where something was moved since. */
        next.by_rays = request->by_rays && norma_fix_plan_moves(plan);
        /* What one turn of a map does not make right, another would only undo. */
        next.left_out[RULE_N812] |= plan->greens != NULL;
        result = norma_fix_make_plan(copy, &next, NULL, &trial->plans[trial->count], error);
        trial->count += !result;
    }
    return result;
}

norma_document_result norma_fix_try(norma_document *document, const fix_request *request,
    fix_plan *first, fix_trial *trial, norma_document_error *error) {
    norma_document *copy = NULL;
    *trial = (fix_trial){.plans = {*first}, .count = 1};
    *first = (fix_plan){0};
    norma_document_result result = norma_document_copy(document, &copy, error);
    const size_t notes = norma_document_note_count(copy);
    if (!result) result = take_steps(copy, request, trial, error);
    if (!result) result = measure_copy(copy, request, &trial->after, error);
    if (!result && norma_document_note_count(copy) > notes)
        norma_check_message(trial->said, "%s", norma_document_note(copy, notes));
    norma_document_close(copy);
    return result;
}

void norma_fix_trial_free(fix_trial *trial) {
    for (size_t i = 0; i < trial->count; i++) norma_fix_plan_free(&trial->plans[i]);
    norma_fix_measure_free(&trial->after);
    *trial = (fix_trial){0};
}
