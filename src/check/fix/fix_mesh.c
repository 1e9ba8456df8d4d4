/* What fixes share: one mesh while it is being fixed, the primitives of a glTF mesh together, and
 * the edges of either. Then where normals and winding disagree (N201, N205), or neighbours do
 * (N301), which of both is wrong, and what is turned. norma_fix_ask_sides judges the faces: those
 * are turned that are shown to be, by the volume of what is closed and by rays from what is open.
 * Rays say nothing of a material that is seen from both sides. norma_fix_windings then reverses
 * faces, and norma_fix_turn_normals normals that most of their faces still oppose. Where nothing is
 * decided nothing is turned, and a note says so; hence norma_fix_may lets these rules in although
 * they may have no fix, and why_idle (fix.c) and norma_fix_worse_shape (fix_plan.c) speak of them.
 */
#include "check/explain/explain.h"
#include "check/fix/fix.h"
#include "check/rules/rules.h"
#include <stdlib.h>
#include <string.h>

/* ---- edges */

int norma_fix_compare_points(const double a[3], const double b[3]) {
    for (int axis = 0; axis < 3; ++axis)
        if (a[axis] != b[axis]) return a[axis] < b[axis] ? -1 : 1;
    return 0;
}

int norma_fix_compare_edges(const void *a, const void *b) {
    const fix_edge *one = a, *other = b;
    int order = norma_fix_compare_points(one->a, other->a);
    order = order ? order : norma_fix_compare_points(one->b, other->b);
    return order ? order : one->mesh != other->mesh ? (one->mesh < other->mesh ? -1 : 1) : 0;
}

size_t norma_fix_face_edges(const core_mesh *mesh, size_t face, uint32_t face_number,
    uint32_t mesh_number, fix_edge *edges) {
    const size_t begin = norma_core_face_begin(mesh, face), end = norma_core_face_end(mesh, face);
    size_t count = 0;
    for (size_t c = begin; c < end; ++c) {
        double from[3], to[3];
        norma_core_position(mesh, norma_core_corner(mesh, c), from);
        norma_core_position(mesh, norma_core_corner(mesh, c + 1 < end ? c + 1 : begin), to);
        const int order = norma_fix_compare_points(from, to);
        if (!norma_core_finite(from) || !norma_core_finite(to) || order == 0) continue;
        fix_edge *edge = &edges[count++];
        memcpy(edge->a, order < 0 ? from : to, sizeof from);
        memcpy(edge->b, order < 0 ? to : from, sizeof to);
        edge->face = face_number;
        edge->mesh = mesh_number;
        edge->way = order < 0;
    }
    return count;
}

/* ---- The primitives of a glTF mesh, or the one mesh of another file, side by side. */

static norma_document_result add_mesh_to_group(fix_maker *m, const norma_mesh_info *info) {
    norma_mesh_data data;
    core_mesh *mesh = &m->meshes[m->count];
    norma_document_result result = norma_document_mesh_data(m->document, m->next, &data, m->error);
    if (!result) result = norma_fix_fail(m->error, norma_core_mesh_shape(&data.mesh, mesh));
    if (result) return result;
    if (!m->count) {
        m->first_info = *info;
        m->first_data = data;
    }
    mesh->scale = 1;
    m->face_count += mesh->face_count;
    m->wheres[m->count] = info->where;
    m->indices[m->count++] = m->next;
    return result;
}

norma_document_result norma_fix_next_group(fix_maker *m) {
    const size_t all = norma_document_mesh_count(m->document), first = m->next;
    norma_document_result result = NORMA_DOCUMENT_OK;
    norma_mesh_info info;
    if (!m->meshes) {
        m->meshes = calloc(all + 1, sizeof *m->meshes);
        m->indices = calloc(all + 1, sizeof *m->indices);
        m->wheres = calloc(all + 1, sizeof *m->wheres);
    }
    if (!m->meshes || !m->indices || !m->wheres)
        return norma_fix_fail(m->error, NORMA_ERROR_MEMORY);
    m->count = m->face_count = 0;
    for (size_t mesh = 0; m->next < all && !result; ++m->next) {
        if (norma_document_mesh_info(m->document, m->next, &info) ||
            (m->next > first && info.mesh != mesh))
            break;
        mesh = info.mesh;
        if (!info.not_read) result = add_mesh_to_group(m, &info);
    }
    m->next += m->next == first;
    return result;
}

void norma_fix_close_groups(fix_maker *m) {
    free(m->meshes);
    free(m->indices);
    free((void *)m->wheres);
}

/* ---- One mesh while it is being fixed: the elements that its findings name, its corners
 * and normals as they will be once the edit is made. */

/* ---- which findings, which elements */

static int compare_left_out(const void *a, const void *b) {
    const fix_left_out *p = a, *q = b;
    return p->rule != q->rule ? (p->rule > q->rule ? 1 : -1) : strcmp(p->where, q->where);
}

size_t norma_fix_sort_left_out(fix_left_out *places, size_t count) {
    size_t kept = 0;
    if (count) qsort(places, count, sizeof *places, compare_left_out);
    for (size_t i = 0; i < count; ++i)
        if (kept && compare_left_out(&places[kept - 1], &places[i]) == 0)
            free(places[i].where);
        else
            places[kept++] = places[i];
    return kept;
}

static int is_finding_left_out(
    const fix_request *request, const norma_finding *finding, check_rule rule) {
    const fix_left_out key = {rule, (char *)(uintptr_t)finding->where};
    return request->left_out[rule] ||
           (request->place_count && bsearch(&key, request->places, request->place_count, sizeof key,
                                        compare_left_out) != NULL);
}

int norma_fix_may(const void *context, const norma_finding *finding) {
    const fix_request *request = context;
    size_t count;
    const check_rule rule = (check_rule)(finding->rule - norma_rules(&count));
    /* Of N201 and N301 it is told why nothing is changed where nothing is shown to be wrong. */
    const int by_rays = request->unsafe && rule == RULE_N304 && request->by_rays,
              turns = rule == RULE_N201 || rule == RULE_N301,
              unsafe = request->unsafe && finding->severity >= request->from &&
                       (finding->fix == NORMA_FIX_UNSAFE || turns);
    return request->wanted[rule] && (by_rays || unsafe || finding->fix == NORMA_FIX_SAFE) &&
           !is_finding_left_out(request, finding, rule);
}

int norma_fix_is_rule(const norma_finding *finding, check_rule rule) {
    size_t count;
    return finding->rule == norma_rules(&count) + rule;
}

int norma_fix_has(const fix_mesh *m, check_rule rule) {
    for (size_t i = 0; i < m->finding_count; ++i)
        if (norma_fix_is_rule(m->findings[i], rule)) return 1;
    return 0;
}

int norma_fix_mark(
    const fix_mesh *m, check_rule rule, fix_element element, size_t count, uint8_t **marks) {
    int any = 0;
    for (size_t i = 0; i < m->finding_count; ++i) {
        const norma_finding *finding = m->findings[i];
        if (!norma_fix_is_rule(finding, rule)) continue;
        if (!*marks && !(*marks = calloc(count + 1, 1))) return -1;
        for (size_t k = 0; k < finding->sample_count; ++k) {
            const norma_sample *sample = &finding->samples[k];
            size_t number = element == MEND_VERTEX ? sample->vertex
                            : element == MEND_FACE ? sample->face
                                                   : sample->normal;
            if (number < count) (*marks)[number] = 1, any = 1;
        }
    }
    return any;
}

void norma_fix_note(fix_plan *plan, uint64_t rules, const char *text, const char *why) {
    fix_note *notes = realloc(plan->notes, (plan->note_count + 1) * sizeof *notes);
    const size_t size = strlen(text) + 1;
    char *copy = notes ? malloc(size) : NULL;
    if (notes) plan->notes = notes;
    if (copy) notes[plan->note_count++] = (fix_note){memcpy(copy, text, size), why, rules};
}

/* Marks the faces of the group that the findings of a rule name, those that may be fixed; 1: there
 * are any. */
static int mark_faces_of_group(const fix_maker *m, check_rule rule, uint8_t *marks) {
    size_t begin = 0, count;
    int any = 0;
    for (size_t i = 0; i < m->count; begin += m->meshes[i++].face_count) {
        const norma_finding **found = norma_places_find(&m->mended, m->wheres[i], &count);
        for (size_t k = 0; k < count; ++k)
            for (size_t s = 0; s < found[k]->sample_count && norma_fix_is_rule(found[k], rule); ++s)
                if (found[k]->samples[s].face < m->meshes[i].face_count)
                    marks[begin + found[k]->samples[s].face] = 1, any = 1;
    }
    return any;
}

/* ---- a mesh as it will be */

static norma_result fix_corners(fix_mesh *m) {
    if (m->corners) return NORMA_OK;
    const core_mesh *mesh = &m->mesh;
    m->corners = malloc((mesh->corner_count + 1) * sizeof *m->corners);
    if (!m->corners) return NORMA_ERROR_MEMORY;
    for (size_t face = 0; face < mesh->face_count; ++face) {
        size_t begin = norma_core_face_begin(mesh, face), end = norma_core_face_end(mesh, face);
        int reversed = m->edit->reverse_faces && m->edit->reverse_faces[face];
        for (size_t c = begin; c < end; ++c)
            m->corners[c] = norma_core_corner(mesh, reversed && c > begin ? end + begin - c : c);
    }
    return NORMA_OK;
}

norma_mesh norma_fix_mesh_now(const fix_mesh *m) {
    norma_mesh now = m->data.mesh;
    now.corners = m->corners;
    now.corner_size = 4;
    now.hard_edges = NULL; /* they may have turned with the faces */
    return now;
}

norma_result norma_fix_face_normals(fix_mesh *m) {
    norma_result result = fix_corners(m);
    if (result || m->face_normals) return result;
    const norma_mesh now = norma_fix_mesh_now(m);
    const norma_options options = {.struct_size = sizeof options, .threads = m->threads};
    m->face_normals = malloc((m->mesh.face_count + 1) * 3 * sizeof *m->face_normals);
    return m->face_normals
               ? norma_face_normals(&now, &options, m->face_normals, m->mesh.face_count, NULL)
               : NORMA_ERROR_MEMORY;
}

/* Normals of another frame show a weight and crease once they are turned. */
static norma_result find_turned_deviation(fix_mesh *m, const norma_options *options) {
    core_call call;
    explain_frame frame;
    norma_result result = norma_core_begin(&call, options);
    if (!result) result = norma_explain_find_frame(&call, &m->data, &m->mesh, NULL, &frame);
    if (result) return result;
    m->deviation = (norma_deviation){.corners = frame.kind != EXPLAIN_FRAME_NONE};
    norma_explain_tell(&frame.trial, &m->deviation);
    return NORMA_OK;
}

/* The weight and crease that the stored normals show; the defaults of computing where they show
 * none. */
static norma_result find_deviation(fix_mesh *m) {
    const norma_options options = {.struct_size = sizeof options, .threads = m->threads};
    norma_result result = NORMA_OK;
    if (m->knows_deviation) return result;
    if (norma_fix_has(m, RULE_N206))
        result = find_turned_deviation(m, &options);
    else if (m->known)
        m->deviation = *m->known;
    else
        result = norma_explain_normals(&m->data, m->info.normals, &options, &m->deviation);
    if (result) return result;
    m->knows_deviation = 1;
    if (m->deviation.corners == 0) {
        m->deviation.weight = NORMA_WEIGHT_ANGLE;
        m->deviation.shading = norma_document_format(m->document) == NORMA_FILE_PLY
                                   ? NORMA_SHADING_SMOOTH
                                   : NORMA_SHADING_CREASE;
        m->deviation.crease_angle_rad = 1.0471975511965976; /* 60 degrees */
    }
    return NORMA_OK;
}

norma_result norma_fix_surface(fix_mesh *m) {
    norma_result result = m->surface ? NORMA_OK : fix_corners(m);
    if (result || m->surface) return result;
    result = find_deviation(m);
    if (result) return result;
    const norma_deviation *d = &m->deviation;
    const int smooth = d->shading == NORMA_SHADING_SMOOTH;
    const float crease = d->shading == NORMA_SHADING_FLAT ? -1.0f
                         : smooth                         ? (float)NORMA_PI
                                                          : (float)d->crease_angle_rad;
    const norma_options options = {.struct_size = sizeof options,
        .weight = d->weight,
        .non_manifold = smooth ? NORMA_NON_MANIFOLD_SMOOTH : NORMA_NON_MANIFOLD_HARD,
        .fallback = NORMA_FALLBACK_NEAREST,
        .threads = m->threads};
    const norma_mesh now = norma_fix_mesh_now(m);
    m->surface = malloc((m->mesh.corner_count + 1) * 3 * sizeof *m->surface);
    return m->surface ? norma_corner_normals(
                            &now, crease, &options, m->surface, m->mesh.corner_count, NULL)
                      : NORMA_ERROR_MEMORY;
}

/* ---- normals as they will be */

size_t norma_fix_normal_count(const fix_mesh *m) {
    return m->info.normals == NORMA_NORMALS_NONE ? 0 : m->data.normals.count;
}

/* corner: as it was read, not as it will be. */
size_t norma_fix_normal_of(const fix_mesh *m, size_t face, size_t corner) {
    size_t number = m->data.corner_normals ? m->data.corner_normals[corner]
                    : m->info.normals == NORMA_NORMALS_PER_FACET
                        ? face
                        : norma_core_corner(&m->mesh, corner);
    return number < norma_fix_normal_count(m) ? number : SIZE_MAX;
}

void norma_fix_normal(const fix_mesh *m, size_t number, double normal[3]) {
    if (!m->edit->set_normals || !m->edit->set_normals[number]) {
        norma_view_read(&m->data.normals, number, normal);
        return;
    }
    for (int axis = 0; axis < 3; ++axis)
        normal[axis] = (double)m->edit->normals[3 * number + (size_t)axis];
}

/* Half of the step between two codes; floats and texts: what rounding and nine digits make of a
 * number. */
static double half_step(const char *encoding) {
    static const struct {
        const char *name;
        double steps;
    } codes[] = {{"snorm8", 127}, {"int8", 127}, {"snorm10", 511}, {"snorm16", 32767},
        {"int16", 32767}, {"float16", 2048}};
    for (size_t i = 0; i < sizeof codes / sizeof *codes; ++i)
        if (strcmp(encoding, codes[i].name) == 0) return .5 / codes[i].steps;
    return 1e-7;
}

/* Whether it would be stored as what is there: then it is no change, and others need not wait for
 * it. */
static int is_stored(const fix_mesh *m, size_t number, const double unit[3]) {
    double stored[3];
    const double near = half_step(m->info.encoding);
    norma_view_read(&m->data.normals, number, stored);
    return fabs(unit[0] - stored[0]) < near && fabs(unit[1] - stored[1]) < near &&
           fabs(unit[2] - stored[2]) < near;
}

int norma_fix_set_normal(fix_mesh *m, size_t number, const double normal[3]) {
    size_t count = norma_fix_normal_count(m);
    double length = sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
    if (!(length > 0) || !isfinite(length)) return 1;
    const double unit[3] = {normal[0] / length, normal[1] / length, normal[2] / length};
    if (!(m->edit->set_normals && m->edit->set_normals[number]) && is_stored(m, number, unit))
        return 1;
    if (!m->edit->set_normals) {
        m->edit->set_normals = calloc(count + 1, 1);
        m->edit->normals = calloc(3 * count + 1, sizeof(float));
    }
    if (!m->edit->set_normals || !m->edit->normals) return 0;
    ((uint8_t *)(uintptr_t)m->edit->set_normals)[number] = 1;
    float *to = (float *)(uintptr_t)m->edit->normals + 3 * number;
    for (int axis = 0; axis < 3; ++axis) to[axis] = (float)unit[axis] + 0.0f;
    return 1;
}

int norma_fix_has_edit(const norma_mesh_edit *edit) {
    return edit->reverse_faces || edit->drop_faces || edit->cut_faces || edit->set_normals ||
           edit->set_positions || edit->set_tangents || edit->strip_normals ||
           edit->source_vertices;
}

/* ---- which side is wrong */

static norma_result open_fix_judge(const fix_maker *m) {
    if (m->judge->is_open) return NORMA_OK;
    return norma_check_open_judge(m->meshes, m->count, m->request->options.threads, m->judge);
}

/* ---- whole bodies: those that look inward (N302), with what lies right inside them, if all of it
 * looks outward: then every shell has the wrong sign; and, where that is asked for, open ones
 * (N304) as a majority of rays has it */

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

static norma_result turn_shells(const core_topology *topology, core_components *c, uint8_t *marks) {
    static const uint8_t not_closed = COMPONENT_OPEN | COMPONENT_CONFLICT | COMPONENT_UNBALANCED;
    uint8_t *keeps = calloc(c->count + 1, 1);
    norma_result result =
        keeps ? norma_core_measure_components(topology, c, not_closed) : NORMA_ERROR_MEMORY;
    if (!result) result = norma_core_judge_nesting(topology, c, not_closed);
    if (!result) mark_shells(c, marks, keeps);
    free(keeps);
    return result;
}

static void add_votes(fix_plan *plan, const norma_orient_report *report) {
    if (plan->by_rays == 0 || report->least_confidence < plan->least_confidence)
        plan->least_confidence = report->least_confidence;
    plan->by_rays += report->by_rays;
    plan->undecided += report->undecided;
}

/* What rays turn is what differs from winding alike alone. marks: in, the faces that are open; out,
 * those of them to be reversed. */
static norma_result ask_rays(const fix_maker *m, uint8_t *marks) {
    const norma_options options = {
        .struct_size = sizeof options, .threads = m->request->options.threads};
    const norma_mesh *whole = &m->judge->whole.mesh;
    norma_orient_report report;
    uint8_t *alike = malloc(m->face_count + 1), *rays = malloc(m->face_count + 1);
    norma_result result = alike && rays ? NORMA_OK : NORMA_ERROR_MEMORY;
    if (!result)
        result = norma_orient(whole, NORMA_ORIENT_OPEN_KEPT, &options, alike, m->face_count, NULL);
    if (!result)
        result =
            norma_orient(whole, NORMA_ORIENT_OPEN_BY_RAYS, &options, rays, m->face_count, &report);
    for (size_t f = 0; f < m->face_count && !result; ++f)
        marks[f] = marks[f] && alike[f] != rays[f];
    if (!result && report.open) add_votes(m->plan, &report);
    free(alike);
    free(rays);
    return result;
}

/* Of each mesh marks of its own, where there are any. */
static norma_result share_turned(const fix_maker *m, const uint8_t *inward, const uint8_t *open) {
    size_t begin = 0;
    for (size_t i = 0; i < m->count; begin += m->meshes[i++].face_count) {
        uint8_t *marks = malloc(m->meshes[i].face_count + 1);
        int any = 0;
        if (!marks) return NORMA_ERROR_MEMORY;
        for (size_t f = 0; f < m->meshes[i].face_count; ++f)
            any |= marks[f] = inward[begin + f] ^ open[begin + f];
        if (any)
            m->shared[m->indices[i]].turned = marks;
        else
            free(marks);
    }
    return NORMA_OK;
}

/* What is closed in its own primitive is a body by itself, whatever touches it: it is not turned
 * with what is open, unless it is named. marks, named: of this primitive's faces. */
static norma_result leave_closed(
    const fix_maker *m, size_t number, const uint8_t *named, uint8_t *marks) {
    const core_topology_visitor nobody = {NULL, NULL, NULL, NULL};
    core_call call = *m->judge->sides.topology.call;
    core_topology topology;
    core_components c;
    core_mesh mesh = m->meshes[number];
    norma_result result = norma_core_mesh_content(&call, &mesh);
    mesh.scale = 1;
    if (!result) result = norma_core_topology_open(&call, &mesh, &topology);
    if (result) return result;
    result = norma_core_pair_edges(&topology, &nobody);
    if (!result) result = norma_core_find_components(&topology, CORE_JOIN_BODIES, &c);
    for (size_t i = 0; !result && i < c.count; ++i) {
        int stays = c.each[i].flags == 0;
        for (size_t k = c.starts[i]; k < c.starts[i + 1] && stays; ++k) stays = !named[c.faces[k]];
        for (size_t k = c.starts[i]; k < c.starts[i + 1] && stays; ++k) marks[c.faces[k]] = 0;
    }
    if (!result) norma_core_release_components(&call, &c);
    norma_core_topology_close(&topology);
    return result;
}

/* Marks the bodies of which faces are marked. */
static norma_result mark_open_bodies(const fix_maker *m, const core_components *c, uint8_t *marks) {
    uint8_t *named = malloc(m->face_count + 1);
    norma_result result = named ? NORMA_OK : NORMA_ERROR_MEMORY;
    size_t begin = 0;
    if (named) memcpy(named, marks, m->face_count);
    if (named) mark_bodies(c, marks);
    for (size_t i = 0; m->count > 1 && i < m->count && !result; begin += m->meshes[i++].face_count)
        if (m->meshes[i].face_count) result = leave_closed(m, i, named + begin, marks + begin);
    free(named);
    return result;
}

static norma_result turn_bodies(const fix_maker *m, uint8_t *inward, uint8_t *open) {
    const int turns = mark_faces_of_group(m, RULE_N302, inward),
              asks = mark_faces_of_group(m, RULE_N304, open);
    const core_topology *topology = &m->judge->sides.topology;
    core_components c;
    norma_result result = turns || asks ? open_fix_judge(m) : NORMA_OK;
    if (result || !(turns || asks)) return result;
    result = norma_core_find_components(topology, CORE_JOIN_BODIES, &c);
    if (result) return result;
    mark_bodies(&c, inward);
    if (turns) result = turn_shells(topology, &c, inward);
    if (!result && asks) result = mark_open_bodies(m, &c, open);
    if (!result && asks) result = ask_rays(m, open);
    norma_core_release_components(topology->call, &c);
    return result ? result : share_turned(m, inward, open);
}

norma_result norma_fix_turn(fix_maker *m) {
    uint8_t *inward = calloc(m->face_count + 1, 1), *open = calloc(m->face_count + 1, 1);
    const norma_result result = inward && open ? turn_bodies(m, inward, open) : NORMA_ERROR_MEMORY;
    free(inward);
    free(open);
    return result;
}

/* ---- which faces are turned */

/* 1: its material is double-sided, or not opaque. */
static norma_document_result is_on_purpose(const fix_maker *m, size_t index, int *on_purpose) {
    norma_mesh_attributes attributes;
    norma_material_info material;
    *on_purpose = 0;
    norma_document_result result =
        norma_document_mesh_attributes(m->document, index, &attributes, m->error);
    if (result || attributes.material >= norma_document_material_count(m->document)) return result;
    result = norma_document_material_info(m->document, attributes.material, &material);
    *on_purpose = !result && (material.double_sided || material.not_opaque);
    return result;
}

static norma_document_result share_sides(const fix_maker *m, const uint8_t *sides) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (size_t i = 0; i < m->count && !result; sides += m->meshes[i++].face_count) {
        const size_t faces = m->meshes[i].face_count;
        int on_purpose;
        uint8_t *own = malloc(faces + 1);
        if (!own) return norma_fix_fail(m->error, NORMA_ERROR_MEMORY);
        memcpy(own, sides, faces);
        m->shared[m->indices[i]].sides = own;
        result = is_on_purpose(m, m->indices[i], &on_purpose);
        for (size_t f = 0; f < faces && !result && on_purpose; ++f)
            if (own[f] & CORE_SIDE_BY_RAYS) own[f] |= CORE_SIDE_UNDECIDED;
    }
    return result;
}

/* The faces whose sides matter: those that are named, those that are turned with a whole body, and
 * those at edges that two faces run along the same way. Rays are cast from the pieces of these
 * alone, as the rules do. */
static void mark_asked_faces(const fix_maker *m, uint8_t *asked) {
    (void)norma_check_count_conflicts(&m->judge->sides.topology, asked);
    (void)mark_faces_of_group(m, RULE_N201, asked);
    (void)mark_faces_of_group(m, RULE_N205, asked);
    size_t begin = 0;
    for (size_t i = 0; i < m->count; begin += m->meshes[i++].face_count) {
        const uint8_t *turned = m->shared[m->indices[i]].turned;
        for (size_t f = 0; turned && f < m->meshes[i].face_count; ++f)
            asked[begin + f] |= turned[f];
    }
}

/* Those of an STL by their stored normals, where nothing else decides. */
static norma_result ask_sides(const fix_maker *m, uint8_t *asked, uint8_t *sides) {
    norma_result result = open_fix_judge(m);
    if (result) return result;
    core_side_judge *judge = &m->judge->sides;
    norma_core_side_judge_forget(judge);
    mark_asked_faces(m, asked);
    result = norma_core_side_judge_ask(judge, 0, m->face_count, asked, sides);
    if (!result) result = norma_check_sides_at_folds(judge, 0, m->face_count, sides);
    return result || m->first_info.normals != NORMA_NORMALS_PER_FACET
               ? result
               : norma_check_sides_by_facets(judge, &m->first_data.normals, sides);
}

norma_document_result norma_fix_ask_sides(fix_maker *m) {
    uint8_t *asked = calloc(m->face_count + 1, 1), *sides = malloc(m->face_count + 1);
    norma_result asking = asked && sides ? NORMA_OK : NORMA_ERROR_MEMORY;
    if (!asking && m->face_count) asking = ask_sides(m, asked, sides);
    const norma_document_result result =
        asking ? norma_fix_fail(m->error, asking) : share_sides(m, sides);
    free(asked);
    free(sides);
    return result;
}

/* ---- parts of a surface: faces that edges join, by exactly equal positions */

/* For each face the least face of its part. NULL: out of memory. */
static uint32_t *find_parts(const core_mesh *mesh) {
    uint32_t *parents = malloc((mesh->face_count + 1) * sizeof *parents);
    fix_edge *edges = malloc((mesh->corner_count + 1) * sizeof *edges);
    if (!parents || !edges) {
        free(parents);
        free(edges);
        return NULL;
    }
    for (size_t face = 0; face < mesh->face_count; ++face) parents[face] = (uint32_t)face;
    size_t count = 0;
    for (size_t face = 0; face < mesh->face_count; ++face)
        count += norma_fix_face_edges(mesh, face, (uint32_t)face, 0, edges + count);
    qsort(edges, count, sizeof *edges, norma_fix_compare_edges);
    for (size_t i = 1; i < count; ++i)
        if (norma_fix_compare_edges(&edges[i - 1], &edges[i]) == 0)
            norma_core_join_sets(parents, edges[i - 1].face, edges[i].face);
    for (size_t face = 0; face < mesh->face_count; ++face)
        parents[face] = norma_core_set_of(parents, (uint32_t)face);
    free(edges);
    return parents;
}

/* ---- windings: which faces are reversed */

static void note_undecided(const fix_mesh *m, check_rule rule, size_t faces) {
    static const char why[] = "neither volume nor rays show which side is outward";
    char text[CHECK_MESSAGE];
    const norma_rule *rules = norma_rules(NULL);
    norma_check_message(text, "%s %s is not fixed%s%s for %z face%s: %s", rules[rule].id,
        rules[rule].name, *m->info.where ? " at " : "", m->info.where, faces,
        norma_check_plural(faces), why);
    norma_fix_note(m->plan, FIX_RULE(rule), text, why);
}

/* A part that is turned as a whole is not what N301 asks for, unless it names one of its faces:
 * then it is wound against another primitive. */
static void leave_whole_parts(const fix_mesh *m, const uint32_t *parts, uint8_t *reverse) {
    uint8_t *stays = calloc(m->mesh.face_count + 1, 1), *named = NULL;
    const int any = norma_fix_mark(m, RULE_N301, MEND_FACE, m->mesh.face_count, &named);
    for (size_t face = 0; stays && face < m->mesh.face_count; ++face)
        if (!reverse[face] || (any > 0 && named[face])) stays[parts[face]] = 1;
    for (size_t face = 0; stays && face < m->mesh.face_count; ++face)
        reverse[face] &= stays[parts[face]];
    free(named);
    free(stays);
}

/* Those that are shown to be turned: of parts that disagree with themselves (N301). */
static norma_result reverse_turned(const fix_mesh *m, uint8_t *reverse) {
    uint32_t *parts = find_parts(&m->mesh);
    size_t undecided = 0;
    if (!parts) return NORMA_ERROR_MEMORY;
    for (size_t face = 0; face < m->mesh.face_count; ++face) {
        reverse[face] = (uint8_t)norma_check_is_turned(m->shared.sides[face]);
        undecided +=
            m->shared.sides[face] & CORE_SIDE_TURNED && m->shared.sides[face] & CORE_SIDE_UNDECIDED;
    }
    leave_whole_parts(m, parts, reverse);
    free(parts);
    if (undecided) note_undecided(m, RULE_N301, undecided);
    return NORMA_OK;
}

/* The parts of faces whose winding is shown to be wrong, and whose normals are right (N201): all
 * that is turned in them, so that they still agree. */
static norma_result reverse_opposed(const fix_mesh *m, uint8_t *reverse) {
    uint8_t *named = NULL;
    const size_t faces = m->mesh.face_count;
    const int any = norma_fix_mark(m, RULE_N201, MEND_FACE, faces, &named);
    uint32_t *parts = any > 0 ? find_parts(&m->mesh) : NULL;
    uint8_t *opposed = any > 0 ? calloc(faces + 1, 1) : NULL;
    const int fine = any == 0 || (parts && opposed);
    size_t undecided = 0;
    for (size_t face = 0; face < faces && any > 0 && fine; ++face) {
        if (!named[face]) continue;
        undecided += (m->shared.sides[face] & CORE_SIDE_UNDECIDED) != 0;
        if (norma_check_is_turned(m->shared.sides[face])) opposed[parts[face]] = 1;
    }
    for (size_t face = 0; face < faces && any > 0 && fine; ++face)
        if (opposed[parts[face]] && norma_check_is_turned(m->shared.sides[face])) reverse[face] = 1;
    if (undecided && fine) note_undecided(m, RULE_N201, undecided);
    free(named);
    free(parts);
    free(opposed);
    return fine ? NORMA_OK : NORMA_ERROR_MEMORY;
}

/* A body that is turned as a whole (N302, N304) is turned once, whatever else names its faces. */
norma_result norma_fix_windings(fix_mesh *m) {
    const int alike = norma_fix_has(m, RULE_N301), opposed = norma_fix_has(m, RULE_N201);
    int any = 0;
    if (!alike && !opposed && !m->shared.turned) return NORMA_OK;
    uint8_t *reverse = calloc(m->mesh.face_count + 1, 1);
    norma_result result = reverse ? NORMA_OK : NORMA_ERROR_MEMORY;
    if (!result && alike && m->shared.sides) result = reverse_turned(m, reverse);
    if (!result && opposed && m->shared.sides) result = reverse_opposed(m, reverse);
    for (size_t face = 0; face < m->mesh.face_count && !result; ++face) {
        if (m->shared.turned && m->shared.turned[face])
            reverse[face] = !m->shared.sides || norma_check_is_turned(m->shared.sides[face]);
        any |= reverse[face];
    }
    if (any && !result)
        m->edit->reverse_faces = reverse;
    else
        free(reverse);
    return result;
}

/* ---- normals: after the windings have become what they will be, a normal that more of its faces
 * oppose than not is turned round, unless it is unknown which of both is wrong */

typedef struct side_count {
    uint32_t with, against;
    int candidate;
} side_count;

static void count_sides(const fix_mesh *m, const uint8_t *named, side_count *sides) {
    for (size_t face = 0; face < m->mesh.face_count; ++face) {
        const float *direction = m->face_normals + 3 * face;
        const int decided = m->shared.sides && !(m->shared.sides[face] & CORE_SIDE_UNDECIDED);
        int candidate = (named && named[face] && decided) ||
                        (m->edit->reverse_faces && m->edit->reverse_faces[face]);
        for (size_t c = norma_core_face_begin(&m->mesh, face);
             c < norma_core_face_end(&m->mesh, face); ++c) {
            double normal[3];
            size_t number = norma_fix_normal_of(m, face, c);
            if (number == SIZE_MAX) continue;
            norma_fix_normal(m, number, normal);
            double dot = norma_check_dot(direction, normal);
            sides[number].with += dot > 0;
            sides[number].against += dot < 0;
            sides[number].candidate |= candidate;
        }
    }
}

norma_result norma_fix_turn_normals(fix_mesh *m) {
    uint8_t *named = NULL;
    int any = norma_fix_mark(m, RULE_N201, MEND_FACE, m->mesh.face_count, &named);
    size_t count = norma_fix_normal_count(m);
    norma_result result = any < 0 ? NORMA_ERROR_MEMORY : NORMA_OK;
    if (!result && count && (any || m->edit->reverse_faces)) {
        side_count *sides = calloc(count + 1, sizeof *sides);
        result = sides ? norma_fix_face_normals(m) : NORMA_ERROR_MEMORY;
        if (!result) count_sides(m, named, sides);
        for (size_t i = 0; i < count && !result; ++i) {
            double normal[3];
            if (!sides[i].candidate || sides[i].against <= sides[i].with) continue;
            norma_fix_normal(m, i, normal);
            for (int axis = 0; axis < 3; ++axis) normal[axis] = -normal[axis];
            result = norma_fix_set_normal(m, i, normal) ? NORMA_OK : NORMA_ERROR_MEMORY;
        }
        free(sides);
    }
    free(named);
    return result;
}
