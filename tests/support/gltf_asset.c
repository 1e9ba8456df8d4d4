/* gltf_asset.c: GLB files put together in memory. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "gltf_asset.h"

static char *append(char *text, const char *more) {
    size_t length = text ? strlen(text) : 0;
    char *longer = realloc(text, length + strlen(more) + 1);
    assert_non_null(longer);
    strcpy(longer + length, more);
    return longer;
}

int asset_view(gltf_asset *a, const void *bytes, size_t size, const char *members) {
    char text[600];
    size_t room = (a->bin_size + size + 3) / 4 * 4;
    a->bin = realloc(a->bin, room + 4);
    assert_non_null(a->bin);
    memset(a->bin + a->bin_size, 0, room - a->bin_size);
    if (size) memcpy(a->bin + a->bin_size, bytes, size);
    snprintf(text, sizeof text, "%s{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu%s}",
        a->views ? "," : "", a->bin_size, size, members);
    a->views = append(a->views, text);
    a->bin_size = room;
    return a->view_count++;
}

int asset_accessor(gltf_asset *a, const char *json) {
    a->accessors = append(append(a->accessors, a->accessor_count ? "," : ""), json);
    return a->accessor_count++;
}

static int add(gltf_asset *a, const void *bytes, size_t size, int component, int normalized,
    size_t stride, size_t count, int width, const char *bounds) {
    static const char *const types[] = {"", "SCALAR", "VEC2", "VEC3", "VEC4"};
    char text[400];
    snprintf(text, sizeof text, ",\"byteStride\":%zu", stride);
    const int view = asset_view(a, bytes, size, stride ? text : "");
    snprintf(text, sizeof text,
        "{\"bufferView\":%d,\"componentType\":%d,\"normalized\":%s,\"count\":%zu,\"type\":\"%s\"%"
        "s}",
        view, component, normalized ? "true" : "false", count, width == 16 ? "MAT4" : types[width],
        bounds);
    return asset_accessor(a, text);
}

int asset_floats(gltf_asset *a, const float *values, size_t count, int width) {
    return add(a, values, count * (size_t)width * 4, 5126, 0, 0, count, width, "");
}

int asset_uint16(gltf_asset *a, const uint16_t *values, size_t count) {
    return add(a, values, count * 2, 5123, 0, 0, count, 1, "");
}

int asset_snorm8(gltf_asset *a, const float *values, size_t count, int width) {
    signed char *codes = calloc(count, 4);
    assert_non_null(codes);
    for (size_t i = 0; i < count; ++i)
        for (int k = 0; k < width; ++k)
            codes[4 * i + (size_t)k] =
                (signed char)lround(127 * (double)values[(size_t)width * i + (size_t)k]);
    int number = add(a, codes, count * 4, 5120, 1, 4, count, width, "");
    free(codes);
    return number;
}

/* The finite half float nearest to a value (IEEE 754-2019, 3.4), by looking at all of them; of two
 * as near, the one whose last bit is 0. */
static uint16_t nearest_half(double value) {
    uint16_t best = 0;
    double least = INFINITY;
    for (uint32_t code = 0; code < 0x7c00; ++code) {
        const int exponent = (int)(code >> 10);
        const double size = exponent ? ldexp(1 + (code & 1023) / 1024.0, exponent - 15)
                                     : ldexp(code, -24),
                     off = fabs(fabs(value) - size);
        if (off < least || (off == least && code % 2 == 0)) best = (uint16_t)code;
        if (off < least) least = off;
    }
    return (uint16_t)(best | (signbit(value) ? 0x8000 : 0));
}

static size_t put_number(unsigned char *at, double value, int component) {
    if (component == 5130) memcpy(at, &value, 8);
    if (component == 5130) return 8;
    const long code = component == 5131 ? nearest_half(value) : lround(value);
    const float single = (float)value;
    if (component == 5126) memcpy(at, &single, 4);
    for (size_t i = 0; component != 5126 && i < 4; ++i)
        at[i] = (unsigned char)((unsigned long)code >>
                                8 * i); /* what is too much is written over by the next */
    return component == 5120 || component == 5121                        ? 1
           : component == 5122 || component == 5123 || component == 5131 ? 2
                                                                         : 4;
}

int asset_numbers(
    gltf_asset *a, const double *values, size_t count, int width, int component, int normalized) {
    const double largest = !normalized || component >= 5126 ? 1
                           : component == 5120              ? 127
                           : component == 5121              ? 255
                           : component == 5122              ? 32767
                                                            : 65535;
    unsigned char probe[8], *bytes = calloc(count, 40);
    const size_t size = put_number(probe, 0, component),
                 stride = (size * (size_t)width + 3) / 4 * 4;
    assert_non_null(bytes);
    for (size_t i = 0; i < count; ++i) {
        unsigned char element[48] = {0};
        for (int k = 0; k < width; ++k)
            put_number(element + (size_t)k * size, largest * values[(size_t)width * i + (size_t)k],
                component);
        memset(element + (size_t)width * size, 0, sizeof element - (size_t)width * size);
        memcpy(bytes + i * stride, element, stride);
    }
    int number = add(a, bytes, count * stride, component, normalized && component < 5126,
        width == 1 ? 0 : stride, count, width, "");
    free(bytes);
    return number;
}

static void put32(unsigned char *at, size_t value) {
    for (int i = 0; i < 4; ++i) at[i] = (unsigned char)(value >> 8 * i);
}

void asset_bytes(gltf_asset *a, const char *rest, size_t *size) {
    char text[200];
    char *json = append(NULL, "{\"asset\":{\"version\":\"2.0\"}");
    if (a->accessor_count) {
        snprintf(text, sizeof text, ",\"buffers\":[{\"byteLength\":%zu}],\"bufferViews\":[",
            a->bin_size);
        json = append(json, text);
        json = append(json, a->views);
        json = append(json, "],\"accessors\":[");
        json = append(json, a->accessors);
        json = append(json, "]");
    }
    json = append(json, ",");
    json = append(json, rest);
    json = append(json, "}");
    while (strlen(json) % 4) json = append(json, " ");
    size_t length = strlen(json);
    *size = 12 + 8 + length + (a->bin_size ? 8 + a->bin_size : 0);
    free(a->glb);
    a->glb = calloc(*size, 1);
    assert_non_null(a->glb);
    memcpy(a->glb, "glTF\2\0\0\0", 8);
    put32(a->glb + 8, *size);
    put32(a->glb + 12, length);
    memcpy(a->glb + 16, "JSON", 4);
    memcpy(a->glb + 20, json, length);
    if (a->bin_size) {
        put32(a->glb + 20 + length, a->bin_size);
        memcpy(a->glb + 24 + length, "BIN", 4);
        memcpy(a->glb + 28 + length, a->bin, a->bin_size);
    }
    free(json);
}

static norma_document_result try_open(gltf_asset *a, const char *rest, int lenient,
    norma_document **document, norma_document_error *error) {
    size_t size;
    asset_bytes(a, rest, &size);
    const norma_document_options options = {
        .struct_size = sizeof options, .format = NORMA_FILE_GLB, .lenient = lenient};
    return norma_document_open_memory(a->glb, size, "asset.glb", &options, document, error);
}

norma_document *asset_open(gltf_asset *a, const char *rest, int lenient) {
    norma_document *document;
    norma_document_error error;
    if (try_open(a, rest, lenient, &document, &error)) fail_msg("%s", error.message);
    return document;
}

const char *asset_refused(gltf_asset *a, const char *rest, int lenient) {
    static norma_document_error error;
    norma_document *document;
    assert_int_not_equal(try_open(a, rest, lenient, &document, &error), NORMA_DOCUMENT_OK);
    assert_null(document);
    return error.message;
}

void asset_free(gltf_asset *a) {
    free(a->bin);
    free(a->glb);
    free(a->views);
    free(a->accessors);
    *a = (gltf_asset){0};
}
