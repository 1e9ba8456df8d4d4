/* ply_read.c: positions, corners and normals of a PLY for the core: views of the file's own bytes
 * where their layout allows, decoded copies elsewhere. */
#include "io/ply/ply.h"
#include <stdlib.h>

/* ---- Triangle strips as VRML and old scanning tools write them into PLY: one list
 * of vertices, -1 where a strip ends and the next begins. Every second triangle of a strip runs the
 * other way. */

size_t norma_ply_strip_triangles(const int64_t *items, size_t count, uint32_t *corners) {
    size_t length = 0, triangles = 0;
    for (size_t i = 0; i < count; ++i) {
        length = items[i] < 0 ? 0 : length + 1;
        if (length < 3) continue;
        if (corners) {
            int odd = length % 2 == 0;
            corners[3 * triangles] = (uint32_t)items[odd ? i - 1 : i - 2];
            corners[3 * triangles + 1] = (uint32_t)items[odd ? i - 2 : i - 1];
            corners[3 * triangles + 2] = (uint32_t)items[i];
        }
        ++triangles;
    }
    return triangles;
}

/* The corner that completes the triangle after the directed edge from -> to, or -1. */
static int64_t completing(const uint32_t triangle[3], int64_t from, int64_t to) {
    for (int k = 0; k < 3; ++k)
        if (triangle[k] == from && triangle[(k + 1) % 3] == to) return triangle[(k + 2) % 3];
    return -1;
}

/* The rotation of a strip's first triangle after which the second can follow. */
static int first_rotation(const uint32_t *triangle, const uint32_t *next) {
    for (int k = 0; k < 3 && next; ++k)
        if (completing(next, triangle[(k + 2) % 3], triangle[(k + 1) % 3]) >= 0) return k;
    return 0;
}

size_t norma_ply_strip_encode(const uint32_t *corners, size_t triangles, int64_t *out) {
    size_t size = 0, length = 0;
    for (size_t t = 0; t < triangles; ++t) {
        const uint32_t *triangle = corners + 3 * t;
        int odd = length % 2 == 1; /* the next triangle of a strip of `length` vertices */
        int64_t more =
            length < 3 ? -1
                       : completing(triangle, out[size - (odd ? 1 : 2)], out[size - (odd ? 2 : 1)]);
        if (more >= 0) {
            out[size++] = more;
            ++length;
            continue;
        }
        if (size > 0) out[size++] = -1;
        int first = first_rotation(triangle, t + 1 < triangles ? triangle + 3 : NULL);
        for (int k = 0; k < 3; ++k) out[size++] = triangle[(first + k) % 3];
        length = 3;
    }
    return size;
}

/* ---- three properties of each row */

static void read_rows_with_lists(
    const ply_state *state, const ply_element *element, const int properties[3], double *values) {
    const ply_header *header = &state->header;
    const unsigned char *at = state->bytes + element->begin;
    for (size_t row = 0; row < element->count; ++row) {
        for (size_t i = 0; i < element->property_count; ++i) {
            const ply_property *property = norma_ply_property(header, element, (int)i);
            for (int axis = 0; axis < 3; ++axis)
                if (properties[axis] == (int)i)
                    values[3 * row + (size_t)axis] =
                        norma_ply_get(at, property->type, header->encoding);
            at += norma_ply_property_size(header, property, at);
        }
    }
}

norma_document_result norma_ply_read_columns(norma_document *document, const ply_element *element,
    const int properties[3], double **values, norma_document_error *error) {
    const ply_state *state = document->state;
    double *read = element->count > SIZE_MAX / 24
                       ? NULL
                       : norma_io_allocate((size_t)element->count, 3 * sizeof *read);
    if (!read) return norma_document_fail_memory(document, error);
    norma_document_result result = NORMA_DOCUMENT_OK;
    if (state->header.encoding == PLY_ASCII)
        result = norma_ply_read_text_columns(document, element, properties, read, error);
    else if (element->list_count == 0)
        norma_ply_decode_rows(&state->header, element, properties, state->bytes + element->begin,
            (size_t)element->count, read);
    else
        read_rows_with_lists(state, element, properties, read);
    if (result) {
        free(read);
        read = NULL;
    }
    *values = read;
    return result;
}

static norma_format ply_format_of(ply_type type) {
    static const norma_format formats[] = {[PLY_INT8] = NORMA_FORMAT_INT8,
        [PLY_UINT8] = NORMA_FORMAT_UINT8,
        [PLY_INT16] = NORMA_FORMAT_INT16,
        [PLY_UINT16] = NORMA_FORMAT_UINT16,
        [PLY_FLOAT] = NORMA_FORMAT_FLOAT,
        [PLY_DOUBLE] = NORMA_FORMAT_DOUBLE};
    return formats[type];
}

/* Whether the core can read the three right from the file. */
static int view_rows(const ply_state *state, const ply_element *element, const int properties[3],
    norma_vec3_view *view) {
    const ply_header *header = &state->header;
    const ply_property *first = norma_ply_property(header, element, properties[0]);
    const size_t size = norma_ply_type_size(first->type);
    if (header->encoding == PLY_ASCII || (!norma_ply_is_native(header->encoding) && size > 1) ||
        element->list_count > 0)
        return 0;
    if (first->type == PLY_INT32 || first->type == PLY_UINT32) return 0;
    for (int axis = 1; axis < 3; ++axis)
        if (properties[axis] != properties[0] + axis ||
            norma_ply_property(header, element, properties[axis])->type != first->type)
            return 0;
    *view = (norma_vec3_view){.data = state->bytes + element->begin +
                                      norma_ply_offset_in_row(header, element, properties[0]),
        .count = (size_t)element->count,
        .stride = element->fixed_size,
        .format = ply_format_of(first->type)};
    return 1;
}

static norma_document_result ply_read_positions(
    norma_document *document, norma_document_error *error) {
    ply_state *state = document->state;
    const ply_header *header = &state->header;
    const ply_element *vertex = norma_ply_element(header, header->vertex);
    if (view_rows(state, vertex, header->position, &state->mesh.positions))
        return NORMA_DOCUMENT_OK;
    double *values = NULL;
    norma_document_result result =
        norma_ply_read_columns(document, vertex, header->position, &values, error);
    state->mesh.own_positions = values;
    if (result) return result;
    const int single = norma_ply_fits_float(header, vertex, header->position);
    if (single) norma_ply_narrow(values, 3 * (size_t)vertex->count);
    state->mesh.positions = (norma_vec3_view){.data = values,
        .count = (size_t)vertex->count,
        .format = single ? NORMA_FORMAT_FLOAT : NORMA_FORMAT_DOUBLE};
    return NORMA_DOCUMENT_OK;
}

/* ---- lists */

/* 0: rows are beyond the bytes, though they were found to fit: a mapped file has changed since. */
static int count_binary_lists(
    const ply_state *state, const ply_element *element, int list, uint32_t *counts, size_t *total) {
    const ply_header *header = &state->header;
    const ply_type count_type = norma_ply_property(header, element, list)->count_type;
    size_t row = element->begin, at = 0, bad, size;
    for (size_t i = 0; i < element->count; ++i, row += size) {
        size = norma_ply_measure_row(state, element, row, list, &at, &bad);
        if (!size) return 0;
        counts[i] =
            (uint32_t)norma_ply_get_integer(state->bytes + at, count_type, header->encoding);
        *total += counts[i];
    }
    return 1;
}

static int read_binary_lists(
    const ply_state *state, const ply_element *element, int list, ply_lists *lists) {
    const ply_header *header = &state->header;
    const ply_property *property = norma_ply_property(header, element, list);
    const size_t item_size = norma_ply_type_size(property->type),
                 count_size = norma_ply_type_size(property->count_type);
    size_t row = element->begin, place = 0, bad, size;
    int64_t *out = lists->items;
    for (size_t i = 0; i < element->count; ++i, row += size) {
        size = norma_ply_measure_row(state, element, row, list, &place, &bad);
        if (!size || (size - (place - row) - count_size) / item_size < lists->counts[i]) return 0;
        const unsigned char *at = state->bytes + place + count_size;
        for (uint32_t k = 0; k < lists->counts[i]; ++k, at += item_size)
            *out++ = norma_ply_get_integer(at, property->type, header->encoding);
    }
    return 1;
}

static norma_document_result fail_changed(norma_document *document, norma_document_error *error) {
    return norma_document_fail_file(document->path, error, "cannot be read", FILE_CHANGED);
}

/* The items too, of text. */
static norma_document_result count_lists(norma_document *document, const ply_element *element,
    int property, ply_lists *lists, norma_document_error *error) {
    const ply_state *state = document->state;
    lists->counts = element->count > SIZE_MAX / 4
                        ? NULL
                        : norma_io_allocate((size_t)element->count, sizeof *lists->counts);
    if (!lists->counts) return norma_document_fail_memory(document, error);
    if (state->header.encoding == PLY_ASCII)
        return norma_ply_read_text_lists(document, element, property, lists, error);
    return count_binary_lists(state, element, property, lists->counts, &lists->item_count)
               ? NORMA_DOCUMENT_OK
               : fail_changed(document, error);
}

norma_document_result norma_ply_read_lists(norma_document *document, const ply_element *element,
    int property, ply_lists *lists, norma_document_error *error) {
    const ply_state *state = document->state;
    norma_document_result result = count_lists(document, element, property, lists, error);
    if (result || state->header.encoding == PLY_ASCII) return result;
    lists->item_capacity = lists->item_count;
    lists->items = lists->item_count > SIZE_MAX / 8
                       ? NULL
                       : norma_io_allocate(lists->item_count, sizeof *lists->items);
    if (!lists->items) return norma_document_fail_memory(document, error);
    return read_binary_lists(state, element, property, lists) ? NORMA_DOCUMENT_OK
                                                              : fail_changed(document, error);
}

void norma_ply_free_lists(ply_lists *lists) {
    free(lists->items);
    free(lists->counts);
    *lists = (ply_lists){0};
}

/* ---- corners */

static size_t triangles_of(uint32_t corners) { return corners > 2 ? corners - 2 : 0; }

static norma_document_result ply_fail_index(norma_document *document, norma_document_error *error,
    const char *element, size_t row, int64_t index) {
    const ply_state *state = document->state;
    const ply_element *of = norma_ply_element(
        &state->header, element[0] == 'f' ? state->header.face : state->header.strips);
    ply_span *spans = NULL;
    norma_ply_row_spans(document, of, &spans, NULL);
    size_t offset = spans ? spans[row].offset : of->begin;
    free(spans);
    return norma_ply_fail_index(document, error, offset, element, row, index, state->vertices);
}

static norma_document_result fail_too_many(
    const norma_document *document, norma_document_error *error) {
    return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, NULL,
        "more than 4294967295 vertices or corners");
}

/* The commonest layout: triangles of a byte and three 32-bit numbers in this machine's order. */
static int is_plain_triangles(const ply_state *state, const ply_element *face) {
    const ply_property *list = norma_ply_property(&state->header, face, state->header.face_list);
    return face->triangle_row == 13 && norma_ply_is_native(state->header.encoding) &&
           (list->type == PLY_INT32 || list->type == PLY_UINT32);
}

static norma_document_result read_plain_triangles(
    norma_document *document, const ply_element *face, norma_document_error *error) {
    ply_state *state = document->state;
    const size_t count = (size_t)face->count;
    uint32_t *corners = state->mesh.corners = norma_io_block(count, 12);
    if (!corners) return norma_document_fail_memory(document, error);
    const uint32_t greatest =
        norma_ply_copy_triangles(state->bytes + face->begin + 1, 13, count, corners);
    for (size_t i = 0; greatest >= state->vertices && i < 3 * count; ++i)
        if (corners[i] >= state->vertices)
            return ply_fail_index(document, error, "face", i / 3,
                norma_ply_property(&state->header, face, 0)->type == PLY_INT32
                    ? (int32_t)corners[i]
                    : (int64_t)corners[i]);
    state->mesh.polygon_corners = 3 * count;
    state->mesh.triangle_count = count;
    return NORMA_DOCUMENT_OK;
}

static int all_triangles(const uint32_t *counts, size_t count) {
    for (size_t i = 0; i < count; ++i)
        if (counts[i] != 3) return 0;
    return 1;
}

static norma_document_result take_face_lists(
    norma_document *document, const ply_lists *lists, size_t rows, norma_document_error *error) {
    ply_state *state = document->state;
    ply_mesh *mesh = &state->mesh;
    mesh->corners = malloc(lists->item_count ? lists->item_count * sizeof *mesh->corners : 1);
    if (!all_triangles(lists->counts, rows))
        mesh->face_starts = norma_io_allocate(rows + 1, sizeof *mesh->face_starts);
    if (!mesh->corners || (!mesh->face_starts && !all_triangles(lists->counts, rows)))
        return norma_document_fail_memory(document, error);
    size_t corner = 0;
    for (size_t row = 0; row < rows; ++row) {
        for (uint32_t k = 0; k < lists->counts[row]; ++k, ++corner) {
            if ((uint64_t)lists->items[corner] >=
                state->vertices) /* a negative one is beyond all */
                return ply_fail_index(document, error, "face", row, lists->items[corner]);
            mesh->corners[corner] = (uint32_t)lists->items[corner];
        }
        if (mesh->face_starts) mesh->face_starts[row + 1] = (uint32_t)corner;
        mesh->triangle_count += triangles_of(lists->counts[row]);
    }
    mesh->polygon_corners = corner;
    return NORMA_DOCUMENT_OK;
}

static norma_document_result read_faces(norma_document *document, norma_document_error *error) {
    ply_state *state = document->state;
    const ply_element *face = norma_ply_element(&state->header, state->header.face);
    if (state->header.face_list == PLY_NONE) return NORMA_DOCUMENT_OK;
    state->mesh.polygon_count = state->mesh.face_count = (size_t)face->count;
    norma_document_result result;
    if (is_plain_triangles(state, face)) {
        result = read_plain_triangles(document, face, error);
    } else {
        ply_lists lists = {0};
        result = norma_ply_read_lists(document, face, state->header.face_list, &lists, error);
        if (!result && lists.item_count > UINT32_MAX) result = fail_too_many(document, error);
        if (!result) result = take_face_lists(document, &lists, (size_t)face->count, error);
        norma_ply_free_lists(&lists);
    }
    state->mesh.corner_count = state->mesh.polygon_corners;
    return result;
}

/* ---- strips, unrolled behind the faces */

static norma_document_result check_strips(norma_document *document, const ply_lists *lists,
    size_t rows, size_t *triangles, norma_document_error *error) {
    const ply_state *state = document->state;
    const int64_t *items = lists->items;
    for (size_t row = 0; row < rows; items += lists->counts[row], ++row) {
        for (uint32_t k = 0; k < lists->counts[row]; ++k)
            if (items[k] < -1 || (items[k] >= 0 && (uint64_t)items[k] >= state->vertices))
                return ply_fail_index(document, error, "strip", row, items[k]);
        *triangles += norma_ply_strip_triangles(items, lists->counts[row], NULL);
    }
    return NORMA_DOCUMENT_OK;
}

static int make_room_for_strips(ply_mesh *mesh, size_t triangles) {
    size_t corners = mesh->corner_count + 3 * triangles;
    uint32_t *grown = realloc(mesh->corners, corners ? corners * sizeof *grown : 1);
    if (!grown) return 0;
    mesh->corners = grown;
    if (!mesh->face_starts) return 1;
    uint32_t *starts =
        realloc(mesh->face_starts, (mesh->face_count + triangles + 1) * sizeof *starts);
    if (!starts) return 0;
    mesh->face_starts = starts;
    return 1;
}

static norma_document_result take_strips(
    norma_document *document, const ply_lists *lists, size_t rows, norma_document_error *error) {
    ply_state *state = document->state;
    ply_mesh *mesh = &state->mesh;
    size_t triangles = 0;
    norma_document_result result = check_strips(document, lists, rows, &triangles, error);
    if (result) return result;
    if (triangles > (UINT32_MAX - mesh->corner_count) / 3) return fail_too_many(document, error);
    if (!make_room_for_strips(mesh, triangles)) return norma_document_fail_memory(document, error);
    const int64_t *items = lists->items;
    for (size_t row = 0; row < rows; items += lists->counts[row], ++row)
        mesh->corner_count += 3 * norma_ply_strip_triangles(items, lists->counts[row],
                                      mesh->corners + mesh->corner_count);
    for (size_t i = 0; mesh->face_starts && i < triangles; ++i)
        mesh->face_starts[mesh->face_count + i + 1] =
            (uint32_t)(mesh->polygon_corners + 3 * (i + 1));
    mesh->face_count += triangles;
    mesh->triangle_count += triangles;
    return NORMA_DOCUMENT_OK;
}

static norma_document_result read_strips(norma_document *document, norma_document_error *error) {
    ply_state *state = document->state;
    const ply_element *strips = norma_ply_element(&state->header, state->header.strips);
    if (state->header.strip_list == PLY_NONE) return NORMA_DOCUMENT_OK;
    ply_lists lists = {0};
    norma_document_result result =
        norma_ply_read_lists(document, strips, state->header.strip_list, &lists, error);
    if (!result) result = take_strips(document, &lists, (size_t)strips->count, error);
    norma_ply_free_lists(&lists);
    return result;
}

/* ---- the whole, or its counts alone */

/* Without the items of the lists: a summary of faces reads their lengths only. */
static norma_document_result ply_count_faces(
    norma_document *document, norma_document_error *error) {
    ply_state *state = document->state;
    const ply_header *header = &state->header;
    const ply_element *face = norma_ply_element(header, header->face);
    if (header->face_list == PLY_NONE) return NORMA_DOCUMENT_OK;
    state->mesh.face_count = (size_t)face->count;
    if (face->triangle_row) {
        state->mesh.triangle_count += (size_t)face->count;
        return NORMA_DOCUMENT_OK;
    }
    ply_lists lists = {0};
    norma_document_result result = count_lists(document, face, header->face_list, &lists, error);
    for (size_t i = 0; !result && i < face->count; ++i)
        state->mesh.triangle_count += triangles_of(lists.counts[i]);
    norma_ply_free_lists(&lists);
    return result;
}

/* Words that should be normals are looked at now, so that a file that cannot be computed is not
 * opened. */
static norma_document_result check_text_normals(norma_document *document,
    const ply_element *element, const int properties[3], norma_document_error *error) {
    if (properties[0] == PLY_NONE) return NORMA_DOCUMENT_OK;
    double *values = NULL;
    norma_document_result result =
        norma_ply_read_columns(document, element, properties, &values, error);
    free(values);
    return result;
}

norma_document_result norma_ply_read_mesh(norma_document *document, norma_document_error *error) {
    ply_state *state = document->state;
    const int whole = document->depth == NORMA_DOCUMENT_WHOLE;
    const ply_element *vertex = norma_ply_vertex(state);
    if (vertex->count > UINT32_MAX) return fail_too_many(document, error);
    state->vertices = (size_t)vertex->count;
    norma_document_result result = whole ? ply_read_positions(document, error) : NORMA_DOCUMENT_OK;
    if (!result) result = whole ? read_faces(document, error) : ply_count_faces(document, error);
    if (!result) result = read_strips(document, error);
    if (!result && whole && state->header.encoding == PLY_ASCII) {
        result = check_text_normals(document, vertex, state->header.normal, error);
        if (!result)
            result =
                check_text_normals(document, norma_ply_element(&state->header, state->header.face),
                    state->header.face_normal, error);
    }
    state->faces = state->mesh.face_count;
    state->triangles = state->mesh.triangle_count;
    return result;
}

norma_mesh norma_ply_core_mesh(const ply_state *state) {
    const ply_mesh *mesh = &state->mesh;
    return (norma_mesh){.positions = mesh->positions,
        .corners = mesh->corners,
        .corner_count = mesh->corner_count,
        .corner_size = 4,
        .face_starts = mesh->face_starts,
        .face_count = mesh->face_count};
}

void norma_ply_free_mesh(ply_mesh *mesh) {
    free(mesh->own_positions);
    free(mesh->corners);
    free(mesh->face_starts);
    *mesh = (ply_mesh){0};
}
