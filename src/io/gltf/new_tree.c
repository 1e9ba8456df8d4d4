/* new_tree.c: the node hierarchy as it is to become, and its JSON. */
#include "io/gltf/gltf_layout.h"
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- The hierarchy in memory: read, re-hung. */

static void append_child(gltf_tree *tree, uint32_t parent, uint32_t child) {
    tree_node *above = &tree->nodes[parent], *node = &tree->nodes[child];
    node->parent = parent;
    node->before = above->last;
    node->after = GLTF_NONE;
    if (above->last == GLTF_NONE)
        above->first = child;
    else
        tree->nodes[above->last].after = child;
    above->last = child;
}

static void add_root(gltf_tree *tree, tree_scene *scene, uint32_t root) {
    uint32_t *added = norma_io_add(&scene->roots, &scene->capacity, &scene->count, sizeof *added);
    if (added) *added = root;
    tree->failed |= !added;
}

static void read_scenes(gltf_tree *tree) {
    const json *j = &tree->g->json;
    const uint32_t scenes = norma_json_member(j, 0, "scenes");
    tree->scene_count = norma_json_size(j, scenes);
    if (tree->scene_count == 0) return;
    tree->scenes = norma_io_allocate(tree->scene_count, sizeof *tree->scenes);
    if (!tree->scenes) {
        tree->scene_count = 0;
        tree->failed = 1;
        return;
    }
    tree_scene *scene = tree->scenes;
    for (uint32_t token = JSON_NONE; norma_json_each(j, scenes, &token); ++scene) {
        const uint32_t roots = norma_json_member(j, token, "nodes");
        scene->token = token;
        for (uint32_t root = JSON_NONE; norma_json_each(j, roots, &root);) {
            const uint32_t node = norma_gltf_number(tree->g, root, tree->g->node_count);
            if (node != GLTF_NONE) add_root(tree, scene, node);
        }
    }
}

static const tree_node no_node = {.parent = GLTF_NONE,
    .first = GLTF_NONE,
    .last = GLTF_NONE,
    .before = GLTF_NONE,
    .after = GLTF_NONE,
    .mesh = GLTF_NONE,
    .like = GLTF_NONE};

void norma_gltf_tree_read(gltf *g, gltf_tree *tree) {
    *tree = (gltf_tree){.g = g};
    tree->nodes =
        norma_io_grow(NULL, &tree->capacity, (size_t)g->node_count + 1, sizeof *tree->nodes);
    if (!tree->nodes) {
        tree->failed = 1;
        return;
    }
    tree->count = g->node_count;
    for (uint32_t i = 0; i < g->node_count; ++i) tree->nodes[i] = no_node;
    for (uint32_t i = 0; i < g->node_count; ++i) {
        const uint32_t children = norma_json_member(&g->json, g->nodes[i].token, "children");
        for (uint32_t child = JSON_NONE; norma_json_each(&g->json, children, &child);) {
            const uint32_t node = norma_gltf_number(g, child, g->node_count);
            if (node != GLTF_NONE && g->nodes[node].parent == i &&
                tree->nodes[node].parent == GLTF_NONE)
                append_child(tree, i, node);
        }
    }
    read_scenes(tree);
}

void norma_gltf_tree_free(gltf_tree *tree) {
    for (size_t i = 0; i < tree->scene_count; ++i) free(tree->scenes[i].roots);
    free(tree->scenes);
    free(tree->nodes);
    *tree = (gltf_tree){0};
}

uint32_t norma_gltf_tree_add(gltf_tree *tree, uint32_t like) {
    tree_node *added =
        tree->failed || tree->count >= GLTF_NONE - 1
            ? NULL
            : norma_io_add(&tree->nodes, &tree->capacity, &tree->count, sizeof *added);
    tree->failed |= !added;
    if (!added) return GLTF_NONE;
    *added = no_node;
    added->like = like;
    return (uint32_t)tree->count - 1;
}

static void detach(gltf_tree *tree, uint32_t child) {
    tree_node *node = &tree->nodes[child];
    if (node->parent == GLTF_NONE) return;
    tree_node *above = &tree->nodes[node->parent];
    above->children_changed = 1;
    *(node->before == GLTF_NONE ? &above->first : &tree->nodes[node->before].after) = node->after;
    *(node->after == GLTF_NONE ? &above->last : &tree->nodes[node->after].before) = node->before;
    node->parent = node->before = node->after = GLTF_NONE;
}

void norma_gltf_tree_give(gltf_tree *tree, uint32_t child, uint32_t parent) {
    if (tree->failed) return;
    detach(tree, child);
    append_child(tree, parent, child);
    tree->nodes[parent].children_changed = 1;
}

/* parent takes node's place, in its parent or in its scenes, and node under it */
static void gltf_tree_insert_above(gltf_tree *tree, uint32_t node, uint32_t parent) {
    if (tree->failed) return;
    const uint32_t above = tree->nodes[node].parent;
    if (above != GLTF_NONE) {
        tree_node *new_parent = &tree->nodes[parent], *child = &tree->nodes[node];
        new_parent->parent = above;
        new_parent->before = child->before;
        new_parent->after = child->after;
        *(child->before == GLTF_NONE ? &tree->nodes[above].first
                                     : &tree->nodes[child->before].after) = parent;
        *(child->after == GLTF_NONE ? &tree->nodes[above].last
                                    : &tree->nodes[child->after].before) = parent;
        tree->nodes[above].children_changed = 1;
    } else {
        for (size_t i = 0; i < tree->scene_count; ++i)
            for (size_t k = 0; k < tree->scenes[i].count; ++k)
                if (tree->scenes[i].roots[k] == node) {
                    tree->scenes[i].roots[k] = parent;
                    tree->scenes[i].changed = 1;
                }
    }
    append_child(tree, parent, node);
    tree->nodes[parent].children_changed = 1;
}

static uint32_t gltf_tree_root(const gltf_tree *tree, uint32_t node) {
    while (tree->nodes[node].parent != GLTF_NONE) node = tree->nodes[node].parent;
    return node;
}

/* whether root is listed there */
static int gltf_tree_shows(const gltf_tree *tree, size_t scene, uint32_t root) {
    for (size_t k = 0; k < tree->scenes[scene].count; ++k)
        if (tree->scenes[scene].roots[k] == root) return 1;
    return 0;
}

void norma_gltf_tree_make_root(gltf_tree *tree, uint32_t node) {
    if (tree->failed || tree->nodes[node].parent == GLTF_NONE) return;
    const uint32_t root = gltf_tree_root(tree, node);
    detach(tree, node);
    for (size_t i = 0; i < tree->scene_count; ++i)
        if (gltf_tree_shows(tree, i, root)) {
            add_root(tree, &tree->scenes[i], node);
            tree->scenes[i].changed = 1;
        }
}

static void set_form(gltf_tree *tree, uint32_t node, const double local[16], int matrix_form) {
    tree->nodes[node].local_changed = 1;
    tree->nodes[node].matrix_form = matrix_form;
    memcpy(tree->nodes[node].local, local, sizeof tree->nodes[node].local);
}

/* Readers take a node's matrix apart with floats: one that is singular for them is not for
 * "matrix". */
static int invertible_in_floats(const double m[16]) {
    double inverse[16];
    for (int i = 0; i < 16; ++i)
        if (fabs(m[i]) > (double)FLT_MAX) return 0;
    if (!norma_gltf_matrix_invert(m, inverse)) return 0;
    const double determinant = m[0] * (m[5] * m[10] - m[6] * m[9]) +
                               m[4] * (m[9] * m[2] - m[10] * m[1]) +
                               m[8] * (m[1] * m[6] - m[2] * m[5]);
    return fabs(determinant) > (double)FLT_MIN && fabs(determinant) < (double)FLT_MAX;
}

/* Up to here columns count as perpendicular: rounding of doubles; and of the floats that rotations
 * are often stored with, which "matrix" still holds. */
static const double exact_tolerance = 1e-13, matrix_tolerance = 1e-6;

void norma_gltf_tree_set_local(gltf_tree *tree, uint32_t node, const double local[16]) {
    if (tree->failed) return;
    gltf_trs outer, inner;
    const double shear = norma_gltf_matrix_decompose(local, &outer);
    if (shear <= exact_tolerance || (shear <= matrix_tolerance && invertible_in_floats(local))) {
        set_form(tree, node, local, shear > exact_tolerance);
        return;
    }
    double matrix[16];
    const uint32_t above = norma_gltf_tree_add(tree, GLTF_NONE);
    if (above == GLTF_NONE) return;
    norma_gltf_matrix_split(local, &outer, &inner);
    norma_gltf_matrix_compose(&outer, matrix);
    set_form(tree, above, matrix, 0);
    norma_gltf_matrix_compose(&inner, matrix);
    set_form(tree, node, matrix, 0);
    gltf_tree_insert_above(tree, node, above);
}

/* Roots by the set of scenes that list them: each scene in turn splits every class into those that
 * it lists and the others. */
typedef struct root_class {
    uint32_t made_in, split_in,
        split_to;   /* the scene (from 1) that made it, split it last; to what */
    uint32_t above; /* the new node */
} root_class;

typedef struct root_classes {
    uint32_t *of; /* for each node, new ones too (a scene may list one); 0: in no scene */
    root_class *list;
    uint32_t count;
} root_classes;

static int allocate_classes(const gltf_tree *tree, root_classes *classes) {
    size_t most = 1;
    for (size_t i = 0; i < tree->scene_count; ++i) most += tree->scenes[i].count;
    *classes = (root_classes){.of = norma_io_allocate(tree->count + 1, sizeof *classes->of),
        .list = norma_io_allocate(most, sizeof *classes->list),
        .count = 1};
    for (size_t i = 0; classes->list && i < most; ++i) classes->list[i].above = GLTF_NONE;
    return classes->of && classes->list;
}

static void classify(const gltf_tree *tree, root_classes *classes) {
    for (size_t i = 0; i < tree->scene_count; ++i) {
        const uint32_t scene = (uint32_t)i + 1;
        for (size_t k = 0; k < tree->scenes[i].count; ++k) {
            uint32_t *of = &classes->of[tree->scenes[i].roots[k]];
            root_class *class = &classes->list[*of];
            if (class->made_in == scene) continue; /* listed twice */
            if (class->split_in != scene) {
                class->split_in = scene;
                class->split_to = classes->count;
                classes->list[classes->count++].made_in = scene;
            }
            *of = class->split_to;
        }
    }
}

static void raise_roots(
    gltf_tree *tree, root_classes *classes, const unsigned char *wanted, const double matrix[16]) {
    for (uint32_t i = 0; i < tree->g->node_count && !tree->failed; ++i) {
        if (!wanted[i] || tree->g->nodes[i].parent != GLTF_NONE ||
            tree->nodes[i].parent != GLTF_NONE)
            continue;
        uint32_t *above = &classes->list[classes->of[i]].above;
        if (*above == GLTF_NONE) *above = norma_gltf_tree_add(tree, GLTF_NONE);
        if (*above != GLTF_NONE) norma_gltf_tree_give(tree, i, *above);
    }
    for (size_t i = 0; i < tree->scene_count && !tree->failed;
         ++i) { /* the new node stands where the first of its roots stood */
        tree_scene *scene = &tree->scenes[i];
        size_t kept = 0;
        for (size_t k = 0; k < scene->count; ++k) {
            const uint32_t root = scene->roots[k], above = classes->list[classes->of[root]].above;
            const int raised =
                tree->nodes[root].parent != GLTF_NONE && tree->nodes[root].parent == above;
            scene->changed |= raised;
            if (!raised)
                scene->roots[kept++] = root;
            else if (tree->nodes[above].first == root)
                scene->roots[kept++] = above;
        }
        scene->count = kept;
    }
    for (uint32_t i = 0; i < classes->count; ++i)
        if (classes->list[i].above != GLTF_NONE)
            norma_gltf_tree_set_local(tree, classes->list[i].above, matrix);
}

void norma_gltf_tree_raise(gltf_tree *tree, const unsigned char *wanted, const double matrix[16]) {
    root_classes classes;
    if (tree->failed) return;
    if (allocate_classes(tree, &classes)) {
        classify(tree, &classes);
        raise_roots(tree, &classes, wanted, matrix);
    } else {
        tree->failed = 1;
    }
    free(classes.of);
    free(classes.list);
}

/* ---- The changed hierarchy as JSON: edits of old nodes and scenes, texts of new nodes.
 * What did not change is not touched. */

static void add_numbers(json_text *text, const double *numbers, size_t count) {
    norma_json_add_text(text, "[");
    for (size_t i = 0; i < count; ++i) {
        if (i) norma_json_add_text(text, ",");
        norma_json_add_number(text, numbers[i] + 0.0); /* -0 becomes 0 */
    }
    norma_json_add_text(text, "]");
}

/* Where a node's members go: into edits of an old one, or the text of a new one. */
typedef struct node_members {
    json_edits *edits; /* NULL: into the text */
    uint32_t object;
    json_text *text;
} node_members;

/* Takes the value; an empty one is no member. */
static void put_node_member(const node_members *to, const char *key, json_text *value) {
    if (to->edits) {
        norma_json_set_made(to->edits, to->object, key, value);
        return;
    }
    to->text->failed |= value->failed;
    if (value->size) norma_json_add_key(to->text, key);
    norma_json_add(to->text, value->data, value->size);
    free(value->data);
}

static void put_node_local(const node_members *to, const tree_node *node) {
    json_text matrix = {0}, translation = {0}, rotation = {0}, scale = {0};
    gltf_trs trs = {{0, 0, 0}, {0, 0, 0, 1}, {1, 1, 1}};
    if (!node->local_changed) return;
    if (node->matrix_form)
        add_numbers(&matrix, node->local, 16);
    else
        norma_gltf_matrix_decompose(node->local, &trs);
    if (trs.translation[0] != 0 || trs.translation[1] != 0 || trs.translation[2] != 0)
        add_numbers(&translation, trs.translation, 3);
    if (trs.rotation[0] != 0 || trs.rotation[1] != 0 || trs.rotation[2] != 0)
        add_numbers(&rotation, trs.rotation, 4);
    if (trs.scale[0] != 1 || trs.scale[1] != 1 || trs.scale[2] != 1)
        add_numbers(&scale, trs.scale, 3);
    put_node_member(to, "matrix", &matrix);
    put_node_member(to, "translation", &translation);
    put_node_member(to, "rotation", &rotation);
    put_node_member(to, "scale", &scale);
}

static void put_children(const node_members *to, const gltf_tree *tree, const tree_node *node) {
    json_text text = {0};
    for (uint32_t child = node->first; child != GLTF_NONE; child = tree->nodes[child].after) {
        norma_json_add_text(&text, child == node->first ? "[" : ",");
        norma_json_add_uint(&text, child);
    }
    if (node->first != GLTF_NONE) norma_json_add_text(&text, "]");
    put_node_member(to, "children", &text);
}

static void edit_node(const gltf_tree *tree, json_edits *edits, uint32_t number) {
    const gltf *g = tree->g;
    const tree_node *node = &tree->nodes[number];
    const uint32_t object = g->nodes[number].token;
    const node_members members = {edits, object, NULL};
    if (node->children_changed) put_children(&members, tree, node);
    put_node_local(&members, node);
    if (node->mesh_changed && node->mesh == GLTF_NONE)
        norma_json_unset(edits, object, "mesh");
    else if (node->mesh_changed)
        norma_json_set_uint(edits, object, "mesh", node->mesh);
    if (node->weights_removed) norma_json_unset(edits, object, "weights");
    if (node->instances_removed)
        norma_gltf_remove_extension(g, edits, object, "EXT_mesh_gpu_instancing");
}

static void add_node_text(const gltf_tree *tree, const tree_node *node, json_text *text) {
    const uint32_t like = node->like == GLTF_NONE ? JSON_NONE : tree->g->nodes[node->like].token;
    const node_members members = {.text = text};
    norma_json_add_text(text, "{");
    norma_gltf_copy_member(tree->g, text, like, "name");
    if (node->mesh != GLTF_NONE) norma_json_add_uint_member(text, "mesh", node->mesh);
    if (node->mesh != GLTF_NONE && node->takes_weights)
        norma_gltf_copy_member(tree->g, text, like, "weights");
    put_children(&members, tree, node);
    put_node_local(&members, node);
    norma_json_add_text(text, "}");
}

static void append_nodes(const gltf_tree *tree, json_edits *edits) {
    for (size_t i = tree->g->node_count; i < tree->count; ++i) {
        json_text text = {0};
        add_node_text(tree, &tree->nodes[i], &text);
        norma_json_append_made(edits, 0, "nodes", &text);
    }
}

static void edit_scene(json_edits *edits, const tree_scene *scene) {
    json_text text = {0};
    for (size_t i = 0; i < scene->count; ++i) {
        norma_json_add_text(&text, i ? "," : "[");
        norma_json_add_uint(&text, scene->roots[i]);
    }
    if (scene->count) norma_json_add_text(&text, "]");
    norma_json_set_made(edits, scene->token, "nodes", &text);
}

/* ---- what a node can hold */

static int exceeds_floats(const double *numbers, size_t count, double *which) {
    for (size_t i = 0; i < count; ++i)
        if (!isfinite((float)(*which = numbers[i]))) return 1;
    return 0;
}

/* Readers take a node's numbers for floats: larger ones would be infinite there. */
static norma_document_result check_numbers(const gltf_tree *tree, norma_document_error *error) {
    for (size_t i = 0; i < tree->count && !tree->failed; ++i) {
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
    const norma_document_result too_large = check_numbers(tree, error);
    if (too_large) return too_large;
    if (tree->count > tree->g->node_count) {
        const norma_document_result dangling =
            norma_gltf_check_dangling(tree->g, GLTF_LIST_NODES, error);
        if (dangling) return dangling;
    }
    for (uint32_t i = 0; edits && i < tree->g->node_count; ++i) edit_node(tree, edits, i);
    if (edits) append_nodes(tree, edits);
    for (size_t i = 0; edits && i < tree->scene_count; ++i)
        if (tree->scenes[i].changed) edit_scene(edits, &tree->scenes[i]);
    return edits && !norma_json_edits_failed(edits)
               ? NORMA_DOCUMENT_OK
               : norma_document_fail_memory(tree->g->document, error);
}
