/* acid_glb.c: writes GLB, version 2 of Khronos's specification: a JSON chunk and a binary one. */
#include "acid/acid_glb.h"
#include "io/text/text.h"
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- text */

static void print_list(growing_bytes *to, const char *format, va_list arguments) {
    char text[512];
    const int length = vsnprintf(text, sizeof text, format, arguments);
    if (length < 0 || (size_t)length >= sizeof text)
        to->failed = 1;
    else
        norma_io_append(to, text, (size_t)length);
}

void acid_print(growing_bytes *to, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    print_list(to, format, arguments);
    va_end(arguments);
}

size_t acid_add(acid_list *list, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    if (list->count) norma_io_append(&list->text, ",\n", 2);
    print_list(&list->text, format, arguments);
    va_end(arguments);
    return list->count++;
}

void acid_print_number(growing_bytes *to, const char *name, double number) {
    char text[32];
    norma_number_format_double(number + 0.0, text);
    acid_print(to, "\"%s\":%s", name, text);
}

void acid_print_numbers(growing_bytes *to, const char *name, const double *numbers, size_t count) {
    acid_print(to, "\"%s\":[", name);
    for (size_t i = 0; i < count; ++i) {
        char text[32];
        norma_number_format_double(numbers[i] + 0.0, text);
        acid_print(to, "%s%s", i ? "," : "", text);
    }
    acid_print(to, "]");
}

/* ---- binary */

static void append_little_endian(growing_bytes *to, uint32_t value, int size) {
    unsigned char bytes[4];
    for (int i = 0; i < size; ++i) bytes[i] = (unsigned char)(value >> (8 * i));
    norma_io_append(to, bytes, (size_t)size);
}

static void append_float(growing_bytes *to, float value) {
    uint32_t bits;
    value += 0.0F; /* no -0 */
    memcpy(&bits, &value, sizeof bits);
    append_little_endian(to, bits, 4);
}

static void pad(growing_bytes *to, char with) {
    while (to->size % 4 && !to->failed) norma_io_append(to, &with, 1);
}

/* Of the bytes from start on. target 0: none. */
static size_t add_bytes_view(acid_glb *glb, size_t start, int stride, int target) {
    const size_t view = acid_add(&glb->views, "{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu",
        start, glb->binary.size - start);
    if (stride) acid_print(&glb->views.text, ",\"byteStride\":%d", stride);
    if (target) acid_print(&glb->views.text, ",\"target\":%d", target);
    acid_print(&glb->views.text, "}");
    pad(&glb->binary, '\0');
    return view;
}

enum {
    VERTEX_DATA = 34962,
    INDEX_DATA = 34963,
    BYTE = 5120,
    UNSIGNED_BYTE = 5121,
    SHORT = 5123,
    FLOAT = 5126,
    MATRIX = 5
};

static void print_extent(
    acid_glb *glb, const float *first, size_t stride, size_t count, size_t width) {
    double low[4] = {0}, high[4] = {0};
    for (size_t i = 0; i < count; ++i)
        for (size_t k = 0; k < width; ++k) {
            const double value = (double)first[i * stride + k];
            low[k] = i && low[k] <= value ? low[k] : value;
            high[k] = i && high[k] >= value ? high[k] : value;
        }
    acid_print(&glb->accessors.text, ",");
    acid_print_numbers(&glb->accessors.text, "min", low, width);
    acid_print(&glb->accessors.text, ",");
    acid_print_numbers(&glb->accessors.text, "max", high, width);
}

static size_t begin_accessor(
    acid_glb *glb, size_t view, int type, size_t count, size_t width, int is_normalized) {
    static const char *const types[] = {"", "SCALAR", "VEC2", "VEC3", "VEC4", "MAT4"};
    return acid_add(&glb->accessors,
        "{\"bufferView\":%zu,\"componentType\":%d,%s\"count\":%zu,\"type\":\"%s\"", view, type,
        is_normalized ? "\"normalized\":true," : "", count, types[width]);
}

size_t acid_add_floats(
    acid_glb *glb, const float *first, size_t stride, size_t count, size_t width, int has_bounds) {
    const size_t start = glb->binary.size;
    for (size_t i = 0; i < count; ++i)
        for (size_t k = 0; k < width; ++k) append_float(&glb->binary, first[i * stride + k]);
    const size_t view = add_bytes_view(glb, start, 0, VERTEX_DATA),
                 accessor = begin_accessor(glb, view, FLOAT, count, width, 0);
    if (has_bounds) print_extent(glb, first, stride, count, width);
    acid_print(&glb->accessors.text, "}");
    return accessor;
}

/* Three bytes and one to fill up. Normals are normalized, positions are not. */
size_t acid_add_bytes(
    acid_glb *glb, const float *first, size_t stride, size_t count, double scale, int is_position) {
    const size_t start = glb->binary.size;
    for (size_t i = 0; i < count; ++i) {
        uint32_t word = 0;
        for (size_t k = 0; k < 3; ++k) {
            const int value = (int)floor((double)first[i * stride + k] * scale + 0.5);
            word |= (uint32_t)(value & 255) << (8 * k);
        }
        append_little_endian(&glb->binary, word, 4);
    }
    const size_t view = add_bytes_view(glb, start, 4, VERTEX_DATA),
                 accessor = begin_accessor(glb, view, BYTE, count, 3, !is_position);
    if (is_position) print_extent(glb, first, stride, count, 3);
    acid_print(&glb->accessors.text, "}");
    return accessor;
}

size_t acid_add_identities(acid_glb *glb, size_t joints) {
    const size_t start = glb->binary.size;
    for (size_t i = 0; i < 16 * joints; ++i) append_float(&glb->binary, i % 16 % 5 ? 0 : 1);
    const size_t view = add_bytes_view(glb, start, 0, 0),
                 accessor = begin_accessor(glb, view, FLOAT, joints, MATRIX, 0);
    acid_print(&glb->accessors.text, "}");
    return accessor;
}

size_t acid_add_joints(acid_glb *glb, size_t count, size_t joints) {
    const size_t start = glb->binary.size;
    for (size_t i = 0; i < count; ++i)
        append_little_endian(&glb->binary, joints > 1 ? 1 << 8 : 0, 4);
    const size_t view = add_bytes_view(glb, start, 0, VERTEX_DATA),
                 accessor = begin_accessor(glb, view, UNSIGNED_BYTE, count, 4, 0);
    acid_print(&glb->accessors.text, "}");
    return accessor;
}

size_t acid_add_indices(acid_glb *glb, const uint16_t *indices, size_t count) {
    const size_t start = glb->binary.size;
    for (size_t i = 0; i < count; ++i) append_little_endian(&glb->binary, indices[i], 2);
    const size_t view = add_bytes_view(glb, start, 0, INDEX_DATA),
                 accessor = begin_accessor(glb, view, SHORT, count, 1, 0);
    acid_print(&glb->accessors.text, "}");
    return accessor;
}

size_t acid_add_texture(acid_glb *glb, const void *png, size_t size) {
    const size_t start = glb->binary.size;
    norma_io_append(&glb->binary, png, size);
    const size_t view = add_bytes_view(glb, start, 0, 0),
                 image = acid_add(
                     &glb->images, "{\"bufferView\":%zu,\"mimeType\":\"image/png\"}", view);
    return acid_add(&glb->textures, "{\"sampler\":0,\"source\":%zu}", image);
}

static void name_extension(acid_list *list, const char *name) {
    char quoted[64];
    const int length = snprintf(quoted, sizeof quoted, "\"%s\"", name);
    for (size_t at = 0; at + (size_t)length <= list->text.size; ++at)
        if (memcmp(list->text.data + at, quoted, (size_t)length) == 0) return;
    acid_add(list, "%s", quoted);
}

void acid_use_extension(acid_glb *glb, const char *name, int is_required) {
    name_extension(&glb->used, name);
    if (is_required) name_extension(&glb->required, name);
}

/* ---- the file */

static void print_array(growing_bytes *to, const char *name, acid_list *list) {
    if (list->count) {
        acid_print(to, "\"%s\":[", name);
        norma_io_append(to, list->text.data, list->text.size);
        acid_print(to, "],\n");
    }
    to->failed |= list->text.failed;
    free(list->text.data);
    *list = (acid_list){0};
}

static void print_document(acid_glb *glb, const growing_bytes *more, growing_bytes *text) {
    acid_print(text, "{\"asset\":{\"version\":\"2.0\",\"generator\":\"norma acid\"},\n");
    print_array(text, "extensionsUsed", &glb->used);
    print_array(text, "extensionsRequired", &glb->required);
    if (glb->textures.count)
        acid_print(text, "\"samplers\":[{\"magFilter\":9729,\"minFilter\":9729,\"wrapS\":33071,"
                         "\"wrapT\":33071}],\n");
    norma_io_append(text, more->data, more->size);
    acid_print(text, "\"scene\":0,\n\"scenes\":[{\"name\":\"acid\",\"nodes\":[");
    norma_io_append(text, glb->roots.text.data, glb->roots.text.size);
    text->failed |= glb->roots.text.failed | more->failed;
    acid_print(text, "]}],\n");
    free(glb->roots.text.data);
    print_array(text, "nodes", &glb->nodes);
    print_array(text, "meshes", &glb->meshes);
    print_array(text, "skins", &glb->skins);
    print_array(text, "materials", &glb->materials);
    print_array(text, "textures", &glb->textures);
    print_array(text, "images", &glb->images);
    print_array(text, "accessors", &glb->accessors);
    print_array(text, "bufferViews", &glb->views);
    acid_print(text, "\"buffers\":[{\"byteLength\":%zu}]}", glb->binary.size);
    pad(text, ' ');
}

int acid_finish(acid_glb *glb, const growing_bytes *more, growing_bytes *file) {
    growing_bytes text = {0};
    print_document(glb, more, &text);
    const size_t total = 12 + 8 + text.size + 8 + glb->binary.size;
    append_little_endian(file, 0x46546C67, 4);
    append_little_endian(file, 2, 4);
    append_little_endian(file, (uint32_t)total, 4);
    append_little_endian(file, (uint32_t)text.size, 4);
    append_little_endian(file, 0x4E4F534A, 4);
    norma_io_append(file, text.data, text.size);
    append_little_endian(file, (uint32_t)glb->binary.size, 4);
    append_little_endian(file, 0x004E4942, 4);
    norma_io_append(file, glb->binary.data, glb->binary.size);
    const int failed = glb->failed || glb->binary.failed || text.failed || file->failed;
    free(glb->binary.data);
    free(text.data);
    *glb = (acid_glb){0};
    return !failed;
}
