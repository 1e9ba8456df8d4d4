/* ascii_read.c: the rows of an ascii PLY. Each row is a line of words; a row may run on over
 * several lines, but two rows never share one: words that the header does not declare are passed
 * over to the end of the line. */
#include "io/ply/ply.h"
#include "io/text/number.h"
#include <stdio.h>
#include <stdlib.h>

static int is_blank(unsigned char byte) { return byte == ' ' || (byte >= '\t' && byte <= '\r'); }

const unsigned char *norma_ply_token(
    const unsigned char *at, const unsigned char *end, size_t *length) {
    while (at < end && is_blank(*at)) ++at;
    const unsigned char *begin = at;
    while (at < end && !is_blank(*at)) ++at;
    *length = (size_t)(at - begin);
    return at > begin ? begin : NULL;
}

/* ---- walking */

enum { COUNT_ITEM = -1 }; /* the number of a list's count among its items */

/* Told every word; item is 0 for a single value. Nonzero stops the walk: the word is then not what
 * it should be. */
typedef int token_visitor(
    void *user, int property, int64_t item, const char *text, const char *end);

typedef struct text_walker {
    const norma_document *document;
    norma_document_error *error;
    const ply_element *element;
    const unsigned char *at, *end;
    token_visitor *visit;
    void *user;
    uint64_t row;
    const unsigned char *row_end, *surplus; /* of the last row: behind its last word; its first word
                                               that the header does not declare, or NULL */
    const void *asked;                      /* where it was last asked whether to go on */
} text_walker;

static int is_cancelled(text_walker *walker) {
    return norma_watch_passed(norma_document_watch(walker->document), &walker->asked, walker->at);
}

static norma_document_result fail_row(
    const text_walker *walker, const unsigned char *at, const char *what) {
    const ply_state *state = walker->document->state;
    ply_span name = walker->element->name;
    return norma_ply_fail_at(walker->document, walker->error, (size_t)(at - state->bytes),
        "row %llu of element \"%.*s\": %s", (unsigned long long)walker->row,
        name.length > 60 ? 60 : (int)name.length, (const char *)state->bytes + name.offset, what);
}

static norma_document_result next_word(text_walker *walker, const char **text, size_t *length) {
    const unsigned char *word = norma_ply_token(walker->at, walker->end, length);
    if (!word) return fail_row(walker, walker->end, "the file ends before the row does");
    walker->at = word + *length;
    *text = (const char *)word;
    return NORMA_DOCUMENT_OK;
}

static norma_document_result walk_value(text_walker *walker, int property, int64_t item) {
    const char *text = NULL;
    size_t length = 0;
    norma_document_result result =
        is_cancelled(walker) ? NORMA_DOCUMENT_CANCELLED : next_word(walker, &text, &length);
    if (!result && walker->visit &&
        walker->visit(walker->user, property, item, text, text + length))
        return fail_row(
            walker, (const unsigned char *)text, "this is not a number of the property's type");
    return result;
}

static norma_document_result walk_list(text_walker *walker, int property) {
    const char *text = NULL;
    size_t length = 0;
    norma_document_result result = next_word(walker, &text, &length);
    if (result) return result;
    int64_t count;
    if (norma_number_parse_integer(text, text + length, &count) != text + length || count < 0)
        return fail_row(walker, (const unsigned char *)text,
            "the count of a list should be a whole number from 0 up");
    if (count > (walker->end - walker->at + 1) / 2)
        return fail_row(
            walker, (const unsigned char *)text, "the list is longer than the rest of the file");
    if (walker->visit && walker->visit(walker->user, property, COUNT_ITEM, text, text + length))
        return norma_document_fail_memory(walker->document, walker->error);
    for (int64_t item = 0; item < count && !result; ++item)
        result = walk_value(walker, property, item);
    return result;
}

/* Words that the header does not declare are passed over to the end of the line. */
static void end_row(text_walker *walker) {
    walker->row_end = walker->at;
    walker->surplus = NULL;
    for (; walker->at < walker->end && !norma_ply_ends_line(*walker->at); ++walker->at) {
        if (is_cancelled(walker)) return;
        if (*walker->at == ' ' || *walker->at == '\t') continue;
        if (!walker->surplus) walker->surplus = walker->at;
        walker->row_end = walker->at + 1;
    }
    if (walker->at == walker->end) return;
    unsigned char first = *walker->at++;
    if (first == '\r' && walker->at < walker->end && *walker->at == '\n') ++walker->at;
}

static norma_document_result walk_row(text_walker *walker) {
    const ply_state *state = walker->document->state;
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (size_t i = 0; i < walker->element->property_count && !result; ++i) {
        const ply_property *property = norma_ply_property(&state->header, walker->element, (int)i);
        result =
            norma_ply_is_list(property) ? walk_list(walker, (int)i) : walk_value(walker, (int)i, 0);
    }
    if (!result) end_row(walker);
    return result;
}

static norma_document_result walk_rows(text_walker *walker) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    if (walker->element->property_count == 0) return result;
    for (walker->row = 0; walker->row < walker->element->count && !result; ++walker->row)
        result = walk_row(walker);
    return result;
}

/* The same, once, counting the rows that hold more than they should. */
static norma_document_result locate_rows(text_walker *walker, ply_state *state) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    if (walker->element->property_count == 0) return result;
    for (; walker->row < walker->element->count && !result; ++walker->row) {
        result = walk_row(walker);
        if (result || !walker->surplus) continue;
        if (state->surplus_rows++ == 0)
            state->first_surplus = (size_t)(walker->surplus - state->bytes);
    }
    return result;
}

void norma_ply_surplus_text(const ply_state *state, char text[120]) {
    snprintf(text, 120, "%zu %s more values than the header declares, first in line %zu",
        state->surplus_rows, state->surplus_rows == 1 ? "row holds" : "rows hold",
        norma_ply_line_of(state, state->first_surplus));
}

norma_document_result norma_ply_locate_text(norma_document *document, norma_document_error *error) {
    ply_state *state = document->state;
    text_walker walker = {.document = document,
        .error = error,
        .at = state->bytes + state->header.body,
        .asked = state->bytes,
        .end = state->bytes + state->size};
    for (size_t i = 0; i < state->header.element_count; ++i) {
        ply_element *element = &state->header.elements[i];
        size_t left = (size_t)(walker.end - walker.at);
        walker.element = element;
        walker.row = 0;
        if (element->property_count > 0 &&
            element->count > (left + 1) / 2 / element->property_count)
            return fail_row(
                &walker, walker.end, "the file is too short for the rows that the header declares");
        element->begin = (size_t)(walker.at - state->bytes);
        norma_document_result result = locate_rows(&walker, state);
        if (result) return result;
        element->end = (size_t)(walker.at - state->bytes);
    }
    char surplus[120];
    norma_ply_surplus_text(state, surplus);
    if (state->surplus_rows)
        norma_document_add_note(document, "%s; they are kept, not read", surplus);
    size_t length;
    const unsigned char *rest = norma_ply_token(walker.at, walker.end, &length);
    if (rest)
        norma_document_add_note(document, "%zu bytes after the last element are kept as they are",
            (size_t)(walker.end - rest));
    return NORMA_DOCUMENT_OK;
}

static text_walker walker_of(norma_document *document, const ply_element *element,
    token_visitor *visit, void *user, norma_document_error *error) {
    const ply_state *state = document->state;
    return (text_walker){.document = document,
        .error = error,
        .element = element,
        .at = state->bytes + element->begin,
        .asked = state->bytes + element->begin,
        .end = state->bytes + element->end,
        .visit = visit,
        .user = user};
}

/* ---- columns */

typedef struct column_reader {
    int properties[3];
    double *next; /* the row's three values */
    int last;     /* the property of the row that comes last */
} column_reader;

static int visit_column(void *user, int property, int64_t item, const char *text, const char *end) {
    column_reader *reader = user;
    (void)item;
    for (int axis = 0; axis < 3; ++axis)
        if (property == reader->properties[axis] &&
            norma_number_parse(text, end, &reader->next[axis]) != end)
            return 1;
    if (property == reader->last) reader->next += 3;
    return 0;
}

norma_document_result norma_ply_read_text_columns(norma_document *document,
    const ply_element *element, const int properties[3], double *values,
    norma_document_error *error) {
    column_reader reader = {
        .properties = {properties[0], properties[1], properties[2]}, .next = values};
    for (int axis = 0; axis < 3; ++axis)
        if (properties[axis] > reader.last) reader.last = properties[axis];
    text_walker walker = walker_of(document, element, visit_column, &reader, error);
    return walk_rows(&walker);
}

/* ---- lists */

typedef struct list_reader {
    ply_lists *lists;
    int property;
    size_t row;
} list_reader;

static int visit_list(void *user, int property, int64_t item, const char *text, const char *end) {
    list_reader *reader = user;
    ply_lists *lists = reader->lists;
    int64_t value;
    if (property != reader->property) return 0;
    if (norma_number_parse_integer(text, end, &value) != end) return 1;
    if (item == COUNT_ITEM) {
        if (value < 0 || value > UINT32_MAX) return 1;
        int64_t *grown = norma_io_grow(
            lists->items, &lists->item_capacity, lists->item_count + (size_t)value, sizeof *grown);
        if (!grown) return 1;
        lists->items = grown;
        lists->counts[reader->row++] = (uint32_t)value;
        return 0;
    }
    lists->items[lists->item_count++] = value;
    return 0;
}

norma_document_result norma_ply_read_text_lists(norma_document *document,
    const ply_element *element, int property, ply_lists *lists, norma_document_error *error) {
    list_reader reader = {.lists = lists, .property = property};
    text_walker walker = walker_of(document, element, visit_list, &reader, error);
    return walk_rows(&walker);
}

/* ---- row spans: from the first word to the end of the last, of those too that are not
 * declared */

typedef struct span_reader {
    const unsigned char *bytes;
    ply_span *spans; /* the row's; the last word of a row overwrites what those before wrote */
    int at_start;
} span_reader;

static int visit_span(void *user, int property, int64_t item, const char *text, const char *end) {
    span_reader *reader = user;
    if (property == 0 && item <= 0 && reader->at_start)
        *reader->spans = (ply_span){(size_t)((const unsigned char *)text - reader->bytes), 0};
    reader->at_start = 0;
    reader->spans->length =
        (size_t)((const unsigned char *)end - reader->bytes) - reader->spans->offset;
    return 0;
}

norma_document_result norma_ply_row_spans(norma_document *document, const ply_element *element,
    ply_span **spans, norma_document_error *error) {
    const ply_state *state = document->state;
    ply_span *made = norma_io_allocate((size_t)element->count, sizeof *made);
    if (!made) return norma_document_fail_memory(document, error);
    *spans = made;
    if (state->header.encoding != PLY_ASCII) {
        const unsigned char *row = state->bytes + element->begin;
        for (size_t i = 0; i < element->count; ++i) {
            const unsigned char *end = norma_ply_row_end(&state->header, element, row);
            made[i] = (ply_span){(size_t)(row - state->bytes), (size_t)(end - row)};
            row = end;
        }
        return NORMA_DOCUMENT_OK;
    }
    span_reader reader = {.bytes = state->bytes};
    text_walker walker = walker_of(document, element, visit_span, &reader, error);
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (walker.row = 0; walker.row < element->count && !result; ++walker.row) {
        reader.spans = made + walker.row;
        reader.at_start = 1;
        result = walk_row(&walker);
        if (!result && walker.surplus)
            reader.spans->length = (size_t)(walker.row_end - state->bytes) - reader.spans->offset;
    }
    return result;
}
