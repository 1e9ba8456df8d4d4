/* document.c: what a document tells of its meshes and nodes, and the changes that it takes. */
#include "io/format/for_fixes.h"
#include "io/format/format.h"
#include "core/call/call.h"
#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

/* ---- A format whose changes wait beside what was read (glTF) is read anew from what it has
 * become, before it is asked or changed again. */

/* From the disk where it was saved over its own file, else from what the format makes of it. */
static norma_document_result take_source(
    norma_document *document, norma_document *made, norma_document_error *error) {
    if (!document->replaced) {
        made->stamp = document->stamp;
        return document->functions->reopen(document, made, error);
    }
    const int failed = norma_file_open(document->path, &(file_reading){0}, &made->source);
    made->stamp = made->source.stamp;
    return failed ? norma_document_fail_file(document->path, error, "cannot be read", failed)
                  : NORMA_DOCUMENT_OK;
}

/* The document is the one that was made, but for its place in memory, its name and its notes. */
static void swap_documents(norma_document *document, norma_document *made) {
    const norma_document old = *document;
    document->source = made->source;
    document->stamp = made->stamp;
    document->state = made->state;
    document->given = made->given;
    document->given_count = made->given_count;
    document->scene = made->scene;
    if (document->replaced) norma_document_forget_images(document); /* they are files now */
    document->replaced = 0;
    made->source = old.source;
    made->state = old.state;
    made->given = old.given;
    made->given_count = old.given_count;
    made->scene = old.scene;
    document->functions->adopt(document);
    document->functions->adopt(made);
}

static norma_document_result flush_changes(norma_document *document, norma_document_error *error) {
    if (!document->functions->reopen || !document->functions->has_change(document))
        return NORMA_DOCUMENT_OK;
    const norma_document_options options = {.struct_size = sizeof options,
        .format = document->format,
        .depth = document->depth,
        .threads = document->threads,
        .lenient = document->lenient,
        .copied = document->copied};
    norma_document *made = norma_document_make(document->path, document->folder != NULL, &options);
    norma_document_result result =
        made ? take_source(document, made, error) : norma_document_fail_memory(document, error);
    if (!result && norma_document_changed(document, error)) result = NORMA_DOCUMENT_ERROR_FILE;
    if (!result) made->functions = document->functions;
    if (!result) result = norma_document_read(made, error);
    if (!result) swap_documents(document, made);
    norma_document_close(made);
    return result;
}

/* Before something is given out, so that it stays where it is until the next change: nothing waits
 * that giving out something else would first have to write. Changes that wait together (OBJ) are
 * shown as they are. */
static norma_document_result flush_waiting(norma_document *document, norma_document_error *error) {
    const edited_format *edited = document->functions->edited;
    return edited && !edited->gathers ? norma_edited_flush(document, error)
                                      : flush_changes(document, error);
}

norma_document_result norma_document_ready(norma_document *document, norma_document_error *error) {
    const norma_document_result result = norma_document_usable(document, error);
    return result ? result : flush_waiting(document, error);
}

int norma_document_up_to_date(const norma_document *document) {
    norma_document *own = (norma_document *)(uintptr_t)document;
    if (own && !own->failed && own->state) (void)flush_changes(own, NULL);
    return document != NULL;
}

/* ---- Hands every call to the table of functions of the document's format. */

/* ---- asking */

norma_file_format norma_document_format(const norma_document *document) {
    return document ? document->format : NORMA_FILE_UNKNOWN;
}

size_t norma_document_note_count(const norma_document *document) {
    return document ? document->note_count : 0;
}

const char *norma_document_note(const norma_document *document, size_t index) {
    return document && index < document->note_count ? document->notes[index] : "";
}

size_t norma_document_mesh_count(const norma_document *document) {
    return norma_document_up_to_date(document) ? document->functions->mesh_count(document) : 0;
}

norma_document_result norma_document_mesh_info(
    const norma_document *document, size_t index, norma_mesh_info *info) {
    if (!info) return NORMA_DOCUMENT_ERROR_ARGUMENT;
    *info = (norma_mesh_info){.name = "", .where = "", .encoding = ""};
    if (index >= norma_document_mesh_count(document)) return NORMA_DOCUMENT_ERROR_ARGUMENT;
    /* Its texts are valid as long as the arrays are. */
    norma_document *own = (norma_document *)(uintptr_t)document;
    const norma_document_result result =
        document->failed || !document->state ? NORMA_DOCUMENT_OK : flush_waiting(own, NULL);
    if (result) return result;
    return document->functions->mesh_info(document, index, info);
}

size_t norma_document_node_count(const norma_document *document) {
    return norma_document_up_to_date(document) && document->functions->node_count
               ? document->functions->node_count(document)
               : 0;
}

/* Where those of a mesh of the file begin, or would: all come in the order of their meshes. */
static norma_document_result find_first_mesh(
    const norma_document *document, size_t number, size_t *first) {
    norma_mesh_info info;
    size_t end = norma_document_mesh_count(document);
    for (*first = 0; *first < end;) {
        const size_t middle = *first + (end - *first) / 2;
        const norma_document_result result = norma_document_mesh_info(document, middle, &info);
        if (result) return result;
        if (info.mesh < number)
            *first = middle + 1;
        else
            end = middle;
    }
    return NORMA_DOCUMENT_OK;
}

norma_document_result norma_document_node_info(
    const norma_document *document, size_t index, norma_node_info *info) {
    size_t end = 0;
    if (!info) return NORMA_DOCUMENT_ERROR_ARGUMENT;
    *info = (norma_node_info){.name = "",
        .instances = 1,
        .parent = SIZE_MAX,
        .skin = SIZE_MAX,
        .where = "",
        .path = "",
        .ignore = ""};
    if (index >= norma_document_node_count(document)) return NORMA_DOCUMENT_ERROR_ARGUMENT;
    norma_document_result result = document->functions->node_info(document, index, info);
    if (!result) result = find_first_mesh(document, info->mesh, &info->first_mesh);
    if (!result) result = find_first_mesh(document, info->mesh + 1, &end);
    if (!result) info->mesh_count = end - info->first_mesh;
    return result;
}

/* ---- what needs the whole document */

norma_document_result norma_document_mesh_data(
    norma_document *document, size_t index, norma_mesh_data *data, norma_document_error *error) {
    norma_document_result result = norma_document_ready(document, error);
    if (result) return result;
    norma_mesh_info info;
    size_t count = norma_document_mesh_count(document);
    if (!data || index >= count)
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL,
            "there is no mesh %zu; the document has %zu, numbered from 0", index, count);
    *data = (norma_mesh_data){0};
    result = norma_document_mesh_info(document, index, &info);
    if (result)
        return norma_document_fail(
            document, error, result, NULL, "mesh %zu cannot be described", index);
    if (info.not_read)
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT,
            info.where[0] ? info.where : NULL, "%s", info.not_read);
    return document->functions->mesh_data(document, index, data, error);
}

static norma_document_result begin_change(norma_document *document, norma_document_error *error) {
    norma_document_result result = norma_document_usable(document, error);
    if (!result) result = flush_changes(document, error);
    if (!result && !document->functions->compute)
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, NULL,
            "files of this format can be read, but not changed");
    if (!result && document->functions->edited) norma_edited_begin(document);
    return result;
}

/* Of what is asked for arrays before it is changed. */
static norma_document_result begin_edit(norma_document *document, norma_document_error *error) {
    const norma_document_result result = norma_document_ready(document, error);
    return result ? result : begin_change(document, error);
}

/* A change that failed is taken back; where that is not possible, the document can only be closed.
 */
static void end_change(norma_document *document, norma_document_result result) {
    if (result && !document->failed)
        document->failed =
            document->functions->edited
                ? !norma_edited_drop(document, result)
                : !document->functions->drop_change || !document->functions->drop_change(document);
}

const char *norma_document_bad_compute_option(const norma_compute_options *options) {
    if ((unsigned)options->shading > NORMA_SHADING_FLAT) return "unknown shading";
    if (options->shading == NORMA_SHADING_CREASE &&
        !(options->crease_angle_rad >= 0 && options->crease_angle_rad <= 3.1425926))
        return "the crease angle must be in radians, from 0 to pi";
    if (!norma_weight_name(options->weight)) return "unknown weight";
    if ((unsigned)options->weld > NORMA_WELD_DISTANCE) return "unknown way to weld";
    if (options->weld == NORMA_WELD_DISTANCE &&
        !(options->weld_distance >= 0 && isfinite(options->weld_distance)))
        return "the weld distance must be a finite number from 0 up";
    if ((unsigned)options->non_manifold > NORMA_NON_MANIFOLD_SMOOTH)
        return "unknown treatment of non-manifold edges";
    if ((unsigned)options->groups > NORMA_GROUPS_IGNORE)
        return "unknown treatment of smoothing groups";
    if ((unsigned)options->tangents > NORMA_STORED_TANGENTS_REGENERATE)
        return "unknown treatment of stored tangents";
    return (unsigned)options->only > NORMA_ONLY_BROKEN ? "unknown choice of what to compute" : NULL;
}

/* Progress over normals, then tangents, as that over both. */
typedef struct two_steps {
    norma_progress *progress;
    void *user;
    double base;
} two_steps;

static int pass_on_progress(void *user, double fraction) {
    const two_steps *steps = user;
    return steps->progress(steps->user, steps->base + fraction / 2);
}

/* The tangents of the primitives that document->renew marks, on the normals just computed. Those
 * are part of the bytes by then, so a failure here cannot be taken back. */
static norma_document_result renew_tangents(norma_document *document,
    const norma_compute_options *compute, norma_compute_summary *summary,
    norma_document_error *error) {
    const norma_tangent_options options = {.struct_size = sizeof options,
        .mode = NORMA_TANGENTS_MIKK,
        .threads = compute->threads,
        .progress = compute->progress,
        .progress_user = compute->progress_user,
        .meshes = document->renew};
    norma_tangent_summary made = {0};
    norma_document_result result = flush_changes(document, error);
    if (!result) result = document->functions->tangents(document, &options, &made, error);
    document->failed |= result != NORMA_DOCUMENT_OK;
    summary->changed |= made.changed;
    if (!result) {
        summary->tangents_regenerated += made.vertices_after - summary->vertices_after;
        summary->vertices_after = made.vertices_after;
    }
    return result;
}

static norma_document_result compute_with_tangents(norma_document *document,
    const norma_compute_options *given, norma_compute_summary *summary,
    norma_document_error *error) {
    two_steps steps = {given->progress, given->progress_user, 0};
    norma_compute_options options = *given;
    options.progress = given->progress ? pass_on_progress : NULL;
    options.progress_user = &steps;
    norma_document_result result = document->functions->compute(document, &options, summary, error);
    steps.base = .5;
    if (!result && document->renew) result = renew_tangents(document, &options, summary, error);
    free(document->renew);
    document->renew = NULL;
    return result;
}

norma_document_result norma_document_compute(norma_document *document,
    const norma_compute_options *given, norma_compute_summary *summary,
    norma_document_error *error) {
    norma_document_result result = begin_change(document, error);
    if (result) return result;
    norma_compute_options options;
    norma_compute_summary unwanted;
    norma_document_copy_options(
        &options, sizeof options, offsetof(norma_compute_options, tangents), given);
    const char *bad = norma_document_bad_compute_option(&options);
    if (bad)
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL, "%s", bad);
    summary = summary ? summary : &unwanted;
    *summary = (norma_compute_summary){0};
    result = options.tangents == NORMA_STORED_TANGENTS_REGENERATE
                 ? compute_with_tangents(document, &options, summary, error)
                 : document->functions->compute(document, &options, summary, error);
    if (!document->functions->has_change) norma_scene_forget(document->scene);
    end_change(document, result);
    return result;
}

static const char *bad_tangent_option(const norma_tangent_options *options) {
    if ((unsigned)options->mode > NORMA_TANGENTS_MIKK) return "unknown mode of tangents";
    if (!norma_weight_name(options->weight)) return "unknown weight";
    return (unsigned)options->only > NORMA_ONLY_BROKEN ? "unknown choice of what to compute" : NULL;
}

norma_document_result norma_document_tangents(norma_document *document,
    const norma_tangent_options *given, norma_tangent_summary *summary,
    norma_document_error *error) {
    norma_document_result result = begin_change(document, error);
    if (result) return result;
    norma_tangent_options options;
    norma_tangent_summary unwanted;
    norma_document_copy_options(
        &options, sizeof options, offsetof(norma_tangent_options, meshes), given);
    const char *bad = document->functions->tangents ? bad_tangent_option(&options)
                                                    : "this format cannot store tangents; glTF can";
    if (bad)
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL, "%s", bad);
    summary = summary ? summary : &unwanted;
    *summary = (norma_tangent_summary){0};
    result = document->functions->tangents(document, &options, summary, error);
    end_change(document, result);
    return result;
}

norma_document_result norma_document_pack(norma_document *document, const norma_pack_options *given,
    norma_pack_summary *summary, norma_document_error *error) {
    norma_document_result result = begin_change(document, error);
    if (result) return result;
    norma_pack_options options;
    norma_pack_summary unwanted;
    norma_document_copy_options(&options, sizeof options, sizeof options, given);
    const char *bad = !document->functions->pack
                          ? "this format has one encoding of normals; glTF has others"
                      : !(options.max_error_rad >= 0 && options.max_error_rad <= 3.1415927)
                          ? "the angle must be in radians, from 0 to pi"
                          : NULL;
    if (bad)
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL, "%s", bad);
    summary = summary ? summary : &unwanted;
    *summary = (norma_pack_summary){0};
    norma_watch_begin(&document->watch, options.progress, options.progress_user);
    result = document->functions->pack(document, &options, summary, error);
    if (norma_watch_end(&document->watch)) result = norma_document_fail_cancelled(document, error);
    end_change(document, result);
    return result;
}

static const char *bad_matrix(double matrix[16]) {
    int all_zero = 1;
    for (int i = 0; i < 16; ++i) {
        if (!isfinite(matrix[i])) return "the matrix holds a number that is not finite";
        all_zero &= matrix[i] == 0;
    }
    if (all_zero) matrix[0] = matrix[5] = matrix[10] = matrix[15] = 1;
    if (matrix[3] != 0 || matrix[7] != 0 || matrix[11] != 0 || matrix[15] != 1)
        return "the last row of the matrix is not 0 0 0 1; a perspective cannot be applied to a "
               "file";
    return NULL;
}

norma_document_result norma_document_transform(norma_document *document,
    const norma_transform_options *given, norma_transform_summary *summary,
    norma_document_error *error) {
    norma_document_result result = begin_change(document, error);
    if (result) return result;
    norma_transform_options options;
    norma_transform_summary unwanted;
    norma_document_copy_options(&options, sizeof options, sizeof options, given);
    const char *bad = bad_matrix(options.matrix);
    if (bad)
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL, "%s", bad);
    summary = summary ? summary : &unwanted;
    *summary = (norma_transform_summary){0};
    norma_watch_begin(&document->watch, options.progress, options.progress_user);
    options.progress = norma_watch_tell;
    options.progress_user = &document->watch;
    result = document->functions->transform(document, &options, summary, error);
    if (norma_watch_end(&document->watch)) result = norma_document_fail_cancelled(document, error);
    end_change(document, result);
    return result;
}

static norma_document_result recentre_whole(
    norma_document *document, int *changed, norma_document_error *error) {
    recentre_box box = norma_recentre_empty();
    norma_transform_options options = {.struct_size = sizeof options,
        .matrix = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1},
        .threads = document->threads};
    norma_transform_summary summary = {0};
    norma_mesh_data data = {0};
    double step[3], position[3];
    norma_document_result result = norma_document_mesh_data(document, 0, &data, error);
    for (size_t i = 0; !result && i < data.mesh.positions.count; ++i) {
        norma_view_read(&data.mesh.positions, i, position);
        norma_recentre_add(&box, position);
    }
    if (result || !norma_recentre_step(&box, step)) return result;
    for (int axis = 0; axis < 3; ++axis) options.matrix[12 + axis] = -step[axis];
    result = norma_document_transform(document, &options, &summary, error);
    *changed = !result && summary.changed;
    return result;
}

norma_document_result norma_document_recentre(
    norma_document *document, const uint8_t *meshes, int *changed, norma_document_error *error) {
    int unwanted;
    norma_document_result result = begin_edit(document, error);
    changed = changed ? changed : &unwanted;
    *changed = 0;
    if (result) return result;
    if (!document->functions->recentre)
        return meshes && !meshes[0] ? NORMA_DOCUMENT_OK : recentre_whole(document, changed, error);
    result = document->functions->recentre(document, meshes, changed, error);
    end_change(document, result);
    return result;
}

/* Read anew at once: where new images stand is known only then. */
norma_document_result norma_document_turn_green(
    norma_document *document, const uint8_t *meshes, int *changed, norma_document_error *error) {
    norma_document_result result = begin_change(document, error);
    *changed = 0;
    if (result || !document->functions->turn_green) return result;
    result = document->functions->turn_green(document, meshes, changed, error);
    end_change(document, result);
    if (result || !*changed) return result;
    result = flush_changes(document, error);
    document->failed |= result != NORMA_DOCUMENT_OK;
    return result;
}

/* Every number in it, before anything is changed. */
static norma_document_result check_vertices(norma_document *document, size_t mesh,
    const norma_mesh_edit *edit, norma_document_error *error) {
    norma_mesh_data data = {0};
    norma_document_result result = norma_document_mesh_data(document, mesh, &data, error);
    int fits = document->functions->equal_vertices && edit->new_corners && edit->vertex_count > 0 &&
               edit->vertex_count < UINT32_MAX && !edit->strip_normals;
    if (result) return result;
    for (size_t v = 0; fits && v < edit->vertex_count; ++v)
        fits = edit->source_vertices[v] < data.mesh.positions.count;
    for (size_t c = 0; fits && c < data.mesh.corner_count; ++c)
        fits = edit->new_corners[c] < edit->vertex_count;
    return fits ? NORMA_DOCUMENT_OK
                : norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL,
                      "mesh %zu cannot have the vertices that were given for it", mesh);
}

norma_document_result norma_document_edit(
    norma_document *document, const norma_mesh_edit *edits, norma_document_error *error) {
    norma_document_result result = begin_edit(document, error);
    if (result) return result;
    if (!edits)
        return norma_document_fail(
            document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL, "no edits were given");
    for (size_t i = 0; i < norma_document_mesh_count(document); ++i)
        if ((edits[i].set_normals && !edits[i].normals) ||
            (edits[i].set_positions && !edits[i].positions) ||
            (edits[i].set_tangents && !edits[i].tangents))
            return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL,
                "marks without numbers were given for mesh %zu", i);
    for (size_t i = 0; !result && i < norma_document_mesh_count(document); ++i)
        result = edits[i].source_vertices ? check_vertices(document, i, &edits[i], error)
                                          : NORMA_DOCUMENT_OK;
    if (result) return result;
    result = document->functions->edit(document, edits, error);
    end_change(document, result);
    return result;
}

norma_document_result norma_document_equal_vertices(
    norma_document *document, size_t mesh, uint32_t *first, norma_document_error *error) {
    norma_mesh_info info;
    norma_document_result result = norma_document_ready(document, error);
    if (result) return result;
    if (!first || norma_document_mesh_info(document, mesh, &info) || info.not_read ||
        !document->functions->equal_vertices)
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL,
            "mesh %zu has no vertices that could be compared", mesh);
    return document->functions->equal_vertices(document, mesh, first, error);
}
