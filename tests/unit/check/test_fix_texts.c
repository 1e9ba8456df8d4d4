/* What norma check --fix-unsafe makes of files whose result is known by hand, byte for byte:
 * vertices of an OBJ, polygons of a PLY in each of its encodings, a glTF mesh that lies far from
 * its origin. */
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

static int mend(norma_document *document, const char *rules) {
    uint8_t mask[128] = {0};
    norma_fix_summary summary;
    norma_document_error error;
    assert_int_equal(norma_rules_select(rules, mask, NULL), NORMA_OK);
    const norma_check_options options = {.struct_size = sizeof options, .rules = mask};
    if (norma_fix_document(document, &options, 1, &summary, &error)) fail_msg("%s", error.message);
    return summary.changed;
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

/* Found, mended into exactly these bytes, then clean and nothing more to do. */
static void becomes(const char *name, const char *rules, const void *before, size_t before_size,
    const void *after, size_t after_size) {
    size_t size;
    norma_document *document = scene_reopen(before, before_size, name);
    assert_true(count_of(document, rules) > 0);
    assert_true(mend(document, rules));
    unsigned char *bytes = scene_output(document, &size);
    norma_document_close(document);
    if (size != after_size || memcmp(bytes, after, size) != 0)
        fail_msg("%s: %.*s\n---- instead of\n%.*s", rules, (int)size, (const char *)bytes,
            (int)after_size, (const char *)after);
    document = scene_reopen(bytes, size, name);
    assert_int_equal(count_of(document, rules), 0);
    assert_int_equal(mend(document, rules), 0);
    norma_document_close(document);
    free(bytes);
}

static void text_becomes(
    const char *name, const char *rules, const char *before, const char *after) {
    becomes(name, rules, before, strlen(before), after, strlen(after));
}

/* ---- OBJ */

/* Lines that are equal word for word become one; whatever names them, counted from the front or the
 * back, is told anew. */
static void test_obj_weld(void **state) {
    (void)state;
    text_becomes("a.obj", "N502",
        "# soup\no one\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0  0 0 # blanks tell them apart\nv 1 1 0\nv 0 "
        "1 0\nvt 0 0\nf 1/1 2 3\nf -3/1 -2//  -1\no two\nv 2 0 0\nv 3 0 0 \nv 0 1 0\nl 2 5 9 -1\nf "
        "7 8 9\n",
        "# soup\no one\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0  0 0 # blanks tell them apart\nv 0 1 0\nvt "
        "0 0\nf 1/1 2 3\nf -2/1 -3//  -1\no two\nv 2 0 0\nv 3 0 0 \nl 2 3 5 -3\nf 6 7 5\n");
    /* Vertices that differ in colour stay apart. */
    text_becomes("a.obj", "N502",
        "v 0 0 0 1 0 0\r\nv 1 0 0\r\nv 1 1 0\r\nv 0 0 0 0 1 0\r\nv 1 1 0\r\nv 0 1 0\r\nf 1 2 "
        "3\r\nf 4 5 6",
        "v 0 0 0 1 0 0\r\nv 1 0 0\r\nv 1 1 0\r\nv 0 0 0 0 1 0\r\nv 0 1 0\r\nf 1 2 3\r\nf 4 3 5");
}

static void test_obj_curves(void **state) {
    (void)state;
    static const char text[] = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 4 "
                               "5 6\ncstype bezier\ndeg 1\ncurv 0 1 1 6\nparm u 0 1\nend\n";
    norma_document *document = scene_reopen((const unsigned char *)text, strlen(text), "a.obj");
    assert_int_equal(count_of(document, "N502"), 1);
    assert_int_equal(mend(document, "N502"), 0);
    norma_document_close(document);
}

/* Two tents that meet at their tips. The new line stands before the face that names it. */
static void test_obj_split(void **state) {
    (void)state;
    text_becomes("a.obj", "N403",
        "v 0 0 0 1 .5 .5\nv 1 0 .5\nv 0 1 .5\nv -1 0 .5\nv 0 -1 .5\nv 1 0 -.5\nv 0 1 -.5\nv -1 0 "
        "-.5\nv 0 -1 -.5\nvt 0 0\nl 1 2\n"
        "f 1 7 6\nf 1 8 7\nf -9 -1 -2\nf -9/1 -4/1 -1/1\nf 1/1 2/1 3/1\nf 1 3 4\nf -9 -6 -5\nf 1 5 "
        "2\nv 7 7 7\np 1 -1 -10 10\n",
        "v 0 0 0 1 .5 .5\nv 1 0 .5\nv 0 1 .5\nv -1 0 .5\nv 0 -1 .5\nv 1 0 -.5\nv 0 1 -.5\nv -1 0 "
        "-.5\nv 0 -1 -.5\nvt 0 0\nl 1 2\n"
        "f 1 7 6\nf 1 8 7\nf -9 -1 -2\nf -9/1 -4/1 -1/1\nv 0 0 0 1 .5 .5\nf 10/1 2/1 3/1\nf 10 3 "
        "4\nf -1 -7 -6\nf 10 5 2\nv 7 7 7\np 1 -1 -11 11\n");
}

/* One normal is too long; the others keep their digits, of which a float holds fewer. */
static void test_obj_digits(void **state) {
    (void)state;
    text_becomes("a.obj", "N103",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0.577350269190 0.577350269 5.7735026919e-1\nvn 0 0 "
        "2.0\nvn -0.267261242 .534522484 0.801783726\nf 1//1 2//2 3//3\n",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0.577350269190 0.577350269 5.7735026919e-1\nvn 0 0 "
        "1\nvn -0.267261242 .534522484 0.801783726\nf 1//1 2//2 3//3\n");
}

/* A floor and a wall share one vn that is no direction: each gets its own. */
static void test_obj_torn(void **state) {
    (void)state;
    text_becomes("a.obj", "N102",
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nvn 0 0 1.000\nvn 0 0 0\n"
        "f 1//1 2//1 3//2 4//2\nf 2//2 1//2 5//2 6//2\n",
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nvn 0 0 1.000\nvn 0 0 1\nvn 0 1 0\n"
        "f 1//1 2//1 3//2 4//2\nf 2//3 1//3 5//3 6//3\n");
    /* A face without normals gets none; both sides then share one as well as they can. */
    text_becomes("a.obj", "N101",
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nvn 0 0 1\nvn nan 0 0\n"
        "f 1//1 2//1 3//2 4//2\nf 2//2 1//2 5//2 6//2\nf 4 3 6 5\n",
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nvn 0 0 1\nvn 0 0.89442718 "
        "0.44721359\n"
        "f 1//1 2//1 3//2 4//2\nf 2//2 1//2 5//2 6//2\nf 4 3 6 5\n");
}

/* ---- PLY: a concave polygon, a bent square, tuples of corners that go with them, a list that does
 * not */

enum { VERTICES = 9, FACES = 4, CUT = 7 };
static const float positions[VERTICES][3] = {{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {2, 1, 0}, {0, 4, 0},
    {6, 0, 0}, {8, 0, 0}, {8, 2, .5F}, {6, 2, 0}};
typedef struct row {
    int flag, corners[6], uvs; /* corners end in -1 */
    float uv[10];
    int red;
} row;
static const row whole[FACES] = {{7, {4, 0, 1, 2, 3, -1}, 10, {.5F, 4, 0, 0, 1, 1, 2, 2, 3, 3}, 9},
    {1, {0, 1, 4, -1}, 6, {0, 0, 1, 1, 2, 2}, 4}, {3, {5, 6, 7, 8, -1}, 3, {1, 2, 3}, 5},
    {4, {1, 2, 5, -1}, 0, {0}, 6}};
static const row cut[CUT] = {{7, {3, 4, 0, -1}, 6, {3, 3, .5F, 4, 0, 0}, 9},
    {7, {3, 0, 1, -1}, 6, {3, 3, 0, 0, 1, 1}, 9}, {7, {1, 2, 3, -1}, 6, {1, 1, 2, 2, 3, 3}, 9},
    {1, {0, 1, 4, -1}, 6, {0, 0, 1, 1, 2, 2}, 4}, {3, {8, 5, 6, -1}, 3, {1, 2, 3}, 5},
    {3, {8, 6, 7, -1}, 3, {1, 2, 3}, 5}, {4, {1, 2, 5, -1}, 0, {0}, 6}};

typedef struct ply_text {
    unsigned char bytes[2000];
    size_t size;
    int encoding; /* 0: text, 1: little endian, 2: big endian */
} ply_text;

static void add_bytes(ply_text *t, const void *bytes, size_t size) {
    assert_true(t->size + size <= sizeof t->bytes);
    for (size_t i = 0; i < size; ++i)
        t->bytes[t->size + i] = ((const unsigned char *)bytes)[t->encoding == 2 ? size - 1 - i : i];
    t->size += size;
}

static void add_words(ply_text *t, const char *words) {
    const int encoding = t->encoding;
    t->encoding = 0;
    add_bytes(t, words, strlen(words));
    t->encoding = encoding;
}

static void add_float(ply_text *t, float value, char end) {
    char word[40];
    snprintf(word, sizeof word, "%g%c", (double)value, end);
    if (t->encoding)
        add_bytes(t, &value, 4);
    else
        add_words(t, word);
}

static void add_integer(ply_text *t, int value, size_t size, char end) {
    char word[40];
    const unsigned char byte = (unsigned char)value;
    const int32_t whole_word = value;
    snprintf(word, sizeof word, "%d%c", value, end);
    if (t->encoding)
        add_bytes(t, size == 1 ? (const void *)&byte : &whole_word, size);
    else
        add_words(t, word);
}

static void add_row(ply_text *t, const row *r) {
    int count = 0;
    while (r->corners[count] >= 0) ++count;
    add_integer(t, r->flag, 1, ' ');
    add_integer(t, count, 1, ' ');
    for (int i = 0; i < count; ++i) add_integer(t, r->corners[i], 4, ' ');
    add_integer(t, r->uvs, 1, ' ');
    for (int i = 0; i < r->uvs; ++i) add_float(t, r->uv[i], ' ');
    add_integer(t, r->red, 1, '\n');
}

static void make_ply(ply_text *t, int encoding, const row *rows, int count) {
    static const char *const names[] = {"ascii", "binary_little_endian", "binary_big_endian"};
    char head[500];
    t->size = 0;
    t->encoding = encoding;
    snprintf(head, sizeof head,
        "ply\nformat %s 1.0\ncomment kept\nelement vertex 9\nproperty float x\nproperty float "
        "y\nproperty float z\nelement face %d\nproperty uchar flag\n"
        "property list uchar int vertex_indices\nproperty list uchar float texcoord\nproperty "
        "uchar red\nelement other 1\nproperty int n\nend_header\n",
        names[encoding], count);
    add_words(t, head);
    for (int v = 0; v < VERTICES; ++v)
        for (int k = 0; k < 3; ++k) add_float(t, positions[v][k], k < 2 ? ' ' : '\n');
    for (int i = 0; i < count; ++i) add_row(t, &rows[i]);
    add_integer(t, 77, 4, '\n');
}

static void test_ply_cut(void **state) {
    (void)state;
    static ply_text before, after;
    for (int encoding = 0; encoding < 3; ++encoding) {
        make_ply(&before, encoding, whole, FACES);
        make_ply(&after, encoding, cut, CUT);
        becomes("a.ply", "N404,N405", before.bytes, before.size, after.bytes, after.size);
    }
}

/* A strip without the triangle that has no height begins anew behind it; a face goes with it. */
static void test_ply_strips(void **state) {
    (void)state;
    static const char head[] =
        "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\nproperty "
        "float z\nelement face %d\nproperty list uchar int vertex_indices\n"
        "element tristrips 2\nproperty list int int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 "
        "0\n3 3 0\n3 3 0\n0 5 1\n%s";
    char before[500], after[500];
    snprintf(before, sizeof before, head, 2, "3 0 2 1\n3 0 3 4\n6 0 1 2 -1 0 5\n7 5 0 4 3 0 2 1\n");
    snprintf(after, sizeof after, head, 1, "3 0 2 1\n6 0 1 2 -1 0 5\n8 5 0 4 -1 3 2 0 1\n");
    text_becomes("a.ply", "N401", before, after);
}

/* ---- glTF: a grid far away, under a node that is turned, scaled and has a child; drawn twice */

enum { SIDE = 6, GRID = SIDE * SIDE };
static const float FAR_AWAY = 4500000;

static norma_document *open_far(gltf_asset *a, const char *node) {
    static const char frame[] =
        "\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"name\":\"a\",\"mesh\":0,"
        "\"translation\":[1,2,3],\"rotation\":[0,0.6,0,0.8],\"scale\":[1,2,1],"
        "\"children\":[1]%s},{\"mesh\":0,\"translation\":[0,5,0]}],\"meshes\":[{\"primitives\":[{"
        "\"attributes\":{\"POSITION\":0},\"indices\":2},"
        "{\"attributes\":{\"POSITION\":1},\"indices\":2}]}],\"skins\":[{\"joints\":[1]}]";
    float first[GRID][3], second[GRID][3];
    uint16_t corners[6 * (SIDE - 1) * (SIDE - 1)];
    size_t count = 0;
    char rest[1000];
    for (int i = 0; i < GRID; ++i) {
        const float near[3] = {
            (float)(i % SIDE) / 2, (float)(i / SIDE) / 2, (float)((i * 7) % 5) / 32};
        for (int k = 0; k < 3; ++k) first[i][k] = second[i][k] = near[k];
        first[i][0] += FAR_AWAY;
        second[i][0] += FAR_AWAY + 2.5F;
    }
    for (int y = 0; y + 1 < SIDE; ++y)
        for (int x = 0; x + 1 < SIDE; ++x) {
            const int at = y * SIDE + x,
                      quad[6] = {at, at + 1, at + SIDE + 1, at, at + SIDE + 1, at + SIDE};
            for (int k = 0; k < 6; ++k) corners[count++] = (uint16_t)quad[k];
        }
    asset_floats(a, &first[0][0], GRID, 3);
    asset_floats(a, &second[0][0], GRID, 3);
    asset_uint16(a, corners, count);
    snprintf(rest, sizeof rest, frame, node);
    return asset_open(a, rest, 1);
}

static void test_gltf_recentre(void **state) {
    (void)state;
    gltf_asset a = {0};
    drawn_scene before = {0}, after = {0};
    size_t size;
    norma_document *document = open_far(&a, "");
    scene_read(document, &before);
    assert_int_equal(count_of(document, "N701"), 2);
    assert_int_equal(mend(document, "N701"), 1);
    unsigned char *bytes = scene_output(document, &size);
    norma_document_close(document);
    document = scene_reopen(bytes, size, "a.glb");
    assert_int_equal(count_of(document, "N701"), 0);
    assert_int_equal(mend(document, "N701"), 0);
    for (size_t mesh = 0; mesh < 2; ++mesh) { /* exactly what it was, but for the step */
        norma_mesh_data data;
        assert_int_equal(norma_document_mesh_data(document, mesh, &data, NULL), NORMA_DOCUMENT_OK);
        const float *p = data.mesh.positions.data;
        const float step = FAR_AWAY + (mesh == 1 ? 2.5F : 0) - p[0];
        for (int i = 0; i < GRID; ++i) {
            assert_true(
                p[3 * i] + step == FAR_AWAY + (float)(i % SIDE) / 2 + (mesh == 1 ? 2.5F : 0));
            assert_true(
                p[3 * i + 1] == (float)(i / SIDE) / 2 && p[3 * i + 2] == (float)((i * 7) % 5) / 32);
        }
    }
    scene_read(document, &after);
    assert_int_equal(before.count, after.count);
    for (size_t i = 0; i < before.count; ++i)
        for (int corner = 0; corner < 3; ++corner)
            for (int k = 0; k < 3; ++k)
                assert_true(fabs(before.triangles[i].position[corner][k] -
                                 after.triangles[i].position[corner][k]) < 1e-7);
    scene_free(&before);
    scene_free(&after);
    norma_document_close(document);
    free(bytes);
    asset_free(&a);
}

/* What else hangs on the node that draws it. */
static void test_gltf_stays(void **state) {
    (void)state;
    static const char *const nodes[] = {",\"skin\":0",
        ",\"extensions\":{\"EXT_mesh_gpu_instancing\":{\"attributes\":{\"TRANSLATION\":1}}}"};
    for (size_t i = 0; i < sizeof nodes / sizeof *nodes; ++i) {
        gltf_asset a = {0};
        int changed = 1;
        norma_document *document = open_far(&a, nodes[i]);
        const size_t notes = norma_document_note_count(document);
        assert_int_equal(
            norma_document_recentre(document, NULL, &changed, NULL), NORMA_DOCUMENT_OK);
        assert_int_equal(changed, 0);
        assert_int_equal(norma_document_note_count(document), notes + 1);
        norma_document_close(document);
        asset_free(&a);
    }
}

/* Steps are taken only along axes that are far, and have few digits. */
static void test_texts_recentre(void **state) {
    (void)state;
    text_becomes("a.obj", "N701", "v 4500000 0 0\nv 4500000.5 0 0\nv 4500000 .5 0\nf 1 2 3\n",
        "v 0 0 0\nv 0.5 0 0\nv 0 .5 0\nf 1 2 3\n");
    text_becomes("a.obj", "N701",
        "v 450000 -300000 7\nv 450000.0625 -300000 7\nv 450000 -300000.03125 7\nf 1 2 3\n",
        "v 0 0 0\nv 0.0625 0 0\nv 0 -0.03125 0\nf 1 2 3\n");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_obj_weld),
        cmocka_unit_test(test_obj_curves),
        cmocka_unit_test(test_obj_split),
        cmocka_unit_test(test_obj_digits),
        cmocka_unit_test(test_obj_torn),
        cmocka_unit_test(test_ply_cut),
        cmocka_unit_test(test_ply_strips),
        cmocka_unit_test(test_gltf_recentre),
        cmocka_unit_test(test_gltf_stays),
        cmocka_unit_test(test_texts_recentre),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
