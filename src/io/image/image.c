/* image.c: images by libpng and libjpeg: read row by row, and normal maps with their green channel
 * inverted. */
#include "io/image/image.h"
#include <stdio.h>

#include <jerror.h>
#include <jpeglib.h>
#include <png.h>
#include <setjmp.h>
#include <stdlib.h>
#include <string.h>

enum { IMAGE_MOST_SIDE = 1 << 14 };

typedef struct image_raster { /* an image as PNG stores it: rows of samples, high bytes first */
    size_t width, height, stride;
    int depth, color_type, interlace; /* as in IHDR */
    int is_srgb;           /* it says so; four samples a pixel, of which RGB leaves the last out */
    unsigned char *pixels; /* the caller's to free */
} image_raster;

/* A header may say that an image is larger than memory, and a deflated byte can become a thousand.
 * Whether a file of size bytes may have so many bytes of an image decoded; held at once. */
static int image_may_decode(size_t size, size_t bytes) {
    return bytes <= ((size_t)1 << 26) + 128 * size;
}
static int image_may_hold(size_t size, size_t bytes) {
    return bytes <= ((size_t)1 << 20) + 256 * size;
}

typedef struct png_source {
    const unsigned char *bytes;
    size_t size, at;
    image_result result;
} png_source;

/* ---- PNG by libpng. Errors end in setjmp; its own functions would print them */

static void fail_png(png_structp png, png_const_charp message) {
    (void)message;
    png_longjmp(png, 1);
}
static void ignore(png_structp png, png_const_charp message) { (void)png, (void)message; }

static void png_give_up(png_structp png, image_result result) {
    ((png_source *)png_get_io_ptr(png))->result = result;
    png_error(png, "given up");
}

/* ---- reading */

static void image_read_bytes(png_structp png, png_bytep out, png_size_t size) {
    png_source *source = png_get_io_ptr(png);
    if (size > source->size - source->at) png_error(png, "cut off");
    memcpy(out, source->bytes + source->at, size);
    source->at += size;
}

/* Libpng's own allocations: those that fail are no fault of the file. */
static png_voidp allocate_for_png(png_structp png, png_alloc_size_t size) {
    void *block = malloc(size);
    if (!block) ((png_source *)png_get_mem_ptr(png))->result = IMAGE_MEMORY;
    return block;
}
static void free_of_png(png_structp png, png_voidp block) {
    (void)png;
    free(block);
}

/* Opens the image, reads its header and calls read, which may give up at any time. job begins with
 * a png_source; what read allocates is kept there. */
static image_result png_read(void *job, void (*read)(png_structp png, png_infop info, void *job)) {
    png_source *source = job;
    png_structp png = png_create_read_struct_2(
        PNG_LIBPNG_VER_STRING, NULL, fail_png, ignore, source, allocate_for_png, free_of_png);
    png_infop info = png ? png_create_info_struct(png) : NULL;
    if (!info) source->result = IMAGE_MEMORY;
    if (!info || setjmp(png_jmpbuf(png))) {
        if (!source->result) source->result = IMAGE_BROKEN;
    } else {
        png_set_user_limits(png, IMAGE_MOST_SIDE, IMAGE_MOST_SIDE);
        png_set_read_fn(png, source, image_read_bytes);
        png_read_info(png, info);
        read(png, info, job);
    }
    png_destroy_read_struct(&png, &info, NULL);
    return source->result;
}

/* ---- writing */

static void image_append(png_structp png, png_bytep bytes, png_size_t size) {
    growing_bytes *out = png_get_io_ptr(png);
    norma_io_append(out, bytes, size);
    if (out->failed) png_error(png, "out of memory");
}
static void flush(png_structp png) { (void)png; }

static image_raster raster_of(unsigned char *pixels, size_t width, size_t height, int color_type) {
    return (image_raster){.width = width,
        .height = height,
        .stride = (color_type == PNG_COLOR_TYPE_RGB ? 3 : 4) * width,
        .depth = 8,
        .color_type = color_type,
        .interlace = PNG_INTERLACE_NONE,
        .pixels = pixels};
}

static void image_write_rows(png_structp png, png_infop info, const image_raster *r) {
    png_set_IHDR(png, info, (png_uint_32)r->width, (png_uint_32)r->height, r->depth, r->color_type,
        r->interlace, PNG_COMPRESSION_TYPE_BASE, PNG_FILTER_TYPE_BASE);
    if (r->is_srgb) {
        png_set_filter(
            png, PNG_FILTER_TYPE_BASE, PNG_FILTER_SUB); /* even surfaces: as small as with a choice
                                                           for each row, in less time */
        png_set_sRGB_gAMA_and_cHRM(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
    }
    png_write_info(png, info);
    if (r->is_srgb && r->color_type == PNG_COLOR_TYPE_RGB) png_set_filler(png, 0, PNG_FILLER_AFTER);
    for (int passes = png_set_interlace_handling(png); passes > 0; --passes)
        for (size_t y = 0; y < r->height; ++y) png_write_row(png, r->pixels + y * r->stride);
    png_write_end(png, info);
}

/* Samples without a word beside them, unless they are sRGB. The only failure is IMAGE_MEMORY. */
static image_result image_write_png(const image_raster *raster, growing_bytes *out) {
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, NULL, fail_png, ignore);
    png_infop info = png ? png_create_info_struct(png) : NULL;
    if (!info || setjmp(png_jmpbuf(png))) {
        png_destroy_write_struct(&png, &info);
        return IMAGE_MEMORY;
    }
    png_set_write_fn(png, out, image_append, flush);
    image_write_rows(png, info, raster);
    png_destroy_write_struct(&png, &info);
    return IMAGE_OK;
}

/* ---- PNG by libpng: any depth and kind as eight bits a channel, without gamma or colour
 * profile, as normals are numbers. Interlaced ones are held whole. */

typedef struct png_reading {
    png_source source;
    const image_sink *sink;
    size_t width, height;
    uint8_t *pixels; /* of a row, or of all where it is interlaced */
} png_reading;

static void expand(png_structp png, png_infop info, int channels) {
    png_set_expand(png);
    png_set_scale_16(png);
    png_set_gray_to_rgb(png);
    if (channels == 4)
        png_set_filler(png, 255, PNG_FILLER_AFTER);
    else
        png_set_strip_alpha(png);
    png_set_interlace_handling(png);
    png_read_update_info(png, info);
}

static void read_header(png_structp png, png_infop info, png_reading *job) {
    job->width = png_get_image_width(png, info);
    job->height = png_get_image_height(png, info);
    if (!image_may_decode(job->source.size, png_get_rowbytes(png, info) * job->height))
        png_give_up(png, IMAGE_TOO_LARGE);
    expand(png, info, job->sink->channels);
    if (png_get_rowbytes(png, info) != (size_t)job->sink->channels * job->width)
        png_give_up(png, IMAGE_BROKEN);
}

static void read_png_rows(png_structp png, png_reading *job) {
    for (size_t y = 0; y < job->height; ++y) {
        png_read_row(png, job->pixels, NULL);
        job->sink->row(job->sink->user, y, job->pixels);
    }
}

static void read_passes(png_structp png, png_reading *job, int passes) {
    const size_t stride = (size_t)job->sink->channels * job->width;
    for (int pass = 0; pass < passes; ++pass)
        for (size_t y = 0; y < job->height; ++y) png_read_row(png, job->pixels + y * stride, NULL);
    for (size_t y = 0; y < job->height; ++y)
        job->sink->row(job->sink->user, y, job->pixels + y * stride);
}

static void read_pixels(png_structp png, png_infop info, png_reading *job) {
    const int interlaced = png_get_interlace_type(png, info) != PNG_INTERLACE_NONE;
    const size_t stride = (size_t)job->sink->channels * job->width;
    if (interlaced && !image_may_hold(job->source.size, stride * job->height))
        png_give_up(png, IMAGE_TOO_LARGE);
    job->pixels = malloc(stride * (interlaced ? job->height : 1));
    if (!job->pixels || !job->sink->begin(job->sink->user, job->width, job->height))
        png_give_up(png, IMAGE_MEMORY);
    if (interlaced)
        read_passes(png, job, 7);
    else
        read_png_rows(png, job);
}

static void read_png(png_structp png, png_infop info, void *job) {
    read_header(png, info, job);
    read_pixels(png, info, job);
}

static image_result image_read_png(
    const unsigned char *bytes, size_t size, const image_sink *sink) {
    png_reading job = {.source = {.bytes = bytes, .size = size}, .sink = sink};
    const image_result result = png_read(&job, read_png);
    free(job.pixels);
    return result;
}

/* ---- JPEG by libjpeg. Progressive ones are held whole by libjpeg itself. */

typedef struct jpeg_job {
    struct jpeg_error_mgr manager; /* first: libjpeg gives its address back */
    jmp_buf back;
    const image_sink *sink;
    size_t size;
    image_result result;
    uint8_t *row, *with_alpha;
} jpeg_job;

static void fail_jpeg(j_common_ptr jpeg) {
    jpeg_job *job = (jpeg_job *)(void *)jpeg->err;
    if (!job->result) job->result = IMAGE_BROKEN;
    longjmp(job->back, 1);
}
static void say_nothing(j_common_ptr jpeg) { (void)jpeg; }

static void image_give_up(struct jpeg_decompress_struct *jpeg, jpeg_job *job, image_result result) {
    job->result = result;
    fail_jpeg((j_common_ptr)jpeg);
}

/* Where data ends too early or is damaged libjpeg makes up the rest, with a warning. */
static void refuse_made_up(j_common_ptr jpeg, int level) {
    const int code = jpeg->err->msg_code;
    if (level < 0 &&
        (code == JWRN_JPEG_EOF || code == JWRN_HIT_MARKER || code == JWRN_HUFF_BAD_CODE))
        fail_jpeg(jpeg);
}

static void begin_jpeg(struct jpeg_decompress_struct *jpeg, jpeg_job *job) {
    jpeg_read_header(jpeg, TRUE);
    if (jpeg->jpeg_color_space == JCS_CMYK || jpeg->jpeg_color_space == JCS_YCCK)
        image_give_up(jpeg, job, IMAGE_CMYK);
    const size_t width = jpeg->image_width, height = jpeg->image_height;
    if (width > IMAGE_MOST_SIDE || height > IMAGE_MOST_SIDE ||
        !image_may_decode(job->size, 3 * width * height) ||
        (jpeg_has_multiple_scans(jpeg) && !image_may_hold(job->size, 6 * width * height)))
        image_give_up(jpeg, job, IMAGE_TOO_LARGE);
    jpeg->out_color_space = JCS_RGB;
    jpeg->dct_method = JDCT_ISLOW;
    jpeg_start_decompress(jpeg);
    job->row = malloc(3 * width);
    job->with_alpha = malloc(4 * width);
    if (!job->row || !job->with_alpha || !job->sink->begin(job->sink->user, width, height))
        image_give_up(jpeg, job, IMAGE_MEMORY);
}

static const uint8_t *add_alpha(jpeg_job *job, size_t width) {
    for (size_t x = 0; x < width; ++x) {
        memcpy(job->with_alpha + 4 * x, job->row + 3 * x, 3);
        job->with_alpha[4 * x + 3] = 255;
    }
    return job->with_alpha;
}

static void read_jpeg_rows(struct jpeg_decompress_struct *jpeg, jpeg_job *job) {
    while (jpeg->output_scanline < jpeg->output_height) {
        const size_t y = jpeg->output_scanline;
        JSAMPROW rows[1] = {job->row};
        jpeg_read_scanlines(jpeg, rows, 1);
        job->sink->row(job->sink->user, y,
            job->sink->channels == 4 ? add_alpha(job, jpeg->output_width) : job->row);
    }
}

static void read_jpeg(const unsigned char *bytes, jpeg_job *job) {
    struct jpeg_decompress_struct jpeg = {0};
    jpeg.err = jpeg_std_error(&job->manager);
    job->manager.error_exit = fail_jpeg;
    job->manager.emit_message = refuse_made_up;
    job->manager.output_message = say_nothing;
    if (setjmp(job->back)) {
        jpeg_destroy_decompress(&jpeg);
        return;
    }
    jpeg_create_decompress(&jpeg);
    jpeg_mem_src(&jpeg, bytes, (unsigned long)job->size);
    begin_jpeg(&jpeg, job);
    read_jpeg_rows(&jpeg, job);
    jpeg_destroy_decompress(&jpeg);
}

static image_result image_read_jpeg(
    const unsigned char *bytes, size_t size, const image_sink *sink) {
    jpeg_job job = {.sink = sink, .size = size};
    read_jpeg(bytes, &job);
    free(job.row);
    free(job.with_alpha);
    return job.result;
}

/* ---- A PNG with its green channel inverted. The pixels alone are encoded anew, at the same
 * depth, kind and interlacing; of a palette its entries change and the pixels stay. Every other
 * chunk keeps its bytes, except those that PNG asks an editor to drop: unknown ones that are not
 * safe to copy, such as the frames of an animation (PNG 3rd edition, 14.2). */

enum { SIGNATURE = 8, CHUNK = 12 }; /* a chunk: length, name and checksum around its data */

typedef struct png_turning {
    png_source source;
    image_raster raster;
} png_turning;

/* ---- reading, as stored */

static void read_raster(png_structp png, png_infop info, void *user) {
    png_turning *job = user;
    image_raster *r = &job->raster;
    r->width = png_get_image_width(png, info);
    r->height = png_get_image_height(png, info);
    r->stride = png_get_rowbytes(png, info);
    r->depth = png_get_bit_depth(png, info);
    r->color_type = png_get_color_type(png, info);
    r->interlace = png_get_interlace_type(png, info);
    if (!image_may_decode(job->source.size, r->stride * r->height))
        png_give_up(png, IMAGE_TOO_LARGE);
    r->pixels = malloc(r->stride * r->height);
    if (!r->pixels) png_give_up(png, IMAGE_MEMORY);
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
static int image_is_turned(const unsigned char *chunk, int color_type) {
    const size_t length = number_at(chunk);
    return color_type == PNG_COLOR_TYPE_PALETTE
               ? is(chunk, "PLTE") && length <= 768
               : is(chunk, "tRNS") && length == 6 && color_type == PNG_COLOR_TYPE_RGB;
}

static int image_is_kept(const unsigned char *chunk) {
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
static void add_chunks(const png_turning *job, const growing_bytes *encoded, growing_bytes *out) {
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
        } else if (image_is_turned(chunk, job->raster.color_type)) {
            add_turned(out, chunk, job->raster.depth);
        } else if (image_is_kept(chunk)) {
            norma_io_append(out, chunk, CHUNK + number_at(chunk));
        }
    }
    norma_io_append(out, end, sizeof end);
}

static image_result image_turn(png_turning *job, growing_bytes *out) {
    growing_bytes encoded = {0};
    const int type = job->raster.color_type, has_palette = type == PNG_COLOR_TYPE_PALETTE;
    if (!has_palette && !(type & PNG_COLOR_MASK_COLOR)) return IMAGE_GREY;
    image_result result = IMAGE_OK;
    if (!has_palette) {
        turn_pixels(&job->raster);
        result = image_write_png(&job->raster, &encoded);
    }
    if (!result) add_chunks(job, has_palette ? NULL : &encoded, out);
    free(encoded.data);
    return result || !out->failed ? result : IMAGE_MEMORY;
}

static image_result image_turn_png(const unsigned char *bytes, size_t size, growing_bytes *out) {
    png_turning job = {.source = {.bytes = bytes, .size = size}};
    image_result result = png_read(&job, read_raster);
    if (!result) result = image_turn(&job, out);
    free(job.raster.pixels);
    return result;
}

/* ---- A JPEG with its green channel inverted, as a PNG: encoding it as a JPEG once more
 * would lose something. */

static int begin_turned(void *user, size_t width, size_t height) {
    image_raster *r = user;
    *r = raster_of(malloc(3 * width * height), width, height, PNG_COLOR_TYPE_RGB);
    return r->pixels != NULL;
}

static void image_keep_row(void *user, size_t y, const uint8_t *pixels) {
    const image_raster *r = user;
    unsigned char *out = r->pixels + y * r->stride;
    for (size_t i = 0; i < r->stride; ++i)
        out[i] = i % 3 == 1 ? (unsigned char)(255 - pixels[i]) : pixels[i];
}

static image_result image_turn_jpeg(const unsigned char *bytes, size_t size, growing_bytes *out) {
    image_raster raster = {.pixels = NULL};
    const image_sink sink = {3, begin_turned, image_keep_row, &raster};
    image_result result = image_read_jpeg(bytes, size, &sink);
    if (!result) result = image_write_png(&raster, out);
    free(raster.pixels);
    return result;
}

/* ---- Which kind of image it is, by its first bytes. */

image_result norma_image_write(
    const uint8_t *pixels, size_t width, size_t height, growing_bytes *out) {
    const image_raster raster =
        raster_of((unsigned char *)pixels, width, height, PNG_COLOR_TYPE_RGB);
    return image_write_png(&raster, out);
}

image_result norma_image_write_srgb(
    const uint8_t *pixels, size_t width, size_t height, growing_bytes *out) {
    size_t opaque = 0;
    image_raster raster =
        raster_of((unsigned char *)pixels, width, height, PNG_COLOR_TYPE_RGB_ALPHA);
    raster.is_srgb = 1;
    while (opaque < width * height && pixels[4 * opaque + 3] == 255) ++opaque;
    if (opaque == width * height) raster.color_type = PNG_COLOR_TYPE_RGB;
    return image_write_png(&raster, out);
}

int norma_image_is_png(const unsigned char *bytes, size_t size) {
    static const unsigned char start[4] = {0x89, 'P', 'N', 'G'};
    return size > sizeof start && memcmp(bytes, start, sizeof start) == 0;
}

static int is_jpeg(const unsigned char *bytes, size_t size) {
    static const unsigned char start[3] = {0xFF, 0xD8, 0xFF};
    return size > sizeof start && memcmp(bytes, start, sizeof start) == 0;
}

image_result norma_image_read(const unsigned char *bytes, size_t size, const image_sink *sink) {
    return norma_image_is_png(bytes, size) ? image_read_png(bytes, size, sink)
           : is_jpeg(bytes, size)          ? image_read_jpeg(bytes, size, sink)
                                           : IMAGE_UNKNOWN;
}

image_result norma_image_turn_green(const unsigned char *bytes, size_t size, growing_bytes *out) {
    return norma_image_is_png(bytes, size) ? image_turn_png(bytes, size, out)
           : is_jpeg(bytes, size)          ? image_turn_jpeg(bytes, size, out)
                                           : IMAGE_UNKNOWN;
}
