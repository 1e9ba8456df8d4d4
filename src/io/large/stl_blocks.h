/* stl_blocks.h: a binary STL read block by block. */
#ifndef NORMA_IO_LARGE_STL_H
#define NORMA_IO_LARGE_STL_H
#include "io/large/large_file.h"
#include "io/stl/stl.h"

enum { LARGE_FACETS = 1 << 14 };

typedef struct large_facets { /* as a file of its own: a header, then facets */
    unsigned char bytes[STL_HEADER + LARGE_FACETS * STL_FACET];
    float positions[9 * LARGE_FACETS], normals[3 * LARGE_FACETS];
    uint8_t reasons[LARGE_FACETS];
} large_facets;

typedef struct large_stl {
    large_file *file;
    stl_state *state; /* its bytes: those of the block */
    large_facets *block;
    size_t facets;
} large_stl;

/* UNSUPPORTED: text. To be closed in any case. */
norma_document_result norma_large_stl_open(large_file *file, large_stl *stl);
void norma_large_stl_close(large_stl *stl);
/* Facets from first on, at most LARGE_FACETS, into the block's bytes. */
norma_document_result norma_large_stl_read(large_stl *stl, size_t first, size_t count);
/* The block's positions, from its bytes. */
void norma_large_stl_positions(const large_stl *stl, size_t count);
#endif
