/* fix_plan.c: what the rules found and a program may put right: every element that a finding names,
 * by an edit of its mesh; missing normals by computing them; transforms by baking them. A plan is
 * made without a change to the document, and may be applied to any copy of it. */
#include "check/fix/fix.h"
#include "io/format/for_fixes.h"
#include <stdlib.h>
#include <string.h>

/* ---- Bodies that N302 names, to be reversed as a whole. As the rule has it, what is
 * closed in its own primitive is a body by itself, and the open parts of all primitives of a glTF
 * mesh are joined where their edges have equal positions. */

typedef struct bodies {
    const core_mesh *meshes;
    size_t count, face_count;
    fix_edge *edges;
    size_t edge_count;
    uint32_t *parts, *joined; /* of each face a face of the same part; of the same body */
    uint8_t *open;            /* at the face that stands for a part */
} bodies;

static int same_edge(const fix_edge *a, const fix_edge *b) {
    return norma_fix_compare_points(a->a, b->a) == 0 && norma_fix_compare_points(a->b, b->b) == 0;
}

/* ---- edges: of faces that have three or more */

static int gather_body_edges(bodies *b) {
    size_t corners = 0, face = 0;
    for (size_t i = 0; i < b->count; ++i) corners += b->meshes[i].corner_count;
    b->edges = malloc((corners + 1) * sizeof *b->edges);
    for (size_t i = 0; b->edges && i < b->count; ++i)
        for (size_t f = 0; f < b->meshes[i].face_count; ++f, ++face) {
            fix_edge *edges = b->edges + b->edge_count;
            const size_t count =
                norma_fix_face_edges(&b->meshes[i], f, (uint32_t)face, (uint32_t)i, edges);
            b->edge_count += count < 3 ? 0 : count;
        }
    if (b->edges) qsort(b->edges, b->edge_count, sizeof *b->edges, norma_fix_compare_edges);
    return b->edges != NULL;
}

/* ---- parts and bodies */

static void find_body_parts(bodies *b) {
    const fix_edge *e = b->edges;
    for (size_t i = 1; i < b->edge_count; ++i)
        if (norma_fix_compare_edges(&e[i - 1], &e[i]) == 0)
            norma_core_join_sets(b->parts, e[i - 1].face, e[i].face);
    for (size_t begin = 0, end; begin < b->edge_count; begin = end) {
        for (end = begin + 1;
             end < b->edge_count && norma_fix_compare_edges(&e[begin], &e[end]) == 0;)
            ++end;
        if (end - begin != 2 || e[begin].way == e[begin + 1].way)
            b->open[norma_core_set_of(b->parts, e[begin].face)] = 1;
    }
}

static void join_open(bodies *b) {
    for (size_t f = 0; f < b->face_count; ++f)
        b->joined[f] = norma_core_set_of(b->parts, (uint32_t)f);
    for (size_t begin = 0, end; begin < b->edge_count; begin = end) {
        size_t first = SIZE_MAX;
        for (end = begin; end < b->edge_count && same_edge(&b->edges[begin], &b->edges[end]);
             ++end) {
            const uint32_t part = norma_core_set_of(b->parts, b->edges[end].face);
            if (!b->open[part]) continue;
            if (first != SIZE_MAX)
                norma_core_join_sets(b->joined, b->edges[first].face, b->edges[end].face);
            first = end;
        }
    }
}

/* named: a mark for each face of all meshes; those of whole bodies in which a face
 * is marked become marked. */
static norma_result fix_whole_bodies(const core_mesh *meshes, size_t count, uint8_t *named) {
    bodies b = {.meshes = meshes, .count = count};
    for (size_t i = 0; i < count; ++i) b.face_count += meshes[i].face_count;
    b.parts = malloc((b.face_count + 1) * sizeof *b.parts);
    b.joined = malloc((b.face_count + 1) * sizeof *b.joined);
    b.open = calloc(b.face_count + 1, 1);
    uint8_t *bodies_named = calloc(b.face_count + 1, 1);
    const int fine = b.parts && b.joined && b.open && bodies_named && b.face_count < UINT32_MAX &&
                     gather_body_edges(&b);
    if (fine) {
        for (size_t f = 0; f < b.face_count; ++f) b.parts[f] = (uint32_t)f;
        find_body_parts(&b);
        join_open(&b);
        for (size_t f = 0; f < b.face_count; ++f)
            if (named[f]) bodies_named[norma_core_set_of(b.joined, (uint32_t)f)] = 1;
        for (size_t f = 0; f < b.face_count; ++f)
            named[f] = bodies_named[norma_core_set_of(b.joined, (uint32_t)f)];
    }
    free(b.edges);
    free(b.parts);
    free(b.joined);
    free(b.open);
    free(bodies_named);
    return fine ? NORMA_OK : NORMA_ERROR_MEMORY;
}

/* ---- Which faces are reversed with the whole body that they belong to: bodies that look
 * inward (N302), and, where that is asked for, open ones (N304) as a majority of rays has it. The
 * primitives of a glTF mesh are looked at together, as those rules do. */

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
    check_joined whole;
    uint8_t *alike = malloc(t->face_count + 1), *rays = malloc(t->face_count + 1);
    norma_result result = norma_check_join(t->meshes, t->group->count, &whole);
    if (!result && !(alike && rays)) result = NORMA_ERROR_MEMORY;
    if (!result)
        result =
            norma_orient(&whole.mesh, NORMA_ORIENT_OPEN_KEPT, &options, alike, t->face_count, NULL);
    if (!result)
        result = norma_orient(
            &whole.mesh, NORMA_ORIENT_OPEN_BY_RAYS, &options, rays, t->face_count, &report);
    for (size_t f = 0; f < t->face_count && !result; ++f)
        marks[f] = marks[f] && alike[f] != rays[f];
    if (!result && report.open) add_votes(t->group->plan, &report);
    norma_check_unjoin(&whole);
    free(alike);
    free(rays);
    return result;
}

/* ---- whole bodies; and those of which every shell has the wrong sign: what lies right inside one
 * that looks inward is turned with it, if all of it looks outward */

static void mark_bodies(const core_components *c, uint8_t *marks) {
    for (size_t i = 0; i < c->count; ++i) {
        int any = 0;
        for (size_t k = c->starts[i]; k < c->starts[i + 1]; ++k) any |= marks[c->faces[k]];
        for (size_t k = c->starts[i]; k < c->starts[i + 1]; ++k) marks[c->faces[k]] = (uint8_t)any;
    }
}

static void mark_shells(const core_components *c, uint8_t *marks, uint8_t *keeps) {
    for (size_t i = 0; i < c->count; ++i)
        if (c->each[i].parent != UINT32_MAX && c->each[i].verdict != COMPONENT_NESTED)
            keeps[c->each[i].parent] = 1;
    for (size_t i = 0; i < c->count; ++i) {
        const uint32_t parent = c->each[i].parent;
        if (parent == UINT32_MAX || keeps[parent] || c->each[parent].verdict != COMPONENT_INWARD ||
            !marks[c->faces[c->starts[parent]]])
            continue;
        for (size_t k = c->starts[i]; k < c->starts[i + 1]; ++k) marks[c->faces[k]] = 1;
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
    check_joined whole;
    norma_result result = norma_core_begin(&call, &options);
    if (!result) result = norma_check_join(t->meshes, t->group->count, &whole);
    if (result) return result;
    result = norma_core_mesh_shape(&whole.mesh, &checked);
    if (!result) result = norma_core_mesh_content(&call, &checked);
    if (!result) result = norma_core_topology_open(&call, &checked, &topology);
    if (!result) {
        result = judge_shells(&topology, marks);
        norma_core_topology_close(&topology);
    }
    norma_check_unjoin(&whole);
    return result;
}

/* ---- all of it */

static norma_result turn_whole(fix_whole *t, uint8_t *inward, uint8_t *open) {
    norma_result result = NORMA_OK;
    if (norma_fix_mark_whole(t, RULE_N302, inward)) result = turn_shells(t, inward);
    if (result || !norma_fix_mark_whole(t, RULE_N304, open)) return result;
    result = fix_whole_bodies(t->meshes, t->group->count, open);
    return result ? result : ask_rays(t, open);
}

/* Of each mesh marks of its own, where there are any. */
static norma_result share_turned(const fix_whole *t, const uint8_t *inward, const uint8_t *open) {
    size_t begin = 0;
    for (size_t i = 0; i < t->group->count; begin += t->meshes[i++].face_count) {
        uint8_t *marks = malloc(t->meshes[i].face_count + 1);
        int any = 0;
        if (!marks) return NORMA_ERROR_MEMORY;
        for (size_t f = 0; f < t->meshes[i].face_count; ++f)
            any |= marks[f] = inward[begin + f] ^ open[begin + f];
        if (any)
            t->group->turned[t->group->indices[i]] = marks;
        else
            free(marks);
    }
    return NORMA_OK;
}

/* N302, N304 */
static norma_document_result fix_turn(const fix_group *group, norma_result *how) {
    fix_whole t;
    norma_document_result result = norma_fix_open_whole(group, &t, how);
    uint8_t *inward = calloc(t.face_count + 1, 1), *open = calloc(t.face_count + 1, 1);
    if (!result && !*how) *how = inward && open ? turn_whole(&t, inward, open) : NORMA_ERROR_MEMORY;
    if (!result && !*how) *how = share_turned(&t, inward, open);
    norma_fix_close_whole(&t);
    free(inward);
    free(open);
    return result;
}

/* ---- the plan of a document */

typedef struct mender {
    norma_document *document;
    const fix_request *request;
    const norma_findings *findings;
    check_places mended, known; /* findings that may be mended; all */
    fix_plan *plan;
    uint8_t **turned; /* of each mesh marks of faces, or NULL */
    uint8_t **sides;  /* of each mesh which faces are turned, or NULL */
    float **smooth;   /* of each mesh normals at seams of several primitives, or NULL */
    size_t mesh_count;
    norma_document_error *error;
} mender;

static norma_document_result fail_plan(const mender *m, norma_result result) {
    const norma_document_result as = result == NORMA_CANCELLED ? NORMA_DOCUMENT_CANCELLED
                                     : result == NORMA_ERROR_MEMORY
                                         ? NORMA_DOCUMENT_ERROR_MEMORY
                                         : NORMA_DOCUMENT_ERROR_MALFORMED;
    if (m->error) {
        m->error->result = as;
        norma_check_message(m->error->message, "cannot be fixed: %s", norma_result_text(result));
    }
    return as;
}

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

static norma_document_result fix_mesh_of(mender *m, size_t index) {
    fix_mesh mesh = {.document = m->document,
        .index = index,
        .plan = m->plan,
        .edit = &m->plan->edits[index],
        .turned = m->turned[index],
        .sides = m->sides[index],
        .smooth = m->smooth[index],
        .threads = m->request->options.threads};
    norma_result mended = NORMA_OK;
    norma_document_result result = norma_document_mesh_info(m->document, index, &mesh.info);
    if (result || mesh.info.not_read) return result;
    mesh.findings = norma_places_find(&m->mended, mesh.info.where, &mesh.finding_count);
    if (mesh.finding_count > 0 || mesh.turned || mesh.smooth) {
        result = norma_document_mesh_data(m->document, index, &mesh.data, m->error);
        if (!result)
            result = norma_document_mesh_attributes(m->document, index, &mesh.attributes, m->error);
        mesh.known = norma_places_deviation(&m->known, mesh.info.where);
        if (!result) mended = fix_arrays(&mesh);
    }
    part_steps(&mesh);
    free(mesh.corners);
    free(mesh.surface);
    free(mesh.face_normals);
    return mended ? fail_plan(m, mended) : result;
}

/* ---- whole bodies, seams between primitives */

size_t norma_fix_gather_group(const norma_document *document, size_t first, size_t *indices,
    const char **wheres, size_t *count) {
    norma_mesh_info info;
    size_t mesh = 0, i = first;
    for (*count = 0; i < norma_document_mesh_count(document); ++i) {
        if (norma_document_mesh_info(document, i, &info) || (i > first && info.mesh != mesh)) break;
        mesh = info.mesh;
        if (info.not_read) continue;
        if (wheres) wheres[*count] = info.where;
        indices[(*count)++] = i;
    }
    return i > first ? i : first + 1;
}

static norma_document_result fix_groups(mender *m, int turns, int sides, int shares) {
    size_t *indices = calloc(m->mesh_count + 1, sizeof *indices), count;
    const char **wheres = calloc(m->mesh_count + 1, sizeof *wheres);
    norma_document_result result =
        indices && wheres ? NORMA_DOCUMENT_OK : fail_plan(m, NORMA_ERROR_MEMORY);
    for (size_t first = 0; first < m->mesh_count && !result;) {
        norma_result how = NORMA_OK;
        first = norma_fix_gather_group(m->document, first, indices, wheres, &count);
        const fix_group group = {m->document, &m->mended, &m->known, indices, wheres, count,
            m->request, m->turned, m->sides, m->smooth, m->plan, m->error};
        if (count && turns) result = fix_turn(&group, &how);
        if (count && !result && !how && sides) result = norma_fix_ask_sides(&group, &how);
        if (!result && !how && count > 1 && shares) result = norma_fix_seams(&group, &how);
        if (!result && how) result = fail_plan(m, how);
    }
    free(indices);
    free((void *)wheres);
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
static void mark_asked(mender *m) {
    for (size_t i = 0; i < m->mended.count; ++i)
        m->plan->asked[m->mended.findings[i]->rule - norma_rules(NULL)] = 1;
}

/* The meshes that a rule names. */
static norma_document_result mark_meshes(mender *m, check_rule rule, uint8_t **marks) {
    if (!m->plan->asked[rule]) return NORMA_DOCUMENT_OK;
    *marks = calloc(m->mesh_count + 1, 1);
    if (!*marks) return fail_plan(m, NORMA_ERROR_MEMORY);
    for (size_t i = 0; i < m->mesh_count; ++i) {
        fix_mesh mesh = {.document = m->document};
        const norma_document_result result = norma_document_mesh_info(m->document, i, &mesh.info);
        if (result) return result;
        mesh.findings = norma_places_find(&m->mended, mesh.info.where, &mesh.finding_count);
        (*marks)[i] = (uint8_t)norma_fix_has(&mesh, rule);
    }
    return NORMA_DOCUMENT_OK;
}

static norma_document_result plan_rest(mender *m) {
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

/* Whether facets are named whose normals are on the other side. */
static int opposes(const mender *m) {
    for (size_t i = 0; i < norma_findings_count(m->findings); ++i) {
        const norma_finding *finding = norma_findings_get(m->findings, i);
        if (norma_fix_is_rule(finding, RULE_N205) && m->request->wanted[RULE_N205] &&
            finding->worst_value > 90)
            return 1;
    }
    return 0;
}

static norma_document_result plan_all(mender *m) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    m->plan->mesh_count = m->mesh_count;
    m->plan->edits = calloc(m->mesh_count + 1, sizeof *m->plan->edits);
    m->turned = calloc(m->mesh_count + 1, sizeof *m->turned);
    m->sides = calloc(m->mesh_count + 1, sizeof *m->sides);
    m->smooth = calloc(m->mesh_count + 1, sizeof *m->smooth);
    if (!m->plan->edits || !m->turned || !m->sides || !m->smooth ||
        !norma_places_gather(&m->mended, m->findings, norma_fix_may, m->request) ||
        !norma_places_gather(&m->known, m->findings, NULL, NULL))
        return fail_plan(m, NORMA_ERROR_MEMORY);
    mark_asked(m);
    const int turns = m->plan->asked[RULE_N302] || m->plan->asked[RULE_N304],
              sides = m->plan->asked[RULE_N201] || m->plan->asked[RULE_N301] || opposes(m),
              shares = m->plan->asked[RULE_N501];
    if (turns || sides || shares) result = fix_groups(m, turns, sides, shares);
    for (size_t i = 0; i < m->mesh_count && !result; ++i) result = fix_mesh_of(m, i);
    return result ? result : plan_rest(m);
}

norma_document_result norma_fix_make_plan(norma_document *document, const fix_request *request,
    const norma_findings *found, fix_plan *plan, norma_document_error *error) {
    mender m = {.document = document,
        .request = request,
        .findings = found,
        .plan = plan,
        .mesh_count = norma_document_mesh_count(document),
        .error = error};
    *plan = (fix_plan){0};
    const norma_document_result result = plan_all(&m);
    for (size_t i = 0; m.turned && m.sides && m.smooth && i < m.mesh_count; ++i) {
        free(m.turned[i]);
        free(m.sides[i]);
        free(m.smooth[i]);
    }
    free((void *)m.turned);
    free((void *)m.sides);
    free((void *)m.smooth);
    free((void *)m.mended.findings);
    free((void *)m.known.findings);
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
