/* test_document_arguments.c: every call on documents with what makes no sense: no document, no
 * place for the answer, numbers beyond what is there, a summary, a document that a change has
 * failed on. Each answers with an argument error, says which, and leaves nothing undefined. */
#include "check.h"
#include "document_bytes.h"
#include "gltf_asset.h"
#include <norma/large.h>

#define ARGUMENT NORMA_DOCUMENT_ERROR_ARGUMENT
static const char TRIANGLE[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

#define refused(call, text)                                                                        \
    do {                                                                                           \
        norma_document_error error = {0}, *e = &error;                                             \
        assert_int_equal(call, ARGUMENT);                                                          \
        assert_string_equal(error.message, text);                                                  \
        assert_int_equal(error.result, ARGUMENT);                                                  \
        e = NULL;                                                                                  \
        assert_int_equal(call, ARGUMENT);                                                          \
    } while (0)

static norma_document *open_with(norma_document_depth depth) {
    const norma_document_options options = {.struct_size = sizeof options, .depth = depth};
    norma_document *document = NULL;
    assert_int_equal(norma_document_open_memory(
                         TRIANGLE, sizeof TRIANGLE - 1, "a.obj", &options, &document, NULL),
        NORMA_DOCUMENT_OK);
    return document;
}

static int take(void *user, const void *bytes, size_t size) {
    (void)user;
    (void)bytes;
    (void)size;
    return 0;
}

typedef struct answers {
    norma_mesh_data data;
    norma_mesh_info info;
    norma_node_info node;
    norma_mesh_attributes attributes;
    norma_morph_data morph;
    norma_skin_info skin;
    norma_material_info material;
    norma_unread unread;
    double world[16];
    uint32_t first[3];
    int changed;
} answers;

static void test_opening(void **state) {
    norma_document *document = NULL;
    (void)state;
    refused(norma_document_open("a.obj", NULL, NULL, e), "no place for the document was given");
    refused(norma_document_open(NULL, NULL, &document, e), "no path was given");
    assert_null(document);
    refused(norma_document_open_memory("", 0, "a.obj", NULL, NULL, e),
        "no place for the document was given");
    refused(
        norma_document_open_memory(NULL, 1, "a.obj", NULL, &document, e), "no bytes were given");
    norma_document_close(NULL);
}

/* What needs a whole document, of one that is not. */
static void expect_unusable(norma_document *document, const char *text) {
    answers a;
    const norma_mesh_edit edit = {0};
    refused(norma_document_mesh_data(document, 0, &a.data, e), text);
    refused(norma_document_mesh_attributes(document, 0, &a.attributes, e), text);
    refused(norma_document_morph_data(document, 0, 0, &a.morph, e), text);
    refused(norma_document_skin_info(document, 0, &a.skin, e), text);
    refused(norma_document_compute(document, NULL, NULL, e), text);
    refused(norma_document_transform(document, NULL, NULL, e), text);
    refused(norma_document_recentre(document, NULL, &a.changed, e), text);
    refused(norma_document_edit(document, &edit, e), text);
    refused(norma_document_equal_vertices(document, 0, a.first, e), text);
    refused(norma_document_save(document, "/nowhere/a.obj", NULL, e), text);
    refused(norma_document_write(document, take, NULL, e), text);
}

static void test_no_document(void **state) {
    answers a;
    (void)state;
    expect_unusable(NULL, "no document was given");
    assert_int_equal(norma_document_format(NULL), NORMA_FILE_UNKNOWN);
    assert_true(norma_document_mesh_count(NULL) == 0 && norma_document_node_count(NULL) == 0 &&
                norma_document_material_count(NULL) == 0 && norma_document_skin_count(NULL) == 0 &&
                norma_document_unread_count(NULL) == 0 && norma_document_note_count(NULL) == 0);
    assert_string_equal(norma_document_note(NULL, 0), "");
    assert_int_equal(norma_document_mesh_info(NULL, 0, &a.info), ARGUMENT);
    assert_int_equal(norma_document_node_info(NULL, 0, &a.node), ARGUMENT);
    assert_int_equal(norma_document_material_info(NULL, 0, &a.material), ARGUMENT);
    assert_int_equal(norma_document_unread(NULL, 0, &a.unread), ARGUMENT);
    assert_string_equal(a.info.name, "");
    assert_string_equal(a.node.path, "");
    assert_string_equal(a.material.ignore, "");
    assert_string_equal(a.unread.why, "");
    refused(norma_document_instance_world(NULL, 0, 0, a.world, e),
        "there is no node 0; the document has 0, numbered from 0");
}

static void test_a_summary(void **state) {
    norma_document *document = open_with(NORMA_DOCUMENT_SUMMARY);
    (void)state;
    expect_unusable(document, "a.obj: was opened as a summary; open it whole");
    norma_document_close(document);
}

/* Refused calls, before and between changes, leave a document as it was. */
static void test_after_a_refusal(void **state) {
    static const char FACET[] = "solid a\nfacet normal 0 0 1 outer loop vertex 0 0 0 vertex 1 0 0 "
                                "vertex 0 2 0 endloop endfacet\nendsolid a\n";
    const norma_compute_options smooth = {
        .struct_size = sizeof smooth, .shading = NORMA_SHADING_SMOOTH};
    norma_transform_options scale = {.struct_size = sizeof scale, .matrix = {2}};
    norma_transform_options huge = {.struct_size = sizeof huge, .matrix = {1e308}};
    norma_document *document = NULL;
    (void)state;
    for (int i = 0; i < 16; i += 5) {
        huge.matrix[i] = i < 15 ? 1e308 : 1;
        scale.matrix[i] = i < 15 ? 2 : 1;
    }
    assert_int_equal(
        norma_document_open_memory(FACET, sizeof FACET - 1, "a.stl", NULL, &document, NULL),
        NORMA_DOCUMENT_OK);
    for (int round = 0; round < 2; ++round) {
        assert_int_equal(norma_document_compute(document, &smooth, NULL, NULL), ARGUMENT);
        assert_int_equal(norma_document_transform(document, &scale, NULL, NULL), NORMA_DOCUMENT_OK);
        assert_int_equal(norma_document_compute(document, &smooth, NULL, NULL), ARGUMENT);
        assert_int_not_equal(
            norma_document_transform(document, &huge, NULL, NULL), NORMA_DOCUMENT_OK);
    }
    document_bytes out = bytes_of(document);
    assert_non_null(strstr((const char *)out.data, "vertex 0 8 0"));
    bytes_free(&out);
    norma_document_close(document);
}

static void test_numbers_and_places(void **state) {
    answers a;
    norma_document *document = open_with(NORMA_DOCUMENT_WHOLE);
    const uint8_t mark[9] = {1};
    const norma_mesh_edit marks[] = {
        {.set_normals = mark}, {.set_positions = mark}, {.set_tangents = mark}};
    const uint32_t sources[3] = {0, 1, 2}, beyond[3] = {0, 1, 3};
    const norma_mesh_edit vertices[] = {{.source_vertices = sources, .vertex_count = 3},
        {.source_vertices = sources, .new_corners = sources},
        {.source_vertices = beyond, .new_corners = sources, .vertex_count = 3},
        {.source_vertices = sources, .new_corners = beyond, .vertex_count = 3},
        {.source_vertices = sources,
            .new_corners = sources,
            .vertex_count = 3,
            .strip_normals = NORMA_STRIP_ALL}};
    (void)state;
    refused(norma_document_mesh_data(document, 1, &a.data, e),
        "a.obj: there is no mesh 1; the document has 1, numbered from 0");
    refused(norma_document_mesh_data(document, 0, NULL, e),
        "a.obj: there is no mesh 0; the document has 1, numbered from 0");
    refused(norma_document_mesh_attributes(document, 1, &a.attributes, e),
        "a.obj: there is no mesh 1; the document has 1, numbered from 0");
    refused(norma_document_mesh_attributes(document, 0, NULL, e),
        "a.obj: no place for the attributes was given");
    refused(norma_document_morph_data(document, 0, 0, &a.morph, e),
        "a.obj: there is no morph target 0; the mesh has 0, numbered from 0");
    refused(norma_document_morph_data(document, 1, 0, &a.morph, e),
        "a.obj: there is no mesh 1; the document has 1, numbered from 0");
    refused(norma_document_morph_data(document, 0, 0, NULL, e),
        "a.obj: no place for the target's data was given");
    refused(norma_document_skin_info(document, 0, &a.skin, e),
        "a.obj: there is no skin 0; the document has 0, numbered from 0");
    refused(norma_document_instance_world(document, 0, 0, a.world, e),
        "a.obj: there is no node 0; the document has 0, numbered from 0");
    refused(norma_document_edit(document, NULL, e), "a.obj: no edits were given");
    for (size_t i = 0; i < COUNT_OF(marks); ++i)
        refused(norma_document_edit(document, &marks[i], e),
            "a.obj: marks without numbers were given for mesh 0");
    for (size_t i = 0; i < COUNT_OF(vertices); ++i)
        refused(norma_document_edit(document, &vertices[i], e),
            "a.obj: mesh 0 cannot have the vertices that were given for it");
    refused(norma_document_equal_vertices(document, 0, NULL, e),
        "a.obj: mesh 0 has no vertices that could be compared");
    refused(norma_document_equal_vertices(document, 1, a.first, e),
        "a.obj: mesh 1 has no vertices that could be compared");
    refused(norma_document_write(document, NULL, NULL, e),
        "a.obj: no function to write with was given");
    refused(norma_document_visit_files(document, NULL, NULL, e),
        "a.obj: no function that receives the files was given");
    assert_int_equal(norma_document_mesh_info(document, 0, NULL), ARGUMENT);
    assert_int_equal(norma_document_mesh_info(document, 1, &a.info), ARGUMENT);
    assert_int_equal(norma_document_node_info(document, 0, NULL), ARGUMENT);
    assert_int_equal(norma_document_node_info(document, 0, &a.node), ARGUMENT);
    assert_int_equal(norma_document_material_info(document, 0, NULL), ARGUMENT);
    assert_int_equal(norma_document_material_info(document, 0, &a.material), ARGUMENT);
    assert_int_equal(norma_document_unread(document, 0, NULL), ARGUMENT);
    assert_int_equal(norma_document_unread(document, 0, &a.unread), ARGUMENT);
    assert_string_equal(norma_document_note(document, 7), "");
    assert_int_equal(norma_document_mesh_data(document, 0, &a.data, NULL),
        NORMA_DOCUMENT_OK); /* none of it has hurt it */
    norma_document_close(document);
}

/* Bytes to nowhere, no bytes, and a device that takes none: said, and nothing is left behind. */
static void test_saving_bytes(void **state) {
    norma_document_error failed = {0};
    (void)state;
    refused(norma_save_bytes(NULL, "a", 1, e), "no path or no bytes were given");
    refused(norma_save_bytes("/nowhere/a.txt", NULL, 1, e), "no path or no bytes were given");
    norma_saving *saving;
    refused(norma_save_begin(NULL, &saving, e), "no path or no place for the result was given");
    assert_null(saving);
    refused(norma_save_begin("/nowhere/a.txt", NULL, e),
        "no path or no place for the result was given");
    refused(norma_save_piece(NULL, "a", 1, e), "no file or no bytes were given");
    refused(norma_save_end(NULL, e), "no file was given");
    refused(norma_save_end_together((norma_saving *[2]){NULL, NULL}, 2, e), "no file was given");
    refused(norma_save_end_together(NULL, 1, e), "no file was given");
    assert_int_equal(norma_save_end_together(NULL, 0, NULL), NORMA_DOCUMENT_OK);
    norma_save_abandon(NULL);
    assert_null(norma_save_temporary(NULL));
    assert_int_equal(
        norma_save_begin("/nowhere/a.txt", &saving, &failed), NORMA_DOCUMENT_ERROR_FILE);
    assert_null(saving);
    assert_string_equal(
        failed.message, "/nowhere/a.txt: cannot be written: No such file or directory");
    FILE *full = fopen("/dev/full", "wb");
    if (!full) skip();
    fclose(full);
    for (size_t size = 1; size <= 1 << 20; size <<= 20) {
        char *bytes = calloc(size, 1);
        assert_non_null(bytes);
        assert_int_equal(
            norma_save_bytes("/dev/full", bytes, size, &failed), NORMA_DOCUMENT_ERROR_FILE);
        free(bytes);
    }
    assert_string_equal(failed.message, "/dev/full: cannot be written: No space left on device");
    /* The first error stays. */
    assert_int_equal(norma_save_begin("/dev/full", &saving, &failed), NORMA_DOCUMENT_OK);
    assert_null(norma_save_temporary(saving));
    char *bytes = calloc(1 << 20, 1);
    assert_non_null(bytes);
    assert_int_equal(norma_save_piece(saving, bytes, 1 << 20, &failed), NORMA_DOCUMENT_ERROR_FILE);
    assert_int_equal(norma_save_piece(saving, bytes, 1, &failed), NORMA_DOCUMENT_ERROR_FILE);
    assert_int_equal(norma_save_end(saving, &failed), NORMA_DOCUMENT_ERROR_FILE);
    free(bytes);
    assert_string_equal(failed.message, "/dev/full: cannot be written: No space left on device");
}

/* A message has a thousand bytes: a name that fills them is cut, at a whole character. */
static void test_a_name_longer_than_a_message(void **state) {
    char name[2001];
    norma_document *document = NULL;
    norma_document_error error;
    (void)state;
    for (size_t i = 0; i < 2000; i += 2) memcpy(name + i, "\xc3\xa4", 3);
    memcpy(name, "aa", 2);
    for (size_t shift = 0; shift < 2; ++shift) {
        const norma_document_options options = {
            .struct_size = sizeof options, .format = NORMA_FILE_OBJ};
        assert_int_equal(
            norma_document_open_memory("f 1 2", 5, name + shift, &options, &document, &error),
            NORMA_DOCUMENT_ERROR_MALFORMED);
        const size_t length = strlen(error.message);
        assert_true(length >= 996 &&
                    length < 1000); /* the last character may be cut though it were whole */
        assert_memory_equal(error.message, name + shift, length);
        assert_true(
            (length - (2 - shift)) % 2 == 0); /* whole characters of two bytes behind the first */
    }
}

static void test_instances(void **state) {
    static const float positions[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    gltf_asset asset = {0};
    answers a;
    (void)state;
    asset_floats(&asset, positions, 3, 3);
    norma_document *document = asset_open(&asset,
        "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}},{\"attributes\":{"
        "\"POSITION\":0},\"mode\":1}]}],\"nodes\":[{\"mesh\":0}]",
        0);
    refused(norma_document_instance_world(document, 0, 1, a.world, e),
        "asset.glb:/nodes/0: there is no instance 1; the node has 1, numbered from 0");
    refused(norma_document_instance_world(document, 0, 0, NULL, e),
        "asset.glb: there is no node 0; the document has 1, numbered from 0");
    refused(norma_document_morph_data(document, 0, 0, &a.morph, e),
        "asset.glb: there is no morph target 0; the mesh has 0, numbered from 0");
    refused(norma_document_mesh_data(document, 1, &a.data, e),
        "asset.glb:/meshes/0/primitives/1: lines have no normals to compute");
    refused(norma_document_mesh_attributes(document, 1, &a.attributes, e),
        "asset.glb:/meshes/0/primitives/1: lines have no normals to compute");
    refused(norma_document_equal_vertices(document, 1, a.first, e),
        "asset.glb: mesh 1 has no vertices that could be compared");
    norma_document_close(document);
    asset_free(&asset);
}

/* Votes are sums, and what is no weight at all is not one. */
static void votes_need_a_sum(void **state) {
    static const int NOT_SUMMED[] = {NORMA_WEIGHT_VISIBLE, NORMA_WEIGHT_ANGLE_LENGTHS + 1, 99};
    const char *tile = "/nowhere/tile.obj";
    (void)state;
    for (size_t i = 0; i < sizeof NOT_SUMMED / sizeof *NOT_SUMMED; ++i) {
        const norma_seams_options options = {
            .struct_size = sizeof options, .weight = (norma_weight)NOT_SUMMED[i]};
        refused(norma_seams_votes(&tile, 1, "/nowhere/a.votes", &options, NULL, e),
            "the weight is not summed over faces; expected angle, area, uniform, max, angle_area "
            "or angle_lengths");
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_opening),
        cmocka_unit_test(test_no_document),
        cmocka_unit_test(test_a_summary),
        cmocka_unit_test(test_after_a_refusal),
        cmocka_unit_test(test_numbers_and_places),
        cmocka_unit_test(test_instances),
        cmocka_unit_test(test_saving_bytes),
        cmocka_unit_test(test_a_name_longer_than_a_message),
        cmocka_unit_test(votes_need_a_sum),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
