/* node_tree.c: the node tree: local matrices, world matrices in double precision, what each node
 * draws. A tree it must be: a node with two parents, or in a loop, is told by name. */
#include "io/gltf/asset.h"
#include <stdlib.h>
#include <string.h>

void norma_gltf_multiply(const double a[16], const double b[16], double out[16]) {
    for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 4; ++row) {
            double sum = 0;
            for (int k = 0; k < 4; ++k) sum += a[4 * k + row] * b[4 * column + k];
            out[4 * column + row] = sum;
        }
}

/* Reads up to count numbers of a member; *there tells whether it is there. 0: of another type or
 * length. */
static int read_node_numbers(
    const gltf *g, uint32_t object, const char *key, uint32_t count, double *out, int *there) {
    const json *j = &g->json;
    uint32_t list = norma_json_member(j, object, key), i = 0;
    *there = list != JSON_NONE;
    if (!*there) return 1;
    if (!norma_json_is(j, list, JSON_ARRAY) || norma_json_size(j, list) != count) return 0;
    for (uint32_t item = norma_json_first(j, list); item != JSON_NONE;
         item = norma_json_next(j, list, item))
        if (!norma_json_number(j, item, &out[i++])) return 0;
    return 1;
}

static void compose_local(const double t[3], const double q[4], const double s[3], double out[16]) {
    const double x = q[0], y = q[1], z = q[2], w = q[3];
    const double rotation[9] = {1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w),
        2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w), 2 * (x * z + y * w),
        2 * (y * z - x * w), 1 - 2 * (x * x + y * y)};
    memset(out, 0, 16 * sizeof *out);
    for (int column = 0; column < 3; ++column)
        for (int row = 0; row < 3; ++row)
            out[4 * column + row] = rotation[3 * column + row] * s[column];
    memcpy(out + 12, t, 3 * sizeof *t);
    out[15] = 1;
}

static norma_document_result read_local(
    const gltf *g, gltf_node *node, norma_document_error *error) {
    double t[3] = {0, 0, 0}, q[4] = {0, 0, 0, 1}, s[3] = {1, 1, 1};
    int there;
    if (!read_node_numbers(g, node->token, "matrix", 16, node->local, &node->has_matrix))
        return norma_gltf_malformed(g, error, node->token, "16 numbers in \"matrix\"");
    if (node->has_matrix) return NORMA_DOCUMENT_OK;
    if (!read_node_numbers(g, node->token, "translation", 3, t, &there) ||
        !read_node_numbers(g, node->token, "rotation", 4, q, &there) ||
        !read_node_numbers(g, node->token, "scale", 3, s, &there))
        return norma_gltf_malformed(
            g, error, node->token, "3 numbers in \"translation\" and \"scale\", 4 in \"rotation\"");
    compose_local(t, q, s, node->local);
    return NORMA_DOCUMENT_OK;
}

static void read_instances(const gltf *g, gltf_node *node) {
    const json *j = &g->json;
    uint32_t extension = norma_json_member(
        j, norma_json_member(j, node->token, "extensions"), "EXT_mesh_gpu_instancing");
    uint32_t attributes = norma_json_member(j, extension, "attributes"),
             first = norma_json_is(j, attributes, JSON_OBJECT) ? norma_json_first(j, attributes)
                                                               : JSON_NONE;
    uint64_t accessor;
    node->instances = 1;
    node->instanced = extension != JSON_NONE;
    if (first != JSON_NONE && norma_json_uint(j, first, &accessor) && accessor < g->accessor_count)
        node->instances = g->accessors[accessor].count;
}

static norma_document_result read_node(gltf *g, gltf_node *node, norma_document_error *error) {
    const json *j = &g->json;
    uint32_t name = norma_json_member(j, node->token, "name");
    node->mesh = node->skin = GLTF_NONE;
    node->name =
        norma_json_is(j, name, JSON_STRING) ? norma_json_string(j, name) : norma_io_allocate(1, 1);
    if (!node->name) return norma_document_fail_memory(g->document, error);
    if (!norma_gltf_index_member(g, node->token, "mesh", g->mesh_count, &node->mesh))
        return norma_gltf_malformed(
            g, error, node->token, "the number of an existing mesh in \"mesh\"");
    if (!norma_gltf_index_member(g, node->token, "skin", g->skin_count, &node->skin))
        return norma_gltf_malformed(
            g, error, node->token, "the number of an existing skin in \"skin\"");
    if (node->mesh != GLTF_NONE) ++g->meshes[node->mesh].uses;
    read_instances(g, node);
    return read_local(g, node, error);
}

static norma_document_result read_children(gltf *g, uint32_t number, norma_document_error *error) {
    const json *j = &g->json;
    uint32_t children = norma_json_member(j, g->nodes[number].token, "children");
    if (children != JSON_NONE && !norma_json_is(j, children, JSON_ARRAY))
        return norma_gltf_malformed(g, error, children, "an array");
    for (uint32_t item = norma_json_first(j, children); item != JSON_NONE;
         item = norma_json_next(j, children, item)) {
        uint64_t child;
        if (!norma_json_uint(j, item, &child) || child >= g->node_count)
            return norma_gltf_malformed(g, error, item, "the number of an existing node");
        if (g->nodes[child].parent != GLTF_NONE || child == number)
            return norma_gltf_malformed(
                g, error, item, "a node that is no other node's child and not its own");
        g->nodes[child].parent = number;
    }
    return NORMA_DOCUMENT_OK;
}

/* World matrices from the roots down. A node that no root leads to hangs in a loop. state: 0
 * unknown, 1 done, 2 on the way. */
static norma_document_result place_nodes(
    gltf *g, uint32_t *path, unsigned char *done, norma_document_error *error) {
    for (uint32_t i = 0; i < g->node_count; ++i) {
        uint32_t depth = 0, at = i;
        while (at != GLTF_NONE && !done[at]) {
            if (depth == g->node_count)
                return norma_gltf_malformed(
                    g, error, g->nodes[i].token, "nodes that form a tree, not a loop");
            path[depth++] = at;
            at = g->nodes[at].parent;
        }
        while (depth-- > 0) {
            gltf_node *node = &g->nodes[path[depth]];
            if (node->parent == GLTF_NONE)
                memcpy(node->world, node->local, sizeof node->world);
            else
                norma_gltf_multiply(g->nodes[node->parent].world, node->local, node->world);
            done[path[depth]] = 1;
        }
    }
    return NORMA_DOCUMENT_OK;
}

static norma_document_result read_all_nodes(gltf *g, uint32_t list, norma_document_error *error) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    uint32_t number = 0;
    for (uint32_t item = norma_json_first(&g->json, list); !result && item != JSON_NONE;
         item = norma_json_next(&g->json, list, item), ++number) {
        if (!norma_json_is(&g->json, item, JSON_OBJECT))
            return norma_gltf_malformed(g, error, item, "an object");
        g->nodes[number].token = item;
        g->nodes[number].parent = GLTF_NONE;
        result = read_node(g, &g->nodes[number], error);
    }
    for (uint32_t i = 0; !result && i < g->node_count; ++i) result = read_children(g, i, error);
    return result;
}

norma_document_result norma_gltf_read_nodes(gltf *g, norma_document_error *error) {
    uint32_t list = norma_json_member(&g->json, 0, "nodes");
    if (list != JSON_NONE && !norma_json_is(&g->json, list, JSON_ARRAY))
        return norma_gltf_malformed(g, error, list, "an array");
    g->node_count = norma_json_size(&g->json, list);
    const uint32_t skins = norma_json_member(&g->json, 0, "skins");
    g->skin_count =
        norma_json_is(&g->json, skins, JSON_ARRAY) ? norma_json_size(&g->json, skins) : 0;
    g->nodes = norma_io_allocate(g->node_count, sizeof *g->nodes);
    g->drawing = norma_io_allocate(g->node_count, sizeof *g->drawing);
    uint32_t *path = norma_io_allocate(g->node_count, sizeof *path);
    unsigned char *done = norma_io_allocate(g->node_count, 1);
    norma_document_result result = NORMA_DOCUMENT_OK;
    if (!g->nodes || !g->drawing || !path || !done)
        result = norma_document_fail_memory(g->document, error);
    if (!result) result = read_all_nodes(g, list, error);
    if (!result) result = place_nodes(g, path, done, error);
    for (uint32_t i = 0; !result && i < g->node_count; ++i) {
        if (g->nodes[i].mesh == GLTF_NONE) continue;
        g->drawing[g->drawing_count++] = i;
        if (g->nodes[i].instanced) result = norma_gltf_place_instances(g, &g->nodes[i], error);
    }
    free(path);
    free(done);
    return result;
}
