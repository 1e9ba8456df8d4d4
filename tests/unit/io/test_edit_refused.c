/* test_edit_refused.c: norma_document_edit in its rarer turns, format by format: single positions,
 * tangents of targets, and what cannot be done, which each format has to say rather than to do
 * something else. */
#include "check.h"
#include "gltf_asset.h"
#include "gltf_output.h"

static const uint8_t ALL[12] = {1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1};
static const double TRIANGLE[3][3] = {{0, 0, 0}, {2, 0, 0}, {0, 1, 0}};
static const uint32_t BACKWARDS[3] = {2, 1, 0}, CORNERS[3] = {0, 1, 2};

static document_bytes text_file(const char *text) { return bytes_copy(text, strlen(text)); }

static void assert_text(document_bytes bytes, const char *expected) {
    if (bytes.size != strlen(expected) || memcmp(bytes.data, expected, bytes.size) != 0)
        fail_msg("got\n%.*s\nexpected\n%s", (int)bytes.size, (const char *)bytes.data, expected);
}

static void expect_edit(
    const char *text, const char *name, const norma_mesh_edit *edit, const char *expected) {
    norma_document_error error;
    document_bytes in = text_file(text);
    norma_document *document = bytes_open(in, name);
    if (norma_document_edit(document, edit, &error)) fail_msg("%s", error.message);
    document_bytes out = bytes_of(document);
    assert_text(out, expected);
    norma_document_close(document);
    bytes_free(&out);
    bytes_free(&in);
}

/* message: after the file's name. What failed is taken back: it fails once more in the same way. */
static void refuse(norma_document *document, const norma_mesh_edit *edits,
    norma_document_result expected, const char *message) {
    norma_document_error error = {0};
    assert_int_equal(norma_document_edit(document, edits, &error), expected);
    if (!strstr(error.message, message))
        fail_msg("said \"%s\", expected \"%s\"", error.message, message);
    assert_int_equal(norma_document_edit(document, edits, NULL), expected);
    norma_document_close(document);
}

static void refuse_text(const char *text, const char *name, const norma_mesh_edit *edit,
    norma_document_result expected, const char *message) {
    document_bytes in = text_file(text);
    refuse(bytes_open(in, name), edit, expected, message);
    bytes_free(&in);
}

/* ---- glTF */

static const char PLAIN[] = "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}]";

static void test_gltf_positions(void **state) {
    static const double moved[3][3] = {{7, 7, 7}, {0.1, -3, 1e30}, {7, 7, 7}},
                        far[3][3] = {{0, 0, 0}, {0, 4e38, 0}, {0, 0, 0}};
    static const uint8_t second[3] = {0, 1, 0};
    const norma_mesh_edit edit = {.positions = moved[0], .set_positions = second},
                          too_far = {.positions = far[0], .set_positions = second};
    gltf_asset a = {0};
    norma_document_error error;
    (void)state;
    asset_numbers(&a, TRIANGLE[0], 3, 3, 5126, 0);
    norma_document *document = asset_open(&a, PLAIN, 0);
    if (norma_document_edit(document, &edit, &error)) fail_msg("%s", error.message);
    gltf_output b = output_of(document);
    norma_mesh_data data = output_mesh(&b, 0);
    assert_vector(&data.mesh.positions, 0, TRIANGLE[0], 0);
    assert_vector(&data.mesh.positions, 1, (const double[]){(double)0.1f, -3, (double)1e30f}, 0);
    assert_vector(&data.mesh.positions, 2, TRIANGLE[2], 0);
    assert_string_equal(output_text(&b, "accessors/0/min"),
        "[0,-3,0]"); /* glTF 2.0, 3.7.2.1: positions have bounds */
    output_free(&b);
    refuse(asset_open(&a, PLAIN, 0), &too_far, NORMA_DOCUMENT_ERROR_MALFORMED,
        "/accessors/0: expected numbers that floats can hold; found ");
    asset_free(&a);
}

/* Normals go, and with them the tangents, those of targets as well; positions stay. */
static void test_gltf_strips_targets(void **state) {
    static const float vectors[3][4] = {{0, 0, 1, 1}, {0, 0, 1, 1}, {0, 0, 1, 1}},
                       normals[3][3] = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}};
    const norma_mesh_edit edit = {.strip_normals = NORMA_STRIP_ALL};
    gltf_asset a = {0};
    norma_document_error error;
    (void)state;
    asset_numbers(&a, TRIANGLE[0], 3, 3, 5126, 0);
    asset_floats(&a, normals[0], 3, 3);
    asset_floats(&a, vectors[0], 3, 4);
    norma_document *document = asset_open(&a,
        "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"NORMAL\":1,\"TANGENT\":2},"
        "\"targets\":[{\"POSITION\":0,\"NORMAL\":1,\"TANGENT\":1},{\"TANGENT\":1}]}]}]",
        0);
    if (norma_document_edit(document, &edit, &error)) fail_msg("%s", error.message);
    gltf_output b = output_of(document);
    assert_string_equal(output_text(&b, "meshes/0/primitives/0"),
        "{\"attributes\":{\"POSITION\":0},\"targets\":[{\"POSITION\":0},{}]}");
    output_free(&b);
    asset_free(&a);
}

static void test_gltf_refuses(void **state) {
    static const float normals[2][3] = {{0, 0, 1}, {0, 0, 1}};
    static const norma_mesh_edit reversed[2] = {{.reverse_faces = ALL}, {0}};
    const norma_mesh_edit backwards = {
        .source_vertices = BACKWARDS, .vertex_count = 3, .new_corners = CORNERS};
    gltf_asset a = {0};
    (void)state;
    asset_numbers(&a, TRIANGLE[0], 3, 3, 5126, 0);
    asset_floats(&a, normals[0], 2, 3);
    refuse(asset_open(&a,
               "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"mode\":1},{"
               "\"attributes\":{\"POSITION\":0}}]}]",
               0),
        reversed, NORMA_DOCUMENT_ERROR_ARGUMENT, "lines have no normals to compute");
    refuse(asset_open(&a,
               "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"NORMAL\":1}}]}]", 1),
        &backwards, NORMA_DOCUMENT_ERROR_ARGUMENT,
        "vertices without a normal, or normals without a vertex, cannot be copied");
    const norma_mesh_edit turned = {.normals = normals[0], .set_normals = ALL},
                          moved[2] = {{.positions = TRIANGLE[0], .set_positions = ALL}, {0}};
    asset_accessor(&a,
        "{\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"}"); /* normals without bytes: read
                                                                      leniently they are none */
    refuse(asset_open(&a,
               "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"NORMAL\":2}}]}]", 1),
        &turned, NORMA_DOCUMENT_ERROR_ARGUMENT,
        "/meshes/0/primitives/0: has no NORMAL that could be replaced");
    refuse(asset_open(&a,
               "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"mode\":0},{"
               "\"attributes\":{\"POSITION\":0}}]}]",
               0),
        moved, NORMA_DOCUMENT_ERROR_ARGUMENT, "points have no normals to compute");
    asset_free(&a);
}

/* Two corners are no triangle: none runs the other way round, and four vertices made of them are
 * none either. */
static void test_gltf_without_triangles(void **state) {
    static const uint32_t sources[4] = {0, 1, 2, 0};
    const norma_mesh_edit reversed = {.reverse_faces = ALL, .drop_faces = ALL},
                          more = {.source_vertices = sources,
                              .vertex_count = 4,
                              .new_corners = CORNERS};
    gltf_asset a = {0};
    (void)state;
    asset_numbers(&a, TRIANGLE[0], 3, 3, 5126, 0);
    asset_uint16(&a, (const uint16_t[]){1, 2}, 2);
    asset_numbers(&a, TRIANGLE[0], 2, 3, 5126, 0);
    for (int indexed = 0; indexed < 2; ++indexed)
        for (int strip = 0; strip < 2; ++strip)
            for (int copies = 0; copies < 2; ++copies) {
                char rest[200];
                norma_document_error error;
                snprintf(rest, sizeof rest,
                    "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":%d},\"mode\":%d%s}]"
                    "}]",
                    indexed ? 0 : 2, 4 + strip, indexed ? ",\"indices\":1" : "");
                norma_document *document = asset_open(&a, rest, 0);
                const norma_mesh_edit fewer = {.source_vertices = (const uint32_t[]){0, 1, 1, 0},
                    .vertex_count = 4,
                    .new_corners = CORNERS};
                if (norma_document_edit(
                        document, copies ? (indexed ? &more : &fewer) : &reversed, &error))
                    fail_msg("%s", error.message);
                gltf_output b = output_of(document);
                norma_mesh_data data = output_mesh(&b, 0);
                assert_int_equal(data.mesh.corner_count, 0);
                assert_int_equal(data.mesh.positions.count, copies ? 4 : indexed ? 3 : 2);
                output_free(&b);
            }
    asset_free(&a);
}

/* ---- OBJ */

static const char OBJ[] = "v 0 0 0\nv 2 0 0\nv 0 1 0\nf 1 2 3\n";

static void test_obj(void **state) {
    const norma_mesh_edit both = {.source_vertices = BACKWARDS,
        .vertex_count = 3,
        .new_corners = CORNERS,
        .reverse_faces = ALL};
    const norma_mesh_edit backwards = {
        .source_vertices = BACKWARDS, .vertex_count = 3, .new_corners = CORNERS};
    (void)state;
    refuse_text(OBJ, "a.obj", &both, NORMA_DOCUMENT_ERROR_ARGUMENT,
        "a.obj: vertices and other things cannot change at once; change one after the other");
    refuse_text("v 0 0 0\nv 2 0 0\nv 0 1 0\ncstype bezier\ndeg 2\ncurv 0 1 1 2 3\nparm u 0 "
                "1\nend\nf 1 2 3\n",
        "a.obj", &backwards, NORMA_DOCUMENT_ERROR_UNSUPPORTED,
        "a.obj: cannot renumber vertices: free-form curves or surfaces may refer to them");
    static const float normal[3] = {0, 0, 1};
    const norma_mesh_edit numbers = {
        .normals = normal, .set_normals = ALL}; /* of the two normals here no face names one, so
                                                   that the document tells of none */
    refuse_text("v 0 0 0\nv 2 0 0\nv 0 1 0\nvn 0 0 1\nvn 0 1 0\nf 1 2 3\n", "a.obj", &numbers,
        NORMA_DOCUMENT_ERROR_ARGUMENT, "a.obj: has no normals that could be replaced");
}

/* A position that is not finite is written and read as that. */
static void test_obj_reads_what_it_wrote(void **state) {
    static const double nowhere[3][3] = {{0, 0, 0}, {(double)INFINITY, 0, 0}, {0, 0, 0}};
    static const uint8_t second[3] = {0, 1, 0};
    const norma_mesh_edit infinite = {.positions = nowhere[0], .set_positions = second};
    norma_mesh_data data;
    (void)state;
    document_bytes in = text_file(OBJ);
    norma_document *document = bytes_open(in, "a.obj");
    assert_int_equal(norma_document_edit(document, &infinite, NULL), NORMA_DOCUMENT_OK);
    assert_int_equal(norma_document_mesh_data(document, 0, &data, NULL), NORMA_DOCUMENT_OK);
    assert_true(((const double *)data.mesh.positions.data)[3] == (double)INFINITY);
    norma_document_close(document);
    bytes_free(&in);
}

/* Lines and points that name vertices get their new numbers; what is no number at all stays. */
static void test_obj_renumbers_what_refers(void **state) {
    static const uint32_t sources[3] = {1, 2, 3}, corners[3] = {0, 1, 2};
    const norma_mesh_edit edit = {
        .source_vertices = sources, .vertex_count = 3, .new_corners = corners};
    (void)state;
    expect_edit("v 9 9 9\nv 0 0 0\nv 2 0 0\nv 0 1 0\nf 2 3 4\nl 2 x 3 4\np 4 -1\n", "a.obj", &edit,
        "v 0 0 0\nv 2 0 0\nv 0 1 0\nf 1 2 3\nl 1 x 2 3\np 3 -1\n");
}

/* ---- PLY */

#define PLY_HEAD                                                                                   \
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float " \
    "z\n"
#define PLY_FACE "element face 1\nproperty list uchar int vertex_indices\n"
#define PLY_ROWS "0 0 0\n2 0 0\n2 1 0\n0 1 0\n"

static void test_ply(void **state) {
    static const uint32_t bad_triangles[12] = {0, 1, 2, 0, 2, 4}, fewer[3] = {1, 2, 3},
                          corners[4] = {0, 1, 2, 0};
    static const float normals[12] = {0};
    const norma_mesh_edit cut = {.cut_faces = ALL, .cut_corners = bad_triangles},
                          turned = {.normals = normals, .set_normals = ALL};
    const norma_mesh_edit dropped = {
        .source_vertices = fewer, .vertex_count = 3, .new_corners = corners};
    (void)state;
    refuse_text(PLY_HEAD PLY_FACE "end_header\n" PLY_ROWS "4 0 1 2 3\n", "a.ply", &cut,
        NORMA_DOCUMENT_ERROR_ARGUMENT,
        "a.ply: a triangle of face 0 was given a corner that the face does not have");
    refuse_text(PLY_HEAD PLY_FACE "end_header\n" PLY_ROWS "4 0 1 2 3\n", "a.ply", &turned,
        NORMA_DOCUMENT_ERROR_ARGUMENT, "a.ply: has no normals that could be replaced");
    refuse_text(PLY_HEAD PLY_FACE
        "element edge 1\nproperty int vertex1\nproperty int vertex2\nend_header\n" PLY_ROWS
        "4 1 2 3 1\n0 1\n",
        "a.ply", &dropped, NORMA_DOCUMENT_ERROR_UNSUPPORTED,
        "a.ply: cannot renumber vertices: an element that is not read may refer to them");
}

/* The first rows go with their line breaks: none is left before the row that then is first. */
static void test_ply_drops_first_rows(void **state) {
    static const uint8_t first[3] = {1, 0, 0};
    const norma_mesh_edit edit = {.drop_faces = first};
    (void)state;
    expect_edit(PLY_HEAD
        "element face 3\nproperty list uchar int vertex_indices\nend_header\n" PLY_ROWS
        "3 0 1 2 \t\n3 0 2 3\n3 1 2 3\n",
        "a.ply", &edit,
        PLY_HEAD "element face 2\nproperty list uchar int vertex_indices\nend_header\n" PLY_ROWS
                 "3 0 2 3\n3 1 2 3\n");
}

/* A vertex more behind a last row that has no line break: it gets one first. */
static void test_ply_adds_rows_at_the_end(void **state) {
    static const uint32_t sources[4] = {0, 1, 2, 0}, corners[3] = {3, 1, 2};
    const norma_mesh_edit edit = {
        .source_vertices = sources, .vertex_count = 4, .new_corners = corners};
    (void)state;
    expect_edit("ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int "
                "vertex_indices\nelement vertex 3\nproperty float x\nproperty float y\nproperty "
                "float z\nend_header\n3 0 1 2\n0 0 0\n2 0 0\n0 1 0",
        "a.ply", &edit,
        "ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int vertex_indices\nelement "
        "vertex 4\nproperty float x\nproperty float y\nproperty float z\nend_header\n3 3 1 2\n0 0 "
        "0\n2 0 0\n0 1 0\n0 0 0\n");
}

/* ---- STL */

static const char STL[] = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 2 0 "
                          "0\nvertex 0 1 0\nendloop\nendfacet\nendsolid a\n";

static void test_stl(void **state) {
    static const double moved[3][3] = {{0, 0, 0}, {0.1, -2.5, 3}, {0, 0, 0}};
    static const uint8_t second[3] = {0, 1, 0};
    const norma_mesh_edit edit = {.positions = moved[0], .set_positions = second},
                          both = {
                              .positions = moved[0], .set_positions = second, .reverse_faces = ALL};
    (void)state;
    expect_edit(STL, "a.stl", &edit,
        "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 0.1 -2.5 3\nvertex 0 1 "
        "0\nendloop\nendfacet\nendsolid a\n");
    refuse_text(STL, "a.stl", &both, NORMA_DOCUMENT_ERROR_ARGUMENT,
        "a.stl: facets cannot be reversed and moved at once; do one after the other");
}

/* Faces of no corner, all there are, the other way round: the same bytes. */
static void test_ply_empty_faces(void **state) {
    static const char text[] = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float "
                               "x\nproperty float y\nproperty float z\nelement face 2\nproperty "
                               "list uchar int vertex_indices\nend_header\n0 0 0\n0\n0\n";
    const norma_mesh_edit reversed = {.reverse_faces = ALL};
    (void)state;
    expect_edit(text, "a.ply", &reversed, text);
}

/* Rows of an element "face" that have no list of corners are no faces: what is done to faces leaves
 * them as they are. */
static void test_ply_rows_without_a_list(void **state) {
    static const char text[] =
        "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty "
        "float z\nelement face 4\nproperty uchar red\nend_header\n0 0 0\n1\n2\n3\n4\n";
    static const uint32_t triangles[1] = {0};
    const norma_mesh_edit edits[] = {
        {.drop_faces = ALL}, {.reverse_faces = ALL}, {.cut_faces = ALL, .cut_corners = triangles}};
    (void)state;
    for (size_t i = 0; i < COUNT_OF(edits); ++i) expect_edit(text, "a.ply", &edits[i], text);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_ply_empty_faces),
        cmocka_unit_test(test_ply_rows_without_a_list),
        cmocka_unit_test(test_gltf_positions),
        cmocka_unit_test(test_gltf_strips_targets),
        cmocka_unit_test(test_gltf_refuses),
        cmocka_unit_test(test_gltf_without_triangles),
        cmocka_unit_test(test_obj),
        cmocka_unit_test(test_obj_reads_what_it_wrote),
        cmocka_unit_test(test_obj_renumbers_what_refers),
        cmocka_unit_test(test_ply),
        cmocka_unit_test(test_ply_drops_first_rows),
        cmocka_unit_test(test_ply_adds_rows_at_the_end),
        cmocka_unit_test(test_stl),
    };
    return cmocka_run_group_tests_name("edits, rare or refused", tests, NULL, NULL);
}
