/* flush_edits.h: what the formats share whose changes wait beside the bytes that were read: written
 * through a sink, compared with what was there, settled into bytes of the document's own. */
#ifndef NORMA_IO_REWRITE_H
#define NORMA_IO_REWRITE_H
#include "io/format/format.h"
#include "io/stream/sink.h"

/* A format's file as it is now, changes included. */
typedef norma_document_result norma_rewrite_body(
    norma_document *document, norma_sink *sink, norma_document_error *error);
norma_document_result norma_rewrite(norma_document *document, norma_rewrite_body *body,
    norma_write *write, void *user, norma_document_error *error);
/* Whether the file would be another than the size bytes it was. */
norma_document_result norma_rewrite_compare(norma_document *document, const unsigned char *bytes,
    size_t size, int *changed, norma_document_error *error);
/* The file as it would be written, in memory, the caller's to free. */
norma_document_result norma_rewrite_to_memory(
    norma_document *document, unsigned char **bytes, size_t *size, norma_document_error *error);
/* Reads such bytes: reading our own says nothing new, so notes of it go. */
norma_document_result norma_rewrite_read(norma_document *document,
    norma_document_result (*read)(norma_document *, norma_document_error *),
    norma_document_error *error);
#endif
