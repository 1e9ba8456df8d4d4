/* unpack_draco.c: primitives that KHR_draco_mesh_compression held and of which something changes.
 * Nothing here compresses, so they are written without it: what the stream held is put into their
 * accessors, and the extension leaves the primitive, and the file with the last of them. */
#include "io/gltf/patch.h"
#include <stdlib.h>
#include <string.h>

static const char UNPACKED_NAME[] = "KHR_draco_mesh_compression";

/* A slot of a primitive, or, without one, that it is stripped of its normals. */
typedef struct change {
    uint32_t copy, primitive, slot;
} change;

static int compare_changes(const void *a, const void *b) {
    const change *x = a, *y = b;
    if (x->copy != y->copy) return x->copy < y->copy ? -1 : 1;
    if (x->primitive != y->primitive) return x->primitive < y->primitive ? -1 : 1;
    return x->slot < y->slot ? -1 : x->slot > y->slot;
}

/* ---- one primitive */

typedef struct group { /* all changes of one primitive */
    const change *changes;
    size_t count;
} group;

static int is_stripped(const group *of) {
    return of->changes[of->count - 1].slot == GLTF_NONE; /* the last one, as they are sorted */
}

static int is_changed(const gltf *g, const group *of) {
    int changed = is_stripped(of);
    for (size_t i = 0; i < of->count && of->changes[i].slot != GLTF_NONE; ++i)
        changed |= !g->patch->slots[of->changes[i].slot].kept;
    return changed;
}

/* The slot is put already: then its contents are wanted, those of before as well. */
static int is_put(gltf *g, const group *of, const gltf_slot *slot) {
    for (size_t i = 0; i < of->count && of->changes[i].slot != GLTF_NONE; ++i) {
        patch_slot *put = &g->patch->slots[of->changes[i].slot];
        if (put->slot.target != slot->target ||
            (slot->attribute && strcmp(put->slot.attribute, slot->attribute) != 0))
            continue;
        put->kept = 0;
        return 1;
    }
    return 0;
}

static norma_document_result put_elements(
    gltf *g, uint32_t accessor, const gltf_slot *slot, norma_document_error *error) {
    gltf_array array;
    norma_document_result result = norma_gltf_array(g, accessor, &array, error);
    if (result) return result;
    gltf_data data = {.component = array.component,
        .normalized = array.normalized,
        .width = array.width,
        .count = array.count,
        .is_indices = slot->target == GLTF_SLOT_INDICES,
        .bounds = slot->attribute && strcmp(slot->attribute, "POSITION") == 0};
    const size_t size = norma_gltf_data_size(&data);
    data.bytes = norma_io_allocate(data.count, size);
    if (!data.bytes) return norma_document_fail_memory(g->document, error);
    for (size_t i = 0; i < data.count; ++i)
        memcpy(data.bytes + i * size, array.data + i * array.stride, size);
    const uint32_t number = norma_gltf_add_data(g, &data);
    return number != GLTF_NONE && norma_gltf_put(g, slot, number)
               ? NORMA_DOCUMENT_OK
               : norma_document_fail_memory(g->document, error);
}

static norma_document_result put_stream(gltf *g, const group *of, norma_document_error *error) {
    const uint32_t copy = of->changes->copy, primitive = of->changes->primitive;
    const gltf_primitive *p = &g->primitives[primitive];
    const int stripped = is_stripped(of);
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (uint32_t i = 0; !result && i <= p->base.count; ++i) {
        const gltf_attribute *of_base = i ? &g->attributes[p->base.first + i - 1] : NULL;
        const uint32_t accessor = i ? of_base->accessor : p->indices;
        const gltf_slot slot = {
            copy, primitive, i ? GLTF_SLOT_BASE : GLTF_SLOT_INDICES, i ? of_base->name : NULL};
        if (g->accessors[accessor].draco == GLTF_NONE || is_put(g, of, &slot) ||
            (i && stripped &&
                (strcmp(of_base->name, "NORMAL") == 0 || strcmp(of_base->name, "TANGENT") == 0)))
            continue;
        result = put_elements(g, accessor, &slot, error);
    }
    return result;
}

static norma_document_result unpack(gltf *g, const group *of, norma_document_error *error) {
    gltf_patch *patch = g->patch;
    const uint32_t copy = of->changes->copy, primitive = of->changes->primitive,
                   token = g->primitives[primitive].token,
                   extensions = norma_json_member(&g->json, token, "extensions");
    patch_unpacked *grown = norma_io_grow(
        patch->unpacked, &patch->unpacked_capacity, patch->unpacked_count + 1, sizeof *grown);
    if (!grown) return norma_document_fail_memory(g->document, error);
    patch->unpacked = grown;
    patch->unpacked[patch->unpacked_count++] = (patch_unpacked){copy, primitive};
    if (norma_json_size(&g->json, extensions) == 1)
        norma_json_unset(norma_gltf_edits(g, copy), token, "extensions");
    else
        norma_json_unset(norma_gltf_edits(g, copy), extensions, UNPACKED_NAME);
    return put_stream(g, of, error);
}

/* ---- all of them */

static change *list_changes(const gltf *g, size_t *count) {
    const gltf_patch *patch = g->patch;
    change *list = norma_io_allocate(patch->slot_count + patch->stripped_count, sizeof *list);
    *count = 0;
    for (uint32_t i = 0; list && i < patch->slot_count; ++i) {
        const gltf_slot *slot = &patch->slots[i].slot;
        if (g->primitives[slot->primitive].draco.view != GLTF_NONE)
            list[(*count)++] = (change){slot->copy, slot->primitive, i};
    }
    for (size_t i = 0; list && i < patch->stripped_count; ++i)
        if (g->primitives[patch->stripped[i]].draco.view != GLTF_NONE)
            list[(*count)++] = (change){0, patch->stripped[i], GLTF_NONE};
    if (list && *count) qsort(list, *count, sizeof *list, compare_changes);
    return list;
}

/* Primitives under the extension after the change, copies of meshes included. */
static size_t count_packed(const gltf *g) {
    size_t packed = 0;
    for (uint32_t i = 0; i < g->primitive_count; ++i)
        packed += g->primitives[i].draco.token != GLTF_NONE;
    for (size_t c = 0; c < g->patch->copy_count; ++c) {
        const gltf_mesh *mesh = &g->meshes[g->patch->copies[c].mesh];
        for (uint32_t i = 0; i < mesh->primitive_count; ++i)
            packed += g->primitives[mesh->first_primitive + i].draco.token != GLTF_NONE;
    }
    return packed - g->patch->unpacked_count;
}

static norma_document_result note_unpacked(gltf *g, norma_document_error *error) {
    const gltf_patch *patch = g->patch;
    const char *first = g->primitives[patch->unpacked[0].primitive].where;
    if (patch->unpacked_count == 1)
        norma_document_add_note(g->document,
            "%s was compressed with %s; it has changed and is written uncompressed", first,
            UNPACKED_NAME);
    else
        norma_document_add_note(g->document,
            "%zu primitives, %s first, were compressed with %s; they have changed and are written "
            "uncompressed",
            patch->unpacked_count, first, UNPACKED_NAME);
    if (count_packed(g) || norma_gltf_unlist(g, UNPACKED_NAME)) return NORMA_DOCUMENT_OK;
    return norma_document_fail_memory(g->document, error);
}

norma_document_result norma_gltf_unpack_changed(gltf *g, norma_document_error *error) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    size_t count;
    change *list = list_changes(g, &count);
    if (!list) return norma_document_fail_memory(g->document, error);
    for (size_t i = 0, next; !result && i < count; i = next) {
        next = i + 1;
        while (next < count && list[next].copy == list[i].copy &&
               list[next].primitive == list[i].primitive)
            ++next;
        const group of = {list + i, next - i};
        if (is_changed(g, &of)) result = unpack(g, &of, error);
    }
    if (!result && g->patch->unpacked_count) result = note_unpacked(g, error);
    free(list);
    return result;
}

/* The copies of a mesh UNPACKED_NAME their streams as well, where they keep them. */
void norma_gltf_unpin_streams(gltf *g) {
    const gltf_patch *patch = g->patch;
    for (size_t c = 0; c < patch->copy_count; ++c) {
        const gltf_mesh *mesh = &g->meshes[patch->copies[c].mesh];
        for (uint32_t i = 0; i < mesh->primitive_count; ++i) {
            const uint32_t view = g->primitives[mesh->first_primitive + i].draco.view;
            if (view != GLTF_NONE) ++patch->pins[view];
        }
    }
    for (size_t i = 0; i < patch->unpacked_count; ++i)
        --patch->pins[g->primitives[patch->unpacked[i].primitive].draco.view];
}
