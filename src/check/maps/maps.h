/* maps.h: normal maps against the surface that they are for (N811, N812): their texels, those that
 * faces use, and what these say. */
#ifndef NORMA_CHECK_MAPS_H
#define NORMA_CHECK_MAPS_H
#include "check/findings/check_run.h"
#include "io/image/image.h"

/* An image, or of a large one a block of 4 x 4 texels out of each cell of 4 k x 4 k: neighbours
 * stay neighbours, and shares and slopes of a million texels say as much as those of all. */
enum { MAP_BLOCK = 4 };
typedef struct map_texels {
    size_t width, height; /* of the image */
    size_t step;          /* k; 1: all texels are kept */
    size_t columns, rows; /* kept */
    uint8_t *colors;      /* red, green, blue; row by row */
    size_t most;          /* how many may be kept, and as many rows painted for a mesh */
} map_texels;

/* For so many meshes: each looks at fewer texels where they are many. */
image_result norma_map_read(const norma_texture_info *map, size_t meshes, map_texels *texels);
void norma_map_free(map_texels *texels);

/* N811 and N812 of a mesh whose normal map was read. */
norma_result norma_check_map(
    check_mesh *m, const norma_texture_info *map, const map_texels *texels);
#endif
