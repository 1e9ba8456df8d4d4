/* read_jpeg.c: JPEG by libjpeg. Progressive ones are held whole by libjpeg itself. */
#include "io/image/image.h"
#include <stdio.h> /* jpeglib.h needs it before */

#include <jerror.h>
#include <jpeglib.h>
#include <setjmp.h>
#include <stdlib.h>
#include <string.h>

typedef struct jpeg_job {
    struct jpeg_error_mgr manager; /* first: libjpeg gives its address back */
    jmp_buf back;
    const image_sink *sink;
    size_t size;
    image_result result;
    uint8_t *row, *with_alpha;
} jpeg_job;

static void fail(j_common_ptr jpeg) {
    jpeg_job *job = (jpeg_job *)(void *)jpeg->err;
    if (!job->result) job->result = IMAGE_BROKEN;
    longjmp(job->back, 1);
}
static void say_nothing(j_common_ptr jpeg) { (void)jpeg; }

static void give_up(struct jpeg_decompress_struct *jpeg, jpeg_job *job, image_result result) {
    job->result = result;
    fail((j_common_ptr)jpeg);
}

/* Where data ends too early or is damaged libjpeg makes up the rest, with a warning. */
static void refuse_made_up(j_common_ptr jpeg, int level) {
    const int code = jpeg->err->msg_code;
    if (level < 0 &&
        (code == JWRN_JPEG_EOF || code == JWRN_HIT_MARKER || code == JWRN_HUFF_BAD_CODE))
        fail(jpeg);
}

static void begin(struct jpeg_decompress_struct *jpeg, jpeg_job *job) {
    jpeg_read_header(jpeg, TRUE);
    if (jpeg->jpeg_color_space == JCS_CMYK || jpeg->jpeg_color_space == JCS_YCCK)
        give_up(jpeg, job, IMAGE_CMYK);
    const size_t width = jpeg->image_width, height = jpeg->image_height;
    if (width > IMAGE_MOST_SIDE || height > IMAGE_MOST_SIDE ||
        !norma_image_may_decode(job->size, 3 * width * height) ||
        (jpeg_has_multiple_scans(jpeg) && !norma_image_may_hold(job->size, 6 * width * height)))
        give_up(jpeg, job, IMAGE_TOO_LARGE);
    jpeg->out_color_space = JCS_RGB;
    jpeg->dct_method = JDCT_ISLOW;
    jpeg_start_decompress(jpeg);
    job->row = malloc(3 * width);
    job->with_alpha = malloc(4 * width);
    if (!job->row || !job->with_alpha || !job->sink->begin(job->sink->user, width, height))
        give_up(jpeg, job, IMAGE_MEMORY);
}

static const uint8_t *add_alpha(jpeg_job *job, size_t width) {
    for (size_t x = 0; x < width; ++x) {
        memcpy(job->with_alpha + 4 * x, job->row + 3 * x, 3);
        job->with_alpha[4 * x + 3] = 255;
    }
    return job->with_alpha;
}

static void read_rows(struct jpeg_decompress_struct *jpeg, jpeg_job *job) {
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
    job->manager.error_exit = fail;
    job->manager.emit_message = refuse_made_up;
    job->manager.output_message = say_nothing;
    if (setjmp(job->back)) {
        jpeg_destroy_decompress(&jpeg);
        return;
    }
    jpeg_create_decompress(&jpeg);
    jpeg_mem_src(&jpeg, bytes, (unsigned long)job->size);
    begin(&jpeg, job);
    read_rows(&jpeg, job);
    jpeg_destroy_decompress(&jpeg);
}

image_result norma_image_read_jpeg(
    const unsigned char *bytes, size_t size, const image_sink *sink) {
    jpeg_job job = {.sink = sink, .size = size};
    read_jpeg(bytes, &job);
    free(job.row);
    free(job.with_alpha);
    return job.result;
}
