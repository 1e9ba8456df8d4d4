/* patch.c: a change to an asset, from its beginning to its end: what is put into it, gathered;
 * lists that nothing may be added to; which old accessors are replaced. */
#include "core/call/table.h"
#include "io/gltf/gltf_layout.h"
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
        return norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_REFUSED,
            norma_gltf_pointer(g, token).text,
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

uint32_t norma_gltf_add_data(gltf *g, const gltf_data *data) {
    gltf_patch *patch = norma_gltf_patch_of(g);
    gltf_data *added =
        patch && patch->data_count < GLTF_NONE
            ? norma_io_add(&patch->datas, &patch->data_capacity, &patch->data_count, sizeof *added)
            : NULL;
    if (added)
        *added = *data;
    else
        free(data->bytes);
    return added ? (uint32_t)patch->data_count - 1 : GLTF_NONE;
}

static void find_old(const gltf *g, patch_slot *slot) {
    const gltf_primitive *p = &g->primitives[slot->slot.primitive];
    slot->old = slot->token = GLTF_NONE;
    if (slot->slot.target == GLTF_SLOT_INDICES) {
        slot->token = norma_json_member(&g->json, p->token, "indices");
        slot->old = p->indices;
        return;
    }
    uint32_t found =
        norma_gltf_find(g, norma_gltf_set_of(g, p, slot->slot.target), slot->slot.attribute);
    if (found == GLTF_NONE) return;
    slot->token = g->attributes[found].token;
    slot->old = g->attributes[found].accessor;
}

int norma_gltf_put(gltf *g, const gltf_slot *slot, uint32_t data) {
    gltf_patch *patch = norma_gltf_patch_of(g);
    patch_slot *added = patch ? norma_io_add(&patch->slots, &patch->slot_capacity,
                                    &patch->slot_count, sizeof *added)
                              : NULL;
    if (!added) return 0;
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
    patch_copy *added = patch ? norma_io_add(&patch->copies, &patch->copy_capacity,
                                    &patch->copy_count, sizeof *added)
                              : NULL;
    if (!added) return 0;
    *added = (patch_copy){mesh, norma_json_edits_create(&g->json, g->meshes[mesh].token)};
    *mesh_number = g->mesh_count + (uint32_t)patch->copy_count - 1;
    return added->edits ? (uint32_t)patch->copy_count : 0;
}

int norma_gltf_release(gltf *g, uint32_t accessor) {
    gltf_patch *patch = norma_gltf_patch_of(g);
    uint32_t *added = patch ? norma_io_add(&patch->released, &patch->released_capacity,
                                  &patch->released_count, sizeof *added)
                            : NULL;
    if (added) *added = accessor;
    return added != NULL;
}

int norma_gltf_strip(gltf *g, uint32_t primitive) {
    gltf_patch *patch = norma_gltf_patch_of(g);
    uint32_t *added = patch ? norma_io_add(&patch->stripped, &patch->stripped_capacity,
                                  &patch->stripped_count, sizeof *added)
                            : NULL;
    if (added) *added = primitive;
    return added != NULL;
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
    for (uint32_t value = JSON_NONE; norma_json_each(j, list, &value);)
        gone += (uint32_t)is_unlisted(g, value);
    if (gone && gone == norma_json_size(j, list)) {
        norma_json_remove(g->edits, list);
        return;
    }
    for (uint32_t value = JSON_NONE; gone && norma_json_each(j, list, &value);)
        if (is_unlisted(g, value)) norma_json_remove(g->edits, value);
}

void norma_gltf_edit_extensions(gltf *g) {
    unlist(g, "extensionsUsed");
    unlist(g, "extensionsRequired");
}

void norma_gltf_require(gltf *g, const char *extension) {
    static const char *const keys[] = {"extensionsUsed", "extensionsRequired"};
    for (size_t k = 0; k < sizeof keys / sizeof keys[0]; ++k) {
        json_text text = {0};
        if (norma_gltf_lists(g, keys[k], extension)) continue;
        norma_json_add_quoted(&text, extension);
        norma_json_append_made(g->edits, 0, keys[k], &text);
    }
}

json_edits *norma_gltf_edits(gltf *g, uint32_t copy) {
    return copy ? g->patch->copies[copy - 1].edits : g->edits;
}

/* ---- Primitives that KHR_draco_mesh_compression held and of which something changes.
 * Nothing here compresses, so they are written without it: what the stream held is put into their
 * accessors, and the extension leaves the primitive, and the file with the last of them. */

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
    gltf_data data;
    const norma_document_result result = norma_gltf_copy_rows(g, accessor,
        g->accessors[accessor].count, NULL, g->accessors[accessor].count, &data, error);
    if (result) return result;
    data.is_indices = slot->target == GLTF_SLOT_INDICES;
    data.bounds = slot->attribute && strcmp(slot->attribute, "POSITION") == 0;
    return norma_gltf_put_new(g, slot, &data, error);
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
    const uint32_t copy = of->changes->copy, primitive = of->changes->primitive;
    patch_unpacked *added = norma_io_add(
        &patch->unpacked, &patch->unpacked_capacity, &patch->unpacked_count, sizeof *added);
    if (!added) return norma_document_fail_memory(g->document, error);
    *added = (patch_unpacked){copy, primitive};
    norma_gltf_remove_extension(
        g, norma_gltf_edits(g, copy), g->primitives[primitive].token, GLTF_DRACO);
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
            GLTF_DRACO);
    else
        norma_document_add_note(g->document,
            "%zu primitives, %s first, were compressed with %s; they have changed and are written "
            "uncompressed",
            patch->unpacked_count, first, GLTF_DRACO);
    if (count_packed(g) || norma_gltf_unlist(g, GLTF_DRACO)) return NORMA_DOCUMENT_OK;
    return norma_document_fail_memory(g->document, error);
}

/* A primitive of which anything changes is written without Draco, and all that
 * its stream held is put; once the slots whose contents stay are known. */
static norma_document_result gltf_unpack_changed(gltf *g, norma_document_error *error) {
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

/* The copies of a mesh pin their streams as well, where they keep them; primitives that are written
 * without theirs no longer do. */
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

/* ---- What was put into slots becomes accessors. An accessor whose every user gets
 * new contents is replaced, and keeps its number; where some users keep the old contents, or users
 * differ, the others get new accessors. Equal contents become one. */

/* ---- equal contents */

static uint64_t hash_shape(const gltf_data *data) {
    return (UINT64_C(0x9E3779B97F4A7C15) ^ (uint64_t)data->component ^ (uint64_t)data->width << 16 ^
               (uint64_t)data->normalized << 24 ^ (uint64_t)data->is_indices << 25) +
           data->count * UINT64_C(0xD6E8FEB86659FD93);
}

static int equal_data(const gltf_data *a, const gltf_data *b) {
    size_t size = norma_gltf_data_size(a);
    return a->component == b->component && a->width == b->width && a->normalized == b->normalized &&
           a->count == b->count && a->is_indices == b->is_indices &&
           size == norma_gltf_data_size(b) && memcmp(a->bytes, b->bytes, a->count * size) == 0;
}

typedef struct hashed {
    uint64_t shape, contents;
    uint32_t data;
} hashed;

static int compare_hashed(const void *a, const void *b) {
    const hashed *x = a, *y = b;
    if (x->shape != y->shape) return x->shape < y->shape ? -1 : 1;
    if (x->contents != y->contents) return x->contents < y->contents ? -1 : 1;
    return x->data < y->data ? -1 : x->data > y->data;
}

/* Contents whose shape no other has are equal to none, and are not looked at. */
static int find_equal_datas(gltf_patch *patch) {
    const size_t count = patch->data_count;
    hashed *list = norma_io_allocate(count, sizeof *list);
    patch->same = norma_io_allocate(count, sizeof *patch->same);
    for (uint32_t i = 0; list && i < count; ++i)
        list[i] = (hashed){.shape = hash_shape(&patch->datas[i]), .data = i};
    if (list && count) qsort(list, count, sizeof *list, compare_hashed);
    for (size_t i = 0; list && i < count; ++i)
        if ((i && list[i - 1].shape == list[i].shape) ||
            (i + 1 < count && list[i + 1].shape == list[i].shape))
            list[i].contents = norma_core_hash(patch->datas[list[i].data].bytes,
                patch->datas[list[i].data].count *
                    norma_gltf_data_size(&patch->datas[list[i].data]));
    if (list && count) qsort(list, count, sizeof *list, compare_hashed);
    for (size_t i = 0, first = 0; list && patch->same && i < count; ++i) {
        const gltf_data *data = &patch->datas[list[i].data];
        if (i && (list[i].shape != list[first].shape || list[i].contents != list[first].contents ||
                     !equal_data(&patch->datas[list[first].data], data)))
            first = i;
        patch->same[list[i].data] = list[first].data;
    }
    free(list);
    return list && patch->same;
}

/* ---- users */

static void count_mesh(const gltf *g, const gltf_mesh *mesh, uint32_t *uses) {
    for (uint32_t i = mesh->first_primitive; i < mesh->first_primitive + mesh->primitive_count;
         ++i) {
        const gltf_primitive *p = &g->primitives[i];
        for (uint32_t k = p->base.first; k < p->attribute_end; ++k)
            ++uses[g->attributes[k].accessor];
        if (p->indices != GLTF_NONE) ++uses[p->indices];
    }
}

/* Numbers of accessors outside meshes: members of these names, and all within instancing
 * attributes. */
static void count_others(const gltf *g, uint32_t *uses) {
    const json *j = &g->json;
    for (uint32_t token = 2; token < j->count; ++token) {
        uint32_t parent = j->tokens[token].parent;
        if (j->tokens[token].type != JSON_NUMBER || j->tokens[parent].type != JSON_OBJECT) continue;
        int named = norma_json_equals(j, token - 1, "input") ||
                    norma_json_equals(j, token - 1, "output") ||
                    norma_json_equals(j, token - 1, "inverseBindMatrices");
        uint32_t above = j->tokens[parent].parent;
        int instancing = above != JSON_NONE && j->tokens[above].type == JSON_OBJECT &&
                         norma_json_equals(j, parent - 1, "attributes") &&
                         norma_json_equals(j, above - 1, "EXT_mesh_gpu_instancing");
        const uint32_t accessor =
            named || instancing ? norma_gltf_number(g, token, g->accessor_count) : GLTF_NONE;
        if (accessor != GLTF_NONE) ++uses[accessor];
    }
}

uint32_t *norma_gltf_accessor_uses(const gltf *g) {
    uint32_t *uses = norma_io_allocate(g->accessor_count, sizeof *uses);
    for (uint32_t i = 0; uses && i < g->mesh_count; ++i) count_mesh(g, &g->meshes[i], uses);
    for (size_t i = 0; uses && i < g->patch->copy_count; ++i)
        count_mesh(g, &g->meshes[g->patch->copies[i].mesh], uses);
    if (uses) count_others(g, uses);
    return uses;
}

/* Whether an accessor has its view to itself, and nothing speaks against vertices in it. */
static int owns_view(const gltf *g, uint32_t accessor) {
    const uint32_t view = g->accessors[accessor].view;
    uint32_t users = 0;
    for (uint32_t i = 0; i < g->accessor_count; ++i)
        users += view != GLTF_NONE && g->accessors[i].view == view;
    return users == 1 && norma_json_member(&g->json, g->views[view].token, "target") == JSON_NONE;
}

/* Of what was released keeps, once each, what nobody uses now and others can take. */
static void find_free(gltf *g, uint32_t *uses) {
    gltf_patch *patch = g->patch;
    size_t kept = 0;
    for (size_t i = 0; i < patch->released_count; ++i) {
        const uint32_t accessor = patch->released[i];
        if (uses[accessor] && --uses[accessor] == 0 && g->accessors[accessor].sparse.count == 0 &&
            g->accessors[accessor].width <= 4 && owns_view(g, accessor))
            patch->released[kept++] = accessor;
    }
    patch->released_count = kept;
}

/* ---- decisions */

int norma_gltf_is_same(const gltf_array *old, const gltf_data *data) {
    size_t size = norma_gltf_data_size(data);
    if (old->component != data->component || old->width != data->width ||
        old->normalized != data->normalized || old->count != data->count)
        return 0;
    for (size_t i = 0; i < data->count; ++i)
        if (memcmp(old->data + i * old->stride, data->bytes + i * size, size) != 0) return 0;
    return 1;
}

static norma_document_result drop_unchanged(gltf *g, norma_document_error *error) {
    for (size_t i = 0; i < g->patch->slot_count; ++i) {
        patch_slot *slot = &g->patch->slots[i];
        gltf_array old;
        if (slot->old == GLTF_NONE) continue;
        norma_document_result result = norma_gltf_array(g, slot->old, &old, error);
        if (result) return result;
        slot->kept = norma_gltf_is_same(&old, &g->patch->datas[slot->data]);
    }
    return NORMA_DOCUMENT_OK;
}

static void point_slot(gltf *g, const patch_slot *slot, uint32_t accessor) {
    json_edits *edits = norma_gltf_edits(g, slot->slot.copy);
    const gltf_primitive *p = &g->primitives[slot->slot.primitive];
    if (slot->old == accessor) return;
    if (slot->token != GLTF_NONE)
        norma_json_replace_uint(edits, slot->token, accessor);
    else if (slot->slot.target == GLTF_SLOT_INDICES)
        norma_json_set_uint(edits, p->token, "indices", accessor);
    else
        norma_json_set_uint(edits, norma_gltf_set_of(g, p, slot->slot.target)->token,
            slot->slot.attribute, accessor);
}

/* Slots are taken in order: the first that finds its accessor free of users who stay replaces it.
 * of_data: the new accessor of each content. */
static norma_document_result assign(
    gltf *g, const uint32_t *stays, uint32_t *of_data, norma_document_error *error) {
    gltf_patch *patch = g->patch;
    for (size_t i = 0; i < patch->slot_count; ++i) {
        const patch_slot *slot = &patch->slots[i];
        uint32_t data = patch->same[slot->data];
        if (slot->kept) continue;
        if (slot->old != GLTF_NONE && stays[slot->old] == 0 &&
            (patch->replaced[slot->old] == GLTF_NONE || patch->replaced[slot->old] == data)) {
            patch->replaced[slot->old] = data;
            point_slot(g, slot, slot->old);
            continue;
        }
        if (of_data[data] == GLTF_NONE && patch->released_count) {
            const uint32_t taken = patch->released[--patch->released_count];
            of_data[data] = taken;
            patch->replaced[taken] = data;
            norma_json_set_uint(g->edits, g->views[g->accessors[taken].view].token, "target",
                patch->datas[data].is_indices ? 34963 : 34962);
        } else if (of_data[data] == GLTF_NONE) {
            of_data[data] = g->accessor_count + (uint32_t)patch->accessor_count;
            patch_accessor *added = norma_io_add(&patch->accessors, &patch->accessor_capacity,
                &patch->accessor_count, sizeof *added);
            if (!added) return norma_document_fail_memory(g->document, error);
            *added = (patch_accessor){.data = data, .like = slot->old, .view = GLTF_NONE};
        }
        point_slot(g, slot, of_data[data]);
    }
    return NORMA_DOCUMENT_OK;
}

norma_document_result norma_gltf_assign_accessors(gltf *g, norma_document_error *error) {
    gltf_patch *patch = g->patch;
    norma_document_result result = drop_unchanged(g, error);
    if (!result) result = gltf_unpack_changed(g, error);
    if (result) return result;
    uint32_t *stays = norma_gltf_accessor_uses(g),
             *of_data = norma_io_allocate(patch->data_count, sizeof *of_data);
    patch->replaced = norma_io_allocate(g->accessor_count, sizeof *patch->replaced);
    if (stays && of_data && patch->replaced && find_equal_datas(patch)) {
        memset(patch->replaced, 0xFF, g->accessor_count * sizeof *patch->replaced);
        memset(of_data, 0xFF, patch->data_count * sizeof *of_data);
        find_free(g, stays);
        for (size_t i = 0; i < patch->slot_count; ++i)
            if (patch->slots[i].old != GLTF_NONE && !patch->slots[i].kept)
                --stays[patch->slots[i].old];
        result = assign(g, stays, of_data, error);
    } else {
        result = norma_document_fail_memory(g->document, error);
    }
    free(stays);
    free(of_data);
    return result;
}
