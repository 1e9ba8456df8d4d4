/* read_image.c: which kind of image it is, by its first bytes. */
#include "io/image/image.h"
#include <string.h>

image_result norma_image_read(const unsigned char *bytes, size_t size, const image_sink *sink) {
    static const unsigned char png[4] = {0x89, 'P', 'N', 'G'}, jpeg[3] = {0xFF, 0xD8, 0xFF};
    if (size > sizeof png && memcmp(bytes, png, sizeof png) == 0)
        return norma_image_read_png(bytes, size, sink);
    if (size > sizeof jpeg && memcmp(bytes, jpeg, sizeof jpeg) == 0)
        return norma_image_read_jpeg(bytes, size, sink);
    return IMAGE_UNKNOWN;
}
