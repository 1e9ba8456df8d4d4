/* image.c: the images of materials: PNG (libpng) and JPEG (libjpeg) as RGBA, eight bits each. */
#include "render/fail.h"
#include <stdio.h> /* jpeglib.h needs it before */

#include <jpeglib.h>
#include <png.h>
#include <setjmp.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_SIDE = 1 << 14 }; /* a small file may say that it is larger than memory */

/* ---- PNG */

typedef struct reader {
    const uint8_t *bytes;
    size_t size, at;
} reader;

static void read_bytes(png_structp png, png_bytep out, png_size_t size) {
    reader *from = png_get_io_ptr(png);
    if (size > from->size - from->at) png_error(png, "cut off");
    memcpy(out, from->bytes + from->at, size);
    from->at += size;
}

static void fail_png(png_structp png, png_const_charp message) {
    (void)message;
    png_longjmp(png, 1);
}
static void ignore(png_structp png, png_const_charp message) { (void)png, (void)message; }

/* Whatever it holds, as four bytes a pixel. */
static void expand(png_structp png, png_infop info) {
    png_set_expand(png);
    png_set_scale_16(png);
    png_set_gray_to_rgb(png);
    png_set_filler(png, 255, PNG_FILLER_AFTER);
    png_set_interlace_handling(png);
    png_read_update_info(png, info);
}

static int decode_png(reader *from, render_picture *picture, png_bytepp *rows) {
    png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, NULL, fail_png, ignore);
    png_infop info = png ? png_create_info_struct(png) : NULL;
    if (!info || setjmp(png_jmpbuf(png))) {
        png_destroy_read_struct(&png, &info, NULL);
        return 0;
    }
    png_set_user_limits(png, MOST_SIDE, MOST_SIDE);
    png_set_read_fn(png, from, read_bytes);
    png_read_info(png, info);
    picture->width = png_get_image_width(png, info);
    picture->height = png_get_image_height(png, info);
    expand(png, info);
    if (png_get_rowbytes(png, info) != 4 * picture->width) png_error(png, "not four bytes");
    picture->pixels = malloc(4 * picture->width * picture->height);
    *rows = malloc(picture->height * sizeof **rows);
    if (!picture->pixels || !*rows) png_error(png, "out of memory");
    for (size_t y = 0; y < picture->height; ++y)
        (*rows)[y] = picture->pixels + 4 * y * picture->width;
    png_read_image(png, *rows);
    png_destroy_read_struct(&png, &info, NULL);
    return 1;
}

/* ---- JPEG */

typedef struct jpeg_failure {
    struct jpeg_error_mgr manager;
    jmp_buf back;
} jpeg_failure;

static void fail_jpeg(j_common_ptr jpeg) {
    jpeg_failure *failure = (jpeg_failure *)(void *)jpeg->err;
    longjmp(failure->back, 1);
}
static void say_nothing(j_common_ptr jpeg) { (void)jpeg; }

static void read_rows(struct jpeg_decompress_struct *jpeg, render_picture *picture, uint8_t *row) {
    while (jpeg->output_scanline < jpeg->output_height) {
        uint8_t *out = picture->pixels + 4 * picture->width * jpeg->output_scanline;
        JSAMPROW rows[1] = {row};
        jpeg_read_scanlines(jpeg, rows, 1);
        for (size_t x = 0; x < picture->width; ++x) {
            memcpy(out + 4 * x, row + 3 * x, 3);
            out[4 * x + 3] = 255;
        }
    }
}

static int decode_jpeg(const reader *from, render_picture *picture, uint8_t **row) {
    struct jpeg_decompress_struct jpeg;
    jpeg_failure failure;
    jpeg.err = jpeg_std_error(&failure.manager);
    failure.manager.error_exit = fail_jpeg;
    failure.manager.output_message = say_nothing;
    if (setjmp(failure.back)) {
        jpeg_destroy_decompress(&jpeg);
        return 0;
    }
    jpeg_create_decompress(&jpeg);
    jpeg_mem_src(&jpeg, from->bytes, (unsigned long)from->size);
    jpeg_read_header(&jpeg, TRUE);
    if (jpeg.image_width > MOST_SIDE || jpeg.image_height > MOST_SIDE)
        fail_jpeg((j_common_ptr)&jpeg);
    jpeg.out_color_space = JCS_RGB;
    jpeg_start_decompress(&jpeg);
    picture->width = jpeg.output_width;
    picture->height = jpeg.output_height;
    picture->pixels = malloc(4 * picture->width * picture->height);
    *row = malloc(3 * picture->width);
    if (!picture->pixels || !*row) fail_jpeg((j_common_ptr)&jpeg);
    read_rows(&jpeg, picture, *row);
    jpeg_finish_decompress(&jpeg);
    jpeg_destroy_decompress(&jpeg);
    return 1;
}

/* ---- either */

enum render_result render_image_decode(
    const uint8_t *bytes, size_t size, render_picture *picture, render_error *error) {
    static const uint8_t png[4] = {0x89, 'P', 'N', 'G'}, jpeg[3] = {0xFF, 0xD8, 0xFF};
    reader from = {bytes, size, 0};
    png_bytepp rows = NULL;
    uint8_t *row = NULL;
    int good = 0;
    *picture = (render_picture){0};
    if (size > sizeof png && memcmp(bytes, png, sizeof png) == 0)
        good = decode_png(&from, picture, &rows);
    else if (size > sizeof jpeg && memcmp(bytes, jpeg, sizeof jpeg) == 0)
        good = decode_jpeg(&from, picture, &row);
    else
        return render_fail(error, RENDER_ERROR_ARGUMENT, "an image that is neither PNG nor JPEG");
    free(rows);
    free(row);
    if (good) return RENDER_OK;
    render_picture_free(picture);
    return render_fail(error, RENDER_ERROR_ARGUMENT, "an image that cannot be decoded");
}
