/* image_left_out.c: stands in for image.c where the library is built without libpng and
 * libjpeg: no image is read, and norma check says so (N002). */
#include "io/image/image.h"

image_result norma_image_read(const unsigned char *bytes, size_t size, const image_sink *sink) {
    return (void)bytes, (void)size, (void)sink, IMAGE_LEFT_OUT;
}

image_result norma_image_turn_green(const unsigned char *bytes, size_t size, growing_bytes *out) {
    return (void)bytes, (void)size, (void)out, IMAGE_LEFT_OUT;
}

image_result norma_image_write(
    const uint8_t *pixels, size_t width, size_t height, growing_bytes *out) {
    return (void)pixels, (void)width, (void)height, (void)out, IMAGE_LEFT_OUT;
}

int norma_image_is_png(const unsigned char *bytes, size_t size) {
    return (void)bytes, (void)size, 0;
}
