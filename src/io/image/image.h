/* image.h: the images that files of meshes refer to, PNG and JPEG, read row by row: whoever looks
 * at a map of normals need not hold it whole. */
#ifndef NORMA_IO_IMAGE_H
#define NORMA_IO_IMAGE_H
#include "io/file/file.h"
#include <stdint.h>

typedef struct image_sink {
    int channels; /* 3: red, green, blue; 4: and alpha. Eight bits each, as stored */
    /* Once, before the rows. 0: out of memory. */
    int (*begin)(void *user, size_t width, size_t height);
    /* Each row, from the top. */
    void (*row)(void *user, size_t y, const uint8_t *pixels);
    void *user;
} image_sink;

typedef enum image_result {
    IMAGE_OK = 0,
    IMAGE_UNKNOWN,   /* neither PNG nor JPEG */
    IMAGE_BROKEN,    /* malformed or cut off */
    IMAGE_TOO_LARGE, /* to be decoded with memory that its file's size allows */
    IMAGE_MEMORY,
    IMAGE_GREY,    /* it has no green channel that could be changed alone */
    IMAGE_CMYK,    /* a JPEG of four inks */
    IMAGE_LEFT_OUT /* the library was built without libpng and libjpeg */
} image_result;

/* Rows may have been given before it fails. The same bytes give the same pixels. */
image_result norma_image_read(const unsigned char *bytes, size_t size, const image_sink *sink);

#if defined(__wasm__)
#define IMAGE_LEFT_OUT_TEXT "Norma reads images on the command line only"
#else
#define IMAGE_LEFT_OUT_TEXT "this Norma was built without libpng and libjpeg"
#endif
/* What is wrong with it. Inline: the tool has it without the library's image.c. */
static inline const char *norma_image_text(image_result result) {
    static const char *const texts[] = {"it was read", "it is neither PNG nor JPEG",
        "it is malformed or cut off", "it is implausibly large for the size of its file",
        "out of memory", "it is grey, or stored in another way than as red, green and blue",
        "it is a JPEG in CMYK, not in red, green and blue", IMAGE_LEFT_OUT_TEXT};
    return texts[result];
}

/* The same image as a PNG whose green channel is inverted, its size, depth, alpha and all other
 * data kept; what a JPEG decodes to becomes a PNG of eight bits, so that nothing more is lost.
 * out: empty; its data is the caller's to free in any case. */
image_result norma_image_turn_green(const unsigned char *bytes, size_t size, growing_bytes *out);
/* Rows of red, green and blue, eight bits each, as a PNG; out as above. */
image_result norma_image_write(
    const uint8_t *pixels, size_t width, size_t height, growing_bytes *out);
/* Rows of red, green, blue and alpha as a PNG that says it is sRGB, without alpha where all of it
 * is opaque; out as above. Not where the library is built without libpng. */
image_result norma_image_write_srgb(
    const uint8_t *pixels, size_t width, size_t height, growing_bytes *out);
int norma_image_is_png(const unsigned char *bytes, size_t size);
#endif
