/* test_plan_calls.c: what the calls on plans ask of their arguments, where memory comes from and
 * goes to, the nearest fallback, formats and strides. */
#define _POSIX_C_SOURCE 200112L /* posix_memalign */
#include "check.h"
#include "mesh_files.h"
#include "oracle/shapes.h"

enum { ROOM = 4096 };

/* ---- arguments */

static void wrong_arguments_of_creation(void **state) {
    (void)state;
    const float p[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    const uint32_t bad[3] = {0, 1, 3};
    norma_mesh mesh = {.positions = {p, 3, 0, NORMA_FORMAT_FLOAT}, .corner_count = 3};
    norma_plan *plan = NULL;
    norma_options options = {.weld = (norma_weld)9};
    assert_int_equal(
        norma_plan_create(NULL, NORMA_PER_VERTEX, 1, NULL, &plan), NORMA_ERROR_ARGUMENT);
    assert_int_equal(
        norma_plan_create(&mesh, NORMA_PER_VERTEX, 1, NULL, NULL), NORMA_ERROR_ARGUMENT);
    assert_int_equal(
        norma_plan_create(&mesh, (norma_element)2, 1, NULL, &plan), NORMA_ERROR_ARGUMENT);
    assert_int_equal(
        norma_plan_create(&mesh, NORMA_PER_VERTEX, NAN, NULL, &plan), NORMA_ERROR_ARGUMENT);
    assert_int_equal(
        norma_plan_create(&mesh, NORMA_PER_VERTEX, 1, &options, &plan), NORMA_ERROR_ARGUMENT);
    mesh.corners = bad;
    assert_int_equal(norma_plan_create(&mesh, NORMA_PER_VERTEX, 1, NULL, &plan), NORMA_ERROR_INDEX);
    mesh.corner_count = 2;
    assert_int_equal(
        norma_plan_create(&mesh, NORMA_PER_VERTEX, 1, NULL, &plan), NORMA_ERROR_ARGUMENT);
    assert_null(plan);
    assert_int_equal(norma_plan_bytes(NULL), 0);
    norma_plan_destroy(NULL);
}

static void wrong_arguments_of_updates(void **state) {
    (void)state;
    const float p[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    const uint32_t moved[3] = {0, 2, 3};
    float out[9], before[9];
    norma_mesh mesh = {.positions = {p, 3, 0, NORMA_FORMAT_FLOAT}, .corner_count = 3};
    norma_vec3_view view = mesh.positions;
    norma_options options = {.normal_stride = 8};
    norma_plan *plan;
    memset(out, 7, sizeof out);
    memcpy(before, out, sizeof out);
    assert_ok(norma_plan_create(&mesh, NORMA_PER_VERTEX, 1, NULL, &plan));
    assert_int_equal(
        norma_plan_update(NULL, view, NULL, 0, NULL, out, 3, NULL), NORMA_ERROR_ARGUMENT);
    assert_int_equal(
        norma_plan_update(plan, view, NULL, 0, NULL, NULL, 3, NULL), NORMA_ERROR_ARGUMENT);
    assert_int_equal(
        norma_plan_update(plan, view, NULL, 0, NULL, out, 2, NULL), NORMA_ERROR_CAPACITY);
    assert_int_equal(
        norma_plan_update(plan, view, NULL, 0, &options, out, 3, NULL), NORMA_ERROR_ARGUMENT);
    assert_int_equal(
        norma_plan_update(plan, view, moved, 3, NULL, out, 3, NULL), NORMA_ERROR_INDEX);
    view.count = 2;
    assert_int_equal(
        norma_plan_update(plan, view, NULL, 0, NULL, out, 3, NULL), NORMA_ERROR_ARGUMENT);
    view.count = 4;
    assert_int_equal(
        norma_plan_update(plan, view, NULL, 0, NULL, out, 3, NULL), NORMA_ERROR_ARGUMENT);
    view = (norma_vec3_view){NULL, 3, 0, NORMA_FORMAT_FLOAT};
    assert_int_equal(
        norma_plan_update(plan, view, NULL, 0, NULL, out, 3, NULL), NORMA_ERROR_ARGUMENT);
    assert_ok(
        norma_plan_update(plan, mesh.positions, moved, 0, NULL, out, 3, NULL)); /* nothing moved */
    assert_memory_equal(out, before, sizeof out);
    assert_ok(norma_plan_update(plan, mesh.positions, moved, 1, NULL, out, 3, NULL));
    assert_direction(out, 0, 0, 1, 0);
    assert_true(norma_plan_bytes(plan) > 0);
    norma_plan_destroy(plan);
}

static void empty_meshes(void **state) {
    (void)state;
    const norma_mesh none = {.corner_count = 0};
    const float p[6] = {0, 0, 0, NAN, 0, 0};
    const norma_mesh points = {.positions = {p, 2, 0, NORMA_FORMAT_FLOAT}};
    const uint32_t moved[3] = {1, 1, 0};
    uint8_t reasons[2] = {9, 9};
    norma_options options = {
        .fallback = NORMA_FALLBACK_GIVEN, .fallback_normal = {0, 0, 1}, .reasons = reasons};
    norma_report report;
    float out[6];
    norma_plan *plan;
    assert_ok(norma_plan_create(&none, NORMA_PER_CORNER, 1, NULL, &plan));
    assert_ok(norma_plan_update(plan, none.positions, NULL, 0, NULL, NULL, 0, NULL));
    norma_plan_destroy(plan);
    assert_ok(norma_plan_create(&points, NORMA_PER_VERTEX, 1, NULL, &plan));
    assert_ok(norma_plan_update(plan, points.positions, moved, 3, &options, out, 2, &report));
    assert_int_equal(reasons[0], NORMA_REASON_UNREFERENCED);
    assert_int_equal(reasons[1], NORMA_REASON_NON_FINITE);
    assert_int_equal(report.unreferenced.count, 1);
    assert_int_equal(report.non_finite.count, 1);
    assert_int_equal(report.non_finite.first, 1);
    assert_true(out[2] == 1 && out[5] == 1);
    norma_plan_destroy(plan);
}

/* ---- memory */

typedef struct accountant {
    size_t calls, fail_at, live, bytes;
} accountant;

static void *take(void *user, size_t size, size_t alignment) {
    accountant *a = user;
    if (++a->calls == a->fail_at) return NULL;
    void *block = NULL;
    assert_int_equal(
        posix_memalign(&block, alignment < sizeof(void *) ? sizeof(void *) : alignment, size), 0);
    memset(block, 0xcd, size);
    ++a->live;
    a->bytes += size;
    return block;
}

static void give(void *user, void *block, size_t size) {
    accountant *a = user;
    --a->live;
    a->bytes -= size;
    free(block);
}

static void fill(mesh_file *mesh, norma_mesh *view, float *floats) {
    shape_uv_sphere(mesh, 12, 8, 1, 1);
    uint32_t hub[700];
    const uint32_t first = (uint32_t)mesh->position_count; /* what fits no tile is in it as well */
    for (uint32_t i = 0; i < 600; ++i)
        mesh_file_add_position(mesh, 4 + cos(i * 0.01), sin(i * 0.01), 0.01 * i);
    for (uint32_t i = 1; i < 599; ++i)
        mesh_file_add_face(mesh, (uint32_t[]){first, first + i, first + i + 1}, 3);
    for (uint32_t i = 0; i < 600; ++i) hub[i] = first + i;
    mesh_file_add_face(mesh, hub, 600);
    shape_round_to_float(mesh);
    *view = mesh_file_view_float(mesh, floats);
}

static void failing_allocations(void **state) {
    (void)state;
    mesh_file mesh = {0};
    norma_mesh view;
    float *floats = test_calloc(3 * ROOM, sizeof *floats),
          *out = test_calloc(3 * ROOM, sizeof *out), *wanted = test_calloc(3 * ROOM, sizeof *out);
    fill(&mesh, &view, floats);
    for (int of = 0; of < 2; ++of) {
        norma_plan *plan;
        const size_t elements = of ? mesh.corner_count : mesh.position_count;
        assert_ok(norma_plan_create(&view, (norma_element)of, 0.5f, NULL, &plan));
        assert_ok(norma_plan_update(plan, view.positions, NULL, 0, NULL, wanted, ROOM, NULL));
        norma_plan_destroy(plan);
        for (size_t fail_at = 1, done = 0; !done; ++fail_at) {
            accountant a = {.fail_at = fail_at};
            norma_options options = {.allocator = {take, give, &a}};
            plan = NULL;
            const norma_result result =
                norma_plan_create(&view, (norma_element)of, 0.5f, &options, &plan);
            if (!result) {
                const size_t calls = a.calls;
                assert_true(a.bytes >= norma_plan_bytes(plan) - 64);
                assert_true(a.bytes <= norma_plan_bytes(plan) + 64);
                assert_ok(
                    norma_plan_update(plan, view.positions, NULL, 0, &options, out, ROOM, NULL));
                assert_int_equal(a.calls, calls); /* an update allocates nothing */
                assert_memory_equal(out, wanted, 12 * elements);
                norma_plan_destroy(plan);
                done = fail_at > a.calls;
            } else {
                assert_int_equal(result, NORMA_ERROR_MEMORY);
                assert_null(plan);
            }
            assert_int_equal(a.live, 0);
            assert_int_equal(a.bytes, 0);
        }
    }
    mesh_file_free(&mesh);
    test_free(floats);
    test_free(out);
    test_free(wanted);
}

/* Threads that a call keeps from step to step need room of their own. */
static void threads_allocate_nothing(void **state) {
    (void)state;
    mesh_file mesh = {0};
    shape_wavy_grid(&mesh, 60, 0);
    shape_round_to_float(&mesh);
    float *floats = test_calloc(3 * mesh.position_count, sizeof *floats),
          *out = test_calloc(3 * mesh.position_count, sizeof *out);
    const norma_mesh view = mesh_file_view_float(&mesh, floats);
    accountant a = {0};
    const norma_options options = {.threads = 2, .allocator = {take, give, &a}};
    norma_plan *plan;
    uint32_t *moved = test_calloc(mesh.position_count - 1, sizeof *moved);
    for (uint32_t i = 0; i + 1 < mesh.position_count; ++i) moved[i] = i + 1;
    assert_true(mesh.corner_count > 1 << 14); /* enough for a thread of its own */
    assert_ok(norma_plan_create(&view, NORMA_PER_VERTEX, 3, &options, &plan));
    const size_t calls = a.calls;
    assert_ok(
        norma_plan_update(plan, view.positions, NULL, 0, &options, out, mesh.position_count, NULL));
    assert_ok(norma_plan_update(plan, view.positions, moved, mesh.position_count - 1, &options, out,
        mesh.position_count, NULL));
    assert_int_equal(a.calls, calls);
    norma_plan_destroy(plan);
    assert_int_equal(a.live, 0);
    mesh_file_free(&mesh);
    test_free(moved);
    test_free(floats);
    test_free(out);
}

static int stop(void *user, double fraction) {
    (void)fraction;
    return --*(int *)user < 0;
}

static void cancelled(void **state) {
    (void)state;
    mesh_file mesh = {0};
    norma_mesh view;
    float *floats = test_calloc(3 * ROOM, sizeof *floats),
          *out = test_calloc(3 * ROOM, sizeof *out);
    fill(&mesh, &view, floats);
    for (int after = 0, done = 0; !done; ++after) {
        accountant a = {0};
        int left = after;
        norma_options options = {
            .allocator = {take, give, &a}, .progress = stop, .progress_user = &left};
        norma_plan *plan = NULL;
        norma_result result = norma_plan_create(&view, NORMA_PER_VERTEX, 0.5f, &options, &plan);
        if (!result)
            result = norma_plan_update(plan, view.positions, NULL, 0, &options, out, ROOM, NULL);
        done = !result;
        if (!done) assert_int_equal(result, NORMA_CANCELLED);
        norma_plan_destroy(plan);
        assert_int_equal(a.live, 0);
    }
    mesh_file_free(&mesh);
    test_free(floats);
    test_free(out);
}

/* ---- the nearest, formats, strides */

/* A grid with a twinned leaf and holes: what has no normal gets what norma_vertex_normals and
 * norma_corner_normals give it. */
static void nearest_as_in_the_full_calls(void **state) {
    (void)state;
    mesh_file mesh = {0};
    norma_options options = {.fallback = NORMA_FALLBACK_NEAREST};
    norma_plan *plan;
    float *floats = test_calloc(3 * ROOM, sizeof *floats),
          *out = test_calloc(3 * ROOM, sizeof *out), *wanted = test_calloc(3 * ROOM, sizeof *out);
    uint32_t moved[2] = {7, 12};
    shape_wavy_grid(&mesh, 12, 0);
    for (uint32_t i = 0; i < 20; ++i) mesh_file_add_position(&mesh, i * 0.3, 5 - i * 0.2, 1);
    mesh_file_add_face(&mesh, (uint32_t[]){3, 3, 40}, 3);
    mesh_file_add_face(&mesh, (uint32_t[]){170, 171, 172}, 3);
    mesh_file_add_face(&mesh, (uint32_t[]){172, 171, 170}, 3);
    norma_mesh view = mesh_file_view_float(&mesh, floats);
    for (int of = 0; of < 2; ++of) {
        const size_t elements = of ? mesh.corner_count : mesh.position_count;
        assert_ok(norma_plan_create(&view, (norma_element)of, 3.1415927F, &options, &plan));
        assert_ok(norma_plan_update(plan, view.positions, NULL, 0, &options, out, ROOM, NULL));
        for (int step = 0; step < 3; ++step) {
            floats[3 * 7 + 2] += 1;
            floats[3 * 12] = step == 1 ? (float)NAN : 0.5f;
            assert_ok(norma_plan_update(plan, view.positions, moved, 2, &options, out, ROOM, NULL));
            assert_ok(of ? norma_corner_normals(&view, 3.1415927F, &options, wanted, ROOM, NULL)
                         : norma_vertex_normals(&view, &options, wanted, ROOM, NULL));
            assert_memory_equal(out, wanted, 12 * elements);
        }
        norma_plan_destroy(plan);
    }
    mesh_file_free(&mesh);
    test_free(floats);
    test_free(out);
    test_free(wanted);
}

static void formats_and_strides(void **state) {
    (void)state;
    static const norma_format formats[] = {NORMA_FORMAT_INT8, NORMA_FORMAT_UINT8,
        NORMA_FORMAT_INT16, NORMA_FORMAT_UINT16, NORMA_FORMAT_DOUBLE, NORMA_FORMAT_FLOAT};
    mesh_file mesh = {0};
    float floats[3 * 200], wanted[3 * 200];
    unsigned char bytes[200 * 40], out[200 * 20];
    shape_box(&mesh, 90, 60, 30, 1);
    mesh_file_add_position(&mesh, 45, 30, 100);
    mesh_file_add_face(&mesh, (uint32_t[]){0, 1, 8}, 3);
    norma_mesh view = mesh_file_view_float(&mesh, floats);
    norma_plan *plan;
    assert_ok(norma_plan_create(&view, NORMA_PER_CORNER, 1, NULL, &plan));
    assert_ok(
        norma_plan_update(plan, view.positions, NULL, 0, NULL, wanted, mesh.corner_count, NULL));
    for (size_t f = 0; f < COUNT_OF(formats); ++f) {
        const norma_options options = {.normal_stride = 17};
        for (size_t v = 0; v < mesh.position_count; ++v)
            for (size_t x = 0; x < 3; ++x) {
                const double number = mesh.positions[v][x];
                const int8_t i8 = (int8_t)number;
                const int16_t i16 = (int16_t)number;
                const float f32 = (float)number;
                const void *from = formats[f] == NORMA_FORMAT_DOUBLE  ? (const void *)&number
                                   : formats[f] == NORMA_FORMAT_FLOAT ? (const void *)&f32
                                   : f < 2                            ? (const void *)&i8
                                                                      : (const void *)&i16;
                const size_t size = formats[f] == NORMA_FORMAT_DOUBLE  ? 8
                                    : formats[f] == NORMA_FORMAT_FLOAT ? 4
                                    : f < 2                            ? 1
                                                                       : 2;
                memcpy(bytes + 1 + 29 * v + size * x, from, size);
            }
        memset(out, 0xa5, sizeof out);
        assert_ok(norma_plan_update(plan,
            (norma_vec3_view){bytes + 1, mesh.position_count, 29, formats[f]}, NULL, 0, &options,
            (float *)(void *)(out + 4), mesh.corner_count, NULL));
        for (size_t c = 0; c < mesh.corner_count; ++c) {
            assert_memory_equal(out + 4 + 17 * c, wanted + 3 * c, 12);
            assert_true(out[4 + 17 * c + 12] == 0xa5 && out[4 + 17 * c + 16] == 0xa5);
        }
    }
    norma_plan_destroy(plan);
    mesh_file_free(&mesh);
}

/* Creases are those of the mesh at creation, however it bends. */
static void creases_stay(void **state) {
    (void)state;
    float p[12] = {0, 0, 0, 0, 1, 0, -1, 0, 0, 1, 0, 0};
    const uint32_t corners[6] = {0, 1, 2, 1, 0, 3};
    float out[18];
    norma_mesh mesh = {
        .positions = {p, 4, 0, NORMA_FORMAT_FLOAT}, .corners = corners, .corner_count = 6};
    norma_edges edges;
    norma_options options = {.struct_size = sizeof options, .edges = &edges};
    norma_plan *plan;
    assert_ok(norma_plan_create(&mesh, NORMA_PER_CORNER, 0.5f, &options, &plan)); /* flat: smooth */
    assert_int_equal(edges.smooth, 1);
    assert_int_equal(edges.open, 4);
    p[11] = 1; /* bent by 45 degrees */
    assert_ok(norma_plan_update(plan, mesh.positions, NULL, 0, NULL, out, 6, NULL));
    assert_memory_equal(out, out + 12, 12);
    assert_memory_equal(out + 3, out + 9, 12);
    norma_plan_destroy(plan);
    assert_ok(norma_plan_create(&mesh, NORMA_PER_CORNER, 0.5f, NULL, &plan)); /* bent: hard */
    p[11] = 0;
    assert_ok(norma_plan_update(plan, mesh.positions, NULL, 0, NULL, out, 6, NULL));
    p[11] = 1;
    const uint32_t moved = 3;
    assert_ok(norma_plan_update(plan, mesh.positions, &moved, 1, NULL, out, 6, NULL));
    assert_direction(out, 0, 0, 1, 0);
    assert_true(degrees_to(out + 12, 0, 0, 1) > 30);
    norma_plan_destroy(plan);
}

/* A report of some is of what was written. */
/* A vertex of no face lies beyond what squares reach in doubles, and comes nearer, or goes there:
 * no normal hangs on that. */
static void far_vertices(void **state) {
    (void)state;
    static const uint32_t faces[] = {0, 1, 2, 0, 2, 3}, moved[] = {4};
    static const double sizes[] = {0x1p984, 0x1p-984, 1}, fars[] = {0, 0x1p984, 0x1p-984, 0x1p300};
    float some[15], all[15];
    for (int weight = NORMA_WEIGHT_ANGLE; norma_weight_name((norma_weight)weight); ++weight)
        for (size_t size = 0; size < 3; ++size)
            for (size_t far = 0; far < 4; ++far) {
                double p[5][3] = {{0, 0, 0}, {5, 0, 1}, {5, 5, 0}, {0, 5, 2}, {sizes[size], 1, 1}};
                norma_mesh mesh = {.positions = {p, 5, 0, NORMA_FORMAT_DOUBLE},
                    .corners = faces,
                    .corner_count = 6};
                norma_options options = {.weight = (norma_weight)weight};
                norma_plan *plan;
                assert_ok(norma_plan_create(&mesh, NORMA_PER_VERTEX, 3.1415927F, &options, &plan));
                assert_ok(
                    norma_plan_update(plan, mesh.positions, NULL, 0, &options, some, 5, NULL));
                p[4][0] = fars[far];
                assert_ok(
                    norma_plan_update(plan, mesh.positions, moved, 1, &options, some, 5, NULL));
                assert_ok(norma_plan_update(plan, mesh.positions, NULL, 0, &options, all, 5, NULL));
                assert_memory_equal(some, all, sizeof all);
                norma_plan_destroy(plan);
            }
}

static void reports(void **state) {
    (void)state;
    float p[21] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 5, 0, 0, 6, 0, 0, 7, 0, 0, 9, 9, 9};
    const uint32_t corners[6] = {0, 1, 2, 3, 4, 5}, moved[2] = {1, 4};
    float out[21];
    norma_mesh mesh = {
        .positions = {p, 7, 0, NORMA_FORMAT_FLOAT}, .corners = corners, .corner_count = 6};
    norma_report report;
    norma_plan *plan;
    assert_ok(norma_plan_create(&mesh, NORMA_PER_VERTEX, 1, NULL, &plan));
    assert_ok(norma_plan_update(plan, mesh.positions, NULL, 0, NULL, out, 7, &report));
    assert_int_equal(report.degenerate_faces.count, 1);
    assert_int_equal(report.degenerate_faces.first, 1);
    assert_int_equal(report.unreferenced.count, 4);
    assert_int_equal(report.unreferenced.first, 3);
    assert_int_equal(report.winding_conflicts.first, SIZE_MAX);
    assert_ok(norma_plan_update(plan, mesh.positions, moved, 1, NULL, out, 7, &report));
    assert_int_equal(report.degenerate_faces.count, 0);
    assert_int_equal(report.unreferenced.count, 0);
    assert_ok(norma_plan_update(plan, mesh.positions, moved + 1, 1, NULL, out, 7, &report));
    assert_int_equal(report.degenerate_faces.count, 1);
    assert_int_equal(report.unreferenced.count, 3);
    norma_plan_destroy(plan);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(wrong_arguments_of_creation),
        cmocka_unit_test(wrong_arguments_of_updates), cmocka_unit_test(empty_meshes),
        cmocka_unit_test(failing_allocations), cmocka_unit_test(threads_allocate_nothing),
        cmocka_unit_test(cancelled), cmocka_unit_test(nearest_as_in_the_full_calls),
        cmocka_unit_test(formats_and_strides), cmocka_unit_test(creases_stay),
        cmocka_unit_test(reports), cmocka_unit_test(far_vertices)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
