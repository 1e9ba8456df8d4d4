/* save_bytes.c: bytes of no format in particular, written as documents are: whole or not at all. */
#include "io/format/format.h"

norma_document_result norma_save_bytes(
    const char *path, const void *bytes, size_t size, norma_document_error *error) {
    file_writer *writer;
    if (error) *error = (norma_document_error){0};
    if (!path || (!bytes && size))
        return norma_document_fail(
            NULL, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL, "no path or no bytes were given");
    int failed = norma_file_writer_open(path, &writer);
    if (!failed) {
        failed = norma_file_writer_write(writer, bytes, size);
        if (failed)
            norma_file_writer_abandon(writer);
        else
            failed = norma_file_writer_commit(writer);
    }
    return failed ? norma_document_fail_file(path, error, "cannot be written", failed)
                  : NORMA_DOCUMENT_OK;
}
