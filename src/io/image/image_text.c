/* image_text.c: why an image was not read, in words. */
#include "io/image/image.h"

const char *norma_image_text(image_result result) {
    static const char *const texts[] = {"it was read", "it is neither PNG nor JPEG",
        "it is malformed or cut off", "it is far larger than its file suggests", "out of memory",
        "this Norma was built without libpng and libjpeg"};
    return texts[result];
}
