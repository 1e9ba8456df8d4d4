/* ply_error.c: errors of a PLY with their place: a line in text, a byte in binary rows. */
#include "io/ply/ply.h"
#include <stdarg.h>
#include <stdio.h>

size_t norma_ply_line_of(const ply_state *state, size_t offset) {
    unsigned char line_end = state->bytes[state->header.line_break.offset] == '\r' &&
                                     state->header.line_break.length == 1
                                 ? '\r'
                                 : '\n';
    size_t line = 1;
    for (const unsigned char *at = state->bytes, *end = at + offset;
         (at = memchr(at, line_end, (size_t)(end - at))) != NULL; ++at)
        ++line;
    return line;
}

norma_document_result norma_ply_fail_at(const norma_document *document, norma_document_error *error,
    size_t offset, const char *format, ...) {
    char place[40], message[400];
    const ply_state *state = document->state;
    int in_text =
        state->header.encoding == PLY_ASCII || (state->header.body && offset < state->header.body);
    snprintf(place, sizeof place, in_text ? "%zu" : "byte %zu",
        in_text ? norma_ply_line_of(state, offset < state->size ? offset : state->size) : offset);
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    return norma_document_fail(
        document, error, NORMA_DOCUMENT_ERROR_MALFORMED, place, "%s", message);
}

norma_document_result norma_ply_fail_short(const norma_document *document,
    norma_document_error *error, size_t size, const ply_element *element, uint64_t row) {
    const ply_state *state = document->state;
    return norma_ply_fail_at(document, error, size,
        "the file ends in row %llu of element \"%.*s\", which should have %llu rows",
        (unsigned long long)row, element->name.length > 60 ? 60 : (int)element->name.length,
        (const char *)state->bytes + element->name.offset, (unsigned long long)element->count);
}

norma_document_result norma_ply_fail_index(const norma_document *document,
    norma_document_error *error, size_t offset, const char *of, uint64_t row, int64_t index,
    size_t vertices) {
    return norma_ply_fail_at(document, error, offset,
        "%s %llu names vertex %lld; vertices are numbered from 0 to %lld", of,
        (unsigned long long)row, (long long)index, (long long)vertices - 1);
}
