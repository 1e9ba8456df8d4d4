/* vec3_view.h: one vector of a view, of any format, stride and alignment, as three doubles, and one
 * index of an array. Every format fits a double exactly. */
#ifndef NORMA_CORE_VEC3_VIEW_H
#define NORMA_CORE_VEC3_VIEW_H
#include <norma/norma.h>
#include <string.h>

/* Bytes of one number; 0 for what is no format. */
static inline size_t norma_format_size(norma_format format) {
    switch (format) {
    case NORMA_FORMAT_FLOAT:
        return sizeof(float);
    case NORMA_FORMAT_DOUBLE:
        return sizeof(double);
    case NORMA_FORMAT_INT8:
        return sizeof(int8_t);
    case NORMA_FORMAT_UINT8:
        return sizeof(uint8_t);
    case NORMA_FORMAT_INT16:
        return sizeof(int16_t);
    case NORMA_FORMAT_UINT16:
        return sizeof(uint16_t);
    }
    return 0;
}

/* Bytes from one vector to the next, never 0 for a valid format. */
static inline size_t norma_view_stride(const norma_vec3_view *view) {
    return view->stride ? view->stride : 3 * norma_format_size(view->format);
}

/* Whether count * stride, or the end of the last vector where it is wider than the stride, is
 * beyond size_t. */
static inline int norma_view_overflows(const norma_vec3_view *view) {
    const size_t stride = norma_view_stride(view), size = 3 * norma_format_size(view->format);
    if (!view->count || !stride) return 0;
    return view->count > SIZE_MAX / stride || (view->count - 1) * stride > SIZE_MAX - size;
}

/* Vector index of the view; the caller has checked format and index. */
static inline void norma_view_read(const norma_vec3_view *view, size_t index, double out[3]) {
    const unsigned char *at = (const unsigned char *)view->data + index * norma_view_stride(view);
    switch (view->format) {
    case NORMA_FORMAT_FLOAT: {
        float v[3];
        memcpy(v, at, sizeof v);
        for (int i = 0; i < 3; i++) out[i] = (double)v[i];
        return;
    }
    case NORMA_FORMAT_DOUBLE:
        memcpy(out, at, 3 * sizeof(double));
        return;
    case NORMA_FORMAT_INT8: {
        int8_t v[3];
        memcpy(v, at, sizeof v);
        for (int i = 0; i < 3; i++) out[i] = (double)v[i];
        return;
    }
    case NORMA_FORMAT_UINT8:
        for (int i = 0; i < 3; i++) out[i] = (double)at[i];
        return;
    case NORMA_FORMAT_INT16: {
        int16_t v[3];
        memcpy(v, at, sizeof v);
        for (int i = 0; i < 3; i++) out[i] = (double)v[i];
        return;
    }
    case NORMA_FORMAT_UINT16: {
        uint16_t v[3];
        memcpy(v, at, sizeof v);
        for (int i = 0; i < 3; i++) out[i] = (double)v[i];
        return;
    }
    }
    out[0] = out[1] = out[2] = 0.0;
}

/* Index number of an array of integers of 1, 2 or 4 bytes. */
static inline uint32_t norma_index_read(const unsigned char *indices, size_t size, size_t number) {
    uint32_t four;
    uint16_t two;
    if (size == 1) return indices[number];
    if (size == 2) {
        memcpy(&two, indices + 2 * number, sizeof two);
        return two;
    }
    memcpy(&four, indices + 4 * number, sizeof four);
    return four;
}
#endif
