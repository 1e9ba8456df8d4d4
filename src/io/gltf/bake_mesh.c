/* bake_mesh.c: every slot of a mesh that a matrix changes: positions, normals, tangents, the morph
 * targets' deltas of each, the order of the corners. */
#include "io/gltf/bake.h"
#include "io/gltf/encode_vectors.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct mesh_baker {
    gltf *g;
    bake_cache *cache;
    const bake_map *map;
    uint32_t node; /* for messages */
} mesh_baker;

static norma_document_result malformed(
    const mesh_baker *b, uint32_t accessor, const char *expected, norma_document_error *error) {
    return norma_gltf_malformed(b->g, error, b->g->accessors[accessor].token, expected);
}

static norma_document_result too_large(
    const mesh_baker *b, uint32_t accessor, norma_document_error *error) {
    char place[60];
    (void)snprintf(place, sizeof place, "accessor %u", (unsigned)accessor);
    return norma_document_fail(b->g->document, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, place,
        "under node %u its coordinates exceed the range of floats; expected a smaller scale",
        (unsigned)b->node);
}

static norma_document_result check_vector_shape(const mesh_baker *b, const bake_entry *entry,
    const gltf_array *array, const gltf_array *base, norma_document_error *error) {
    if (array->width != (entry->role == BAKE_TANGENTS ? 4u : 3u))
        return malformed(b, entry->a,
            entry->role == BAKE_TANGENTS ? "the type VEC4 for tangents" : "the type VEC3", error);
    if (array->component == GLTF_UINT)
        return malformed(b, entry->a, "floats, or integers of at most 16 bits", error);
    if (base && (base->count < array->count || base->width < 3 || base->width > 4 ||
                    base->component == GLTF_UINT))
        return malformed(b, entry->b, "as many vectors as the other attributes have", error);
    return NORMA_DOCUMENT_OK;
}

/* Contents equal to the stored ones, bit for bit, change nothing. */
static int unchanged(const gltf_data *data, const gltf_array *old) {
    if (data->component != old->component || data->normalized != old->normalized) return 0;
    const size_t size = data->width * norma_gltf_component_size(data->component);
    for (size_t i = 0; i < data->count; i++)
        if (memcmp(data->bytes + i * size, old->data + i * old->stride, size) != 0) return 0;
    return 1;
}

static norma_document_result make_data(
    const mesh_baker *b, bake_entry *entry, norma_document_error *error) {
    gltf_array array, base;
    norma_document_result result = norma_gltf_array(b->g, entry->a, &array, error);
    if (!result && entry->b != GLTF_NONE) result = norma_gltf_array(b->g, entry->b, &base, error);
    if (!result)
        result = check_vector_shape(b, entry, &array, entry->b == GLTF_NONE ? NULL : &base, error);
    if (result) return result;
    double *values = norma_io_allocate(array.count + 1, array.width * sizeof *values);
    if (!values) return norma_document_fail_memory(b->g->document, error);
    norma_gltf_transform_vectors(
        (bake_role)entry->role, b->map, &array, entry->b == GLTF_NONE ? NULL : &base, values);
    gltf_data data;
    const bake_encoded encoded = norma_gltf_encode((bake_role)entry->role, &array, values, &data);
    free(values);
    if (encoded == BAKE_TOO_LARGE) return too_large(b, entry->a, error);
    if (encoded == BAKE_NO_MEMORY) return norma_document_fail_memory(b->g->document, error);
    if (unchanged(&data, &array)) {
        free(data.bytes);
        entry->data = BAKE_UNCHANGED;
        return NORMA_DOCUMENT_OK;
    }
    entry->data = norma_gltf_add_data(b->g, &data);
    return entry->data == GLTF_NONE ? norma_document_fail_memory(b->g->document, error)
                                    : NORMA_DOCUMENT_OK;
}

/* base: see norma_gltf_transform_vectors. */
static norma_document_result bake_slot(const mesh_baker *b, bake_role role, uint32_t accessor,
    uint32_t base, const gltf_slot *slot, norma_document_error *error) {
    const int is_direction = role != BAKE_POSITIONS && role != BAKE_POSITION_DELTAS;
    if (accessor == GLTF_NONE || (is_direction && !b->map->turns)) return NORMA_DOCUMENT_OK;
    bake_entry entry = {role, accessor, base, b->map->id, 0, 0};
    if (!norma_gltf_bake_cache_find(b->cache, &entry, &entry.data)) {
        const norma_document_result result = make_data(b, &entry, error);
        if (result) return result;
        if (!norma_gltf_bake_cache_add(b->cache, &entry))
            return norma_document_fail_memory(b->g->document, error);
    }
    if (entry.data != BAKE_UNCHANGED && !norma_gltf_put(b->g, slot, entry.data))
        return norma_document_fail_memory(b->g->document, error);
    return NORMA_DOCUMENT_OK;
}

static norma_document_result bake_attributes(const mesh_baker *b, const gltf_primitive *primitive,
    const gltf_attributes *attributes, gltf_slot slot, norma_document_error *error) {
    const int delta = slot.target >= 0;
    const gltf_attributes *base = &primitive->base;
    slot.attribute = "POSITION";
    norma_document_result result = bake_slot(b, delta ? BAKE_POSITION_DELTAS : BAKE_POSITIONS,
        attributes->position, GLTF_NONE, &slot, error);
    slot.attribute = "NORMAL";
    if (!result)
        result = bake_slot(b, delta ? BAKE_NORMAL_DELTAS : BAKE_NORMALS, attributes->normal,
            delta ? base->normal : GLTF_NONE, &slot, error);
    slot.attribute = "TANGENT";
    if (!result)
        result = bake_slot(b, delta ? BAKE_TANGENT_DELTAS : BAKE_TANGENTS, attributes->tangent,
            delta ? base->tangent : base->normal, &slot, error);
    return result;
}

norma_document_result norma_gltf_bake_mesh(gltf *g, bake_cache *cache, const mesh_use *use,
    const bake_map *map, size_t *vertices, norma_document_error *error) {
    const mesh_baker b = {g, cache, map, use->node};
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (uint32_t i = 0; !result && i < g->meshes[use->mesh].primitive_count; i++) {
        const uint32_t number = g->meshes[use->mesh].first_primitive + i;
        const gltf_primitive *primitive = &g->primitives[number];
        gltf_slot slot = {use->copy, number, GLTF_SLOT_BASE, NULL};
        if (primitive->base.position == GLTF_NONE) continue; /* nothing is drawn */
        result = bake_attributes(&b, primitive, &primitive->base, slot, error);
        for (uint32_t k = 0; !result && k < primitive->target_count; k++) {
            slot.target = (int32_t)k;
            result = bake_attributes(
                &b, primitive, &g->targets[primitive->first_target + k], slot, error);
        }
        if (!result && map->mirrored)
            result = norma_gltf_bake_winding(g, cache, number, use->copy, error);
        *vertices += primitive->vertices;
    }
    return result;
}
