/* save_bytes.c: bytes of no format in particular, written as documents are: whole or not at all. */
#include "io/format/format.h"
#include <stdlib.h>
#include <string.h>

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

norma_document_result norma_save_end(norma_saving *saving, norma_document_error *error) {
    norma_document_clear(error);
    if (!saving)
        return norma_document_fail(
            NULL, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL, "no file was given");
    const int failed = norma_file_writer_commit(saving->writer);
    const norma_document_result result =
        failed ? fail_save_bytes(saving->path, error, failed) : NORMA_DOCUMENT_OK;
    free(saving);
    return result;
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
