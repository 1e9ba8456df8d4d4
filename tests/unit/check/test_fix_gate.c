/* Fixes that would do harm are left out, and those only: the rule that would report more, selected
 * or not, or the edges that would come open, are known by hand. */
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

static norma_check_options select(const char *rules, uint8_t mask[128]) {
    memset(mask, 0, 128);
    assert_int_equal(norma_rules_select(rules, mask, NULL), NORMA_OK);
    return (norma_check_options){.struct_size = sizeof(norma_check_options), .rules = mask};
}

static norma_fix_summary fix(norma_document *document, const char *rules) {
    uint8_t mask[128];
    norma_fix_summary summary;
    norma_document_error error;
    const norma_check_options options = select(rules, mask);
    if (norma_fix_document(document, &options, 1, &summary, &error)) fail_msg("%s", error.message);
    return summary;
}

static size_t count_of(norma_document *document, const char *rules) {
    uint8_t mask[128];
    norma_findings *findings;
    size_t count = 0;
    const norma_check_options options = select(rules, mask);
    assert_int_equal(norma_check_document(document, &options, &findings, NULL), NORMA_DOCUMENT_OK);
    for (size_t i = 0; i < norma_findings_count(findings); ++i)
        count += norma_findings_get(findings, i)->count;
    norma_findings_free(findings);
    return count;
}

static int has_note(const norma_document *document, const char *first, const char *second) {
    for (size_t i = 0; i < norma_document_note_count(document); ++i)
        if (strstr(norma_document_note(document, i), first) &&
            strstr(norma_document_note(document, i), second))
            return 1;
    return 0;
}

/* A concave polygon, and a face that is one of the triangles that it would be cut into: cut, that
 * one would be there twice (N305). A bent square can be cut. */
static const char polygons[] =
    "v 0 0 0\nv 4 0 0\nv 4 4 0\nv 2 1 0\nv 0 4 0\nv 6 0 0\nv 8 0 0\nv 8 2 .5\nv 6 2 0\n"
    "f 5 1 2 3 4\nf 1 2 4\nf 6 7 8 9\n";

static void only_the_fix_that_harms_is_left_out(void **state) {
    (void)state;
    norma_document *document = scene_of_obj(polygons);
    assert_int_equal(count_of(document, "N404"), 1);
    assert_true(count_of(document, "N405") > 0);
    norma_fix_summary summary = fix(document, "N404,N405");
    assert_int_equal(summary.changed, 1);
    assert_int_equal(summary.left_out, 1);
    assert_true(has_note(document, "N404 bad-polygon is not fixed", "N305"));
    assert_int_equal(count_of(document, "N404"), 1);
    assert_int_equal(count_of(document, "N405"), 0);
    assert_int_equal(count_of(document, "N305"), 0);
    summary = fix(document, "N404,N405");
    assert_int_equal(summary.changed, 0);
    assert_int_equal(summary.left_out, 1);
    norma_document_close(document);
}

/* N305 is not selected, and counts all the same. */
static void a_rule_that_is_not_selected_counts(void **state) {
    (void)state;
    size_t size;
    norma_document *document = scene_of_obj(polygons);
    const norma_fix_summary summary = fix(document, "N404");
    assert_int_equal(summary.changed, 0);
    assert_int_equal(summary.left_out, 1);
    unsigned char *bytes = scene_output(document, &size);
    assert_int_equal(size, strlen(polygons));
    assert_memory_equal(bytes, polygons, size);
    free(bytes);
    norma_document_close(document);
}

/* A rule that reports something already may not report more of it. */
static void a_count_may_not_grow(void **state) {
    (void)state;
    char text[400];
    snprintf(
        text, sizeof text, "%sv 20 0 0\nv 21 0 0\nv 20 1 0\nf 10 11 12\nf 10 11 12\n", polygons);
    norma_document *document = scene_of_obj(text);
    assert_int_equal(count_of(document, "N305"), 1);
    const norma_fix_summary summary = fix(document, "N404");
    assert_int_equal(summary.changed, 0);
    assert_int_equal(summary.left_out, 1);
    norma_document_close(document);
}

/* Without that face there is no harm, and nothing is left out. */
static void what_does_no_harm_is_done(void **state) {
    (void)state;
    static const char text[] = "v 0 0 0\nv 4 0 0\nv 4 4 0\nv 2 1 0\nv 0 4 0\nf 5 1 2 3 4\n";
    norma_document *document = scene_of_obj(text);
    const norma_fix_summary summary = fix(document, "N404");
    assert_int_equal(summary.changed, 1);
    assert_int_equal(summary.left_out, 0);
    assert_int_equal(norma_document_note_count(document), 0);
    assert_int_equal(count_of(document, "N404"), 0);
    norma_document_close(document);
}

/* ---- glTF: primitives */

typedef struct primitive {
    const float (*positions)[3];
    size_t vertices;
    const uint16_t *corners;
    size_t count;
} primitive;

static norma_document *open_primitives(gltf_asset *a, const primitive *list, int count) {
    char rest[1000] = "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[", text[100];
    for (int i = 0; i < count; ++i) {
        const int positions = asset_floats(a, &list[i].positions[0][0], list[i].vertices, 3),
                  corners = asset_uint16(a, list[i].corners, list[i].count);
        snprintf(text, sizeof text, "%s{\"attributes\":{\"POSITION\":%d},\"indices\":%d}",
            i ? "," : "", positions, corners);
        strcat(rest, text);
    }
    strcat(rest, "]}]");
    return asset_open(a, rest, 1);
}

/* In the first primitive two faces become the same one where almost equal positions become equal,
 * in the second two faces come to share an edge: there the fix is made. */
static void a_fix_is_left_out_where_it_harms(void **state) {
    (void)state;
    static const float twice[][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1e-8F}},
                       edge[][3] = {{5, 0, 0}, {6, 0, 0}, {5, 1, 0}, {6, 0, 1e-8F}, {6, 1, 0},
                           {5, 1, 1e-8F}};
    static const uint16_t corners[] = {0, 1, 2, 3, 1, 2}, others[] = {0, 1, 2, 3, 4, 5};
    gltf_asset a = {0};
    norma_document *document =
        open_primitives(&a, (primitive[]){{twice, 4, corners, 6}, {edge, 6, others, 6}}, 2);
    assert_int_equal(count_of(document, "N503"), 6);
    norma_fix_summary summary = fix(document, "N503");
    assert_int_equal(summary.changed, 1);
    assert_int_equal(summary.left_out, 1);
    assert_true(has_note(document, "N503", "/meshes/0/primitives/0"));
    assert_int_equal(count_of(document, "N503"), 2);
    assert_int_equal(count_of(document, "N305"), 0);
    summary = fix(document, "N503");
    assert_int_equal(summary.changed, 0);
    norma_document_close(document);
    asset_free(&a);
}

/* A box with a point on one of its edges, which a face without area joins that is of another
 * primitive (as is a pane, which is open). Without it the box would be open. */
static void what_is_closed_stays_closed(void **state) {
    (void)state;
    static const float positions[][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1},
        {1, 0, 1}, {1, 1, 1}, {0, 1, 1}, {.5F, 0, 1}, {5, 0, 0}, {5, 1, 0}, {5, 0, 1}};
    static const uint16_t box[] = {0, 3, 2, 0, 2, 1, 4, 5, 6, 4, 6, 7, 0, 1, 8, 1, 5, 8, 0, 8, 4, 1,
        2, 6, 1, 6, 5, 2, 3, 7, 2, 7, 6, 3, 0, 4, 3, 4, 7},
                          joint[] = {4, 8, 5, 9, 10, 11};
    gltf_asset a = {0};
    norma_document *document = open_primitives(&a,
        (primitive[]){{positions, 12, box, sizeof box / sizeof *box}, {positions, 12, joint, 6}},
        2);
    assert_int_equal(count_of(document, "N304"), 1);
    norma_fix_summary summary = fix(document, "N401");
    assert_int_equal(count_of(document, "N304"), 1);
    assert_int_equal(summary.changed, 0);
    assert_int_equal(summary.left_out, 1);
    assert_true(has_note(document, "N401", "open"));
    norma_document_close(document);
    asset_free(&a);
}

/* In one primitive the face that joins is kept, one that joins nothing is dropped; the note says
 * which stays. */
static void degenerate_faces_that_are_kept_are_named(void **state) {
    (void)state;
    static const char text[] =
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\nv .5 0 1\n"
        "f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 9 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\nf 5 9 6\nf 1 2 2\n";
    norma_document *document = scene_of_obj(text);
    assert_int_equal(count_of(document, "N401"), 2);
    norma_fix_summary summary = fix(document, "N401");
    assert_int_equal(summary.changed, 1);
    assert_int_equal(summary.left_out, 0);
    assert_true(has_note(document, "1 face is kept", "face 6"));
    assert_int_equal(count_of(document, "N401"), 1);
    assert_int_equal(count_of(document, "N304"), 0);
    summary = fix(document, "N401");
    assert_int_equal(summary.changed, 0);
    norma_document_close(document);
}

/* A glTF primitive needs a face: the only one stays, and nothing is changed over and over. */
static void the_only_face_of_a_primitive_stays(void **state) {
    (void)state;
    static const float positions[][3] = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
    static const uint16_t corners[] = {0, 1, 2};
    gltf_asset a = {0};
    norma_document *document = open_primitives(&a, &(primitive){positions, 3, corners, 3}, 1);
    assert_int_equal(count_of(document, "N401"), 1);
    const norma_fix_summary summary = fix(document, "N401");
    assert_int_equal(summary.changed, 0);
    assert_true(has_note(document, "1 face is kept", "face 0"));
    norma_document_close(document);
    asset_free(&a);
}

/* Progress never falls, whatever a trial and what it leaves out take. */
static int never_falls(void *user, double fraction) {
    double *last = user;
    assert_true(fraction >= *last && fraction <= 1);
    *last = fraction;
    return 0;
}

static void progress_never_falls(void **state) {
    (void)state;
    uint8_t mask[128];
    double last = 0;
    norma_document *document = scene_of_obj(polygons);
    norma_check_options options = select("N404,N405", mask);
    options.progress = never_falls;
    options.progress_user = &last;
    assert_int_equal(norma_fix_document(document, &options, 1, NULL, NULL), NORMA_DOCUMENT_OK);
    assert_true(last > .5);
    norma_document_close(document);
}

#define THREE_SQUARES                                                                              \
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 1 -1 0\nv 0 -1 0\nv 0 0 1e-7\nv 1 0 1e-7\nv 1 0 1\n"    \
    "v 0 0 1\nf 1 2 3 4\nf 2 1 6 5\nf 7 8 9 10\n"

/* Two squares at an edge, and a third one almost at it: joined to them, it would be the edge's
 * third face, which is no more than an information. */
static void no_edge_gets_a_third_face(void **state) {
    (void)state;
    norma_document *document = scene_of_obj(THREE_SQUARES);
    assert_int_equal(count_of(document, "N503"), 4);
    const norma_fix_summary summary = fix(document, "N503");
    assert_int_equal(summary.changed, 0);
    assert_int_equal(summary.left_out, 1);
    assert_true(has_note(document, "N503 almost-coincident is not fixed", "a third face"));
    norma_document_close(document);
}

/* The same squares, and two others of which one is there twice: left out once, it takes a third
 * face from their edge, which is no leave for the first edge to get one. */
static void no_edge_gets_a_third_face_for_another(void **state) {
    (void)state;
    norma_document *document =
        scene_of_obj(THREE_SQUARES "v 5 0 0\nv 6 0 0\nv 6 1 0\nv 5 1 0\nv 6 -1 0\nv 5 -1 0\n"
                                   "f 11 12 13 14\nf 12 11 16 15\nf 11 12 13 14\n");
    assert_int_equal(count_of(document, "N305"), 1);
    const norma_fix_summary summary = fix(document, "N305,N503");
    assert_int_equal(summary.changed, 1);
    assert_int_equal(count_of(document, "N305"), 0);
    assert_int_equal(count_of(document, "N503"), 4);
    assert_true(has_note(document, "N503 almost-coincident is not fixed", "a third face"));
    norma_document_close(document);
}

/* A cube whose floor is turned, with normals that go with its winding, and a larger square against
 * its normals, twice: less area is behind its normals once one of these is left out, but the floor
 * may not be for that. */
static void no_face_gets_behind_its_normals_for_another(void **state) {
    (void)state;
    static const char cube[] =
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
        "v 5 0 0\nv 8 0 0\nv 8 3 0\nv 5 3 0\n"
        "vn 0 0 1\nvn 0 0 -1\nvn 0 -1 0\nvn 1 0 0\nvn 0 1 0\nvn -1 0 0\n"
        "f 1//1 2//1 3//1 4//1\nf 5//1 6//1 7//1 8//1\nf 1//3 2//3 6//3 5//3\n"
        "f 2//4 3//4 7//4 6//4\nf 3//5 4//5 8//5 7//5\nf 4//6 1//6 5//6 8//6\n"
        "f 9//2 10//2 11//2 12//2\nf 9//2 10//2 11//2 12//2\n";
    norma_document *document = scene_of_obj(cube);
    assert_int_equal(count_of(document, "N201"), 2);
    assert_int_equal(fix(document, "N301,N305").changed, 1);
    assert_int_equal(count_of(document, "N305"), 0);
    assert_int_equal(count_of(document, "N201"), 1);
    assert_true(has_note(document, "N301 inconsistent-winding is not fixed", "N201"));
    norma_document_close(document);
}

/* ---- what findings offer, tried */

static norma_findings *tried(norma_document *document, norma_severity from) {
    norma_findings *findings;
    assert_int_equal(norma_check_document(document, NULL, &findings, NULL), NORMA_DOCUMENT_OK);
    assert_int_equal(
        norma_document_try_fixes(document, NULL, from, findings, NULL), NORMA_DOCUMENT_OK);
    return findings;
}

static const norma_finding *finding_of(const norma_findings *findings, const char *rule) {
    for (size_t i = 0; i < norma_findings_count(findings); ++i)
        if (strcmp(norma_findings_get(findings, i)->rule->id, rule) == 0)
            return norma_findings_get(findings, i);
    fail_msg("%s is not found", rule);
    return NULL;
}

/* Whatever is offered removes its finding, from a document that the trials left as it was; what is
 * not offered says why. */
static void an_offer_keeps_its_promise(void **state) {
    (void)state;
    norma_document *document = scene_of_obj(polygons);
    norma_findings *findings = tried(document, NORMA_SEVERITY_INFO);
    const norma_finding *folded = finding_of(findings, "N404");
    size_t size, offers = 0;
    assert_int_equal(folded->fix, NORMA_FIX_NONE);
    assert_non_null(strstr(folded->message, "no fix: N305 duplicate-faces would report more"));
    assert_int_equal(norma_finding_command(folded, "a.obj", NULL, NULL, 0), 0);
    assert_int_equal(finding_of(findings, "N405")->fix, NORMA_FIX_UNSAFE);
    for (size_t i = 0; i < norma_findings_count(findings); ++i) {
        const norma_finding *finding = norma_findings_get(findings, i);
        if (finding->fix == NORMA_FIX_NONE) continue;
        norma_document *other = scene_of_obj(polygons);
        assert_int_equal(fix(other, finding->rule->id).changed, 1);
        assert_int_equal(count_of(other, finding->rule->id), 0);
        norma_document_close(other);
        ++offers;
    }
    assert_true(offers > 1);
    unsigned char *bytes = scene_output(document, &size);
    assert_int_equal(size, strlen(polygons));
    assert_memory_equal(bytes, polygons, size);
    free(bytes);
    norma_findings_free(findings);
    /* Informations are not tried where nobody reads of them. */
    findings = tried(document, NORMA_SEVERITY_WARNING);
    assert_null(strstr(finding_of(findings, "N405")->message, "no fix"));
    assert_int_equal(finding_of(findings, "N404")->fix, NORMA_FIX_NONE);
    norma_findings_free(findings);
    norma_document_close(document);
}

/* A square of its own for each fault: to try all of them takes more than twenty checks. */
static const char faults[] =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 3 0 0\nv 4 0 0\nv 4 1 0\nv 3 1 0\n"
    "v 6 0 0\nv 7 0 0\nv 7 1 0\nv 6 1 0\nv 9 0 0\nv 10 0 0\nv 10 1 0\nv 9 1 0\n"
    "v 12 0 0\nv 13 0 0\nv 13 1 0\nv 12 1 0\nv 15 0 0\nv 16 0 0\nv 16 1 0\nv 15 1 0\n"
    "v 18 0 0\nv 20 0 0\nv 20 2 .5\nv 18 2 0\nv 21 0 0\nv 25 2 0\nv 21 4 0\nv 22 2 0\n"
    "v 27 0 0\nv 28 0 0\nv 29 0 0\nv 31 0 0\nv 32 0 0\nv 32 1 0\nv 31 1 0\n"
    "v 33.0000001 0 0\nv 33 0 0\nv 34 0 0\nv 34 1 0\nv 35 0 0\nv 36 0 0\nv 36 1 0\nv 35 1 0\n"
    "vn 0 0 1\nvn 0 0 0\nvn 0 0 2\nvn 0 0 -1\nvn nan 0 1\nvn 1 0 -.5\n"
    "f 1//2 2//1 3//1 4//1\nf 5//3 6//1 7//1 8//1\nf 9//4 10//4 11//4 12//4\n"
    "f 13//5 14//1 15//1 16//1\nf 17 18 19 20\nf 21//1 22//1 23//1 24\n"
    "f 25//1 26//1 27//1 28//1\nf 29//1 30//1 31//1 32//1\nf 33//1 34//1 35//1\n"
    "f 36//1 37//1 38//1 39//1\nf 36//1 37//1 38//1 39//1\nf 40//1 42//1 43//1\n"
    "f 41//1 43//1 42//1\nf 44//6 45//1 46//1 47//1\n";

static void what_would_take_too_long_is_told(void **state) {
    (void)state;
    norma_document *document = scene_of_obj(faults);
    norma_findings *findings = tried(document, NORMA_SEVERITY_INFO);
    size_t offers = 0, untried = 0;
    for (size_t i = 0; i < norma_findings_count(findings); ++i) {
        const norma_finding *finding = norma_findings_get(findings, i);
        offers += finding->fix != NORMA_FIX_NONE;
        if (!strstr(finding->message, "no fix: to find out whether it does harm takes too long"))
            continue;
        assert_int_equal(finding->fix, NORMA_FIX_NONE);
        ++untried;
    }
    assert_true(offers > 3);
    assert_true(untried > 0);
    norma_findings_free(findings);
    norma_document_close(document);
}

/* A bent square (N405, an information) is cut where that is asked for by name. */
static void informations_are_left(void **state) {
    (void)state;
    static const char bent[] = "v 6 0 0\nv 8 0 0\nv 8 2 .5\nv 6 2 0\nf 1 2 3 4\n";
    for (int from = NORMA_SEVERITY_NONE; from <= NORMA_SEVERITY_WARNING; ++from) {
        norma_document *document = scene_of_obj(bent);
        norma_fix_summary summary;
        const norma_check_options options = {
            .struct_size = sizeof options, .fix_from = (norma_severity)from};
        assert_int_equal(
            norma_fix_document(document, &options, 1, &summary, NULL), NORMA_DOCUMENT_OK);
        assert_int_equal(summary.changed, from < NORMA_SEVERITY_WARNING);
        assert_int_equal(count_of(document, "N405") > 0, from == NORMA_SEVERITY_WARNING);
        norma_document_close(document);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(only_the_fix_that_harms_is_left_out),
        cmocka_unit_test(a_rule_that_is_not_selected_counts),
        cmocka_unit_test(a_count_may_not_grow),
        cmocka_unit_test(what_does_no_harm_is_done),
        cmocka_unit_test(a_fix_is_left_out_where_it_harms),
        cmocka_unit_test(what_is_closed_stays_closed),
        cmocka_unit_test(degenerate_faces_that_are_kept_are_named),
        cmocka_unit_test(the_only_face_of_a_primitive_stays),
        cmocka_unit_test(progress_never_falls),
        cmocka_unit_test(no_edge_gets_a_third_face),
        cmocka_unit_test(no_edge_gets_a_third_face_for_another),
        cmocka_unit_test(no_face_gets_behind_its_normals_for_another),
        cmocka_unit_test(an_offer_keeps_its_promise),
        cmocka_unit_test(what_would_take_too_long_is_told),
        cmocka_unit_test(informations_are_left),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
