/* write_png.c: samples as a PNG, without a word beside them. */
#include "io/image/png_memory.h"

static void write_rows(png_structp png, png_infop info, const void *raster) {
    const image_raster *r = raster;
    png_set_IHDR(png, info, (png_uint_32)r->width, (png_uint_32)r->height, r->depth, r->color_type,
        r->interlace, PNG_COMPRESSION_TYPE_BASE, PNG_FILTER_TYPE_BASE);
    png_write_info(png, info);
    for (int passes = png_set_interlace_handling(png); passes > 0; --passes)
        for (size_t y = 0; y < r->height; ++y) png_write_row(png, r->pixels + y * r->stride);
    png_write_end(png, info);
}

image_result norma_image_write_png(const image_raster *raster, growing_bytes *out) {
    return norma_png_write(out, write_rows, raster);
}
