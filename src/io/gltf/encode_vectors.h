/* encode_vectors.h: the elements of one accessor through a matrix, and back into an encoding. */
#ifndef NORMA_IO_GLTF_BAKE_VECTORS_H
#define NORMA_IO_GLTF_BAKE_VECTORS_H
#include "io/gltf/asset.h"

typedef struct bake_map { /* what carries one mesh */
    uint32_t id;          /* equal for equal matrices */
    double matrix[16];
    double normal[9];   /* sign(det) cof, times a power of two */
    double fallback[3]; /* unit: what becomes of normals that a singular matrix makes zero */
    int mirrored, rank;
    int turns; /* 0: directions stay as they are (translation, uniform scale) */
} bake_map;

typedef enum bake_role {
    BAKE_POSITIONS = 0,
    BAKE_NORMALS,
    BAKE_TANGENTS,
    BAKE_POSITION_DELTAS,
    BAKE_NORMAL_DELTAS,
    BAKE_TANGENT_DELTAS,
    BAKE_WINDING
} bake_role;

/* array->count elements of array->width numbers into values. base: the normals that tangents go
 * with, or that deltas of normals are added to, or the tangents that deltas of tangents are; NULL
 * where there are none. */
void norma_gltf_transform_vectors(bake_role role, const bake_map *map, const gltf_array *array,
    const gltf_array *base, double *values);

/* values in the encoding of the stored array where that can hold them (positions: exactly;
 * directions: as well as it ever does; their deltas: in range), else as floats. */
typedef enum bake_encoded { BAKE_ENCODED = 0, BAKE_NO_MEMORY, BAKE_TOO_LARGE } bake_encoded;
bake_encoded norma_gltf_encode(
    bake_role role, const gltf_array *stored, const double *values, gltf_data *data);
#endif
