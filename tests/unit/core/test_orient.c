/* test_orient.c: norma_orient on bodies whose faces were turned at random, hollow ones, solids in
 * solids, touching ones, one-sided ones and open ones. What is right is known from how they were
 * built. */
#include "check.h"
#include "core/topology/topology.h"
#include "mesh_files.h"

/* A box wound outward, or inward. */
static void add_box(mesh_file *mesh, double x, double y, double z, double half, int inward) {
    static const uint8_t quads[6][4] = {
        {0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
    const uint32_t first = (uint32_t)mesh->position_count;
    for (int i = 0; i < 8; ++i)
        mesh_file_add_position(mesh, x + (i & 1 ? half : -half), y + (i & 2 ? half : -half),
            z + (i & 4 ? half : -half));
    for (int q = 0; q < 6; ++q) {
        uint32_t quad[4];
        for (uint32_t k = 0; k < 4; ++k) quad[inward ? 3 - k : k] = first + quads[q][k];
        mesh_file_add_face(mesh, quad, 4);
    }
}

/* Its first corner stays, so that it is cut into triangles as before. */
static void turn(mesh_file *mesh, size_t face) {
    const uint32_t starts[2] = {0, mesh->starts[face + 1] - mesh->starts[face]};
    assert_ok(norma_reverse_winding(mesh->corners + mesh->starts[face], 4, starts[1], starts, 1));
}

static norma_orient_report orient(const mesh_file *mesh, norma_orient_open open, uint8_t *reverse) {
    const norma_mesh view = mesh_file_view_polygons(mesh);
    norma_orient_report report;
    assert_ok(norma_orient(&view, open, NULL, reverse, mesh->face_count, &report));
    return report;
}

static uint32_t random_next(uint32_t *state) {
    return *state = *state * 1664525u + 1013904223u, *state >> 8;
}

static void faces_turned_at_random_are_found(void **state) {
    (void)state;
    uint32_t seed = 1;
    for (int round = 0; round < 50; ++round) {
        mesh_file mesh = {0};
        uint8_t reverse[64], turned[64] = {0};
        add_box(&mesh, 0, 0, 0, 1, 0);
        add_box(&mesh, 5, 0, 0, 1, 0);
        for (size_t f = 0; f < mesh.face_count; ++f)
            if (random_next(&seed) % 2) {
                turned[f] = 1;
                turn(&mesh, f);
            }
        const norma_orient_report report = orient(&mesh, NORMA_ORIENT_OPEN_KEPT, reverse);
        assert_memory_equal(reverse, turned, mesh.face_count);
        assert_int_equal(report.parts, 2);
        assert_int_equal(report.closed, 2);
        mesh_file_free(&mesh);
    }
}

static void a_cavity_stays_one_and_what_is_in_it_looks_outward(void **state) {
    (void)state;
    mesh_file mesh = {0};
    uint8_t reverse[64];
    add_box(&mesh, 0, 0, 0, 4, 1);       /* a shell, inside out */
    add_box(&mesh, 0.1, 0, 0, 3, 1);     /* its cavity, right */
    add_box(&mesh, 0.1, 0.1, 0, 2, 1);   /* a body in the cavity, inside out */
    add_box(&mesh, 0.1, 0.1, 0.1, 1, 0); /* a body in that body: nothing can be known */
    add_box(&mesh, 20, 0, 0, 4, 0);      /* elsewhere, right */
    const norma_orient_report report = orient(&mesh, NORMA_ORIENT_OPEN_KEPT, reverse);
    static const uint8_t expected[5] = {1, 0, 1, 0, 0};
    for (size_t f = 0; f < mesh.face_count; ++f) assert_int_equal(reverse[f], expected[f / 6]);
    assert_int_equal(report.inward, 2);
    assert_int_equal(report.nested, 1);
    assert_int_equal(report.reversed_faces, 12);
    mesh_file_free(&mesh);
}

/* Two boxes with an edge in common: four faces there. Each is a part of its own. */
static void parts_are_cut_at_edges_of_many_faces(void **state) {
    (void)state;
    mesh_file mesh = {0};
    uint8_t reverse[64];
    add_box(&mesh, 0, 0, 0, 1, 0);
    add_box(&mesh, 2, 2, 0, 1, 1);
    turn(&mesh, 3);
    const norma_orient_report report = orient(&mesh, NORMA_ORIENT_OPEN_KEPT, reverse);
    assert_int_equal(report.non_manifold_edges, 1);
    assert_int_equal(report.parts, 2);
    assert_int_equal(report.closed, 2);
    for (size_t f = 0; f < 12; ++f) assert_int_equal(reverse[f], f == 3 || f >= 6);
    mesh_file_free(&mesh);
}

static void a_moebius_band_is_left(void **state) {
    (void)state;
    mesh_file mesh = {0};
    uint8_t reverse[64];
    enum { STEPS = 24 };
    for (int i = 0; i < STEPS; ++i) {
        const double turn_rad = i * 2 * 3.141592653589793 / STEPS;
        for (int side = -1; side <= 1; side += 2)
            mesh_file_add_position(&mesh, cos(turn_rad) * (3 + side * cos(turn_rad / 2)),
                sin(turn_rad) * (3 + side * cos(turn_rad / 2)), side * sin(turn_rad / 2));
    }
    for (uint32_t i = 0; i < STEPS; ++i) {
        const uint32_t next = (i + 1) % STEPS, cross = next == 0;
        mesh_file_add_face(
            &mesh, (uint32_t[]){2 * i, 2 * next + cross, 2 * next + 1 - cross, 2 * i + 1}, 4);
    }
    const norma_orient_report report = orient(&mesh, NORMA_ORIENT_OPEN_BY_RAYS, reverse);
    assert_int_equal(report.one_sided, 1);
    assert_int_equal(report.reversed_faces, 0);
    assert_int_equal(report.winding_conflicts, 1);
    mesh_file_free(&mesh);
}

/* A small sheet close above a wide box, looking down at it: every ray from its front meets the box,
 * none from its back meets anything. */
static void a_sheet_that_looks_at_a_box_is_turned(void **state) {
    (void)state;
    mesh_file mesh = {0};
    uint8_t reverse[64];
    add_box(&mesh, 0, 0, -1001, 1000, 0);
    mesh_file_add_position(&mesh, 0, 0, 0);
    mesh_file_add_position(&mesh, 0, 0x1p-6, 0);
    mesh_file_add_position(&mesh, 0x1p-6, 0, 0);
    mesh_file_add_face(&mesh, (uint32_t[]){8, 9, 10}, 3);
    const norma_orient_report report = orient(&mesh, NORMA_ORIENT_OPEN_BY_RAYS, reverse);
    for (size_t f = 0; f < 7; ++f) assert_int_equal(reverse[f], f == 6);
    assert_int_equal(report.by_rays, 1);
    assert_true(report.least_confidence > .95);
    mesh_file_free(&mesh);
}

/* A box without its lid, inward: its inside is nearer to itself than its outside. */
static void rays_turn_what_is_open(void **state) {
    (void)state;
    for (int inward = 0; inward < 2; ++inward) {
        mesh_file mesh = {0};
        uint8_t reverse[64];
        add_box(&mesh, 0, 0, 0, 1, inward);
        --mesh.face_count;
        mesh.corner_count -= 4;
        turn(&mesh, 2);
        norma_orient_report report = orient(&mesh, NORMA_ORIENT_OPEN_KEPT, reverse);
        assert_int_equal(report.open, 1);
        assert_int_equal(report.undecided, 1);
        for (size_t f = 0; f < 5; ++f) assert_int_equal(reverse[f], f == 2);
        report = orient(&mesh, NORMA_ORIENT_OPEN_BY_RAYS, reverse);
        assert_int_equal(report.by_rays, 1);
        assert_true(report.least_confidence > .5 && report.least_confidence <= 1);
        for (size_t f = 0; f < 5; ++f) assert_int_equal(reverse[f], (f == 2) != inward);
        mesh_file_free(&mesh);
    }
}

static double random_unit(uint32_t *state) { return random_next(state) / 16777216.0; }

/* Triangles in a unit cube, of random corners up to size apart. At 1 every box overlaps most
 * others.
 */
static void add_random_triangles(mesh_file *mesh, size_t count, double size) {
    uint32_t state = 7;
    for (uint32_t f = 0; f < count; ++f) {
        double from[3];
        for (int k = 0; k < 3; ++k) from[k] = (1 - size) * random_unit(&state);
        for (int k = 0; k < 3; ++k)
            mesh_file_add_position(mesh, from[0] + size * random_unit(&state),
                from[1] + size * random_unit(&state), from[2] + size * random_unit(&state));
        mesh_file_add_face(mesh, (uint32_t[]){3 * f, 3 * f + 1, 3 * f + 2}, 3);
    }
}

static uint64_t count_ray_steps(const mesh_file *mesh) {
    core_call call;
    core_mesh checked;
    core_topology topology;
    core_components components;
    core_ray_votes votes;
    const norma_mesh view = mesh_file_view_polygons(mesh);
    assert_ok(norma_core_begin(&call, NULL));
    assert_ok(norma_core_mesh_shape(&view, &checked));
    assert_ok(norma_core_mesh_content(&call, &checked));
    assert_ok(norma_core_topology_open(&call, &checked, &topology));
    assert_ok(norma_core_pair_edges(&topology, NULL));
    assert_ok(norma_core_find_components(&topology, CORE_JOIN_CUT, &components));
    assert_ok(norma_core_orient_by_rays(
        &topology, &components, COMPONENT_OPEN | COMPONENT_UNBALANCED, &votes));
    norma_core_release_components(&call, &components);
    norma_core_topology_close(&topology);
    return votes.steps;
}

/* The work of rays grows as n log n even where they can leave out nothing: in four times as many
 * triangles whose boxes all overlap, each may look at a quarter more at most, and never at more
 * than 300 times the logarithm: separate triangles cost half a second a megabyte. */
static void rays_take_n_log_n_steps(void **state) {
    (void)state;
    static const double sizes[] = {1, .05, .01};
    for (size_t i = 0; i < 3; ++i) {
        uint64_t before = 0;
        for (size_t count = 1000; count <= 16000 / SLOWER; count *= 4) {
            mesh_file mesh = {0};
            add_random_triangles(&mesh, count, sizes[i]);
            const uint64_t steps = count_ray_steps(&mesh);
            assert_true(steps > 64 * count);
            assert_true((double)steps < 300 * (double)count * log2((double)count));
            if (count > 4000 && i == 0) assert_true(steps < 5 * before);
            before = steps;
            mesh_file_free(&mesh);
        }
    }
}

/* Where all triangles coincide, each ray meets all of them, and none of them is a part that rays
 * could tell the sides of: that is found out by few. */
static void coincident_triangles_take_few_steps(void **state) {
    (void)state;
    for (uint32_t count = 1000; count <= 16000; count *= 4) {
        mesh_file mesh = {0};
        for (int k = 0; k < 3; ++k) mesh_file_add_position(&mesh, k == 1, k == 2, 0);
        for (uint32_t f = 0; f < count; ++f)
            mesh_file_add_face(&mesh, (uint32_t[]){0, 1 + f % 2, 2 - f % 2}, 3);
        assert_true((double)count_ray_steps(&mesh) < 64 * (double)count * log2((double)count));
        mesh_file_free(&mesh);
    }
}

/* Open boxes, of which each second one looks inward. What rays turned once they leave as it is:
 * they start and go the same way on either winding. */
static void rays_turn_nothing_twice(void **state) {
    (void)state;
    enum { BOXES = 60, COUNT = 5 * BOXES };
    mesh_file mesh = {0};
    uint8_t reverse[COUNT];
    uint32_t seed = 7;
    for (int i = 0; i < BOXES; ++i) {
        add_box(&mesh, 30 * random_unit(&seed), 30 * random_unit(&seed), 30 * random_unit(&seed),
            .1 + random_unit(&seed), i % 2);
        --mesh.face_count;
        mesh.corner_count -= 4;
    }
    norma_orient_report report = orient(&mesh, NORMA_ORIENT_OPEN_BY_RAYS, reverse);
    assert_true(report.by_rays > BOXES / 2 && report.least_confidence >= .25);
    for (size_t f = 0; f < COUNT; ++f) {
        assert_true(!reverse[f] || f / 5 % 2);
        if (reverse[f]) turn(&mesh, f);
    }
    report = orient(&mesh, NORMA_ORIENT_OPEN_BY_RAYS, reverse);
    assert_true(report.by_rays > BOXES / 2);
    assert_int_equal(report.reversed_faces, 0);
    mesh_file_free(&mesh);
}

/* Two panes side by side, near enough that each hides less than a quarter of what the other sees:
 * that decides nothing. Much nearer, each looks away from the other. */
static void fewer_than_a_quarter_more_decide_nothing(void **state) {
    (void)state;
    for (int near = 0; near < 2; ++near) {
        mesh_file mesh = {0};
        uint8_t reverse[2];
        const double apart = near ? .2 : 3;
        for (uint32_t i = 0; i < 2; ++i) {
            for (int k = 0; k < 4; ++k)
                mesh_file_add_position(&mesh, k == 1 || k == 2, k > 1, i * apart);
            mesh_file_add_face(
                &mesh, (uint32_t[]){4 * i, 4 * i + 1, 4 * i + 2, 4 * i + 3}, 4); /* looks up */
        }
        const norma_orient_report report = orient(&mesh, NORMA_ORIENT_OPEN_BY_RAYS, reverse);
        assert_int_equal(report.by_rays, near ? 2 : 0);
        assert_int_equal(report.undecided, near ? 0 : 2);
        assert_int_equal(reverse[0], near);
        assert_int_equal(reverse[1], 0);
        mesh_file_free(&mesh);
    }
}

/* Of every mesh of the data set: turning faces as told leaves no conflict but at one-sided parts,
 * and a second look turns nothing more. */
static void once_is_enough(void *user, const char *path, const char *name) {
    mesh_file mesh = {0};
    (void)user;
    if (mesh_file_load(path, &mesh) != 0 || mesh.face_count == 0 ||
        mesh.face_count > 100000 / SLOWER) {
        mesh_file_free(&mesh);
        return;
    }
    uint8_t *reverse = malloc(mesh.face_count);
    const norma_orient_report first = orient(&mesh, NORMA_ORIENT_OPEN_KEPT, reverse);
    for (size_t f = 0; f < mesh.face_count; ++f)
        if (reverse[f]) turn(&mesh, f);
    const norma_orient_report second = orient(&mesh, NORMA_ORIENT_OPEN_KEPT, reverse);
    if (second.reversed_faces || (second.winding_conflicts && !first.one_sided))
        fail_msg("%s: %zu faces turned again, %zu conflicts left", name, second.reversed_faces,
            second.winding_conflicts);
    assert_int_equal(second.inward, 0);
    assert_int_equal(first.parts, second.parts);
    free(reverse);
    mesh_file_free(&mesh);
}

static void turned_meshes_stay(void **state) {
    (void)state;
    const char *folder = data_folder();
    if (!folder) skip();
    assert_true(data_for_each(folder, once_is_enough, NULL) > 0);
}

/* Boxes in boxes and loose triangles, in doubles or floats of any size. Powers of two change no bit
 * that is computed, the others round. */
static void no_size_changes_the_answer(void **state) {
    (void)state;
    enum { LOOSE = 300 };
    static const double sizes[] = {0x1p-126, 1e-30, 1e-12, 0x1p-40, 0x1p40, 1e12, 1e30, 0x1p122};
    mesh_file mesh = {0};
    add_random_triangles(&mesh, LOOSE, .05);
    add_box(&mesh, 8, 0, 0, 4, 1);
    add_box(&mesh, 8.1, 0, 0, 3, 1);
    add_box(&mesh, 8.1, 0.1, 0, 2, 1);
    add_box(&mesh, 8.1, 0.1, 0.1, 1e-3, 0);
    uint8_t right[LOOSE + 24], reverse[LOOSE + 24];
    const norma_orient_report expected = orient(&mesh, NORMA_ORIENT_OPEN_BY_RAYS, right);
    double *doubles = malloc(3 * mesh.position_count * sizeof *doubles);
    float *floats = malloc(3 * mesh.position_count * sizeof *floats);
    norma_mesh view = mesh_file_view_polygons(&mesh);
    for (size_t i = 0; i < 2 * sizeof sizes / sizeof *sizes; ++i) {
        norma_orient_report report;
        for (size_t k = 0; k < 3 * mesh.position_count; ++k) {
            doubles[k] = sizes[i / 2] * ((double *)mesh.positions)[k];
            floats[k] = (float)doubles[k];
        }
        view.positions = (norma_vec3_view){i % 2 ? (void *)floats : (void *)doubles,
            mesh.position_count, 0, i % 2 ? NORMA_FORMAT_FLOAT : NORMA_FORMAT_DOUBLE};
        assert_ok(norma_orient(
            &view, NORMA_ORIENT_OPEN_BY_RAYS, NULL, reverse, mesh.face_count, &report));
        assert_memory_equal(reverse, right, mesh.face_count);
        assert_memory_equal(&report, &expected, sizeof report);
    }
    free(doubles);
    free(floats);
    mesh_file_free(&mesh);
}

static void threads_change_nothing(void **state) {
    (void)state;
    mesh_file mesh = {0};
    uint32_t seed = 7;
    for (int i = 0; i < 400; ++i)
        add_box(&mesh, random_next(&seed) % 20, random_next(&seed) % 20, random_next(&seed) % 20,
            0.1 + (random_next(&seed) % 1000) / 300.0, (int)(random_next(&seed) % 2));
    uint8_t *one = malloc(mesh.face_count), *many = malloc(mesh.face_count);
    const norma_mesh view = mesh_file_view_polygons(&mesh);
    const norma_options threads = {.struct_size = sizeof threads, .threads = 8};
    norma_orient_report of_one, of_many;
    assert_ok(norma_orient(&view, NORMA_ORIENT_OPEN_BY_RAYS, NULL, one, mesh.face_count, &of_one));
    assert_ok(
        norma_orient(&view, NORMA_ORIENT_OPEN_BY_RAYS, &threads, many, mesh.face_count, &of_many));
    assert_memory_equal(one, many, mesh.face_count);
    assert_memory_equal(&of_one, &of_many, sizeof of_one);
    free(one);
    free(many);
    mesh_file_free(&mesh);
}

static void arguments_are_checked(void **state) {
    (void)state;
    const float positions[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    const norma_mesh mesh = {.positions = {positions, 3, 0, NORMA_FORMAT_FLOAT}, .corner_count = 3},
                     empty = {.corner_count = 0};
    uint8_t reverse[1] = {7};
    assert_int_equal(
        norma_orient(NULL, NORMA_ORIENT_OPEN_KEPT, NULL, reverse, 1, NULL), NORMA_ERROR_ARGUMENT);
    assert_int_equal(
        norma_orient(&mesh, NORMA_ORIENT_OPEN_KEPT, NULL, NULL, 1, NULL), NORMA_ERROR_ARGUMENT);
    assert_int_equal(
        norma_orient(&mesh, (norma_orient_open)2, NULL, reverse, 1, NULL), NORMA_ERROR_ARGUMENT);
    assert_int_equal(
        norma_orient(&mesh, NORMA_ORIENT_OPEN_KEPT, NULL, reverse, 0, NULL), NORMA_ERROR_CAPACITY);
    assert_int_equal(reverse[0], 7);
    assert_ok(norma_orient(&empty, NORMA_ORIENT_OPEN_KEPT, NULL, NULL, 0, NULL));
    assert_ok(norma_orient(&mesh, NORMA_ORIENT_OPEN_BY_RAYS, NULL, reverse, 1, NULL));
    assert_int_equal(reverse[0], 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(faces_turned_at_random_are_found),
        cmocka_unit_test(a_cavity_stays_one_and_what_is_in_it_looks_outward),
        cmocka_unit_test(parts_are_cut_at_edges_of_many_faces),
        cmocka_unit_test(a_moebius_band_is_left),
        cmocka_unit_test(rays_turn_what_is_open),
        cmocka_unit_test(rays_take_n_log_n_steps),
        cmocka_unit_test(coincident_triangles_take_few_steps),
        cmocka_unit_test(rays_turn_nothing_twice),
        cmocka_unit_test(a_sheet_that_looks_at_a_box_is_turned),
        cmocka_unit_test(fewer_than_a_quarter_more_decide_nothing),
        cmocka_unit_test(turned_meshes_stay),
        cmocka_unit_test(no_size_changes_the_answer),
        cmocka_unit_test(threads_change_nothing),
        cmocka_unit_test(arguments_are_checked),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
