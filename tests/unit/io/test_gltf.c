/* test_gltf.c: glTF in small: closed forms of what compute gives, what else must not change, and
 * where files go. The assets are made here, their buffers as data: URIs or as files in a folder of
 * the test's own. */
#define _GNU_SOURCE
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include "document_bytes.h"
#include "io/gltf/gltf.h"

/* ---- making assets */

typedef struct bytes {
    unsigned char data[1 << 16];
    size_t size;
} bytes;

static void add_floats(bytes *b, const float *values, size_t count) {
    memcpy(b->data + b->size, values, count * sizeof *values);
    b->size += count * sizeof *values;
}

static void add_shorts(bytes *b, const uint16_t *values, size_t count) {
    memcpy(b->data + b->size, values, count * sizeof *values);
    b->size += count * sizeof *values;
}

static char *base64(const bytes *b) {
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    char *out = calloc(b->size * 2 + 8, 1), *to = out;
    for (size_t i = 0; i < b->size; i += 3) {
        unsigned bits = (unsigned)b->data[i] << 16 | (unsigned)b->data[i + 1] << 8 | b->data[i + 2];
        for (int k = 18; k >= 0; k -= 6) *to++ = digits[bits >> k & 63];
    }
    return out; /* zeros at the end instead of padding: longer than byteLength, which is allowed */
}

/* format holds one %s for the data: URI. */
static document_bytes asset(const char *format, const bytes *b) {
    char *code = base64(b), *text = NULL, *uri = NULL;
    assert_true(asprintf(&uri, "data:application/octet-stream;base64,%s", code) > 0);
    size_t size = strlen(format) + strlen(uri) + 16;
    text = malloc(size);
    const char *place = strstr(format, "@URI@");
    assert_non_null(place);
    snprintf(text, size, "%.*s%s%s", (int)(place - format), format, uri, place + 5);
    document_bytes made = bytes_copy(text, strlen(text));
    free(code);
    free(uri);
    free(text);
    return made;
}

static const float CUBE[24] = {
    -1, -1, -1, 1, -1, -1, 1, 1, -1, -1, 1, -1, -1, -1, 1, 1, -1, 1, 1, 1, 1, -1, 1, 1};
static const uint16_t CUBE_CORNERS[36] = {0, 2, 1, 0, 3, 2, 4, 5, 6, 4, 6, 7, 0, 1, 5, 0, 5, 4, 2,
    3, 7, 2, 7, 6, 1, 2, 6, 1, 6, 5, 3, 0, 4, 3, 4, 7};

/* Eight vertices, a colour on each, names and numbers of every spelling that must survive. */
static const char CUBE_TEXT[] =
    "{ \"asset\":{\"version\":\"2.0\",\"generator\":\"hand\\u00e9\"}, "
    "\"extras\":{\"big\":12345678901234567890, \"zero\":-0.0, \"a\":1, \"a\":2},\n"
    "  "
    "\"meshes\":[{\"name\":\"cube\",\"primitives\":[{\"attributes\":{\"POSITION\":0,\"COLOR_0\":2,"
    "\"_ID\":3},\"indices\":1,\"extras\":[1.50]}]}],\n"
    "  "
    "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":8,\"type\":\"VEC3\",\"min\":"
    "[-1.00,-1,-1],\"max\":[1,1,1e0]},\n"
    "    {\"bufferView\":1,\"componentType\":5123,\"count\":36,\"type\":\"SCALAR\"},\n"
    "    "
    "{\"bufferView\":2,\"componentType\":5121,\"normalized\":true,\"count\":8,\"type\":\"VEC4\"},\n"
    "    {\"bufferView\":3,\"componentType\":5126,\"count\":8,\"type\":\"SCALAR\"}],\n"
    "  "
    "\"bufferViews\":[{\"buffer\":0,\"byteLength\":96,\"target\":34962},{\"buffer\":0,"
    "\"byteOffset\":96,\"byteLength\":72,\"target\":34963},\n"
    "    "
    "{\"buffer\":0,\"byteOffset\":168,\"byteLength\":32,\"target\":34962},{\"buffer\":0,"
    "\"byteOffset\":200,\"byteLength\":32,\"target\":34962}],\n"
    "  \"buffers\":[{\"byteLength\":232,\"uri\":\"@URI@\"}] }\n";

static void cube_bytes(bytes *b) {
    b->size = 0;
    add_floats(b, CUBE, 24);
    add_shorts(b, CUBE_CORNERS, 36);
    for (int i = 0; i < 32; ++i) b->data[b->size++] = (unsigned char)(i * 7);
    for (int i = 0; i < 8; ++i) add_floats(b, &(float){(float)i}, 1);
}

static document_bytes cube(void) {
    static bytes b;
    cube_bytes(&b);
    return asset(CUBE_TEXT, &b);
}

/* ---- looking at results */

static const gltf *inside(norma_document *document) { return norma_gltf_of(document); }

static gltf_array array_of(norma_document *document, uint32_t accessor) {
    gltf_array array;
    norma_document_error error;
    if (norma_gltf_array(norma_gltf_of(document), accessor, &array, &error))
        fail_msg("%s", error.message);
    return array;
}

static uint32_t attribute(norma_document *document, uint32_t primitive, const char *name) {
    const gltf *g = inside(document);
    uint32_t found = norma_gltf_find(g, &g->primitives[primitive].base, name);
    return found == GLTF_NONE ? GLTF_NONE : g->attributes[found].accessor;
}

static int contains(document_bytes text, const char *part) {
    return memmem(text.data, text.size, part, strlen(part)) != NULL;
}

static const uint32_t *corners_of(norma_document *document, uint32_t primitive) {
    const uint32_t *corners;
    norma_document_error error;
    if (norma_gltf_corners(norma_gltf_of(document), primitive, &corners, &error))
        fail_msg("%s", error.message);
    return corners;
}

static void element(norma_document *document, uint32_t accessor, size_t index, float out[16]) {
    gltf_array array = array_of(document, accessor);
    norma_gltf_floats(&array, index, out);
}

/* ---- compute */

static void a_cube_gets_its_faces_normals(void **state) {
    norma_compute_summary summary;
    document_bytes in = cube(), out = bytes_computed(in, "cube.gltf", NULL, &summary);
    norma_document *after = bytes_open(out, "cube.gltf");
    (void)state;
    assert_int_equal(summary.changed, 1);
    assert_int_equal(summary.vertices_before, 8);
    assert_int_equal(summary.vertices_after, 24);
    assert_int_equal(summary.hard_edges, 12);
    const uint32_t *corners = corners_of(after, 0);
    for (size_t c = 0; c < 36; ++c) {
        float position[16], normal[16], id[16];
        const float *was = CUBE + 3 * CUBE_CORNERS[c];
        element(after, attribute(after, 0, "POSITION"), corners[c], position);
        element(after, attribute(after, 0, "NORMAL"), corners[c], normal);
        element(after, attribute(after, 0, "_ID"), corners[c], id);
        assert_memory_equal(position, was, 12);
        assert_true(id[0] == (float)CUBE_CORNERS[c]);
        const float *a = CUBE + 3 * CUBE_CORNERS[c / 3 * 3],
                    *b = CUBE + 3 * CUBE_CORNERS[c / 3 * 3 + 1],
                    *d = CUBE + 3 * CUBE_CORNERS[c / 3 * 3 + 2];
        for (int k = 0; k < 3; ++k) { /* the axis along which the face's corners agree */
            float expected = a[k] == b[k] && b[k] == d[k] ? a[k] : 0;
            assert_true(normal[k] == expected);
        }
    }
    norma_document_close(after);
    bytes_free(&out);
    bytes_free(&in);
}

static void smooth_adds_no_vertex(void **state) {
    norma_compute_summary summary;
    const norma_compute_options options = {
        .struct_size = sizeof options, .shading = NORMA_SHADING_SMOOTH};
    document_bytes in = cube(), out = bytes_computed(in, "cube.gltf", &options, &summary);
    norma_document *after = bytes_open(out, "cube.gltf");
    (void)state;
    assert_int_equal(summary.vertices_after, 8);
    for (size_t v = 0; v < 8; ++v) {
        float normal[16];
        element(after, attribute(after, 0, "NORMAL"), v, normal);
        for (int k = 0; k < 3; ++k)
            assert_true(fabs((double)normal[k] - (double)CUBE[3 * v + (size_t)k] / sqrt(3)) < 1e-7);
    }
    norma_document_close(after);
    bytes_free(&out);
    bytes_free(&in);
}

static void the_rest_of_the_text_stays(void **state) {
    document_bytes in = cube(), out = bytes_computed(in, "cube.gltf", NULL, NULL);
    (void)state;
    assert_true(contains(out,
        "{ \"asset\":{\"version\":\"2.0\",\"generator\":\"hand\\u00e9\"}, "
        "\"extras\":{\"big\":12345678901234567890, \"zero\":-0.0, \"a\":1, \"a\":2},\n"));
    assert_true(contains(out,
        "{\"POSITION\":0,\"COLOR_0\":2,\"_ID\":3,\"NORMAL\":4},\"indices\":1,\"extras\":[1.50]}"));
    assert_true(contains(out, "\"min\":[-1.00,-1,-1],\"max\":[1,1,1e0]}"));
    bytes_free(&out);
    bytes_free(&in);
}

static void a_second_time_changes_nothing(void **state) {
    norma_compute_summary summary;
    document_bytes in = cube(), out = bytes_computed(in, "cube.gltf", NULL, NULL),
                   again = bytes_computed(out, "cube.gltf", NULL, &summary);
    const norma_compute_options missing = {.struct_size = sizeof missing,
                                    .only = NORMA_ONLY_MISSING},
                                broken = {.struct_size = sizeof broken, .only = NORMA_ONLY_BROKEN};
    (void)state;
    assert_int_equal(summary.changed, 0);
    assert_true(bytes_equal(out, again));
    bytes_free(&again);
    again = bytes_computed(out, "cube.gltf", &missing, &summary);
    assert_true(summary.changed == 0 && bytes_equal(out, again));
    bytes_free(&again);
    again = bytes_computed(out, "cube.gltf", &broken, &summary);
    assert_true(summary.changed == 0 && bytes_equal(out, again));
    bytes_free(&again);
    bytes_free(&out);
    bytes_free(&in);
}

/* 31 cubes, 248 vertices, bytes as indices: 744 vertices need shorts; the value 255 is no index. */
static norma_document_result double_it(norma_document *document, norma_document_error *error) {
    const norma_transform_options options = {
        .struct_size = sizeof options, .matrix = {2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1}};
    return norma_document_transform(document, &options, NULL, error);
}

static norma_document_result change(
    norma_document *document, int doubled, norma_document_error *error) {
    return doubled ? double_it(document, error)
                   : norma_document_compute(document, NULL, NULL, error);
}

static document_bytes written(norma_document *document) {
    document_bytes out = bytes_of(document);
    norma_document_close(document);
    return out;
}

/* Two changes are what each is to the file that the other wrote; what is asked between them is of
 * the first; a refused one changes nothing. */
static void a_document_takes_any_changes(void **state) {
    const norma_compute_options unknown = {.struct_size = sizeof unknown, .weight = 99};
    norma_document_error error;
    static bytes b;
    cube_bytes(&b);
    char text[sizeof CUBE_TEXT + 64];
    (void)state;
    snprintf(text, sizeof text,
        "{ \"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}],%s", CUBE_TEXT + 1);
    document_bytes in = asset(text, &b);
    for (int way = 0; way < 8; ++way) {
        const int first = way & 1, second = way >> 1 & 1, asked = way >> 2;
        norma_document *once = bytes_open(in, "cube.gltf"), *both = bytes_open(in, "cube.gltf");
        if (change(once, first, &error) || change(both, first, &error))
            fail_msg("%s", error.message);
        document_bytes between = written(once);
        once = bytes_open(between, "cube.gltf");
        if (change(once, second, &error)) fail_msg("%s", error.message);
        if (asked) {
            norma_mesh_data data;
            assert_int_equal(norma_document_mesh_data(both, 0, &data, &error), NORMA_DOCUMENT_OK);
            assert_int_equal(data.normals.count > 0, !first);
        }
        assert_int_equal(
            norma_document_compute(both, &unknown, NULL, &error), NORMA_DOCUMENT_ERROR_ARGUMENT);
        if (change(both, second, &error)) fail_msg("%s", error.message);
        document_bytes expected = written(once), out = written(both);
        assert_true(bytes_equal(expected, out));
        bytes_free(&between);
        bytes_free(&expected);
        bytes_free(&out);
    }
    bytes_free(&in);
}

static void indices_widen(void **state) {
    static bytes b;
    char text[1200];
    (void)state;
    for (unsigned cubes = 10; cubes <= 31; cubes += 21) {
        b.size = 0;
        for (unsigned i = 0; i < cubes; ++i)
            for (int k = 0; k < 24; ++k)
                add_floats(&b, &(float){CUBE[k] + (float)(k % 3 == 0 ? 10 * i : 0)}, 1);
        size_t positions = b.size;
        for (unsigned i = 0; i < cubes; ++i)
            for (int k = 0; k < 36; ++k)
                b.data[b.size++] = (unsigned char)(8 * i + CUBE_CORNERS[k]);
        snprintf(text, sizeof text,
            "{\"asset\":{\"version\":\"2.0\"},\"meshes\":[{\"primitives\":[{\"attributes\":{"
            "\"POSITION\":0},\"indices\":1}]}],\"accessors\":[{\"bufferView\":0,\"componentType\":"
            "5126,"
            "\"count\":%u,\"type\":\"VEC3\"},{\"bufferView\":1,\"componentType\":5121,\"count\":%u,"
            "\"type\":\"SCALAR\",\"min\":[0],\"max\":[%u]}],\"bufferViews\":[{\"buffer\":0,"
            "\"byteLength\":%zu},"
            "{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%u}],\"buffers\":[{\"byteLength\":%zu,"
            "\"uri\":\"@URI@\"}]}",
            8 * cubes, 36 * cubes, 8 * cubes - 1, positions, positions, 36 * cubes, b.size);
        document_bytes in = asset(text, &b), out = bytes_computed(in, "cubes.gltf", NULL, NULL);
        norma_document *after = bytes_open(out, "cubes.gltf");
        assert_int_equal(
            inside(after)->accessors[1].component, cubes == 10 ? GLTF_UBYTE : GLTF_USHORT);
        assert_int_equal(inside(after)->accessors[0].count, 24 * cubes);
        snprintf(text, sizeof text, "\"max\":[%u]", 24 * cubes - 1);
        assert_true(contains(out, text));
        norma_document_close(after);
        bytes_free(&out);
        bytes_free(&in);
    }
}

/* Two triangles in one plane and a third at a right angle, two materials, one vertex buffer; points
 * over the same positions. */
static void what_is_shared_stays_shared(void **state) {
    static bytes b;
    static const float positions[15] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 0, 1};
    static const uint16_t indices[10] = {0, 1, 2, 1, 3, 2, 0, 2, 4, 0};
    norma_compute_summary summary;
    (void)state;
    b.size = 0;
    add_floats(&b, positions, 15);
    add_shorts(&b, indices, 10);
    document_bytes in =
        asset("{\"asset\":{\"version\":\"2.0\"},\"meshes\":[{\"primitives\":[{\"attributes\":{"
              "\"POSITION\":0},\"indices\":1},{\"attributes\":{\"POSITION\":0},\"indices\":2},"
              "{\"attributes\":{\"POSITION\":0},\"mode\":0}]}],\"accessors\":[{\"bufferView\":0,"
              "\"componentType\":5126,\"count\":5,\"type\":\"VEC3\",\"name\":\"p\\u0020q\","
              "\"extras\":[1.0],\"min\":[0,0.0,0],\"max\":[1,1,1e0]},{\"bufferView\":1,"
              "\"componentType\":5123,\"count\":6,\"type\":\"SCALAR\"},{\"bufferView\":1,"
              "\"byteOffset\":12,\"componentType\":5123,\"count\":3,\"type\":\"SCALAR\"}],"
              "\"bufferViews\":[{\"buffer\":0,\"byteLength\":60},{\"buffer\":0,\"byteOffset\":60,"
              "\"byteLength\":20}],\"buffers\":[{\"byteLength\":80,\"uri\":\"@URI@\"}]}",
            &b);
    document_bytes out = bytes_computed(in, "shared.gltf", NULL, &summary);
    norma_document *after = bytes_open(out, "shared.gltf");
    assert_int_equal(summary.vertices_after - summary.vertices_before,
        2 * 2); /* vertices 0 and 2 lie on the crease, in both primitives' set */
    assert_int_equal(attribute(after, 0, "POSITION"), attribute(after, 1, "POSITION"));
    assert_int_equal(attribute(after, 0, "NORMAL"), attribute(after, 1, "NORMAL"));
    assert_int_equal(attribute(after, 2, "POSITION"), 0); /* the points keep theirs */
    assert_true(
        contains(out, "\"count\":7,\"type\":\"VEC3\",\"min\":[0,0.0,0],\"max\":[1,1,1e0],\"name\":"
                      "\"p\\u0020q\",\"extras\":[1.0]}")); /* the others' is like it */
    assert_int_equal(inside(after)->accessors[0].count, 5);
    assert_int_equal(attribute(after, 2, "NORMAL"), GLTF_NONE);
    for (uint32_t p = 0; p < 2; ++p) {
        const uint32_t *corners = corners_of(after, p);
        for (size_t c = 0; c < (p ? 3u : 6u); ++c) {
            float normal[16];
            element(after, attribute(after, p, "NORMAL"), corners[c], normal);
            assert_true(normal[0] == (p ? 1.0F : 0.0F) && normal[2] == (p ? 0.0F : 1.0F));
        }
    }
    norma_document_close(after);
    bytes_free(&out);
    bytes_free(&in);
}

/* One quad as two primitives, folded by 30 degrees along their seam: one surface, so the seam's
 * normals are the same on both sides. */
static void materials_make_no_seam(void **state) {
    static bytes b;
    static const float positions[24] = {0, 0, 0, 0, 1, 0, -1, 0, 0, -1, 1, 0, /* */ 0, 0, 0, 0, 1,
        0, .8660254F, 0, .5F, .8660254F, 1, .5F};
    static const uint16_t indices[12] = {0, 1, 2, 1, 3, 2, 0, 2, 1, 1, 2, 3};
    (void)state;
    b.size = 0;
    add_floats(&b, positions, 24);
    add_shorts(&b, indices, 12);
    document_bytes in = asset(
        "{\"asset\":{\"version\":\"2.0\"},\"meshes\":[{\"primitives\":[{\"attributes\":{"
        "\"POSITION\":0},\"indices\":2},{\"attributes\":{\"POSITION\":1},\"indices\":3}]}],"
        "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":4,\"type\":\"VEC3\"},{"
        "\"bufferView\":0,\"byteOffset\":48,\"componentType\":5126,\"count\":4,\"type\":\"VEC3\"},"
        "{\"bufferView\":1,\"componentType\":5123,\"count\":6,\"type\":\"SCALAR\"},{\"bufferView\":"
        "1,\"byteOffset\":12,\"componentType\":5123,\"count\":6,\"type\":\"SCALAR\"}],"
        "\"bufferViews\":[{\"buffer\":0,\"byteLength\":96},{\"buffer\":0,\"byteOffset\":96,"
        "\"byteLength\":24}],\"buffers\":[{\"byteLength\":120,\"uri\":\"@URI@\"}]}",
        &b);
    document_bytes out = bytes_computed(in, "fold.gltf", NULL, NULL);
    norma_document *after = bytes_open(out, "fold.gltf");
    for (size_t v = 0; v < 2; ++v) {
        float left[16], right[16];
        element(after, attribute(after, 0, "NORMAL"), v, left);
        element(after, attribute(after, 1, "NORMAL"), v, right);
        assert_memory_equal(left, right, 12);
        assert_true(fabs((double)left[0] + sin(.2617993877991494)) < 1e-6 &&
                    fabs((double)left[2] - cos(.2617993877991494)) < 1e-6); /* half of 30 degrees */
    }
    norma_document_close(after);
    bytes_free(&out);
    bytes_free(&in);
}

/* A triangle in z = 0 whose target lifts it to z = x: the normal turns to (-1, 0, 1) / sqrt 2. */
static void morphs_turn_normals(void **state) {
    static bytes b;
    static const float positions[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0},
                       lifts[9] = {0, 0, 0, 0, 0, 1, 0, 0, 0},
                       tangents[12] = {.6F, 0, .8F, -1, 1, 0, 0, -1, 0, 0, 1, -1};
    const char *text =
        "{\"asset\":{\"version\":\"2.0\"},\"meshes\":[{\"primitives\":[{\"attributes\":{"
        "\"POSITION\":0,\"TANGENT\":2},\"targets\":[{\"POSITION\":1}]}]}],"
        "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"},{"
        "\"bufferView\":1,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"},"
        "{\"bufferView\":2,\"componentType\":5126,\"count\":3,\"type\":\"VEC4\"}],\"bufferViews\":["
        "{\"buffer\":0,\"byteLength\":36},{\"buffer\":0,\"byteOffset\":36,\"byteLength\":36},"
        "{\"buffer\":0,\"byteOffset\":72,\"byteLength\":48}],\"buffers\":[{\"byteLength\":120,"
        "\"uri\":\"@URI@\"}]}";
    const norma_compute_options options = {.struct_size = sizeof options, .morphs = 1};
    (void)state;
    b.size = 0;
    add_floats(&b, positions, 9);
    add_floats(&b, lifts, 9);
    add_floats(&b, tangents, 12);
    document_bytes in = asset(text, &b), plain = bytes_computed(in, "morph.gltf", NULL, NULL),
                   out = bytes_computed(in, "morph.gltf", &options, NULL);
    assert_true(contains(plain, "\"targets\":[{\"POSITION\":1}]"));
    norma_document *after = bytes_open(out, "morph.gltf");
    uint32_t delta = inside(after)->targets[0].normal;
    assert_true(delta != GLTF_NONE);
    for (size_t v = 0; v < 3; ++v) {
        float d[16], t[16];
        element(after, delta, v, d);
        assert_true(fabs((double)d[0] + sqrt(.5)) < 1e-7 && d[1] == 0 &&
                    fabs((double)d[2] - (sqrt(.5) - 1)) < 1e-7);
        element(after, attribute(after, 0, "TANGENT"), v, t);
        assert_true(
            fabsf(t[2]) < 1e-7F && t[3] == -1 && fabsf(t[0] * t[0] + t[1] * t[1] - 1) < 1e-6F);
    }
    norma_document_close(after);
    bytes_free(&plain);
    bytes_free(&out);
    bytes_free(&in);
}

/* Normals of bytes, one of them of no length: it alone is mended, with --only broken; all others
 * keep codes that no encoder of ours would choose. */
static void broken_normals_alone_are_fixed(void **state) {
    static bytes b;
    static const float positions[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0};
    static const uint16_t indices[6] = {0, 1, 2, 1, 3, 2};
    static const int8_t normals[16] = {0, 9, 127, 0, 9, 0, 127, 0, 0, 0, 0, 0, 0, 0, 127, 0};
    const norma_compute_options options = {
        .struct_size = sizeof options, .only = NORMA_ONLY_BROKEN};
    norma_compute_summary summary;
    (void)state;
    b.size = 0;
    add_floats(&b, positions, 12);
    add_shorts(&b, indices, 6);
    memcpy(b.data + b.size, normals, 16);
    b.size += 16;
    document_bytes in = asset(
        "{\"asset\":{\"version\":\"2.0\"},\"meshes\":[{\"primitives\":[{\"attributes\":{"
        "\"POSITION\":0,\"NORMAL\":2},\"indices\":1}]}],\"accessors\":[{\"bufferView\":0,"
        "\"componentType\":5126,\"count\":4,\"type\":\"VEC3\"},{\"bufferView\":1,\"componentType\":"
        "5123,\"count\":6,\"type\":\"SCALAR\"},{\"bufferView\":2,\"componentType\":5120,"
        "\"normalized\":true,\"count\":4,\"type\":\"VEC3\"}],\"bufferViews\":[{\"buffer\":0,"
        "\"byteLength\":48},{\"buffer\":0,\"byteOffset\":48,\"byteLength\":12},{\"buffer\":0,"
        "\"byteOffset\":60,\"byteLength\":16,\"byteStride\":4}],\"buffers\":[{\"byteLength\":76,"
        "\"uri\":\"@URI@\"}]}",
        &b);
    document_bytes out = bytes_computed(in, "broken.gltf", &options, &summary);
    norma_document *after = bytes_open(out, "broken.gltf");
    gltf_array array = array_of(after, attribute(after, 0, "NORMAL"));
    assert_int_equal(summary.changed, 1);
    assert_int_equal(summary.vertices_after, 4);
    assert_int_equal(array.component, GLTF_BYTE);
    assert_memory_equal(array.data, normals, 3);
    assert_memory_equal(array.data + 4, normals + 4, 3);
    assert_memory_equal(array.data + 8, "\0\0\x7f", 3);
    assert_memory_equal(array.data + 12, normals + 12, 3);
    assert_int_equal(in.size, out.size);
    norma_document_close(after);
    bytes_free(&out);
    bytes_free(&in);
}

static void nan_positions_are_filled(void **state) {
    static bytes b;
    norma_compute_summary summary;
    (void)state;
    cube_bytes(&b);
    memcpy(b.data, &(float){NAN}, 4);
    document_bytes in = asset(CUBE_TEXT, &b), out = bytes_computed(in, "cube.gltf", NULL, &summary);
    norma_document *after = bytes_open(out, "cube.gltf");
    gltf_array array = array_of(after, attribute(after, 0, "NORMAL"));
    assert_true(summary.filled > 0);
    for (size_t v = 0; v < array.count; ++v) {
        float n[16];
        norma_gltf_floats(&array, v, n);
        assert_true(fabsf(n[0] * n[0] + n[1] * n[1] + n[2] * n[2] - 1) < 1e-6F);
    }
    norma_document_close(after);
    bytes_free(&out);
    bytes_free(&in);
}

/* A strip of four triangles that folds by a right angle in its middle, and a fan: the
 * specification's order of corners, by hand; then as triangles, split at the fold. */
static void strips_and_fans_unroll(void **state) {
    static bytes b;
    static const float positions[18] = {0, 0, 0, 0, 1, 0, 1, 0, 0, 1, 1, 0, 1, 0, 1, 1, 1, 1};
    static const uint32_t strip[12] = {0, 1, 2, 1, 3, 2, 2, 3, 4, 3, 5, 4},
                          fan[12] = {1, 2, 0, 2, 3, 0, 3, 4, 0, 4, 5, 0};
    const char *text =
        "{\"asset\":{\"version\":\"2.0\"},\"meshes\":[{\"primitives\":[{\"attributes\":{"
        "\"POSITION\":0},\"mode\":%d}]}],\"accessors\":[{\"bufferView\":0,"
        "\"componentType\":5126,\"count\":6,\"type\":\"VEC3\"}],\"bufferViews\":[{\"buffer\":0,"
        "\"byteLength\":72}],\"buffers\":[{\"byteLength\":72,\"uri\":\"@URI@\"}]}";
    char written[600];
    (void)state;
    b.size = 0;
    add_floats(&b, positions, 18);
    for (int mode = 5; mode <= 6; ++mode) {
        snprintf(written, sizeof written, text, mode);
        document_bytes in = asset(written, &b);
        norma_document *before = bytes_open(in, "strip.gltf");
        assert_memory_equal(corners_of(before, 0), mode == 5 ? strip : fan, sizeof strip);
        norma_document_close(before);
        if (mode == 5) {
            norma_compute_summary summary;
            document_bytes out = bytes_computed(in, "strip.gltf", NULL, &summary);
            norma_document *after = bytes_open(out, "strip.gltf");
            assert_int_equal(summary.vertices_after, 8);
            assert_int_equal(inside(after)->primitives[0].mode, GLTF_TRIANGLES);
            for (size_t c = 0; c < 12; ++c) {
                float n[16], at[16];
                element(after, attribute(after, 0, "NORMAL"), corners_of(after, 0)[c], n);
                element(after, 0, corners_of(after, 0)[c], at);
                assert_true(c < 6 ? n[2] == -1 : n[0] == 1 || n[0] == -1);
                assert_memory_equal(at, positions + 3 * strip[c], 12);
            }
            norma_document_close(after);
            bytes_free(&out);
        }
        bytes_free(&in);
    }
}

/* Two strips of a quad each, a right angle between them, sewn into one by corners that repeat: the
 * list that it becomes has the four triangles that are drawn. */
static void stitches_are_left_out_of_a_list(void **state) {
    static bytes b;
    static const float positions[24] = {
        0, 0, 0, 0, 1, 0, 1, 0, 0, 1, 1, 0, 1, 0, 0, 1, 1, 0, 1, 0, 1, 1, 1, 1};
    static const uint16_t strip[10] = {0, 1, 2, 3, 3, 2, 2, 3, 6, 7};
    static const float drawn[4][3] = {
        {0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {1, 1, 0}}; /* first corners */
    norma_compute_summary summary;
    (void)state;
    b.size = 0;
    add_floats(&b, positions, 24);
    add_shorts(&b, strip, 10);
    document_bytes in =
        asset("{\"asset\":{\"version\":\"2.0\"},\"meshes\":[{\"primitives\":[{\"attributes\":{"
              "\"POSITION\":0},\"indices\":1,\"mode\":5}]}],\"accessors\":[{\"bufferView\":0,"
              "\"componentType\":5126,\"count\":8,\"type\":\"VEC3\"},{\"bufferView\":1,"
              "\"componentType\":5123,\"count\":10,\"type\":\"SCALAR\"}],\"bufferViews\":["
              "{\"buffer\":0,\"byteLength\":96},{\"buffer\":0,\"byteOffset\":96,\"byteLength\":20}]"
              ",\"buffers\":[{\"byteLength\":116,\"uri\":\"@URI@\"}]}",
            &b);
    document_bytes out = bytes_computed(in, "sewn.gltf", NULL, &summary);
    norma_document *after = bytes_open(out, "sewn.gltf");
    assert_int_equal(inside(after)->primitives[0].mode, GLTF_TRIANGLES);
    assert_int_equal(inside(after)->primitives[0].faces, 4);
    for (size_t f = 0; f < 4; ++f) {
        float at[16], n[16];
        element(after, 0, corners_of(after, 0)[3 * f], at);
        element(after, attribute(after, 0, "NORMAL"), corners_of(after, 0)[3 * f], n);
        assert_memory_equal(at, drawn[f], 12);
        assert_true(fabsf(n[f < 2 ? 2 : 0]) == 1);
    }
    norma_document_close(after);
    bytes_free(&out);
    bytes_free(&in);
}

/* Normals that are right already, one tangent that leans, one that is perpendicular to the last
 * bits of a float, which stay. */
static void leaning_tangents_are_turned_under_right_normals(void **state) {
    static bytes b;
    static const float positions[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0},
                       normals[9] = {0, 0, 1, 0, 0, 1, 0, 0, 1},
                       tangents[12] = {.6F, 0, .8F, -1, 1, 0, 1e-6F, 1, 0, 1, 0, 1};
    (void)state;
    b.size = 0;
    add_floats(&b, positions, 9);
    add_floats(&b, normals, 9);
    add_floats(&b, tangents, 12);
    document_bytes in =
        asset("{\"asset\":{\"version\":\"2.0\"},\"meshes\":[{\"primitives\":[{\"attributes\":{"
              "\"POSITION\":0,\"NORMAL\":1,\"TANGENT\":2}}]}],\"accessors\":["
              "{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"},{"
              "\"bufferView\":1,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"},"
              "{\"bufferView\":2,\"componentType\":5126,\"count\":3,\"type\":\"VEC4\"}],"
              "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36},{\"buffer\":0,\"byteOffset\":36,"
              "\"byteLength\":36},{\"buffer\":0,\"byteOffset\":72,\"byteLength\":48}],\"buffers\":["
              "{\"byteLength\":120,\"uri\":\"@URI@\"}]}",
            &b);
    const norma_compute_options missing = {
        .struct_size = sizeof missing, .only = NORMA_ONLY_MISSING};
    document_bytes out = bytes_computed(in, "lean.gltf", NULL, NULL),
                   kept = bytes_computed(in, "lean.gltf", &missing, NULL);
    norma_document *after = bytes_open(out, "lean.gltf");
    float t[16];
    element(after, attribute(after, 0, "TANGENT"), 0, t);
    assert_true(t[0] == 1 && t[1] == 0 && t[2] == 0 && t[3] == -1);
    for (size_t v = 1; v < 3; ++v) {
        element(after, attribute(after, 0, "TANGENT"), v, t);
        assert_memory_equal(t, tangents + 4 * v, 16);
    }
    assert_true(bytes_equal(kept, in));
    norma_document_close(after);
    bytes_free(&kept);
    bytes_free(&out);
    bytes_free(&in);
}

/* Another attribute names the very bytes of the normals, or some of them with another stride: those
 * must stay what they were. */
static void bytes_of_others_are_not_written_over(void **state) {
    static bytes b;
    static const float positions[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0},
                       normals[9] = {1, 0, 0, 0, 1, 0, 1, 0, 0};
    static const char *const others[] = {"\"count\":3,\"type\":\"VEC3\"",
        "\"byteOffset\":4,\"count\":3,\"type\":\"VEC2\"",
        "\"byteOffset\":20,\"count\":3,\"type\":\"SCALAR\""};
    char text[900];
    (void)state;
    b.size = 0;
    add_floats(&b, positions, 9);
    add_floats(&b, normals, 9);
    for (size_t i = 0; i < 3; ++i) {
        snprintf(text, sizeof text,
            "{\"asset\":{\"version\":\"2.0\"},\"meshes\":[{\"primitives\":[{\"attributes\":{"
            "\"POSITION\":0,\"NORMAL\":1,\"_OTHER\":2}}]}],\"accessors\":[{\"bufferView\":0,"
            "\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"},{\"bufferView\":1,"
            "\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"},{\"bufferView\":%d,"
            "\"componentType\":5126,%s}],"
            "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36},{\"buffer\":0,\"byteOffset\":36,"
            "\"byteLength\":36},{\"buffer\":0,\"byteOffset\":36,\"byteLength\":36}],"
            "\"buffers\":[{\"byteLength\":72,\"uri\":\"@URI@\"}]}",
            i == 2 ? 2 : 1, others[i]);
        document_bytes in = asset(text, &b), out = bytes_computed(in, "alias.gltf", NULL, NULL);
        norma_document *before = bytes_open(in, "alias.gltf"),
                       *after = bytes_open(out, "alias.gltf");
        gltf_array x = array_of(before, 2), y = array_of(after, 2);
        for (size_t v = 0; v < 3; ++v)
            assert_memory_equal(x.data + v * x.stride, y.data + v * y.stride, 4 * x.width);
        float n[16];
        element(after, attribute(after, 0, "NORMAL"), 1, n);
        assert_true(n[0] == 0 && n[1] == 0 && n[2] == 1);
        norma_document_close(before);
        norma_document_close(after);
        bytes_free(&out);
        bytes_free(&in);
    }
}

/* ---- reading that must fail, with a message that names the place */

static void refused_texts(void **state) {
    static const struct {
        const char *text, *name;
        norma_document_result result;
        const char *message;
    } cases[] = {
        {"{\"asset\":{\"version\":\"2.0\"},\"extensionsRequired\":[\"ACME_gizmo\"]}", "a.gltf",
            NORMA_DOCUMENT_ERROR_UNSUPPORTED, "ACME_gizmo"},
        {"{\"asset\":{\"version\":\"1.0\"}}", "a.gltf", NORMA_DOCUMENT_ERROR_UNSUPPORTED, "2.0"},
        {"{\"asset\":{\"version\":\"2.0\"},}", "a.gltf", NORMA_DOCUMENT_ERROR_MALFORMED, "byte 27"},
        {"{\"asset\":{\"version\":\"2.0\"},\"nodes\":[{\"children\":[1]},{\"children\":[0]}]}",
            "a.gltf", NORMA_DOCUMENT_ERROR_MALFORMED, "loop"},
        {"{\"asset\":{\"version\":\"2.0\"},\"nodes\":[{\"children\":[2]},{\"children\":[2]},{}]}",
            "a.gltf", NORMA_DOCUMENT_ERROR_MALFORMED, "/nodes/1/children/0"},
        {"{\"asset\":{\"version\":\"2.0\"},\"meshes\":[{\"primitives\":[{\"attributes\":{"
         "\"POSITION\":0}}]}],\"accessors\":[{\"componentType\":5126,\"count\":9000000000,\"type\":"
         "\"VEC3\"}]}",
            "a.gltf", NORMA_DOCUMENT_ERROR_MALFORMED, "/accessors/0"},
        {"{\"asset\":{\"version\":\"2.0\"},\"meshes\":[{\"primitives\":[{\"attributes\":{"
         "\"POSITION\":0}}]}],\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,"
         "\"type\":\"VEC3\"}],"
         "\"bufferViews\":[{\"buffer\":0,\"byteLength\":35}],\"buffers\":[{\"byteLength\":35,"
         "\"uri\":\"data:;base64,AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA=\"}]}",
            "a.gltf", NORMA_DOCUMENT_ERROR_MALFORMED, "/accessors/0"},
    };
    static const char *const outside[] = {"../x.bin", "a/../../x.bin", "/etc/hostname",
        "file:x.bin", "http://example.com/x.bin", "%2e%2e/x.bin", "C:x.bin", "..%5Cx.bin"};
    char message[1000], text[600];
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        document_bytes b = bytes_copy(cases[i].text, strlen(cases[i].text));
        norma_mesh_info info;
        assert_int_equal(bytes_try(b, cases[i].name, &info, message), cases[i].result);
        if (!strstr(message, cases[i].message)) fail_msg("%s: %s", cases[i].text, message);
        bytes_free(&b);
    }
    for (size_t i = 0; i < sizeof outside / sizeof *outside; ++i) {
        snprintf(text, sizeof text,
            "{\"asset\":{\"version\":\"2.0\"},\"meshes\":[{\"primitives\":[{\"attributes\":{"
            "\"POSITION\":0}}]}],\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":"
            "3,\"type\":\"VEC3\"}],"
            "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],\"buffers\":[{\"byteLength\":36,"
            "\"uri\":\"%s\"}]}",
            outside[i]);
        document_bytes b = bytes_copy(text, strlen(text));
        norma_mesh_info info;
        assert_int_equal(bytes_try(b, "a.gltf", &info, message), NORMA_DOCUMENT_ERROR_REFUSED);
        bytes_free(&b);
    }
}

/* What a view beyond its buffer should hold must not become what is written: its buffer does not
 * grow, and a note tells of it. */
static void a_view_beyond_its_buffer_is_told_of(void **state) {
    static bytes b;
    static const float positions[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    (void)state;
    b.size = 0;
    add_floats(&b, positions, 9);
    document_bytes in =
        asset("{\"asset\":{\"version\":\"2.0\"},\"meshes\":[{\"primitives\":[{\"attributes\":{"
              "\"POSITION\":0}}]}],\"accessors\":[{\"bufferView\":0,\"componentType\":5126,"
              "\"count\":3,\"type\":\"VEC3\"}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":36},{"
              "\"buffer\":0,\"byteOffset\":36,\"byteLength\":36}],"
              "\"buffers\":[{\"byteLength\":36,\"uri\":\"@URI@\"}]}",
            &b);
    norma_document *before = bytes_open(in, "beyond.gltf");
    assert_int_equal(norma_document_note_count(before), 1);
    assert_string_equal(
        norma_document_note(before, 0), "bufferView 1 ends beyond its buffer; its data is missing");
    norma_document_close(before);
    document_bytes out = bytes_computed(in, "beyond.gltf", NULL, NULL);
    norma_document *after = bytes_open(out, "beyond.gltf");
    assert_int_equal(inside(after)->buffers[0].length, 36);
    assert_int_equal(inside(after)->accessors[attribute(after, 0, "NORMAL")].view, 2);
    assert_int_equal(inside(after)->views[2].buffer, 1);
    norma_document_close(after);
    bytes_free(&out);
    bytes_free(&in);
}

/* ---- files */

typedef struct place {
    char folder[64], other[64], source[96], bin[96];
    document_bytes text, bytes;
} place;

static void write_file(const char *path, const void *data, size_t size) {
    FILE *f = fopen(path, "wb");
    assert_non_null(f);
    assert_int_equal(fwrite(data, 1, size, f), size);
    fclose(f);
}

static void make_place(place *p) {
    static bytes b;
    char *text = strdup(CUBE_TEXT), *uri = strstr(text, "@URI@");
    strcpy(p->folder, "/tmp/norma-gltf-XXXXXX");
    assert_non_null(mkdtemp(p->folder));
    strcpy(p->other, "/tmp/norma-gltf-XXXXXX");
    assert_non_null(mkdtemp(p->other));
    snprintf(p->source, sizeof p->source, "%s/cube.gltf", p->folder);
    snprintf(p->bin, sizeof p->bin, "%s/b c.bin", p->folder);
    *uri = '\0';
    char *whole = NULL;
    assert_true(asprintf(&whole, "%sb%%20c.bin%s", text, uri + 5) > 0);
    cube_bytes(&b);
    write_file(p->source, whole, strlen(whole));
    write_file(p->bin, b.data, b.size);
    p->text = bytes_copy(whole, strlen(whole));
    p->bytes = bytes_copy(b.data, b.size);
    free(whole);
    free(text);
}

static void drop_place(place *p) {
    char command[200];
    snprintf(command, sizeof command, "rm -r '%s' '%s'", p->folder, p->other);
    assert_int_equal(system(command), 0);
    bytes_free(&p->text);
    bytes_free(&p->bytes);
}

static norma_document_result save_shaded(const place *p, const char *path, int in_place,
    norma_shading shading, norma_document_error *error) {
    const norma_save_options options = {.struct_size = sizeof options, .in_place = in_place};
    const norma_compute_options compute = {.struct_size = sizeof compute, .shading = shading};
    norma_document *document;
    norma_document_result result = norma_document_open(p->source, NULL, &document, error);
    if (!result) result = norma_document_compute(document, &compute, NULL, error);
    if (!result) result = norma_document_save(document, path, &options, error);
    norma_document_close(document);
    return result;
}

static norma_document_result save_computed(
    const place *p, const char *path, int in_place, norma_document_error *error) {
    return save_shaded(p, path, in_place, NORMA_SHADING_DEFAULT, error);
}

static int has(const char *path, document_bytes expected) {
    document_bytes found = bytes_load(path);
    int same = bytes_equal(found, expected);
    bytes_free(&found);
    return same;
}

static void buffers_are_named_after_the_output(void **state) {
    place p;
    char out[128], bin[128];
    norma_document_error error;
    (void)state;
    make_place(&p);
    for (int other = 0; other < 2; ++other) {
        snprintf(out, sizeof out, "%s/new one.gltf", other ? p.other : p.folder);
        snprintf(bin, sizeof bin, "%s/new one.bin", other ? p.other : p.folder);
        if (save_computed(&p, out, 0, &error)) fail_msg("%s", error.message);
        document_bytes text = bytes_load(out);
        assert_true(contains(text, "\"new%20one.bin\""));
        bytes_free(&text);
        assert_int_equal(access(bin, F_OK), 0);
        assert_true(has(p.source, p.text) && has(p.bin, p.bytes));
        norma_document *again;
        assert_int_equal(norma_document_open(out, NULL, &again, &error), NORMA_DOCUMENT_OK);
        norma_document_close(again);
    }
    drop_place(&p);
}

static void other_content_is_not_overwritten(void **state) {
    place p;
    char out[128], bin[128];
    norma_document_error error;
    document_bytes mine = bytes_copy("mine", 4);
    (void)state;
    make_place(&p);
    snprintf(out, sizeof out, "%s/out.gltf", p.other);
    snprintf(bin, sizeof bin, "%s/out.bin", p.other);
    write_file(bin, "mine", 4);
    assert_int_equal(save_computed(&p, out, 0, &error), NORMA_DOCUMENT_ERROR_REFUSED);
    assert_non_null(strstr(error.message, "out.bin"));
    assert_true(access(out, F_OK) != 0 && has(bin, mine));
    /* a buffer of the asset that is to be replaced does not stand in the way, and stays whole */
    unlink(bin);
    assert_int_equal(save_computed(&p, out, 0, &error), NORMA_DOCUMENT_OK);
    document_bytes before = bytes_load(bin);
    write_file(p.bin, p.bytes.data, p.bytes.size - 4);
    write_file(p.bin, "\0\0\0\x40", 4); /* the first position moves */
    FILE *f = fopen(p.bin, "ab");
    fwrite(p.bytes.data + 4, 1, p.bytes.size - 4, f);
    fclose(f);
    if (save_computed(&p, out, 0, &error)) fail_msg("%s", error.message);
    assert_true(has(bin, before));
    document_bytes text = bytes_load(out);
    assert_true(contains(text, "out-1.bin"));
    bytes_free(&text);
    bytes_free(&before);
    bytes_free(&mine);
    drop_place(&p);
}

/* Someone tries one shading after the other into the same output: each time the buffers of the
 * times before stay whole, and are used again where they serve. */
static void an_output_is_replaced_again_and_again(void **state) {
    static const norma_shading shadings[] = {NORMA_SHADING_SMOOTH, NORMA_SHADING_DEFAULT,
        NORMA_SHADING_FLAT, NORMA_SHADING_SMOOTH, NORMA_SHADING_DEFAULT};
    static const char *const names[] = {"\"out.bin\"", "\"out-1.bin\"", "\"out-1.bin\"",
        "\"out.bin\"", "\"out-1.bin\""}; /* a cube's creases are flat */
    static const char *const tails[] = {"x.bin", "-1x.bin", "-.bin2"}; /* no names of ours */
    place p;
    char out[128], bin[140], *text;
    norma_document_error error;
    (void)state;
    make_place(&p);
    snprintf(out, sizeof out, "%s/out.gltf", p.other);
    for (size_t i = 0; i < sizeof shadings / sizeof shadings[0]; ++i) {
        if (save_shaded(&p, out, 0, shadings[i], &error)) fail_msg("%zu: %s", i, error.message);
        document_bytes written = bytes_load(out);
        assert_true(contains(written, names[i]));
        bytes_free(&written);
    }
    char colon[128];
    snprintf(colon, sizeof colon, "%s/a:b.gltf", p.other);
    for (size_t i = 0; i < 3; ++i) /* a name that is no scheme */
        assert_int_equal(
            save_shaded(&p, colon, 0, i ? NORMA_SHADING_FLAT : NORMA_SHADING_SMOOTH, &error),
            NORMA_DOCUMENT_OK);
    norma_document *again;
    if (norma_document_open(colon, NULL, &again, &error)) fail_msg("%s", error.message);
    assert_string_equal(inside(again)->buffers[0].name, "./a:b-1.bin");
    assert_int_equal(norma_document_compute(again, NULL, NULL, &error), NORMA_DOCUMENT_OK);
    norma_document_close(again);
    for (size_t i = 0; i < 3; ++i) { /* an asset at the output's place whose buffers are named
                                        otherwise says nothing about out.bin */
        assert_true(asprintf(&text,
                        "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":4,\"uri\":"
                        "\"out%s\"}]}",
                        tails[i]) > 0);
        write_file(out, text, strlen(text));
        free(text);
        snprintf(bin, sizeof bin, "%s/out.bin", p.other);
        write_file(bin, "mine", 4);
        assert_int_equal(
            save_shaded(&p, out, 0, NORMA_SHADING_FLAT, &error), NORMA_DOCUMENT_ERROR_REFUSED);
    }
    drop_place(&p);
}

static void in_place_only_adds_to_the_buffer(void **state) {
    place p;
    norma_document_error error;
    (void)state;
    make_place(&p);
    if (save_computed(&p, p.source, 1, &error)) fail_msg("%s", error.message);
    document_bytes text = bytes_load(p.source), bin = bytes_load(p.bin);
    assert_true(contains(text, "\"b%20c.bin\"") && !bytes_equal(text, p.text));
    assert_true(bin.size > p.bytes.size);
    assert_memory_equal(
        bin.data, p.bytes.data, p.bytes.size); /* the old asset would still read what it read */
    norma_document *again;
    assert_int_equal(norma_document_open(p.source, NULL, &again, &error), NORMA_DOCUMENT_OK);
    assert_true(attribute(again, 0, "NORMAL") != GLTF_NONE);
    norma_document_close(again);
    bytes_free(&text);
    bytes_free(&bin);
    assert_int_equal(save_computed(&p, p.source, 0, &error), NORMA_DOCUMENT_ERROR_ARGUMENT);
    drop_place(&p);
}

static void a_link_out_of_the_folder_is_not_followed(void **state) {
    place p;
    char away[128];
    norma_document_error error;
    norma_document *document;
    (void)state;
    make_place(&p);
    snprintf(away, sizeof away, "%s/away.bin", p.other);
    assert_int_equal(rename(p.bin, away), 0);
    assert_int_equal(symlink(away, p.bin), 0);
    assert_int_equal(
        norma_document_open(p.source, NULL, &document, &error), NORMA_DOCUMENT_ERROR_REFUSED);
    drop_place(&p);
}

static void images_go_along(void **state) {
    place p;
    char path[160];
    norma_document_error error;
    document_bytes image = bytes_copy("\x89PNG\r\n\x1A\n", 8);
    (void)state;
    make_place(&p);
    char *text = NULL;
    assert_true(
        asprintf(&text,
            "{\"images\":[{\"uri\":\"t/"
            "a%%20b.png\"},{\"uri\":\"missing.png\"},{\"uri\":\"data:image/png;base64,AAAA\"}],%s",
            (char *)memchr(p.text.data, '"', p.text.size)) > 0);
    write_file(p.source, text, strlen(text));
    free(text);
    snprintf(path, sizeof path, "%s/t", p.folder);
    mkdir(path, 0777);
    snprintf(path, sizeof path, "%s/t/a b.png", p.folder);
    write_file(path, image.data, image.size);
    snprintf(path, sizeof path, "%s/cube.gltf", p.other);
    if (save_computed(&p, path, 0, &error)) fail_msg("%s", error.message);
    snprintf(path, sizeof path, "%s/t/a b.png", p.other);
    assert_true(has(path, image));
    bytes_free(&image);
    drop_place(&p);
}

static void a_stream_is_whole_in_itself(void **state) {
    place p;
    norma_document_error error;
    norma_document *document;
    (void)state;
    make_place(&p);
    assert_int_equal(norma_document_open(p.source, NULL, &document, &error), NORMA_DOCUMENT_OK);
    assert_int_equal(norma_document_compute(document, NULL, NULL, &error), NORMA_DOCUMENT_OK);
    document_bytes out = bytes_of(document);
    norma_document_close(document);
    assert_true(contains(out, "\"data:application/octet-stream;base64,"));
    const norma_document_options options = {
        .struct_size = sizeof options, .format = NORMA_FILE_GLTF};
    assert_int_equal(
        norma_document_open_memory(out.data, out.size, NULL, &options, &document, &error),
        NORMA_DOCUMENT_OK); /* no folder */
    norma_document_close(document);
    bytes_free(&out);
    drop_place(&p);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_cube_gets_its_faces_normals),
        cmocka_unit_test(smooth_adds_no_vertex),
        cmocka_unit_test(the_rest_of_the_text_stays),
        cmocka_unit_test(a_second_time_changes_nothing),
        cmocka_unit_test(a_document_takes_any_changes),
        cmocka_unit_test(indices_widen),
        cmocka_unit_test(what_is_shared_stays_shared),
        cmocka_unit_test(materials_make_no_seam),
        cmocka_unit_test(morphs_turn_normals),
        cmocka_unit_test(broken_normals_alone_are_fixed),
        cmocka_unit_test(nan_positions_are_filled),
        cmocka_unit_test(strips_and_fans_unroll),
        cmocka_unit_test(stitches_are_left_out_of_a_list),
        cmocka_unit_test(leaning_tangents_are_turned_under_right_normals),
        cmocka_unit_test(bytes_of_others_are_not_written_over),
        cmocka_unit_test(refused_texts),
        cmocka_unit_test(a_view_beyond_its_buffer_is_told_of),
        cmocka_unit_test(buffers_are_named_after_the_output),
        cmocka_unit_test(other_content_is_not_overwritten),
        cmocka_unit_test(an_output_is_replaced_again_and_again),
        cmocka_unit_test(in_place_only_adds_to_the_buffer),
        cmocka_unit_test(a_link_out_of_the_folder_is_not_followed),
        cmocka_unit_test(images_go_along),
        cmocka_unit_test(a_stream_is_whole_in_itself),
    };
    return cmocka_run_group_tests_name("gltf", tests, NULL, NULL);
}
