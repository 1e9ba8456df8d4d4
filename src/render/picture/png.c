/* png.c: a picture as PNG bytes in memory. Its chunk sRGB says what the numbers mean. */
#include "io/image/png_memory.h"
#include "render/fail.h"
#include <stdlib.h>

static int is_opaque(const render_picture *picture) {
    for (size_t i = 0; i < picture->width * picture->height; ++i)
        if (picture->pixels[4 * i + 3] != 255) return 0;
    return 1;
}

static void write_picture(png_structp png, png_infop info, const void *job) {
    const render_picture *picture = job;
    const int opaque = is_opaque(picture);
    png_set_IHDR(png, info, (png_uint_32)picture->width, (png_uint_32)picture->height, 8,
        opaque ? PNG_COLOR_TYPE_RGB : PNG_COLOR_TYPE_RGB_ALPHA, PNG_INTERLACE_NONE,
        PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_filter(png, PNG_FILTER_TYPE_BASE,
        PNG_FILTER_SUB); /* even surfaces: as small as with a choice for each row, in less time */
    png_set_sRGB_gAMA_and_cHRM(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
    png_write_info(png, info);
    if (opaque) png_set_filler(png, 0, PNG_FILLER_AFTER);
    for (size_t y = 0; y < picture->height; ++y)
        png_write_row(png, picture->pixels + 4 * y * picture->width);
    png_write_end(png, info);
}

enum render_result render_png_encode(
    const render_picture *picture, render_png *out, render_error *error) {
    growing_bytes bytes = {0};
    const int failed = norma_png_write(&bytes, write_picture, picture) != IMAGE_OK;
    if (failed) {
        free(bytes.data);
        bytes = (growing_bytes){0};
    }
    *out = (render_png){(uint8_t *)bytes.data, bytes.size};
    return failed ? render_fail_memory(error) : RENDER_OK;
}
