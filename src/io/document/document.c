/* document.c: opens a document, and hands every call to the table of functions of its format. */
#include "io/format/format.h"
#include "io/format/recentre.h"
#include "io/format/scene.h"
#include "core/call/vec3_view.h"
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- options of any version */

void norma_document_copy_options(void *copy, size_t size, size_t first_size, const void *given) {
    memset(copy, 0, size);
    if (!given) return;
    size_t given_size;
    memcpy(&given_size, given, sizeof given_size);
    given_size = given_size ? given_size : first_size;
    memcpy(copy, given, given_size < size ? given_size : size);
}

/* ---- opening and closing */

static const format_functions *functions_of(norma_file_format format) {
    switch (format) {
    case NORMA_FILE_OBJ:
        return &norma_obj_functions;
    case NORMA_FILE_PLY:
        return &norma_ply_functions;
    case NORMA_FILE_STL:
        return &norma_stl_functions;
    case NORMA_FILE_GLTF:
    case NORMA_FILE_GLB:
        return &norma_gltf_functions;
    default:
        return NULL;
    }
}

norma_document *norma_document_make(
    const char *name, int has_folder, const norma_document_options *options) {
    norma_document *document = norma_io_allocate(1, sizeof *document);
    if (!document) return NULL;
    const char *slash = strrchr(name, '/');
    document->path = norma_io_copy_text(name, strlen(name));
    document->folder =
        has_folder ? norma_io_copy_text(name, slash ? (size_t)(slash - name) + 1 : 0) : NULL;
    document->format = options->format ? options->format : norma_file_format_of_path(name);
    document->depth = options->depth;
    document->threads = options->threads;
    document->progress = options->progress;
    document->progress_user = options->progress_user;
    document->lenient = options->lenient;
    document->copied = options->copied;
    document->scene = norma_scene_create();
    if (document->scene && document->path && (document->folder || !has_folder)) return document;
    norma_document_close(document);
    return NULL;
}

norma_document_result norma_document_read(norma_document *document, norma_document_error *error) {
    const format_functions *functions = functions_of(document->format);
    if (!functions)
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, NULL,
            "unknown kind of file; expected a name that ends in .obj, .ply, .stl, .gltf or .glb, "
            "or to be told the format");
    if (document->progress && document->progress(document->progress_user, 0))
        return norma_document_fail(document, error, NORMA_DOCUMENT_CANCELLED, NULL, "cancelled");
    document->functions = functions;
    norma_document_result result = functions->open(document, error);
    document->progress = NULL;
    return result;
}

int norma_document_changed(const norma_document *document, norma_document_error *error) {
    const format_functions *functions = document->functions;
    char *beside = functions && functions->changed_companion && document->state
                       ? functions->changed_companion(document)
                       : NULL;
    const int changed = beside || norma_file_has_changed(document->path, &document->stamp);
    if (changed)
        norma_document_fail_file(
            beside ? beside : document->path, error, "cannot be read", FILE_CHANGED);
    free(beside);
    return changed;
}

static norma_document_result open_with(const char *name, int has_folder, const file_bytes *memory,
    const norma_document_options *given, norma_document **document, norma_document_error *error) {
    norma_document_options options;
    norma_document_copy_options(
        &options, sizeof options, offsetof(norma_document_options, lenient), given);
    norma_document *made = norma_document_make(name, has_folder, &options);
    if (!made) return norma_document_fail_memory(NULL, error);
    norma_document_result result = NORMA_DOCUMENT_OK;
    if (memory) {
        made->source = *memory;
    } else {
        const file_reading how = {
            .map_large = !made->copied && options.depth != NORMA_DOCUMENT_WHOLE,
            .progress = options.progress,
            .progress_user = options.progress_user};
        int failed = norma_file_open(name, &how, &made->source);
        if (failed) result = norma_document_fail_file(name, error, "cannot be read", failed);
        made->stamp = made->source.stamp;
    }
    if (!result) {
        result = norma_document_read(made, error);
        /* What was found in it may come of that. */
        if (result != NORMA_DOCUMENT_CANCELLED && result != NORMA_DOCUMENT_ERROR_MEMORY &&
            norma_document_changed(made, error))
            result = NORMA_DOCUMENT_ERROR_FILE;
    }
    if (result)
        norma_document_close(made);
    else
        *document = made;
    return result;
}

void norma_document_clear(norma_document_error *error) {
    if (error) {
        error->result = NORMA_DOCUMENT_OK;
        error->message[0] = '\0';
    }
}

norma_document_result norma_document_open(const char *path, const norma_document_options *options,
    norma_document **document, norma_document_error *error) {
    norma_document_clear(error);
    if (!document)
        return norma_document_fail(NULL, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL,
            "no place for the document was given");
    *document = NULL;
    if (!path)
        return norma_document_fail(
            NULL, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL, "no path was given");
    return open_with(path, 1, NULL, options, document, error);
}

norma_document_result norma_document_open_memory(const void *bytes, size_t size, const char *name,
    const norma_document_options *options, norma_document **document, norma_document_error *error) {
    norma_document_clear(error);
    if (!document)
        return norma_document_fail(NULL, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL,
            "no place for the document was given");
    *document = NULL;
    if (!bytes && size)
        return norma_document_fail(
            NULL, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL, "no bytes were given");
    const file_bytes source = {.data = bytes ? bytes : (const void *)"", .size = size};
    return open_with(name ? name : "<memory>", name != NULL, &source, options, document, error);
}

void norma_document_close(norma_document *document) {
    if (!document) return;
    if (document->functions) document->functions->close(document);
    norma_scene_destroy(document->scene);
    for (size_t i = 0; i < document->note_count; ++i) free(document->notes[i]);
    free(document->notes);
    norma_file_close(&document->source);
    for (size_t i = 0; document->given && i < document->given_count; ++i)
        free(document->given[i].bytes);
    free(document->given);
    free(document->path);
    free(document->folder);
    free(document);
}

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
    return document ? document->functions->mesh_count(document) : 0;
}

norma_document_result norma_document_mesh_info(
    const norma_document *document, size_t index, norma_mesh_info *info) {
    if (!info) return NORMA_DOCUMENT_ERROR_ARGUMENT;
    *info = (norma_mesh_info){.name = "", .where = "", .encoding = ""};
    if (index >= norma_document_mesh_count(document)) return NORMA_DOCUMENT_ERROR_ARGUMENT;
    return document->functions->mesh_info(document, index, info);
}

size_t norma_document_node_count(const norma_document *document) {
    return document && document->functions->node_count ? document->functions->node_count(document)
                                                       : 0;
}

norma_document_result norma_document_node_info(
    const norma_document *document, size_t index, norma_node_info *info) {
    if (!info) return NORMA_DOCUMENT_ERROR_ARGUMENT;
    *info = (norma_node_info){.name = "",
        .instances = 1,
        .parent = SIZE_MAX,
        .skin = SIZE_MAX,
        .where = "",
        .path = "",
        .ignore = ""};
    if (index >= norma_document_node_count(document)) return NORMA_DOCUMENT_ERROR_ARGUMENT;
    return document->functions->node_info(document, index, info);
}

/* ---- what needs the whole document */

norma_document_result norma_document_usable(
    const norma_document *document, norma_document_error *error) {
    norma_document_clear(error);
    if (!document)
        return norma_document_fail(
            NULL, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL, "no document was given");
    if (document->depth != NORMA_DOCUMENT_WHOLE)
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL,
            "opened as a summary only; expected to be opened whole");
    if (document->failed)
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL,
            "an earlier change of it failed; it can only be closed");
    return NORMA_DOCUMENT_OK;
}

norma_document_result norma_document_mesh_data(
    norma_document *document, size_t index, norma_mesh_data *data, norma_document_error *error) {
    norma_document_result result = norma_document_usable(document, error);
    if (result) return result;
    norma_mesh_info info;
    size_t count = norma_document_mesh_count(document);
    if (!data || index >= count)
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL,
            "mesh %zu of %zu was asked for", index, count);
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

static const char *bad_compute_option(const norma_compute_options *options) {
    if ((unsigned)options->shading > NORMA_SHADING_FLAT) return "unknown shading";
    if (options->shading == NORMA_SHADING_CREASE &&
        !(options->crease_angle_rad >= 0 && options->crease_angle_rad <= 3.1425926))
        return "the crease angle must be in radians, from 0 to pi";
    if ((unsigned)options->weight > NORMA_WEIGHT_ANGLE_LENGTHS) return "unknown weight";
    if ((unsigned)options->weld > NORMA_WELD_DISTANCE) return "unknown way to weld";
    if (options->weld == NORMA_WELD_DISTANCE &&
        !(options->weld_distance >= 0 && isfinite(options->weld_distance)))
        return "the weld distance is no finite number from 0 up";
    if ((unsigned)options->non_manifold > NORMA_NON_MANIFOLD_SMOOTH)
        return "unknown treatment of non-manifold edges";
    if ((unsigned)options->groups > NORMA_GROUPS_IGNORE)
        return "unknown treatment of smoothing groups";
    return (unsigned)options->only > NORMA_ONLY_BROKEN ? "unknown choice of what to compute" : NULL;
}

norma_document_result norma_document_compute(norma_document *document,
    const norma_compute_options *given, norma_compute_summary *summary,
    norma_document_error *error) {
    norma_document_result result = norma_document_usable(document, error);
    if (result) return result;
    norma_compute_options options;
    norma_compute_summary unwanted;
    norma_document_copy_options(&options, sizeof options, sizeof options, given);
    const char *bad = bad_compute_option(&options);
    if (bad)
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL, "%s", bad);
    summary = summary ? summary : &unwanted;
    *summary = (norma_compute_summary){0};
    result = document->functions->compute(document, &options, summary, error);
    if (document->functions != &norma_gltf_functions) /* whose data stay as they were read */
        norma_scene_forget(document->scene);
    document->failed = result != NORMA_DOCUMENT_OK;
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
    norma_document_result result = norma_document_usable(document, error);
    if (result) return result;
    norma_transform_options options;
    norma_transform_summary unwanted;
    norma_document_copy_options(&options, sizeof options, sizeof options, given);
    const char *bad = bad_matrix(options.matrix);
    if (bad)
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL, "%s", bad);
    summary = summary ? summary : &unwanted;
    *summary = (norma_transform_summary){0};
    result = document->functions->transform(document, &options, summary, error);
    document->failed = result != NORMA_DOCUMENT_OK;
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
    norma_document_result result = norma_document_usable(document, error);
    changed = changed ? changed : &unwanted;
    *changed = 0;
    if (result) return result;
    if (!document->functions->recentre)
        return meshes && !meshes[0] ? NORMA_DOCUMENT_OK : recentre_whole(document, changed, error);
    result = document->functions->recentre(document, meshes, changed, error);
    document->failed = result != NORMA_DOCUMENT_OK;
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
    norma_document_result result = norma_document_usable(document, error);
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
    document->failed = result != NORMA_DOCUMENT_OK;
    return result;
}

norma_document_result norma_document_equal_vertices(
    norma_document *document, size_t mesh, uint32_t *first, norma_document_error *error) {
    norma_mesh_info info;
    norma_document_result result = norma_document_usable(document, error);
    if (result) return result;
    if (!first || norma_document_mesh_info(document, mesh, &info) || info.not_read ||
        !document->functions->equal_vertices)
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL,
            "mesh %zu has no vertices that could be compared", mesh);
    return document->functions->equal_vertices(document, mesh, first, error);
}
