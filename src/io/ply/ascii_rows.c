/* ascii_rows.c: rows of text with some words replaced or put in. All white space stays, and so does
 * each word whose number is the one wanted already. */
#include "io/ply/ply.h"
#include "io/text/number.h"
#include <stdlib.h>

typedef struct text_writer {
    const ply_state *state;
    const ply_plan *plan;
    norma_sink *sink;
    const unsigned char *at, *end; /* what has not been copied yet */
    const uint32_t *next_index;
    const uint32_t *triangle; /* of the face that is cut, which this row is; or NULL */
    const int64_t *next_item;
    size_t row; /* the old row */
    int any;    /* a row was written */
    norma_watch *watch;
    const void *asked; /* where it was last asked whether to go on */
} text_writer;

/* The sink takes nothing any more, or it is cancelled: of the rest nothing matters. */
static int stops(text_writer *writer) {
    return writer->sink->failed || norma_watch_passed(writer->watch, &writer->asked, writer->at);
}

/* The next word, the white space before it copied. Reading has made sure that there is one. */
static ply_span take_word(text_writer *writer) {
    size_t length = 0;
    const unsigned char *word = norma_ply_token(writer->at, writer->end, &length);
    if (!word) return (ply_span){0, 0};
    norma_sink_put(writer->sink, writer->at, (size_t)(word - writer->at));
    writer->at = word + length;
    return (ply_span){(size_t)(word - writer->state->bytes), length};
}

static void put_word(text_writer *writer, ply_span word) {
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

static double column_value(const ply_column *column, size_t number) {
    return column->floats ? (double)column->floats[3 * number] : column->doubles[3 * number];
}

static int is_same_number(
    const text_writer *writer, ply_span word, const ply_item *item, double value) {
    double old;
    const char *text = (const char *)writer->state->bytes + word.offset;
    if (norma_number_parse(text, text + word.length, &old) != text + word.length) return 0;
    if (old != old && value != value) return 1;
    return item->type == PLY_FLOAT ? (float)old == (float)value : old == value;
}

static void put_value(text_writer *writer, const ply_item *item, size_t number) {
    char text[32];
    const double value = column_value(&item->column, number);
    if (item->source) {
        ply_span word = take_word(writer);
        if (is_same_number(writer, word, item, value)) {
            put_word(writer, word);
            return;
        }
    } else {
        norma_sink_put(writer->sink, " ", 1);
    }
    norma_sink_put(
        writer->sink, text, norma_ply_format(item->type, value, item->column.unit, text));
}

/* ---- lists */

static void put_list(text_writer *writer) {
    ply_span word = take_word(writer);
    put_word(writer, word);
    for (int64_t left = integer_of(writer, word); left > 0 && !stops(writer); --left)
        put_word(writer, take_word(writer));
}

static void skip_words(text_writer *writer, int64_t count) {
    for (; count > 0 && !stops(writer); --count) {
        size_t length = 0;
        writer->at = norma_ply_token(writer->at, writer->end, &length);
        writer->at += length;
    }
}

static void put_triangle(text_writer *writer) {
    const int64_t count = integer_of(writer, take_word(writer));
    put_integer(writer, 3);
    for (int k = 0; k < 3; ++k) {
        norma_sink_put(writer->sink, " ", 1);
        put_integer(writer, writer->next_index[writer->triangle[k]]);
    }
    skip_words(writer, count);
}

static void put_face(text_writer *writer) {
    if (writer->triangle) {
        put_triangle(writer);
        return;
    }
    ply_span word = take_word(writer);
    put_word(writer, word);
    for (int64_t left = integer_of(writer, word); left > 0 && !stops(writer); --left) {
        ply_span index = take_word(writer);
        const uint32_t wanted = *writer->next_index++;
        if (integer_of(writer, index) == wanted)
            put_word(writer, index);
        else
            put_integer(writer, wanted);
    }
}

static void put_strip(text_writer *writer) {
    ply_span word = take_word(writer);
    const uint32_t count = writer->plan->lists->counts[writer->row];
    put_integer(writer, count);
    for (uint32_t i = 0; i < count && !stops(writer); ++i) {
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
        put_word(writer, words[writer->triangle[i / tuple] * tuple + i % tuple]);
    }
    skip_words(writer, (int64_t)count);
}

/* Where faces turn, the first corner's tuple stays and the others turn round, as the corners do; a
 * triangle of a face that is cut has the tuples of its corners. 0: out of memory. */
static int put_corners(text_writer *writer) {
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
        const unsigned char *found = norma_ply_token(at, writer->end, &words[i].length);
        words[i].offset = (size_t)(found - writer->state->bytes);
        at = found + words[i].length;
    }
    const uint8_t *rows = plan->reversed_rows;
    const size_t tuple =
        in_step && plan->reversed && (!rows || rows[writer->row]) ? count / corners : 0;
    if (in_step && writer->triangle)
        put_part(writer, words, count, corners);
    else
        put_word(writer, word);
    for (size_t i = 0; i < count && !(in_step && writer->triangle) && !stops(writer); ++i) {
        const size_t corner = tuple ? i / tuple : 0,
                     from = tuple && corner > 0 ? (corners - corner) * tuple + i % tuple : i;
        take_word(writer);
        put_word(writer, words[from]);
    }
    free(words);
    return 1;
}

/* ---- rows */

static int put_item(text_writer *writer, const ply_item *item, size_t number) {
    if (item->action == PLY_VALUE)
        put_value(writer, item, number);
    else if (item->action == PLY_CORNERS)
        return put_corners(writer);
    else if (item->action == PLY_INDICES && writer->plan->lists)
        put_strip(writer);
    else if (item->action == PLY_INDICES)
        put_face(writer);
    else if (norma_ply_is_list(item->source))
        put_list(writer);
    else
        put_word(writer, take_word(writer));
    return 1;
}

/* With all that follows in its line, white space or words that the header does not declare. */
static int put_row(text_writer *writer, size_t number) {
    int ok = 1;
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

static norma_document_result write_added(
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
static void drop_row(text_writer *writer, const ply_span *span) {
    if (writer->next_index) writer->next_index += norma_ply_row_corners(writer->plan, writer->row);
    writer->at = writer->state->bytes + span->offset + span->length;
    while (!writer->any && writer->at < writer->end &&
           (*writer->at == ' ' || *writer->at == '\t' || *writer->at == '\r'))
        ++writer->at;
    if (!writer->any && writer->at < writer->end && *writer->at == '\n') ++writer->at;
}

/* As many copies of the row as it becomes triangles, on lines of their own. */
static int cut_row(text_writer *writer, const ply_span *span) {
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
    for (writer.row = 0; !result && writer.row < plan->element->count && !stops(&writer);
         ++writer.row) {
        if (plan->dropped_rows && plan->dropped_rows[writer.row])
            drop_row(&writer, &spans[writer.row]);
        else if (!(norma_ply_is_cut(plan, writer.row) ? cut_row(&writer, &spans[writer.row])
                                                      : put_row(&writer, writer.row)))
            result = norma_document_fail_memory(document, error);
        else
            writer.any = 1;
    }
    free(spans);
    if (result) return result;
    norma_sink_put(sink, writer.at, (size_t)(writer.end - writer.at));
    return write_added(document, &writer, error);
}
