/* test_gltf_patch.c: how changed accessors come to stand in the file, in the rarer ways: shared
 * ones that part, sparse ones over a base of zeros, a GLB that had no binary chunk, files of one
 * .gltf of which only some change, padding between views. Judged by what is read back, and by what
 * glTF 2.0 asks of the JSON. */
#define _POSIX_C_SOURCE 200809L
#include "check.h"
#include "message.h"
#include "gltf_asset.h"
#include "gltf_output.h"

enum { BYTE = 5120, UBYTE, SHORT, USHORT, UINT = 5125, FLOAT };

static const double TRIANGLE[3][3] = {{0, 0, 0}, {2, 0, 0}, {0, 1, 0}};

static gltf_output edited(norma_document *document, const norma_mesh_edit *edits) {
    norma_document_error error;
    if (norma_document_edit(document, edits, &error)) fail_msg("%s", error.message);
    return output_of(document);
}

/* ---- accessors */

/* One mesh at two places, its normals a byte a number: the second place needs normals of its own,
 * which say that they are normalized, as the first ones do. */
static void test_shared_normals_part(void **state) {
    static const float normals[3][3] = {{0, 0, 1}, {1, 0, 0}, {0, 1, 0}};
    gltf_asset a = {0};
    (void)state;
    asset_numbers(&a, TRIANGLE[0], 3, 3, FLOAT, 0);
    asset_snorm8(&a, normals[0], 3, 3);
    gltf_output b = output_transformed(&a,
        "\"extensionsUsed\":[\"KHR_mesh_quantization\"],\"extensionsRequired\":[\"KHR_mesh_"
        "quantization\"],\"scene\":0,\"scenes\":[{\"nodes\":[0,1]}],\"nodes\":[{\"mesh\":0,"
        "\"rotation\":[1,0,0,0]},{\"mesh\":0,\"rotation\":[0,0,1,0]}],\"meshes\":[{\"primitives\":["
        "{\"attributes\":{\"POSITION\":0,\"NORMAL\":1}}]}]",
        1, NULL);
    assert_int_equal(norma_document_mesh_count(b.document), 2);
    for (size_t m = 0; m < 2; ++m) { /* half turns about x and about z */
        norma_mesh_data data = output_mesh(&b, m);
        const double turn[3] = {m ? -1 : 1, -1, m ? 1 : -1};
        for (size_t v = 0; v < 3; ++v)
            assert_vector(&data.normals, v,
                (const double[]){turn[0] * (double)normals[v][0], turn[1] * (double)normals[v][1],
                    turn[2] * (double)normals[v][2]},
                0);
        const long normal = output_number(&b, "meshes/%ld/primitives/0/attributes/NORMAL", (long)m);
        char path[40];
        snprintf(path, sizeof path, "accessors/%ld/normalized", normal);
        assert_string_equal(output_text(&b, path), "true");
        assert_int_equal(output_number(&b, "accessors/%ld/componentType", normal), BYTE);
    }
    output_finish(&b, &a);
}

/* A target's displacements, zero but for one vertex: sparse over no base. They are carried and stay
 * so: no base is written. */
static void test_sparse_over_nothing(void **state) {
    static const float moves[1][3] = {{0, 0, 3}};
    static const double larger[16] = {2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1};
    gltf_asset a = {0};
    norma_morph_data morph;
    (void)state;
    asset_numbers(&a, TRIANGLE[0], 3, 3, FLOAT, 0);
    const int indices = asset_view(&a, (const uint16_t[]){1}, 2, ""),
              values = asset_view(&a, moves, sizeof moves, "");
    char text[400];
    snprintf(text, sizeof text,
        "{\"componentType\":5126,\"count\":3,\"type\":\"VEC3\",\"min\":[0,0,0],\"max\":[0,0,3],"
        "\"sparse\":{\"count\":1,\"indices\":{\"bufferView\":%d,\"componentType\":5123},\"values\":"
        "{\"bufferView\":%d}}}",
        indices, values);
    asset_accessor(&a, text);
    gltf_output b = output_transformed(&a,
        "\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}],\"meshes\":[{"
        "\"primitives\":[{\"attributes\":{\"POSITION\":0},\"targets\":[{\"POSITION\":1}]}]}]",
        1, larger);
    assert_int_equal(norma_document_morph_data(b.document, 0, 0, &morph, NULL), NORMA_DOCUMENT_OK);
    for (size_t v = 0; v < 3; ++v)
        assert_vector(&morph.positions, v, (const double[]){0, 0, v == 1 ? 6 : 0}, 0);
    assert_int_equal(output_number(&b, "accessors/%ld/bufferView", 1), -1);
    assert_int_equal(output_number(&b, "accessors/%ld/sparse/count", 1), 1);
    assert_string_equal(output_text(&b, "accessors/1/max"), "[0,0,6]");
    assert_int_equal(norma_json_size(&b.json, norma_json_member(&b.json, 0, "bufferViews")), 3);
    output_finish(&b, &a);
}

/* Fewer vertices than before, and sparse accessors, over one list of indices, that name the last:
 * what they now hold is what those vertices had. */
static void expect_fewer_vertices(
    const uint32_t *sources, size_t count, const uint32_t corners[3], int with_base) {
    static const double points[4][3] = {{0, 0, 0}, {2, 0, 0}, {0, 1, 0}, {9, 9, 9}};
    static const float moves[2][3] = {{0, 0, 3}, {0, 0, 5}}, turns[2][3] = {{0, 0, 0}, {1, 0, 0}};
    static const float based[4][3] = {{1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {4, 0, 0}};
    gltf_asset a = {0};
    norma_morph_data morph;
    norma_document_error error;
    char text[400], base[40] = "";
    float wanted[2][4][3];
    asset_numbers(&a, points[0], 4, 3, FLOAT, 0);
    asset_uint16(&a, (const uint16_t[]){0, 2, 3}, 3);
    if (with_base)
        snprintf(base, sizeof base, "\"bufferView\":%d,", asset_view(&a, based, sizeof based, ""));
    const int indices = asset_view(&a, (const uint16_t[]){1, 3}, 4, ""),
              values[2] = {
                  asset_view(&a, moves, sizeof moves, ""), asset_view(&a, turns, sizeof turns, "")};
    for (int k = 0; k < 2; ++k) {
        snprintf(text, sizeof text,
            "{%s\"componentType\":5126,\"count\":4,\"type\":\"VEC3\",\"sparse\":{\"count\":2,"
            "\"indices\":{\"bufferView\":%d,\"componentType\":5123},\"values\":{\"bufferView\":%d}}"
            "}",
            base, indices, values[k]);
        asset_accessor(&a, text);
    }
    const norma_mesh_edit edit = {
        .source_vertices = sources, .vertex_count = count, .new_corners = corners};
    norma_document *document = asset_open(&a,
        "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1,\"targets\":[{"
        "\"POSITION\":2,\"NORMAL\":3}]}]}]",
        0);
    if (norma_document_morph_data(document, 0, 0, &morph, &error)) fail_msg("%s", error.message);
    for (size_t v = 0; v < count; ++v) {
        memcpy(wanted[0][v], (const float *)morph.positions.data + 3 * sources[v],
            sizeof wanted[0][v]);
        memcpy(
            wanted[1][v], (const float *)morph.normals.data + 3 * sources[v], sizeof wanted[1][v]);
    }
    gltf_output b = edited(document, &edit);
    if (norma_document_morph_data(b.document, 0, 0, &morph, &error)) fail_msg("%s", error.message);
    assert_true(morph.positions.count == count && morph.normals.count == count);
    assert_memory_equal(morph.positions.data, wanted[0], count * sizeof wanted[0][0]);
    assert_memory_equal(morph.normals.data, wanted[1], count * sizeof wanted[1][0]);
    for (long k = 2; k < 4; ++k) { /* strictly rising, below count (glTF 2.0, 5.2) */
        const long named = output_number(&b, "accessors/%ld/sparse/count", k);
        assert_int_equal(named, count < 2 ? count : 2);
        assert_int_equal(output_number(&b, "accessors/%ld/bufferView", k) < 0, !with_base);
    }
    norma_mesh_data data = output_mesh(&b, 0);
    for (size_t v = 0; v < count; ++v)
        assert_vector(&data.mesh.positions, v, points[sources[v]], 0);
    output_finish(&b, &a);
}

static void test_sparse_of_fewer_vertices(void **state) {
    (void)state;
    expect_fewer_vertices((const uint32_t[]){0, 2, 3}, 3, (const uint32_t[]){0, 1, 2}, 0);
    expect_fewer_vertices((const uint32_t[]){3, 1}, 2, (const uint32_t[]){0, 1, 0}, 0);
    expect_fewer_vertices((const uint32_t[]){3}, 1, (const uint32_t[]){0, 0, 0}, 0);
    for (int fewer = 1; fewer < 4; ++fewer)
        expect_fewer_vertices((const uint32_t[]){3, 0, 1}, (size_t)fewer,
            (const uint32_t[]){0, 0, (uint32_t)fewer - 1}, 1);
}

/* Sparse values with a byteStride, which they must not have (glTF 2.0, 3.6.2.3): as they are read
 * they are written. */
static void test_sparse_values_apart(void **state) {
    static const float values[2][4] = {{1, 0, 0, 7}, {0, 1, 0, 7}},
                       turned[3][3] = {{0}, {0}, {0, 0, 1}};
    static const uint8_t last[3] = {0, 0, 1};
    const norma_mesh_edit edit = {.normals = turned[0], .set_normals = last};
    gltf_asset a = {0};
    char text[400];
    (void)state;
    asset_numbers(&a, TRIANGLE[0], 3, 3, FLOAT, 0);
    const int base = asset_view(&a, TRIANGLE, 36, ""),
              indices = asset_view(&a, (const uint16_t[]){0, 2}, 4, ""),
              spread = asset_view(&a, values, sizeof values, ",\"byteStride\":16");
    snprintf(text, sizeof text,
        "{\"bufferView\":%d,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\",\"sparse\":{"
        "\"count\":2,\"indices\":{\"bufferView\":%d,\"componentType\":5123},\"values\":{"
        "\"bufferView\":%d}}}",
        base, indices, spread);
    asset_accessor(&a, text);
    gltf_output b = edited(
        asset_open(&a,
            "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"NORMAL\":1}}]}]", 0),
        &edit);
    norma_mesh_data data = output_mesh(&b, 0);
    assert_vector(&data.normals, 0, (const double[]){1, 0, 0}, 0);
    assert_vector(&data.normals, 2, (const double[]){0, 0, 1}, 0);
    output_finish(&b, &a);
}

/* Positions without a view are zeros (glTF 2.0, 3.6.2.3), and a GLB with nothing else has no binary
 * chunk. Normals need one: the first buffer, without a URI, right behind the JSON. A triangle of
 * one point has no normal, the vertex that no triangle uses none to take: +Z both, as everywhere
 * where a mesh has no normal at all. */
static void test_a_glb_without_bytes(void **state) {
    gltf_asset a = {0};
    norma_compute_summary summary;
    norma_document_error error;
    size_t size;
    (void)state;
    asset_bytes(&a,
        "\"accessors\":[{\"componentType\":5126,\"count\":4,\"type\":\"VEC3\",\"min\":[0,0,0],"
        "\"max\":[0,0,0]}],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}]",
        &size);
    document_bytes in = bytes_copy(a.glb, size);
    norma_document *document = bytes_open(in, "a.glb");
    if (norma_document_compute(document, NULL, &summary, &error)) fail_msg("%s", error.message);
    gltf_output b = output_of(document);
    assert_string_equal(output_text(&b, "buffers/0/uri"), "");
    assert_int_equal(output_number(&b, "buffers/%ld/byteLength", 0), 48);
    assert_int_equal(summary.filled, 4);
    norma_mesh_data data = output_mesh(&b, 0);
    assert_int_equal(data.normals.count, 4);
    for (size_t v = 0; v < 4; ++v) assert_vector(&data.normals, v, (const double[]){0, 0, 1}, 0);
    bytes_free(&in);
    output_finish(&b, &a);
}

/* A buffer that says more bytes than the binary chunk has. */
static void test_a_chunk_too_short(void **state) {
    gltf_asset a = {0};
    (void)state;
    asset_numbers(&a, TRIANGLE[0], 3, 3, FLOAT, 0);
    size_t size;
    norma_document *document = NULL;
    norma_document_error error;
    asset_bytes(&a, "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}]", &size);
    char *place = strstr((char *)a.glb + 20, "\"buffers\":[{\"byteLength\":36}");
    assert_non_null(place);
    memcpy(place, "\"buffers\":[{\"byteLength\":96}", 28);
    assert_int_equal(norma_document_open_memory(a.glb, size, "a.glb", NULL, &document, &error),
        NORMA_DOCUMENT_ERROR_MALFORMED);
    assert_message(error.message,
        "a.glb:/buffers/0: expected a byteLength no longer than the BIN chunk; found ");
    asset_free(&a);
}

/* ---- files beside a .gltf */

typedef struct folder {
    char path[80], file[200];
} folder;

static int make_folder(void **state) {
    folder *made = calloc(1, sizeof *made);
    snprintf(made->path, sizeof made->path, "/tmp/norma-gltf-patch-XXXXXX");
    *state = made;
    return made && mkdtemp(made->path) ? 0 : -1;
}

static int remove_folder(void **state) {
    char command[200];
    folder *here = *state;
    snprintf(command, sizeof command, "rm -rf '%s'", here->path);
    const int failed = system(command);
    free(here);
    return failed;
}

static const char *in_folder(folder *here, const char *name) {
    snprintf(here->file, sizeof here->file, "%s/%s", here->path, name);
    return here->file;
}

static void put_file(folder *here, const char *name, const void *bytes, size_t size) {
    FILE *file = fopen(in_folder(here, name), "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, size, file), size);
    fclose(file);
}

static size_t count_files(const folder *here) {
    char command[200];
    int count = 0;
    snprintf(command, sizeof command, "ls -A '%s' | wc -l", here->path);
    FILE *list = popen(command, "r");
    assert_non_null(list);
    assert_int_equal(fscanf(list, "%d", &count), 1);
    pclose(list);
    return (size_t)count;
}

static norma_document *open_file(folder *here, const char *name) {
    norma_document *document;
    norma_document_error error;
    if (norma_document_open(in_folder(here, name), NULL, &document, &error))
        fail_msg("%s", error.message);
    return document;
}

static const char TWO_FILES[] =
    "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":72,\"uri\":\"a.bin\"},{"
    "\"byteLength\":72,\"uri\":\"b.bin\"}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":36},{"
    "\"buffer\":0,\"byteOffset\":36,\"byteLength\":36},{\"buffer\":1,\"byteLength\":36},{"
    "\"buffer\":1,\"byteOffset\":36,\"byteLength\":36}],\"accessors\":[{\"bufferView\":0,"
    "\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"},{\"bufferView\":1,\"componentType\":"
    "5126,\"count\":3,\"type\":\"VEC3\"},{\"bufferView\":2,\"componentType\":5126,\"count\":3,"
    "\"type\":\"VEC3\"},{\"bufferView\":3,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}],"
    "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"NORMAL\":1}},{\"attributes\":{"
    "\"POSITION\":2,\"NORMAL\":3}}]}]}";

static void floats_of(const double (*vectors)[3], size_t count, float *out) {
    for (size_t i = 0; i < 3 * count; ++i) out[i] = (float)vectors[i / 3][i % 3];
}

/* Positions in one file, normals of +Z: one primitive's are changed; what is read then holds both,
 * the unchanged one too though its file is gone meanwhile. */
static void test_changed_with_a_file_that_stays(void **state) {
    static const float down[9] = {0, 0, -1, 0, 0, -1, 0, 0, -1};
    static const uint8_t all[3] = {1, 1, 1};
    folder *here = *state;
    float bytes[18] = {0};
    norma_document_error error;
    floats_of(TRIANGLE, 3, bytes);
    for (int i = 0; i < 3; ++i) bytes[11 + 3 * i] = 1;
    put_file(here, "a.gltf", TWO_FILES, sizeof TWO_FILES - 1);
    put_file(here, "a.bin", bytes, sizeof bytes);
    put_file(here, "b.bin", bytes, sizeof bytes);
    norma_document *document = open_file(here, "a.gltf");
    const norma_mesh_edit edits[2] = {{.normals = down, .set_normals = all}, {0}};
    assert_int_equal(norma_document_edit(document, edits, NULL), NORMA_DOCUMENT_OK);
    (void)norma_document_mesh_count(document);
    remove(in_folder(here, "b.bin"));
    for (size_t m = 0; m < 2; ++m) {
        norma_mesh_data data;
        if (norma_document_mesh_data(document, m, &data, &error)) fail_msg("%s", error.message);
        for (size_t v = 0; v < 3; ++v) {
            assert_vector(&data.mesh.positions, v, TRIANGLE[v], 0);
            assert_vector(&data.normals, v, (const double[]){0, 0, m ? 1 : -1}, 0);
        }
    }
    norma_document_close(document);
}

/* A file of 38 bytes gets normals: views begin at multiples of four, and what lies between is
 * zeros. The same output twice is the same file; one that differs in those zeros alone is another
 * file, and stays. */
static void test_padding_is_compared(void **state) {
    static const char text[] =
        "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":42,\"uri\":\"c.bin\"}],"
        "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36},{\"buffer\":0,\"byteOffset\":36,"
        "\"byteLength\":6}],\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,"
        "\"type\":\"VEC3\"},{\"bufferView\":1,\"componentType\":5123,\"count\":3,\"type\":"
        "\"SCALAR\"}],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1}]"
        "}]}";
    static const uint16_t corners[3] = {0, 1, 2};
    folder *here = *state;
    unsigned char bytes[42];
    float floats[9];
    floats_of(TRIANGLE, 3, floats);
    memcpy(bytes, floats, 36);
    memcpy(bytes + 36, corners, 6);
    put_file(here, "c.gltf", text, sizeof text - 1);
    put_file(here, "c.bin", bytes, sizeof bytes);
    for (int round = 0; round < 3; ++round) {
        norma_document_error error = {0};
        norma_document *document = open_file(here, "c.gltf");
        assert_int_equal(norma_document_compute(document, NULL, NULL, NULL), NORMA_DOCUMENT_OK);
        if (round == 2) { /* in the padding, behind 42 bytes */
            document_bytes out = bytes_load(in_folder(here, "d.bin"));
            assert_int_equal(out.size, 80);
            assert_true(out.data[42] == 0 && out.data[43] == 0);
            out.data[43] = 1;
            put_file(here, "d.bin", out.data, out.size);
            remove(in_folder(here, "d.gltf"));
            bytes_free(&out);
        }
        const norma_document_result result =
            norma_document_save(document, in_folder(here, "d.gltf"), NULL, &error);
        assert_int_equal(result, round == 2 ? NORMA_DOCUMENT_ERROR_REFUSED : NORMA_DOCUMENT_OK);
        if (round == 2)
            assert_non_null(
                strstr(error.message, "d.bin: exists with other content and is not overwritten"));
        assert_int_equal(count_files(here), round == 2 ? 3 : 4);
        norma_document_close(document);
    }
}

static void test_a_file_too_short(void **state) {
    folder *here = *state;
    float bytes[18] = {0};
    norma_document *document = NULL;
    norma_document_error error;
    put_file(here, "a.gltf", TWO_FILES, sizeof TWO_FILES - 1);
    put_file(here, "a.bin", bytes, sizeof bytes);
    put_file(here, "b.bin", bytes, sizeof bytes - 1);
    assert_int_equal(norma_document_open(in_folder(here, "a.gltf"), NULL, &document, &error),
        NORMA_DOCUMENT_ERROR_MALFORMED);
    assert_non_null(strstr(
        error.message, "/a.gltf:/buffers/1: the buffer b.bin has 71 bytes, but should have 72"));
}

/* Bytes between views that no view names, in a file with lengths that are multiples of 4. */
static long unnamed(const gltf_output *b) {
    long left = output_number(b, "buffers/%ld/byteLength", 0);
    for (long view = 0; *output_text(b, view == 0   ? "bufferViews/0"
                                        : view == 1 ? "bufferViews/1"
                                        : view == 2 ? "bufferViews/2"
                                        : view == 3 ? "bufferViews/3"
                                                    : "bufferViews/4");
         ++view)
        left -= output_number(b, "bufferViews/%ld/byteLength", view);
    return left;
}

/* Vertices are added, and taken away from what they were: what is replaced is left out, what stays
 * moves and is the same. But where an extension may mean bytes that no view names, all stay. */
static void replaced_bytes(const char *more) {
    static const float positions[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    static const float between[5] = {5, 6, 7, 8, 9};
    static const uint32_t corners[6] = {0, 1, 2, 0, 2, 3};
    static const norma_shading shadings[] = {NORMA_SHADING_FLAT, NORMA_SHADING_SMOOTH};
    gltf_asset a = {0};
    char rest[300];
    asset_floats(&a, positions[0], 4, 3);
    asset_view(&a, corners, sizeof corners, "");
    asset_accessor(&a, "{\"bufferView\":1,\"componentType\":5125,\"count\":6,\"type\":\"SCALAR\"}");
    asset_view(&a, between, sizeof between, ""); /* of nobody whom we know */
    snprintf(rest, sizeof rest,
        "%s\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1}]}]", more);
    norma_document *document = asset_open(&a, rest, 0);
    for (int turn = 0; turn < 2; ++turn) {
        const norma_compute_options options = {
            .struct_size = sizeof options, .shading = shadings[turn]};
        assert_int_equal(norma_document_compute(document, &options, NULL, NULL), NORMA_DOCUMENT_OK);
    }
    gltf_output b = output_of(document);
    assert_int_equal(output_number(&b, "accessors/%ld/count", 0), 6);
    const unsigned char *glb = (const unsigned char *)b.bytes.data,
                        *bin = glb + 28 + (glb[12] | glb[13] << 8);
    assert_memory_equal(
        bin + output_number(&b, "bufferViews/%ld/byteOffset", 2), between, sizeof between);
    if (*more) {
        assert_memory_equal(bin, positions, sizeof positions);
        assert_memory_equal(bin + sizeof positions, corners, sizeof corners);
    } else {
        assert_int_equal(unnamed(&b), 0);
    }
    output_finish(&b, &a);
}

static void test_replaced_bytes_are_left_out(void **state) {
    (void)state;
    replaced_bytes("");
    replaced_bytes("\"extensions\":{\"VENDOR_x\":{\"buffer\":0,\"byteLength\":60}},");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_shared_normals_part),
        cmocka_unit_test(test_replaced_bytes_are_left_out),
        cmocka_unit_test(test_sparse_over_nothing),
        cmocka_unit_test(test_sparse_of_fewer_vertices),
        cmocka_unit_test(test_sparse_values_apart),
        cmocka_unit_test(test_a_glb_without_bytes),
        cmocka_unit_test(test_a_chunk_too_short),
        cmocka_unit_test_setup_teardown(
            test_changed_with_a_file_that_stays, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_padding_is_compared, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_a_file_too_short, make_folder, remove_folder),
    };
    return cmocka_run_group_tests_name("glTF: where changes go", tests, NULL, NULL);
}
