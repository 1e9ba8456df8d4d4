/* layout_json.c: the layout as JSON: offsets and lengths of views, lengths and URIs of buffers, and
 * how views are compressed. */
#include "io/gltf/patch.h"
#include <stdlib.h>
#include <string.h>

/* ---- views */

static void add_uint_member(json_text *text, const char *key, uint64_t number) {
    norma_json_add_text(text, ",");
    norma_json_add_quoted(text, key);
    norma_json_add_text(text, ":");
    norma_json_add_uint(text, number);
}

static void describe_compression(json_text *text, const patch_view *view) {
    static const char *const modes[] = {"ATTRIBUTES", "TRIANGLES", "INDICES"};
    static const char *const filters[] = {"NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL"};
    const gltf_meshopt *m = &view->meshopt;
    norma_json_add_text(text, "{\"buffer\":");
    norma_json_add_uint(text, view->packed.buffer);
    add_uint_member(text, "byteOffset", view->packed.offset);
    add_uint_member(text, "byteLength", view->packed.length);
    add_uint_member(text, "byteStride", m->stride);
    add_uint_member(text, "count", m->count);
    norma_json_add_text(text, ",\"mode\":");
    norma_json_add_quoted(text, modes[m->mode]);
    if (m->filter != GLTF_FILTER_NONE) {
        norma_json_add_text(text, ",\"filter\":");
        norma_json_add_quoted(text, filters[m->filter]);
    }
    norma_json_add_text(text, "}");
}

/* Compressed bytes that only moved keep their description; of two, under both names of the
 * extension or one of them twice, the one that was read stays. */
static void edit_compression(gltf *g, uint32_t number) {
    const gltf_meshopt *m = &g->views[number].meshopt;
    const patch_view *view = &g->patch->views[number];
    const uint32_t extensions = g->json.tokens[m->token].parent;
    json_edits *edits = g->patch->layout;
    json_text text = {0};
    if (!view->packed.bytes) {
        if (view->packed.offset != m->offset)
            norma_json_set_uint(edits, m->token, "byteOffset", view->packed.offset);
        return;
    }
    describe_compression(&text, view);
    norma_json_add(&text, "", 1);
    norma_json_unset(edits, extensions, "EXT_meshopt_compression");
    norma_json_unset(edits, extensions, "KHR_meshopt_compression");
    if (text.failed)
        norma_json_edits_fail(edits);
    else
        norma_json_set(edits, extensions, norma_gltf_extension_of(g, m), text.data);
    free(text.data);
}

static void edit_view(gltf *g, uint32_t number) {
    const gltf_view *old = &g->views[number];
    const patch_view *view = &g->patch->views[number];
    json_edits *edits = g->patch->layout;
    if (old->meshopt.token != GLTF_NONE) edit_compression(g, number);
    if (view->plain.offset != old->offset)
        norma_json_set_uint(edits, old->token, "byteOffset", view->plain.offset);
    if (!view->plain.bytes) return;
    if (view->plain.buffer != old->buffer)
        norma_json_set_uint(edits, old->token, "buffer", view->plain.buffer);
    if (view->plain.length != old->length)
        norma_json_set_uint(edits, old->token, "byteLength", view->plain.length);
    if (view->stride && view->stride != old->stride)
        norma_json_set_uint(edits, old->token, "byteStride", view->stride);
    if (!view->stride && old->stride) norma_json_unset(edits, old->token, "byteStride");
}

static void describe_view(const gltf *g, json_text *text, const patch_view *view) {
    norma_json_add_text(text, "{\"buffer\":");
    norma_json_add_uint(text, view->plain.buffer);
    add_uint_member(text, "byteOffset", view->plain.offset);
    add_uint_member(text, "byteLength", view->plain.length);
    if (view->stride) add_uint_member(text, "byteStride", view->stride);
    if (view->target) add_uint_member(text, "target", (uint64_t)view->target);
    if (view->packed.bytes) {
        norma_json_add_text(text, ",\"extensions\":{");
        norma_json_add_quoted(text, norma_gltf_extension_of(g, &view->meshopt));
        norma_json_add_text(text, ":");
        describe_compression(text, view);
        norma_json_add_text(text, "}");
    }
    norma_json_add_text(text, "}");
}

/* Adds to an array of the root, which is made where it is not there. */
static void append_to_root(
    gltf *g, const char *key, json_text *list, size_t *starts, size_t count) {
    uint32_t array = norma_json_member(&g->json, 0, key);
    if (list->failed) return;
    if (array == JSON_NONE) {
        json_text whole = {0};
        norma_json_add_text(&whole, "[");
        for (size_t i = 0; i < count; ++i) {
            norma_json_add_text(&whole, i ? "," : "");
            norma_json_add_text(&whole, list->data + starts[i]);
        }
        norma_json_add(&whole, "]", 2);
        if (whole.failed)
            list->failed = 1;
        else
            norma_json_set(g->patch->layout, 0, key, whole.data);
        free(whole.data);
        return;
    }
    for (size_t i = 0; i < count; ++i)
        norma_json_append(g->patch->layout, array, list->data + starts[i]);
}

void norma_gltf_edit_views(gltf *g) {
    gltf_patch *patch = g->patch;
    size_t added = patch->view_count - g->view_count;
    size_t *starts = norma_io_allocate(added, sizeof *starts);
    json_text list = {.failed = !starts};
    for (uint32_t v = 0; v < g->view_count; ++v) edit_view(g, v);
    for (size_t i = 0; starts && i < added; ++i) {
        starts[i] = list.size;
        describe_view(g, &list, &patch->views[g->view_count + i]);
        norma_json_add(&list, "", 1);
    }
    if (added) append_to_root(g, "bufferViews", &list, starts, added);
    if (list.failed) norma_json_edits_fail(patch->layout);
    free(list.data);
    free(starts);
}

/* ---- buffers */

void norma_gltf_add_base64(
    json_text *text, const patch_segment *segments, size_t count, norma_watch *watch) {
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    uint32_t bits = 0, held = 0;
    for (size_t i = 0; i < count && !text->failed; ++i)
        for (size_t k = 0; k < segments[i].length; ++k) {
            if (k % WATCH_BYTES == WATCH_BYTES - 1 && norma_watch_cancelled(watch)) return;
            bits = bits << 8 | (segments[i].bytes ? segments[i].bytes[k] : 0u);
            if (++held < 3) continue;
            const char four[4] = {digits[bits >> 18 & 63], digits[bits >> 12 & 63],
                digits[bits >> 6 & 63], digits[bits & 63]};
            norma_json_add(text, four, 4);
            bits = held = 0;
        }
    if (held) {
        bits <<= held == 1 ? 16 : 8;
        const char four[4] = {digits[bits >> 18 & 63], digits[bits >> 12 & 63],
            held == 2 ? digits[bits >> 6 & 63] : '=', '='};
        norma_json_add(text, four, 4);
    }
}

/* What stands before the comma of the old data: URI, where that says base64, else what glTF
 * recommends. */
static void add_data_prefix(const gltf *g, uint32_t buffer, json_text *text) {
    uint32_t token = buffer < g->buffer_count
                         ? norma_json_member(&g->json, g->buffers[buffer].token, "uri")
                         : JSON_NONE;
    if (token != JSON_NONE && g->buffers[buffer].storage == GLTF_STORED_DATA) {
        const char *start = g->text + g->json.tokens[token].start + 1,
                   *end = g->text + g->json.tokens[token].end - 1,
                   *comma = memchr(start, ',', (size_t)(end - start));
        if (comma && comma - start >= 7 && memcmp(comma - 7, ";base64", 7) == 0) {
            norma_json_add(text, start, (size_t)(comma + 1 - start));
            return;
        }
    }
    norma_json_add_text(text, "data:application/octet-stream;base64,");
}

static int write_buffer_uri(const gltf *g, uint32_t buffer, json_text *text) {
    const patch_buffer *b = &g->patch->buffers[buffer];
    if (b->name) {
        char *uri = norma_gltf_uri_encode(b->name);
        if (!uri) return 0;
        norma_json_add_quoted(text, uri);
        free(uri);
        return !text->failed;
    }
    norma_json_add_text(text, "\"");
    add_data_prefix(g, buffer, text);
    norma_gltf_add_base64(text, b->segments, b->segment_count, norma_document_watch(g->document));
    norma_json_add_text(text, "\"");
    return !text->failed;
}

static int goes_as_data(const gltf *g, uint32_t buffer, gltf_destination destination) {
    gltf_storage storage = norma_gltf_storage_of(g, buffer);
    return storage == GLTF_STORED_DATA ||
           (storage == GLTF_STORED_FILE && destination == GLTF_TO_STREAM);
}

/* The whole buffer as one segment, for one that goes as it was. */
static int whole(const gltf *g, uint32_t buffer) {
    patch_buffer *b = &g->patch->buffers[buffer];
    if (b->segment_count) return 1;
    b->segments = norma_io_allocate(1, sizeof *b->segments);
    if (!b->segments) return 0;
    b->length = g->buffers[buffer].length;
    b->segments[0] = (patch_segment){.length = b->length, .bytes = g->buffers[buffer].bytes};
    b->segment_count = b->segment_capacity = 1;
    return 1;
}

static int edit_buffer(gltf *g, uint32_t number, gltf_destination destination) {
    const gltf_buffer *old = &g->buffers[number];
    const patch_buffer *b = &g->patch->buffers[number];
    json_edits *edits = g->patch->layout;
    json_text uri = {0};
    int data = goes_as_data(g, number, destination);
    int moved = data ? b->changed || (old->storage == GLTF_STORED_FILE && old->bytes)
                     : b->name && (!old->name || strcmp(b->name, old->name) != 0);
    if (b->changed && b->byte_length != old->length)
        norma_json_set_uint(edits, old->token, "byteLength", b->byte_length);
    if (!moved) return 1;
    int ok = whole(g, number) && write_buffer_uri(g, number, &uri);
    norma_json_add(&uri, "", 1);
    ok = ok && !uri.failed;
    if (ok) norma_json_set(edits, old->token, "uri", uri.data);
    free(uri.data);
    return ok;
}

static int append_buffer(gltf *g) {
    uint32_t number = g->buffer_count;
    const patch_buffer *b = &g->patch->buffers[number];
    json_text text = {0};
    size_t start = 0;
    norma_json_add_text(&text, "{");
    if (norma_gltf_storage_of(g, number) != GLTF_STORED_BIN) {
        norma_json_add_text(&text, "\"uri\":");
        write_buffer_uri(g, number, &text);
        norma_json_add_text(&text, ",");
    }
    norma_json_add_text(&text, "\"byteLength\":");
    norma_json_add_uint(&text, b->byte_length);
    norma_json_add(&text, "}", 2);
    append_to_root(g, "buffers", &text, &start, 1);
    free(text.data);
    return !text.failed;
}

norma_document_result norma_gltf_edit_buffers(
    gltf *g, gltf_destination destination, norma_document_error *error) {
    int ok = 1;
    for (uint32_t b = 0; ok && b < g->buffer_count; ++b) ok = edit_buffer(g, b, destination);
    if (ok && g->patch->buffers[g->buffer_count].changed) {
        const norma_document_result dangling =
            norma_gltf_check_dangling(g, GLTF_LIST_BUFFERS, error);
        if (dangling) return dangling;
        ok = append_buffer(g);
    }
    return ok ? NORMA_DOCUMENT_OK : norma_document_fail_memory(g->document, error);
}
