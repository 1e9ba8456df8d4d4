/* stream.h: what every call that maps one array of vectors to another shares: the checks of its
 * arguments, and directions without a range. */
#ifndef NORMA_CORE_STREAM_H
#define NORMA_CORE_STREAM_H
#include "core/call/vec3_view.h"
#include "core/call/vector.h"
#include <float.h>
#include <math.h>

/* An output of count elements of size bytes; *stride becomes size where it is 0. */
static inline norma_result norma_output_check(
    const void *out, size_t *stride, size_t size, size_t count, size_t capacity) {
    if (!count) return NORMA_OK;
    if (!out) return NORMA_ERROR_ARGUMENT;
    if (!*stride) *stride = size;
    if (*stride < size) return NORMA_ERROR_ARGUMENT;
    if (count > SIZE_MAX / *stride) return NORMA_ERROR_OVERFLOW;
    return capacity < count ? NORMA_ERROR_CAPACITY : NORMA_OK;
}

static inline norma_result norma_input_check(const norma_vec3_view *view) {
    if (!norma_format_size(view->format)) return NORMA_ERROR_ARGUMENT;
    if (view->count && !view->data) return NORMA_ERROR_ARGUMENT;
    return norma_view_overflows(view) ? NORMA_ERROR_OVERFLOW : NORMA_OK;
}

/* Multiplies v by the power of two that brings its largest component into [1, 2); 0 where v is zero
 * or not finite. */
static inline int norma_vec3_scale(double v[3]) {
    double largest = 0.0;
    for (int i = 0; i < 3; i++) {
        if (!(fabs(v[i]) <= DBL_MAX)) return 0;
        if (fabs(v[i]) > largest) largest = fabs(v[i]);
    }
    if (largest == 0.0) return 0;
    int exponent;
    (void)frexp(largest, &exponent);
    for (int i = 0; i < 3; i++) v[i] = ldexp(v[i], 1 - exponent);
    return 1;
}

/* Makes v a unit vector, whatever its length; 0, and v unspecified, where it is zero or not finite.
 */
static inline int norma_vec3_unit(double v[3]) {
    if (!norma_vec3_scale(v)) return 0;
    const double length = sqrt(norma_core_dot(v, v));
    for (int i = 0; i < 3; i++) v[i] /= length;
    return 1;
}
#endif
