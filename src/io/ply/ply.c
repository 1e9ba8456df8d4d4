/* ply.c: PLY documents: opened, edited, read again, and as a scene. */
#include "io/ply/ply.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- The state of a PLY document: read, let go, and read again once its changes have
 * become bytes. */

static void ply_free_content(void *content) {
    ply_state *state = content;
    norma_ply_forget_edit(state);
    norma_ply_free_mesh(&state->mesh);
    free(state->normals);
    free(state->header.elements);
    free(state->header.properties);
}

static norma_document_result read_source(norma_document *document, norma_document_error *error) {
    ply_state *state = document->state;
    state->bytes = document->source.data;
    state->size = document->source.size;
    norma_document_result result = norma_ply_read_header(document, error);
    if (!result) result = norma_ply_locate(document, error);
    return result ? result : norma_ply_read_mesh(document, error);
}

static const edited_format PLY_EDITED = {sizeof(ply_state), 0, norma_ply_has_edit, ply_free_content,
    read_source, norma_ply_write_changed, norma_ply_forget_edit};

/* ---- Vertices of a PLY as a list of copies of old ones: rows that stay or go, further
 * ones behind them; and which rows are equal. */

/* Elements other than those that are read (edges, say) may name vertices by their numbers. */
static int names_vertices(const ply_state *state) {
    const ply_header *header = &state->header;
    for (size_t i = 0; i < header->element_count; ++i)
        if ((int)i != header->vertex && (int)i != header->face && (int)i != header->strips &&
            header->elements[i].count > 0)
            return 1;
    return 0;
}

/* ---- equal ones */

typedef struct span_rows {
    const unsigned char *bytes;
    const ply_span *spans;
} span_rows;

static const unsigned char *ply_row_of(const void *context, size_t row, size_t *length) {
    const span_rows *rows = context;
    *length = rows->spans[row].length;
    return rows->bytes + rows->spans[row].offset;
}

static norma_document_result ply_equal_vertices(
    norma_document *document, size_t mesh, uint32_t *first, norma_document_error *error) {
    const ply_state *state = document->state;
    ply_span *spans = NULL;
    (void)mesh;
    if (names_vertices(state)) {
        for (size_t v = 0; v < state->vertices; ++v) first[v] = (uint32_t)v;
        return NORMA_DOCUMENT_OK;
    }
    norma_document_result result =
        norma_ply_row_spans(document, norma_ply_vertex(state), &spans, error);
    const span_rows rows = {state->bytes, spans};
    if (!result && !norma_equal_rows(ply_row_of, &rows, state->vertices, first))
        result = norma_document_fail_memory(document, error);
    free(spans);
    return result;
}

/* ---- copies */

/* The edit's list of vertices as a change; how many of them, from the first on, are
 * old rows that stay in their order */
static norma_document_result ply_edit_vertices(
    norma_document *document, const norma_mesh_edit *edit, norma_document_error *error) {
    ply_state *state = document->state;
    ply_edit *change = &state->edit;
    const size_t kept = norma_edit_kept(edit), added = edit->vertex_count - kept;
    if (kept < state->vertices && names_vertices(state))
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, NULL,
            "cannot renumber vertices: an element that is not read may refer to them");
    change->corners = norma_io_allocate(state->mesh.corner_count, sizeof *change->corners);
    change->added = norma_io_allocate(added, sizeof *change->added);
    if (!change->corners || !change->added) return norma_document_fail_memory(document, error);
    if (state->mesh.corner_count)
        memcpy(
            change->corners, edit->new_corners, state->mesh.corner_count * sizeof *change->corners);
    if (added) memcpy(change->added, edit->source_vertices + kept, added * sizeof *change->added);
    change->added_count = added;
    if (kept == state->vertices) return NORMA_DOCUMENT_OK;
    change->dropped_vertices = norma_io_allocate(state->vertices, 1);
    if (!change->dropped_vertices) return norma_document_fail_memory(document, error);
    memset(change->dropped_vertices, 1, state->vertices);
    for (size_t v = 0; v < kept; ++v) change->dropped_vertices[edit->source_vertices[v]] = 0;
    return NORMA_DOCUMENT_OK;
}

/* ---- Faces of a PLY reversed, cut into triangles or left out, normals and positions of
 * single vertices replaced, vertices listed anew: kept as changes beside the bytes, then made
 * bytes. */

static uint8_t *copy_marks(const uint8_t *marks, size_t count) {
    uint8_t *copy = norma_io_allocate(count, 1);
    if (copy && count) memcpy(copy, marks, count);
    return copy;
}

/* Where the values of a vertex of the edit lie among those of a change: by old rows, added ones
 * behind them. */
static size_t ply_place_of(
    const ply_state *state, const norma_mesh_edit *edit, size_t kept, size_t vertex) {
    if (!edit->source_vertices) return vertex;
    return vertex < kept ? edit->source_vertices[vertex] : state->vertices + vertex - kept;
}

static size_t vertex_count(const ply_state *state, const norma_mesh_edit *edit) {
    return edit->source_vertices ? edit->vertex_count : state->vertices;
}

/* Three properties of each vertex as stored, those of the added ones behind them. */
static norma_document_result read_columns(norma_document *document, const int properties[3],
    double **values, norma_document_error *error) {
    const ply_state *state = document->state;
    const size_t count = state->vertices, added = state->edit.added_count;
    norma_document_result result =
        norma_ply_read_columns(document, norma_ply_vertex(state), properties, values, error);
    if (result || added == 0) return result;
    double *grown = count > SIZE_MAX / (6 * sizeof *grown) || added > SIZE_MAX / (6 * sizeof *grown)
                        ? NULL
                        : realloc(*values, 3 * (count + added) * sizeof *grown);
    if (!grown) return norma_document_fail_memory(document, error);
    *values = grown;
    for (size_t i = 0; i < added; ++i)
        memcpy(
            grown + 3 * (count + i), grown + 3 * (size_t)state->edit.added[i], 3 * sizeof *grown);
    return NORMA_DOCUMENT_OK;
}

/* As stored, with codes for the new ones. */
static norma_document_result edit_normals(
    norma_document *document, const norma_mesh_edit *edit, norma_document_error *error) {
    ply_state *state = document->state;
    const ply_element *vertex = norma_ply_vertex(state);
    ply_edit *change = &state->edit;
    double *values = NULL;
    const size_t count = vertex_count(state, edit),
                 kept = edit->source_vertices ? norma_edit_kept(edit) : count;
    float *codes = norma_io_allocate(count, 3 * sizeof *codes);
    norma_document_result result =
        codes ? read_columns(document, state->header.normal, &values, error)
              : norma_document_fail_memory(document, error);
    if (!result) {
        norma_ply_normal_types(&state->header, vertex, state->header.normal, change->normals.types);
        for (size_t i = 0; i < count; ++i)
            if (norma_edit_says(edit->set_normals, i))
                memcpy(codes + 3 * i, edit->normals + 3 * i, 3 * sizeof *codes);
        result = norma_ply_encode_normals(document, change->normals.types, codes, count, error);
    }
    for (size_t i = 0; !result && i < count; ++i)
        for (size_t axis = 0; axis < 3 && norma_edit_says(edit->set_normals, i); ++axis)
            values[3 * ply_place_of(state, edit, kept, i) + axis] = (double)codes[3 * i + axis];
    free(codes);
    if (result)
        free(values);
    else
        change->normals.doubles = values;
    return result;
}

static norma_document_result edit_positions(
    norma_document *document, const norma_mesh_edit *edit, norma_document_error *error) {
    ply_state *state = document->state;
    const ply_element *vertex = norma_ply_vertex(state);
    const size_t count = vertex_count(state, edit),
                 kept = edit->source_vertices ? norma_edit_kept(edit) : count;
    norma_document_result result =
        read_columns(document, state->header.position, &state->edit.positions.doubles, error);
    for (int axis = 0; axis < 3; ++axis)
        state->edit.positions.types[axis] =
            norma_ply_property(&state->header, vertex, state->header.position[axis])->type;
    for (size_t i = 0; !result && i < count; ++i)
        if (norma_edit_says(edit->set_positions, i))
            memcpy(state->edit.positions.doubles + 3 * ply_place_of(state, edit, kept, i),
                edit->positions + 3 * i, 3 * sizeof(double));
    return result;
}

/* Of the polygons alone: a strip has no other faces than triangles. */
static norma_document_result cut_faces(
    norma_document *document, const norma_mesh_edit *edit, norma_document_error *error) {
    ply_state *state = document->state;
    const ply_mesh *mesh = &state->mesh;
    ply_edit *change = &state->edit;
    if (mesh->polygon_corners == 0) return NORMA_DOCUMENT_OK;
    change->cut_rows = copy_marks(edit->cut_faces, mesh->polygon_count);
    change->cut_corners = norma_io_allocate(mesh->polygon_corners, 3 * sizeof *change->cut_corners);
    if (!change->corners)
        change->corners = norma_io_allocate(mesh->corner_count, sizeof *change->corners);
    if (!change->cut_rows || !change->cut_corners || !change->corners)
        return norma_document_fail_memory(document, error);
    memcpy(change->corners, edit->source_vertices ? edit->new_corners : mesh->corners,
        mesh->corner_count * sizeof *change->corners);
    for (size_t face = 0; face < mesh->polygon_count; ++face) {
        const size_t begin = mesh->face_starts ? mesh->face_starts[face] : 3 * face,
                     count = mesh->face_starts ? mesh->face_starts[face + 1] - begin : 3;
        change->cut_rows[face] = change->cut_rows[face] && count > 3;
        for (size_t i = 0; change->cut_rows[face] && i < 3 * (count - 2); ++i) {
            if (edit->cut_corners[3 * begin + i] >= count)
                return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL,
                    "a triangle of face %zu was given a corner that the face does not have", face);
            change->cut_corners[3 * begin + i] = edit->cut_corners[3 * begin + i];
        }
    }
    return NORMA_DOCUMENT_OK;
}

static norma_document_result ply_edit_faces(
    norma_document *document, const norma_mesh_edit *edit, norma_document_error *error) {
    ply_state *state = document->state;
    const ply_mesh *mesh = &state->mesh;
    ply_edit *change = &state->edit;
    const uint32_t *corners = edit->source_vertices ? edit->new_corners : mesh->corners;
    if (edit->drop_faces &&
        !(change->dropped_rows = copy_marks(edit->drop_faces, mesh->face_count)))
        return norma_document_fail_memory(document, error);
    const int makes_strips =
        edit->drop_faces && mesh->polygon_count < mesh->face_count && !change->corners;
    if (makes_strips || edit->reverse_faces)
        change->corners = change->corners
                              ? change->corners
                              : norma_io_allocate(mesh->corner_count, sizeof *change->corners);
    if (makes_strips && change->corners)
        memcpy(change->corners, corners, mesh->corner_count * sizeof *change->corners);
    if (!edit->reverse_faces)
        return change->corners || !makes_strips ? NORMA_DOCUMENT_OK
                                                : norma_document_fail_memory(document, error);
    change->reversed_rows = copy_marks(edit->reverse_faces, mesh->polygon_count);
    if (!change->corners || !change->reversed_rows)
        return norma_document_fail_memory(document, error);
    change->reversed = 1;
    if (mesh->corner_count == 0) /* faces without a list of corners */
        return NORMA_DOCUMENT_OK;
    memcpy(change->corners, corners, mesh->corner_count * sizeof *change->corners);
    for (size_t face = 0; face < mesh->face_count; ++face) {
        size_t begin = mesh->face_starts ? mesh->face_starts[face] : 3 * face,
               end = mesh->face_starts ? mesh->face_starts[face + 1] : begin + 3;
        for (size_t i = begin + 1; edit->reverse_faces[face] && i < end; ++i)
            change->corners[i] = corners[end + begin - i];
    }
    return NORMA_DOCUMENT_OK;
}

static norma_document_result edit_ply(
    norma_document *document, const norma_mesh_edit *edit, norma_document_error *error) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    const ply_state *state = document->state;
    if (edit->set_normals && state->header.normal[0] == PLY_NONE)
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL,
            "has no normals that could be replaced");
    if (edit->source_vertices) result = ply_edit_vertices(document, edit, error);
    if (!result && edit->set_normals) result = edit_normals(document, edit, error);
    if (!result && edit->set_positions) result = edit_positions(document, edit, error);
    if (!result && edit->cut_faces)
        result = edit->reverse_faces
                     ? norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL,
                           "faces cannot be cut and reversed at once; do one after the other")
                     : cut_faces(document, edit, error);
    if (!result && (edit->reverse_faces || edit->drop_faces))
        result = ply_edit_faces(document, edit, error);
    return result ? result : norma_edited_flush(document, error);
}

/* ---- What a PLY's vertices have beside positions and normals: UVs and colours, by the
 * names that programs give them. */

static int ply_find(const ply_state *state, const ply_element *element, const char *name) {
    for (size_t i = 0; i < element->property_count; ++i) {
        const ply_property *property = norma_ply_property(&state->header, element, (int)i);
        if (!norma_ply_is_list(property) && norma_ply_span_is(state, property->name, name))
            return (int)i;
    }
    return PLY_NONE;
}

/* Properties of each row that become floats: the first width of them (at most three are read at
 * once), divided by scale, at every stride-th float. */
typedef struct float_columns {
    int properties[3];
    size_t width, stride;
    double scale;
} float_columns;

static norma_document_result ply_read_floats(norma_document *document, const ply_element *element,
    const float_columns *columns, float *out, norma_document_error *error) {
    double *values;
    norma_document_result result =
        norma_ply_read_columns(document, element, columns->properties, &values, error);
    if (result) return result;
    for (size_t row = 0; row < element->count; ++row)
        for (size_t k = 0; k < columns->width; ++k)
            out[columns->stride * row + k] = (float)(values[3 * row + k] / columns->scale);
    free(values);
    return NORMA_DOCUMENT_OK;
}

static norma_document_result ply_read_texcoords(norma_document *document, const ply_element *vertex,
    norma_mesh_attributes *attributes, norma_document_error *error) {
    static const char *const names[][2] = {
        {"s", "t"}, {"u", "v"}, {"texture_u", "texture_v"}, {"texcoord_u", "texcoord_v"}};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i) {
        int u = ply_find(document->state, vertex, names[i][0]),
            v = ply_find(document->state, vertex, names[i][1]);
        const float_columns uv = {{u, v, v}, 2, 2, 1};
        if (u == PLY_NONE || v == PLY_NONE) continue;
        float *texcoords =
            norma_scene_allocate(document->scene, (size_t)vertex->count, 2 * sizeof *texcoords);
        if (!texcoords) return norma_document_fail_memory(document, error);
        attributes->texcoords = texcoords;
        attributes->texcoord_count = (size_t)vertex->count;
        return ply_read_floats(document, vertex, &uv, texcoords, error);
    }
    return NORMA_DOCUMENT_OK;
}

static double color_scale(ply_type type) {
    return type == PLY_UINT8 ? 255 : type == PLY_UINT16 ? 65535 : 1;
}

static norma_document_result ply_read_colors(norma_document *document, const ply_element *vertex,
    norma_mesh_attributes *attributes, norma_document_error *error) {
    const ply_state *state = document->state;
    const int rgb[3] = {ply_find(state, vertex, "red"), ply_find(state, vertex, "green"),
        ply_find(state, vertex, "blue")};
    if (rgb[0] == PLY_NONE || rgb[1] == PLY_NONE || rgb[2] == PLY_NONE) return NORMA_DOCUMENT_OK;
    float *colors =
        norma_scene_allocate(document->scene, (size_t)vertex->count, 4 * sizeof *colors);
    if (!colors) return norma_document_fail_memory(document, error);
    for (size_t i = 0; i < vertex->count; ++i) colors[4 * i + 3] = 1;
    attributes->colors = colors;
    const float_columns color = {{rgb[0], rgb[1], rgb[2]}, 3, 4,
        color_scale(norma_ply_property(&state->header, vertex, rgb[0])->type)};
    return ply_read_floats(document, vertex, &color, colors, error);
}

static norma_document_result ply_read_attributes(norma_document *document, size_t mesh,
    norma_mesh_attributes *attributes, norma_document_error *error) {
    const ply_state *state = document->state;
    const ply_element *vertex = norma_ply_vertex(state);
    (void)mesh;
    if (!vertex) return NORMA_DOCUMENT_OK;
    norma_document_result result = ply_read_texcoords(document, vertex, attributes, error);
    return result ? result : ply_read_colors(document, vertex, attributes, error);
}

static norma_document_result ply_read_unread(
    norma_document *document, norma_document_error *error) {
    const ply_state *state = document->state;
    char *texts = norma_scene_allocate(document->scene, 4, sizeof(char[120]));
    if (!texts) return norma_document_fail_memory(document, error);
    const size_t count = (size_t)(state->surplus_rows > 0) + (state->tail > 0);
    norma_unread *unread = norma_scene_tell_unread(document, count, error);
    if (!unread) return NORMA_DOCUMENT_ERROR_MEMORY;
    if (state->surplus_rows) {
        snprintf(texts, 120, "line %zu", norma_ply_line_of(state, state->first_surplus));
        norma_ply_surplus_text(state, texts + 120);
        *unread++ = (norma_unread){texts, texts + 120};
    }
    if (state->tail) {
        texts += 240;
        if (state->header.encoding == PLY_ASCII)
            snprintf(texts, 120, "line %zu", norma_ply_line_of(state, state->tail));
        else
            snprintf(texts, 120, "byte %zu", state->tail);
        snprintf(texts + 120, 120, "%zu %s the last element that the header declares",
            state->size - state->tail,
            state->size - state->tail == 1 ? "byte follows" : "bytes follow");
        *unread = (norma_unread){texts, texts + 120};
    }
    return NORMA_DOCUMENT_OK;
}

static const scene_functions PLY_SCENE = {
    .attributes = ply_read_attributes, .unread = ply_read_unread};

/* ---- PLY documents. The file's bytes stay as they are; what compute and transform change is
 * kept beside them until it is written, or until another change needs to see it: then it becomes
 * the document's bytes, which are read anew. */

static const char *ply_encoding_of(const ply_state *state) {
    const ply_header *header = &state->header;
    const ply_element *vertex = norma_ply_element(header, header->vertex);
    if (header->encoding == PLY_ASCII) return "text";
    const ply_type first = norma_ply_property(header, vertex, header->normal[0])->type;
    for (int axis = 1; axis < 3; ++axis)
        if (norma_ply_property(header, vertex, header->normal[axis])->type != first) return "mixed";
    return first == PLY_INT8    ? "snorm8"
           : first == PLY_INT16 ? "snorm16"
                                : norma_ply_type_name(first, first < PLY_FLOAT);
}

static norma_document_result describe_mesh(
    const norma_document *document, size_t index, norma_mesh_info *info) {
    ply_state *state = document->state;
    (void)index;
    info->vertices = state->vertices + state->edit.added_count;
    info->faces = state->faces;
    info->triangles = state->triangles;
    if (state->header.normal[0] != PLY_NONE) {
        info->normals = NORMA_NORMALS_PER_VERTEX;
        info->encoding = ply_encoding_of(state);
    } else if (state->edit.normals.floats || state->edit.normals.doubles) {
        info->normals = NORMA_NORMALS_PER_VERTEX;
        info->encoding = state->header.encoding == PLY_ASCII ? "text" : "float";
    }
    return NORMA_DOCUMENT_OK;
}

/* As floats of unit length where whole codes stand for fractions. */
static norma_document_result decode_normals(norma_document *document, norma_document_error *error) {
    ply_state *state = document->state;
    const ply_element *vertex = norma_ply_vertex(state);
    double *values = NULL;
    norma_document_result result =
        norma_ply_read_columns(document, vertex, state->header.normal, &values, error);
    const size_t count = 3 * state->vertices;
    state->normals = result || count > SIZE_MAX / sizeof(float)
                         ? NULL
                         : norma_io_allocate(count, sizeof *state->normals);
    if (state->normals) {
        const double scale = norma_ply_normal_scale(&state->header, vertex, state->header.normal);
        for (size_t i = 0; i < count; ++i)
            state->normals[i] = norma_ply_normal_value(values[i], scale);
    } else if (!result) {
        result = norma_document_fail_memory(document, error);
    }
    free(values);
    return result;
}

static norma_document_result give_mesh(
    norma_document *document, size_t index, norma_mesh_data *data, norma_document_error *error) {
    (void)index;
    ply_state *state = document->state;
    const norma_document_result result = state->normals || state->header.normal[0] == PLY_NONE
                                             ? NORMA_DOCUMENT_OK
                                             : decode_normals(document, error);
    if (result) return result;
    data->mesh = norma_ply_core_mesh(state);
    if (state->normals)
        data->normals = (norma_vec3_view){
            .data = state->normals, .count = state->vertices, .format = NORMA_FORMAT_FLOAT};
    return NORMA_DOCUMENT_OK;
}

/* "comment TextureFile NAME" in the header, as MeshLab and others write it. */
static int ply_visit_files(const norma_document *document, norma_visit_file *visit, void *user) {
    static const char word[] = "comment TextureFile ", last[] = "end_header";
    const char *at = (const char *)document->source.data, *end = at + document->source.size;
    int stop = 0;
    while (at < end && !stop) {
        const char *line_end = memchr(at, '\n', (size_t)(end - at)), *stops = line_end;
        if (!line_end || strncmp(at, last, sizeof last - 1) == 0) break;
        if (stops > at && stops[-1] == '\r') --stops;
        if ((size_t)(stops - at) > sizeof word - 1 && memcmp(at, word, sizeof word - 1) == 0)
            stop = norma_document_visit_names(document, at + sizeof word - 1,
                (size_t)(stops - at) - (sizeof word - 1), visit, user);
        at = line_end + 1;
    }
    return stop;
}

const format_functions norma_ply_functions = {
    .open = norma_edited_open,
    .close = norma_edited_close,
    .edited = &PLY_EDITED,
    .mesh_count = norma_edited_mesh_count,
    .mesh_info = describe_mesh,
    .mesh_data = give_mesh,
    .compute = norma_ply_compute,
    .transform = norma_ply_transform,
    .edit = edit_ply,
    .equal_vertices = ply_equal_vertices,
    .write = norma_edited_write,
    .visit_files = ply_visit_files,
    .scene = &PLY_SCENE,
};
