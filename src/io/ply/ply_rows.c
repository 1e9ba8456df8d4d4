/* ply_rows.c: binary rows of a PLY: where they lie, and rewritten with some properties replaced or
 * put in. */
#include "io/ply/ply.h"
#include <stdlib.h>

/* ---- Where the rows of each element lie. Rows of fixed size are skipped by arithmetic;
 * only lists in binary rows and text must be walked. Counts are bounded by the bytes that are there
 * before anything follows from them. */

size_t norma_ply_measure_row(const ply_state *state, const ply_element *element, size_t begin,
    int wanted, size_t *place, size_t *bad) {
    const ply_header *header = &state->header;
    size_t at = begin;
    for (size_t i = 0; i < element->property_count; ++i) {
        const ply_property *property = norma_ply_property(header, element, (int)i);
        size_t left = state->size - at;
        if ((int)i == wanted) *place = at;
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

/* The commonest faces by far are triangles: then no row hangs on the one before it. */
static int are_triangles(
    const ply_state *state, const ply_element *element, size_t at, size_t row_size) {
    unsigned differs = 0;
    if (element->count == 0 || element->count > (state->size - at) / row_size) return 0;
    for (size_t i = 0; i < element->count && !differs; ++i)
        differs = state->bytes[at + i * row_size] ^ 3u;
    return !differs;
}

static norma_document_result walk_lists(const norma_document *document, ply_element *element,
    size_t *end, norma_document_error *error) {
    const ply_state *state = document->state;
    size_t at = *end, unused, bad = SIZE_MAX;
    if (element->property_count == 1 &&
        norma_ply_property(&state->header, element, 0)->count_type == PLY_UINT8) {
        const size_t row_size =
            1 + 3 * norma_ply_type_size(norma_ply_property(&state->header, element, 0)->type);
        if (are_triangles(state, element, at, row_size)) {
            element->triangle_row = row_size;
            *end = at + (size_t)element->count * row_size;
            return NORMA_DOCUMENT_OK;
        }
    }
    for (uint64_t row = 0; row < element->count; ++row) {
        size_t size = norma_ply_measure_row(state, element, at, PLY_NONE, &unused, &bad);
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
    state->tail = norma_is_padding(state->bytes + at, state->size - at) ? 0 : at;
    if (at < state->size)
        norma_document_add_note(
            document, "bytes after the last element, kept as they are: %zu", state->size - at);
    return NORMA_DOCUMENT_OK;
}

norma_document_result norma_ply_locate(norma_document *document, norma_document_error *error) {
    ply_state *state = document->state;
    return state->header.encoding == PLY_ASCII ? norma_ply_locate_text(document, error)
                                               : locate_binary(document, error);
}

/* ---- Binary rows with some properties replaced or put in. A plan becomes a short
 * program of steps that runs once for each row; neighbouring properties that are only copied are
 * one step. */

typedef enum step_kind {
    STEP_COPY, /* size bytes of the old row */
    STEP_SKIP, /* size bytes of the old row are left out */
    STEP_SIDE, /* size bytes of an array, which moves on by stride each row */
    STEP_ITEM  /* what becomes of one property */
} step_kind;

typedef struct row_step {
    step_kind kind;
    size_t size, stride;
    const unsigned char *side;
    const ply_item *item;
} row_step;

typedef struct row_writer {
    const ply_state *state;
    const ply_plan *plan;
    norma_sink *sink;
    row_step *steps;
    size_t step_count;
    const uint32_t *next_index; /* of faces */
    const uint32_t *triangle;   /* of the face that is cut, which this row is; or NULL */
    const int64_t *next_item;   /* of strips */
} row_writer;

/* ---- the program */

static void add_step(row_writer *writer, row_step step) {
    row_step *last = writer->step_count ? &writer->steps[writer->step_count - 1] : NULL;
    if (last && last->kind == step.kind && (step.kind == STEP_COPY || step.kind == STEP_SKIP)) {
        last->size += step.size;
        return;
    }
    if (last && last->kind == STEP_SIDE && step.kind == STEP_SIDE && last->stride == step.stride &&
        last->side + last->size == step.side) {
        last->size += step.size;
        return;
    }
    writer->steps[writer->step_count++] = step;
}

static void add_value(row_writer *writer, const ply_item *item) {
    const int native = norma_ply_is_native(writer->state->header.encoding);
    if (native && item->type == PLY_FLOAT && item->column.floats)
        add_step(writer, (row_step){.kind = STEP_SIDE,
                             .size = 4,
                             .stride = 12,
                             .side = (const unsigned char *)item->column.floats});
    else if (native && item->type == PLY_DOUBLE && item->column.doubles)
        add_step(writer, (row_step){.kind = STEP_SIDE,
                             .size = 8,
                             .stride = 24,
                             .side = (const unsigned char *)item->column.doubles});
    else
        add_step(writer, (row_step){.kind = STEP_ITEM, .item = item});
}

/* Skips move behind the values that neighbour them, so that three replaced numbers are one step
 * each way. */
static void binary_compile(row_writer *writer) {
    size_t skipped = 0;
    for (size_t i = 0; i < writer->plan->item_count; ++i) {
        const ply_item *item = &writer->plan->items[i];
        if (item->action == PLY_VALUE) {
            add_value(writer, item);
            skipped += item->source ? norma_ply_type_size(item->source->type) : 0;
            continue;
        }
        if (skipped > 0) add_step(writer, (row_step){.kind = STEP_SKIP, .size = skipped});
        skipped = 0;
        if (item->action != PLY_COPY || norma_ply_is_list(item->source))
            add_step(writer, (row_step){.kind = STEP_ITEM, .item = item});
        else
            add_step(
                writer, (row_step){.kind = STEP_COPY, .size = norma_ply_type_size(item->type)});
    }
    if (skipped > 0) add_step(writer, (row_step){.kind = STEP_SKIP, .size = skipped});
}

/* ---- its steps */

static void ply_put_number(const row_writer *writer, ply_type type, double value) {
    norma_ply_put(norma_sink_room(writer->sink, norma_ply_type_size(type)), type,
        writer->state->header.encoding, value);
}

static void put_triangle(row_writer *writer, const ply_item *item) {
    ply_put_number(writer, item->count_type, 3);
    for (int k = 0; k < 3; ++k)
        ply_put_number(writer, item->type, (double)writer->next_index[writer->triangle[k]]);
}

static void put_face(row_writer *writer, const ply_item *item, const unsigned char *at) {
    const ply_encoding encoding = writer->state->header.encoding;
    const size_t count = (size_t)norma_ply_get_integer(at, item->source->count_type, encoding),
                 size = norma_ply_type_size(item->type);
    if (writer->triangle) {
        put_triangle(writer, item);
        return;
    }
    norma_sink_put(writer->sink, at, norma_ply_type_size(item->source->count_type));
    if (size == sizeof(uint32_t) && norma_ply_is_native(encoding)) {
        norma_sink_put(writer->sink, (const unsigned char *)writer->next_index, count * size);
        writer->next_index += count;
        return;
    }
    for (size_t i = 0; i < count; ++i) ply_put_number(writer, item->type, *writer->next_index++);
}

static void put_strip(row_writer *writer, const ply_item *item, size_t row) {
    const uint32_t count = writer->plan->lists->counts[row];
    ply_put_number(writer, item->count_type, count);
    for (uint32_t i = 0; i < count; ++i)
        ply_put_number(writer, item->type, (double)*writer->next_item++);
}

/* Where faces turn, the first corner's tuple stays and the others turn round, as the corners do; a
 * triangle of a face that is cut has the tuples of its corners. */
static void put_corners(
    const row_writer *writer, const ply_item *item, const unsigned char *at, size_t row) {
    const ply_encoding encoding = writer->state->header.encoding;
    const size_t corners = norma_ply_row_corners(writer->plan, row),
                 count = (size_t)norma_ply_get_integer(at, item->source->count_type, encoding);
    const size_t count_size = norma_ply_type_size(item->source->count_type),
                 bytes = count * norma_ply_type_size(item->type);
    const uint8_t *rows = writer->plan->reversed_rows;
    const int in_step = corners > 0 && count % corners == 0,
              turns = writer->plan->reversed && (!rows || rows[row]);
    const size_t tuple = in_step ? bytes / corners : 0,
                 of_triangle = in_step ? count / corners * 3 : 0;
    if (writer->triangle && in_step)
        ply_put_number(writer, item->source->count_type, (double)of_triangle);
    else
        norma_sink_put(writer->sink, at, count_size);
    at += count_size;
    if (!in_step || (!writer->triangle && !turns)) {
        norma_sink_put(writer->sink, at, bytes);
        return;
    }
    for (size_t i = 0; i < (writer->triangle ? 3 : corners); ++i)
        norma_sink_put(writer->sink,
            at + (writer->triangle ? writer->triangle[i]
                     : i == 0      ? 0
                                   : corners - i) *
                     tuple,
            tuple);
}

static const unsigned char *binary_run_step(
    row_writer *writer, const row_step *step, const unsigned char *at, size_t row, size_t number) {
    const ply_item *item = step->item;
    switch (step->kind) {
    case STEP_COPY:
        norma_sink_put(writer->sink, at, step->size);
        return at + step->size;
    case STEP_SKIP:
        return at + step->size;
    case STEP_SIDE:
        norma_sink_put(writer->sink, step->side + step->stride * number, step->size);
        return at;
    default:
        break;
    }
    if (item->action == PLY_VALUE) {
        ply_put_number(writer, item->type, norma_ply_column_value(&item->column, number));
        return at;
    }
    const size_t size = norma_ply_property_size(&writer->state->header, item->source, at);
    if (item->action == PLY_COPY)
        norma_sink_put(writer->sink, at, size);
    else if (item->action == PLY_CORNERS)
        put_corners(writer, item, at, row);
    else if (writer->plan->lists)
        put_strip(writer, item, row);
    else
        put_face(writer, item, at);
    return at + size;
}

static const unsigned char *write_row(
    row_writer *writer, const unsigned char *at, size_t row, size_t number) {
    for (size_t i = 0; i < writer->step_count; ++i)
        at = binary_run_step(writer, &writer->steps[i], at, row, number);
    return at;
}

static const unsigned char *drop_row(row_writer *writer, const unsigned char *at, size_t row) {
    if (writer->next_index) writer->next_index += norma_ply_row_corners(writer->plan, row);
    return norma_ply_row_end(&writer->state->header, writer->plan->element, at);
}

/* As many copies of the row as it becomes triangles. */
static const unsigned char *cut_row(row_writer *writer, const unsigned char *at, size_t row) {
    const size_t corners = norma_ply_row_corners(writer->plan, row);
    writer->triangle = writer->plan->cut_corners + 3 * norma_ply_row_begin(writer->plan, row);
    for (size_t i = 0; i + 2 < corners; ++i, writer->triangle += 3) write_row(writer, at, row, row);
    writer->triangle = NULL;
    return drop_row(writer, at, row);
}

static norma_document_result write_added(
    norma_document *document, row_writer *writer, norma_document_error *error) {
    const ply_plan *plan = writer->plan;
    const ply_element *element = plan->element;
    ply_span *spans = NULL;
    norma_document_result result = NORMA_DOCUMENT_OK;
    if (plan->added_count > 0 && element->list_count > 0)
        result = norma_ply_row_spans(document, element, &spans, error);
    for (size_t i = 0; i < plan->added_count && !result; ++i) {
        const size_t row = plan->added[i];
        write_row(writer,
            writer->state->bytes +
                (spans ? spans[row].offset : element->begin + row * element->fixed_size),
            row, (size_t)element->count + i);
    }
    free(spans);
    return result;
}

/* ---- rows that do not hang on the ones before them, in slices made side by side */

enum { SLICE = 1 << 13 }; /* rows */

typedef struct row_slices {
    const row_writer *writer;
    size_t row_size, slices; /* slices of old rows; those of added ones follow */
} row_slices;

/* The bytes of each row, where all have as many. */
static size_t even_row(const ply_plan *plan) {
    if (plan->lists || plan->dropped_rows || plan->cut_rows) return 0;
    return plan->element->list_count == 0 ? plan->element->fixed_size : plan->element->triangle_row;
}

static void make_slice(void *context, size_t index, norma_data_run *piece) {
    const row_slices *slices = context;
    const ply_plan *plan = slices->writer->plan;
    const int added = index >= slices->slices;
    const size_t first = (added ? index - slices->slices : index) * SLICE,
                 count = added ? plan->added_count : (size_t)plan->element->count;
    const unsigned char *rows = slices->writer->state->bytes + plan->element->begin;
    row_writer writer = *slices->writer;
    writer.sink = &piece->sink;
    if (writer.next_index) writer.next_index += 3 * first;
    for (size_t i = first; i < count && i < first + SLICE; ++i) {
        const size_t row = added ? plan->added[i] : i;
        write_row(&writer, rows + row * slices->row_size, row,
            added ? (size_t)plan->element->count + i : i);
    }
}

static norma_document_result write_slices(norma_document *document, const row_writer *writer,
    size_t row_size, norma_document_error *error) {
    const ply_plan *plan = writer->plan;
    row_slices slices = {.writer = writer,
        .row_size = row_size,
        .slices = ((size_t)plan->element->count + SLICE - 1) / SLICE};
    return norma_edited_put_ordered(document, writer->sink,
        slices.slices + (plan->added_count + SLICE - 1) / SLICE, make_slice, &slices, error);
}

static norma_document_result write_in_turn(
    norma_document *document, row_writer *writer, norma_document_error *error) {
    const ply_plan *plan = writer->plan;
    const unsigned char *at = writer->state->bytes + plan->element->begin;
    for (size_t row = 0; row < plan->element->count && !writer->sink->failed; ++row)
        at = plan->dropped_rows && plan->dropped_rows[row] ? drop_row(writer, at, row)
             : norma_ply_is_cut(plan, row)                 ? cut_row(writer, at, row)
                                                           : write_row(writer, at, row, row);
    return write_added(document, writer, error);
}

norma_document_result norma_ply_write_rows(
    norma_document *document, const ply_plan *plan, norma_sink *sink, norma_document_error *error) {
    row_writer writer = {.state = document->state,
        .plan = plan,
        .sink = sink,
        .next_index = plan->indices,
        .next_item = plan->lists ? plan->lists->items : NULL};
    const size_t row_size = even_row(plan);
    writer.steps = norma_io_allocate(2 * plan->item_count + 1, sizeof *writer.steps);
    if (!writer.steps) return norma_document_fail_memory(document, error);
    binary_compile(&writer);
    norma_document_result result = row_size && sink->write
                                       ? write_slices(document, &writer, row_size, error)
                                       : write_in_turn(document, &writer, error);
    free(writer.steps);
    return result;
}
