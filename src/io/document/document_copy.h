/* document_copy.h: a document to try changes on. */
#ifndef NORMA_IO_DOCUMENT_COPY_H
#define NORMA_IO_DOCUMENT_COPY_H
#include <norma/document.h>

/* A document that is read, leniently, from the bytes that the document would be written as; it is
 * not to be saved. To be closed. */
norma_document_result norma_document_copy(
    norma_document *document, norma_document **copy, norma_document_error *error);
#endif
