/* bake.h: what the files of --bake share. bake.c decides which nodes are baked and what becomes of
 * the hierarchy, bake_plan.c finds out what must stay, bake_mesh.c carries a mesh's data,
 * bake_winding.c reverses its triangles, gltf_bake_tree*.c hold the nodes. */
#ifndef NORMA_IO_GLTF_BAKE_H
#define NORMA_IO_GLTF_BAKE_H
#include "io/gltf/asset.h"
#include "io/gltf/new_tree.h"
#include "io/gltf/encode_vectors.h"

/* Contents that several slots ask for, made once. */
typedef struct bake_entry {
    uint32_t role, a, b, map, data, after;
} bake_entry;
typedef struct bake_cache {
    bake_entry *entries;
    uint32_t *heads; /* hash table of chains */
    size_t count, capacity, head_count;
    double (*matrices)[16]; /* by id */
    size_t matrix_count, matrix_capacity;
} bake_cache;

#define BAKE_UNCHANGED (UINT32_MAX - 1) /* as data: the slot keeps what it has */

void norma_gltf_bake_cache_free(bake_cache *cache);
int norma_gltf_bake_cache_find(const bake_cache *cache, const bake_entry *key, uint32_t *data);
int norma_gltf_bake_cache_add(bake_cache *cache, const bake_entry *entry); /* 0: out of memory */
int norma_gltf_bake_map(
    bake_cache *cache, const double matrix[16], bake_map *map); /* 0: out of memory */

/* A mesh (copy 0: itself) as the node, for messages, draws it under the map; vertices are added to
 * *vertices. */
/* One use of a mesh: copy is the number that its slots have, node the one that draws it. */
typedef struct mesh_use {
    uint32_t mesh, copy, node;
} mesh_use;
norma_document_result norma_gltf_bake_mesh(gltf *g, bake_cache *cache, const mesh_use *use,
    const bake_map *map, size_t *vertices, norma_document_error *error);
norma_document_result norma_gltf_bake_winding(
    gltf *g, bake_cache *cache, uint32_t primitive, uint32_t copy, norma_document_error *error);

/* For each node of the file. */
enum {
    BAKE_MOVES = 1,   /* an animation moves it */
    BAKE_WEIGHTS = 2, /* an animation sets its morph weights */
    BAKE_MOVED = 4,   /* it or a node above it is moved */
    BAKE_JOINT = 8,   /* of a skin, or its skeleton */
    BAKE_CARRIES = 16 /* a camera, a light, an extension that may depend on where the node is */
};
unsigned char *norma_gltf_bake_flags(
    const gltf *g, const uint32_t *order); /* NULL: out of memory; to be freed */
/* Parents before their children; NULL: out of memory; to be freed. */
uint32_t *norma_gltf_bake_order(const gltf *g, const gltf_tree *tree);
/* NULL, or why a mesh cannot be carried. */
const char *norma_gltf_bake_obstacle(const gltf *g, uint32_t mesh);

norma_document_result norma_gltf_bake(gltf *g, const norma_transform_options *options,
    norma_transform_summary *summary, norma_document_error *error);
#endif
