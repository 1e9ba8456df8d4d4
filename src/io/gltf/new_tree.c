/* new_tree.c: the hierarchy in memory: read, re-hung. */
#include "io/gltf/new_tree.h"
#include "io/gltf/node_matrix.h"
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

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
    uint32_t *grown =
        norma_io_grow(scene->roots, &scene->capacity, scene->count + 1, sizeof *grown);
    if (!grown) {
        tree->failed = 1;
        return;
    }
    scene->roots = grown;
    scene->roots[scene->count++] = root;
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
    for (uint32_t token = norma_json_first(j, scenes); token != JSON_NONE;
         token = norma_json_next(j, scenes, token), scene++) {
        const uint32_t roots = norma_json_member(j, token, "nodes");
        scene->token = token;
        for (uint32_t root = norma_json_first(j, roots); root != JSON_NONE;
             root = norma_json_next(j, roots, root)) {
            uint64_t number;
            if (norma_json_uint(j, root, &number) && number < tree->g->node_count)
                add_root(tree, scene, (uint32_t)number);
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
    for (uint32_t i = 0; i < g->node_count; i++) tree->nodes[i] = no_node;
    for (uint32_t i = 0; i < g->node_count; i++) {
        const uint32_t children = norma_json_member(&g->json, g->nodes[i].token, "children");
        for (uint32_t child = norma_json_first(&g->json, children); child != JSON_NONE;
             child = norma_json_next(&g->json, children, child)) {
            uint64_t number;
            if (norma_json_uint(&g->json, child, &number) && number < g->node_count &&
                g->nodes[number].parent == i && tree->nodes[number].parent == GLTF_NONE)
                append_child(tree, i, (uint32_t)number);
        }
    }
    read_scenes(tree);
}

void norma_gltf_tree_free(gltf_tree *tree) {
    for (size_t i = 0; i < tree->scene_count; i++) free(tree->scenes[i].roots);
    free(tree->scenes);
    free(tree->nodes);
    *tree = (gltf_tree){0};
}

uint32_t norma_gltf_tree_add(gltf_tree *tree, uint32_t like) {
    tree_node *grown =
        tree->failed || tree->count >= GLTF_NONE - 1
            ? NULL
            : norma_io_grow(tree->nodes, &tree->capacity, tree->count + 1, sizeof *grown);
    if (!grown) {
        tree->failed = 1;
        return GLTF_NONE;
    }
    tree->nodes = grown;
    tree->nodes[tree->count] = no_node;
    tree->nodes[tree->count].like = like;
    return (uint32_t)tree->count++;
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

void norma_gltf_tree_insert_above(gltf_tree *tree, uint32_t node, uint32_t parent) {
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
        for (size_t i = 0; i < tree->scene_count; i++)
            for (size_t k = 0; k < tree->scenes[i].count; k++)
                if (tree->scenes[i].roots[k] == node) {
                    tree->scenes[i].roots[k] = parent;
                    tree->scenes[i].changed = 1;
                }
    }
    append_child(tree, parent, node);
    tree->nodes[parent].children_changed = 1;
}

uint32_t norma_gltf_tree_root(const gltf_tree *tree, uint32_t node) {
    while (tree->nodes[node].parent != GLTF_NONE) node = tree->nodes[node].parent;
    return node;
}

int norma_gltf_tree_shows(const gltf_tree *tree, size_t scene, uint32_t root) {
    for (size_t k = 0; k < tree->scenes[scene].count; k++)
        if (tree->scenes[scene].roots[k] == root) return 1;
    return 0;
}

void norma_gltf_tree_make_root(gltf_tree *tree, uint32_t node) {
    if (tree->failed || tree->nodes[node].parent == GLTF_NONE) return;
    const uint32_t root = norma_gltf_tree_root(tree, node);
    detach(tree, node);
    for (size_t i = 0; i < tree->scene_count; i++)
        if (norma_gltf_tree_shows(tree, i, root)) {
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
    for (int i = 0; i < 16; i++)
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
    norma_gltf_tree_insert_above(tree, node, above);
}

/* Roots by the set of scenes that list them: each scene in turn splits every class into those that
 * it lists and the others. */
typedef struct root_classes {
    uint32_t
        *of; /* for each node, new ones too (a scene may list one), its class; 0: in no scene */
    uint32_t *made_in, *split_in, *split_to,
        *above; /* for each class: the scene (from 1) that made it, that split it last, into what;
                   the new node */
    uint32_t count;
} root_classes;

static int allocate_classes(const gltf_tree *tree, root_classes *classes) {
    size_t most = 1;
    for (size_t i = 0; i < tree->scene_count; i++) most += tree->scenes[i].count;
    *classes = (root_classes){.count = 1};
    classes->of = norma_io_allocate(tree->count + 1, sizeof *classes->of);
    classes->made_in = norma_io_allocate(most, sizeof *classes->made_in);
    classes->split_in = norma_io_allocate(most, sizeof *classes->split_in);
    classes->split_to = norma_io_allocate(most, sizeof *classes->split_to);
    classes->above = norma_io_allocate(most, sizeof *classes->above);
    for (size_t i = 0; classes->above && i < most; i++) classes->above[i] = GLTF_NONE;
    return classes->of && classes->made_in && classes->split_in && classes->split_to &&
           classes->above;
}

static void free_classes(root_classes *classes) {
    free(classes->of);
    free(classes->made_in);
    free(classes->split_in);
    free(classes->split_to);
    free(classes->above);
}

static void classify(const gltf_tree *tree, root_classes *classes) {
    for (size_t i = 0; i < tree->scene_count; i++) {
        const uint32_t scene = (uint32_t)i + 1;
        for (size_t k = 0; k < tree->scenes[i].count; k++) {
            uint32_t *of = &classes->of[tree->scenes[i].roots[k]];
            if (classes->made_in[*of] == scene) continue; /* listed twice */
            if (classes->split_in[*of] != scene) {
                classes->split_in[*of] = scene;
                classes->split_to[*of] = classes->count;
                classes->made_in[classes->count++] = scene;
            }
            *of = classes->split_to[*of];
        }
    }
}

static void raise_roots(
    gltf_tree *tree, root_classes *classes, const unsigned char *wanted, const double matrix[16]) {
    for (uint32_t i = 0; i < tree->g->node_count && !tree->failed; i++) {
        if (!wanted[i] || tree->g->nodes[i].parent != GLTF_NONE ||
            tree->nodes[i].parent != GLTF_NONE)
            continue;
        uint32_t *above = &classes->above[classes->of[i]];
        if (*above == GLTF_NONE) *above = norma_gltf_tree_add(tree, GLTF_NONE);
        if (*above != GLTF_NONE) norma_gltf_tree_give(tree, i, *above);
    }
    for (size_t i = 0; i < tree->scene_count && !tree->failed;
         i++) { /* the new node stands where the first of its roots stood */
        tree_scene *scene = &tree->scenes[i];
        size_t kept = 0;
        for (size_t k = 0; k < scene->count; k++) {
            const uint32_t root = scene->roots[k], class = classes->of[root];
            const int raised = tree->nodes[root].parent != GLTF_NONE &&
                               tree->nodes[root].parent == classes->above[class];
            scene->changed |= raised;
            if (!raised)
                scene->roots[kept++] = root;
            else if (tree->nodes[classes->above[class]].first == root)
                scene->roots[kept++] = classes->above[class];
        }
        scene->count = kept;
    }
    for (uint32_t i = 0; i < classes->count; i++)
        if (classes->above[i] != GLTF_NONE)
            norma_gltf_tree_set_local(tree, classes->above[i], matrix);
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
    free_classes(&classes);
}
