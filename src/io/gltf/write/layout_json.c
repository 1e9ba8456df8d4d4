/* layout_json.c: the layout as JSON: offsets and lengths of views, lengths and URIs of buffers, and
 * the compression extension where nothing uses it any more. */
#include "io/gltf/write/patch.h"
#include <stdlib.h>
#include <string.h>

static const char *const compressions[] = {"EXT_meshopt_compression", "KHR_meshopt_compression"};
enum { COMPRESSIONS = sizeof compressions / sizeof *compressions };

static int is_compressed(const gltf *g, uint32_t view, const char *name) {
    return norma_json_member(&g->json,
               norma_json_member(&g->json, g->views[view].token, "extensions"), name) != JSON_NONE;
}

/* ---- views */

/* Whichever of them it was read by, none is true any more. */
static void drop_compression(const gltf *g, json_edits *edits, uint32_t view) {
    const json *j = &g->json;
    const uint32_t extensions = norma_json_member(j, g->views[view].token, "extensions");
    int others = 0;
    for (uint32_t value = norma_json_first(j, extensions); value != JSON_NONE;
         value = norma_json_next(j, extensions, value))
        others |= !norma_json_equals(j, value - 1, compressions[0]) &&
                  !norma_json_equals(j, value - 1, compressions[1]);
    if (!others) norma_json_remove(edits, extensions);
    for (size_t i = 0; others && i < COMPRESSIONS; ++i)
        norma_json_unset(edits, extensions, compressions[i]);
}

static void edit_view(gltf *g, uint32_t number) {
    const gltf_view *old = &g->views[number];
    const patch_view *view = &g->patch->views[number];
    json_edits *edits = g->patch->layout;
    if (view->buffer != old->buffer) norma_json_set_uint(edits, old->token, "buffer", view->buffer);
    if (view->offset != old->offset)
        norma_json_set_uint(edits, old->token, "byteOffset", view->offset);
    if (view->length != old->length)
        norma_json_set_uint(edits, old->token, "byteLength", view->length);
    if (view->stride && view->stride != old->stride)
        norma_json_set_uint(edits, old->token, "byteStride", view->stride);
    if (!view->stride && old->stride) norma_json_unset(edits, old->token, "byteStride");
    if (old->meshopt.token != GLTF_NONE) drop_compression(g, edits, number);
}

static void describe_view(json_text *text, const patch_view *view) {
    norma_json_add_text(text, "{\"buffer\":");
    norma_json_add_uint(text, view->buffer);
    norma_json_add_text(text, ",\"byteOffset\":");
    norma_json_add_uint(text, view->offset);
    norma_json_add_text(text, ",\"byteLength\":");
    norma_json_add_uint(text, view->length);
    if (view->stride) {
        norma_json_add_text(text, ",\"byteStride\":");
        norma_json_add_uint(text, view->stride);
    }
    if (view->target) {
        norma_json_add_text(text, ",\"target\":");
        norma_json_add_uint(text, (uint64_t)view->target);
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
    for (uint32_t v = 0; v < g->view_count; ++v)
        if (patch->views[v].bytes) edit_view(g, v);
    for (size_t i = 0; starts && i < added; ++i) {
        starts[i] = list.size;
        describe_view(&list, &patch->views[g->view_count + i]);
        norma_json_add(&list, "", 1);
    }
    if (added) append_to_root(g, "bufferViews", &list, starts, added);
    if (list.failed) norma_json_edits_fail(patch->layout);
    free(list.data);
    free(starts);
}

/* ---- buffers */

static void add_base64(json_text *text, const patch_buffer *buffer) {
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    uint32_t bits = 0, held = 0;
    for (size_t i = 0; i < buffer->segment_count && !text->failed; ++i)
        for (size_t k = 0; k < buffer->segments[i].length; ++k) {
            bits = bits << 8 | (buffer->segments[i].bytes ? buffer->segments[i].bytes[k] : 0u);
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

static int write_uri(const gltf *g, uint32_t buffer, json_text *text) {
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
    add_base64(text, b);
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
    int ok = whole(g, number) && write_uri(g, number, &uri);
    norma_json_add(&uri, "", 1);
    ok = ok && !uri.failed;
    if (ok) norma_json_set(edits, old->token, "uri", uri.data);
    free(uri.data);
    return ok;
}

static int add_buffer(gltf *g) {
    uint32_t number = g->buffer_count;
    const patch_buffer *b = &g->patch->buffers[number];
    json_text text = {0};
    size_t start = 0;
    norma_json_add_text(&text, "{");
    if (norma_gltf_storage_of(g, number) != GLTF_STORED_BIN) {
        norma_json_add_text(&text, "\"uri\":");
        write_uri(g, number, &text);
        norma_json_add_text(&text, ",");
    }
    norma_json_add_text(&text, "\"byteLength\":");
    norma_json_add_uint(&text, b->byte_length);
    norma_json_add(&text, "}", 2);
    append_to_root(g, "buffers", &text, &start, 1);
    free(text.data);
    return !text.failed;
}

/* ---- compression that nothing uses any more */

static int view_refers(const gltf *g, uint32_t view, uint32_t buffer) {
    const gltf_view *v = &g->views[view];
    if (g->patch->views[view].bytes) return g->patch->views[view].buffer == buffer;
    return v->buffer == buffer || (v->meshopt.token != GLTF_NONE && v->meshopt.buffer == buffer);
}

/* Placeholders at the end of "buffers" whose views have all been written uncompressed go; one in
 * the middle must keep its number. */
static void remove_placeholders(gltf *g) {
    for (uint32_t b = g->buffer_count; b-- > 0 && !g->patch->buffers[g->buffer_count].changed;) {
        int used = 0, was = 0;
        for (uint32_t v = 0; v < g->view_count; ++v) {
            used |= view_refers(g, v, b);
            was |= g->views[v].buffer == b;
        }
        if (used || !was || g->buffers[b].storage != GLTF_STORED_NOWHERE) return;
        g->patch->buffers[b].removed = 1;
        norma_json_remove(g->patch->layout, g->buffers[b].token);
    }
}

static int uses_extension(const gltf *g, const char *name) {
    for (uint32_t v = 0; v < g->view_count; ++v)
        if (!g->patch->views[v].bytes && is_compressed(g, v, name)) return 1;
    for (uint32_t b = 0; b < g->buffer_count; ++b)
        if (!g->patch->buffers[b].removed &&
            norma_json_member(&g->json,
                norma_json_member(&g->json, g->buffers[b].token, "extensions"), name) != JSON_NONE)
            return 1;
    return 0;
}

static void drop_from_list(gltf *g, const char *list_name, const char *name) {
    const json *j = &g->json;
    uint32_t list = norma_json_member(j, 0, list_name);
    for (uint32_t item = norma_json_first(j, list); item != JSON_NONE;
         item = norma_json_next(j, list, item))
        if (norma_json_equals(j, item, name)) norma_json_remove(g->patch->layout, item);
}

/* A list of nothing is not valid (glTF 2.0, 5.17). */
static void drop_empty_list(gltf *g, const char *list_name) {
    const uint32_t list = norma_json_member(&g->json, 0, list_name);
    if (norma_json_size(&g->json, list) && !norma_json_keeps_any(g->patch->layout, list))
        norma_json_remove(g->patch->layout, list);
}

static void drop_unused_extensions(gltf *g) {
    for (size_t i = 0; i < COMPRESSIONS; ++i) {
        int decoded = 0;
        for (uint32_t v = 0; v < g->view_count; ++v)
            decoded |= g->patch->views[v].bytes && is_compressed(g, v, compressions[i]);
        if (!decoded || uses_extension(g, compressions[i])) continue;
        drop_from_list(g, "extensionsUsed", compressions[i]);
        drop_from_list(g, "extensionsRequired", compressions[i]);
    }
    drop_empty_list(g, "extensionsUsed");
    drop_empty_list(g, "extensionsRequired");
}

norma_document_result norma_gltf_edit_buffers(
    gltf *g, gltf_destination destination, norma_document_error *error) {
    int ok = 1;
    for (uint32_t b = 0; ok && b < g->buffer_count; ++b) ok = edit_buffer(g, b, destination);
    if (ok && g->patch->buffers[g->buffer_count].changed) {
        const norma_document_result dangling =
            norma_gltf_check_dangling(g, GLTF_LIST_BUFFERS, error);
        if (dangling) return dangling;
        ok = add_buffer(g);
    }
    if (!ok) return norma_document_fail_memory(g->document, error);
    remove_placeholders(g);
    drop_unused_extensions(g);
    return NORMA_DOCUMENT_OK;
}
