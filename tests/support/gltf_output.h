/* gltf_output.h: a changed GLB as it was written: opened again, and its JSON to be looked into.
 * Each call fails the test where it cannot do its part. */
#ifndef NORMA_TESTS_GLTF_OUTPUT_H
#define NORMA_TESTS_GLTF_OUTPUT_H
#include <norma/document.h>
#include "document_bytes.h"
#include "gltf_asset.h"
#include "io/text/text.h"

typedef struct gltf_output {
    document_bytes bytes;
    norma_document *document;
    json json;
    char notes[1000]; /* of the document that was written, a line each */
} gltf_output;

/* Writes the document and closes it. */
gltf_output output_of(norma_document *document);
void output_free(gltf_output *output);
/* What the asset with rest, see asset_open, becomes under a matrix; NULL: the identity. */
gltf_output output_transformed(gltf_asset *a, const char *rest, int bake, const double *matrix);
/* Frees both. */
void output_finish(gltf_output *output, gltf_asset *a);

/* The text of a value: a path of members and elements, "nodes/0/mesh"; "" where it is not there.
 * Lasts until the next call. */
const char *output_text(const gltf_output *output, const char *path);
/* The same as a number, %ld in the path replaced; -1 where it is not there. */
long output_number(const gltf_output *output, const char *path, long number);
/* The bytes that an accessor's view begins with. */
const unsigned char *output_bytes(const gltf_output *output, long accessor);

norma_mesh_data output_mesh(const gltf_output *output, size_t mesh);
void assert_vector(
    const norma_vec3_view *view, size_t index, const double expected[3], double tolerance);
void assert_corners(const gltf_output *output, size_t mesh, const uint32_t *expected, size_t count);
#endif
