/* large_file.h: what the files of this folder share: a file read through a window, what it needs
 * for messages, its budget and its progress. */
#ifndef NORMA_IO_LARGE_FILE_H
#define NORMA_IO_LARGE_FILE_H
#include "io/file/window.h"
#include "io/format/format.h"
#include "io/large/budget.h"
#include <norma/large.h>

/* Where bytes come from, unless from a file of this machine through a window; and what a message
 * says of why not all of them are read at once, and of the way out. */
typedef struct large_source {
    int (*read)(
        void *user, uint64_t offset, void *bytes, size_t size); /* errno or FILE_...; or 0 */
    void *user;
    uint64_t size;
    const char *why, *instead;
} large_source;

typedef struct large_file {
    norma_document *document; /* its name and header, without its body */
    file_window *window;      /* NULL where the source reads otherwise */
    large_source source;
    uint64_t size;
    norma_document_error *error;
    large_budget budget;
    norma_progress *progress;
    void *progress_user;
    double from, to; /* the part of the progress that the step under way takes */
} large_file;

/* large.c: made whole; and what is said of formats that are read whole. */
norma_large_options norma_large_options_of(const norma_large_options *given);
norma_document_result norma_large_fail_format(const char *path, norma_document_error *error);

/* Opens it and reads what it begins with, at most so many bytes, into document->source. */
norma_document_result norma_large_open(const char *path, const norma_large_options *options,
    norma_file_format format, large_file *file, norma_document_error *error);
/* The same from another source; error and budget are those of file. */
norma_document_result norma_large_open_source(
    const char *path, norma_file_format format, const large_source *source, large_file *file);
void norma_large_close(large_file *file);

norma_document_result norma_large_fail_memory(large_file *file);
/* What the system said when the input was read. */
norma_document_result norma_large_fail_read(large_file *file, int system_error);
/* The step under way, from 0 to 1. CANCELLED with its message, or OK. */
norma_document_result norma_large_tell(large_file *file, double fraction);
void norma_large_stage(large_file *file, double from, double to);
norma_document_result norma_large_read(large_file *file, uint64_t offset, void *bytes, size_t size);

/* ---- rows of a file, one after another */

typedef struct large_reader {
    large_file *file;
    unsigned char *buffer;
    size_t capacity, filled, at;
    uint64_t offset; /* of the buffer's first byte in the file */
    norma_document_result result;
} large_reader;

enum { LARGE_BUFFER = 1 << 22, SMALL_BUFFER = 1 << 20 };
int norma_large_reader_open(large_file *file, large_reader *reader); /* 0: out of memory */
void norma_large_reader_close(large_reader *reader);
void norma_large_reader_seek(large_reader *reader, uint64_t offset);
static inline uint64_t norma_large_reader_tell(const large_reader *reader) {
    return reader->offset + reader->at;
}
/* So many bytes from here on, at most SMALL_BUFFER; NULL: the file has fewer, or result is set. */
const unsigned char *norma_large_peek(large_reader *reader, size_t size);
#endif
