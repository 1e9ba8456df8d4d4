/* reopen.c: the buffers of a changed .gltf, in memory, for the document that is read from its new
 * JSON before either is on the disk. */
#include "io/gltf/patch.h"
#include "io/stream/sink.h"
#include <stdlib.h>
#include <string.h>

static int copy_changed(const patch_buffer *buffer, given_buffer *given) {
    given->bytes = norma_io_allocate(buffer->length, 1);
    for (size_t i = 0; given->bytes && i < buffer->segment_count; ++i)
        if (buffer->segments[i].bytes)
            memcpy(given->bytes + buffer->segments[i].offset, buffer->segments[i].bytes,
                buffer->segments[i].length);
    given->size = buffer->length;
    given->changed = 1;
    return given->bytes != NULL;
}

static int copy_unchanged_buffer(const gltf_buffer *buffer, given_buffer *given) {
    given->bytes = norma_io_allocate(buffer->available, 1);
    if (given->bytes) memcpy(given->bytes, buffer->bytes, buffer->available);
    given->size = buffer->available;
    return given->bytes != NULL;
}

static norma_document_result give_buffers(
    const gltf *g, norma_document *made, norma_document_error *error) {
    const norma_document *document = g->document;
    made->given = norma_io_allocate((size_t)g->buffer_count + 1, sizeof *made->given);
    if (!made->given) return norma_document_fail_memory(document, error);
    made->given_count = (size_t)g->buffer_count + 1;
    for (uint32_t b = 0; b < g->buffer_count; ++b) {
        given_buffer *given = &made->given[b];
        int fine = 1;
        if (g->buffers[b].storage != GLTF_STORED_FILE) continue;
        given->changed = b < document->given_count && document->given[b].changed;
        if (g->patch->buffers[b].changed)
            fine = copy_changed(&g->patch->buffers[b], given);
        else if (g->buffers[b].bytes)
            fine = copy_unchanged_buffer(&g->buffers[b], given);
        given->stamp = g->buffers[b].file.stamp;
        if (!fine) return norma_document_fail_memory(document, error);
    }
    return NORMA_DOCUMENT_OK;
}

norma_document_result norma_gltf_reopen(
    norma_document *document, norma_document *made, norma_document_error *error) {
    gltf *g = norma_gltf_of(document);
    growing_bytes bytes = {0};
    norma_document_result result = norma_gltf_lay_out_for(g, GLTF_TO_MEMORY, NULL, error);
    if (!result) result = norma_gltf_write_laid_out(g, norma_memory_sink_write, &bytes, error);
    if (result == NORMA_DOCUMENT_ERROR_FILE) /* only memory can fail of a sink in memory */
        result = norma_document_fail_memory(document, error);
    made->source = (file_bytes){.data = bytes.data ? (const void *)bytes.data : "",
        .size = bytes.size,
        .owned = bytes.data != NULL};
    return result ? result : give_buffers(g, made, error);
}

int norma_gltf_has_change(const norma_document *document) {
    return norma_gltf_of(document)->changed || document->replaced;
}

void norma_gltf_adopt(norma_document *document) {
    if (document->state) norma_gltf_of(document)->document = document;
}
