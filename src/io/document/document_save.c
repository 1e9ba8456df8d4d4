/* document_save.c: a document, or any bytes, written to a path, whole or not at all. */
#include "io/format/format.h"
#include <errno.h>
#include <stdlib.h>
#include <string.h>

/* ---- Bytes of no format in particular, written as documents are: whole or not at all. */

struct norma_saving {
    file_writer *writer;
    char path[]; /* for messages */
};

static norma_document_result fail_save_bytes(
    const char *path, norma_document_error *error, int failed) {
    return norma_document_fail_file(path, error, "cannot be written", failed);
}

norma_document_result norma_save_begin(
    const char *path, norma_saving **saving, norma_document_error *error) {
    norma_document_clear(error);
    if (saving) *saving = NULL;
    if (!path || !saving)
        return norma_document_fail(NULL, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL,
            "no path or no place for the result was given");
    const size_t size = strlen(path) + 1;
    norma_saving *made = malloc(sizeof *made + size);
    if (!made) return norma_document_fail_memory(NULL, error);
    memcpy(made->path, path, size);
    const int failed = norma_file_writer_open(path, &made->writer);
    if (failed) {
        free(made);
        return fail_save_bytes(path, error, failed);
    }
    *saving = made;
    return NORMA_DOCUMENT_OK;
}

norma_document_result norma_save_piece(
    norma_saving *saving, const void *bytes, size_t size, norma_document_error *error) {
    norma_document_clear(error);
    if (!saving || (!bytes && size))
        return norma_document_fail(
            NULL, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL, "no file or no bytes were given");
    const int failed = norma_file_writer_write(saving->writer, bytes, size);
    return failed ? fail_save_bytes(saving->path, error, failed) : NORMA_DOCUMENT_OK;
}

const char *norma_save_temporary(const norma_saving *saving) {
    return saving ? norma_file_writer_temporary(saving->writer) : NULL;
}

norma_document_result norma_save_end_together(
    norma_saving **savings, size_t count, norma_document_error *error) {
    size_t at = 0;
    norma_document_clear(error);
    for (size_t i = 0; i < count; ++i)
        if (!savings || !savings[i])
            return norma_document_fail(
                NULL, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL, "no file was given");
    file_writer **writers = norma_io_allocate(count, sizeof *writers);
    for (size_t i = 0; i < count && writers; ++i) {
        writers[i] = savings[i]->writer;
        if (count > 1) norma_file_writer_batch(writers[i], 1);
    }
    const int failed = !writers ? ENOMEM
                       : count  ? norma_file_writers_commit(writers, count, &at)
                                : 0;
    const norma_document_result result =
        failed ? fail_save_bytes(savings[at]->path, error, failed) : NORMA_DOCUMENT_OK;
    for (size_t i = 0; i < count; ++i) {
        if (!writers) norma_file_writer_abandon(savings[i]->writer);
        free(savings[i]);
    }
    free(writers);
    return result;
}

norma_document_result norma_save_end(norma_saving *saving, norma_document_error *error) {
    return norma_save_end_together(&saving, 1, error);
}

void norma_save_abandon(norma_saving *saving) {
    if (!saving) return;
    norma_file_writer_abandon(saving->writer);
    free(saving);
}

norma_document_result norma_save_bytes(
    const char *path, const void *bytes, size_t size, norma_document_error *error) {
    norma_saving *saving;
    norma_document_clear(error);
    if (!path || (!bytes && size))
        return norma_document_fail(
            NULL, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL, "no path or no bytes were given");
    norma_document_result result = norma_save_begin(path, &saving, error);
    if (!result) result = norma_save_piece(saving, bytes, size, error);
    if (!result) return norma_save_end(saving, error);
    norma_save_abandon(saving);
    return result;
}

/* ---- Documents on their way out: where one may be written, its files whole or not at
 * all. */

static int same_extension(const char *a, const char *b) {
    const char *of_a = strrchr(a, '.'), *of_b = strrchr(b, '.');
    return of_a && of_b && !strchr(of_a, '/') && strcmp(of_a, of_b) == 0;
}

/* A name must not promise another format than the bytes have; a source of a strange name that was
 * opened with its format told may be written under that. */
static int name_fits(const norma_document *document, const char *path) {
    norma_file_format named = norma_file_format_of_path(path);
    return named == document->format ||
           (named == NORMA_FILE_UNKNOWN && same_extension(path, document->path)) ||
           norma_file_same(path, document->path) || norma_file_is_stream(path);
}

norma_document_result norma_document_check_target(
    const norma_document *document, const char *path, int in_place, norma_document_error *error) {
    if (!path)
        return norma_document_fail(
            document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL, "no path to write to was given");
    const norma_document target = {.path = (char *)(uintptr_t)path};
    if (!in_place && norma_file_same(path, document->path) && !norma_file_is_stream(path))
        return norma_document_fail(&target, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL,
            "is the input itself; give another name, or work in place");
    if (!in_place && norma_document_names_file(document, path))
        return norma_document_fail(&target, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL,
            "is used by %s; give another name", document->path);
    if (!name_fits(document, path)) {
        const char *name = norma_file_format_name(document->format);
        return norma_document_fail(&target, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL,
            "%s is %s, and the output has its input's format; give a name that ends in .%s",
            document->path, name, name);
    }
    return NORMA_DOCUMENT_OK;
}

typedef struct file_sink {
    const norma_document *document;
    file_writer *writer;
    uint64_t written;
    int error;
} file_sink;

/* In slices, so that a cancel is noticed also where a format hands over a gigabyte at once. */
static int write_to_file(void *user, const void *bytes, size_t size) {
    const size_t slice = (size_t)1 << 23;
    file_sink *sink = user;
    const norma_document *document = sink->document;
    norma_watch *watch = norma_document_watch(document);
    for (const unsigned char *at = bytes; size > 0 && !sink->error;) {
        size_t part = size < slice ? size : slice;
        double fraction = document->source.size
                              ? (double)(sink->written + part) / (double)document->source.size
                              : 1;
        if (norma_watch_tell(watch, fraction < 1 ? fraction : 1)) return 1;
        sink->error = norma_file_writer_write(sink->writer, at, part);
        sink->written += part;
        at += part;
        size -= part;
    }
    return sink->error;
}

/* Everything that can fail for want of room or by the format happens before the first rename. */
static norma_document_result write_target(norma_document *document, const char *path, int in_place,
    file_writer *writer, companion_writers *companions, norma_document_error *error) {
    file_sink sink = {.document = document, .writer = writer};
    int stream = norma_file_is_stream(path);
    norma_document_result result =
        document->functions->write(document, stream ? NULL : path, write_to_file, &sink, error);
    if (norma_watch_cancelled(&document->watch)) return NORMA_DOCUMENT_CANCELLED;
    if (!sink.error && !result) sink.error = norma_file_writer_prepare(writer);
    if (sink.error && sink.error != FILE_CHANGED)
        return norma_document_fail_file(path, error, "cannot be written", sink.error);
    if (!result && !stream && document->functions->write_companions)
        result = document->functions->write_companions(document, path, in_place, companions, error);
    companions->size += sink.written;
    /* After all of it is read for the last time; what went wrong before may come of it. */
    if (norma_document_changed(document, error)) return NORMA_DOCUMENT_ERROR_FILE;
    return sink.error
               ? norma_document_fail_file(document->path, error, "cannot be read", sink.error)
               : result;
}

norma_document_result norma_document_prepare(norma_document *document, const char *path,
    const norma_save_options *options, companion_writers *writers, norma_document_error *error) {
    file_writer *writer;
    const int failed = norma_file_writer_open(path, &writer);
    if (failed) return norma_document_fail_file(path, error, "cannot be written", failed);
    if (options->in_place && norma_file_same(path, document->path))
        norma_document_expect(writers, writer, &document->stamp);
    norma_watch_begin(&document->watch, options->progress, options->progress_user);
    const size_t before = writers->count;
    if (writers->outlive) norma_file_writer_batch(writer, 0);
    norma_document_result result =
        write_target(document, path, options->in_place, writer, writers, error);
    if (norma_watch_end(&document->watch)) result = norma_document_fail_cancelled(document, error);
    if (result) {
        norma_file_writer_abandon(writer);
        return result;
    }
    if (writers->outlive) norma_file_writer_batch(writer, writers->count == before);
    return norma_document_add_writer(writers, writer, path)
               ? NORMA_DOCUMENT_OK
               : norma_document_fail_memory(document, error);
}

static norma_document_result save_document(norma_document *document, const char *path,
    const norma_save_options *options, companion_writers *writers, norma_document_error *error) {
    norma_document_result result = norma_document_prepare(document, path, options, writers, error);
    if (!result) result = norma_document_commit(writers, error);
    document->replaced |= !result && options->in_place && norma_file_same(path, document->path);
    return result;
}

norma_document_result norma_document_save(norma_document *document, const char *path,
    const norma_save_options *given, norma_document_error *error) {
    norma_document_result result = norma_document_usable(document, error);
    norma_save_options options;
    norma_document_copy_options(
        &options, sizeof options, offsetof(norma_save_options, size), given);
    if (!result) result = norma_document_check_target(document, path, options.in_place, error);
    if (result) return result;
    companion_writers writers = {0};
    result = save_document(document, path, &options, &writers, error);
    if (!result && options.size) *options.size = writers.size;
    norma_document_free_writers(&writers, result != NORMA_DOCUMENT_OK);
    return result;
}

norma_document_result norma_document_write(
    norma_document *document, norma_write *write, void *user, norma_document_error *error) {
    norma_document_result result = norma_document_usable(document, error);
    if (result) return result;
    if (!write)
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL,
            "no function to write with was given");
    result = document->functions->write(document, NULL, write, user, error);
    return norma_document_changed(document, error) ? NORMA_DOCUMENT_ERROR_FILE : result;
}
