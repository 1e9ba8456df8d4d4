/* maps.h: normal maps against the surface that they are for (N811, N812): their texels, those that
 * faces use, and what these say. */
#ifndef NORMA_CHECK_MAPS_H
#define NORMA_CHECK_MAPS_H
#include "check/findings/check_run.h"
#include "io/image/image.h"

/* ---- map_texels.c: an image, or of a large one a block of 4 x 4 texels out of each cell of
 * 4 k x 4 k: neighbours stay neighbours, and shares and slopes of a million texels say as much as
 * those of all. */

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

/* How many kept columns (rows) lie before x. */
static inline size_t norma_map_kept(const map_texels *texels, size_t x) {
    const size_t cell = MAP_BLOCK * texels->step, within = x % cell;
    return x / cell * MAP_BLOCK + (within < MAP_BLOCK ? within : MAP_BLOCK);
}
static inline int norma_map_keeps(const map_texels *texels, size_t x) {
    return x % (MAP_BLOCK * texels->step) < MAP_BLOCK;
}

/* ---- used_texels.c: which of them faces show */

typedef struct map_mask {
    uint64_t *bits; /* rows of words */
    size_t words;   /* in a row */
} map_mask;

/* 0: out of memory. */
int norma_map_mask(
    const check_mesh *m, const norma_texture_info *map, const map_texels *texels, map_mask *mask);
static inline int norma_map_used(const map_mask *mask, size_t column, size_t row) {
    return (int)(mask->bits[row * mask->words + column / 64] >> (column % 64) & 1);
}

/* ---- map_lengths.c: whether they are unit vectors; map_curl.c: whether they are slopes */

typedef struct map_lengths {
    size_t used, bad;
    uint8_t first[3]; /* of the used ones */
    int one_value;
} map_lengths;
void norma_map_lengths(const map_texels *texels, const map_mask *mask, map_lengths *lengths);

/* Of a height field's slopes the two mixed derivatives are equal. agreement: 1 where they are equal
 * everywhere, -1 where they are opposite, as turning the green channel makes them, and 0 where
 * they say nothing. Level 0 compares neighbouring texels, the others means of 4 x 4, 8 x 8, ... */
enum { MAP_LEVELS = 8 };
typedef struct map_curl {
    double agreement[MAP_LEVELS];
    size_t votes[MAP_LEVELS];
} map_curl;
int norma_map_curl(const map_texels *texels, const map_mask *mask, map_curl *curl); /* 0: memory */

/* ---- judge_map.c: N811 and N812 of a mesh whose normal map was read */
norma_result norma_check_map(
    check_mesh *m, const norma_texture_info *map, const map_texels *texels);
#endif
