/* map_texels.c: the texels of a normal map as far as they are looked at. */
#include "check/maps/maps.h"
#include <stdlib.h>
#include <string.h>

enum { MOST_TEXELS = 1 << 20, FEWEST_TEXELS = 1 << 12, OF_SMALL_FILE = 1 << 17 };

static int begin(void *user, size_t width, size_t height) {
    map_texels *texels = user;
    texels->width = width;
    texels->height = height;
    for (texels->step = 1;; ++texels->step) {
        texels->columns = norma_map_kept(texels, width);
        texels->rows = norma_map_kept(texels, height);
        if (texels->columns * texels->rows <= texels->most) break;
    }
    texels->colors = malloc(3 * texels->columns * texels->rows + 1);
    return texels->colors != NULL;
}

static void keep_row(void *user, size_t y, const uint8_t *pixels) {
    const map_texels *texels = user;
    if (!norma_map_keeps(texels, y)) return;
    uint8_t *out = texels->colors + 3 * texels->columns * norma_map_kept(texels, y);
    const size_t cell = texels->step == 1 ? texels->width : MAP_BLOCK * texels->step,
                 block = texels->step == 1 ? texels->width : MAP_BLOCK;
    for (size_t x = 0; x < texels->width; x += cell) {
        const size_t count = texels->width - x < block ? texels->width - x : block;
        memcpy(out, pixels + 3 * x, 3 * count);
        out += 3 * count;
    }
}

static size_t least(size_t a, size_t b) { return a < b ? a : b; }

/* A small file has a small image, or says the same thing everywhere. */
image_result norma_map_read(const norma_texture_info *map, size_t meshes, map_texels *texels) {
    const size_t share = 4 * (size_t)MOST_TEXELS / meshes;
    *texels = (map_texels){
        .most = least(MOST_TEXELS,
            least(OF_SMALL_FILE + 32 * map->size, share > FEWEST_TEXELS ? share : FEWEST_TEXELS))};
    const image_sink sink = {3, begin, keep_row, texels};
    const image_result result = norma_image_read(map->bytes, map->size, &sink);
    if (result) norma_map_free(texels);
    return result;
}

void norma_map_free(map_texels *texels) {
    free(texels->colors);
    texels->colors = NULL;
}
