/* picture.c: a picture in memory: freeing, comparing, and the two directions of sRGB. */
#include "render/picture/picture.h"
#include <math.h>
#include <stdlib.h>

void render_picture_free(render_picture *picture) {
    free(picture->pixels);
    *picture = (render_picture){0};
}

int render_picture_difference(const render_picture *picture, size_t ax, size_t ay, size_t bx,
    size_t by, size_t width, size_t height) {
    int largest = 0;
    for (size_t y = 0; y < height; ++y)
        for (size_t x = 0; x < width; ++x) {
            const uint8_t *a = picture->pixels + 4 * ((ay + y) * picture->width + ax + x),
                          *b = picture->pixels + 4 * ((by + y) * picture->width + bx + x);
            for (int k = 0; k < 3; ++k) {
                const int difference = abs((int)a[k] - (int)b[k]);
                largest = difference > largest ? difference : largest;
            }
        }
    return largest;
}

static double decoded(double c) { return c <= 0.04045 ? c / 12.92 : pow((c + 0.055) / 1.055, 2.4); }

void render_srgb_make(render_srgb *table) {
    for (int level = 0; level < 256; ++level)
        table->linear[level] = (uint16_t)(decoded(level / 255.0) * 65535 + 0.5);
    /* The level whose light is nearest: borders lie half way between the levels, as they are
     * encoded. */
    int level = 0;
    for (int light = 0; light < 65536; ++light) {
        while (level < 255 && light / 65535.0 > decoded((level + 0.5) / 255.0)) ++level;
        table->encoded[light] = (uint8_t)level;
    }
}
