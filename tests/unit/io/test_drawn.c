/* Meshes as viewers draw them at rest: morph targets by the weights of node or mesh, skins, the
 * scene that is shown, normalised positions, images of materials. Assets are written here, each
 * expected number by hand.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>
#include "gltf_asset.h"

static const float points[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
static const float normals[3][3] = {{0.6F, 0.8F, 0}, {0, 0, 1}, {0, 1, 0}};
static const float tangents[3][4] = {{0.8F, -0.6F, 0, 1}, {1, 0, 0, 1}, {1, 0, 0, -1}};

#define PRIMITIVE(more)                                                                            \
    "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"NORMAL\":1,\"TANGENT\":2" more

static void add_triangle(gltf_asset *a) {
    asset_floats(a, &points[0][0], 3, 3);
    asset_floats(a, &normals[0][0], 3, 3);
    asset_floats(a, &tangents[0][0], 3, 4);
}

static norma_drawn_mesh drawn_at(norma_document *document, size_t node) {
    norma_drawn_mesh drawn;
    norma_document_error error;
    if (norma_document_drawn_mesh(document, node, 0, 0, &drawn, &error))
        fail_msg("%s", error.message);
    return drawn;
}

/* Where a vertex stands in the scene. */
static void assert_at(const norma_drawn_mesh *drawn, size_t vertex, double x, double y, double z) {
    double p[3], expected[3] = {x, y, z};
    norma_view_vector(&drawn->positions, vertex, p);
    for (int r = 0; r < 3; ++r) {
        const double *m = drawn->world,
                     got = m[r] * p[0] + m[4 + r] * p[1] + m[8 + r] * p[2] + m[12 + r];
        if (fabs(got - expected[r]) > 1e-6)
            fail_msg("vertex %zu, axis %d: %g, expected %g", vertex, r, got, expected[r]);
    }
}

static void assert_points_to(const float *vector, double x, double y, double z) {
    const double length = sqrt(x * x + y * y + z * z),
                 own = sqrt((double)(vector[0] * vector[0] + vector[1] * vector[1] +
                                     vector[2] * vector[2]));
    const double expected[3] = {x / length, y / length, z / length};
    for (int k = 0; k < 3; ++k)
        if (fabs((double)vector[k] / own - expected[k]) > 1e-6)
            fail_msg("(%g, %g, %g), expected the direction (%g, %g, %g)", (double)vector[0],
                (double)vector[1], (double)vector[2], x, y, z);
}

/* ---- morph targets */

#define TARGETS                                                                                    \
    "},\"targets\":[{\"POSITION\":3,\"NORMAL\":4},{\"POSITION\":4}]}],\"weights\":[0.5,0]}]"

static void test_weights(void **state) {
    (void)state;
    static const float up[3][3] = {{0, 0, 2}, {0, 0, 4}, {0, 0, 0}},
                       along[3][3] = {{1, 0, 0}, {1, 0, 0}, {1, 0, 0}};
    gltf_asset a = {0};
    add_triangle(&a);
    asset_floats(&a, &up[0][0], 3, 3);
    asset_floats(&a, &along[0][0], 3, 3);
    norma_document *document = asset_open(&a,
        PRIMITIVE("") TARGETS ",\"nodes\":[{\"mesh\":0,\"translation\":[0,10,0]},{\"mesh\":0,"
                              "\"weights\":[0,2]},{\"mesh\":0,\"weights\":[0,0]}]",
        0);
    const norma_drawn_mesh usual = drawn_at(document, 0), own = drawn_at(document, 1),
                           none = drawn_at(document, 2);
    assert_true(usual.moved && !usual.skinned && usual.shown && own.moved && !none.moved);
    assert_at(&usual, 0, 1, 10, 1);
    assert_at(&usual, 1, 0, 11, 2);
    assert_at(&usual, 2, 0, 10, 1);
    assert_points_to((const float *)usual.normals.data, 1.1, 0.8, 0);
    assert_at(&own, 0, 3, 0, 0);
    assert_at(&none, 0, 1, 0, 0);
    assert_points_to((const float *)own.normals.data, 0.6, 0.8, 0);
    norma_document_close(document);
    asset_free(&a);
}

/* ---- skins: joint 1 lies at (10, 0, 0), joint 2 below it triples y, and both were bound at (0, 2,
 * 0) */

#define SKIN                                                                                       \
    ",\"JOINTS_0\":3,\"WEIGHTS_0\":4}}]}],\"skins\":[{\"joints\":[1,2],"                           \
    "\"inverseBindMatrices\":5}],\"nodes\":[{\"mesh\":0,\"skin\":0,\"translation\":[0,0,99]},"     \
    "{\"translation\":[10,0,0],\"children\":[2]},{\"scale\":[1,"
static const float bound[2][16] = {{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -2, 0, 1},
    {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -2, 0, 1}};
/* The second vertex's weights add up to 2; the third has none, and follows its first joint. */
static const float weights[3][4] = {{0, 1, 0, 0}, {1, 1, 0, 0}, {0, 0, 0, 0}};

static void add_skin(gltf_asset *a, double joint) {
    const double joints[3][4] = {{0, joint, 0, 0}, {0, 1, 0, 0}, {0, 1, 0, 0}};
    add_triangle(a);
    asset_numbers(a, &joints[0][0], 3, 4, 5121, 0);
    asset_floats(a, &weights[0][0], 3, 4);
    asset_floats(a, &bound[0][0], 2, 16);
}

static void test_skin(void **state) {
    (void)state;
    gltf_asset a = {0};
    add_skin(&a, 1);
    norma_document *document = asset_open(&a, PRIMITIVE("") SKIN "3,1]}]", 0);
    const norma_drawn_mesh drawn = drawn_at(document, 0);
    assert_true(drawn.moved && drawn.skinned);
    assert_at(&drawn, 0, 11, -6, 0);              /* 3 (0 - 2) */
    assert_at(&drawn, 1, 10, 0.5 * (-1 + -3), 0); /* the mean of 1 - 2 and 3 (1 - 2) */
    assert_at(&drawn, 2, 10, -2, 1);
    assert_points_to(drawn.normals.data, 0.6, 0.8 / 3, 0);
    assert_points_to(drawn.tangents, 0.8, -1.8, 0);
    assert_true(drawn.tangents[3] == 1);
    norma_document_close(document);
    asset_free(&a);
}

/* Both joints mirror: so does world, and the tangents' signs are those of the mirrored mesh. */
static void test_mirrored_skin(void **state) {
    (void)state;
    gltf_asset a = {0};
    add_skin(&a, 1);
    norma_document *document = asset_open(&a,
        PRIMITIVE("") ",\"JOINTS_0\":3,\"WEIGHTS_0\":4}}]}],\"skins\":[{\"joints\":[1,1]}],"
                      "\"nodes\":[{\"mesh\":0,\"skin\":0},{\"scale\":[1,1,-1]}]",
        0);
    const norma_drawn_mesh drawn = drawn_at(document, 0);
    double normal_matrix[9];
    norma_matrix_info info;
    norma_normal_matrix_double(drawn.world, NORMA_WINDING_REVERSED, normal_matrix, &info);
    assert_true(info.mirrored);
    assert_at(&drawn, 0, 1, 0, 0);
    assert_at(&drawn, 2, 0, 0, -1);
    const float *n = drawn.normals.data;
    const float there[3] = {(float)normal_matrix[0] * n[3], n[4], n[5]};
    assert_points_to(there, 0, 0, -1); /* of the second vertex, 0 0 1 in the file */
    assert_true(drawn.tangents[3] == 1 && drawn.tangents[11] == -1);
    norma_document_close(document);
    asset_free(&a);
}

/* The skin of test_skin, on a globe: floats there are half a metre apart, but the mesh keeps its
 * shape. The tangents become perpendicular to the normals. */
static void test_far_skin(void **state) {
    (void)state;
    const double far = 6378137.3;
    gltf_asset a = {0};
    add_skin(&a, 1);
    norma_document *document = asset_open(
        &a, PRIMITIVE("") SKIN "3,1]},{\"children\":[1],\"translation\":[0,0,6378137.3]}]", 0);
    const norma_drawn_mesh drawn = drawn_at(document, 0);
    assert_at(&drawn, 0, 11, -6, far);
    assert_at(&drawn, 1, 10, 0.5 * (-1 + -3), far);
    assert_at(&drawn, 2, 10, -2, far + 1);
    assert_points_to(drawn.tangents + 8, 1, 0, 0);
    norma_document_close(document);
    asset_free(&a);
}

/* A joint number of a weight that is 0 is not looked at; a matrix that is not finite is named. */
static void test_unusable_joints(void **state) {
    (void)state;
    norma_drawn_mesh drawn;
    norma_document_error error;
    for (int broken = 0; broken < 2; ++broken) {
        const double joints[3][4] = {{7, 1, 0, 9}, {0, 1, 8, 0}, {0, 200, 0, 0}};
        gltf_asset a = {0};
        add_triangle(&a);
        asset_numbers(&a, &joints[0][0], 3, 4, 5121, 0);
        asset_floats(&a, &weights[0][0], 3, 4);
        asset_floats(&a, &bound[0][0], 2, 16);
        norma_document *document = asset_open(
            &a, broken ? PRIMITIVE("") SKIN "1e39,1]}]" : PRIMITIVE("") SKIN "3,1]}]", 0);
        if (!broken) {
            drawn = drawn_at(document, 0);
            assert_at(&drawn, 0, 11, -6, 0);
        } else {
            assert_int_equal(norma_document_drawn_mesh(document, 0, 0, 0, &drawn, &error),
                NORMA_DOCUMENT_ERROR_MALFORMED);
            assert_non_null(strstr(error.message, "joint 1 of its skin has a matrix that is not"));
        }
        norma_document_close(document);
        asset_free(&a);
    }
}

static void test_joint_out_of_range(void **state) {
    (void)state;
    gltf_asset a = {0};
    norma_drawn_mesh drawn;
    norma_document_error error;
    add_skin(&a, 2);
    norma_document *document = asset_open(&a, PRIMITIVE("") SKIN "3,1]}]", 0);
    assert_int_equal(norma_document_drawn_mesh(document, 0, 0, 0, &drawn, &error),
        NORMA_DOCUMENT_ERROR_MALFORMED);
    assert_non_null(strstr(error.message, "vertex 0 names joint 2"));
    norma_document_close(document);
    asset_free(&a);
}

/* Its values are as many as it likes, but no joints. */
static void test_joints_no_list(void **state) {
    (void)state;
    gltf_asset a = {0};
    norma_drawn_mesh drawn;
    norma_document_error error;
    add_skin(&a, 1);
    norma_document *document = asset_open(&a,
        PRIMITIVE("") ",\"JOINTS_0\":3,\"WEIGHTS_0\":4}}]}],"
                      "\"skins\":[{\"joints\":{\"a\":1,\"b\":1,\"c\":1}}],"
                      "\"nodes\":[{\"mesh\":0,\"skin\":0},{}]",
        0);
    assert_int_equal(norma_document_drawn_mesh(document, 0, 0, 0, &drawn, &error),
        NORMA_DOCUMENT_ERROR_MALFORMED);
    assert_non_null(strstr(error.message, "/skins/0/joints: expected an array"));
    norma_document_close(document);
    asset_free(&a);
}

/* ---- images of materials */

static const char materials[] =
    "\"images\":[{\"uri\":\"data:image/png;base64,AQID\"},{\"bufferView\":0,\"mimeType\":\"image/"
    "png\"},{\"uri\":\"../outside.png\"},{\"uri\":\"missing.png\"}],"
    "\"samplers\":[{\"wrapS\":33071,\"wrapT\":33648,\"magFilter\":9728,\"minFilter\":9987}],"
    "\"textures\":[{\"source\":0,\"sampler\":0},{\"source\":1},{\"source\":2},{\"source\":3},{}],"
    "\"materials\":[{\"alphaMode\":\"MASK\",\"alphaCutoff\":0.25,\"pbrMetallicRoughness\":{"
    "\"baseColorTexture\":{\"index\":0,\"texCoord\":3,\"extensions\":{\"KHR_texture_transform\":{"
    "\"offset\":[0.5,0.25],\"scale\":[2,4],\"rotation\":1,\"texCoord\":1}}}},"
    "\"normalTexture\":{\"index\":1,\"scale\":0.5}},"
    "{\"alphaMode\":\"BLEND\",\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":2}},"
    "\"normalTexture\":{\"index\":3}},"
    "{\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":4}},\"normalTexture\":{\"index\":9}"
    "},"
    "{}]";

static norma_material_maps maps_of(norma_document *document, size_t index) {
    norma_material_maps maps;
    norma_document_error error;
    if (norma_document_material_maps(document, index, &maps, &error)) fail_msg("%s", error.message);
    return maps;
}

static void test_maps(void **state) {
    (void)state;
    gltf_asset a = {0};
    asset_view(&a, "an image", 8, "");
    add_triangle(&a);
    norma_document *document = asset_open(&a, materials, 0);
    const norma_material_maps first = maps_of(document, 0), second = maps_of(document, 1),
                              third = maps_of(document, 2), plain = maps_of(document, 3);
    const norma_texture_info *base = &first.base_color, *normal = &first.normal;
    assert_true(first.alpha_mode == NORMA_ALPHA_MASK && first.alpha_cutoff == 0.25F);
    assert_true(base->there && base->size == 3 && memcmp(base->bytes, "\1\2\3", 3) == 0);
    assert_true(base->texcoord == 1 && base->offset[0] == 0.5F && base->offset[1] == 0.25F &&
                base->scale[0] == 2 && base->scale[1] == 4 && base->rotation == 1);
    assert_true(base->wrap_s == 33071 && base->wrap_t == 33648 && base->mag_filter == 9728 &&
                base->min_filter == 9987);
    assert_true(normal->size == 8 && memcmp(normal->bytes, "an image", 8) == 0);
    assert_true(normal->strength == 0.5F && normal->wrap_s == 10497 && normal->min_filter == 0 &&
                normal->image == 1 && normal->scale[1] == 1);
    assert_true(second.alpha_mode == NORMA_ALPHA_BLEND && second.alpha_cutoff == 0.5F);
    assert_true(second.base_color.there && !second.base_color.bytes && second.normal.there);
    assert_non_null(strstr(second.base_color.not_read, "not a file in the asset's folder"));
    assert_true(!second.normal.bytes && second.normal.not_read);
    assert_true(third.base_color.not_read && third.normal.not_read && !third.normal.bytes);
    assert_non_null(strstr(third.base_color.not_read, "format")); /* a texture without a source */
    assert_true(plain.alpha_mode == NORMA_ALPHA_OPAQUE && !plain.base_color.there &&
                !plain.normal.there && plain.base_color.image == SIZE_MAX);
    norma_material_maps maps;
    assert_int_equal(
        norma_document_material_maps(document, 4, &maps, NULL), NORMA_DOCUMENT_ERROR_ARGUMENT);
    assert_int_equal(
        norma_document_material_maps(document, 0, NULL, NULL), NORMA_DOCUMENT_ERROR_ARGUMENT);
    norma_document_close(document);
    asset_free(&a);
}

static void test_texcoords(void **state) {
    (void)state;
    static const float coordinates[3][2] = {{0, 1}, {0.5F, 0.25F}, {2, -3}};
    gltf_asset a = {0};
    const float *found;
    size_t count;
    add_triangle(&a);
    asset_floats(&a, &coordinates[0][0], 3, 2);
    norma_document *document = asset_open(&a, PRIMITIVE("") ",\"TEXCOORD_1\":3}}]}]", 0);
    assert_int_equal(
        norma_document_texcoords(document, 0, 1, &found, &count, NULL), NORMA_DOCUMENT_OK);
    assert_true(count == 3 && memcmp(found, coordinates, sizeof coordinates) == 0);
    assert_int_equal(
        norma_document_texcoords(document, 0, 0, &found, &count, NULL), NORMA_DOCUMENT_OK);
    assert_true(count == 0 && !found);
    assert_int_equal(norma_document_texcoords(document, 1, 0, &found, &count, NULL),
        NORMA_DOCUMENT_ERROR_ARGUMENT);
    norma_document_close(document);
    asset_free(&a);
}

/* Scaled, then turned anticlockwise as seen in the image, whose v points down; then moved. */
static void test_texture_place(void **state) {
    (void)state;
    static const float coordinates[2][2] = {{0.25F, 0.5F}, {-1, 3}},
                       quarter_turn[2][2] = {{2.5F, -0.25F}, {12.5F, 2.25F}};
    norma_texture_info info = {.offset = {0.5F, 0.25F}, .scale = {2, 4}};
    float placed[8] = {0, 0, 7, 7, 0, 0, 7, 7};
    norma_texture_place(&info, &coordinates[0][0], 2, 4, placed);
    assert_true(placed[0] == 1 && placed[1] == 2.25F && placed[4] == -1.5F && placed[5] == 12.25F);
    assert_true(placed[2] == 7 && placed[3] == 7 && placed[6] == 7 && placed[7] == 7);
    info.rotation = 1.57079633F;
    norma_texture_place(&info, &coordinates[0][0], 2, 2, placed);
    for (size_t i = 0; i < 4; ++i)
        assert_true(fabsf(placed[i] - quarter_turn[i / 2][i % 2]) < 1e-5F);
}

/* ---- places */

static void test_scene(void **state) {
    (void)state;
    gltf_asset a = {0};
    add_triangle(&a);
    norma_document *document = asset_open(&a,
        PRIMITIVE("") "}}]}],\"scene\":1,\"scenes\":[{\"nodes\":[0]},{\"nodes\":[1]}],"
                      "\"nodes\":[{\"mesh\":0},{\"children\":[2]},{\"mesh\":0}]",
        0);
    assert_true(!drawn_at(document, 0).shown && drawn_at(document, 1).shown);
    norma_document_close(document);
    asset_free(&a);
}

static void test_normalised(void **state) {
    (void)state;
    static const double stored[3][3] = {{1, 0, 0}, {0, -1, 0}, {0, 0, 1}};
    gltf_asset a = {0};
    asset_numbers(&a, &stored[0][0], 3, 3, 5122, 1);
    norma_document *document = asset_open(&a,
        "\"extensionsUsed\":[\"KHR_mesh_quantization\"],\"extensionsRequired\":[\"KHR_mesh_"
        "quantization\"],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],"
        "\"nodes\":[{\"mesh\":0,\"scale\":[3,3,3],\"translation\":[1,1,1]}]",
        0);
    const norma_drawn_mesh drawn = drawn_at(document, 0);
    assert_at(&drawn, 0, 4, 1, 1);
    assert_at(&drawn, 1, 1, -2, 1);
    assert_true(!drawn.moved && drawn.normals.count == 0 && !drawn.tangents);
    norma_document_close(document);
    asset_free(&a);
}

static void test_arguments(void **state) {
    (void)state;
    gltf_asset a = {0};
    norma_drawn_mesh drawn;
    add_triangle(&a);
    norma_document *document = asset_open(&a,
        PRIMITIVE("") "}}]},{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],"
                      "\"nodes\":[{\"mesh\":0}]",
        0);
    const struct {
        size_t node, instance, mesh;
    } wrong[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 2}};
    for (size_t i = 0; i < 4; ++i)
        assert_int_equal(norma_document_drawn_mesh(document, wrong[i].node, wrong[i].instance,
                             wrong[i].mesh, &drawn, NULL),
            NORMA_DOCUMENT_ERROR_ARGUMENT);
    assert_int_equal(
        norma_document_drawn_mesh(document, 0, 0, 0, NULL, NULL), NORMA_DOCUMENT_ERROR_ARGUMENT);
    norma_document_close(document);
    asset_free(&a);
}

/* Elements without bytes, as many as the file has: four influences of each fit in 256 bytes for
 * each byte, 32 do not, and once they are gone they no longer count. */
static void test_memory_of_influences(void **state) {
    (void)state;
    enum { COUNT = 20000 };
    static unsigned char bytes[COUNT];
    static const char *const accessors[] = {"5126,\"type\":\"VEC3\"", "5121,\"type\":\"VEC4\"",
        "5121,\"normalized\":true,\"type\":\"VEC4\""};
    for (int sets = 1; sets <= 8; sets += 7) {
        gltf_asset a = {0};
        norma_drawn_mesh drawn;
        norma_document_error error;
        char json[1000] = "\"meshes\":[{\"primitives\":[{\"mode\":4,\"attributes\":{\"POSITION\":0";
        asset_view(&a, bytes, sizeof bytes, "");
        for (int i = 0; i < 3; ++i) {
            char accessor[200];
            snprintf(accessor, sizeof accessor, "{\"count\":%d,\"componentType\":%s}",
                COUNT / 3 * 3, accessors[i]);
            asset_accessor(&a, accessor);
        }
        for (int i = 0; i < sets; ++i)
            sprintf(json + strlen(json), ",\"JOINTS_%d\":1,\"WEIGHTS_%d\":2", i, i);
        strcat(json, "}}]}],\"skins\":[{\"joints\":[1]}],\"nodes\":[{\"mesh\":0,\"skin\":0},{},"
                     "{\"mesh\":0,\"skin\":0},{\"mesh\":0,\"skin\":0}]");
        norma_document *document = asset_open(&a, json, 0);
        const int result = norma_document_drawn_mesh(document, 0, 0, 0, &drawn, &error);
        if (sets == 1) {
            if (result) fail_msg("%s", error.message);
            drawn_at(document, 1);
            drawn_at(document, 2);
        } else {
            assert_int_equal(result, NORMA_DOCUMENT_ERROR_UNSUPPORTED);
            assert_non_null(strstr(error.message,
                "/meshes/0/primitives/0: 19998 elements from here, with all before them, would "
                "take far more memory than the file"));
        }
        norma_document_close(document);
        asset_free(&a);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_weights),
        cmocka_unit_test(test_skin),
        cmocka_unit_test(test_mirrored_skin),
        cmocka_unit_test(test_far_skin),
        cmocka_unit_test(test_unusable_joints),
        cmocka_unit_test(test_joint_out_of_range),
        cmocka_unit_test(test_joints_no_list),
        cmocka_unit_test(test_memory_of_influences),
        cmocka_unit_test(test_maps),
        cmocka_unit_test(test_texcoords),
        cmocka_unit_test(test_texture_place),
        cmocka_unit_test(test_scene),
        cmocka_unit_test(test_normalised),
        cmocka_unit_test(test_arguments),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
