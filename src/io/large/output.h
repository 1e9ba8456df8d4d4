/* output.h: what a large file becomes, on its way to its place. */
#ifndef NORMA_IO_LARGE_OUTPUT_H
#define NORMA_IO_LARGE_OUTPUT_H
#include "io/large/large_file.h"

typedef struct large_output {
    large_file *file;
    const char *path;
    file_writer *writer;
    uint64_t written;
    int error;
    norma_document_result result; /* of what stopped the writing, beside its error */
} large_output;

/* Whether it may be written there, and opens it. */
norma_document_result norma_large_output_open(
    large_file *file, const char *path, const norma_large_options *options, large_output *output);
/* A norma_write; its failure is told by norma_large_output_result. */
int norma_large_output_write(void *output, const void *bytes, size_t size);
norma_document_result norma_large_output_result(large_output *output);
/* Bytes of the input as they are. Progress from 0 to 1 of the stage. */
norma_document_result norma_large_output_copy(large_output *output, uint64_t begin, uint64_t end);
norma_document_result norma_large_output_read(
    large_output *output, uint64_t offset, void *bytes, size_t size);
norma_document_result norma_large_output_patch(
    large_output *output, uint64_t offset, const void *bytes, size_t size);
/* Into its place, if result is OK and the input has not changed meanwhile; else all of it is gone.
 * Returns result, or what went wrong. */
norma_document_result norma_large_output_close(
    large_output *output, norma_document_result result, uint64_t *size);
#endif
