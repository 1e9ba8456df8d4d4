/* test_check_generated.c: the profile for models made by a program, as RULES.md has it: the graver
 * of the two other severities, and errors for what such a model must not have. */
#include "check.h"
#include "surfaces.h"
#include <string.h>

static const double ORIGIN[3] = {0, 0, 0};

static norma_findings *find(surface *s, norma_check_profile profile) {
    return surface_findings(s, &(norma_check_options){.profile = profile}, NORMA_FILE_GLB);
}

/* The severity that a rule has in a profile; NONE: it finds nothing. */
static norma_severity severity_of(surface *s, const char *id, norma_check_profile profile) {
    norma_findings *found = find(s, profile);
    const norma_finding *finding = finding_of(found, id, NORMA_SEVERITY_NONE);
    const norma_severity severity = finding ? finding->severity : NORMA_SEVERITY_NONE;
    assert_int_equal(norma_findings_profile(found), profile);
    norma_findings_free(found);
    return severity;
}

static void assert_severities(surface *s, const char *id, norma_severity render,
    norma_severity print, norma_severity generated) {
    assert_int_equal(severity_of(s, id, NORMA_CHECK_PROFILE_RENDER), render);
    assert_int_equal(severity_of(s, id, NORMA_CHECK_PROFILE_PRINT), print);
    assert_int_equal(severity_of(s, id, NORMA_CHECK_PROFILE_GENERATED), generated);
    surface_free(s);
}

static void a_clean_model_is_accepted(void **state) {
    (void)state;
    surface s = surface_box(ORIGIN, 1, 0);
    norma_findings *found = find(&s, NORMA_CHECK_PROFILE_GENERATED);
    assert_false(findings_trouble(found));
    norma_findings_free(found);
    surface_free(&s);
}

static void what_a_model_must_not_have(void **state) {
    (void)state;
    surface inward = surface_box(ORIGIN, 1, 1);
    assert_severities(
        &inward, "N302", NORMA_SEVERITY_WARNING, NORMA_SEVERITY_ERROR, NORMA_SEVERITY_ERROR);

    surface twice = surface_box(ORIGIN, 1, 0);
    surface_add_face(
        &twice, (const uint32_t[]){twice.corners[0], twice.corners[1], twice.corners[2]});
    assert_severities(
        &twice, "N305", NORMA_SEVERITY_WARNING, NORMA_SEVERITY_WARNING, NORMA_SEVERITY_ERROR);

    surface sheet = surface_box(ORIGIN, 1, 0);
    surface_add_face(
        &sheet, (const uint32_t[]){sheet.corners[0], sheet.corners[2], sheet.corners[1]});
    assert_severities(
        &sheet, "N306", NORMA_SEVERITY_INFO, NORMA_SEVERITY_WARNING, NORMA_SEVERITY_ERROR);

    surface fin = surface_box(ORIGIN, 1, 0);
    const uint32_t tip =
        surface_add_vertex(&fin, (const float[]){3, 3, 3}, (const float[]){0, 0, 1});
    surface_add_face(&fin, (const uint32_t[]){fin.corners[0], fin.corners[1], tip});
    assert_severities(
        &fin, "N303", NORMA_SEVERITY_INFO, NORMA_SEVERITY_WARNING, NORMA_SEVERITY_ERROR);
}

static void placeholders_of_a_material_with_two_sides_may_be_meant(void **state) {
    (void)state;
    for (int two_sided = 0; two_sided < 2; ++two_sided) {
        surface s = surface_torus(24, 12);
        for (size_t i = 0; i < s.vertices; ++i)
            memcpy(s.normals + 3 * i, (const float[]){0, 0, 1}, 3 * sizeof(float));
        s.mesh.material.double_sided = two_sided;
        if (two_sided)
            assert_severities(
                &s, "N203", NORMA_SEVERITY_INFO, NORMA_SEVERITY_INFO, NORMA_SEVERITY_INFO);
        else
            assert_severities(
                &s, "N203", NORMA_SEVERITY_WARNING, NORMA_SEVERITY_WARNING, NORMA_SEVERITY_ERROR);
    }
}

static void other_rules_keep_their_severity(void **state) {
    (void)state;
    surface s = surface_torus(24, 12);
    s.normals[3] *= 2;
    assert_severities(&s, "N103", NORMA_SEVERITY_ERROR, NORMA_SEVERITY_ERROR, NORMA_SEVERITY_ERROR);
    s = surface_soup(surface_torus(24, 12));
    assert_severities(&s, "N502", NORMA_SEVERITY_INFO, NORMA_SEVERITY_INFO, NORMA_SEVERITY_INFO);
}

static void severities_of_rules(void **state) {
    (void)state;
    static const struct {
        const char *id;
        norma_severity severity;
    } expected[] = {{"N102", NORMA_SEVERITY_ERROR}, {"N203", NORMA_SEVERITY_ERROR},
        {"N302", NORMA_SEVERITY_ERROR}, {"N303", NORMA_SEVERITY_ERROR},
        {"N305", NORMA_SEVERITY_ERROR}, {"N306", NORMA_SEVERITY_ERROR},
        {"N401", NORMA_SEVERITY_INFO}, {"N501", NORMA_SEVERITY_WARNING}};
    size_t count;
    const norma_rule *rules = norma_rules(&count);
    for (size_t i = 0; i < sizeof expected / sizeof *expected; ++i)
        for (size_t rule = 0; rule < count; ++rule)
            if (strcmp(rules[rule].id, expected[i].id) == 0) {
                assert_int_equal(norma_rule_severity(&rules[rule], NORMA_CHECK_PROFILE_GENERATED),
                    expected[i].severity);
                assert_int_equal(norma_rule_severity(&rules[rule], NORMA_CHECK_PROFILE_RENDER),
                    rules[rule].render);
                assert_int_equal(norma_rule_severity(&rules[rule], NORMA_CHECK_PROFILE_PRINT),
                    rules[rule].print);
            }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_clean_model_is_accepted),
        cmocka_unit_test(what_a_model_must_not_have),
        cmocka_unit_test(placeholders_of_a_material_with_two_sides_may_be_meant),
        cmocka_unit_test(other_rules_keep_their_severity),
        cmocka_unit_test(severities_of_rules),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
