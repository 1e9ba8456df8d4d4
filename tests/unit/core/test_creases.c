/* test_creases.c: the page's creases (web/page/model/crease_slider.c), which keep what does not
 * hang on the crease, give the bits of norma_corner_normals: nasty meshes, and one that is smooth,
 * under one crease, weight and weld after the other. */
#include "../../../web/page/model/crease_slider.c"
#include "plan_check.h"

enum { SEEDS = 1500 / SLOWER, ROUNDS = 14, MOST_NASTY = 1 << 12 };

typedef struct tally {
    size_t own, plain;
} tally;

static const double CREASES[] = {60, 0, 30, 180, 90, 45, 20, 179.99, 1, 135, 10, 75, -1, 5};
static const norma_weight WEIGHTS[] = {NORMA_WEIGHT_ANGLE, NORMA_WEIGHT_ANGLE, NORMA_WEIGHT_AREA,
    NORMA_WEIGHT_AREA, NORMA_WEIGHT_UNIFORM, NORMA_WEIGHT_MAX, NORMA_WEIGHT_ANGLE_AREA,
    NORMA_WEIGHT_ANGLE, NORMA_WEIGHT_VISIBLE, NORMA_WEIGHT_ANGLE_LENGTHS, NORMA_WEIGHT_ANGLE,
    NORMA_WEIGHT_AREA, NORMA_WEIGHT_MAX, NORMA_WEIGHT_VISIBLE};

static int all_have_normals(const uint8_t *reasons, size_t count) {
    for (size_t i = 0; i < count; ++i)
        if (reasons[i] != NORMA_REASON_NONE) return 0;
    return 1;
}

/* Either it gives the bits, or a corner really has no normal. */
static void compare(creases *c, const norma_mesh *mesh, norma_weld weld, int round, tally *t) {
    const size_t count = mesh->corner_count;
    float *wanted = calloc(3 * count + 1, sizeof *wanted),
          *given = calloc(3 * count + 1, sizeof *given);
    uint8_t *reasons = calloc(count + 1, 1);
    const float crease = (float)(CREASES[round] / DEGREES);
    norma_options options = {
        .struct_size = sizeof options, .weld = weld, .weight = WEIGHTS[round], .reasons = reasons};
    assert_ok(norma_corner_normals(mesh, crease, &options, wanted, count, NULL));
    const int done = creases_compute(c, crease, WEIGHTS[round], given);
    assert_int_equal(done, all_have_normals(reasons, count));
    if (done) assert_memory_equal(wanted, given, 12 * count);
    t->own += done != 0;
    t->plain += done == 0;
    free(wanted);
    free(given);
    free(reasons);
}

static void compare_all(const norma_mesh *mesh, norma_weld weld, tally *t) {
    creases *c = creases_open(mesh, weld);
    assert_non_null(c);
    assert_int_equal(creases_weld(c), weld);
    for (int round = 0; round < ROUNDS; ++round) compare(c, mesh, weld, round, t);
    creases_close(c);
}

static void nasty_meshes(void **state) {
    tally t = {0, 0};
    (void)state;
    for (uint64_t seed = 1; seed <= SEEDS; ++seed) {
        plan_case c;
        plan_case_make(&c, seed);
        c.view.hard_edges = NULL;
        c.view.smoothing_groups = NULL;
        if (c.view.corner_count < MOST_NASTY)
            compare_all(&c.view, seed % 2 ? NORMA_WELD_EXACT : NORMA_WELD_NONE, &t);
        plan_case_free(&c);
    }
    assert_true(t.own > 1000 / SLOWER && t.plain > 1000 / SLOWER);
}

/* ---- grids, where nearly all is done by the short loops: bent along lines, open and closed,
 * corners doubled along a seam */

typedef struct sheet {
    float *positions;
    uint32_t *corners;
    norma_mesh mesh;
} sheet;

static sheet make_sheet(uint32_t columns, uint32_t rows, int closed, uint64_t seed) {
    const uint32_t across = columns + 1, points = across * (rows + 1);
    sheet s = {malloc(12 * points), malloc(24 * columns * rows), {.corner_count = 0}};
    for (uint32_t p = 0; p < points; ++p) {
        const uint32_t i = p % across, j = p / across;
        const double around = closed ? 6.283185307179586 * (i % columns) / columns : 0.2 * i,
                     bump = 0.02 * plan_random(&seed, 100) * (j % 3 == 0);
        s.positions[3 * p] = (float)(closed ? (2 + bump) * cos(around) : around);
        s.positions[3 * p + 1] = (float)(closed ? (2 + bump) * sin(around) : bump);
        s.positions[3 * p + 2] = (float)(0.3 * j + (j % 4 == 1 ? 0.25 : 0));
    }
    uint32_t *out = s.corners;
    for (uint32_t j = 0; j < rows; ++j)
        for (uint32_t i = 0; i < columns; ++i) {
            const uint32_t a = j * across + i,
                           quad[6] = {a, a + 1, a + across + 1, a, a + across + 1, a + across};
            memcpy(out, quad, sizeof quad);
            out += 6;
        }
    s.mesh = (norma_mesh){.positions = {s.positions, points, 0, NORMA_FORMAT_FLOAT},
        .corners = s.corners,
        .corner_count = 6u * columns * rows};
    return s;
}

static void sheets(void **state) {
    tally t = {0, 0};
    (void)state;
    for (uint64_t seed = 1; seed <= 40; ++seed) {
        sheet s = make_sheet(3 + (uint32_t)seed % 17, 4 + (uint32_t)seed % 11, seed % 3 != 0, seed);
        compare_all(&s.mesh, seed % 4 ? NORMA_WELD_EXACT : NORMA_WELD_NONE, &t);
        free(s.positions);
        free(s.corners);
    }
    assert_int_equal(t.plain, 0);
}

static void what_cannot_be_kept(void **state) {
    sheet s = make_sheet(4, 4, 0, 1);
    uint8_t hard[96] = {1};
    (void)state;
    s.mesh.hard_edges = hard;
    assert_null(creases_open(&s.mesh, NORMA_WELD_EXACT));
    s.mesh.hard_edges = NULL;
    s.corners[5] = 1000;
    assert_null(creases_open(&s.mesh, NORMA_WELD_EXACT));
    free(s.positions);
    free(s.corners);
    creases_close(NULL);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(nasty_meshes), cmocka_unit_test(sheets),
        cmocka_unit_test(what_cannot_be_kept)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
