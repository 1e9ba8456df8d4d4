/* large.c: the public calls for files larger than memory. */
#include "io/large/passes.h"
#include "io/large/ply_body.h"
#include "io/stl/stl.h"

enum { FIRST_VERSION = sizeof(norma_large_options) };
static const uint64_t USUAL_MEMORY = (uint64_t)1 << 29, MEMORY_FOR_THREADS = (uint64_t)1 << 26;

/* ---- options */

norma_large_options norma_large_options_of(const norma_large_options *given) {
    norma_large_options options;
    norma_document_copy_options(&options, sizeof options, FIRST_VERSION, given);
    if (!options.max_memory) options.max_memory = USUAL_MEMORY;
    return options;
}

static norma_file_format format_of(const char *path, norma_file_format format) {
    return format ? format : norma_file_format_of_path(path);
}

static norma_document_result fail_argument(norma_document_error *error, const char *what) {
    return norma_document_fail(NULL, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL, "%s", what);
}

norma_document_result norma_large_fail_format(const char *path, norma_document_error *error) {
    const norma_document named = {.path = (char *)(uintptr_t)path};
    return norma_document_fail(&named, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, NULL,
        "only PLY and STL can be read in passes; allow more memory");
}

/* ---- the calls */

norma_document_result norma_large_compute(const char *input, const char *output,
    const norma_large_options *given, const norma_compute_options *compute,
    norma_compute_summary *summary, norma_document_error *error) {
    const norma_large_options options = norma_large_options_of(given);
    norma_compute_options chosen;
    norma_compute_summary unwanted;
    large_file file;
    norma_document_clear(error);
    if (!input || !output) return fail_argument(error, "no path was given");
    const norma_file_format format = format_of(input, options.format);
    if (format != NORMA_FILE_PLY && format != NORMA_FILE_STL)
        return norma_large_fail_format(input, error);
    norma_document_copy_options(
        &chosen, sizeof chosen, offsetof(norma_compute_options, tangents), compute);
    /* Each thread takes megabytes for its stack. */
    if (options.max_memory < MEMORY_FOR_THREADS) chosen.threads = 1;
    const char *bad = norma_document_bad_compute_option(&chosen);
    if (bad) return fail_argument(error, bad);
    summary = summary ? summary : &unwanted;
    *summary = (norma_compute_summary){0};
    large_compute job = {.file = &file, .output = output, .options = &options};
    norma_document_result result = norma_large_open(input, &options, format, &file, error);
    file.progress = chosen.progress;
    file.progress_user = chosen.progress_user;
    if (file.document) file.document->threads = chosen.threads;
    const int is_stl = format == NORMA_FILE_STL;
    job.policy =
        norma_policy_begin(&chosen, summary, is_stl ? NORMA_SHADING_FLAT : NORMA_SHADING_SMOOTH, 0);
    if (!result) result = is_stl ? norma_large_compute_stl(&job) : norma_large_compute_ply(&job);
    norma_large_close(&file);
    return result;
}

norma_document_result norma_large_describe(const char *path, const norma_large_options *given,
    norma_progress *progress, void *progress_user, norma_large_description *description,
    norma_document_error *error) {
    const norma_large_options options = norma_large_options_of(given);
    large_file file;
    norma_document_clear(error);
    if (!path || !description) return fail_argument(error, "no path or no place was given");
    *description =
        (norma_large_description){.format = format_of(path, options.format), .encoding = ""};
    if (description->format != NORMA_FILE_PLY && description->format != NORMA_FILE_STL)
        return norma_large_fail_format(path, error);
    norma_document_result result =
        norma_large_open(path, &options, description->format, &file, error);
    file.progress = progress;
    file.progress_user = progress_user;
    if (!result)
        result = description->format == NORMA_FILE_STL
                     ? norma_large_describe_stl(&file, description)
                     : norma_large_describe_ply(&file, description);
    if (!result && norma_window_has_changed(file.window))
        result = norma_large_fail_read(&file, FILE_CHANGED);
    norma_large_close(&file);
    return result;
}

/* ---- what a whole file takes */

/* The file, corners, the core's sums and map, normals and reasons; and what is decoded. */
static uint64_t need_of_ply(large_file *file, int *possible) {
    large_ply ply;
    uint64_t bytes = file->size;
    *possible = norma_large_ply_open(file, &ply) == NORMA_DOCUMENT_OK;
    if (*possible) {
        const uint64_t decoded =
            (ply.plain_floats ? 0U : 24U) + (ply.state->header.normal[0] == PLY_NONE ? 0U : 24U);
        bytes += ply.faces * 12 + ply.vertices * (56 + 13 + decoded);
    }
    norma_large_ply_close(&ply);
    return bytes;
}

static uint64_t need_of_stl(large_file *file, int *possible) {
    stl_state state = {.bytes = file->document->source.data, .size = (size_t)file->size};
    *possible = file->size >= STL_HEADER && norma_stl_is_binary(&state);
    return *possible ? file->size + file->size / 50 : 2 * file->size;
}

int norma_large_need(const char *path, norma_file_format format, uint64_t *bytes) {
    const norma_large_options options = {.max_memory = (uint64_t)1 << 26};
    norma_document_error error;
    large_file file;
    int possible = 0;
    uint64_t need = 0;
    format = path ? format_of(path, format) : NORMA_FILE_UNKNOWN;
    if (format == NORMA_FILE_PLY || format == NORMA_FILE_STL) {
        if (norma_large_open(path, &options, format, &file, &error) == NORMA_DOCUMENT_OK)
            need = format == NORMA_FILE_STL ? need_of_stl(&file, &possible)
                                            : need_of_ply(&file, &possible);
        norma_large_close(&file);
    }
    if (bytes) *bytes = need;
    return possible;
}
