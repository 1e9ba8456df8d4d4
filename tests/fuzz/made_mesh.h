/* made_mesh.h: a mesh of arrays, any at all, made of a target's bytes. Each array is a block of its
 * own and as long as the mesh needs, so that the address sanitizer sees every read beside it. */
#ifndef NORMA_FUZZ_MADE_MESH_H
#define NORMA_FUZZ_MADE_MESH_H
#include "fuzz.h"

typedef struct made_mesh {
    norma_mesh mesh;
    size_t faces; /* as far as they can be counted */
    void *blocks[8];
    size_t block_count;
} made_mesh;
made_mesh *made_mesh_take(fuzz_bytes *bytes);
void made_mesh_free(made_mesh *made);
/* count vectors of any format and stride; block is to be freed. */
norma_vec3_view made_view(fuzz_bytes *bytes, size_t count, void **block);

typedef struct made_options {
    norma_options options;
    fuzz_allocator allocator;
    norma_edges edges;
} made_options;
/* Any options, also wrong ones now and then; reasons NULL. */
void made_options_take(fuzz_bytes *bytes, made_options *made);
#endif
