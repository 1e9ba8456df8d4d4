/* large_file.c: a file that is read through a window, in order or by place. */
#include "io/large/large_file.h"
#include <stdlib.h>
#include <string.h>

static const size_t MOST_HEADER = (size_t)1 << 19;

static norma_document_result read_beginning(large_file *file) {
    const size_t size = file->size < MOST_HEADER ? (size_t)file->size : MOST_HEADER;
    unsigned char *bytes = malloc(size ? size : 1);
    if (!bytes) return norma_large_fail_memory(file);
    file->document->source = (file_bytes){.data = bytes, .size = size, .owned = 1};
    return norma_large_read(file, 0, bytes, size);
}

static norma_document_result make_document(
    const char *path, norma_file_format format, large_file *file) {
    const norma_document_options opening = {.struct_size = sizeof opening, .format = format};
    file->document = norma_document_make(path, 1, &opening);
    return file->document ? NORMA_DOCUMENT_OK : norma_document_fail_memory(NULL, file->error);
}

static int read_window(void *window, uint64_t offset, void *bytes, size_t size) {
    return norma_window_read(window, offset, bytes, size);
}

norma_document_result norma_large_open(const char *path, const norma_large_options *options,
    norma_file_format format, large_file *file, norma_document_error *error) {
    *file = (large_file){.error = error, .budget = {.most = options->max_memory}, .to = 1};
    const norma_document_result result = make_document(path, format, file);
    if (result) return result;
    const int failed = norma_window_open(path, &file->window);
    if (failed) return norma_large_fail_read(file, failed);
    file->document->stamp = *norma_window_stamp(file->window);
    file->size = file->document->stamp.size;
    file->source = (large_source){read_window, file->window, file->size,
        "does not fit into the memory allowed", "allow more memory"};
    return read_beginning(file);
}

norma_document_result norma_large_open_source(
    const char *path, norma_file_format format, const large_source *source, large_file *file) {
    const norma_document_result result = make_document(path, format, file);
    file->source = *source;
    file->size = source->size;
    return result ? result : read_beginning(file);
}

void norma_large_close(large_file *file) {
    norma_window_close(file->window);
    norma_document_close(file->document);
    *file = (large_file){0};
}

norma_document_result norma_large_fail_memory(large_file *file) {
    return norma_document_fail(file->document, file->error, NORMA_DOCUMENT_ERROR_MEMORY, NULL,
        "out of memory, even in the smallest parts; allow more memory");
}

norma_document_result norma_large_fail_read(large_file *file, int system_error) {
    return norma_document_fail_file(
        file->document->path, file->error, "cannot be read", system_error);
}

norma_document_result norma_large_read(
    large_file *file, uint64_t offset, void *bytes, size_t size) {
    const int failed = file->source.read(file->source.user, offset, bytes, size);
    return failed ? norma_large_fail_read(file, failed) : NORMA_DOCUMENT_OK;
}

void norma_large_stage(large_file *file, double from, double to) {
    file->from = from;
    file->to = to;
}

norma_document_result norma_large_tell(large_file *file, double fraction) {
    const double done = file->from + (file->to - file->from) * fraction;
    if (!file->progress || !file->progress(file->progress_user, done < 1 ? done : 1))
        return NORMA_DOCUMENT_OK;
    return norma_document_fail(
        file->document, file->error, NORMA_DOCUMENT_CANCELLED, NULL, "cancelled");
}

/* ---- rows */

int norma_large_reader_open(large_file *file, large_reader *reader) {
    const uint64_t plenty = 16 * (uint64_t)LARGE_BUFFER;
    *reader = (large_reader){.file = file};
    reader->capacity = file->budget.most < plenty ? SMALL_BUFFER : LARGE_BUFFER;
    reader->buffer = norma_large_take(&file->budget, reader->capacity, 1);
    return reader->buffer != NULL;
}

void norma_large_reader_close(large_reader *reader) {
    norma_large_give(&reader->file->budget, reader->buffer, reader->capacity, 1);
    reader->buffer = NULL;
}

void norma_large_reader_seek(large_reader *reader, uint64_t offset) {
    if (offset >= reader->offset && offset - reader->offset <= reader->filled) {
        reader->at = (size_t)(offset - reader->offset);
        return;
    }
    reader->offset = offset;
    reader->filled = reader->at = 0;
}

const unsigned char *norma_large_peek(large_reader *reader, size_t size) {
    if (reader->filled - reader->at >= size) return reader->buffer + reader->at;
    const uint64_t end = reader->offset + reader->filled, left = reader->file->size - end;
    if (reader->result || size > reader->capacity || size > reader->filled - reader->at + left)
        return NULL;
    memmove(reader->buffer, reader->buffer + reader->at, reader->filled - reader->at);
    reader->offset += reader->at;
    reader->filled -= reader->at;
    reader->at = 0;
    const size_t room = reader->capacity - reader->filled, more = left < room ? (size_t)left : room;
    reader->result = norma_large_read(reader->file, end, reader->buffer + reader->filled, more);
    if (reader->result) return NULL;
    reader->filled += more;
    return reader->buffer;
}
