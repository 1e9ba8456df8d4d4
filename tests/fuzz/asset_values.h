/* asset_values.h: what a .gltf with its files says, read by other means than Norma's: jansson and
 * the glTF 2.0 specification. */
#ifndef NORMA_FUZZ_ASSET_VALUES_H
#define NORMA_FUZZ_ASSET_VALUES_H
#include <stdint.h>

typedef struct asset_values {
    int known;       /* the asset is there and keeps to the rules below */
    char why[160];   /* else: what is wrong */
    uint64_t places; /* of all corners in order: positions, texture coordinates, own attributes,
                        morph targets' positions: their bits */
    uint64_t all;    /* the same with normals and tangents */
} asset_values;

/* Views lie in buffers, buffers in files, accessors in views and aligned, indices below the number
 * of vertices, all attributes of a primitive as long as its positions, bounds of positions true. */
void fuzz_read_asset(const char *path, asset_values *values);
#endif
