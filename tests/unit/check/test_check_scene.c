/* Planted faults for the rules about files, materials, transforms, tangents and morph targets: each
 * in a known place and amount, the numbers by hand; and beside each what comes nearest to it and is
 * right, of which nothing may be said. */
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
#include "document_bytes.h"
#include "gltf_asset.h"
#include "gltf_scene.h"

/* ---- what is found */

static norma_findings *check(norma_document *document, const char *rules) {
    uint8_t mask[128] = {0};
    size_t count;
    norma_rules(&count);
    assert_true(count <= sizeof mask);
    assert_int_equal(norma_rules_select(rules, mask, NULL), NORMA_OK);
    const norma_check_options options = {.struct_size = sizeof options, .rules = mask};
    norma_findings *findings;
    norma_document_error error;
    if (norma_check_document(document, &options, &findings, &error)) fail_msg("%s", error.message);
    norma_document_close(document);
    return findings;
}

#define DEGREES_PI 3.14159265358979323846

/* N807, like N204, has something to report of every mesh. */
#define MINE "N001,N002,N104,N105,N106,N6,N801,N802,N803,N804,N805,N806,N813,N9"

typedef struct expected {
    const char *rule, *where;
    norma_severity severity;
    size_t count;
    double worst;       /* NaN: there is none */
    const char *places; /* "v5 v9", "f0 f1"; "": none */
} expected;

static void places_of(const norma_finding *finding, char text[400]) {
    text[0] = 0;
    for (size_t i = 0; i < finding->sample_count; ++i) {
        const norma_sample *s = &finding->samples[i];
        sprintf(text + strlen(text), "%s%c%zu", i ? " " : "", s->vertex != SIZE_MAX ? 'v' : 'f',
            s->vertex != SIZE_MAX ? s->vertex : s->face);
    }
}

static void show(const norma_findings *findings) {
    for (size_t i = 0; i < norma_findings_count(findings); ++i) {
        const norma_finding *f = norma_findings_get(findings, i);
        char places[400];
        places_of(f, places);
        print_error("  {%s, %s, severity %d, %zu, %.9g, \"%s\"} %s\n", f->rule->id, f->where,
            (int)f->severity, f->count, f->worst_value, places, f->message);
    }
}

/* Exactly these, in this order. Frees the findings. */
static void assert_found(norma_findings *findings, const expected *wanted, size_t count) {
    int right = norma_findings_count(findings) == count;
    for (size_t i = 0; right && i < count; ++i) {
        const norma_finding *f = norma_findings_get(findings, i);
        char places[400];
        places_of(f, places);
        right = !strcmp(f->rule->id, wanted[i].rule) && !strcmp(f->where, wanted[i].where) &&
                f->severity == wanted[i].severity && f->count == wanted[i].count &&
                !strcmp(places, wanted[i].places) && f->message[0];
        right = right && (isnan(wanted[i].worst) ? isnan(f->worst_value)
                                                 : wanted[i].worst == f->worst_value ||
                                                       fabs(f->worst_value - wanted[i].worst) <=
                                                           1e-5 * fabs(wanted[i].worst));
    }
    if (!right) show(findings);
    norma_findings_free(findings);
    assert_true(right);
}

#define FOUND(findings, ...)                                                                       \
    do {                                                                                           \
        const expected wanted_[] = {__VA_ARGS__};                                                  \
        assert_found(findings, wanted_, sizeof wanted_ / sizeof *wanted_);                         \
    } while (0)
static void assert_clean(norma_findings *findings) { assert_found(findings, NULL, 0); }

#define I NORMA_SEVERITY_INFO
#define W NORMA_SEVERITY_WARNING
#define E NORMA_SEVERITY_ERROR

/* ---- nodes: a square, its normals, its indices: accessors 0, 1, 2 */

static const float square[4][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
static const float up[5][3] = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}, {0, 0, 1}, {0, 0, 1}};
static const uint16_t corners[6] = {0, 1, 2, 0, 2, 3};

static void add_square(gltf_asset *a) {
    asset_floats(a, &square[0][0], 4, 3);
    asset_floats(a, &up[0][0], 4, 3);
    asset_uint16(a, corners, 6);
}

#define SURFACE  "\"attributes\":{\"POSITION\":0,\"NORMAL\":1},\"indices\":2"
#define ONE_SIDE "\"meshes\":[{\"primitives\":[{" SURFACE "}]}]"
#define TWO_SIDES                                                                                  \
    "\"materials\":[{},{\"doubleSided\":true}],\"meshes\":[{\"primitives\":[{" SURFACE             \
    ",\"material\":0},{" SURFACE ",\"material\":1}]}]"

static norma_findings *check_nodes(const char *meshes, const char *nodes) {
    char rest[4000];
    gltf_asset a = {0};
    add_square(&a);
    assert_true(snprintf(rest, sizeof rest, "%s,%s", meshes, nodes) < (int)sizeof rest);
    norma_findings *findings = check(asset_open(&a, rest, 1), MINE);
    asset_free(&a);
    return findings;
}

static void test_mirrored(void **state) {
    (void)state;
    static const char two_levels_up[] =
        "\"nodes\":[{\"scale\":[-1,1,1],\"children\":[1,3]},{\"children\":[2]},{\"mesh\":0,"
        "\"name\":\"leaf\"},{},{\"mesh\":0}]";
    FOUND(check_nodes(ONE_SIDE, two_levels_up), {"N602", "/nodes/2", I, 1, -1, ""});
    FOUND(check_nodes(TWO_SIDES, two_levels_up), {"N602", "/nodes/2", W, 1, -1, ""});
    FOUND(check_nodes(ONE_SIDE, "\"nodes\":[{\"mesh\":0,\"scale\":[-2,-2,-2]}]"),
        {"N602", "/nodes/0", I, 1, -8, ""});
    assert_clean(check_nodes(ONE_SIDE,
        "\"nodes\":[{\"scale\":[-1,1,1],\"children\":[1]},{\"scale\":[1,1,-1],\"mesh\":0}]"));
    assert_clean(check_nodes(TWO_SIDES, "\"nodes\":[{\"mesh\":0,\"scale\":[-3,-3,3]}]"));
    assert_clean(check_nodes(ONE_SIDE, "\"nodes\":[{\"scale\":[-1,1,1]},{\"mesh\":0}]"));
    /* The node of a skinned mesh does not place it. */
    assert_clean(check_nodes(TWO_SIDES,
        "\"skins\":[{\"joints\":[1]}],\"nodes\":[{\"mesh\":0,\"skin\":0,\"scale\":[-1,5,1]},{}]"));
}

/* Columns (2c, s) and (-2s, c) at 45 degrees: their cosine is 1.5 / 2.5. */
static void test_sheared(void **state) {
    (void)state;
    static const char turned[] =
        "{\"rotation\":[0,0,0.3826834323650898,0.9238795325112867],\"mesh\":0}";
    char nodes[400];
    sprintf(nodes, "\"nodes\":[{\"scale\":[2,1,1],\"children\":[1]},%s]", turned);
    FOUND(check_nodes(ONE_SIDE, nodes), {"N601", "/nodes/1", I, 1, 2, ""},
        {"N604", "/nodes/1", W, 1, 0.6, ""});
    sprintf(nodes, "\"nodes\":[{\"scale\":[2,2,2],\"children\":[1]},%s]", turned);
    assert_clean(check_nodes(ONE_SIDE, nodes));
    FOUND(check_nodes(ONE_SIDE,
              "\"nodes\":[{\"mesh\":0,\"matrix\":[1,0,0,0, 0.0011,1,0,0, 0,0,1,0, 5,6,7,1]}]"),
        {"N604", "/nodes/0", W, 1, 0.0011, ""});
    assert_clean(check_nodes(
        ONE_SIDE, "\"nodes\":[{\"mesh\":0,\"matrix\":[1,0,0,0, 0.0009,1,0,0, 0,0,1,0, 5,6,7,1]}]"));
}

static void test_uneven(void **state) {
    (void)state;
    FOUND(check_nodes(ONE_SIDE,
              "\"nodes\":[{\"mesh\":0,\"scale\":[1,1.0501,1]},{\"mesh\":0,\"scale\":[1,1.0499,1]},{"
              "\"mesh\":0,\"scale\":[1e-7,1e-7,4e-7]},{\"mesh\":0,\"scale\":[1e-9,1e-9,1e-9]}]"),
        {"N601", "/nodes/0", I, 1, 1.0501, ""}, {"N601", "/nodes/2", I, 1, 4, ""});
    norma_findings *findings = check_nodes(ONE_SIDE, "\"nodes\":[{\"mesh\":0,\"scale\":[2,1,1]}]");
    assert_non_null(
        strstr(norma_findings_get(findings, 0)->message, "36.9 degrees")); /* asin(3 / 5) */
    assert_string_equal(norma_findings_get(findings, 0)->label, "node 0");
    norma_findings_free(findings);
}

static void test_singular(void **state) {
    (void)state;
    FOUND(check_nodes(TWO_SIDES, "\"nodes\":[{\"mesh\":0,\"scale\":[1,0,1]},{\"mesh\":0,\"scale\":["
                                 "0,0,0]},{\"mesh\":0,\"scale\":[1,1,-0.0000001]},{\"mesh\":0}]"),
        {"N603", "/nodes/0", W, 1, 2, ""}, {"N603", "/nodes/1", W, 1, 0, ""},
        {"N603", "/nodes/2", W, 1, 2, ""});
}

static norma_findings *check_instances(const float *scales, size_t count, const char *node_scale) {
    gltf_asset a = {0};
    char rest[1000];
    add_square(&a);
    asset_floats(&a, scales, count, 3);
    snprintf(rest, sizeof rest,
        "\"nodes\":[{\"mesh\":0,\"scale\":%s,\"extensions\":{\"EXT_mesh_gpu_instancing\":{"
        "\"attributes\":{\"SCALE\":3}}}}]," ONE_SIDE,
        node_scale);
    norma_findings *findings = check(asset_open(&a, rest, 1), MINE);
    asset_free(&a);
    return findings;
}

static void test_instances(void **state) {
    (void)state;
    static const float mixed[5][3] = {{1, 1, 1}, {-1, 1, 1}, {2, 2, 2}, {-3, -3, -3}, {1, 1, 1}},
                       all[3][3] = {{-1, 1, 1}, {1, -1, 1}, {-1, -1, -1}},
                       right[3][3] = {{1, 1, 1}, {-1, -1, 1}, {5, 5, 5}};
    static const float uneven[4][3] = {{1, 1, 1}, {2, 1, 1}, {1, 1, 3}, {1, 0, 1}};
    FOUND(check_instances(&mixed[0][0], 5, "[1,1,1]"), {"N602", "/nodes/0", W, 2, -27, ""});
    FOUND(check_instances(&all[0][0], 3, "[1,1,1]"), {"N602", "/nodes/0", I, 3, -1, ""});
    assert_clean(check_instances(&all[0][0], 3, "[1,1,-1]"));
    assert_clean(check_instances(&right[0][0], 3, "[1,1,1]"));
    FOUND(check_instances(&right[0][0], 3, "[1,-1,1]"), {"N602", "/nodes/0", I, 3, -125, ""});
    FOUND(check_instances(&uneven[0][0], 4, "[1,1,1]"), {"N601", "/nodes/0", I, 2, 3, ""},
        {"N603", "/nodes/0", W, 1, 2, ""});
}

/* An i3dm (OGC 18-053r2, 10.3): 32 bytes, the feature table as JSON and as numbers, the GLB. Each
 * instance has places of three zeros, then what numbers has. */
static norma_findings *check_tile(
    const char *features, const float *numbers, size_t size, const char *node, const char *rules) {
    enum { TEXT = 128, HEADER = 32 };
    unsigned char bytes[4096] = "i3dm\1";
    gltf_asset a = {0};
    char rest[1000];
    size_t glb;
    add_square(&a);
    snprintf(rest, sizeof rest, "\"nodes\":[{\"mesh\":0%s}]," ONE_SIDE, node);
    asset_bytes(&a, rest, &glb);
    const size_t end = HEADER + TEXT + size, length = (end + glb + 7) / 8 * 8;
    assert_true(length <= sizeof bytes && strlen(features) <= TEXT);
    for (size_t i = 0; i < 4; ++i) {
        bytes[8 + i] = (unsigned char)(length >> 8 * i);
        bytes[12 + i] = (unsigned char)((size_t)TEXT >> 8 * i);
        bytes[16 + i] = (unsigned char)(size >> 8 * i);
    }
    bytes[28] = 1; /* the GLB lies inside */
    memset(bytes + HEADER, ' ', TEXT);
    memcpy(bytes + HEADER, features, strlen(features));
    memcpy(bytes + HEADER + TEXT, numbers, size);
    memcpy(bytes + end, a.glb, glb);
    document_bytes file = bytes_copy(bytes, length);
    norma_findings *findings = check(bytes_open(file, "a.i3dm"), rules);
    bytes_free(&file);
    asset_free(&a);
    return findings;
}

static void expect_message(norma_findings *findings, const char *message) {
    assert_int_equal(norma_findings_count(findings), 1);
    assert_string_equal(norma_findings_get(findings, 0)->message, message);
    norma_findings_free(findings);
}

static void test_tile_instances(void **state) {
    (void)state;
    const char *scaled = "{\"INSTANCES_LENGTH\":3,\"POSITION\":{\"byteOffset\":0},"
                         "\"SCALE\":{\"byteOffset\":36}}",
               *uneven = "{\"INSTANCES_LENGTH\":2,\"POSITION\":{\"byteOffset\":0},"
                         "\"SCALE_NON_UNIFORM\":{\"byteOffset\":24}}",
               *turned = "{\"INSTANCES_LENGTH\":1,\"POSITION\":{\"byteOffset\":0},"
                         "\"NORMAL_UP\":{\"byteOffset\":12},"
                         "\"NORMAL_RIGHT\":{\"byteOffset\":24}}",
               *packed = "{\"INSTANCES_LENGTH\":1,\"POSITION\":{\"byteOffset\":0},"
                         "\"NORMAL_UP_OCT32P\":{\"byteOffset\":12},"
                         "\"NORMAL_RIGHT_OCT32P\":{\"byteOffset\":16}}";
    float of_scale[12] = {[9] = 1, [10] = -1, [11] = 2};
    FOUND(check_tile(scaled, of_scale, sizeof of_scale, "", MINE),
        {"N602", "/nodes/0", W, 1, -1, ""});
    expect_message(check_tile(scaled, of_scale, sizeof of_scale, "", "N602"),
        "mirrored at instance 1 of 3: world determinant -1, and the others do not mirror; one draw "
        "call can cull in only one direction");
    /* a mirror of the node's own makes the mirrored one the only one that is right */
    FOUND(check_tile(scaled, of_scale, sizeof of_scale, ",\"scale\":[1,1,-1]", MINE),
        {"N602", "/nodes/0", W, 2, -8, ""});
    of_scale[10] = 0;
    FOUND(
        check_tile(scaled, of_scale, sizeof of_scale, "", MINE), {"N603", "/nodes/0", W, 1, 0, ""});
    /* along z of the tile, which is y of the model */
    const float of_axes[12] = {[6] = 1, [7] = 1, [8] = 3, [9] = 1, [10] = 1, [11] = 1};
    FOUND(check_tile(uneven, of_axes, sizeof of_axes, "", MINE), {"N601", "/nodes/0", I, 1, 3, ""});
    assert_clean(check_tile(uneven, of_axes, sizeof of_axes,
        ",\"extras\":{\"norma\":{\"ignore\":"
        "[\"N601\"]}}",
        MINE));
    const float upright[9] = {[5] = 1, [6] = 1}, flat[9] = {[5] = 1, [8] = 1};
    assert_clean(check_tile(turned, upright, sizeof upright, "", MINE));
    FOUND(check_tile(turned, flat, sizeof flat, "", MINE), {"N603", "/nodes/0", W, 1, 1, ""});
    const uint16_t codes[10] = {[6] = 32768, 65535, 65535, 32768}; /* about +y, +x */
    float octahedral[5];
    memcpy(octahedral, codes, sizeof codes);
    assert_clean(check_tile(packed, octahedral, sizeof octahedral, "", MINE));
    /* one instance fewer than there are said to be */
    FOUND(check_tile(scaled, of_scale, sizeof of_scale - 4, "", MINE),
        {"N002", "instances", W, 1, NAN, ""});
}

static void test_ignored_nodes(void **state) {
    (void)state;
    assert_clean(check_nodes(ONE_SIDE, "\"nodes\":[{\"mesh\":0,\"scale\":[-1,1,1],\"extras\":{"
                                       "\"norma\":{\"ignore\":[\"N602\"]}}}]"));
    assert_clean(check_nodes(ONE_SIDE, "\"nodes\":[{\"children\":[1],\"extras\":{\"norma\":{"
                                       "\"ignore\":[\"N60\"]}}},{\"mesh\":0,\"scale\":[-1,2,0]}]"));
    assert_clean(
        check_nodes(ONE_SIDE, "\"extras\":{\"norma\":{\"ignore\":[\"mirrored\",\"non-uniform-"
                              "scale\"]}},\"nodes\":[{\"mesh\":0,\"scale\":[-1,2,1]}]"));
    FOUND(check_nodes(ONE_SIDE, "\"nodes\":[{\"mesh\":0,\"scale\":[-1,2,1],\"extras\":{\"norma\":{"
                                "\"ignore\":[\"N601\",\"nonsense\"]}}}]"),
        {"N602", "/nodes/0", I, 1, -2, ""});
}

/* ---- skins */

static void test_joints(void **state) {
    (void)state;
    FOUND(check_nodes(ONE_SIDE,
              "\"skins\":[{\"joints\":[0]},{\"joints\":[0,1],\"name\":\"arm\"}],\"nodes\":[{"
              "\"scale\":[1,1.04,1],\"children\":[1]},{\"scale\":[1,1.02,1]}]"),
        {"N605", "/skins/1", I, 1, 1.0608, ""});
    static const float times[2] = {0, 1}, scales[2][3] = {{1, 1, 1}, {1, 1, 1.5F}};
    gltf_asset a = {0};
    asset_floats(&a, times, 2, 1);
    asset_floats(&a, &scales[0][0], 2, 3);
    FOUND(check(asset_open(&a,
                    "\"skins\":[{\"joints\":[1]}],\"nodes\":[{\"children\":[1]},{}],\"animations\":"
                    "[{\"samplers\":[{\"input\":0,\"output\":1}],\"channels\":[{\"sampler\":0,"
                    "\"target\":{\"node\":0,\"path\":\"scale\"}}]}]",
                    1),
              MINE),
        {"N605", "/skins/0", I, 1, 1.5, ""});
    asset_free(&a);
}

/* ---- what a shader that takes normals through the blended matrix makes of them */

/* The tangent of the angle between B n and the normal of what B makes of a plane of normal n, for
 * B = diag(1, s, 1) and n = (sin a, cos a, 0): t = tan a; (t, s) against (t, 1 / s). */
static double error_of(double s, double t) {
    return fabs(atan2(s, t) - atan2(1 / s, t)) * 180 / DEGREES_PI;
}

/* Two joints: node 1 stands still, node 2 is animated. One vertex hangs on node 1 alone, one on
 * both half and half, one on node 2 alone; all have the normal (0.6, 0.8, 0). scales: of node 2
 * along y at the keys 0, 1, 2 seconds. */
static norma_skin_info bent_skin(
    const float *scales, const double *bind, const float *turns, norma_findings **findings) {
    static const float positions[3][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}},
                       normals[3][3] = {{.6F, .8F, 0}, {.6F, .8F, 0}, {.6F, .8F, 0}},
                       times[3] = {0, 1, 2};
    static const double joints[3][4] = {{0}, {0, 1}, {1}}, weights[3][4] = {{1}, {.5, .5}, {1}};
    gltf_asset a = {0};
    norma_skin_info info;
    float of_keys[3][3], matrices[2][16];
    for (int k = 0; k < 3; ++k) {
        of_keys[k][0] = of_keys[k][2] = 1;
        of_keys[k][1] = scales[k];
    }
    for (int i = 0; i < 16; ++i) {
        matrices[0][i] = i % 5 == 0 ? 1 : 0;
        matrices[1][i] = (float)bind[i];
    }
    asset_floats(&a, &positions[0][0], 3, 3);
    asset_floats(&a, &normals[0][0], 3, 3);
    asset_numbers(&a, &joints[0][0], 3, 4, 5121, 0);
    asset_numbers(&a, &weights[0][0], 3, 4, 5126, 0);
    asset_floats(&a, times, 3, 1);
    asset_floats(&a, &of_keys[0][0], 3, 3);
    asset_floats(&a, &matrices[0][0], 2, 16);
    asset_floats(&a, turns, 3, 4);
    norma_document *document = asset_open(&a,
        "\"scene\":0,\"scenes\":[{\"nodes\":[0,1,2]}],\"nodes\":[{\"mesh\":0,\"skin\":0},{},{}],"
        "\"skins\":[{\"joints\":[1,2],\"inverseBindMatrices\":6}],\"meshes\":[{\"primitives\":[{"
        "\"attributes\":{\"POSITION\":0,\"NORMAL\":1,\"JOINTS_0\":2,\"WEIGHTS_0\":3}}]}],"
        "\"animations\":[{\"samplers\":[{\"input\":4,\"output\":5},{\"input\":4,\"output\":7}],"
        "\"channels\":[{\"sampler\":0,\"target\":{\"node\":2,\"path\":\"scale\"}},{\"sampler\":1,"
        "\"target\":{\"node\":2,\"path\":\"rotation\"}}]}]",
        1);
    assert_int_equal(norma_document_skin_info(document, 0, &info, NULL), NORMA_DOCUMENT_OK);
    if (findings) assert_int_equal(norma_check_document(document, NULL, findings, NULL), 0);
    norma_document_close(document);
    asset_free(&a);
    return info;
}

static const double UNBOUND[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
static const float UNTURNED[3][4] = {{0, 0, 0, 1}, {0, 0, 0, 1}, {0, 0, 0, 1}};

static void test_skin_errors(void **state) {
    (void)state;
    const double t = .75; /* of the normal (0.6, 0.8, 0) */
    norma_skin_info info = bent_skin((float[]){1, 3, 1}, UNBOUND, UNTURNED[0], NULL);
    /* The vertex on node 2 alone at 1 s: s = 3. That on both has s = 2. */
    assert_true(fabs(info.normal_error_rad * 180 / DEGREES_PI - error_of(3, t)) < 1e-5);
    assert_true(info.error_vertex == 2 && info.error_mesh == 0 && info.error_animation == 0);
    assert_true(info.error_time_s == 1 && info.keys == 3 && info.examined_keys == 3);
    info = bent_skin((float[]){1, 2, .25F}, UNBOUND, UNTURNED[0], NULL);
    assert_true(fabs(info.normal_error_rad * 180 / DEGREES_PI - error_of(.25, t)) < 1e-5);
    assert_true(info.error_vertex == 2 && info.error_time_s == 2);
    /* Bound at a stretch that the joint undoes at 1 s: nothing is wrong there, but at 0 and 2 s. */
    const double bound[16] = {1, 0, 0, 0, 0, .5, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    info = bent_skin((float[]){1.9F, 2, 6}, bound, UNTURNED[0], NULL);
    assert_true(fabs(info.normal_error_rad * 180 / DEGREES_PI - error_of(3, t)) < 1e-5);
    assert_true(info.error_vertex == 2 && info.error_time_s == 2);
    /* An even joint: nothing is measured. */
    info = bent_skin((float[]){1, 1, 1}, UNBOUND, UNTURNED[0], NULL);
    assert_true(isnan(info.normal_error_rad));
}

/* What stretches 1.2 times along y and turns by 150 degrees at 2 s: alone it errs as much as
 * unturned; the vertex on both joints more. Its matrix, twice, has the columns (1 + c, s, 0) and
 * (-1.2 s, 1 + 1.2 c, 0) of the cosine and sine. */
static void test_turned_skin_errors(void **state) {
    const double c = -sqrt(.75), s = .5, p = 1 + c, q = s, u = -1.2 * s, v = 1 + 1.2 * c, x = .6,
                 y = .8;
    const float turns[3][4] = {
        {0, 0, 0, 1}, {0, 0, 0, 1}, {0, 0, (float)sqrt((1 - c) / 2), (float)sqrt((1 + c) / 2)}};
    norma_findings *findings;
    (void)state;
    const norma_skin_info info = bent_skin((float[]){1, 1, 1.2F}, UNBOUND, turns[0], &findings);
    const double both =
        (atan2(q * x + v * y, p * x + u * y) - atan2(p * y - u * x, v * x - q * y)) * 180 /
        DEGREES_PI;
    assert_true(both > error_of(1.2, .75) + 3);
    assert_true(fabs(info.normal_error_rad * 180 / DEGREES_PI - both) < 1e-4);
    assert_true(info.error_vertex == 1 && info.error_time_s == 2);
    int told = 0;
    for (size_t i = 0; i < norma_findings_count(findings); ++i) {
        const norma_finding *finding = norma_findings_get(findings, i);
        if (strcmp(finding->rule->id, "N605") != 0) continue;
        told = 1;
        assert_non_null(strstr(finding->message, "errs by up to "));
        assert_non_null(
            strstr(finding->message, " degrees, at vertex 1 of mesh 0, in animation 0 at 2 s"));
    }
    assert_true(told);
    norma_findings_free(findings);
}

/* ---- tangents: islands, squares side by side, each of four vertices; v downwards, so that the
 * sign +1 is right */

enum { ISLANDS = 5, COUNT = 4 * ISLANDS };

typedef struct islands {
    float positions[COUNT][3], normals[COUNT][3], tangents[COUNT][4], uvs[COUNT][2];
    uint16_t corners[6 * ISLANDS];
    int unmapped; /* the material has no normal map */
} islands;

static void make_islands(islands *s) {
    s->unmapped = 0;
    for (int v = 0; v < COUNT; ++v) {
        const float *p = square[v % 4];
        memcpy(s->positions[v], (const float[3]){p[0] + 2.0F * (float)(v / 4), p[1], 0},
            sizeof s->positions[v]);
        memcpy(s->normals[v], up[0], sizeof up[0]);
        memcpy(s->tangents[v], (const float[4]){1, 0, 0, 1}, sizeof s->tangents[v]);
        memcpy(s->uvs[v], (const float[2]){p[0], 1 - p[1]}, sizeof s->uvs[v]);
    }
    for (int i = 0; i < ISLANDS; ++i)
        for (int k = 0; k < 6; ++k) s->corners[6 * i + k] = (uint16_t)(4 * i + corners[k]);
}

static void mirror_uvs(islands *s, int island) {
    for (int v = 4 * island; v < 4 * island + 4; ++v) s->uvs[v][0] = 1 - s->uvs[v][0];
}

static void set_signs(islands *s, int island, float sign) {
    for (int v = 4 * island; v < 4 * island + 4; ++v) s->tangents[v][3] = sign;
}

/* One texel, (128, 128, 255). */
#define FLAT_MAP                                                                                   \
    "\"textures\":[{\"source\":0}],\"images\":[{\"name\":\"bumps.png\",\"uri\":\"data:image/"      \
    "png;base64,"                                                                                  \
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAA"                                               \
    "AADElEQVR42mNoaPgPAAODAgA+WCglAAAAAElFTkSuQmCC\"}],"

static norma_findings *check_islands(const islands *s, int snorm8) {
    gltf_asset a = {0};
    asset_floats(&a, &s->positions[0][0], COUNT, 3);
    asset_floats(&a, &s->normals[0][0], COUNT, 3);
    asset_uint16(&a, s->corners, 6 * ISLANDS);
    if (snorm8)
        asset_snorm8(&a, &s->tangents[0][0], COUNT, 4);
    else
        asset_floats(&a, &s->tangents[0][0], COUNT, 4);
    asset_floats(&a, &s->uvs[0][0], COUNT, 2);
    char rest[700];
    snprintf(rest, sizeof rest,
        FLAT_MAP "\"materials\":[%s],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,"
                 "\"NORMAL\":1,\"TANGENT\":3,\"TEXCOORD_0\":4},\"indices\":2,\"material\":0}]}]",
        s->unmapped ? "{}" : "{\"normalTexture\":{\"index\":0}}");
    norma_findings *findings = check(asset_open(&a, rest, 1), MINE);
    asset_free(&a);
    return findings;
}

#define PRIMITIVE "/meshes/0/primitives/0"

/* Each names the map that is read through the tangents, and says first what is seen. */
static void test_tangent_words(void **state) {
    (void)state;
    islands s;
    make_islands(&s);
    s.tangents[7][0] = 2;
    expect_message(check_islands(&s, 0),
        "black spots, or light from a wrong side, through the normal map \"bumps.png\": 1 tangent "
        "with a component that is not finite or a length other than 1");
    make_islands(&s);
    s.tangents[7][3] = 2;
    expect_message(check_islands(&s, 0),
        "bumps of the normal map \"bumps.png\" become dents or have the wrong height: 1 tangent "
        "with a sign that is neither 1 nor -1");
    make_islands(&s);
    memcpy(s.tangents[17], (const float[4]){0, 0, -1, 1}, sizeof s.tangents[17]);
    expect_message(check_islands(&s, 0),
        "the normal map \"bumps.png\" bends light the wrong way: 1 tangent up to 90 degrees off "
        "perpendicular to the normal");
    make_islands(&s);
    for (int v = 0; v < 4; ++v) s.tangents[v][3] = -s.tangents[v][3];
    expect_message(check_islands(&s, 0),
        "bumps of the normal map \"bumps.png\" become dents in one of two groups: 4 tangents have "
        "the opposite of the sign that the UVs give, and 16 agree with the UVs");
}

static void test_tangent_lengths(void **state) {
    (void)state;
    islands s;
    make_islands(&s);
    assert_clean(check_islands(&s, 0));
    s.tangents[4][0] = 1.0004F; /* within */
    s.tangents[5][0] = 0.9996F;
    assert_clean(check_islands(&s, 0));
    s.tangents[7][0] = 1.01F;
    s.tangents[11][0] = 0;
    s.tangents[3][0] = 0.99F;
    FOUND(check_islands(&s, 0), {"N801", PRIMITIVE, E, 3, 1, "v3 v7 v11"});
    s.tangents[19][1] = NAN;
    FOUND(check_islands(&s, 0), {"N801", PRIMITIVE, E, 4, INFINITY, "v3 v7 v11 v19"});
    make_islands(&s);
    for (int v = 0; v < COUNT; ++v) { /* units that eight bits round to a length of up to 1.0068 */
        const double angle = 0.3 * v;
        s.tangents[v][0] = (float)cos(angle);
        s.tangents[v][1] = (float)sin(angle);
    }
    assert_clean(check_islands(&s, 1));
    s.tangents[6][0] = s.tangents[6][1] = 0.6F; /* .8485 */
    norma_findings *findings = check_islands(&s, 1);
    assert_true(norma_findings_count(findings) == 1 &&
                norma_findings_get(findings, 0)->count == 1 &&
                norma_findings_get(findings, 0)->samples[0].vertex == 6);
    norma_findings_free(findings);
}

static void test_tangent_signs_of_none(void **state) {
    (void)state;
    islands s;
    make_islands(&s);
    s.tangents[5][3] = 0.5F;
    s.tangents[9][3] = 0;
    s.tangents[13][3] = NAN;
    s.tangents[18][3] = -1.0001F;
    FOUND(check_islands(&s, 0), {"N802", PRIMITIVE, E, 4, NAN, "v5 v9 v13 v18"});
}

static void test_tangent_lean(void **state) {
    (void)state;
    islands s;
    make_islands(&s);
    memcpy(s.tangents[2], (const float[4]){(float)sqrt(1 - .11 * .11), 0, .11F, 1},
        sizeof s.tangents[2]);
    memcpy(s.tangents[6], (const float[4]){(float)sqrt(1 - .09 * .09), 0, .09F, 1},
        sizeof s.tangents[6]);
    memcpy(s.tangents[17], (const float[4]){0, 0, -1, 1}, sizeof s.tangents[17]);
    FOUND(check_islands(&s, 0), {"N803", PRIMITIVE, W, 2, 90, "v2 v17"});
    s.unmapped = 1; /* nothing is lit by them */
    FOUND(check_islands(&s, 0), {"N803", PRIMITIVE, I, 2, 90, "v2 v17"});
    s.unmapped = 0;
    memcpy(s.normals[2], (const float[3]){0, 0, NAN}, sizeof s.normals[2]); /* nothing to lean on */
    memset(s.normals[17], 0, sizeof s.normals[17]);
    assert_clean(check_islands(&s, 0));
}

static void test_tangent_windings(void **state) {
    (void)state;
    islands s;
    make_islands(&s);
    mirror_uvs(&s, 3);
    set_signs(&s, 3, -1); /* as it should be */
    assert_clean(check_islands(&s, 0));
    set_signs(&s, 2, -1);
    FOUND(check_islands(&s, 0), {"N804", PRIMITIVE, W, 4, NAN, "v8 v9 v10 v11"});
    s.unmapped = 1;
    FOUND(check_islands(&s, 0), {"N804", PRIMITIVE, I, 4, NAN, "v8 v9 v10 v11"});
    s.unmapped = 0;
    set_signs(&s, 2, 1);
    set_signs(&s, 3, 1); /* a mirrored twin that kept its sign */
    FOUND(check_islands(&s, 0), {"N804", PRIMITIVE, W, 4, NAN, "v12 v13 v14 v15"});
    for (int v = 12; v < 16; ++v)
        for (int k = 0; k < 2; ++k)
            s.uvs[v][k] = 0.125F + s.uvs[v][k] * 0x1p-20F; /* as small as it may be, it counts */
    FOUND(check_islands(&s, 0), {"N804", PRIMITIVE, W, 4, NAN, "v12 v13 v14 v15"});
    for (int v = 12; v < 16; ++v) s.uvs[v][1] = 0.5F; /* no area: no winding */
    assert_clean(check_islands(&s, 0));
    static const float last_digits[4][2] = {{0.3F, 0.7F}, {0.30000001192F + 0x1p-25F, 0.7F},
        {0.3F, 0.7F + 0x1p-24F},
        {0.3F - 0x1p-25F, 0.7F - 0x1p-24F}}; /* one point, but for rounding */
    memcpy(s.uvs[12], last_digits, sizeof last_digits);
    assert_clean(check_islands(&s, 0));

    make_islands(&s); /* the smaller side, whichever it is */
    for (int i = 0; i < 4; ++i) set_signs(&s, i, -1);
    FOUND(check_islands(&s, 0), {"N804", PRIMITIVE, W, 4, NAN, "v16 v17 v18 v19"});
    set_signs(&s, 4, -1); /* all */
    FOUND(check_islands(&s, 0), {"N804", PRIMITIVE, I, 20, NAN, "v0 v1 v2 v3 v4 v5 v6 v7 v8 v9"});
}

/* A vertex that faces of both windings share cannot be right for both: it is right as long as one
 * agrees. */
static void test_tangent_at_a_mirror_line(void **state) {
    (void)state;
    islands s;
    make_islands(&s);
    set_signs(&s, 1, -1);
    mirror_uvs(&s, 1);
    for (int k = 0; k < 6; ++k) /* island 1 hangs on the right edge of island 0 */
        s.corners[6 + k] = (uint16_t)(s.corners[6 + k] == 4   ? 1
                                      : s.corners[6 + k] == 7 ? 2
                                                              : s.corners[6 + k]);
    assert_clean(check_islands(&s, 0));
}

static norma_findings *check_surface(const char *attributes, const char *material) {
    islands s;
    char rest[1000];
    gltf_asset a = {0};
    make_islands(&s);
    asset_floats(&a, &s.positions[0][0], COUNT, 3);
    asset_floats(&a, &s.normals[0][0], COUNT, 3);
    asset_uint16(&a, s.corners, 6 * ISLANDS);
    asset_floats(&a, &s.tangents[0][0], COUNT, 4);
    asset_floats(&a, &s.uvs[0][0], COUNT, 2);
    snprintf(rest, sizeof rest,
        FLAT_MAP "\"materials\":[%s],\"meshes\":[{\"primitives\":[{\"attributes\":{%s},"
                 "\"indices\":2,\"material\":0}]}]",
        material, attributes);
    norma_findings *findings = check(asset_open(&a, rest, 1), MINE);
    asset_free(&a);
    return findings;
}

#define MAPPED "{\"normalTexture\":{\"index\":0}}"
#define SET_1  "{\"normalTexture\":{\"index\":0,\"texCoord\":1}}"
#define UNLIT  "{\"extensions\":{\"KHR_materials_unlit\":{}}}"

static void test_parts_of_tangents(void **state) {
    (void)state;
    assert_clean(
        check_surface("\"POSITION\":0,\"NORMAL\":1,\"TANGENT\":3,\"TEXCOORD_0\":4", MAPPED));
    FOUND(check_surface("\"POSITION\":0,\"NORMAL\":1,\"TEXCOORD_0\":4", MAPPED),
        {"N805", PRIMITIVE, I, 1, NAN, ""});
    assert_clean(check_surface("\"POSITION\":0,\"NORMAL\":1,\"TEXCOORD_0\":4", "{}"));
    FOUND(check_surface("\"POSITION\":0,\"TANGENT\":3,\"TEXCOORD_0\":4", "{}"),
        {"N104", PRIMITIVE, I, 10, NAN, "f0 f1 f2 f3 f4 f5 f6 f7 f8 f9"},
        {"N806", PRIMITIVE, W, 1, NAN, ""});
    norma_findings *ignored =
        check_surface("\"POSITION\":0,\"TANGENT\":3,\"TEXCOORD_0\":4", MAPPED);
    assert_int_equal(norma_findings_get(ignored, 1)->fix, NORMA_FIX_NONE); /* that of N806 is it */
    assert_null(strstr(norma_findings_get(ignored, 1)->message, "no tangents"));
    FOUND(ignored, {"N104", PRIMITIVE, I, 10, NAN, "f0 f1 f2 f3 f4 f5 f6 f7 f8 f9"},
        {"N805", PRIMITIVE, I, 1, NAN, ""}, {"N806", PRIMITIVE, W, 1, NAN, ""});
}

/* The set that the map names, not any set. */
static void test_map_without_texcoords(void **state) {
    (void)state;
    FOUND(check_surface("\"POSITION\":0,\"NORMAL\":1,\"TANGENT\":3,\"TEXCOORD_0\":4", SET_1),
        {"N813", PRIMITIVE, NORMA_SEVERITY_ERROR, 1, NAN, ""});
    FOUND(check_surface("\"POSITION\":0,\"NORMAL\":1,\"TANGENT\":3", MAPPED),
        {"N813", PRIMITIVE, NORMA_SEVERITY_ERROR, 1, NAN, ""});
    assert_clean(check_surface(
        "\"POSITION\":0,\"NORMAL\":1,\"TANGENT\":3,\"TEXCOORD_0\":4,\"TEXCOORD_1\":4", SET_1));
    assert_clean(check_surface("\"POSITION\":0,\"NORMAL\":1,\"TANGENT\":3", "{}"));
}

/* ---- normals there or not */

static void test_presence(void **state) {
    (void)state;
    FOUND(check_surface("\"POSITION\":0", "{}"),
        {"N104", PRIMITIVE, I, 10, NAN, "f0 f1 f2 f3 f4 f5 f6 f7 f8 f9"});
    assert_clean(check_surface("\"POSITION\":0", UNLIT));
    FOUND(check_surface("\"POSITION\":0,\"NORMAL\":1", UNLIT), {"N105", PRIMITIVE, I, 20, NAN, ""});
    /* Toon shaders of VRM avatars are lit, whatever their fallback says. */
    assert_clean(check_surface("\"POSITION\":0,\"NORMAL\":1",
        "{\"extensions\":{\"KHR_materials_unlit\":{},\"VRMC_materials_mtoon\":{}}}"));
    assert_clean(check_surface(
        "\"POSITION\":0", "{\"extras\":{\"norma\":{\"ignore\":[\"missing-normals\"]}}}"));
}

static norma_findings *check_counts(size_t normals, const char *extras) {
    static const uint16_t other_corners[6] = {
        0, 1, 2, 2, 1, 3}; /* the second face begins behind the first normal */
    gltf_asset a = {0};
    char rest[1000];
    asset_floats(&a, &square[0][0], 4, 3);
    asset_floats(&a, &up[0][0], normals, 3);
    asset_uint16(&a, other_corners, 6);
    snprintf(rest, sizeof rest, "\"meshes\":[{%s\"primitives\":[{" SURFACE "}]}]", extras);
    norma_findings *findings = check(asset_open(&a, rest, 1), MINE);
    asset_free(&a);
    return findings;
}

static void test_counts(void **state) {
    (void)state;
    assert_clean(check_counts(4, ""));
    FOUND(check_counts(2, ""), {"N106", PRIMITIVE, E, 2, NAN, "v2 v3"});
    FOUND(check_counts(1, ""), {"N106", PRIMITIVE, E, 3, NAN, "v1 v2 v3"});
    FOUND(check_counts(5, ""), {"N106", PRIMITIVE, E, 1, NAN, ""});
    assert_clean(check_counts(5, "\"extras\":{\"norma\":{\"ignore\":[\"N1\"]}},"));
}

static norma_document *open_text(const char *text, const char *name) {
    norma_document *document;
    norma_document_error error;
    const norma_document_options options = {.struct_size = sizeof options, .lenient = 1};
    if (norma_document_open_memory(text, strlen(text), name, &options, &document, &error))
        fail_msg("%s", error.message);
    return document;
}

static void test_obj_faces(void **state) {
    (void)state;
    static const char head[] = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvn 0 0 1\n";
    char text[1000];
    snprintf(text, sizeof text,
        "%sf 1//1 2//1 3//1\nf 1 2 3\nf 1//1 2 3//1\nf 1//0 2//0 3//0\nf 1//1 2//1 3//7\nf 1/1/ "
        "2// 3 4\nf 1//1 3//1 4//1\nf -4//-1 -2//-1 -1//-2\n",
        head);
    FOUND(check(open_text(text, "a.obj"), MINE), {"N104", "", W, 2, NAN, "f1 f5"},
        {"N106", "", E, 4, NAN, "f2 f3 f4 f7"});
    /* The message has what there is, and nothing of which there is none. */
    snprintf(text, sizeof text, "%sf 1//1 2//1 3//1\nf 1//1 3 4//1\n", head);
    norma_findings *partly = check(open_text(text, "a.obj"), "N106");
    assert_string_equal(norma_findings_get(partly, 0)->message,
        "shaded differently by each reader: 1 face with normals at some corners only");
    norma_findings_free(partly);
    snprintf(text, sizeof text, "%sf 1//1 2//1 3//1 4//1\n", head);
    assert_clean(check(open_text(text, "a.obj"), MINE));
    snprintf(text, sizeof text, "%sf 1 2 3 4\n", head);
    FOUND(check(open_text(text, "a.obj"), MINE), {"N104", "", I, 1, NAN, "f0"});
}

/* ---- morph targets */

/* A square that turns by angles about its edge in y = 0, as base positions and what a target adds.
 */
static norma_findings *check_morphs(
    const double *degrees, size_t targets, const char *more, const char *material, int snorm8) {
    gltf_asset a = {0};
    char rest[2000], list[1000] = "";
    if (snorm8) { /* positions as normalised integers, the moves as floats */
        asset_snorm8(&a, &square[0][0], 4, 3);
        asset_floats(&a, &up[0][0], 4, 3);
        asset_uint16(&a, corners, 6);
    } else {
        add_square(&a);
    }
    for (size_t t = 0; t < targets; ++t) {
        float moves[4][3] = {{0}};
        const double angle = degrees[t] * 0.017453292519943295;
        for (int v = 2; v < 4; ++v) {
            moves[v][1] = (float)(cos(angle) - 1);
            moves[v][2] = (float)sin(angle);
        }
        sprintf(list + strlen(list), "%s{\"POSITION\":%d%s}", t ? "," : "",
            asset_floats(&a, &moves[0][0], 4, 3), more);
    }
    snprintf(rest, sizeof rest,
        "\"materials\":[%s],\"meshes\":[{\"primitives\":[{" SURFACE
        ",\"material\":0,\"targets\":[%s]}]}]",
        material, list);
    norma_findings *findings = check(asset_open(&a, rest, 1), MINE);
    asset_free(&a);
    return findings;
}

static void test_bending_morphs(void **state) {
    (void)state;
    static const double six[] = {6}, under[] = {4.99}, several[] = {4, 6, 5.01, 0, 120};
    FOUND(check_morphs(six, 1, "", "{}", 0), {"N901", PRIMITIVE, I, 2, 6, "f0 f1"});
    assert_clean(check_morphs(under, 1, "", "{}", 0));
    assert_clean(check_morphs(six, 1, ",\"NORMAL\":1", "{}", 0));
    FOUND(
        check_morphs(several, 5, "", "{}", 0), {"N901", PRIMITIVE, W, 6, 120, "f0 f1 f0 f1 f0 f1"});
    static const double less[] = {29.9}, much[] = {30.1};
    FOUND(check_morphs(less, 1, "", "{}", 0), {"N901", PRIMITIVE, I, 2, 29.9, "f0 f1"});
    FOUND(check_morphs(much, 1, "", "{}", 0), {"N901", PRIMITIVE, W, 2, 30.1, "f0 f1"});
    FOUND(check_morphs(six, 1, "", UNLIT, 0), {"N105", PRIMITIVE, I, 4, NAN, ""});
    FOUND(check_morphs(six, 1, "", "{}", 1), {"N901", PRIMITIVE, I, 2, 6, "f0 f1"});
    assert_clean(check_morphs(under, 1, "", "{}", 1));
}

static norma_findings *check_deltas(const float *deltas, const char *base) {
    gltf_asset a = {0};
    char rest[1000];
    add_square(&a);
    asset_floats(&a, deltas, 4, 3);
    snprintf(rest, sizeof rest,
        "\"meshes\":[{\"primitives\":[{\"attributes\":{%s},\"indices\":2,\"targets\":[{},{"
        "\"NORMAL\":3},{\"NORMAL\":3}]}]}]",
        base);
    norma_findings *findings = check(asset_open(&a, rest, 1), MINE);
    asset_free(&a);
    return findings;
}

static void test_cancelling_morphs(void **state) {
    (void)state;
    static const float cancels[4][3] = {{0, 0, -2}, {0, 0, -0.89F}, {0, 0, -0.95F}, {0.5F, 0, -1}},
                       fine[4][3] = {{0, 0, -2}, {1, 0, -1}, {0, 0, 0}, {0, 0.1F, -1}};
    FOUND(check_deltas(&cancels[0][0], "\"POSITION\":0,\"NORMAL\":1"),
        {"N902", PRIMITIVE, W, 2, 0.05, "v2 v2"}); /* two targets */
    assert_clean(check_deltas(&fine[0][0], "\"POSITION\":0,\"NORMAL\":1"));
    FOUND(check_deltas(&fine[0][0], "\"POSITION\":0"), {"N104", PRIMITIVE, I, 2, NAN, "f0 f1"},
        {"N903", PRIMITIVE, E, 1, NAN, ""});
}

/* ---- files */

static void test_not_checked(void **state) {
    (void)state;
    static const char rest[] =
        "\"extensionsRequired\":[\"ACME_gizmo\"],\"meshes\":[{\"primitives\":[{" SURFACE
        "},{\"mode\":5," SURFACE
        ",\"extensions\":{\"KHR_draco_mesh_compression\":{\"bufferView\":0,"
        "\"attributes\":{}}}},{\"attributes\":{\"NORMAL\":1}}]}]";
    gltf_asset a = {0};
    add_square(&a);
    norma_findings *findings = check(asset_open(&a, rest, 1), MINE);
    assert_true(norma_findings_partly(findings));
    assert_string_equal(norma_findings_get(findings, 1)->label, "mesh 0 primitive 1");
    FOUND(findings, {"N002", "/extensionsRequired/0", W, 1, NAN, ""},
        {"N002", "/meshes/0/primitives/1", W, 1, NAN, ""},
        {"N002", "/meshes/0/primitives/2", W, 1, NAN, ""});
    findings = check(asset_open(&a, rest, 1), "N104"); /* a skip is one, whether asked for or not */
    assert_true(norma_findings_partly(findings));
    assert_clean(findings);
    findings = check(asset_open(&a, ONE_SIDE, 1), MINE);
    assert_false(norma_findings_partly(findings));
    assert_clean(findings);
    FOUND(
        check(asset_open(&a, "\"meshes\":[{\"primitives\":[{\"attributes\":{\"NORMAL\":1}}]}]", 1),
            MINE),
        {"N002", "/meshes/0/primitives/0", E, 1, NAN, ""});
    FOUND(check(asset_open(&a,
                    "\"meshes\":[{\"primitives\":[{" SURFACE "},{\"mode\":0," SURFACE
                    "},{\"mode\":3,\"attributes\":{\"POSITION\":0}}]}]",
                    1),
              MINE),
        {"N002", "/meshes/0/primitives/1", W, 1, NAN, ""});
    asset_free(&a);
}

/* A file goes on behind what its header declares. Padding holds nothing that could be checked. */
static void test_behind_the_end(void **state) {
    (void)state;
    enum { HEADER = 84, FACET = 50 };
#define PLY(encoding)                                                                              \
    "ply\nformat " encoding " 1.0\nelement vertex 3\nproperty uchar x\nproperty uchar y\n"         \
    "property uchar z\nelement face 1\nproperty list uchar uchar vertex_indices\nend_header\n"
    static const char rows[] = PLY("ascii") "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
                      more[] = PLY("ascii") "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n\n3 0 2 1\n",
                      blank[] = PLY("ascii") "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n \n\n",
                      codes[] = PLY("binary_little_endian") "@@@A@@@A@\3\0\1\2\n\0",
                      beyond[] = PLY("binary_little_endian") "@@@A@@@A@\3\0\1\2\3";
    static const struct {
        const char *text;
        size_t size;
        const char *where;
    } plys[] = {{rows, sizeof rows - 1, NULL}, {more, sizeof more - 1, "line 15"},
        {blank, sizeof blank - 1, NULL}, {codes, sizeof codes - 1, NULL},
        {beyond, sizeof beyond - 1, "byte 184"}};
    for (size_t i = 0; i < sizeof plys / sizeof *plys; ++i) {
        norma_findings *findings =
            check(scene_reopen((const unsigned char *)plys[i].text, plys[i].size, "a.ply"), "N002");
        if (!plys[i].where)
            assert_clean(findings);
        else
            FOUND(findings, {"N002", plys[i].where, W, 1, NAN, ""});
    }
    static const float facet[12] = {0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0};
    unsigned char stl[HEADER + 3 * FACET] = {0};
    memcpy(stl + HEADER, facet, sizeof facet);
    memcpy(stl + HEADER + FACET, facet, sizeof facet);
    stl[80] = 1;
    assert_clean(check(scene_reopen(stl, HEADER + FACET, "a.stl"), "N002"));
    FOUND(check(scene_reopen(stl, HEADER + 2 * FACET, "a.stl"), "N002"),
        {"N002", "byte 134", W, 1, NAN, ""});
    stl[80] = 2;
    assert_clean(check(scene_reopen(stl, HEADER + 3 * FACET - 1, "a.stl"), "N002"));
    FOUND(check(scene_reopen(stl, HEADER + 3 * FACET, "a.stl"), "N002"),
        {"N002", "byte 184", W, 1, NAN, ""}); /* a facet, though one of zeros */
    stl[80] = 0;
    FOUND(check(scene_reopen(stl, sizeof stl, "a.stl"), "N002"),
        {"N002", "byte 84", E, 1, NAN, ""}); /* nothing was checked */
}

/* Faces whose positions are no points are not checked; where there is nothing else, it is an error.
 */
static void test_faces_nowhere(void **state) {
    (void)state;
#define NOWHERE "v nan 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvn 0 0 1\n"
    static const char all[] = NOWHERE "f 1 2 3\n", some[] = NOWHERE "f 1 2 3\nf 2 3 4\n",
                      normals[] = NOWHERE "f 1//1 2//1 3//1\n";
    FOUND(check(scene_reopen((const unsigned char *)all, sizeof all - 1, "a.obj"), "N002"),
        {"N002", "", E, 1, NAN, "f0"});
    FOUND(check(scene_reopen((const unsigned char *)some, sizeof some - 1, "a.obj"), "N002"),
        {"N002", "", W, 1, NAN, "f0"});
    FOUND(check(scene_reopen((const unsigned char *)normals, sizeof normals - 1, "a.obj"), "N002"),
        {"N002", "", W, 1, NAN, "f0"});
    /* As many as there are faces, and not about them: tangents without data. */
    static const char tangents[] =
        "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":36,\"uri\":\"data:"
        "application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"
        "\"}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],\"accessors\":[{\"buffer"
        "View\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\",\"min\":[0,0,0],\""
        "max\":[1,1,0]},{\"componentType\":5126,\"count\":3,\"type\":\"VEC4\"}],\"meshes\""
        ":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"TANGENT\":1}}]}],\"nodes\":"
        "[{\"mesh\":0}],\"scenes\":[{\"nodes\":[0]}],\"scene\":0}";
    FOUND(
        check(scene_reopen((const unsigned char *)tangents, sizeof tangents - 1, "a.gltf"), "N002"),
        {"N002", "/meshes/0/primitives/0", W, 1, NAN, ""});
}

/* The message tells vertices that no face uses from those of degenerate faces. */
static void test_zeros_of_no_use(void **state) {
    (void)state;
    static const char text[] =
        "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty "
        "float z\nproperty float nx\nproperty float ny\nproperty float nz\nelement face "
        "2\nproperty list uchar int vertex_indices\nend_header\n0 0 0 0 0 1\n1 0 0 0 0 0\n0 1 0 0 "
        "0 1\n0 0 0 0 0 0\n1 0 0 0 0 0\n2 0 0 0 0 1\n5 5 5 0 0 0\n6 6 6 0 0 1\n3 0 1 2\n3 3 4 5\n";
    norma_findings *findings =
        check(scene_reopen((const unsigned char *)text, sizeof text - 1, "a.ply"), "N102");
    assert_string_equal(norma_findings_get(findings, 0)->message,
        "black spots: 4 zero-length normals; 2 used only by degenerate faces (N401); 1 used by no "
        "face");
    norma_findings_free(findings);
}

static void test_malformed_skin(void **state) {
    (void)state;
    norma_findings *findings = check_nodes(ONE_SIDE,
        "\"skins\":[{\"joints\":[0]},{\"joints\":[9]}],\"nodes\":[{\"mesh\":0,\"scale\":[1,2,1]}]");
    assert_true(norma_findings_partly(findings));
    FOUND(findings, {"N001", "/skins/1", E, 1, NAN, ""}, {"N601", "/nodes/0", I, 1, 2, ""},
        {"N605", "/skins/0", I, 1, 2, ""});
}

/* A small file that asks for a million million matrices is told of, soon. */
static void test_endless_skins(void **state) {
    (void)state;
    enum { SKINS = 300, ANIMATIONS = 300, KEYS = 3000, NODES = 300 };
    static float times[KEYS], scales[KEYS][3];
    gltf_asset a = {0};
    char *rest = malloc(400000 + NODES * 40 + SKINS * (NODES * 6 + 40)), *at = rest;
    assert_non_null(rest);
    for (int k = 0; k < KEYS; ++k) {
        times[k] = (float)k;
        scales[k][0] = scales[k][1] = 1;
        scales[k][2] = k == KEYS - 1 ? 2 : 1;
    }
    asset_floats(&a, times, KEYS, 1);
    asset_floats(&a, &scales[0][0], KEYS, 3);
    at += sprintf(at, "\"nodes\":[{}");
    for (int i = 1; i < NODES; ++i) at += sprintf(at, ",{\"children\":[%d]}", i - 1);
    at += sprintf(at, "],\"skins\":[");
    for (int i = 0; i < SKINS; ++i) {
        at += sprintf(at, "%s{\"joints\":[0", i ? "," : "");
        for (int k = 1; k < NODES; ++k) at += sprintf(at, ",%d", k);
        at += sprintf(at, "]}");
    }
    at += sprintf(at, "],\"animations\":[");
    for (int i = 0; i < ANIMATIONS; ++i)
        at += sprintf(at,
            "%s{\"samplers\":[{\"input\":0,\"output\":1}],\"channels\":[{\"sampler\":0,\"target\":{"
            "\"node\":%d,\"path\":\"scale\"}}]}",
            i ? "," : "", i % NODES);
    sprintf(at, "]");
    norma_findings *findings = check(asset_open(&a, rest, 1), MINE);
    assert_true(norma_findings_partly(findings) && norma_findings_count(findings) == SKINS);
    assert_string_equal(norma_findings_get(findings, SKINS - 1)->rule->id, "N002");
    norma_findings_free(findings);
    asset_free(&a);
    free(rest);
}

static void test_unreadable(void **state) {
    (void)state;
    const norma_document_error error = {
        .result = NORMA_DOCUMENT_ERROR_MALFORMED, .message = "a.glb:byte 0: expected more"};
    norma_findings *findings = norma_check_unreadable(&error, NORMA_FILE_GLB, NULL);
    assert_non_null(findings);
    assert_string_equal(norma_findings_get(findings, 0)->message, error.message);
    FOUND(findings, {"N001", "", E, 1, NAN, ""});
}

/* ---- arrays in memory */

static void test_arrays(void **state) {
    (void)state;
    static const float tangents[4][4] = {{1, 0, 0, 1}, {1, 0, 0, 2}, {1, 0, 0, 1}, {1, 0, 0, 1}};
    const norma_check_mesh mesh = {.info = {.name = "",
                                       .where = "/meshes/3/primitives/0",
                                       .mesh = 3,
                                       .vertices = 4,
                                       .faces = 2,
                                       .triangles = 2,
                                       .normals = NORMA_NORMALS_PER_VERTEX,
                                       .encoding = "float",
                                       .has_tangents = 1},
        .data = {.mesh = {.positions = {square, 4, 0, NORMA_FORMAT_FLOAT},
                     .corners = corners,
                     .corner_count = 6,
                     .corner_size = 2},
            .normals = {up, 4, 0, NORMA_FORMAT_FLOAT}},
        .attributes = {.material = SIZE_MAX,
            .tangents = &tangents[0][0],
            .tangent_count = 4,
            .tangent_encoding = "float"},
        .material = {.double_sided = 1}};
    const norma_node_info nodes[2] = {
        {.name = "one",
            .where = "/nodes/7",
            .node = 7,
            .mesh = 3,
            .instances = 1,
            .skin = SIZE_MAX,
            .world = {-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}},
        {.name = "set",
            .where = "/nodes/8",
            .node = 8,
            .mesh = 4,
            .instances = 5,
            .mirrored_instances = 2,
            .skin = SIZE_MAX,
            .world = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}}};
    const norma_skin_info skin = {
        .name = "", .where = "/skins/0", .joint_count = 1, .anisotropy = 1.2, .joint = 9};
    const norma_check_scene scene = {.meshes = &mesh,
        .mesh_count = 1,
        .nodes = nodes,
        .node_count = 2,
        .skins = &skin,
        .skin_count = 1,
        .format = NORMA_FILE_GLTF};
    uint8_t mask[128] = {0};
    assert_int_equal(norma_rules_select(MINE, mask, NULL), NORMA_OK);
    const norma_check_options options = {.struct_size = sizeof options, .rules = mask};
    norma_findings *findings;
    assert_int_equal(norma_check_scene_run(&scene, &options, &findings), NORMA_OK);
    FOUND(findings, {"N802", "/meshes/3/primitives/0", E, 1, NAN, "v1"},
        {"N602", "/nodes/7", W, 1, -1, ""}, {"N602", "/nodes/8", W, 2, NAN, ""},
        {"N605", "/skins/0", I, 1, 1.2, ""});
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_mirrored),
        cmocka_unit_test(test_sheared),
        cmocka_unit_test(test_uneven),
        cmocka_unit_test(test_singular),
        cmocka_unit_test(test_instances),
        cmocka_unit_test(test_tile_instances),
        cmocka_unit_test(test_ignored_nodes),
        cmocka_unit_test(test_joints),
        cmocka_unit_test(test_skin_errors),
        cmocka_unit_test(test_turned_skin_errors),
        cmocka_unit_test(test_tangent_words),
        cmocka_unit_test(test_tangent_lengths),
        cmocka_unit_test(test_tangent_signs_of_none),
        cmocka_unit_test(test_tangent_lean),
        cmocka_unit_test(test_tangent_windings),
        cmocka_unit_test(test_tangent_at_a_mirror_line),
        cmocka_unit_test(test_parts_of_tangents),
        cmocka_unit_test(test_map_without_texcoords),
        cmocka_unit_test(test_presence),
        cmocka_unit_test(test_counts),
        cmocka_unit_test(test_obj_faces),
        cmocka_unit_test(test_bending_morphs),
        cmocka_unit_test(test_cancelling_morphs),
        cmocka_unit_test(test_not_checked),
        cmocka_unit_test(test_malformed_skin),
        cmocka_unit_test(test_endless_skins),
        cmocka_unit_test(test_behind_the_end),
        cmocka_unit_test(test_faces_nowhere),
        cmocka_unit_test(test_zeros_of_no_use),
        cmocka_unit_test(test_unreadable),
        cmocka_unit_test(test_arrays),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
