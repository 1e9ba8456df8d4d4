/* ply_write.c: a changed PLY: the header with single words replaced and lines put in, then each
 * element by its plan. */
#include "io/ply/ply.h"
#include "io/text/text.h"
#include <stdlib.h>

int norma_ply_has_edit(const void *state) {
    const ply_edit *edit = &((const ply_state *)state)->edit;
    return norma_ply_has_values(&edit->normals) || norma_ply_has_values(&edit->positions) ||
           norma_ply_has_values(&edit->face_normals) || edit->corners || edit->added_count > 0 ||
           edit->dropped_rows || edit->dropped_vertices || edit->cut_rows;
}

void norma_ply_forget_edit(void *state) {
    ply_edit *edit = &((ply_state *)state)->edit;
    free(edit->normals.floats);
    free(edit->normals.doubles);
    free(edit->positions.doubles);
    free(edit->positions.floats);
    free(edit->face_normals.floats);
    free(edit->added);
    free(edit->corners);
    free(edit->reversed_rows);
    free(edit->dropped_rows);
    free(edit->cut_rows);
    free(edit->cut_corners);
    free(edit->dropped_vertices);
    *edit = (ply_edit){0};
}

/* ---- plans */

static int ply_axis_of(const int properties[3], int property) {
    for (int axis = 0; axis < 3; ++axis)
        if (properties[axis] == property) return axis;
    return PLY_NONE;
}

static ply_item copy_item(const ply_property *property) {
    return (ply_item){
        .source = property, .type = property->type, .count_type = property->count_type};
}

/* unit: components of unit vectors. */
static ply_item value_item(
    const ply_property *source, const ply_values *values, int axis, int unit) {
    const ply_column column = {.floats = values->floats ? values->floats + axis : NULL,
        .doubles = values->floats ? NULL : values->doubles + axis,
        .unit = unit};
    return (ply_item){.source = source,
        .action = PLY_VALUE,
        .type = values->types[axis],
        .count_type = PLY_NO_TYPE,
        .column = column};
}

static void plan_vertex(const ply_state *state, ply_plan *plan) {
    const ply_header *header = &state->header;
    const ply_edit *edit = &state->edit;
    const int has_normals = norma_ply_has_values(&edit->normals),
              has_positions = norma_ply_has_values(&edit->positions);
    int last_position = 0;
    for (int axis = 0; axis < 3; ++axis)
        last_position =
            header->position[axis] > last_position ? header->position[axis] : last_position;
    size_t count = 0;
    for (int i = 0; i < (int)plan->element->property_count; ++i) {
        const ply_property *property = norma_ply_property(header, plan->element, i);
        const int position = ply_axis_of(header->position, i),
                  normal = ply_axis_of(header->normal, i);
        ply_item *item = &plan->items[count++];
        *item = copy_item(property);
        if (has_positions && position != PLY_NONE)
            *item = value_item(property, &edit->positions, position, 0);
        else if (has_normals && normal != PLY_NONE)
            *item = value_item(property, &edit->normals, normal, 1);
        if (has_normals && header->normal[0] == PLY_NONE && i == last_position)
            for (int axis = 0; axis < 3; ++axis)
                plan->items[count++] = value_item(NULL, &edit->normals, axis, 1);
    }
    plan->item_count = count;
    plan->added = edit->added;
    plan->added_count = edit->added_count;
    plan->dropped_rows = edit->dropped_vertices;
    plan->changed = has_normals || has_positions || edit->added_count > 0 || edit->dropped_vertices;
}

/* The narrowest type that counts up to value: the same, or a wider one that is signed or unsigned
 * as it was. */
static ply_type ply_widen(ply_type type, double value, int needs_sign) {
    static const ply_type signed_types[] = {PLY_INT8, PLY_INT16, PLY_INT32},
                          unsigned_types[] = {PLY_UINT8, PLY_UINT16, PLY_UINT32};
    const int is_signed = needs_sign || type == PLY_INT8 || type == PLY_INT16 || type == PLY_INT32;
    if (norma_ply_type_holds(type, value) && (!needs_sign || norma_ply_type_holds(type, -1)))
        return type;
    for (int i = 0; i < 3; ++i) {
        ply_type wider = is_signed ? signed_types[i] : unsigned_types[i];
        if (norma_ply_type_holds(wider, value)) return wider;
    }
    return PLY_UINT32;
}

static double highest_index(const ply_state *state) {
    return (double)(state->vertices + state->edit.added_count) - 1;
}

/* Wedge texture coordinates, as MeshLab writes them: pairs or triples in the order of the corners.
 */
static int goes_with_corners(const ply_state *state, const ply_property *property) {
    return norma_ply_is_list(property) &&
           (norma_ply_span_is(state, property->name, "texcoord") ||
               norma_ply_span_is(state, property->name, "texcoords"));
}

static void plan_faces(const ply_state *state, ply_plan *plan) {
    const ply_edit nothing = {0};
    const ply_header *header = &state->header;
    const ply_edit *edit = header->face_list == PLY_NONE
                               ? &nothing
                               : &state->edit; /* rows without a list of corners are no faces */
    for (int i = 0; i < (int)plan->element->property_count; ++i) {
        const ply_property *property = norma_ply_property(header, plan->element, i);
        const int normal = ply_axis_of(header->face_normal, i);
        ply_item *item = &plan->items[i];
        *item = copy_item(property);
        if (edit->corners && i == header->face_list) {
            item->action = PLY_INDICES;
            item->type = edit->added_count ? ply_widen(property->type, highest_index(state), 0)
                                           : property->type;
        } else if (norma_ply_has_values(&edit->face_normals) && normal != PLY_NONE) {
            *item = value_item(property, &edit->face_normals, normal, 1);
        } else if ((edit->reversed || edit->cut_rows) && goes_with_corners(state, property)) {
            item->action = PLY_CORNERS;
        }
        plan->changed |= item->action != PLY_COPY;
    }
    plan->item_count = plan->element->property_count;
    plan->indices = edit->corners;
    plan->face_starts = state->mesh.face_starts;
    plan->reversed_rows = edit->reversed_rows;
    plan->reversed = edit->reversed;
    plan->dropped_rows = edit->dropped_rows;
    plan->cut_rows = edit->cut_rows;
    plan->cut_corners = edit->cut_corners;
    plan->changed |= edit->dropped_rows != NULL;
}

/* Those of a strip that are not left out; how many. */
static size_t keep_triangles(
    const uint32_t *corners, const uint8_t *dropped, size_t count, uint32_t *kept) {
    size_t left = 0;
    for (size_t i = 0; i < count; ++i)
        if (!dropped || !dropped[i]) memcpy(kept + 3 * left++, corners + 3 * i, 3 * sizeof *kept);
    return left;
}

/* One list anew into out, or as it was where its triangles are; the count. own: room for them. */
static size_t encode_list(const int64_t *items, size_t count, const uint32_t *kept, size_t left,
    uint32_t *own, int64_t *out) {
    if (norma_ply_strip_triangles(items, count, own) != left ||
        (left && memcmp(own, kept, 3 * left * sizeof *kept) != 0))
        return norma_ply_strip_encode(kept, left, out);
    if (count) memcpy(out, items, count * sizeof *out);
    return count;
}

/* The strips anew: where a crease or a mirror parts their triangles, they end in -1 and begin
 * again. */
static norma_document_result encode_strips(norma_document *document, const ply_element *strips,
    ply_lists *lists, norma_document_error *error) {
    const ply_state *state = document->state;
    ply_lists old = {0};
    norma_document_result result =
        norma_ply_read_lists(document, strips, state->header.strip_list, &old, error);
    const uint32_t *corners = state->edit.corners + state->mesh.polygon_corners;
    const uint8_t *dropped =
        state->edit.dropped_rows ? state->edit.dropped_rows + state->mesh.polygon_count : NULL;
    const size_t all = state->mesh.face_count - state->mesh.polygon_count;
    uint32_t *kept = norma_io_allocate(all, 3 * sizeof *kept),
             *own = norma_io_allocate(all, 3 * sizeof *own);
    const int64_t *items = old.items;
    const size_t room = 4 * all + old.item_count;
    if (!result) {
        lists->items = norma_io_allocate(room, sizeof *lists->items);
        lists->counts = norma_io_allocate((size_t)strips->count, sizeof *lists->counts);
        if (!lists->items || !lists->counts || !kept || !own)
            result = norma_document_fail_memory(document, error);
    }
    for (size_t row = 0; !result && row < strips->count; items += old.counts[row], ++row) {
        size_t triangles = norma_ply_strip_triangles(items, old.counts[row], NULL);
        const size_t left = keep_triangles(corners, dropped, triangles, kept);
        lists->counts[row] = (uint32_t)encode_list(
            items, old.counts[row], kept, left, own, lists->items + lists->item_count);
        lists->item_count += lists->counts[row];
        corners += 3 * triangles;
        dropped = dropped ? dropped + triangles : NULL;
    }
    free(kept);
    free(own);
    norma_ply_free_lists(&old);
    return result;
}

static norma_document_result plan_strips(
    norma_document *document, ply_plan *plan, ply_lists *lists, norma_document_error *error) {
    const ply_state *state = document->state;
    const ply_header *header = &state->header;
    for (int i = 0; i < (int)plan->element->property_count; ++i)
        plan->items[i] = copy_item(norma_ply_property(header, plan->element, i));
    plan->item_count = plan->element->property_count;
    if (!state->edit.corners || header->strip_list == PLY_NONE) return NORMA_DOCUMENT_OK;
    norma_document_result result = encode_strips(document, plan->element, lists, error);
    if (result) return result;
    int restarts = 0;
    uint32_t longest = 0;
    for (size_t i = 0; i < lists->item_count; ++i) restarts |= lists->items[i] < 0;
    for (size_t row = 0; row < plan->element->count; ++row)
        longest = lists->counts[row] > longest ? lists->counts[row] : longest;
    ply_item *item = &plan->items[header->strip_list];
    item->action = PLY_INDICES;
    item->type = ply_widen(item->type, highest_index(state), restarts);
    item->count_type = ply_widen(item->count_type, longest, 0);
    plan->lists = lists;
    plan->changed = 1;
    return NORMA_DOCUMENT_OK;
}

static norma_document_result make_plan(norma_document *document, size_t index, ply_plan *plan,
    ply_lists *lists, norma_document_error *error) {
    const ply_state *state = document->state;
    plan->element = &state->header.elements[index];
    plan->items = norma_io_allocate(plan->element->property_count + 3, sizeof *plan->items);
    if (!plan->items) return norma_document_fail_memory(document, error);
    if ((int)index == state->header.vertex)
        plan_vertex(state, plan);
    else if ((int)index == state->header.face)
        plan_faces(state, plan);
    else if ((int)index == state->header.strips)
        return plan_strips(document, plan, lists, error);
    return NORMA_DOCUMENT_OK;
}

/* ---- the header */

typedef struct header_writer {
    const ply_state *state;
    norma_sink *sink;
    size_t at; /* up to where the old header has been copied */
} header_writer;

static void copy_to(header_writer *writer, size_t offset) {
    norma_sink_put(writer->sink, writer->state->bytes + writer->at, offset - writer->at);
    writer->at = offset;
}

static void replace_word(header_writer *writer, ply_span word, const char *text) {
    copy_to(writer, word.offset);
    norma_sink_put(writer->sink, text, strlen(text));
    writer->at = word.offset + word.length;
}

static int names_bits(const ply_state *state, ply_span type_text) {
    unsigned char last = state->bytes[type_text.offset + type_text.length - 1];
    return last >= '0' && last <= '9';
}

static void insert_normal_line(header_writer *writer, const ply_property *after, int axis) {
    const ply_state *state = writer->state;
    const char *type = norma_ply_type_name(PLY_FLOAT, names_bits(state, after->type_text));
    const char name[] = {' ', 'n', (char)('x' + axis)};
    copy_to(writer, after->line_end);
    norma_sink_put(writer->sink, "property ", 9);
    norma_sink_put(writer->sink, type, strlen(type));
    norma_sink_put(writer->sink, name, sizeof name);
    norma_sink_put(writer->sink, state->bytes + state->header.line_break.offset,
        state->header.line_break.length);
}

static void write_header_part(header_writer *writer, const ply_plan *plan) {
    const ply_property *before = NULL;
    int inserted = 0;
    size_t dropped = 0, added = plan->added_count;
    for (size_t row = 0; plan->dropped_rows && row < plan->element->count; ++row)
        dropped += plan->dropped_rows[row] != 0;
    for (size_t row = 0; plan->cut_rows && row < plan->element->count; ++row)
        added += norma_ply_is_cut(plan, row) ? norma_ply_row_corners(plan, row) - 3 : 0;
    if (added > 0 || dropped > 0) {
        char count[20 + 1];
        count[norma_number_format_integer(plan->element->count + added - dropped, count)] = '\0';
        replace_word(writer, plan->element->count_text, count);
    }
    for (size_t i = 0; i < plan->item_count; ++i) {
        const ply_item *item = &plan->items[i];
        if (!item->source) {
            insert_normal_line(writer, before, inserted++);
            continue;
        }
        before = item->source;
        const int bits = names_bits(writer->state, before->type_text);
        if (item->count_type != before->count_type)
            replace_word(
                writer, before->count_type_text, norma_ply_type_name(item->count_type, bits));
        if (item->type != before->type)
            replace_word(writer, before->type_text, norma_ply_type_name(item->type, bits));
    }
}

/* ---- all of it */

static norma_document_result ply_write_elements(norma_document *document, const ply_plan *plans,
    norma_sink *sink, norma_document_error *error) {
    const ply_state *state = document->state;
    header_writer writer = {.state = state, .sink = sink};
    for (size_t i = 0; i < state->header.element_count; ++i) write_header_part(&writer, &plans[i]);
    copy_to(&writer, state->header.body);
    size_t at = state->header.body;
    for (size_t i = 0; i < state->header.element_count; ++i) {
        const ply_element *element = plans[i].element;
        norma_document_result result = NORMA_DOCUMENT_OK;
        if (!plans[i].changed)
            norma_sink_put(sink, state->bytes + element->begin, element->end - element->begin);
        else if (state->header.encoding == PLY_ASCII)
            result = norma_ply_write_text_rows(document, &plans[i], sink, error);
        else
            result = norma_ply_write_rows(document, &plans[i], sink, error);
        if (result) return result;
        at = element->end;
    }
    norma_sink_put(sink, state->bytes + at, state->size - at);
    return NORMA_DOCUMENT_OK;
}

/* ---- parts of it, for files that are never in memory as a whole */

static void measure_written(const ply_state *state, const ply_plan *plan, ply_row *row) {
    int axis = 0;
    *row = (ply_row){0};
    for (size_t i = 0; i < plan->item_count; ++i) {
        const ply_item *item = &plan->items[i];
        const int own = item->source ? ply_axis_of(state->header.normal, (int)i) : axis++;
        if (item->action == PLY_VALUE && own != PLY_NONE) row->normal[own] = row->size;
        row->size += norma_ply_type_size(item->type);
    }
}

norma_document_result norma_ply_write_header(
    norma_document *document, norma_sink *sink, ply_row *row, norma_document_error *error) {
    const ply_state *state = document->state;
    header_writer writer = {.state = state, .sink = sink};
    ply_lists lists = {0};
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (size_t i = 0; i < state->header.element_count && !result; ++i) {
        ply_plan plan = {0};
        result = make_plan(document, i, &plan, &lists, error);
        if (!result) write_header_part(&writer, &plan);
        if (!result && (int)i == state->header.vertex) measure_written(state, &plan, row);
        free(plan.items);
    }
    copy_to(&writer, state->header.body);
    return result;
}

norma_document_result norma_ply_write_vertices(
    norma_document *document, norma_sink *sink, norma_document_error *error) {
    const ply_state *state = document->state;
    ply_plan plan = {0};
    norma_document_result result =
        make_plan(document, (size_t)state->header.vertex, &plan, NULL, error);
    if (!result) result = norma_ply_write_rows(document, &plan, sink, error);
    free(plan.items);
    return result;
}

norma_document_result norma_ply_write_changed(
    norma_document *document, norma_sink *sink, norma_document_error *error) {
    const ply_state *state = document->state;
    ply_lists lists = {0};
    ply_plan *plans = norma_io_allocate(state->header.element_count, sizeof *plans);
    norma_document_result result =
        plans ? NORMA_DOCUMENT_OK : norma_document_fail_memory(document, error);
    for (size_t i = 0; !result && i < state->header.element_count; ++i)
        result = make_plan(document, i, &plans[i], &lists, error);
    if (!result) result = ply_write_elements(document, plans, sink, error);
    for (size_t i = 0; plans && i < state->header.element_count; ++i) free(plans[i].items);
    free(plans);
    norma_ply_free_lists(&lists);
    return result;
}
