/* image_text.c: why an image was not read, in words. */
#include "io/image/image.h"

#if defined(__wasm__)
#define LEFT_OUT "Norma reads images on the command line only"
#else
#define LEFT_OUT "this Norma was built without libpng and libjpeg"
#endif

const char *norma_image_text(image_result result) {
    static const char *const texts[] = {"it was read", "it is neither PNG nor JPEG",
        "it is malformed or cut off", "it is implausibly large for the size of its file",
        "out of memory", "it is grey, or stored in another way than as red, green and blue",
        "it is a JPEG in CMYK, not in red, green and blue", LEFT_OUT};
    return texts[result];
}
