/* document_life.c: documents made, read by the functions of their format, closed, and copied to
 * try changes on. */
#include "io/format/format.h"
#include "io/stream/stream.h"
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* ---- The files that a document was read from or names, beside its own: buffers, images,
 * material libraries. A program that writes somewhere asks for them, so that no source is
 * overwritten; none of them is opened here. */

norma_document_result norma_document_visit_files(
    norma_document *document, norma_visit_file *visit, void *user, norma_document_error *error) {
    const int is_summary = document && document->depth == NORMA_DOCUMENT_SUMMARY;
    norma_document_clear(error);
    norma_document_result result =
        is_summary ? NORMA_DOCUMENT_OK : norma_document_usable(document, error);
    if (result) return result;
    if (!visit)
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL,
            "no function that receives the files was given");
    if (!document->folder || !document->functions->visit_files) return NORMA_DOCUMENT_OK;
    const int stopped = document->functions->visit_files(document, visit, user);
    return stopped < 0 ? norma_document_fail_memory(document, error) : NORMA_DOCUMENT_OK;
}

typedef struct search {
    const char *path;
    int found;
} search;

static int compare_file(void *user, const char *path) {
    search *s = user;
    s->found = norma_file_same(path, s->path);
    return s->found;
}

int norma_document_names_file(const norma_document *document, const char *path) {
    search s = {.path = path};
    struct stat status;
    /* Most outputs do not exist yet, and then they are nobody's source. */
    if (document->folder && document->functions->visit_files && stat(path, &status) == 0)
        document->functions->visit_files(document, compare_file, &s);
    return s.found;
}

/* ---- Documents opened, read by the functions of their format, and closed. */

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
    norma_watch_begin(&document->watch, options->progress, options->progress_user);
    document->lenient = options->lenient;
    document->copied = options->copied;
    document->scene = norma_io_allocate(1, sizeof *document->scene);
    if (document->scene && document->path && (document->folder || !has_folder)) return document;
    norma_document_close(document);
    return NULL;
}

norma_document_result norma_document_read(norma_document *document, norma_document_error *error) {
    if (!document->functions)
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, NULL,
            "unknown kind of file; the name should end in .obj, .ply, .stl, .gltf, .glb, .vrm, "
            ".b3dm, "
            ".i3dm, .cmpt or .3mf, or the format must be given");
    norma_document_result result = NORMA_DOCUMENT_OK;
    if (!norma_watch_cancelled(&document->watch))
        result = document->functions->open(document, error);
    /* What was found where it stopped means nothing. */
    return norma_watch_end(&document->watch) ? norma_document_fail_cancelled(document, error)
                                             : result;
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

/* ---- the models of a composite tile */

norma_document *norma_document_tile(norma_document *document, size_t index) {
    if (!document || !document->tiles) return index == 0 ? document : NULL;
    return index < document->tile_count ? document->tiles[index] : NULL;
}

void norma_document_clear(norma_document_error *error) {
    if (error) {
        error->result = NORMA_DOCUMENT_OK;
        error->message[0] = '\0';
    }
}

void norma_document_close(norma_document *document) {
    if (!document) return;
    if (document->functions) document->functions->close(document);
    for (size_t i = 0; document->tiles && i < document->tile_count; ++i)
        norma_document_close(document->tiles[i]);
    free(document->tiles);
    norma_scene_forget(document->scene);
    free(document->scene);
    for (size_t i = 0; i < document->note_count; ++i) free(document->notes[i]);
    free(document->notes);
    norma_file_close(&document->source);
    for (size_t i = 0; document->given && i < document->given_count; ++i)
        free(document->given[i].bytes);
    free(document->given);
    norma_document_forget_images(document);
    free(document->path);
    free(document->folder);
    free(document);
}

norma_document_result norma_document_usable(
    const norma_document *document, norma_document_error *error) {
    norma_document_clear(error);
    if (!document)
        return norma_document_fail(
            NULL, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL, "no document was given");
    if (document->depth != NORMA_DOCUMENT_WHOLE)
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL,
            "was opened as a summary; open it whole");
    if (document->failed)
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL,
            "an earlier change of it failed; it can only be closed");
    return NORMA_DOCUMENT_OK;
}

/* ---- A document to try changes on. */

norma_document_result norma_document_copy(
    norma_document *document, norma_document **copy, norma_document_error *error) {
    growing_bytes memory = {0};
    const norma_document_options options = {.struct_size = sizeof options,
        .format = document->format,
        .threads = document->threads,
        .lenient = 1};
    *copy = NULL;
    norma_document_result result =
        document->functions->write(document, NULL, norma_memory_sink_write, &memory, error);
    norma_document *made =
        result ? NULL : norma_document_make(document->path, document->folder != NULL, &options);
    if (!made) {
        free(memory.data);
        return result && result != NORMA_DOCUMENT_ERROR_FILE
                   ? result
                   : norma_document_fail_memory(document, error);
    }
    made->functions = document->functions;
    made->source = (file_bytes){.data = (const void *)memory.data, .size = memory.size, .owned = 1};
    result = norma_document_read(made, error);
    if (result)
        norma_document_close(made);
    else
        *copy = made;
    return result;
}
