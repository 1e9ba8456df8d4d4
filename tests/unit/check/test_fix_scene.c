/* What norma check --fix-unsafe makes of planted faults in tangents, morph targets, counts of
 * normals and materials: the fault is gone, what it was about is right by hand, all else keeps its
 * bits, and a second time changes nothing. */
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

/* Five squares side by side, v downwards: the sign +1 is right. */
enum { ISLANDS = 5, COUNT = 4 * ISLANDS };
static const float square[4][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};

typedef struct islands {
    float positions[COUNT][3], normals[COUNT + 3][3], tangents[COUNT][4], uvs[COUNT][2],
        moves[COUNT][3], turns[COUNT][3];
    uint16_t corners[6 * ISLANDS];
    size_t normal_count;
} islands;

static void make_islands(islands *s) {
    static const uint16_t corners[6] = {0, 1, 2, 0, 2, 3};
    memset(s, 0, sizeof *s);
    for (int v = 0; v < COUNT + 3; ++v) s->normals[v][2] = 1;
    for (int v = 0; v < COUNT; ++v) {
        const float *p = square[v % 4];
        memcpy(s->positions[v], (const float[3]){p[0] + 2.0F * (float)(v / 4), p[1], 0},
            sizeof s->positions[v]);
        s->tangents[v][0] = s->tangents[v][3] = 1;
        memcpy(s->uvs[v], (const float[2]){p[0], 1 - p[1]}, sizeof s->uvs[v]);
        s->moves[v][1] = p[1] * (float)(cos(0.5) - 1); /* each square turns about its lower edge */
        s->moves[v][2] = p[1] * (float)sin(0.5);
        s->turns[v][0] = 0.25F;
    }
    for (int i = 0; i < ISLANDS; ++i)
        for (int k = 0; k < 6; ++k) s->corners[6 * i + k] = (uint16_t)(4 * i + corners[k]);
    s->normal_count = COUNT;
}

/* Accessors: 0 POSITION, 1 NORMAL, 2 TANGENT, 3 TEXCOORD_0, 4 indices, 5 what moves, 6 what turns.
 */
static norma_document *open_islands(gltf_asset *a, const islands *s, const char *rest) {
    asset_floats(a, &s->positions[0][0], COUNT, 3);
    asset_floats(a, &s->normals[0][0], s->normal_count, 3);
    asset_floats(a, &s->tangents[0][0], COUNT, 4);
    asset_floats(a, &s->uvs[0][0], COUNT, 2);
    asset_uint16(a, s->corners, 6 * ISLANDS);
    asset_floats(a, &s->moves[0][0], COUNT, 3);
    asset_floats(a, &s->turns[0][0], COUNT, 3);
    return asset_open(a, rest, 1);
}

#define ALL "\"POSITION\":0,\"NORMAL\":1,\"TANGENT\":2,\"TEXCOORD_0\":3"
#define MESH(attributes, more)                                                                     \
    "\"meshes\":[{\"primitives\":[{\"attributes\":{" attributes "},\"indices\":4" more "}]}]"

/* ---- mending until nothing is left to mend */

static norma_check_options options_of(const char *rules, uint8_t mask[128]) {
    memset(mask, 0, 128);
    assert_int_equal(norma_rules_select(rules, mask, NULL), NORMA_OK);
    return (norma_check_options){.struct_size = sizeof(norma_check_options), .rules = mask};
}

static size_t count_of(norma_document *document, const char *rules) {
    uint8_t mask[128];
    const norma_check_options options = options_of(rules, mask);
    norma_findings *findings;
    norma_document_error error;
    size_t count = 0;
    if (norma_check_document(document, &options, &findings, &error)) fail_msg("%s", error.message);
    for (size_t i = 0; i < norma_findings_count(findings); ++i)
        count += norma_findings_get(findings, i)->count;
    norma_findings_free(findings);
    return count;
}

static norma_document *reopen(norma_document *document, unsigned char **bytes) {
    size_t size;
    norma_document *again;
    norma_document_error error;
    unsigned char *output = scene_output(document, &size);
    norma_document_close(document);
    free(*bytes);
    *bytes = output;
    const norma_document_options options = {
        .struct_size = sizeof options, .format = NORMA_FILE_GLB, .lenient = 1};
    if (norma_document_open_memory(output, size, "mended.glb", &options, &again, &error))
        fail_msg("%s", error.message);
    return again;
}

static norma_fix_summary mend(norma_document *document, const char *rules, int unsafe) {
    uint8_t mask[128];
    const norma_check_options options = options_of(rules, mask);
    norma_fix_summary summary;
    norma_document_error error;
    if (norma_fix_document(document, &options, unsafe, &summary, &error))
        fail_msg("%s", error.message);
    return summary;
}

/* The document is closed; the result lives in bytes. A further time must change nothing. */
static norma_document *mended(
    norma_document *document, const char *rules, int unsafe, unsigned char **bytes) {
    norma_fix_summary summary = {.changed = 1};
    for (int i = 0; i < 4 && summary.changed; ++i) summary = mend(document, rules, unsafe);
    document = reopen(document, bytes);
    summary = mend(document, rules, unsafe);
    assert_true(!summary.changed);
    return document;
}

typedef struct outcome {
    norma_document *document;
    unsigned char *bytes;
    gltf_asset asset;
    norma_mesh_data data;
    norma_mesh_attributes attributes;
} outcome;

static void run(
    outcome *o, const islands *s, const char *rest, const char *rules, int unsafe, size_t before) {
    norma_document_error error;
    *o = (outcome){0};
    norma_document *document = open_islands(&o->asset, s, rest);
    assert_int_equal(count_of(document, rules), before);
    o->document = mended(document, rules, unsafe, &o->bytes);
    assert_int_equal(count_of(o->document, rules), 0);
    if (norma_document_mesh_data(o->document, 0, &o->data, &error) ||
        norma_document_mesh_attributes(o->document, 0, &o->attributes, &error))
        fail_msg("%s", error.message);
}

static void finish(outcome *o) {
    norma_document_close(o->document);
    free(o->bytes);
    asset_free(&o->asset);
}

/* Positions, UVs and corners, and the normals and tangents that keep marks, have the bits they had.
 */
static void assert_kept(const outcome *o, const islands *s, int normals,
    const int *changed_tangents, size_t changed_count) {
    assert_int_equal(o->data.mesh.positions.count, COUNT);
    assert_memory_equal(o->data.mesh.positions.data, s->positions, sizeof s->positions);
    assert_memory_equal(o->attributes.texcoords, s->uvs, sizeof s->uvs);
    assert_int_equal(o->data.mesh.corner_count, 6 * ISLANDS);
    for (int i = 0; i < 6 * ISLANDS; ++i)
        assert_int_equal(((const uint32_t *)o->data.mesh.corners)[i], s->corners[i]);
    if (normals)
        assert_memory_equal(o->data.normals.data, s->normals, COUNT * sizeof s->normals[0]);
    for (size_t v = 0; changed_tangents && v < COUNT; ++v) {
        int changed = 0;
        for (size_t i = 0; i < changed_count; ++i) changed |= changed_tangents[i] == (int)v;
        assert_int_equal(
            memcmp(o->attributes.tangents + 4 * v, s->tangents[v], sizeof s->tangents[v]) != 0,
            changed);
    }
}

static void assert_tangent(const outcome *o, size_t v, double x, double y, double z, float sign) {
    const float *t = o->attributes.tangents + 4 * v;
    assert_true(fabs((double)t[0] - x) < 1e-6 && fabs((double)t[1] - y) < 1e-6 &&
                fabs((double)t[2] - z) < 1e-6 && t[3] == sign);
}

/* ---- tangents */

static void test_bad_tangents(void **state) {
    (void)state;
    islands s;
    outcome o;
    make_islands(&s);
    s.tangents[3][0] = 0.5F;
    s.tangents[7][0] = 0;
    s.tangents[9][1] = NAN;
    s.tangents[13][3] = 0.5F;
    run(&o, &s, MESH(ALL, ""), "N801,N802", 0, 4);
    assert_kept(&o, &s, 1, (const int[]){3, 7, 9, 13}, 4);
    for (size_t v = 0; v < COUNT; ++v) assert_tangent(&o, v, 1, 0, 0, 1);
    finish(&o);
}

static void test_leaning_tangents(void **state) {
    (void)state;
    islands s;
    outcome o;
    make_islands(&s);
    memcpy(s.tangents[5], (const float[4]){0.48F, 0.64F, 0.6F, -1}, sizeof s.tangents[5]);
    run(&o, &s, MESH(ALL, ""), "N803", 0, 1);
    assert_kept(&o, &s, 1, (const int[]){5}, 1);
    assert_tangent(&o, 5, 0.6, 0.8, 0, -1); /* of the sign another rule judges */
    finish(&o);
}

/* The smaller side turns its signs, whichever it is; vectors stay to the bit. */
static void test_signs(void **state) {
    (void)state;
    islands s;
    outcome o;
    static const int third[] = {8, 9, 10, 11}, last[] = {16, 17, 18, 19};
    make_islands(&s);
    for (int k = 0; k < 4; ++k) {
        s.tangents[third[k]][3] = -1;
        s.tangents[third[k]][2] = 0.01F; /* leans less than N803 minds */
    }
    run(&o, &s, MESH(ALL, ""), "N804", 0, 4);
    assert_kept(&o, &s, 1, third, 4);
    for (int k = 0; k < 4; ++k) assert_tangent(&o, (size_t)third[k], 1, 0, (double)0.01F, 1);
    finish(&o);

    make_islands(&s);
    for (int v = 0; v < 16; ++v) s.tangents[v][3] = -1;
    o = (outcome){0};
    norma_document *document = open_islands(&o.asset, &s, MESH(ALL, ""));
    o.document = mended(document, "N804", 1, &o.bytes);
    assert_int_equal(norma_document_mesh_data(o.document, 0, &o.data, NULL), NORMA_DOCUMENT_OK);
    assert_int_equal(
        norma_document_mesh_attributes(o.document, 0, &o.attributes, NULL), NORMA_DOCUMENT_OK);
    assert_kept(&o, &s, 1, last, 4);
    assert_tangent(&o, 17, 1, 0, 0, -1);
    assert_int_equal(count_of(o.document, "N804"),
        COUNT); /* information: all against their UVs, as the map may be made */
    finish(&o);
}

static void test_missing_tangents(void **state) {
    (void)state;
    islands s;
    outcome o;
    make_islands(&s);
    for (int v = 4; v < 8; ++v) s.uvs[v][0] = 1 - s.uvs[v][0]; /* mirrored */
    run(&o, &s,
        "\"materials\":[{\"normalTexture\":{\"index\":0}}]," MESH(
            "\"POSITION\":0,\"NORMAL\":1,\"TEXCOORD_0\":3", ",\"material\":0"),
        "N805", 1, 1);
    assert_kept(&o, &s, 1, NULL, 0);
    assert_int_equal(o.attributes.tangent_count, COUNT);
    for (size_t v = 0; v < COUNT; ++v)
        assert_tangent(&o, v, v / 4 == 1 ? -1 : 1, 0, 0, v / 4 == 1 ? -1 : 1);
    assert_int_equal(count_of(o.document, "N801,N802,N803,N804,N805,N806"), 0);
    finish(&o);
}

static void test_tangents_without_normals(void **state) {
    (void)state;
    islands s;
    outcome o;
    make_islands(&s);
    run(&o, &s, MESH("\"POSITION\":0,\"TANGENT\":2,\"TEXCOORD_0\":3", ""), "N806", 0, 1);
    assert_kept(&o, &s, 1, (const int[]){-1}, 1); /* the normals are +Z */
    finish(&o);
}

/* ---- normals */

static void test_counts(void **state) {
    (void)state;
    islands s;
    outcome o;
    for (size_t count = COUNT - 3; count <= COUNT + 3; count += 2) {
        make_islands(&s);
        memcpy(s.normals[2], (const float[3]){0.6F, 0, 0.8F},
            sizeof s.normals[2]); /* no business of this fix */
        s.normal_count = count;
        run(&o, &s, MESH(ALL, ""), "N106", 0, count < COUNT ? COUNT - count : count - COUNT);
        assert_int_equal(o.data.normals.count, COUNT);
        assert_kept(&o, &s, 1, (const int[]){-1}, 1);
        finish(&o);
    }
}

static void test_unlit(void **state) {
    (void)state;
    islands s;
    outcome o;
    make_islands(&s);
    run(&o, &s,
        "\"materials\":[{\"extensions\":{\"KHR_materials_unlit\":{}}}]," MESH(
            ALL, ",\"material\":0,\"targets\":[{\"POSITION\":5,\"NORMAL\":6}]"),
        "N105", 1, COUNT);
    norma_mesh_info info;
    norma_morph_data morph;
    assert_int_equal(norma_document_mesh_info(o.document, 0, &info), NORMA_DOCUMENT_OK);
    assert_true(info.normals == NORMA_NORMALS_NONE && !info.has_tangents);
    assert_int_equal(norma_document_morph_data(o.document, 0, 0, &morph, NULL), NORMA_DOCUMENT_OK);
    assert_true(morph.positions.count == COUNT && morph.normals.count == 0);
    assert_kept(&o, &s, 0, NULL, 0);
    finish(&o);
}

/* OBJ: what names a normal keeps it; what names none, or one that is not there, gets one. */
static void test_obj(void **state) {
    (void)state;
    static const char text[] = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nv 2 1 0\nvn 0 0.6 "
                               "0.8\nf 1//1 2//1 3//1\nf 1//1 3 4//1\nf 2//0 5//9 6//1\n";
    norma_document *document, *again;
    norma_document_error error;
    const norma_document_options options = {.struct_size = sizeof options, .lenient = 1};
    if (norma_document_open_memory(text, sizeof text - 1, "a.obj", &options, &document, &error))
        fail_msg("%s", error.message);
    assert_int_equal(count_of(document, "N106"), 2);
    assert_true(mend(document, "N106", 0).changed);
    size_t size;
    unsigned char *bytes = scene_output(document, &size);
    norma_document_close(document);
    if (norma_document_open_memory(bytes, size, "a.obj", &options, &again, &error))
        fail_msg("%s", error.message);
    assert_int_equal(count_of(again, "N106,N104"), 0);
    norma_mesh_data data;
    assert_int_equal(norma_document_mesh_data(again, 0, &data, NULL), NORMA_DOCUMENT_OK);
    static const int kept[9] = {1, 1, 1, 1, 0, 1, 0, 0, 1};
    for (int c = 0; c < 9; ++c) {
        const float *n = (const float *)data.normals.data + 3 * data.corner_normals[c];
        if (kept[c])
            assert_true(n[0] == 0 && n[1] == 0.6F && n[2] == 0.8F);
        else
            assert_true(n[0] == 0 && n[1] == 0 && n[2] == 1);
    }
    assert_false(mend(again, "N106", 0).changed);
    norma_document_close(again);
    free(bytes);
}

/* ---- morph targets */

static void test_bending_morph(void **state) {
    (void)state;
    islands s;
    outcome o;
    make_islands(&s);
    run(&o, &s, MESH(ALL, ",\"targets\":[{\"POSITION\":5},{\"POSITION\":5,\"NORMAL\":6}]"), "N901",
        1, 2 * ISLANDS);
    assert_kept(&o, &s, 1, (const int[]){-1}, 1);
    norma_morph_data made, kept;
    assert_int_equal(norma_document_morph_data(o.document, 0, 0, &made, NULL), NORMA_DOCUMENT_OK);
    assert_int_equal(norma_document_morph_data(o.document, 0, 1, &kept, NULL), NORMA_DOCUMENT_OK);
    assert_memory_equal(
        kept.normals.data, s.turns, sizeof s.turns); /* another target's keep their bits */
    assert_memory_equal(made.positions.data, s.moves, sizeof s.moves);
    assert_int_equal(made.normals.count, COUNT);
    for (size_t v = 0; v < COUNT; ++v) {
        const float *delta = (const float *)made.normals.data + 3 * v;
        assert_true(fabs((double)delta[0]) < 1e-6 && fabs((double)delta[1] + sin(0.5)) < 1e-6 &&
                    fabs((double)delta[2] - (cos(0.5) - 1)) < 1e-6);
    }
    finish(&o);
}

static void test_morph_without_base(void **state) {
    (void)state;
    islands s;
    outcome o;
    norma_morph_data morph;
    make_islands(&s);
    run(&o, &s,
        MESH("\"POSITION\":0,\"TEXCOORD_0\":3", ",\"targets\":[{\"POSITION\":5,\"NORMAL\":6}]"),
        "N903", 1, 1);
    assert_int_equal(norma_document_morph_data(o.document, 0, 0, &morph, NULL), NORMA_DOCUMENT_OK);
    assert_true(morph.positions.count == COUNT && morph.normals.count == 0);
    assert_kept(&o, &s, 0, NULL, 0);
    finish(&o);
}

/* ---- transforms: what is drawn stays where it was, and how it was lit */

static void test_baked(void **state) {
    (void)state;
    islands s;
    outcome o;
    drawn_scene before = {0}, after = {0};
    static const char nodes[] = ",\"nodes\":[{\"scale\":[-2,1,1],\"children\":[1]},{\"mesh\":0,"
                                "\"translation\":[1,2,3],\"rotation\":[0.2705980500730985,0,0."
                                "2705980500730985,0.9238795325112867]}]";
    make_islands(&s);
    char rest[1000];
    snprintf(rest, sizeof rest, "%s%s", MESH(ALL, ""), nodes);
    gltf_asset a = {0};
    norma_document *document = open_islands(&a, &s, rest);
    scene_read(document, &before);
    norma_document_close(document);
    asset_free(&a);
    run(&o, &s, rest, "N601,N602,N604", 1, 3);
    scene_read(o.document, &after);
    assert_int_equal(before.count, after.count);
    for (size_t i = 0; i < before.count; ++i) {
        double facet[3];
        scene_facet_normal(&after.triangles[i], facet);
        for (int k = 0; k < 3; ++k) {
            int found = 0; /* a mirror that was baked has reversed the corners behind the first */
            for (int c = 0; c < 3; ++c) {
                double off = 0;
                for (int x = 0; x < 3; ++x)
                    off = fmax(off, fabs(before.triangles[i].position[k][x] -
                                         after.triangles[i].position[c][x]));
                found |= off < 1e-5;
            }
            assert_true(found);
            assert_true(scene_angle_deg(facet, after.triangles[i].normal[k]) < 1e-3);
        }
    }
    scene_free(&before);
    scene_free(&after);
    finish(&o);
}

/* A sheared node whose mesh has numbers that do not fit under it cannot be baked: the fault lies in
 * the file, not in the call. */
static void test_too_large_to_bake(void **state) {
    static const float positions[3][3] = {{0, 0, 0}, {3e38F, 0, 0}, {0, 3e38F, 0}},
                       normals[3][3] = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}};
    gltf_asset a = {0};
    norma_document_error error;
    const norma_check_options options = {.struct_size = sizeof options};
    (void)state;
    asset_floats(&a, positions[0], 3, 3);
    asset_floats(&a, normals[0], 3, 3);
    norma_document *document = asset_open(&a,
        "\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0,\"matrix\":[2,0,0,0,0.5,1,"
        "0,0,0,0,1,0,0,0,0,1]}],"
        "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"NORMAL\":1}}]}]",
        1);
    norma_document_result result = NORMA_DOCUMENT_OK;
    result = norma_fix_document(document, &options, 1, NULL, &error);
    assert_int_equal(result, NORMA_DOCUMENT_ERROR_UNSUPPORTED);
    assert_int_equal(error.result, result);
    assert_non_null(strstr(error.message, "its coordinates exceed the range of floats"));
    norma_document_close(document);
    asset_free(&a);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_too_large_to_bake),
        cmocka_unit_test(test_bad_tangents),
        cmocka_unit_test(test_leaning_tangents),
        cmocka_unit_test(test_signs),
        cmocka_unit_test(test_missing_tangents),
        cmocka_unit_test(test_tangents_without_normals),
        cmocka_unit_test(test_counts),
        cmocka_unit_test(test_unlit),
        cmocka_unit_test(test_obj),
        cmocka_unit_test(test_bending_morph),
        cmocka_unit_test(test_morph_without_base),
        cmocka_unit_test(test_baked),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
