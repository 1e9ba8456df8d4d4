/* output.c: what a large file becomes: written whole to a temporary file, changed there where a
 * normal is known only in the end, and put in its place as every output is. */
#include "io/large/output.h"

norma_document_result norma_large_output_open(
    large_file *file, const char *path, const norma_large_options *options, large_output *output) {
    *output = (large_output){.file = file, .path = path};
    norma_document_result result =
        norma_document_check_target(file->document, path, options->in_place, file->error);
    if (!result && norma_file_is_stream(path))
        result =
            norma_document_fail(file->document, file->error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, NULL,
                "does not fit into the memory allowed, and a device or a pipe cannot be written "
                "in passes; give the name of a file");
    if (result) return result;
    const int failed = norma_file_writer_open(path, &output->writer);
    if (failed) return norma_document_fail_file(path, file->error, "cannot be written", failed);
    if (options->in_place && norma_file_same(path, file->document->path))
        norma_file_writer_expect(output->writer, &file->document->stamp);
    return NORMA_DOCUMENT_OK;
}

int norma_large_output_write(void *user, const void *bytes, size_t size) {
    large_output *output = user;
    if (!output->error) output->error = norma_file_writer_write(output->writer, bytes, size);
    output->written += size;
    return output->error;
}

static norma_document_result fail_write(large_output *output, int error) {
    return norma_document_fail_file(output->path, output->file->error, "cannot be written", error);
}

norma_document_result norma_large_output_result(large_output *output) {
    return output->error ? fail_write(output, output->error) : NORMA_DOCUMENT_OK;
}

norma_document_result norma_large_output_copy(large_output *output, uint64_t begin, uint64_t end) {
    large_file *file = output->file;
    unsigned char *buffer = norma_large_take(&file->budget, SMALL_BUFFER, 1);
    norma_document_result result = buffer ? NORMA_DOCUMENT_OK : norma_large_fail_memory(file);
    for (uint64_t at = begin; at < end && !result;) {
        const size_t size = end - at < SMALL_BUFFER ? (size_t)(end - at) : SMALL_BUFFER;
        result = norma_large_read(file, at, buffer, size);
        if (!result) {
            norma_large_output_write(output, buffer, size);
            result = norma_large_output_result(output);
        }
        at += size;
        if (!result) result = norma_large_tell(file, (double)(at - begin) / (double)(end - begin));
    }
    norma_large_give(&file->budget, buffer, SMALL_BUFFER, 1);
    return result;
}

norma_document_result norma_large_output_read(
    large_output *output, uint64_t offset, void *bytes, size_t size) {
    const int error = norma_file_writer_read(output->writer, offset, bytes, size);
    return error ? fail_write(output, error) : NORMA_DOCUMENT_OK;
}

norma_document_result norma_large_output_patch(
    large_output *output, uint64_t offset, const void *bytes, size_t size) {
    const int error = norma_file_writer_patch(output->writer, offset, bytes, size);
    return error ? fail_write(output, error) : NORMA_DOCUMENT_OK;
}

norma_document_result norma_large_output_close(
    large_output *output, norma_document_result result, uint64_t *size) {
    large_file *file = output->file;
    if (!output->writer) return result;
    int failed = result ? 0 : norma_file_writer_prepare(output->writer);
    if (failed) result = fail_write(output, failed);
    if (result != NORMA_DOCUMENT_CANCELLED && result != NORMA_DOCUMENT_ERROR_MEMORY &&
        norma_window_has_changed(file->window))
        result = norma_large_fail_read(file, FILE_CHANGED);
    if (result) {
        norma_file_writer_abandon(output->writer);
        return result;
    }
    failed = norma_file_writer_commit(output->writer);
    if (failed) return fail_write(output, failed);
    if (size) *size = output->written;
    return NORMA_DOCUMENT_OK;
}
