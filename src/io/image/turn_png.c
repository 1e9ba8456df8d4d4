/* turn_png.c: a PNG with its green channel inverted. The pixels alone are encoded anew, at the same
 * depth, kind and interlacing; of a palette its entries change and the pixels stay. Every other
 * chunk keeps its bytes, except those that PNG asks an editor to drop: unknown ones that are not
 * safe to copy, such as the frames of an animation (PNG 3rd edition, 14.2). */
#include "io/image/png_memory.h"
#include <stdlib.h>
#include <string.h>

enum { SIGNATURE = 8, CHUNK = 12 }; /* a chunk: length, name and checksum around its data */

typedef struct png_job {
    png_source source;
    image_raster raster;
} png_job;

/* ---- reading, as stored */

static void read_raster(png_structp png, png_infop info, void *user) {
    png_job *job = user;
    image_raster *r = &job->raster;
    r->width = png_get_image_width(png, info);
    r->height = png_get_image_height(png, info);
    r->stride = png_get_rowbytes(png, info);
    r->depth = png_get_bit_depth(png, info);
    r->color_type = png_get_color_type(png, info);
    r->interlace = png_get_interlace_type(png, info);
    if (!norma_image_may_decode(job->source.size, r->stride * r->height))
        norma_png_give_up(png, IMAGE_TOO_LARGE);
    r->pixels = malloc(r->stride * r->height);
    if (!r->pixels) norma_png_give_up(png, IMAGE_MEMORY);
    for (int passes = png_set_interlace_handling(png); passes > 0; --passes)
        for (size_t y = 0; y < r->height; ++y) png_read_row(png, r->pixels + y * r->stride, NULL);
}

/* Inverting each byte of a sample inverts the sample. */
static void turn_pixels(const image_raster *r) {
    const size_t sample = (size_t)r->depth / 8,
                 pixel = (r->color_type == PNG_COLOR_TYPE_RGB_ALPHA ? 4 : 3) * sample;
    for (size_t y = 0; y < r->height; ++y)
        for (size_t x = 0; x < r->width; ++x)
            for (size_t k = 0; k < sample; ++k)
                r->pixels[y * r->stride + x * pixel + sample + k] ^= 0xFF;
}

/* ---- chunks */

static size_t number_at(const unsigned char *at) {
    return (size_t)at[0] << 24 | (size_t)at[1] << 16 | (size_t)at[2] << 8 | at[3];
}

static int is(const unsigned char *chunk, const char *name) {
    return memcmp(chunk + 4, name, 4) == 0;
}

/* ISO 3309, as PNG asks for it. */
static uint32_t checksum(const unsigned char *bytes, size_t size) {
    uint32_t crc = 0xFFFFFFFF;
    for (size_t i = 0; i < size; ++i) {
        crc ^= bytes[i];
        for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (crc & 1 ? 0xEDB88320 : 0);
    }
    return ~crc;
}

/* A chunk of at most 256 colours, every third byte from the second on inverted; or one colour of
 * 16 bits each, of a smaller depth its low byte. */
static void add_turned(growing_bytes *out, const unsigned char *chunk, int depth) {
    unsigned char copy[CHUNK + 768];
    const size_t length = number_at(chunk);
    memcpy(copy, chunk, CHUNK + length);
    if (is(chunk, "PLTE"))
        for (size_t i = 1; i < length; i += 3) copy[8 + i] ^= 0xFF;
    else
        for (size_t i = depth == 16 ? 2 : 3; i < 4; ++i) copy[8 + i] ^= 0xFF;
    const uint32_t crc = checksum(copy + 4, 4 + length);
    for (size_t k = 0; k < 4; ++k) copy[8 + length + k] = (unsigned char)(crc >> (24 - 8 * k));
    norma_io_append(out, copy, CHUNK + length);
}

/* Whether it holds colours that pixels name, or that are transparent. */
static int is_turned(const unsigned char *chunk, int color_type) {
    const size_t length = number_at(chunk);
    return color_type == PNG_COLOR_TYPE_PALETTE
               ? is(chunk, "PLTE") && length <= 768
               : is(chunk, "tRNS") && length == 6 && color_type == PNG_COLOR_TYPE_RGB;
}

static int is_kept(const unsigned char *chunk) {
    static const char *const known[] = {"cHRM", "gAMA", "iCCP", "sBIT", "sRGB", "cICP", "bKGD",
        "mDCV", "cLLI", "hIST", "tRNS", "sPLT", "tIME"};
    const int critical = !(chunk[4] & 0x20), safe_to_copy = chunk[7] & 0x20;
    int kept = critical || safe_to_copy;
    for (size_t i = 0; i < sizeof known / sizeof *known; ++i) kept |= is(chunk, known[i]);
    return kept;
}

/* The chunk at an offset, or NULL where the bytes end before it does. */
static const unsigned char *chunk_at(const unsigned char *bytes, size_t size, size_t at) {
    return size - at >= CHUNK && number_at(bytes + at) <= size - at - CHUNK ? bytes + at : NULL;
}

static void add_pixels(growing_bytes *out, const growing_bytes *encoded) {
    const unsigned char *bytes = (const unsigned char *)encoded->data, *chunk;
    for (size_t at = SIGNATURE; (chunk = chunk_at(bytes, encoded->size, at)) != NULL;
         at += CHUNK + number_at(chunk))
        if (is(chunk, "IDAT")) norma_io_append(out, chunk, CHUNK + number_at(chunk));
}

/* encoded: the pixels as a PNG of their own; NULL: they stay. One that was cut off behind its
 * pixels gets its end. */
static void add_chunks(const png_job *job, const growing_bytes *encoded, growing_bytes *out) {
    static const unsigned char end[CHUNK] = {
        0, 0, 0, 0, 'I', 'E', 'N', 'D', 0xAE, 0x42, 0x60, 0x82};
    const unsigned char *chunk;
    int has_pixels = 0;
    norma_io_append(out, job->source.bytes, SIGNATURE);
    for (size_t at = SIGNATURE; (chunk = chunk_at(job->source.bytes, job->source.size, at)) != NULL;
         at += CHUNK + number_at(chunk)) {
        if (is(chunk, "IEND")) break;
        if (is(chunk, "IDAT") && encoded) {
            if (!has_pixels) add_pixels(out, encoded);
            has_pixels = 1;
        } else if (is_turned(chunk, job->raster.color_type)) {
            add_turned(out, chunk, job->raster.depth);
        } else if (is_kept(chunk)) {
            norma_io_append(out, chunk, CHUNK + number_at(chunk));
        }
    }
    norma_io_append(out, end, sizeof end);
}

static image_result turn(png_job *job, growing_bytes *out) {
    growing_bytes encoded = {0};
    const int type = job->raster.color_type, has_palette = type == PNG_COLOR_TYPE_PALETTE;
    if (!has_palette && !(type & PNG_COLOR_MASK_COLOR)) return IMAGE_GREY;
    image_result result = IMAGE_OK;
    if (!has_palette) {
        turn_pixels(&job->raster);
        result = norma_image_write_png(&job->raster, &encoded);
    }
    if (!result) add_chunks(job, has_palette ? NULL : &encoded, out);
    free(encoded.data);
    return result || !out->failed ? result : IMAGE_MEMORY;
}

image_result norma_image_turn_png(const unsigned char *bytes, size_t size, growing_bytes *out) {
    png_job job = {.source = {.bytes = bytes, .size = size}};
    image_result result = norma_png_read(&job, read_raster);
    if (!result) result = turn(&job, out);
    free(job.raster.pixels);
    return result;
}
