/* ply_header.c: the header of a PLY, the types of its values, and errors with their place. */
#include "io/ply/ply.h"
#include "io/text/text.h"
#include <math.h>
#include <stdarg.h>
#include <stdio.h>

/* ---- The types of PLY values; single values, binary in either byte order and as text; the
 * size of a binary row. */

static const struct {
    const char *name, *bits_name;
    size_t size;
} TYPES[] = {
    [PLY_INT8] = {"char", "int8", 1},
    [PLY_UINT8] = {"uchar", "uint8", 1},
    [PLY_INT16] = {"short", "int16", 2},
    [PLY_UINT16] = {"ushort", "uint16", 2},
    [PLY_INT32] = {"int", "int32", 4},
    [PLY_UINT32] = {"uint", "uint32", 4},
    [PLY_FLOAT] = {"float", "float32", 4},
    [PLY_DOUBLE] = {"double", "float64", 8},
    [PLY_NO_TYPE] = {"", "", 0},
};

size_t norma_ply_type_size(ply_type type) { return TYPES[type].size; }
const char *norma_ply_type_name(ply_type type, int with_bits) {
    return with_bits ? TYPES[type].bits_name : TYPES[type].name;
}

int norma_ply_is_native(ply_encoding encoding) {
    const uint16_t probe = 1;
    unsigned char first;
    memcpy(&first, &probe, 1);
    return encoding == (first ? PLY_LITTLE_ENDIAN : PLY_BIG_ENDIAN);
}

static uint64_t ply_load(const unsigned char *at, size_t size, ply_encoding encoding) {
    uint64_t bits = 0;
    for (size_t i = 0; i < size; ++i)
        bits = bits << 8 | at[encoding == PLY_BIG_ENDIAN ? i : size - 1 - i];
    return bits;
}

static void ply_store(unsigned char *at, size_t size, ply_encoding encoding, uint64_t bits) {
    for (size_t i = 0; i < size; ++i)
        at[encoding == PLY_BIG_ENDIAN ? size - 1 - i : i] = (unsigned char)(bits >> (8 * i));
}

int64_t norma_ply_get_integer(const unsigned char *at, ply_type type, ply_encoding encoding) {
    switch (type) {
    case PLY_INT8:
        return *at < 0x80 ? *at : (int64_t)*at - 0x100;
    case PLY_UINT8:
        return *at;
    case PLY_INT16: {
        int64_t value = (int64_t)ply_load(at, 2, encoding);
        return value < 0x8000 ? value : value - 0x10000;
    }
    case PLY_UINT16:
        return (int64_t)ply_load(at, 2, encoding);
    case PLY_INT32: {
        int64_t value = (int64_t)ply_load(at, 4, encoding);
        return value < INT64_C(0x80000000) ? value : value - INT64_C(0x100000000);
    }
    default:
        return (int64_t)ply_load(at, 4, encoding);
    }
}

double norma_ply_get(const unsigned char *at, ply_type type, ply_encoding encoding) {
    if (type == PLY_FLOAT) {
        uint32_t bits = (uint32_t)ply_load(at, 4, encoding);
        float value;
        memcpy(&value, &bits, sizeof value);
        return (double)value;
    }
    if (type == PLY_DOUBLE) {
        uint64_t bits = ply_load(at, 8, encoding);
        double value;
        memcpy(&value, &bits, sizeof value);
        return value;
    }
    return (double)norma_ply_get_integer(at, type, encoding);
}

void norma_ply_put(unsigned char *at, ply_type type, ply_encoding encoding, double value) {
    if (type == PLY_FLOAT) {
        float narrow = (float)value;
        uint32_t bits;
        memcpy(&bits, &narrow, sizeof bits);
        ply_store(at, 4, encoding, bits);
    } else if (type == PLY_DOUBLE) {
        uint64_t bits;
        memcpy(&bits, &value, sizeof bits);
        ply_store(at, 8, encoding, bits);
    } else {
        ply_store(at, norma_ply_type_size(type), encoding, (uint64_t)(int64_t)value);
    }
}

int norma_ply_type_holds(ply_type type, double value) {
    static const double lowest[] = {
        [PLY_INT8] = -128, [PLY_INT16] = -32768, [PLY_INT32] = -2147483648.0, [PLY_DOUBLE] = 0};
    static const double highest[] = {[PLY_INT8] = 127,
        [PLY_UINT8] = 255,
        [PLY_INT16] = 32767,
        [PLY_UINT16] = 65535,
        [PLY_INT32] = 2147483647.0,
        [PLY_UINT32] = 4294967295.0,
        [PLY_DOUBLE] = 0};
    if (type == PLY_FLOAT) return !isfinite(value) || fabs(value) < 0x1.ffffffp127;
    if (type == PLY_DOUBLE) return 1;
    return value >= lowest[type] && value <= highest[type] && value == floor(value);
}

size_t norma_ply_format(ply_type type, double value, int unit, char text[32]) {
    if (type == PLY_DOUBLE && !unit) return norma_number_format_double(value, text);
    if (type >= PLY_FLOAT)
        return unit ? norma_number_format_normal((float)value, text)
                    : norma_number_format_float((float)value, text);
    size_t sign = value < 0;
    text[0] = '-';
    size_t length = sign + norma_number_format_integer((uint64_t)(int64_t)fabs(value), text + sign);
    text[length] = '\0';
    return length;
}

size_t norma_ply_property_size(
    const ply_header *header, const ply_property *property, const unsigned char *at) {
    if (!norma_ply_is_list(property)) return norma_ply_type_size(property->type);
    int64_t count = norma_ply_get_integer(at, property->count_type, header->encoding);
    return norma_ply_type_size(property->count_type) +
           (size_t)count * norma_ply_type_size(property->type);
}

const unsigned char *norma_ply_row_end(
    const ply_header *header, const ply_element *element, const unsigned char *row) {
    if (element->list_count == 0) return row + element->fixed_size;
    for (size_t i = 0; i < element->property_count; ++i)
        row += norma_ply_property_size(header, norma_ply_property(header, element, (int)i), row);
    return row;
}

/* ---- rows of one size */

size_t norma_ply_offset_in_row(const ply_header *header, const ply_element *element, int property) {
    size_t offset = 0;
    for (int i = 0; i < property; ++i)
        offset += norma_ply_type_size(norma_ply_property(header, element, i)->type);
    return offset;
}

void norma_ply_decode_rows(const ply_header *header, const ply_element *element,
    const int properties[3], const unsigned char *rows, size_t count, double *values) {
    for (int axis = 0; axis < 3; ++axis) {
        const ply_type type = norma_ply_property(header, element, properties[axis])->type;
        const unsigned char *at = rows + norma_ply_offset_in_row(header, element, properties[axis]);
        for (size_t row = 0; row < count; ++row, at += element->fixed_size)
            values[3 * row + (size_t)axis] = norma_ply_get(at, type, header->encoding);
    }
}

int norma_ply_fits_float(
    const ply_header *header, const ply_element *element, const int properties[3]) {
    for (int axis = 0; axis < 3; ++axis) {
        const ply_type type = norma_ply_property(header, element, properties[axis])->type;
        if (type == PLY_INT32 || type == PLY_UINT32 || type == PLY_DOUBLE) return 0;
    }
    return 1;
}

/* Each float lies before or on the double it comes from. */
void norma_ply_narrow(double *values, size_t count) {
    unsigned char *bytes = (unsigned char *)values;
    for (size_t i = 0; i < count; ++i) {
        const float value = (float)values[i];
        memcpy(bytes + i * sizeof value, &value, sizeof value);
    }
}

uint32_t norma_ply_copy_triangles(
    const unsigned char *at, size_t row_size, size_t count, uint32_t *corners) {
    uint32_t greatest = 0;
    for (size_t i = 0; i < count; ++i, at += row_size, corners += 3) {
        memcpy(corners, at, 12);
        for (size_t k = 0; k < 3; ++k) greatest = corners[k] > greatest ? corners[k] : greatest;
    }
    return greatest;
}

/* ---- Errors of a PLY with their place: a line in text, a byte in binary rows. */

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

/* ---- The header of a PLY file: elements, properties and where each word of them stands, so
 * that single words can be replaced.
 *
 * Lines end in LF, CRLF or CR. Which of them is told by the first line: in a file whose first line
 * ends in CR alone, a body may begin with 0x0A, and in one with LF a line may still end in CRLF. */

enum { MAX_WORDS = 6 };

int norma_ply_span_is(const ply_state *state, ply_span span, const char *text) {
    return span.length == strlen(text) &&
           memcmp(state->bytes + span.offset, text, span.length) == 0;
}

/* ---- lines and words */

typedef struct header_line {
    size_t number, begin, end, next; /* next: where the next line begins */
    ply_span words[MAX_WORDS];
    size_t word_count; /* all of them, also those beyond MAX_WORDS */
} header_line;

typedef struct header_reader {
    norma_document *document;
    norma_document_error *error;
    ply_state *state;
    header_line line;
    int cr_only;
} header_reader;

static norma_document_result fail_line(
    const header_reader *reader, const char *what, ply_span span) {
    char place[24];
    place[norma_number_format_integer(reader->line.number, place)] = '\0';
    const ply_state *state = reader->state;
    int length = span.length > 60 ? 60 : (int)span.length;
    if (length == 0)
        return norma_document_fail(
            reader->document, reader->error, NORMA_DOCUMENT_ERROR_MALFORMED, place, "%s", what);
    return norma_document_fail(reader->document, reader->error, NORMA_DOCUMENT_ERROR_MALFORMED,
        place, "\"%.*s\": %s", length, (const char *)state->bytes + span.offset, what);
}

static void split_words(const ply_state *state, header_line *line) {
    line->word_count = 0;
    for (size_t at = line->begin; at < line->end;) {
        while (at < line->end && norma_is_blank(state->bytes[at])) ++at;
        size_t begin = at;
        while (at < line->end && !norma_is_blank(state->bytes[at])) ++at;
        if (at > begin && line->word_count++ < MAX_WORDS)
            line->words[line->word_count - 1] = (ply_span){begin, at - begin};
    }
}

/* 0 at the end of the file. */
static int next_line(header_reader *reader) {
    const ply_state *state = reader->state;
    header_line *line = &reader->line;
    if (line->next >= state->size) return 0;
    line->begin = line->next;
    const unsigned char *from = state->bytes + line->begin;
    const unsigned char *found =
        memchr(from, reader->cr_only ? '\r' : '\n', state->size - line->begin);
    line->end = found ? (size_t)(found - state->bytes) : state->size;
    line->next = found ? line->end + 1 : state->size;
    ++line->number;
    split_words(state, line);
    return 1;
}

/* From its first word, which it has, to the end of its last. */
static ply_span whole_line(const ply_state *state, const header_line *line) {
    size_t begin = line->words[0].offset, end = line->end;
    while (norma_is_blank(state->bytes[end - 1])) --end;
    return (ply_span){begin, end - begin};
}

static norma_document_result read_magic(header_reader *reader) {
    ply_state *state = reader->state;
    if (state->size < 4 || memcmp(state->bytes, "ply", 3) != 0 || !norma_is_blank(state->bytes[3]))
        return norma_document_fail(reader->document, reader->error, NORMA_DOCUMENT_ERROR_MALFORMED,
            "1", "%s; a PLY file begins with the line \"ply\"",
            state->size == 0 ? "the file is empty" : "not a PLY file");
    size_t at = 3;
    while (at < state->size && (state->bytes[at] == ' ' || state->bytes[at] == '\t')) ++at;
    size_t length = 1;
    if (at + 1 < state->size && state->bytes[at] == '\r')
        length = state->bytes[at + 1] == '\n' ? 2 : 1;
    reader->cr_only = at < state->size && state->bytes[at] == '\r' && length == 1;
    state->header.line_break = (ply_span){at, at < state->size ? length : 0};
    next_line(reader);
    return reader->line.word_count == 1
               ? NORMA_DOCUMENT_OK
               : fail_line(reader, "the first line should be \"ply\" alone",
                     whole_line(reader->state, &reader->line));
}

/* ---- statements */

static norma_document_result read_format(header_reader *reader) {
    static const char *const names[] = {[PLY_ASCII] = "ascii",
        [PLY_LITTLE_ENDIAN] = "binary_little_endian",
        [PLY_BIG_ENDIAN] = "binary_big_endian"};
    const header_line *line = &reader->line;
    if (line->word_count != 3 || !norma_ply_span_is(reader->state, line->words[2], "1.0"))
        return fail_line(reader, "this line should be \"format\", an encoding and \"1.0\"",
            whole_line(reader->state, line));
    for (int i = PLY_ASCII; i <= PLY_BIG_ENDIAN; ++i) {
        if (norma_ply_span_is(reader->state, line->words[1], names[i])) {
            reader->state->header.encoding = (ply_encoding)i;
            return NORMA_DOCUMENT_OK;
        }
    }
    return fail_line(reader,
        "this encoding is not known; PLY has ascii, binary_little_endian and binary_big_endian",
        line->words[1]);
}

static norma_document_result ply_read_element(header_reader *reader) {
    const header_line *line = &reader->line;
    ply_state *state = reader->state;
    ply_header *header = &state->header;
    if (line->word_count != 3)
        return fail_line(reader, "this line should be \"element\", a name and a count",
            whole_line(reader->state, line));
    int64_t count;
    const char *text = (const char *)state->bytes + line->words[2].offset,
               *end = text + line->words[2].length;
    if (norma_number_parse_integer(text, end, &count) != end || count < 0)
        return fail_line(reader, "this should be the number of rows", line->words[2]);
    ply_element *element = norma_io_add(
        &header->elements, &header->element_capacity, &header->element_count, sizeof *element);
    if (!element) return norma_document_fail_memory(reader->document, reader->error);
    *element = (ply_element){.name = line->words[1],
        .count_text = line->words[2],
        .count = (uint64_t)count,
        .first_property = header->property_count};
    return NORMA_DOCUMENT_OK;
}

static ply_type type_of(const ply_state *state, ply_span word) {
    for (int i = 0; i < PLY_NO_TYPE; ++i)
        if (norma_ply_span_is(state, word, norma_ply_type_name((ply_type)i, 0)) ||
            norma_ply_span_is(state, word, norma_ply_type_name((ply_type)i, 1)))
            return (ply_type)i;
    return PLY_NO_TYPE;
}

static norma_document_result parse_property(header_reader *reader, ply_property *property) {
    const header_line *line = &reader->line;
    const ply_state *state = reader->state;
    int is_list = line->word_count > 1 && norma_ply_span_is(state, line->words[1], "list");
    if (line->word_count != (is_list ? 5u : 3u))
        return fail_line(reader,
            is_list
                ? "this line should be \"property list\", the types of count and items, and a name"
                : "this line should be \"property\", a type and a name",
            whole_line(reader->state, line));
    size_t type_word = is_list ? 3 : 1;
    *property = (ply_property){.name = line->words[type_word + 1],
        .type_text = line->words[type_word],
        .line_end = line->next,
        .count_type = PLY_NO_TYPE};
    property->type = type_of(state, property->type_text);
    if (property->type == PLY_NO_TYPE)
        return fail_line(reader,
            "this type is not known; PLY has char, uchar, short, ushort, int, uint, float, double "
            "and int8 to float64",
            property->type_text);
    if (!is_list) return NORMA_DOCUMENT_OK;
    property->count_type_text = line->words[2];
    property->count_type = type_of(state, line->words[2]);
    if (property->count_type >= PLY_FLOAT)
        return fail_line(reader, "the count of a list should have an integer type", line->words[2]);
    return NORMA_DOCUMENT_OK;
}

static norma_document_result read_property(header_reader *reader) {
    ply_header *header = &reader->state->header;
    if (header->element_count == 0)
        return fail_line(reader, "a property before the first element",
            whole_line(reader->state, &reader->line));
    ply_property property = {0};
    norma_document_result result = parse_property(reader, &property);
    if (result) return result;
    ply_property *added = norma_io_add(
        &header->properties, &header->property_capacity, &header->property_count, sizeof *added);
    if (!added) return norma_document_fail_memory(reader->document, reader->error);
    *added = property;
    ply_element *element = &header->elements[header->element_count - 1];
    ++element->property_count;
    element->list_count += property.count_type != PLY_NO_TYPE;
    element->fixed_size +=
        norma_ply_type_size(norma_ply_is_list(&property) ? property.count_type : property.type);
    return NORMA_DOCUMENT_OK;
}

/* Old Blender versions wrote a line without the word "comment" before the first element: passed
 * over there, with a note. */
static norma_document_result read_unknown(header_reader *reader, int has_format) {
    const header_line *line = &reader->line;
    if (!has_format)
        return fail_line(reader, "this line should be \"format\", an encoding and \"1.0\"",
            whole_line(reader->state, line));
    if (reader->state->header.element_count > 0)
        return fail_line(reader,
            "this line should begin with element, property, comment, obj_info or end_header",
            whole_line(reader->state, line));
    ply_span text = whole_line(reader->state, line);
    int length = text.length > 60 ? 60 : (int)text.length;
    norma_document_add_note(reader->document,
        "header line %zu is not a PLY statement and was ignored: \"%.*s\"", line->number, length,
        (const char *)reader->state->bytes + text.offset);
    return NORMA_DOCUMENT_OK;
}

static norma_document_result ply_read_statement(
    header_reader *reader, int *has_format, int *ended) {
    const header_line *line = &reader->line;
    const ply_state *state = reader->state;
    if (line->word_count == 0) return NORMA_DOCUMENT_OK;
    ply_span word = line->words[0];
    if (norma_ply_span_is(state, word, "comment") || norma_ply_span_is(state, word, "obj_info"))
        return NORMA_DOCUMENT_OK;
    if (norma_ply_span_is(state, word, "format") && !*has_format) {
        *has_format = 1;
        return read_format(reader);
    }
    if (*has_format && norma_ply_span_is(state, word, "element")) return ply_read_element(reader);
    if (*has_format && norma_ply_span_is(state, word, "property")) return read_property(reader);
    if (*has_format && norma_ply_span_is(state, word, "end_header") && line->word_count == 1) {
        *ended = 1;
        return NORMA_DOCUMENT_OK;
    }
    return read_unknown(reader, *has_format);
}

/* ---- which property plays which part */

static int find_element(const ply_state *state, const char *name) {
    for (size_t i = 0; i < state->header.element_count; ++i)
        if (norma_ply_span_is(state, state->header.elements[i].name, name)) return (int)i;
    return PLY_NONE;
}

static int find_property(const ply_state *state, int element, const char *name) {
    if (element == PLY_NONE) return PLY_NONE;
    const ply_element *of = &state->header.elements[element];
    for (size_t i = 0; i < of->property_count; ++i)
        if (norma_ply_span_is(state, state->header.properties[of->first_property + i].name, name))
            return (int)i;
    return PLY_NONE;
}

static int find_list(const ply_state *state, int element) {
    int found = find_property(state, element, "vertex_indices");
    return found != PLY_NONE ? found : find_property(state, element, "vertex_index");
}

static norma_document_result fail_name(const norma_document *document, norma_document_error *error,
    const ply_state *state, ply_span name, const char *what) {
    return norma_ply_fail_at(document, error, name.offset, "\"%.*s\": %s",
        name.length > 60 ? 60 : (int)name.length, (const char *)state->bytes + name.offset, what);
}

/* A name that we use may stand but once in its element. */
static norma_document_result check_triple(
    const norma_document *document, norma_document_error *error, int element, const int found[3]) {
    const ply_state *state = document->state;
    const ply_element *of = norma_ply_element(&state->header, element);
    for (int axis = 0; axis < 3 && of; ++axis) {
        if (found[axis] == PLY_NONE) continue;
        const ply_property *property = norma_ply_property(&state->header, of, found[axis]);
        if (norma_ply_is_list(property))
            return fail_name(document, error, state, property->name,
                "this is a list, but should be a single number");
        for (size_t i = (size_t)found[axis] + 1; i < of->property_count; ++i) {
            const ply_property *other = norma_ply_property(&state->header, of, (int)i);
            if (other->name.length == property->name.length &&
                memcmp(state->bytes + other->name.offset, state->bytes + property->name.offset,
                    other->name.length) == 0)
                return fail_name(document, error, state, other->name,
                    "the property appears twice in this element");
        }
    }
    return NORMA_DOCUMENT_OK;
}

static norma_document_result check_list(
    const norma_document *document, norma_document_error *error, int element, int list) {
    const ply_state *state = document->state;
    if (list == PLY_NONE) return NORMA_DOCUMENT_OK;
    const ply_property *property =
        norma_ply_property(&state->header, norma_ply_element(&state->header, element), list);
    if (!norma_ply_is_list(property) || property->type >= PLY_FLOAT)
        return fail_name(
            document, error, state, property->name, "this should be a list of integers");
    return NORMA_DOCUMENT_OK;
}

static norma_document_result check_elements(
    const norma_document *document, norma_document_error *error) {
    const ply_state *state = document->state;
    for (size_t i = 0; i < state->header.element_count; ++i) {
        ply_span name = state->header.elements[i].name;
        const int ours = norma_ply_span_is(state, name, "vertex") ||
                         norma_ply_span_is(state, name, "face") ||
                         norma_ply_span_is(state, name, "tristrips");
        for (size_t k = 0; ours && k < i; ++k) {
            ply_span other = state->header.elements[k].name;
            if (other.length == name.length &&
                memcmp(state->bytes + other.offset, state->bytes + name.offset, name.length) == 0)
                return fail_name(
                    document, error, state, name, "the element appears twice in this header");
        }
    }
    return NORMA_DOCUMENT_OK;
}

static int count_found(const int found[3]) {
    return (found[0] != PLY_NONE) + (found[1] != PLY_NONE) + (found[2] != PLY_NONE);
}

static norma_document_result assign_parts(
    const norma_document *document, norma_document_error *error) {
    static const char *const axes[3] = {"x", "y", "z"}, *const normal_axes[3] = {"nx", "ny", "nz"};
    ply_state *state = document->state;
    ply_header *header = &state->header;
    header->vertex = find_element(state, "vertex");
    header->face = find_element(state, "face");
    header->strips = find_element(state, "tristrips");
    if (header->vertex == PLY_NONE)
        return norma_ply_fail_at(
            document, error, header->body - 1, "the header declares no element \"vertex\"");
    for (int axis = 0; axis < 3; ++axis) {
        header->position[axis] = find_property(state, header->vertex, axes[axis]);
        header->normal[axis] = find_property(state, header->vertex, normal_axes[axis]);
        header->face_normal[axis] = find_property(state, header->face, normal_axes[axis]);
    }
    header->face_list = find_list(state, header->face);
    header->strip_list = find_list(state, header->strips);
    const ply_element *vertex = norma_ply_element(header, header->vertex);
    if (count_found(header->position) != 3)
        return fail_name(
            document, error, state, vertex->name, "the element needs the properties x, y and z");
    if (count_found(header->normal) % 3 != 0)
        return fail_name(document, error, state, vertex->name,
            "the element should have all of nx, ny and nz, or none of them");
    if (count_found(header->face_normal) != 3 ||
        check_triple(document, NULL, header->face, header->face_normal))
        header->face_normal[0] = header->face_normal[1] = header->face_normal[2] = PLY_NONE;
    norma_document_result result = check_elements(document, error);
    result = result ? result : check_triple(document, error, header->vertex, header->position);
    result = result ? result : check_triple(document, error, header->vertex, header->normal);
    result = result ? result : check_list(document, error, header->face, header->face_list);
    return result ? result : check_list(document, error, header->strips, header->strip_list);
}

norma_document_result norma_ply_read_header(norma_document *document, norma_document_error *error) {
    ply_state *state = document->state;
    header_reader reader = {.document = document, .error = error, .state = state};
    norma_document_result result = read_magic(&reader);
    int has_format = 0, ended = 0;
    while (!result && !ended) {
        if (!next_line(&reader))
            return fail_line(&reader, "the file ends within the header, before \"end_header\"",
                (ply_span){0, 0});
        result = ply_read_statement(&reader, &has_format, &ended);
    }
    if (result) return result;
    state->header.body = reader.line.next;
    return assign_parts(document, error);
}
