/* test_draco.c: glTF primitives that Draco compressed, read and changed. The streams are another
 * program's (draco_streams.h), so what they hold is known; those that are damaged, cut short or lie
 * about themselves are refused with a message that says so. */
#define _POSIX_C_SOURCE 200809L
#include "check.h"
#include "draco_streams.h"
#include "gltf_asset.h"
#include "gltf_output.h"
#include "io/gltf/draco_decoder.h"

#define NAMES "KHR_draco_mesh_compression"
#define LISTS ",\"extensionsUsed\":[\"" NAMES "\"],\"extensionsRequired\":[\"" NAMES "\"]"
#define IDS                                                                                        \
    "\"POSITION\":0,\"NORMAL\":1,\"TEXCOORD_0\":2,\"TANGENT\":3,\"COLOR_0\":4,\"JOINTS_0\":5,"     \
    "\"WEIGHTS_0\":6"
#define ATTRIBUTES                                                                                 \
    "\"attributes\":{\"POSITION\":1,\"NORMAL\":2,\"TEXCOORD_0\":3,\"TANGENT\":4,\"COLOR_0\":5,"    \
    "\"JOINTS_0\":6,\"WEIGHTS_0\":7},\"indices\":0"
#define PACKED                                                                                     \
    "{" ATTRIBUTES ",\"extensions\":{\"" NAMES "\":{\"bufferView\":0,\"attributes\":{" IDS "}}}}"
#define SCENE "\"nodes\":[{\"mesh\":0}],\"scenes\":[{\"nodes\":[0]}],\"scene\":0"
#define ONE   SCENE ",\"meshes\":[{\"primitives\":[" PACKED "]}]" LISTS

static const struct {
    const unsigned char *bytes;
    size_t size;
} STREAMS[] = {{SEQUENTIAL, sizeof SEQUENTIAL}, {EDGEBREAKER, sizeof EDGEBREAKER}};

static const char *const ACCESSORS[] = {
    "{\"componentType\":5123,\"count\":24,\"type\":\"SCALAR\"}",
    "{\"componentType\":5126,\"count\":9,\"type\":\"VEC3\",\"min\":[0,0,0],\"max\":[2,2,0.5]}",
    "{\"componentType\":5126,\"count\":9,\"type\":\"VEC3\"}",
    "{\"componentType\":5126,\"count\":9,\"type\":\"VEC2\"}",
    "{\"componentType\":5126,\"count\":9,\"type\":\"VEC4\"}",
    "{\"componentType\":5121,\"normalized\":true,\"count\":9,\"type\":\"VEC4\"}",
    "{\"componentType\":5121,\"count\":9,\"type\":\"VEC4\"}",
    "{\"componentType\":5126,\"count\":9,\"type\":\"VEC4\"}",
};

/* The asset with the stream in view 0; one of the accessors (-1: none) is another. */
static gltf_asset packed(const void *bytes, size_t size, int other, const char *instead) {
    gltf_asset a = {0};
    asset_view(&a, bytes, size, "");
    for (int i = 0; i < (int)COUNT_OF(ACCESSORS); ++i)
        asset_accessor(&a, i == other ? instead : ACCESSORS[i]);
    return a;
}

static void assert_near(double value, double expected, double tolerance) {
    if (!(fabs(value - expected) <= tolerance))
        fail_msg("%g is not within %g of %g", value, tolerance, expected);
}

/* ---- what is in them */

/* Which vertex of the grid, by its texture coordinates. */
static int vertex_of(const float *texcoord) {
    const long i = lround(2 * (double)texcoord[0]), j = lround(2 * (double)texcoord[1]);
    assert_in_range(i, 0, 2);
    assert_in_range(j, 0, 2);
    assert_near((double)texcoord[0], (double)i / 2, 1.0 / 1024);
    assert_near((double)texcoord[1], (double)j / 2, 1.0 / 1024);
    return (int)(3 * j + i);
}

static void check_vertex(
    const norma_mesh_data *data, const norma_mesh_attributes *more, size_t v, int k) {
    double at[3], normal[3];
    norma_view_vector(&data->mesh.positions, v, at);
    norma_view_vector(&data->normals, v, normal);
    assert_near(at[0], k % 3, 2.0 / 2047);
    assert_near(at[1], k / 3, 2.0 / 2047);
    assert_near(at[2], 0.25 * (k % 3 * (k / 3) % 3), 2.0 / 2047);
    assert_near(normal[0], k % 2 ? 0 : 0.6, 2.0 / 256);
    assert_near(normal[2], k % 2 ? 1 : 0.8, 2.0 / 256);
    assert_near((double)more->tangents[4 * v], 1, 2.0 / 255);
    assert_near((double)more->tangents[4 * v + 3], k % 2 ? 1 : -1, 2.0 / 255);
    assert_near((double)more->colors[4 * v], 10 * k / 255.0, 1e-6);
    assert_near((double)more->colors[4 * v + 1], (255 - k) / 255.0, 1e-6);
}

/* Each of the grid's triangles once, with its winding: a + 4 is the largest corner of both. */
static void check_faces(const norma_mesh_data *data, const int *vertices) {
    int seen[9][2] = {{0}};
    assert_int_equal(data->mesh.corner_count, 24);
    for (size_t f = 0; f < 8; ++f) {
        int c[3], first = 0;
        for (size_t k = 0; k < 3; ++k) c[k] = vertices[norma_mesh_corner(&data->mesh, 3 * f + k)];
        for (int k = 1; k < 3; ++k)
            if (c[k] < c[first]) first = k;
        const int a = c[first], b = c[(first + 1) % 3], d = c[(first + 2) % 3], upper = b == a + 4;
        assert_true(upper ? d == a + 3 : b == a + 1 && d == a + 4);
        assert_int_equal(seen[a][upper]++, 0);
    }
}

static void check_grid(norma_document *document, size_t mesh) {
    norma_mesh_data data;
    norma_mesh_attributes more;
    norma_document_error error;
    int vertices[9], seen = 0;
    if (norma_document_mesh_data(document, mesh, &data, &error) ||
        norma_document_mesh_attributes(document, mesh, &more, &error))
        fail_msg("%s", error.message);
    assert_int_equal(data.mesh.positions.count, 9);
    assert_int_equal(more.texcoord_count, 9);
    for (size_t v = 0; v < 9; ++v) {
        vertices[v] = vertex_of(more.texcoords + 2 * v);
        seen |= 1 << vertices[v];
        check_vertex(&data, &more, v, vertices[v]);
    }
    assert_int_equal(seen, 0x1FF);
    check_faces(&data, vertices);
}

static void test_values(void **state) {
    (void)state;
    for (size_t i = 0; i < COUNT_OF(STREAMS); ++i) {
        gltf_asset a = packed(STREAMS[i].bytes, STREAMS[i].size, -1, NULL);
        norma_document *document = asset_open(&a, ONE, 0);
        norma_mesh_info info;
        assert_int_equal(norma_document_mesh_info(document, 0, &info), NORMA_DOCUMENT_OK);
        assert_string_equal(info.compression, NAMES);
        assert_null(info.not_read);
        check_grid(document, 0);
        norma_document_close(document);
        asset_free(&a);
    }
}

/* A reader without Draco takes the fallback that an accessor's own view holds; this one must not.
 */
static void test_fallback_is_not_read(void **state) {
    static const unsigned char other[108] = {0};
    gltf_asset a = {0};
    (void)state;
    asset_view(&a, SEQUENTIAL, sizeof SEQUENTIAL, "");
    asset_view(&a, other, sizeof other, "");
    for (size_t i = 0; i < COUNT_OF(ACCESSORS); ++i)
        asset_accessor(&a, i == 1 ? "{\"bufferView\":1,\"componentType\":5126,\"count\":9,"
                                    "\"type\":\"VEC3\"}"
                                  : ACCESSORS[i]);
    norma_document *document = asset_open(&a, ONE, 0);
    check_grid(document, 0);
    norma_document_close(document);
    asset_free(&a);
}

/* The accessors' elements are the stream's, whichever primitive asks for them first. */
static void test_shared_with_one_before(void **state) {
    (void)state;
    for (size_t i = 0; i < COUNT_OF(STREAMS); ++i) {
        gltf_asset a = packed(STREAMS[i].bytes, STREAMS[i].size, -1, NULL);
        norma_document *document = asset_open(
            &a, SCENE ",\"meshes\":[{\"primitives\":[{" ATTRIBUTES "}," PACKED "]}]" LISTS, 0);
        check_grid(document, 0);
        check_grid(document, 1);
        norma_document_close(document);
        asset_free(&a);
    }
}

/* ---- what is refused */

static void refused(
    const void *bytes, size_t size, int accessor, const char *instead, const char *expected) {
    gltf_asset a = packed(bytes, size, accessor, instead);
    for (int lenient = 0; lenient < 2; ++lenient) {
        const char *message = asset_refused(&a, ONE, lenient);
        if (!strstr(message, expected) || !strstr(message, "/"))
            fail_msg("expected \"%s\", got \"%s\"", expected, message);
    }
    asset_free(&a);
}

static void test_lying_accessors(void **state) {
    static const struct {
        int accessor;
        const char *json, *expected;
    } cases[] = {
        {0, "{\"componentType\":5123,\"count\":27,\"type\":\"SCALAR\"}",
            "declares 8 triangles; expected 9, as the accessor of the indices does"},
        {0, "{\"componentType\":5123,\"count\":25,\"type\":\"SCALAR\"}",
            "/accessors/0: expected a count that is a multiple of 3"},
        {0, "{\"componentType\":5126,\"count\":24,\"type\":\"SCALAR\"}",
            "/accessors/0: expected a type that the Draco stream can hold"},
        {1, "{\"componentType\":5126,\"count\":10,\"type\":\"VEC3\"}", "expected"},
        {1, "{\"componentType\":5126,\"count\":2000000000,\"type\":\"VEC3\"}", "expected"},
        {0, "{\"componentType\":5125,\"count\":3000000000,\"type\":\"SCALAR\"}",
            "would take far more memory than the file"},
        {0, "{\"componentType\":5125,\"count\":60000,\"type\":\"SCALAR\"}",
            "20000 triangles and 648 bytes of attributes are far more than a Draco stream of"},
        {3, "{\"componentType\":5126,\"count\":9,\"type\":\"VEC3\"}",
            "has TEXCOORD_0 with another number of components; expected 3"},
        {3, "{\"componentType\":5126,\"count\":9,\"type\":\"MAT2\"}",
            "/accessors/3: expected a type that the Draco stream can hold"},
        {1,
            "{\"bufferView\":0,\"byteOffset\":400,\"componentType\":5126,\"count\":9,\"type\":"
            "\"VEC3\"}",
            "/accessors/1: expected elements that end inside their view"},
    };
    (void)state;
    for (size_t s = 0; s < COUNT_OF(STREAMS); ++s)
        for (size_t i = 0; i < COUNT_OF(cases); ++i)
            refused(STREAMS[s].bytes, STREAMS[s].size, cases[i].accessor, cases[i].json,
                cases[i].expected);
}

/* No part of a stream is a stream. */
static void test_cut_short(void **state) {
    (void)state;
    for (size_t s = 0; s < COUNT_OF(STREAMS); ++s)
        for (size_t size = 1; size < STREAMS[s].size; ++size) {
            unsigned char *bytes = malloc(size); /* so that reading behind it is seen */
            assert_non_null(bytes);
            memcpy(bytes, STREAMS[s].bytes, size);
            refused(bytes, size, -1, NULL, "the Draco stream of ");
            free(bytes);
        }
}

/* Counts of a thousand million triangles and points: refused before anything is allocated. */
static void test_lying_headers(void **state) {
    static const unsigned char billion[5] = {0x80, 0x94, 0xEB, 0xDC, 3};
    static const char version[] = "expected a mesh, bitstream version 2.2";
    unsigned char bytes[sizeof EDGEBREAKER + 8];
    (void)state;
    memcpy(bytes, SEQUENTIAL, 11); /* then faces and points */
    memcpy(bytes + 11, billion, 5);
    memcpy(bytes + 16, SEQUENTIAL + 12, sizeof SEQUENTIAL - 12);
    refused(bytes, sizeof SEQUENTIAL + 4, -1, NULL, "declares 1000000000 triangles; expected 8");
    memcpy(bytes + 11, SEQUENTIAL + 11, 1);
    memcpy(bytes + 12, billion, 5);
    memcpy(bytes + 17, SEQUENTIAL + 13, sizeof SEQUENTIAL - 13);
    refused(bytes, sizeof SEQUENTIAL + 4, -1, NULL, "declares 1000000000 vertices; expected 9");
    memcpy(bytes, EDGEBREAKER, 13); /* a way of traversing, vertices, then faces */
    memcpy(bytes + 13, billion, 5);
    memcpy(bytes + 18, EDGEBREAKER + 14, sizeof EDGEBREAKER - 14);
    refused(bytes, sizeof EDGEBREAKER + 4, -1, NULL, "declares 1000000000 triangles; expected 8");
    memcpy(bytes, SEQUENTIAL, sizeof SEQUENTIAL);
    bytes[6] = 1; /* the version's second number */
    refused(bytes, sizeof SEQUENTIAL, -1, NULL, version);
    memcpy(bytes, SEQUENTIAL, sizeof SEQUENTIAL);
    bytes[7] = 0; /* a point cloud */
    refused(bytes, sizeof SEQUENTIAL, -1, NULL, version);
}

/* Whatever is turned in a stream: it is read or refused, with no message but those above. */
static void test_damaged(void **state) {
    (void)state;
    for (size_t s = 0; s < COUNT_OF(STREAMS); ++s)
        for (size_t i = 0; i<8 * STREAMS[s].size; i += SLOWER> 1 ? 3 : 1) {
            unsigned char *bytes = malloc(STREAMS[s].size);
            gltf_asset a;
            document_bytes file;
            char message[1000] = "";
            assert_non_null(bytes);
            memcpy(bytes, STREAMS[s].bytes, STREAMS[s].size);
            bytes[i / 8] ^= (unsigned char)(1u << i % 8);
            a = packed(bytes, STREAMS[s].size, -1, NULL);
            asset_bytes(&a, ONE, &file.size);
            file.data = a.glb;
            if (bytes_try(file, "a.glb", NULL, message) != NORMA_DOCUMENT_OK &&
                !strstr(message, "the Draco stream of "))
                fail_msg("bit %zu: %s", i, message);
            asset_free(&a);
            free(bytes);
        }
}

static void test_attribute_that_is_not_there(void **state) {
    gltf_asset a = packed(SEQUENTIAL, sizeof SEQUENTIAL, -1, NULL);
    (void)state;
    const char *message = asset_refused(&a,
        SCENE ",\"meshes\":[{\"primitives\":[{" ATTRIBUTES ",\"extensions\":{\"" NAMES
              "\":{\"bufferView\":0,\"attributes\":{\"POSITION\":0,\"NORMAL\":42}}}}]}]" LISTS,
        0);
    assert_non_null(strstr(message, "/meshes/0/primitives/0: the Draco stream"));
    assert_non_null(strstr(message, "has no attribute 42, which should be NORMAL"));
    message = asset_refused(&a,
        SCENE ",\"meshes\":[{\"primitives\":[{" ATTRIBUTES ",\"extensions\":{\"" NAMES
              "\":{\"bufferView\":0,\"attributes\":{\"POSITION\":-1}}}}]}]" LISTS,
        0);
    assert_non_null(strstr(message, "the numbers of attributes in the Draco stream"));
    message = asset_refused(&a,
        SCENE ",\"meshes\":[{\"primitives\":[{" ATTRIBUTES ",\"extensions\":{\"" NAMES
              "\":{\"bufferView\":7,\"attributes\":{}}}}]}]" LISTS,
        0);
    assert_non_null(strstr(message, "bufferView and attributes as the extension has them"));
    asset_free(&a);
}

/* Named, not read; the rest of the file is. */
static void test_not_read(void **state) {
    static const struct {
        const char *primitive, *why;
    } cases[] = {
        {"{\"mode\":5," ATTRIBUTES ",\"extensions\":{\"" NAMES
         "\":{\"bufferView\":0,\"attributes\":{" IDS "}}}}",
            "viewers disagree on what they mean as a strip"},
        {"{\"mode\":6," ATTRIBUTES ",\"extensions\":{\"" NAMES
         "\":{\"bufferView\":0,\"attributes\":{" IDS "}}}}",
            "which holds no fans"},
        {"{\"attributes\":{\"POSITION\":1},\"extensions\":{\"" NAMES
         "\":{\"bufferView\":0,\"attributes\":{\"POSITION\":0}}}}",
            "but without indices"},
        {"{\"attributes\":{\"POSITION\":1,\"NORMAL\":1},\"indices\":0,\"extensions\":{\"" NAMES
         "\":{\"bufferView\":0,\"attributes\":{\"POSITION\":1}}}}",
            "its accessors already belong to another stream"},
    };
    (void)state;
    for (size_t i = 0; i < COUNT_OF(cases); ++i) {
        gltf_asset a = packed(SEQUENTIAL, sizeof SEQUENTIAL, -1, NULL);
        char rest[3000];
        norma_mesh_info info;
        snprintf(rest, sizeof rest, SCENE ",\"meshes\":[{\"primitives\":[%s,%s]}]" LISTS, PACKED,
            cases[i].primitive);
        norma_document *document = asset_open(&a, rest, 0);
        check_grid(document, 0);
        assert_int_equal(norma_document_mesh_info(document, 1, &info), NORMA_DOCUMENT_OK);
        if (!info.not_read || !strstr(info.not_read, cases[i].why))
            fail_msg("%zu: %s", i, info.not_read ? info.not_read : "read");
        norma_document_close(document);
        asset_free(&a);
    }
}

/* ---- what is written */

static gltf_output computed(gltf_asset *a, const char *rest) {
    static const norma_compute_options smooth = {
        .struct_size = sizeof smooth, .shading = NORMA_SHADING_SMOOTH};
    norma_document *document = asset_open(a, rest, 0);
    norma_document_error error;
    if (norma_document_compute(document, &smooth, NULL, &error)) fail_msg("%s", error.message);
    return output_of(document);
}

/* Its joints and weights, which Norma has no view of, beside its coordinates. */
static void check_skin(const gltf_output *b) {
    const float *texcoords = (const float *)(const void *)output_bytes(b, 3);
    const unsigned char *joints = output_bytes(b, 6);
    const float *weights = (const float *)(const void *)output_bytes(b, 7);
    for (size_t v = 0; v < 9; ++v) {
        const int k = vertex_of(texcoords + 2 * v);
        assert_int_equal(joints[4 * v], k);
        assert_int_equal(joints[4 * v + 1], k + 1);
        assert_near((double)weights[4 * v], 0.25, 1.0 / 255);
        assert_near((double)weights[4 * v + 1], 0.75, 1.0 / 255);
    }
}

/* Every accessor has a view of its own, the first of them that of the stream. */
static void test_written_without_it(void **state) {
    (void)state;
    for (size_t s = 0; s < COUNT_OF(STREAMS); ++s) {
        gltf_asset a = packed(STREAMS[s].bytes, STREAMS[s].size, -1, NULL);
        gltf_output b = computed(&a, ONE);
        int seen = 0;
        assert_non_null(strstr(b.notes, "/meshes/0/primitives/0 was compressed with " NAMES
                                        "; it has changed and is written uncompressed"));
        assert_string_equal(output_text(&b, "meshes/0/primitives/0/extensions"), "");
        assert_string_equal(output_text(&b, "extensionsUsed"), "");
        assert_string_equal(output_text(&b, "extensionsRequired"), "");
        for (long i = 0; i < 8; ++i) {
            const long view = output_number(&b, "accessors/%ld/bufferView", i);
            assert_in_range(view, 0, 7);
            seen |= 1 << view;
            assert_int_equal(output_number(&b, "bufferViews/%ld/target", view), i ? 34962 : 34963);
        }
        assert_int_equal(seen, 0xFF);
        assert_string_equal(output_text(&b, "bufferViews/8"), "");
        check_skin(&b);
        output_finish(&b, &a);
    }
}

/* Two primitives of one stream: the one that changes leaves it, the other and the lists stay. */
static void test_one_of_two(void **state) {
    static const float up[27] = {
        0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1};
    static const uint8_t set[9] = {1, 1, 1, 1, 1, 1, 1, 1, 1};
    static const norma_mesh_edit edits[2] = {{.normals = up, .set_normals = set}};
    gltf_asset a = packed(EDGEBREAKER, sizeof EDGEBREAKER, -1, NULL);
    norma_document *document =
        asset_open(&a, SCENE ",\"meshes\":[{\"primitives\":[" PACKED "," PACKED "]}]" LISTS, 0);
    norma_document_error error;
    double normal[3];
    (void)state;
    if (norma_document_edit(document, edits, &error)) fail_msg("%s", error.message);
    gltf_output b = output_of(document);
    assert_string_equal(output_text(&b, "meshes/0/primitives/0/extensions"), "");
    assert_int_equal(
        output_number(&b, "meshes/0/primitives/1/extensions/" NAMES "/bufferView", 0), 0);
    assert_string_equal(output_text(&b, "extensionsRequired/0"), "\"" NAMES "\"");
    check_grid(b.document, 1);
    const norma_mesh_data data = output_mesh(&b, 0);
    norma_view_vector(&data.normals, 4, normal);
    assert_near(normal[2], 1, 0);
    output_finish(&b, &a);
}

/* Nothing changes: the stream stays, byte for byte. */
static void test_unchanged(void **state) {
    static const norma_compute_options missing = {
        .struct_size = sizeof missing, .only = NORMA_ONLY_MISSING};
    gltf_asset a = packed(EDGEBREAKER, sizeof EDGEBREAKER, -1, NULL);
    norma_document_error error;
    document_bytes before = {0};
    (void)state;
    asset_bytes(&a, ONE, &before.size);
    before = bytes_copy(a.glb, before.size);
    norma_document *document = asset_open(&a, ONE, 0); /* its bytes live as long as it does */
    if (norma_document_compute(document, &missing, NULL, &error)) fail_msg("%s", error.message);
    document_bytes after = bytes_of(document);
    assert_true(bytes_equal(before, after));
    assert_int_equal(norma_document_note_count(document), 0);
    norma_document_close(document);
    bytes_free(&before);
    bytes_free(&after);
    asset_free(&a);
}

/* Normals and tangents removed: nothing is written for them. */
static void test_stripped(void **state) {
    static const norma_mesh_edit edit = {.strip_normals = NORMA_STRIP_ALL};
    gltf_asset a = packed(SEQUENTIAL, sizeof SEQUENTIAL, -1, NULL);
    norma_document *document = asset_open(&a, ONE, 0);
    norma_document_error error;
    (void)state;
    if (norma_document_edit(document, &edit, &error)) fail_msg("%s", error.message);
    gltf_output b = output_of(document);
    assert_string_equal(output_text(&b, "meshes/0/primitives/0/attributes/NORMAL"), "");
    assert_string_equal(output_text(&b, "meshes/0/primitives/0/extensions"), "");
    assert_string_equal(output_text(&b, "accessors/2/bufferView"), "");
    assert_string_equal(output_text(&b, "extensionsUsed"), "");
    check_skin(&b);
    output_finish(&b, &a);
}

/* A mesh at two places, baked into two: both without the stream. */
static void test_baked_copies(void **state) {
    gltf_asset a = packed(EDGEBREAKER, sizeof EDGEBREAKER, -1, NULL);
    double at[3];
    (void)state;
    gltf_output b = output_transformed(&a,
        "\"nodes\":[{\"mesh\":0,\"translation\":[5,0,0]},{\"mesh\":0,\"translation\":[0,7,0]}],"
        "\"scenes\":[{\"nodes\":[0,1]}],\"scene\":0,\"meshes\":[{\"primitives\":[" PACKED
        "]}]" LISTS,
        1, NULL);
    assert_int_equal(norma_document_mesh_count(b.document), 2);
    assert_string_equal(output_text(&b, "extensionsUsed"), "");
    assert_string_equal(output_text(&b, "meshes/1/primitives/0/extensions"), "");
    for (size_t m = 0; m < 2; ++m) {
        const norma_mesh_data data = output_mesh(&b, m);
        double least[3] = {INFINITY, INFINITY, INFINITY};
        for (size_t v = 0; v < 9; ++v) {
            norma_view_vector(&data.mesh.positions, v, at);
            for (int k = 0; k < 3; ++k) least[k] = fmin(least[k], at[k]);
        }
        assert_near(least[0], m ? 0 : 5, 1e-6);
        assert_near(least[1], m ? 7 : 0, 1e-6);
    }
    output_finish(&b, &a);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_values),
        cmocka_unit_test(test_fallback_is_not_read),
        cmocka_unit_test(test_shared_with_one_before),
        cmocka_unit_test(test_lying_accessors),
        cmocka_unit_test(test_cut_short),
        cmocka_unit_test(test_lying_headers),
        cmocka_unit_test(test_damaged),
        cmocka_unit_test(test_attribute_that_is_not_there),
        cmocka_unit_test(test_not_read),
        cmocka_unit_test(test_written_without_it),
        cmocka_unit_test(test_one_of_two),
        cmocka_unit_test(test_unchanged),
        cmocka_unit_test(test_stripped),
        cmocka_unit_test(test_baked_copies),
    };
    if (!norma_draco_reads()) {
        print_message("built without libdraco: nothing to test\n");
        return 0;
    }
    return cmocka_run_group_tests(tests, NULL, NULL);
}
