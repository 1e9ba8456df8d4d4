/* test_gltf_corners.c: glTF and matrices in their corners: attributes of kinds that cannot be
 * baked, meshes that stay as they are and why, instances, skins and edits that do not fit, codes
 * below the least, matrices that flatten. */
#include "check.h"
#include "message.h"
#include "document_bytes.h"
#include "gltf_asset.h"

static const float CORNERS[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
static const double ZEROS[16] = {0};
enum { BYTE = 5120, UBYTE, SHORT, USHORT, UINT = 5125, FLOAT };

typedef enum act { READ, BAKE, INSTANCES, SKIN, EDIT_NORMALS, EDIT_TANGENTS, COMPUTE_MORPHS } act;

static norma_document_result do_it(
    norma_document *document, act what, norma_document_error *error) {
    const norma_transform_options bake = {.struct_size = sizeof bake,
        .matrix = {2, 0, 0, 0, 0, 3, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1},
        .bake = 1};
    const norma_compute_options morphs = {.struct_size = sizeof morphs, .morphs = 1};
    const uint8_t mark[3] = {1, 1, 1};
    const float vectors[12] = {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1};
    const norma_mesh_edit normals = {.normals = vectors, .set_normals = mark},
                          tangents = {.tangents = vectors, .set_tangents = mark};
    norma_skin_info skin;
    double world[16];
    switch (what) {
    case BAKE:
        return norma_document_transform(document, &bake, NULL, error);
    case INSTANCES:
        return norma_document_instance_world(document, 0, 0, world, error);
    case SKIN:
        return norma_document_skin_info(document, 0, &skin, error);
    case EDIT_NORMALS:
        return norma_document_edit(document, &normals, error);
    case EDIT_TANGENTS:
        return norma_document_edit(document, &tangents, error);
    case COMPUTE_MORPHS:
        return norma_document_compute(document, &morphs, NULL, error);
    default:
        return NORMA_DOCUMENT_OK;
    }
}

/* Accessors: 0 three positions, 1 three pairs, 2 three vectors of 32-bit numbers, 3 three vectors,
 * 4 two vectors, 5 three vectors of four, 6 sixty thousand vectors without bytes. */
/* attributes: what follows POSITION in the primitive, the closing brace of its attributes included.
 */
static norma_document *open_corners(gltf_asset *a, const char *attributes, const char *more) {
    char rest[900];
    asset_floats(a, CORNERS, 3, 3);
    asset_floats(a, CORNERS, 3, 2);
    asset_numbers(a, ZEROS, 3, 3, UINT, 0);
    asset_floats(a, CORNERS, 3, 3);
    asset_floats(a, CORNERS, 2, 3);
    asset_numbers(a, ZEROS, 3, 4, FLOAT, 0);
    asset_accessor(a, "{\"componentType\":5126,\"count\":60000,\"type\":\"VEC3\"}");
    snprintf(rest, sizeof rest,
        "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0%s}]}],%s", attributes, more);
    return asset_open(a, rest, 0);
}

#define NODE "\"nodes\":[{\"mesh\":0}]"

static void test_what_does_not_fit(void **state) {
    static const struct {
        act what;
        norma_document_result result;
        const char *attributes, *more, *message;
    } cases[] = {
        {BAKE, NORMA_DOCUMENT_ERROR_MALFORMED, ",\"NORMAL\":1}", NODE,
            "/accessors/1: expected the type VEC3; found "},
        {BAKE, NORMA_DOCUMENT_ERROR_MALFORMED, ",\"NORMAL\":2}", NODE,
            "/accessors/2: expected floats, or integers of at most 16 bits; found "},
        {BAKE, NORMA_DOCUMENT_ERROR_MALFORMED, ",\"NORMAL\":3,\"TANGENT\":3}", NODE,
            "/accessors/3: expected the type VEC4 for tangents; found "},
        {INSTANCES, NORMA_DOCUMENT_ERROR_MALFORMED, "}",
            "\"nodes\":[{\"mesh\":0,\"extensions\":{\"EXT_mesh_gpu_instancing\":{\"attributes\":{"
            "\"TRANSLATION\":0,\"SCALE\":9}}}}]",
            "/nodes/0/extensions/EXT_mesh_gpu_instancing/attributes/SCALE: expected the number of "
            "an existing accessor; found "},
        {INSTANCES, NORMA_DOCUMENT_ERROR_MALFORMED, "}",
            "\"nodes\":[{\"mesh\":0,\"extensions\":{\"EXT_mesh_gpu_instancing\":{\"attributes\":{"
            "\"TRANSLATION\":0,\"SCALE\":4}}}}]",
            "/nodes/0/extensions/EXT_mesh_gpu_instancing/attributes/SCALE: expected one vector for "
            "each instance; found "},
        {INSTANCES, NORMA_DOCUMENT_ERROR_MALFORMED, "}",
            "\"nodes\":[{\"mesh\":0,\"extensions\":{\"EXT_mesh_gpu_instancing\":{\"attributes\":{"
            "\"TRANSLATION\":0,\"ROTATION\":3}}}}]",
            "/nodes/0/extensions/EXT_mesh_gpu_instancing/attributes/ROTATION: expected one vector "
            "for each instance; found "},
        {INSTANCES, NORMA_DOCUMENT_ERROR_MALFORMED, "}",
            "\"nodes\":[{\"mesh\":0,\"extensions\":{\"EXT_mesh_gpu_instancing\":{\"attributes\":{"
            "\"_ID\":6}}}}]",
            "/accessors/6: expected a count that is plausible for the size of the file; found "},
        {SKIN, NORMA_DOCUMENT_ERROR_MALFORMED, "}", "\"nodes\":[{}],\"skins\":[{\"joints\":{}}]",
            "/skins/0/joints: expected an array; found "},
        {SKIN, NORMA_DOCUMENT_ERROR_MALFORMED, "}", "\"nodes\":[{}],\"skins\":[{\"joints\":[0,1]}]",
            "/skins/0/joints/1: expected the number of an existing node; found "},
        {EDIT_NORMALS, NORMA_DOCUMENT_ERROR_ARGUMENT, "}", NODE,
            "/meshes/0/primitives/0: has no NORMAL that could be replaced"},
        {EDIT_NORMALS, NORMA_DOCUMENT_ERROR_MALFORMED, ",\"NORMAL\":1}", NODE,
            "/accessors/1: expected as many vectors as vertices; found "},
        {EDIT_TANGENTS, NORMA_DOCUMENT_ERROR_MALFORMED, ",\"TANGENT\":3}", NODE,
            "/accessors/3: expected as many vectors as vertices; found "},
        {COMPUTE_MORPHS, NORMA_DOCUMENT_ERROR_MALFORMED, "},\"targets\":[{\"POSITION\":1}]", NODE,
            "/accessors/1: expected displacements of three numbers; found "},
    };
    size_t wrong = 0;
    (void)state;
    for (size_t i = 0; i < COUNT_OF(cases); ++i) {
        gltf_asset a = {0};
        char expected[1000];
        norma_document_error error = {0};
        norma_document *document = open_corners(&a, cases[i].attributes, cases[i].more);
        const norma_document_result result = do_it(document, cases[i].what, &error);
        snprintf(expected, sizeof expected, "asset.glb:%s", cases[i].message);
        if (result != cases[i].result || !is_message(error.message, expected)) {
            print_error("case %zu: result %d, \"%s\"\n   expected %d, \"%s\"\n", i, (int)result,
                error.message, (int)cases[i].result, expected);
            ++wrong;
        }
        norma_document_close(document);
        asset_free(&a);
    }
    assert_int_equal(wrong, 0);
}

/* What is not baked is named, and drawn as before: its node keeps its matrix. */
static void test_what_stays(void **state) {
    static const struct {
        const char *primitive, *more, *note;
    } cases[] = {
        {",\"extensions\":{\"KHR_gaussian_splatting\":{}}", NODE,
            "node 0 is not baked: mesh 0 holds splats (KHR_gaussian_splatting)"},
        {",\"extensions\":{\"KHR_draco_mesh_compression\":{}}",
            "\"nodes\":[{\"mesh\":0,\"name\":\"leg\"}]",
            "node 0 is not baked: mesh 0 is compressed with KHR_draco_mesh_compression and "
            "cannot be read"},
        {"",
            "\"nodes\":[{\"mesh\":0,\"name\":\"leg\"}],\"animations\":[{\"samplers\":[{\"input\":0,"
            "\"output\":3}],\"channels\":[{\"sampler\":0,\"target\":{\"node\":0,\"path\":"
            "\"translation\"}}]}]",
            "node 0 \"leg\" is not baked: it is animated"},
        {"",
            "\"nodes\":[{\"children\":[1]},{\"mesh\":0}],\"animations\":[{\"samplers\":[{\"input\":"
            "0,\"output\":3}],\"channels\":[{\"sampler\":0,\"target\":{\"node\":0,\"path\":"
            "\"scale\"}}]}]",
            "node 1 is not baked: a node above it is animated"},
        {"", "\"nodes\":[{\"mesh\":0,\"skin\":0}],\"skins\":[{\"joints\":[0]}]",
            "node 0 is not baked: its mesh is skinned, and follows its joints"},
    };
    (void)state;
    for (size_t i = 0; i < COUNT_OF(cases); ++i) {
        gltf_asset a = {0};
        norma_document_error error = {0};
        char attributes[300];
        int found = 0;
        snprintf(attributes, sizeof attributes, "}%s", cases[i].primitive);
        norma_document *document = open_corners(&a, attributes, cases[i].more);
        if (do_it(document, BAKE, &error)) fail_msg("%zu: %s", i, error.message);
        for (size_t n = 0; n < norma_document_note_count(document); ++n)
            found |= strcmp(norma_document_note(document, n), cases[i].note) == 0;
        if (!found)
            fail_msg("%zu: no note \"%s\", but \"%s\"", i, cases[i].note,
                norma_document_note(document, 0));
        norma_document_close(document);
        asset_free(&a);
    }
}

/* -128 counts as -127 (glTF 2.0, 3.11): two triangles that meet at one and the other share their
 * positions, and so their normals. */
static void test_codes_below_the_least(void **state) {
    static const int types[] = {BYTE, SHORT};
    (void)state;
    for (size_t t = 0; t < COUNT_OF(types); ++t) {
        const double low = types[t] == BYTE ? -128 / 127.0 : -32768 / 32767.0;
        const double positions[6][3] = {
            {-1, 0, 0}, {1, 0, 0}, {-1, 1, 0}, {low, 0, 0}, {low, 1, 0}, {-1, 0, 1}};
        gltf_asset a = {0};
        norma_mesh_data data;
        norma_document_error error;
        const norma_compute_options smooth = {
            .struct_size = sizeof smooth, .shading = NORMA_SHADING_SMOOTH};
        asset_numbers(&a, positions[0], 6, 3, types[t], 1);
        norma_document *document = asset_open(&a,
            "\"extensionsUsed\":[\"KHR_mesh_quantization\"],\"meshes\":[{\"primitives\":[{"
            "\"attributes\":{\"POSITION\":0}}]}]",
            0);
        if (norma_document_compute(document, &smooth, NULL, &error)) fail_msg("%s", error.message);
        document_bytes out = bytes_of(document);
        norma_document_close(document);
        document = bytes_open(out, "asset.glb");
        assert_int_equal(norma_document_mesh_data(document, 0, &data, NULL), NORMA_DOCUMENT_OK);
        const float *n = data.normals.data;
        assert_memory_equal(n + 0, n + 9, 12);
        assert_memory_equal(n + 6, n + 12, 12);
        assert_direction(n, 1, 0, 1,
            0.001); /* between two faces at a right angle, each with one of its corners there */
        norma_document_close(document);
        bytes_free(&out);
        asset_free(&a);
    }
}

static void test_encodings_are_told(void **state) {
    static const struct {
        int component;
        const char *name;
    } cases[] = {{BYTE, "snorm8"}, {UBYTE, "unorm8"}, {SHORT, "snorm16"}, {USHORT, "unorm16"},
        {FLOAT, "float"}};
    (void)state;
    for (size_t i = 0; i < COUNT_OF(cases); ++i) {
        gltf_asset a = {0};
        norma_mesh_info info;
        norma_mesh_attributes attributes;
        asset_floats(&a, CORNERS, 3, 3);
        asset_numbers(&a, ZEROS, 3, 3, cases[i].component, 1);
        asset_numbers(&a, ZEROS, 3, 4, cases[i].component, 1);
        norma_document *document = asset_open(&a,
            "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"NORMAL\":1,\"TANGENT\":"
            "2}}]}]",
            1);
        assert_int_equal(norma_document_mesh_info(document, 0, &info), NORMA_DOCUMENT_OK);
        assert_int_equal(
            norma_document_mesh_attributes(document, 0, &attributes, NULL), NORMA_DOCUMENT_OK);
        assert_string_equal(info.encoding, cases[i].name);
        assert_string_equal(attributes.tangent_encoding, cases[i].name);
        norma_document_close(document);
        asset_free(&a);
    }
}

/* Pressed flat, what stood upright has no direction of its own any more and gets the one that
 * remains. */
static void test_flattened(void **state) {
    static const char ply[] =
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty "
        "float z\nproperty float nx\nproperty float ny\nproperty float nz\nelement face "
        "1\nproperty list uchar int vertex_indices\nend_header\n0 0 0 1 0 0\n1 0 0 0 0 1\n0 1 0 0 "
        "-1 0\n3 0 1 2\n";
    static const char stl[] = "solid a\nfacet normal 1 0 0 outer loop vertex 0 0 0 vertex 0 1 0 "
                              "vertex 0 0 1 endloop endfacet\nendsolid a\n";
    static const struct {
        const char *name, *text, *note;
        size_t count;
    } files[] = {
        {"a.ply", ply,
            "normals that vanish under this matrix, because it flattens: 2; they got the one "
            "direction that is left",
            3},
        {"a.stl", stl,
            "normals that vanish under this matrix, because it flattens: 1; they got the one "
            "direction that is left",
            1},
    };
    const norma_transform_options options = {
        .struct_size = sizeof options, .matrix = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1}};
    (void)state;
    for (size_t i = 0; i < COUNT_OF(files); ++i) {
        document_bytes in = bytes_copy(files[i].text, strlen(files[i].text));
        norma_document *document = bytes_open(in, files[i].name);
        norma_document_error error;
        norma_mesh_data data;
        if (norma_document_transform(document, &options, NULL, &error))
            fail_msg("%s", error.message);
        assert_int_equal(norma_document_note_count(document), 1);
        assert_string_equal(norma_document_note(document, 0), files[i].note);
        assert_int_equal(norma_document_mesh_data(document, 0, &data, NULL), NORMA_DOCUMENT_OK);
        assert_int_equal(data.normals.count, files[i].count);
        for (size_t n = 0; n < files[i].count; ++n)
            assert_direction((const float *)data.normals.data + 3 * n, 0, 0, 1, 1e-5);
        norma_document_close(document);
        bytes_free(&in);
    }
}

/* Two normals that a primitive of forty vertices and one of four share, read leniently: what
 * follows them reaches for both, whichever comes first. */
static void test_too_few_normals_shared(void **state) {
    static const float normals[6] = {0, 0, 1, 0, 0, 1};
    double places[40][3];
    (void)state;
    for (int i = 0; i < 40; ++i)
        places[i][0] = i % 3 == 1, places[i][1] = i % 3 == 2, places[i][2] = i / 3;
    for (int few_first = 0; few_first < 2; ++few_first) {
        const norma_compute_options broken = {
            .struct_size = sizeof broken, .only = NORMA_ONLY_BROKEN};
        norma_compute_summary summary;
        norma_document_error error;
        gltf_asset a = {0};
        asset_numbers(&a, places[0], 40, 3, FLOAT, 0);
        asset_numbers(&a, places[0], 4, 3, FLOAT, 0);
        asset_floats(&a, normals, 2, 3);
        norma_document *document = asset_open(&a,
            few_first ? "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":1,\"NORMAL\":2}"
                        "},{\"attributes\":{\"POSITION\":0,\"NORMAL\":2}}]}]"
                      : "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"NORMAL\":2}"
                        "},{\"attributes\":{\"POSITION\":1,\"NORMAL\":2}}]}]",
            1);
        if (norma_document_compute(document, &broken, &summary, &error))
            fail_msg("%s", error.message);
        document_bytes out = bytes_of(document);
        norma_document *after = bytes_open(out, "a.glb");
        for (size_t m = 0; m < 2; ++m) {
            norma_mesh_data data;
            assert_int_equal(norma_document_mesh_data(after, m, &data, NULL), NORMA_DOCUMENT_OK);
            assert_int_equal(data.normals.count, data.mesh.positions.count);
            for (size_t v = 0; v < data.normals.count; ++v) {
                const float *n = (const float *)data.normals.data + 3 * v;
                assert_true(n[0] == 0 && n[1] == 0 && (n[2] == 1 || n[2] == -1));
            }
        }
        norma_document_close(after);
        norma_document_close(document);
        bytes_free(&out);
        asset_free(&a);
    }
}

/* Instancing without an attribute: one instance, where the node is. With one that is no place: as
 * many as it has elements, all there. */
static void test_instances_without_places(void **state) {
    static const uint16_t ids[4] = {7, 8, 9, 10};
    gltf_asset a = {0};
    (void)state;
    asset_floats(&a, CORNERS, 3, 3);
    asset_uint16(&a, ids, 4);
    for (int named = 0; named < 2; ++named) {
        char rest[300];
        double world[16];
        norma_node_info info;
        snprintf(rest, sizeof rest,
            "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],\"nodes\":[{"
            "\"mesh\":0,\"scale\":[-1,1,1],\"extensions\":{\"EXT_mesh_gpu_instancing\":{"
            "\"attributes\":{%s}}}}]",
            named ? "\"_ID\":1" : "");
        norma_document *document = asset_open(&a, rest, 0);
        assert_int_equal(norma_document_node_info(document, 0, &info), NORMA_DOCUMENT_OK);
        assert_int_equal(info.instances, named ? 4 : 1);
        assert_int_equal(info.mirrored_instances, info.instances);
        assert_int_equal(
            norma_document_instance_world(document, 0, info.instances - 1, world, NULL),
            NORMA_DOCUMENT_OK);
        assert_true(world[0] == -1 && world[5] == 1 && world[10] == 1 && world[12] == 0);
        norma_document_close(document);
    }
    asset_free(&a);
}

/* Too few normals are told of, and mended; what else names them would keep them, and is refused. */
static void test_too_few_normals_elsewhere(void **state) {
    static const float normals[6] = {0, 0, 1, 0, 0, 1};
    gltf_asset a = {0};
    (void)state;
    asset_floats(&a, CORNERS, 3, 3);
    asset_floats(&a, normals, 2, 3);
    assert_message(asset_refused(&a,
                       "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,"
                       "\"NORMAL\":1,\"_OLD\":1}}]}]",
                       1),
        "asset.glb:/meshes/0/primitives/0/attributes/_OLD: expected an accessor with as many "
        "elements as POSITION has; found ");
    norma_document_close(asset_open(
        &a, "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"NORMAL\":1}}]}]", 1));
    asset_free(&a);
}

/* Indices of one primitive, sparse, that are the "normals" of another, of which there are too few:
 * read leniently the corners stay what they are. */
static void test_indices_as_normals(void **state) {
    static const uint32_t indices[6] = {0, 1, 2, 2, 1, 0}, expected[6] = {0, 3, 2, 2, 1, 0};
    static const float places[27] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0};
    gltf_asset a = {0};
    char text[400];
    norma_mesh_data data;
    (void)state;
    asset_floats(&a, places, 9, 3);
    const int base = asset_view(&a, indices, sizeof indices, ""),
              which = asset_view(&a, (const uint16_t[]){1}, 2, ""),
              value = asset_view(&a, (const uint32_t[]){3}, 4, "");
    snprintf(text, sizeof text,
        "{\"bufferView\":%d,\"componentType\":5125,\"count\":6,\"type\":\"SCALAR\",\"sparse\":{"
        "\"count\":1,\"indices\":{\"bufferView\":%d,\"componentType\":5123},\"values\":{"
        "\"bufferView\":%d}}}",
        base, which, value);
    asset_accessor(&a, text);
    norma_document *document = asset_open(&a,
        "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1},{"
        "\"attributes\":{\"POSITION\":0,\"NORMAL\":1}}]}]",
        1);
    assert_int_equal(norma_document_mesh_data(document, 0, &data, NULL), NORMA_DOCUMENT_OK);
    assert_int_equal(data.mesh.corner_count, 6);
    assert_memory_equal(data.mesh.corners, expected, sizeof expected);
    norma_document_close(document);
    asset_free(&a);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_too_few_normals_shared),
        cmocka_unit_test(test_indices_as_normals),
        cmocka_unit_test(test_instances_without_places),
        cmocka_unit_test(test_too_few_normals_elsewhere),
        cmocka_unit_test(test_what_does_not_fit),
        cmocka_unit_test(test_what_stays),
        cmocka_unit_test(test_codes_below_the_least),
        cmocka_unit_test(test_encodings_are_told),
        cmocka_unit_test(test_flattened),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
