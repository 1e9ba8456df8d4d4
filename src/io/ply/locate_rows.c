/* locate_rows.c: where the rows of each element lie. Rows of fixed size are skipped by arithmetic;
 * only lists in binary rows and text must be walked. Counts are bounded by the bytes that are there
 * before anything follows from them. */
#include "io/ply/ply.h"
#include "io/text/number.h"
#include "io/stream/tasks.h"

/* The bytes of one row, or 0 where it does not lie within the file or a count of a list is negative
 * (then *bad is where). */
static size_t measure_row(
    const ply_state *state, const ply_element *element, size_t begin, size_t *bad) {
    const ply_header *header = &state->header;
    size_t at = begin;
    for (size_t i = 0; i < element->property_count; ++i) {
        const ply_property *property = norma_ply_property(header, element, (int)i);
        size_t left = state->size - at;
        size_t fixed = norma_ply_type_size(
            norma_ply_is_list(property) ? property->count_type : property->type);
        if (left < fixed) return 0;
        at += fixed;
        if (!norma_ply_is_list(property)) continue;
        int64_t count = norma_ply_get_integer(
            state->bytes + at - fixed, property->count_type, header->encoding);
        if (count < 0) *bad = at - fixed;
        if (count < 0 || (uint64_t)count > (left - fixed) / norma_ply_type_size(property->type))
            return 0;
        at += (size_t)count * norma_ply_type_size(property->type);
    }
    return at - begin;
}

enum { LEAST_SLICE = 1 << 16 };

/* Rows of a list of three, as far as their counts say so. */
typedef struct triangle_check {
    const unsigned char *rows;
    size_t count, row_size, slices;
    unsigned char differs[256]; /* of each slice */
} triangle_check;

static void check_slice(void *context, size_t slice) {
    triangle_check *check = context;
    const size_t end = norma_io_slice(check->count, check->slices, slice + 1);
    unsigned differs = 0;
    for (size_t i = norma_io_slice(check->count, check->slices, slice); i < end; ++i)
        differs |= check->rows[i * check->row_size] ^ 3u;
    check->differs[slice] = differs != 0;
}

/* The commonest faces by far are triangles: then no row hangs on the one before it, and all are
 * looked at side by side. */
static int are_triangles(
    const norma_document *document, const ply_element *element, size_t at, size_t row_size) {
    const ply_state *state = document->state;
    if (element->count == 0 || element->count > (state->size - at) / row_size ||
        state->bytes[at] != 3)
        return 0;
    triangle_check check = {
        .rows = state->bytes + at, .count = (size_t)element->count, .row_size = row_size};
    check.slices = norma_io_slices(check.count, LEAST_SLICE);
    norma_io_tasks(document->threads, check.slices, check_slice, &check);
    return memchr(check.differs, 1, check.slices) == NULL;
}

/* Other faces of one list whose count is a byte. Stops where a row does not fit. */
static uint64_t walk_short_lists(const ply_state *state, const ply_element *element, size_t *at) {
    const size_t item = norma_ply_type_size(norma_ply_property(&state->header, element, 0)->type);
    uint64_t row = 0;
    for (size_t size; row < element->count && *at < state->size; ++row, *at += size) {
        size = 1 + state->bytes[*at] * item;
        if (size > state->size - *at) break;
    }
    return row;
}

static norma_document_result walk_lists(const norma_document *document, ply_element *element,
    size_t *end, norma_document_error *error) {
    const ply_state *state = document->state;
    size_t at = *end, bad = SIZE_MAX;
    uint64_t row = 0;
    if (element->property_count == 1 &&
        norma_ply_property(&state->header, element, 0)->count_type == PLY_UINT8) {
        const size_t row_size =
            1 + 3 * norma_ply_type_size(norma_ply_property(&state->header, element, 0)->type);
        if (are_triangles(document, element, at, row_size)) {
            element->triangle_row = row_size;
            *end = at + (size_t)element->count * row_size;
            return NORMA_DOCUMENT_OK;
        }
        row = walk_short_lists(state, element, &at);
    }
    for (; row < element->count; ++row) {
        size_t size = measure_row(state, element, at, &bad);
        if (bad != SIZE_MAX)
            return norma_ply_fail_at(document, error, bad, "a list of negative length");
        if (size == 0) return norma_ply_fail_short(document, error, state->size, element, row);
        at += size;
    }
    *end = at;
    return NORMA_DOCUMENT_OK;
}

static norma_document_result locate_binary(norma_document *document, norma_document_error *error) {
    ply_state *state = document->state;
    size_t at = state->header.body;
    for (size_t i = 0; i < state->header.element_count; ++i) {
        ply_element *element = &state->header.elements[i];
        element->begin = at;
        if (element->fixed_size > 0 && element->count > (state->size - at) / element->fixed_size)
            return norma_ply_fail_short(
                document, error, state->size, element, (state->size - at) / element->fixed_size);
        if (element->list_count == 0)
            at += (size_t)element->count * element->fixed_size;
        else {
            norma_document_result result = walk_lists(document, element, &at, error);
            if (result) return result;
        }
        element->end = at;
    }
    if (at < state->size)
        norma_document_add_note(
            document, "%zu bytes after the last element are kept as they are", state->size - at);
    return NORMA_DOCUMENT_OK;
}

norma_document_result norma_ply_locate(norma_document *document, norma_document_error *error) {
    ply_state *state = document->state;
    return state->header.encoding == PLY_ASCII ? norma_ply_locate_text(document, error)
                                               : locate_binary(document, error);
}
