/* turn_jpeg.c: a JPEG with its green channel inverted, as a PNG: encoding it as a JPEG once more
 * would lose something. */
#include "io/image/image.h"
#include <png.h>
#include <stdlib.h>

static int begin(void *user, size_t width, size_t height) {
    image_raster *r = user;
    *r = (image_raster){.width = width,
        .height = height,
        .stride = 3 * width,
        .depth = 8,
        .color_type = PNG_COLOR_TYPE_RGB,
        .interlace = PNG_INTERLACE_NONE,
        .pixels = malloc(3 * width * height)};
    return r->pixels != NULL;
}

static void keep_row(void *user, size_t y, const uint8_t *pixels) {
    const image_raster *r = user;
    unsigned char *out = r->pixels + y * r->stride;
    for (size_t i = 0; i < r->stride; ++i)
        out[i] = i % 3 == 1 ? (unsigned char)(255 - pixels[i]) : pixels[i];
}

image_result norma_image_turn_jpeg(const unsigned char *bytes, size_t size, growing_bytes *out) {
    image_raster raster = {.pixels = NULL};
    const image_sink sink = {3, begin, keep_row, &raster};
    image_result result = norma_image_read_jpeg(bytes, size, &sink);
    if (!result) result = norma_image_write_png(&raster, out);
    free(raster.pixels);
    return result;
}
