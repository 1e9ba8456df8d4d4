/* document_copy.c: a document to try changes on. */
#include "io/format/format.h"
#include "io/stream/sink.h"
#include <stdlib.h>

norma_document_result norma_document_copy(
    norma_document *document, norma_document **copy, norma_document_error *error) {
    growing_bytes memory = {0};
    const norma_document_options options = {.struct_size = sizeof options,
        .format = document->format,
        .threads = document->threads,
        .lenient = 1};
    *copy = NULL;
    norma_document_result result =
        document->functions->write(document, NULL, norma_memory_sink_write, &memory, error);
    norma_document *made =
        result ? NULL : norma_document_make(document->path, document->folder != NULL, &options);
    if (!made) {
        free(memory.data);
        return result && result != NORMA_DOCUMENT_ERROR_FILE
                   ? result
                   : norma_document_fail_memory(document, error);
    }
    made->source = (file_bytes){.data = (const void *)memory.data, .size = memory.size, .owned = 1};
    result = norma_document_read(made, error);
    if (result)
        norma_document_close(made);
    else
        *copy = made;
    return result;
}
