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
        norma_check_message(m->error->message, "cannot be fixed: %s", norma_result_text(result));
    }
    return as;
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

static int has_edit(const mender *m) {
    for (size_t i = 0; i < m->mesh_count; i++)
        if (norma_fix_has_edit(&m->edits[i])) return 1;
    return 0;
}

/* Whether a finding of the document asks for the rule's fix. */
static int is_asked(const mender *m, check_rule rule) {
    for (size_t i = 0; i < norma_findings_count(m->findings); i++) {
        const norma_finding *finding = norma_findings_get(m->findings, i);
        if (may_fix(m, finding) && norma_fix_is_rule(finding, rule)) return 1;
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

/* The caller gave no matrix, so numbers that do not fit are the file's own fault. */
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

/* Changes to a whole document, after those of its meshes. */
static norma_document_result fix_rest(mender *m) {
    const int wants_compute = is_asked(m, RULE_N104) || is_asked(m, RULE_N106) ||
                              is_asked(m, RULE_N806) || is_asked(m, RULE_N901);
    const int wants_bake =
        is_asked(m, RULE_N601) || is_asked(m, RULE_N602) || is_asked(m, RULE_N604);
    norma_document_result result = is_asked(m, RULE_N701) ? recentre(m) : NORMA_DOCUMENT_OK;
    if (!result && is_asked(m, RULE_N203) && norma_document_format(m->document) == NORMA_FILE_OBJ)
        result = replace_placeholders(m);
    if (!result && wants_compute) result = compute_missing(m, is_asked(m, RULE_N901));
    return result || !wants_bake ? result : bake(m);
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
