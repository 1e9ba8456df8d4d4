/* test_gltf_surface.c: a glTF mesh as one surface, in its rarer shapes: primitives in several
 * encodings, some over the same positions, some that are not read; deltas that outgrow their
 * encoding; meshes too large to count; what else belongs to a surface. Two faces of a roof, mirror
 * images of one another, give the ridge a normal that points straight up: so it is seen whether
 * they are one surface. */
#include "check.h"
#include "gltf_asset.h"
#include "gltf_output.h"

enum { BYTE = 5120, UBYTE, SHORT, USHORT, UINT = 5125, FLOAT };

/* Left and right face: the ridge from (0,0,2) to (0,4,2), eaves at x = -4 and 4; 53 degrees between
 * them. */
static const double LEFT[3][3] = {{0, 0, 2}, {0, 4, 2}, {-4, 2, 0}},
                    RIGHT[3][3] = {{0, 4, 2}, {0, 0, 2}, {4, 2, 0}};
static const double UP[3] = {0, 0, 1};
#define SLOPE 0.4472135954999579 /* of an eave's normal along x; twice that along z */

static gltf_output computed(
    gltf_asset *a, const char *rest, const norma_compute_options *options, int lenient) {
    norma_document_error error;
    norma_document *document = asset_open(a, rest, lenient);
    if (norma_document_compute(document, options, NULL, &error)) fail_msg("%s", error.message);
    return output_of(document);
}

static void assert_roof(const gltf_output *b, size_t mesh, double side, size_t ridge, size_t eave) {
    norma_mesh_data data = output_mesh(b, mesh);
    assert_vector(&data.normals, ridge, UP, 1e-6);
    assert_vector(&data.normals, ridge + 1, UP, 1e-6);
    assert_vector(&data.normals, eave, (const double[]){side * SLOPE, 0, 2 * SLOPE}, 1e-6);
}

/* ---- primitives of one mesh */

/* One face in floats, one in 16-bit numbers: equal numbers are equal positions. */
static void test_two_encodings(void **state) {
    gltf_asset a = {0};
    (void)state;
    asset_numbers(&a, LEFT[0], 3, 3, FLOAT, 0);
    asset_numbers(&a, RIGHT[0], 3, 3, SHORT, 0);
    gltf_output b = computed(&a,
        "\"extensionsUsed\":[\"KHR_mesh_quantization\"],\"extensionsRequired\":[\"KHR_mesh_"
        "quantization\"],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}},{"
        "\"attributes\":{\"POSITION\":1}}]}]",
        NULL, 0);
    assert_roof(&b, 0, -1, 0, 2);
    assert_roof(&b, 1, 1, 0, 2);
    output_free(&b);
    asset_free(&a);
}

/* Two primitives over the same positions, which draw a face each, and a third of its own: the wall
 * below the right eave, with a crease between. */
static void test_some_share_positions(void **state) {
    static const double wall[4][3] = {{4, 2, 0}, {0, 0, 2}, {8, 0, -6}, {0, 0, 0}};
    double points[6][3];
    gltf_asset a = {0};
    (void)state;
    memcpy(points, LEFT, sizeof LEFT);
    memcpy(points + 3, RIGHT, sizeof RIGHT);
    asset_numbers(&a, points[0], 6, 3, FLOAT, 0);
    asset_uint16(&a, (const uint16_t[]){0, 1, 2}, 3);
    asset_uint16(&a, (const uint16_t[]){3, 4, 5}, 3);
    asset_numbers(&a, wall[0], 3, 3, FLOAT, 0);
    gltf_output b = computed(&a,
        "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1},{"
        "\"attributes\":{\"POSITION\":0},\"indices\":2},{\"attributes\":{\"POSITION\":3}}]}]",
        NULL, 0);
    norma_mesh_data data = output_mesh(&b, 0);
    assert_int_equal(output_number(&b, "meshes/0/primitives/%ld/attributes/NORMAL", 0),
        output_number(&b, "meshes/0/primitives/%ld/attributes/NORMAL", 1));
    assert_int_equal(data.normals.count, 6);
    assert_vector(&data.normals, 1, UP, 1e-6); /* the ridge's far end, where no third face comes */
    assert_vector(&data.normals, 3, UP, 1e-6);
    assert_vector(&data.normals, 2, (const double[]){-SLOPE, 0, 2 * SLOPE}, 1e-6);
    data = output_mesh(&b, 2);
    assert_int_equal(data.normals.count, 3);
    output_free(&b);
    asset_free(&a);
}

/* A line beside the triangle, with a target as every primitive of its mesh has: not read; the
 * triangle's deltas are what the turned triangle's normal has more than its own. */
static void test_morphed_beside_a_line(void **state) {
    static const double flat[3][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}},
                        moves[3][3] = {{0, 0, 0}, {0, 0, 1}, {0, 0, 0}}, none[3][3] = {{0}};
    const norma_compute_options options = {.struct_size = sizeof options, .morphs = 1};
    gltf_asset a = {0};
    norma_morph_data morph;
    (void)state;
    asset_numbers(&a, flat[0], 3, 3, FLOAT, 0);
    asset_numbers(&a, moves[0], 3, 3, FLOAT, 0);
    asset_numbers(&a, none[0], 3, 3, FLOAT, 0);
    gltf_output b = computed(&a,
        "\"meshes\":[{\"primitives\":[{\"mode\":3,\"attributes\":{\"POSITION\":0},\"targets\":[{"
        "\"POSITION\":2}]},{\"attributes\":{\"POSITION\":0},\"targets\":[{\"POSITION\":1}]}]}]",
        &options, 0);
    assert_int_equal(norma_document_morph_data(b.document, 1, 0, &morph, NULL), NORMA_DOCUMENT_OK);
    for (size_t v = 0; v < 3; ++v)
        assert_vector(&morph.normals, v, (const double[]){-sqrt(.5), 0, sqrt(.5) - 1},
            1e-6); /* (1,0,1) x (0,1,0) = (-1,0,1) */
    assert_int_equal(output_number(&b, "meshes/0/primitives/%ld/attributes/NORMAL", 0), -1);
    output_free(&b);
    asset_free(&a);
}

/* Deltas in bytes, of which only those of broken normals are made anew: a face that turns over
 * needs -2, which fractions do not hold. They become floats, the others with the values that their
 * codes meant. */
static void test_deltas_outgrow_their_encoding(void **state) {
    static const double points[6][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {5, 0, 0}, {6, 0, 0},
        {5, 1, 0}},
                        normals[6][3] = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}, {0}, {0}, {0}};
    static const double moves[6][3] = {{0}, {0}, {0}, {0}, {-2, 0, 0}, {0}},
                        deltas[6][3] = {
                            {64 / 127.0, 0, 0}, {0, -1, 0}, {0, 0, -128 / 127.0}, {0}, {0}, {0}};
    const norma_compute_options options = {
        .struct_size = sizeof options, .only = NORMA_ONLY_BROKEN};
    gltf_asset a = {0};
    norma_morph_data morph;
    (void)state;
    asset_numbers(&a, points[0], 6, 3, FLOAT, 0);
    asset_numbers(&a, normals[0], 6, 3, FLOAT, 0);
    asset_numbers(&a, moves[0], 6, 3, FLOAT, 0);
    asset_numbers(&a, deltas[0], 6, 3, BYTE, 1);
    gltf_output b = computed(&a,
        "\"extensionsUsed\":[\"KHR_mesh_quantization\"],\"extensionsRequired\":[\"KHR_mesh_"
        "quantization\"],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"NORMAL\":1}"
        ",\"targets\":[{\"POSITION\":2,\"NORMAL\":3}]}]}]",
        &options, 0);
    assert_int_equal(output_number(&b, "accessors/%ld/componentType",
                         output_number(&b, "meshes/0/primitives/%ld/targets/0/NORMAL", 0)),
        FLOAT);
    assert_int_equal(norma_document_morph_data(b.document, 0, 0, &morph, NULL), NORMA_DOCUMENT_OK);
    norma_mesh_data data = output_mesh(&b, 0);
    for (size_t v = 0; v < 6; ++v) {
        assert_vector(&data.normals, v, UP, 0);
        assert_vector(&morph.normals, v,
            v < 3 ? (const double[]){deltas[v][0], deltas[v][1], v == 2 ? -1 : 0}
                  : (const double[]){0, 0, -2},
            1e-7);
    }
    output_free(&b);
    asset_free(&a);
}

/* ---- sizes */

/* 772 primitives over 5,600,000 vertices each are more than 32 bits count. The file is 67 MB, of
 * zeros. */
static void test_too_many_vertices(void **state) {
    enum { PRIMITIVES = 772, VERTICES = 5600000 };
    char *text = malloc(200 * PRIMITIVES + 1000);
    norma_document *document = NULL;
    norma_document_error error;
    (void)state;
    assert_non_null(text);
    char *at =
        text + sprintf(text,
                   "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":%d}],"
                   "\"bufferViews\":[{\"buffer\":0,\"byteLength\":%d}],\"accessors\":[{"
                   "\"bufferView\":0,\"componentType\":5123,\"count\":3,\"type\":\"SCALAR\"}",
                   12 * VERTICES, 12 * VERTICES);
    for (int i = 0; i < PRIMITIVES; ++i)
        at += sprintf(at,
            ",{\"bufferView\":0,\"componentType\":5126,\"count\":%d,\"type\":\"VEC3\"}", VERTICES);
    at += sprintf(at, "],\"meshes\":[{\"primitives\":[");
    for (int i = 0; i < PRIMITIVES; ++i)
        at +=
            sprintf(at, "%s{\"attributes\":{\"POSITION\":%d},\"indices\":0}", i ? "," : "", i + 1);
    at += sprintf(at, "]}]}");
    while ((at - text) % 4) *at++ = ' ';
    const size_t length = (size_t)(at - text), size = 28 + length + 12 * (size_t)VERTICES;
    unsigned char *glb = calloc(size, 1);
    assert_non_null(glb);
    const uint32_t head[5] = {0x46546c67, 2, (uint32_t)size, (uint32_t)length, 0x4e4f534a},
                   chunk[2] = {12 * VERTICES, 0x4e4942};
    memcpy(glb, head, sizeof head);
    memcpy(glb + 20, text, length);
    memcpy(glb + 20 + length, chunk, sizeof chunk);
    if (norma_document_open_memory(glb, size, "a.glb", NULL, &document, &error))
        fail_msg("%s", error.message);
    assert_int_equal(
        norma_document_compute(document, NULL, NULL, &error), NORMA_DOCUMENT_ERROR_UNSUPPORTED);
    assert_non_null(strstr(error.message, "a mesh of more than 4294967295 vertices or corners"));
    norma_document_close(document);
    free(glb);
    free(text);
}

/* ---- what else belongs to a surface */

/* Whole numbers of 32 bits, which glTF has for indices alone, are taken as the numbers they are. */
static void test_wide_numbers(void **state) {
    static const uint32_t uvs[3][2] = {{0, 1}, {4000000000u, 2}, {16777216, 3}};
    gltf_asset a = {0};
    norma_mesh_attributes attributes;
    char text[200];
    (void)state;
    asset_numbers(&a, LEFT[0], 3, 3, FLOAT, 0);
    const int view = asset_view(&a, uvs, sizeof uvs, "");
    snprintf(text, sizeof text,
        "{\"bufferView\":%d,\"componentType\":5125,\"count\":3,\"type\":\"VEC2\"}", view);
    asset_accessor(&a, text);
    norma_document *document = asset_open(&a,
        "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"TEXCOORD_0\":1}}]}]", 0);
    assert_int_equal(
        norma_document_mesh_attributes(document, 0, &attributes, NULL), NORMA_DOCUMENT_OK);
    assert_int_equal(attributes.texcoord_count, 3);
    for (int i = 0; i < 6; ++i)
        assert_true((double)attributes.texcoords[i] == (double)uvs[i / 2][i % 2]);
    norma_document_close(document);
    asset_free(&a);
}

/* A list of rules that is far too long counts as far as it is kept: whole names, the first ones. */
static void test_a_long_list_of_rules(void **state) {
    gltf_asset a = {0};
    norma_mesh_attributes attributes;
    char rest[4000] = "\"extras\":{\"norma\":{\"ignore\":[", wanted[2000] = "";
    (void)state;
    asset_numbers(&a, LEFT[0], 3, 3, FLOAT, 0);
    for (int i = 0; i < 200; ++i)
        snprintf(
            rest + strlen(rest), sizeof rest - strlen(rest), "%s\"N%d\"", i ? "," : "", 100 + i);
    strcat(rest, "]}},\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}]");
    norma_document *document = asset_open(&a, rest, 0);
    assert_int_equal(
        norma_document_mesh_attributes(document, 0, &attributes, NULL), NORMA_DOCUMENT_OK);
    const size_t length = strlen(attributes.ignore);
    assert_true(length > 500 && length < 600 && length % 5 == 4);
    for (int i = 0; i < 200; ++i)
        snprintf(wanted + strlen(wanted), sizeof wanted - strlen(wanted), "N%d,", 100 + i);
    assert_memory_equal(attributes.ignore, wanted, length);
    norma_document_close(document);
    asset_free(&a);
}

/* A node that is no instancing one has one instance: itself. */
static void test_a_node_is_its_own_instance(void **state) {
    gltf_asset a = {0};
    norma_document_error error;
    double world[16];
    (void)state;
    asset_numbers(&a, LEFT[0], 3, 3, FLOAT, 0);
    norma_document *document = asset_open(&a,
        "\"nodes\":[{\"mesh\":0,\"translation\":[1,2,3],\"scale\":[2,2,2]}],\"meshes\":[{"
        "\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}]",
        0);
    assert_int_equal(
        norma_document_instance_world(document, 0, 0, world, &error), NORMA_DOCUMENT_OK);
    const double expected[16] = {2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 1, 2, 3, 1};
    for (int i = 0; i < 16; ++i) assert_true(world[i] == expected[i]);
    assert_int_equal(norma_document_instance_world(document, 0, 1, world, &error),
        NORMA_DOCUMENT_ERROR_ARGUMENT);
    norma_document_close(document);
    asset_free(&a);
}

/* ---- how much a file may stand for */

enum { GRID = 30 };

/* A sheet whose triangles all face elsewhere; so many attributes beside the positions, all of one
 * accessor. */
static norma_document_result computed_flat(int attributes, norma_document_error *error) {
    float positions[GRID * GRID][3];
    uint16_t corners[6 * (GRID - 1) * (GRID - 1)];
    size_t count = 0;
    for (int i = 0; i < GRID * GRID; ++i) {
        const float x = (float)(i % GRID), y = (float)(i / GRID);
        memcpy(positions[i],
            (const float[]){x, y, x * x * 0.01f + x * y * 0.02f + y * y * y * 0.001f},
            sizeof positions[i]);
    }
    for (int y = 0; y < GRID - 1; ++y)
        for (int x = 0; x < GRID - 1; ++x)
            for (int k = 0; k < 6; ++k)
                corners[count++] =
                    (uint16_t)(GRID * y + x + (const int[]){0, 1, GRID, 1, GRID + 1, GRID}[k]);
    gltf_asset a = {0};
    char *rest = malloc(100 + 20 * (size_t)attributes), *at = rest;
    assert_non_null(rest);
    const int numbers[] = {
        asset_floats(&a, positions[0], (size_t)GRID * GRID, 3), asset_uint16(&a, corners, count)};
    at +=
        sprintf(at, "\"meshes\":[{\"primitives\":[{\"indices\":%d,\"attributes\":{\"POSITION\":%d",
            numbers[1], numbers[0]);
    for (int i = 0; i < attributes; ++i) at += sprintf(at, ",\"_%d\":%d", i, numbers[0]);
    strcpy(at, "}}]}]");
    norma_document *document = asset_open(&a, rest, 0);
    const norma_compute_options flat = {.struct_size = sizeof flat, .shading = NORMA_SHADING_FLAT};
    const norma_document_result result = norma_document_compute(document, &flat, NULL, error);
    norma_document_close(document);
    asset_free(&a);
    free(rest);
    return result;
}

static void test_copies_are_measured_by_the_file(void **state) {
    (void)state;
    norma_document_error error = {0};
    assert_int_equal(computed_flat(100, &error), NORMA_DOCUMENT_OK);
    assert_int_equal(computed_flat(1000, &error), NORMA_DOCUMENT_ERROR_UNSUPPORTED);
    assert_non_null(strstr(error.message, "/meshes/0/primitives/0: "));
    assert_non_null(strstr(error.message,
        "vertices of 12012 bytes each, with those of all primitives before, would take far more "
        "memory than the file; at most 512 bytes are read for each byte of it"));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_copies_are_measured_by_the_file),
        cmocka_unit_test(test_two_encodings),
        cmocka_unit_test(test_some_share_positions),
        cmocka_unit_test(test_morphed_beside_a_line),
        cmocka_unit_test(test_deltas_outgrow_their_encoding),
        cmocka_unit_test(test_too_many_vertices),
        cmocka_unit_test(test_wide_numbers),
        cmocka_unit_test(test_a_long_list_of_rules),
        cmocka_unit_test(test_a_node_is_its_own_instance),
    };
    return cmocka_run_group_tests_name("glTF surfaces", tests, NULL, NULL);
}
