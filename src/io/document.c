/* document.c: opens a document, and hands every call to the table of functions of its format. */
#include "document_internal.h"
#include "recentre.h"
#include "scene.h"
#include "../core/vec3_view.h"
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- options of any version */

/* A caller's header may be older or newer than this library: what it does not know is zero, what we do not know is left out. A size of 0 is that
 * of the first version. */
static void copy_options(void *copy, size_t size, size_t first_size, const void *given) {
    memset(copy, 0, size);
    if (!given)
        return;
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

static char *copy_text(const char *text, size_t length) {
    char *copy = norma_io_allocate(length + 1, 1);
    if (copy)
        memcpy(copy, text, length);
    return copy;
}

static norma_document *make_document(const char *name, int has_folder, const norma_document_options *options) {
    norma_document *document = norma_io_allocate(1, sizeof *document);
    if (!document)
        return NULL;
    const char *slash = strrchr(name, '/');
    document->path = copy_text(name, strlen(name));
    document->folder = has_folder ? copy_text(name, slash ? (size_t)(slash - name) + 1 : 0) : NULL;
    document->format = options->format ? options->format : norma_file_format_of_path(name);
    document->depth = options->depth;
    document->threads = options->threads;
    document->progress = options->progress;
    document->progress_user = options->progress_user;
    document->lenient = options->lenient;
    document->copied = options->copied;
    document->scene = norma_scene_create();
    if (document->scene && document->path && (document->folder || !has_folder))
        return document;
    norma_document_close(document);
    return NULL;
}

static norma_document_result read_document(norma_document *document, norma_document_error *error) {
    const format_functions *functions = functions_of(document->format);
    if (!functions)
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, NULL,
                                   "unknown kind of file; expected a name that ends in .obj, .ply, .stl, .gltf or .glb, or to be told the format");
    if (document->progress && document->progress(document->progress_user, 0))
        return norma_document_fail(document, error, NORMA_DOCUMENT_CANCELLED, NULL, "cancelled");
    document->functions = functions;
    norma_document_result result = functions->open(document, error);
    document->progress = NULL;
    return result;
}

/* Mapped bytes are those of the file as it is now: half of them may be old and half of them new. */
static int changed_since_read(const norma_document *document, norma_document_error *error) {
    const format_functions *functions = document->functions;
    char *beside = functions && functions->changed_companion && document->state ? functions->changed_companion(document) : NULL;
    const int changed = beside || norma_file_has_changed(document->path, &document->stamp);
    if (changed)
        norma_document_fail_file(beside ? beside : document->path, error, "cannot be read", FILE_CHANGED);
    free(beside);
    return changed;
}

static norma_document_result open_with(const char *name, int has_folder, const file_bytes *memory, const norma_document_options *given,
                                       norma_document **document, norma_document_error *error) {
    norma_document_options options;
    copy_options(&options, sizeof options, offsetof(norma_document_options, lenient), given);
    norma_document *made = make_document(name, has_folder, &options);
    if (!made)
        return norma_document_fail_memory(NULL, error);
    norma_document_result result = NORMA_DOCUMENT_OK;
    if (memory) {
        made->source = *memory;
    } else {
        int failed = norma_file_open(name, made->copied, &made->source);
        if (failed)
            result = norma_document_fail_file(name, error, "cannot be read", failed);
        made->stamp = made->source.stamp;
    }
    if (!result) {
        result = read_document(made, error);
        /* What was found in it may come of that. */
        if (result != NORMA_DOCUMENT_CANCELLED && result != NORMA_DOCUMENT_ERROR_MEMORY && changed_since_read(made, error))
            result = NORMA_DOCUMENT_ERROR_FILE;
    }
    if (result)
        norma_document_close(made);
    else
        *document = made;
    return result;
}

static void clear_error(norma_document_error *error) {
    if (error) {
        error->result = NORMA_DOCUMENT_OK;
        error->message[0] = '\0';
    }
}

norma_document_result norma_document_open(const char *path, const norma_document_options *options, norma_document **document, norma_document_error *error) {
    clear_error(error);
    if (!document)
        return norma_document_fail(NULL, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL, "no place for the document was given");
    *document = NULL;
    if (!path)
        return norma_document_fail(NULL, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL, "no path was given");
    return open_with(path, 1, NULL, options, document, error);
}

norma_document_result norma_document_open_memory(const void *bytes, size_t size, const char *name, const norma_document_options *options,
                                                 norma_document **document, norma_document_error *error) {
    clear_error(error);
    if (!document)
        return norma_document_fail(NULL, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL, "no place for the document was given");
    *document = NULL;
    if (!bytes && size)
        return norma_document_fail(NULL, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL, "no bytes were given");
    const file_bytes source = {.data = bytes ? bytes : (const void *)"", .size = size};
    return open_with(name ? name : "<memory>", name != NULL, &source, options, document, error);
}

void norma_document_close(norma_document *document) {
    if (!document)
        return;
    if (document->functions)
        document->functions->close(document);
    norma_scene_destroy(document->scene);
    for (size_t i = 0; i < document->note_count; ++i) free(document->notes[i]);
    free(document->notes);
    norma_file_close(&document->source);
    free(document->path);
    free(document->folder);
    free(document);
}

/* ---- asking */

norma_file_format norma_document_format(const norma_document *document) { return document ? document->format : NORMA_FILE_UNKNOWN; }

size_t norma_document_note_count(const norma_document *document) { return document ? document->note_count : 0; }

const char *norma_document_note(const norma_document *document, size_t index) { return document && index < document->note_count ? document->notes[index] : ""; }

size_t norma_document_mesh_count(const norma_document *document) { return document ? document->functions->mesh_count(document) : 0; }

norma_document_result norma_document_mesh_info(const norma_document *document, size_t index, norma_mesh_info *info) {
    if (!info)
        return NORMA_DOCUMENT_ERROR_ARGUMENT;
    *info = (norma_mesh_info){.name = "", .where = "", .encoding = ""};
    if (index >= norma_document_mesh_count(document))
        return NORMA_DOCUMENT_ERROR_ARGUMENT;
    return document->functions->mesh_info(document, index, info);
}

size_t norma_document_node_count(const norma_document *document) {
    return document && document->functions->node_count ? document->functions->node_count(document) : 0;
}

norma_document_result norma_document_node_info(const norma_document *document, size_t index, norma_node_info *info) {
    if (!info)
        return NORMA_DOCUMENT_ERROR_ARGUMENT;
    *info = (norma_node_info){.name = "", .instances = 1, .parent = SIZE_MAX, .skin = SIZE_MAX, .where = "", .path = "", .ignore = ""};
    if (index >= norma_document_node_count(document))
        return NORMA_DOCUMENT_ERROR_ARGUMENT;
    return document->functions->node_info(document, index, info);
}

/* ---- what needs the whole document */

static norma_document_result check_usable(const norma_document *document, norma_document_error *error) {
    clear_error(error);
    if (!document)
        return norma_document_fail(NULL, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL, "no document was given");
    if (document->depth != NORMA_DOCUMENT_WHOLE)
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL, "opened as a summary only; expected to be opened whole");
    if (document->failed)
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL, "an earlier change of it failed; it can only be closed");
    return NORMA_DOCUMENT_OK;
}

norma_document_result norma_document_mesh_data(norma_document *document, size_t index, norma_mesh_data *data, norma_document_error *error) {
    norma_document_result result = check_usable(document, error);
    if (result)
        return result;
    norma_mesh_info info;
    size_t count = norma_document_mesh_count(document);
    if (!data || index >= count)
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL, "mesh %zu of %zu was asked for", index, count);
    *data = (norma_mesh_data){0};
    result = norma_document_mesh_info(document, index, &info);
    if (result)
        return norma_document_fail(document, error, result, NULL, "mesh %zu cannot be described", index);
    if (info.not_read)
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, info.where[0] ? info.where : NULL, "%s", info.not_read);
    return document->functions->mesh_data(document, index, data, error);
}

static const char *bad_compute_option(const norma_compute_options *options) {
    if ((unsigned)options->shading > NORMA_SHADING_FLAT)
        return "unknown shading";
    if (options->shading == NORMA_SHADING_CREASE && !(options->crease_angle_rad >= 0 && isfinite(options->crease_angle_rad)))
        return "the crease angle is no finite number from 0 up";
    if ((unsigned)options->weight > NORMA_WEIGHT_ANGLE_LENGTHS)
        return "unknown weight";
    if ((unsigned)options->weld > NORMA_WELD_DISTANCE)
        return "unknown way to weld";
    if (options->weld == NORMA_WELD_DISTANCE && !(options->weld_distance >= 0 && isfinite(options->weld_distance)))
        return "the weld distance is no finite number from 0 up";
    if ((unsigned)options->non_manifold > NORMA_NON_MANIFOLD_SMOOTH)
        return "unknown treatment of non-manifold edges";
    if ((unsigned)options->groups > NORMA_GROUPS_IGNORE)
        return "unknown treatment of smoothing groups";
    return (unsigned)options->only > NORMA_ONLY_BROKEN ? "unknown choice of what to compute" : NULL;
}

norma_document_result norma_document_compute(norma_document *document, const norma_compute_options *given, norma_compute_summary *summary,
                                             norma_document_error *error) {
    norma_document_result result = check_usable(document, error);
    if (result)
        return result;
    norma_compute_options options;
    norma_compute_summary unwanted;
    copy_options(&options, sizeof options, sizeof options, given);
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
        if (!isfinite(matrix[i]))
            return "the matrix holds a number that is not finite";
        all_zero &= matrix[i] == 0;
    }
    if (all_zero)
        matrix[0] = matrix[5] = matrix[10] = matrix[15] = 1;
    if (matrix[3] != 0 || matrix[7] != 0 || matrix[11] != 0 || matrix[15] != 1)
        return "the last row of the matrix is not 0 0 0 1; a perspective cannot be applied to a file";
    return NULL;
}

norma_document_result norma_document_transform(norma_document *document, const norma_transform_options *given, norma_transform_summary *summary,
                                               norma_document_error *error) {
    norma_document_result result = check_usable(document, error);
    if (result)
        return result;
    norma_transform_options options;
    norma_transform_summary unwanted;
    copy_options(&options, sizeof options, sizeof options, given);
    const char *bad = bad_matrix(options.matrix);
    if (bad)
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL, "%s", bad);
    summary = summary ? summary : &unwanted;
    *summary = (norma_transform_summary){0};
    result = document->functions->transform(document, &options, summary, error);
    document->failed = result != NORMA_DOCUMENT_OK;
    return result;
}

static norma_document_result recentre_whole(norma_document *document, int *changed, norma_document_error *error) {
    recentre_box box = norma_recentre_empty();
    norma_transform_options options = {.struct_size = sizeof options, .matrix = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}, .threads = document->threads};
    norma_transform_summary summary = {0};
    norma_mesh_data data;
    double step[3], position[3];
    norma_document_result result = norma_document_mesh_data(document, 0, &data, error);
    for (size_t i = 0; !result && i < data.mesh.positions.count; ++i) {
        norma_view_read(&data.mesh.positions, i, position);
        norma_recentre_add(&box, position);
    }
    if (result || !norma_recentre_step(&box, step))
        return result;
    for (int axis = 0; axis < 3; ++axis) options.matrix[12 + axis] = -step[axis];
    result = norma_document_transform(document, &options, &summary, error);
    *changed = !result && summary.changed;
    return result;
}

norma_document_result norma_document_recentre(norma_document *document, const uint8_t *meshes, int *changed, norma_document_error *error) {
    int unwanted;
    norma_document_result result = check_usable(document, error);
    changed = changed ? changed : &unwanted;
    *changed = 0;
    if (result)
        return result;
    if (!document->functions->recentre)
        return meshes && !meshes[0] ? NORMA_DOCUMENT_OK : recentre_whole(document, changed, error);
    result = document->functions->recentre(document, meshes, changed, error);
    document->failed = result != NORMA_DOCUMENT_OK;
    return result;
}

/* Every number in it, before anything is changed. */
static norma_document_result check_vertices(norma_document *document, size_t mesh, const norma_mesh_edit *edit, norma_document_error *error) {
    norma_mesh_data data;
    norma_document_result result = norma_document_mesh_data(document, mesh, &data, error);
    int fits = document->functions->equal_vertices && edit->new_corners && edit->vertex_count > 0 && edit->vertex_count < UINT32_MAX && !edit->strip_normals;
    if (result)
        return result;
    for (size_t v = 0; fits && v < edit->vertex_count; ++v)
        fits = edit->source_vertices[v] < data.mesh.positions.count;
    for (size_t c = 0; fits && c < data.mesh.corner_count; ++c)
        fits = edit->new_corners[c] < edit->vertex_count;
    return fits ? NORMA_DOCUMENT_OK : norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL, "mesh %zu cannot have the vertices that were given for it", mesh);
}

norma_document_result norma_document_edit(norma_document *document, const norma_mesh_edit *edits, norma_document_error *error) {
    norma_document_result result = check_usable(document, error);
    if (result)
        return result;
    if (!edits)
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL, "no edits were given");
    for (size_t i = 0; i < norma_document_mesh_count(document); ++i)
        if ((edits[i].set_normals && !edits[i].normals) || (edits[i].set_positions && !edits[i].positions) || (edits[i].set_tangents && !edits[i].tangents))
            return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL, "marks without numbers were given for mesh %zu", i);
    for (size_t i = 0; !result && i < norma_document_mesh_count(document); ++i)
        result = edits[i].source_vertices ? check_vertices(document, i, &edits[i], error) : NORMA_DOCUMENT_OK;
    if (result)
        return result;
    result = document->functions->edit(document, edits, error);
    document->failed = result != NORMA_DOCUMENT_OK;
    return result;
}

norma_document_result norma_document_equal_vertices(norma_document *document, size_t mesh, uint32_t *first, norma_document_error *error) {
    norma_mesh_info info;
    norma_document_result result = check_usable(document, error);
    if (result)
        return result;
    if (!first || norma_document_mesh_info(document, mesh, &info) || info.not_read || !document->functions->equal_vertices)
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL, "mesh %zu has no vertices that could be compared", mesh);
    return document->functions->equal_vertices(document, mesh, first, error);
}

/* ---- writing */

static int same_extension(const char *a, const char *b) {
    const char *of_a = strrchr(a, '.'), *of_b = strrchr(b, '.');
    return of_a && of_b && !strchr(of_a, '/') && strcmp(of_a, of_b) == 0;
}

/* A name must not promise another format than the bytes have; a source of a strange name that was opened with its format told may be written under that. */
static int name_fits(const norma_document *document, const char *path) {
    norma_file_format named = norma_file_format_of_path(path);
    return named == document->format || (named == NORMA_FILE_UNKNOWN && same_extension(path, document->path)) || norma_file_same(path, document->path) ||
           norma_file_is_stream(path);
}

static norma_document_result check_target(const norma_document *document, const char *path, int in_place, norma_document_error *error) {
    if (!path)
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL, "no path to write to was given");
    const norma_document target = {.path = (char *)(uintptr_t)path};
    if (!in_place && norma_file_same(path, document->path) && !norma_file_is_stream(path))
        return norma_document_fail(&target, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL,
                                   "is the input itself; expected another name, or to be told to work in place");
    if (!in_place && document->functions->reads_from && document->functions->reads_from(document, path))
        return norma_document_fail(&target, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL, "is one of the files that %s is read from; expected another name",
                                   document->path);
    if (!name_fits(document, path)) {
        const char *name = norma_file_format_name(document->format);
        return norma_document_fail(&target, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL,
                                   "%s is %s, and the output has its input's format; expected a name that ends in .%s", document->path, name, name);
    }
    return NORMA_DOCUMENT_OK;
}

typedef struct file_sink {
    const norma_document *document;
    file_writer *writer;
    uint64_t written;
    int error, cancelled;
} file_sink;

/* In slices, so that a cancel is noticed also where a format hands over a gigabyte at once. */
static int write_to_file(void *user, const void *bytes, size_t size) {
    const size_t slice = (size_t)1 << 23;
    file_sink *sink = user;
    const norma_document *document = sink->document;
    for (const unsigned char *at = bytes; size > 0 && !sink->error;) {
        size_t part = size < slice ? size : slice;
        double fraction = document->source.size ? (double)(sink->written + part) / (double)document->source.size : 1;
        sink->cancelled = document->progress && document->progress(document->progress_user, fraction < 1 ? fraction : 1);
        if (sink->cancelled)
            return 1;
        sink->error = norma_file_writer_write(sink->writer, at, part);
        sink->written += part;
        at += part;
        size -= part;
    }
    return sink->error;
}

int norma_document_add_writer(companion_writers *writers, file_writer *writer, const char *path) {
    file_writer **list = norma_io_grow(writers->list, &writers->list_capacity, writers->count + 1, sizeof *list);
    writers->list = list ? list : writers->list;
    char **paths = list ? norma_io_grow(writers->paths, &writers->path_capacity, writers->count + 1, sizeof *paths) : NULL, *copy = paths ? copy_text(path, strlen(path)) : NULL;
    writers->paths = paths ? paths : writers->paths;
    if (!copy) {
        norma_file_writer_abandon(writer);
        return 0;
    }
    list[writers->count] = writer;
    paths[writers->count++] = copy;
    return 1;
}

static void free_writers(companion_writers *writers, int abandon) {
    for (size_t i = 0; i < writers->count; ++i) {
        if (abandon)
            norma_file_writer_abandon(writers->list[i]);
        free(writers->paths[i]);
    }
    free(writers->list);
    free(writers->paths);
}

/* Everything that can fail for want of room or by the format happens before the first rename. */
static norma_document_result write_target(norma_document *document, const char *path, int in_place, file_writer *writer, companion_writers *companions,
                                          norma_document_error *error) {
    file_sink sink = {.document = document, .writer = writer};
    int stream = norma_file_is_stream(path);
    norma_document_result result = document->functions->write(document, stream ? NULL : path, write_to_file, &sink, error);
    if (sink.cancelled)
        return norma_document_fail(document, error, NORMA_DOCUMENT_CANCELLED, NULL, "cancelled");
    if (!sink.error && !result)
        sink.error = norma_file_writer_prepare(writer);
    if (sink.error && sink.error != FILE_CHANGED)
        return norma_document_fail_file(path, error, "cannot be written", sink.error);
    if (!result && !stream && document->functions->write_companions)
        result = document->functions->write_companions(document, path, in_place, companions, error);
    /* After all of it is read for the last time; what went wrong before may come of it. */
    if (changed_since_read(document, error))
        return NORMA_DOCUMENT_ERROR_FILE;
    return sink.error ? norma_document_fail_file(document->path, error, "cannot be read", sink.error) : result;
}

static norma_document_result save(norma_document *document, const char *path, const norma_save_options *options, companion_writers *writers, norma_document_error *error) {
    file_writer *writer;
    size_t at;
    int failed = norma_file_writer_open(path, &writer);
    if (failed)
        return norma_document_fail_file(path, error, "cannot be written", failed);
    if (options->in_place && norma_file_same(path, document->path))
        norma_file_writer_expect(writer, &document->stamp);
    document->progress = options->progress;
    document->progress_user = options->progress_user;
    norma_document_result result = write_target(document, path, options->in_place, writer, writers, error);
    document->progress = NULL;
    if (result) {
        norma_file_writer_abandon(writer);
        return result;
    }
    if (!norma_document_add_writer(writers, writer, path))
        return norma_document_fail_memory(document, error);
    failed = norma_file_writers_commit(writers->list, writers->count, &at);
    if (failed)
        norma_document_fail_file(writers->paths[at], error, "cannot be written", failed);
    for (size_t i = 0; i < writers->count; ++i) writers->list[i] = NULL;
    return !failed ? NORMA_DOCUMENT_OK : failed == ENOMEM ? NORMA_DOCUMENT_ERROR_MEMORY : NORMA_DOCUMENT_ERROR_FILE;
}

norma_document_result norma_document_save(norma_document *document, const char *path, const norma_save_options *given, norma_document_error *error) {
    norma_document_result result = check_usable(document, error);
    norma_save_options options;
    copy_options(&options, sizeof options, sizeof options, given);
    if (!result)
        result = check_target(document, path, options.in_place, error);
    if (result)
        return result;
    companion_writers writers = {0};
    result = save(document, path, &options, &writers, error);
    free_writers(&writers, result != NORMA_DOCUMENT_OK);
    return result;
}

norma_document_result norma_document_write(norma_document *document, norma_write *write, void *user, norma_document_error *error) {
    norma_document_result result = check_usable(document, error);
    if (result)
        return result;
    if (!write)
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL, "no function to write with was given");
    result = document->functions->write(document, NULL, write, user, error);
    return changed_since_read(document, error) ? NORMA_DOCUMENT_ERROR_FILE : result;
}
