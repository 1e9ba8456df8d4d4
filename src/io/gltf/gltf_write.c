/* gltf_write.c: the beginning and the end of a change; the asset written as bytes, to a file or to
 * be opened again. */
#include "io/gltf/gltf.h"
#include "io/stream/stream.h"
#include <stdlib.h>
#include <string.h>

/* ---- Beginning and end of a change: what was put becomes edits and views. */

void norma_gltf_begin_change(gltf *g) { norma_gltf_patch_free(g); /* one that changed nothing */ }

int norma_gltf_drop_change(norma_document *document) {
    gltf *g = norma_gltf_of(document);
    norma_gltf_patch_free(g);
    norma_json_edits_destroy(g->edits);
    g->edits = norma_json_edits_create(&g->json, 0);
    g->changed = 0;
    return g->edits != NULL;
}

static norma_document_result append_copies(gltf *g, norma_document_error *error) {
    gltf_patch *patch = g->patch;
    uint32_t meshes = norma_json_member(&g->json, 0, "meshes");
    for (size_t i = 0; i < patch->copy_count; ++i) {
        json_text text = {0};
        int ok =
            norma_json_write(patch->copies[i].edits, g->meshes[patch->copies[i].mesh].token, &text);
        norma_json_add(&text, "", 1);
        if (ok && !text.failed) norma_json_append(g->edits, meshes, text.data);
        free(text.data);
        if (!ok || text.failed) return norma_document_fail_memory(g->document, error);
    }
    return NORMA_DOCUMENT_OK;
}

norma_document_result norma_gltf_finish(gltf *g, norma_document_error *error) {
    gltf_patch *patch = norma_gltf_patch_of(g);
    norma_document_result result = patch ? norma_gltf_assign_accessors(g, error)
                                         : norma_document_fail_memory(g->document, error);
    if (!result) result = norma_gltf_assign_views(g, error);
    if (!result && patch->accessor_count)
        result = norma_gltf_check_dangling(g, GLTF_LIST_ACCESSORS, error);
    if (!result && patch->view_count > g->view_count)
        result = norma_gltf_check_dangling(g, GLTF_LIST_VIEWS, error);
    if (!result && patch->copy_count)
        result = norma_gltf_check_dangling(g, GLTF_LIST_MESHES, error);
    if (!result) result = append_copies(g, error);
    if (result) return result;
    norma_gltf_edit_extensions(g);
    if (norma_json_edits_failed(g->edits)) return norma_document_fail_memory(g->document, error);
    g->changed = norma_json_edits_any(g->edits);
    for (size_t i = 0; i < patch->view_count; ++i)
        g->changed |= patch->views[i].plain.bytes != NULL;
    return NORMA_DOCUMENT_OK;
}

/* ---- The asset's main file: the JSON with all edits, as text or in a GLB with its other
 * chunks as they were. */

static const uint32_t GLB_BIN = 0x004E4942;
enum { GLB_HEADER = 12, GLB_CHUNK_HEADER = 8 };

static norma_document_result gltf_lay_out_for(
    gltf *g, gltf_destination destination, const char *path, norma_document_error *error) {
    norma_document_result result = g->patch ? NORMA_DOCUMENT_OK : norma_gltf_finish(g, error);
    if (result) return result;
    gltf_patch *patch = g->patch;
    norma_gltf_free_layout(g);
    patch->buffers = norma_io_allocate((size_t)g->buffer_count + 1, sizeof *patch->buffers);
    patch->layout = norma_json_edits_copy(g->edits);
    result = patch->buffers && patch->layout ? NORMA_DOCUMENT_OK
                                             : norma_document_fail_memory(g->document, error);
    if (!result) result = norma_gltf_fill_buffers(g, destination, error);
    if (!result) result = norma_gltf_name_buffers(g, destination, path, error);
    if (!result) result = norma_gltf_name_images(g, destination, path, error);
    if (!result) norma_gltf_edit_views(g);
    if (!result) result = norma_gltf_edit_buffers(g, destination, error);
    if (!result && norma_json_edits_failed(patch->layout))
        result = norma_document_fail_memory(g->document, error);
    return result;
}

norma_document_result norma_gltf_lay_out(gltf *g, const char *path, norma_document_error *error) {
    const char *key = path ? path : "";
    if (g->patch && g->patch->laid_out_for && strcmp(g->patch->laid_out_for, key) == 0)
        return NORMA_DOCUMENT_OK;
    norma_document_result result =
        gltf_lay_out_for(g, norma_gltf_destination(g, path), path, error);
    if (result) return result;
    g->patch->laid_out_for = norma_io_join(key, "");
    return g->patch->laid_out_for ? NORMA_DOCUMENT_OK
                                  : norma_document_fail_memory(g->document, error);
}

static size_t padding(size_t size) { return (4 - size % 4) % 4; }

static void put_segments(gltf_output *out, const patch_buffer *buffer) {
    for (size_t i = 0; i < buffer->segment_count; ++i) {
        if (buffer->segments[i].bytes)
            norma_gltf_write_bytes(out, buffer->segments[i].bytes, buffer->segments[i].length);
        else
            norma_gltf_write_fill(out, 0, buffer->segments[i].length);
    }
}

static void put_bin(gltf_output *out, const patch_buffer *bin) {
    norma_gltf_write_u32(out, (uint32_t)(bin->length + padding(bin->length)));
    norma_gltf_write_u32(out, GLB_BIN);
    put_segments(out, bin);
    norma_gltf_write_fill(out, 0, padding(bin->length));
}

/* The BIN chunk where it is written anew, else NULL. */
static const patch_buffer *new_bin(const gltf *g) {
    for (uint32_t b = 0; b <= g->buffer_count; ++b)
        if (g->patch->buffers[b].changed && norma_gltf_storage_of(g, b) == GLTF_STORED_BIN)
            return &g->patch->buffers[b];
    return NULL;
}

static size_t chunk_size(const gltf *g, size_t at) {
    return GLB_CHUNK_HEADER + norma_gltf_u32(g->document->source.data + g->tile.at + at);
}

static norma_document_result write_glb(
    gltf *g, const json_text *text, gltf_output *out, norma_document_error *error) {
    const unsigned char *source = g->document->source.data + g->tile.at;
    const patch_buffer *bin = new_bin(g);
    size_t first = GLB_HEADER + chunk_size(g, GLB_HEADER),
           json_size = text->size + padding(text->size);
    size_t total = GLB_HEADER + GLB_CHUNK_HEADER + json_size + (g->container_size - first);
    if (bin)
        total += GLB_CHUNK_HEADER + bin->length + padding(bin->length) -
                 (g->bin ? GLB_CHUNK_HEADER + g->bin_size : 0);
    if (norma_gltf_tile_size(g, total) > UINT32_MAX)
        return norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, NULL,
            "would become larger than the 4 GiB that a GLB can be; expected a .gltf with its "
            "buffers beside it");
    norma_gltf_begin_tile(g, total, out);
    norma_gltf_write_bytes(out, "glTF", 4);
    norma_gltf_write_u32(out, 2);
    norma_gltf_write_u32(out, (uint32_t)total);
    norma_gltf_write_u32(out, (uint32_t)json_size);
    norma_gltf_write_bytes(out, "JSON", 4);
    norma_gltf_write_bytes(out, text->data, text->size);
    norma_gltf_write_fill(out, ' ', padding(text->size));
    if (bin && !g->bin) put_bin(out, bin);
    for (size_t at = first; at < g->container_size; at += chunk_size(g, at)) {
        if (bin && g->bin && at == g->bin_chunk)
            put_bin(out, bin);
        else
            norma_gltf_write_bytes(out, source + at, chunk_size(g, at));
    }
    norma_gltf_end_tile(g, total, out);
    return NORMA_DOCUMENT_OK;
}

static norma_document_result gltf_write_laid_out(
    gltf *g, norma_write *write, void *user, norma_document_error *error) {
    gltf_output out = {.write = write, .user = user};
    json_text text = {0};
    norma_document_result result = NORMA_DOCUMENT_OK;
    if (!norma_json_write(g->patch->layout, 0, &text))
        result = norma_document_fail_memory(g->document, error);
    else if (g->document->format != NORMA_FILE_GLTF)
        result = write_glb(g, &text, &out, error);
    else
        norma_gltf_write_bytes(&out, text.data, text.size);
    free(text.data);
    if (!result && out.failed)
        result = norma_document_fail(
            g->document, error, NORMA_DOCUMENT_ERROR_FILE, NULL, "the output could not be written");
    return result;
}

norma_document_result norma_gltf_write(norma_document *document, const char *path,
    norma_write *write, void *user, norma_document_error *error) {
    gltf *g = norma_gltf_of(document);
    if (norma_gltf_differs(g)) {
        norma_document_result result = norma_gltf_lay_out(g, path, error);
        return result ? result : gltf_write_laid_out(g, write, user, error);
    }
    if (document->source.size == 0 || !write(user, document->source.data, document->source.size))
        return NORMA_DOCUMENT_OK;
    return norma_document_fail(
        document, error, NORMA_DOCUMENT_ERROR_FILE, NULL, "the output could not be written");
}

/* ---- The buffers of a changed .gltf, in memory, for the document that is read from its new
 * JSON before either is on the disk. */

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
    norma_document_result result = gltf_lay_out_for(g, GLTF_TO_MEMORY, NULL, error);
    if (!result) result = gltf_write_laid_out(g, norma_memory_sink_write, &bytes, error);
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
