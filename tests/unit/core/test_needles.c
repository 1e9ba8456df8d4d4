/* test_needles.c: polygons with a corner whose two edges run back on one another, as far as doubles
 * can tell: its interior angle is next to nothing or nearly a full turn, and only exact arithmetic
 * says which. Against the oracle, in every weight. */
#include "check.h"
#include "mesh_files.h"
#include "oracle/compare.h"
#include "oracle/shapes.h"

/* The corner of 23 in this quadrilateral is reflex: its neighbours lie in one direction, the next
 * one left of the one before by 1.7e-17 rad. */
static void test_a_needle_that_is_nearly_a_full_turn(void **state) {
    static const double p[6][3] = {
        {-0.53033007681369781, -0.30618622899055475, -0.70710676908493042},
        {-0.70710676908493042, 8.6595606034265543e-17, -0.70710676908493042},
        {-0.35355338454246521, -0.61237245798110962, -0.70710676908493042},
        {-0.5, -0.86602538824081421, 6.1232342629258393e-17},
        {-0.70710676908493042 + 1, 8.6595606034265543e-17, -0.70710676908493042},
        {-0.70710676908493042, 1, -0.70710676908493042}};
    static const uint32_t corners[] = {0, 1, 2, 3, 1, 4, 5}, starts[] = {0, 4, 7};
    const norma_mesh mesh = {.positions = {.data = p, .count = 6, .format = NORMA_FORMAT_DOUBLE},
        .corners = corners,
        .corner_count = 7,
        .face_starts = starts,
        .face_count = 2};
    const norma_options by_angle = {.struct_size = sizeof by_angle, .weight = NORMA_WEIGHT_ANGLE};
    float normals[6][3];
    (void)state;
    assert_ok(norma_vertex_normals(&mesh, &by_angle, normals[0], 6, NULL));
    /* The quadrilateral's vector area, from one of its vertices; a full turn of it, and a quarter
     * of the triangle's (0, 0, 1). */
    double n[3] = {0}, length = 0;
    for (int i = 1; i < 3; ++i)
        for (int k = 0; k < 3; ++k) {
            const int y = (k + 1) % 3, z = (k + 2) % 3;
            n[k] += (p[i][y] - p[0][y]) * (p[i + 1][z] - p[0][z]) -
                    (p[i][z] - p[0][z]) * (p[i + 1][y] - p[0][y]);
        }
    for (int k = 0; k < 3; ++k) length += n[k] * n[k];
    const double turn = 8 * atan(1) / sqrt(length), right = atan2(1 - 8.6595606034265543e-17, 0);
    assert_direction(normals[1], turn * n[0], turn * n[1], turn * n[2] + right, 1e-4);
}

/* Quadrilaterals about one point, their needles there: each from a point halfway, as doubles round
 * it, out and back. */
static size_t compare_needles(uint64_t seed) {
    mesh_file mesh = {0};
    char name[40];
    snprintf(name, sizeof name, "needles %llu", (unsigned long long)seed);
    const double x = shape_random_unit(&seed), y = shape_random_unit(&seed),
                 z = shape_random_unit(&seed);
    mesh_file_add_position(&mesh, x, y, z);
    for (uint32_t f = 0; f < 4; ++f) {
        const double a = shape_random_unit(&seed), b = shape_random_unit(&seed),
                     c = shape_random_unit(&seed), part = f % 2 ? .5 : shape_random_unit(&seed);
        const double d = shape_random_unit(&seed), e = shape_random_unit(&seed),
                     g = shape_random_unit(&seed);
        const uint32_t at = (uint32_t)mesh.position_count;
        mesh_file_add_position(&mesh, a, b, c);
        mesh_file_add_position(&mesh, x + part * (a - x), y + part * (b - y), z + part * (c - z));
        mesh_file_add_position(&mesh, d, e, g);
        if (f % 4 < 2)
            mesh_file_add_face(&mesh, (uint32_t[]){at + 1, 0, at, at + 2}, 4);
        else
            mesh_file_add_face(&mesh, (uint32_t[]){0, at + 1, at + 2, at}, 4);
    }
    const norma_mesh view = mesh_file_view_polygons(&mesh);
    const size_t wrong = compare_everything(name, &view, NORMA_WELD_EXACT, 0);
    mesh_file_free(&mesh);
    return wrong;
}

static void test_needles(void **state) {
    size_t wrong = 0;
    (void)state;
    for (uint64_t seed = 1; seed <= 150 / SLOWER && wrong < 10; ++seed)
        wrong += compare_needles(seed);
    assert_int_equal(wrong, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_needle_that_is_nearly_a_full_turn), cmocka_unit_test(test_needles)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
