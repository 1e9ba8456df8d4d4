/* write_tree.c: the changed hierarchy as JSON: edits of old nodes and scenes, texts of new nodes.
 * What did not change is not touched. */
#include "io/gltf/new_tree.h"
#include "io/gltf/patch.h"
#include "io/gltf/node_matrix.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void add_numbers(json_text *text, const double *numbers, size_t count) {
    norma_json_add_text(text, "[");
    for (size_t i = 0; i < count; i++) {
        if (i) norma_json_add_text(text, ",");
        norma_json_add_number(text, numbers[i] + 0.0); /* -0 becomes 0 */
    }
    norma_json_add_text(text, "]");
}

typedef struct local_text {
    json_text matrix, translation, rotation, scale;
} local_text; /* each empty where the member is not needed */

static void free_local(local_text *text) {
    free(text->matrix.data);
    free(text->translation.data);
    free(text->rotation.data);
    free(text->scale.data);
}

static void write_local(const tree_node *node, local_text *text) {
    *text = (local_text){0};
    gltf_trs trs;
    if (node->matrix_form) {
        add_numbers(&text->matrix, node->local, 16);
        return;
    }
    norma_gltf_matrix_decompose(node->local, &trs);
    if (trs.translation[0] != 0 || trs.translation[1] != 0 || trs.translation[2] != 0)
        add_numbers(&text->translation, trs.translation, 3);
    if (trs.rotation[0] != 0 || trs.rotation[1] != 0 || trs.rotation[2] != 0)
        add_numbers(&text->rotation, trs.rotation, 4);
    if (trs.scale[0] != 1 || trs.scale[1] != 1 || trs.scale[2] != 1)
        add_numbers(&text->scale, trs.scale, 3);
}

static char *terminated(json_text *text) {
    norma_json_add(text, "", 1);
    return text->failed ? NULL : text->data;
}

/* object.key = text, or nothing of that name where the text is empty. */
static int set_or_unset(json_edits *edits, uint32_t object, const char *key, json_text *text) {
    if (text->size == 0 && !text->failed) {
        norma_json_unset(edits, object, key);
        return 1;
    }
    const char *value = terminated(text);
    if (value) norma_json_set(edits, object, key, value);
    return value != NULL;
}

static void add_children(const gltf_tree *tree, const tree_node *node, json_text *text) {
    if (node->first == GLTF_NONE) return;
    norma_json_add_text(text, "[");
    for (uint32_t child = node->first; child != GLTF_NONE; child = tree->nodes[child].after) {
        if (child != node->first) norma_json_add_text(text, ",");
        norma_json_add_uint(text, child);
    }
    norma_json_add_text(text, "]");
}

static void remove_instances(const gltf *g, json_edits *edits, uint32_t object) {
    const uint32_t extensions = norma_json_member(&g->json, object, "extensions");
    if (norma_json_size(&g->json, extensions) == 1)
        norma_json_unset(edits, object, "extensions");
    else
        norma_json_unset(edits, extensions, "EXT_mesh_gpu_instancing");
}

static int edit_node(const gltf_tree *tree, json_edits *edits, uint32_t number) {
    const gltf *g = tree->g;
    const tree_node *node = &tree->nodes[number];
    const uint32_t object = g->nodes[number].token;
    int done = 1;
    if (node->children_changed) {
        json_text text = {0};
        add_children(tree, node, &text);
        done &= set_or_unset(edits, object, "children", &text);
        free(text.data);
    }
    if (node->local_changed) {
        local_text text;
        write_local(node, &text);
        done &= set_or_unset(edits, object, "matrix", &text.matrix) &
                set_or_unset(edits, object, "translation", &text.translation) &
                set_or_unset(edits, object, "rotation", &text.rotation) &
                set_or_unset(edits, object, "scale", &text.scale);
        free_local(&text);
    }
    if (node->mesh_changed && node->mesh == GLTF_NONE)
        norma_json_unset(edits, object, "mesh");
    else if (node->mesh_changed)
        norma_json_set_uint(edits, object, "mesh", node->mesh);
    if (node->weights_removed) norma_json_unset(edits, object, "weights");
    if (node->instances_removed) remove_instances(g, edits, object);
    return done;
}

static void add_node_member(json_text *text, const char *key, const json_text *value) {
    text->failed |= value->failed;
    if (value->size == 0) return;
    norma_json_add_text(text, text->size > 1 ? ",\"" : "\"");
    norma_json_add_text(text, key);
    norma_json_add_text(text, "\":");
    norma_json_add(text, value->data, value->size);
    text->failed |= value->failed;
}

static void copy_node_member(const gltf *g, json_text *text, uint32_t object, const char *key) {
    const uint32_t value = norma_json_member(&g->json, object, key);
    if (value == JSON_NONE) return;
    json_text bytes = {0};
    norma_json_add(&bytes, g->json.text + g->json.tokens[value].start,
        g->json.tokens[value].end - g->json.tokens[value].start);
    add_node_member(text, key, &bytes);
    free(bytes.data);
}

static void add_node_text(const gltf_tree *tree, const tree_node *node, json_text *text) {
    norma_json_add_text(text, "{");
    if (node->like != GLTF_NONE)
        copy_node_member(tree->g, text, tree->g->nodes[node->like].token, "name");
    json_text value = {0};
    if (node->mesh != GLTF_NONE) {
        norma_json_add_uint(&value, node->mesh);
        add_node_member(text, "mesh", &value);
        if (node->takes_weights)
            copy_node_member(tree->g, text, tree->g->nodes[node->like].token, "weights");
    }
    value.size = 0;
    add_children(tree, node, &value);
    add_node_member(text, "children", &value);
    free(value.data);
    if (node->local_changed) {
        local_text local;
        write_local(node, &local);
        add_node_member(text, "matrix", &local.matrix);
        add_node_member(text, "translation", &local.translation);
        add_node_member(text, "rotation", &local.rotation);
        add_node_member(text, "scale", &local.scale);
        free_local(&local);
    }
    norma_json_add_text(text, "}");
}

static int append_nodes(const gltf_tree *tree, json_edits *edits) {
    const uint32_t array = norma_json_member(&tree->g->json, 0, "nodes");
    for (size_t i = tree->g->node_count; i < tree->count; i++) {
        json_text text = {0};
        add_node_text(tree, &tree->nodes[i], &text);
        const char *value = terminated(&text);
        if (value) norma_json_append(edits, array, value);
        free(text.data);
        if (!value) return 0;
    }
    return 1;
}

static int edit_scene(json_edits *edits, const tree_scene *scene) {
    json_text text = {0};
    for (size_t i = 0; i < scene->count; i++) {
        norma_json_add_text(&text, i ? "," : "[");
        norma_json_add_uint(&text, scene->roots[i]);
    }
    if (scene->count) norma_json_add_text(&text, "]");
    const int done = set_or_unset(edits, scene->token, "nodes", &text);
    free(text.data);
    return done;
}

/* ---- what a node can hold */

static int exceeds_floats(const double *numbers, size_t count, double *which) {
    for (size_t i = 0; i < count; i++)
        if (!isfinite((float)(*which = numbers[i]))) return 1;
    return 0;
}

/* Readers take a node's numbers for floats: larger ones would be infinite there. */
static norma_document_result check_numbers(const gltf_tree *tree, norma_document_error *error) {
    for (size_t i = 0; i < tree->count && !tree->failed; i++) {
        const tree_node *node = &tree->nodes[i];
        gltf_trs trs = {{0}, {0}, {0}};
        double number = 0;
        char place[40];
        if (!node->local_changed) continue;
        if (!node->matrix_form) norma_gltf_matrix_decompose(node->local, &trs);
        const char *what = node->matrix_form
                               ? exceeds_floats(node->local, 16, &number) ? "matrix" : NULL
                           : exceeds_floats(trs.translation, 3, &number) ? "translation"
                           : exceeds_floats(trs.scale, 3, &number)       ? "scale"
                                                                         : NULL;
        if (!what) continue;
        (void)snprintf(place, sizeof place, "%snode %zu", i < tree->g->node_count ? "" : "new ", i);
        return norma_document_fail(tree->g->document, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED,
            place, "its %s would hold %.3g; expected numbers up to 3.4e+38, the largest float",
            what, number);
    }
    return NORMA_DOCUMENT_OK;
}

norma_document_result norma_gltf_tree_write(gltf_tree *tree, norma_document_error *error) {
    json_edits *edits = tree->failed ? NULL : norma_gltf_edits(tree->g, 0);
    int done = edits != NULL;
    const norma_document_result too_large = check_numbers(tree, error);
    if (too_large) return too_large;
    if (tree->count > tree->g->node_count) {
        const norma_document_result dangling =
            norma_gltf_check_dangling(tree->g, GLTF_LIST_NODES, error);
        if (dangling) return dangling;
    }
    for (uint32_t i = 0; done && i < tree->g->node_count; i++) done = edit_node(tree, edits, i);
    done = done && (tree->count == tree->g->node_count || append_nodes(tree, edits));
    for (size_t i = 0; done && i < tree->scene_count; i++)
        if (tree->scenes[i].changed) done = edit_scene(edits, &tree->scenes[i]);
    return done ? NORMA_DOCUMENT_OK : norma_document_fail_memory(tree->g->document, error);
}
