/* read_png.c: PNG by libpng: any depth and kind as eight bits a channel, without gamma or colour
 * profile, as normals are numbers. Interlaced ones are held whole. */
#include "io/image/png_memory.h"
#include <stdlib.h>

typedef struct png_job {
    png_source source;
    const image_sink *sink;
    size_t width, height;
    uint8_t *pixels; /* of a row, or of all where it is interlaced */
} png_job;

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

static void read_header(png_structp png, png_infop info, png_job *job) {
    job->width = png_get_image_width(png, info);
    job->height = png_get_image_height(png, info);
    if (!norma_image_may_decode(job->source.size, png_get_rowbytes(png, info) * job->height))
        norma_png_give_up(png, IMAGE_TOO_LARGE);
    expand(png, info, job->sink->channels);
    if (png_get_rowbytes(png, info) != (size_t)job->sink->channels * job->width)
        norma_png_give_up(png, IMAGE_BROKEN);
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
    if (interlaced && !norma_image_may_hold(job->source.size, stride * job->height))
        norma_png_give_up(png, IMAGE_TOO_LARGE);
    job->pixels = malloc(stride * (interlaced ? job->height : 1));
    if (!job->pixels || !job->sink->begin(job->sink->user, job->width, job->height))
        norma_png_give_up(png, IMAGE_MEMORY);
    if (interlaced)
        read_passes(png, job, 7);
    else
        read_rows(png, job);
}

static void read_png(png_structp png, png_infop info, void *job) {
    read_header(png, info, job);
    read_pixels(png, info, job);
}

image_result norma_image_read_png(const unsigned char *bytes, size_t size, const image_sink *sink) {
    png_job job = {.source = {.bytes = bytes, .size = size}, .sink = sink};
    const image_result result = norma_png_read(&job, read_png);
    free(job.pixels);
    return result;
}
