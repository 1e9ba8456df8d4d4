/* fail.c: writes the words of an error. */
#include "render/fail.h"
#include <stdarg.h>
#include <stdio.h>

enum render_result render_fail(
    render_error *error, enum render_result result, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(error->message, sizeof error->message, format, arguments);
    va_end(arguments);
    error->result = result;
    return result;
}
