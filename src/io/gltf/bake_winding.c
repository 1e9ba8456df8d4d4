/* bake_winding.c: the triangles of a primitive turned round. In a list each keeps its first corner.
 * Strips of an odd number of corners are read backwards, fans too but for their first corner; a
 * strip of an even number would keep its winding, read backwards: it becomes a list. */
#include "io/gltf/bake.h"
#include "io/gltf/encode_vectors.h"
#include <stdlib.h>
#include <string.h>

typedef struct corner_list {
    uint32_t *corners;
    size_t count;
    uint32_t mode;
} corner_list;

static void swap_corners(uint32_t *a, uint32_t *b) {
    const uint32_t kept = *a;
    *a = *b;
    *b = kept;
}

static void reverse_order(uint32_t *corners, size_t count) {
    for (size_t i = 0; i < count / 2; i++) swap_corners(&corners[i], &corners[count - 1 - i]);
}

/* FB_ngon_encoding: triangles that follow one another with one first corner are one polygon, a fan;
 * reversed, it is told from the other end. */
static void reverse_polygons(uint32_t *corners, size_t triangles) {
    for (size_t first = 0, after; first < triangles; first = after) {
        for (after = first + 1; after < triangles && corners[3 * after] == corners[3 * first];)
            after++;
        for (size_t i = 0; i < (after - first) / 2; i++)
            for (size_t k = 0; k < 3; k++)
                swap_corners(&corners[3 * (first + i) + k], &corners[3 * (after - 1 - i) + k]);
    }
}

/* An even strip as a list, each triangle turned; triangles of no area by their corners alone are
 * left out. Returns the number of corners. */
static size_t unroll_strip(const uint32_t *strip, size_t count, uint32_t *list) {
    size_t made = 0;
    for (size_t i = 0; i + 2 < count; i++) {
        const uint32_t a = strip[i], b = strip[i + 1], c = strip[i + 2];
        if (a == b || b == c || c == a) continue;
        list[made++] = a;
        list[made++] = i % 2 ? b : c;
        list[made++] = i % 2 ? c : b;
    }
    return made;
}

static int reverse(corner_list *list, int polygons) {
    if (list->mode == GLTF_TRIANGLES) {
        for (size_t i = 0; i + 2 < list->count; i += 3)
            swap_corners(&list->corners[i + 1], &list->corners[i + 2]);
        if (polygons) reverse_polygons(list->corners, list->count / 3);
    } else if (list->mode == GLTF_FAN) {
        reverse_order(list->corners + 1, list->count - 1);
    } else if (list->count % 2) {
        reverse_order(list->corners, list->count);
    } else {
        uint32_t *unrolled = norma_io_allocate(list->count, 3 * sizeof *unrolled);
        if (!unrolled) return 0;
        const size_t made = unroll_strip(list->corners, list->count, unrolled);
        free(list->corners);
        *list = (corner_list){unrolled, made, GLTF_TRIANGLES};
    }
    return 1;
}

static norma_document_result read_winding(
    gltf *g, const gltf_primitive *primitive, corner_list *list, norma_document_error *error) {
    gltf_array array = {.count = primitive->vertices};
    if (primitive->indices != GLTF_NONE) {
        const norma_document_result result = norma_gltf_array(g, primitive->indices, &array, error);
        if (result) return result;
    }
    list->mode = primitive->mode;
    list->count = array.count;
    list->corners = norma_io_allocate(array.count + 1, sizeof *list->corners);
    if (!list->corners) return norma_document_fail_memory(g->document, error);
    for (size_t i = 0; i < array.count; i++) {
        list->corners[i] = (uint32_t)i;
        if (primitive->indices != GLTF_NONE) norma_gltf_uints(&array, i, &list->corners[i]);
    }
    return NORMA_DOCUMENT_OK;
}

static norma_document_result add_turned_corners(gltf *g, const gltf_primitive *primitive,
    const corner_list *list, uint32_t *number, norma_document_error *error) {
    gltf_data data = {.component = primitive->vertices <= 65535 ? GLTF_USHORT : GLTF_UINT,
        .width = 1,
        .count = list->count,
        .is_indices = 1};
    if (primitive->indices != GLTF_NONE)
        data.component = g->accessors[primitive->indices].component;
    const size_t size = norma_gltf_component_size(data.component);
    data.bytes = norma_io_allocate(list->count + 1, size);
    if (!data.bytes) return norma_document_fail_memory(g->document, error);
    for (size_t i = 0; i < list->count; i++) {
        const uint16_t two = (uint16_t)list->corners[i];
        if (size == 1)
            data.bytes[i] = (unsigned char)list->corners[i];
        else if (size == 2)
            memcpy(data.bytes + 2 * i, &two, 2);
        else
            memcpy(data.bytes + 4 * i, &list->corners[i], 4);
    }
    *number = norma_gltf_add_data(g, &data);
    return *number == GLTF_NONE ? norma_document_fail_memory(g->document, error)
                                : NORMA_DOCUMENT_OK;
}

static norma_document_result make_corners(gltf *g, const gltf_primitive *primitive, int polygons,
    bake_entry *entry, norma_document_error *error) {
    corner_list list = {NULL, 0, 0};
    norma_document_result result = read_winding(g, primitive, &list, error);
    if (!result && list.count >= 3 && !reverse(&list, polygons))
        result = norma_document_fail_memory(g->document, error);
    if (!result && list.count < 3) /* nothing to turn */
        entry->data = BAKE_UNCHANGED;
    else if (!result)
        result = add_turned_corners(g, primitive, &list, &entry->data, error);
    free(list.corners);
    return result;
}

norma_document_result norma_gltf_bake_winding(gltf *g, bake_cache *cache, uint32_t primitive_number,
    uint32_t copy, norma_document_error *error) {
    const gltf_primitive *primitive = &g->primitives[primitive_number];
    if (primitive->mode < GLTF_TRIANGLES) return NORMA_DOCUMENT_OK;
    const uint32_t extensions = norma_json_member(&g->json, primitive->token, "extensions");
    const int polygons = norma_json_member(&g->json, extensions, "FB_ngon_encoding") != JSON_NONE;
    const int indexed = primitive->indices != GLTF_NONE;
    if (!indexed && primitive->vertices >= UINT32_MAX)
        return NORMA_DOCUMENT_OK; /* more than any index names: nothing that a file holds */
    bake_entry entry = {BAKE_WINDING, primitive->indices,
        indexed ? primitive->vertices > 0 : (uint32_t)primitive->vertices,
        2 * primitive->mode + (unsigned)polygons, 0, 0};
    if (!norma_gltf_bake_cache_find(cache, &entry, &entry.data)) {
        const norma_document_result result = make_corners(g, primitive, polygons, &entry, error);
        if (result) return result;
        if (!norma_gltf_bake_cache_add(cache, &entry))
            return norma_document_fail_memory(g->document, error);
    }
    if (entry.data == BAKE_UNCHANGED) return NORMA_DOCUMENT_OK;
    const gltf_slot slot = {copy, primitive_number, GLTF_SLOT_INDICES, NULL};
    if (!norma_gltf_put(g, &slot, entry.data))
        return norma_document_fail_memory(g->document, error);
    const size_t count = indexed ? g->accessors[primitive->indices].count : primitive->vertices;
    if (primitive->mode == GLTF_STRIP && count % 2 == 0)
        norma_gltf_set_mode(g, copy, primitive_number, GLTF_TRIANGLES);
    return NORMA_DOCUMENT_OK;
}
