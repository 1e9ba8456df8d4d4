/* test_shared_edges.c: who shares an edge, worked by hand: faces that run twice along an edge, back
 * to back faces that do, and the faces that others without a direction borrow from. Each answer
 * must be that of corner normals, of the split mesh and of a plan. */
#include "check.h"
#include "mesh_files.h"

static const float PI_FLOAT = 3.14159274f;

enum { MOST_CORNERS = 36 };
typedef struct result {
    float normals[3 * MOST_CORNERS];
    uint8_t reasons[MOST_CORNERS];
    norma_report report;
    norma_edges edges;
    norma_options options;
} result;

static void compare_split(const norma_mesh *mesh, float crease, const result *r) {
    uint32_t corners[MOST_CORNERS], sources[MOST_CORNERS];
    float normals[3 * MOST_CORNERS];
    size_t count = 0;
    norma_report report;
    norma_options options = r->options;
    options.reasons = NULL;
    options.edges = NULL;
    assert_ok(norma_split(mesh, crease, &options, corners, MOST_CORNERS, sources, normals,
        MOST_CORNERS, &count, &report));
    for (size_t c = 0; c < mesh->corner_count; ++c)
        assert_memory_equal(normals + 3 * (size_t)corners[c], r->normals + 3 * c, 12);
    assert_int_equal(report.non_manifold_edges.count, r->report.non_manifold_edges.count);
    assert_int_equal(report.winding_conflicts.count, r->report.winding_conflicts.count);
}

static void compare_plan(const norma_mesh *mesh, float crease, const result *r) {
    float normals[3 * MOST_CORNERS];
    norma_plan *plan;
    norma_edges edges = {0};
    norma_options options = r->options;
    options.reasons = NULL;
    options.edges = &edges;
    assert_ok(norma_plan_create(mesh, NORMA_PER_CORNER, crease, &options, &plan));
    options.edges = NULL;
    assert_ok(
        norma_plan_update(plan, mesh->positions, NULL, 0, &options, normals, MOST_CORNERS, NULL));
    assert_memory_equal(normals, r->normals, 12 * mesh->corner_count);
    assert_memory_equal(&edges, &r->edges, sizeof edges);
    norma_plan_destroy(plan);
}

static result corners_with(const norma_mesh *mesh, double crease_deg, norma_options options) {
    result r = {.options = options};
    const float crease = crease_deg >= 180 ? PI_FLOAT : (float)(crease_deg / DEGREES);
    r.options.struct_size = sizeof r.options;
    r.options.reasons = r.reasons;
    r.options.edges = &r.edges;
    assert_ok(norma_corner_normals(mesh, crease, &r.options, r.normals, MOST_CORNERS, &r.report));
    compare_split(mesh, crease, &r);
    compare_plan(mesh, crease, &r);
    return r;
}

static result corners(const norma_mesh *mesh, double crease_deg) {
    return corners_with(mesh, crease_deg, (norma_options){0});
}

#define POLYGONS(p, c, s)                                                                          \
    (norma_mesh) {                                                                                 \
        .positions = {p, sizeof(p) / 12, 0, NORMA_FORMAT_FLOAT}, .corners = c,                     \
        .corner_count = COUNT_OF(c), .face_starts = s, .face_count = COUNT_OF(s) - 1               \
    }
#define at(i)              (r.normals + 3 * (size_t)(i))
#define assert_same(i, j)  assert_memory_equal(at(i), at(j), 12)
#define assert_other(i, j) assert_memory_not_equal(at(i), at(j), 12)
#define assert_edges(n, no_face_beside, smooth_ones, hard_ones)                                    \
    do {                                                                                           \
        assert_int_equal(r.edges.count, n);                                                        \
        assert_int_equal(r.edges.open, no_face_beside);                                            \
        assert_int_equal(r.edges.smooth, smooth_ones);                                             \
        assert_int_equal(r.edges.hard, hard_ones);                                                 \
    } while (0)
#define assert_report(non_manifold, conflicts)                                                     \
    do {                                                                                           \
        assert_int_equal(r.report.non_manifold_edges.count, non_manifold);                         \
        assert_int_equal(r.report.winding_conflicts.count, conflicts);                             \
    } while (0)

/* A square with a square hole, as one polygon: in along the slit 0 4, round the hole, out again;
 * and a square at its left side 3 0 (corners 10 to 13), hanging down. */
static const float KEYHOLE[] = {0, 0, 0, 8, 0, 0, 8, 8, 0, 0, 8, 0, 2, 2, 0, 6, 2, 0, 6, 6, 0, 2, 6,
    0, -4, 8, -1, -4, 0, -1, 0, 0, 4};
static const uint32_t KEYHOLE_CORNERS[] = {0, 1, 2, 3, 0, 4, 7, 6, 5, 4, 0, 3, 8, 9, 4, 0, 10};

static void a_slit_is_shared_by_its_face(void **state) {
    (void)state;
    static const uint32_t starts[] = {0, 10, 14};
    norma_mesh mesh = POLYGONS(KEYHOLE, KEYHOLE_CORNERS, starts);
    mesh.corner_count = 14;
    result r = corners(&mesh, 30);
    assert_edges(4 + 4 + 1 + 3, 3 + 4 + 3, 2, 0);
    assert_report(0, 0);
    assert_same(4, 10); /* at 0, beside the square */
    assert_same(0, 10); /* at 0, on the slit's other side */
    assert_direction(at(1), 0, 0, 1, 0);
    assert_other(0, 1);

    uint8_t hard[14] = {0};
    mesh.hard_edges = hard;
    for (int side = 0; side < 2; ++side) { /* 0 4 begins at corner 4, 4 0 at corner 9 */
        hard[4] = (uint8_t)!side;
        hard[9] = (uint8_t)side;
        r = corners(&mesh, 30);
        assert_edges(12, 10, 1, 1);
        assert_same(4, 10);
        assert_direction(at(0), 0, 0, 1, 0);
        assert_other(0, 10);
    }
    static const uint32_t groups[] = {2, 1}; /* the slit's sides have the group in common */
    mesh.hard_edges = NULL;
    mesh.smoothing_groups = groups;
    r = corners(&mesh, 30);
    assert_edges(12, 10, 1, 1);
    assert_same(0, 4);
    assert_other(0, 10);
}

/* A third face, from 4 to 0 as the polygon's second run goes: the first run has two partners. */
static void a_face_more_at_a_slit_is_one_too_many(void **state) {
    (void)state;
    static const uint32_t starts[] = {0, 10, 14, 17};
    const norma_mesh mesh = POLYGONS(KEYHOLE, KEYHOLE_CORNERS, starts);
    result r = corners(&mesh, 30);
    assert_edges(12 + 2, 10 + 2, 1, 0);
    assert_report(1, 0);
    assert_int_equal(r.report.non_manifold_edges.first, 4);
    assert_same(4, 10);
    assert_other(0, 10);
    r = corners_with(&mesh, 30, (norma_options){.non_manifold = NORMA_NON_MANIFOLD_SMOOTH});
    assert_edges(14, 12, 1, 0);
    assert_report(1, 0);
    assert_same(0, 10);   /* the two runs are partners, whoever else there is */
    assert_other(15, 10); /* the third face is beyond the crease */
    r = corners_with(&mesh, 180, (norma_options){.non_manifold = NORMA_NON_MANIFOLD_SMOOTH});
    assert_same(15, 10);
}

/* Both sides of a sheet with a slit: each run's partner is its own face's other run. */
static void a_slit_in_a_double_sided_sheet(void **state) {
    (void)state;
    static const uint32_t c[] = {0, 1, 2, 3, 0, 4, 7, 6, 5, 4, 5, 6, 7, 4, 0, 3, 2, 1, 0, 4},
                          starts[] = {0, 10, 20};
    norma_mesh mesh = POLYGONS(KEYHOLE, c, starts);
    result r = corners(&mesh, 180);
    assert_edges(9, 0, 1, 8);
    assert_report(0, 0);
    for (size_t i = 0; i < 20; ++i) assert_direction(at(i), 0, 0, i < 10 ? 1 : -1, 0);
    r = corners_with(&mesh, 180, (norma_options){.non_manifold = NORMA_NON_MANIFOLD_SMOOTH});
    for (size_t i = 0; i < 20; ++i) assert_direction(at(i), 0, 0, i < 10 ? 1 : -1, 0);

    /* The same face again is no twin: at the slit each run has two partners. */
    static const uint32_t again[] = {0, 1, 2, 3, 0, 4, 7, 6, 5, 4, 7, 6, 5, 4, 0, 1, 2, 3, 0, 4};
    mesh.corners = again;
    r = corners(&mesh, 180);
    assert_edges(9, 0, 0, 0);
    assert_report(1, 8);
}

/* Two lobes, each run round twice in one direction at 0 1. */
static void twice_the_same_way_is_a_conflict(void **state) {
    (void)state;
    static const float p[] = {0, 0, 0, 2, 0, 0, 2, 2, 0, 1, -1, 4};
    static const uint32_t c[] = {0, 1, 2, 0, 1, 3}, starts[] = {0, 6};
    const norma_mesh mesh = POLYGONS(p, c, starts);
    const result r = corners(&mesh, 180);
    assert_edges(5, 4, 0, 0);
    assert_report(0, 1);
    assert_int_equal(r.report.winding_conflicts.first, 0);
}

/* There and back: no area, and at both edges its two runs are twins, back to back. */
static void a_face_that_is_its_own_reverse(void **state) {
    (void)state;
    static const float p[] = {0, 0, 0, 2, 0, 0, 0, 2, 0, -1, 0, 0};
    static const uint32_t c[] = {0, 1, 0, 2, 0, 1, 0, 2}, starts[] = {0, 4, 8};
    norma_mesh mesh = POLYGONS(p, c, starts);
    mesh.corner_count = 4;
    mesh.face_count = 1;
    result r = corners(&mesh, 180);
    assert_edges(2, 0, 0, 2);
    assert_int_equal(r.report.degenerate_faces.count, 1);
    mesh.corner_count = 8; /* twice: four runs, all each other's twins */
    mesh.face_count = 2;
    r = corners(&mesh, 180);
    assert_edges(2, 0, 0, 0);
    assert_report(2, 0);
    r = corners_with(&mesh, 180, (norma_options){.non_manifold = NORMA_NON_MANIFOLD_SMOOTH});
    assert_edges(2, 0, 0, 0);
}

/* 3 x 3 quads of a bent sheet, where the middle one (corners 16 to 19) names its second position in
 * place of its fourth: it shares a b and b c with the faces beyond them and is in their fans; on
 * its way back only its own first run comes against it. */
static void a_quad_that_names_a_position_twice(void **state) {
    (void)state;
    float p[3 * 16];
    uint32_t c[36], starts[10] = {0};
    for (uint32_t i = 0; i < 16; ++i) {
        const float x = (float)(i % 4);
        memcpy(p + 3 * i, (const float[]){x, (float)(i / 4), .1f * x * x}, 12);
    }
    for (uint32_t f = 0; f < 9; ++f) {
        const uint32_t a = f / 3 * 4 + f % 3;
        memcpy(c + 4 * f, (const uint32_t[]){a, a + 1, a + 5, a + 4}, 16);
        starts[f + 1] = 4 * (f + 1);
    }
    norma_mesh mesh = POLYGONS(p, c, starts);
    for (uint32_t turn = 0; turn < 2; ++turn) /* b twice; then with its first position, a b a d */
        for (int crease = 20; crease <= 180; crease += 40)
            for (int smooth = 0; smooth < 2; ++smooth) {
                memcpy(c + 16, (const uint32_t[]){5, 6, turn ? 5 : 10, turn ? 9 : 6}, 16);
                const result r = corners_with(
                    &mesh, crease, (norma_options){.non_manifold = (norma_non_manifold)smooth});
                const uint32_t alike[2][3][2] = {
                    {{16, 7}, {17, 6}, {18, 23}}, {{16, 13}, {17, 6}, {19, 14}}};
                for (int i = 0; i < 3; ++i) {
                    assert_same(alike[turn][i][0], alike[turn][i][1]);
                    assert_int_equal(r.reasons[alike[turn][i][0]], NORMA_REASON_NONE);
                }
                assert_int_equal(r.report.unreferenced.count, 1);
                assert_report(2, 0);
            }
}

/* Three loops round 0; the other face has the same edges, but runs along the middle loop the same
 * way: no twin. */
static void equal_edges_are_no_twins(void **state) {
    (void)state;
    static const float p[] = {0, 0, 0, 4, 0, 0, 4, 1, 0, 0, 4, 0, -1, 4, 0, -4, 0, 0, -4, -1, 0};
    static const uint32_t c[] = {0, 1, 2, 0, 3, 4, 0, 5, 6, 0, 6, 5, 0, 3, 4, 0, 2, 1},
                          starts[] = {0, 9, 18};
    const norma_mesh mesh = POLYGONS(p, c, starts);
    const result r = corners(&mesh, 180); /* the first and the last loop run against each other */
    assert_edges(9, 0, 6, 0);
    assert_report(0, 3);
}

/* ---- borrowing: a sliver 0 1 2 whose longest edge is 0 1, with a face beyond each shorter one */

static void only_one_partner_lends(void **state) {
    (void)state;
    static const float p[] = {0, 0, 0, 4, 0, 0, 2, 0, 0, 2, -3, -1, 2, 0, 3, 2, 3, 0};
    static const uint32_t starts[] = {0, 3, 6, 9, 12};
    /* sliver; at 0 1 below; beyond 1 2 and 2 0 above */
    static const uint32_t c[] = {0, 1, 2, 1, 0, 3, 2, 1, 5, 0, 2, 5, 1, 0, 4};
    norma_mesh mesh = POLYGONS(p, c, starts);
    mesh.corner_count = 12;
    result r = corners(&mesh, 180);
    assert_edges(3 + 2 + 3, 4, 4, 0);
    assert_same(0, 9);
    assert_same(0, 4);
    /* A second face at 0 1: hard, it shares with nobody and borrows nothing, even at 180. */
    static const uint32_t five[] = {0, 3, 6, 9, 12, 15};
    mesh = POLYGONS(p, c, five);
    r = corners(&mesh, 180);
    assert_report(1, 0);
    assert_edges(8 + 2, 4 + 2, 1, 2);
    assert_other(4, 9);
    assert_int_equal(r.reasons[0], NORMA_REASON_UNREFERENCED);
    /* Smooth: it shares with two, so that nothing says whose direction it has. */
    r = corners_with(&mesh, 180, (norma_options){.non_manifold = NORMA_NON_MANIFOLD_SMOOTH});
    assert_report(1, 0);
    assert_int_equal(r.reasons[0], NORMA_REASON_UNREFERENCED);
    assert_edges(10, 6, 1, 2);
}

/* Under the smooth policy a sliver with one partner borrows, though the partner has two. */
static void the_partner_may_have_others(void **state) {
    (void)state;
    static const float p[] = {0, 0, 0, 4, 0, 0, 2, 0, 0, 2, -3, 0, 2, 0, 3, 2, 3, 0};
    /* sliver and another face from 0 to 1, one face from 1 to 0 */
    static const uint32_t c[] = {0, 1, 2, 0, 1, 4, 1, 0, 3, 2, 1, 5}, starts[] = {0, 3, 6, 9, 12};
    const norma_mesh mesh = POLYGONS(p, c, starts);
    result r = corners(&mesh, 180);
    assert_int_equal(r.reasons[2], NORMA_REASON_UNREFERENCED);
    assert_int_equal(r.reasons[0], NORMA_REASON_UNREFERENCED);
    r = corners_with(&mesh, 180, (norma_options){.non_manifold = NORMA_NON_MANIFOLD_SMOOTH});
    assert_int_equal(r.reasons[0], NORMA_REASON_NONE);
    assert_same(0, 7);
    assert_same(2, 9); /* and is smooth to the face beyond it */
}

/* A sliver 0 1 2 along x: 1 2 is longer than 0 1 by one part in 2^53, which no double holds. */
static void the_longest_edge_is_found_exactly(void **state) {
    (void)state;
    static const double long_one = 0x1p53;
    const double p[] = {0, 0, 0, long_one, 0, 0, -1, 0, 0, 0, long_one, 0, 0, 0, long_one};
    /* the sliver; beyond 0 1, upright; beyond 1 2, flat */
    static const uint32_t c[] = {0, 1, 2, 1, 0, 4, 2, 1, 3};
    const norma_mesh mesh = {
        .positions = {p, 5, 0, NORMA_FORMAT_DOUBLE}, .corners = c, .corner_count = 9};
    const result r = corners(&mesh, 30);
    assert_edges(7, 5, 1, 1);
    assert_same(2, 6);
    assert_same(1, 7);
    assert_int_equal(r.reasons[0], NORMA_REASON_UNREFERENCED);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(a_slit_is_shared_by_its_face),
        cmocka_unit_test(a_face_more_at_a_slit_is_one_too_many),
        cmocka_unit_test(a_slit_in_a_double_sided_sheet),
        cmocka_unit_test(twice_the_same_way_is_a_conflict),
        cmocka_unit_test(a_face_that_is_its_own_reverse),
        cmocka_unit_test(a_quad_that_names_a_position_twice),
        cmocka_unit_test(equal_edges_are_no_twins), cmocka_unit_test(only_one_partner_lends),
        cmocka_unit_test(the_partner_may_have_others),
        cmocka_unit_test(the_longest_edge_is_found_exactly)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
