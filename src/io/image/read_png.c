/* read_png.c: PNG by libpng: any depth and kind as eight bits a channel, without gamma or colour
 * profile, as normals are numbers. Interlaced ones are held whole. */
#include "io/image/image.h"
#include <png.h>
#include <setjmp.h>
#include <stdlib.h>
#include <string.h>

typedef struct png_job {
    const unsigned char *bytes;
    size_t size, at;
    const image_sink *sink;
    size_t width, height;
    image_result result;
    uint8_t *pixels; /* of a row, or of all where it is interlaced */
} png_job;

static void read_bytes(png_structp png, png_bytep out, png_size_t size) {
    png_job *job = png_get_io_ptr(png);
    if (size > job->size - job->at) png_error(png, "cut off");
    memcpy(out, job->bytes + job->at, size);
    job->at += size;
}

static void fail(png_structp png, png_const_charp message) {
    (void)message;
    png_longjmp(png, 1);
}
static void ignore(png_structp png, png_const_charp message) { (void)png, (void)message; }

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

static void give_up(png_structp png, png_job *job, image_result result) {
    job->result = result;
    png_error(png, "given up");
}

static void read_header(png_structp png, png_infop info, png_job *job) {
    png_set_user_limits(png, IMAGE_MOST_SIDE, IMAGE_MOST_SIDE);
    png_set_read_fn(png, job, read_bytes);
    png_read_info(png, info);
    job->width = png_get_image_width(png, info);
    job->height = png_get_image_height(png, info);
    if (!norma_image_may_decode(job->size, png_get_rowbytes(png, info) * job->height))
        give_up(png, job, IMAGE_TOO_LARGE);
    expand(png, info, job->sink->channels);
    if (png_get_rowbytes(png, info) != (size_t)job->sink->channels * job->width)
        give_up(png, job, IMAGE_BROKEN);
}

static void read_rows(png_structp png, png_job *job) {
    for (size_t y = 0; y < job->height; ++y) {
        png_read_row(png, job->pixels, NULL);
        job->sink->row(job->sink->user, y, job->pixels);
    }
}

static void read_passes(png_structp png, png_job *job, int passes) {
    const size_t stride = (size_t)job->sink->channels * job->width;
    for (int pass = 0; pass < passes; ++pass)
        for (size_t y = 0; y < job->height; ++y) png_read_row(png, job->pixels + y * stride, NULL);
    for (size_t y = 0; y < job->height; ++y)
        job->sink->row(job->sink->user, y, job->pixels + y * stride);
}

static void read_pixels(png_structp png, png_infop info, png_job *job) {
    const int interlaced = png_get_interlace_type(png, info) != PNG_INTERLACE_NONE;
    const size_t stride = (size_t)job->sink->channels * job->width;
    if (interlaced && !norma_image_may_hold(job->size, stride * job->height))
        give_up(png, job, IMAGE_TOO_LARGE);
    job->pixels = malloc(stride * (interlaced ? job->height : 1));
    if (!job->pixels || !job->sink->begin(job->sink->user, job->width, job->height))
        give_up(png, job, IMAGE_MEMORY);
    if (interlaced)
        read_passes(png, job, 7);
    else
        read_rows(png, job);
}

static void read_png(png_job *job) {
    png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, NULL, fail, ignore);
    png_infop info = png ? png_create_info_struct(png) : NULL;
    if (!info) job->result = IMAGE_MEMORY;
    if (!info || setjmp(png_jmpbuf(png))) {
        if (!job->result) job->result = IMAGE_BROKEN;
        png_destroy_read_struct(&png, &info, NULL);
        return;
    }
    read_header(png, info, job);
    read_pixels(png, info, job);
    png_destroy_read_struct(&png, &info, NULL);
}

image_result norma_image_read_png(const unsigned char *bytes, size_t size, const image_sink *sink) {
    png_job job = {.bytes = bytes, .size = size, .sink = sink};
    read_png(&job);
    free(job.pixels);
    return job.result;
}
