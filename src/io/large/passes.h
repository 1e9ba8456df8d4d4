/* passes.h: normals computed piece by piece, for each format that can be. */
#ifndef NORMA_IO_LARGE_PASSES_H
#define NORMA_IO_LARGE_PASSES_H
#include "io/format/compute_policy.h"
#include "io/large/counts.h"
#include "io/large/large_file.h"

typedef struct large_compute {
    large_file *file;
    const char *output;
    const norma_large_options *options;
    compute_policy policy;
} large_compute;

norma_document_result norma_large_compute_ply(large_compute *job);
norma_document_result norma_large_compute_stl(large_compute *job);
norma_document_result norma_large_describe_ply(
    large_file *file, norma_large_description *description);
norma_document_result norma_large_describe_stl(
    large_file *file, norma_large_description *description);
#endif
