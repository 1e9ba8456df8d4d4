/* pack.c: unit vectors as signed normalised integers, c / 127 or c / 32767, and back.
 *
 * Rounding to the nearest code can make a vector whose length a reader no longer takes for 1: the
 * Khronos validator allows 0.00674, and (67, 76, 78) / 127 is 1.00680 long. Then the nearest code
 * that passes is taken; every passing code that can be nearest lies within one step of the rounded
 * one. */
#include "core/matrix/matrix.h"

#define LENGTH_TOLERANCE 0.00674 /* of the unit length */

static int passes(const int code[3], int scale) {
    const double square =
        (double)code[0] * code[0] + (double)code[1] * code[1] + (double)code[2] * code[2];
    return fabs(sqrt(square) / scale - 1.0) <= LENGTH_TOLERANCE;
}

static double code_distance(const int code[3], const double target[3]) {
    double sum = 0.0;
    for (int i = 0; i < 3; ++i) sum += (code[i] - target[i]) * (code[i] - target[i]);
    return sum;
}

/* The code nearest to target (a unit vector times scale) among those within a step of rounded; the
 * first of equals. */
static void nearest_passing(const double target[3], int scale, const int rounded[3], int code[3]) {
    double best = DBL_MAX;
    for (int n = 0; n < 27; ++n) {
        const int steps[3] = {n / 9 - 1, n / 3 % 3 - 1, n % 3 - 1};
        int tried[3];
        for (int i = 0; i < 3; ++i) {
            tried[i] = rounded[i] + steps[i];
            if (tried[i] > scale) tried[i] = scale;
            if (tried[i] < -scale) tried[i] = -scale;
        }
        const double d = code_distance(tried, target);
        if (d < best && passes(tried, scale)) {
            best = d;
            memcpy(code, tried, sizeof tried);
        }
    }
}

/* What has no direction becomes zero. */
static void encode(const double normal[3], int scale, int code[3]) {
    double target[3] = {normal[0], normal[1], normal[2]};
    code[0] = code[1] = code[2] = 0;
    if (!norma_vec3_unit(target)) return;
    int rounded[3];
    for (int i = 0; i < 3; ++i) {
        target[i] *= scale;
        rounded[i] =
            (int)(target[i] +
                  (target[i] < 0.0
                          ? -0.5
                          : 0.5)); /* half away from zero, so that -n gets the negated code */
    }
    if (passes(rounded, scale))
        memcpy(code, rounded, sizeof rounded);
    else
        nearest_passing(target, scale, rounded, code);
}

/* As codes of size bytes each. */
static norma_result encode_all(const norma_vec3_view *normals, int scale, unsigned char *out,
    size_t stride, size_t size, size_t capacity) {
    norma_result result = norma_input_check(normals);
    if (!result) result = norma_output_check(out, &stride, 3 * size, normals->count, capacity);
    if (result) return result;
    for (size_t i = 0; i < normals->count; ++i) {
        double normal[3];
        int code[3];
        norma_view_read(normals, i, normal);
        encode(normal, scale, code);
        const int8_t bytes[3] = {(int8_t)code[0], (int8_t)code[1], (int8_t)code[2]};
        const int16_t shorts[3] = {(int16_t)code[0], (int16_t)code[1], (int16_t)code[2]};
        if (size == sizeof *bytes)
            memcpy(out + i * stride, bytes, sizeof bytes);
        else
            memcpy(out + i * stride, shorts, sizeof shorts);
    }
    return NORMA_OK;
}

norma_result norma_encode_snorm8(
    norma_vec3_view normals, int8_t *out, size_t out_stride, size_t capacity) {
    return encode_all(&normals, 127, (unsigned char *)out, out_stride, sizeof *out, capacity);
}

norma_result norma_encode_snorm16(
    norma_vec3_view normals, int16_t *out, size_t out_stride, size_t capacity) {
    return encode_all(&normals, 32767, (unsigned char *)out, out_stride, sizeof *out, capacity);
}

static norma_result decode_all(
    norma_vec3_view codes, float scale, float *out, size_t out_stride, size_t capacity) {
    norma_result result = norma_input_check(&codes);
    if (!result)
        result = norma_output_check(out, &out_stride, 3 * sizeof *out, codes.count, capacity);
    if (result) return result;
    for (size_t i = 0; i < codes.count; ++i) {
        double code[3];
        float v[3];
        norma_view_read(&codes, i, code);
        for (int c = 0; c < 3; ++c) {
            v[c] = (float)code[c] / scale;
            if (v[c] < -1.0f) v[c] = -1.0f; /* the one code below -scale */
        }
        memcpy((unsigned char *)out + i * out_stride, v, sizeof v);
    }
    return NORMA_OK;
}

norma_result norma_decode_snorm8(const int8_t *codes, size_t stride, size_t count, float *out,
    size_t out_stride, size_t capacity) {
    return decode_all((norma_vec3_view){codes, count, stride, NORMA_FORMAT_INT8}, 127.0f, out,
        out_stride, capacity);
}

norma_result norma_decode_snorm16(const int16_t *codes, size_t stride, size_t count, float *out,
    size_t out_stride, size_t capacity) {
    return decode_all((norma_vec3_view){codes, count, stride, NORMA_FORMAT_INT16}, 32767.0f, out,
        out_stride, capacity);
}
