/* What a document tells beside meshes and normals: materials, UVs, colours, tangents, morph
 * targets, nodes, instances, skins, rules that extras silence, what was not read; and what lenient
 * reading lets through. Assets are written here, each expected number by hand. */
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

static const float square[4][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
static const float up[5][3] = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}, {0, 0, 1}, {0, 0, 1}};
static const uint16_t corners[6] = {0, 1, 2, 0, 2, 3};

/* Accessors 0 POSITION, 1 NORMAL, 2 indices. */
static void add_square(gltf_asset *a) {
    asset_floats(a, &square[0][0], 4, 3);
    asset_floats(a, &up[0][0], 4, 3);
    asset_uint16(a, corners, 6);
}

#define PRIMITIVE "\"attributes\":{\"POSITION\":0,\"NORMAL\":1},\"indices\":2"
#define MESH      "\"meshes\":[{\"primitives\":[{" PRIMITIVE "}]}]"

static norma_node_info node_info(norma_document *document, size_t index) {
    norma_node_info info;
    assert_int_equal(norma_document_node_info(document, index, &info), NORMA_DOCUMENT_OK);
    return info;
}

static norma_mesh_attributes attributes_of(norma_document *document, size_t index) {
    norma_mesh_attributes attributes;
    norma_document_error error;
    if (norma_document_mesh_attributes(document, index, &attributes, &error))
        fail_msg("%s", error.message);
    return attributes;
}

static norma_material_info material_of(norma_document *document, size_t index) {
    norma_material_info info;
    assert_int_equal(norma_document_material_info(document, index, &info), NORMA_DOCUMENT_OK);
    return info;
}

/* ---- materials */

static void test_materials(void **state) {
    (void)state;
    gltf_asset a = {0};
    norma_document *document = asset_open(&a,
        "\"materials\":[{},"
        "{\"name\":\"two "
        "\\u0041\",\"doubleSided\":true,\"alphaMode\":\"MASK\",\"extensions\":{\"KHR_materials_"
        "unlit\":{}}},"
        "{\"alphaMode\":\"OPAQUE\",\"normalTexture\":{\"index\":0,\"texCoord\":2},"
        "\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.5,0.25,0,1],"
        "\"metallicFactor\":0.125,\"roughnessFactor\":0.75}},"
        "{\"extensions\":{\"KHR_materials_transmission\":{\"transmissionFactor\":0.5}}},"
        "{\"extensions\":{\"KHR_materials_transmission\":{\"transmissionFactor\":0}}},"
        "{\"extensions\":{\"KHR_materials_clearcoat\":{\"clearcoatNormalTexture\":{\"index\":0,"
        "\"texCoord\":1,"
        "\"extensions\":{\"KHR_texture_transform\":{\"texCoord\":3}}}}},"
        "\"extras\":{\"norma\":{\"ignore\":[\"N201\",7,\"N3\",\"placeholder-normals\"]}}},"
        "{\"doubleSided\":\"yes\",\"alphaMode\":4,\"normalTexture\":5,\"pbrMetallicRoughness\":[]}"
        "]",
        0);
    assert_int_equal(norma_document_material_count(document), 7);
    const norma_material_info plain = material_of(document, 0), two = material_of(document, 1),
                              mapped = material_of(document, 2), odd = material_of(document, 6);
    assert_string_equal(plain.name, "");
    assert_string_equal(plain.where, "/materials/0");
    assert_string_equal(plain.ignore, "");
    assert_true(!plain.double_sided && !plain.unlit && !plain.not_opaque && !plain.normal_map);
    assert_true(plain.base_color[0] == 1 && plain.base_color[3] == 1);
    assert_string_equal(two.name, "two A");
    assert_true(two.double_sided && two.unlit && two.not_opaque);
    assert_true(mapped.normal_map && mapped.normal_texcoord == 2 && !mapped.not_opaque);
    assert_true(
        mapped.base_color[0] == 0.5F && mapped.base_color[1] == 0.25F && mapped.base_color[2] == 0);
    assert_true(material_of(document, 3).not_opaque && !material_of(document, 4).not_opaque);
    assert_true(
        material_of(document, 5).normal_map && material_of(document, 5).normal_texcoord == 3);
    assert_string_equal(material_of(document, 5).ignore, "N201,N3,placeholder-normals");
    assert_true(!odd.double_sided && !odd.not_opaque && !odd.normal_map);
    norma_material_info none;
    assert_int_equal(
        norma_document_material_info(document, 7, &none), NORMA_DOCUMENT_ERROR_ARGUMENT);
    assert_int_equal(
        norma_document_material_info(document, 0, NULL), NORMA_DOCUMENT_ERROR_ARGUMENT);
    norma_document_close(document);
    asset_free(&a);
}

/* ---- attributes */

static void test_attributes(void **state) {
    (void)state;
    static const float uvs[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}},
                       other_uvs[4][2] = {{5, 5}, {6, 5}, {6, 6}, {5, 6}};
    static const float colors[4][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.5F, 0.5F, 0.5F}};
    static const float tangents[4][4] = {{1, 0, 0, 1}, {1, 0, 0, -1}, {0, 1, 0, 1}, {-1, 0, 0, 1}};
    gltf_asset a = {0};
    add_square(&a);
    asset_floats(&a, &uvs[0][0], 4, 2);
    asset_floats(&a, &other_uvs[0][0], 4, 2);
    asset_floats(&a, &colors[0][0], 4, 3);
    asset_snorm8(&a, &tangents[0][0], 4, 4);
    norma_document *document = asset_open(&a,
        "\"extras\":{\"norma\":{\"ignore\":[\"N702\"]}},\"materials\":[{},{\"normalTexture\":{"
        "\"index\":0,\"texCoord\":1}}],"
        "\"meshes\":[{\"extras\":{\"norma\":{\"ignore\":\"N4\"}},\"primitives\":[{\"attributes\":{"
        "\"POSITION\":0,\"NORMAL\":1,\"TEXCOORD_0\":3,"
        "\"TEXCOORD_1\":4,\"COLOR_0\":5,\"TANGENT\":6},\"indices\":2,\"material\":1,\"extras\":{"
        "\"norma\":{\"ignore\":[\"N201\"]}}},{" PRIMITIVE "}]}]",
        0);
    const norma_mesh_attributes full = attributes_of(document, 0),
                                bare = attributes_of(document, 1);
    assert_int_equal(full.material, 1);
    assert_int_equal(full.texcoord_count, 4);
    assert_memory_equal(
        full.texcoords, other_uvs, sizeof other_uvs); /* the set of the normal map */
    assert_null(full.corner_texcoords);
    for (size_t i = 0; i < 4; ++i)
        assert_true(memcmp(full.colors + 4 * i, colors[i], sizeof colors[i]) == 0 &&
                    full.colors[4 * i + 3] == 1);
    assert_int_equal(full.tangent_count, 4);
    assert_string_equal(full.tangent_encoding, "snorm8");
    assert_memory_equal(full.tangents, tangents, sizeof tangents);
    assert_string_equal(full.ignore, "N702,N4,N201");
    assert_true(
        full.normals_missing == 0 && full.normals_surplus == 0 && full.normals_out_of_range == 0);
    assert_true(bare.material == SIZE_MAX && !bare.texcoords && !bare.colors && !bare.tangents);
    assert_string_equal(bare.tangent_encoding, "");
    assert_string_equal(bare.ignore, "N702,N4");
    norma_mesh_attributes none;
    norma_document_error error;
    assert_int_equal(
        norma_document_mesh_attributes(document, 2, &none, &error), NORMA_DOCUMENT_ERROR_ARGUMENT);
    norma_document_close(document);
    asset_free(&a);
}

static void test_morphs(void **state) {
    (void)state;
    static const float moves[4][3] = {{0, 0, 1}, {0, 0, 2}, {0, 0, 3}, {0, 0, 4}},
                       turns[4][3] = {{-1, 0.5F, 0}, {0, 0, 0}, {1, 0, 0}, {0, -1, 0}};
    gltf_asset a = {0};
    add_square(&a);
    asset_floats(&a, &moves[0][0], 4, 3);
    asset_snorm8(&a, &turns[0][0], 4, 3);
    norma_document *document = asset_open(&a,
        "\"meshes\":[{\"primitives\":[{" PRIMITIVE
        ",\"targets\":[{\"POSITION\":3},{\"NORMAL\":4},{}]}]}]",
        0);
    norma_morph_data data;
    assert_int_equal(norma_document_morph_data(document, 0, 0, &data, NULL), NORMA_DOCUMENT_OK);
    assert_true(data.positions.count == 4 && data.normals.count == 0 && data.tangents.count == 0);
    assert_memory_equal(data.positions.data, moves, sizeof moves);
    assert_int_equal(norma_document_morph_data(document, 0, 1, &data, NULL), NORMA_DOCUMENT_OK);
    assert_true(data.positions.count == 0 && data.normals.count == 4 &&
                data.normals.format == NORMA_FORMAT_FLOAT);
    const float *first = data.normals.data;
    assert_true(first[0] == -1 && fabsf(first[1] - 64 / 127.0F) < 1e-6F && first[2] == 0);
    assert_int_equal(norma_document_morph_data(document, 0, 2, &data, NULL), NORMA_DOCUMENT_OK);
    assert_true(data.positions.count == 0 && data.normals.count == 0);
    assert_int_equal(
        norma_document_morph_data(document, 0, 3, &data, NULL), NORMA_DOCUMENT_ERROR_ARGUMENT);
    norma_document_close(document);
    asset_free(&a);
}

/* ---- nodes */

static void test_nodes(void **state) {
    (void)state;
    gltf_asset a = {0};
    add_square(&a);
    norma_document *document = asset_open(&a,
        "\"nodes\":[{\"name\":\"a\",\"children\":[1],\"scale\":[-1,1,1],\"extras\":{\"norma\":{"
        "\"ignore\":[\"N601\"]}}},"
        "{\"children\":[2]},{\"name\":\"leg\",\"mesh\":0,\"skin\":0,\"extras\":{\"norma\":{"
        "\"ignore\":[\"N602\"]}}},{\"name\":\"alone\",\"mesh\":0}],"
        "\"skins\":[{\"joints\":[0]}]," MESH,
        0);
    assert_int_equal(norma_document_node_count(document), 2);
    const norma_node_info leg = node_info(document, 0), alone = node_info(document, 1);
    assert_true(leg.node == 2 && leg.parent == 1 && leg.skin == 0 && leg.instances == 1 &&
                leg.mirrored_instances == 1);
    assert_string_equal(leg.where, "/nodes/2");
    assert_string_equal(leg.path, "a/1/leg");
    assert_string_equal(leg.ignore, "N601,N602");
    assert_true(alone.node == 3 && alone.parent == SIZE_MAX && alone.skin == SIZE_MAX &&
                alone.mirrored_instances == 0);
    assert_string_equal(alone.path, "alone");
    assert_string_equal(alone.ignore, "");
    norma_document_close(document);
    asset_free(&a);
}

/* Primitives of a mesh follow each other; meshes without any, and without a node, lie between. */
static void test_what_a_node_draws(void **state) {
    (void)state;
    gltf_asset a = {0};
    add_square(&a);
    norma_document *document = asset_open(&a,
        "\"nodes\":[{\"mesh\":3},{\"mesh\":0},{\"mesh\":1},{\"mesh\":4},{\"mesh\":3}],\"meshes\":["
        "{\"primitives\":[{" PRIMITIVE "}]},{\"primitives\":[]},{\"primitives\":[{" PRIMITIVE
        "},{" PRIMITIVE "}]},{\"primitives\":[{" PRIMITIVE "},{" PRIMITIVE "},{" PRIMITIVE
        "}]},{\"primitives\":[{" PRIMITIVE "}]}]",
        0);
    static const size_t drawn[5][2] = {{3, 3}, {0, 1}, {1, 0}, {6, 1}, {3, 3}};
    assert_int_equal(norma_document_mesh_count(document), 7);
    for (size_t i = 0; i < 5; ++i) {
        const norma_node_info node = node_info(document, i);
        assert_int_equal(node.first_mesh, drawn[i][0]);
        assert_int_equal(node.mesh_count, drawn[i][1]);
    }
    norma_document_close(document);
    asset_free(&a);
}

static void test_deep_path(void **state) {
    (void)state;
    enum { DEPTH = 3000 };
    gltf_asset a = {0};
    char *rest = malloc(DEPTH * 64), *at = rest;
    assert_non_null(rest);
    add_square(&a);
    at += sprintf(at, "%s,\"nodes\":[", MESH);
    for (int i = 0; i < DEPTH - 1; ++i)
        at += sprintf(at, "{\"name\":\"node\",\"children\":[%d]},", i + 1);
    sprintf(at, "{\"name\":\"leaf\",\"mesh\":0}]");
    norma_document *document = asset_open(&a, rest, 0);
    const norma_node_info leaf = node_info(document, 0);
    size_t length = strlen(leaf.path);
    assert_true(length <= 400 && length > 390);
    assert_memory_equal(leaf.path, ".../node/node", 13);
    assert_string_equal(leaf.path + length - 9, "node/leaf");
    norma_document_close(document);
    memset(rest, 'x', 1000); /* a name that is longer by itself is kept whole */
    sprintf(rest + 1000, "\"}]," MESH);
    memcpy(rest, "\"nodes\":[{\"mesh\":0,\"name\":\"", 27);
    document = asset_open(&a, rest, 0);
    assert_int_equal(strlen(node_info(document, 0).path), 1000 - 27);
    norma_document_close(document);
    free(rest);
    asset_free(&a);
}

static void test_instances(void **state) {
    (void)state;
    static const float places[3][3] = {{1, 0, 0}, {2, 0, 0}, {3, 0, 0}},
                       scales[3][3] = {{1, 1, 1}, {-1, 1, 1}, {2, -2, -2}};
    gltf_asset a = {0};
    add_square(&a);
    asset_floats(&a, &places[0][0], 3, 3);
    asset_floats(&a, &scales[0][0], 3, 3);
    static const char rest[] = "\"extensionsUsed\":[\"EXT_mesh_gpu_instancing\"],\"nodes\":[{"
                               "\"mesh\":0,\"translation\":[0,5,0],\"scale\":[10,10,10],"
                               "\"extensions\":{\"EXT_mesh_gpu_instancing\":{\"attributes\":{"
                               "\"TRANSLATION\":3,\"SCALE\":4}}}}]," MESH;
    norma_document *document = asset_open(&a, rest, 0);
    const norma_node_info info = node_info(document, 0);
    assert_true(info.instances == 3 && info.mirrored_instances == 1);
    double world[16];
    assert_int_equal(norma_document_instance_world(document, 0, 2, world, NULL), NORMA_DOCUMENT_OK);
    assert_true(world[0] == 20 && world[5] == -20 && world[10] == -20 && world[12] == 30 &&
                world[13] == 5 && world[15] == 1);
    assert_int_equal(
        norma_document_instance_world(document, 0, 3, world, NULL), NORMA_DOCUMENT_ERROR_ARGUMENT);
    assert_int_equal(
        norma_document_instance_world(document, 1, 0, world, NULL), NORMA_DOCUMENT_ERROR_ARGUMENT);
    norma_document_close(document);
    asset_free(&a);
}

/* Matrices of integers, some near to singular beyond what doubles tell, at sizes up to the ends of
 * their range: the sign of the determinant is that of integer arithmetic. */
__extension__ typedef __int128 wide;

static wide determinant(const int64_t m[3][3]) {
    wide sum = 0;
    for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        sum += (wide)m[0][i] * ((wide)m[1][j] * m[2][k] - (wide)m[1][k] * m[2][j]);
    }
    return sum;
}

static int64_t random_below(uint64_t *seed, int64_t bound) {
    *seed = *seed * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (int64_t)(*seed >> 33) % (2 * bound + 1) - bound;
}

static void random_matrix(uint64_t *seed, int kind, int64_t m[3][3]) {
    const int64_t times = random_below(seed, 1 << 18);
    for (int i = 0; i < 3; ++i) {
        m[0][i] = random_below(seed, 1 << 20);
        m[1][i] = kind < 2 ? random_below(seed, 1 << 20) : times * m[0][i] + random_below(seed, 3);
        m[2][i] = kind == 0   ? random_below(seed, 1 << 20)
                  : kind == 1 ? m[0][i] - m[1][i]
                              : m[0][i] + m[1][i] + random_below(seed, 1);
    }
}

static void test_mirrors(void **state) {
    (void)state;
    enum { NODES = 3000 };
    gltf_asset a = {0};
    uint64_t seed = 7;
    char *rest = malloc((size_t)NODES * 512), *at = rest;
    uint8_t *expected = malloc(NODES);
    size_t signs[3] = {0};
    assert_true(rest && expected);
    add_square(&a);
    at += sprintf(at, "%s,\"nodes\":[", MESH);
    for (int n = 0; n < NODES; ++n) {
        int64_t m[3][3];
        random_matrix(&seed, n % 3, m);
        const wide d = determinant((const int64_t(*)[3])m);
        expected[n] = d < 0;
        ++signs[d < 0 ? 0 : d > 0 ? 2 : 1];
        at += sprintf(at, "%s{\"mesh\":0,\"matrix\":[", n ? "," : "");
        for (int c = 0; c < 3; ++c) {
            for (int r = 0; r < 3; ++r)
                at += sprintf(at, "%.17g,",
                    ldexp((double)m[c][r], n % 5 == 0   ? -340
                                           : n % 5 == 1 ? 270
                                                        : 0));
            at += sprintf(at, "0,");
        }
        at += sprintf(at, "0,0,0,1]}");
    }
    strcpy(at, "]");
    assert_true(signs[0] > NODES / 4 && signs[1] > NODES / 4 && signs[2] > NODES / 4);
    norma_document *document = asset_open(&a, rest, 0);
    for (size_t n = 0; n < NODES; ++n)
        assert_int_equal(node_info(document, n).mirrored_instances, expected[n]);
    norma_document_close(document);
    free(rest);
    free(expected);
    asset_free(&a);
}

/* ---- skins */

static norma_skin_info skin_of(const char *rest, const float *times, size_t time_count,
    const float *values, size_t value_count, int width) {
    gltf_asset a = {0};
    norma_skin_info info;
    norma_document_error error;
    if (times) {
        asset_floats(&a, times, time_count, 1);
        asset_floats(&a, values, value_count, width);
    }
    norma_document *document = asset_open(&a, rest, 0);
    assert_int_equal(norma_document_skin_count(document), 1);
    if (norma_document_skin_info(document, 0, &info, &error)) fail_msg("%s", error.message);
    assert_string_equal(info.where, "/skins/0");
    norma_document_close(document);
    asset_free(&a);
    return info;
}

#define ANIMATION(node, path, kind)                                                                \
    ",\"animations\":[{\"samplers\":[{\"input\":0,\"output\":1,\"interpolation\":\"" kind          \
    "\"}],\"channels\":[{\"sampler\":0,\"target\":{\"node\":" node ",\"path\":\"" path "\"}}]}]"
#define JOINTS "\"skins\":[{\"joints\":[1,2]}],\"nodes\":[{\"children\":[1]},{\"children\":[2]},{}]"

static void test_skins(void **state) {
    (void)state;
    static const float times[3] = {0, 1, 2},
                       even[3][3] = {{1, 1, 1}, {3, 3, 3}, {0.5F, -0.5F, 0.5F}},
                       uneven[3][3] = {{1, 1, 1}, {1, 4, 2}, {3, 1, 1}};
    static const float splines[3][3][3] = {{{0, 0, 0}, {1, 1, 1}, {0, 0, 0}},
        {{9, 0, 0}, {1, 1, 1.5F}, {0, 0, 0}}, {{0, 0, 0}, {1, 1, 1}, {0, 0, 0}}};
    norma_skin_info skin = skin_of(JOINTS, NULL, 0, NULL, 0, 0);
    assert_true(skin.joint_count == 2 && fabs(skin.anisotropy - 1) < 1e-12);
    skin = skin_of("\"skins\":[{\"joints\":[1]}],\"nodes\":[{\"children\":[1],\"scale\":[1,3,1]},{"
                   "\"scale\":[2,2,-2]}]",
        NULL, 0, NULL, 0, 0);
    assert_true(skin.joint == 1 && fabs(skin.anisotropy - 3) < 1e-12);
    skin =
        skin_of("\"skins\":[{\"joints\":[1]}],\"nodes\":[{\"children\":[1],\"scale\":[1,0,1]},{}]",
            NULL, 0, NULL, 0, 0);
    assert_true(isinf(skin.anisotropy));
    assert_true(fabs(skin_of(JOINTS ANIMATION("1", "scale", "LINEAR"), times, 3, &even[0][0], 3, 3)
                         .anisotropy -
                     1) < 1e-12);
    skin = skin_of(JOINTS ANIMATION("0", "scale", "LINEAR"), times, 3, &uneven[0][0], 3,
        3); /* a node above the joints */
    assert_true(fabs(skin.anisotropy - 4) < 1e-6);
    skin = skin_of(JOINTS ANIMATION("2", "scale", "STEP"), times, 3, &uneven[0][0], 3, 3);
    assert_true(skin.joint == 2 && fabs(skin.anisotropy - 4) < 1e-6);
    skin =
        skin_of(JOINTS ANIMATION("2", "scale", "CUBICSPLINE"), times, 3, &splines[0][0][0], 9, 3);
    assert_true(fabs(skin.anisotropy - 1.5) < 1e-6);
    skin = skin_of("\"skins\":[{\"joints\":[1]}],\"nodes\":[{\"children\":[1]},{},{}]" ANIMATION(
                       "2", "scale", "LINEAR"),
        times, 3, &uneven[0][0], 3, 3);
    assert_true(fabs(skin.anisotropy - 1) < 1e-12); /* no joint's */
    assert_true(skin_of("\"skins\":[{\"joints\":[]}]", NULL, 0, NULL, 0, 0).joint == SIZE_MAX);
}

/* Turned by a quarter between two moments, with one key of an uneven scale half-way, under an
 * uneven scale above: M = diag(4,1) R(45) diag(1,4) in the plane, the sum of whose squares is (16 +
 * 256 + 1 + 16) / 2 and whose determinant is 16. */
static void test_skin_between_keys(void **state) {
    (void)state;
    static const float turns[2][4] = {{0, 0, 0, 1}, {0, 0, 0.70710678F, 0.70710678F}},
                       scales[1][3] = {{1, 4, 2}}, moments[2] = {0, 2}, moment[1] = {1};
    gltf_asset a = {0};
    norma_skin_info info;
    asset_floats(&a, moments, 2, 1);
    asset_floats(&a, &turns[0][0], 2, 4);
    asset_floats(&a, moment, 1, 1);
    asset_floats(&a, &scales[0][0], 1, 3);
    norma_document *document = asset_open(&a,
        "\"skins\":[{\"joints\":[1]}],\"nodes\":[{\"children\":[1],\"scale\":[4,1,2]},{}],"
        "\"animations\":[{\"samplers\":[{\"input\":0,\"output\":1},{\"input\":2,\"output\":3}],"
        "\"channels\":[{\"sampler\":0,\"target\":"
        "{\"node\":1,\"path\":\"rotation\"}},{\"sampler\":1,\"target\":{\"node\":1,\"path\":"
        "\"scale\"}}]}]",
        0);
    assert_int_equal(norma_document_skin_info(document, 0, &info, NULL), NORMA_DOCUMENT_OK);
    const double squares = (16 + 256 + 1 + 16) / 2.0,
                 product = 16; /* of the two in the plane; the third is 4 */
    const double sum = sqrt(squares + 2 * product), difference = sqrt(squares - 2 * product);
    const double largest = (sum + difference) / 2, smallest = (sum - difference) / 2;
    assert_true(fabs(info.anisotropy - largest / smallest) < 1e-5);
    norma_document_close(document);
    asset_free(&a);
}

/* ---- lenient reading */

static void test_counts(void **state) {
    (void)state;
    gltf_asset a = {0};
    norma_mesh_data data;
    asset_floats(&a, &square[0][0], 4, 3);
    asset_floats(&a, &up[0][0], 3, 3);
    asset_uint16(&a, corners, 6);
    assert_non_null(strstr(asset_refused(&a, MESH, 0), "as many elements as POSITION"));
    norma_document *document = asset_open(&a, MESH, 1);
    assert_int_equal(attributes_of(document, 0).normals_missing, 1);
    assert_int_equal(norma_document_mesh_data(document, 0, &data, NULL), NORMA_DOCUMENT_OK);
    assert_int_equal(data.normals.count, 3);
    static const uint32_t names[6] = {0, 1, 2, 0, 2, UINT32_MAX};
    assert_memory_equal(data.corner_normals, names, sizeof names);
    norma_document_close(document);
    asset_free(&a);

    asset_floats(&a, &square[0][0], 4, 3);
    asset_floats(&a, &up[0][0], 5, 3);
    asset_uint16(&a, corners, 6);
    assert_non_null(strstr(asset_refused(&a, MESH, 0), "as many elements as POSITION"));
    document = asset_open(&a, MESH, 1);
    assert_int_equal(attributes_of(document, 0).normals_surplus, 1);
    assert_int_equal(norma_document_mesh_data(document, 0, &data, NULL), NORMA_DOCUMENT_OK);
    assert_true(data.normals.count == 4 && !data.corner_normals);
    norma_document_close(document);
    asset_free(&a);
}

/* Computing over normals that are too few reads none that is not there, and mends the count. */
static void test_compute_lenient(void **state) {
    (void)state;
    for (size_t normals = 1; normals <= 5; normals += 2) {
        gltf_asset a = {0};
        asset_floats(&a, &square[0][0], 4, 3);
        asset_floats(&a, &up[0][0], normals, 3);
        asset_uint16(&a, corners, 6);
        for (int only = NORMA_ONLY_ALL; only <= NORMA_ONLY_BROKEN; ++only) {
            norma_document *document = asset_open(&a, MESH, 1);
            const norma_compute_options options = {
                .struct_size = sizeof options, .only = (norma_only)only};
            norma_document_error error;
            if (norma_document_compute(document, &options, NULL, &error))
                fail_msg("%s", error.message);
            norma_document_close(document);
        }
        asset_free(&a);
    }
}

static void test_unread(void **state) {
    (void)state;
    gltf_asset a = {0};
    add_square(&a);
    static const char rest[] =
        "\"extensionsUsed\":[\"ACME_gizmo\",\"KHR_mesh_quantization\"],\"extensionsRequired\":["
        "\"KHR_mesh_quantization\",\"ACME_gizmo\"],"
        "\"meshes\":[{\"primitives\":[{" PRIMITIVE
        "},{\"attributes\":{\"NORMAL\":1}},{\"attributes\":{\"POSITION\":0},\"mode\":0}]}]";
    assert_non_null(strstr(asset_refused(&a, rest, 0), "ACME_gizmo"));
    norma_document *document = asset_open(&a, rest, 1);
    norma_unread unread;
    assert_int_equal(norma_document_unread_count(document), 2); /* points are no surface */
    assert_int_equal(norma_document_unread(document, 0, &unread), NORMA_DOCUMENT_OK);
    assert_string_equal(unread.where, "/extensionsRequired/1");
    assert_string_equal(unread.why, "requires ACME_gizmo, which is unknown to this version");
    assert_int_equal(norma_document_unread(document, 1, &unread), NORMA_DOCUMENT_OK);
    assert_string_equal(unread.where, "/meshes/0/primitives/1");
    assert_string_equal(unread.why, "no positions");
    norma_mesh_attributes attributes;
    assert_int_equal(norma_document_mesh_attributes(document, 1, &attributes, NULL),
        NORMA_DOCUMENT_ERROR_ARGUMENT);
    norma_document_close(document);
    asset_free(&a);
}

/* A caller of the first version, whose options end before the new field, is not read beyond them.
 */
static void test_option_size(void **state) {
    (void)state;
    gltf_asset a = {0};
    size_t size;
    norma_document *document;
    asset_floats(&a, &square[0][0], 4, 3);
    asset_floats(&a, &up[0][0], 3, 3);
    asset_uint16(&a, corners, 6);
    asset_bytes(&a, MESH, &size);
    norma_document_options options = {.struct_size = offsetof(norma_document_options, lenient),
        .format = NORMA_FILE_GLB,
        .lenient = 1};
    assert_int_equal(
        norma_document_open_memory(a.glb, size, "asset.glb", &options, &document, NULL),
        NORMA_DOCUMENT_ERROR_MALFORMED);
    options.struct_size = 0;
    assert_int_equal(
        norma_document_open_memory(a.glb, size, "asset.glb", &options, &document, NULL),
        NORMA_DOCUMENT_ERROR_MALFORMED);
    options.struct_size = sizeof options;
    assert_int_equal(
        norma_document_open_memory(a.glb, size, "asset.glb", &options, &document, NULL),
        NORMA_DOCUMENT_OK);
    norma_document_close(document);
    asset_free(&a);
}

/* ---- OBJ, PLY */

static norma_document *open_text(const char *text, const char *name) {
    norma_document *document;
    norma_document_error error;
    const norma_document_options options = {.struct_size = sizeof options, .lenient = 1};
    if (norma_document_open_memory(text, strlen(text), name, &options, &document, &error))
        fail_msg("%s", error.message);
    return document;
}

static void test_obj(void **state) {
    (void)state;
    norma_document *document =
        open_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvn 0 0 1\nf 1 2 3\nvt 0 0\nvt 1 0 0\n  vt "
                  ".5 .25\nusemtl  red  \nf 1/1/1 2/2/1 3/3/1\n"
                  "usemtl blue#1\nf 1/-3/  2/3 4/4\nusemtl red\nf 1//1 2 3//1\nf 1//0 2//1 3//1\nf "
                  "1//1 2//2 3\n",
            "a.obj");
    const norma_mesh_attributes attributes = attributes_of(document, 0);
    assert_int_equal(norma_document_material_count(document), 2);
    assert_string_equal(material_of(document, 0).name, "red");
    assert_string_equal(material_of(document, 1).name, "blue#1");
    static const uint32_t materials[6] = {UINT32_MAX, 0, 1, 0, 0, 0},
                          texcoords[9] = {
                              UINT32_MAX, UINT32_MAX, UINT32_MAX, 0, 1, 2, 0, 2, UINT32_MAX};
    assert_int_equal(attributes.material, SIZE_MAX);
    assert_memory_equal(attributes.face_materials, materials, sizeof materials);
    static const float uvs[3][2] = {{0, 0}, {1, 0}, {.5F, .25F}};
    assert_int_equal(attributes.texcoord_count, 3);
    assert_memory_equal(attributes.texcoords, uvs, sizeof uvs);
    assert_memory_equal(attributes.corner_texcoords, texcoords, sizeof texcoords);
    assert_true(attributes.normals_missing == 1 && attributes.normals_out_of_range == 2 &&
                attributes.normals_surplus == 0);
    norma_document_close(document);

    document = open_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nusemtl only\nf 1 2 3\n", "a.obj");
    const norma_mesh_attributes bare = attributes_of(document, 0);
    assert_true(
        bare.material == 0 && !bare.face_materials && !bare.texcoords && !bare.corner_texcoords);
    norma_document_close(document);
}

/* Plain lines are read a short way and all others a long one: the same text with other line ends
 * tells the same. */
static void test_obj_line_ends(void **state) {
    (void)state;
    static const char text[] =
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nvt 0 0\nvt 1 0\n#c \\\nf 1/1 2/2 3/1\nf 1/1 2/2 3/1 # x\nf 1/1 "
        "\\\n 2/2 3/0\nf\t1/1\t2/2\t3\nusemtl \\\n b\n"
        "f 1/1 2/2 3/7777777777777\nf 0000000001/2 2/1 3/2   \n f 1/2 2 3\nf 1/+2 2 3\nf 1//  2 "
        "3\nfo 1/2 2 3\nf 3/-1 2/-2/ 1/2/\nf 1/2 2/1/ 3";
    static const char *const ends[] = {"\r\n", "\r"};
    static const uint32_t first[6] = {0, 1, 0, 0, 1, 0};
    norma_document *plain = open_text(text, "a.obj");
    const norma_mesh_attributes a = attributes_of(plain, 0);
    norma_mesh_info info;
    assert_int_equal(norma_document_mesh_info(plain, 0, &info), NORMA_DOCUMENT_OK);
    assert_memory_equal(a.corner_texcoords, first, sizeof first);
    for (size_t k = 0; k < 2; ++k) {
        char other[2 * sizeof text];
        size_t length = 0;
        for (size_t i = 0; i < sizeof text; ++i)
            if (text[i] == '\n')
                length += (size_t)sprintf(other + length, "%s", ends[k]);
            else
                other[length++] = text[i];
        norma_document *document = open_text(other, "a.obj");
        const norma_mesh_attributes b = attributes_of(document, 0);
        assert_int_equal(a.texcoord_count, b.texcoord_count);
        assert_memory_equal(
            a.corner_texcoords, b.corner_texcoords, 3 * info.faces * sizeof *a.corner_texcoords);
        assert_memory_equal(
            a.face_materials, b.face_materials, info.faces * sizeof *a.face_materials);
        norma_document_close(document);
    }
    norma_document_close(plain);
}

/* What is told follows the changes of an OBJ. */
static void test_after_a_change(void **state) {
    (void)state;
    norma_document *document = open_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nvt 0 0\nvn 0 0 1\nusemtl a\nf "
                                         "1/1/1 2/1 3/1/1\nf 1//1 2//1 3//1\n",
        "a.obj");
    assert_int_equal(attributes_of(document, 0).normals_missing, 1);
    const norma_compute_options options = {.struct_size = sizeof options};
    assert_int_equal(norma_document_compute(document, &options, NULL, NULL), NORMA_DOCUMENT_OK);
    assert_true(
        attributes_of(document, 0).normals_missing == 0 && !attributes_of(document, 0).face_faults);
    static const uint8_t drop[2] = {1, 0};
    const norma_mesh_edit edit = {.drop_faces = drop};
    assert_int_equal(norma_document_edit(document, &edit, NULL), NORMA_DOCUMENT_OK);
    const norma_mesh_attributes attributes = attributes_of(document, 0);
    assert_true(attributes.material == 0 && !attributes.texcoords); /* the face with UVs is gone */
    assert_string_equal(material_of(document, 0).name, "a");
    norma_document_close(document);
}

static void test_many_materials(void **state) {
    (void)state;
    enum { COUNT = 1000 };
    char *text = malloc(COUNT * 64 + 100), *at = text;
    assert_non_null(text);
    at += sprintf(at, "v 0 0 0\nv 1 0 0\nv 1 1 0\n");
    for (int i = 0; i < 2 * COUNT; ++i) at += sprintf(at, "usemtl m%d\nf 1 2 3\n", i * 7 % COUNT);
    norma_document *document = open_text(text, "a.obj");
    assert_int_equal(norma_document_material_count(document), COUNT);
    const norma_mesh_attributes attributes = attributes_of(document, 0);
    for (int i = 0; i < 2 * COUNT; ++i) {
        char name[16];
        sprintf(name, "m%d", i * 7 % COUNT);
        assert_string_equal(material_of(document, attributes.face_materials[i]).name, name);
    }
    norma_document_close(document);
    free(text);
}

static void test_ply(void **state) {
    (void)state;
    norma_document *document =
        open_text("ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float "
                  "y\nproperty float z\nproperty float s\nproperty float t\n"
                  "property uchar red\nproperty uchar green\nproperty uchar blue\nelement face "
                  "1\nproperty list uchar int vertex_indices\nend_header\n"
                  "0 0 0 .25 .5 255 0 51\n1 0 0 1 0 0 0 0\n0 1 0 0 1 255 255 255\n3 0 1 2\n",
            "a.ply");
    const norma_mesh_attributes attributes = attributes_of(document, 0);
    static const float uvs[3][2] = {{.25F, .5F}, {1, 0}, {0, 1}},
                       colors[3][4] = {{1, 0, .2F, 1}, {0, 0, 0, 1}, {1, 1, 1, 1}};
    assert_int_equal(attributes.texcoord_count, 3);
    assert_memory_equal(attributes.texcoords, uvs, sizeof uvs);
    assert_memory_equal(attributes.colors, colors, sizeof colors);
    assert_int_equal(attributes.material, SIZE_MAX);
    assert_int_equal(norma_document_material_count(document), 0);
    norma_document_close(document);
}

static void test_nothing(void **state) {
    (void)state;
    assert_int_equal(norma_document_material_count(NULL), 0);
    assert_int_equal(norma_document_skin_count(NULL), 0);
    assert_int_equal(norma_document_unread_count(NULL), 0);
    norma_document *document =
        open_text("solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 "
                  "0\nendloop\nendfacet\nendsolid a\n",
            "a.stl");
    const norma_mesh_attributes attributes = attributes_of(document, 0);
    assert_true(attributes.material == SIZE_MAX && !attributes.texcoords && !attributes.colors);
    assert_int_equal(norma_document_material_count(document), 0);
    norma_document_close(document);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_materials),
        cmocka_unit_test(test_attributes),
        cmocka_unit_test(test_morphs),
        cmocka_unit_test(test_nodes),
        cmocka_unit_test(test_what_a_node_draws),
        cmocka_unit_test(test_deep_path),
        cmocka_unit_test(test_instances),
        cmocka_unit_test(test_skins),
        cmocka_unit_test(test_skin_between_keys),
        cmocka_unit_test(test_counts),
        cmocka_unit_test(test_compute_lenient),
        cmocka_unit_test(test_unread),
        cmocka_unit_test(test_option_size),
        cmocka_unit_test(test_obj),
        cmocka_unit_test(test_after_a_change),
        cmocka_unit_test(test_obj_line_ends),
        cmocka_unit_test(test_many_materials),
        cmocka_unit_test(test_ply),
        cmocka_unit_test(test_nothing),
        cmocka_unit_test(test_mirrors),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
