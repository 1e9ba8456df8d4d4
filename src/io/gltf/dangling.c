/* dangling.c: indices that name nothing. A list that grows must not give one of them a meaning: the
 * accessor 7 that an animation names in error would become the new normals. */
#include "io/gltf/patch.h"
#include <stdio.h>
#include <string.h>

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
