/* fail.h: the error that a call ends with, in words. */
#ifndef NORMA_RENDER_FAIL_H
#define NORMA_RENDER_FAIL_H
#include "render/render.h"

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
