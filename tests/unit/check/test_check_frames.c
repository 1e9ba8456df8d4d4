/* test_check_frames.c: normals of another frame (N206): of a torus whose normals were reversed,
 * mirrored or rotated by a known angle while its positions stayed; and the twins, in which both or
 * neither were. */
#include "check.h"
#include "surfaces.h"

enum { AROUND = SLOWER > 1 ? 48 : 160, ACROSS = SLOWER > 1 ? 32 : 96 };

static norma_findings *found;

static const norma_finding *look(surface *s, const char *id, norma_severity severity) {
    norma_findings_free(found);
    found = surface_findings(s, NULL, NORMA_FILE_GLB);
    return finding_of(found, id, severity);
}

static int tear_down(void **state) {
    (void)state;
    norma_findings_free(found);
    found = NULL;
    return 0;
}

typedef double matrix3[3][3];

/* Rodrigues' formula, times sign. */
static void rotation(const double axis[3], double degrees, double sign, matrix3 out) {
    const double length = sqrt(axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2]),
                 c = cos(degrees / DEGREES), s = sin(degrees / DEGREES);
    const double a[3] = {axis[0] / length, axis[1] / length, axis[2] / length};
    const matrix3 cross = {{0, -a[2], a[1]}, {a[2], 0, -a[0]}, {-a[1], a[0], 0}};
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k)
            out[i][k] = sign * ((i == k) * c + s * cross[i][k] + (1 - c) * a[i] * a[k]);
}

static void apply(matrix3 m, float *vectors, size_t count) {
    for (size_t i = 0; i < count; ++i) {
        double to[3] = {0};
        for (int r = 0; r < 3; ++r)
            for (int k = 0; k < 3; ++k) to[r] += m[r][k] * (double)vectors[3 * i + (size_t)k];
        for (int r = 0; r < 3; ++r) vectors[3 * i + (size_t)r] = (float)to[r];
    }
}

static void assert_silent(const char *id) {
    assert_null(finding_of(found, id, NORMA_SEVERITY_NONE));
}

/* The finding says so, and the rules that would report its effects say nothing. */
static void assert_named(surface *s, norma_severity severity, const char *words) {
    const norma_finding *f = look(s, "N206", severity);
    assert_non_null(f);
    assert_int_equal(f->count, 1);
    assert_int_equal(f->fix, NORMA_FIX_UNSAFE);
    assert_true(f->worst_value > 30);
    if (!strstr(f->message, words)) fail_msg("\"%s\" is not in: %s", words, f->message);
    assert_silent("N201");
    assert_silent("N202");
    assert_silent("N501");
    assert_non_null(finding_of(found, "N204", NORMA_SEVERITY_INFO));
}

typedef struct frame_case {
    double axis[3], degrees, sign;
    const char *words;
} frame_case;

/* What is named is what must be done to the normals: the inverse of what was done to them. */
static const frame_case cases[] = {
    {{1, 0, 0}, 0, -1, "they are reversed"},
    {{1, 0, 0}, 180, -1, "a mirror along the axis (1, 0, 0) puts"},
    {{0, 1, -1}, 180, -1, "a mirror along the axis (0, 0.707, -0.707) puts"}, /* y and z swapped */
    {{1, 0, 0}, 90, 1, "a rotation of 90 degrees about the axis (-1, 0, 0)"},
    {{1, 1, 1}, 120, 1, "a rotation of 120 degrees about the axis (-0.577, -0.577, -0.577)"},
    {{1, 2, 2}, 75, 1, "a rotation of 75 degrees about the axis (-0.333, -0.667, -0.667)"},
    {{0, 1, 0}, 180, 1, "a rotation of 180 degrees about the axis (0, 1, 0)"},
};

/* A torus has symmetries that a rotation could be mistaken for: it is dented on one side. */
static surface dented(void) {
    surface s = surface_torus(AROUND, ACROSS);
    for (size_t i = 0; i < s.vertices; ++i) {
        float *p = &s.positions[3 * i], *n = &s.normals[3 * i];
        /* A shear, under which normals go with its inverse transpose. */
        p[0] += .3f * p[1];
        p[2] += .2f * p[0];
        n[1] -= .3f * n[0];
        n[0] -= .2f * n[2];
        const float length = sqrtf(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        for (int k = 0; k < 3; ++k) n[k] /= length;
    }
    return s;
}

static void frames_are_named(void **state) {
    (void)state;
    for (size_t i = 0; i < COUNT_OF(cases); ++i) {
        surface s = dented();
        matrix3 m;
        rotation(cases[i].axis, cases[i].degrees, cases[i].sign, m);
        apply(m, s.normals, s.vertices);
        assert_named(&s, NORMA_SEVERITY_ERROR, cases[i].words);
        s.mesh.material.double_sided = 1;
        assert_named(&s, NORMA_SEVERITY_INFO, cases[i].words);
        surface_free(&s);
    }
}

static void a_surface_turned_with_its_normals_is_fine(void **state) {
    (void)state;
    for (size_t i = 0; i < COUNT_OF(cases); ++i) {
        surface s = dented();
        matrix3 m;
        rotation(cases[i].axis, cases[i].degrees, cases[i].sign, m);
        apply(m, s.normals, s.vertices);
        apply(m, s.positions, s.vertices);
        for (size_t f = 0; f < s.faces && cases[i].sign < 0; ++f) surface_turn_face(&s, f);
        (void)look(&s, "N206", NORMA_SEVERITY_NONE);
        assert_false(findings_trouble(found));
        surface_free(&s);
    }
}

/* Each turned by as much, about an axis of its own. */
static void scattered_normals_have_no_frame(void **state) {
    (void)state;
    surface s = dented();
    for (size_t i = 0; i < s.vertices; ++i) {
        matrix3 m;
        const double axis[3] = {sin((double)i * 12.9898), cos((double)i * 78.233), .1};
        rotation(axis, 60, 1, m);
        apply(m, &s.normals[3 * i], 1);
    }
    assert_named(&s, NORMA_SEVERITY_ERROR, "no mirror or rotation puts them right");
    surface_free(&s);
}

/* A third of them turned is no other frame: they are named one by one. */
static void a_part_is_no_frame(void **state) {
    (void)state;
    surface s = surface_soup(dented());
    for (size_t f = 0; f < s.faces / 3; ++f)
        for (size_t k = 0; k < 9; ++k) s.normals[9 * f + k] = -s.normals[9 * f + k];
    assert_non_null(look(&s, "N201", NORMA_SEVERITY_ERROR));
    assert_silent("N206");
    surface_free(&s);
}

/* ---- the winding is wrong instead, or nothing shows which is */

static void a_wrong_winding_is_no_frame(void **state) {
    (void)state;
    surface s = dented();
    for (size_t f = 0; f < s.faces; ++f) surface_turn_face(&s, f);
    const norma_finding *f = look(&s, "N201", NORMA_SEVERITY_ERROR);
    assert_non_null(f);
    assert_int_equal(f->count, s.faces);
    assert_non_null(strstr(f->message, "the winding is wrong"));
    assert_int_equal(f->fix, NORMA_FIX_UNSAFE);
    assert_silent("N206");
    surface_free(&s);
}

/* A bumpy sheet, seen from both sides alike. */
static surface sheet(void) {
    enum { SIDE = 20 };
    const double origin[3] = {0, 0, 0};
    surface s = surface_box(origin, 1, 0);
    s.vertices = s.faces = 0;
    for (int y = 0; y <= SIDE; ++y)
        for (int x = 0; x <= SIDE; ++x) {
            const double slope = .05 * cos(x), length = sqrt(1 + slope * slope);
            const float p[3] = {(float)x, (float)y, (float)(.05 * sin(x))},
                        n[3] = {(float)(slope / length), 0, (float)(-1 / length)};
            surface_add_vertex(&s, p, n);
        }
    for (uint32_t y = 0; y < SIDE; ++y)
        for (uint32_t x = 0; x < SIDE; ++x) {
            const uint32_t at = y * (SIDE + 1) + x;
            surface_add_face(&s, (const uint32_t[3]){at, at + 1, at + SIDE + 2});
            surface_add_face(&s, (const uint32_t[3]){at, at + SIDE + 2, at + SIDE + 1});
        }
    return s;
}

static void a_sheet_stays_undecided(void **state) {
    (void)state;
    surface s = sheet();
    const norma_finding *f = look(&s, "N201", NORMA_SEVERITY_ERROR);
    assert_non_null(f);
    assert_int_equal(f->count, s.faces);
    assert_non_null(strstr(f->message, "neither volume nor rays"));
    assert_int_equal(f->fix, NORMA_FIX_NONE);
    assert_silent("N206");
    surface_free(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(frames_are_named),
        cmocka_unit_test(a_surface_turned_with_its_normals_is_fine),
        cmocka_unit_test(scattered_normals_have_no_frame),
        cmocka_unit_test(a_part_is_no_frame),
        cmocka_unit_test(a_wrong_winding_is_no_frame),
        cmocka_unit_test(a_sheet_stays_undecided),
    };
    return cmocka_run_group_tests(tests, NULL, tear_down);
}
