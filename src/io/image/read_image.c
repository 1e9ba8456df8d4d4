/* read_image.c: which kind of image it is, by its first bytes. */
#include "io/image/image.h"
#include <string.h>

int norma_image_is_png(const unsigned char *bytes, size_t size) {
    static const unsigned char start[4] = {0x89, 'P', 'N', 'G'};
    return size > sizeof start && memcmp(bytes, start, sizeof start) == 0;
}

static int is_jpeg(const unsigned char *bytes, size_t size) {
    static const unsigned char start[3] = {0xFF, 0xD8, 0xFF};
    return size > sizeof start && memcmp(bytes, start, sizeof start) == 0;
}

image_result norma_image_read(const unsigned char *bytes, size_t size, const image_sink *sink) {
    return norma_image_is_png(bytes, size) ? norma_image_read_png(bytes, size, sink)
           : is_jpeg(bytes, size)          ? norma_image_read_jpeg(bytes, size, sink)
                                           : IMAGE_UNKNOWN;
}

image_result norma_image_turn_green(const unsigned char *bytes, size_t size, growing_bytes *out) {
    return norma_image_is_png(bytes, size) ? norma_image_turn_png(bytes, size, out)
           : is_jpeg(bytes, size)          ? norma_image_turn_jpeg(bytes, size, out)
                                           : IMAGE_UNKNOWN;
}
