/* test_cut_polygon.c: polygons cut into triangles. A cut is right when every triangle turns the way
 * that the polygon does and their areas add up to its own: then none overlaps another, and none
 * lies outside. */
#include "check.h"
#include "core/face/cut_polygon.h"
#include <math.h>
#include <stdlib.h>

enum { MOST = 200 };

typedef struct flat_polygon {
    size_t count;
    double points[MOST][2];
} flat_polygon;

static double area_of(const double a[2], const double b[2], const double c[2]) {
    return .5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]));
}

static double area_of_polygon(const flat_polygon *p) {
    double sum = 0;
    for (size_t i = 1; i + 1 < p->count; ++i)
        sum += area_of(p->points[0], p->points[i], p->points[i + 1]);
    return sum;
}

static double random_number(uint32_t *state) {
    *state = *state * 1664525u + 1013904223u;
    return (*state >> 8) / 16777216.0;
}

/* A plane that lies askew and far from the origin. */
static void place(const double flat[2], double out[3]) {
    out[0] = 1e3 + .6 * flat[0] - .64 * flat[1];
    out[1] = -5e2 + .8 * flat[0] + .48 * flat[1];
    out[2] = 7 + .6 * flat[1];
}

/* Returns how many triangles are ears. */
static size_t cut(const flat_polygon *p, uint32_t *triangles) {
    core_cutter cutter;
    void *memory = malloc(norma_core_cutter_size(p->count));
    assert_non_null(memory);
    norma_core_cutter_begin(&cutter, memory, p->count, p->count);
    for (size_t i = 0; i < p->count; ++i) place(p->points[i], cutter.points[i]);
    const size_t ears = norma_core_cut_polygon(&cutter, p->count, triangles);
    free(memory);
    return ears;
}

static void assert_cut_well(const flat_polygon *p) {
    uint32_t triangles[3 * MOST];
    double sum = 0;
    const double whole = area_of_polygon(p);
    assert_true(whole > 0);
    assert_int_equal(cut(p, triangles), p->count - 2);
    for (size_t t = 0; t + 2 < p->count; ++t) {
        const uint32_t *c = &triangles[3 * t];
        assert_true(c[0] < p->count && c[1] < p->count && c[2] < p->count);
        const double area = area_of(p->points[c[0]], p->points[c[1]], p->points[c[2]]);
        assert_true(area > 0);
        sum += area;
    }
    assert_true(fabs(sum - whole) < 1e-9 * whole);
}

static void stars_with_random_rays(void **state) {
    (void)state;
    uint32_t seed = 1;
    for (int round = 0; round < 300; ++round) {
        flat_polygon p = {.count = 4 + (size_t)round % 60};
        for (size_t i = 0; i < p.count; ++i) {
            const double angle = 6.283185307179586 * (double)i / (double)p.count,
                         radius = .1 + random_number(&seed);
            p.points[i][0] = radius * cos(angle);
            p.points[i][1] = radius * sin(angle);
        }
        assert_cut_well(&p);
    }
}

/* There and back along a spiral: most corners are reflex on one of the two ways. */
static void a_spiral(void **state) {
    (void)state;
    flat_polygon p = {.count = MOST};
    for (size_t i = 0; i < MOST / 2; ++i) {
        const double angle = .2 * (double)i;
        for (int side = 0; side < 2; ++side) {
            double *to = p.points[side ? MOST - 1 - i : i];
            const double radius = 1 + angle + (side ? 0 : 2);
            to[0] = radius * cos(angle);
            to[1] = radius * sin(angle);
        }
    }
    assert_cut_well(&p);
}

static void a_comb_of_needles(void **state) {
    (void)state;
    flat_polygon p = {.count = 0};
    uint32_t seed = 3;
    p.points[p.count][0] = 0;
    p.points[p.count++][1] = -1;
    p.points[p.count][0] = 90;
    p.points[p.count++][1] = -1;
    for (int tooth = 90; tooth >= 0; --tooth) {
        p.points[p.count][0] = tooth;
        p.points[p.count++][1] = tooth % 2 ? 100 : .5 * random_number(&seed);
    }
    assert_cut_well(&p);
}

static void what_crosses_itself_is_a_fan_in_part(void **state) {
    (void)state;
    const flat_polygon bow = {5, {{0, 0}, {4, 0}, {0, 2}, {4, 2}, {2, 5}}};
    uint32_t triangles[3 * MOST];
    assert_true(cut(&bow, triangles) < 3);
    for (size_t i = 0; i < 9; ++i) assert_true(triangles[i] < 5);
}

static void without_area_or_with_nan_it_is_a_fan(void **state) {
    (void)state;
    const flat_polygon line = {4, {{0, 0}, {1, 0}, {2, 0}, {1, 0}}},
                       broken = {4, {{0, 0}, {1, 0}, {NAN, 1}, {0, 1}}};
    static const uint32_t fan[6] = {0, 1, 2, 0, 2, 3};
    uint32_t triangles[3 * MOST];
    assert_int_equal(cut(&line, triangles), 0);
    assert_memory_equal(triangles, fan, sizeof fan);
    assert_int_equal(cut(&broken, triangles), 0);
    assert_memory_equal(triangles, fan, sizeof fan);
}

static void only_reflex_corners_forbid_a_fan(void **state) {
    (void)state;
    static const double arrow[4][3] = {{0, 0, 0}, {2, -1, 0}, {1, 0, 0}, {2, 1, 0}},
                        square[4][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    core_cutter cutter;
    void *memory = malloc(norma_core_cutter_size(4));
    assert_non_null(memory);
    norma_core_cutter_begin(&cutter, memory, 4, 8);
    memcpy(cutter.points, arrow, sizeof arrow);
    assert_false(norma_core_polygon_fans(&cutter, 4));
    memcpy(cutter.points, square, sizeof square);
    assert_true(norma_core_polygon_fans(&cutter, 4));
    free(memory);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(stars_with_random_rays),
        cmocka_unit_test(a_spiral),
        cmocka_unit_test(a_comb_of_needles),
        cmocka_unit_test(what_crosses_itself_is_a_fan_in_part),
        cmocka_unit_test(without_area_or_with_nan_it_is_a_fan),
        cmocka_unit_test(only_reflex_corners_forbid_a_fan),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
