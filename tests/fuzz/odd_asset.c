/* odd_asset.c: the choices behind an odd asset. Every byte of the input is a choice, so that
 * libFuzzer's own mutations change the structure of the JSON and never break it. */
#include "odd_asset.h"
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

enum { SHORT_INDICES = 0, LONG_INDICES = 64, SPARSE_INDICES = 128, FLOATS = 160 };
enum { MOST_BUFFERS = 3, MOST_VIEWS = 12, MOST_ACCESSORS = 40, NOTHING = -1 };

typedef struct view {
    int buffer, offset, length, stride;
} view;

typedef struct accessor {
    int view, offset, type, components, count, has_bounds, sparse_view;
} accessor;

typedef struct odd {
    fuzz_bytes *bytes;
    uint8_t contents[ODD_FILE_SIZE];
    int lengths[MOST_BUFFERS];
    view views[MOST_VIEWS];
    accessor accessors[MOST_ACCESSORS];
    int buffer_count, view_count, accessor_count;
    char *text;
    size_t length;
} odd;

void fuzz_odd_contents(uint8_t contents[ODD_FILE_SIZE]) {
    for (int i = 0; i < 32; ++i) contents[2 * i] = (uint8_t)(i % 3), contents[2 * i + 1] = 0;
    for (uint32_t i = 0; i < 16; ++i) {
        const uint32_t index = (i * 2 + i / 3) % 3;
        memcpy(contents + LONG_INDICES + 4 * i, &index, 4);
    }
    for (int i = 0; i < 32; ++i) contents[SPARSE_INDICES + i] = (uint8_t)(i % 3);
    for (int i = 0; FLOATS + 4 * i < ODD_FILE_SIZE; ++i) {
        const float value = i % 3 == 2 ? (float)(i * 7 % 5 - 2) : i * 5 % 8 > 4 ? 1.f : 0.f;
        memcpy(contents + FLOATS + 4 * i, &value, 4);
    }
}

static int choose(odd *o, uint32_t bound) { return (int)fuzz_below(o->bytes, bound); }

#if defined(__GNUC__)
__attribute__((format(printf, 2, 3)))
#endif
static void
put(odd *o, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    const int length = vsnprintf(o->text + o->length, ODD_TEXT_SIZE - o->length, format, arguments);
    va_end(arguments);
    if (length < 0 || o->length + (size_t)length >= ODD_TEXT_SIZE)
        fuzz_fail("an odd asset is too long");
    o->length += (size_t)length;
}

static int add_view(odd *o, int buffer, int offset, int length, int stride) {
    if (o->view_count == MOST_VIEWS) return 0;
    o->views[o->view_count] = (view){buffer, offset, length, stride};
    return o->view_count++;
}

/* Views of indices of 16, 8 and 32 bits and of sparse ones over some buffer, then odd ones of
 * floats. */
static void choose_views(odd *o) {
    static const int strides[] = {0, 12, 16, 20, 24, 36};
    const int buffer = choose(o, (uint32_t)o->buffer_count), more = 1 + choose(o, 6);
    add_view(o, buffer, SHORT_INDICES, 64, 0);
    add_view(o, buffer, LONG_INDICES, 64, 0);
    add_view(o, buffer, SPARSE_INDICES, 32, 0);
    for (int i = 0; i < more; ++i) {
        const int of = choose(o, (uint32_t)o->buffer_count), room = o->lengths[of] - FLOATS,
                  offset = choose(o, 4) ? 0 : 4 * choose(o, 30),
                  length = choose(o, 3) ? room - offset : 48 + 4 * choose(o, 40);
        add_view(o, of, FLOATS + offset, length < room - offset ? length : room - offset,
            strides[choose(o, 6)]);
    }
}

static int size_of(const accessor *a) {
    return a->components * (a->type == 5126 || a->type == 5125 ? 4 : a->type == 5123 ? 2 : 1);
}

static int stride_of(const odd *o, const accessor *a) {
    const int stride = a->view == NOTHING ? 0 : o->views[a->view].stride;
    return stride ? stride : size_of(a);
}

static int fits(const odd *o, const accessor *a) {
    return a->offset + stride_of(o, a) * (a->count - 1) + size_of(a) <= o->views[a->view].length &&
           stride_of(o, a) >= size_of(a);
}

static int add_accessor(odd *o, accessor a) {
    if (o->accessor_count == MOST_ACCESSORS) return 0;
    o->accessors[o->accessor_count] = a;
    return o->accessor_count++;
}

/* Floats: an accessor that is there, or a new one on a view of floats; sparse values now and then.
 */
static int add_floats(odd *o, int components, int count, int has_bounds) {
    if (choose(o, 4) == 0)
        for (int i = 0; i < o->accessor_count; ++i) {
            const accessor *a = &o->accessors[i];
            if (a->type == 5126 && a->components == components && a->count == count &&
                a->has_bounds >= has_bounds)
                return i;
        }
    accessor a = {3 + choose(o, (uint32_t)(o->view_count - 3)), 4 * choose(o, 12), 5126, components,
        count, has_bounds, NOTHING};
    if (a.view >= o->view_count || !fits(o, &a)) a.offset = 0;
    if (a.view >= o->view_count || !fits(o, &a) || choose(o, 16) == 0)
        a.view = NOTHING, a.offset = 0;
    const int sparse = choose(o, 6) ? NOTHING : 3 + choose(o, (uint32_t)(o->view_count - 3));
    if (sparse != NOTHING && o->views[sparse].length >= 12 * components && !o->views[sparse].stride)
        a.sparse_view = sparse;
    return add_accessor(o, a);
}

static int add_indices(odd *o) {
    static const int types[] = {5123, 5121, 5125};
    const int kind = choose(o, 4);
    if (kind == 3) return NOTHING;
    return add_accessor(
        o, (accessor){kind == 2, 0, types[kind], 1, 3 * (1 + choose(o, 5)), 0, NOTHING});
}

static float component(const odd *o, const accessor *a, int i, int k) {
    float value = 0;
    int at = NOTHING;
    if (a->view != NOTHING) at = o->views[a->view].offset + a->offset + stride_of(o, a) * i + 4 * k;
    if (a->sparse_view != NOTHING && i < 3)
        at = o->views[a->sparse_view].offset + 4 * (a->components * i + k);
    if (at != NOTHING) memcpy(&value, o->contents + at, 4);
    return value;
}

static void put_bounds(odd *o, const accessor *a) {
    for (int most = 0; most < 2; ++most) {
        put(o, ",\"%s\":[", most ? "max" : "min");
        for (int k = 0; k < a->components; ++k) {
            float bound = component(o, a, 0, k);
            for (int i = 1; i < a->count; ++i) {
                const float value = component(o, a, i, k);
                if (most ? value > bound : value < bound) bound = value;
            }
            put(o, "%s%g", k ? "," : "", (double)bound);
        }
        put(o, "]");
    }
}

static void put_accessor(odd *o, const accessor *a) {
    static const char *const types[] = {"", "SCALAR", "VEC2", "VEC3", "VEC4"};
    put(o, "{\"componentType\":%d,\"count\":%d,\"type\":\"%s\"", a->type, a->count,
        types[a->components]);
    if (a->view != NOTHING) put(o, ",\"bufferView\":%d", a->view);
    if (a->offset) put(o, ",\"byteOffset\":%d", a->offset);
    if (a->has_bounds) put_bounds(o, a);
    if (a->sparse_view != NOTHING)
        put(o,
            ",\"sparse\":{\"count\":3,\"indices\":{\"bufferView\":2,\"componentType\":5121},"
            "\"values\":{\"bufferView\":%d}}",
            a->sparse_view);
    put(o, "}");
}

static void put_views(odd *o) {
    put(o, ",\"bufferViews\":[");
    for (int i = 0; i < o->view_count; ++i) {
        const view *v = &o->views[i];
        put(o, "%s{\"buffer\":%d,\"byteOffset\":%d,\"byteLength\":%d", i ? "," : "", v->buffer,
            v->offset, v->length);
        if (v->stride) put(o, ",\"byteStride\":%d", v->stride);
        put(o, "}");
    }
    put(o, "]");
}

static void put_data(odd *o, int length) {
    static const char letters[] =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    put(o, "data:application/octet-stream;base64,");
    for (int i = 0; i < length; i += 3) {
        const int left = length - i;
        const unsigned bits = (unsigned)o->contents[i] << 16 |
                              (left > 1 ? (unsigned)o->contents[i + 1] << 8 : 0) |
                              (left > 2 ? o->contents[i + 2] : 0);
        put(o, "%c%c%c%c", letters[bits >> 18], letters[bits >> 12 & 63],
            left > 1 ? letters[bits >> 6 & 63] : '=', left > 2 ? letters[bits & 63] : '=');
    }
}

static void put_buffers(odd *o, const char *const *names, size_t name_count) {
    put(o, ",\"buffers\":[");
    for (int i = 0; i < o->buffer_count; ++i) {
        const int name = choose(o, (uint32_t)name_count + 1);
        put(o, "%s{\"byteLength\":%d,\"uri\":\"", i ? "," : "", o->lengths[i]);
        if (name < (int)name_count)
            put(o, "%s", names[name]);
        else
            put_data(o, o->lengths[i]);
        put(o, "\"}");
    }
    put(o, "]");
}

static void put_primitive(odd *o) {
    const int indices = add_indices(o),
              count = indices == NOTHING ? 3 * (1 + choose(o, 3)) : 3 + choose(o, 5);
    const int what = choose(o, 64);
    put(o, "{\"attributes\":{\"POSITION\":%d", add_floats(o, 3, count, 1));
    if (what & 1) put(o, ",\"NORMAL\":%d", add_floats(o, 3, count, 0));
    if (what & 2) put(o, ",\"TEXCOORD_0\":%d", add_floats(o, 2, count, 0));
    if (what & 4) put(o, ",\"TANGENT\":%d", add_floats(o, 4, count, 0));
    if (what & 8) put(o, ",\"_OWN\":%d", add_floats(o, 1 + choose(o, 4), count, 0));
    put(o, "}");
    if (indices != NOTHING) put(o, ",\"indices\":%d", indices);
    if (what & 16) put(o, ",\"material\":0");
    if (what & 32) {
        put(o, ",\"targets\":[{\"POSITION\":%d", add_floats(o, 3, count, 1));
        if (choose(o, 2)) put(o, ",\"NORMAL\":%d", add_floats(o, 3, count, 0));
        put(o, "}]");
    }
    put(o, "}");
}

static void put_nodes(odd *o, int meshes) {
    static const char *const places[] = {"", ",\"scale\":[2,-1,1]", ",\"translation\":[1,2,3]",
        ",\"rotation\":[0,0,0.7071068,0.7071068]",
        ",\"matrix\":[1,0,0,0,0.5,1,0,0,0,0,1,0,0,0,0,1]"};
    const int count = 1 + choose(o, 3);
    put(o, "\"nodes\":[");
    for (int i = 0; i < count; ++i)
        put(o, "%s{\"name\":\"n%d\",\"mesh\":%d%s}", i ? "," : "", i, choose(o, (uint32_t)meshes),
            places[choose(o, 5)]);
    put(o, "],\"scenes\":[{\"nodes\":[");
    for (int i = 0; i < count; ++i) put(o, "%s%d", i ? "," : "", i);
    put(o, "]}]");
}

static void put_rest(odd *o, const char *image) {
    static const char *const extras[] = {"",
        ",\"extras\":{\"a\":-0,\"a\":1e300,\"b\":\"\\ud83d\\ude00\"}",
        ",\"extras\":{\"norma\":{\"ignore\":[\"N2\"]}}", ",\"extras\":[null,9007199254740993]"};
    put(o, ",\"materials\":[{\"doubleSided\":%s}]", choose(o, 2) ? "true" : "false");
    if (image) put(o, ",\"images\":[{\"uri\":\"%s\"}]", image);
    put(o, "%s}", extras[choose(o, 4)]);
}

size_t fuzz_odd_asset(fuzz_bytes *bytes, const char *const *names, size_t name_count,
    const char *image, char text[ODD_TEXT_SIZE]) {
    odd o = {.bytes = bytes, .text = text};
    const int meshes = 1 + (int)fuzz_below(bytes, 2);
    fuzz_odd_contents(o.contents);
    o.buffer_count = 1 + choose(&o, MOST_BUFFERS);
    for (int i = 0; i < o.buffer_count; ++i)
        o.lengths[i] = choose(&o, 3) ? ODD_FILE_SIZE : ODD_FILE_SIZE - 4 * choose(&o, 60);
    choose_views(&o);
    put(&o, "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,");
    put_nodes(&o, meshes);
    put(&o, ",\"meshes\":[");
    for (int m = 0; m < meshes; ++m) {
        const int primitives = 1 + choose(&o, 2);
        put(&o, "%s{\"primitives\":[", m ? "," : "");
        for (int p = 0; p < primitives; ++p) {
            if (p) put(&o, ",");
            put_primitive(&o);
        }
        put(&o, "]}");
    }
    put(&o, "],\"accessors\":[");
    for (int i = 0; i < o.accessor_count; ++i) {
        if (i) put(&o, ",");
        put_accessor(&o, &o.accessors[i]);
    }
    put(&o, "]");
    put_views(&o);
    put_buffers(&o, names, name_count);
    put_rest(&o, image);
    return o.length;
}
