/* Where normals and winding disagree, or neighbours do, fixes change what is shown to be wrong, by
 * volume or by rays, and leave the rest. What is right is known from how the boxes were built. */
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

enum { SIDES = 6, LID = 1 };

/* A unit cube with a vn for each side; side 1 is its lid. turned: of each side whether its face is
 * wound inward; normals: 1 outward, -1 inward. */
static norma_document *open_box(char text[1500], int sides, const char *turned, int normals) {
    static const int quads[SIDES][4] = {
        {1, 4, 3, 2}, {5, 6, 7, 8}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 4, 8, 7}, {4, 1, 5, 8}};
    static const int outward[SIDES][3] = {
        {0, 0, -1}, {0, 0, 1}, {0, -1, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}};
    size_t used = (size_t)snprintf(
        text, 1500, "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n");
    for (int i = 0; i < SIDES; ++i) {
        const int sign = i == LID && sides < SIDES ? 1 : normals; /* nothing uses it */
        used += (size_t)snprintf(text + used, 1500 - used, "vn %d %d %d\n", sign * outward[i][0],
            sign * outward[i][1], sign * outward[i][2]);
    }
    for (int i = 0; i < SIDES; ++i) {
        if (i == LID && sides < SIDES) continue;
        used += (size_t)snprintf(text + used, 1500 - used, "f");
        for (int k = 0; k < 4; ++k)
            used += (size_t)snprintf(text + used, 1500 - used, " %d//%d",
                quads[i][turned[i] == 't' ? (4 - k) % 4 : k], i + 1);
        used += (size_t)snprintf(text + used, 1500 - used, "\n");
    }
    return scene_reopen((const unsigned char *)text, used, "a.obj");
}

static int fix(norma_document *document, const char *rules) {
    uint8_t mask[128] = {0};
    norma_fix_summary summary;
    norma_document_error error;
    assert_int_equal(norma_rules_select(rules, mask, NULL), NORMA_OK);
    const norma_check_options options = {.struct_size = sizeof options, .rules = mask};
    if (norma_fix_document(document, &options, 1, &summary, &error)) fail_msg("%s", error.message);
    return summary.changed;
}

/* Into the box that was asked for, and a second time nothing. */
static void becomes(
    norma_document *document, const char *rules, int sides, const char *turned, int normals) {
    char text[1500];
    size_t size, wanted_size;
    fix(document, rules);
    assert_int_equal(fix(document, rules), 0);
    norma_document *box = open_box(text, sides, turned, normals);
    unsigned char *bytes = scene_output(document, &size), *wanted = scene_output(box, &wanted_size);
    if (size != wanted_size || memcmp(bytes, wanted, size) != 0)
        fail_msg("%s: %.*s\n---- instead of\n%s", rules, (int)size, (const char *)bytes, text);
    free(bytes);
    free(wanted);
    norma_document_close(box);
    norma_document_close(document);
}

static int says_undecided(const norma_document *document) {
    for (size_t i = 0; i < norma_document_note_count(document); ++i)
        if (strstr(norma_document_note(document, i), "neither volume nor rays")) return 1;
    return 0;
}

/* What is closed shows by its volume which of both is wrong; what is open, by rays. */
static void what_is_wrong_is_turned(void **state) {
    (void)state;
    char text[1500];
    for (int sides = SIDES - 1; sides <= SIDES; ++sides) {
        becomes(open_box(text, sides, "tttttt", 1), "N201", sides, "......", 1);
        becomes(open_box(text, sides, "......", -1), "N201,N206", sides, "......", 1);
        becomes(open_box(text, sides, "tttttt", 1), "N201,N302", sides, "......", 1);
        becomes(open_box(text, sides, "......", 1), "N201,N301,N302", sides, "......", 1);
    }
}

/* Most of its faces are turned, and it is they that are turned back. */
static void most_faces_may_be_wrong(void **state) {
    (void)state;
    char text[1500];
    for (int sides = SIDES - 1; sides <= SIDES; ++sides) {
        becomes(open_box(text, sides, "tt.ttt", 1), "N301", sides, "......", 1);
        becomes(open_box(text, sides, "..t...", 1), "N301", sides, "......", 1);
        becomes(open_box(text, sides, "tt.ttt", 1), "N201,N301", sides, "......", 1);
    }
}

/* ---- what nothing decides stays, and the reason is given */

static void stays(const char *text, const char *rules) {
    size_t size;
    norma_document *document = scene_of_obj(text);
    assert_int_equal(fix(document, rules), 0);
    assert_true(says_undecided(document));
    unsigned char *bytes = scene_output(document, &size);
    assert_int_equal(size, strlen(text));
    assert_memory_equal(bytes, text, size);
    free(bytes);
    norma_document_close(document);
}

static void what_is_undecided_stays(void **state) {
    (void)state;
    stays("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvn 0 0 -1\nf 1//1 2//1 3//1 4//1\n", "N201");
    stays("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nv 2 1 0\nf 1 2 3 4\nf 2 3 6 5\n", "N301");
}

/* ---- glTF: a tray whose normals look inward; of a material that is seen from both sides rays say
 * nothing */

/* A box over a wide open bowl, whose rim is above its floor, so that the bowl winds round that by
 * more than one half, as if the box were a hole in it: but rays from its lid, which alone is wound
 * outward, leave. */
#define BOX_OVER_BOWL(faces)                                                                       \
    "v -.5 -.5 0\nv .5 -.5 0\nv .5 .5 0\nv -.5 .5 0\nv -.5 -.5 .5\nv .5 -.5 .5\nv .5 .5 .5\n"      \
    "v -.5 .5 .5\nv -8 -8 .6\nv 8 -8 .6\nv 8 8 .6\nv -8 8 .6\nv 0 0 -1\n" faces                    \
    "f 9 13 10\nf 10 13 11\nf 11 13 12\nf 12 13 9\n"

static void what_rays_call_right_stays(void **state) {
    (void)state;
    static const char before[] =
        BOX_OVER_BOWL("f 1 2 3 4\nf 5 6 7 8\nf 5 6 2 1\nf 6 7 3 2\nf 7 8 4 3\nf 8 5 1 4\n"),
                      after[] = BOX_OVER_BOWL(
                          "f 1 4 3 2\nf 5 6 7 8\nf 5 1 2 6\nf 6 2 3 7\nf 7 3 4 8\nf 8 4 1 5\n");
    size_t size;
    norma_document *document = scene_of_obj(before);
    assert_int_equal(fix(document, "N301"), 1);
    unsigned char *bytes = scene_output(document, &size);
    assert_int_equal(size, strlen(after));
    assert_memory_equal(bytes, after, size);
    free(bytes);
    norma_document_close(document);
}

static void a_double_sided_material_stays(void **state) {
    (void)state;
    static const float corners[8][3] = {
        {0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
    static const int quads[5][4] = {
        {0, 3, 2, 1}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
    static const float inward[5][3] = {{0, 0, 1}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}, {1, 0, 0}};
    float positions[20][3], normals[20][3];
    uint16_t indices[30];
    for (int q = 0; q < 5; ++q)
        for (int k = 0; k < 4; ++k) {
            memcpy(positions[4 * q + k], corners[quads[q][k]], sizeof positions[0]);
            memcpy(normals[4 * q + k], inward[q], sizeof normals[0]);
        }
    for (int q = 0; q < 5; ++q)
        for (int k = 0; k < 6; ++k)
            indices[6 * q + k] = (uint16_t)(4 * q + (k < 3 ? k : k == 3 ? 0 : k - 2));
    for (int double_sided = 0; double_sided < 2; ++double_sided) {
        gltf_asset a = {0};
        char rest[500];
        const int p = asset_floats(&a, &positions[0][0], 20, 3),
                  n = asset_floats(&a, &normals[0][0], 20, 3), i = asset_uint16(&a, indices, 30);
        snprintf(rest, sizeof rest,
            "\"nodes\":[{\"mesh\":0}],\"materials\":[{\"doubleSided\":%s}],\"meshes\":[{"
            "\"primitives\":[{\"attributes\":{\"POSITION\":%d,\"NORMAL\":%d},\"indices\":%d,"
            "\"material\":0}]}]",
            double_sided ? "true" : "false", p, n, i);
        norma_document *document = asset_open(&a, rest, 1);
        assert_int_equal(fix(document, "N201,N206"), !double_sided);
        assert_int_equal(says_undecided(document), double_sided);
        norma_document_close(document);
        asset_free(&a);
    }
}

/* ---- STL: facets of a body that is inside out have normals that look outward: these are right */

static void normals_of_facets_that_are_right_stay(void **state) {
    (void)state;
    static const char facet[] = "facet normal %d %d %d\nouter loop\nvertex %d %d %d\nvertex %d %d "
                                "%d\nvertex %d %d %d\nendloop\nendfacet\n";
    static const int points[4][3] = {{0, 0, 0}, {9, 0, 0}, {0, 9, 0}, {0, 0, 9}};
    static const int faces[4][3] = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
    static const int outward[4][3] = {{0, 0, -1}, {0, -1, 0}, {-1, 0, 0}, {1, 1, 1}};
    for (int inward = 0; inward < 2; ++inward) {
        char text[1500];
        size_t used = (size_t)snprintf(text, sizeof text, "solid a\n"), size;
        const int sign = inward ? 1 : -1; /* normals and winding disagree either way */
        for (int f = 0; f < 3; ++f) {
            const int *a = points[faces[f][0]], *b = points[faces[f][inward ? 2 : 1]],
                      *c = points[faces[f][inward ? 1 : 2]];
            used += (size_t)snprintf(text + used, sizeof text - used, facet, sign * outward[f][0],
                sign * outward[f][1], sign * outward[f][2], a[0], a[1], a[2], b[0], b[1], b[2],
                c[0], c[1], c[2]);
        }
        const int *a = points[faces[3][0]], *b = points[faces[3][inward ? 2 : 1]],
                  *c = points[faces[3][inward ? 1 : 2]];
        used += (size_t)snprintf(text + used, sizeof text - used,
            "facet normal %s\nouter loop\nvertex %d %d %d\nvertex %d %d %d\nvertex %d %d "
            "%d\nendloop\nendfacet\nendsolid a\n",
            inward ? "0.57735026 0.57735026 0.57735026" : "-0.57735026 -0.57735026 -0.57735026",
            a[0], a[1], a[2], b[0], b[1], b[2], c[0], c[1], c[2]);
        norma_document *document = scene_reopen((const unsigned char *)text, used, "a.stl");
        assert_int_equal(fix(document, "N205"), !inward);
        if (inward) { /* the winding is turned, and the normals are then right */
            assert_int_equal(fix(document, "N302"), 1);
            assert_int_equal(fix(document, "N205"), 0);
        }
        unsigned char *bytes = scene_output(document, &size);
        snprintf(text, sizeof text, "%.*s", (int)size, (const char *)bytes);
        assert_non_null(strstr(text, "0 0 -1"));
        free(bytes);
        norma_document_close(document);
    }
}

/* A sheet of 72 facets, of which neither volume nor rays say which side is outside; above it two
 * facets that touch nothing. state: of each facet '.': right, 't': wound the other way round, 'n':
 * its normal is the opposite of what it was. */
enum { ACROSS = 6, FACETS = 2 * ACROSS * ACROSS + 2 };
static unsigned char *sheet(const char *state, size_t *size) {
    unsigned char *stl = calloc(1, 84 + 50 * FACETS);
    assert_non_null(stl);
    stl[80] = FACETS;
    for (int f = 0; f < FACETS; ++f) {
        static const int halves[2][3][2] = {{{0, 0}, {1, 0}, {1, 1}}, {{0, 0}, {1, 1}, {0, 1}}};
        const int x = f / 2 % ACROSS, y = f / 2 / ACROSS, turned = state[f] == 't';
        float facet[4][3] = {{0, 0, state[f] == 'n' ? -1.0F : 1.0F}};
        for (int k = 0; k < 3; ++k) {
            const int *at = halves[f % 2][turned ? (3 - k) % 3 : k];
            facet[1 + k][0] = (float)(x + at[0] + (f == FACETS - 1 ? 8 : 0));
            facet[1 + k][1] = (float)(y + at[1] + (f >= FACETS - 2 ? 2 : 0));
        }
        memcpy(stl + 84 + 50 * f, facet, sizeof facet);
    }
    *size = 84 + 50 * FACETS;
    return stl;
}

static void sheet_becomes(const char *state, const char *rules, const char *wanted) {
    size_t size, fixed_size;
    unsigned char *before = sheet(state, &size), *after = sheet(wanted, &size);
    norma_document *document = scene_reopen(before, size, "a.stl");
    assert_int_equal(fix(document, rules), memcmp(before, after, size) != 0);
    unsigned char *fixed = scene_output(document, &fixed_size);
    assert_int_equal(fixed_size, size);
    assert_memory_equal(fixed, after, size);
    norma_document_close(document);
    free(fixed);
    free(before);
    free(after);
}

/* Stored normals say which facets are turned, where nothing else does; a normal that its
 * neighbours' contradict is wrong itself; of a facet by itself nothing says which of both is wrong.
 */
static void stored_normals_are_evidence(void **state) {
    (void)state;
    static const char
        right[] = "..........................................................................",
        turned[] = "..t..tt.......t.....ttt............tt...........t...........t...........t.",
        back[] = "........................................................................t.",
        mixed[] = "..t..tt.....n.t.....ttt.....n......tt...........t.......n...t.........n.tn",
        lone[] = "........................................................................tn",
        half[] = "..t..tt.......t.....ttt............tt...........t...........t...........tn";
    assert_int_equal(sizeof right, FACETS + 1);
    sheet_becomes(turned, "N205", turned);
    sheet_becomes(turned, "N301", back);
    sheet_becomes(mixed, "N205", half);
    sheet_becomes(mixed, "N205,N301", lone);
    sheet_becomes(right, "N205,N301", right);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_wrong_is_turned),
        cmocka_unit_test(most_faces_may_be_wrong),
        cmocka_unit_test(what_is_undecided_stays),
        cmocka_unit_test(what_rays_call_right_stays),
        cmocka_unit_test(a_double_sided_material_stays),
        cmocka_unit_test(normals_of_facets_that_are_right_stay),
        cmocka_unit_test(stored_normals_are_evidence),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
