/* vertex_copies.c: vertices of a glTF primitive as a list of copies of old ones: every attribute
 * and every target's, byte by byte; and which vertices are equal in all of them. */
#include "io/format/edit.h"
#include "io/stream/equal_rows.h"
#include "io/gltf/asset.h"
#include "io/file/large_memory.h"
#include <stdlib.h>
#include <string.h>

/* ---- a vertex's bytes */

static size_t element_size_of(const gltf *g, uint32_t accessor) {
    return g->accessors[accessor].width *
           norma_gltf_component_size(g->accessors[accessor].component);
}

static size_t attributes_size(const gltf *g, const gltf_attributes *set) {
    size_t size = 0;
    for (uint32_t i = set->first; i < set->first + set->count; ++i)
        size += element_size_of(g, g->attributes[i].accessor);
    return size;
}

size_t norma_gltf_vertex_size(const gltf *g, const gltf_primitive *p) {
    size_t size = attributes_size(g, &p->base);
    for (uint32_t t = 0; t < p->target_count; ++t)
        size += attributes_size(g, &g->targets[p->first_target + t]);
    return size;
}

/* ---- copies */

norma_document_result norma_gltf_copy_array(gltf *g, uint32_t accessor, const norma_mesh_edit *edit,
    gltf_array *array, unsigned char **owned, norma_document_error *error) {
    norma_document_result result = norma_gltf_array(g, accessor, array, error);
    const size_t size = g->accessors[accessor].element_size;
    *owned = NULL;
    if (result || !edit->source_vertices) return result;
    *owned = norma_io_block(edit->vertex_count, size);
    if (!*owned) return norma_document_fail_memory(g->document, error);
    for (size_t v = 0; v < edit->vertex_count; ++v)
        memcpy(*owned + v * size, array->data + edit->source_vertices[v] * array->stride, size);
    array->data = *owned;
    array->count = edit->vertex_count;
    array->stride = size;
    return NORMA_DOCUMENT_OK;
}

static norma_document_result copy_attribute(gltf *g, uint32_t primitive, int32_t target,
    const gltf_attribute *attribute, const norma_mesh_edit *edit, norma_document_error *error) {
    gltf_array array;
    unsigned char *bytes;
    norma_document_result result =
        norma_gltf_copy_array(g, attribute->accessor, edit, &array, &bytes, error);
    if (result) return result;
    const gltf_data data = {.component = array.component,
        .normalized = array.normalized,
        .width = array.width,
        .element_size = array.stride,
        .count = array.count,
        .bytes = bytes};
    const gltf_slot slot = {.primitive = primitive, .target = target, .attribute = attribute->name};
    uint32_t number = norma_gltf_add_data(g, &data);
    return number != GLTF_NONE && norma_gltf_put(g, &slot, number)
               ? NORMA_DOCUMENT_OK
               : norma_document_fail_memory(g->document, error);
}

/* Whether single numbers of it are replaced as well, by whom the copies are made then. */
static int is_set(const norma_mesh_edit *edit, const char *name) {
    return (edit->set_normals && strcmp(name, "NORMAL") == 0) ||
           (edit->set_tangents && strcmp(name, "TANGENT") == 0) ||
           (edit->set_positions && strcmp(name, "POSITION") == 0);
}

static norma_document_result copy_unknown_attributes(gltf *g, uint32_t primitive, int32_t target,
    const gltf_attributes *set, const norma_mesh_edit *edit, norma_document_error *error) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (uint32_t i = set->first; !result && i < set->first + set->count; ++i)
        if (target != GLTF_SLOT_BASE || !is_set(edit, g->attributes[i].name))
            result = copy_attribute(g, primitive, target, &g->attributes[i], edit, error);
    return result;
}

/* Extensions that say nothing of vertices by their number. */
static int names_no_vertices(const gltf *g, const gltf_primitive *p) {
    static const char *const harmless[] = {"KHR_materials_variants", "EXT_mesh_features"};
    const json *j = &g->json;
    uint32_t extensions = norma_json_member(j, p->token, "extensions");
    for (uint32_t token = norma_json_first(j, extensions); token != JSON_NONE;
         token = norma_json_next(j, extensions, token)) {
        int known = 0;
        for (size_t i = 0; i < sizeof harmless / sizeof *harmless; ++i)
            known |= norma_json_equals(j, token - 1, harmless[i]);
        if (!known) return 0;
    }
    return 1;
}

/* Each old vertex keeps its number; further ones follow. */
static int keeps_numbers(const gltf_primitive *p, const norma_mesh_edit *edit) {
    for (size_t v = 0; v < p->vertices && v < edit->vertex_count; ++v)
        if (edit->source_vertices[v] != v) return 0;
    return edit->vertex_count >= p->vertices;
}

norma_document_result norma_gltf_put_vertices(
    gltf *g, uint32_t primitive, const norma_mesh_edit *edit, norma_document_error *error) {
    gltf_primitive *p = &g->primitives[primitive];
    const gltf_attributes *base = &p->base;
    if (!keeps_numbers(p, edit) && !names_no_vertices(g, p))
        return norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, p->where,
            "cannot renumber vertices: an extension may refer to them");
    if (base->normal != GLTF_NONE && g->accessors[base->normal].count != p->vertices)
        return norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, p->where,
            "vertices without a normal, or normals without a vertex, cannot be copied");
    norma_document_result result =
        norma_gltf_copy_vertices(g, p, edit->vertex_count, norma_gltf_vertex_size(g, p), error);
    if (!result) result = copy_unknown_attributes(g, primitive, GLTF_SLOT_BASE, base, edit, error);
    for (uint32_t t = 0; !result && t < p->target_count; ++t)
        result = copy_unknown_attributes(
            g, primitive, (int32_t)t, &g->targets[p->first_target + t], edit, error);
    return result;
}

/* ---- equal ones */

typedef struct vertex_rows {
    unsigned char *bytes;
    size_t size;
} vertex_rows;

static const unsigned char *copied_row_of(const void *context, size_t row, size_t *length) {
    const vertex_rows *rows = context;
    *length = rows->size;
    return rows->bytes + row * rows->size;
}

static norma_document_result gather_set(gltf *g, const gltf_primitive *p,
    const gltf_attributes *set, vertex_rows *rows, size_t *at, norma_document_error *error) {
    for (uint32_t i = set->first; i < set->first + set->count; ++i) {
        gltf_array array;
        const uint32_t accessor = g->attributes[i].accessor;
        const size_t size = element_size_of(g, accessor);
        norma_document_result result = norma_gltf_array(g, accessor, &array, error);
        if (result) return result;
        for (size_t v = 0; v < p->vertices && v < array.count; ++v)
            memcpy(rows->bytes + v * rows->size + *at, array.data + v * array.stride, size);
        *at += size;
    }
    return NORMA_DOCUMENT_OK;
}

norma_document_result norma_gltf_equal_vertices(
    norma_document *document, size_t mesh, uint32_t *first, norma_document_error *error) {
    gltf *g = norma_gltf_of(document);
    gltf_primitive *p = &g->primitives[mesh];
    vertex_rows rows = {.size = norma_gltf_vertex_size(g, p)};
    if (!names_no_vertices(g, p)) {
        for (size_t v = 0; v < p->vertices; ++v) first[v] = (uint32_t)v;
        return NORMA_DOCUMENT_OK;
    }
    norma_document_result result = norma_gltf_copy_vertices(
        g, p, p->vertices, rows.size, error); /* as much room as if it got them anew */
    if (result) return result;
    rows.bytes = norma_io_allocate(p->vertices, rows.size);
    if (!rows.bytes) return norma_document_fail_memory(document, error);
    size_t at = 0;
    result = gather_set(g, p, &p->base, &rows, &at, error);
    for (uint32_t t = 0; !result && t < p->target_count; ++t)
        result = gather_set(g, p, &g->targets[p->first_target + t], &rows, &at, error);
    if (!result && !norma_equal_rows(copied_row_of, &rows, p->vertices, first))
        result = norma_document_fail_memory(document, error);
    free(rows.bytes);
    return result;
}
