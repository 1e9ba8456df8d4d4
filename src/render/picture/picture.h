/* picture.h: what makes and letters pictures, and tells errors, within the renderer. */
#ifndef NORMA_RENDER_PICTURE_H
#define NORMA_RENDER_PICTURE_H
#include "render/render.h"

typedef struct render_srgb { /* IEC 61966-2-1, both ways; a level that is decoded and encoded is
                                itself again */
    uint16_t linear[256];    /* of 65535 */
    uint8_t encoded[65536];
} render_srgb;
void render_srgb_make(render_srgb *table);

/* Words in Open Sans. size: the height of
 * capitals in pixels; (x, y): where the line of writing begins. */
double render_text_width(const char *text, double size);
void render_text_draw(render_picture *picture, const char *text, double x, double y, double size,
    const uint8_t ink[3]);

/* The error that a call ends with, in words. */
enum render_result render_fail(
    render_error *error, enum render_result result, const char *format, ...)
#if defined(__GNUC__)
    __attribute__((format(printf, 3, 4)))
#endif
    ;
/* Inline, so that an analyser of the callers sees that it never returns OK. */
static inline enum render_result render_fail_memory(render_error *error) {
    (void)render_fail(error, RENDER_ERROR_MEMORY, "out of memory");
    return RENDER_ERROR_MEMORY;
}
#endif
