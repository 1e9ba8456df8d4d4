/* test_plan_threads.c: several threads update by one plan at once, each with positions and normals
 * of its own, some with threads of their own; the marks that a large plan lends to one of them at a
 * time are taken by one, and the others do without. Every outcome is that of a call by itself. */
#include "check.h"
#include "mesh_files.h"
#include "oracle/shapes.h"
#include <pthread.h>

enum { SIDE = 370, CALLERS = 3, STEPS = 3 }; /* so many that the stack has no bits for all */

typedef struct caller {
    const norma_plan *plan;
    const mesh_file *mesh;
    uint32_t number;
    float *positions, *out;
    uint32_t *moved;
    size_t moved_count;
} caller;

static void place(caller *c) {
    for (size_t v = 0; v < c->mesh->position_count; ++v)
        for (size_t x = 0; x < 3; ++x) c->positions[3 * v + x] = (float)c->mesh->positions[v][x];
}

static void *work(void *user) {
    caller *c = user;
    norma_options options = {.threads = 1 + c->number % 2};
    const norma_vec3_view view = {c->positions, c->mesh->position_count, 0, NORMA_FORMAT_FLOAT};
    norma_result result =
        norma_plan_update(c->plan, view, NULL, 0, &options, c->out, c->mesh->position_count, NULL);
    for (int step = 0; step < STEPS && !result; ++step) {
        for (size_t i = 0; i < c->moved_count; ++i)
            c->positions[3 * c->moved[i] + 2] += 0.01f * (float)(1 + c->number);
        result = norma_plan_update(c->plan, view, c->moved, c->moved_count, &options, c->out,
            c->mesh->position_count, NULL);
    }
    return !result ? NULL : user;
}

static void updates_at_once(void **state) {
    (void)state;
    mesh_file mesh = {0};
    caller callers[CALLERS];
    pthread_t threads[CALLERS];
    norma_plan *plan;
    shape_wavy_grid(&mesh, SIDE, 0);
    float *floats = test_calloc(3 * mesh.position_count, sizeof *floats),
          *wanted = test_calloc(3 * mesh.position_count, sizeof *floats);
    norma_mesh view = mesh_file_view_float(&mesh, floats);
    const norma_options two = {.threads = 2};
    assert_ok(norma_plan_create(&view, NORMA_PER_VERTEX, 1, &two, &plan));
    for (uint32_t i = 0; i < CALLERS; ++i) {
        callers[i] = (caller){plan, &mesh, i, test_calloc(3 * mesh.position_count, sizeof(float)),
            test_calloc(3 * mesh.position_count, sizeof(float)),
            test_calloc(mesh.position_count, sizeof(uint32_t)), 0};
        for (uint32_t v = i; v < mesh.position_count; v += 5 + i)
            callers[i].moved[callers[i].moved_count++] = v;
        place(&callers[i]);
    }
    for (int i = 0; i < CALLERS; ++i)
        assert_int_equal(pthread_create(&threads[i], NULL, work, &callers[i]), 0);
    for (int i = 0; i < CALLERS; ++i) {
        void *failed;
        assert_int_equal(pthread_join(threads[i], &failed), 0);
        assert_null(failed);
    }
    for (int i = 0; i < CALLERS; ++i) {
        view.positions.data = callers[i].positions;
        assert_ok(norma_vertex_normals(&view, NULL, wanted, mesh.position_count, NULL));
        assert_memory_equal(callers[i].out, wanted, 12 * mesh.position_count);
        test_free(callers[i].positions);
        test_free(callers[i].out);
        test_free(callers[i].moved);
    }
    norma_plan_destroy(plan);
    mesh_file_free(&mesh);
    test_free(floats);
    test_free(wanted);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(updates_at_once)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
