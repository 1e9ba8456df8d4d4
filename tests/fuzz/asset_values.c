/* asset_values.c: a small reader of glTF 2.0 (sections 3.6 and 3.7) that decodes by the
 * specification and checks as it goes. */
#include "asset_values.h"
#include <jansson.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct reader {
    const char *path;
    json_t *root;
    unsigned char **buffers;
    size_t *sizes, buffer_count;
    asset_values *values;
} reader;

static int wrong(reader *r, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    if (!r->values->why[0]) vsnprintf(r->values->why, sizeof r->values->why, format, arguments);
    va_end(arguments);
    return 0;
}

static size_t number(const json_t *object, const char *key, size_t otherwise) {
    const json_t *value = json_object_get(object, key);
    return json_is_integer(value) ? (size_t)json_integer_value(value) : otherwise;
}

static json_t *item(const reader *r, const char *list, size_t at) {
    return json_array_get(json_object_get(r->root, list), at);
}

static unsigned char *load(const char *path, size_t *size) {
    FILE *file = fopen(path, "rb");
    unsigned char *bytes = file ? malloc(1 << 20) : NULL;
    *size = bytes ? fread(bytes, 1, 1 << 20, file) : 0;
    if (file) fclose(file);
    return bytes;
}

static int letter_value(char c) {
    static const char letters[] =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const char *found = c ? strchr(letters, c) : NULL;
    return found ? (int)(found - letters) : -1;
}

static unsigned char *decode_data(const char *uri, size_t *size) {
    const char *text = strchr(uri, ',');
    unsigned char *bytes = malloc(strlen(uri) + 1);
    unsigned bits = 0, held = 0;
    *size = 0;
    for (text = text ? text + 1 : ""; letter_value(*text) >= 0; ++text) {
        bits = bits << 6 | (unsigned)letter_value(*text);
        if ((held += 6) >= 8) bytes[(*size)++] = (unsigned char)(bits >> (held -= 8));
    }
    return bytes;
}

/* A name beside the asset, its escapes resolved. */
static unsigned char *load_beside(const reader *r, const char *uri, size_t *size) {
    const char *slash = strrchr(r->path, '/');
    char path[1024];
    int length =
        snprintf(path, sizeof path, "%.*s", slash ? (int)(slash - r->path) + 1 : 0, r->path);
    for (unsigned code; *uri && length < (int)sizeof path - 1; ++uri) {
        if (*uri == '%' && sscanf(uri + 1, "%2x", &code) == 1) {
            path[length++] = (char)code;
            uri += 2;
        } else
            path[length++] = *uri;
    }
    path[length] = '\0';
    return load(path, size);
}

static int load_buffers(reader *r) {
    r->buffer_count = json_array_size(json_object_get(r->root, "buffers"));
    r->buffers = calloc(r->buffer_count + 1, sizeof *r->buffers);
    r->sizes = calloc(r->buffer_count + 1, sizeof *r->sizes);
    for (size_t i = 0; i < r->buffer_count; ++i) {
        const json_t *buffer = item(r, "buffers", i);
        const char *uri = json_string_value(json_object_get(buffer, "uri"));
        if (!uri) return wrong(r, "buffer %zu has no URI", i);
        r->buffers[i] = strncmp(uri, "data:", 5) == 0 ? decode_data(uri, &r->sizes[i])
                                                      : load_beside(r, uri, &r->sizes[i]);
        const size_t length = number(buffer, "byteLength", 0);
        if (!r->buffers[i] || length > r->sizes[i])
            return wrong(r, "buffer %zu has %zu bytes of %zu", i, r->sizes[i], length);
        r->sizes[i] = length;
    }
    return 1;
}

static size_t component_size(size_t type) {
    return type <= 5121 ? 1 : type <= 5123 || type == 5131 ? 2 : type == 5130 ? 8 : 4;
}

static size_t component_count(const json_t *accessor) {
    static const char *const names[] = {"SCALAR", "VEC2", "VEC3", "VEC4"};
    const char *type = json_string_value(json_object_get(accessor, "type"));
    for (size_t i = 0; type && i < 4; ++i)
        if (strcmp(type, names[i]) == 0) return i + 1;
    return 0;
}

/* size bytes at offset of a view, in the view and aligned; NULL: wrong. */
static const unsigned char *in_view(
    reader *r, size_t view, size_t offset, size_t size, size_t alignment) {
    const json_t *v = item(r, "bufferViews", view);
    const size_t buffer = number(v, "buffer", SIZE_MAX), start = number(v, "byteOffset", 0),
                 length = number(v, "byteLength", 0);
    if (!v || buffer >= r->buffer_count || start + length > r->sizes[buffer])
        return wrong(r, "view %zu is not in its buffer", view), NULL;
    if (offset + size > length)
        return wrong(r, "view %zu is shorter than %zu", view, offset + size), NULL;
    if ((start + offset) % alignment) return wrong(r, "view %zu is not aligned", view), NULL;
    return r->buffers[buffer] + start + offset;
}

static size_t index_at(const unsigned char *at, size_t size) {
    uint32_t value = 0;
    memcpy(&value, at, size); /* little-endian machines only, as fuzzing is */
    return value;
}

static int apply_sparse(
    reader *r, const json_t *accessor, unsigned char *out, size_t size, size_t count) {
    const json_t *sparse = json_object_get(accessor, "sparse"),
                 *indices = json_object_get(sparse, "indices"),
                 *of_values = json_object_get(sparse, "values");
    const size_t changed = number(sparse, "count", 0),
                 wide = component_size(number(indices, "componentType", 0));
    if (!sparse) return 1;
    const unsigned char *at = in_view(r, number(indices, "bufferView", SIZE_MAX),
                            number(indices, "byteOffset", 0), changed * wide, wide),
                        *values = in_view(r, number(of_values, "bufferView", SIZE_MAX),
                            number(of_values, "byteOffset", 0), changed * size,
                            component_size(number(accessor, "componentType", 0)));
    for (size_t i = 0; at && values && i < changed; ++i) {
        if (index_at(at + i * wide, wide) >= count)
            return wrong(r, "a sparse index is out of range");
        memcpy(out + index_at(at + i * wide, wide) * size, values + i * size, size);
    }
    return at && values;
}

/* The elements of an accessor, one after the other; the caller's to free. */
static unsigned char *decode(reader *r, size_t number_of, size_t *count, size_t *size) {
    const json_t *a = item(r, "accessors", number_of);
    const size_t wide = component_size(number(a, "componentType", 0)),
                 view = number(a, "bufferView", SIZE_MAX);
    *count = number(a, "count", 0);
    *size = wide * component_count(a);
    if (!a || !*size || !*count || *count > 100000)
        return wrong(r, "accessor %zu is none", number_of), NULL;
    unsigned char *out = calloc(*count, *size);
    size_t stride = view == SIZE_MAX ? 0 : number(item(r, "bufferViews", view), "byteStride", 0);
    const int strided = stride != 0;
    if (!stride) stride = *size;
    const unsigned char *from = view == SIZE_MAX ? NULL
                                                 : in_view(r, view, number(a, "byteOffset", 0),
                                                       stride * (*count - 1) + *size, wide);
    if (strided && (stride < *size || stride % 4))
        from = NULL, wrong(r, "a stride of %zu for %zu", stride, *size);
    for (size_t i = 0; from && i < *count; ++i) memcpy(out + i * *size, from + i * stride, *size);
    if ((view != SIZE_MAX && !from) || !apply_sparse(r, a, out, *size, *count)) {
        free(out);
        return NULL;
    }
    return out;
}

static void mix(uint64_t *hash, const void *bytes, size_t size) { /* FNV-1a */
    for (size_t i = 0; i < size; ++i)
        *hash = (*hash ^ ((const unsigned char *)bytes)[i]) * 1099511628211u;
}

static int check_bounds(reader *r, size_t accessor, const unsigned char *values, size_t count) {
    for (int most = 0; most < 2; ++most) {
        const json_t *bounds =
            json_object_get(item(r, "accessors", accessor), most ? "max" : "min");
        for (size_t k = 0; json_is_array(bounds) && k < json_array_size(bounds); ++k) {
            float bound = 0, value;
            for (size_t i = 0; i < count; ++i) {
                memcpy(&value, values + 12 * i + 4 * k, 4);
                if (i == 0 || (most ? value > bound : value < bound)) bound = value;
            }
            if ((float)json_number_value(json_array_get(bounds, k)) != bound)
                return wrong(r, "accessor %zu: bounds that are not those of its values", accessor);
        }
    }
    return 1;
}

/* An attribute by corners, so that vertices may be added and numbered anew. */
static int mix_attribute(reader *r, size_t accessor, const unsigned char *indices, size_t corners,
    size_t wide, size_t vertices, int is_place, int has_bounds) {
    size_t count, size;
    unsigned char *values = decode(r, accessor, &count, &size);
    if (!values) return 0;
    int ok = count == vertices ||
             wrong(r, "accessor %zu has %zu elements of %zu", accessor, count, vertices);
    if (ok && has_bounds) ok = check_bounds(r, accessor, values, count);
    for (size_t c = 0; ok && c < corners; ++c) {
        const size_t v = indices ? index_at(indices + c * wide, wide) : c;
        ok = v < count || wrong(r, "index %zu of %zu", v, count);
        if (ok) mix(&r->values->all, values + v * size, size);
        if (ok && is_place) mix(&r->values->places, values + v * size, size);
    }
    free(values);
    return ok;
}

static int mix_attributes(reader *r, json_t *attributes, const unsigned char *indices,
    size_t corners, size_t wide, size_t vertices) {
    const char *names[64];
    size_t count = 0;
    for (void *i = json_object_iter(attributes); i && count < 64;
         i = json_object_iter_next(attributes, i))
        names[count++] = json_object_iter_key(i);
    for (size_t i = 1; i < count; ++i) /* in the order of names */
        for (size_t k = i; k > 0 && strcmp(names[k - 1], names[k]) > 0; --k) {
            const char *swapped = names[k];
            names[k] = names[k - 1];
            names[k - 1] = swapped;
        }
    for (size_t i = 0; i < count; ++i) {
        const int place = strcmp(names[i], "NORMAL") != 0 && strcmp(names[i], "TANGENT") != 0;
        if (!mix_attribute(r, number(attributes, names[i], SIZE_MAX), indices, corners, wide,
                vertices, place, strcmp(names[i], "POSITION") == 0))
            return 0;
        mix(&r->values->all, names[i], strlen(names[i]));
        if (place) mix(&r->values->places, names[i], strlen(names[i]));
    }
    return 1;
}

static int mix_primitive(reader *r, json_t *primitive) {
    json_t *attributes = json_object_get(primitive, "attributes"),
           *targets = json_object_get(primitive, "targets");
    const size_t of_positions = number(attributes, "POSITION", SIZE_MAX),
                 of_indices = number(primitive, "indices", SIZE_MAX),
                 vertices = number(item(r, "accessors", of_positions), "count", 0);
    size_t corners = vertices, wide = 0;
    unsigned char *indices = NULL;
    if (of_indices != SIZE_MAX && !(indices = decode(r, of_indices, &corners, &wide))) return 0;
    mix(&r->values->places, &corners, sizeof corners);
    int ok = mix_attributes(r, attributes, indices, corners, wide, vertices);
    for (size_t t = 0; ok && t < json_array_size(targets); ++t)
        ok = mix_attributes(r, json_array_get(targets, t), indices, corners, wide, vertices);
    free(indices);
    return ok;
}

static int mix_meshes(reader *r) {
    const json_t *meshes = json_object_get(r->root, "meshes");
    for (size_t m = 0; m < json_array_size(meshes); ++m) {
        const json_t *primitives = json_object_get(json_array_get(meshes, m), "primitives");
        for (size_t p = 0; p < json_array_size(primitives); ++p)
            if (!mix_primitive(r, json_array_get(primitives, p))) return 0;
    }
    return 1;
}

void fuzz_read_asset(const char *path, asset_values *values) {
    size_t size;
    unsigned char *text = load(path, &size);
    reader r = {.path = path, .values = values};
    *values = (asset_values){.places = 14695981039346656037u, .all = 14695981039346656037u};
    r.root = text ? json_loadb((const char *)text, size, 0, NULL) : NULL;
    if (!r.root) wrong(&r, text ? "no JSON" : "no file");
    values->known = r.root && load_buffers(&r) && mix_meshes(&r);
    for (size_t i = 0; i < r.buffer_count; ++i) free(r.buffers[i]);
    free(r.buffers);
    free(r.sizes);
    json_decref(r.root);
    free(text);
}
