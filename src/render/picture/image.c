/* image.c: the images of materials as pictures: RGBA, eight bits each. */
#include "io/image/image.h"
#include "render/fail.h"
#include <stdlib.h>
#include <string.h>

static int begin(void *user, size_t width, size_t height) {
    render_picture *picture = user;
    picture->width = width;
    picture->height = height;
    picture->pixels = malloc(4 * width * height);
    return picture->pixels != NULL;
}

static void copy_row(void *user, size_t y, const uint8_t *pixels) {
    const render_picture *picture = user;
    memcpy(picture->pixels + 4 * picture->width * y, pixels, 4 * picture->width);
}

enum render_result render_image_decode(
    const uint8_t *bytes, size_t size, render_picture *picture, render_error *error) {
    *picture = (render_picture){0};
    const image_sink sink = {4, begin, copy_row, picture};
    const image_result result = norma_image_read(bytes, size, &sink);
    if (!result) return RENDER_OK;
    render_picture_free(picture);
    return render_fail(
        error, RENDER_ERROR_ARGUMENT, "an image cannot be decoded: %s", norma_image_text(result));
}
