/* gltf_asset.h: GLB files put together in memory: accessors one by one, the rest of the JSON as
 * text. Each call fails the test where it cannot do its part. */
#ifndef NORMA_TESTS_GLTF_ASSET_H
#define NORMA_TESTS_GLTF_ASSET_H
#include <norma/document.h>

typedef struct gltf_asset {
    unsigned char *bin, *glb;
    size_t bin_size;
    char *views, *accessors; /* JSON, comma-separated */
    int accessor_count, view_count;
} gltf_asset; /* zero-initialised */

/* Numbers of accessors; sixteen wide: matrices. */
int asset_floats(gltf_asset *a, const float *values, size_t count, int width);
int asset_uint16(gltf_asset *a, const uint16_t *values, size_t count);
/* Normalised, each element padded to four bytes. */
int asset_snorm8(gltf_asset *a, const float *values, size_t count, int width);
/* Of any component type, each element padded to four bytes; normalized: 1 is the type's largest
 * number. */
int asset_numbers(
    gltf_asset *a, const double *values, size_t count, int width, int component, int normalized);
/* A view of these bytes alone; members (", ..." or "") go into its JSON. Its number. */
int asset_view(gltf_asset *a, const void *bytes, size_t size, const char *members);
/* An accessor as it is written. Its number. */
int asset_accessor(gltf_asset *a, const char *json);

/* The file: rest is the root's JSON besides asset, buffers, bufferViews and accessors. */
norma_document *asset_open(gltf_asset *a, const char *rest, int lenient);
/* The same where opening must fail; the error's text lasts until the next call. */
const char *asset_refused(gltf_asset *a, const char *rest, int lenient);
void asset_bytes(gltf_asset *a, const char *rest, size_t *size); /* a->glb */
void asset_free(gltf_asset *a);
#endif
