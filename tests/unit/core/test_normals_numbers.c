/* test_normals_numbers.c: the measured and the exact figures of FACTS, section 3: what each weight
 * makes of spheres, boxes and an inserted vertex. */
#include "check.h"
#include "mesh_files.h"
#include "oracle/shapes.h"

typedef struct errors {
    double mean, worst;
} errors;

/* Angles between vertex normals and those of the ellipsoid with half-axes a through the vertices;
 * each position once. */
static errors ellipsoid_errors(const mesh_file *mesh, norma_weight weight, const double a[3]) {
    errors e = {0, 0};
    float *normals = test_calloc(3 * mesh->position_count, sizeof *normals);
    const norma_mesh view = mesh_file_view(mesh);
    assert_ok(norma_vertex_normals(
        &view, &(norma_options){.weight = weight}, normals, mesh->position_count, NULL));
    for (size_t i = 0; i < mesh->position_count; ++i) {
        const double *p = mesh->positions[i];
        const double off = degrees_to(
            normals + 3 * i, p[0] / (a[0] * a[0]), p[1] / (a[1] * a[1]), p[2] / (a[2] * a[2]));
        e.mean += off / (double)mesh->position_count;
        if (off > e.worst) e.worst = off;
    }
    test_free(normals);
    return e;
}

static const double unit_axes[3] = {1, 1, 1};

static void uv_sphere_32_by_16(void **state) {
    (void)state;
    static const struct {
        norma_weight weight;
        double mean, worst, tolerance;
    } expected[] = {{NORMA_WEIGHT_UNIFORM, .244, 1.17, .005}, {NORMA_WEIGHT_AREA, .664, 1.93, .005},
        {NORMA_WEIGHT_ANGLE, .212, .344, .0006}, {NORMA_WEIGHT_MAX, 0, 0, 1e-5},
        {NORMA_WEIGHT_ANGLE_AREA, .408, .640, .0006}};
    mesh_file mesh = {0};
    shape_uv_sphere(&mesh, 32, 16, 0, 0);
    for (size_t i = 0; i < COUNT_OF(expected); ++i) {
        const errors e = ellipsoid_errors(&mesh, expected[i].weight, unit_axes);
        assert_true(fabs(e.mean - expected[i].mean) <= expected[i].tolerance);
        assert_true(fabs(e.worst - expected[i].worst) <= expected[i].tolerance);
    }
    mesh_file_free(&mesh);
}

static void max_is_exact_on_every_sphere(void **state) {
    (void)state;
    mesh_file meshes[4] = {0};
    shape_octahedron_sphere(&meshes[0], 9);
    shape_uv_sphere(&meshes[1], 17, 5, 1, 0);
    shape_pole_sphere(&meshes[2], 5, 12, 0);
    shape_octahedron_sphere(&meshes[3], 3);
    uint64_t seed = 7;
    for (size_t i = 0; i < meshes[3].position_count;
         ++i) { /* uneven, yet closed: a smooth map of the sphere to itself */
        double *p = meshes[3].positions[i], length;
        p[0] += .3 * p[1] * p[2] + .2;
        p[1] -= .25 * p[0];
        length = sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
        for (int x = 0; x < 3; ++x) p[x] /= length;
        (void)shape_random(&seed);
    }
    for (size_t i = 0; i < 4; ++i) {
        const errors e = ellipsoid_errors(&meshes[i], NORMA_WEIGHT_MAX, unit_axes),
                     angle = ellipsoid_errors(&meshes[i], NORMA_WEIGHT_ANGLE, unit_axes);
        assert_true(e.worst <= 1.2e-5);
        assert_true(angle.worst > .1); /* that it is exact is no accident of the mesh */
        mesh_file_free(&meshes[i]);
    }
}

static errors cube_errors(norma_weight weight, const double size[3], int quads) {
    mesh_file mesh = {0};
    float normals[24];
    errors e = {0, 0};
    shape_box(&mesh, size[0], size[1], size[2], quads);
    const norma_mesh view = mesh_file_view(&mesh);
    assert_ok(norma_vertex_normals(&view, &(norma_options){.weight = weight}, normals, 8, NULL));
    for (int i = 0; i < 8; ++i) {
        const double off =
            degrees_to(normals + 3 * i, i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
        e.mean += off / 8;
        if (off > e.worst) e.worst = off;
    }
    mesh_file_free(&mesh);
    return e;
}

static void cube_of_12_triangles(void **state) {
    (void)state;
    static const double unit[3] = {1, 1, 1};
    static const norma_weight exact[] = {
        NORMA_WEIGHT_ANGLE, NORMA_WEIGHT_MAX, NORMA_WEIGHT_ANGLE_AREA, NORMA_WEIGHT_VISIBLE};
    static const norma_weight tilted[] = {NORMA_WEIGHT_UNIFORM, NORMA_WEIGHT_AREA};
    for (size_t i = 0; i < COUNT_OF(exact); ++i)
        assert_true(cube_errors(exact[i], unit, 0).worst < 1e-5);
    for (size_t i = 0; i < COUNT_OF(tilted);
         ++i) { /* corners of 1 and 2 triangles a side: (2, 1, 1) or (1, 2, 2) against (1, 1,
                   1), 19.4712 and 15.7932 */
        const errors e = cube_errors(tilted[i], unit, 0);
        assert_true(fabs(e.worst - 19.47) < .005);
        assert_true(fabs(e.mean - 14.6) < .05);
    }
    for (int w = NORMA_WEIGHT_ANGLE; norma_weight_name((norma_weight)w); ++w)
        assert_true(cube_errors((norma_weight)w, unit, 1).worst < 1e-5);
}

static void box_10_1_1(void **state) {
    (void)state;
    static const double size[3] = {10, 1, 1};
    assert_true(cube_errors(NORMA_WEIGHT_ANGLE, size, 0).worst < 1e-5);
    assert_true(cube_errors(NORMA_WEIGHT_ANGLE, size, 1).worst < 1e-5);
    assert_true(cube_errors(NORMA_WEIGHT_VISIBLE, size, 0).worst < 1e-5);
    const errors area = cube_errors(NORMA_WEIGHT_AREA, size, 1); /* areas 10, 10, 1 */
    assert_true(fabs(area.worst - 31.2197) < 1e-3 && fabs(area.mean - 31.2197) < 1e-3);
    assert_true(cube_errors(NORMA_WEIGHT_UNIFORM, size, 1).worst < 1e-5);
    const errors angle_area = cube_errors(NORMA_WEIGHT_ANGLE_AREA, size, 0);
    assert_true(fabs(angle_area.worst - 31.2197) < 1e-3);
    const errors lengths = cube_errors(
        NORMA_WEIGHT_ANGLE_LENGTHS, size, 1); /* pi/2 |a||b|: as area for a box of quads */
    assert_true(fabs(lengths.worst - 31.2197) < 1e-3);
    const errors max =
        cube_errors(NORMA_WEIGHT_MAX, size, 1); /* 1/(|a||b|): .1, .1, 1: 46.686 degrees */
    assert_true(fabs(max.worst - 46.6861) < 1e-3);
}

static void vertex_inserted_near_a_cube_corner(void **state) {
    (void)state;
    static const struct {
        double delta, max_deg;
    } cases[] = {{.5, 19.47}, {.1, 46.69}, {.01, 53.93}};
    for (size_t i = 0; i < COUNT_OF(cases); ++i) {
        /* The corner at 0 of a unit cube that fills the positive octant; its faces there look down
         * -x, -y, -z; the bottom's quad is cut into four at (d, d, 0). */
        mesh_file mesh = {0};
        const double d = cases[i].delta;
        shape_box(&mesh, 1, 1, 1, 1);
        mesh_file cut = {0};
        for (size_t v = 0; v < 8; ++v)
            mesh_file_add_position(
                &cut, mesh.positions[v][0], mesh.positions[v][1], mesh.positions[v][2]);
        mesh_file_add_position(&cut, d, d, 0);
        for (size_t f = 1; f < 6; ++f) mesh_file_add_face(&cut, mesh.corners + mesh.starts[f], 4);
        static const uint32_t bottom[4] = {0, 2, 3, 1};
        for (uint32_t k = 0; k < 4; ++k)
            mesh_file_add_face(&cut, (uint32_t[]){bottom[k], bottom[(k + 1) % 4], 8}, 3);
        const norma_mesh view = mesh_file_view(&cut);
        float normals[27];
        assert_ok(norma_vertex_normals(&view, NULL, normals, 9, NULL));
        for (int v = 0; v < 8; ++v)
            assert_direction(normals + 3 * v, v & 1 ? 1 : -1, v & 2 ? 1 : -1, v & 4 ? 1 : -1,
                1e-5); /* angle: unmoved */
        assert_ok(norma_vertex_normals(
            &view, &(norma_options){.weight = NORMA_WEIGHT_MAX}, normals, 9, NULL));
        const double off = degrees_to(normals, -1, -1, -1);
        assert_true(fabs(off - cases[i].max_deg) < .006);
        mesh_file_free(&mesh);
        mesh_file_free(&cut);
    }
}

static void angle_weights_do_not_feel_how_flat_faces_are_cut(void **state) {
    (void)state;
    /* A prism over an L; its caps whole, and cut in three ways, one with a vertex in the middle of
     * an edge and one inside. */
    static const double p[7][2] = {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}, {.5, .25}};
    static const uint32_t whole[] = {6, 0, 1, 2, 3, 4, 5, 0},
                          two[] = {4, 0, 1, 2, 3, 4, 0, 3, 4, 5, 0},
                          four[] = {3, 0, 1, 2, 3, 0, 2, 3, 3, 0, 3, 4, 3, 0, 4, 5, 0},
                          inside[] = {3, 0, 1, 6, 3, 1, 2, 6, 3, 2, 3, 6, 3, 3, 4, 6, 3, 4, 5, 6, 3,
                              5, 0, 6, 0};
    const uint32_t *const cuts[] = {whole, two, four, inside};
    float normals[4][14 * 3];
    for (size_t k = 0; k < 4; ++k) {
        mesh_file mesh = {0};
        for (int level = 0; level < 2; ++level)
            for (int v = 0; v < 7; ++v) mesh_file_add_position(&mesh, p[v][0], p[v][1], level);
        for (const uint32_t *c = cuts[k]; *c; c += *c + 1) {
            uint32_t top[8], bottom[8];
            for (uint32_t i = 0; i < *c; ++i) {
                top[i] = c[1 + i] + 7;
                bottom[*c - 1 - i] = c[1 + i];
            }
            mesh_file_add_face(&mesh, top, *c);
            mesh_file_add_face(&mesh, bottom, *c);
        }
        for (uint32_t i = 0; i < 6; ++i)
            mesh_file_add_face(&mesh, (uint32_t[]){i, (i + 1) % 6, (i + 1) % 6 + 7, i + 7}, 4);
        const norma_mesh view = mesh_file_view(&mesh);
        assert_ok(norma_vertex_normals(&view, NULL, normals[k], 14, NULL));
        for (int v = 0; v < 6; ++v) {
            const float *a = normals[k] + 3 * v, *b = normals[0] + 3 * v;
            assert_direction(a, (double)b[0], (double)b[1], (double)b[2], 1e-5);
        }
        mesh_file_free(&mesh);
    }
    assert_direction(normals[0] + 3 * 3, 1, 1, -3,
        1e-5); /* the reflex corner, 3 pi / 2 of floor, two walls of pi / 2 */
}

static void visible_is_the_centre_of_the_smallest_cone(void **state) {
    (void)state;
    /* A pyramid of three walls whose tip repeats one wall many times in slim slices: the cone does
     * not feel them, angle weights do not either, uniform does. */
    mesh_file mesh = {0};
    mesh_file_add_position(&mesh, 0, 0, 0);
    mesh_file_add_position(&mesh, 1, 0, 0);
    mesh_file_add_position(&mesh, 0, 1, 0);
    mesh_file_add_position(&mesh, 0, 0, 1);
    mesh_file_add_face(&mesh, (uint32_t[]){0, 2, 3}, 3);
    mesh_file_add_face(&mesh, (uint32_t[]){0, 3, 1}, 3);
    for (uint32_t i = 0; i < 16; ++i) {
        if (i < 15) mesh_file_add_position(&mesh, 1 - (i + 1) / 16., (i + 1) / 16., 0);
        mesh_file_add_face(&mesh, (uint32_t[]){0, i == 0 ? 1 : 3 + i, i == 15 ? 2 : 4 + i}, 3);
    }
    const norma_mesh view = mesh_file_view(&mesh);
    float normals[3 * 20];
    assert_ok(norma_vertex_normals(&view, &(norma_options){.weight = NORMA_WEIGHT_VISIBLE}, normals,
        mesh.position_count, NULL));
    assert_direction(normals, 1, 1, 1, 1e-5);
    assert_ok(norma_vertex_normals(&view, NULL, normals, mesh.position_count, NULL));
    assert_direction(normals, 1, 1, 1, 1e-5);
    assert_ok(norma_vertex_normals(&view, &(norma_options){.weight = NORMA_WEIGHT_UNIFORM}, normals,
        mesh.position_count, NULL));
    assert_direction(normals, 1, 1, 16, 1e-5);
    /* Two normals 90 degrees apart and a third between them that changes nothing: half-way. */
    mesh_file_free(&mesh);
    static const double p[][3] = {
        {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0, .5}, {0, -1, 0}, {.1, 0, 1}};
    for (size_t i = 0; i < COUNT_OF(p); ++i)
        mesh_file_add_position(&mesh, p[i][0], p[i][1], p[i][2]);
    mesh_file_add_face(&mesh, (uint32_t[]){0, 1, 2}, 3); /* (0, 0, 1) */
    mesh_file_add_face(&mesh, (uint32_t[]){0, 2, 3}, 3); /* (.5, 0, 1) */
    mesh_file_add_face(&mesh, (uint32_t[]){0, 4, 5}, 3); /* (-1, 0, .1) */
    const norma_mesh bent = mesh_file_view(&mesh);
    assert_ok(norma_vertex_normals(&bent, &(norma_options){.weight = NORMA_WEIGHT_VISIBLE}, normals,
        mesh.position_count, NULL));
    const double a = atan2(.5, 1), b = atan2(-1, .1), middle = (a + b) / 2;
    assert_direction(normals, sin(middle), 0, cos(middle), 1e-5);
    mesh_file_free(&mesh);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(uv_sphere_32_by_16),
        cmocka_unit_test(max_is_exact_on_every_sphere),
        cmocka_unit_test(cube_of_12_triangles),
        cmocka_unit_test(box_10_1_1),
        cmocka_unit_test(vertex_inserted_near_a_cube_corner),
        cmocka_unit_test(angle_weights_do_not_feel_how_flat_faces_are_cut),
        cmocka_unit_test(visible_is_the_centre_of_the_smallest_cone),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
