/* png_memory.c: libpng's setjmp, longjmp and callbacks, for all who read or write PNG. */
#include "io/image/png_memory.h"
#include <setjmp.h>
#include <string.h>

/* ---- errors: libpng's own functions would print */

static void fail(png_structp png, png_const_charp message) {
    (void)message;
    png_longjmp(png, 1);
}
static void ignore(png_structp png, png_const_charp message) { (void)png, (void)message; }

void norma_png_give_up(png_structp png, image_result result) {
    ((png_source *)png_get_io_ptr(png))->result = result;
    png_error(png, "given up");
}

/* ---- reading */

static void read_bytes(png_structp png, png_bytep out, png_size_t size) {
    png_source *source = png_get_io_ptr(png);
    if (size > source->size - source->at) png_error(png, "cut off");
    memcpy(out, source->bytes + source->at, size);
    source->at += size;
}

image_result norma_png_read(void *job, void (*read)(png_structp png, png_infop info, void *job)) {
    png_source *source = job;
    png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, NULL, fail, ignore);
    png_infop info = png ? png_create_info_struct(png) : NULL;
    if (!info) source->result = IMAGE_MEMORY;
    if (!info || setjmp(png_jmpbuf(png))) {
        if (!source->result) source->result = IMAGE_BROKEN;
    } else {
        png_set_user_limits(png, IMAGE_MOST_SIDE, IMAGE_MOST_SIDE);
        png_set_read_fn(png, source, read_bytes);
        png_read_info(png, info);
        read(png, info, job);
    }
    png_destroy_read_struct(&png, &info, NULL);
    return source->result;
}

/* ---- writing */

static void append(png_structp png, png_bytep bytes, png_size_t size) {
    growing_bytes *out = png_get_io_ptr(png);
    norma_io_append(out, bytes, size);
    if (out->failed) png_error(png, "out of memory");
}
static void flush(png_structp png) { (void)png; }

image_result norma_png_write(growing_bytes *out,
    void (*write)(png_structp png, png_infop info, const void *job), const void *job) {
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, NULL, fail, ignore);
    png_infop info = png ? png_create_info_struct(png) : NULL;
    if (!info || setjmp(png_jmpbuf(png))) {
        png_destroy_write_struct(&png, &info);
        return IMAGE_MEMORY;
    }
    png_set_write_fn(png, out, append, flush);
    write(png, info, job);
    png_destroy_write_struct(&png, &info);
    return IMAGE_OK;
}
