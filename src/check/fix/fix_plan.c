/* fix_plan.c: what the rules found and a program may put right: every element that a finding names,
 * by an edit of its mesh; missing normals by computing them; transforms by baking them. A plan is
 * made without a change to the document, and may be applied to any copy of it. */
#include "check/fix/fix.h"
#include "check/rules/rules.h"
#include "io/format/for_fixes.h"
#include <stdlib.h>
#include <string.h>

/* ---- one mesh */

static void strip_normals(fix_mesh *m) {
    if (norma_fix_has(m, RULE_N105))
        m->edit->strip_normals = NORMA_STRIP_ALL;
    else if (norma_fix_has(m, RULE_N903))
        m->edit->strip_normals = NORMA_STRIP_MORPHS;
}

static norma_result fix_arrays(fix_mesh *mesh) {
    norma_result result = norma_core_mesh_shape(&mesh->data.mesh, &mesh->mesh);
    mesh->mesh.scale = 1;
    if (!result) result = norma_fix_windings(mesh);
    if (!result) result = norma_fix_faces(mesh);
    if (!result) result = norma_fix_polygons(mesh);
    if (!result) result = norma_fix_positions(mesh);
    if (!result) result = norma_fix_normals(mesh);
    if (!result) result = norma_fix_tangents(mesh);
    strip_normals(mesh);
    if (!result) result = norma_fix_vertices(mesh);
    return result;
}

/* The facets of an STL are turned in one step and moved in another: what is to be moved is found
 * again once they are turned. */
static void part_steps(fix_mesh *m) {
    if (m->info.normals != NORMA_NORMALS_PER_FACET || !m->edit->reverse_faces ||
        !m->edit->set_positions)
        return;
    free((void *)(uintptr_t)m->edit->positions);
    free((void *)(uintptr_t)m->edit->set_positions);
    m->edit->positions = NULL;
    m->edit->set_positions = NULL;
}

static norma_document_result fix_mesh_of(fix_maker *m, size_t index) {
    fix_mesh mesh = {.document = m->document,
        .index = index,
        .plan = m->plan,
        .edit = &m->plan->edits[index],
        .shared = m->shared[index],
        .threads = m->request->options.threads};
    norma_document_result result = norma_document_mesh_info(m->document, index, &mesh.info);
    if (result || mesh.info.not_read) return result;
    mesh.findings = norma_places_find(&m->mended, mesh.info.where, &mesh.finding_count);
    if (mesh.finding_count > 0 || mesh.shared.turned || mesh.shared.smooth) {
        result = norma_document_mesh_data(m->document, index, &mesh.data, m->error);
        if (!result)
            result = norma_document_mesh_attributes(m->document, index, &mesh.attributes, m->error);
        mesh.known = norma_places_deviation(&m->known, mesh.info.where);
        if (!result) result = norma_fix_fail(m->error, fix_arrays(&mesh));
    }
    part_steps(&mesh);
    free(mesh.corners);
    free(mesh.surface);
    free(mesh.face_normals);
    return result;
}

/* ---- whole bodies, sides, seams between primitives */

/* Whether facets are named whose normals are on the other side. */
static int opposes(const fix_maker *m) {
    for (size_t i = 0; i < norma_findings_count(m->findings); ++i) {
        const norma_finding *finding = norma_findings_get(m->findings, i);
        if (norma_fix_is_rule(finding, RULE_N205) && m->request->wanted[RULE_N205] &&
            finding->worst_value > 90)
            return 1;
    }
    return 0;
}

static norma_document_result fix_groups(fix_maker *m) {
    const uint8_t *asked = m->plan->asked;
    const int turns = asked[RULE_N302] || asked[RULE_N304],
              sides = asked[RULE_N201] || asked[RULE_N301] || opposes(m), shares = asked[RULE_N501];
    norma_document_result result = NORMA_DOCUMENT_OK;
    while ((turns || sides || shares) && !result && m->next < m->plan->mesh_count) {
        check_judge own = {.is_open = 0};
        result = norma_fix_next_group(m);
        if (result || !m->count) continue;
        m->judge = m->request->judges ? &m->request->judges[m->indices[0]] : &own;
        if (turns) result = norma_fix_fail(m->error, norma_fix_turn(m));
        if (!result && sides) result = norma_fix_ask_sides(m);
        if (!result && m->count > 1 && shares)
            result = norma_fix_fail(m->error, norma_fix_seams(m));
        norma_check_close_judge(&own);
    }
    return result;
}

/* ---- the document: changes to the whole of it come after those of its meshes */

void norma_fix_plan_free(fix_plan *plan) {
    for (size_t i = 0; plan->edits && i < plan->mesh_count; ++i) {
        const norma_mesh_edit *edit = &plan->edits[i];
        const void *const blocks[] = {edit->reverse_faces, edit->drop_faces, edit->normals,
            edit->set_normals, edit->positions, edit->set_positions, edit->tangents,
            edit->set_tangents, edit->cut_faces, edit->cut_corners, edit->source_vertices,
            edit->new_corners};
        for (size_t k = 0; k < sizeof blocks / sizeof *blocks; ++k)
            free((void *)(uintptr_t)blocks[k]);
    }
    for (size_t i = 0; i < plan->note_count; ++i) free(plan->notes[i].text);
    free(plan->notes);
    free(plan->edits);
    free(plan->recentred);
    free(plan->greens);
    free(plan->tangents);
    free(plan->smoothed);
    *plan = (fix_plan){0};
}

static int has_edit(const fix_plan *plan) {
    for (size_t i = 0; i < plan->mesh_count; ++i)
        if (norma_fix_has_edit(&plan->edits[i])) return 1;
    return 0;
}

int norma_fix_plan_is_empty(const fix_plan *plan) {
    return !has_edit(plan) && !plan->recentred && !plan->greens && !plan->tangents &&
           !plan->smoothed && !plan->replaces && !plan->breaks && !plan->computes && !plan->bakes;
}

int norma_fix_plan_moves(const fix_plan *plan) {
    int moves = plan->recentred || plan->tangents || plan->smoothed || plan->bakes;
    for (size_t i = 0; i < plan->mesh_count; ++i)
        moves |= plan->edits[i].drop_faces || plan->edits[i].cut_faces ||
                 plan->edits[i].set_positions || plan->edits[i].source_vertices;
    return moves;
}

/* The rules whose fixes the document's findings ask for. */
static void mark_asked(fix_maker *m) {
    for (size_t i = 0; i < m->mended.count; ++i)
        m->plan->asked[m->mended.findings[i]->rule - norma_rules(NULL)] = 1;
}

/* The meshes that a rule names. */
static norma_document_result mark_meshes(fix_maker *m, check_rule rule, uint8_t **marks) {
    if (!m->plan->asked[rule]) return NORMA_DOCUMENT_OK;
    *marks = calloc(m->plan->mesh_count + 1, 1);
    if (!*marks) return norma_fix_fail(m->error, NORMA_ERROR_MEMORY);
    for (size_t i = 0; i < m->plan->mesh_count; ++i) {
        fix_mesh mesh = {.document = m->document};
        const norma_document_result result = norma_document_mesh_info(m->document, i, &mesh.info);
        if (result) return result;
        mesh.findings = norma_places_find(&m->mended, mesh.info.where, &mesh.finding_count);
        (*marks)[i] = (uint8_t)norma_fix_has(&mesh, rule);
    }
    return NORMA_DOCUMENT_OK;
}

static norma_document_result plan_rest(fix_maker *m) {
    fix_plan *plan = m->plan;
    const uint8_t *asked = plan->asked;
    /* Placeholders of an OBJ: corners with quite different normals name one vn. */
    plan->replaces = asked[RULE_N203] && norma_document_format(m->document) == NORMA_FILE_OBJ;
    plan->computes = asked[RULE_N104] || asked[RULE_N106] || asked[RULE_N806] || asked[RULE_N901];
    plan->morphs = asked[RULE_N901];
    plan->bakes = asked[RULE_N601] || asked[RULE_N602] || asked[RULE_N604];
    norma_document_result result = mark_meshes(m, RULE_N701, &plan->recentred);
    if (!result) result = mark_meshes(m, RULE_N207, &plan->smoothed);
    return result ? result : mark_meshes(m, RULE_N812, &plan->greens);
}

static norma_document_result plan_all(fix_maker *m) {
    const size_t meshes = m->plan->mesh_count;
    m->plan->edits = calloc(meshes + 1, sizeof *m->plan->edits);
    m->shared = calloc(meshes + 1, sizeof *m->shared);
    if (!m->plan->edits || !m->shared ||
        !norma_places_gather(&m->mended, m->findings, norma_fix_may, m->request) ||
        !norma_places_gather(&m->known, m->findings, NULL, NULL))
        return norma_fix_fail(m->error, NORMA_ERROR_MEMORY);
    mark_asked(m);
    norma_document_result result = fix_groups(m);
    for (size_t i = 0; i < meshes && !result; ++i) result = fix_mesh_of(m, i);
    return result ? result : plan_rest(m);
}

norma_document_result norma_fix_make_plan(norma_document *document, const fix_request *request,
    const norma_findings *found, fix_plan *plan, norma_document_error *error) {
    fix_maker m = {
        .document = document, .request = request, .findings = found, .plan = plan, .error = error};
    *plan = (fix_plan){.mesh_count = norma_document_mesh_count(document)};
    const norma_document_result result = plan_all(&m);
    for (size_t i = 0; m.shared && i < plan->mesh_count; ++i) {
        free(m.shared[i].turned);
        free(m.shared[i].sides);
        free(m.shared[i].smooth);
    }
    free(m.shared);
    free((void *)m.mended.findings);
    free((void *)m.known.findings);
    norma_fix_close_groups(&m);
    if (result) norma_fix_plan_free(plan);
    return result;
}

/* ---- a plan is carried out */

static norma_document_result compute_normals_of(norma_document *document,
    const norma_compute_options *options, int *changed, norma_document_error *error) {
    norma_compute_summary summary;
    const norma_document_result result = norma_document_compute(document, options, &summary, error);
    *changed |= !result && summary.changed;
    return result;
}

static norma_document_result compute_tangents(norma_document *document, const fix_plan *plan,
    uint32_t threads, int *changed, norma_document_error *error) {
    norma_tangent_summary summary;
    const norma_tangent_options options = {.struct_size = sizeof options,
        .mode = NORMA_TANGENTS_MIKK,
        .only = NORMA_ONLY_BROKEN,
        .threads = threads,
        .meshes = plan->tangents};
    const norma_document_result result =
        norma_document_tangents(document, &options, &summary, error);
    *changed |= !result && summary.changed;
    return result;
}

/* The caller gave no matrix, so numbers that do not fit are the file's own fault. */
static norma_document_result bake(
    norma_document *document, uint32_t threads, int *changed, norma_document_error *error) {
    norma_transform_summary summary;
    const norma_transform_options options = {
        .struct_size = sizeof options, .bake = 1, .threads = threads};
    norma_document_result result = norma_document_transform(document, &options, &summary, error);
    if (result == NORMA_DOCUMENT_ERROR_ARGUMENT) {
        result = NORMA_DOCUMENT_ERROR_MALFORMED;
        if (error) error->result = result;
    }
    *changed |= !result && summary.changed;
    return result;
}

norma_document_result norma_fix_apply(norma_document *document, const fix_plan *plan,
    uint32_t threads, int *changed, norma_document_error *error) {
    const norma_deviation *how = &plan->deviation;
    const norma_compute_options all = {.struct_size = sizeof all, .threads = threads},
                                creased = {.struct_size = sizeof creased,
                                    .shading = NORMA_SHADING_CREASE,
                                    .crease_angle_rad = NORMA_PI / 3,
                                    .groups = NORMA_GROUPS_IGNORE,
                                    .threads = threads,
                                    .meshes = plan->smoothed},
                                broken = {.struct_size = sizeof broken,
                                    .shading = how->shading,
                                    .crease_angle_rad = how->shading == NORMA_SHADING_CREASE
                                                            ? how->crease_angle_rad
                                                            : 0,
                                    .weight = how->weight,
                                    .groups = NORMA_GROUPS_IGNORE,
                                    .only = NORMA_ONLY_BROKEN,
                                    .threads = threads},
                                missing = {.struct_size = sizeof missing,
                                    .only = NORMA_ONLY_MISSING,
                                    .morphs = plan->morphs,
                                    .threads = threads,
                                    .tangents = plan->asked[RULE_N806]
                                                    ? NORMA_STORED_TANGENTS_REGENERATE
                                                    : NORMA_STORED_TANGENTS_ORTHOGONALISE};
    norma_document_result result = NORMA_DOCUMENT_OK;
    int moved = 0, turned = 0;
    if (has_edit(plan)) {
        result = norma_document_edit(document, plan->edits, error);
        *changed |= !result;
    }
    if (!result && plan->recentred)
        result = norma_document_recentre(document, plan->recentred, &moved, error);
    *changed |= moved;
    if (!result && plan->greens)
        result = norma_document_turn_green(document, plan->greens, &turned, error);
    *changed |= turned;
    if (!result && plan->replaces) result = compute_normals_of(document, &all, changed, error);
    if (!result && plan->breaks) result = compute_normals_of(document, &broken, changed, error);
    if (!result && plan->smoothed) result = compute_normals_of(document, &creased, changed, error);
    if (!result && plan->computes) result = compute_normals_of(document, &missing, changed, error);
    if (!result && plan->tangents)
        result = compute_tangents(document, plan, threads, changed, error);
    return result || !plan->bakes ? result : bake(document, threads, changed, error);
}
