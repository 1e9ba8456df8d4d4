/* 3mf_left_out.c: stands in for the other files of this folder where the library is built without
 * zlib. */
#include "io/format/format.h"

static norma_document_result open_nothing(norma_document *document, norma_document_error *error) {
    return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, NULL,
        "3MF needs zlib, which this Norma was built without");
}

static void close_nothing(norma_document *document) { (void)document; }

const format_functions norma_3mf_functions = {.open = open_nothing, .close = close_nothing};
