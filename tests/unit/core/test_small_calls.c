/* test_small_calls.c: calls on few triangles ask the system nothing: with all threads allowed, the
 * number of processors is asked for only where there is enough to share, and never so that the
 * system looks into a file, as glibc's sysconf does. */
#define _GNU_SOURCE
#include "check.h"
#include "oracle/shapes.h"
#include <sched.h>
#include <unistd.h>

static int asked, files;

/* The linker has every call of these end here (--wrap). */
long __real_sysconf(int name);
long __wrap_sysconf(int name);
long __wrap_sysconf(int name) {
    if (name != _SC_NPROCESSORS_ONLN) return __real_sysconf(name);
    ++files;
    return 4;
}
int __wrap_sched_getaffinity(pid_t process, size_t size, cpu_set_t *set);
int __wrap_sched_getaffinity(pid_t process, size_t size, cpu_set_t *set) {
    (void)process;
    memset(set, 0, size);
    for (size_t i = 0; i < 4; ++i) CPU_SET(i, set);
    ++asked;
    return 0;
}

static void all_calls(const norma_mesh *mesh, float *normals, size_t capacity) {
    const norma_options options = {.struct_size = sizeof options, .threads = NORMA_ALL_THREADS};
    norma_plan *plan;
    uint8_t *reverse = test_calloc(capacity, 1);
    size_t count;
    assert_int_equal(norma_face_normals(mesh, &options, normals, capacity, NULL), NORMA_OK);
    assert_int_equal(norma_vertex_normals(mesh, &options, normals, capacity, NULL), NORMA_OK);
    assert_int_equal(norma_corner_normals(mesh, 1, &options, normals, capacity, NULL), NORMA_OK);
    assert_int_equal(
        norma_split(mesh, 1, &options, NULL, 0, NULL, NULL, 0, &count, NULL), NORMA_OK);
    assert_int_equal(
        norma_orient(mesh, NORMA_ORIENT_OPEN_KEPT, &options, reverse, capacity, NULL), NORMA_OK);
    assert_int_equal(norma_plan_create(mesh, NORMA_PER_VERTEX, 1, &options, &plan), NORMA_OK);
    assert_int_equal(
        norma_plan_update(plan, mesh->positions, NULL, 0, &options, normals, capacity, NULL),
        NORMA_OK);
    norma_plan_destroy(plan);
    test_free(reverse);
}

static void run(uint32_t side, int may_ask) {
    mesh_file grid = {0};
    shape_wavy_grid(&grid, side, 0);
    const norma_mesh mesh = mesh_file_view(&grid);
    float *normals = test_calloc(3 * grid.corner_count, sizeof *normals);
    asked = 0;
    all_calls(&mesh, normals, grid.corner_count);
    if (may_ask)
        assert_true(asked > 0);
    else
        assert_int_equal(asked, 0);
    assert_int_equal(files, 0);
    test_free(normals);
    mesh_file_free(&grid);
}

static void few_triangles_ask_nothing(void **state) {
    (void)state;
    run(9, 0);
    run(30, 0);
}

static void many_triangles_ask(void **state) {
    (void)state;
    run(300, 1);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(few_triangles_ask_nothing), cmocka_unit_test(many_triangles_ask)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
