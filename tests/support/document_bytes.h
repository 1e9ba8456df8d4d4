/* document_bytes.h: documents opened from bytes and written back to bytes, for tests. Every
 * function fails the test on an error. */
#ifndef NORMA_TESTS_DOCUMENT_BYTES_H
#define NORMA_TESTS_DOCUMENT_BYTES_H
#include <norma/document.h>
#include <stddef.h>

typedef struct document_bytes {
    unsigned char *data;
    size_t size;
} document_bytes;

document_bytes bytes_load(const char *path);
document_bytes bytes_copy(const void *data, size_t size);
void bytes_free(document_bytes *bytes);

norma_document *bytes_open(document_bytes bytes, const char *name); /* bytes must outlive it */
document_bytes bytes_of(norma_document *document);
int bytes_equal(document_bytes a, document_bytes b);

/* Opened, computed, written; options and summary may be NULL. */
document_bytes bytes_computed(document_bytes bytes, const char *name,
    const norma_compute_options *options, norma_compute_summary *summary);
document_bytes bytes_transformed(document_bytes bytes, const char *name, const double matrix[16],
    norma_transform_summary *summary);

/* What opening answers; the document is closed again. message may be NULL, else room for 1000. */
norma_document_result bytes_try(
    document_bytes bytes, const char *name, norma_mesh_info *info, char *message);

/* Calls visit for every file of the data set of which INDEX.tsv says this format ("ply"), with its
 * path, its name there and its expect column. Returns how many. */
size_t data_for_each_format(
    const char *format, void (*visit)(const char *path, const char *name, const char *expect));
#endif
