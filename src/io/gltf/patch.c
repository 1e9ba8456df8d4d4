/* patch.c: what is put into an asset, gathered; and lists that nothing may be added to. */
#include "io/gltf/gltf.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- Indices that name nothing. A list that grows must not give one of them a meaning: the
 * accessor 7 that an animation names in error would become the new normals. */

static int key_is(const json *j, uint32_t token, const char *const *keys) {
    const uint32_t parent = token ? j->tokens[token].parent : JSON_NONE;
    if (parent == JSON_NONE || j->tokens[parent].type != JSON_OBJECT) return 0;
    for (; *keys; ++keys)
        if (norma_json_equals(j, token - 1, *keys)) return 1;
    return 0;
}

/* The elements of arrays under these names. */
static int lies_in(const json *j, uint32_t token, const char *const *keys) {
    const uint32_t parent = j->tokens[token].parent;
    return j->tokens[parent].type == JSON_ARRAY && key_is(j, parent, keys);
}

static int is_attribute(const json *j, uint32_t token) {
    static const char *const attributes[] = {"attributes", NULL},
                             *const targets[] = {"targets", NULL},
                             *const draco[] = {"KHR_draco_mesh_compression", NULL};
    const uint32_t set = j->tokens[token].parent, above = j->tokens[set].parent;
    if (j->tokens[set].type != JSON_OBJECT || above == JSON_NONE) return 0;
    return (key_is(j, set, attributes) && !key_is(j, above, draco)) || lies_in(j, set, targets);
}

static int names_element(const json *j, uint32_t token, gltf_list list) {
    static const char *const accessors[] = {
        "input", "output", "inverseBindMatrices", "indices", "accessor", NULL};
    static const char *const views[] = {"bufferView", NULL}, *const buffers[] = {"buffer", NULL},
                             *const meshes[] = {"mesh", NULL}, *const textures[] = {"index", NULL},
                             *const images[] = {"source", NULL},
                             *const nodes[] = {"node", "skeleton", NULL},
                             *const node_lists[] = {"nodes", "children", "joints", NULL};
    switch (list) {
    case GLTF_LIST_ACCESSORS:
        return key_is(j, token, accessors) || is_attribute(j, token);
    case GLTF_LIST_VIEWS:
        return key_is(j, token, views);
    case GLTF_LIST_BUFFERS:
        return key_is(j, token, buffers);
    case GLTF_LIST_MESHES:
        return key_is(j, token, meshes);
    case GLTF_LIST_TEXTURES:
        return key_is(j, token, textures);
    case GLTF_LIST_IMAGES:
        return key_is(j, token, images);
    default:
        return key_is(j, token, nodes) || lies_in(j, token, node_lists);
    }
}

static uint32_t skip_extras(const json *j, uint32_t token) {
    static const char *const extras[] = {"extras", NULL};
    return key_is(j, token, extras) ? j->tokens[token].next : token + 1;
}

norma_document_result norma_gltf_check_dangling(
    const gltf *g, gltf_list list, norma_document_error *error) {
    static const char *const names[] = {
        "accessor", "bufferView", "buffer", "mesh", "node", "texture", "image"};
    const json *j = &g->json;
    const uint32_t counts[] = {g->accessor_count, g->view_count, g->buffer_count, g->mesh_count,
        g->node_count, norma_json_size(j, norma_json_member(j, 0, "textures")),
        norma_json_size(j, norma_json_member(j, 0, "images"))};
    uint64_t index;
    for (uint32_t token = 1; token < j->count; token = skip_extras(j, token)) {
        if (j->tokens[token].type != JSON_NUMBER || !norma_json_uint(j, token, &index) ||
            index < counts[list] || !names_element(j, token, list))
            continue;
        char place[200];
        norma_gltf_pointer(g, token, place, sizeof place);
        return norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_REFUSED, place,
            "names %s %llu of %u, and a new one that has to be added would take its place; "
            "expected an index below %u",
            names[list], (unsigned long long)index, (unsigned)counts[list], (unsigned)counts[list]);
    }
    return NORMA_DOCUMENT_OK;
}

/* ---- Gathers what is put into an asset: contents for slots, copies of meshes, modes of
 * primitives; and at the end turns it into edits. */

gltf_patch *norma_gltf_patch_of(gltf *g) {
    if (!g->patch) {
        g->patch = norma_io_allocate(1, sizeof *g->patch);
        if (g->patch) g->patch->default_buffer = GLTF_NONE;
    }
    return g->patch;
}

void norma_gltf_free_layout(gltf *g) {
    gltf_patch *patch = g->patch;
    for (uint32_t i = 0; patch->buffers && i <= g->buffer_count; ++i) {
        free(patch->buffers[i].segments);
        free(patch->buffers[i].name);
    }
    free(patch->buffers);
    free(patch->laid_out_for);
    norma_json_edits_destroy(patch->layout);
    patch->buffers = NULL;
    patch->laid_out_for = NULL;
    patch->layout = NULL;
}

void norma_gltf_patch_free(gltf *g) {
    gltf_patch *patch = g->patch;
    if (!patch) return;
    norma_gltf_free_layout(g);
    for (size_t i = 0; i < patch->data_count; ++i) free(patch->datas[i].bytes);
    for (size_t i = 0; i < patch->copy_count; ++i) norma_json_edits_destroy(patch->copies[i].edits);
    for (size_t i = 0; i < patch->run_count; ++i) free(patch->runs[i].owned);
    for (size_t i = 0; i < patch->view_count; ++i) {
        free(patch->views[i].owned);
        free(patch->views[i].owned_packed);
    }
    for (size_t i = 0; i < patch->image_count; ++i) free(patch->images[i].bytes);
    void *const blocks[] = {patch->datas, patch->same, patch->slots, patch->copies,
        patch->accessors, patch->runs, patch->views, patch->replaced, patch->released, patch->pins,
        patch->stripped, patch->unpacked, patch->images};
    for (size_t i = 0; i < sizeof blocks / sizeof blocks[0]; ++i) free(blocks[i]);
    free(patch);
    g->patch = NULL;
}

size_t norma_gltf_data_size(const gltf_data *data) {
    return data->element_size ? data->element_size
                              : data->width * norma_gltf_component_size(data->component);
}

/* Room for one more at the end of a list. */
static int grow_list(void **list, size_t *capacity, size_t count, size_t size) {
    void *grown = norma_io_grow(*list, capacity, count + 1, size);
    if (grown) *list = grown;
    return grown != NULL;
}

uint32_t norma_gltf_add_data(gltf *g, const gltf_data *data) {
    gltf_patch *patch = norma_gltf_patch_of(g);
    if (!patch || patch->data_count >= GLTF_NONE ||
        !grow_list((void **)&patch->datas, &patch->data_capacity, patch->data_count,
            sizeof *patch->datas)) {
        free(data->bytes);
        return GLTF_NONE;
    }
    patch->datas[patch->data_count] = *data;
    return (uint32_t)patch->data_count++;
}

static void find_old(const gltf *g, patch_slot *slot) {
    const gltf_primitive *p = &g->primitives[slot->slot.primitive];
    slot->old = slot->token = GLTF_NONE;
    if (slot->slot.target == GLTF_SLOT_INDICES) {
        slot->token = norma_json_member(&g->json, p->token, "indices");
        slot->old = p->indices;
        return;
    }
    const gltf_attributes *set = slot->slot.target == GLTF_SLOT_BASE
                                     ? &p->base
                                     : &g->targets[p->first_target + (uint32_t)slot->slot.target];
    uint32_t found = norma_gltf_find(g, set, slot->slot.attribute);
    if (found == GLTF_NONE) return;
    slot->token = g->attributes[found].token;
    slot->old = g->attributes[found].accessor;
}

int norma_gltf_put(gltf *g, const gltf_slot *slot, uint32_t data) {
    gltf_patch *patch = norma_gltf_patch_of(g);
    if (!patch || !grow_list((void **)&patch->slots, &patch->slot_capacity, patch->slot_count,
                      sizeof *patch->slots))
        return 0;
    patch_slot *added = &patch->slots[patch->slot_count++];
    *added = (patch_slot){.slot = *slot, .data = data};
    find_old(g, added);
    return 1;
}

norma_document_result norma_gltf_put_new(
    gltf *g, const gltf_slot *slot, const gltf_data *data, norma_document_error *error) {
    const uint32_t number = norma_gltf_add_data(g, data);
    return number != GLTF_NONE && norma_gltf_put(g, slot, number)
               ? NORMA_DOCUMENT_OK
               : norma_document_fail_memory(g->document, error);
}

void norma_gltf_set_mode(gltf *g, uint32_t copy, uint32_t primitive, uint32_t mode) {
    norma_json_set_uint(norma_gltf_edits(g, copy), g->primitives[primitive].token, "mode", mode);
}

uint32_t norma_gltf_copy_mesh(gltf *g, uint32_t mesh, uint32_t *mesh_number) {
    gltf_patch *patch = norma_gltf_patch_of(g);
    json_edits *edits = norma_json_edits_create(&g->json, g->meshes[mesh].token);
    if (!patch || !edits ||
        !grow_list((void **)&patch->copies, &patch->copy_capacity, patch->copy_count,
            sizeof *patch->copies)) {
        norma_json_edits_destroy(edits);
        return 0;
    }
    *mesh_number = g->mesh_count + (uint32_t)patch->copy_count;
    patch->copies[patch->copy_count++] = (patch_copy){.mesh = mesh, .edits = edits};
    return (uint32_t)patch->copy_count;
}

int norma_gltf_release(gltf *g, uint32_t accessor) {
    gltf_patch *patch = norma_gltf_patch_of(g);
    if (!patch || !grow_list((void **)&patch->released, &patch->released_capacity,
                      patch->released_count, sizeof *patch->released))
        return 0;
    patch->released[patch->released_count++] = accessor;
    return 1;
}

int norma_gltf_strip(gltf *g, uint32_t primitive) {
    gltf_patch *patch = norma_gltf_patch_of(g);
    if (!patch || !grow_list((void **)&patch->stripped, &patch->stripped_capacity,
                      patch->stripped_count, sizeof *patch->stripped))
        return 0;
    patch->stripped[patch->stripped_count++] = primitive;
    return 1;
}

int norma_gltf_unlist(gltf *g, const char *extension) {
    gltf_patch *patch = norma_gltf_patch_of(g);
    if (patch) patch->unlisted[patch->unlisted[0] != NULL] = extension;
    return patch != NULL;
}

static int is_unlisted(const gltf *g, uint32_t value) {
    const char *const *names = g->patch->unlisted;
    return (names[0] && norma_json_equals(&g->json, value, names[0])) ||
           (names[1] && norma_json_equals(&g->json, value, names[1]));
}

/* A list of nothing is not valid (glTF 2.0, 5.17). */
static void unlist(gltf *g, const char *key) {
    const json *j = &g->json;
    const uint32_t list = norma_json_member(j, 0, key);
    uint32_t gone = 0;
    for (uint32_t value = norma_json_first(j, list); value != JSON_NONE;
         value = norma_json_next(j, list, value))
        gone += (uint32_t)is_unlisted(g, value);
    if (gone && gone == norma_json_size(j, list)) {
        norma_json_remove(g->edits, list);
        return;
    }
    for (uint32_t value = norma_json_first(j, list); gone && value != JSON_NONE;
         value = norma_json_next(j, list, value))
        if (is_unlisted(g, value)) norma_json_remove(g->edits, value);
}

void norma_gltf_edit_extensions(gltf *g) {
    unlist(g, "extensionsUsed");
    unlist(g, "extensionsRequired");
}

json_edits *norma_gltf_edits(gltf *g, uint32_t copy) {
    return copy ? g->patch->copies[copy - 1].edits : g->edits;
}
