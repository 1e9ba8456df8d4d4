/* test_check_planted.c: faults planted in clean surfaces, one at a time: each rule must find them
 * all, at the right place, in the right count and severity; the clean surfaces stay without errors
 * and warnings. */
#include "check.h"
#include "surfaces.h"

enum { AROUND = SLOWER > 1 ? 80 : 320, ACROSS = 160 };

static const double origin[3] = {0, 0, 0};

static norma_findings *found;

/* Runs the rules, and gives the finding of one. */
static const norma_finding *look(surface *s, const char *id, norma_severity severity,
    const norma_check_options *options, norma_file_format format) {
    norma_findings_free(found);
    found = surface_findings(s, options, format);
    return finding_of(found, id, severity);
}
static const norma_finding *in_render(surface *s, const char *id, norma_severity severity) {
    return look(s, id, severity, NULL, NORMA_FILE_GLB);
}
static const norma_finding *in_print(surface *s, const char *id, norma_severity severity) {
    return look(s, id, severity, &(norma_check_options){.profile = NORMA_CHECK_PROFILE_PRINT},
        NORMA_FILE_GLB);
}

#define assert_found(finding, n)                                                                   \
    do {                                                                                           \
        const norma_finding *finding_ = (finding);                                                 \
        assert_non_null(finding_);                                                                 \
        assert_int_equal(finding_->count, n);                                                      \
    } while (0)

static int tear_down(void **state) {
    (void)state;
    norma_findings_free(found);
    found = NULL;
    return 0;
}

/* ---- clean */

static void clean_surfaces_stay_clean(void **state) {
    (void)state;
    surface all[] = {surface_torus(AROUND, ACROSS), surface_torus(16, 12),
        surface_box(origin, 1, 0),
        surface_join(surface_box(origin, 3, 0), surface_box(origin, 1, 1)),
        surface_soup(surface_torus(32, 16))};
    for (size_t i = 0; i < COUNT_OF(all); ++i) {
        (void)in_render(&all[i], "N001", NORMA_SEVERITY_NONE);
        assert_false(findings_trouble(found));
        (void)in_print(&all[i], "N001", NORMA_SEVERITY_NONE);
        assert_false(findings_trouble(found));
        assert_null(finding_of(found, "N304", NORMA_SEVERITY_NONE));
        surface_free(&all[i]);
    }
}

/* ---- lengths */

static void set_normal(surface *s, size_t vertex, double x, double y, double z) {
    s->normals[3 * vertex] = (float)x;
    s->normals[3 * vertex + 1] = (float)y;
    s->normals[3 * vertex + 2] = (float)z;
}

static void scale_normal(surface *s, size_t vertex, double by) {
    for (size_t k = 0; k < 3; ++k)
        s->normals[3 * vertex + k] = (float)((double)s->normals[3 * vertex + k] * by);
}

static void lengths(void **state) {
    (void)state;
    surface s = surface_torus(AROUND, ACROSS);
    set_normal(&s, 1234, NAN, 0, 1);
    set_normal(&s, 1235, 0, INFINITY, 1);
    set_normal(&s, 4321, 0, 0, 0);
    set_normal(&s, 4322, 5e-7, 0, 0);
    scale_normal(&s, 77, 1.0006);
    scale_normal(&s, 78, 0.5);
    scale_normal(&s, 79, 1.0004);
    const norma_finding *f = in_render(&s, "N101", NORMA_SEVERITY_ERROR);
    assert_found(f, 2);
    assert_int_equal(f->samples[0].vertex, 1234);
    assert_int_equal(f->samples[1].vertex, 1235);
    assert_true(
        f->samples[0].has_position && f->samples[0].position[0] == (double)s.positions[3 * 1234]);
    assert_int_equal(f->fix, NORMA_FIX_SAFE);
    f = finding_of(found, "N102", NORMA_SEVERITY_ERROR);
    assert_found(f, 2);
    assert_int_equal(f->worst.vertex, 4321);
    f = finding_of(found, "N103", NORMA_SEVERITY_ERROR);
    assert_found(f, 2);
    assert_int_equal(f->worst.vertex, 78);
    assert_true(fabs(f->worst_value - .5) < 1e-6);
    assert_found(
        look(&s, "N103", NORMA_SEVERITY_ERROR, &(norma_check_options){.strict = 1}, NORMA_FILE_GLB),
        3);
    s.mesh.info.encoding = "snorm8";
    assert_found(in_render(&s, "N103", NORMA_SEVERITY_ERROR), 1);
    scale_normal(&s, 80, 1.0069);
    scale_normal(&s, 81, 1.0067);
    assert_found(in_render(&s, "N103", NORMA_SEVERITY_ERROR), 2);
    surface_free(&s);
}

/* ---- faces that no rule looks at */

/* A position that is no point takes its faces from every rule, which is said. */
static void faces_without_a_place(void **state) {
    (void)state;
    surface s = surface_torus(AROUND, ACROSS);
    s.positions[3 * 1234 + 1] = INFINITY;
    s.positions[3 * 4321] = NAN;
    const norma_finding *f = in_render(&s, "N002", NORMA_SEVERITY_WARNING);
    assert_found(f, 12);
    assert_true(norma_findings_partly(found));
    assert_int_equal(f->worst.face, f->samples[0].face);
    uint8_t rules[64];
    memset(rules, 1, sizeof rules);
    for (size_t i = 0, count = 0; i < sizeof rules; ++i) {
        const norma_rule *all = norma_rules(&count);
        if (i < count && !strcmp(all[i].id, "N002")) rules[i] = 0;
    }
    assert_null(look(
        &s, "N002", NORMA_SEVERITY_NONE, &(norma_check_options){.rules = rules}, NORMA_FILE_GLB));
    assert_true(norma_findings_partly(found));
    surface_free(&s);
}

/* ---- normals against faces */

static void opposing_normals(void **state) {
    (void)state;
    surface s = surface_soup(surface_torus(AROUND, ACROSS));
    for (size_t k = 0; k < 3; ++k) scale_normal(&s, 3 * 500 + k, -1);
    const norma_finding *f = in_render(&s, "N201", NORMA_SEVERITY_INFO);
    assert_found(f, 1);
    assert_int_equal(f->samples[0].face, 500);
    assert_true(f->worst_value > 175);
    assert_found(finding_of(found, "N202", NORMA_SEVERITY_INFO), 3);
    for (size_t face = 1000; face < 1000 + s.faces / 50; ++face)
        for (size_t k = 0; k < 3; ++k) scale_normal(&s, 3 * face + k, -1);
    assert_found(in_render(&s, "N201", NORMA_SEVERITY_ERROR), 1 + s.faces / 50);
    s.mesh.material.double_sided = 1;
    assert_found(in_render(&s, "N201", NORMA_SEVERITY_INFO), 1 + s.faces / 50);
    assert_null(finding_of(found, "N202", NORMA_SEVERITY_WARNING));
    assert_non_null(finding_of(found, "N202", NORMA_SEVERITY_INFO));
    surface_free(&s);
    s = surface_soup(surface_torus(AROUND, ACROSS)); /* two corners of three are not all */
    for (size_t k = 0; k < 2; ++k) scale_normal(&s, 3 * 500 + k, -1);
    assert_null(in_render(&s, "N201", NORMA_SEVERITY_NONE));
    surface_free(&s);
    s = surface_box(origin, 1,
        0); /* all corners of a side 80 degrees off it are still before it; at 100 they are not */
    for (size_t k = 20; k < 24; ++k) set_normal(&s, k, sin(80 / DEGREES), 0, cos(80 / DEGREES));
    assert_null(in_render(&s, "N201", NORMA_SEVERITY_NONE));
    for (size_t k = 20; k < 24; ++k) set_normal(&s, k, sin(100 / DEGREES), 0, cos(100 / DEGREES));
    assert_found(in_render(&s, "N201", NORMA_SEVERITY_ERROR), 2);
    surface_free(&s);
}

/* A triangle of that height over a longest edge of length, whose normals look down. */
static void add_opposed(surface *s, float length, float height) {
    const float corners[3][3] = {{20, 0, 0}, {20 + length, 0, 0}, {20 + length / 2, height, 0}},
                down[3] = {0, 0, -1};
    uint32_t face[3];
    for (int k = 0; k < 3; ++k) face[k] = surface_add_vertex(s, corners[k], down);
    surface_add_face(s, face);
}

/* Shares are shares of the area, and slivers say nothing. */
static void opposing_normals_by_area(void **state) {
    (void)state;
    surface s = surface_torus(AROUND, ACROSS);
    add_opposed(&s, 1, 5e-5F);
    assert_null(in_render(&s, "N201", NORMA_SEVERITY_NONE));
    add_opposed(&s, .2F, .2F);
    assert_found(in_render(&s, "N201", NORMA_SEVERITY_WARNING), 1);
    add_opposed(&s, 40, 40);
    assert_found(in_render(&s, "N201", NORMA_SEVERITY_ERROR), 2);
    surface_free(&s);
}

static void one_normal_far_off(void **state) {
    (void)state;
    surface s = surface_torus(AROUND, ACROSS);
    const size_t vertex = 40 * (ACROSS + 1) + 7;
    const double a = 2 * 3.141592653589793 * 40 / AROUND, b = 2 * 3.141592653589793 * 7 / ACROSS,
                 off = 80 / DEGREES, near_off = 70 / DEGREES;
    const double n[3] = {cos(a) * cos(b), sin(a) * cos(b), sin(b)}, t[3] = {-sin(a), cos(a), 0};
    set_normal(&s, vertex, cos(off) * n[0] + sin(off) * t[0], cos(off) * n[1] + sin(off) * t[1],
        cos(off) * n[2] + sin(off) * t[2]);
    /* By their area its faces are too small to be seen; those of the box below are not. */
    const norma_finding *f = in_render(&s, "N202", NORMA_SEVERITY_INFO);
    assert_found(f, 1);
    assert_int_equal(f->samples[0].vertex, vertex);
    assert_true(fabs(f->worst_value - 80) < 5);
    set_normal(&s, vertex, cos(near_off) * n[0] + sin(near_off) * t[0],
        cos(near_off) * n[1] + sin(near_off) * t[1], cos(near_off) * n[2] + sin(near_off) * t[2]);
    assert_null(in_render(&s, "N202", NORMA_SEVERITY_NONE));
    surface_free(&s);
    s = surface_box(origin, 1, 0); /* vertices of one side each: along the side next to it a normal
                                      is near to a face at its position; away from it, to none */
    for (size_t k = 20; k < 24; ++k) set_normal(&s, k, s.positions[3 * k] > 0 ? 1 : -1, 0, 0);
    assert_null(in_render(&s, "N202", NORMA_SEVERITY_NONE));
    set_normal(&s, 21, s.positions[3 * 21] > 0 ? -1 : 1, 0, 0);
    assert_found(in_render(&s, "N202", NORMA_SEVERITY_WARNING), 1);
    surface_free(&s);
}

static void placeholders(void **state) {
    (void)state;
    surface s = surface_torus(AROUND, ACROSS);
    for (size_t v = 0; v < s.vertices; ++v)
        if (v % 25) set_normal(&s, v, 0, 0, 1);
    assert_found(in_render(&s, "N203", NORMA_SEVERITY_WARNING), 1);
    s.mesh.material.not_opaque = 1;
    assert_found(in_render(&s, "N203", NORMA_SEVERITY_INFO), 1);
    for (size_t v = 0; v < s.vertices; ++v)
        if (v % 15 == 0) set_normal(&s, v, 1, 0, 0);
    assert_null(in_render(&s, "N203", NORMA_SEVERITY_NONE)); /* nine in a hundred differ */
    surface_free(&s);
    s = surface_torus(64, 32); /* flattened: a plate has one normal */
    for (size_t v = 0; v < s.vertices; ++v) {
        s.positions[3 * v + 2] = 0;
        set_normal(&s, v, 0, 0, 1);
    }
    assert_null(in_render(&s, "N203", NORMA_SEVERITY_NONE));
    surface_free(&s);
}

/* Normals that the library is asked for by other ways than the ones that are tried first are told
 * by their makings. */
static void explained(void **state) {
    (void)state;
    static const struct {
        norma_weight weight;
        float crease_deg;
    } ways[] = {{NORMA_WEIGHT_ANGLE, 180}, {NORMA_WEIGHT_AREA, 180}, {NORMA_WEIGHT_UNIFORM, 180},
        {NORMA_WEIGHT_AREA, 40}, {NORMA_WEIGHT_MAX, 20}};
    for (size_t i = 0; i < COUNT_OF(ways); ++i) {
        for (size_t large = 0; large < 2; ++large) {
            surface s = surface_soup(
                large ? surface_torus(AROUND, 44)
                      : surface_torus(60, 20)); /* edges bend by some 8 or 18 degrees across */
            s.mesh.info.normals = NORMA_NORMALS_PER_CORNER;
            for (size_t v = 0; v < s.vertices; ++v)
                if (s.positions[3 * v + 2] > 0.9f) s.positions[3 * v + 2] *= 3;
            const norma_mesh mesh = {.positions = {s.positions, s.vertices, 0, NORMA_FORMAT_FLOAT},
                .corners = s.corners,
                .corner_count = 3 * s.faces};
            assert_ok(norma_corner_normals(&mesh, ways[i].crease_deg / (float)DEGREES,
                &(norma_options){.weight = ways[i].weight}, s.normals, s.vertices, NULL));
            s.mesh.info.normals = NORMA_NORMALS_PER_VERTEX;
            const norma_finding *f = in_render(&s, "N204", NORMA_SEVERITY_INFO);
            assert_found(f, s.vertices);
            assert_non_null(f->deviation);
            assert_true(f->deviation->max_rad < 1e-5);
            assert_int_equal(f->deviation->weight, ways[i].weight);
            assert_int_equal(f->deviation->corners, s.vertices);
            assert_int_equal(f->deviation->histogram[0], s.vertices);
            assert_int_equal(f->worst.vertex, SIZE_MAX); /* nothing to show */
            surface_free(&s);
        }
    }
}

/* Where it is greatest: at the one normal that leans. */
static void deviation_has_a_place(void **state) {
    (void)state;
    surface s = surface_torus(AROUND, ACROSS);
    const size_t vertex = 4321;
    float *n = s.normals + 3 * vertex, leaning[3] = {n[0] + n[1], n[1] - n[0], n[2]};
    memcpy(n, leaning, sizeof leaning);
    const norma_finding *f = in_render(&s, "N204", NORMA_SEVERITY_INFO);
    assert_non_null(f);
    assert_true(f->worst_value > 5);
    assert_int_equal(f->worst.vertex, vertex);
    assert_true(f->worst.has_position);
    surface_free(&s);
}

/* Two squares side by side, one of them wound wrongly or with a wrong normal for it: nothing says
 * which is turned but the normals. */
static void facets_of_polygons(void **state) {
    (void)state;
    static const float positions[6][3] = {
        {0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {2, 0, 0}, {2, 1, 0}};
    static const uint32_t corners[8] = {0, 1, 2, 3, 1, 4, 5, 2}, starts[3] = {0, 4, 8};
    for (int wrong = 0; wrong < 2; ++wrong) {
        const float normals[2][3] = {{0, 0, wrong ? -1.0F : 1.0F}, {0, 0, 1}};
        const uint32_t turned[8] = {0, 1, 2, 3, 1, 2, 5, 4};
        const norma_check_mesh mesh = {.info = {.name = "",
                                           .where = "",
                                           .encoding = "float",
                                           .vertices = 6,
                                           .faces = 2,
                                           .triangles = 4,
                                           .normals = NORMA_NORMALS_PER_FACET},
            .data = {.mesh = {.positions = {positions, 6, 0, NORMA_FORMAT_FLOAT},
                         .corners = wrong ? corners : turned,
                         .corner_count = 8,
                         .face_starts = starts,
                         .face_count = 2},
                .normals = {normals, 2, 0, NORMA_FORMAT_FLOAT}},
            .attributes = {.material = SIZE_MAX, .tangent_encoding = "", .ignore = ""},
            .material = {.name = "", .where = "", .ignore = ""}};
        const norma_check_scene scene = {
            .meshes = &mesh, .mesh_count = 1, .format = NORMA_FILE_STL};
        norma_findings *findings;
        assert_ok(norma_check_scene_run(&scene, NULL, &findings));
        const norma_finding *f = finding_of(findings, "N205", NORMA_SEVERITY_NONE);
        assert_non_null(f);
        assert_int_equal(f->count, 1);
        assert_int_equal(f->samples[0].face, !wrong);
        /* the second is shown to be turned; the first one's normal to be wrong */
        assert_int_equal(f->fix, wrong ? NORMA_FIX_SAFE : NORMA_FIX_NONE);
        norma_findings_free(findings);
    }
}

static void facets(void **state) {
    (void)state;
    surface s = surface_soup(surface_torus(AROUND, ACROSS));
    const norma_mesh mesh = {
        .positions = {s.positions, s.vertices, 0, NORMA_FORMAT_FLOAT}, .corner_count = 3 * s.faces};
    assert_ok(norma_face_normals(&mesh, NULL, s.normals, s.faces, NULL));
    s.mesh.info.normals = NORMA_NORMALS_PER_FACET;
    assert_null(look(&s, "N205", NORMA_SEVERITY_NONE, NULL, NORMA_FILE_STL));
    assert_false(findings_trouble(found));
    assert_int_equal(norma_findings_profile(found), NORMA_CHECK_PROFILE_PRINT);
    set_normal(&s, 10, 0, 0, 0);
    scale_normal(&s, 20, -1);
    scale_normal(&s, 30, 17); /* a length means nothing here */
    /* two facets are less than a thousandth of the area */
    const norma_finding *f = look(&s, "N205", NORMA_SEVERITY_INFO, NULL, NORMA_FILE_STL);
    assert_found(f, 2);
    assert_int_equal(f->samples[0].face, 10);
    assert_int_equal(f->samples[1].face, 20);
    for (size_t i = 0; i < s.faces / 200; ++i) scale_normal(&s, 1000 + i, -1);
    assert_found(look(&s, "N205", NORMA_SEVERITY_WARNING, NULL, NORMA_FILE_STL), 2 + s.faces / 200);
    assert_null(finding_of(found, "N102", NORMA_SEVERITY_NONE));
    assert_null(finding_of(found, "N103", NORMA_SEVERITY_NONE));
    assert_null(finding_of(found, "N204", NORMA_SEVERITY_NONE));
    surface_free(&s);
}

/* ---- winding */

static void one_face_turned_in_a_hundred_thousand(void **state) {
    (void)state;
    surface s = surface_torus(AROUND, ACROSS);
    const size_t face = 2 * (50 * ACROSS + 20); /* far from the seams */
    surface_turn_face(&s, face);
    const norma_finding *f = in_render(&s, "N301", NORMA_SEVERITY_INFO);
    assert_found(f, 3);
    assert_int_equal(f->fix, NORMA_FIX_UNSAFE);
    for (size_t i = 0; i < 3; ++i) assert_int_equal(f->samples[i].face, face);
    assert_found(finding_of(found, "N201", NORMA_SEVERITY_INFO), 1);
    assert_null(finding_of(found, "N302", NORMA_SEVERITY_NONE));
    assert_null(finding_of(found, "N304", NORMA_SEVERITY_NONE));
    s.mesh.material.double_sided = 1;
    assert_found(in_render(&s, "N301", NORMA_SEVERITY_INFO), 3);
    assert_found(in_print(&s, "N301", NORMA_SEVERITY_INFO), 3);
    surface_free(&s);
}

/* Without a vertex in common as well: positions make the surface. */
static void one_face_turned_in_a_soup(void **state) {
    (void)state;
    surface s = surface_soup(surface_torus(32, 16));
    surface_turn_face(&s, 777);
    const norma_finding *f = in_render(&s, "N301", NORMA_SEVERITY_ERROR);
    assert_found(f, 3);
    assert_non_null(strstr(f->message, ": 1 face to turn"));
    assert_int_equal(f->fix, NORMA_FIX_UNSAFE);
    assert_found(in_print(&s, "N301", NORMA_SEVERITY_ERROR), 3);
    surface_free(&s);
}

enum { RING = 32 };

/* Vertices on a circle; returns the first. */
static uint32_t add_ring(surface *s, double radius, double z) {
    const uint32_t first = (uint32_t)s->vertices;
    for (int i = 0; i < RING; ++i) {
        const double a = 2 * 3.141592653589793 * i / RING;
        const float p[3] = {(float)(radius * cos(a)), (float)(radius * sin(a)), (float)z},
                    n[3] = {(float)cos(a), (float)sin(a), 0};
        surface_add_vertex(s, p, n);
    }
    return first;
}

/* A band between two rings, wound from the one to the other as their angle grows. */
static void add_band(surface *s, uint32_t one, uint32_t other) {
    for (uint32_t i = 0; i < RING; ++i) {
        const uint32_t next = (i + 1) % RING;
        surface_add_face(s, (const uint32_t[3]){one + i, one + next, other + next});
        surface_add_face(s, (const uint32_t[3]){one + i, other + next, other + i});
    }
}

/* A tube, its outside outside, with a brim around its upper end that looks up: along the rim both
 * run the same way, and both are right. */
static void pieces_that_touch(void **state) {
    (void)state;
    surface s = surface_box(origin, 1, 0);
    s.vertices = s.faces = 0;
    const uint32_t bottom = add_ring(&s, 1, 0), top = add_ring(&s, 1, 2),
                   brim = add_ring(&s, 1.3, 1.95);
    add_band(&s, bottom, top);
    add_band(&s, brim, top);
    const norma_finding *f = in_render(&s, "N301", NORMA_SEVERITY_INFO);
    assert_found(f, RING);
    assert_int_equal(f->fix, NORMA_FIX_NONE);
    assert_null(finding_of(found, "N301", NORMA_SEVERITY_WARNING));
    assert_null(finding_of(found, "N301", NORMA_SEVERITY_ERROR));
    assert_found(in_print(&s, "N301", NORMA_SEVERITY_INFO), RING);
    for (size_t face = 4; face < 12; face += 4) surface_turn_face(&s, face); /* not at the rim */
    f = in_render(&s, "N301", NORMA_SEVERITY_ERROR);
    assert_non_null(f);
    assert_non_null(strstr(f->message, ": 2 faces to turn"));
    surface_free(&s);
}

/* A flat sheet is seen from both sides alike: that one of its faces is turned is sure, which one is
 * not. */
static void a_sheet_is_undecided(void **state) {
    (void)state;
    surface s = surface_box(origin, 1, 0);
    s.vertices = s.faces = 0;
    for (int i = 0; i < 6; ++i) {
        const float p[3] = {(float)(i % 2), (float)(i / 2), 0}, n[3] = {0, 0, 1};
        surface_add_vertex(&s, p, n);
    }
    static const uint32_t faces[4][3] = {{0, 1, 3}, {0, 3, 2}, {2, 5, 3}, {2, 4, 5}};
    for (int i = 0; i < 4; ++i) surface_add_face(&s, faces[i]);
    const norma_finding *f = in_render(&s, "N301", NORMA_SEVERITY_WARNING);
    assert_non_null(f);
    assert_int_equal(f->fix, NORMA_FIX_NONE);
    assert_non_null(strstr(f->message, "neither volume nor rays"));
    assert_null(finding_of(found, "N301", NORMA_SEVERITY_ERROR));
    surface_free(&s);
}

/* A sheet of which one face at the border is there twice: its two copies run along that edge the
 * same way, and neither is turned. Its other face at the border is turned: that is told of. */
static void a_face_twice_is_not_turned(void **state) {
    (void)state;
    for (int polygons = 0; polygons < 2; ++polygons) {
        surface s = surface_box(origin, 1, 0);
        s.vertices = s.faces = 0;
        for (int i = 0; i < 6; ++i)
            surface_add_vertex(
                &s, (const float[3]){(float)(i % 2), (float)(i / 2), 0}, (const float[3]){0, 0, 1});
        static const uint32_t faces[5][3] = {{0, 1, 3}, {0, 3, 2}, {2, 3, 5}, {2, 5, 4}, {1, 3, 0}};
        for (int i = 0; i < 5; ++i) surface_add_face(&s, faces[i]);
        s.starts = polygons ? malloc((s.faces + 2) * sizeof *s.starts) : NULL;
        for (uint32_t f = 0; polygons && f <= s.faces; ++f) s.starts[f] = 3 * f;
        const norma_finding *f = in_render(&s, "N301", NORMA_SEVERITY_INFO);
        assert_found(f, 2); /* of three: one is shared with the next face */
        assert_int_equal(f->fix, NORMA_FIX_NONE);
        assert_found(finding_of(found, "N305", NORMA_SEVERITY_WARNING), 1);
        assert_null(finding_of(found, "N301", NORMA_SEVERITY_WARNING));
        assert_null(finding_of(found, "N301", NORMA_SEVERITY_ERROR));
        surface_turn_face(&s, 3);
        assert_found(in_render(&s, "N301", NORMA_SEVERITY_WARNING), 1);
        assert_found(finding_of(found, "N301", NORMA_SEVERITY_INFO), 2);
        surface_free(&s);
    }
}

/* ---- N307 */

static void open_edges(void **state) {
    (void)state;
    surface s = surface_torus(AROUND, ACROSS);
    assert_null(in_print(&s, "N307", NORMA_SEVERITY_NONE));
    --s.faces;
    assert_found(in_print(&s, "N307", NORMA_SEVERITY_WARNING), 3);
    assert_null(in_render(&s, "N307", NORMA_SEVERITY_NONE));
    const norma_finding *f = look(&s, "N307", NORMA_SEVERITY_ERROR,
        &(norma_check_options){.profile = NORMA_CHECK_PROFILE_GENERATED}, NORMA_FILE_GLB);
    assert_found(f, 3);
    surface_free(&s);
}

static void turned_inside_out(void **state) {
    (void)state;
    surface s = surface_torus(AROUND, ACROSS);
    for (size_t f = 0; f < s.faces; ++f) surface_turn_face(&s, f);
    const norma_finding *f = in_render(&s, "N302", NORMA_SEVERITY_WARNING);
    assert_found(f, 1);
    assert_int_equal(f->samples[0].face, 0);
    assert_true(fabs(f->worst_value + 2 * 3.141592653589793 * 3.141592653589793 * 3) <
                .1); /* the volume of a torus */
    assert_int_equal(f->fix, NORMA_FIX_UNSAFE);
    assert_found(in_print(&s, "N302", NORMA_SEVERITY_ERROR), 1);
    surface_free(&s);
}

static void shells_in_shells(void **state) {
    (void)state;
    /* From outside in: inside out; its cavity, right once that is put right; a body in it, inside
     * out; a body in that body. */
    surface s = surface_join(surface_join(surface_box(origin, 4, 1), surface_box(origin, 3, 1)),
        surface_join(surface_box(origin, 2, 1), surface_box(origin, 1, 0)));
    const norma_finding *f = in_print(&s, "N302", NORMA_SEVERITY_ERROR);
    assert_found(f, 2);
    assert_int_equal(f->samples[0].face, 0);
    assert_int_equal(f->samples[1].face, 24);
    f = finding_of(found, "N302", NORMA_SEVERITY_WARNING);
    assert_found(f, 1);
    assert_int_equal(f->samples[0].face, 36);
    assert_int_equal(f->fix, NORMA_FIX_NONE);
    assert_found(in_render(&s, "N302", NORMA_SEVERITY_INFO), 1);
    surface_free(&s);
    s = surface_join(
        surface_torus(AROUND, ACROSS), surface_box((const double[3]){3, 0, 0}, .2,
                                           0)); /* a turned cavity in a wall of many faces */
    assert_found(in_render(&s, "N302", NORMA_SEVERITY_INFO), 1);
    surface_free(&s);
    s = surface_join(surface_torus(AROUND, ACROSS),
        surface_box(origin, .2, 1)); /* in its hole: nothing encloses it */
    assert_found(in_render(&s, "N302", NORMA_SEVERITY_WARNING), 1);
    surface_free(&s);
}

static void open_surfaces(void **state) {
    (void)state;
    surface s = surface_join(surface_torus(64, 32), surface_box((const double[3]){9, 0, 0}, 1, 1));
    --s.faces;
    const norma_finding *f = in_render(&s, "N304", NORMA_SEVERITY_INFO);
    assert_found(f, 1);
    /* A face beside the one that is missing. */
    const uint32_t *open = s.corners + 3 * f->samples[0].face, *missing = s.corners + 3 * s.faces;
    size_t shared = 0;
    for (size_t i = 0; i < 9; ++i)
        shared += memcmp(s.positions + 3 * open[i / 3], s.positions + 3 * missing[i % 3],
                      3 * sizeof *s.positions) == 0;
    assert_int_equal(shared, 2);
    assert_null(finding_of(found, "N302", NORMA_SEVERITY_NONE));
    surface_free(&s);
}

/* ---- what is there twice, or too often */

static void fins_and_bow_ties(void **state) {
    (void)state;
    surface s = surface_torus(AROUND, ACROSS);
    const uint32_t *inner = s.corners + 3 * 2 * (50 * ACROSS + 20);
    const uint32_t edge[2] = {inner[0], inner[1]};
    const float away[3] = {9, 9, 9}, up[3] = {0, 0, 1}, tip[2][3] = {{20, 1, 0}, {20, 0, 1}};
    surface_add_face(&s, (uint32_t[]){edge[0], edge[1], surface_add_vertex(&s, away, up)});
    const norma_finding *f = in_render(&s, "N303", NORMA_SEVERITY_INFO);
    assert_found(f, 1);
    assert_true(f->samples[0].vertex == edge[0] || f->samples[0].vertex == edge[1]);
    assert_true(f->worst_value == 3);
    surface_add_face(
        &s, (uint32_t[]){s.corners[3 * 2 * (70 * ACROSS + 20)], surface_add_vertex(&s, tip[0], up),
                surface_add_vertex(&s, tip[1], up)});
    assert_found(in_print(&s, "N303", NORMA_SEVERITY_WARNING), 2);
    surface_free(&s);
}

static void twice(void **state) {
    (void)state;
    surface s = surface_torus(AROUND, ACROSS);
    uint32_t copy[3];
    memcpy(copy, s.corners + 3 * 4000, sizeof copy);
    const size_t same = surface_add_face(&s, (uint32_t[]){copy[1], copy[2], copy[0]});
    const norma_finding *f = in_render(&s, "N305", NORMA_SEVERITY_INFO);
    assert_found(f, 1);
    assert_int_equal(f->samples[0].face, same);
    assert_null(finding_of(found, "N306", NORMA_SEVERITY_NONE));
    assert_found(finding_of(found, "N303", NORMA_SEVERITY_INFO), 3);
    surface_turn_face(&s, same);
    f = in_render(&s, "N306", NORMA_SEVERITY_INFO);
    assert_found(f, 1);
    assert_null(finding_of(found, "N305", NORMA_SEVERITY_NONE));
    assert_null(finding_of(found, "N303", NORMA_SEVERITY_NONE)); /* the pair explains its edges */
    assert_found(in_print(&s, "N306", NORMA_SEVERITY_WARNING), 1);
    surface_free(&s);
    /* Each face of a body with its reversed twin, on vertices of their own. */
    s = surface_torus(40, 20);
    surface back = surface_torus(40, 20);
    for (size_t k = 0; k < back.faces; ++k) surface_turn_face(&back, k);
    for (size_t v = 0; v < back.vertices; ++v) scale_normal(&back, v, -1);
    s = surface_join(s, back);
    assert_found(in_render(&s, "N306", NORMA_SEVERITY_WARNING), 2 * 40 * 20);
    assert_null(finding_of(found, "N302", NORMA_SEVERITY_NONE));
    assert_null(finding_of(found, "N303", NORMA_SEVERITY_NONE));
    surface_free(&s);
}

/* ---- shapes */

static void flat_faces(void **state) {
    (void)state;
    surface s = surface_torus(64, 32);
    const float up[3] = {0, 0, 1};
    const uint32_t a = surface_add_vertex(&s, (const float[3]){10, 0, 0}, up),
                   b = surface_add_vertex(&s, (const float[3]){12, 0, 0}, up);
    const uint32_t collinear = surface_add_vertex(&s, (const float[3]){11, 0, 0}, up),
                   thin = surface_add_vertex(&s, (const float[3]){11, 1e-6f, 0}, up);
    const uint32_t sliver = surface_add_vertex(&s, (const float[3]){11, 1e-3f, 0}, up),
                   fine = surface_add_vertex(&s, (const float[3]){11, 4e-3f, 0}, up);
    const size_t first = surface_add_face(&s, (uint32_t[]){a, b, collinear});
    surface_add_face(&s, (uint32_t[]){a, b, thin});
    surface_add_face(&s, (uint32_t[]){a, a, b});
    const size_t narrow = surface_add_face(&s, (uint32_t[]){a, b, sliver});
    surface_add_face(&s, (uint32_t[]){a, b, fine});
    const norma_finding *f = in_render(&s, "N401", NORMA_SEVERITY_INFO);
    assert_found(f, 3);
    assert_int_equal(f->samples[0].face, first);
    f = finding_of(found, "N402", NORMA_SEVERITY_INFO);
    assert_found(f, 1);
    assert_int_equal(f->samples[0].face, narrow);
    assert_true(fabs(f->worst_value - .0573) < .001);
    assert_found(in_print(&s, "N401", NORMA_SEVERITY_INFO), 3);
    surface_free(&s);
}

/* Two tips that meet in one vertex, from above and from below. */
static void cancelled(void **state) {
    (void)state;
    surface s = surface_torus(64, 32);
    const float up[3] = {0, 0, 1};
    const uint32_t middle = surface_add_vertex(&s, (const float[3]){10, 0, 0}, up);
    uint32_t ring[2][4];
    for (int side = 0; side < 2; ++side)
        for (int k = 0; k < 4; ++k) {
            const float p[3] = {
                (float)(10 + (k == 0) - (k == 2)), (float)((k == 1) - (k == 3)), side ? 1 : -1};
            ring[side][k] = surface_add_vertex(&s, p, up);
        }
    for (size_t k = 0; k < 4; ++k) {
        surface_add_face(&s, (uint32_t[]){middle, ring[0][k], ring[0][(k + 1) % 4]});
        surface_add_face(&s, (uint32_t[]){middle, ring[1][(k + 1) % 4], ring[1][k]});
    }
    const norma_finding *f = in_render(&s, "N403", NORMA_SEVERITY_INFO);
    assert_found(f, 1);
    assert_int_equal(f->samples[0].vertex, middle);
    free(s.normals);
    s.normals = NULL;
    s.mesh.info.normals = NORMA_NORMALS_NONE;
    assert_found(in_render(&s, "N403", NORMA_SEVERITY_WARNING), 1);
    surface_free(&s);
}

/* A row of polygons of one kind each. */
static void polygons(void **state) {
    (void)state;
    static const float shapes[][5][3] = {
        {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {-.5f, .5f, 0}}, /* convex */
        {{10, 0, 0}, {12, 0, 0}, {10.5f, .5f, 0}, {10, 2, 0},
            {9.5f, 1, 0}}, /* concave, but not as seen from its first corner */
        {{22, 0, 0}, {20.5f, .5f, 0}, {20, 2, 0}, {19.5f, 1, 0},
            {20, 0, 0}}, /* the same from another corner: the fan folds */
        {{30, 0, 0}, {32, 0, 0}, {30.2f, 1.5f, 0}, {31.8f, 1.4f, 0},
            {31, 3, 0}}, /* its edges cross */
        {{40, 0, 0}, {41, 0, 0}, {41, 1, .05f}, {40, 1, 0},
            {39.5f, .5f, 0}}, /* bent by more than a degree */
        {{50, 0, 0}, {51, 0, 0}, {51, 1, .005f}, {50, 1, 0}, {49.5f, .5f, 0}}, /* by less */
    };
    surface s = {.faces = COUNT_OF(shapes), .vertices = 5 * COUNT_OF(shapes)};
    s.positions = malloc(sizeof shapes);
    s.corners = malloc(5 * COUNT_OF(shapes) * sizeof *s.corners);
    s.starts = malloc((COUNT_OF(shapes) + 1) * sizeof *s.starts);
    memcpy(s.positions, shapes, sizeof shapes);
    for (uint32_t c = 0; c < 5 * COUNT_OF(shapes); ++c) s.corners[c] = c;
    for (uint32_t f = 0; f <= COUNT_OF(shapes); ++f) s.starts[f] = 5 * f;
    const norma_finding *f = look(&s, "N404", NORMA_SEVERITY_WARNING, NULL, NORMA_FILE_OBJ);
    assert_found(f, 2);
    assert_int_equal(f->samples[0].face, 2);
    assert_int_equal(f->samples[1].face, 3);
    assert_int_equal(f->fix, NORMA_FIX_UNSAFE);
    f = finding_of(found, "N405", NORMA_SEVERITY_INFO);
    assert_found(f, 1);
    assert_int_equal(f->samples[0].face, 4);
    surface_free(&s);
}

/* ---- seams, soups, cracks */

static void turn_normal(surface *s, size_t vertex, double degrees) {
    const double x = (double)s->normals[3 * vertex], y = (double)s->normals[3 * vertex + 1],
                 a = degrees / DEGREES;
    set_normal(s, vertex, cos(a) * x - sin(a) * y, sin(a) * x + cos(a) * y,
        (double)s->normals[3 * vertex + 2]);
}

static void a_seam_two_degrees_apart(void **state) {
    (void)state;
    surface s = surface_torus(AROUND, ACROSS);
    for (size_t k = 3; k < 8; ++k)
        turn_normal(&s, k, 2); /* the first of both sides of the seam across */
    const norma_finding *f = in_render(&s, "N501", NORMA_SEVERITY_WARNING);
    assert_found(f, 5);
    for (size_t i = 0; i < 5; ++i) assert_int_equal(f->samples[i].vertex, 3 + i);
    assert_true(f->worst_value > 1.9 && f->worst_value < 2.01);
    for (size_t k = 3; k < 8; ++k) turn_normal(&s, k, -1.5);
    assert_null(in_render(&s, "N501", NORMA_SEVERITY_NONE)); /* half a degree */
    for (size_t k = 3; k < 8; ++k) turn_normal(&s, k, 1.2);
    assert_non_null(in_render(&s, "N501", NORMA_SEVERITY_WARNING));
    s.mesh.info.encoding = "oct8"; /* twice .957 */
    assert_null(in_render(&s, "N501", NORMA_SEVERITY_NONE));
    surface_free(&s);
    s = surface_torus(AROUND, ACROSS); /* a vertex of one face alone, with UVs of its own */
    const size_t lone = 2 * (50 * ACROSS + 20), old = s.corners[3 * lone];
    s.corners[3 * lone] = surface_add_vertex(&s,
        (const float[3]){s.positions[3 * old], s.positions[3 * old + 1], s.positions[3 * old + 2]},
        (const float[3]){s.normals[3 * old], s.normals[3 * old + 1], s.normals[3 * old + 2]});
    turn_normal(&s, s.corners[3 * lone], 5);
    assert_null(in_render(&s, "N501", NORMA_SEVERITY_NONE));
    surface_free(&s);
    s = surface_torus(AROUND, ACROSS); /* no UVs: what parts the vertices is their normals alone */
    for (size_t k = 3; k < 8; ++k) turn_normal(&s, k, 2);
    memset(s.texcoords, 0, 8 * s.vertices);
    assert_null(in_render(&s, "N501", NORMA_SEVERITY_NONE));
    surface_free(&s);
    s = surface_box(origin, 1, 0); /* edges of ninety degrees */
    for (size_t v = 0; v < s.vertices; ++v) s.texcoords[2 * v] = (float)v;
    assert_null(in_render(&s, "N501", NORMA_SEVERITY_NONE));
    surface_free(&s);
}

enum { ROUND = 48, OVER = 32 };

/* A torus of quads, cut into patches of rows by columns of them, that have vertices, UVs and
 * normals of their own: the mean of each patch's faces, at each vertex. Patches of one quad are
 * flat. */
static surface patched_torus(size_t rows, size_t columns, int own_islands) {
    surface smooth = surface_torus(ROUND, OVER), s = surface_box(origin, 1, 0);
    const size_t over = OVER / columns, side = columns + 1;
    s.vertices = s.faces = 0;
    for (size_t p = 0; p < ROUND / rows * over; ++p) {
        const uint32_t first = (uint32_t)s.vertices;
        for (size_t i = 0; i < (rows + 1) * side; ++i)
            surface_add_vertex(&s, (const float[3]){0, 0, 0}, (const float[3]){0, 0, 0});
        for (size_t q = 0; q < rows * columns; ++q) {
            const size_t x = q / columns, y = q % columns,
                         at = (p / over * rows + x) * OVER + p % over * columns + y;
            const uint32_t *c = &smooth.corners[6 * at], quad[4] = {c[0], c[1], c[2], c[5]},
                           a = first + (uint32_t)(x * side + y), b = a + (uint32_t)side,
                           own[4] = {a, b, b + 1, a + 1};
            float normal[3] = {0, 0, 0};
            for (uint32_t k = 0; k < 12; ++k)
                normal[k % 3] += smooth.normals[3 * quad[k / 3] + k % 3];
            for (int k = 0; k < 4; ++k) {
                memcpy(&s.positions[3 * own[k]], &smooth.positions[3 * quad[k]], 12);
                for (uint32_t d = 0; d < 3; ++d) s.normals[3 * own[k] + d] += normal[d];
                memcpy(&s.texcoords[2 * own[k]], &smooth.texcoords[2 * quad[k]], 8);
                if (own_islands) s.texcoords[2 * own[k]] += (float)(2 * p);
            }
            surface_add_face(&s, (const uint32_t[3]){own[0], own[1], own[2]});
            surface_add_face(&s, (const uint32_t[3]){own[0], own[2], own[3]});
        }
    }
    for (size_t v = 0; v < s.vertices; ++v) {
        float *n = &s.normals[3 * v];
        const float length = sqrtf(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        for (int d = 0; d < 3; ++d) n[d] /= length;
    }
    surface_free(&smooth);
    return s;
}

/* Each quad has vertices and a normal of its own: the seam of UVs is a hard edge like all others,
 * and so is each edge where each quad is an island of its own. */
static void a_seam_of_a_flat_file(void **state) {
    (void)state;
    for (int own_islands = 0; own_islands < 2; ++own_islands) {
        surface s = patched_torus(1, 1, own_islands);
        assert_null(in_render(&s, "N501", NORMA_SEVERITY_NONE));
        assert_null(finding_of(found, "N201", NORMA_SEVERITY_NONE));
        surface_free(&s);
    }
}

/* Islands that are smooth within: all positions on their borders are told of. Along the borders of
 * strips as narrow as a face there is no edge that is smooth; yet the strips are not flat. */
static void seams_of_many_islands(void **state) {
    (void)state;
    surface s = patched_torus(4, 4, 1);
    const size_t inner = ROUND / 4 * (OVER / 4) * 9;
    assert_found(in_render(&s, "N501", NORMA_SEVERITY_WARNING), ROUND * OVER - inner);
    surface_free(&s);
    s = patched_torus(4, 1, 1);
    assert_found(in_render(&s, "N501", NORMA_SEVERITY_WARNING), ROUND * OVER);
    surface_free(&s);
}

enum { SIDE = 6 };

/* A flat sheet of two halves with UVs of their own, whose normals at the seam are 3 degrees apart.
 */
static surface parted_sheet(void) {
    surface s = surface_box(origin, 1, 0);
    s.vertices = s.faces = 0;
    for (int half = 0; half < 2; ++half) {
        const uint32_t first = (uint32_t)s.vertices;
        for (int y = 0; y <= SIDE; ++y)
            for (int x = 0; x <= SIDE / 2; ++x) {
                const double a = half && x == 0 ? 3 / DEGREES : 0;
                const float p[3] = {(float)(x + half * SIDE / 2), (float)y, 0},
                            n[3] = {(float)sin(a), 0, (float)cos(a)};
                const uint32_t v = surface_add_vertex(&s, p, n);
                s.texcoords[2 * v] = (float)(x + 10 * half);
            }
        for (uint32_t y = 0; y < SIDE; ++y)
            for (uint32_t x = 0; x < SIDE / 2; ++x) {
                const uint32_t at = first + y * (SIDE / 2 + 1) + x, above = at + SIDE / 2 + 1;
                surface_add_face(&s, (const uint32_t[3]){at, at + 1, above});
                surface_add_face(&s, (const uint32_t[3]){at + 1, above + 1, above});
            }
    }
    return s;
}

/* A face without area between two of them says nothing of how the surface bends. */
static void a_seam_at_a_degenerate_face(void **state) {
    (void)state;
    surface s = parted_sheet();
    const uint32_t stride = SIDE / 2 + 1, first = stride * (SIDE + 1);
    assert_found(in_render(&s, "N501", NORMA_SEVERITY_WARNING), SIDE - 1);
    /* The edge from (3, 3) to (4, 3), of the face above it, gets a vertex in its middle. */
    const uint32_t a = first + 3 * stride, b = a + 1, above = a + stride,
                   middle = surface_add_vertex(
                       &s, (const float[3]){3.5f, 3, 0}, (const float[3]){0, 0, 1});
    for (size_t f = 0; f < s.faces; ++f) {
        uint32_t *c = &s.corners[3 * f];
        if (c[0] == a && c[1] == b && c[2] == above) c[1] = middle;
    }
    surface_add_face(&s, (const uint32_t[3]){middle, b, above});
    surface_add_face(&s, (const uint32_t[3]){a, b, middle});
    assert_found(in_render(&s, "N501", NORMA_SEVERITY_INFO), SIDE - 2);
    assert_found(finding_of(found, "N401", NORMA_SEVERITY_INFO), 1);
    surface_free(&s);
}

/* A torus cut into two primitives of one mesh, the second half with a material of its own: vertices
 * on the border are in both, some turned there. */
static void a_seam_between_primitives(void **state) {
    (void)state;
    for (int turned = 0; turned < 2; ++turned) {
        surface a = surface_torus(AROUND, ACROSS), b = surface_torus(AROUND, ACROSS);
        const size_t half = a.faces / 2;
        memset(a.texcoords, 0, 8 * a.vertices);
        memset(b.texcoords, 0, 8 * b.vertices);
        for (size_t k = 3; turned && k < 8; ++k) turn_normal(&b, b.corners[3 * half] + k, 3);
        (void)in_render(&a, "N501", NORMA_SEVERITY_NONE); /* makes the views */
        (void)in_render(&b, "N501", NORMA_SEVERITY_NONE);
        norma_check_mesh meshes[2] = {a.mesh, b.mesh};
        for (size_t i = 0; i < 2; ++i) {
            norma_mesh *mesh = &meshes[i].data.mesh;
            mesh->corners = (i ? b.corners : a.corners) + (i ? 3 * half : 0);
            mesh->corner_count = 3 * (i ? b.faces - half : half);
            meshes[i].info.where = i ? "/meshes/0/primitives/1" : "/meshes/0/primitives/0";
            meshes[i].info.primitive = i;
            meshes[i].attributes.material = i;
        }
        norma_findings *findings = NULL;
        const norma_check_scene scene = {
            .meshes = meshes, .mesh_count = 2, .format = NORMA_FILE_GLB};
        assert_int_equal(norma_check_scene_run(&scene, NULL, &findings), NORMA_OK);
        const norma_finding *f = finding_of(findings, "N501", NORMA_SEVERITY_NONE);
        if (turned) {
            assert_found(f, 5);
            assert_string_equal(f->where, "/meshes/0/primitives/1");
            assert_true(f->worst_value > 2.8 && f->worst_value < 3.01);
            for (size_t i = 0; i < 5; ++i)
                assert_int_equal(f->samples[i].vertex, b.corners[3 * half] + 3 + i);
        } else {
            assert_null(f);
        }
        norma_findings_free(findings);
        surface_free(&a);
        surface_free(&b);
    }
}

static void soups_and_cracks(void **state) {
    (void)state;
    surface s = surface_soup(surface_torus(64, 32));
    assert_found(in_render(&s, "N502", NORMA_SEVERITY_INFO), 1);
    surface_free(&s);
    s = surface_torus(AROUND, ACROSS);
    assert_null(in_render(&s, "N502", NORMA_SEVERITY_NONE));
    assert_null(finding_of(found, "N503", NORMA_SEVERITY_NONE));
    for (size_t k = 10; k < 14; ++k)
        s.positions[3 * k] += 2e-6f; /* diagonal about 12, spacing of floats at 4 about 5e-7 */
    const norma_finding *f = in_render(&s, "N503", NORMA_SEVERITY_INFO);
    assert_found(f, 8);
    assert_int_equal(f->samples[0].vertex, 10);
    for (size_t k = 10; k < 14; ++k) s.positions[3 * k] += 1e-3f;
    assert_null(in_render(&s, "N503", NORMA_SEVERITY_NONE));
    surface_free(&s);
    /* Every 50th face a little aside, in whatever cell it lies: its positions and those of its
     * neighbours, each once. */
    s = surface_torus(AROUND, ACROSS);
    uint8_t aside[AROUND * ACROSS] = {0};
    size_t places = 0;
    for (size_t c = 0; c < 3 * s.faces; ++c) {
        const size_t place =
            s.corners[c] / (ACROSS + 1) % AROUND * ACROSS + s.corners[c] % (ACROSS + 1) % ACROSS;
        places += c / 3 % 50 == 0 && !aside[place];
        aside[place] |= c / 3 % 50 == 0;
    }
    s = surface_soup(s);
    for (size_t v = 0; v < s.vertices; ++v)
        if (v / 3 % 50 == 0) s.positions[3 * v] += s.positions[3 * v] > 0 ? -6e-6f : 6e-6f;
    assert_found(in_render(&s, "N503", NORMA_SEVERITY_INFO), 2 * places);
    surface_free(&s);
}

/* ---- precision */

static void far_away(void **state) {
    (void)state;
    surface s = surface_torus(AROUND, ACROSS);
    for (size_t v = 0; v < s.vertices; ++v) s.positions[3 * v + 1] += 100000;
    const norma_finding *f = in_render(&s, "N701", NORMA_SEVERITY_WARNING);
    assert_found(f, 1);
    assert_true(
        f->worst_value > .02 && f->worst_value < .3); /* spacing .0078, edges from .03 to .3 */
    surface_free(&s);
    s = surface_torus(AROUND, ACROSS);
    for (size_t v = 0; v < s.vertices; ++v) s.positions[3 * v + 1] += 1000;
    assert_null(in_render(&s, "N701", NORMA_SEVERITY_NONE));
    s.mesh.info.encoding = "snorm8";
    assert_found(in_render(&s, "N702", NORMA_SEVERITY_INFO), 1);
    s.mesh.info.encoding = "snorm16";
    assert_null(in_render(&s, "N702", NORMA_SEVERITY_NONE));
    surface_free(&s);
}

/* ---- how it is told */

static void samples_rules_and_silence(void **state) {
    (void)state;
    surface s = surface_torus(AROUND, ACROSS);
    for (size_t v = 100; v < 200; ++v) set_normal(&s, v, 0, 0, 0);
    const norma_finding *f = in_render(&s, "N102", NORMA_SEVERITY_ERROR);
    assert_found(f, 100);
    assert_int_equal(f->sample_count, 10);
    f = look(&s, "N102", NORMA_SEVERITY_ERROR, &(norma_check_options){.max_samples = 37},
        NORMA_FILE_GLB);
    assert_int_equal(f->sample_count, 37);
    assert_int_equal(f->samples[36].vertex, 136);
    uint8_t mask[128] = {0};
    assert_ok(norma_rules_select("n3, zero-normal", mask, NULL));
    (void)look(
        &s, "N102", NORMA_SEVERITY_ERROR, &(norma_check_options){.rules = mask}, NORMA_FILE_GLB);
    assert_int_equal(norma_findings_count(found), 1);
    s.mesh.material.ignore = "N204,zero-normal,no-such-rule";
    assert_null(in_render(&s, "N102", NORMA_SEVERITY_NONE));
    assert_null(finding_of(found, "N204", NORMA_SEVERITY_NONE));
    s.mesh.material.ignore = NULL;
    s.mesh.attributes.ignore = "N1";
    assert_null(in_render(&s, "N102", NORMA_SEVERITY_NONE));
    surface_free(&s);
}

static void lists_of_rules(void **state) {
    (void)state;
    size_t count;
    const norma_rule *rules = norma_rules(&count);
    uint8_t mask[128] = {0};
    char unknown[64] = "";
    assert_int_equal(count, 50);
    for (size_t i = 0; i < count; ++i) {
        assert_true(i == 0 || strcmp(rules[i - 1].id, rules[i].id) < 0);
        assert_true(*rules[i].what && *rules[i].cause && *rules[i].why && *rules[i].how);
        assert_int_equal(rules[i].fix != NORMA_FIX_NONE, *rules[i].fix_verb != 0);
        for (size_t j = 0; j < i; ++j) /* a cause and an impact of its own */
            assert_true(
                strcmp(rules[i].cause, rules[j].cause) && strcmp(rules[i].why, rules[j].why));
    }
    assert_int_equal(norma_rules_select("N301,nonsense", mask, unknown), NORMA_ERROR_ARGUMENT);
    assert_string_equal(unknown, "nonsense");
    for (size_t i = 0; i < count; ++i) assert_int_equal(mask[i], 0);
    assert_ok(norma_rules_select(" N30 ,triangle-soup,", mask, unknown));
    for (size_t i = 0; i < count; ++i)
        assert_int_equal(mask[i], !strncmp(rules[i].id, "N30", 3) || !strcmp(rules[i].id, "N502"));
}

static void assert_same_sample(const norma_sample *a, const norma_sample *b) {
    assert_int_equal(a->vertex, b->vertex);
    assert_int_equal(a->face, b->face);
    assert_int_equal(a->normal, b->normal);
    assert_int_equal(a->has_position, b->has_position);
    assert_memory_equal(a->position, b->position, sizeof a->position);
}

static void threads_change_nothing(void **state) {
    (void)state;
    surface s = surface_soup(surface_torus(AROUND, ACROSS));
    for (size_t f = 0; f < s.faces; f += 97) surface_turn_face(&s, f);
    for (size_t v = 0; v < s.vertices; v += 331) set_normal(&s, v, 0, 0, v % 2 ? 0 : 3);
    for (size_t v = 0; v < s.vertices; v += 501) s.positions[3 * v] += 3e-6f;
    norma_findings *one = surface_findings(&s, NULL, NORMA_FILE_GLB),
                   *many =
                       surface_findings(&s, &(norma_check_options){.threads = 8}, NORMA_FILE_GLB);
    assert_int_equal(norma_findings_count(one), norma_findings_count(many));
    for (size_t i = 0; i < norma_findings_count(one); ++i) {
        const norma_finding *a = norma_findings_get(one, i), *b = norma_findings_get(many, i);
        assert_ptr_equal(a->rule, b->rule);
        assert_string_equal(a->message, b->message);
        assert_int_equal(a->count, b->count);
        assert_int_equal(a->sample_count, b->sample_count);
        for (size_t k = 0; k < a->sample_count; ++k)
            assert_same_sample(&a->samples[k], &b->samples[k]);
        assert_same_sample(&a->worst, &b->worst);
        assert_memory_equal(&a->worst_value, &b->worst_value, sizeof a->worst_value);
    }
    norma_findings_free(one);
    norma_findings_free(many);
    surface_free(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(clean_surfaces_stay_clean),
        cmocka_unit_test(lengths),
        cmocka_unit_test(faces_without_a_place),
        cmocka_unit_test(opposing_normals),
        cmocka_unit_test(opposing_normals_by_area),
        cmocka_unit_test(one_normal_far_off),
        cmocka_unit_test(placeholders),
        cmocka_unit_test(explained),
        cmocka_unit_test(deviation_has_a_place),
        cmocka_unit_test(facets),
        cmocka_unit_test(facets_of_polygons),
        cmocka_unit_test(one_face_turned_in_a_hundred_thousand),
        cmocka_unit_test(one_face_turned_in_a_soup),
        cmocka_unit_test(pieces_that_touch),
        cmocka_unit_test(a_sheet_is_undecided),
        cmocka_unit_test(a_face_twice_is_not_turned),
        cmocka_unit_test(open_edges),
        cmocka_unit_test(turned_inside_out),
        cmocka_unit_test(shells_in_shells),
        cmocka_unit_test(open_surfaces),
        cmocka_unit_test(fins_and_bow_ties),
        cmocka_unit_test(twice),
        cmocka_unit_test(flat_faces),
        cmocka_unit_test(cancelled),
        cmocka_unit_test(polygons),
        cmocka_unit_test(a_seam_two_degrees_apart),
        cmocka_unit_test(a_seam_of_a_flat_file),
        cmocka_unit_test(seams_of_many_islands),
        cmocka_unit_test(a_seam_at_a_degenerate_face),
        cmocka_unit_test(a_seam_between_primitives),
        cmocka_unit_test(soups_and_cracks),
        cmocka_unit_test(far_away),
        cmocka_unit_test(samples_rules_and_silence),
        cmocka_unit_test(lists_of_rules),
        cmocka_unit_test(threads_change_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, tear_down);
}
