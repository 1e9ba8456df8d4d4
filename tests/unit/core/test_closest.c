/* test_closest.c: nearest points of a cube, whose distances have a closed form: those outside are
 * as far as the box, those inside as far as the nearest side. */
#include "check.h"
#include <float.h>

static const float CUBE[8][3] = {{-1, -1, -1}, {-1, -1, 1}, {-1, 1, -1}, {-1, 1, 1}, {1, -1, -1},
    {1, -1, 1}, {1, 1, -1}, {1, 1, 1}};
static const uint32_t SIDES[24] = {
    0, 1, 3, 2, 4, 6, 7, 5, 0, 4, 5, 1, 2, 3, 7, 6, 0, 2, 6, 4, 1, 5, 7, 3};
static const uint32_t STARTS[7] = {0, 4, 8, 12, 16, 20, 24};

static double distance_to_cube(const double p[3]) {
    double outside = 0, inside = -1;
    for (int k = 0; k < 3; ++k) {
        outside += pow(fmax(fabs(p[k]) - 1, 0), 2);
        inside = fmax(inside, fabs(p[k]) - 1);
    }
    return outside > 0 ? sqrt(outside) : -inside;
}

static norma_mesh cube_of_quads(void) {
    return (norma_mesh){.positions = {CUBE, 8, 0, NORMA_FORMAT_FLOAT},
        .corners = SIDES,
        .corner_count = 24,
        .corner_size = 4,
        .face_starts = STARTS,
        .face_count = 6};
}

static void closest_in_a_cube(void **state) {
    enum { SIDE = 11, COUNT = SIDE * SIDE * SIDE };
    static double points[COUNT][3];
    static norma_closest found[COUNT];
    const norma_mesh mesh = cube_of_quads();
    (void)state;
    for (int i = 0; i < COUNT; ++i)
        for (int k = 0, rest = i; k < 3; ++k, rest /= SIDE) points[i][k] = rest % SIDE * 0.37 - 1.8;
    for (uint32_t threads = 1; threads < 4; ++threads) {
        const norma_options options = {.threads = threads};
        assert_ok(norma_closest_points(&mesh,
            (norma_vec3_view){points, COUNT, 0, NORMA_FORMAT_DOUBLE}, &options, found, COUNT));
        for (int i = 0; i < COUNT; ++i) {
            double far = 0, apart = 0;
            assert_true(fabs(found[i].distance - distance_to_cube(points[i])) < 1e-12);
            for (int k = 0; k < 3; ++k) {
                double sum = 0;
                for (int c = 0; c < 3; ++c)
                    sum += found[i].weights[c] * (double)CUBE[SIDES[found[i].corners[c]]][k];
                apart = fmax(apart, fabs(sum - found[i].point[k]));
                far += pow(found[i].point[k] - points[i][k], 2);
            }
            assert_true(apart < 1e-12 && fabs(sqrt(far) - found[i].distance) < 1e-12);
            assert_int_equal(found[i].corners[0] / 4, found[i].face);
        }
    }
}

static void nothing_is_closest(void **state) {
    const norma_mesh mesh = cube_of_quads();
    norma_mesh needle = cube_of_quads();
    const double nowhere[2][3] = {{NAN, 0, 0}, {0, 0, 3}};
    norma_closest found[2];
    (void)state;
    const norma_vec3_view points = {nowhere, 2, 0, NORMA_FORMAT_DOUBLE};
    assert_ok(norma_closest_points(&mesh, points, NULL, found, 2));
    assert_true(found[0].face == UINT32_MAX && found[0].distance == -1 && found[1].distance == 2);
    needle.face_count = 0;
    needle.corner_count = 0;
    needle.face_starts = (const uint32_t[]){0};
    assert_ok(norma_closest_points(&needle, points, NULL, found, 2));
    assert_true(found[1].face == UINT32_MAX && found[1].distance == -1);
    assert_int_equal(norma_closest_points(&mesh, points, NULL, found, 1), NORMA_ERROR_CAPACITY);
    assert_int_equal(norma_closest_points(&mesh, points, NULL, NULL, 2), NORMA_ERROR_ARGUMENT);
    assert_int_equal(norma_closest_points(NULL, points, NULL, found, 2), NORMA_ERROR_ARGUMENT);
}

/* Coordinates whose squares a double cannot hold: none, or what the closed form says. */
static void far_points(void **state) {
    enum { COUNT = 9 };
    static const double FAR[COUNT] = {1e10, 1e60, 1e90, 3e90, 1e100, 1e154, 1e200, 1e300, DBL_MAX};
    const norma_mesh mesh = cube_of_quads();
    double points[2 * COUNT][3], vast[8][3];
    norma_closest found[2 * COUNT];
    (void)state;
    for (int i = 0; i < 2 * COUNT; ++i)
        for (int k = 0; k < 3; ++k) points[i][k] = k == 0 || i >= COUNT ? FAR[i % COUNT] : 0;
    const norma_vec3_view far_away = {points, 2 * COUNT, 0, NORMA_FORMAT_DOUBLE};
    assert_ok(norma_closest_points(&mesh, far_away, NULL, found, 2 * COUNT));
    for (int i = 0; i < 2 * COUNT; ++i) {
        const double far = FAR[i % COUNT] * (i < COUNT ? 1 : sqrt(3));
        const int none = FAR[i % COUNT] > 0x1p300;
        assert_true(none ? found[i].face == UINT32_MAX && found[i].distance == -1
                         : fabs(found[i].distance / far - 1) < 1e-9);
        for (int k = 0; k < 3; ++k)
            assert_true(isfinite(found[i].weights[k]) && fabs(found[i].point[k]) <= 1);
    }
    norma_mesh great =
        mesh; /* DBL_MAX is near it; the distance to its other side is not a double */
    for (int i = 0; i < 8; ++i)
        for (int k = 0; k < 3; ++k) vast[i][k] = (double)CUBE[i][k] * 1e300 - (k ? 0 : 1e308);
    great.positions = (norma_vec3_view){vast, 8, 0, NORMA_FORMAT_DOUBLE};
    const double ends[2][3] = {{-DBL_MAX, 0, 0}, {DBL_MAX, 0, 0}};
    assert_ok(norma_closest_points(
        &great, (norma_vec3_view){ends, 2, 0, NORMA_FORMAT_DOUBLE}, NULL, found, 2));
    assert_true(fabs(found[0].distance / (DBL_MAX - 1e308 - 1e300) - 1) < 1e-9);
    assert_true(found[1].face == UINT32_MAX && found[1].distance == -1);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(closest_in_a_cube),
        cmocka_unit_test(nothing_is_closest),
        cmocka_unit_test(far_points),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
