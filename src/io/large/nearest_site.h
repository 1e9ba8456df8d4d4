/* nearest_site.h: for elements without a normal, the nearest element that has one, among more than
 * memory holds. */
#ifndef NORMA_IO_LARGE_NEAREST_H
#define NORMA_IO_LARGE_NEAREST_H
#include "io/large/bits.h"
#include "io/large/large_file.h"

typedef struct large_sites {
    large_file *file;
    size_t count;              /* of elements */
    const large_bits *without; /* those that have no normal */
    int single;                /* positions are floats, else doubles */
    /* The positions of at most 8192 elements from first on, three numbers each. */
    norma_document_result (*positions)(void *context, size_t first, size_t count, void *out);
    void *context;
    uint32_t anchor; /* an element whose coordinate is the greatest; UINT32_MAX: none is needed */
    const norma_options *core;
} large_sites;

/* Hands visit each element without a normal, in ascending order, with its source; UINT32_MAX: no
 * element has a normal. */
typedef norma_document_result large_visit_source(void *context, uint32_t element, uint32_t source);
norma_document_result norma_large_visit_nearest(
    const large_sites *sites, large_visit_source *visit, void *context);
#endif
