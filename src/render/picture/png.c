/* png.c: a picture as PNG bytes in memory (libpng). Its chunk sRGB says what the numbers mean. */
#include "render/fail.h"
#include <png.h>
#include <setjmp.h>
#include <stdlib.h>
#include <string.h>

static void write_bytes(png_structp png, png_bytep bytes, png_size_t size) {
    render_png *out = png_get_io_ptr(png);
    if (size > SIZE_MAX / 4 - out->size) png_error(png, "too large");
    if (out->size + size > out->capacity) {
        size_t capacity = 2 * (out->size + size) + 4096;
        uint8_t *larger = realloc(out->bytes, capacity);
        if (!larger) png_error(png, "out of memory");
        out->bytes = larger;
        out->capacity = capacity;
    }
    memcpy(out->bytes + out->size, bytes, size);
    out->size += size;
}

static void flush_nothing(png_structp png) { (void)png; }

/* libpng's own would print. */
static void fail(png_structp png, png_const_charp message) {
    (void)message;
    png_longjmp(png, 1);
}
static void ignore(png_structp png, png_const_charp message) { (void)png, (void)message; }

static int is_opaque(const render_picture *picture) {
    for (size_t i = 0; i < picture->width * picture->height; ++i)
        if (picture->pixels[4 * i + 3] != 255) return 0;
    return 1;
}

static void write_picture(png_structp png, png_infop info, const render_picture *picture) {
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
    *out = (render_png){0};
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, NULL, fail, ignore);
    png_infop info = png ? png_create_info_struct(png) : NULL;
    if (!info || setjmp(png_jmpbuf(png))) {
        png_destroy_write_struct(&png, &info);
        free(out->bytes);
        *out = (render_png){0};
        return render_fail_memory(error);
    }
    png_set_write_fn(png, out, write_bytes, flush_nothing);
    write_picture(png, info, picture);
    png_destroy_write_struct(&png, &info);
    return RENDER_OK;
}
