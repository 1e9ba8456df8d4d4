/* flush_edits.c: files whose changes wait beside the bytes that were read: opened, written,
 * compared, and turned into bytes of the document's own. */
#include "io/format/flush_edits.h"
#include "io/format/scene.h"
#include <stdlib.h>
#include <string.h>

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

/* ---- opening, closing, and changes that become bytes */

norma_document_result norma_edited_open(norma_document *document, norma_document_error *error) {
    const edited_format *format = document->functions->edited;
    document->state = norma_io_allocate(1, format->state_size);
    return document->state ? format->read(document, error)
                           : norma_document_fail_memory(document, error);
}

void norma_edited_close(norma_document *document) {
    if (!document->state) return;
    document->functions->edited->free_content(document->state);
    free(document->state);
    document->state = NULL;
}

/* Reading our own bytes finds nothing new, so notes about them are removed. */
static norma_document_result read_again(norma_document *document, norma_document_error *error) {
    const edited_format *format = document->functions->edited;
    const size_t notes = document->note_count;
    format->free_content(document->state);
    memset(document->state, 0, format->state_size);
    norma_document_result result = format->read(document, error);
    norma_scene_forget(document->scene);
    while (document->note_count > notes) free(document->notes[--document->note_count]);
    return result;
}

norma_document_result norma_edited_replace(
    norma_document *document, const growing_bytes *bytes, norma_document_error *error) {
    norma_file_close(&document->source);
    document->source =
        (file_bytes){.data = (const void *)bytes->data, .size = bytes->size, .owned = 1};
    norma_document_result result = read_again(document, error);
    document->failed |= result != NORMA_DOCUMENT_OK;
    return result;
}

void norma_edited_begin(norma_document *document) {
    document->had_edit = document->functions->edited->has_edit(document->state);
}

int norma_edited_drop(norma_document *document, norma_document_result why) {
    const edited_format *format = document->functions->edited;
    if (why == NORMA_DOCUMENT_ERROR_ARGUMENT &&
        !format->has_edit(document->state) == !document->had_edit)
        return 1; /* refused before anything was done */
    /* What came before is in the bytes only if the change could begin with flushing it. */
    if (document->had_edit && (format->gathers || why == NORMA_DOCUMENT_ERROR_MEMORY)) return 0;
    return read_again(document, NULL) == NORMA_DOCUMENT_OK;
}

unsigned char *norma_edited_own_bytes(norma_document *document) {
    file_bytes *source = &document->source;
    if (!source->owned || source->mapped) {
        unsigned char *copy = malloc(source->size ? source->size : 1);
        if (!copy) return NULL;
        if (source->size) memcpy(copy, source->data, source->size);
        const file_bytes own = {.data = copy, .size = source->size, .owned = 1};
        norma_file_close(source);
        *source = own;
    }
    return (unsigned char *)(uintptr_t)source->data;
}

static norma_document_result flush_all(norma_document *document, norma_document_error *error) {
    growing_bytes memory = {0};
    norma_document_result result =
        document->functions->write(document, NULL, norma_memory_sink_write, &memory, error);
    if (!result) return norma_edited_replace(document, &memory, error);
    free(memory.data);
    return result == NORMA_DOCUMENT_ERROR_FILE ? norma_document_fail_memory(document, error)
                                               : result;
}

/* A change that is cancelled takes nothing of the changes before it away, so these are written to
 * their end. */
norma_document_result norma_edited_flush(norma_document *document, norma_document_error *error) {
    if (!document->functions->edited->has_edit(document->state)) return NORMA_DOCUMENT_OK;
    norma_progress *const progress = document->watch.progress;
    document->watch.progress = NULL;
    const norma_document_result result = flush_all(document, error);
    document->watch.progress = progress;
    return result;
}
