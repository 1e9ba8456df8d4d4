/* large_ply.c: a binary PLY read through windows, and its faces gone through once. */
#include "io/large/large.h"

/* ---- A binary PLY read through windows. Vertices are rows of one size, so any block of
 * them can be read; faces are walked once, and found again by the offsets of their chunks. */

/* ---- opening */

static norma_document_result large_read_header(large_file *file, ply_state *state) {
    norma_document *document = file->document;
    document->functions = &norma_ply_functions;
    state->bytes = document->source.data;
    state->size = document->source.size;
    return norma_ply_read_header(document, file->error);
}

static const char *why_whole(const ply_state *state) {
    const ply_header *header = &state->header;
    const ply_element *strips = norma_ply_element(header, header->strips);
    if (header->encoding == PLY_ASCII) return "an ASCII PLY is read whole";
    if (header->elements[header->vertex].list_count) return "its vertices have lists";
    if (strips && strips->count && header->strip_list != PLY_NONE)
        return "triangle strips are read whole";
    return NULL;
}

static norma_document_result large_walk_row(
    large_ply *ply, const ply_element *element, uint64_t row, int is_read);

/* Elements with lists that are not read are walked row by row. */
static norma_document_result walk_element(large_ply *ply, ply_element *element, uint64_t *at) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    norma_large_reader_seek(&ply->rows, *at);
    for (uint64_t row = 0; row < element->count && !result; ++row)
        result = large_walk_row(ply, element, row, 0);
    *at = norma_large_reader_tell(&ply->rows);
    return result;
}

/* Faces end where the survey of them ends; what follows is copied. */
static norma_document_result find_elements(large_ply *ply) {
    ply_header *header = &ply->state->header;
    uint64_t at = header->body;
    for (size_t i = 0; i < header->element_count; ++i) {
        ply_element *element = &header->elements[i];
        element->begin = (size_t)at;
        const uint64_t left = ply->file->size - at;
        if (element->fixed_size > 0 && element->count > left / element->fixed_size)
            return norma_ply_fail_short(ply->file->document, ply->file->error,
                (size_t)ply->file->size, element, left / element->fixed_size);
        const int vertices_follow = (int)i < header->vertex || (int)i < header->face;
        if (element->list_count == 0)
            at += element->count * element->fixed_size;
        else if (vertices_follow) {
            norma_document_result result = walk_element(ply, element, &at);
            if (result) return result;
        }
        element->end = (size_t)at;
    }
    return NORMA_DOCUMENT_OK;
}

static void choose_positions(large_ply *ply) {
    const ply_header *header = &ply->state->header;
    const int *position = header->position;
    int plain = norma_ply_is_native(header->encoding);
    ply->single = norma_ply_fits_float(header, ply->vertex, position);
    for (int axis = 0; axis < 3; ++axis)
        plain &= norma_ply_property(header, ply->vertex, position[axis])->type == PLY_FLOAT &&
                 position[axis] == position[0] + axis;
    if (plain) ply->plain_floats = 1 + norma_ply_offset_in_row(header, ply->vertex, position[0]);
}

static int large_make_room(large_ply *ply, size_t more) {
    large_faces *chunk = &ply->chunk;
    const size_t needed = chunk->corner_count + more;
    if (needed <= chunk->capacity) return 1;
    const size_t capacity = needed < (size_t)3 * LARGE_CHUNK ? (size_t)3 * LARGE_CHUNK : 2 * needed;
    uint32_t *grown = norma_large_grow(
        &ply->file->budget, chunk->corners, chunk->capacity, capacity, sizeof *grown);
    if (!grown) return 0;
    chunk->corners = grown;
    chunk->capacity = capacity;
    return 1;
}

static norma_document_result open_parts(large_ply *ply) {
    large_budget *budget = &ply->file->budget;
    ply->scratch = norma_large_take(budget, LARGE_BLOCK, 3 * sizeof *ply->scratch);
    ply->chunk.starts = norma_large_take(budget, LARGE_CHUNK + 1, sizeof *ply->chunk.starts);
    if (!norma_large_reader_open(ply->file, &ply->rows) ||
        !norma_large_reader_open(ply->file, &ply->blocks) || !ply->scratch || !ply->chunk.starts ||
        !large_make_room(ply, 1))
        return norma_large_fail_memory(ply->file);
    return find_elements(ply);
}

norma_document_result norma_large_ply_open(large_file *file, large_ply *ply) {
    *ply = (large_ply){.file = file};
    ply->state = file->document->state = norma_io_allocate(1, sizeof *ply->state);
    if (!ply->state) return norma_large_fail_memory(file);
    norma_document_result result = large_read_header(file, ply->state);
    if (result) return result;
    const ply_header *header = &ply->state->header;
    const char *whole = why_whole(ply->state);
    ply->vertex = norma_ply_element(header, header->vertex);
    ply->face = header->face_list == PLY_NONE ? NULL : norma_ply_element(header, header->face);
    ply->faces = ply->face ? ply->face->count : 0;
    if (ply->vertex->count >= UINT32_MAX) whole = "it has more than 4294967294 vertices";
    if (whole) return norma_large_fail_whole(file, whole);
    ply->vertices = ply->state->vertices = (size_t)ply->vertex->count;
    choose_positions(ply);
    return open_parts(ply);
}

void norma_large_ply_close(large_ply *ply) {
    if (!ply->file) return;
    large_budget *budget = &ply->file->budget;
    norma_large_reader_close(&ply->rows);
    norma_large_reader_close(&ply->blocks);
    norma_large_give(budget, ply->scratch, LARGE_BLOCK, 3 * sizeof *ply->scratch);
    norma_large_give(budget, ply->chunk.starts, LARGE_CHUNK + 1, sizeof *ply->chunk.starts);
    norma_large_give(budget, ply->chunk.corners, ply->chunk.capacity, sizeof *ply->chunk.corners);
}

/* ---- vertices */

/* Rows from first on, at most LARGE_BLOCK. NULL: file->error says why. */
static const unsigned char *rows_of(
    large_ply *ply, size_t first, size_t count, norma_document_result *result) {
    const size_t size = ply->vertex->fixed_size;
    *result = NORMA_DOCUMENT_OK;
    norma_large_reader_seek(&ply->blocks, ply->vertex->begin + (uint64_t)first * size);
    const unsigned char *rows = norma_large_peek(&ply->blocks, count * size);
    if (!rows)
        *result = ply->blocks.result ? ply->blocks.result
                                     : norma_large_fail_whole(
                                           ply->file, "its vertices take more than 128 bytes each");
    return rows;
}

/* The state, as long as a block is looked at, seen as a file of these rows alone. */
typedef struct large_view {
    const unsigned char *bytes;
    size_t begin, vertices;
    uint64_t count;
} large_view;

static large_view look_at_rows(large_ply *ply, const unsigned char *rows, size_t count) {
    ply_state *state = ply->state;
    ply_element *vertex = &state->header.elements[state->header.vertex];
    const large_view before = {state->bytes, vertex->begin, state->vertices, vertex->count};
    state->bytes = rows;
    state->vertices = count;
    vertex->begin = 0;
    vertex->count = count;
    return before;
}

static void look_away(large_ply *ply, const large_view *before) {
    ply_state *state = ply->state;
    ply_element *vertex = &state->header.elements[state->header.vertex];
    state->bytes = before->bytes;
    state->vertices = before->vertices;
    vertex->begin = before->begin;
    vertex->count = before->count;
}

norma_document_result norma_large_ply_positions(
    large_ply *ply, size_t first, size_t count, void *positions) {
    norma_document_result result;
    const unsigned char *rows = rows_of(ply, first, count, &result);
    if (!rows) return result;
    if (!ply->plain_floats) {
        const ply_header *header = &ply->state->header;
        norma_ply_decode_rows(header, ply->vertex, header->position, rows, count, ply->scratch);
        if (ply->single) norma_ply_narrow(ply->scratch, 3 * count);
        if (positions != ply->scratch)
            memcpy(positions, ply->scratch, count * norma_large_position_size(ply));
        return NORMA_DOCUMENT_OK;
    }
    const unsigned char *at = rows + ply->plain_floats - 1;
    for (size_t i = 0; i < count; ++i, at += ply->vertex->fixed_size)
        memcpy((unsigned char *)positions + 12 * i, at, 12);
    return NORMA_DOCUMENT_OK;
}

norma_document_result norma_large_gather_positions(
    large_ply *ply, const large_bits *members, size_t base, size_t end, void *positions) {
    const size_t size = norma_large_position_size(ply);
    unsigned char *out = positions;
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (size_t first = base; first < end && !result; first += LARGE_BLOCK) {
        const size_t count = norma_large_some(end - first, LARGE_BLOCK);
        if (!norma_large_bits_any(members, first - base, first - base + count)) continue;
        result = norma_large_ply_positions(ply, first, count, ply->scratch);
        for (size_t i = 0; i < count && !result; ++i)
            if (norma_large_bits_has(members, first - base + i)) {
                memcpy(out, (const unsigned char *)ply->scratch + i * size, size);
                out += size;
            }
    }
    return result;
}

/* ---- rows with other normals */

norma_document_result norma_large_ply_stored(
    large_ply *ply, size_t first, size_t count, double **stored) {
    const int *normal = ply->state->header.normal;
    norma_document_result result = NORMA_DOCUMENT_OK;
    *stored = NULL;
    if (normal[0] == PLY_NONE) return result;
    const unsigned char *rows = rows_of(ply, first, count, &result);
    if (!rows) return result;
    const large_view before = look_at_rows(ply, rows, count);
    result =
        norma_ply_read_columns(ply->file->document, ply->vertex, normal, stored, ply->file->error);
    look_away(ply, &before);
    return result;
}

/* The header, with its rows, or the vertices that are looked at. Normals as the writer asks for
 * them while it plans. */
static norma_document_result write_with(
    large_ply *ply, float *normals, ply_row *row, norma_write *write, void *user) {
    large_file *file = ply->file;
    norma_sink *sink = norma_sink_create(write, user);
    if (!sink) return norma_large_fail_memory(file);
    ply->state->edit.normals.floats = normals;
    const norma_document_result result =
        row ? norma_ply_write_header(file->document, sink, row, file->error)
            : norma_ply_write_vertices(file->document, sink, file->error);
    ply->state->edit.normals.floats = NULL;
    norma_sink_finish(sink);
    return result;
}

norma_document_result norma_large_ply_write_header(
    large_ply *ply, norma_write *write, void *user, ply_row *row) {
    const ply_header *header = &ply->state->header;
    ply_type *types = ply->state->edit.normals.types;
    float unit[3] = {0, 0, 1};
    types[0] = types[1] = types[2] = PLY_FLOAT;
    if (header->normal[0] != PLY_NONE)
        norma_ply_normal_types(header, ply->vertex, header->normal, types);
    return write_with(ply, unit, row, write, user);
}

norma_document_result norma_large_ply_write_rows(
    large_ply *ply, size_t first, size_t count, float *normals, norma_write *write, void *user) {
    norma_document_result result;
    const unsigned char *rows = rows_of(ply, first, count, &result);
    if (!rows) return result;
    const large_view before = look_at_rows(ply, rows, count);
    result = write_with(ply, normals, NULL, write, user);
    look_away(ply, &before);
    return result;
}

/* ---- faces */

/* Of the list of a row: count of them at `at`. */
static norma_document_result large_take_corners(
    large_ply *ply, const unsigned char *at, size_t count, uint64_t offset, uint64_t face) {
    const ply_header *header = &ply->state->header;
    const ply_type type = norma_ply_property(header, ply->face, header->face_list)->type;
    const size_t size = norma_ply_type_size(type);
    uint32_t *out = ply->chunk.corners + ply->chunk.corner_count;
    for (size_t k = 0; k < count; ++k, at += size) {
        const int64_t index = norma_ply_get_integer(at, type, header->encoding);
        if ((uint64_t)index >= ply->vertices)
            return norma_ply_fail_index(ply->file->document, ply->file->error, (size_t)offset,
                "face", face, index, ply->vertices);
        out[k] = (uint32_t)index;
    }
    ply->chunk.corner_count += count;
    return NORMA_DOCUMENT_OK;
}

/* A row of any kind, of faces perhaps read into the chunk. */
static norma_document_result large_walk_row(
    large_ply *ply, const ply_element *element, uint64_t row, int is_read) {
    const ply_header *header = &ply->state->header;
    large_reader *reader = &ply->rows;
    norma_document *document = ply->file->document;
    const uint64_t begin = norma_large_reader_tell(reader);
    for (size_t i = 0; i < element->property_count; ++i) {
        const ply_property *property = norma_ply_property(header, element, (int)i);
        const int is_list = norma_ply_is_list(property);
        const size_t first = norma_ply_type_size(is_list ? property->count_type : property->type);
        const unsigned char *at = norma_large_peek(reader, first);
        const int64_t items =
            at && is_list ? norma_ply_get_integer(at, property->count_type, header->encoding) : 0;
        if (items < 0)
            return norma_ply_fail_at(document, ply->file->error,
                (size_t)norma_large_reader_tell(reader), "a list of negative length");
        const uint64_t size = first + (uint64_t)items * norma_ply_type_size(property->type);
        if (reader->result) return reader->result;
        if (!at || size > ply->file->size - norma_large_reader_tell(reader))
            return norma_ply_fail_short(
                document, ply->file->error, (size_t)ply->file->size, element, row);
        if (is_read && (int)i == header->face_list) {
            at = norma_large_peek(reader, size < SMALL_BUFFER ? (size_t)size : SIZE_MAX);
            if (!at && reader->result) return reader->result;
            if (!at) return norma_large_fail_whole(ply->file, "a face is longer than a megabyte");
            if (!large_make_room(ply, (size_t)items)) return norma_large_fail_memory(ply->file);
            norma_document_result result =
                large_take_corners(ply, at + first, (size_t)items, begin, row);
            if (result) return result;
        }
        norma_large_reader_seek(reader, norma_large_reader_tell(reader) + size);
    }
    return NORMA_DOCUMENT_OK;
}

size_t norma_large_even_row(const large_ply *ply) {
    const ply_header *header = &ply->state->header;
    if (!ply->face || ply->face->list_count != 1) return 0;
    return ply->face->fixed_size +
           3 * norma_ply_type_size(norma_ply_property(header, ply->face, header->face_list)->type);
}

static int large_are_triangles(
    const large_ply *ply, const unsigned char *rows, size_t count, size_t row_size) {
    const ply_header *header = &ply->state->header;
    const ply_type type = norma_ply_property(header, ply->face, header->face_list)->count_type;
    const size_t list = norma_ply_offset_in_row(header, ply->face, header->face_list);
    if (norma_ply_type_size(type) == 1) {
        unsigned differs = 0;
        for (size_t i = 0; i < count; ++i) differs |= rows[i * row_size + list] ^ 3u;
        return !differs;
    }
    for (size_t i = 0; i < count; ++i)
        if (norma_ply_get_integer(rows + i * row_size + list, type, header->encoding) != 3)
            return 0;
    return 1;
}

norma_document_result norma_large_are_even(
    large_ply *ply, uint64_t offset, size_t count, int *are_even) {
    const size_t row_size = norma_large_even_row(ply);
    norma_large_reader_seek(&ply->rows, offset);
    const unsigned char *rows = norma_large_peek(&ply->rows, count * row_size);
    *are_even = rows && large_are_triangles(ply, rows, count, row_size);
    return ply->rows.result;
}

/* *done: whether all rows were triangles. */
static norma_document_result large_read_triangles(
    large_ply *ply, uint64_t first, size_t count, int *done) {
    const ply_header *header = &ply->state->header;
    const ply_property *property = norma_ply_property(header, ply->face, header->face_list);
    const size_t row_size = norma_large_even_row(ply),
                 items = norma_ply_offset_in_row(header, ply->face, header->face_list) +
                         norma_ply_type_size(property->count_type);
    const unsigned char *rows = row_size ? norma_large_peek(&ply->rows, count * row_size) : NULL;
    const uint64_t begin = norma_large_reader_tell(&ply->rows);
    *done = rows && large_are_triangles(ply, rows, count, row_size);
    if (!*done) return ply->rows.result;
    if (!large_make_room(ply, 3 * count)) return norma_large_fail_memory(ply->file);
    const int native = norma_ply_is_native(header->encoding) &&
                       (property->type == PLY_INT32 || property->type == PLY_UINT32);
    if (!native || norma_ply_copy_triangles(rows + items, row_size, count, ply->chunk.corners) >=
                       ply->vertices)
        for (size_t i = 0; i < count; ++i) {
            norma_document_result result = large_take_corners(
                ply, rows + i * row_size + items, 3, begin + i * row_size, first + i);
            if (result) return result;
        }
    ply->chunk.corner_count = 3 * count;
    for (size_t i = 0; i <= count; ++i) ply->chunk.starts[i] = (uint32_t)(3 * i);
    norma_large_reader_seek(&ply->rows, begin + count * row_size);
    return NORMA_DOCUMENT_OK;
}

norma_document_result norma_large_ply_chunk(
    large_ply *ply, uint64_t first, size_t count, uint64_t *offset) {
    large_faces *chunk = &ply->chunk;
    int done = 0;
    chunk->count = count;
    chunk->corner_count = 0;
    chunk->starts[0] = 0;
    norma_large_reader_seek(&ply->rows, *offset);
    norma_document_result result = large_read_triangles(ply, first, count, &done);
    for (size_t i = 0; i < count && !result && !done; ++i) {
        result = large_walk_row(ply, ply->face, first + i, 1);
        chunk->starts[i + 1] = (uint32_t)chunk->corner_count;
    }
    *offset = norma_large_reader_tell(&ply->rows);
    return result;
}

/* ---- The faces of a large PLY, gone through once. */

/* begun and ended hold, until all faces are counted, those of the stretch before. */
static void count_face(large_survey *survey, const uint32_t *corners, size_t count) {
    size_t seen[3], distinct = 0, least = SIZE_MAX, most = 0;
    for (size_t k = 0; k < count; ++k) {
        const size_t stretch = corners[k] / survey->stretch;
        int known = 0;
        for (size_t i = 0; i < distinct; ++i) known |= seen[i] == stretch;
        if (known || distinct == 3) continue;
        seen[distinct++] = stretch;
        ++survey->touching[stretch];
        least = stretch < least ? stretch : least;
        most = stretch > most ? stretch : most;
    }
    for (size_t i = 0; i < distinct && distinct > 1; ++i) ++survey->crossing[seen[i]];
    if (!distinct) return;
    ++survey->begun[least + 1];
    ++survey->ended[most + 1];
}

static void count_chunk(
    const large_faces *faces, uint64_t first, large_survey *survey, large_chunk *chunk) {
    for (size_t i = 0; i < faces->corner_count; ++i) {
        const uint32_t vertex = faces->corners[i];
        chunk->least = vertex < chunk->least ? vertex : chunk->least;
        chunk->most = vertex > chunk->most ? vertex : chunk->most;
    }
    for (size_t i = 0; i < faces->count; ++i) {
        const size_t corners = faces->starts[i + 1] - faces->starts[i];
        if (!corners && survey->empty.count++ == 0) survey->empty.first = (size_t)first + i;
        survey->polygons |= corners != 3;
        survey->triangles += corners > 2 ? corners - 2 : 0;
        count_face(survey, faces->corners + faces->starts[i], corners);
    }
    survey->corners += faces->corner_count;
}

static void sum_stretches(large_survey *survey) {
    for (size_t i = 1; i <= survey->stretches; ++i) {
        survey->begun[i] += survey->begun[i - 1];
        survey->ended[i] += survey->ended[i - 1];
    }
}

static int open_survey(large_ply *ply, large_survey *survey) {
    large_budget *budget = &ply->file->budget;
    survey->stretch = ply->vertices / LARGE_STRETCHES + 1;
    survey->stretches = ply->vertices / survey->stretch + 1;
    survey->chunk_count = (size_t)(ply->faces / LARGE_CHUNK) + (ply->faces % LARGE_CHUNK != 0);
    survey->chunks = norma_large_take(budget, survey->chunk_count, sizeof *survey->chunks);
    survey->touching = norma_large_take_zeroed(budget, survey->stretches, sizeof *survey->touching);
    survey->crossing = norma_large_take_zeroed(budget, survey->stretches, sizeof *survey->crossing);
    survey->begun = norma_large_take_zeroed(budget, survey->stretches + 1, sizeof *survey->begun);
    survey->ended = norma_large_take_zeroed(budget, survey->stretches + 1, sizeof *survey->ended);
    return survey->chunks && survey->touching && survey->crossing && survey->begun && survey->ended;
}

norma_document_result norma_large_survey(large_ply *ply, large_survey *survey) {
    *survey = (large_survey){.end = ply->face ? ply->face->begin : 0, .empty = {0, SIZE_MAX}};
    norma_document_result result =
        open_survey(ply, survey) ? NORMA_DOCUMENT_OK : norma_large_fail_memory(ply->file);
    for (size_t i = 0; i < survey->chunk_count && !result; ++i) {
        survey->chunks[i] = (large_chunk){survey->end, UINT32_MAX, 0};
        result = norma_large_ply_chunk(
            ply, (uint64_t)i * LARGE_CHUNK, norma_large_chunk_faces(ply, i), &survey->end);
        if (!result)
            count_chunk(&ply->chunk, (uint64_t)i * LARGE_CHUNK, survey, &survey->chunks[i]);
        if (!result && i % 64 == 0)
            result = norma_large_tell(ply->file, (double)i / (double)survey->chunk_count);
    }
    if (!result && survey->begun) sum_stretches(survey);
    return result;
}

void norma_large_survey_close(large_ply *ply, large_survey *survey) {
    if (!ply->file) return;
    large_budget *budget = &ply->file->budget;
    norma_large_give(budget, survey->chunks, survey->chunk_count, sizeof *survey->chunks);
    norma_large_give(budget, survey->touching, survey->stretches, sizeof *survey->touching);
    norma_large_give(budget, survey->crossing, survey->stretches, sizeof *survey->crossing);
    norma_large_give(budget, survey->begun, survey->stretches + 1, sizeof *survey->begun);
    norma_large_give(budget, survey->ended, survey->stretches + 1, sizeof *survey->ended);
    *survey = (large_survey){0};
}
