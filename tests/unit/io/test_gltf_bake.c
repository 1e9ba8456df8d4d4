/* test_gltf_bake.c: what --bake meets rarely: instances beside other extensions, weights that
 * animate what has several meshes, strips and lines under a mirror, tangents that no normal goes
 * with, whole numbers that stay whole, a root that a scene lists twice. Judged by what is drawn,
 * worked out by hand, and by what the specifications of glTF and its extensions ask of the file. */
#include "check.h"
#include "message.h"
#include "gltf_asset.h"
#include "gltf_output.h"

enum { BYTE = 5120, UBYTE, SHORT, USHORT, UINT = 5125, FLOAT };

#define SCENE "\"scene\":0,\"scenes\":[{\"nodes\":[0]}],"
#define QUANTIZED                                                                                  \
    "\"extensionsUsed\":[\"KHR_mesh_quantization\"],\"extensionsRequired\":[\"KHR_mesh_"           \
    "quantization\"],"
static const double TRIANGLE[3][3] = {{0, 0, 0}, {2, 0, 0}, {0, 1, 0}};

static void assert_world_is_identity(const gltf_output *b, size_t node) {
    norma_node_info info;
    assert_int_equal(norma_document_node_info(b->document, node, &info), NORMA_DOCUMENT_OK);
    for (int i = 0; i < 16; ++i) assert_true(fabs(info.world[i] - (i % 5 == 0)) < 1e-12);
}

/* glTF 2.0: 3.6.2.4: each element of a vertex attribute is at a multiple of four; an accessor that
 * nothing uses is reported by the validator. */
static void assert_well_formed(const gltf_output *b) {
    const long accessors =
        (long)norma_json_size(&b->json, norma_json_member(&b->json, 0, "accessors"));
    for (long i = 0; i < accessors; ++i) {
        const long type = output_number(b, "accessors/%ld/componentType", i),
                   view = output_number(b, "accessors/%ld/bufferView", i),
                   stride = output_number(b, "bufferViews/%ld/byteStride", view);
        char path[60];
        snprintf(path, sizeof path, "accessors/%ld/type", i);
        const int is_vertex = strcmp(output_text(b, path), "\"VEC3\"") == 0;
        if (is_vertex && (type == BYTE || type == UBYTE || type == SHORT || type == USHORT))
            assert_true(stride > 0 && stride % 4 == 0);
    }
}

/* ---- instances */

/* Two instances, one of them mirrored, of a mesh with normals in a byte each; on their node another
 * extension, and numbers for each instance besides its place. The node's own extension stays, the
 * list of extensions keeps what is used; the accessors of the instances, which nothing needs any
 * more, hold the second mesh's. */
static void test_instances_beside_other_extensions(void **state) {
    static const float normals[3][3] = {{0, 0, 1}, {1, 0, 0}, {0, 1, 0}},
                       places[2][3] = {{10, 0, 0}, {0, 20, 0}},
                       sizes[2][3] = {{1, 1, 1}, {-1, 2, 1}};
    static const double numbers[2] = {7, 8};
    gltf_asset a = {0};
    (void)state;
    asset_numbers(&a, TRIANGLE[0], 3, 3, FLOAT, 0);
    asset_snorm8(&a, normals[0], 3, 3);
    asset_uint16(&a, (const uint16_t[]){0, 1, 2}, 3);
    asset_floats(&a, places[0], 2, 3);
    asset_floats(&a, sizes[0], 2, 3);
    asset_numbers(&a, numbers, 2, 1, FLOAT, 0);
    gltf_output b = output_transformed(&a,
        SCENE "\"extensionsUsed\":[\"KHR_node_visibility\",\"EXT_mesh_gpu_instancing\",\"KHR_mesh_"
              "quantization\"],\"extensionsRequired\":[\"KHR_mesh_quantization\",\"EXT_mesh_gpu_"
              "instancing\"],\"nodes\":[{\"mesh\":0,\"extensions\":{\"KHR_node_visibility\":{"
              "\"visible\":true},\"EXT_mesh_gpu_instancing\":{\"attributes\":{\"TRANSLATION\":3,"
              "\"SCALE\":4,\"_ID\":5}}}}],\"meshes\":[{\"primitives\":[{\"attributes\":{"
              "\"POSITION\":0,\"NORMAL\":1},\"indices\":2}]}]",
        1, NULL);
    assert_string_equal(
        output_text(&b, "extensionsUsed"), "[\"KHR_node_visibility\",\"KHR_mesh_quantization\"]");
    assert_string_equal(output_text(&b, "extensionsRequired"), "[\"KHR_mesh_quantization\"]");
    assert_string_equal(
        output_text(&b, "nodes/0/extensions"), "{\"KHR_node_visibility\":{\"visible\":true}}");
    assert_non_null(strstr(b.notes, "node 0: other attributes of its instances (such as _ID) "
                                    "cannot be stored in separate meshes and are dropped\n"));
    assert_int_equal(norma_document_node_count(b.document), 2);
    assert_int_equal(norma_document_mesh_count(b.document), 2);
    assert_world_is_identity(&b, 0);
    assert_world_is_identity(&b, 1);
    assert_well_formed(&b);
    for (size_t m = 0; m < 2; ++m) {
        norma_mesh_data data = output_mesh(&b, m);
        norma_mesh_info info;
        assert_int_equal(norma_document_mesh_info(b.document, m, &info), NORMA_DOCUMENT_OK);
        assert_string_equal(info.encoding, "snorm8");
        for (size_t v = 0; v < 3; ++v) {
            double p[3], n[3];
            for (int k = 0; k < 3; ++k) {
                p[k] = TRIANGLE[v][k] * (double)sizes[m][k] + (double)places[m][k];
                n[k] =
                    (double)normals[v][k] *
                    (k == 0 && m == 1 ? -1 : 1); /* each along an axis, and the mirror is along x */
            }
            assert_vector(&data.mesh.positions, v, p, 0);
            assert_vector(&data.normals, v, n, 0);
        }
        const uint32_t *corners = data.mesh.corners;
        assert_true(corners[0] == 0 && corners[1] == (m ? 2 : 1) && corners[2] == (m ? 1 : 2));
    }
    assert_int_equal(norma_json_size(&b.json, norma_json_member(&b.json, 0, "accessors")),
        6); /* three for each mesh: none new, none left over */
    output_finish(&b, &a);
}

/* One morph target, animated through KHR_animation_pointer, of a node with two instances: they
 * would have to share one animation. The node stays, and says so. */
static void test_weights_of_several_meshes(void **state) {
    static const float places[2][3] = {{10, 0, 0}, {0, 20, 0}}, times[2] = {0, 1},
                       weights[2] = {0, 1};
    gltf_asset a = {0};
    (void)state;
    asset_numbers(&a, TRIANGLE[0], 3, 3, FLOAT, 0);
    asset_floats(&a, places[0], 2, 3);
    asset_floats(&a, times, 2, 1);
    asset_floats(&a, weights, 2, 1);
    static const char node[] = "{\"mesh\":0,\"name\":\"two\",\"scale\":[2,2,2],\"extensions\":{"
                               "\"EXT_mesh_gpu_instancing\":{\"attributes\":{\"TRANSLATION\":1}}}}";
    char rest[1500];
    snprintf(rest, sizeof rest,
        SCENE "\"extensionsUsed\":[\"KHR_animation_pointer\",\"EXT_mesh_gpu_instancing\"],"
              "\"nodes\":[%s],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},"
              "\"targets\":[{\"POSITION\":0}]}]}],\"animations\":[{\"samplers\":[{\"input\":2,"
              "\"output\":3}],\"channels\":[{\"sampler\":0,\"target\":{\"path\":\"pointer\","
              "\"extensions\":{\"KHR_animation_pointer\":{\"pointer\":\"/nodes/0/weights\"}}}}]}]",
        node);
    gltf_output b = output_transformed(&a, rest, 1, NULL);
    assert_string_equal(output_text(&b, "nodes/0"), node);
    assert_string_equal(b.notes, "node 0 \"two\" is not baked: its morph weights are animated, and "
                                 "it holds more than one mesh at one place\n");
    output_finish(&b, &a);
    asset_numbers(
        &a, TRIANGLE[0], 3, 3, FLOAT, 0); /* of a node with one mesh they stay where they are */
    asset_floats(&a, places[0], 2, 3);
    asset_floats(&a, times, 2, 1);
    asset_floats(&a, weights, 2, 1);
    memcpy(strstr(rest, "EXT_mesh_gpu_instancing\":{"), "NOT_mesh_gpu_instancing", 23);
    memcpy(strstr(rest, "\"extensions\":{\"NOT"), "\"extras\":{    \"NOT", 18);
    b = output_transformed(&a, rest, 1, NULL);
    assert_world_is_identity(&b, 0);
    assert_string_equal(b.notes, "");
    norma_mesh_data data = output_mesh(&b, 0);
    assert_vector(&data.mesh.positions, 1, (const double[]){4, 0, 0}, 0);
    output_finish(&b, &a);
}

/* ---- winding under a mirror */

/* An even strip has no reversed strip: it becomes a list, each triangle turned, without those that
 * only lead from one part to the next (glTF 2.0, 3.7.2.1: triangle i is v(i), v(i + (1 + i % 2)),
 * v(i + (2 - i % 2))). */
static void test_a_strip_with_stitches(void **state) {
    static const double points[5][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 2, 0}, {0, 3, 1}};
    gltf_asset a = {0};
    (void)state;
    asset_numbers(&a, points[0], 5, 3, FLOAT, 0);
    asset_uint16(&a, (const uint16_t[]){0, 1, 2, 2, 3, 4}, 6);
    gltf_output b = output_transformed(&a,
        SCENE "\"nodes\":[{\"mesh\":0,\"scale\":[1,-1,1]}],\"meshes\":[{\"primitives\":[{"
              "\"attributes\":{\"POSITION\":0},\"indices\":1,\"mode\":5}]}]",
        1, NULL);
    assert_corners(&b, 0, (const uint32_t[]){0, 2, 1, 2, 3, 4}, 6);
    assert_string_equal(output_text(&b, "meshes/0/primitives/0/mode"), "4");
    output_finish(&b, &a);
}

/* Lines have no winding, and two corners make no triangle: both keep their indices; the triangle
 * beside them turns. */
static void test_what_has_no_winding(void **state) {
    gltf_asset a = {0};
    (void)state;
    asset_numbers(&a, TRIANGLE[0], 3, 3, FLOAT, 0);
    asset_uint16(&a, (const uint16_t[]){0, 1, 2}, 3);
    asset_uint16(&a, (const uint16_t[]){2, 1, 0}, 3);
    asset_uint16(&a, (const uint16_t[]){1, 2}, 2);
    gltf_output b = output_transformed(&a,
        SCENE "\"nodes\":[{\"mesh\":0,\"scale\":[-1,1,1]}],\"meshes\":[{\"primitives\":[{"
              "\"attributes\":{\"POSITION\":0},\"indices\":1},{\"attributes\":{\"POSITION\":0},"
              "\"indices\":2,\"mode\":3},{\"attributes\":{\"POSITION\":0},\"indices\":3}]}]",
        1, NULL);
    assert_corners(&b, 0, (const uint32_t[]){0, 2, 1}, 3);
    for (long i = 1; i < 3; ++i) {
        const uint16_t expected[2][4] = {{2, 1, 0}, {1, 2}};
        const long accessor = output_number(&b, "meshes/0/primitives/%ld/indices", i);
        assert_int_equal(output_number(&b, "accessors/%ld/count", accessor), i == 1 ? 3 : 2);
        assert_memory_equal(output_bytes(&b, accessor), expected[i - 1], i == 1 ? 6 : 4);
    }
    norma_mesh_data data = output_mesh(&b, 0);
    assert_vector(&data.mesh.positions, 1, (const double[]){-2, 0, 0}, 0);
    output_finish(&b, &a);
}

/* ---- vectors */

/* A matrix that leaves only the z axis: a tangent along x has no image and there is no normal to be
 * perpendicular to; what is written is of unit length all the same, as a tangent has to be. */
static void test_a_tangent_without_an_image(void **state) {
    static const float tangents[3][4] = {{1, 0, 0, 1}, {0, 1, 0, -1}, {0, 0, 1, 1}};
    gltf_asset a = {0};
    (void)state;
    asset_numbers(&a, TRIANGLE[0], 3, 3, FLOAT, 0);
    asset_floats(&a, tangents[0], 3, 4);
    gltf_output b = output_transformed(&a,
        SCENE "\"nodes\":[{\"mesh\":0,\"scale\":[0,0,3]}],\"meshes\":[{\"primitives\":[{"
              "\"attributes\":{\"POSITION\":0,\"TANGENT\":1}}]}]",
        1, NULL);
    norma_mesh_attributes attributes;
    assert_int_equal(
        norma_document_mesh_attributes(b.document, 0, &attributes, NULL), NORMA_DOCUMENT_OK);
    assert_int_equal(attributes.tangent_count, 3);
    for (size_t v = 0; v < 3; ++v) {
        const float *t = attributes.tangents + 4 * v;
        assert_true(fabsf(t[0] * t[0] + t[1] * t[1] + t[2] * t[2] - 1) < 1e-6f);
        assert_true(t[3] == tangents[v][3]);
    }
    assert_true(attributes.tangents[10] == 1); /* along z it has its image */
    output_finish(&b, &a);
}

/* Unsigned numbers that a whole step moves are what they were, exactly; min and max follow. */
static void test_whole_numbers_stay(void **state) {
    static const double points[3][3] = {{0, 0, 0}, {200, 0, 7}, {0, 100, 255}};
    (void)state;
    for (int type = UBYTE; type <= USHORT; type += USHORT - UBYTE) {
        gltf_asset a = {0};
        asset_numbers(&a, points[0], 3, 3, type, 0);
        gltf_output b = output_transformed(&a,
            SCENE QUANTIZED "\"nodes\":[{\"mesh\":0,\"translation\":[55,30,0]}],\"meshes\":[{"
                            "\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}]",
            1, NULL);
        assert_int_equal(output_number(&b, "accessors/%ld/componentType", 0), type);
        assert_string_equal(output_text(&b, "accessors/0/min"), "[55,30,0]");
        assert_string_equal(output_text(&b, "accessors/0/max"), "[255,130,255]");
        norma_mesh_data data = output_mesh(&b, 0);
        for (size_t v = 0; v < 3; ++v)
            assert_vector(&data.mesh.positions, v,
                (const double[]){points[v][0] + 55, points[v][1] + 30, points[v][2]}, 0);
        output_finish(&b, &a);
    }
}

/* Read leniently, a primitive may have fewer normals than vertices; tangents cannot be carried
 * beside them. */
static void test_fewer_normals_than_tangents(void **state) {
    static const float normals[2][3] = {{0, 0, 1}, {0, 0, 1}},
                       tangents[3][4] = {{1, 0, 0, 1}, {1, 0, 0, 1}, {1, 0, 0, 1}};
    const norma_transform_options options = {.struct_size = sizeof options, .bake = 1};
    norma_document_error error;
    gltf_asset a = {0};
    (void)state;
    asset_numbers(&a, TRIANGLE[0], 3, 3, FLOAT, 0);
    asset_floats(&a, normals[0], 2, 3);
    asset_floats(&a, tangents[0], 3, 4);
    norma_document *document = asset_open(&a,
        SCENE "\"nodes\":[{\"mesh\":0,\"scale\":[1,2,3]}],\"meshes\":[{\"primitives\":[{"
              "\"attributes\":{\"POSITION\":0,\"NORMAL\":1,\"TANGENT\":2}}]}]",
        1);
    assert_int_equal(
        norma_document_transform(document, &options, NULL, &error), NORMA_DOCUMENT_ERROR_MALFORMED);
    assert_message(error.message,
        "asset.glb:/accessors/1: expected as many vectors as the other attributes have; found ");
    norma_document_close(document);
    asset_free(&a);
}

/* ---- the scene's roots */

/* A scene may not list a root twice, and one that does is moved once: one new node above, with the
 * scene's other root. */
static void test_a_root_listed_twice(void **state) {
    const double up[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 5, 1};
    gltf_asset a = {0};
    norma_node_info info;
    (void)state;
    asset_numbers(&a, TRIANGLE[0], 3, 3, FLOAT, 0);
    gltf_output b = output_transformed(&a,
        "\"scene\":0,\"scenes\":[{\"nodes\":[0,2,1,0]}],\"nodes\":[{\"camera\":0},{\"camera\":0},{"
        "\"mesh\":0}],\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":1,\"znear\":"
        "1}}],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}]",
        1, up);
    assert_string_equal(output_text(&b, "nodes/3/children"), "[0,1]");
    assert_string_equal(output_text(&b, "nodes/4"), "");
    assert_int_equal(norma_document_node_info(b.document, 0, &info), NORMA_DOCUMENT_OK);
    assert_world_is_identity(&b, 0);
    norma_mesh_data data = output_mesh(&b, 0);
    assert_vector(&data.mesh.positions, 0, (const double[]){0, 0, 5}, 0);
    output_finish(&b, &a);
}

/* Nodes that draw a mesh and carry a camera, below one that flattens: each camera stays where it
 * is, and its mesh goes to a new node, which no inverse can bring to the identity there, so it
 * becomes a root. The scene's roots are then mostly nodes that the file did not have (found by
 * fuzzing: a heap overflow). */
static void test_new_nodes_among_the_roots(void **state) {
    enum { CAMERAS = 60 };
    const double up[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 5, 1};
    char rest[4000], roots[400] = "[121", *at = rest;
    gltf_asset a = {0};
    (void)state;
    asset_numbers(&a, TRIANGLE[0], 3, 3, FLOAT, 0);
    at += sprintf(at, SCENE "\"nodes\":[{\"scale\":[1,1,0],\"children\":[1");
    for (int i = 2; i <= CAMERAS; ++i) at += sprintf(at, ",%d", i);
    at += sprintf(at, "]}");
    for (int i = 1; i <= CAMERAS; ++i) at += sprintf(at, ",{\"mesh\":0,\"camera\":0}");
    sprintf(at,
        "],\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":1,\"znear\":1}}],"
        "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}]");
    for (int i = 0; i < CAMERAS; ++i)
        sprintf(roots + strlen(roots), ",%d%s", 1 + CAMERAS + i, i + 1 < CAMERAS ? "" : "]");
    gltf_output b = output_transformed(&a, rest, 1, up);
    assert_string_equal(output_text(&b, "scenes/0/nodes"), roots);
    assert_string_equal(output_text(&b, "nodes/121/children"), "[0]");
    assert_string_equal(output_text(&b, "nodes/121/translation"), "[0,0,5]");
    assert_string_equal(output_text(&b, "nodes/122"), "");
    assert_int_equal(norma_document_node_count(b.document), CAMERAS);
    for (size_t i = 0; i < CAMERAS; ++i) {
        assert_world_is_identity(&b, i);
        norma_mesh_data data = output_mesh(&b, i);
        for (size_t v = 0; v < 3; ++v)
            assert_vector(
                &data.mesh.positions, v, (const double[]){TRIANGLE[v][0], TRIANGLE[v][1], 5}, 0);
    }
    output_finish(&b, &a);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_instances_beside_other_extensions),
        cmocka_unit_test(test_weights_of_several_meshes),
        cmocka_unit_test(test_a_strip_with_stitches),
        cmocka_unit_test(test_what_has_no_winding),
        cmocka_unit_test(test_a_tangent_without_an_image),
        cmocka_unit_test(test_whole_numbers_stay),
        cmocka_unit_test(test_fewer_normals_than_tangents),
        cmocka_unit_test(test_a_root_listed_twice),
        cmocka_unit_test(test_new_nodes_among_the_roots),
    };
    return cmocka_run_group_tests_name("glTF baked", tests, NULL, NULL);
}
