/* hostile_files.c: writes into a folder small files that say they are large, deep, endless or
 * elsewhere: counts near 2^31, 2^32 and 2^64 in every field of a header, accessors that overrun or
 * wrap, numbers of what is not there, nodes in a circle, URIs out of the folder.
 * tests/cli/hostile.sh runs the tool over them. hostile_files FOLDER */
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *folder;

typedef struct bytes {
    unsigned char *at;
    size_t size, room;
} bytes;

static void put(bytes *b, const void *data, size_t size) {
    if (b->size + size > b->room) {
        b->room = 2 * (b->size + size);
        b->at = realloc(b->at, b->room);
        if (!b->at) exit(1);
    }
    if (size) memcpy(b->at + b->size, data, size);
    b->size += size;
}

#if defined(__GNUC__)
__attribute__((format(printf, 2, 3)))
#endif
static void
print(bytes *b, const char *format, ...) {
    char text[4096];
    va_list arguments;
    va_start(arguments, format);
    int length = vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    put(b, text, (size_t)length);
}

static void put_u32(bytes *b, uint32_t number) {
    for (int i = 0; i < 4; ++i) put(b, &(unsigned char){(unsigned char)(number >> 8 * i)}, 1);
}

static void put_float(bytes *b, float number) {
    uint32_t bits;
    memcpy(&bits, &number, sizeof bits);
    put_u32(b, bits);
}

/* Writes b as FOLDER/name and empties it. */
static void save(bytes *b, const char *name) {
    char path[4096];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "wb");
    if (!file || fwrite(b->at, 1, b->size, file) != b->size || fclose(file)) {
        fprintf(stderr, "hostile_files: %s cannot be written\n", path);
        exit(1);
    }
    free(b->at);
    *b = (bytes){0};
}

static const char *const counts[] = {"2147483647", "2147483648", "4294967295", "4294967296",
    "9223372036854775808", "18446744073709551615", "18446744073709551616", "-1"};
enum { COUNTS = sizeof counts / sizeof counts[0] };

/* ---- PLY */

static void put_corners(bytes *b) {
    static const float places[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    for (int i = 0; i < 9; ++i) put_float(b, places[i]);
}

static void ply_counts(void) {
    static const char *const fields[] = {"vertex", "face", "edge"};
    char name[256];
    for (int binary = 0; binary < 2; ++binary)
        for (int field = 0; field < 3; ++field)
            for (int c = 0; c < COUNTS; ++c) {
                bytes b = {0};
                const char *const count[3] = {field == 0 ? counts[c] : "3",
                    field == 1 ? counts[c] : "1", field == 2 ? counts[c] : "0"};
                print(&b,
                    "ply\nformat %s 1.0\nelement vertex %s\nproperty float x\nproperty float "
                    "y\nproperty float z\n",
                    binary ? "binary_little_endian" : "ascii", count[0]);
                print(&b,
                    "element edge %s\nproperty int vertex1\nproperty int vertex2\nelement face "
                    "%s\nproperty list uchar int vertex_indices\nend_header\n",
                    count[2], count[1]);
                if (binary) {
                    put_corners(&b);
                    put(&b, "\3\0\0\0\0\1\0\0\0\2\0\0\0", 13);
                } else
                    print(&b, "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
                snprintf(name, sizeof name, "%s-%s-count-%s.ply", binary ? "binary" : "text",
                    fields[field], counts[c]);
                save(&b, name);
            }
}

/* The length of a face's list, and a number in it. */
static void ply_lists(void) {
    static const uint32_t numbers[] = {0x7fffffff, 0x80000000, 0xffffffff, 0xfffffffc};
    static const char *const types[] = {"int", "uint"};
    char name[256];
    for (int t = 0; t < 2; ++t)
        for (int n = 0; n < 4; ++n)
            for (int of_index = 0; of_index < 2; ++of_index) {
                bytes b = {0};
                print(&b, "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float "
                          "x\nproperty float y\nproperty float z\nelement face 1\n");
                print(&b, "property list %s %s vertex_indices\nend_header\n", types[t], types[t]);
                put_corners(&b);
                put_u32(&b, of_index ? 3 : numbers[n]);
                put_u32(&b, of_index ? numbers[n] : 0);
                put_u32(&b, 1);
                put_u32(&b, 2);
                snprintf(name, sizeof name, "%s-%s-%08x.ply", of_index ? "index" : "list", types[t],
                    (unsigned)numbers[n]);
                save(&b, name);
            }
}

/* ---- OBJ: numbers of vertices */

static void obj_indices(void) {
    char name[256];
    for (int c = 0; c < COUNTS; ++c)
        for (int kind = 0; kind < 3; ++kind) {
            bytes b = {0};
            const char *sign = kind == 2 && counts[c][0] != '-' ? "-" : "";
            print(&b, "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\n");
            if (kind == 1)
                print(&b, "f 1//1 2//1 3//%s\n", counts[c][0] == '-' ? "-2" : counts[c]);
            else
                print(&b, "f 1 2 %s%s\n", sign, counts[c][0] == '-' ? "-4" : counts[c]);
            snprintf(name, sizeof name, "%s-%s%s.obj", kind == 1 ? "normal" : "vertex",
                kind == 2 ? "back-" : "", counts[c]);
            save(&b, name);
        }
}

/* ---- STL */

static void stl_counts(void) {
    static const uint32_t numbers[] = {
        2, 0x7fffffff, 0x80000000, 0xffffffff, 85899346 /* times 50 it wraps in 32 bits */};
    char name[256];
    for (size_t n = 0; n < sizeof numbers / sizeof numbers[0]; ++n) {
        bytes b = {0};
        print(&b, "%-80s", "binary");
        put_u32(&b, numbers[n]);
        for (int i = 0; i < 3; ++i) put_float(&b, i == 2);
        put_corners(&b);
        put(&b, "\0\0", 2);
        snprintf(name, sizeof name, "facets-%u.stl", (unsigned)numbers[n]);
        save(&b, name);
    }
}

/* ---- glTF: one asset, of which one number is another */

typedef struct asset {
    const char *accessor_count, *accessor_offset, *accessor_view, *indices_offset, *view_offset,
        *view_length, *stride, *buffer_length, *view_buffer;
    const char *sparse_count, *sparse_index_view, *sparse_index_offset, *sparse_value_view,
        *sparse_value_offset, *indices, *position, *mesh, *root, *children, *skin, *material,
        *targets, *component;
    const char *uri; /* NULL: the bytes as a data: URI */
    const char *mode;
    uint32_t sparse_index;
} asset;

static const asset whole = {"3", "0", "0", "0", "0", "36", "12", "52", "0", NULL, "2", "0", "0",
    "0", "1", "0", "0", "0", "", "", "", "", "5126", NULL, "4", 0};

static void put_base64(bytes *b, const bytes *from) {
    static const char letters[] =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t i = 0; i < from->size; i += 3) {
        uint32_t bits = (uint32_t)from->at[i] << 16 |
                        (i + 1 < from->size ? (uint32_t)from->at[i + 1] << 8 : 0) |
                        (i + 2 < from->size ? from->at[i + 2] : 0);
        for (size_t k = 0; k < 4; ++k)
            put(b, i + k > from->size ? "=" : &letters[bits >> (18 - 6 * k) & 63], 1);
    }
}

/* 36 bytes of positions, three indices of 16 bits, two of padding, one sparse index of 32 bits, and
 * again: 52 in all. */
static bytes asset_bytes(const asset *a) {
    bytes b = {0};
    put_corners(&b);
    put(&b, "\0\0\1\0\2\0\0\0", 8);
    put_u32(&b, a->sparse_index);
    put_u32(&b, 0);
    return b;
}

static void save_asset(const asset *a, const char *name) {
    bytes b = {0}, data = asset_bytes(a);
    print(&b,
        "{\"asset\":{\"version\":\"2.0\"},\"scenes\":[{\"nodes\":[%s]}],\"nodes\":[{\"mesh\":%s%s%"
        "s}],",
        a->root, a->mesh, a->children, a->skin);
    print(&b,
        "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":%s},\"indices\":%s,\"mode\":%s%"
        "s%s}]}],\"accessors\":[",
        a->position, a->indices, a->mode, a->material, a->targets);
    print(&b,
        "{\"bufferView\":%s,\"byteOffset\":%s,\"componentType\":%s,\"type\":\"VEC3\",\"count\":%s",
        a->accessor_view, a->accessor_offset, a->component, a->accessor_count);
    if (a->sparse_count)
        print(&b,
            ",\"sparse\":{\"count\":%s,\"indices\":{\"bufferView\":%s,\"byteOffset\":%s,"
            "\"componentType\":5125},\"values\":{\"bufferView\":%s,\"byteOffset\":%s}}",
            a->sparse_count, a->sparse_index_view, a->sparse_index_offset, a->sparse_value_view,
            a->sparse_value_offset);
    print(&b,
        "},{\"bufferView\":1,\"byteOffset\":%s,\"componentType\":5123,\"type\":\"SCALAR\","
        "\"count\":3}],",
        a->indices_offset);
    print(&b,
        "\"bufferViews\":[{\"buffer\":%s,\"byteOffset\":%s,\"byteLength\":%s,\"byteStride\":%s},",
        a->view_buffer, a->view_offset, a->view_length, a->stride);
    print(&b,
        "{\"buffer\":0,\"byteOffset\":36,\"byteLength\":8},{\"buffer\":0,\"byteOffset\":44,"
        "\"byteLength\":8}],\"buffers\":[{\"byteLength\":%s,\"uri\":\"",
        a->buffer_length);
    if (a->uri)
        print(&b, "%s", a->uri);
    else {
        print(&b, "data:application/octet-stream;base64,");
        put_base64(&b, &data);
    }
    print(&b, "\"}]}");
    save(&b, name);
    free(data.at);
}

static void gltf_numbers(void) {
    static const char *const numbers[] = {"2147483647", "2147483648", "4294967295", "4294967296",
        "9007199254740993", "18446744073709551615", "18446744073709551616", "1e300", "-1", "0.5"};
    static const struct {
        const char *name;
        size_t field;
        int sparse;
    } fields[] = {{"accessor-count", offsetof(asset, accessor_count), 0},
        {"accessor-byteOffset", offsetof(asset, accessor_offset), 0},
        {"accessor-bufferView", offsetof(asset, accessor_view), 0},
        {"indices-byteOffset", offsetof(asset, indices_offset), 0},
        {"view-byteOffset", offsetof(asset, view_offset), 0},
        {"view-byteLength", offsetof(asset, view_length), 0},
        {"view-byteStride", offsetof(asset, stride), 0},
        {"view-buffer", offsetof(asset, view_buffer), 0},
        {"buffer-byteLength", offsetof(asset, buffer_length), 0},
        {"sparse-count", offsetof(asset, sparse_count), 1},
        {"sparse-indices-bufferView", offsetof(asset, sparse_index_view), 1},
        {"sparse-indices-byteOffset", offsetof(asset, sparse_index_offset), 1},
        {"sparse-values-bufferView", offsetof(asset, sparse_value_view), 1},
        {"sparse-values-byteOffset", offsetof(asset, sparse_value_offset), 1},
        {"indices", offsetof(asset, indices), 0}, {"position", offsetof(asset, position), 0},
        {"node-mesh", offsetof(asset, mesh), 0}, {"scene-node", offsetof(asset, root), 0},
        {"componentType", offsetof(asset, component), 0}, {"mode", offsetof(asset, mode), 0}};
    char name[256];
    for (size_t f = 0; f < sizeof fields / sizeof fields[0]; ++f)
        for (size_t n = 0; n < sizeof numbers / sizeof numbers[0]; ++n) {
            asset a = whole;
            a.sparse_count = fields[f].sparse ? "1" : NULL;
            memcpy((char *)&a + fields[f].field, &numbers[n], sizeof numbers[n]);
            snprintf(name, sizeof name, "%s-%s.gltf", fields[f].name, numbers[n]);
            save_asset(&a, name);
        }
}

static void gltf_places(void) {
    asset a = whole;
    save_asset(&a, "fine.gltf");
    a.indices = "0"; /* positions as indices */
    save_asset(&a, "overlap-indices-are-positions.gltf");
    a = whole, a.indices_offset = "4", save_asset(&a, "overrun-indices-by-two-bytes.gltf");
    a = whole, a.accessor_offset = "4", save_asset(&a, "overrun-positions-by-four-bytes.gltf");
    a = whole, a.accessor_count = "4", save_asset(&a, "overrun-positions-by-one.gltf");
    a = whole, a.view_offset = "17", save_asset(&a, "overrun-view-by-one-byte.gltf");
    a = whole, a.view_offset = "18446744073709551608", a.view_length = "44",
    save_asset(&a, "wrap-view.gltf");
    a = whole, a.accessor_offset = "18446744073709551612", a.accessor_count = "2",
    save_asset(&a, "wrap-accessor-byteOffset.gltf");
    a = whole, a.accessor_count = "1537228672809129302",
    save_asset(&a, "wrap-accessor-count.gltf"); /* times 12 it wraps to 8 */
    a = whole, a.stride = "9223372036854775808", save_asset(&a, "wrap-stride.gltf");
    a = whole, a.stride = "1", save_asset(&a, "overlap-elements.gltf");
    a = whole, a.view_offset = "8", save_asset(&a, "overlap-views.gltf");
    a = whole, a.sparse_count = "1", a.sparse_index = 3, save_asset(&a, "sparse-index-3-of-3.gltf");
    a = whole, a.sparse_count = "1", a.sparse_index = UINT32_MAX,
    save_asset(&a, "sparse-index-4294967295.gltf");
    a = whole, a.sparse_count = "2", a.sparse_index = 0,
    save_asset(&a, "sparse-indices-not-rising.gltf");
    a = whole, a.sparse_count = "4", save_asset(&a, "sparse-count-above-count.gltf");
    a = whole, a.material = ",\"material\":4294967296", save_asset(&a, "material-4294967296.gltf");
    a = whole, a.skin = ",\"skin\":4294967296", save_asset(&a, "skin-4294967296.gltf");
    a = whole, a.targets = ",\"targets\":[{\"POSITION\":4294967296}]",
    save_asset(&a, "target-4294967296.gltf");
    a = whole, a.children = ",\"children\":[4294967296]", save_asset(&a, "child-4294967296.gltf");
    a = whole, a.children = ",\"children\":[0]", save_asset(&a, "cycle-of-one.gltf");
    a = whole, a.children = ",\"children\":[1]},{\"children\":[2]},{\"children\":[1]",
    save_asset(&a, "cycle-beside-the-scene.gltf");
    a = whole, a.children = ",\"children\":[1]},{\"children\":[2]},{\"children\":[0]",
    save_asset(&a, "cycle-of-three.gltf");
    a = whole, a.children = ",\"children\":[1,1]},{\"name\":\"twice\"",
    save_asset(&a, "child-twice.gltf");
    a = whole, a.children = ",\"children\":[2]},{\"children\":[2]},{\"mesh\":0",
    save_asset(&a, "two-parents.gltf");
}

/* ---- URIs out of the folder; tests/cli/hostile.sh has put files and links there */

static void gltf_uris(void) {
    static const struct {
        const char *name, *uri;
    } uris[] = {{"fine", "inside.bin"}, {"fine-below", "below/inside.bin"},
        {"fine-link", "link-inside.bin"}, {"fine-escaped", "in%73ide.bin"},
        {"parent", "../outside.bin"}, {"parent-later", "below/../../outside.bin"},
        {"parent-escaped", "%2e%2e/outside.bin"}, {"parent-slash-escaped", "..%2foutside.bin"},
        {"parent-half-escaped", ".%2E/outside.bin"},
        {"parent-twice-escaped", "%252e%252e/outside.bin"},
        {"parent-and-back", "../files/inside.bin"}, {"backslash", "..\\\\outside.bin"},
        {"backslash-escaped", "..%5Coutside.bin"}, {"absolute", "/etc/passwd"},
        {"absolute-escaped", "%2fetc%2fpasswd"}, {"two-slashes", "//host/share.bin"},
        {"file", "file:///etc/passwd"}, {"file-relative", "file:inside.bin"},
        {"http", "http://127.0.0.1/a.bin"}, {"https-escaped", "https%3A//127.0.0.1/a.bin"},
        {"drive", "C:/a.bin"}, {"link", "link-outside.bin"}, {"link-folder", "linked/outside.bin"},
        {"empty", ""}, {"dot", "."}, {"folder", "below"}, {"null", "inside.bin%00.png"},
        {"bad-escape", "inside%zz.bin"}, {"cut-escape", "inside.bin%2"},
        {"data-not-base64", "data:application/octet-stream;base64,????"},
        {"data-short", "data:application/octet-stream;base64,AAAA"},
        {"data-no-comma", "data:application/octet-stream;base64"}, {"device", "zero"},
        {"missing", "missing.bin"}};
    char name[256];
    for (size_t i = 0; i < sizeof uris / sizeof uris[0]; ++i) {
        asset a = whole;
        a.uri = uris[i].uri;
        snprintf(name, sizeof name, "uri-%s.gltf", uris[i].name);
        save_asset(&a, name);
    }
    bytes b = asset_bytes(&whole);
    save(&b, "inside.bin");
}

/* ---- depth, and little that stands for much */

static void repeat(bytes *b, const char *text, size_t times) {
    for (size_t i = 0; i < times; ++i) put(b, text, strlen(text));
}

static void gltf_depth(void) {
    static const struct {
        const char *name, *open, *close;
    } nests[] = {{"arrays", "[", "]"}, {"objects", "{\"a\":", "}"}, {"arrays-open", "[", ""}};
    char name[256];
    for (size_t i = 0; i < 3; ++i)
        for (size_t depth = 100; depth <= 1000000; depth *= 100) {
            bytes b = {0};
            print(&b, "{\"asset\":{\"version\":\"2.0\"},\"extras\":");
            repeat(&b, nests[i].open, depth);
            print(&b, "0");
            repeat(&b, nests[i].close, depth);
            print(&b, "}");
            snprintf(name, sizeof name, "nested-%s-%zu.gltf", nests[i].name, depth);
            save(&b, name);
        }
    bytes b = {0};
    print(&b, "{\"asset\":{\"version\":\"2.0\"},\"scenes\":[{\"nodes\":[0]}],\"nodes\":[");
    for (int n = 1; n < 50000; ++n) print(&b, "{\"children\":[%d]},", n);
    print(&b, "{}]}");
    save(&b, "nodes-50000-deep.gltf");
}

/* Many primitives of one accessor, many accessors without bytes: each line of the file would be a
 * copy of all of it. */
static void gltf_many(void) {
    enum { PRIMITIVES = 4000, VERTICES = 20000 };
    bytes b = {0}, zeros = {0};
    print(&b, "{\"asset\":{\"version\":\"2.0\"},\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":"
              "0}],\"meshes\":[{\"primitives\":[");
    for (int i = 0; i < PRIMITIVES; ++i)
        print(&b, "%s{\"attributes\":{\"POSITION\":0,\"NORMAL\":0}}", i ? "," : "");
    print(&b,
        "]}],\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"type\":\"VEC3\",\"count\":%"
        "d}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":%d}],\"buffers\":[{\"byteLength\":%d,"
        "\"uri\":\"data:;base64,",
        VERTICES, 12 * VERTICES, 12 * VERTICES);
    for (int i = 0; i < 3 * VERTICES; ++i) put_float(&zeros, (float)(i % 7));
    put_base64(&b, &zeros);
    free(zeros.at);
    print(&b, "\"}]}");
    save(&b, "many-primitives-of-one-accessor.gltf");
    print(&b, "{\"asset\":{\"version\":\"2.0\"},\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":"
              "0}],\"meshes\":[{\"primitives\":[");
    for (int i = 0; i < PRIMITIVES; ++i)
        print(&b, "%s{\"attributes\":{\"POSITION\":%d}}", i ? "," : "", i);
    print(&b, "]}],\"accessors\":[");
    for (int i = 0; i < PRIMITIVES; ++i)
        print(&b, "%s{\"componentType\":5126,\"type\":\"VEC3\",\"count\":300000}", i ? "," : "");
    print(&b, "]}");
    save(&b, "many-accessors-without-bytes.gltf");
}

/* The end of an asset: one buffer, one view of all of it. */
static void end_asset(bytes *b, const bytes *data) {
    print(b,
        "\"bufferViews\":[{\"buffer\":0,\"byteLength\":%zu}],\"buffers\":[{\"byteLength\":%zu,"
        "\"uri\":\"data:;base64,",
        data->size, data->size);
    put_base64(b, data);
    print(b, "\"}]}");
}

/* Five thousand morph targets of one accessor, a thousand nodes with thirty thousand instances of
 * one, a chain of two thousand joints under two thousand channels of one sampler. */
static void gltf_shared(void) {
    enum {
        VERTICES = 9999,
        TARGETS = 5000,
        INSTANCES = 30000,
        NODES = 1000,
        JOINTS = 2000,
        KEYS = 5000
    };
    bytes b = {0}, data = {0};
    for (int i = 0; i < 3 * INSTANCES; ++i) put_float(&data, (float)(i % 7 + 1));
    print(&b,
        "{\"asset\":{\"version\":\"2.0\"},\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":"
        "[{\"attributes\":{\"POSITION\":0,\"NORMAL\":0},\"targets\":[{\"POSITION\":0}");
    for (int i = 1; i < TARGETS; ++i) print(&b, ",{\"POSITION\":0,\"NORMAL\":0}");
    print(&b,
        "]}]}],\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"type\":\"VEC3\",\"count\":"
        "%d}],",
        VERTICES);
    end_asset(&b, &data);
    save(&b, "many-targets-of-one-accessor.gltf");
    print(&b, "{\"asset\":{\"version\":\"2.0\"},\"extensionsUsed\":[\"EXT_mesh_gpu_instancing\"],"
              "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":1}}]}],\"nodes\":[");
    for (int i = 0; i < NODES; ++i)
        print(&b,
            "%s{\"mesh\":0,\"extensions\":{\"EXT_mesh_gpu_instancing\":{\"attributes\":{"
            "\"TRANSLATION\":0}}}}",
            i ? "," : "");
    print(&b,
        "],\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"type\":\"VEC3\",\"count\":%d},"
        "{\"bufferView\":0,\"componentType\":5126,\"type\":\"VEC3\",\"count\":3}],",
        INSTANCES);
    end_asset(&b, &data);
    save(&b, "many-instances-of-one-accessor.gltf");
    print(&b, "{\"asset\":{\"version\":\"2.0\"},\"meshes\":[{\"primitives\":[{\"attributes\":{"
              "\"POSITION\":0}}]}],\"nodes\":[{\"mesh\":0,\"skin\":0}");
    for (int i = 1; i < JOINTS; ++i) print(&b, ",{\"children\":[%d]}", i + 1);
    print(&b, ",{}],\"skins\":[{\"joints\":[1");
    for (int i = 2; i <= JOINTS; ++i) print(&b, ",%d", i);
    print(&b, "]}],\"animations\":[{\"samplers\":[{\"input\":1,\"output\":2}],\"channels\":[{"
              "\"sampler\":0,\"target\":{\"node\":1,\"path\":\"scale\"}}");
    for (int i = 2; i <= JOINTS; ++i)
        print(&b, ",{\"sampler\":0,\"target\":{\"node\":%d,\"path\":\"scale\"}}", i);
    print(&b,
        "]}],\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"type\":\"VEC3\",\"count\":3}"
        ",{\"bufferView\":0,\"componentType\":5126,\"type\":\"SCALAR\",\"count\":%d},",
        KEYS);
    print(&b, "{\"bufferView\":0,\"componentType\":5126,\"type\":\"VEC3\",\"count\":%d}],", KEYS);
    for (int i = 0; i < KEYS; ++i) memcpy(data.at + 4 * i, &(float){(float)i}, 4);
    end_asset(&b, &data);
    save(&b, "many-keys-over-many-joints.gltf");
    free(data.at);
}

/* What would take the square of its size: skins under a root of many members, meshes or primitives
 * of one position that have nothing else in common, nodes that share a mesh, which baking parts,
 * nodes with a mesh each, all of the same vertices, and attributes without number. */
static void gltf_squares(void) {
    enum {
        MEMBERS = 60000,
        SKINS = 30000,
        PRIMITIVES = 20000,
        NODES = 20000,
        DRAWN = 8000,
        ATTRIBUTES = 20000
    };
    static const char accessor[] = "{\"componentType\":5126,\"type\":\"VEC3\",\"count\":3}";
    bytes b = {0};
    print(&b, "{\"asset\":{\"version\":\"2.0\"}");
    repeat(&b, ",\"a\":0", MEMBERS);
    print(&b, ",\"skins\":[{}");
    repeat(&b, ",{}", SKINS);
    print(&b, "]}");
    save(&b, "many-skins.gltf");
    print(&b, "{\"asset\":{\"version\":\"2.0\"},\"accessors\":[%s", accessor);
    for (int i = 1; i <= PRIMITIVES; ++i) print(&b, ",%s", accessor);
    print(&b, "],\"meshes\":[{\"primitives\":[");
    for (int i = 1; i <= PRIMITIVES; ++i)
        print(&b, "%s{\"attributes\":{\"POSITION\":0,\"_A\":%d}}", i > 1 ? "," : "", i);
    print(&b, "]}]}");
    save(&b, "many-primitives-of-one-position.gltf");
    print(&b,
        "{\"asset\":{\"version\":\"2.0\"},\"accessors\":[%s],\"meshes\":[{\"primitives\":[{"
        "\"attributes\":{\"POSITION\":0}}]}],\"nodes\":[{\"mesh\":0}",
        accessor);
    repeat(&b, ",{\"mesh\":0}", NODES);
    print(&b, "]}");
    save(&b, "many-nodes-of-one-mesh.gltf");
    print(&b,
        "{\"asset\":{\"version\":\"2.0\"},\"accessors\":[%s,{\"componentType\":5126,\"type\":"
        "\"VEC2\",\"count\":3}],\"nodes\":[{\"mesh\":0}",
        accessor);
    for (int i = 1; i < DRAWN; ++i) print(&b, ",{\"mesh\":%d}", i);
    static const char drawn[] =
        "{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"NORMAL\":0,\"TEXCOORD_0\":1}}]}";
    print(&b, "],\"meshes\":[%s", drawn);
    for (int i = 1; i < DRAWN; ++i) print(&b, ",%s", drawn);
    print(&b, "]}");
    save(&b, "many-drawn-meshes.gltf");
    print(&b,
        "{\"asset\":{\"version\":\"2.0\"},\"accessors\":[%s],\"meshes\":[{\"primitives\":[{"
        "\"attributes\":{\"POSITION\":0",
        accessor);
    for (int i = 0; i < ATTRIBUTES; ++i) print(&b, ",\"_A%d\":0", i);
    print(&b, "}}]}]}");
    save(&b, "many-attributes.gltf");
}

/* One polygon of three hundred thousand corners that lie at three places, and one with teeth at
 * right angles to it, whose corners turn to no side: what costs as much as it has corners, at each
 * of them, never ends. */
static void obj_polygon(void) {
    enum { TEETH = 20001 };
    bytes b = {0};
    print(&b, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf");
    repeat(&b, " 1 2 3", 100000);
    print(&b, "\n");
    save(&b, "polygon-of-300000-corners.obj");
    for (int i = 0; i < TEETH; ++i) print(&b, "v %d 0 %d\n", i, (int[]){0, 1, 0, -1}[i % 4]);
    print(&b, "v %d 3 0\nv 0 3 0\nf", TEETH);
    for (int i = 1; i <= TEETH + 2; ++i) print(&b, " %d", i);
    print(&b, "\n");
    save(&b, "polygon-of-upright-teeth.obj");
}

/* ---- GLB */

static void glb_lengths(void) {
    static const uint32_t numbers[] = {
        0, 11, 12, 20, 0x7fffffff, 0x80000000, 0xfffffff0, 0xffffffff};
    static const char *const fields[] = {"length", "json-length", "bin-length", "version"};
    char name[256];
    for (int field = 0; field < 4; ++field)
        for (size_t n = 0; n < sizeof numbers / sizeof numbers[0]; ++n) {
            bytes b = {0}, json = {0}, bin = asset_bytes(&whole);
            print(&json,
                "{\"asset\":{\"version\":\"2.0\"},\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{"
                "\"mesh\":0}],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],");
            print(&json, "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"type\":"
                         "\"VEC3\",\"count\":3}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}]"
                         ",\"buffers\":[{\"byteLength\":52}]}");
            while (json.size % 4) put(&json, " ", 1);
            put(&b, "glTF", 4);
            put_u32(&b, field == 3 ? numbers[n] : 2);
            put_u32(&b, field == 0 ? numbers[n] : (uint32_t)(28 + json.size + bin.size));
            put_u32(&b, field == 1 ? numbers[n] : (uint32_t)json.size);
            put(&b, "JSON", 4);
            put(&b, json.at, json.size);
            put_u32(&b, field == 2 ? numbers[n] : (uint32_t)bin.size);
            put(&b, "BIN", 4);
            put(&b, bin.at, bin.size);
            free(json.at);
            free(bin.at);
            snprintf(name, sizeof name, "glb-%s-%08x.glb", fields[field], (unsigned)numbers[n]);
            save(&b, name);
        }
    bytes b = {0}; /* 4 GiB by declaration, 80 bytes in fact */
    put(&b, "glTF", 4);
    put_u32(&b, 2);
    put_u32(&b, 0xffffffff);
    put_u32(&b, 28);
    print(&b, "JSON{\"asset\":{\"version\":\"2.0\"}} ");
    put_u32(&b, 0xffffffff - 48);
    put(&b, "BIN\0abcdefgh", 12);
    save(&b, "glb-of-4-gib.glb");
}

int main(int count, char **arguments) {
    if (count != 2) {
        fprintf(stderr, "usage: hostile_files FOLDER\n");
        return 2;
    }
    folder = arguments[1];
    ply_counts();
    ply_lists();
    obj_indices();
    stl_counts();
    gltf_numbers();
    gltf_places();
    gltf_uris();
    gltf_depth();
    gltf_many();
    gltf_shared();
    gltf_squares();
    obj_polygon();
    glb_lengths();
    return 0;
}
