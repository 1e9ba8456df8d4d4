/* reopen.c: the buffers of a changed .gltf, in memory, for the document that is read from its new
 * JSON before either is on the disk. */
#include "io/gltf/write/patch.h"
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

static int copy_unchanged(const gltf_buffer *buffer, given_buffer *given) {
    given->bytes = norma_io_allocate(buffer->length, 1);
    if (given->bytes) memcpy(given->bytes, buffer->bytes, buffer->length);
    given->size = buffer->length;
    return given->bytes != NULL;
}

norma_document_result norma_gltf_reopen(
    const norma_document *document, norma_document *settled, norma_document_error *error) {
    const gltf *g = norma_gltf_of(document);
    const patch_buffer *changed = g->changed ? g->patch->buffers : NULL;
    settled->given = norma_io_allocate((size_t)g->buffer_count + 1, sizeof *settled->given);
    if (!settled->given) return norma_document_fail_memory(document, error);
    settled->given_count = (size_t)g->buffer_count + 1;
    for (uint32_t b = 0; b <= g->buffer_count; ++b) {
        given_buffer *given = &settled->given[b];
        int fine = 1;
        if (norma_gltf_storage_of(g, b) != GLTF_STORED_FILE) continue;
        given->changed = document->given && b < g->buffer_count && document->given[b].changed;
        if (changed && changed[b].changed)
            fine = copy_changed(&changed[b], given);
        else if (b < g->buffer_count && g->buffers[b].bytes)
            fine = copy_unchanged(&g->buffers[b], given);
        if (b < g->buffer_count) given->stamp = g->buffers[b].file.stamp;
        if (!fine) return norma_document_fail_memory(document, error);
    }
    return NORMA_DOCUMENT_OK;
}
