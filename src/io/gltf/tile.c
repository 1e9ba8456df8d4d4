/* tile.c: a GLB in a tile of 3D Tiles 1.0, or in a composite of tiles: where it lies, and the same
 * headers and tables around another GLB. Everything but lengths and padding stays as it is.
 * Source: OGC 18-053r2, 3D Tiles Specification 1.0, chapters 10 (Batched 3D Model), 11 (Instanced
 * 3D Model) and 13 (Composite). */
#include "io/gltf/gltf.h"
#include <stdio.h>
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

void norma_gltf_write_bytes(gltf_output *out, const void *bytes, size_t size) {
    if (!out->failed && size) out->failed = out->write(out->user, bytes, size);
}

void norma_gltf_write_fill(gltf_output *out, unsigned char fill, size_t size) {
    unsigned char block[256];
    memset(block, fill, sizeof block);
    for (; size > 0 && !out->failed; size -= size < sizeof block ? size : sizeof block)
        norma_gltf_write_bytes(out, block, size < sizeof block ? size : sizeof block);
}

void norma_gltf_write_u32(gltf_output *out, uint32_t value) {
    const unsigned char bytes[4] = {(unsigned char)value, (unsigned char)(value >> 8),
        (unsigned char)(value >> 16), (unsigned char)(value >> 24)};
    norma_gltf_write_bytes(out, bytes, 4);
}

/* ---- what is around a GLB */

/* How many zeros follow a GLB of so many bytes. */
static size_t tile_padding(const gltf *g, size_t glb) {
    if (!g->tile.depth) return 0;
    const size_t length =
        g->tile.at - g->tile.headers[g->tile.depth - 1] + glb + norma_gltf_surplus(g);
    return (ALIGNED - length % ALIGNED) % ALIGNED;
}

size_t norma_gltf_tile_size(const gltf *g, size_t glb) {
    return g->tile.at + glb + norma_gltf_surplus(g) + tile_padding(g, glb) +
           (g->document->source.size - g->tile.end);
}

void norma_gltf_begin_tile(const gltf *g, size_t glb, gltf_output *out) {
    const unsigned char *source = g->document->source.data;
    const uint32_t grown = (uint32_t)(norma_gltf_tile_size(g, glb) - g->document->source.size);
    size_t at = 0;
    for (uint32_t i = 0; i < g->tile.depth; ++i) {
        const size_t length = g->tile.headers[i] + BYTE_LENGTH;
        norma_gltf_write_bytes(out, source + at, length - at);
        norma_gltf_write_u32(out, norma_gltf_u32(source + length) + grown);
        at = length + 4;
    }
    norma_gltf_write_bytes(out, source + at, g->tile.at - at);
}

void norma_gltf_end_tile(const gltf *g, size_t glb, gltf_output *out) {
    const unsigned char *source = g->document->source.data;
    norma_gltf_write_bytes(out, source + g->tile.at + g->container_size, norma_gltf_surplus(g));
    norma_gltf_write_fill(out, 0, tile_padding(g, glb));
    norma_gltf_write_bytes(out, source + g->tile.end, g->document->source.size - g->tile.end);
}
