/* open.c: documents opened from files and from memory, by the functions of their format. */
#include "io/format/format.h"
#include <stddef.h>

static const format_functions *format_functions_of(norma_file_format format) {
    switch (format) {
    case NORMA_FILE_OBJ:
        return &norma_obj_functions;
    case NORMA_FILE_PLY:
        return &norma_ply_functions;
    case NORMA_FILE_STL:
        return &norma_stl_functions;
    case NORMA_FILE_GLTF:
    case NORMA_FILE_GLB:
    case NORMA_FILE_B3DM:
    case NORMA_FILE_I3DM:
        return &norma_gltf_functions;
    case NORMA_FILE_CMPT:
        return &norma_composite_functions;
    case NORMA_FILE_3MF:
        return &norma_3mf_functions;
    default:
        return NULL;
    }
}

/* missing: what should have been given; NULL: nothing. */
static norma_document_result open_with(const char *missing, const char *name, int has_folder,
    const file_bytes *memory, const norma_document_options *given, norma_document **document,
    norma_document_error *error) {
    norma_document_options options;
    norma_document_clear(error);
    if (!document) missing = "no place for the document was given";
    if (document) *document = NULL;
    if (missing)
        return norma_document_fail(NULL, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL, "%s", missing);
    norma_document_copy_options(
        &options, sizeof options, offsetof(norma_document_options, lenient), given);
    norma_document *made = norma_document_make(name, has_folder, &options);
    if (!made) return norma_document_fail_memory(NULL, error);
    made->functions = format_functions_of(made->format);
    norma_document_result result = NORMA_DOCUMENT_OK;
    if (memory) {
        made->source = *memory;
    } else {
        const file_reading how = {
            .map_large = !made->copied && options.depth != NORMA_DOCUMENT_WHOLE,
            .progress = norma_watch_tell,
            .progress_user = &made->watch};
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

norma_document_result norma_document_open(const char *path, const norma_document_options *options,
    norma_document **document, norma_document_error *error) {
    return open_with(path ? NULL : "no path was given", path, 1, NULL, options, document, error);
}

norma_document_result norma_document_open_memory(const void *bytes, size_t size, const char *name,
    const norma_document_options *options, norma_document **document, norma_document_error *error) {
    const char *missing = !bytes && size ? "no bytes were given" : NULL;
    const file_bytes source = {.data = bytes ? bytes : (const void *)"", .size = size};
    return open_with(
        missing, name ? name : "<memory>", name != NULL, &source, options, document, error);
}
