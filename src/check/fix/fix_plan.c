/* What the rules found and a program may put right: every element that a finding names, by an edit
 * of its mesh; missing normals by computing them; transforms by baking them. A plan is made without
 * a change to the document, and may be applied to any copy of it. A trial applies plans to a copy,
 * step by step, and measures what became of it. */
#include "check/fix/fix.h"
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

/* Whether faces or positions do not stay. */
static int plan_moves(const fix_plan *plan) {
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

/* ---- what fixes would make of a document, found out on a copy of it, and measured */

/* ---- shapes that are found again by their positions: what is one less here and one more there is
 * the same in number */

enum { MOST_SHAPES = 1 << 20 };        /* noted; where there are more, sums must do */
static const double SHAPE_NEAR = 4e-6; /* of the diagonal: N503 moves by less */
static const double SHAPE_KEY[] = {
    1, .62, .27}; /* a direction in which little lies at right angles */

static double shape_key(const double p[3]) {
    return SHAPE_KEY[0] * p[0] + SHAPE_KEY[1] * p[1] + SHAPE_KEY[2] * p[2];
}

/* Its points follow. 0: out of memory. */
static int begin_shape(fix_shapes *s, size_t mesh) {
    fix_shape *each = norma_check_grow(s->each, s->count, &s->room, sizeof *each);
    if (!each) return 0;
    s->each = each;
    s->each[s->count++] = (fix_shape){.begin = s->point_count, .mesh = mesh};
    return 1;
}

static int add_shape_point(fix_shapes *s, const double p[3]) {
    double(*points)[3] =
        norma_check_grow(s->points, s->point_count, &s->point_room, sizeof *points);
    if (!points) return 0;
    s->points = points;
    memcpy(s->points[s->point_count++], p, sizeof *points);
    ++s->each[s->count - 1].count;
    return 1;
}

static int compare_keys(const void *a, const void *b) {
    const fix_key *x = a, *y = b;
    return (x->key > y->key) - (x->key < y->key);
}

static int sort_shapes(fix_shapes *s) {
    s->keys = malloc((s->point_count + 1) * sizeof *s->keys);
    for (size_t i = 0; s->keys && i < s->count; ++i)
        for (size_t k = s->each[i].begin; k < s->each[i].begin + s->each[i].count; ++k)
            s->keys[k] = (fix_key){shape_key(s->points[k]), i};
    if (s->keys) qsort(s->keys, s->point_count, sizeof *s->keys, compare_keys);
    return s->keys != NULL;
}

static void free_shapes(fix_shapes *s) {
    free(s->each);
    free(s->points);
    free(s->keys);
}

static int has_point(const fix_shapes *s, const fix_shape *shape, const double p[3], double near) {
    for (size_t k = shape->begin; k < shape->begin + shape->count; ++k) {
        const double *q = s->points[k];
        if (fabs(p[0] - q[0]) <= near && fabs(p[1] - q[1]) <= near && fabs(p[2] - q[2]) <= near)
            return 1;
    }
    return 0;
}

/* The first key that is not below. */
static size_t find_key(const fix_shapes *s, double key) {
    size_t begin = 0, end = s->point_count;
    while (begin < end) {
        const size_t middle = begin + (end - begin) / 2;
        if (s->keys[middle].key < key)
            begin = middle + 1;
        else
            end = middle;
    }
    return begin;
}

/* Whether one of those before has all its points: looked for at the one where the fewest are. */
static int was_there(
    const fix_shapes *before, const fix_shapes *after, const fix_shape *shape, double near) {
    size_t begin = 0, end = SIZE_MAX;
    for (size_t k = shape->begin; k < shape->begin + shape->count; ++k) {
        const double key = shape_key(after->points[k]), reach = 2 * near;
        const size_t from = find_key(before, key - reach), to = find_key(before, key + reach);
        if (to - from < end - begin) begin = from, end = to;
    }
    for (size_t i = begin; i < end; ++i) {
        const fix_shape *was = &before->each[before->keys[i].shape];
        size_t found = 0;
        while (was->mesh == shape->mesh && found < shape->count &&
               has_point(before, was, after->points[shape->begin + found], near))
            ++found;
        if (found == shape->count) return 1;
    }
    return 0;
}

static int has_new_shape(const fix_shapes *before, const fix_shapes *after, double near) {
    if (before->is_cut || after->is_cut) return 0;
    for (size_t i = 0; i < after->count; ++i)
        if (!was_there(before, after, &after->each[i], near)) return 1;
    return 0;
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
    for (size_t i = 0; i < count; ++i) out += runs[i].out != 0;
    counts[block].loose += 2 * out != count;
    counts[block].surplus += count > 2 ? count - 2 : 0;
}

/* Once for each face at it. */
static int add_crowded(const core_topology *t, size_t group, fix_shapes *edges) {
    for (size_t face = 0; face < t->mesh.face_count; ++face) {
        const size_t begin = norma_core_face_begin(&t->mesh, face),
                     end = norma_core_face_end(&t->mesh, face);
        for (size_t c = begin; c < end; ++c) {
            double a[3], b[3];
            if (t->partners[c] != CORE_EDGE_MANY) continue;
            edges->is_cut |= edges->count >= MOST_SHAPES;
            if (edges->is_cut) return 1;
            norma_view_read(&t->mesh.positions, norma_core_corner(&t->mesh, c), a);
            norma_view_read(
                &t->mesh.positions, norma_core_corner(&t->mesh, c + 1 < end ? c + 1 : begin), b);
            if (!begin_shape(edges, group) || !add_shape_point(edges, a) ||
                !add_shape_point(edges, b))
                return 0;
        }
    }
    return 1;
}

static norma_result count_odd_edges(
    const norma_mesh *mesh, size_t group, uint32_t threads, fix_measure *measure) {
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
    for (size_t i = 0; counts && i < blocks; ++i) {
        measure->loose += counts[i].loose;
        measure->surplus += counts[i].surplus;
    }
    free(counts);
    if (!result && !add_crowded(&topology, group, &measure->crowded)) result = NORMA_ERROR_MEMORY;
    norma_core_topology_close(&topology);
    return result;
}

static norma_result measure_group(const fix_maker *m, fix_measure *measure) {
    check_joined joined;
    core_mesh shape;
    norma_result result = norma_check_join(m->meshes, m->count, &joined);
    if (result) return result;
    result = count_odd_edges(&joined.mesh, m->indices[0], m->request->options.threads, measure);
    if (!result) result = norma_core_mesh_shape(&joined.mesh, &shape);
    shape.scale = 1;
    if (!result) measure->size = fmax(measure->size, norma_check_diagonal(&shape));
    norma_check_unjoin(&joined);
    return result;
}

/* ---- normals on the other side */

static int is_opposed(const fix_mesh *m, size_t face, const core_face *geometry, double across) {
    const size_t begin = norma_core_face_begin(&m->mesh, face),
                 end = norma_core_face_end(&m->mesh, face);
    int opposed = end > begin;
    for (size_t c = begin; c < end && opposed; ++c) {
        double n[3];
        const size_t number = norma_fix_normal_of(m, face, c);
        if (number == SIZE_MAX) return 0;
        norma_view_read(&m->data.normals, number, n);
        opposed = norma_core_dot(geometry->normal, n) < -across * norma_core_length(n);
    }
    return opposed;
}

static int is_sliver(const core_mesh *mesh, size_t face, const core_face *geometry) {
    const size_t begin = norma_core_face_begin(mesh, face), end = norma_core_face_end(mesh, face);
    double longest = 0, a[3], b[3];
    for (size_t c = begin; c < end; ++c) {
        norma_core_position(mesh, norma_core_corner(mesh, c), a);
        norma_core_position(mesh, norma_core_corner(mesh, c + 1 < end ? c + 1 : begin), b);
        const double d[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
        longest = fmax(longest, norma_core_dot(d, d));
    }
    return geometry->twice_area < 1e-4 * longest;
}

static int add_behind(const core_mesh *mesh, size_t face, size_t index, fix_shapes *faces) {
    faces->is_cut |= faces->count >= MOST_SHAPES;
    if (faces->is_cut) return 1;
    int fine = begin_shape(faces, index);
    for (size_t c = norma_core_face_begin(mesh, face); c < norma_core_face_end(mesh, face); ++c) {
        double p[3];
        norma_core_position(mesh, norma_core_corner(mesh, c), p);
        fine = fine && add_shape_point(faces, p);
    }
    return fine;
}

/* Whatever else is wrong with them: rules are silent where others hold. */
static norma_document_result measure_normals(
    const fix_maker *maker, size_t number, fix_measure *measure) {
    const size_t index = maker->indices[number];
    fix_mesh m = {.document = maker->document, .mesh = maker->meshes[number]};
    norma_document_result result = norma_document_mesh_info(m.document, index, &m.info);
    if (!result) result = norma_document_mesh_data(m.document, index, &m.data, maker->error);
    if (result) return result;
    const double across = fmax(1e-6, norma_check_encoding_bound(m.info.encoding));
    for (size_t face = 0; face < m.mesh.face_count; ++face) {
        core_face geometry;
        norma_core_face_geometry(&m.mesh, face, &geometry);
        if (!(geometry.flags & CORE_FACE_FINITE)) continue;
        measure->area += geometry.twice_area;
        if (!(geometry.flags & CORE_FACE_DIRECTED) || !is_opposed(&m, face, &geometry, across))
            continue;
        measure->opposed += geometry.twice_area;
        if (!is_sliver(&m.mesh, face, &geometry) &&
            !add_behind(&m.mesh, face, index, &measure->behind))
            result = norma_fix_fail(maker->error, NORMA_ERROR_MEMORY);
    }
    return result;
}

norma_document_result norma_fix_measure_shape(norma_document *document, const fix_request *request,
    fix_measure *measure, norma_document_error *error) {
    fix_maker m = {.document = document, .request = request, .error = error};
    norma_document_result result = NORMA_DOCUMENT_OK;
    while (m.next < norma_document_mesh_count(document) && !result) {
        result = norma_fix_next_group(&m);
        if (!result && m.face_count) result = norma_fix_fail(error, measure_group(&m, measure));
        for (size_t i = 0; i < m.count && !result; ++i) result = measure_normals(&m, i, measure);
    }
    norma_fix_close_groups(&m);
    if (!result && !(sort_shapes(&measure->crowded) && sort_shapes(&measure->behind)))
        result = norma_fix_fail(error, NORMA_ERROR_MEMORY);
    measure->has_shape = 1;
    return result;
}

/* ---- better or worse */

/* What never is more than an information, and no fix is for, is not asked: it takes long to find
 * out how normals and tangents were made. */
int norma_fix_is_weighed(const fix_request *request, check_rule rule) {
    const norma_rule *r = &norma_rules(NULL)[rule];
    return r->fix != NORMA_FIX_NONE || r->render > NORMA_SEVERITY_INFO ||
           r->print > NORMA_SEVERITY_INFO || (rule == RULE_N304 && request->by_rays);
}

norma_document_result norma_fix_find(norma_document *document, const fix_request *request, int maps,
    const check_known *known, norma_findings **findings, norma_document_error *error) {
    norma_check_options options = request->options;
    uint8_t rules[CHECK_RULE_COUNT];
    for (size_t rule = 0; rule < CHECK_RULE_COUNT; ++rule)
        rules[rule] = (uint8_t)norma_fix_is_weighed(request, (check_rule)rule);
    rules[RULE_N811] = rules[RULE_N812] = (uint8_t)(maps != 0);
    options.rules = rules;
    return norma_check_again(document, known, &options, findings, error);
}

void norma_fix_measure_free(fix_measure *measure) {
    norma_findings_free(measure->findings);
    free_shapes(&measure->crowded);
    free_shapes(&measure->behind);
    *measure = (fix_measure){0};
}

typedef struct verdict { /* of each rule: elements at warning or above, and the gravest severity */
    size_t counts[CHECK_RULE_COUNT];
    norma_severity gravest[CHECK_RULE_COUNT];
} verdict;

static verdict weigh_findings(const norma_findings *findings) {
    verdict sum = {0};
    size_t count;
    for (size_t i = 0; i < norma_findings_count(findings); ++i) {
        const norma_finding *finding = norma_findings_get(findings, i);
        const size_t rule = (size_t)(finding->rule - norma_rules(&count));
        if (finding->severity < NORMA_SEVERITY_WARNING) continue;
        sum.counts[rule] += finding->count;
        if (finding->severity > sum.gravest[rule]) sum.gravest[rule] = finding->severity;
    }
    return sum;
}

static int is_found_at(const norma_findings *findings, check_rule rule, const char *where) {
    for (size_t i = 0; i < norma_findings_count(findings); ++i) {
        const norma_finding *finding = norma_findings_get(findings, i);
        if (norma_fix_is_rule(finding, rule) && strcmp(finding->where, where) == 0) return 1;
    }
    return 0;
}

/* Whether one part of a map is right now, and another wrong. */
static int changes_place(const fix_measure *before, const fix_measure *after, check_rule rule) {
    for (size_t i = 0; i < norma_findings_count(after->findings); ++i) {
        const norma_finding *finding = norma_findings_get(after->findings, i);
        if (norma_fix_is_rule(finding, rule) &&
            !is_found_at(before->findings, rule, finding->where))
            return 1;
    }
    return 0;
}

const char *norma_fix_worse_shape(const fix_measure *before, const fix_measure *after) {
    const double whole = fmax(before->area, after->area), near = SHAPE_NEAR * before->size;
    const int compares = !after->is_elsewhere;
    if (after->loose > before->loose) return "closed edges would become open";
    if (after->surplus > before->surplus ||
        (compares && has_new_shape(&before->crowded, &after->crowded, near)))
        return "an edge would get a third face";
    if (after->opposed > before->opposed + 1e-9 * whole ||
        (compares && has_new_shape(&before->behind, &after->behind, near)))
        return "a face would have its normals on the other side";
    return NULL;
}

int norma_fix_find_worse(const fix_measure *before, const fix_measure *after, uint8_t *worse) {
    const verdict was = weigh_findings(before->findings), is = weigh_findings(after->findings);
    int any = norma_fix_worse_shape(before, after) != NULL;
    for (size_t i = 0; i < CHECK_RULE_COUNT; ++i)
        worse[i] = is.counts[i] > was.counts[i] || is.gravest[i] > was.gravest[i];
    worse[RULE_N812] |= (uint8_t)changes_place(before, after, RULE_N812);
    for (size_t i = 0; i < CHECK_RULE_COUNT; ++i) any |= worse[i];
    return any;
}

/* ---- a trial */

/* What is to be done next is planned by the same look. */
static norma_document_result look_at_copy(norma_document *copy, const fix_request *request,
    const check_known *known, fix_trial *trial, norma_document_error *error) {
    norma_findings_free(trial->after.findings);
    trial->after.findings = NULL;
    return norma_fix_find(
        copy, request, request->changes_maps, known, &trial->after.findings, error);
}

static norma_document_result take_steps(norma_document *copy, const fix_request *request,
    const check_known *known, fix_trial *trial, norma_document_error *error) {
    fix_request next = *request;
    next.judges = NULL;

    norma_document_result result = NORMA_DOCUMENT_OK;
    int changed = 1;
    while (!result && changed && trial->count <= FIX_MOST_STEPS) {
        fix_plan *plan = &trial->plans[trial->count - 1];
        changed = 0;
        if (norma_fix_plan_is_empty(plan)) break;
        result = norma_fix_apply(copy, plan, request->options.threads, &changed, error);
        if (!result) result = look_at_copy(copy, request, known, trial, error);
        if (result || !changed || trial->count == FIX_MOST_STEPS) break;
        /* What rays said they would say again, but where something was moved since. */
        next.by_rays = request->by_rays && plan_moves(plan);
        /* What one turn of a map does not make right, another would only undo. */
        next.left_out[RULE_N812] |= plan->greens != NULL;
        result = norma_fix_make_plan(
            copy, &next, trial->after.findings, &trial->plans[trial->count], error);
        trial->count += !result;
    }
    return result;
}

norma_document_result norma_fix_try(const check_known *known, const fix_request *request,
    fix_plan *first, fix_trial *trial, norma_document_error *error) {
    norma_document *copy = NULL;
    *trial = (fix_trial){.plans = {*first}, .count = 1};
    *first = (fix_plan){0};
    norma_document_result result = norma_document_copy(known->document, &copy, error);
    const size_t notes = norma_document_note_count(copy);
    if (!result) result = take_steps(copy, request, known, trial, error);
    for (size_t i = 0; i < trial->count; ++i)
        trial->after.is_elsewhere |= trial->plans[i].recentred || trial->plans[i].bakes;
    if (!result) result = norma_fix_measure_shape(copy, request, &trial->after, error);
    if (!result && norma_document_note_count(copy) > notes)
        norma_check_message(trial->said, "%s", norma_document_note(copy, notes));
    norma_document_close(copy);
    return result;
}

void norma_fix_trial_free(fix_trial *trial) {
    for (size_t i = 0; i < trial->count; ++i) norma_fix_plan_free(&trial->plans[i]);
    norma_fix_measure_free(&trial->after);
    *trial = (fix_trial){0};
}
