/* new_tree.h: the node hierarchy as it is to become: nodes get new parents, new nodes come behind
 * the old ones, and at the end the JSON of what changed is edited. Numbers of nodes never shift. */
#ifndef NORMA_IO_GLTF_BAKE_TREE_H
#define NORMA_IO_GLTF_BAKE_TREE_H
#include "io/gltf/asset.h"

typedef struct tree_node {
    uint32_t parent, first, last, before, after; /* siblings in order; GLTF_NONE: the last one */
    int children_changed, local_changed, matrix_form;
    double local[16]; /* where local_changed; as TRS unless matrix_form */
    uint32_t mesh;    /* where mesh_changed, or new; GLTF_NONE: none */
    int mesh_changed, instances_removed;
    uint32_t like; /* new nodes: the old one whose name they take (and, where takes_weights, whose
                      morph weights); GLTF_NONE: none */
    int takes_weights, weights_removed;
} tree_node;

typedef struct tree_scene {
    uint32_t token; /* of the scene's object */
    uint32_t *roots;
    size_t count, capacity;
    int changed;
} tree_scene;

typedef struct gltf_tree {
    gltf *g;
    tree_node *nodes;
    size_t count, capacity; /* the first g->node_count are the file's */
    tree_scene *scenes;
    size_t scene_count;
    int failed; /* out of memory; functions below then do nothing */
} gltf_tree;

void norma_gltf_tree_read(gltf *g, gltf_tree *tree); /* failed shows at norma_gltf_tree_write */
void norma_gltf_tree_free(gltf_tree *tree);

uint32_t norma_gltf_tree_add(
    gltf_tree *tree, uint32_t like); /* a new node without parent; GLTF_NONE: out of memory */
void norma_gltf_tree_give(gltf_tree *tree, uint32_t child,
    uint32_t parent); /* moves child, from wherever it is, to the end of parent's children */
void norma_gltf_tree_insert_above(gltf_tree *tree, uint32_t node,
    uint32_t
        parent); /* parent takes node's place, in its parent or in its scenes, and node under it */
void norma_gltf_tree_make_root(gltf_tree *tree, uint32_t node); /* of the scenes that show it */
uint32_t norma_gltf_tree_root(const gltf_tree *tree, uint32_t node);
int norma_gltf_tree_shows(
    const gltf_tree *tree, size_t scene, uint32_t root); /* whether root is listed there */

/* The node's local matrix. Where one node cannot hold it (shear), a second one is put above. */
void norma_gltf_tree_set_local(gltf_tree *tree, uint32_t node, const double local[16]);

/* Puts a node above those of the asset's roots that wanted says (one byte for each old node), one
 * for each set of scenes that the roots share. */
void norma_gltf_tree_raise(gltf_tree *tree, const unsigned char *wanted, const double matrix[16]);

norma_document_result norma_gltf_tree_write(
    gltf_tree *tree, norma_document_error *error); /* into g->edits */
#endif
