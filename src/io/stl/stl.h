/* stl.h: what the files of the STL reader and writer share. An STL file is a list of facets, each a
 * normal and three vertices, as text or binary. */
#ifndef NORMA_IO_STL_H
#define NORMA_IO_STL_H
#include "io/format/format.h"

enum { STL_HEADER = 84, STL_FACET = 50, STL_NORMAL = 12, STL_VERTICES = 36 };

typedef struct stl_state {
    const unsigned char *bytes; /* the document's */
    size_t size;
    int binary;
    size_t facets;
    size_t tail;     /* binary: where bytes begin that follow the last facet; 0: none */
    char *name;      /* of the first solid */
    int many_digits; /* text: some number of a vertex has more digits than a float */
    void *positions; /* nine numbers a facet, decoded on demand: floats, in text doubles */
    float *stored;   /* normals as they are in the file, decoded on demand */
    /* Changes not yet in the bytes; NULL: none. */
    float *normals;   /* three for each facet */
    double *vertices; /* nine for each facet */
} stl_state;

/* stl_facets.c */
norma_document_result norma_stl_read_text(
    norma_document *document, norma_document_error *error); /* facets and name */
norma_document_result norma_stl_decode_text(norma_document *document, norma_document_error *error);
norma_document_result norma_stl_write_text(
    norma_document *document, norma_sink *sink, norma_document_error *error);

norma_document_result norma_stl_edit_text(norma_document *document, const norma_mesh_edit *edit,
    norma_sink *sink, norma_document_error *error);
void norma_stl_edit_binary(const stl_state *state, const norma_mesh_edit *edit, norma_sink *sink);

/* Facets are flat. */
norma_document_result norma_stl_check_shading(const norma_document *document,
    const norma_compute_options *options, norma_document_error *error);
int norma_stl_is_binary(const stl_state *state);
norma_document_result norma_stl_read_binary(norma_document *document, norma_document_error *error);
norma_document_result norma_stl_decode_binary(
    norma_document *document, norma_document_error *error);
void norma_stl_load(const stl_state *state, size_t facet, float normal[3],
    float vertices[9]); /* each may be NULL */
/* Stores the normals of facets from first on; the sign of zeros stays. Whether a byte changed. */
int norma_stl_replace_normals(
    unsigned char *bytes, size_t first, size_t count, const float *normals);
norma_document_result norma_stl_write_binary(
    norma_document *document, norma_sink *sink, norma_document_error *error);
#endif
