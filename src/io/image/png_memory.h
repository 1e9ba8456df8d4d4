/* png_memory.h: PNG in memory by libpng, whose errors become results. */
#ifndef NORMA_IO_PNG_MEMORY_H
#define NORMA_IO_PNG_MEMORY_H
#include "io/image/image.h"
#include <png.h>

typedef struct png_source {
    const unsigned char *bytes;
    size_t size, at;
    image_result result;
} png_source;

/* Appends what write writes of job. The only failure is IMAGE_MEMORY. out: the caller's to free in
 * any case. */
image_result norma_png_write(growing_bytes *out,
    void (*write)(png_structp png, png_infop info, const void *job), const void *job);
#endif
