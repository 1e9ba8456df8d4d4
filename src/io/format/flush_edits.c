/* flush_edits.c: files whose changes wait beside the bytes that were read: written, compared, and
 * settled into bytes of the document's own. */
#include "io/format/flush_edits.h"
#include "io/format/scene.h"
#include <stdlib.h>

norma_document_result norma_rewrite(norma_document *document, norma_rewrite_body *body,
    norma_write *write, void *user, norma_document_error *error) {
    norma_sink *sink = norma_sink_create(write, user);
    if (!sink) return norma_document_fail_memory(document, error);
    norma_document_result result = body(document, sink, error);
    int failed = norma_sink_finish(sink);
    if (!result && failed)
        return norma_document_fail(
            document, error, NORMA_DOCUMENT_ERROR_FILE, NULL, "the output could not be written");
    return result;
}

norma_document_result norma_rewrite_compare(norma_document *document, const unsigned char *bytes,
    size_t size, int *changed, norma_document_error *error) {
    norma_compare_sink same = {bytes, size};
    norma_document_result result =
        document->functions->write(document, NULL, norma_compare_sink_write, &same, NULL);
    *changed = result == NORMA_DOCUMENT_ERROR_FILE || same.left > 0;
    return result == NORMA_DOCUMENT_ERROR_MEMORY ? norma_document_fail_memory(document, error)
                                                 : NORMA_DOCUMENT_OK;
}

norma_document_result norma_rewrite_to_memory(
    norma_document *document, unsigned char **bytes, size_t *size, norma_document_error *error) {
    norma_memory_sink memory = {0};
    norma_document_result result =
        document->functions->write(document, NULL, norma_memory_sink_write, &memory, error);
    if (result) {
        free(memory.bytes);
        return result == NORMA_DOCUMENT_ERROR_FILE ? norma_document_fail_memory(document, error)
                                                   : result;
    }
    *bytes = memory.bytes;
    *size = memory.size;
    return NORMA_DOCUMENT_OK;
}

norma_document_result norma_rewrite_read(norma_document *document,
    norma_document_result (*read)(norma_document *, norma_document_error *),
    norma_document_error *error) {
    const size_t notes = document->note_count;
    norma_document_result result = read(document, error);
    norma_scene_forget(document->scene);
    while (document->note_count > notes) free(document->notes[--document->note_count]);
    return result;
}
