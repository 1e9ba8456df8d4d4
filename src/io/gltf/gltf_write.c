/* gltf_write.c: the beginning and the end of a change; the asset written as bytes, to a file or to
 * be opened again. */
#include "io/gltf/gltf.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { BYTE_LENGTH = 8, COMPOSITE_HEADER = 16, TABLES = 12, MODEL_TABLES_END = 28, ALIGNED = 8 };

typedef struct tile_search {
    gltf *g;
    gltf_tile path;      /* the headers above what is looked at */
    size_t found;        /* GLBs */
    const char *without; /* NULL, or what the last tile without a GLB has instead */
} tile_search;

static norma_document_result fail_tile(const tile_search *s, norma_document_error *error,
    norma_document_result result, size_t byte, const char *message) {
    char place[40];
    snprintf(place, sizeof place, "byte %zu", byte);
    return norma_document_fail(s->g->document, error, result, place, "%s", message);
}

static int has_magic(const unsigned char *at, const char *magic) {
    return memcmp(at, magic, 4) == 0;
}

/* The GLB begins behind a header and four tables, whose lengths the header lists. */
static norma_document_result find_model(
    tile_search *s, size_t at, size_t end, norma_document_error *error) {
    const unsigned char *tile = s->g->document->source.data + at;
    const int has_instances = has_magic(tile, "i3dm");
    uint64_t begin = MODEL_TABLES_END + (has_instances ? 4 : 0);
    if (end - at < begin)
        return fail_tile(s, error, NORMA_DOCUMENT_ERROR_MALFORMED, at, "the tile's header is cut");
    const int is_outside = has_instances && norma_gltf_u32(tile + MODEL_TABLES_END) == 0;
    for (int i = TABLES; i < MODEL_TABLES_END; i += 4) begin += norma_gltf_u32(tile + i);
    if (begin > end - at)
        return fail_tile(s, error, NORMA_DOCUMENT_ERROR_MALFORMED, at + TABLES,
            "the tables are longer than the tile; expected the 28 bytes of a header as 3D Tiles "
            "1.0 "
            "has them");
    s->without =
        is_outside ? "names a glTF file instead of holding one; give that file" : s->without;
    if (is_outside) return NORMA_DOCUMENT_OK;
    if (s->found++ == 0) {
        s->g->tile = s->path;
        s->g->tile.at = at + (size_t)begin;
        s->g->tile.end = end;
    }
    return NORMA_DOCUMENT_OK;
}

static norma_document_result look_into_tile(
    tile_search *s, size_t at, size_t end, size_t *next, norma_document_error *error) {
    const unsigned char *tile = s->g->document->source.data + at;
    if (end - at < COMPOSITE_HEADER)
        return fail_tile(s, error, NORMA_DOCUMENT_ERROR_MALFORMED, at,
            "expected the header of a tile; found the end");
    const size_t length = norma_gltf_u32(tile + BYTE_LENGTH);
    if (norma_gltf_u32(tile + 4) != 1)
        return fail_tile(s, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, at + 4,
            "this is not version 1 of a tile, the only one that can be read");
    if (length < COMPOSITE_HEADER || length > end - at)
        return fail_tile(s, error, NORMA_DOCUMENT_ERROR_MALFORMED, at + BYTE_LENGTH,
            "the tile's length does not fit into the file");
    if (s->path.depth == TILE_DEPTH)
        return fail_tile(s, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, at,
            "composite tiles are nested more than eight deep");
    *next = at + length;
    s->path.headers[s->path.depth++] = at;
    norma_document_result result = NORMA_DOCUMENT_OK;
    if (has_magic(tile, "b3dm") || has_magic(tile, "i3dm"))
        result = find_model(s, at, *next, error);
    else if (has_magic(tile, "cmpt")) {
        size_t inner = at + COMPOSITE_HEADER;
        for (uint32_t i = norma_gltf_u32(tile + 12); i > 0 && !result; --i)
            result = look_into_tile(s, inner, *next, &inner, error);
    } else if (has_magic(tile, "pnts"))
        s->without = "has points, which have no faces";
    else
        result = fail_tile(s, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, at,
            "expected a tile that begins with b3dm, i3dm, cmpt or pnts");
    --s->path.depth;
    return result;
}

norma_document_result norma_gltf_find_tile(gltf *g, norma_document_error *error) {
    tile_search s = {.g = g};
    size_t next = 0;
    if (g->document->format == NORMA_FILE_GLB) return NORMA_DOCUMENT_OK;
    const norma_document_result result =
        look_into_tile(&s, 0, g->document->source.size, &next, error);
    if (result || s.found == 1) return result;
    if (s.found == 0)
        return norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, NULL,
            "the tile %s", s.without ? s.without : "is empty");
    return norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, NULL,
        "the composite has %zu tiles with meshes; only one can be read, so split it first",
        s.found);
}

size_t norma_gltf_surplus(const gltf *g) {
    const size_t size = g->container_size ? g->tile.end - g->tile.at - g->container_size : 0;
    return g->tile.depth && size < ALIGNED ? 0 : size;
}

/* ---- writing: bytes in order */

static void gltf_write_bytes(gltf_output *out, const void *bytes, size_t size) {
    if (!out->failed && size) out->failed = out->write(out->user, bytes, size);
}

static void gltf_write_fill(gltf_output *out, unsigned char fill, size_t size) {
    unsigned char block[256];
    memset(block, fill, sizeof block);
    for (; size > 0 && !out->failed; size -= size < sizeof block ? size : sizeof block)
        gltf_write_bytes(out, block, size < sizeof block ? size : sizeof block);
}

static void gltf_write_u32(gltf_output *out, uint32_t value) {
    const unsigned char bytes[4] = {(unsigned char)value, (unsigned char)(value >> 8),
        (unsigned char)(value >> 16), (unsigned char)(value >> 24)};
    gltf_write_bytes(out, bytes, 4);
}

/* ---- what is around a GLB */

/* How many zeros follow a GLB of so many bytes. */
static size_t tile_padding(const gltf *g, size_t glb) {
    if (!g->tile.depth) return 0;
    const size_t length =
        g->tile.at - g->tile.headers[g->tile.depth - 1] + glb + norma_gltf_surplus(g);
    return (ALIGNED - length % ALIGNED) % ALIGNED;
}

static size_t gltf_tile_size(const gltf *g, size_t glb) {
    return g->tile.at + glb + norma_gltf_surplus(g) + tile_padding(g, glb) +
           (g->document->source.size - g->tile.end);
}

static void gltf_begin_tile(const gltf *g, size_t glb, gltf_output *out) {
    const unsigned char *source = g->document->source.data;
    const uint32_t grown = (uint32_t)(gltf_tile_size(g, glb) - g->document->source.size);
    size_t at = 0;
    for (uint32_t i = 0; i < g->tile.depth; ++i) {
        const size_t length = g->tile.headers[i] + BYTE_LENGTH;
        gltf_write_bytes(out, source + at, length - at);
        gltf_write_u32(out, norma_gltf_u32(source + length) + grown);
        at = length + 4;
    }
    gltf_write_bytes(out, source + at, g->tile.at - at);
}

static void gltf_end_tile(const gltf *g, size_t glb, gltf_output *out) {
    const unsigned char *source = g->document->source.data;
    gltf_write_bytes(out, source + g->tile.at + g->container_size, norma_gltf_surplus(g));
    gltf_write_fill(out, 0, tile_padding(g, glb));
    gltf_write_bytes(out, source + g->tile.end, g->document->source.size - g->tile.end);
}

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

static void append_copies(gltf *g) {
    const gltf_patch *patch = g->patch;
    for (size_t i = 0; i < patch->copy_count; ++i) {
        json_text text = {0};
        text.failed = !norma_json_write(
            patch->copies[i].edits, g->meshes[patch->copies[i].mesh].token, &text);
        norma_json_append_made(g->edits, 0, "meshes", &text);
    }
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
    if (!result) append_copies(g);
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
            gltf_write_bytes(out, buffer->segments[i].bytes, buffer->segments[i].length);
        else
            gltf_write_fill(out, 0, buffer->segments[i].length);
    }
}

static void put_bin(gltf_output *out, const patch_buffer *bin) {
    gltf_write_u32(out, (uint32_t)(bin->length + padding(bin->length)));
    gltf_write_u32(out, GLB_BIN);
    put_segments(out, bin);
    gltf_write_fill(out, 0, padding(bin->length));
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
    if (gltf_tile_size(g, total) > UINT32_MAX)
        return norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, NULL,
            "would become larger than the 4 GiB that a GLB can be; expected a .gltf with its "
            "buffers beside it");
    gltf_begin_tile(g, total, out);
    gltf_write_bytes(out, "glTF", 4);
    gltf_write_u32(out, 2);
    gltf_write_u32(out, (uint32_t)total);
    gltf_write_u32(out, (uint32_t)json_size);
    gltf_write_bytes(out, "JSON", 4);
    gltf_write_bytes(out, text->data, text->size);
    gltf_write_fill(out, ' ', padding(text->size));
    if (bin && !g->bin) put_bin(out, bin);
    for (size_t at = first; at < g->container_size; at += chunk_size(g, at)) {
        if (bin && g->bin && at == g->bin_chunk)
            put_bin(out, bin);
        else
            gltf_write_bytes(out, source + at, chunk_size(g, at));
    }
    gltf_end_tile(g, total, out);
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
        gltf_write_bytes(&out, text.data, text.size);
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
