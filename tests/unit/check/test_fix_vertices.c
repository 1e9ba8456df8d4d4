/* What norma check --fix-unsafe makes of vertices: a soup's become one where they are equal in
 * everything, and only there; one whose faces cancel is split by its fans. Known by hand. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>
#include <norma/check.h>
#include "gltf_asset.h"
#include "gltf_scene.h"

/* ---- mending until nothing is left to mend */

static size_t mend(norma_document *document, const char *rules) {
    uint8_t mask[128] = {0};
    norma_fix_summary summary;
    norma_document_error error;
    assert_int_equal(norma_rules_select(rules, mask, NULL), NORMA_OK);
    const norma_check_options options = {.struct_size = sizeof options, .rules = mask};
    if (norma_fix_document(document, &options, 1, &summary, &error)) fail_msg("%s", error.message);
    return (size_t)summary.changed;
}

/* The document is closed; what it became lives in *bytes. A second time changes nothing. */
static norma_document *mended(
    norma_document *document, const char *rules, unsigned char **bytes, int changes) {
    size_t size;
    assert_int_equal(mend(document, rules), changes);
    *bytes = scene_output(document, &size);
    norma_document_close(document);
    document = scene_reopen(*bytes, size, "mended.glb");
    assert_int_equal(mend(document, rules), 0);
    return document;
}

static size_t count_of(norma_document *document, const char *rules) {
    uint8_t mask[128] = {0};
    norma_findings *findings;
    size_t count = 0;
    assert_int_equal(norma_rules_select(rules, mask, NULL), NORMA_OK);
    const norma_check_options options = {.struct_size = sizeof options, .rules = mask};
    assert_int_equal(norma_check_document(document, &options, &findings, NULL), NORMA_DOCUMENT_OK);
    for (size_t i = 0; i < norma_findings_count(findings); ++i)
        count += norma_findings_get(findings, i)->count;
    norma_findings_free(findings);
    return count;
}

static norma_mesh_data data_of(norma_document *document, size_t mesh) {
    norma_mesh_data data;
    assert_int_equal(norma_document_mesh_data(document, mesh, &data, NULL), NORMA_DOCUMENT_OK);
    return data;
}

static uint32_t corner_of(const norma_mesh_data *data, size_t corner) {
    return data->mesh.corners ? ((const uint32_t *)data->mesh.corners)[corner] : (uint32_t)corner;
}

/* ---- weld: a square of two triangles, six vertices */

enum { SOUP = 6 };
static const float soup[SOUP][3] = {
    {0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 0, 0}, {1, 1, 0}, {0, 1, 0}};
static const float folded[SOUP][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 0, 0}, {1, 1, 0},
    {1, 0, 0}}; /* the second lies on the back of the first */

typedef struct soup_case {
    const char *mesh;       /* its attributes and targets */
    uint32_t corners[SOUP]; /* as they are to be */
    size_t vertices;
} soup_case;

/* Accessors: 0 POSITION, 1 something that differs at vertex 4, 2 normals, 3 the folded POSITION. */
static norma_document *open_soup(gltf_asset *a, const char *rest) {
    static const float moved[SOUP][3] = {[4] = {0.25F, 0, 0}};
    float normals[SOUP][3] = {{0}};
    for (int v = 0; v < SOUP; ++v) normals[v][2] = 1;
    asset_floats(a, &soup[0][0], SOUP, 3);
    asset_floats(a, &moved[0][0], SOUP, 3);
    asset_floats(a, &normals[0][0], SOUP, 3);
    asset_floats(a, &folded[0][0], SOUP, 3);
    return asset_open(a, rest, 1);
}

static void weld(const soup_case *c) {
    gltf_asset a = {0};
    unsigned char *bytes;
    char rest[500];
    snprintf(rest, sizeof rest, "\"meshes\":[{\"primitives\":[{%s}]}]", c->mesh);
    norma_document *document = open_soup(&a, rest);
    assert_int_equal(count_of(document, "N502"), 1);
    document = mended(document, "N502", &bytes, c->vertices < SOUP);
    norma_mesh_data data = data_of(document, 0);
    assert_int_equal(data.mesh.positions.count, c->vertices);
    assert_int_equal(data.mesh.corner_count, SOUP);
    for (size_t i = 0; i < SOUP; ++i) {
        assert_int_equal(corner_of(&data, i), c->corners[i]);
        if (!strstr(c->mesh, "\"POSITION\":3"))
            assert_memory_equal((const float *)data.mesh.positions.data + 3 * c->corners[i],
                soup[i], sizeof soup[i]);
    }
    norma_document_close(document);
    free(bytes);
    asset_free(&a);
}

static void test_weld(void **state) {
    (void)state;
    static const soup_case cases[] = {
        {"\"attributes\":{\"POSITION\":0,\"NORMAL\":2}", {0, 1, 2, 0, 2, 3}, 4},
        {"\"attributes\":{\"POSITION\":0}", {0, 1, 2, 0, 2, 3}, 4},
        {"\"attributes\":{\"POSITION\":0,\"_OTHER\":1}", {0, 1, 2, 0, 3, 4}, 5},
        {"\"attributes\":{\"POSITION\":0,\"NORMAL\":2},\"targets\":[{\"POSITION\":1}]",
            {0, 1, 2, 0, 3, 4}, 5},
        /* an extension that may name vertices */
        {"\"attributes\":{\"POSITION\":0,\"NORMAL\":2},\"extensions\":{\"X_outline\":{\"indices\":"
         "1}}",
            {0, 1, 2, 3, 4, 5}, 6},
        /* where both sides would share vertices there would be no direction left (N403) */
        {"\"attributes\":{\"POSITION\":3}", {0, 1, 2, 3, 4, 5}, 6},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) weld(&cases[i]);
}

/* Two primitives of one accessor of positions: each has its own vertices then, and the one that is
 * no soup keeps what it had. */
static void test_shared(void **state) {
    (void)state;
    gltf_asset a = {0};
    unsigned char *bytes;
    const uint16_t corners[3] = {5, 4, 1};
    static const uint32_t welded[SOUP] = {0, 1, 2, 0, 2, 3};
    norma_document_close(open_soup(&a, "\"meshes\":[]"));
    asset_uint16(&a, corners, 3);
    norma_document *document = asset_open(&a,
        "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}},{\"attributes\":{"
        "\"POSITION\":0},\"indices\":4}]}]",
        1);
    document = mended(document, "N502", &bytes, 1);
    norma_mesh_data first = data_of(document, 0), second = data_of(document, 1);
    assert_int_equal(first.mesh.positions.count, 4);
    for (size_t i = 0; i < SOUP; ++i) assert_int_equal(corner_of(&first, i), welded[i]);
    assert_int_equal(second.mesh.positions.count, SOUP);
    assert_memory_equal(second.mesh.positions.data, soup, sizeof soup);
    for (size_t i = 0; i < 3; ++i) assert_int_equal(corner_of(&second, i), corners[i]);
    norma_document_close(document);
    free(bytes);
    asset_free(&a);
}

/* ---- split: two tents, one upside down, that meet at their tips, and a square beside them */

enum { TENTS = 13 };
static const float tents[TENTS][3] = {{0, 0, 0}, {1, 0, 0.5F}, {0, 1, 0.5F}, {-1, 0, 0.5F},
    {0, -1, 0.5F}, {1, 0, -0.5F}, {0, 1, -0.5F}, {-1, 0, -0.5F}, {0, -1, -0.5F}, {5, 0, 0},
    {6, 0, 0}, {6, 1, 0}, {5, 1, 0}};
static const uint16_t tent_corners[30] = {
    0, 1, 2, 0, 2, 3, 0, 3, 4, 0, 4, 1, 0, 6, 5, 0, 7, 6, 0, 8, 7, 0, 5, 8, 9, 10, 11, 9, 11, 12};

/* The first normal is of neither fan, and its tangent lies along both; the first morphs. */
static void split(const char *attributes, int tangents) {
    gltf_asset a = {0};
    unsigned char *bytes;
    float normals[TENTS][3] = {{1, 0, 0}}, directions[TENTS][4] = {{0, 0, 1, -1}},
          moves[TENTS][3] = {{0.5F, 0, 0}};
    char rest[500];
    for (int v = 1; v < TENTS; ++v) {
        float side = v < 5   ? 1.0F
                     : v < 9 ? -1.0F
                             : 0; /* inwards and up above, inwards and down below */
        double x = v < 9 ? -0.5 * (double)tents[v][0] : 0,
               y = v < 9 ? -0.5 * (double)tents[v][1] : 0, z = v < 9 ? (double)side : 1,
               length = sqrt(x * x + y * y + z * z);
        normals[v][0] = (float)(x / length), normals[v][1] = (float)(y / length),
        normals[v][2] = (float)(z / length);
        directions[v][fabs(x) > 0 ? 1 : 0] = directions[v][3] = 1;
    }
    asset_floats(&a, &tents[0][0], TENTS, 3);
    asset_floats(&a, &normals[0][0], TENTS, 3);
    asset_floats(&a, &directions[0][0], TENTS, 4);
    asset_floats(&a, &moves[0][0], TENTS, 3);
    asset_uint16(&a, tent_corners, 30);
    snprintf(rest, sizeof rest,
        "\"meshes\":[{\"primitives\":[{\"attributes\":{%s},\"indices\":4,\"targets\":[{"
        "\"POSITION\":3}]}]}]",
        attributes);
    norma_document *document = asset_open(&a, rest, 1);
    assert_int_equal(count_of(document, "N403"), 1);
    document = mended(document, "N403", &bytes, 1);
    assert_int_equal(count_of(document, "N403"), 0);
    norma_mesh_data data = data_of(document, 0);
    norma_morph_data morph;
    norma_mesh_attributes extra;
    assert_int_equal(data.mesh.positions.count, TENTS + 1);
    assert_memory_equal(data.mesh.positions.data, tents, sizeof tents);
    assert_memory_equal(
        (const float *)data.mesh.positions.data + 3 * TENTS, tents[0], sizeof tents[0]);
    uint32_t above = corner_of(&data, 0), below = corner_of(&data, 12);
    assert_true(above + below == TENTS && (above == 0 || below == 0));
    for (size_t c = 0; c < 30; ++c)
        assert_int_equal(corner_of(&data, c), tent_corners[c] != 0 ? tent_corners[c]
                                              : c < 12             ? above
                                                                   : below);
    assert_int_equal(norma_document_morph_data(document, 0, 0, &morph, NULL), NORMA_DOCUMENT_OK);
    assert_memory_equal(morph.positions.data, moves, sizeof moves);
    assert_memory_equal((const float *)morph.positions.data + 3 * TENTS, moves[0], sizeof moves[0]);
    assert_int_equal(data.normals.count, strstr(attributes, "NORMAL") ? TENTS + 1 : 0);
    for (size_t v = 0; v < data.normals.count; ++v) {
        const float *n = (const float *)data.normals.data + 3 * v;
        if (v == 0 || v == TENTS)
            assert_true(fabs((double)n[0]) < 1e-6 && fabs((double)n[1]) < 1e-6 &&
                        n[2] == (v == above ? 1.0F : -1.0F));
        else
            assert_memory_equal(n, normals[v], sizeof normals[v]);
    }
    assert_int_equal(norma_document_mesh_attributes(document, 0, &extra, NULL), NORMA_DOCUMENT_OK);
    assert_int_equal(extra.tangent_count, tangents ? TENTS + 1 : 0);
    for (size_t v = 0; v < extra.tangent_count; ++v) {
        const float *t = extra.tangents + 4 * v;
        if (v == 0 || v == TENTS) /* its old one lay along the new normals: any across them, the
                                     sign as it was */
            assert_true(fabs((double)t[2]) < 1e-6 &&
                        fabs(hypot((double)t[0], (double)t[1]) - 1) < 1e-6 && t[3] == -1);
        else
            assert_memory_equal(t, directions[v], sizeof directions[v]);
    }
    norma_document_close(document);
    free(bytes);
    asset_free(&a);
}

static void test_split(void **state) {
    (void)state;
    split("\"POSITION\":0,\"NORMAL\":1,\"TANGENT\":2", 1);
    split("\"POSITION\":0,\"NORMAL\":1", 0);
    split("\"POSITION\":0", 0);
}

/* Both at once until nothing changes, without going back and forth: a triangle and its back. */
static void test_both(void **state) {
    (void)state;
    gltf_asset a = {0};
    unsigned char *bytes;
    const uint16_t corners[SOUP] = {0, 1, 2, 0, 2, 1};
    asset_floats(&a, &soup[0][0], 3, 3);
    asset_uint16(&a, corners, SOUP);
    norma_document *document = asset_open(
        &a, "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1}]}]", 1);
    assert_int_equal(count_of(document, "N403"), 3);
    document = mended(document, "N403,N502", &bytes, 1);
    assert_int_equal(count_of(document, "N403"), 0);
    assert_int_equal(data_of(document, 0).mesh.positions.count, SOUP);
    norma_document_close(document);
    free(bytes);
    asset_free(&a);
}

/* ---- PLY */

static norma_document *open_ply(const void *bytes, size_t size) {
    return scene_reopen(bytes, size, "mended.ply");
}

static norma_document *mended_ply(
    const char *text, const char *rules, unsigned char **bytes, size_t *size) {
    norma_document *document = open_ply(text, strlen(text));
    assert_true(mend(document, rules));
    *bytes = scene_output(document, size);
    norma_document_close(document);
    document = open_ply(*bytes, *size);
    assert_int_equal(mend(document, rules), 0);
    return document;
}

static void test_ply_weld(void **state) {
    (void)state;
    static const char
        head[] = "ply\nformat ascii 1.0\ncomment kept\nelement vertex ",
        kind[] = "\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\n",
        rows[] = "end_header\n0 0 0 7\n1 0 0 7\n1 1 0 7\n",
        faces[] = "element face 2\nproperty list uchar int vertex_indices\nproperty list uchar "
                  "float texcoord\n";
    char text[1000], wanted[1000];
    unsigned char *bytes;
    size_t size;
    snprintf(text, sizeof text,
        "%s6%s%s%s0 0 0 7\n1 1 0 8\n0 1 0 7\n3 0 1 2 6 0 0 1 0 1 1\n3 3 4 5 6 0 0 1 1 .5 1\n", head,
        kind, faces, rows);
    snprintf(wanted, sizeof wanted,
        "%s5%s%s%s1 1 0 8\n0 1 0 7\n3 0 1 2 6 0 0 1 0 1 1\n3 0 3 4 6 0 0 1 1 .5 1\n", head, kind,
        faces, rows);
    norma_document_close(mended_ply(text, "N502", &bytes, &size));
    assert_int_equal(size, strlen(wanted));
    assert_memory_equal(bytes, wanted, size);
    free(bytes);
    /* edges name vertices by their numbers */
    snprintf(text, sizeof text,
        "%s6%s%selement edge 1\nproperty int vertex1\nproperty int vertex2\n%s0 0 0 7\n1 1 0 7\n0 "
        "1 0 7\n3 0 1 2 0\n3 3 4 5 0\n0 5\n",
        head, kind, faces, rows);
    norma_document *document = open_ply(text, strlen(text));
    assert_int_equal(mend(document, "N502"), 0);
    norma_document_close(document);
}

static void test_ply_split(void **state) {
    (void)state;
    char text[2000];
    unsigned char *bytes;
    size_t size, at = (size_t)snprintf(text, sizeof text,
                     "ply\nformat ascii 1.0\nelement vertex 9\nproperty float x\nproperty float "
                     "y\nproperty float z\nproperty float nx\n"
                     "property float ny\nproperty float nz\nproperty uchar red\nelement face "
                     "8\nproperty list uchar int vertex_indices\nend_header\n");
    for (int v = 0; v < 9; ++v) /* of the others the normals stay, whatever they are */
        at += (size_t)snprintf(text + at, sizeof text - at, "%g %g %g %s %d\n", (double)tents[v][0],
            (double)tents[v][1], (double)tents[v][2],
            v == 0  ? "1 0 0"
            : v < 5 ? "0 0 1"
                    : "0 0 -1",
            v);
    for (int f = 0; f < 8; ++f)
        at += (size_t)snprintf(text + at, sizeof text - at, "3 %d %d %d\n", tent_corners[3 * f],
            tent_corners[3 * f + 1], tent_corners[3 * f + 2]);
    norma_document *document = mended_ply(text, "N403", &bytes, &size);
    norma_mesh_data data = data_of(document, 0);
    norma_mesh_attributes extra;
    assert_int_equal(norma_document_mesh_attributes(document, 0, &extra, NULL), NORMA_DOCUMENT_OK);
    assert_int_equal(data.mesh.positions.count, 10);
    uint32_t above = corner_of(&data, 0), below = corner_of(&data, 12);
    assert_true(above + below == 9 && (above == 0 || below == 0));
    for (size_t c = 0; c < 24; ++c)
        assert_int_equal(corner_of(&data, c), tent_corners[c] != 0 ? tent_corners[c]
                                              : c < 12             ? above
                                                                   : below);
    for (size_t v = 0; v < 10; ++v) {
        const float *n = (const float *)data.normals.data + 3 * v;
        assert_true(fabs((double)n[0]) < 1e-6 && fabs((double)n[1]) < 1e-6 &&
                    n[2] == (v == above || (v > 0 && v < 5) ? 1.0F : -1.0F));
    }
    norma_document_close(document);
    free(bytes);
}

/* Normals are made, and then a mesh is asked which of its vertices are equal: what was read before
 * the question is still used after it. */
static void test_obj_weld_after_normals(void **state) {
    (void)state;
    static const char text[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 0\nv 0 1 0\nv 0 0 1\nv 0 0 0\n"
                               "v 0 0 0\nv 1 0 0\nf 1 2 3\nf 4 5 6\nf 7 8 9\n";
    norma_document *document =
        scene_reopen((const unsigned char *)text, sizeof text - 1, "mended.obj");
    assert_int_equal(mend(document, "N1,N2,N3,N4,N5,N6,N7,N8,N9"), 1);
    const norma_mesh_data data = data_of(document, 0);
    assert_int_equal(data.mesh.positions.count, 4); /* of nine lines; four are different */
    assert_int_equal(count_of(document, "N104,N502"), 0);
    norma_document_close(document);
}

/* ---- what makes no sense is refused before anything is changed */

static void test_refused(void **state) {
    (void)state;
    gltf_asset a = {0};
    norma_document *document =
        open_soup(&a, "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}]");
    const uint32_t sources[3] = {0, 1, SOUP}, corners[SOUP] = {0, 1, 2, 0, 1, 3};
    const norma_mesh_edit bad[] = {
        {.source_vertices = sources, .vertex_count = 3, .new_corners = corners},
        {.source_vertices = sources, .vertex_count = 2},
        {.source_vertices = sources, .new_corners = corners},
        {.source_vertices = sources, .vertex_count = 2, .new_corners = corners}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; ++i)
        assert_int_equal(
            norma_document_edit(document, &bad[i], NULL), NORMA_DOCUMENT_ERROR_ARGUMENT);
    const uint32_t wide[SOUP] = {0, 1, 2, 3, 4, 5};
    const norma_mesh_edit good = {
        .source_vertices = wide, .vertex_count = SOUP, .new_corners = corners};
    assert_int_equal(norma_document_edit(document, &good, NULL), NORMA_DOCUMENT_OK);
    norma_document_close(document);
    asset_free(&a);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_weld),
        cmocka_unit_test(test_shared),
        cmocka_unit_test(test_split),
        cmocka_unit_test(test_both),
        cmocka_unit_test(test_ply_weld),
        cmocka_unit_test(test_ply_split),
        cmocka_unit_test(test_obj_weld_after_normals),
        cmocka_unit_test(test_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
