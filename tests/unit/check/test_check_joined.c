/* Components, and seams, over the primitives of one glTF mesh: a body that is cut by material is
 * closed, a cavity lies in a shell of another material, bodies that touch stay apart. Found at the
 * primitive of the first face, mended there and in the others. Known by hand. */
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

/* ---- boxes, a side at a time */

enum { MOST = 200 };
typedef struct part {
    float positions[MOST][3];
    uint16_t corners[MOST];
    size_t vertices, count;
} part;

/* Sides 0 to 5 of a box: -x, +x, -y, +y, -z, +z; looking outward, or inward. */
static void add_side(part *p, const float low[3], const float high[3], int side, int inward) {
    const int axis = side / 2, u = (axis + 1) % 3, v = (axis + 2) % 3, up = side % 2;
    static const int square[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    const size_t first = p->vertices;
    for (int i = 0; i < 4; ++i) {
        float *to = p->positions[p->vertices++];
        to[axis] = up ? high[axis] : low[axis];
        to[u] = square[i][0] ? high[u] : low[u];
        to[v] = square[i][1] ? high[v] : low[v];
    }
    const int turned = (up == 0) != (inward != 0);
    for (int t = 0; t < 2; ++t) {
        p->corners[p->count++] = (uint16_t)first;
        p->corners[p->count++] = (uint16_t)(first + (size_t)(turned ? t + 2 : t + 1));
        p->corners[p->count++] = (uint16_t)(first + (size_t)(turned ? t + 1 : t + 2));
    }
}

static void add_box(part *p, float from, float to, int inward) {
    const float low[3] = {from, from, from}, high[3] = {to, to, to};
    for (int side = 0; side < 6; ++side) add_side(p, low, high, side, inward);
}

/* One mesh with these for primitives. */
static norma_document *open_parts(gltf_asset *a, const part *parts, int count) {
    char rest[2000] = "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[";
    for (int i = 0; i < count; ++i) {
        char primitive[100];
        const int positions = asset_floats(a, &parts[i].positions[0][0], parts[i].vertices, 3),
                  corners = asset_uint16(a, parts[i].corners, parts[i].count);
        snprintf(primitive, sizeof primitive, "%s{\"attributes\":{\"POSITION\":%d},\"indices\":%d}",
            i ? "," : "", positions, corners);
        strcat(rest, primitive);
    }
    strcat(rest, "]}]");
    return asset_open(a, rest, 1);
}

/* ---- what is found */

typedef struct expected {
    const char *rule, *where;
    size_t count, face; /* of the first sample */
    norma_severity severity;
} expected;

static void has_only(norma_document *document, const expected *wanted, size_t count) {
    uint8_t mask[128] = {0};
    norma_findings *findings;
    assert_int_equal(norma_rules_select("N302,N304", mask, NULL), NORMA_OK);
    const norma_check_options options = {.struct_size = sizeof options, .rules = mask};
    assert_int_equal(norma_check_document(document, &options, &findings, NULL), NORMA_DOCUMENT_OK);
    assert_int_equal(norma_findings_count(findings), count);
    for (size_t i = 0; i < count; ++i) {
        const norma_finding *f = norma_findings_get(findings, i);
        assert_string_equal(f->rule->id, wanted[i].rule);
        assert_string_equal(f->where, wanted[i].where);
        assert_int_equal(f->count, wanted[i].count);
        assert_int_equal(f->severity, wanted[i].severity);
        assert_int_equal(f->samples[0].face, wanted[i].face);
    }
    norma_findings_free(findings);
}

/* How many edges are open (N307) in all primitives together. */
static void has_open_edges(norma_document *document, norma_check_profile profile, size_t count) {
    uint8_t mask[128] = {0};
    norma_findings *findings;
    size_t sum = 0;
    assert_int_equal(norma_rules_select("N307", mask, NULL), NORMA_OK);
    const norma_check_options options = {
        .struct_size = sizeof options, .rules = mask, .profile = profile};
    assert_int_equal(norma_check_document(document, &options, &findings, NULL), NORMA_DOCUMENT_OK);
    for (size_t i = 0; i < norma_findings_count(findings); ++i)
        sum += norma_findings_get(findings, i)->count;
    assert_int_equal(sum, count);
    norma_findings_free(findings);
}

/* Mended by N302, then clean, and every corner of every face where it was but for the reversed
 * ones; again: nothing. rays: open ones too. */
static void mends(norma_document *document, int rays, const char *rules, uint8_t (*turned)[MOST],
    const part *parts, int count) {
    uint8_t mask[128] = {0};
    norma_fix_summary summary;
    size_t size;
    assert_int_equal(norma_rules_select(rules, mask, NULL), NORMA_OK);
    const norma_check_options options = {
        .struct_size = sizeof options, .rules = mask, .open_by_rays = rays};
    assert_int_equal(norma_fix_document(document, &options, 1, &summary, NULL), NORMA_DOCUMENT_OK);
    assert_int_equal(summary.changed, 1);
    unsigned char *bytes = scene_output(document, &size);
    document = scene_reopen(bytes, size, "a.glb");
    for (int i = 0; i < count; ++i) {
        norma_mesh_data data;
        assert_int_equal(
            norma_document_mesh_data(document, (size_t)i, &data, NULL), NORMA_DOCUMENT_OK);
        assert_int_equal(data.mesh.corner_count, parts[i].count);
        for (size_t c = 0; c < parts[i].count; ++c) {
            const size_t from = !turned[i][c / 3] || c % 3 == 0 ? c : c % 3 == 1 ? c + 1 : c - 1;
            assert_int_equal(((const uint32_t *)data.mesh.corners)[c], parts[i].corners[from]);
        }
    }
    assert_int_equal(norma_fix_document(document, &options, 1, &summary, NULL), NORMA_DOCUMENT_OK);
    assert_int_equal(summary.changed, 0);
    if (rays) assert_true(summary.by_rays > 0 && summary.least_confidence > 0);
    norma_document_close(document);
    free(bytes);
}

/* ---- a box of three materials */

static const float low[3] = {0, 0, 0}, high[3] = {1, 2, 3};

static void cut_box(part parts[3], int inward) {
    memset(parts, 0, 3 * sizeof *parts);
    for (int side = 0; side < 6; ++side) add_side(&parts[side / 2], low, high, side, inward);
}

static void test_cut(void **state) {
    (void)state;
    static part parts[3];
    static uint8_t all[3][MOST] = {{1, 1, 1, 1}, {1, 1, 1, 1}, {1, 1, 1, 1}};
    for (int inward = 0; inward < 2; ++inward) {
        gltf_asset a = {0};
        cut_box(parts, inward);
        norma_document *document = open_parts(&a, parts, 3);
        has_only(document,
            &(expected){"N302", "/meshes/0/primitives/0", 1, 0, NORMA_SEVERITY_WARNING},
            (size_t)inward);
        has_open_edges(document, NORMA_CHECK_PROFILE_PRINT, 0);
        if (inward) mends(document, 0, "N302", all, parts, 3);
        norma_document_close(document);
        asset_free(&a);
    }
}

/* A side is missing: open, told of once, at the first side's face beside it. */
static void test_open(void **state) {
    (void)state;
    static part parts[2];
    gltf_asset a = {0};
    memset(parts, 0, sizeof parts);
    for (int side = 0; side < 5; ++side) add_side(&parts[side > 1], low, high, side, 0);
    norma_document *document = open_parts(&a, parts, 2);
    has_only(document, &(expected){"N304", "/meshes/0/primitives/0", 1, 1, NORMA_SEVERITY_INFO}, 1);
    has_open_edges(document, NORMA_CHECK_PROFILE_PRINT, 4);
    has_open_edges(document, NORMA_CHECK_PROFILE_RENDER, 0);
    norma_document_close(document);
    asset_free(&a);
}

/* Open ones are turned by rays where that is asked for, the whole of them. */
static void test_rays(void **state) {
    (void)state;
    static part parts[2];
    static uint8_t all[2][MOST] = {{1, 1, 1, 1}, {1, 1, 1, 1, 1, 1}};
    gltf_asset a = {0};
    norma_fix_summary summary;
    memset(parts, 0, sizeof parts);
    for (int side = 0; side < 5; ++side) add_side(&parts[side > 1], low, high, side, 1);
    norma_document *document = open_parts(&a, parts, 2);
    uint8_t mask[128] = {0};
    assert_int_equal(norma_rules_select("N304,N302", mask, NULL), NORMA_OK);
    norma_check_options options = {.struct_size = sizeof options, .rules = mask};
    assert_int_equal(norma_fix_document(document, &options, 1, &summary, NULL),
        NORMA_DOCUMENT_OK); /* only when asked */
    assert_int_equal(summary.changed, 0);
    options.open_by_rays = 1;
    assert_int_equal(norma_fix_document(document, &options, 0, &summary, NULL),
        NORMA_DOCUMENT_OK); /* and not by what is safe */
    assert_int_equal(summary.changed, 0);
    mends(document, 1, "N304", all, parts, 2);
    norma_document_close(document);
    asset_free(&a);
}

/* A room of one material beside an open box of another: closed, whatever touches it, so that it is
 * not turned with what is open. */
static void test_room(void **state) {
    (void)state;
    static part parts[2];
    static const float beside_low[3] = {1, 0, 0}, beside_high[3] = {2, 1, 1};
    gltf_asset a = {0};
    norma_fix_summary summary;
    uint8_t mask[128] = {0};
    memset(parts, 0, sizeof parts);
    for (int side = 1; side < 6; ++side) add_side(&parts[0], beside_low, beside_high, side, 0);
    add_box(&parts[1], 0, 1, 1);
    norma_document *document = open_parts(&a, parts, 2);
    const expected wanted[] = {{"N304", "/meshes/0/primitives/0", 1, 7, NORMA_SEVERITY_INFO},
        {"N302", "/meshes/0/primitives/1", 1, 0, NORMA_SEVERITY_WARNING}};
    has_only(document, wanted, 2);
    assert_int_equal(norma_rules_select("N304", mask, NULL), NORMA_OK);
    const norma_check_options options = {
        .struct_size = sizeof options, .rules = mask, .open_by_rays = 1};
    assert_int_equal(norma_fix_document(document, &options, 1, &summary, NULL), NORMA_DOCUMENT_OK);
    assert_int_equal(summary.changed, 0);
    norma_document_close(document);
    asset_free(&a);
}

/* ---- a shell of one material, its cavity of another */

static void test_cavity(void **state) {
    (void)state;
    static part parts[2];
    for (int outer = 0; outer < 2; ++outer)
        for (int inner = 0; inner < 2; ++inner) { /* nonzero: looks inward */
            gltf_asset a = {0};
            memset(parts, 0, sizeof parts);
            add_box(&parts[0], 0, 3, outer);
            add_box(&parts[1], 1, 2, inner);
            norma_document *document = open_parts(&a, parts, 2);
            /* The shell first; then what lies in it, taken as put right: a cavity is fine, a solid
             * may be meant. */
            expected wanted[2];
            size_t count = 0;
            if (outer)
                wanted[count++] =
                    (expected){"N302", "/meshes/0/primitives/0", 1, 0, NORMA_SEVERITY_WARNING};
            if (!inner)
                wanted[count++] =
                    (expected){"N302", "/meshes/0/primitives/1", 1, 0, NORMA_SEVERITY_INFO};
            has_only(document, wanted, count);
            norma_document_close(document);
            asset_free(&a);
        }
}

/* The faces from begin to end are the samples of the one N302, the first that stands for all ahead;
 * without the option that one alone. */
static void has_whole_component(norma_document *document, size_t begin, size_t end) {
    uint8_t mask[128] = {0};
    norma_findings *findings;
    assert_int_equal(norma_rules_select("N302", mask, NULL), NORMA_OK);
    for (int whole = 0; whole < 2; ++whole) {
        const norma_check_options options = {.struct_size = sizeof options,
            .rules = mask,
            .max_samples = 100,
            .whole_components = whole};
        assert_int_equal(
            norma_check_document(document, &options, &findings, NULL), NORMA_DOCUMENT_OK);
        assert_int_equal(norma_findings_count(findings), 1);
        const norma_finding *f = norma_findings_get(findings, 0);
        uint8_t seen[MOST] = {0};
        assert_int_equal(f->count, 1);
        assert_int_equal(f->sample_count, whole ? end - begin : 1);
        assert_int_equal(f->samples[0].face, begin);
        assert_true(f->worst.face == begin);
        for (size_t i = 0; i < f->sample_count; ++i) {
            assert_in_range(f->samples[i].face, begin, end - 1);
            assert_int_equal(seen[f->samples[i].face]++, 0);
        }
        norma_findings_free(findings);
    }
}

/* ---- two boxes, each closed in its own primitive, that share an edge: one of them looks inward */

static void test_touching(void **state) {
    (void)state;
    static part parts[2];
    static uint8_t turned[2][MOST];
    static const float beside[3] = {1, 2, 0}, end[3] = {2, 4, 3};
    gltf_asset a = {0};
    memset(parts, 0, sizeof parts);
    for (int side = 0; side < 6; ++side) {
        add_side(&parts[0], low, high, side, 0);
        add_side(&parts[1], beside, end, side, 1);
    }
    memset(turned[1], 1, sizeof turned[1]);
    norma_document *document = open_parts(&a, parts, 2);
    has_only(
        document, &(expected){"N302", "/meshes/0/primitives/1", 1, 0, NORMA_SEVERITY_WARNING}, 1);
    has_whole_component(document, 0, 12);
    mends(document, 0, "N302", turned, parts, 2);
    norma_document_close(document);
    asset_free(&a);
}

/* Of two boxes in one primitive the one that looks inward is turned, and no other. */
static void test_one_of_two(void **state) {
    (void)state;
    static part parts[1];
    static uint8_t turned[1][MOST];
    gltf_asset a = {0};
    memset(parts, 0, sizeof parts);
    add_box(&parts[0], 0, 1, 0);
    add_box(&parts[0], 2, 3, 1);
    memset(turned[0] + 12, 1, 12);
    norma_document *document = open_parts(&a, parts, 1);
    has_only(
        document, &(expected){"N302", "/meshes/0/primitives/0", 1, 12, NORMA_SEVERITY_WARNING}, 1);
    has_whole_component(document, 12, 24);
    mends(document, 0, "N302", turned, parts, 1);
    norma_document_close(document);
    asset_free(&a);
}

/* ---- options of other headers than this: blocks of their sizes, so that a reader beyond is seen
 */

static void takes(norma_document *document, size_t size, size_t said, int surplus, int good) {
    norma_check_options options = {.struct_size = said, .max_samples = 100, .whole_components = 1};
    unsigned char *block = calloc(size, 1);
    norma_findings *findings = NULL;
    norma_fix_summary summary;
    memcpy(block, &options, size < sizeof options ? size : sizeof options);
    if (size > sizeof options) block[size - 1] = (unsigned char)surplus;
    const norma_check_options *given = (const norma_check_options *)(const void *)block;
    const norma_document_result wanted = good ? NORMA_DOCUMENT_OK : NORMA_DOCUMENT_ERROR_ARGUMENT;
    assert_int_equal(norma_check_document(document, given, &findings, NULL), wanted);
    for (size_t i = 0; i < norma_findings_count(findings); ++i) {
        const norma_finding *f = norma_findings_get(findings, i);
        if (strcmp(f->rule->id, "N302") == 0)
            assert_int_equal(f->sample_count, size < sizeof options ? 1 : 12);
    }
    assert_int_equal(norma_findings_count(findings) > 0, good);
    norma_findings_free(findings);
    assert_int_equal(norma_fix_document(document, given, 0, &summary, NULL), wanted);
    free(block);
}

static void test_other_headers(void **state) {
    (void)state;
    static part parts[1];
    gltf_asset a = {0};
    const size_t first = offsetof(norma_check_options, whole_components),
                 size = sizeof(norma_check_options);
    memset(parts, 0, sizeof parts);
    add_box(&parts[0], 0, 1, 0);
    add_box(&parts[0], 2, 3, 1);
    norma_document *document = open_parts(&a, parts, 1);
    takes(document, first, first, 0, 1);
    takes(document, first, 0, 0, 1);
    takes(document, size, size, 0, 1);
    takes(document, size + 8, size + 8, 0, 1);
    takes(document, size + 8, size + 8, 1, 0);
    norma_document_close(document);
    asset_free(&a);
}

/* ---- a quarter of a cylinder of two materials: at the border the second one's normals are turned
 * by five degrees */

enum { COLUMNS = 7, ROWS = 5, STRIP = COLUMNS * ROWS };
static const double QUARTER = 1.5707963267948966, TURNED = 0.08726646259971647;

static norma_document *open_cylinder(gltf_asset *a, float normals[2][STRIP][3]) {
    float positions[2][STRIP][3];
    uint16_t corners[6 * (COLUMNS - 1) * (ROWS - 1)];
    size_t count = 0;
    for (int half = 0; half < 2; ++half)
        for (int y = 0; y < ROWS; ++y)
            for (int x = 0; x < COLUMNS; ++x) {
                const double angle = QUARTER * (half * (COLUMNS - 1) + x) / (2 * COLUMNS - 2),
                             shaded = angle + (half == 1 && x == 0 ? TURNED : 0);
                const float position[3] = {(float)cos(angle), (float)y / 4, (float)-sin(angle)},
                            normal[3] = {(float)cos(shaded), 0, (float)-sin(shaded)};
                memcpy(positions[half][y * COLUMNS + x], position, sizeof position);
                memcpy(normals[half][y * COLUMNS + x], normal, sizeof normal);
            }
    for (int y = 0; y + 1 < ROWS; ++y)
        for (int x = 0; x + 1 < COLUMNS; ++x) {
            const int at = y * COLUMNS + x,
                      quad[6] = {at, at + 1, at + COLUMNS + 1, at, at + COLUMNS + 1, at + COLUMNS};
            for (int k = 0; k < 6; ++k) corners[count++] = (uint16_t)quad[k];
        }
    for (int half = 0; half < 2; ++half) {
        asset_floats(a, &positions[half][0][0], STRIP, 3);
        asset_floats(a, &normals[half][0][0], STRIP, 3);
    }
    asset_uint16(a, corners, count);
    return asset_open(a,
        "\"nodes\":[{\"mesh\":0}],\"materials\":[{},{}],\"meshes\":[{\"primitives\":[{\"material\":"
        "0,\"attributes\":{\"POSITION\":0,\"NORMAL\":1},\"indices\":4},"
        "{\"material\":1,\"attributes\":{\"POSITION\":2,\"NORMAL\":3},\"indices\":4}]}]",
        1);
}

static size_t count_seams(norma_document *document) {
    uint8_t mask[128] = {0};
    norma_findings *findings;
    size_t count = 0;
    assert_int_equal(norma_rules_select("N501", mask, NULL), NORMA_OK);
    const norma_check_options options = {.struct_size = sizeof options, .rules = mask};
    assert_int_equal(norma_check_document(document, &options, &findings, NULL), NORMA_DOCUMENT_OK);
    for (size_t i = 0; i < norma_findings_count(findings); ++i)
        count += norma_findings_get(findings, i)->count;
    norma_findings_free(findings);
    return count;
}

/* Both sides get the whole surface's normal, which is the cylinder's where it goes on alike on both
 * sides; the ends of the border, where it is open, and all else stay. */
static void test_seam(void **state) {
    (void)state;
    gltf_asset a = {0};
    float normals[2][STRIP][3];
    uint8_t mask[128] = {0};
    norma_fix_summary summary;
    size_t size;
    norma_document *document = open_cylinder(&a, normals);
    assert_int_equal(count_seams(document), ROWS - 2);
    assert_int_equal(norma_rules_select("N501", mask, NULL), NORMA_OK);
    const norma_check_options options = {.struct_size = sizeof options, .rules = mask};
    assert_int_equal(norma_fix_document(document, &options, 1, &summary, NULL), NORMA_DOCUMENT_OK);
    unsigned char *bytes = scene_output(document, &size);
    norma_document_close(document);
    document = scene_reopen(bytes, size, "a.glb");
    assert_int_equal(count_seams(document), 0);
    assert_int_equal(norma_fix_document(document, &options, 1, &summary, NULL), NORMA_DOCUMENT_OK);
    assert_int_equal(summary.changed, 0);
    for (int half = 0; half < 2; ++half) {
        norma_mesh_data data;
        assert_int_equal(
            norma_document_mesh_data(document, (size_t)half, &data, NULL), NORMA_DOCUMENT_OK);
        for (int v = 0; v < STRIP; ++v) {
            const float *n = (const float *)data.normals.data + 3 * v;
            const int row = v / COLUMNS, border = v % COLUMNS == (half == 0 ? COLUMNS - 1 : 0) &&
                                                  row > 0 && row + 1 < ROWS;
            if (!border)
                assert_memory_equal(n, normals[half][v], sizeof normals[half][v]);
            else
                assert_true(fabs((double)n[0] - cos(QUARTER / 2)) < 1e-6 &&
                            fabs((double)n[1]) < 1e-6 &&
                            fabs((double)n[2] + sin(QUARTER / 2)) < 1e-6);
        }
    }
    norma_document_close(document);
    free(bytes);
    asset_free(&a);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_cut),
        cmocka_unit_test(test_open),
        cmocka_unit_test(test_rays),
        cmocka_unit_test(test_room),
        cmocka_unit_test(test_cavity),
        cmocka_unit_test(test_touching),
        cmocka_unit_test(test_one_of_two),
        cmocka_unit_test(test_other_headers),
        cmocka_unit_test(test_seam),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
