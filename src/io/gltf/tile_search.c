/* tile_search.c: where the models of a tile of 3D Tiles 1.0 (OGC 18-053r2) stand in its file. */
#include "io/gltf/gltf.h"
#include <stdio.h>
#include <string.h>

enum { BYTE_LENGTH = 8, COMPOSITE_HEADER = 16, TABLES = 12, MODEL_TABLES_END = 28 };

typedef struct tile_search {
    const norma_document *document;
    gltf_tile path;   /* the headers above what is looked at, and which have no GLB */
    size_t found;     /* GLBs */
    gltf_tile *tiles; /* written: of the first GLBs, */
    size_t room;      /* so many */
} tile_search;

static norma_document_result fail_tile(const tile_search *s, norma_document_error *error,
    norma_document_result result, size_t byte, const char *message) {
    char place[40];
    snprintf(place, sizeof place, "byte %zu", byte);
    return norma_document_fail(s->document, error, result, place, "%s", message);
}

static void leave_out_tile(tile_search *s, size_t at, const char *instead) {
    if (s->path.left_out++ > 0) return;
    s->path.left_out_at = at;
    s->path.left_out_why = instead;
}

static int has_magic(const unsigned char *at, const char *magic) {
    return memcmp(at, magic, 4) == 0;
}

/* The GLB begins behind a header and four tables, whose lengths the header lists. */
static norma_document_result find_model(
    tile_search *s, size_t at, size_t end, norma_document_error *error) {
    const unsigned char *tile = s->document->source.data + at;
    const int has_instances = has_magic(tile, "i3dm");
    uint64_t begin = MODEL_TABLES_END + (has_instances ? 4 : 0);
    if (end - at < begin)
        return fail_tile(s, error, NORMA_DOCUMENT_ERROR_MALFORMED, at, "the tile's header is cut");
    const int is_outside = has_instances && norma_gltf_u32(tile + MODEL_TABLES_END) == 0;
    for (int i = TABLES; i < MODEL_TABLES_END; i += 4) begin += norma_gltf_u32(tile + i);
    if (begin > end - at)
        return fail_tile(s, error, NORMA_DOCUMENT_ERROR_MALFORMED, at + TABLES,
            "the tables are longer than the tile; expected the 28 bytes of a header as 3D Tiles "
            "1.0 has them");
    if (is_outside) {
        leave_out_tile(s, at, "names a glTF file instead of holding one; give that file");
    } else if (s->found++ < s->room) {
        gltf_tile *tile_found = &s->tiles[s->found - 1];
        *tile_found = s->path;
        tile_found->at = at + (size_t)begin;
        tile_found->end = end;
    }
    return NORMA_DOCUMENT_OK;
}

static norma_document_result look_into_tile(
    tile_search *s, size_t at, size_t end, size_t *next, norma_document_error *error) {
    const unsigned char *tile = s->document->source.data + at;
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
        leave_out_tile(s, at, "has points, which have no faces");
    else
        result = fail_tile(s, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, at,
            "expected a tile that begins with b3dm, i3dm, cmpt or pnts");
    --s->path.depth;
    return result;
}

static norma_document_result look_into_file(tile_search *s, norma_document_error *error) {
    size_t next = 0;
    const norma_document_result result =
        look_into_tile(s, 0, s->document->source.size, &next, error);
    if (result || s->found) return result;
    return norma_document_fail(s->document, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, NULL,
        "the tile %s", s->path.left_out_why ? s->path.left_out_why : "is empty");
}

norma_document_result norma_gltf_find_tiles(const norma_document *document, gltf_tile *tiles,
    size_t room, size_t *found, gltf_tile *left_out, norma_document_error *error) {
    tile_search s = {.document = document, .tiles = tiles, .room = room};
    const norma_document_result result = look_into_file(&s, error);
    *found = s.found;
    *left_out = s.path;
    return result;
}

norma_document_result norma_gltf_find_tile(gltf *g, norma_document_error *error) {
    gltf_tile left_out;
    size_t found;
    if (g->document->format == NORMA_FILE_GLB) return NORMA_DOCUMENT_OK;
    const norma_document_result result =
        norma_gltf_find_tiles(g->document, &g->tile, 1, &found, &left_out, error);
    g->tile.left_out = left_out.left_out;
    g->tile.left_out_at = left_out.left_out_at;
    g->tile.left_out_why = left_out.left_out_why;
    return result;
}
