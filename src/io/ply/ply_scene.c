/* ply_scene.c: what a PLY's vertices have beside positions and normals: UVs and colours, by the
 * names that programs give them. */
#include "io/ply/ply.h"
#include "io/format/scene.h"
#include <stdio.h>
#include <stdlib.h>

static int find(const ply_state *state, const ply_element *element, const char *name) {
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

static norma_document_result read_floats(norma_document *document, const ply_element *element,
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

static norma_document_result read_texcoords(norma_document *document, const ply_element *vertex,
    norma_mesh_attributes *attributes, norma_document_error *error) {
    static const char *const names[][2] = {
        {"s", "t"}, {"u", "v"}, {"texture_u", "texture_v"}, {"texcoord_u", "texcoord_v"}};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i) {
        int u = find(document->state, vertex, names[i][0]),
            v = find(document->state, vertex, names[i][1]);
        const float_columns uv = {{u, v, v}, 2, 2, 1};
        if (u == PLY_NONE || v == PLY_NONE) continue;
        float *texcoords =
            norma_scene_allocate(document->scene, (size_t)vertex->count, 2 * sizeof *texcoords);
        if (!texcoords) return norma_document_fail_memory(document, error);
        attributes->texcoords = texcoords;
        attributes->texcoord_count = (size_t)vertex->count;
        return read_floats(document, vertex, &uv, texcoords, error);
    }
    return NORMA_DOCUMENT_OK;
}

static double color_scale(ply_type type) {
    return type == PLY_UINT8 ? 255 : type == PLY_UINT16 ? 65535 : 1;
}

static norma_document_result read_colors(norma_document *document, const ply_element *vertex,
    norma_mesh_attributes *attributes, norma_document_error *error) {
    const ply_state *state = document->state;
    const int rgb[3] = {
        find(state, vertex, "red"), find(state, vertex, "green"), find(state, vertex, "blue")};
    if (rgb[0] == PLY_NONE || rgb[1] == PLY_NONE || rgb[2] == PLY_NONE) return NORMA_DOCUMENT_OK;
    float *colors =
        norma_scene_allocate(document->scene, (size_t)vertex->count, 4 * sizeof *colors);
    if (!colors) return norma_document_fail_memory(document, error);
    for (size_t i = 0; i < vertex->count; ++i) colors[4 * i + 3] = 1;
    attributes->colors = colors;
    const float_columns color = {{rgb[0], rgb[1], rgb[2]}, 3, 4,
        color_scale(norma_ply_property(&state->header, vertex, rgb[0])->type)};
    return read_floats(document, vertex, &color, colors, error);
}

static norma_document_result read_attributes(norma_document *document, size_t mesh,
    norma_mesh_attributes *attributes, norma_document_error *error) {
    const ply_state *state = document->state;
    const ply_element *vertex = norma_ply_element(&state->header, state->header.vertex);
    (void)mesh;
    if (!vertex) return NORMA_DOCUMENT_OK;
    norma_document_result result = read_texcoords(document, vertex, attributes, error);
    return result ? result : read_colors(document, vertex, attributes, error);
}

static norma_document_result read_unread(norma_document *document, norma_document_error *error) {
    const ply_state *state = document->state;
    norma_scene *scene = document->scene;
    norma_unread *unread = norma_scene_allocate(scene, 1, sizeof *unread);
    char *texts = norma_scene_allocate(scene, 2, sizeof(char[120]));
    if (!unread || !texts) return norma_document_fail_memory(document, error);
    if (state->surplus_rows) {
        snprintf(texts, 120, "line %zu", norma_ply_line_of(state, state->first_surplus));
        norma_ply_surplus_text(state, texts + 120);
        *unread = (norma_unread){texts, texts + 120};
    }
    scene->unread = unread;
    scene->unread_count = state->surplus_rows > 0;
    return NORMA_DOCUMENT_OK;
}

const scene_functions norma_ply_scene = {.attributes = read_attributes, .unread = read_unread};
