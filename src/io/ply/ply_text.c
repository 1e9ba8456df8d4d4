/* ply_text.c: the rows of an ASCII PLY. Each row is a line of words; a row may run on over
 * several lines, but two rows never share one: words that the header does not declare are passed
 * over to the end of the line. */
#include "io/ply/ply.h"
#include "io/text/text.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* NULL: no more; skips white space and line breaks */
static const unsigned char *ply_token(
    const unsigned char *at, const unsigned char *end, size_t *length) {
    while (at < end && norma_is_blank(*at)) ++at;
    const unsigned char *begin = at;
    while (at < end && !norma_is_blank(*at)) ++at;
    *length = (size_t)(at - begin);
    return at > begin ? begin : NULL;
}

/* Behind lines of comments, before the end of the last. The format has them in its header only, but
 * people write them between rows too. */
static const unsigned char *skip_comments(const unsigned char *at, const unsigned char *end) {
    static const char word[] = "comment";
    const size_t length = sizeof word - 1;
    for (;;) {
        const unsigned char *behind = at;
        while (at < end && norma_is_blank(*at)) ++at;
        if ((size_t)(end - at) <= length || memcmp(at, word, length) != 0 ||
            !norma_is_blank(at[length]))
            return behind;
        while (at < end && !norma_ply_ends_line(*at)) ++at;
    }
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
    ply_state *counting; /* NULL, or counts the rows that hold more than they should */
} text_walker;

static int text_is_cancelled(text_walker *walker) {
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

static norma_document_result text_next_word(
    text_walker *walker, const char **text, size_t *length) {
    const unsigned char *word = ply_token(walker->at, walker->end, length);
    if (!word) return fail_row(walker, walker->end, "the file ends before the row does");
    walker->at = word + *length;
    *text = (const char *)word;
    return NORMA_DOCUMENT_OK;
}

static norma_document_result walk_value(text_walker *walker, int property, int64_t item) {
    const char *text = NULL;
    size_t length = 0;
    norma_document_result result = text_is_cancelled(walker)
                                       ? NORMA_DOCUMENT_CANCELLED
                                       : text_next_word(walker, &text, &length);
    if (!result && walker->visit &&
        walker->visit(walker->user, property, item, text, text + length))
        return fail_row(
            walker, (const unsigned char *)text, "this is not a number of the property's type");
    return result;
}

static norma_document_result walk_list(text_walker *walker, int property) {
    const char *text = NULL;
    size_t length = 0;
    norma_document_result result = text_next_word(walker, &text, &length);
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
        if (text_is_cancelled(walker)) return;
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
    walker->at = skip_comments(walker->at, walker->end);
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
    ply_state *state = walker->counting;
    for (walker->row = 0; walker->row < walker->element->count && !result; ++walker->row) {
        result = walk_row(walker);
        if (result || !walker->surplus || !state) continue;
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
        .end = state->bytes + state->size,
        .counting = state};
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
        norma_document_result result = walk_rows(&walker);
        if (result) return result;
        element->end = (size_t)(walker.at - state->bytes);
    }
    char surplus[120];
    norma_ply_surplus_text(state, surplus);
    if (state->surplus_rows)
        norma_document_add_note(document, "%s; they are kept, not read", surplus);
    size_t length;
    const unsigned char *rest =
        ply_token(skip_comments(walker.at, walker.end), walker.end, &length);
    state->tail = rest ? (size_t)(rest - state->bytes) : 0;
    if (rest)
        norma_document_add_note(document, "bytes after the last element, kept as they are: %zu",
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

/* ---- Rows of text with some words replaced or put in. All white space stays, and so does
 * each word whose number is the one wanted already. */

typedef struct text_writer {
    const ply_state *state;
    const ply_plan *plan;
    norma_sink *sink;
    const unsigned char *at, *end; /* what has not been copied yet */
    const uint32_t *next_index;
    const uint32_t *triangle; /* of the face that is cut, which this row is; or NULL */
    const int64_t *next_item;
    size_t row; /* the old row */
    int any;    /* a row, or a comment, was written */
    norma_watch *watch;
    const void *asked; /* where it was last asked whether to go on */
} text_writer;

/* The sink takes nothing any more, or it is cancelled: of the rest nothing matters. */
static int text_stops(text_writer *writer) {
    return writer->sink->failed || norma_watch_passed(writer->watch, &writer->asked, writer->at);
}

/* The next word, the white space before it copied. Reading has made sure that there is one. */
static ply_span take_word(text_writer *writer) {
    size_t length = 0;
    const unsigned char *word = ply_token(writer->at, writer->end, &length);
    if (!word) return (ply_span){0, 0};
    norma_sink_put(writer->sink, writer->at, (size_t)(word - writer->at));
    writer->at = word + length;
    return (ply_span){(size_t)(word - writer->state->bytes), length};
}

static void text_put_word(text_writer *writer, ply_span word) {
    norma_sink_put(writer->sink, writer->state->bytes + word.offset, word.length);
}

static void put_integer(text_writer *writer, int64_t value) {
    char text[32];
    norma_sink_put(writer->sink, text, norma_ply_format(PLY_INT32, (double)value, 0, text));
}

static int64_t integer_of(const text_writer *writer, ply_span word) {
    int64_t value = 0;
    const char *text = (const char *)writer->state->bytes + word.offset;
    norma_number_parse_integer(text, text + word.length, &value);
    return value;
}

/* ---- values */

static int is_same_number(
    const text_writer *writer, ply_span word, const ply_item *item, double value) {
    double old;
    const char *text = (const char *)writer->state->bytes + word.offset;
    if (norma_number_parse(text, text + word.length, &old) != text + word.length) return 0;
    if (old != old && value != value) return 1;
    return item->type == PLY_FLOAT ? (float)old == (float)value : old == value;
}

static void text_put_value(text_writer *writer, const ply_item *item, size_t number) {
    char text[32];
    const double value = norma_ply_column_value(&item->column, number);
    if (item->source) {
        ply_span word = take_word(writer);
        if (is_same_number(writer, word, item, value)) {
            text_put_word(writer, word);
            return;
        }
    } else {
        norma_sink_put(writer->sink, " ", 1);
    }
    norma_sink_put(
        writer->sink, text, norma_ply_format(item->type, value, item->column.unit, text));
}

/* ---- lists */

static void skip_words(text_writer *writer, int64_t count) {
    for (; count > 0 && !text_stops(writer); --count) {
        size_t length = 0;
        writer->at = ply_token(writer->at, writer->end, &length);
        writer->at += length;
    }
}

static void text_put_triangle(text_writer *writer) {
    const int64_t count = integer_of(writer, take_word(writer));
    put_integer(writer, 3);
    for (int k = 0; k < 3; ++k) {
        norma_sink_put(writer->sink, " ", 1);
        put_integer(writer, writer->next_index[writer->triangle[k]]);
    }
    skip_words(writer, count);
}

/* renumbers: items that are other numbers now. */
static void text_put_list(text_writer *writer, int renumbers) {
    ply_span word = take_word(writer);
    text_put_word(writer, word);
    for (int64_t left = integer_of(writer, word); left > 0 && !text_stops(writer); --left) {
        word = take_word(writer);
        const int64_t wanted = renumbers ? *writer->next_index++ : 0;
        if (renumbers && integer_of(writer, word) != wanted)
            put_integer(writer, wanted);
        else
            text_put_word(writer, word);
    }
}

static void text_put_strip(text_writer *writer) {
    ply_span word = take_word(writer);
    const uint32_t count = writer->plan->lists->counts[writer->row];
    put_integer(writer, count);
    for (uint32_t i = 0; i < count && !text_stops(writer); ++i) {
        norma_sink_put(writer->sink, " ", 1);
        put_integer(writer, *writer->next_item++);
    }
    skip_words(writer, integer_of(writer, word));
}

/* Those of a triangle's corners. */
static void put_part(text_writer *writer, const ply_span *words, size_t count, size_t corners) {
    const size_t tuple = count / corners;
    put_integer(writer, (int64_t)(3 * tuple));
    for (size_t i = 0; i < 3 * tuple; ++i) {
        norma_sink_put(writer->sink, " ", 1);
        text_put_word(writer, words[writer->triangle[i / tuple] * tuple + i % tuple]);
    }
    skip_words(writer, (int64_t)count);
}

/* Where faces turn, the first corner's tuple stays and the others turn round, as the corners do; a
 * triangle of a face that is cut has the tuples of its corners. 0: out of memory. */
static int text_put_corners(text_writer *writer) {
    const ply_plan *plan = writer->plan;
    const ply_span word = take_word(writer);
    const size_t count = (size_t)integer_of(writer, word),
                 corners = norma_ply_row_corners(plan, writer->row);
    const int in_step = corners > 0 && count > 0 && count % corners == 0;
    ply_span *words = norma_io_allocate(count, sizeof *words);
    if (!words) return 0;
    const unsigned char *at = writer->at;
    for (size_t i = 0; i < count; ++i) {
        if (norma_watch_passed(writer->watch, &writer->asked, at)) break; /* all else drops */
        const unsigned char *found = ply_token(at, writer->end, &words[i].length);
        words[i].offset = (size_t)(found - writer->state->bytes);
        at = found + words[i].length;
    }
    const uint8_t *rows = plan->reversed_rows;
    const size_t tuple =
        in_step && plan->reversed && (!rows || rows[writer->row]) ? count / corners : 0;
    if (in_step && writer->triangle)
        put_part(writer, words, count, corners);
    else
        text_put_word(writer, word);
    for (size_t i = 0; i < count && !(in_step && writer->triangle) && !text_stops(writer); ++i) {
        const size_t corner = tuple ? i / tuple : 0,
                     from = tuple && corner > 0 ? (corners - corner) * tuple + i % tuple : i;
        take_word(writer);
        text_put_word(writer, words[from]);
    }
    free(words);
    return 1;
}

/* ---- rows */

static int put_item(text_writer *writer, const ply_item *item, size_t number) {
    if (item->action == PLY_VALUE)
        text_put_value(writer, item, number);
    else if (item->action == PLY_CORNERS)
        return text_put_corners(writer);
    else if (item->action == PLY_INDICES && writer->plan->lists)
        text_put_strip(writer);
    else if (item->action == PLY_INDICES && writer->triangle)
        text_put_triangle(writer);
    else if (norma_ply_is_list(item->source))
        text_put_list(writer, item->action == PLY_INDICES);
    else
        text_put_word(writer, take_word(writer));
    return 1;
}

static void put_comments(text_writer *writer) {
    const unsigned char *behind = skip_comments(writer->at, writer->end);
    if (behind > writer->at) writer->any = 1;
    norma_sink_put(writer->sink, writer->at, (size_t)(behind - writer->at));
    writer->at = behind;
}

/* With all that follows in its line, white space or words that the header does not declare. */
static int put_row(text_writer *writer, size_t number) {
    int ok = 1;
    put_comments(writer);
    for (size_t i = 0; i < writer->plan->item_count && ok; ++i)
        ok = put_item(writer, &writer->plan->items[i], number);
    const unsigned char *end = writer->at;
    while (end < writer->end && !norma_ply_ends_line(*end) &&
           !norma_watch_passed(writer->watch, &writer->asked, end))
        ++end;
    norma_sink_put(writer->sink, writer->at, (size_t)(end - writer->at));
    writer->at = end;
    return ok;
}

static void put_line_break(text_writer *writer) {
    const ply_span line_break = writer->state->header.line_break;
    norma_sink_put(writer->sink, writer->state->bytes + line_break.offset, line_break.length);
}

/* A last row may lack its line's end, which it needs when others follow. */
static int ends_in_line_break(const text_writer *writer) {
    const ply_element *element = writer->plan->element;
    const unsigned char last =
        element->end > element->begin ? writer->state->bytes[element->end - 1] : '\n';
    return last == '\n' || last == '\r';
}

static norma_document_result text_write_added(
    norma_document *document, text_writer *writer, norma_document_error *error) {
    const ply_plan *plan = writer->plan;
    ply_span *spans = NULL;
    if (plan->added_count == 0) return NORMA_DOCUMENT_OK;
    norma_document_result result = norma_ply_row_spans(document, plan->element, &spans, error);
    if (!result && !ends_in_line_break(writer)) put_line_break(writer);
    for (size_t i = 0; i < plan->added_count && !result; ++i) {
        writer->row = plan->added[i];
        writer->at = writer->state->bytes + spans[writer->row].offset;
        writer->end = writer->at + spans[writer->row].length;
        if (!put_row(writer, (size_t)plan->element->count + i))
            result = norma_document_fail_memory(document, error);
        put_line_break(writer);
    }
    free(spans);
    return result;
}

/* Drops a row with the line break before it. Before the first row that stays there is no break, so
 * the break behind the dropped row goes instead. */
static void text_drop_row(text_writer *writer, const ply_span *span) {
    put_comments(writer);
    if (writer->next_index) writer->next_index += norma_ply_row_corners(writer->plan, writer->row);
    writer->at = writer->state->bytes + span->offset + span->length;
    while (!writer->any && writer->at < writer->end &&
           (*writer->at == ' ' || *writer->at == '\t' || *writer->at == '\r'))
        ++writer->at;
    if (!writer->any && writer->at < writer->end && *writer->at == '\n') ++writer->at;
}

/* As many copies of the row as it becomes triangles, on lines of their own. */
static int text_cut_row(text_writer *writer, const ply_span *span) {
    const size_t corners = norma_ply_row_corners(writer->plan, writer->row);
    int ok = 1;
    writer->triangle =
        writer->plan->cut_corners + 3 * norma_ply_row_begin(writer->plan, writer->row);
    for (size_t i = 0; i + 2 < corners && ok; ++i, writer->triangle += 3) {
        if (i > 0) {
            put_line_break(writer);
            writer->at = writer->state->bytes + span->offset;
        }
        ok = put_row(writer, writer->row);
    }
    writer->triangle = NULL;
    writer->next_index += corners;
    return ok;
}

norma_document_result norma_ply_write_text_rows(
    norma_document *document, const ply_plan *plan, norma_sink *sink, norma_document_error *error) {
    const ply_state *state = document->state;
    text_writer writer = {.state = state,
        .plan = plan,
        .sink = sink,
        .at = state->bytes + plan->element->begin,
        .end = state->bytes + plan->element->end,
        .watch = &document->watch,
        .asked = state->bytes + plan->element->begin,
        .next_index = plan->indices,
        .next_item = plan->lists ? plan->lists->items : NULL};
    ply_span *spans = NULL;
    norma_document_result result = plan->dropped_rows || plan->cut_rows
                                       ? norma_ply_row_spans(document, plan->element, &spans, error)
                                       : NORMA_DOCUMENT_OK;
    for (writer.row = 0; !result && writer.row < plan->element->count && !text_stops(&writer);
         ++writer.row) {
        if (plan->dropped_rows && plan->dropped_rows[writer.row])
            text_drop_row(&writer, &spans[writer.row]);
        else if (!(norma_ply_is_cut(plan, writer.row) ? text_cut_row(&writer, &spans[writer.row])
                                                      : put_row(&writer, writer.row)))
            result = norma_document_fail_memory(document, error);
        else
            writer.any = 1;
    }
    free(spans);
    if (result) return result;
    norma_sink_put(sink, writer.at, (size_t)(writer.end - writer.at));
    return text_write_added(document, &writer, error);
}
