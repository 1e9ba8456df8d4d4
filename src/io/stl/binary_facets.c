/* binary_facets.c: binary STL: 80 bytes of anything, the number of facets, then 50 bytes for each,
 * little-endian: normal, three vertices, two bytes of attributes. */
#include "io/stl/stl.h"
#include "io/format/compute_policy.h"
#include "io/file/large_memory.h"
#include "io/stream/ordered.h"
#include <stdlib.h>

static uint32_t load_32(const unsigned char *at) {
    return (uint32_t)at[0] | (uint32_t)at[1] << 8 | (uint32_t)at[2] << 16 | (uint32_t)at[3] << 24;
}

static int is_little_endian(void) {
    const uint16_t probe = 1;
    unsigned char first;
    memcpy(&first, &probe, 1);
    return first == 1;
}

static void load_floats(const unsigned char *at, float *out, size_t count) {
    if (is_little_endian()) {
        memcpy(out, at, count * sizeof *out);
        return;
    }
    for (size_t i = 0; i < count; ++i) {
        uint32_t bits = load_32(at + 4 * i);
        memcpy(out + i, &bits, sizeof bits);
    }
}

static void store_floats(unsigned char *at, const float *values, size_t count) {
    if (is_little_endian()) {
        memcpy(at, values, count * sizeof *values);
        return;
    }
    for (size_t i = 0; i < count; ++i) {
        uint32_t bits;
        memcpy(&bits, values + i, sizeof bits);
        for (size_t k = 0; k < 4; ++k) at[4 * i + k] = (unsigned char)(bits >> (8 * k));
    }
}

/* Of a file that is read in parts no more than its beginning is there. */
static int begins_with_solid(const stl_state *state) {
    enum { MOST_BLANKS = 1 << 16 };
    static const char word[] = "solid";
    size_t at = 0;
    while (at < state->size && at < MOST_BLANKS &&
           (state->bytes[at] == ' ' || (state->bytes[at] >= '\t' && state->bytes[at] <= '\r')))
        ++at;
    for (size_t i = 0; i < 5; ++i)
        if (at + i >= state->size || (state->bytes[at + i] | 0x20) != word[i]) return 0;
    return 1;
}

/* No text holds bytes of zero, and every binary header of fewer than 2^24 facets does. */
static int looks_like_text(const stl_state *state) {
    const size_t looked_at = state->size < 1024 ? state->size : 1024;
    return memchr(state->bytes, 0, looked_at) == NULL;
}

/* The size decides, since many programs begin their binary files with "solid" too. */
int norma_stl_is_binary(const stl_state *state) {
    if (state->size >= STL_HEADER &&
        STL_HEADER + (uint64_t)STL_FACET * load_32(state->bytes + 80) == state->size)
        return 1;
    return !(begins_with_solid(state) && looks_like_text(state));
}

norma_document_result norma_stl_read_binary(norma_document *document, norma_document_error *error) {
    stl_state *state = document->state;
    if (state->size < STL_HEADER)
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_MALFORMED, "byte 0",
            "%s; an STL file begins with \"solid\" or with a binary header of 84 bytes",
            state->size == 0 ? "the file is empty" : "not an STL file");
    const uint32_t count = load_32(state->bytes + 80);
    const size_t room = (state->size - STL_HEADER) / STL_FACET;
    if (count > room)
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_MALFORMED, "byte 80",
            "the header declares %lu facets, but the file holds only %zu", (unsigned long)count,
            room);
    state->facets = count;
    const size_t rest = state->size - STL_HEADER - (size_t)count * STL_FACET;
    if (rest > 0)
        norma_document_add_note(document,
            "%zu bytes after the last of the %lu facets declared are kept as they are", rest,
            (unsigned long)count);
    return NORMA_DOCUMENT_OK;
}

void norma_stl_load(const stl_state *state, size_t facet, float normal[3], float vertices[9]) {
    const unsigned char *at = state->bytes + STL_HEADER + facet * STL_FACET;
    if (normal) load_floats(at, normal, 3);
    if (vertices) load_floats(at + STL_NORMAL, vertices, 9);
}

int norma_stl_replace_normals(
    unsigned char *bytes, size_t first, size_t count, const float *normals) {
    unsigned char *at = bytes + STL_HEADER + first * STL_FACET;
    int changed = 0;
    for (size_t i = 0; i < count; ++i, at += STL_FACET) {
        float stored[3], now[3];
        load_floats(at, stored, 3);
        for (size_t k = 0; k < 3; ++k)
            now[k] = norma_policy_keep_zero(normals[3 * i + k], (double)stored[k]);
        changed |= memcmp(now, stored, sizeof now) != 0;
        store_floats(at, now, 3);
    }
    return changed;
}

norma_document_result norma_stl_decode_binary(
    norma_document *document, norma_document_error *error) {
    stl_state *state = document->state;
    const size_t bytes_a_facet = STL_VERTICES, count = state->facets;
    if (count > SIZE_MAX / STL_FACET) return norma_document_fail_memory(document, error);
    float *positions = norma_io_block(count, bytes_a_facet),
          *normals = norma_io_block(count, STL_NORMAL);
    state->positions = positions;
    state->stored = normals;
    if (!positions || !normals) return norma_document_fail_memory(document, error);
    for (size_t i = 0; i < count; ++i) norma_stl_load(state, i, normals + 3 * i, positions + 9 * i);
    return NORMA_DOCUMENT_OK;
}

static void put_vertices(const stl_state *state, unsigned char *out, size_t facet) {
    float vertices[9];
    for (size_t i = 0; i < 9; ++i) vertices[i] = (float)state->vertices[9 * facet + i];
    store_floats(out, vertices, 9);
}

enum { SLICE = 1 << 12 }; /* facets */

static void make_facets(void *context, size_t slice, norma_data_run *piece) {
    const stl_state *state = context;
    const size_t first = slice * SLICE, left = state->facets - first,
                 end = first + (left < SLICE ? left : SLICE);
    const unsigned char *at = state->bytes + STL_HEADER + first * STL_FACET;
    for (size_t i = first; i < end; ++i, at += STL_FACET) {
        unsigned char *out = norma_sink_room(&piece->sink, STL_FACET);
        memcpy(out, at, STL_FACET);
        if (state->normals) store_floats(out, state->normals + 3 * i, 3);
        if (state->vertices) put_vertices(state, out + STL_NORMAL, i);
    }
}

norma_document_result norma_stl_write_binary(
    norma_document *document, norma_sink *sink, norma_document_error *error) {
    stl_state *state = document->state;
    norma_sink_put(sink, state->bytes, STL_HEADER);
    norma_sink_flush(sink);
    if (sink->failed) return NORMA_DOCUMENT_OK;
    norma_ordered_result result =
        norma_write_ordered((norma_ordered_how){document->threads, &document->watch},
            (state->facets + SLICE - 1) / SLICE, make_facets, state, sink->write, sink->user);
    if (result == NORMA_ORDERED_MEMORY) return norma_document_fail_memory(document, error);
    sink->failed = result != NORMA_ORDERED_OK;
    const size_t end = STL_HEADER + state->facets * STL_FACET;
    norma_sink_put(sink, state->bytes + end, state->size - end);
    return NORMA_DOCUMENT_OK;
}
