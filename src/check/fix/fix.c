/* fix.c: what the rules found and a program may put right, put right: every element that a finding
 * names, by an edit of its mesh; missing normals by computing them; transforms by baking them. All
 * changes to single elements come first; where a glTF takes no second change, the summary says that
 * there is more to do. */
#include "check/fix/fix.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct mender {
    norma_document *document;
    norma_check_options options;
    int unsafe;
    norma_findings *findings;
    norma_mesh_edit *edits;
    uint8_t **turned; /* of each mesh marks of faces, or NULL */
    float **smooth;   /* of each mesh normals at seams of several primitives, or NULL */
    size_t mesh_count;
    norma_fix_summary *summary;
    norma_document_error *error;
} mender;

static norma_document_result fail(const mender *m, norma_result result) {
    const norma_document_result as = result == NORMA_CANCELLED ? NORMA_DOCUMENT_CANCELLED
                                     : result == NORMA_ERROR_MEMORY
                                         ? NORMA_DOCUMENT_ERROR_MEMORY
                                         : NORMA_DOCUMENT_ERROR_MALFORMED;
    if (m->error) {
        m->error->result = as;
        norma_check_message(m->error->message, "cannot be mended: %s", norma_result_text(result));
    }
    return as;
}

/* ---- marks */

static int is_rule(const norma_finding *finding, check_rule rule) {
    size_t count;
    return finding->rule == norma_rules(&count) + rule;
}

int norma_fix_has(const fix_mesh *m, check_rule rule) {
    for (size_t i = 0; i < m->finding_count; i++)
        if (is_rule(m->findings[i], rule)) return 1;
    return 0;
}

int norma_fix_mark(
    const fix_mesh *m, check_rule rule, fix_element element, size_t count, uint8_t **marks) {
    int any = 0;
    for (size_t i = 0; i < m->finding_count; i++) {
        const norma_finding *finding = m->findings[i];
        if (!is_rule(finding, rule)) continue;
        if (!*marks && !(*marks = calloc(count + 1, 1))) return -1;
        for (size_t k = 0; k < finding->sample_count; k++) {
            const norma_sample *sample = &finding->samples[k];
            size_t number = element == MEND_VERTEX ? sample->vertex
                            : element == MEND_FACE ? sample->face
                                                   : sample->normal;
            if (number < count) (*marks)[number] = 1, any = 1;
        }
    }
    return any;
}

/* ---- a mesh as it will be */

norma_result norma_fix_corners(fix_mesh *m) {
    if (m->corners) return NORMA_OK;
    const core_mesh *mesh = &m->mesh;
    m->corners = malloc((mesh->corner_count + 1) * sizeof *m->corners);
    if (!m->corners) return NORMA_ERROR_MEMORY;
    for (size_t face = 0; face < mesh->face_count; face++) {
        size_t begin = norma_core_face_begin(mesh, face), end = norma_core_face_end(mesh, face);
        int reversed = m->edit->reverse_faces && m->edit->reverse_faces[face];
        for (size_t c = begin; c < end; c++)
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
    norma_result result = norma_fix_corners(m);
    if (result || m->face_normals) return result;
    const norma_mesh now = norma_fix_mesh_now(m);
    const norma_options options = {.struct_size = sizeof options, .threads = m->threads};
    m->face_normals = malloc((m->mesh.face_count + 1) * 3 * sizeof *m->face_normals);
    return m->face_normals
               ? norma_face_normals(&now, &options, m->face_normals, m->mesh.face_count, NULL)
               : NORMA_ERROR_MEMORY;
}

/* The weight and crease that the stored normals show; the defaults of computing where they show
 * none. */
static norma_result find_deviation(fix_mesh *m) {
    const norma_options options = {.struct_size = sizeof options, .threads = m->threads};
    norma_result result = m->knows_deviation ? NORMA_OK
                                             : norma_explain_normals(&m->data, m->info.normals,
                                                   &options, &m->deviation);
    if (result || m->knows_deviation) return result;
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
    norma_result result = m->surface ? NORMA_OK : norma_fix_corners(m);
    if (result || m->surface) return result;
    result = find_deviation(m);
    if (result) return result;
    const norma_deviation *d = &m->deviation;
    const int smooth = d->shading == NORMA_SHADING_SMOOTH;
    const float crease = d->shading == NORMA_SHADING_FLAT ? -1.0f
                         : smooth                         ? 3.5f
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
    for (int axis = 0; axis < 3; axis++)
        normal[axis] = (double)m->edit->normals[3 * number + (size_t)axis];
}

/* Half of the step between two codes; floats and texts: what rounding and nine digits make of a
 * number. */
static double half_step(const char *encoding) {
    static const struct {
        const char *name;
        double steps;
    } codes[] = {
        {"snorm8", 127}, {"int8", 127}, {"snorm10", 511}, {"snorm16", 32767}, {"int16", 32767}};
    for (size_t i = 0; i < sizeof codes / sizeof *codes; i++)
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
    for (int axis = 0; axis < 3; axis++) to[axis] = (float)unit[axis] + 0.0f;
    return 1;
}

/* ---- one mesh */

static int may_fix(const mender *m, const norma_finding *finding) {
    return finding->fix == NORMA_FIX_SAFE || (finding->fix == NORMA_FIX_UNSAFE && m->unsafe);
}

static int gather_findings(const mender *m, fix_mesh *mesh) {
    size_t count = norma_findings_count(m->findings);
    mesh->findings = calloc(count + 1, sizeof *mesh->findings);
    for (size_t i = 0; mesh->findings && i < count; i++) {
        const norma_finding *finding = norma_findings_get(m->findings, i);
        if (may_fix(m, finding) && strcmp(finding->where, mesh->info.where) == 0)
            mesh->findings[mesh->finding_count++] = finding;
    }
    return mesh->findings != NULL;
}

static void strip_normals(fix_mesh *m) {
    if (norma_fix_has(m, RULE_N105))
        m->edit->strip_normals = NORMA_STRIP_ALL;
    else if (norma_fix_has(m, RULE_N903))
        m->edit->strip_normals = NORMA_STRIP_MORPHS;
}

static norma_result fix_arrays(fix_mesh *mesh) {
    norma_result result = norma_core_mesh_shape(&mesh->data.mesh, &mesh->mesh);
    mesh->mesh.scale = 1;
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
    m->waits = 1;
}

static norma_document_result fix_mesh_of(mender *m, size_t index) {
    fix_mesh mesh = {.document = m->document,
        .index = index,
        .edit = &m->edits[index],
        .turned = m->turned[index],
        .smooth = m->smooth[index],
        .threads = m->options.threads};
    norma_result mended = NORMA_OK;
    norma_document_result result = norma_document_mesh_info(m->document, index, &mesh.info);
    if (result || mesh.info.not_read) return result;
    if (!gather_findings(m, &mesh)) return fail(m, NORMA_ERROR_MEMORY);
    if (mesh.finding_count > 0 || mesh.turned || mesh.smooth) {
        result = norma_document_mesh_data(m->document, index, &mesh.data, m->error);
        if (!result)
            result = norma_document_mesh_attributes(m->document, index, &mesh.attributes, m->error);
        if (!result) mended = fix_arrays(&mesh);
    }
    part_steps(&mesh);
    m->summary->again |= mesh.waits;
    free(mesh.findings);
    free(mesh.corners);
    free(mesh.surface);
    free(mesh.face_normals);
    return mended ? fail(m, mended) : result;
}

/* ---- whole bodies, seams between primitives */

/* The meshes from first on that belong together, those that were read; returns the one after. */
static size_t gather_group(
    const mender *m, size_t first, size_t *indices, const char **wheres, size_t *count) {
    norma_mesh_info info;
    size_t mesh = 0, i = first;
    for (*count = 0; i < m->mesh_count; i++) {
        if (norma_document_mesh_info(m->document, i, &info) || (i > first && info.mesh != mesh))
            break;
        mesh = info.mesh;
        if (info.not_read) continue;
        indices[*count] = i;
        wheres[(*count)++] = info.where;
    }
    return i > first ? i : first + 1;
}

static norma_document_result fix_groups(mender *m, int turns, int shares) {
    size_t *indices = calloc(m->mesh_count + 1, sizeof *indices), count;
    const char **wheres = calloc(m->mesh_count + 1, sizeof *wheres);
    norma_document_result result =
        indices && wheres ? NORMA_DOCUMENT_OK : fail(m, NORMA_ERROR_MEMORY);
    for (size_t first = 0; first < m->mesh_count && !result;) {
        norma_result how = NORMA_OK;
        first = gather_group(m, first, indices, wheres, &count);
        const fix_group group = {m->document, m->findings, indices, wheres, count,
            m->options.threads, m->options.open_by_rays, m->turned, m->smooth, m->summary,
            m->error};
        if (count && turns) result = norma_fix_turn(&group, &how);
        if (!result && !how && count > 1 && shares) result = norma_fix_seams(&group, &how);
        if (!result && how) result = fail(m, how);
    }
    free(indices);
    free((void *)wheres);
    return result;
}

/* ---- the document */

static void free_edits(mender *m) {
    for (size_t i = 0; m->edits && i < m->mesh_count; i++) {
        const norma_mesh_edit *edit = &m->edits[i];
        const void *const blocks[] = {edit->reverse_faces, edit->drop_faces, edit->normals,
            edit->set_normals, edit->positions, edit->set_positions, edit->tangents,
            edit->set_tangents, edit->cut_faces, edit->cut_corners, edit->source_vertices,
            edit->new_corners};
        for (size_t k = 0; k < sizeof blocks / sizeof *blocks; k++)
            free((void *)(uintptr_t)blocks[k]);
    }
    for (size_t i = 0; m->turned && m->smooth && i < m->mesh_count; i++) {
        free(m->turned[i]);
        free(m->smooth[i]);
    }
    free((void *)m->turned);
    free((void *)m->smooth);
    free(m->edits);
}

int norma_fix_has_edit(const norma_mesh_edit *edit) {
    return edit->reverse_faces || edit->drop_faces || edit->cut_faces || edit->set_normals ||
           edit->set_positions || edit->set_tangents || edit->strip_normals ||
           edit->source_vertices;
}

static int has_edit(const mender *m) {
    for (size_t i = 0; i < m->mesh_count; i++)
        if (norma_fix_has_edit(&m->edits[i])) return 1;
    return 0;
}

/* Whether a finding of the document asks for the rule's fix. */
static int is_asked(const mender *m, check_rule rule) {
    for (size_t i = 0; i < norma_findings_count(m->findings); i++) {
        const norma_finding *finding = norma_findings_get(m->findings, i);
        if (may_fix(m, finding) && is_rule(finding, rule)) return 1;
    }
    return 0;
}

static norma_document_result compute_missing(mender *m, int morphs) {
    norma_compute_summary summary;
    const norma_compute_options options = {.struct_size = sizeof options,
        .only = NORMA_ONLY_MISSING,
        .morphs = morphs,
        .threads = m->options.threads};
    norma_document_result result =
        norma_document_compute(m->document, &options, &summary, m->error);
    m->summary->changed |= !result && summary.changed;
    return result;
}

/* Placeholders of an OBJ: corners with quite different normals name one vn, so that all are made
 * anew. */
static norma_document_result replace_placeholders(mender *m) {
    norma_compute_summary summary;
    const norma_compute_options options = {
        .struct_size = sizeof options, .threads = m->options.threads};
    norma_document_result result =
        norma_document_compute(m->document, &options, &summary, m->error);
    m->summary->changed |= !result && summary.changed;
    return result;
}

/* The matrix is none that the caller gave: what does not fit is the file's own. */
static norma_document_result bake(mender *m) {
    norma_transform_summary summary;
    const norma_transform_options options = {
        .struct_size = sizeof options, .bake = 1, .threads = m->options.threads};
    norma_document_result result =
        norma_document_transform(m->document, &options, &summary, m->error);
    if (result == NORMA_DOCUMENT_ERROR_ARGUMENT) {
        result = NORMA_DOCUMENT_ERROR_MALFORMED;
        if (m->error) m->error->result = result;
    }
    m->summary->changed |= !result && summary.changed;
    return result;
}

/* The meshes that N701 names. */
static norma_document_result recentre(mender *m) {
    uint8_t *meshes = calloc(m->mesh_count + 1, 1);
    int changed = 0;
    norma_document_result result = meshes ? NORMA_DOCUMENT_OK : fail(m, NORMA_ERROR_MEMORY);
    for (size_t i = 0; i < m->mesh_count && !result; i++) {
        norma_mesh_info info;
        fix_mesh mesh = {.document = m->document};
        result = norma_document_mesh_info(m->document, i, &info);
        mesh.info = info;
        if (!result && !gather_findings(m, &mesh)) result = fail(m, NORMA_ERROR_MEMORY);
        meshes[i] = !result && norma_fix_has(&mesh, RULE_N701);
        free(mesh.findings);
    }
    if (!result) result = norma_document_recentre(m->document, meshes, &changed, m->error);
    free(meshes);
    m->summary->changed |= changed;
    return result;
}

/* Changes to a whole document. A glTF that was changed already takes none: they wait for a further
 * call on what it becomes. */
static norma_document_result fix_rest(mender *m) {
    const norma_file_format format = norma_document_format(m->document);
    const int one_change = format == NORMA_FILE_GLTF || format == NORMA_FILE_GLB;
    const int wants_compute = is_asked(m, RULE_N104) || is_asked(m, RULE_N106) ||
                              is_asked(m, RULE_N806) || is_asked(m, RULE_N901);
    const int wants_bake =
        is_asked(m, RULE_N601) || is_asked(m, RULE_N602) || is_asked(m, RULE_N604);
    norma_document_result result = NORMA_DOCUMENT_OK;
    if (is_asked(m, RULE_N701) && !(one_change && m->summary->changed))
        result = recentre(m);
    else
        m->summary->again |= is_asked(m, RULE_N701);
    if (!result && is_asked(m, RULE_N203) && format == NORMA_FILE_OBJ)
        result = replace_placeholders(m);
    if (result) return result;
    if (wants_compute && !(one_change && m->summary->changed))
        result = compute_missing(m, is_asked(m, RULE_N901));
    else
        m->summary->again |= wants_compute;
    if (result || !wants_bake) return result;
    if (one_change && m->summary->changed)
        m->summary->again = 1;
    else
        result = bake(m);
    return result;
}

static norma_document_result mend(mender *m) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    m->mesh_count = norma_document_mesh_count(m->document);
    m->edits = calloc(m->mesh_count + 1, sizeof *m->edits);
    m->turned = calloc(m->mesh_count + 1, sizeof *m->turned);
    m->smooth = calloc(m->mesh_count + 1, sizeof *m->smooth);
    if (!m->edits || !m->turned || !m->smooth) return fail(m, NORMA_ERROR_MEMORY);
    const int turns = m->unsafe && (is_asked(m, RULE_N302) || m->options.open_by_rays),
              shares = is_asked(m, RULE_N501);
    if (turns || shares) result = fix_groups(m, turns, shares);
    for (size_t i = 0; i < m->mesh_count && !result; i++) result = fix_mesh_of(m, i);
    if (!result && has_edit(m)) {
        result = norma_document_edit(m->document, m->edits, m->error);
        m->summary->changed = 1;
    }
    return result ? result : fix_rest(m);
}

norma_document_result norma_fix_document(norma_document *document,
    const norma_check_options *options, int unsafe, norma_fix_summary *summary,
    norma_document_error *error) {
    norma_fix_summary unwanted;
    mender m = {.document = document,
        .unsafe = unsafe,
        .summary = summary ? summary : &unwanted,
        .error = error};
    *m.summary = (norma_fix_summary){0};
    if (options) m.options = *options;
    m.options.struct_size = sizeof m.options;
    m.options.max_samples = SIZE_MAX; /* every element is wanted */
    norma_document_result result = norma_check_document(document, &m.options, &m.findings, error);
    if (!result) result = mend(&m);
    free_edits(&m);
    norma_findings_free(m.findings);
    return result;
}
