/* flush_edits.h: what the formats share whose changes wait beside the bytes that were read: written
 * through a sink, compared with what was there, made the document's own bytes. */
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

/* A format whose changes wait beside the bytes of the document: how its state is made, read and let
 * go. */
struct edited_format {
    size_t state_size;
    int gathers; /* nonzero: changes wait together; 0: each begins with flushing those before */
    int (*has_edit)(const void *state);
    void (*free_content)(void *state);
    /* From document->source, into a state of zeros. */
    norma_document_result (*read)(norma_document *document, norma_document_error *error);
};
norma_document_result norma_edited_open(norma_document *document, norma_document_error *error);
void norma_edited_close(norma_document *document);
/* The changes become the document's bytes, which are read again. Does nothing without changes. */
norma_document_result norma_edited_flush(norma_document *document, norma_document_error *error);
/* Before a change; and a change that failed for this reason is taken back, by reading the
 * document's bytes again if anything was done. 0: it cannot be, because other changes wait with it,
 * or memory is out. */
void norma_edited_begin(norma_document *document);
int norma_edited_drop(norma_document *document, norma_document_result why);
/* These bytes become the document's, which owns them from now on. */
norma_document_result norma_edited_replace(
    norma_document *document, const growing_bytes *bytes, norma_document_error *error);
/* The document's bytes to be changed in place, copied first if they belong to the caller; NULL: out
 * of memory. */
unsigned char *norma_edited_own_bytes(norma_document *document);
#endif
