/* fix_mesh.c: what fixes share: one mesh while it is being fixed, the primitives of a glTF mesh
 * together, and the edges of either. */
#include "check/fix/fix.h"
#include "check/explain/explain.h"
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

int norma_fix_mark_group(const fix_maker *m, check_rule rule, uint8_t *marks) {
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
