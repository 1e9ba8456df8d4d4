/* map_lengths.c: whether the texels that are used are unit vectors, and whether they differ at
 * all. A channel of c is the number 2 c / 255 - 1. */
#include "check/maps/maps.h"
#include <string.h>

/* Longer or shorter than 1 by more than a tenth, or below the surface by more than rounding. */
static int is_bad(const uint8_t c[3]) {
    const int x = 2 * c[0] - 255, y = 2 * c[1] - 255, z = 2 * c[2] - 255,
              square = x * x + y * y + z * z;
    return z < -1 || square * 100 < 81 * 255 * 255 || square * 100 > 121 * 255 * 255;
}

static void add_row(const uint8_t *row, const uint64_t *bits, size_t columns, map_lengths *sum) {
    for (size_t x = 0; x < columns; ++x) {
        if (!bits[x / 64]) {
            x |= 63;
            continue;
        }
        const uint8_t *c = row + 3 * x;
        if (!(bits[x / 64] >> (x % 64) & 1)) continue;
        if (sum->used++ == 0) memcpy(sum->first, c, 3);
        sum->bad += (size_t)is_bad(c);
        sum->one_value &= memcmp(c, sum->first, 3) == 0;
    }
}

void norma_map_lengths(const map_texels *texels, const map_mask *mask, map_lengths *lengths) {
    *lengths = (map_lengths){.one_value = 1};
    for (size_t y = 0; y < texels->rows; ++y)
        add_row(texels->colors + 3 * texels->columns * y, mask->bits + y * mask->words,
            texels->columns, lengths);
}
