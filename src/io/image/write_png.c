/* write_png.c: samples as a PNG by libpng, without a word beside them. */
#include "io/image/image.h"
#include <png.h>
#include <setjmp.h>

static void append(png_structp png, png_bytep bytes, png_size_t size) {
    norma_io_append(png_get_io_ptr(png), bytes, size);
}
static void flush(png_structp png) { (void)png; }

static void fail(png_structp png, png_const_charp message) {
    (void)message;
    png_longjmp(png, 1);
}
static void ignore(png_structp png, png_const_charp message) { (void)png, (void)message; }

static void write_rows(png_structp png, png_infop info, const image_raster *r) {
    png_set_IHDR(png, info, (png_uint_32)r->width, (png_uint_32)r->height, r->depth, r->color_type,
        r->interlace, PNG_COMPRESSION_TYPE_BASE, PNG_FILTER_TYPE_BASE);
    png_write_info(png, info);
    for (int passes = png_set_interlace_handling(png); passes > 0; --passes)
        for (size_t y = 0; y < r->height; ++y) png_write_row(png, r->pixels + y * r->stride);
    png_write_end(png, info);
}

/* All that can go wrong with good samples is that memory is out. */
image_result norma_image_write_png(const image_raster *raster, growing_bytes *out) {
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, NULL, fail, ignore);
    png_infop info = png ? png_create_info_struct(png) : NULL;
    if (!info || setjmp(png_jmpbuf(png))) {
        png_destroy_write_struct(&png, &info);
        return IMAGE_MEMORY;
    }
    png_set_write_fn(png, out, append, flush);
    write_rows(png, info, raster);
    png_destroy_write_struct(&png, &info);
    return out->failed ? IMAGE_MEMORY : IMAGE_OK;
}
